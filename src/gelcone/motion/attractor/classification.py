"""Classification of motions - rest, periodic, quasi-periodic, chaotic, not settled, left the domain - with evidence.

A damped motion is followed to its attractor, and chaos from several starts (`search`, `lifetime`). A motion that
reaches no cycle is classified by the sign of its largest Lyapunov exponent and by the 0-1 test. Transient chaos has a
name of its own, and the exponents of the attractor it ends on. Without damping there are no attractors: a motion
returns, or it is classified by these measurements.

With two states and damping, a quasi-periodic motion is impossible: its section points would lie on a closed curve, and
the map that carries the curve onto itself shrinks the area inside by exp(-2 zeta T). With more states it is possible,
and a damped motion whose largest exponent is zero within its error and whose 0-1 test is regular is named so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome, Regime
from gelcone.motion.attractor.cycle import REST_TOLERANCE, SMALLEST_SIZE, Cycles, extremes, find_cycles, sampled
from gelcone.motion.attractor.lifetime import FATES, STARTS, Nearby, chaos_of, follow_starts
from gelcone.motion.attractor.search import Search, cycles_reached, patience_of, period_of, transient_of
from gelcone.motion.columns import Columns, column
from gelcone.motion.exponents import average, bound_shear, shear_level
from gelcone.motion.flow import integrate
from gelcone.motion.settle import LONG_STRETCH, STRETCH, repeats_lasting, settle
from gelcone.motion.validity import VALIDITY
from gelcone.motion.zero_one import zero_one
from gelcone.physics.members import Members
from gelcone.progress import Counted, Progress
from gelcone.quantity import Array

RETURNS = 64
"""Forcing periods of a motion that are sampled for its section."""
PHASES = 8
"""Samples within a forcing period, for the amplitude and for returns: a slow drive can push all motions to the same
point once a period although they differ in between."""
RETURN_TOLERANCE = 1e-6
"""Largest distance of the return of an undamped motion, over its size; nothing pulls such a motion closer."""
CYCLE_SAMPLES = 64
"""Samples of a cycle within a forcing period, for its extent."""
MEASURE_TOLERANCE = 1e-8
"""Least tolerance at which the exponents of damped motions are averaged."""
TEST_POINTS = (200, 800)
"""Points of the 0-1 test, and of its repetition after an unclear result."""
ENDED = 1e-3
"""Largest distance, over the size, between returning points at the end of the 0-1 test after which chaos has ended."""
DRIFT_WINDOWS, DRIFT_PERIODS = 8, 16
CHAOTIC_K = 0.8
REGULAR_K = 0.2


@dataclass
class Evidence(Columns):
    """The regime of each member and the evidence for it; arrays (members, ...).

    ``regime`` (a `Regime`), ``period`` in forcing periods (0: none), ``symmetric`` under x -> -x, ``return_distance``
    and ``cycle_distance`` over the motion's size, ``exponents`` and ``standard_error`` (members, N), averaged over
    ``averaged_time``, with the ``sign`` of the largest (0: uncertain), ``zero_one``, taken at the sample
    ``test_phase`` of a forcing period, ``coexisting`` (some nearby starts end soon on a cycle or rest, the others
    never), ``under_way`` (the motion still leaves an unstable cycle, or returned at the end of the 0-1 test),
    ``lowest`` and ``highest`` displacement, ``section`` (members, points, N), ``settled_time``, ``validity``
    (`gelcone.motion.validity.validity`), ``outcome``, ``final`` states (members, N), and ``doubtful`` (the evidence
    does not agree).

    Lifetime of chaos (`gelcone.motion.attractor.lifetime`): ``chaotic_until``, the time to which the motion was
    observed to be chaotic; ``share_chaotic`` of the nearby starts; the mean ``lifetime`` between ``lifetime_low`` and
    ``lifetime_high`` (NaN: no chaos; infinite: no end was seen). Attractors that nearby starts end on (members,
    `FATES`), the most frequent first: ``fate_regime`` (-1: none), ``fate_period`` and ``fate_share`` of the
    ``followed`` starts.
    """

    regime: npt.NDArray[np.int8] = column(Regime.TRANSIENT, kind=np.int8)
    period: npt.NDArray[np.int64] = column(0, kind=np.int64)
    symmetric: npt.NDArray[np.bool_] = column(False, kind=bool)
    return_distance: Array = column()
    cycle_distance: Array = column()
    exponents: Array = column(np.nan, "N")
    standard_error: Array = column(np.nan, "N")
    averaged_time: Array = column(0.0)
    sign: npt.NDArray[np.int8] = column(0, kind=np.int8)
    zero_one: Array = column()
    test_phase: npt.NDArray[np.int64] = column(0, kind=np.int64)
    coexisting: npt.NDArray[np.bool_] = column(False, kind=bool)
    under_way: npt.NDArray[np.bool_] = column(False, kind=bool)
    lowest: Array = column()
    highest: Array = column()
    section: Array = column(np.nan, RETURNS, "N")
    settled_time: Array = column(0.0)
    validity: Array = column(np.nan, VALIDITY)
    outcome: npt.NDArray[np.int8] = column(0, kind=np.int8)
    final: Array = column(np.nan, "N")
    doubtful: npt.NDArray[np.bool_] = column(False, kind=bool)
    chaotic_until: Array = column()
    share_chaotic: Array = column()
    lifetime: Array = column()
    lifetime_low: Array = column()
    lifetime_high: Array = column()
    fate_regime: npt.NDArray[np.int8] = column(-1, FATES, kind=np.int8)
    fate_period: npt.NDArray[np.int64] = column(0, FATES, kind=np.int64)
    fate_share: Array = column(0.0, FATES)
    followed: npt.NDArray[np.int64] = column(1, kind=np.int64)

    @classmethod
    def join(cls, parts: list[Evidence]) -> Evidence:
        """Joins the evidence of several groups of members."""
        return cls(**{f.name: np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(cls)})


def classify(
    members: Members,
    states: Array,
    *,
    transient: float | None = None,
    patience: float | Array | None = None,
    budget: float = 20_000.0,
    progress: Progress = None,
    **flow_options: Any,
) -> Evidence:
    """Classify each member of a flattened ensemble from its initial state (members, N).

    `gelcone.regime`, bifurcation diagrams and maps use this. A member's result does not depend on the others. Options
    as in `gelcone.regime`.
    """
    evidence = Evidence.blank(members.size, states=len(members.system.states))
    evidence.final[:] = states
    counted = Counted(progress)
    duration, longest = transient_of(members, transient), patience_of(members, patience)
    losing, kept = np.flatnonzero(members.damped), np.flatnonzero(~members.damped)
    measures = (partial(_measure, budget=budget), _test_chaos)
    _examine((partial(_settle, duration=duration[kept]), _returns), members, kept, evidence, flow_options)
    _examine(measures, members, _wandering(kept, evidence), evidence, flow_options)
    nearby = Nearby.at(evidence.final, STARTS)
    search = Search(members, nearby, counted, **flow_options)
    unsettled = follow_starts(search, nearby, losing, duration, longest)
    evidence.settled_time[losing] = np.where(np.isin(losing, unsettled), duration[losing], nearby.followed[losing, 0])
    _store_found(search, losing, evidence, flow_options)
    averaging = flow_options | {"tolerance": max(flow_options.get("tolerance", 0.0), MEASURE_TOLERANCE)}
    measured = _examine((_sample, *measures), members, _wandering(losing, evidence), evidence, averaging)
    _find_late_cycles(members, measured, nearby, evidence, flow_options)
    judge(members, evidence)
    _store_lifetimes(members, losing, duration, nearby, evidence)
    counted.finish()
    return evidence


Step = Callable[[Members, npt.NDArray[np.intp], Evidence, dict[str, Any]], object]


def _examine(
    steps: tuple[Step, ...], members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any]
) -> npt.NDArray[np.intp]:
    """Applies the steps to the members ``rows`` one after the other, and returns those without a failed run."""
    for step in steps:
        rows = _alive(rows, evidence)
        if rows.size:
            step(members.take(rows), rows, evidence, options)
    return _alive(rows, evidence)


def _alive(rows: npt.NDArray[np.intp], evidence: Evidence) -> npt.NDArray[np.intp]:
    return rows[evidence.outcome[rows] == Outcome.OK]


def _wandering(rows: npt.NDArray[np.intp], evidence: Evidence) -> npt.NDArray[np.intp]:
    """Those ``rows`` that are near no cycle."""
    return rows[np.isnan(evidence.cycle_distance[rows])]


# --- undamped members -------------------------------------------------------------------------------------------------


def _settle(
    members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any], *, duration: Array
) -> None:
    """Advances the states by the ``duration``."""
    repeats = repeats_lasting(members, duration)
    evidence.final[rows], evidence.outcome[rows] = settle(members, evidence.final[rows], repeats, **options)
    evidence.settled_time[rows] = duration


def _sample(members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any]) -> Array:
    """Stores section points, extent and validity over `RETURNS` forcing periods, and returns the path (members,
    periods, phases, N)."""
    start = evidence.final[rows]
    motion = sampled(members, start, RETURNS, PHASES, **options)
    path = motion.path.reshape(rows.size, RETURNS, PHASES, -1)
    evidence.outcome[rows], evidence.validity[rows] = motion.outcome, motion.validity(members, turn=False)
    evidence.lowest[rows], evidence.highest[rows] = extremes(members, start, RETURNS, motion, **options)
    evidence.section[rows], evidence.final[rows] = path[:, :, -1], path[:, -1, -1]
    evidence.test_phase[rows] = _widest(path[..., 0])
    return path


def _widest(displacement: Array) -> npt.NDArray[np.int64]:
    """The sample within a period at which displacements (members, periods, phases) of different periods differ most.

    Sample 0 lies at phase 0; in the path that sample is the last of a period.
    """
    return (np.ptp(displacement, axis=1).argmax(axis=1) + 1) % PHASES


def _returns(members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any]) -> None:
    """Classifies undamped members that return or are at rest."""
    path = _sample(members, rows, evidence, options)
    x, u = path[..., 0], path[..., 1]
    whole = path.reshape(len(x), RETURNS, -1)
    period, distance = period_of(whole, RETURN_TOLERANCE, RETURNS)
    still = (np.ptp(x, axis=(1, 2)) < REST_TOLERANCE) & (np.abs(u).max(axis=(1, 2)) < REST_TOLERANCE)
    evidence.period[rows] = np.where(still, 0, period)
    evidence.return_distance[rows] = distance
    evidence.symmetric[rows] = symmetric(whole, period, np.tile(members.system.mirror, PHASES)) & members.symmetric
    evidence.regime[rows] = np.select([still, period > 0], [Regime.REST, Regime.PERIODIC], Regime.TRANSIENT)


def symmetric(points: Array, period: npt.NDArray[np.int64], signs: Array | float = -1.0) -> npt.NDArray[np.bool_]:
    """Mask (members,) of periodic motions that map onto themselves under x -> -x.

    Then the mirror image of the first point is a point of the cycle. ``points`` (members, periods, coordinates);
    ``signs`` of the coordinates under the reflection.
    """
    scale = np.maximum(np.abs(points).max(axis=(1, 2)), SMALLEST_SIZE)
    gaps = np.abs(points - signs * points[:, :1]).max(axis=2)
    within = np.arange(points.shape[1]) < np.maximum(period, 1)[:, None]
    return np.where(within, gaps, np.inf).min(axis=1) < 10 * RETURN_TOLERANCE * scale


# --- damped members ---------------------------------------------------------------------------------------------------


def _store_found(search: Search, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any]) -> None:
    """Stores the results of a search for the damped members ``rows``."""
    at = (rows, search.start[rows])
    evidence.final[rows], evidence.outcome[rows] = search.starts.state[at], search.starts.outcome[at]
    evidence.return_distance[rows] = search.starts.gap[at]
    _on_cycles(search.members, rows, search.cycles.take(rows), evidence, options)


def _on_cycles(
    members: Members, rows: npt.NDArray[np.intp], cycles: Cycles, evidence: Evidence, options: dict[str, Any]
) -> None:
    """Classifies those ``rows`` with a cycle by it; ``cycles`` (rows,)."""
    rows, cycles = rows[cycles.found], cycles.take(cycles.found)
    evidence.regime[rows] = np.where(cycles.resting, Regime.REST, Regime.PERIODIC)
    evidence.period[rows] = np.where(cycles.resting, 0, cycles.period)
    evidence.symmetric[rows], evidence.cycle_distance[rows] = cycles.symmetric, cycles.distance
    evidence.exponents[rows], evidence.standard_error[rows] = cycles.exponents, cycles.error
    evidence.averaged_time[rows], evidence.sign[rows] = cycles.time, cycles.sign
    for periods in np.unique(cycles.period):
        same = np.flatnonzero(cycles.period == periods)
        part, at = members.take(rows[same]), rows[same]
        turn = sampled(part, cycles.point[same], int(periods), CYCLE_SAMPLES, **options)
        evidence.validity[at] = turn.validity(part, turn=True)
        section = turn.path[:, CYCLE_SAMPLES - 1 :: CYCLE_SAMPLES]
        evidence.lowest[at], evidence.highest[at] = extremes(part, cycles.point[same], int(periods), turn, **options)
        evidence.section[at] = section[:, np.arange(RETURNS) % periods]
        evidence.final[at] = section[:, -1]


def _find_late_cycles(
    members: Members, rows: npt.NDArray[np.intp], nearby: Nearby, evidence: Evidence, options: dict[str, Any]
) -> None:
    """Finds the cycles that motions of ``rows`` have reached during their measurement."""
    wandering = (evidence.regime[rows] == Regime.TRANSIENT) & ~evidence.under_way[rows]
    chaotic = wandering & (evidence.sign[rows] > 0) & (evidence.zero_one[rows] > CHAOTIC_K)  # both show it
    rows = rows[~chaotic]
    if not rows.size:
        return
    reached = cycles_reached(members.take(rows), evidence.final[rows], **options)
    there, period = rows[reached.attracting], reached.period[reached.attracting]
    cycles = find_cycles(members.take(there), evidence.final[there], period, **options)
    _on_cycles(members, there, cycles, evidence, options)
    nearby.ended[there, 0] = nearby.followed[there, 0]


# --- measurements -----------------------------------------------------------------------------------------------------


def _measure(
    members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any], *, budget: float
) -> None:
    """Averages the exponents of motions on no cycle."""
    stretch = LONG_STRETCH if members.system.planar else STRETCH
    result = average(members, evidence.final[rows], budget=budget, stretch=stretch, **options)
    bound_shear(members, result)
    evidence.exponents[rows], evidence.standard_error[rows] = result.values, result.standard_error
    evidence.averaged_time[rows], evidence.sign[rows] = result.time, result.sign
    evidence.outcome[rows] = result.outcome
    ok = result.outcome == Outcome.OK
    evidence.final[rows[ok]] = result.states[ok]


def _test_chaos(members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any]) -> None:
    """Applies the 0-1 test to members that may be chaotic or quasi-periodic, with more points where it is unclear."""
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
    members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, points: int, options: dict[str, Any]
) -> None:
    """Applies the 0-1 test at the phase at which the motion varies the most, and marks motions that are under way."""
    phase = evidence.test_phase[rows] / PHASES
    shares = np.stack([np.where(phase > 0.0, phase, 0.5), np.ones(len(rows))], axis=1)
    ticks = (np.arange(points)[:, None] + shares[:, None, :]).reshape(len(rows), -1)
    flow = integrate(members, evidence.final[rows], members.forcing_period[:, None] * ticks, **options)
    between, section = flow.states[:, ::2], flow.states[:, 1::2]
    evidence.outcome[rows], evidence.final[rows] = flow.outcome, section[:, -1]
    evidence.zero_one[rows] = zero_one(np.where(phase[:, None] > 0.0, between[..., 0], section[..., 0]))
    returned = period_of(section[:, -RETURNS:], ENDED, RETURNS)[0] > 0
    evidence.under_way[rows] = returned | drifts(section)


def drifts(section: Array) -> npt.NDArray[np.bool_]:
    """Mask (members,) of motions that leave an unstable cycle or rest, from their sections (members, points, N).

    Deviations grow as in chaos, but each return after the period of that cycle is further away than those before; in
    chaos closer returns follow.
    """
    drifting = np.zeros(len(section), dtype=bool)
    for period in range(1, DRIFT_PERIODS + 1):
        gap = np.abs(section[:, period:] - section[:, :-period]).max(axis=2)
        length = gap.shape[1] // DRIFT_WINDOWS
        worst = gap[:, : length * DRIFT_WINDOWS].reshape(len(gap), DRIFT_WINDOWS, length).max(axis=2)
        drifting |= (np.diff(worst, axis=1) > 0.0).all(axis=1)
    return drifting


# --- names ------------------------------------------------------------------------------------------------------------


def judge(members: Members, evidence: Evidence) -> None:
    """Classifies motions that do not return, and marks regimes as doubtful that the evidence does not support."""
    losing = members.damped
    ran = evidence.outcome == Outcome.OK
    wandering = (evidence.regime == Regime.TRANSIENT) & ran
    # Without damping, chaotic motions stick to islands for long, and their averages may never become steady.
    sticky = ~losing & (evidence.exponents[:, 0] > shear_level(evidence.averaged_time)) & (evidence.sign == 0)
    sticky &= evidence.zero_one > CHAOTIC_K
    chaotic = wandering & ((evidence.sign > 0) | sticky) & ~(losing & evidence.under_way)
    neutral = (evidence.sign == 0) & (evidence.zero_one < REGULAR_K) & ~evidence.under_way
    on_torus = (not members.system.planar) & neutral
    quasi_periodic = wandering & ~chaotic & (~losing | on_torus)
    evidence.regime[chaotic] = Regime.CHAOTIC
    evidence.regime[quasi_periodic] = Regime.QUASI_PERIODIC
    evidence.regime[~ran] = Regime.LEFT_THE_DOMAIN
    # a run out of steps, or out of digits near the stretch limit, is not evidence for an attractor
    stopped = np.isin(evidence.outcome, (Outcome.STEP_LIMIT, Outcome.STRETCH_LIMIT))
    evidence.regime[stopped] = Regime.TRANSIENT
    evidence.doubtful = chaotic & (sticky | ~(evidence.zero_one > CHAOTIC_K))
    evidence.doubtful |= quasi_periodic & ~(evidence.zero_one < REGULAR_K)
    # A cycle or a rest that attracts has a negative exponent; without damping it is neutral at best.
    returns = (evidence.regime == Regime.REST) | (evidence.regime == Regime.PERIODIC)
    evidence.doubtful |= returns & np.where(losing, evidence.sign >= 0, evidence.sign > 0)
    evidence.doubtful |= evidence.regime == Regime.TRANSIENT


def _store_lifetimes(
    members: Members, rows: npt.NDArray[np.intp], duration: Array, nearby: Nearby, evidence: Evidence
) -> None:
    """Stores the lifetime of the chaos of the damped members ``rows``, and classifies transient chaos."""
    chaos = np.isfinite(nearby.apart) | (evidence.regime == Regime.CHAOTIC)
    rows = _alive(rows[chaos[rows]], evidence)
    # No cycle attracts faster than the damping lets it.
    damping = members.values["damping_ratio"]
    attraction = np.where(evidence.sign < 0, np.minimum(-evidence.exponents[:, 0], damping), damping)
    for name, values in chaos_of(nearby, rows, attraction, evidence.regime == Regime.CHAOTIC).items():
        getattr(evidence, name)[rows] = values
    returns = np.isin(evidence.regime[rows], (Regime.PERIODIC, Regime.REST)) & (evidence.sign[rows] < 0)
    ends = (evidence.share_chaotic[rows] < 1.0) & ~evidence.coexisting[rows]
    lasted = evidence.lifetime[rows] > duration[rows]
    evidence.regime[rows[returns & ends & lasted]] = Regime.TRANSIENT_CHAOS
    # a start next to this one may have a lifetime on the other side
    either = (evidence.lifetime_low[rows] <= duration[rows]) & (evidence.lifetime_high[rows] > duration[rows])
    evidence.doubtful[rows[returns & ends & either]] = True
    undamped = (evidence.regime == Regime.CHAOTIC) & ~members.damped
    evidence.chaotic_until[undamped] = (evidence.settled_time + evidence.averaged_time)[undamped]
    evidence.share_chaotic[undamped], evidence.lifetime[undamped] = 1.0, np.inf
    evidence.lifetime_low[undamped], evidence.lifetime_high[undamped] = 0.0, np.inf
