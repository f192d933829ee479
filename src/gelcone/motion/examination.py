"""What one motion shows: the cycle it returns to, its exponents, the 0-1 test, and the name that follows."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome, Regime
from gelcone.motion.cycle import (
    LONGEST_PERIOD,
    NEAR_RETURN,
    PHASES,
    RETURN_TOLERANCE,
    RETURNS,
    SMALLEST_SIZE,
    Cycles,
    find_cycles,
    follow,
    periods_of,
)
from gelcone.motion.evidence import Evidence
from gelcone.motion.flow import integrate
from gelcone.motion.lyapunov import average, bound_shear, shear_level
from gelcone.motion.settle import (
    LONG_STRETCH,
    STRETCH,
)
from gelcone.motion.tangents import CERTAIN, FLOOR
from gelcone.motion.validity import spread_over, validity
from gelcone.motion.zero_one import zero_one
from gelcone.physics.members import Members
from gelcone.quantity import Array

REST_TOLERANCE = 1e-6
TEST_POINTS = (200, 800)
"""Points of the 0-1 test, and of its repetition where the first is no clear answer."""
ENDED = 1e-3
"""Chaos has ended when the last points of its 0-1 test return this closely."""
DRIFT_WINDOWS = 8
CHAOTIC_K = 0.8
REGULAR_K = 0.2
CYCLE_SAMPLES = 64
"""Samples of a forcing period of a cycle, for its extent."""


def examine(
    steps: tuple[Callable[..., object], ...],
    members: Members,
    rows: npt.NDArray[np.intp],
    evidence: Evidence,
    options: dict[str, Any],
) -> npt.NDArray[np.intp]:
    """Takes some members through the steps; those that are still running after them."""
    for step in steps:
        rows = alive(rows, evidence)
        if rows.size:
            step(members.take(rows), rows, evidence, options)
    return alive(rows, evidence)


def alive(rows: npt.NDArray[np.intp], evidence: Evidence) -> npt.NDArray[np.intp]:
    return rows[evidence.outcome[rows] == Outcome.OK]


def look(members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any]) -> Array:
    """Follows `RETURNS` forcing periods: section points and extent; the path (members, periods, phases, N)."""
    path, evidence.outcome[rows], times, states = follow(members, evidence.final[rows], **options)
    evidence.validity[rows] = validity(members, times, states)
    x = path[..., 0]
    evidence.lowest[rows], evidence.highest[rows] = x.min(axis=(1, 2)), x.max(axis=(1, 2))
    evidence.section[rows], evidence.final[rows] = path[:, :, -1], path[:, -1, -1]
    evidence.test_phase[rows] = _widest(x)
    return path


def examine_returns(members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any]) -> None:
    """Whether undamped members return or are at rest."""
    path = look(members, rows, evidence, options)
    x, u = path[..., 0], path[..., 1]
    whole = path.reshape(len(x), RETURNS, -1)
    period, distance = periods_of(whole, RETURN_TOLERANCE)
    still = (np.ptp(x, axis=(1, 2)) < REST_TOLERANCE) & (np.abs(u).max(axis=(1, 2)) < REST_TOLERANCE)
    evidence.period[rows] = np.where(still, 0, period)
    evidence.return_distance[rows] = distance
    evidence.symmetric[rows] = symmetric(whole, period, np.tile(members.system.mirror, PHASES)) & members.symmetric
    evidence.regime[rows] = np.select([still, period > 0], [Regime.REST, Regime.PERIODIC], Regime.TRANSIENT)


def _widest(displacement: Array) -> npt.NDArray[np.int64]:
    """The sample within a period at which the displacements (members, periods, phases) differ the most.

    Samples are numbered from 0 at phase 0, whereas the last of the path's samples of a period lies at its end.
    """
    return (np.ptp(displacement, axis=1).argmax(axis=1) + 1) % PHASES


def symmetric(points: Array, period: npt.NDArray[np.int64], signs: Array | float = -1.0) -> npt.NDArray[np.bool_]:
    """Whether a periodic motion maps onto itself under x -> -x: its first point mirrored is a point of its cycle.

    ``points`` (members, periods, coordinates); ``signs`` of the coordinates under the reflection.
    """
    scale = np.maximum(np.abs(points).max(axis=(1, 2)), SMALLEST_SIZE)
    gaps = np.abs(points[:, :LONGEST_PERIOD] - signs * points[:, :1]).max(axis=2)
    within = np.arange(LONGEST_PERIOD) < np.maximum(period, 1)[:, None]
    return np.where(within, gaps, np.inf).min(axis=1) < 10 * RETURN_TOLERANCE * scale


def find_cycle(members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any]) -> None:
    """Names the damped motions that return by the cycle they return to; without one they do not count as returned."""
    returns = evidence.period[rows] > 0
    if not returns.any():
        return
    members, rows = members.take(returns), rows[returns]
    cycles = find_cycles(members, evidence.final[rows], evidence.period[rows], **options)
    still = cycles.extent < REST_TOLERANCE
    evidence.regime[rows] = np.where(cycles.found, np.where(still, Regime.REST, Regime.PERIODIC), Regime.TRANSIENT)
    evidence.period[rows] = np.where(cycles.found & ~still, cycles.period, 0)
    evidence.symmetric[rows] = cycles.found & cycles.symmetric & members.symmetric
    evidence.cycle_distance[rows] = np.where(cycles.found, cycles.distance, np.nan)
    evidence.sign[rows] = 0
    found = rows[cycles.found]
    evidence.exponents[found] = cycles.exponents[cycles.found]
    evidence.standard_error[found] = cycles.error[cycles.found]
    evidence.averaged_time[found] = cycles.time[cycles.found]
    largest, error = cycles.exponents[cycles.found, 0], cycles.error[cycles.found, 0]
    evidence.sign[found] = np.where(np.abs(largest) > np.maximum(CERTAIN * error, FLOOR), np.sign(largest), 0)
    _draw(members.take(cycles.found), found, cycles.take(cycles.found), evidence, options)


def _draw(
    members: Members, rows: npt.NDArray[np.intp], cycles: Cycles, evidence: Evidence, options: dict[str, Any]
) -> None:
    """Section points and extent of cycles, from one turn of each: what repeats need not be followed."""
    for repeats in np.unique(cycles.period):
        same = np.flatnonzero(cycles.period == repeats)
        part, count = members.take(same), repeats * CYCLE_SAMPLES
        even, spread = np.arange(1, count + 1) / CYCLE_SAMPLES, spread_over(repeats)
        ticks = np.union1d(even, spread)
        turn = integrate(part, cycles.point[same], part.forcing_period[:, None] * ticks, **options)
        path, between = turn.states[:, np.searchsorted(ticks, even)], np.searchsorted(ticks, spread)
        evidence.validity[rows[same]] = validity(part, turn.times[:, between], turn.states[:, between], turn=True)
        section, at = path[:, CYCLE_SAMPLES - 1 :: CYCLE_SAMPLES], rows[same]
        evidence.lowest[at], evidence.highest[at] = path[..., 0].min(axis=1), path[..., 0].max(axis=1)
        evidence.section[at] = section[:, np.arange(RETURNS) % repeats]
        evidence.final[at] = section[:, -1]


def unsettled(members: Members, rows: npt.NDArray[np.intp], evidence: Evidence) -> npt.NDArray[np.bool_]:
    """Damped members that are on no attracting cycle yet: slow, or on their way through chaos, which may take long.

    Not those that do not move at all, for which more time changes nothing.
    """
    attracted = (evidence.sign[rows] < 0) & (evidence.cycle_distance[rows] < NEAR_RETURN)
    return members.damped[rows] & ~attracted & (evidence.return_distance[rows] > 0.0)


def is_chaotic(evidence: Evidence, rows: npt.NDArray[np.intp]) -> npt.NDArray[np.bool_]:
    """Whether both opinions say so."""
    wandering = evidence.regime[rows] == Regime.TRANSIENT
    agree = (evidence.sign[rows] > 0) & (evidence.zero_one[rows] > CHAOTIC_K)
    return wandering & agree & ~evidence.under_way[rows]


def measure(
    members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any], *, budget: float
) -> None:
    """The exponents of those that are on no cycle, by averaging."""
    stretch = LONG_STRETCH if members.system.planar else STRETCH
    result = average(members, evidence.final[rows], budget=budget, stretch=stretch, **options)
    bound_shear(members, result)
    evidence.exponents[rows], evidence.standard_error[rows] = result.values, result.standard_error
    evidence.averaged_time[rows], evidence.sign[rows] = result.time, result.sign
    evidence.outcome[rows] = result.outcome
    ok = result.outcome == Outcome.OK
    evidence.final[rows[ok]] = result.states[ok]


def second_opinion(members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any]) -> None:
    """The 0-1 test of the members that do not return and may not be slow: chaotic ones, and those that may be
    quasi-periodic."""
    regular = ~members.damped | ((not members.system.planar) & (evidence.sign[rows] == 0))
    wandering = (evidence.regime[rows] == Regime.TRANSIENT) & ((evidence.sign[rows] > 0) | regular)
    for points in TEST_POINTS:
        part = rows[wandering]
        if not part.size:
            return
        _test(members.take(wandering), part, evidence, points, options)
        unclear = ~((evidence.zero_one[part] < REGULAR_K) | (evidence.zero_one[part] > CHAOTIC_K))
        wandering[wandering] = unclear & (evidence.outcome[part] == Outcome.OK)


def _test(
    members: Members,
    rows: npt.NDArray[np.intp],
    evidence: Evidence,
    points: int,
    options: dict[str, Any],
) -> None:
    """The 0-1 test at the phase at which the motion varies the most, and whether the motion was under way in it."""
    phase = evidence.test_phase[rows] / PHASES
    shares = np.stack([np.where(phase > 0.0, phase, 0.5), np.ones(len(rows))], axis=1)
    ticks = (np.arange(points)[:, None] + shares[:, None, :]).reshape(len(rows), -1)
    flow = integrate(members, evidence.final[rows], members.forcing_period[:, None] * ticks, **options)
    between, section = flow.states[:, ::2], flow.states[:, 1::2]
    evidence.outcome[rows], evidence.final[rows] = flow.outcome, section[:, -1]
    evidence.zero_one[rows] = zero_one(np.where(phase[:, None] > 0.0, between[..., 0], section[..., 0]))
    evidence.under_way[rows] = (periods_of(section[:, -RETURNS:], ENDED)[0] > 0) | drifts(section)


def drifts(section: Array) -> npt.NDArray[np.bool_]:
    """Whether a motion leaves an unstable cycle or rest behind, ever faster, its section (members, points, N) says.

    The deviations grow as in chaos, but every return after the period of that cycle is worse than those before; in
    chaos there are always closer ones to come.
    """
    drifting = np.zeros(len(section), dtype=bool)
    for period in range(1, LONGEST_PERIOD + 1):
        gap = np.abs(section[:, period:] - section[:, :-period]).max(axis=2)
        length = gap.shape[1] // DRIFT_WINDOWS
        worst = gap[:, : length * DRIFT_WINDOWS].reshape(len(gap), DRIFT_WINDOWS, length).max(axis=2)
        drifting |= (np.diff(worst, axis=1) > 0.0).all(axis=1)
    return drifting


def judge(members: Members, evidence: Evidence) -> None:
    """Names those that do not return, and marks every verdict that its evidence does not support."""
    losing = members.damped
    ran = evidence.outcome == Outcome.OK
    wandering = (evidence.regime == Regime.TRANSIENT) & ran
    # Chaos without damping sticks to the islands in it for long, so that its average may never become steady.
    sticky = ~losing & (evidence.exponents[:, 0] > shear_level(evidence.averaged_time)) & (evidence.sign == 0)
    sticky &= evidence.zero_one > CHAOTIC_K
    chaotic = wandering & ((evidence.sign > 0) | sticky) & ~(losing & evidence.under_way)
    neutral = (evidence.sign == 0) & (evidence.zero_one < REGULAR_K) & ~evidence.under_way
    on_torus = (not members.system.planar) & neutral
    quasi_periodic = wandering & ~chaotic & (~losing | on_torus)
    evidence.regime[chaotic] = Regime.CHAOTIC
    evidence.regime[quasi_periodic] = Regime.QUASI_PERIODIC
    evidence.regime[~ran] = Regime.LEFT_THE_DOMAIN
    # that a run ran out of steps, or of digits beside its stretch limit, says nothing of where the motion goes
    stopped = np.isin(evidence.outcome, (Outcome.STEP_LIMIT, Outcome.STRETCH_LIMIT))
    evidence.regime[stopped] = Regime.TRANSIENT
    evidence.doubtful = chaotic & (sticky | ~(evidence.zero_one > CHAOTIC_K))
    evidence.doubtful |= quasi_periodic & ~(evidence.zero_one < REGULAR_K)
    # A cycle or a rest that attracts has a negative exponent; without damping it is neutral at best.
    returns = (evidence.regime == Regime.REST) | (evidence.regime == Regime.PERIODIC)
    evidence.doubtful |= returns & np.where(losing, evidence.sign >= 0, evidence.sign > 0)
    evidence.doubtful |= evidence.regime == Regime.TRANSIENT
