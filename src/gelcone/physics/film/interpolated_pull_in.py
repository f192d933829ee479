"""Pull-in curves of many films, interpolated between those of a few of them.

A curve takes a membrane, which takes about a second: draws of an uncertain device would take one each.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from gelcone.physics.film.pull_in import (
    DEFAULT_RADIUS_RATIO,
    CurveKey,
    PullInCurve,
    curve_keys,
    curve_of,
    curves_between,
)
from gelcone.physics.film.taut import TautCone
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.quantity import Array

if TYPE_CHECKING:
    from gelcone.physics.members import Members

LARGEST_ERROR = 0.03
"""Largest root mean square error of interpolated voltages, as a share; beyond it each film has its own membrane."""
MORE_NODES = 4
"""Membranes that are made, beyond twice the number of ways in which the films differ."""
PLACES = 2001
"""Displacements at which their curves are tabulated."""


@dataclass(frozen=True)
class InterpolatedCurve(PullInCurve):
    """An interpolated curve: ``voltages`` at equally spaced displacements from 0 to the reach, the last beyond it, as
    in the film's table; ``numbers`` holds its error and reach."""

    voltages: Array

    def voltage(self, x: npt.ArrayLike) -> Array:
        places = np.linspace(0.0, self.reach, self.voltages.size)
        return np.asarray(np.interp(np.abs(x), places, self.voltages))


@dataclass(frozen=True)
class Interpolation:
    """Summary of an interpolation: the number of ``films`` and of membranes ``made``, and the leave-one-out root mean
    square ``error`` of the voltages of the made membranes, as a share."""

    films: int
    made: int
    error: float


@contextmanager
def interpolated_curves(members: Members) -> Iterator[Interpolation | None]:
    """Interpolate the curves of many different films inside the context: membranes are made of a few films alone, and
    voltages are linear in the numbers in which the films differ.

    Yields None, and changes nothing: for few films; for films other than homogeneous cones; where one of the made
    membranes has no curve, another reach, or no pull-in at a displacement where others pull in; and where the error
    exceeds ``LARGEST_ERROR``.
    """
    keys = _keys_of(members)
    table = np.array([[*others, *dict(law).values()] for _, law, *others in keys])
    varied = table[:, np.ptp(table, axis=0) > 0.0] if len(keys) else table
    count = 2 * varied.shape[-1] + MORE_NODES
    if len(keys) <= count:
        yield None
        return
    places = (varied - varied.mean(axis=0)) / varied.std(axis=0)
    nodes = _spread_out(places, count)
    curves = [curve_of(*keys[k]) for k in nodes]
    made_curves = [curve for curve in curves if curve is not None]
    if len(made_curves) < count:
        yield None
        return
    reach = made_curves[0].reach
    volts = np.array([curve.voltage(np.linspace(0.0, reach, PLACES)) for curve in made_curves])
    always = np.isfinite(volts).all(axis=0)
    alike = (
        np.ptp([curve.reach for curve in made_curves]) <= 1e-9 * reach
        and (always == np.isfinite(volts).any(axis=0)).all()
    )
    features = np.column_stack([np.ones(len(keys)), places])
    weights = features @ np.linalg.pinv(features[nodes])
    voltages = np.full((len(keys), PLACES), np.inf)
    voltages[:, always] = weights @ volts[:, always]
    off = volts[:, always] - voltages[nodes][:, always]
    off /= (1.0 - np.diag(weights[nodes]))[:, None] * volts[:, always]
    error = float(np.sqrt(np.mean(off**2))) if always.any() else 0.0
    if not alike or not error <= LARGEST_ERROR:
        yield None
        return
    numbers = {"film_error": max(curve.error for curve in made_curves), "reach_squared": reach**2}
    added = [k for k in range(len(keys)) if k not in nodes and keys[k] not in curves_between]
    curves_between.update((keys[k], InterpolatedCurve(numbers, voltages[k])) for k in added)
    try:
        yield Interpolation(len(keys), count, error)
    finally:
        for k in added:
            curves_between.pop(keys[k], None)


def _keys_of(members: Members) -> list[CurveKey]:
    """The keys of the different films of members, as `membrane_pull_in` and `over_pull_in` use them."""
    film, values = members.system.film, members.values
    wrinkling = isinstance(film, WrinklingCone) and film.pull_in == "first"
    taut = type(film) is TautCone and "radius_ratio" in values
    if not isinstance(film, TautCone) or not (wrinkling or taut) or len(members.system.films) > 1:
        return []
    return curve_keys(film, values, values.get("radius_ratio", DEFAULT_RADIUS_RATIO))[0]


def _spread_out(places: Array, count: int) -> Sequence[int]:
    """Indices of ``count`` points that lie far apart, the first of them far from the centre."""
    chosen = [int(np.argmax((places**2).sum(axis=1)))]
    nearest = np.full(len(places), np.inf)
    while len(chosen) < count:
        nearest = np.minimum(nearest, ((places - places[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(np.argmax(nearest)))
    return chosen
