"""Where damped motions and the starts beside them arrive, and how long the chaos on the way lasts."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome, Regime
from gelcone.motion.course import cycles_reached
from gelcone.motion.evidence import FATES, Evidence
from gelcone.motion.examination import REST_TOLERANCE, examine, find_cycle, is_chaotic, unsettled
from gelcone.motion.lasting import SETTLING, STARTS, Nearby, lifetimes
from gelcone.motion.tangents import FLOOR
from gelcone.physics.members import Members
from gelcone.progress import Counted, weighted
from gelcone.quantity import Array


def follow_starts(
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
    examine((find_cycle,), members, rows, evidence, exact)
    there = ~unsettled(members, rows, evidence)
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


def find_ended(
    members: Members,
    rows: npt.NDArray[np.intp],
    nearby: Nearby,
    evidence: Evidence,
    options: dict[str, Any],
) -> None:
    """Finds the cycles on which some ``rows`` have arrived while they were measured."""
    rows = rows[~is_chaotic(evidence, rows)]
    if not rows.size:
        return
    reached = cycles_reached(members.take(rows), evidence.final[rows], **options)
    there = rows[reached.attracting]
    evidence.period[there] = reached.period[reached.attracting]
    examine((find_cycle,), members, there, evidence, options)
    nearby.ended[there, 0] = nearby.followed[there, 0]


def tell_how_long(
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
