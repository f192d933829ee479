"""Slow drift of motions whose film creeps far more slowly than the drive repeats, in long steps.

Such a motion nearly returns after some forcing periods, and drifts. The map over these periods and its tangent map
give the drift at a point and its rate of change; K repetitions of the linearised map take the motion K times as far at
the cost of one (an exponential Rosenbrock-Euler method: Hochbruck and Ostermann, Acta Numerica 19 (2010) 209, for a
map). K doubles as long as the linear map predicts the drift. At the end K is nearly infinite, and the step is that of
Newton's method. A drift is followed no further than to where the fast motion becomes unstable, the film pulls in or
the steps become too short.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.motion.attractor.cycle import NEAR_RETURN, SMALLEST_SIZE
from gelcone.motion.columns import Columns, column
from gelcone.motion.cyclic import scaled_product
from gelcone.motion.flow import DEFAULT_TOLERANCE, integrate
from gelcone.motion.orbit import mapped
from gelcone.motion.settle import turns
from gelcone.physics.members import Members
from gelcone.quantity import Array

TOLERANCE = 1e-10
"""Least tolerance of the map: its error adds up over the forcing periods in which the slow state relaxes."""
SLIP = 3e-3
"""Largest error of a step over the motion's size."""
REACH = 0.2
"""Longest step over the motion's size."""
SETTLED = 1e-6
"""Change of the drift by a doubling, over the motion's size, below which the repeated linear map has converged."""
SMALLEST_DECAY = 1e-12
"""Smallest decay of a deviation in one turn of the map that exceeds rounding."""
GROWTH = 10.0
"""Largest growth of a deviation at the end of a drift, over the decay of the slowest state in the same time."""
MOST_DOUBLINGS = 50
FEWEST_PERIODS = 4
"""Least number of repetitions of the map by which a step is worth its cost."""
MOST_STEPS = 60
"""Largest number of steps of a drift."""


@dataclass(frozen=True)
class Returned(Columns):
    """One turn of the map; NaN where a run ended.

    ``gap`` (members, N), the state after the turn less that before; the ``tangent`` map (members, N, N); the ``size``
    of the motion and the largest ``growth`` of a deviation (members,).
    """

    gap: Array = column(np.nan, "N")
    tangent: Array = column(np.nan, "N", "N")
    size: Array = column()
    growth: Array = column()


class Drift(NamedTuple):
    """Drifts of motions.

    The last ``point`` (members, N) to which they were followed, its ``time`` (members,), ``ends``, true for each drift
    that ends there, and the ``course`` (members, points, N) of all points, NaN beyond the last.
    """

    point: Array
    time: Array
    ends: npt.NDArray[np.bool_]
    course: Array


def drifted(members: Members, states: Array, period: npt.NDArray[np.int64], **flow_options: Any) -> Drift:
    """Follow the drift of motions from ``states`` (members, N) at phase 0 that nearly return after ``period``
    (members,) forcing periods. A member's numbers do not depend on the others."""
    count = len(states)
    point, time = states.copy(), np.zeros(count)
    ends, most = np.zeros(count, dtype=bool), np.full(count, MOST_DOUBLINGS)
    longest, course = most.copy(), [states.copy()]
    turn = period * members.forcing_period
    fastest_growth = 1.0 + GROWTH * turn / np.maximum(members.time_constant, turn)
    rows = np.arange(count)
    at = _returned(members, point, period, flow_options)
    rows = rows[np.isfinite(at.growth)]
    for _ in range(MOST_STEPS):
        if not rows.size:
            break
        before = at.take(rows)
        leap = _repeated(before, most[rows], members.time_constant[rows] / turn[rows])
        new = _returned(members.take(rows), point[rows] + leap.step, period[rows], flow_options)
        with np.errstate(all="ignore"):
            error = np.abs(mapped(leap.sum, new.gap - leap.gap)).max(axis=1) / before.size / SLIP
            good = (error < 1.0) & np.isfinite(new.growth)
            change = np.where(np.isfinite(error), np.floor(-0.5 * np.log2(np.maximum(error, 1e-6))), -4.0)
        most[rows] = leap.doublings + np.where(good, np.maximum(change, 0.0), np.minimum(change, -1.0)).astype(int)
        beyond = np.isnan(new.size)  # the film pulled in: later steps stay shorter
        longest[rows[beyond]] = leap.doublings[beyond] - 1
        most[rows] = np.minimum(most[rows], longest[rows])
        advanced = rows[good]
        point[advanced] += leap.step[good]
        time[advanced] += turn[advanced] * 2.0 ** leap.doublings[good]
        at.put(advanced, new.take(good))
        arrived = good & leap.settled & (np.abs(leap.step).max(axis=1) < 0.1 * NEAR_RETURN * before.size)
        arrived &= new.growth < fastest_growth[rows]
        ends[rows[arrived]] = True
        course.append(np.full(states.shape, np.nan))
        course[-1][advanced] = point[advanced]
        rows = rows[~arrived & (2.0 ** most[rows] >= FEWEST_PERIODS)]
    return Drift(point, time, ends, _passed(np.stack(course, axis=1)))


def _passed(course: Array) -> Array:
    """Moves points that are NaN behind the others; (members, points, N)."""
    order = np.argsort(np.isnan(course[..., 0]), axis=1, kind="stable")
    passed = np.take_along_axis(course, order[..., None], axis=1)
    return passed[:, : int(np.isfinite(passed[..., 0]).sum(axis=1).max(initial=0))]


class _Leap(NamedTuple):
    """Repetitions of a linearised map.

    Their number is 2^``doublings`` (members,); ``step`` (members, N) that they take; ``sum`` (members, N, N) of the
    powers of the map, whose product with the first gap is the step; ``gap`` (members, N) thereafter; ``settled``, true
    for each step that has converged.
    """

    doublings: npt.NDArray[np.int64]
    step: Array
    sum: Array
    gap: Array
    settled: npt.NDArray[np.bool_]


def _repeated(at: Returned, most: npt.NDArray[np.int64], slowest: Array) -> _Leap:
    """Repeats the linearised map until the step converges, at most 2^``most`` (members,) times and within `REACH`.

    A step converges no sooner than after the number of turns in which the slowest state relaxes, ``slowest``
    (members,), or the slowest deviation of the map: before, a drift may be too slow to show.
    """
    total, power = np.tile(np.eye(at.gap.shape[1]), (len(at.gap), 1, 1)), at.tangent.copy()
    step, gap = at.gap.copy(), mapped(power, at.gap)
    doublings, active = np.zeros(len(gap), dtype=np.int64), np.ones(len(gap), dtype=bool)
    settled = np.zeros(len(gap), dtype=bool)
    with np.errstate(all="ignore"):
        fewest = np.log2(np.fmax(slowest, -1.0 / np.log(np.minimum(at.growth, 1.0 - SMALLEST_DECAY))))
        for _ in range(MOST_DOUBLINGS):
            sums, powers = total + power @ total, power @ power
            steps, gaps = mapped(sums, at.gap), mapped(powers, at.gap)
            settled |= active & (doublings >= fewest) & (np.abs(steps - step).max(axis=1) < SETTLED * at.size)
            near = np.abs(steps).max(axis=1) < REACH * at.size  # false where a step is not finite
            active &= near & (doublings < most) & ~settled
            if not active.any():
                break
            total[active], power[active] = sums[active], powers[active]
            step[active], gap[active] = steps[active], gaps[active]
            doublings += active
    return _Leap(doublings, step, total, gap, settled)


def _returned(members: Members, states: Array, period: npt.NDArray[np.int64], options: dict[str, Any]) -> Returned:
    """One turn of the map of ``period`` (members,) forcing periods from ``states`` (members, N)."""
    options = options | {"tolerance": max(options.get("tolerance", DEFAULT_TOLERANCE), TOLERANCE)}
    returned = Returned.blank(len(states), states=states.shape[1])
    for rows, clock, repeats in turns(members, period):
        times = clock.repeat[:, None] * (np.arange(1, repeats * clock.per_repeat + 1) / clock.per_repeat)
        run = integrate(members.take(rows), states[rows], times, keep="tangents", **options)
        assert run.tangents is not None
        done = np.flatnonzero(run.outcome == Outcome.OK)
        product, log_scale = scaled_product(run.tangents[done])
        tangent = product * np.exp(log_scale)[:, None, None]
        size = np.maximum(np.abs(run.states[done]).max(axis=(1, 2)), SMALLEST_SIZE)
        growth = np.abs(np.linalg.eigvals(tangent)).max(axis=1)
        gap = run.states[done, -1] - states[rows[done]]
        returned.put(rows[done], Returned(gap, tangent, size, growth))
    return returned
