"""The voltages at which the membrane pulls in that a cone stands for: those of the film ``membrane`` of its gel."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from gelcone.errors import InputError
from gelcone.membrane.made import numbers_of
from gelcone.physics.film.membrane import MembraneFilm
from gelcone.physics.film.taut import TautCone
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.laws import StrainEnergyLaw
from gelcone.quantity import Array

if TYPE_CHECKING:
    from gelcone.physics.model import ConeModel
    from gelcone.physics.placed import PlacedFilm

DEFAULT_RADIUS_RATIO = 0.2
"""a/b of the source paper's Table 1: 10 mm in 50 mm."""
MOST = 4096
"""Curves held in memory."""


@dataclass(frozen=True)
class PullInCurve:
    """Voltages above which a film, held at a displacement of either sign, has pulled in; infinite where it does not.

    ``numbers`` are those of the table of the film ``membrane``.
    """

    numbers: Mapping[str, float]

    @property
    def error(self) -> float:
        """The largest error of the film's force, over that without voltage."""
        return float(self.numbers["film_error"])

    @property
    def reach(self) -> float:
        """The largest displacement at which the film is known."""
        return float(np.sqrt(self.numbers["reach_squared"]))

    def voltage(self, x: npt.ArrayLike) -> Array:
        """The voltages at displacements."""
        squared = MembraneFilm().highest_squared(x, self.numbers)
        with np.errstate(invalid="ignore"):  # next to the flat film a strong hoop leaves no state at any voltage
            return np.sqrt(np.where(np.isnan(squared), np.inf, squared))


def membrane_pull_in(model: ConeModel) -> PullInCurve | None:
    """The curve of one actuator; None where it does not apply: for another film than the wrinkling cone, or with a
    second one, and for a film of which there is no table. A model without a ``radius_ratio`` has one of 0.2.

    Raises `InputError` for a ratio of 1 or more.
    """
    film = model.film
    if not isinstance(film, WrinklingCone) or film.pull_in != "first" or len(model.system.films) > 1 or model.shape:
        return None
    numbers, law = model.own_numbers, film.law.numbers(model.values)
    ratio = float(model.values.get("radius_ratio", DEFAULT_RADIUS_RATIO))
    if not ratio < 1.0:
        raise InputError(f"radius_ratio = {ratio:g}: must lie between 0 and 1; the disc is smaller than its ring")
    squares = float(numbers["A"]), float(numbers["B"])
    return curve_of(film.law, tuple((name, float(value)) for name, value in law.items()), *squares, ratio)


CurveKey = tuple[StrainEnergyLaw, tuple[tuple[str, float], ...], float, float, float]
"""A law with its numbers, squared pre-stretches and a/b."""
_curves: dict[CurveKey, PullInCurve | None] = {}
_thread = threading.local()


@contextmanager
def known_curves() -> Iterator[dict[CurveKey, None]]:
    """In this thread `over_pull_in` leaves out curves that are not known, in place of a second for each: for pictures
    under a moving hand. Gives those that were left out, so that one may compute them later.
    """
    before, _thread.missing = getattr(_thread, "missing", None), dict[CurveKey, None]()
    try:
        yield _thread.missing
    finally:
        _thread.missing = before


def keep_curve(key: CurveKey, found: PullInCurve | None) -> None:
    """Keeps a curve, also one that was computed in another process."""
    if len(_curves) >= MOST:
        _curves.clear()
    _curves[key] = found


def curve_of(
    law: StrainEnergyLaw, law_numbers: tuple[tuple[str, float], ...], A: float, B: float, ratio: float
) -> PullInCurve | None:
    """The curve of a film of a law with its numbers, squared pre-stretches and a/b; None for one of which there is no
    table."""
    key = (law, law_numbers, A, B, ratio)
    if key not in _curves:
        keep_curve(key, _made(*key))
    return _curves[key]


def _made(
    law: StrainEnergyLaw, law_numbers: tuple[tuple[str, float], ...], A: float, B: float, ratio: float
) -> PullInCurve | None:
    try:
        found = numbers_of(law, dict(law_numbers), ratio, A, B)
    except InputError:
        return None
    return PullInCurve({name: float(value) for name, value in found.items()})


def over_pull_in(placed: PlacedFilm, values: Mapping[str, Array], x: Array, voltage: Array) -> Array | None:
    """By which share the voltage on a cone is above that at which its membrane has pulled in, at the displacements of
    the disc (members, samples); -1 where there is no such voltage. None for another film, and where the cone's
    ``radius_ratio`` is not among the ``values`` of the members.
    """
    film, own = placed.film, placed.own(values)
    if not isinstance(film, TautCone) or type(film) not in (TautCone, WrinklingCone) or "radius_ratio" not in own:
        return None
    law, stretches = film.law.numbers(own), film.stretches(own)
    columns = np.broadcast_arrays(*map(np.square, stretches), own["radius_ratio"], *law.values())
    rows, which = np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)
    found = np.full(np.shape(x), -1.0)
    at = np.broadcast_to(placed.place(x, {name: np.reshape(value, (-1, 1)) for name, value in values.items()}), x.shape)
    missing = getattr(_thread, "missing", None)
    for k, (A, B, ratio, *numbers) in enumerate(rows.tolist()):
        key = (film.law, tuple(zip(law, numbers, strict=True)), A, B, ratio)
        if missing is not None and key not in _curves and 0.0 < ratio < 1.0:
            missing[key] = None
            return None
        curve = curve_of(*key) if 0.0 < ratio < 1.0 else None
        if curve is not None:
            own_rows = which.ravel() == k
            found[own_rows] = np.abs(voltage[own_rows]) / curve.voltage(at[own_rows]) - 1.0
    return found
