"""The voltages at which the membrane pulls in that a cone stands for: those of the film ``membrane`` of its gel."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping, Sequence
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
    from gelcone.physics.members import Members
    from gelcone.physics.model import ConeModel
    from gelcone.physics.placed import PlacedFilm

DEFAULT_RADIUS_RATIO = 0.2
"""a/b of the source paper's Table 1: 10 mm in 50 mm."""
MOST = 4096
"""Curves held in memory."""
LARGEST_ERROR = 0.03
"""Share by which interpolated voltages may be off, root mean square; beyond it each film has a membrane of its own."""
MORE_NODES, PLACES = 4, 2001
"""Films beyond twice the number of ways in which films differ, of which membranes are made to interpolate between; and
displacements at which their curves are read."""


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


@dataclass(frozen=True)
class ReadCurve(PullInCurve):
    """A curve between those of other films, whose ``numbers`` are error and reach: ``voltages`` at displacements evenly
    from 0 to the reach; beyond it the last, as of the film's own table."""

    voltages: Array

    def voltage(self, x: npt.ArrayLike) -> Array:
        places = np.linspace(0.0, self.reach, self.voltages.size)
        return np.asarray(np.interp(np.abs(x), places, self.voltages))


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
_between: dict[CurveKey, ReadCurve] = {}
"""Curves between others, inside `interpolated_curves`; those of ``_curves`` come first."""
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
    if key in _between and key not in _curves:
        return _between[key]
    if key not in _curves:
        keep_curve(key, _made(*key))
    return _curves[key]


@dataclass(frozen=True)
class Between:
    """Interpolation between the curves of many films: ``made`` membranes, and the root mean square ``error`` of the
    voltages of each of these films by the others, as a share."""

    films: int
    made: int
    error: float


@contextmanager
def interpolated_curves(members: Members) -> Iterator[Between | None]:
    """Inside, the curves of the films of many ``members`` are interpolated between those of a few of them, which takes
    a membrane for each of these alone: linearly in the numbers in which the films differ, each over its deviation.

    Yields None, and changes nothing, for few films and for other films than homogeneous cones; where one of the few has
    no curve, another reach, or no pull-in at a displacement at which another has one; and where the error exceeds
    ``LARGEST_ERROR``.
    """
    keys = _keys_of(members)
    table = np.array([_row(key) for key in keys])
    varied = table[:, np.ptp(table, axis=0) > 0.0] if len(keys) else table
    count = 2 * varied.shape[-1] + MORE_NODES
    if len(keys) <= count:
        yield None
        return
    places = (varied - varied.mean(axis=0)) / varied.std(axis=0)
    nodes = _spread_out(places, count)
    curves = [curve_of(*keys[k]) for k in nodes]
    known = [curve for curve in curves if curve is not None]
    if len(known) < count:
        yield None
        return
    reach = known[0].reach
    volts = np.array([curve.voltage(np.linspace(0.0, reach, PLACES)) for curve in known])
    always = np.isfinite(volts).all(axis=0)
    alike = (
        np.ptp([curve.reach for curve in known]) <= 1e-9 * reach and (always == np.isfinite(volts).any(axis=0)).all()
    )
    features = np.column_stack([np.ones(len(keys)), places])
    weights = features @ np.linalg.pinv(features[nodes])
    found = np.full((len(keys), PLACES), np.inf)
    found[:, always] = weights @ volts[:, always]
    off = volts[:, always] - found[nodes][:, always]
    off /= (1.0 - np.diag(weights[nodes]))[:, None] * volts[:, always]
    error = float(np.sqrt(np.mean(off**2))) if always.any() else 0.0
    if not alike or not error <= LARGEST_ERROR:
        yield None
        return
    numbers = {"film_error": max(curve.error for curve in known), "reach_squared": reach**2}
    own = [k for k in range(len(keys)) if k not in nodes and keys[k] not in _between]
    _between.update((keys[k], ReadCurve(numbers, found[k])) for k in own)
    try:
        yield Between(len(keys), count, error)
    finally:
        for k in own:
            _between.pop(keys[k], None)


def _keys_of(members: Members) -> list[CurveKey]:
    """The keys of the different films of members, as `membrane_pull_in` and `over_pull_in` ask for them."""
    film, own = members.system.film, members.values
    wrinkling = isinstance(film, WrinklingCone) and film.pull_in == "first"
    taut = type(film) is TautCone and "radius_ratio" in own
    if not isinstance(film, TautCone) or not (wrinkling or taut) or len(members.system.films) > 1:
        return []
    law = film.law.numbers(own)
    ratio = own.get("radius_ratio", DEFAULT_RADIUS_RATIO)
    columns = np.broadcast_arrays(*map(np.square, film.stretches(own)), ratio, *law.values(), np.zeros(members.size))
    rows = np.unique(np.stack(columns[:-1], axis=1), axis=0).tolist()
    return [(film.law, tuple(zip(law, numbers, strict=True)), A, B, ratio) for A, B, ratio, *numbers in rows]


def _row(key: CurveKey) -> list[float]:
    """The numbers of a film."""
    _, law, *others = key
    return [*others, *(number for _, number in law)]


def _spread_out(places: Array, count: int) -> Sequence[int]:
    """Which ``count`` points lie far from one another, the first far from the middle."""
    chosen = [int(np.argmax((places**2).sum(axis=1)))]
    nearest = np.full(len(places), np.inf)
    while len(chosen) < count:
        nearest = np.minimum(nearest, ((places - places[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(np.argmax(nearest)))
    return chosen


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
        if missing is not None and key not in _curves and key not in _between and 0.0 < ratio < 1.0:
            missing[key] = None
            return None
        curve = curve_of(*key) if 0.0 < ratio < 1.0 else None
        if curve is not None:
            own_rows = which.ravel() == k
            found[own_rows] = np.abs(voltage[own_rows]) / curve.voltage(at[own_rows]) - 1.0
    return found
