"""What kind of motion it is - rest, periodic, quasi-periodic, chaotic, not settled, left the domain - with evidence.

The motion is let settle, then looked at: does it return (`periods_of`), and is there a cycle or a rest that it returns
to (`find_cycles`)? A motion that does not settle on an attracting cycle is given more time, up to a bound. What then
still wanders is measured: does the largest Lyapunov exponent have a certain sign, and what does the 0-1 test say? With
damping, a quasi-periodic motion is impossible: its section points would lie on a closed curve, and the map that carries
the curve onto itself shrinks the area inside by exp(-2 zeta T).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Outcome, Regime
from gelcone.motion.cycle import (
    LONGEST_PERIOD,
    NEAR_RETURN,
    PHASES,
    RETURN_TOLERANCE,
    RETURNS,
    SMALLEST_SIZE,
    attractors_beside,
    find_cycles,
    follow,
    periods_of,
)
from gelcone.motion.flow import DEFAULT_TOLERANCE, integrate
from gelcone.motion.lyapunov import average, check_budgets, default_transient, shear_level
from gelcone.motion.response import start_states
from gelcone.motion.section import repeats_lasting, settle
from gelcone.motion.tangents import CERTAIN, FLOOR, LONG_STRETCH
from gelcone.motion.zero_one import zero_one
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

REST_TOLERANCE = 1e-6
ROUNDS = 5
"""A motion that has not settled is looked at again this many times, each after as long as all before together: chaos
that ends in a cycle often lasts for ten transients, and is told from the lasting kind by little but patience."""
STARTS_A_ROUND = 5
"""Starts of the search for attractors beside chaos, for each of the rounds."""
FOLLOW_TOLERANCE = 1e-10
"""Tolerance of damped motions that have not settled at first: one that settles later forgets the error, and of chaos
only averages are taken, which are uncertain by far more."""
TEST_POINTS = (200, 800)
"""Points of the 0-1 test, and of its repetition where the first is no clear answer."""
ENDED = 1e-3
"""What was chaotic has ended when the last points of its 0-1 test return this closely."""
DRIFT_WINDOWS = 8
CHAOTIC_K = 0.8
REGULAR_K = 0.2


@dataclass
class Evidence:
    """All that is known of each member; arrays (members, ...). Codes of `Regime` in ``regime``."""

    regime: npt.NDArray[np.int8]
    period: npt.NDArray[np.int64]
    symmetric: npt.NDArray[np.bool_]
    return_distance: Array
    cycle_distance: Array
    exponents: Array
    standard_error: Array
    averaged_time: Array
    sign: npt.NDArray[np.int8]
    zero_one: Array
    test_phase: npt.NDArray[np.int64]
    beside: npt.NDArray[np.bool_]
    under_way: npt.NDArray[np.bool_]
    lowest: Array
    highest: Array
    section: Array
    settled_time: Array
    outcome: npt.NDArray[np.int8]
    final: Array
    flag: npt.NDArray[np.bool_]

    @classmethod
    def blank(cls, count: int) -> Evidence:
        def nan(*shape: int) -> Array:
            return np.full((count, *shape), np.nan)

        return cls(
            regime=np.full(count, Regime.TRANSIENT, dtype=np.int8),
            period=np.zeros(count, dtype=np.int64),
            symmetric=np.zeros(count, dtype=bool),
            return_distance=nan(),
            cycle_distance=nan(),
            exponents=nan(2),
            standard_error=nan(2),
            averaged_time=np.zeros(count),
            sign=np.zeros(count, dtype=np.int8),
            zero_one=nan(),
            test_phase=np.zeros(count, dtype=np.int64),
            beside=np.zeros(count, dtype=bool),
            under_way=np.zeros(count, dtype=bool),
            lowest=nan(),
            highest=nan(),
            section=nan(RETURNS, 2),
            settled_time=np.zeros(count),
            outcome=np.zeros(count, dtype=np.int8),
            final=nan(2),
            flag=np.zeros(count, dtype=bool),
        )


def classify(
    model: ConeModel,
    states: Array,
    *,
    transient: float | None = None,
    budget: float = 20_000.0,
    rounds: int = ROUNDS,
    **flow_options: Any,
) -> Evidence:
    """The regime of every member of a flattened ensemble from its initial state (members, 2), with the evidence.

    The workhorse behind `regime`, bifurcation diagrams and maps: a member's result depends on nothing but itself.
    ``rounds`` says how often a motion that has not settled is looked at again, and how long attractors are looked for
    beside chaos; fewer than the default are faster and take chaos that does not last for chaos.
    """
    evidence = Evidence.blank(model.size)
    evidence.final[:] = states
    duration = default_transient(model) if transient is None else np.full(model.size, float(transient))
    loose = flow_options | {"tolerance": max(flow_options.get("tolerance", 0.0), FOLLOW_TOLERANCE)}
    open_members = np.arange(model.size)
    for trial in range(rounds):
        options = loose if trial else flow_options
        _settle(model, open_members, duration, trial, evidence, options)
        open_members = _examine((_look,), model, open_members, evidence, options)
        open_members = _examine((_find_cycle,), model, open_members, evidence, flow_options)
        open_members = open_members[_unsettled(model, open_members, evidence)]
        if not open_members.size:
            break
    wandering = _alive(np.flatnonzero(np.isnan(evidence.cycle_distance)), evidence)
    damped = np.broadcast_to(model.damping_ratio, model.shape).ravel()[wandering] > 0.0
    measures = (partial(_measure, budget=budget), partial(_second_opinion, rounds=rounds))
    _examine(measures, model, wandering[~damped], evidence, flow_options)
    wandering = _examine(measures, model, wandering[damped], evidence, loose)
    # What was chaotic may have ended while it was measured.
    ended = wandering[_unsettled(model, wandering, evidence) & ~_is_chaotic(evidence, wandering)]
    _examine((_look, _find_cycle), model, ended, evidence, flow_options)
    _judge(model, evidence)
    return evidence


def _examine(
    steps: tuple[Callable[..., None], ...],
    model: ConeModel,
    members: npt.NDArray[np.intp],
    evidence: Evidence,
    options: dict[str, Any],
) -> npt.NDArray[np.intp]:
    """Takes some members through the steps; those that are still running after them."""
    for step in steps:
        members = _alive(members, evidence)
        if members.size:
            step(model.take(members), members, evidence, options)
    return _alive(members, evidence)


def _alive(members: npt.NDArray[np.intp], evidence: Evidence) -> npt.NDArray[np.intp]:
    return members[evidence.outcome[members] == Outcome.OK]


def _settle(
    model: ConeModel,
    members: npt.NDArray[np.intp],
    duration: Array,
    trial: int,
    evidence: Evidence,
    options: dict[str, Any],
) -> None:
    """Lets ``duration`` (of all members) pass, and in later trials as long as all before together."""
    part, span = model.take(members), duration[members] * 2 ** max(trial - 1, 0)
    if trial:  # the look before was part of the time that this round is to last
        span = np.maximum(span - RETURNS * np.broadcast_to(part.forcing_period, part.shape), 0.0)
    repeats = repeats_lasting(part, span)
    evidence.final[members], evidence.outcome[members] = settle(part, evidence.final[members], repeats, **options)
    evidence.settled_time[members] += span


def _look(model: ConeModel, members: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any]) -> None:
    """Follows `RETURNS` repeats: section points, amplitude, returns, rest."""
    path, evidence.outcome[members] = follow(model, evidence.final[members], **options)
    evidence.cycle_distance[members] = np.nan
    x, u = path[..., 0], path[..., 1]
    evidence.lowest[members], evidence.highest[members] = x.min(axis=(1, 2)), x.max(axis=(1, 2))
    evidence.section[members], evidence.final[members] = path[:, :, -1], path[:, -1, -1]
    evidence.test_phase[members] = _widest(x)
    whole = path.reshape(len(x), RETURNS, 2 * PHASES)
    damped = np.broadcast_to(model.damping_ratio, model.shape) > 0.0
    period, distance = periods_of(whole, np.where(damped, NEAR_RETURN, RETURN_TOLERANCE))
    still = (np.ptp(x, axis=(1, 2)) < REST_TOLERANCE) & (np.abs(u).max(axis=(1, 2)) < REST_TOLERANCE)
    evidence.period[members] = np.where(still & ~damped, 0, period)
    evidence.return_distance[members] = distance
    evidence.symmetric[members] = symmetric(whole, period) & (np.asarray(model.rest_height) == 0.0)
    evidence.regime[members] = np.select([still, period > 0], [Regime.REST, Regime.PERIODIC], Regime.TRANSIENT)


def _widest(displacement: Array) -> npt.NDArray[np.int64]:
    """The sample within a repeat at which the displacements (members, repeats, phases) differ the most."""
    return (np.ptp(displacement, axis=1).argmax(axis=1) + 1) % PHASES


def symmetric(points: Array, period: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """Whether a periodic motion maps onto itself under x -> -x: minus the first point is a point of its cycle."""
    scale = np.maximum(np.abs(points).max(axis=(1, 2)), SMALLEST_SIZE)
    gaps = np.abs(points[:, :LONGEST_PERIOD] + points[:, :1]).max(axis=2)
    within = np.arange(LONGEST_PERIOD) < np.maximum(period, 1)[:, None]
    return np.where(within, gaps, np.inf).min(axis=1) < 10 * RETURN_TOLERANCE * scale


def _find_cycle(model: ConeModel, members: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any]) -> None:
    """Names the damped motions that return by the cycle they return to; without one they do not count as returned."""
    returns = (evidence.period[members] > 0) & (np.broadcast_to(model.damping_ratio, model.shape) > 0.0)
    if not returns.any():
        return
    model, members = model.take(returns), members[returns]
    cycles = find_cycles(model, evidence.final[members], evidence.period[members], **options)
    still = cycles.extent < REST_TOLERANCE
    evidence.regime[members] = np.where(cycles.found, np.where(still, Regime.REST, Regime.PERIODIC), Regime.TRANSIENT)
    evidence.period[members] = np.where(cycles.found & ~still, cycles.period, 0)
    evidence.symmetric[members] = cycles.found & cycles.symmetric & (np.asarray(model.rest_height) == 0.0)
    evidence.cycle_distance[members] = np.where(cycles.found, cycles.distance, np.nan)
    evidence.sign[members] = 0
    found = members[cycles.found]
    evidence.exponents[found], evidence.standard_error[found] = (
        cycles.exponents[cycles.found],
        cycles.error[cycles.found],
    )
    evidence.averaged_time[found] = cycles.time[cycles.found]
    largest, error = cycles.exponents[cycles.found, 0], cycles.error[cycles.found, 0]
    evidence.sign[found] = np.where(np.abs(largest) > np.maximum(CERTAIN * error, FLOOR), np.sign(largest), 0)


def _unsettled(model: ConeModel, members: npt.NDArray[np.intp], evidence: Evidence) -> npt.NDArray[np.bool_]:
    """Damped members that are on no attracting cycle yet: slow, or on their way through chaos, which may take long.

    Not those that do not move at all, whom no time helps.
    """
    damped = np.broadcast_to(model.damping_ratio, model.shape).ravel()[members] > 0.0
    attracted = (evidence.sign[members] < 0) & (evidence.cycle_distance[members] < NEAR_RETURN)
    return damped & ~attracted & (evidence.return_distance[members] > 0.0)


def _is_chaotic(evidence: Evidence, members: npt.NDArray[np.intp]) -> npt.NDArray[np.bool_]:
    """Whether both opinions say so."""
    wandering = evidence.regime[members] == Regime.TRANSIENT
    agree = (evidence.sign[members] > 0) & (evidence.zero_one[members] > CHAOTIC_K)
    return wandering & agree & ~evidence.under_way[members]


def _measure(
    model: ConeModel, members: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any], *, budget: float
) -> None:
    """The exponents of those that are on no cycle, by averaging."""
    result = average(model, evidence.final[members], budget=budget, stretch=LONG_STRETCH, **options)
    evidence.exponents[members], evidence.standard_error[members] = result.values, result.standard_error
    evidence.averaged_time[members], evidence.sign[members] = result.time, result.sign
    evidence.outcome[members] = result.outcome
    ok = result.outcome == Outcome.OK
    evidence.final[members[ok]] = result.states[ok]


def _second_opinion(
    model: ConeModel, members: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any], *, rounds: int
) -> None:
    """The 0-1 test of the members that do not return and may not be slow: chaotic ones, and all without damping."""
    damped = np.broadcast_to(model.damping_ratio, model.shape) > 0.0
    wandering = (evidence.regime[members] == Regime.TRANSIENT) & ((evidence.sign[members] > 0) | ~damped)
    for points in TEST_POINTS:
        part = members[wandering]
        if not part.size:
            return
        _test(model.take(wandering), part, evidence, points, rounds, options)
        unclear = ~((evidence.zero_one[part] < REGULAR_K) | (evidence.zero_one[part] > CHAOTIC_K))
        wandering[wandering] = unclear & (evidence.outcome[part] == Outcome.OK)


def _test(
    model: ConeModel,
    members: npt.NDArray[np.intp],
    evidence: Evidence,
    points: int,
    rounds: int,
    options: dict[str, Any],
) -> None:
    """The 0-1 test, taken where in the repeat the motion varies the most, and whether chaos has an attractor beside."""
    repeat = np.broadcast_to(model.forcing_period, model.shape)
    phase = evidence.test_phase[members] / PHASES
    shares = np.stack([np.where(phase > 0.0, phase, 0.5), np.ones(len(members))], axis=1)
    ticks = (np.arange(points)[:, None] + shares[:, None, :]).reshape(len(members), -1)
    flow = integrate(model, evidence.final[members], repeat[:, None] * ticks, **options)
    between, section = flow.states[:, ::2], flow.states[:, 1::2]
    evidence.outcome[members], evidence.final[members] = flow.outcome, section[:, -1]
    evidence.zero_one[members] = zero_one(np.where(phase[:, None] > 0.0, between[..., 0], section[..., 0]))
    evidence.under_way[members] = (periods_of(section[:, -RETURNS:], ENDED)[0] > 0) | drifts(section)
    damped = np.broadcast_to(model.damping_ratio, model.shape) > 0.0
    chaotic = np.flatnonzero(damped & _is_chaotic(evidence, members) & (flow.outcome == Outcome.OK))
    if chaotic.size:
        starts = STARTS_A_ROUND * rounds
        found = attractors_beside(model.take(chaotic), section[chaotic], starts, **options)
        evidence.beside[members[chaotic]] = found


def drifts(section: Array) -> npt.NDArray[np.bool_]:
    """Whether a motion leaves an unstable cycle or rest behind, ever faster, its section (members, points, 2) says.

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


def _judge(model: ConeModel, evidence: Evidence) -> None:
    """Names those that do not return, and flags every verdict that its evidence does not bear out."""
    damped = np.broadcast_to(model.damping_ratio, model.shape).ravel() > 0.0
    ran = evidence.outcome == Outcome.OK
    wandering = (evidence.regime == Regime.TRANSIENT) & ran
    # Chaos without damping sticks to the islands in it for long, so that its average may never become steady.
    sticky = ~damped & (evidence.exponents[:, 0] > shear_level(evidence.averaged_time)) & (evidence.sign == 0)
    sticky &= evidence.zero_one > CHAOTIC_K
    chaotic = wandering & ((evidence.sign > 0) | sticky) & ~(damped & evidence.under_way)
    quasi_periodic = wandering & ~damped & ~chaotic
    evidence.regime[chaotic] = Regime.CHAOTIC
    evidence.regime[quasi_periodic] = Regime.QUASI_PERIODIC
    evidence.regime[~ran] = Regime.LEFT_THE_DOMAIN
    evidence.regime[evidence.outcome == Outcome.STEP_LIMIT] = Regime.TRANSIENT
    evidence.flag = chaotic & (evidence.beside | sticky | ~(evidence.zero_one > CHAOTIC_K))
    evidence.flag |= quasi_periodic & ~(evidence.zero_one < REGULAR_K)
    # A cycle or a rest that attracts has a negative exponent; without damping it is neutral at best.
    returns = (evidence.regime == Regime.REST) | (evidence.regime == Regime.PERIODIC)
    evidence.flag |= returns & np.where(damped, evidence.sign >= 0, evidence.sign > 0)
    evidence.flag |= evidence.regime == Regime.TRANSIENT


def regime(
    model: ConeModel,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    transient: float | None = None,
    budget: float = 20_000.0,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Names the motion of every member after a transient, with the evidence.

    Parameters
    ----------
    model : one actuator or an ensemble.
    initial : displacement and velocity at time 0, shape (2,) or ensemble shape + (2,). Default (1, 0).
    transient : time after which the motion is first looked at; default `default_transient`. A motion that has not
        settled on a cycle is followed for 16 times as long before it is measured.
    budget : longest averaging time of the exponents. Default 20,000.
    tolerance : relative error of one integration step. Default 1e-15. A damped motion that has not settled when it is
        first looked at goes on, and is measured, with at least 1e-10: it forgets the error, or is chaotic.

    Returns
    -------
    Dataset with ``regime`` (codes of `Regime`, as CF flags), ``period`` in drive repeats (0: none), ``symmetric``
    (maps onto itself under x -> -x), and the evidence: ``lyapunov`` and ``standard_error`` (..., exponent) per unit
    time, from the Floquet multipliers of the cycle where there is one and averaged elsewhere, ``averaged_time``,
    ``return_distance`` (of the motion a period later, over its size), ``cycle_distance`` (of the motion from the cycle,
    over its size; with damping, where there is one), ``zero_one`` (only where the motion does not return), ``beside``
    (1 where an attracting cycle or rest was found from within chaos, which may then end there), ``section``
    (..., point, state), ``lowest`` and ``highest`` displacement, ``settled_time``, ``flag`` (1 where the evidence does
    not agree: read it before you believe the name), ``outcome``.

    Raises
    ------
    InputError : for a transient or budget that is not positive, or when no member can start.
    """
    check_budgets(transient=transient, budget=budget)
    states = start_states(model, initial)
    flat = model.members()
    evidence = classify(flat, states, transient=transient, budget=budget, tolerance=tolerance, threads=threads)
    if progress is not None:
        progress(1.0)
    options = {"transient": transient, "budget": budget, "tolerance": tolerance}
    return label_evidence(model, evidence, options, "regime of motion")


def label_evidence(model: ConeModel, evidence: Evidence, options: dict[str, Any], title: str) -> xr.Dataset:
    """Evidence of all members as a Dataset over the ensemble's dims."""
    result = dataset.label(
        model,
        {
            "regime": ((), evidence.regime, "kind of motion", "code"),
            "period": ((), evidence.period, "period in drive repeats, 0 if none", "count"),
            "symmetric": ((), evidence.symmetric.astype(np.int8), "1 if the motion equals its mirror image", "code"),
            "flag": ((), evidence.flag.astype(np.int8), "1 if the evidence does not agree", "code"),
            "lyapunov": (("exponent",), evidence.exponents, "Lyapunov exponents per unit time", "rate"),
            "standard_error": (("exponent",), evidence.standard_error, "standard error of the exponents", "rate"),
            "sign": ((), evidence.sign, "sign of the largest exponent, 0 if uncertain", "code"),
            "averaged_time": ((), evidence.averaged_time, "averaging time behind the exponents", "time"),
            "return_distance": (
                (),
                evidence.return_distance,
                "distance of returning points over size",
                "share",
            ),
            "cycle_distance": ((), evidence.cycle_distance, "distance from the cycle over size", "share"),
            "zero_one": ((), evidence.zero_one, "0-1 test, 1 for chaos", "share"),
            "beside": (
                (),
                evidence.beside.astype(np.int8),
                "1 if an attracting cycle or rest lies beside chaos, which may end there",
                "code",
            ),
            "lowest": ((), evidence.lowest, "lowest displacement", "length"),
            "highest": ((), evidence.highest, "highest displacement", "length"),
            "section": (("point", "state"), evidence.section, "displacement and velocity at drive repeats", "state"),
            "settled_time": ((), evidence.settled_time, "time before the motion was looked at", "time"),
        },
        outcome=evidence.outcome,
        options=options,
        title=title,
    )
    result["regime"].attrs |= {
        "flag_values": np.array([r.value for r in Regime], dtype=np.int8),
        "flag_meanings": " ".join(r.name.lower() for r in Regime),
    }
    return result
