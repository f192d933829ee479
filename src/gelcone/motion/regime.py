"""What kind of motion it is - rest, periodic, quasi-periodic, chaotic, not settled, left the domain - with evidence.

The motion settles and is then examined: does it return (`periods_of`), and is there a cycle or a rest that it returns
to (`find_cycles`)? A motion that does not settle on an attracting cycle is given more time, up to a bound. Motions that
have not settled then are measured: does the largest Lyapunov exponent have a certain sign, and what does the 0-1 test
say?

With two states and damping, a quasi-periodic motion is impossible: its section points would lie on a closed curve, and
the map that carries the curve onto itself shrinks the area inside by exp(-2 zeta T). With more states it is possible,
and a damped motion whose largest exponent is zero within its error and whose 0-1 test is regular is named so.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome, Regime
from gelcone.dataset import Findings
from gelcone.motion.cycle import (
    LONGEST_PERIOD,
    NEAR_RETURN,
    PHASES,
    RETURN_TOLERANCE,
    RETURNS,
    SMALLEST_SIZE,
    coexisting_attractors,
    find_cycles,
    follow,
    periods_of,
)
from gelcone.motion.evidence import Evidence, label_regimes
from gelcone.motion.flow import DEFAULT_TOLERANCE, integrate
from gelcone.motion.lyapunov import average, shear_level
from gelcone.motion.settle import (
    LONG_STRETCH,
    STRETCH,
    check_budgets,
    repeats_lasting,
    round_duration,
    settle,
    start_states,
    transient_of,
)
from gelcone.motion.tangents import CERTAIN, FLOOR
from gelcone.motion.validity import validity
from gelcone.motion.zero_one import zero_one
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.progress import Counted, Progress, weighted
from gelcone.quantity import Array, check_count

if TYPE_CHECKING:
    import xarray as xr

REST_TOLERANCE = 1e-6
ROUNDS = 5
"""A motion that has not settled is examined this many times, each after as long as all rounds before together: chaos
that ends in a cycle often lasts for ten transients, and only time tells it from chaos that lasts."""
STARTS_A_ROUND = 5
"""Starts of the search for attractors that coexist with chaos, for each of the rounds."""
FOLLOW_TOLERANCE = 1e-10
"""Tolerance of damped motions that have not settled at first: one that settles later forgets the error, and of chaos
only averages are taken, which are uncertain by far more."""
TEST_POINTS = (200, 800)
"""Points of the 0-1 test, and of its repetition where the first is no clear answer."""
ENDED = 1e-3
"""Chaos has ended when the last points of its 0-1 test return this closely."""
DRIFT_WINDOWS = 8
CHAOTIC_K = 0.8
REGULAR_K = 0.2
FIRST_ROUND, LATER_ROUNDS = 0.4, 0.4
"""Shares of the progress; the rest is for the measures."""


def classify(
    members: Members,
    states: Array,
    *,
    transient: float | None = None,
    budget: float = 20_000.0,
    rounds: int = ROUNDS,
    progress: Progress = None,
    **flow_options: Any,
) -> Evidence:
    """The regime of every member of a flattened ensemble from its initial state (members, N), with the evidence.

    The workhorse behind `regime`, bifurcation diagrams and maps: a member's result depends on nothing but itself.
    ``rounds`` says how often a motion that has not settled is examined, and how long the search for attractors that
    coexist with chaos is; fewer than the default are faster and take chaos that does not last for chaos.
    """
    evidence = Evidence.blank(members.size, len(members.system.states))
    evidence.final[:] = states
    counted = Counted(progress)
    duration = transient_of(members, transient)
    loose = flow_options | {"tolerance": max(flow_options.get("tolerance", 0.0), FOLLOW_TOLERANCE)}
    unsettled = np.arange(members.size)
    for trial in range(rounds):
        options = loose if trial else flow_options
        share = LATER_ROUNDS / (rounds - 1) if trial else FIRST_ROUND
        _settle(members, unsettled, duration, trial, evidence, options | {"progress": weighted(counted, share)})
        unsettled = _examine((_examine_returns,), members, unsettled, evidence, options)
        unsettled = _examine((_find_cycle,), members, unsettled, evidence, flow_options)
        unsettled = unsettled[_unsettled(members, unsettled, evidence)]
        if not unsettled.size:
            break
    wandering = _alive(np.flatnonzero(np.isnan(evidence.cycle_distance)), evidence)
    losing = members.damped[wandering]
    measures = (partial(_measure, budget=budget), partial(_second_opinion, rounds=rounds))
    _examine(measures, members, wandering[~losing], evidence, flow_options)
    wandering = _examine(measures, members, wandering[losing], evidence, loose)
    # What was chaotic may have ended while it was measured.
    ended = wandering[_unsettled(members, wandering, evidence) & ~_is_chaotic(evidence, wandering)]
    _examine((_examine_returns, _find_cycle), members, ended, evidence, flow_options)
    _judge(members, evidence)
    counted.finish()
    return evidence


def _examine(
    steps: tuple[Callable[..., None], ...],
    members: Members,
    rows: npt.NDArray[np.intp],
    evidence: Evidence,
    options: dict[str, Any],
) -> npt.NDArray[np.intp]:
    """Takes some members through the steps; those that are still running after them."""
    for step in steps:
        rows = _alive(rows, evidence)
        if rows.size:
            step(members.take(rows), rows, evidence, options)
    return _alive(rows, evidence)


def _alive(rows: npt.NDArray[np.intp], evidence: Evidence) -> npt.NDArray[np.intp]:
    return rows[evidence.outcome[rows] == Outcome.OK]


def _settle(
    members: Members,
    rows: npt.NDArray[np.intp],
    duration: Array,
    trial: int,
    evidence: Evidence,
    options: dict[str, Any],
) -> None:
    """Lets ``duration`` (of all members) pass, and in later rounds as long as all before together."""
    part, span = members.take(rows), round_duration(duration[rows], trial)
    if trial:  # the examination before was part of the time that this round lasts
        span = np.maximum(span - RETURNS * part.forcing_period, 0.0)
    evidence.final[rows], evidence.outcome[rows] = settle(
        part, evidence.final[rows], repeats_lasting(part, span), **options
    )
    evidence.settled_time[rows] += span


def _examine_returns(members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any]) -> None:
    """Follows `RETURNS` forcing periods: section points, amplitude, returns, rest."""
    path, evidence.outcome[rows], times, states = follow(members, evidence.final[rows], **options)
    evidence.validity[rows] = validity(members, times, states)
    evidence.cycle_distance[rows] = np.nan
    x, u = path[..., 0], path[..., 1]
    evidence.lowest[rows], evidence.highest[rows] = x.min(axis=(1, 2)), x.max(axis=(1, 2))
    evidence.section[rows], evidence.final[rows] = path[:, :, -1], path[:, -1, -1]
    evidence.test_phase[rows] = _widest(x)
    losing = members.damped
    whole = path.reshape(len(x), RETURNS, -1)
    period, distance = periods_of(whole, np.where(losing, NEAR_RETURN, RETURN_TOLERANCE))
    still = (np.ptp(x, axis=(1, 2)) < REST_TOLERANCE) & (np.abs(u).max(axis=(1, 2)) < REST_TOLERANCE)
    evidence.period[rows] = np.where(still & ~losing, 0, period)
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


def _find_cycle(members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any]) -> None:
    """Names the damped motions that return by the cycle they return to; without one they do not count as returned."""
    returns = (evidence.period[rows] > 0) & members.damped
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


def _unsettled(members: Members, rows: npt.NDArray[np.intp], evidence: Evidence) -> npt.NDArray[np.bool_]:
    """Damped members that are on no attracting cycle yet: slow, or on their way through chaos, which may take long.

    Not those that do not move at all, for which more time changes nothing.
    """
    attracted = (evidence.sign[rows] < 0) & (evidence.cycle_distance[rows] < NEAR_RETURN)
    return members.damped[rows] & ~attracted & (evidence.return_distance[rows] > 0.0)


def _is_chaotic(evidence: Evidence, rows: npt.NDArray[np.intp]) -> npt.NDArray[np.bool_]:
    """Whether both opinions say so."""
    wandering = evidence.regime[rows] == Regime.TRANSIENT
    agree = (evidence.sign[rows] > 0) & (evidence.zero_one[rows] > CHAOTIC_K)
    return wandering & agree & ~evidence.under_way[rows]


def _measure(
    members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any], *, budget: float
) -> None:
    """The exponents of those that are on no cycle, by averaging."""
    stretch = LONG_STRETCH if members.system.planar else STRETCH
    result = average(members, evidence.final[rows], budget=budget, stretch=stretch, **options)
    evidence.exponents[rows], evidence.standard_error[rows] = result.values, result.standard_error
    evidence.averaged_time[rows], evidence.sign[rows] = result.time, result.sign
    evidence.outcome[rows] = result.outcome
    ok = result.outcome == Outcome.OK
    evidence.final[rows[ok]] = result.states[ok]


def _second_opinion(
    members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any], *, rounds: int
) -> None:
    """The 0-1 test of the members that do not return and may not be slow: chaotic ones, and those that may be
    quasi-periodic."""
    regular = ~members.damped | ((not members.system.planar) & (evidence.sign[rows] == 0))
    wandering = (evidence.regime[rows] == Regime.TRANSIENT) & ((evidence.sign[rows] > 0) | regular)
    for points in TEST_POINTS:
        part = rows[wandering]
        if not part.size:
            return
        _test(members.take(wandering), part, evidence, points, rounds, options)
        unclear = ~((evidence.zero_one[part] < REGULAR_K) | (evidence.zero_one[part] > CHAOTIC_K))
        wandering[wandering] = unclear & (evidence.outcome[part] == Outcome.OK)


def _test(
    members: Members,
    rows: npt.NDArray[np.intp],
    evidence: Evidence,
    points: int,
    rounds: int,
    options: dict[str, Any],
) -> None:
    """The 0-1 test at the phase at which the motion varies the most, and whether an attractor coexists with chaos."""
    phase = evidence.test_phase[rows] / PHASES
    shares = np.stack([np.where(phase > 0.0, phase, 0.5), np.ones(len(rows))], axis=1)
    ticks = (np.arange(points)[:, None] + shares[:, None, :]).reshape(len(rows), -1)
    flow = integrate(members, evidence.final[rows], members.forcing_period[:, None] * ticks, **options)
    between, section = flow.states[:, ::2], flow.states[:, 1::2]
    evidence.outcome[rows], evidence.final[rows] = flow.outcome, section[:, -1]
    evidence.zero_one[rows] = zero_one(np.where(phase[:, None] > 0.0, between[..., 0], section[..., 0]))
    evidence.under_way[rows] = (periods_of(section[:, -RETURNS:], ENDED)[0] > 0) | drifts(section)
    chaotic = np.flatnonzero(members.damped & _is_chaotic(evidence, rows) & (flow.outcome == Outcome.OK))
    if chaotic.size:
        found = coexisting_attractors(members.take(chaotic), section[chaotic], STARTS_A_ROUND * rounds, **options)
        evidence.coexisting[rows[chaotic]] = found


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


def _judge(members: Members, evidence: Evidence) -> None:
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
    evidence.regime[evidence.outcome == Outcome.STEP_LIMIT] = Regime.TRANSIENT
    evidence.doubtful = chaotic & (evidence.coexisting | sticky | ~(evidence.zero_one > CHAOTIC_K))
    evidence.doubtful |= quasi_periodic & ~(evidence.zero_one < REGULAR_K)
    # A cycle or a rest that attracts has a negative exponent; without damping it is neutral at best.
    returns = (evidence.regime == Regime.REST) | (evidence.regime == Regime.PERIODIC)
    evidence.doubtful |= returns & np.where(losing, evidence.sign >= 0, evidence.sign > 0)
    evidence.doubtful |= evidence.regime == Regime.TRANSIENT


def regime(
    model: ConeModel,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    transient: float | None = None,
    budget: float = 20_000.0,
    rounds: int = ROUNDS,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Names the motion of every member after a transient, with the evidence.

    Parameters
    ----------
    model : one actuator or an ensemble.
    initial : displacement and velocity at time 0, shape (2,) or ensemble shape + (2,). Default (1, 0).
    transient : time after which the motion is first examined; default by damping and drive
        (`gelcone.motion.settle.default_transient`).
    budget : longest averaging time of the exponents. Default 20,000.
    rounds : how often a motion that has not settled on a cycle is examined, each time after as long as all before
        together, before it is measured. Default 5: followed for 16 times the transient.
    tolerance : relative error of one integration step. Default 1e-15. A damped motion that has not settled when it is
        first examined is followed and measured with at least 1e-10: it forgets the error, or is chaotic.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset with ``regime`` (codes of `Regime`, as CF flags), ``period`` in forcing periods (0: none), ``symmetric``
    (maps onto itself under x -> -x), and the evidence: ``lyapunov`` and ``standard_error`` (..., exponent) per unit
    time, from the Floquet multipliers of the cycle where there is one and averaged elsewhere, ``averaged_time``,
    ``return_distance`` (of the motion a period later, over its size), ``cycle_distance`` (of the motion from the cycle,
    over its size; with damping, where there is one), ``zero_one`` (only where the motion does not return),
    ``coexisting`` (1 where an attracting cycle or rest was found from within chaos, which may then end there),
    ``section`` (..., point, state), ``lowest`` and ``highest`` displacement, ``settled_time``, ``doubtful`` (1 where
    the evidence does not agree: read it before you believe the name), ``outcome``.

    Raises
    ------
    InputError : for a transient or budget that is not positive, no rounds, or when no member can start.
    """
    options: dict[str, Any] = {"transient": transient, "budget": budget, "rounds": rounds, "tolerance": tolerance}
    states = start_states(model, initial)
    found = regime_cells(model.members(), states, **options, threads=threads, progress=progress)
    return label_regimes(model, found, options, "regime of motion")


def regime_cells(
    members: Members,
    states: Array,
    *,
    transient: float | None = None,
    budget: float = 20_000.0,
    rounds: int = ROUNDS,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> Findings:
    """What `regime` finds of every member of a flattened ensemble from its state (members, N); options as there."""
    check_budgets(transient=transient, budget=budget)
    check_count("rounds", rounds, 1)
    evidence = classify(
        members,
        states,
        transient=transient,
        budget=budget,
        rounds=rounds,
        tolerance=tolerance,
        threads=threads,
        progress=progress,
    )
    return evidence.findings()
