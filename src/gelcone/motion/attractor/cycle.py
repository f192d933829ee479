"""Cycles: the periodic orbits that damped motions settle on, their distances from them, and their exponents.

A motion that nearly returns after n forcing periods is near a fixed point of the map over n periods. Three Newton steps
give the cycle, or show a slow drift, which has no fixed point nearby. The eigenvalues of the tangent map over the
cycle, its Floquet multipliers, give all Lyapunov exponents without averaging (Nayfeh and Balachandran, Applied
Nonlinear Dynamics (1995), chapters 3 and 7). Rest is a cycle of one forcing period.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone.motion.columns import Columns, column
from gelcone.motion.extent import extent
from gelcone.motion.flow import DEFAULT_TOLERANCE, integrate
from gelcone.motion.orbit import Turn, newton
from gelcone.motion.settle import Clock, blocks, samples_per_repeat, turns
from gelcone.motion.tangents import CERTAIN, FLOOR
from gelcone.motion.validity import validity
from gelcone.physics.members import Members
from gelcone.quantity import Array

NEAR_RETURN = 1e-4
"""Largest distance from an attracting cycle, over the motion's size, of a motion that has arrived there."""
NEAR = 1e-2
"""Largest distance, over the motion's size, of the cycle that a motion is taken to be on."""
CONVERGENCE = 0.1
"""Largest ratio of the last Newton step to the distance of the cycle at which Newton's method has converged."""
NEGLIGIBLE = 1e-8
FIRST_TOLERANCE = 1e-8
"""Least tolerance of the first Newton step: it starts from a motion of this accuracy."""
SAME_POINT = 1e-6
"""Largest distance, over the size of a cycle, of points that are taken to be equal."""
ALIKE = 1e-3
"""Distance of a cycle from itself after a part of its period, over its size, below which it may have that period: next
to a doubling the map over both turns is almost singular, and Newton's method has not arrived."""
UNRESOLVED = 10.0
"""Largest distance of a cycle from its mirror image, over the last Newton step, at which it may be symmetric: next to a
symmetry breaking the map over the whole turn is almost singular, too, and the step is a third of its error or more."""
SMALLEST_SIZE = 1e-3
TICKS = 32
"""Fewest samples of a forcing period between which motions are interpolated for their validity."""
PER_OSCILLATION = 8
"""Fewest ticks of an oscillation at the fastest rate for the extremes of a motion."""
REST_TOLERANCE = 1e-6
"""Least extent, in displacement and velocity, of a cycle that is not a rest."""


@dataclass(frozen=True)
class Cycles(Columns):
    """The cycles near some motions; arrays (members, ...).

    ``found``; ``period`` in forcing periods; ``extent`` (of displacement or velocity, the larger); ``symmetric`` under
    x -> -x; ``exponents`` (members, N) per unit time and their ``error``; ``divergence``, the mean trace of the
    Jacobian, which is their sum; ``distance`` of the motion from the cycle over its size; ``time`` over which the
    exponents are taken; ``size``, the largest coordinate; ``point`` (members, N) at phase 0.
    """

    found: npt.NDArray[np.bool_] = column(False, kind=bool)
    period: npt.NDArray[np.int64] = column(0, kind=np.int64)
    extent: Array = column()
    symmetric: npt.NDArray[np.bool_] = column(False, kind=bool)
    exponents: Array = column(np.nan, "N")
    error: Array = column(np.nan, "N")
    divergence: Array = column()
    distance: Array = column()
    time: Array = column(0.0)
    size: Array = column()
    point: Array = column(np.nan, "N")

    @property
    def sign(self) -> npt.NDArray[np.int8]:
        """Sign of the largest exponent, 0 where it is uncertain or there is no cycle."""
        largest, error = self.exponents[:, 0], self.error[:, 0]
        certain = self.found & (np.abs(largest) > np.maximum(CERTAIN * error, FLOOR))
        return np.where(certain, np.sign(largest), 0.0).astype(np.int8)

    @property
    def attracting(self) -> npt.NDArray[np.bool_]:
        """Mask of motions that have arrived at a cycle that certainly attracts."""
        return self.found & (self.sign < 0) & (self.distance < NEAR_RETURN)

    @property
    def resting(self) -> npt.NDArray[np.bool_]:
        """Mask of cycles at rest."""
        return self.found & (self.extent < REST_TOLERANCE)


def find_cycles(members: Members, states: Array, period: npt.NDArray[np.int64], **flow_options: Any) -> Cycles:
    """Find the cycles of ``period`` (members,) forcing periods, or of a divisor of it, near ``states`` at phase 0.

    A member of period 0 has no cycle.
    """
    cycles, alike, between = _found(members, states, period, flow_options)
    rows = np.flatnonzero(cycles.found & (alike > 0))
    if rows.size:
        shorter = find_cycles(members.take(rows), cycles.point[rows], alike[rows], **flow_options)
        attract = shorter.found & (shorter.sign < 0)
        distance = cycles.distance[rows] + shorter.distance
        cycles.put(rows[attract], replace(shorter, distance=distance).take(attract))
        between[rows[attract]] = np.nan
    rows = np.flatnonzero(cycles.found & np.isfinite(between).all(axis=1))
    if rows.size:
        candidates, _, _ = _found(members.take(rows), between[rows], cycles.period[rows], flow_options)
        attract = candidates.found & candidates.symmetric & (candidates.sign < 0)
        distance = np.abs(candidates.point - states[rows]).max(axis=1) / candidates.size
        cycles.put(rows[attract], replace(candidates, distance=distance).take(attract))
    return cycles


def _found(
    members: Members, states: Array, period: npt.NDArray[np.int64], flow_options: dict[str, Any]
) -> tuple[Cycles, npt.NDArray[np.int64], Array]:
    """The cycles near some states; the next smaller period that each may have (0: none), see `ALIKE`; and the points
    (members, N) at which to search for a symmetric cycle in place of each (NaN: none), see `UNRESOLVED`."""
    cycles, alike = Cycles.blank(len(states), states=states.shape[1]), np.zeros_like(period)
    between = np.full(states.shape, np.nan)
    for rows, clock, repeats in turns(members, period):
        triple = _of_period(members.take(rows), states[rows], clock, repeats, flow_options)
        row_cycles, alike[rows], between[rows] = triple
        cycles.put(rows, row_cycles)
    return cycles, alike, between


def _of_period(
    members: Members, states: Array, clock: Clock, repeats: int, flow_options: dict[str, Any]
) -> tuple[Cycles, npt.NDArray[np.int64], Array]:
    """`_found` for members of one clock and period."""
    options = dict(flow_options)
    exact = options.pop("tolerance", DEFAULT_TOLERANCE)
    with np.errstate(all="ignore"):  # far from a cycle, Newton steps may be infinite or NaN
        tolerances = max(exact, FIRST_TOLERANCE), exact, exact
        _, before, last = newton(members, states, repeats, clock.per_repeat, tolerances, **options)
        path = last.path.reshape(len(states), repeats, clock.per_repeat, -1)
        size = np.maximum(np.abs(path).max(axis=(1, 2, 3)), SMALLEST_SIZE)
        distance, left = np.abs(last.point - states).max(axis=1) / size, np.abs(last.step).max(axis=1) / size
        time = repeats * clock.repeat
        exponents, first = (turn.log_multipliers / time[:, None] for turn in (last, before))
        # The last step was far larger than the remaining error, so the change in it bounds the error of the exponents.
        error = np.maximum(np.abs(exponents - first), np.maximum(last.error / time[:, None], FLOOR / 10))
        found = (distance < NEAR) & ((left < CONVERGENCE * distance) | (left < NEGLIGIBLE))
    period, alike = _periods(path, size)
    symmetric = _is_symmetric(path, period, size, members.system.mirror) & members.symmetric
    cycles = Cycles(
        found=found,
        period=period,
        extent=np.maximum(np.ptp(path[..., 0], axis=(1, 2)), np.abs(path[..., 1]).max(axis=(1, 2))),
        symmetric=symmetric,
        exponents=exponents,
        error=error,
        divergence=last.contraction / time,
        distance=distance,
        time=time,
        size=size,
        point=last.point + last.step,
    )
    between = _between_images(path, period, last, members.system.mirror)
    between[symmetric | ~members.symmetric] = np.nan
    return cycles, alike, between


def _periods(path: Array, size: Array) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Smallest number of forcing periods after which the path (members, periods, stretches, N) repeats itself, and the
    next smaller one after which it almost does (0: none)."""
    repeats = path.shape[1]
    divisors = [divisor for divisor in range(1, repeats) if repeats % divisor == 0]
    gaps = {d: np.abs(path - np.roll(path, d, axis=1)).max(axis=(1, 2, 3)) / size for d in divisors}
    period, alike = np.full(len(path), repeats), np.zeros(len(path), dtype=np.int64)
    for divisor in reversed(divisors):
        period[gaps[divisor] < SAME_POINT] = divisor
    for divisor in divisors:
        alike[(gaps[divisor] < ALIKE) & (divisor < period) & (period % divisor == 0)] = divisor
    return period, alike


def _is_symmetric(path: Array, period: npt.NDArray[np.int64], size: Array, signs: Array) -> npt.NDArray[np.bool_]:
    """Mask of paths that equal their mirror image half a period later (at once for an odd period)."""
    shift = np.where(period % 2 == 0, period // 2, 0)
    later = (np.arange(path.shape[1]) + shift[:, None]) % path.shape[1]
    image = signs * np.take_along_axis(path, later[:, :, None, None], axis=1)
    return np.abs(path - image).max(axis=(1, 2, 3)) < 10.0 * SAME_POINT * size


def _between_images(path: Array, period: npt.NDArray[np.int64], last: Turn, signs: Array) -> Array:
    """Points (members, N) in the middle between cycles and their mirror images half a period later, NaN where these are
    further apart than `UNRESOLVED` or the period is odd.

    Next to a symmetry breaking a deviation from the symmetric cycle changes its sign from one to the other, so that
    nothing of it is left in the middle.
    """
    image = signs * path[np.arange(len(path)), period // 2 - 1, -1]
    near = np.abs(image - last.point).max(axis=1) < UNRESOLVED * np.abs(last.step).max(axis=1)
    return np.where((near & (period % 2 == 0))[:, None], 0.5 * (last.point + image), np.nan)


class Sampled(NamedTuple):
    """Motions over some forcing periods.

    ``path`` (members, samples, N) at even times, the last at the end; ``times`` (members, ticks) and ``states``
    (members, ticks, N) from start to end, at least `TICKS` a period; ``outcome`` of each run and ``film_times`` as in
    `gelcone.motion.job.Trajectories`.
    """

    path: Array
    times: Array
    states: Array
    outcome: npt.NDArray[np.int8]
    film_times: Array

    def validity(self, members: Members, *, turn: bool) -> Array:
        """Validity of the model along the motions (`gelcone.motion.validity.validity`)."""
        return validity(members, self.times, self.states, whole=turn, film_times=self.film_times)


def sampled(members: Members, states: Array, periods: int, samples: int, **flow_options: Any) -> Sampled:
    """Sample motions over ``periods`` forcing periods from ``states`` (members, N) at phase 0, ``samples`` in each."""
    finer = -(-TICKS // samples)
    ticks = np.arange(periods * samples * finer + 1) / (samples * finer)
    run = integrate(members, states, members.forcing_period[:, None] * ticks, **flow_options)
    return Sampled(run.states[:, finer::finer], run.times, run.states, run.outcome, run.film_times)


def extremes(
    members: Members, states: Array, periods: int, motion: Sampled, **flow_options: Any
) -> tuple[Array, Array]:
    """The lowest and highest displacement, (members,), of a ``motion`` over ``periods`` forcing periods from ``states``
    (members, N). Under a slow drive, where the disc turns several times between two ticks, it is sampled again."""
    lowest, highest = extent(members, motion.times, motion.states, **flow_options)
    ticks, needed = (motion.times.shape[1] - 1) // periods, samples_per_repeat(members, PER_OSCILLATION)
    for (samples,), rows in blocks(np.where(needed > ticks, periods * needed, 0)):
        if samples:
            part = members.take(rows)
            finer = sampled(part, states[rows], periods, samples // periods, **flow_options)
            lowest[rows], highest[rows] = extent(part, finer.times, finer.states, **flow_options)
    return lowest, highest
