"""Slow drift: where a film creeps far more slowly than its drive repeats, the motion is followed without the wait.

Such a motion nearly returns after some forcing periods, and drifts. The map over these periods, with its tangent map,
gives at one point what the drift is and how it changes; the linearised map repeated K times takes the motion K periods
further at the cost of one (an exponential Rosenbrock-Euler method: Hochbruck and Ostermann, Acta Numerica 19 (2010)
209, for a map). K doubles as long as the drift beyond is what the linear map says. At the end K is as good as infinite,
and the step is Newton's. A drift on which the fast motion loses its stability, the film its hold or the steps their
way is followed as far as it leads.
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
from gelcone.motion.settle import clocks
from gelcone.physics.members import Members
from gelcone.quantity import Array

TOLERANCE = 1e-10
"""Least tolerance of the map: its error counts as often as the slow state needs forcing periods to relax."""
SLIP = 3e-3
"""Error of a step over the motion's size."""
REACH = 0.2
"""Longest step over the motion's size."""
SETTLED = 1e-6
"""What is left of the drift, over the motion's size, where the linear map has forgotten where it began."""
SMALLEST_DECAY = 1e-12
"""Smallest decay of a deviation in one turn that rounding does not hide."""
GROWTH = 10.0
"""No drift ends where a deviation grows by more than this times what the slowest state forgets in the same time."""
MOST_DOUBLINGS = 50
FEWEST_PERIODS = 4
"""Where fewer repetitions of the map at once are too many, a step gains nothing."""
MOST_STEPS = 60
"""Turns of a motion."""


@dataclass(frozen=True)
class Returned(Columns):
    """Motions after one turn of the map: where they are less where they began, ``gap`` (members, N), the ``tangent``
    map (members, N, N), their ``size`` and largest ``growth`` of a deviation (members,); NaN where a run ended."""

    gap: Array = column(np.nan, "N")
    tangent: Array = column(np.nan, "N", "N")
    size: Array = column()
    growth: Array = column()


class Drift(NamedTuple):
    """Drifts of motions: the points (members, N) to which they were followed, the ``time`` (members,) that it takes to
    come there, whether they end there (members,), and all points on the way, ``course`` (members, points, N), NaN
    beyond the last."""

    point: Array
    time: Array
    ends: npt.NDArray[np.bool_]
    course: Array


def drifted(members: Members, states: Array, period: npt.NDArray[np.int64], **flow_options: Any) -> Drift:
    """The drift of motions that nearly return after ``period`` (members,) forcing periods from ``states`` (members, N)
    at phase 0. A member's numbers depend on nothing but itself."""
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
        own = at.take(rows)
        leap = _leap(own, most[rows], members.time_constant[rows] / turn[rows])
        new = _returned(members.take(rows), point[rows] + leap.step, period[rows], flow_options)
        with np.errstate(all="ignore"):
            error = np.abs(mapped(leap.sum, new.gap - leap.gap)).max(axis=1) / own.size / SLIP
            good = (error < 1.0) & np.isfinite(new.growth)
            change = np.where(np.isfinite(error), np.floor(-0.5 * np.log2(np.maximum(error, 1e-6))), -4.0)
        most[rows] = leap.doublings + np.where(good, np.maximum(change, 0.0), np.minimum(change, -1.0)).astype(int)
        beyond = np.isnan(new.size)  # where the film has ended: no later leap need be as long
        longest[rows[beyond]] = leap.doublings[beyond] - 1
        most[rows] = np.minimum(most[rows], longest[rows])
        gone = rows[good]
        point[gone] += leap.step[good]
        time[gone] += turn[gone] * 2.0 ** leap.doublings[good]
        at.put(gone, new.take(good))
        there = good & leap.settled & (np.abs(leap.step).max(axis=1) < 0.1 * NEAR_RETURN * own.size)
        there &= new.growth < fastest_growth[rows]
        ends[rows[there]] = True
        course.append(np.full(states.shape, np.nan))
        course[-1][gone] = point[gone]
        rows = rows[~there & (2.0 ** most[rows] >= FEWEST_PERIODS)]
    return Drift(point, time, ends, _passed(np.stack(course, axis=1)))


def _passed(course: Array) -> Array:
    """The points (members, points, N) of each member in a row, those that are NaN last."""
    order = np.argsort(np.isnan(course[..., 0]), axis=1, kind="stable")
    passed = np.take_along_axis(course, order[..., None], axis=1)
    return passed[:, : int(np.isfinite(passed[..., 0]).sum(axis=1).max(initial=0))]


class _Leap(NamedTuple):
    """Repetitions of linearised maps: 2^``doublings`` (members,) of them, the ``step`` (members, N) that they take, the
    ``sum`` (members, N, N) that gives it of the gap, the ``gap`` (members, N) thereafter, and whether that is
    ``settled``."""

    doublings: npt.NDArray[np.int64]
    step: Array
    sum: Array
    gap: Array
    settled: npt.NDArray[np.bool_]


def _leap(at: Returned, most: npt.NDArray[np.int64], slowest: Array) -> _Leap:
    """As many repetitions as settle, at most 2^``most`` (members,) and no more than keep within `REACH`.

    A drift so slow that one repetition changes nothing has not settled before as many as the slowest state needs,
    ``slowest`` (members,), or the slowest deviation of the map.
    """
    total, power = np.tile(np.eye(at.gap.shape[1]), (len(at.gap), 1, 1)), at.tangent.copy()
    step, gap = at.gap.copy(), mapped(power, at.gap)
    doublings, going = np.zeros(len(gap), dtype=np.int64), np.ones(len(gap), dtype=bool)
    settled = np.zeros(len(gap), dtype=bool)
    with np.errstate(all="ignore"):
        fewest = np.log2(np.fmax(slowest, -1.0 / np.log(np.minimum(at.growth, 1.0 - SMALLEST_DECAY))))
        for _ in range(MOST_DOUBLINGS):
            sums, powers = total + power @ total, power @ power
            steps, gaps = mapped(sums, at.gap), mapped(powers, at.gap)
            settled |= going & (doublings >= fewest) & (np.abs(steps - step).max(axis=1) < SETTLED * at.size)
            near = np.abs(steps).max(axis=1) < REACH * at.size  # not so where one is not finite
            going &= near & (doublings < most) & ~settled
            if not going.any():
                break
            total[going], power[going] = sums[going], powers[going]
            step[going], gap[going] = steps[going], gaps[going]
            doublings += going
    return _Leap(doublings, step, total, gap, settled)


def _returned(members: Members, states: Array, period: npt.NDArray[np.int64], options: dict[str, Any]) -> Returned:
    """One turn of the map of ``period`` (members,) forcing periods from ``states`` (members, N)."""
    options = options | {"tolerance": max(options.get("tolerance", DEFAULT_TOLERANCE), TOLERANCE)}
    found = Returned.blank(len(states), states=states.shape[1])
    for group, clock in clocks(members):
        for repeats in np.unique(period[group]):
            same = period[group] == repeats
            rows = group[same]
            ticks = np.arange(1, int(repeats) * clock.per_repeat + 1) / clock.per_repeat
            times = clock.repeat[same, None] * ticks
            run = integrate(members.take(rows), states[rows], times, keep="tangents", **options)
            assert run.tangents is not None
            done = np.flatnonzero(run.outcome == Outcome.OK)
            product, log_scale = scaled_product(run.tangents[done])
            tangent = product * np.exp(log_scale)[:, None, None]
            size = np.maximum(np.abs(run.states[done]).max(axis=(1, 2)), SMALLEST_SIZE)
            growth = np.abs(np.linalg.eigvals(tangent)).max(axis=1)
            gap = run.states[done, -1] - states[rows[done]]
            found.put(rows[done], Returned(gap, tangent, size, growth))
    return found
