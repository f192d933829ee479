"""Cycles: the periodic orbit that a damped motion settles on, how far it still is from it, and its exponents.

A motion that nearly returns after n forcing periods is near a fixed point of the map over n periods. Three Newton steps
from it give the cycle itself and tell it from a slow drift, which has no fixed point nearby. The eigenvalues of the
tangent map over the cycle, its Floquet multipliers, give all Lyapunov exponents without any averaging. Nayfeh and
Balachandran, Applied Nonlinear Dynamics (1995), chapters 3 and 7.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone.motion.flow import DEFAULT_TOLERANCE, integrate
from gelcone.motion.orbit import newton
from gelcone.motion.settle import Clock, clocks
from gelcone.motion.tangents import CERTAIN, FLOOR
from gelcone.motion.validity import spread_over
from gelcone.physics.members import Members
from gelcone.quantity import Array

RETURNS = 64
"""Forcing periods that are examined; motions with up to a quarter of this as period are recognised."""
LONGEST_PERIOD = RETURNS // 4
PHASES = 8
"""Samples within each forcing period, for the amplitude and for returns: a slow drive can push all motions to the same
point once a period, and they still differ between."""
RETURN_TOLERANCE = 1e-6
NEAR_RETURN = 1e-4
"""For a damped motion that returns this closely, the cycle that it returns to is computed; one that is no further from
it has arrived."""
NEAR = 1e-2
"""A cycle further away than this share of the motion's size is not the one that the motion is on."""
CONVERGENCE = 0.1
"""The second Newton step has to be this much smaller than the first, or negligible, for a cycle to be there."""
NEGLIGIBLE = 1e-8
FIRST_TOLERANCE = 1e-8
"""Tolerance of the first Newton step, which starts from a motion that was followed with less."""
SAME_POINT = 1e-6
"""Points of a cycle that are closer than this share of its size are one."""
SMALLEST_SIZE = 1e-3


class Followed(NamedTuple):
    """Motions over `RETURNS` forcing periods: the ``path`` (members, periods, phases, N), the last phase of each period
    being its end; the ``outcome``; and samples spread evenly over all phases, ``times`` (members, samples) and
    ``states`` (members, samples, N), see `gelcone.motion.validity`."""

    path: Array
    outcome: npt.NDArray[np.int8]
    times: Array
    states: Array


def follow(members: Members, states: Array, **flow_options: Any) -> Followed:
    """Motions over `RETURNS` forcing periods from ``states`` at phase 0."""
    at_phases, spread = np.arange(1, RETURNS * PHASES + 1) / PHASES, spread_over(RETURNS)
    ticks = np.sort(np.concatenate([at_phases, spread]))
    flow = integrate(members, states, members.forcing_period[:, None] * ticks, **flow_options)
    path = flow.states[:, np.searchsorted(ticks, at_phases)].reshape(len(states), RETURNS, PHASES, -1)
    between = np.searchsorted(ticks, spread)
    return Followed(path, flow.outcome, flow.times[:, between], flow.states[:, between])


def periods_of(points: Array, tolerance: npt.ArrayLike = RETURN_TOLERANCE) -> tuple[npt.NDArray[np.int64], Array]:
    """Smallest number of forcing periods after which all points return, (members,), 0 if none; and the least distance.

    ``points`` (members, periods, coordinates). A return is closer than ``tolerance`` times the size of the motion (at
    least 1e-3 of a length), for every point.
    """
    tolerance = np.broadcast_to(tolerance, (len(points),))
    scale = np.maximum(np.abs(points).max(axis=(1, 2)), SMALLEST_SIZE)
    period = np.zeros(len(points), dtype=np.int64)
    nearest = np.full(len(points), np.inf)
    left = np.arange(len(points))
    for candidate in range(1, LONGEST_PERIOD + 1):
        distance = np.abs(points[:, candidate:] - points[:, :-candidate]).max(axis=(1, 2)) / scale[left]
        nearest[left] = np.fmin(nearest[left], distance)
        returns = distance < tolerance[left]
        period[left[returns]] = candidate
        if returns.any():
            left, points = left[~returns], points[~returns]
        if not left.size:
            break
    return period, nearest


@dataclass(frozen=True)
class Cycles:
    """The cycles near some motions; arrays (members, ...).

    ``found``; ``period`` in forcing periods; ``extent`` (the larger one of its displacement and velocity);
    ``symmetric`` under x -> -x; ``exponents`` (members, N) per unit time and their ``error``; ``distance`` of the
    motion from the cycle over its size; ``time`` over which the exponents are taken; ``point`` (members, N) of it at
    phase 0.
    """

    found: npt.NDArray[np.bool_]
    period: npt.NDArray[np.int64]
    extent: Array
    symmetric: npt.NDArray[np.bool_]
    exponents: Array
    error: Array
    distance: Array
    time: Array
    point: Array

    def take(self, rows: Any) -> Cycles:
        """The cycles of some members."""
        return Cycles(**{f.name: getattr(self, f.name)[rows] for f in fields(self)})

    @property
    def attracting(self) -> npt.NDArray[np.bool_]:
        """Where the motion has arrived at a cycle that certainly attracts."""
        certain = self.exponents[:, 0] < -np.maximum(CERTAIN * self.error[:, 0], FLOOR)
        return self.found & certain & (self.distance < NEAR_RETURN)


def find_cycles(members: Members, states: Array, period: npt.NDArray[np.int64], **flow_options: Any) -> Cycles:
    """The cycles of ``period`` (members,) forcing periods, or of a divisor of it, near ``states`` at phase 0.

    A member of period 0 has none.
    """
    count, size = states.shape
    cycles = Cycles(
        found=np.zeros(count, dtype=bool),
        period=np.zeros(count, dtype=np.int64),
        extent=np.full(count, np.nan),
        symmetric=np.zeros(count, dtype=bool),
        exponents=np.full((count, size), np.nan),
        error=np.full((count, size), np.nan),
        distance=np.full(count, np.nan),
        time=np.zeros(count),
        point=np.full((count, size), np.nan),
    )
    for group, clock in clocks(members):
        for repeats in np.unique(period[group][period[group] > 0]):
            same = period[group] == repeats
            rows = group[same]
            _find(members.take(rows), states[rows], clock.take(same), int(repeats), rows, cycles, flow_options)
    return cycles


def _find(
    members: Members,
    states: Array,
    clock: Clock,
    repeats: int,
    rows: npt.NDArray[np.intp],
    cycles: Cycles,
    flow_options: dict[str, Any],
) -> None:
    options = dict(flow_options)
    exact = options.pop("tolerance", DEFAULT_TOLERANCE)
    with np.errstate(all="ignore"):  # a motion that is on no cycle gives steps of any size, or none
        tolerances = max(exact, FIRST_TOLERANCE), exact, exact
        _, before, last = newton(members, states, repeats, clock.per_repeat, tolerances, **options)
        path = last.path.reshape(len(states), repeats, clock.per_repeat, -1)
        size = np.maximum(np.abs(path).max(axis=(1, 2, 3)), SMALLEST_SIZE)
        distance, left = np.abs(last.point - states).max(axis=1) / size, np.abs(last.step).max(axis=1) / size
        time = repeats * clock.repeat
        exponents, first = (turn.log_multipliers / time[:, None] for turn in (last, before))
        found = (distance < NEAR) & ((left < CONVERGENCE * distance) | (left < NEGLIGIBLE))
    period = _smallest_period(path, size)
    cycles.found[rows], cycles.period[rows], cycles.distance[rows] = found, period, distance
    cycles.extent[rows] = np.maximum(np.ptp(path[..., 0], axis=(1, 2)), np.abs(path[..., 1]).max(axis=(1, 2)))
    cycles.symmetric[rows] = _is_symmetric(path, period, size, members.system.mirror)
    # The exponents of the cycle against those found before the last step, which was far larger than what is left.
    cycles.exponents[rows], cycles.error[rows] = exponents, np.maximum(np.abs(exponents - first), FLOOR / 10)
    cycles.time[rows] = time
    cycles.point[rows] = last.point + last.step


def _smallest_period(path: Array, size: Array) -> npt.NDArray[np.int64]:
    """Smallest number of forcing periods after which the path (members, periods, stretches, N) repeats itself."""
    repeats = path.shape[1]
    period = np.full(len(path), repeats)
    for divisor in range(repeats - 1, 0, -1):
        if repeats % divisor == 0:
            gap = np.abs(path - np.roll(path, divisor, axis=1)).max(axis=(1, 2, 3))
            period[gap < SAME_POINT * size] = divisor
    return period


def _is_symmetric(path: Array, period: npt.NDArray[np.int64], size: Array, signs: Array) -> npt.NDArray[np.bool_]:
    """Whether the path is its own mirror image, half a period later (or, at rest, at once)."""
    shift = np.where(period % 2 == 0, period // 2, 0)
    later = (np.arange(path.shape[1]) + shift[:, None]) % path.shape[1]
    image = signs * np.take_along_axis(path, later[:, :, None, None], axis=1)
    return np.abs(path - image).max(axis=(1, 2, 3)) < 10.0 * SAME_POINT * size
