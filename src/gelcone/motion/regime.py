"""What kind of motion it is - rest, periodic, quasi-periodic, chaotic, not settled, left the domain - with evidence.

The motion settles, and a damped one is then looked for among cycles: one that returns and is on a cycle that attracts,
which Newton's method finds, has arrived. A start beside it (`gelcone.motion.lasting`) tells whether chaos takes part;
where it does, or where nothing settles soon, more starts show where they end and how long the chaos lasts. What none of
them leaves is followed for as long as there is patience and then measured: does the largest Lyapunov exponent have a
certain sign, and what does the 0-1 test say? Chaos that ends has a name of its own, and the exponents of what it ends
in.

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
from gelcone.devices.analysis import for_devices
from gelcone.motion.course import cycles_reached
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
from gelcone.motion.evidence import FATES, Evidence, label_regimes
from gelcone.motion.flow import DEFAULT_TOLERANCE, integrate
from gelcone.motion.lasting import SETTLING, STARTS, Nearby, lifetimes
from gelcone.motion.lyapunov import average, bound_shear, shear_level
from gelcone.motion.settle import (
    LONG_STRETCH,
    STRETCH,
    check_budgets,
    repeats_lasting,
    settle,
    start_states,
    transient_of,
)
from gelcone.motion.tangents import CERTAIN, FLOOR
from gelcone.motion.validity import spread_over, validity
from gelcone.motion.zero_one import zero_one
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.progress import Counted, Progress, weighted
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

REST_TOLERANCE = 1e-6
PATIENCE, PATIENCE_PERIODS = 1e5, 300
"""Time, and forcing periods, for which chaos is followed by default: the longer of both."""
FOLLOW_TOLERANCE = 1e-6
"""Tolerance of damped motions once chaos has pulled nearby starts apart: one that settles forgets the error, and is
then polished; of chaos only times and averages are taken, which are uncertain by far more."""
MEASURE_TOLERANCE = 1e-8
"""The same while exponents are averaged."""
TEST_POINTS = (200, 800)
"""Points of the 0-1 test, and of its repetition where the first is no clear answer."""
ENDED = 1e-3
"""Chaos has ended when the last points of its 0-1 test return this closely."""
DRIFT_WINDOWS = 8
CHAOTIC_K = 0.8
REGULAR_K = 0.2
CYCLE_SAMPLES = 64
"""Samples of a forcing period of a cycle, for its extent."""


def classify(
    members: Members,
    states: Array,
    *,
    transient: float | None = None,
    patience: float | None = None,
    budget: float = 20_000.0,
    progress: Progress = None,
    **flow_options: Any,
) -> Evidence:
    """The regime of every member of a flattened ensemble from its initial state (members, N), with the evidence.

    The workhorse behind `regime`, bifurcation diagrams and maps: a member's result depends on nothing but itself.
    Options as in `regime`.
    """
    evidence = Evidence.blank(members.size, len(members.system.states))
    evidence.final[:] = states
    counted = Counted(progress)
    duration = transient_of(members, transient)
    longest = patience_of(members, patience)
    loose, averaging = (
        flow_options | {"tolerance": max(flow_options.get("tolerance", 0.0), least)}
        for least in (FOLLOW_TOLERANCE, MEASURE_TOLERANCE)
    )
    losing = np.flatnonzero(members.damped)
    _settle(members, np.flatnonzero(~members.damped), duration, evidence, flow_options)
    _examine((_examine_returns,), members, np.flatnonzero(~members.damped), evidence, flow_options)
    nearby = Nearby.at(evidence.final)
    _follow(members, losing, duration, longest, nearby, evidence, loose, flow_options, counted)
    wandering = _alive(np.flatnonzero(np.isnan(evidence.cycle_distance)), evidence)
    measures = (partial(_measure, budget=budget), _second_opinion)
    damped = members.damped[wandering]
    _examine(measures, members, wandering[~damped], evidence, flow_options)
    wandering = _examine((_see, *measures), members, wandering[damped], evidence, averaging)
    _find_ended(members, wandering, nearby, evidence, flow_options)
    _judge(members, evidence)
    _tell_how_long(members, losing, duration, nearby, evidence)
    counted.finish()
    return evidence


def patience_of(members: Members, patience: float | None) -> Array:
    """For how long chaos is followed, (members,): ``patience``, or by default `PATIENCE` or `PATIENCE_PERIODS`."""
    if patience is not None:
        return np.full(members.size, float(patience))
    return np.maximum(PATIENCE, PATIENCE_PERIODS * members.forcing_period)


def _follow(
    members: Members,
    rows: npt.NDArray[np.intp],
    duration: Array,
    longest: Array,
    nearby: Nearby,
    evidence: Evidence,
    loose: dict[str, Any],
    exact: dict[str, Any],
    counted: Counted,
) -> None:
    """Follows damped members until they have settled, or patience ends; where chaos takes part, the nearby starts too.

    All nearby starts together are followed for as long as the motion itself.
    """

    def onward(rows: npt.NDArray[np.intp], starts: slice, until: Array, share: float, compared: bool = False) -> None:
        apart = np.isfinite(nearby.apart[rows])
        for part, options in ((rows[~apart], exact), (rows[apart], loose)):
            if part.size:
                progress = weighted(counted, share * part.size / rows.size)
                nearby.advance(members, part, starts, until, compared=compared, progress=progress, **options)

    def own_way(rows: npt.NDArray[np.intp], begin: Array, end: Array, share: float) -> npt.NDArray[np.intp]:
        """Follows the motion itself in rounds, each as long as all before; those that have not settled."""
        until, rounds = np.minimum(begin, end), _rounds(begin[rows], end[rows])
        for _ in range(rounds):
            until = np.minimum(2.0 * until, end)
            onward(rows, slice(0, 1), until, share / rounds)
            rows = rows[~_arrive(members, rows, 0, nearby, evidence, exact)]
        return rows

    if not rows.size:
        return
    together = np.maximum(longest / (STARTS - 1), duration)
    onward(rows, slice(0, 2), duration, 0.2, compared=True)
    unsettled = rows[~_arrive(members, rows, 0, nearby, evidence, exact)]
    unsettled = own_way(unsettled, duration, np.minimum(together, longest), 0.1)
    chaotic = rows[np.isfinite(nearby.apart[rows]) | np.isin(rows, unsettled)]
    until = duration
    onward(chaotic, slice(1, STARTS), until, 0.1)
    rounds = _rounds(duration[chaotic], together[chaotic])
    for _ in range(rounds):
        until = np.minimum(2.0 * until, together)
        onward(chaotic, slice(1, STARTS), until, 0.2 / rounds)
    unsettled = unsettled[~_arrive_elsewhere(members, unsettled, nearby, evidence, exact)]
    unsettled = own_way(unsettled, together, longest, 0.2)
    evidence.settled_time[rows] = np.where(np.isin(rows, unsettled), duration[rows], nearby.followed[rows, 0])


def _find_ended(
    members: Members,
    rows: npt.NDArray[np.intp],
    nearby: Nearby,
    evidence: Evidence,
    options: dict[str, Any],
) -> None:
    """Finds the cycles on which some ``rows`` have arrived while they were measured."""
    rows = rows[~_is_chaotic(evidence, rows)]
    if not rows.size:
        return
    reached = cycles_reached(members.take(rows), evidence.final[rows], **options)
    there = rows[reached.attracting]
    evidence.period[there] = reached.period[reached.attracting]
    _examine((_find_cycle,), members, there, evidence, options)
    nearby.ended[there, 0] = nearby.followed[there, 0]


def _rounds(begin: Array, end: Array) -> int:
    """How many doublings lead from ``begin`` to ``end`` for all members."""
    return int(np.ceil(np.log2(np.maximum(end / begin, 1.0))).max(initial=0.0))


def _arrive(
    members: Members,
    rows: npt.NDArray[np.intp],
    start: npt.NDArray[np.intp] | int,
    nearby: Nearby,
    evidence: Evidence,
    exact: dict[str, Any],
) -> npt.NDArray[np.bool_]:
    """Which ``rows`` have settled, or stopped, with one of their starts: on a cycle that attracts, which is then their
    evidence. Those that have not go on."""
    column = np.broadcast_to(start, rows.shape)
    evidence.final[rows] = nearby.state[rows, column]
    evidence.outcome[rows] = nearby.outcome[rows, column]
    evidence.period[rows], evidence.return_distance[rows] = nearby.period[rows, column], nearby.gap[rows, column]
    evidence.regime[rows] = np.where(evidence.period[rows] > 0, Regime.PERIODIC, Regime.TRANSIENT)
    evidence.cycle_distance[rows] = np.nan
    alive = evidence.outcome[rows] == Outcome.OK
    _examine((_find_cycle,), members, rows, evidence, exact)
    there = ~_unsettled(members, rows, evidence)
    back = ~there & alive
    nearby.ended[rows[back], column[back]] = np.inf
    return np.asarray(there | ~alive)


def _arrive_elsewhere(
    members: Members, rows: npt.NDArray[np.intp], nearby: Nearby, evidence: Evidence, exact: dict[str, Any]
) -> npt.NDArray[np.bool_]:
    """Which ``rows`` have not settled themselves and show by nearby starts what they will end in.

    Where most of the starts end stands for the motion. Not where those that have not ended seem to last.
    """
    there = np.zeros(rows.size, dtype=bool)
    tried = np.isfinite(nearby.apart[rows]) & ~nearby.persists()[rows]
    for _ in range(FATES):
        tried &= nearby.escaped[rows].any(axis=1) & ~there
        some = np.flatnonzero(tried)
        if not some.size:
            break
        start = np.array([nearby.fates(int(row))[0][0] for row in rows[some]])
        there[some] = _arrive(members, rows[some], start, nearby, evidence, exact)
    left = rows[~there]
    evidence.final[left], evidence.outcome[left] = nearby.state[left, 0], nearby.outcome[left, 0]
    return there


def _tell_how_long(
    members: Members, rows: npt.NDArray[np.intp], duration: Array, nearby: Nearby, evidence: Evidence
) -> None:
    """How long the chaos of the damped members lasts, where their starts end, and the name of chaos that ends."""
    chaos = np.isfinite(nearby.apart) | (evidence.regime == Regime.CHAOTIC)
    rows = rows[chaos[rows] & (evidence.outcome[rows] == Outcome.OK)]
    # No cycle attracts faster than the damping lets it.
    damping = np.broadcast_to(members.damping_ratio, members.shape).ravel()
    attraction = np.where(evidence.sign < 0, np.minimum(-evidence.exponents[:, 0], damping), damping)
    times = nearby.times(SETTLING / np.maximum(attraction, FLOOR))[rows]
    escaped, valid = nearby.escaped[rows], nearby.outcome[rows] == Outcome.OK
    ended, count = (escaped & valid).sum(axis=1), valid.sum(axis=1)
    lasting = lifetimes(ended, np.where(valid, times, 0.0).sum(axis=1))
    evidence.lifetime[rows], evidence.lifetime_low[rows] = lasting.mean, lasting.low
    evidence.lifetime_high[rows], evidence.followed[rows] = lasting.high, count
    evidence.share_chaotic[rows] = 1.0 - ended / count
    evidence.seen_until[rows] = np.minimum(nearby.ended, nearby.followed)[rows, 0]
    coexisting = nearby.persists()[rows]
    evidence.coexisting[rows] = coexisting
    returns = np.isin(evidence.regime[rows], (Regime.PERIODIC, Regime.REST)) & (evidence.sign[rows] < 0)
    ends = returns & (ended > 0) & ~coexisting & (lasting.mean > duration[rows])
    evidence.regime[rows[ends]] = Regime.TRANSIENT_CHAOS
    for row in rows:
        _tell_fates(int(row), nearby, evidence)
    undamped = (evidence.regime == Regime.CHAOTIC) & ~members.damped
    evidence.seen_until[undamped] = (evidence.settled_time + evidence.averaged_time)[undamped]
    evidence.share_chaotic[undamped], evidence.lifetime[undamped] = 1.0, np.inf
    evidence.lifetime_low[undamped], evidence.lifetime_high[undamped] = 0.0, np.inf


def _tell_fates(row: int, nearby: Nearby, evidence: Evidence) -> None:
    """Where the starts of one member end, the most frequent first."""
    groups = [(group.size, group) for group in nearby.fates(row)]
    left = int(((nearby.outcome[row] == Outcome.OK) & ~nearby.escaped[row]).sum())
    told = [
        (size, Regime.REST if _still(nearby, row, int(group[0])) else Regime.PERIODIC, nearby.period[row, group[0]])
        for size, group in groups
    ]
    if left:
        told.append((left, Regime.CHAOTIC, 0))
    for k, (size, kind, period) in enumerate(sorted(told, key=lambda fate: -fate[0])[:FATES]):
        evidence.fate_regime[row, k] = kind
        evidence.fate_period[row, k] = 0 if kind is Regime.REST else period
        evidence.fate_share[row, k] = size / evidence.followed[row]


def _still(nearby: Nearby, row: int, start: int) -> bool:
    """Whether a start has come to rest."""
    return bool((nearby.highest[row, start] - nearby.lowest[row, start]).max() < REST_TOLERANCE)


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
    evidence: Evidence,
    options: dict[str, Any],
) -> None:
    """Lets ``duration`` (of all members) pass."""
    if not rows.size:
        return
    part = members.take(rows)
    evidence.final[rows], evidence.outcome[rows] = settle(
        part, evidence.final[rows], repeats_lasting(part, duration[rows]), **options
    )
    evidence.settled_time[rows] = duration[rows]


def _look(members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any]) -> Array:
    """Follows `RETURNS` forcing periods: section points and extent; the path (members, periods, phases, N)."""
    path, evidence.outcome[rows], times, states = follow(members, evidence.final[rows], **options)
    evidence.validity[rows] = validity(members, times, states)
    x = path[..., 0]
    evidence.lowest[rows], evidence.highest[rows] = x.min(axis=(1, 2)), x.max(axis=(1, 2))
    evidence.section[rows], evidence.final[rows] = path[:, :, -1], path[:, -1, -1]
    evidence.test_phase[rows] = _widest(x)
    return path


def _see(members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any]) -> None:
    _look(members, rows, evidence, options)


def _examine_returns(members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any]) -> None:
    """Whether undamped members return or are at rest."""
    path = _look(members, rows, evidence, options)
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


def _find_cycle(members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any]) -> None:
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
    bound_shear(members, result)
    evidence.exponents[rows], evidence.standard_error[rows] = result.values, result.standard_error
    evidence.averaged_time[rows], evidence.sign[rows] = result.time, result.sign
    evidence.outcome[rows] = result.outcome
    ok = result.outcome == Outcome.OK
    evidence.final[rows[ok]] = result.states[ok]


def _second_opinion(members: Members, rows: npt.NDArray[np.intp], evidence: Evidence, options: dict[str, Any]) -> None:
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
    # that a run ran out of steps, or of digits beside its stretch limit, says nothing of where the motion goes
    stopped = np.isin(evidence.outcome, (Outcome.STEP_LIMIT, Outcome.STRETCH_LIMIT))
    evidence.regime[stopped] = Regime.TRANSIENT
    evidence.doubtful = chaotic & (sticky | ~(evidence.zero_one > CHAOTIC_K))
    evidence.doubtful |= quasi_periodic & ~(evidence.zero_one < REGULAR_K)
    # A cycle or a rest that attracts has a negative exponent; without damping it is neutral at best.
    returns = (evidence.regime == Regime.REST) | (evidence.regime == Regime.PERIODIC)
    evidence.doubtful |= returns & np.where(losing, evidence.sign >= 0, evidence.sign > 0)
    evidence.doubtful |= evidence.regime == Regime.TRANSIENT


@for_devices
def regime(
    model: ConeModel,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    transient: float | None = None,
    patience: float | None = None,
    budget: float = 20_000.0,
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
    patience : time for which a damped motion that does not settle is followed before it is called chaotic, and all
        starts beside it together. Default 100,000, or 300 forcing periods where those are longer.
    budget : longest averaging time of the exponents. Default 20,000.
    tolerance : relative error of one integration step. Default 1e-15. Once chaos has pulled nearby starts
        apart, a damped motion is followed with at least 1e-6: it forgets the error, and is polished when it has
        settled. Chaos is measured with at least 1e-8.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset with ``regime`` (codes of `Regime`, as CF flags), ``period`` in forcing periods (0: none), ``symmetric``
    (maps onto itself under x -> -x), and the evidence: ``lyapunov`` and ``standard_error`` (..., exponent) per unit
    time, from the Floquet multipliers of the cycle where there is one and averaged elsewhere, ``averaged_time``,
    ``return_distance`` (of the motion a period later, over its size), ``cycle_distance`` (of the motion from the cycle,
    over its size; with damping, where there is one), ``zero_one`` (only where the motion does not return),
    ``section`` (..., point, state), ``lowest`` and ``highest`` displacement, ``settled_time``, ``doubtful`` (1 where
    the evidence does not agree: read it before you believe the name), ``outcome``.
    Of chaos: ``seen_until``, the time to which the motion was seen to be chaotic; of 16 ``starts`` within 1e-9 the
    ``share_chaotic`` that still is, and the mean ``lifetime`` (infinite where none has ended) between ``lifetime_low``
    and ``lifetime_high``. Chaos that ends is ``transient chaos``; its period, section and exponents are those of what
    most of the starts end in. Over ``fate``, the most frequent first, where the starts end: ``fate_regime`` (-1:
    none), ``fate_period`` and ``fate_share`` between ``fate_share_low`` and ``fate_share_high``; ``coexisting`` is 1
    where some end and the others seem to last.

    Raises
    ------
    InputError : for a transient or budget that is not positive, no rounds, or when no member can start.
    """
    options: dict[str, Any] = {
        "transient": transient,
        "patience": patience,
        "budget": budget,
        "tolerance": tolerance,
    }
    states = start_states(model, initial)
    found = regime_cells(model.members(), states, **options, threads=threads, progress=progress)
    return label_regimes(model, found, options, "regime of motion")


def regime_cells(
    members: Members,
    states: Array,
    *,
    transient: float | None = None,
    patience: float | None = None,
    budget: float = 20_000.0,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> Findings:
    """What `regime` finds of every member of a flattened ensemble from its state (members, N); options as there."""
    check_budgets(transient=transient, patience=patience, budget=budget)
    evidence = classify(
        members,
        states,
        transient=transient,
        patience=patience,
        budget=budget,
        tolerance=tolerance,
        threads=threads,
        progress=progress,
    )
    return evidence.findings(members.system)
