"""Pull-in curves of cones: voltages at which the membrane that a cone approximates pulls in, over the displacement."""

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
"""Most curves that are stored in memory."""


@dataclass(frozen=True)
class PullInCurve:
    """Voltages above which a film, held at a displacement of either sign, has pulled in; infinite where it does not.

    ``numbers`` are those of the film ``membrane``.
    """

    numbers: Mapping[str, float]

    @property
    def error(self) -> float:
        """The largest error of the film's force, over that without voltage."""
        return float(self.numbers["film_error"])

    @property
    def reach(self) -> float:
        """The largest displacement at which the membrane is computed."""
        return float(np.sqrt(self.numbers["reach_squared"]))

    def voltage(self, x: npt.ArrayLike) -> Array:
        """Pull-in voltages at displacements, in their shape."""
        squared = MembraneFilm().highest_squared(x, self.numbers)
        with np.errstate(invalid="ignore"):  # next to the flat film a strong hoop leaves no state at any voltage
            return np.sqrt(np.where(np.isnan(squared), np.inf, squared))


def membrane_pull_in(model: ConeModel) -> PullInCurve | None:
    """Compute the curve of a single actuator with one wrinkling cone; None for other films, and where the membrane
    cannot be computed. The default ``radius_ratio`` is 0.2.

    Raises `InputError` for a ratio of 1 or more.
    """
    film = model.film
    if not isinstance(film, WrinklingCone) or film.pull_in != "first" or len(model.system.films) > 1 or model.shape:
        return None
    ratio = float(model.values.get("radius_ratio", DEFAULT_RADIUS_RATIO))
    if not ratio < 1.0:
        raise InputError(f"radius_ratio = {ratio:g}: must lie between 0 and 1; the disc is smaller than its ring")
    (key,), _ = curve_keys(film, model.members().values, ratio)
    return curve_of(*key)


CurveKey = tuple[StrainEnergyLaw, tuple[tuple[str, float], ...], float, float, float]
"""A law with its numbers, squared pre-stretches and a/b."""
_curves: dict[CurveKey, PullInCurve | None] = {}
curves_between: dict[CurveKey, PullInCurve] = {}
"""Interpolated curves, see `gelcone.physics.film.interpolated_pull_in`; those of ``_curves`` come first."""
_thread = threading.local()


@contextmanager
def known_curves() -> Iterator[dict[CurveKey, None]]:
    """Let `over_pull_in` skip curves that are not stored, in this thread, since each takes a second: for live pictures.

    Yields the keys of the skipped curves, so that they can be computed later.
    """
    before, _thread.missing = getattr(_thread, "missing", None), dict[CurveKey, None]()
    try:
        yield _thread.missing
    finally:
        _thread.missing = before


def store_curve(key: CurveKey, found: PullInCurve | None) -> None:
    """Store a curve, such as one that another process has computed."""
    if len(_curves) >= MOST:
        _curves.clear()
    _curves[key] = found


def curve_keys(
    film: TautCone, values: Mapping[str, Array], ratio: npt.ArrayLike
) -> tuple[list[CurveKey], npt.NDArray[np.intp]]:
    """The keys of the different cones of members, by their ``values`` and a/b, and the index of that of each member."""
    law = film.law.numbers(values)
    columns = np.broadcast_arrays(*map(np.square, film.stretches(values)), ratio, *law.values())
    rows, which = np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)
    keys = [(film.law, tuple(zip(law, law_values, strict=True)), A, B, a_b) for A, B, a_b, *law_values in rows.tolist()]
    return keys, which.ravel()


def curve_of(
    law: StrainEnergyLaw, law_numbers: tuple[tuple[str, float], ...], A: float, B: float, ratio: float
) -> PullInCurve | None:
    """Return the curve of a film with a law and its numbers, squared pre-stretches and a/b; computed if it is not
    stored, None where the membrane cannot be computed."""
    key = (law, law_numbers, A, B, ratio)
    if key in curves_between and key not in _curves:
        return curves_between[key]
    if key not in _curves:
        store_curve(key, _made(*key))
    return _curves[key]


def _made(
    law: StrainEnergyLaw, law_numbers: tuple[tuple[str, float], ...], A: float, B: float, ratio: float
) -> PullInCurve | None:
    try:
        numbers = numbers_of(law, dict(law_numbers), ratio, A, B)
    except InputError:
        return None
    return PullInCurve({name: float(value) for name, value in numbers.items()})


def over_pull_in(placed: PlacedFilm, values: Mapping[str, Array], x: Array, voltage: Array) -> Array | None:
    """Excess of the voltage on a cone over the pull-in voltage of its membrane, as a share, at displacements of the
    disc (members, samples); -1 where the membrane does not pull in. None where `curves_of_members` has none.
    """
    curves = curves_of_members(placed, values)
    if curves is None:
        return None
    excess = np.full(np.shape(x), -1.0)
    at = np.broadcast_to(placed.place(x, {name: np.reshape(value, (-1, 1)) for name, value in values.items()}), x.shape)
    for rows, curve in curves:
        excess[rows] = np.abs(voltage[rows]) / curve.voltage(at[rows]) - 1.0
    return excess


def is_cone(placed: PlacedFilm) -> bool:
    """Whether a film is a cone that may stand for a membrane."""
    return type(placed.film) in (TautCone, WrinklingCone)


def curves_of_members(
    placed: PlacedFilm, values: Mapping[str, Array]
) -> list[tuple[npt.NDArray[np.bool_], PullInCurve]] | None:
    """Masks of members, by their ``values``, and the curve of the membrane that their cone stands for; members without
    a curve are left out. None for other films, without a ``radius_ratio``, and where `known_curves` skips a curve.
    """
    film, film_values = placed.film, placed.own(values)
    if not isinstance(film, TautCone) or not is_cone(placed) or "radius_ratio" not in film_values:
        return None
    keys, which = curve_keys(film, film_values, film_values["radius_ratio"])
    curves, missing = [], getattr(_thread, "missing", None)
    for k, key in enumerate(keys):
        possible = 0.0 < key[-1] < 1.0
        if missing is not None and key not in _curves and key not in curves_between and possible:
            missing[key] = None
            return None
        curve = curve_of(*key) if possible else None
        if curve is not None:
            curves.append((which == k, curve))
    return curves
