"""Search for attractors: motions are followed until they settle on an attracting cycle, at most for ``patience``.

A motion may have settled when its last points return, forcing period after forcing period; it has settled when Newton's
method finds an attracting cycle there (`gelcone.motion.attractor.cycle`). Its earlier distances from that cycle give
the time of arrival; distances between nearby starts give the time at which chaos separated them. All analyses of
settled motions use this search: one ``transient`` first, then twice the time so far, up to ``patience``. Where states
that components add relax far more slowly than the disc, the drift is followed (`gelcone.motion.attractor.drift`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.motion.attractor.cycle import SMALLEST_SIZE, Cycles, find_cycles
from gelcone.motion.attractor.drift import drifted
from gelcone.motion.columns import Columns, column
from gelcone.motion.flow import integrate
from gelcone.motion.settle import alike
from gelcone.physics.members import Members
from gelcone.progress import Counted, Progress, weighted
from gelcone.quantity import Array

DECAY_TIMES = 20.0
LONGEST_DECAY = 5000.0
FEWEST_REPEATS = 30
SLOW = 2.0
"""Least ratio of the time in which slow states settle to that of the disc."""
MOST_DRIFTS = 8
"""Extra rounds for motions that leave a drift and begin the next one."""
SHORTEST_TRANSIENT = 200.0
PATIENCE, PATIENCE_PERIODS, PATIENCE_TRANSIENTS = 1e5, 300, 5
"""Time, forcing periods and default transients of which the longest is the default patience."""
CHAOS_TRANSIENTS = 32
"""Default patience for chaos, in transients, of analyses that need neither its lifetime nor its exponents."""
FOLLOW_TOLERANCE = 1e-6
"""Least tolerance of damped motions once chaos has separated nearby starts: a motion that settles forgets the error,
and Newton's method refines it; times and averages of chaos are far more uncertain."""
NEARBY = 1e-9
"""Distance of nearby starts from that of the motion, in displacement or velocity."""
SEPARATED = 1e-3
"""Least distance of separated starts, over the motion's size."""
LONGEST_PERIOD = 64
"""Longest period, in forcing periods, that is recognised."""
HISTORY, WINDOW = 64, 144
"""Forcing periods of a run that are examined: spread over it, and in a row at its end."""
PHASES = (0.5, 1.0)
"""Phases at which periods are sampled, two because a slow drive can push all motions to the same point once a
period."""
LAGS = 24
"""Least number of points that return in a settled motion."""
RETURN = 1e-4
"""Largest distance of a return over the motion's size; a thousand times the error of the loosest run."""
AWAY = 1e-2
"""Least distance from the final cycle, over its size, of a motion that has not arrived."""
BLOCK_SAMPLES = 2**19
"""Most samples of a block of members; bounds the memory."""


# --- budgets ----------------------------------------------------------------------------------------------------------


def default_transient(members: Members) -> Array:
    """Time after which a motion is first examined, (members,).

    20 times the slowest decay: 1/zeta, at most 5,000 in all, or the time constants of the states that components add;
    and at least 30 forcing periods and 200.
    """
    return np.maximum(transient_of_the_disc(members), DECAY_TIMES * members.time_constant)


def are_slow(members: Members, duration: Array | float = np.inf) -> npt.NDArray[np.bool_]:
    """Mask (members,): the default transient and ``duration`` are far longer than that of the disc."""
    return np.asarray(SLOW * transient_of_the_disc(members) < np.minimum(default_transient(members), duration))


def transient_of_the_disc(members: Members) -> Array:
    """`default_transient` without the states that components add."""
    decay = np.minimum(DECAY_TIMES / np.maximum(members.values["damping_ratio"], 1e-12), LONGEST_DECAY)
    return np.maximum(np.maximum(FEWEST_REPEATS * members.forcing_period, decay), SHORTEST_TRANSIENT)


def transient_of(members: Members, transient: float | None) -> Array:
    """The time discarded of each member, (members,): ``transient``, or `default_transient` if it is None."""
    return default_transient(members) if transient is None else np.full(members.size, float(transient))


def patience_of(members: Members, patience: float | Array | None) -> Array:
    """Longest time for which motions are followed, (members,): ``patience``, or the default (`PATIENCE`)."""
    if patience is not None:
        return np.full(members.size, patience, dtype=float)
    return np.maximum(
        np.maximum(PATIENCE, PATIENCE_PERIODS * members.forcing_period),
        PATIENCE_TRANSIENTS * default_transient(members),
    )


# --- returns ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Returns(Columns):
    """Ends of runs and returns found there; arrays (members, ...).

    ``final`` states (members, N); ``outcome``; ``period`` on which they have settled, in forcing periods (0: none);
    ``drift``, the same for motions that return but for an even drift; ``away``, the time since the start when they were
    last away from the cycle; ``lowest`` and ``highest`` (members, 2 N) states at the two `PHASES` over that period;
    ``gap``, the least distance of a return over the size.
    """

    final: Array = column(np.nan, "N")
    outcome: npt.NDArray[np.int8] = column(0, kind=np.int8)
    period: npt.NDArray[np.int64] = column(0, kind=np.int64)
    drift: npt.NDArray[np.int64] = column(0, kind=np.int64)
    away: Array = column(np.inf)
    lowest: Array = column(np.nan, "2N")
    highest: Array = column(np.nan, "2N")
    gap: Array = column()


def follow(
    members: Members,
    states: Array,
    repeats: npt.NDArray[np.int64],
    *,
    abreast: int = 1,
    progress: Progress = None,
    **flow_options: Any,
) -> tuple[Returns, Array]:
    """Follow members from ``states`` (members, N) at phase 0 over ``repeats`` (members,) forcing periods each.

    Also returns the times (members,) at which each separated from the first of its group of ``abreast`` members,
    infinite if it did not.
    """
    returns, apart = Returns.blank(len(states), states=states.shape[1]), np.full(members.size, np.inf)
    for rows, numbers in _groups(repeats, abreast):
        group = members.take(rows)
        ticks = (numbers[:, :, None] + np.asarray(PHASES) - 1.0).reshape(len(rows), -1)
        share = weighted(progress, rows.size / members.size)
        run = integrate(group, states[rows], ticks * group.forcing_period[:, None], progress=share, **flow_options)
        points = run.states.reshape(*numbers.shape, -1)
        times = numbers * group.forcing_period[:, None]
        returns.final[rows], returns.outcome[rows] = run.states[:, -1], run.outcome
        dense = points[:, -min(WINDOW, points.shape[1]) :]
        returns.period[rows], returns.gap[rows] = period_of(dense)
        if not members.system.planar:  # an even drift changes the state by the same amount in each period
            drift, _ = period_of(np.diff(dense, axis=1), size=np.abs(dense).max(axis=(1, 2)))
            returns.drift[rows] = np.where(returns.period[rows] > 0, returns.period[rows], drift)
        _store_cycles(returns, rows, points, times)
        apart[rows] = _separation_times(points, times, abreast)
    return returns, apart


def _groups(
    repeats: npt.NDArray[np.int64], abreast: int
) -> Iterator[tuple[npt.NDArray[np.intp], npt.NDArray[np.int64]]]:
    """Blocks of members that are sampled equally often, and the numbers (members, samples) of their sampled periods."""
    window = np.minimum(repeats, WINDOW)
    before = np.minimum(repeats - window, HISTORY)
    for (last, first), group in alike(window, before):
        size = max(1, BLOCK_SAMPLES // (last + first) // abreast) * abreast
        for begin in range(0, group.size, size):
            rows = group[begin : begin + size]
            spread = (repeats[rows, None] - last) * np.arange(1, first + 1) // max(first, 1)
            ends = repeats[rows, None] - last + np.arange(1, last + 1)
            yield rows, np.concatenate([spread, ends], axis=1)


def period_of(
    points: Array, tolerance: float = RETURN, fewest: int = LAGS, size: Array | None = None
) -> tuple[npt.NDArray[np.int64], Array]:
    """Smallest number of periods (members,) after which the last points return, 0 if none; and the least distance.

    ``points`` (members, periods, coordinates) of periods in a row. Distances are over the motion's ``size`` (members,),
    by default the largest coordinate. At least the ``fewest`` last points, and those of a whole period, have to agree
    with earlier ones to the ``tolerance``.
    """
    count, length = points.shape[:2]
    with np.errstate(invalid="ignore"):
        scale = np.maximum(np.abs(points).max(axis=(1, 2)) if size is None else size, SMALLEST_SIZE)
        longest = min(LONGEST_PERIOD, length // 2)
        last = np.abs(points[:, -1:] - points[:, -1 - longest : -1][:, ::-1]).max(axis=2) / scale[:, None]
    period, gap = np.zeros(count, dtype=np.int64), np.full(count, np.inf)
    candidates = last < tolerance
    for lag in np.flatnonzero(candidates.any(axis=0)) + 1:
        rows = np.flatnonzero(candidates[:, lag - 1] & (period == 0))
        if not rows.size:
            continue
        compared = min(max(fewest, lag), length - lag)
        later = points[rows, -compared:]
        earlier = points[rows, -compared - lag : -lag]
        distance = np.abs(later - earlier).max(axis=(1, 2)) / scale[rows]
        gap[rows] = np.minimum(gap[rows], distance)
        period[rows[distance < tolerance]] = lag
    nearest = last.min(axis=1, initial=np.inf)
    return period, np.where(np.isfinite(gap), gap, nearest)


def _store_cycles(found: Returns, rows: npt.NDArray[np.intp], points: Array, times: Array) -> None:
    """Stores the time when settled ``rows`` were last away from their cycles, and the ends of these."""
    period = found.period[rows]
    for repeats in np.unique(period[period > 0]):
        same = np.flatnonzero(period == repeats)
        path = points[same]
        cycle = path[:, -repeats:]
        scale = np.maximum(np.abs(cycle).max(axis=(1, 2)), SMALLEST_SIZE)
        distance = np.full(path.shape[:2], np.inf)
        for k in range(repeats):
            distance = np.minimum(distance, np.abs(path - cycle[:, k : k + 1]).max(axis=2))
        away = np.where(distance > AWAY * scale[:, None], times[same], 0.0)
        found.away[rows[same]] = away.max(axis=1)
        found.lowest[rows[same]], found.highest[rows[same]] = cycle.min(axis=1), cycle.max(axis=1)


def _separation_times(points: Array, times: Array, abreast: int) -> Array:
    """Times (members,) at which each separated from the first of its group, infinite if it did not."""
    if abreast == 1:
        return np.full(len(points), np.inf)
    together = points.reshape(-1, abreast, *points.shape[1:])
    with np.errstate(invalid="ignore"):
        scale = np.maximum(np.abs(together[:, :1]).max(axis=(2, 3)), SMALLEST_SIZE)
        apart = np.abs(together - together[:, :1]).max(axis=3) > SEPARATED * scale[..., None]
    each = times.reshape(-1, abreast, times.shape[1])
    return np.asarray(np.where(apart, each, np.inf).min(axis=2).ravel())


# --- searches ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Starts(Columns):
    """Motions of each member from several starts; arrays (members, starts, ...), that of the member itself first.

    ``state`` (members, starts, N) now, at phase 0; ``followed``, the time so far; ``ended``, the time at which the
    motion had settled (infinite: not yet), on a cycle of ``period`` forcing periods between ``lowest`` and ``highest``
    (both of the states at two phases of the drive); ``drift``, the forcing periods after which it nearly returns; the
    ``outcome``; the ``gap`` of its return; ``apart`` (members,), the time at which chaos had separated the starts.
    """

    state: Array = column(np.nan, "N")
    followed: Array = column(0.0)
    ended: Array = column(np.inf)
    period: npt.NDArray[np.int64] = column(0, kind=np.int64)
    drift: npt.NDArray[np.int64] = column(0, kind=np.int64)
    lowest: Array = column(np.nan, "2N")
    highest: Array = column(np.nan, "2N")
    outcome: npt.NDArray[np.int8] = column(0, kind=np.int8)
    gap: Array = column()
    apart: Array = column()

    @classmethod
    def at(cls, states: Array, starts: int) -> Self:
        """Starts at and around ``states`` (members, N), whose displacement and velocity differ by `NEARBY`."""
        count, size = states.shape
        angles = 2.0 * np.pi * np.arange(starts - 1) / (starts - 1)
        around = np.zeros((starts, size))
        around[1:, 0], around[1:, 1] = NEARBY * np.cos(angles), NEARBY * np.sin(angles)
        new_starts = cls.blank(count, starts, states=size)
        new_starts.state[:] = states[:, None] + around
        return replace(new_starts, apart=np.full(count, np.inf))

    @property
    def escaped(self) -> npt.NDArray[np.bool_]:
        """Mask (members, starts) of starts that have settled."""
        return np.isfinite(self.ended)

    def advance(
        self,
        members: Members,
        rows: npt.NDArray[np.intp],
        starts: slice,
        until: Array,
        *,
        compared: bool = False,
        **flow_options: Any,
    ) -> None:
        """Follows ``starts`` of the members ``rows`` that have not ended to the end of the forcing period in which
        ``until`` (members,) lies. Starts ``compared`` from their beginning give the time of their separation."""
        part, columns = np.broadcast_arrays(rows[:, None], np.arange(self.ended.shape[1])[starts])
        left = np.rint((until[part] - self.followed[part, columns]) / members.forcing_period[part] + 0.4999)
        runs = np.isinf(self.ended[part, columns]) & (self.outcome[part, columns] == Outcome.OK) & (left >= 1.0)
        abreast = part.shape[1] if compared else 1
        row, start, repeats = part[runs], columns[runs], left[runs].astype(np.int64)
        if not row.size:
            return
        some, before = members.take(row), self.followed[row, start]
        run, apart = follow(some, self.state[row, start], repeats, abreast=abreast, **flow_options)
        settled = run.period > 0
        self.ended[row, start] = np.where(settled, before + run.away, np.inf)
        self.followed[row, start] += repeats * some.forcing_period
        self.state[row, start] = run.final
        for name in ("outcome", "period", "drift", "gap", "lowest", "highest"):
            getattr(self, name)[row, start] = getattr(run, name)
        np.minimum.at(self.apart, row, before + apart)


class Search:
    """A search for the attractors of damped ``members``, from the ``starts`` of each.

    One of the starts represents each member: the number ``start`` (members,), 0 at first, that of the member itself.
    ``cycles`` are those near these starts; a member has arrived if its cycle is `Cycles.attracting`. ``courses`` are
    the rows and points (rows, points, N) of the drifts that were followed.
    """

    def __init__(self, members: Members, starts: Starts, progress: Progress, **flow_options: Any) -> None:
        self.members, self.starts, self.progress, self.exact = members, starts, progress, flow_options
        self.loose = flow_options | {"tolerance": max(flow_options.get("tolerance", 0.0), FOLLOW_TOLERANCE)}
        self.cycles = Cycles.blank(members.size, states=starts.state.shape[2])
        self.start = np.zeros(members.size, dtype=np.intp)
        self.courses: list[tuple[npt.NDArray[np.intp], Array]] = []

    @property
    def state(self) -> Array:
        """States (members, N) of the starts that represent the members."""
        return np.asarray(self.starts.state[np.arange(self.members.size), self.start])

    @property
    def outcome(self) -> npt.NDArray[np.int8]:
        """Outcomes (members,) of the starts that represent the members."""
        return np.asarray(self.starts.outcome[np.arange(self.members.size), self.start])

    def advance(
        self, rows: npt.NDArray[np.intp], starts: slice, until: Array, share: float, *, compared: bool = False
    ) -> None:
        """Advances starts (`Starts.advance`), with the given tolerance until chaos has separated those of a member."""
        apart = np.isfinite(self.starts.apart[rows])
        for part, options in ((rows[~apart], self.exact), (rows[apart], self.loose)):
            if part.size:
                progress = weighted(self.progress, share * part.size / rows.size)
                self.starts.advance(self.members, part, starts, until, compared=compared, progress=progress, **options)

    def begin(self, rows: npt.NDArray[np.intp], duration: Array, share: float) -> None:
        """Follows the first two starts of each member together to the time ``duration`` (members,).

        A motion that returns but for a drift of slow states is taken along the drift as far as it leads. A motion that
        leaves its drift is followed until it drifts again.
        """
        disc = transient_of_the_disc(self.members)
        until, left = np.where(are_slow(self.members, duration), disc, duration), rows[:0]
        rounds = 1 + doublings(until[rows], duration[rows])
        rounds += MOST_DRIFTS * (rounds > 1)
        for _ in range(rounds):
            self.advance(rows, slice(0, 2), until, share / rounds, compared=True)
            rows, lost, left = self._drifting(rows[(until[rows] < duration[rows]) | np.isin(rows, left)])
            if not rows.size:
                break
            until = np.minimum(2.0 * until, duration)
            until[lost] = duration[lost]
            until[left] = self.starts.followed[left, 0] + disc[left]

    def _drifting(
        self, rows: npt.NDArray[np.intp]
    ) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp], npt.NDArray[np.intp]]:
        """Takes the ``rows`` to the ends of their drifts.

        Returns the rows that have to be followed further; among them those whose drift ends at no attracting cycle, and
        those that left their drift, at the point where they did.
        """
        starts = self.starts
        starts.ended[rows, :2] = np.inf  # a very slow drift looks settled
        one_ended = rows[(starts.outcome[rows, 0] == Outcome.OK) & (starts.outcome[rows, 1] != Outcome.OK)]
        starts.apart[one_ended] = np.fmin(starts.apart[one_ended], starts.followed[one_ended, 1])
        rows = np.setdiff1d(rows, one_ended)
        together = np.isinf(starts.apart[rows]) & (starts.outcome[rows, :2] == Outcome.OK).all(axis=1)
        steady = rows[together & (starts.drift[rows, 0] > 0)]
        part, period = self.members.take(steady), starts.drift[steady, 0]
        drift = drifted(part, starts.state[steady, 0], period, **self.exact)
        if steady.size:
            self.courses.append((steady, drift.course))
        cycles = find_cycles(part, drift.point, np.where(drift.ends, period, 0), **self.exact)
        at, there = steady[cycles.attracting], cycles.attracting
        starts.state[at, :2], starts.period[at, :2] = cycles.point[there, None], cycles.period[there, None]
        starts.followed[at, :2] += drift.time[there, None]
        starts.ended[at, :2] = starts.followed[at, :2]
        self.cycles.put(at, cycles.take(there))
        leaves = ~drift.ends & (drift.time > 0.0)
        left = steady[leaves]
        starts.state[left, :2] = Starts.at(drift.point[leaves], 2).state
        starts.followed[left, :2] += drift.time[leaves, None]
        lost = np.setdiff1d(steady, np.concatenate([at, left]))
        return np.setdiff1d(rows[starts.outcome[rows, 0] == Outcome.OK], at), lost, left

    def under_way(self, rows: npt.NDArray[np.intp], start: npt.NDArray[np.intp] | int = 0) -> npt.NDArray[np.intp]:
        """Lets a ``start`` represent each member, and returns the ``rows`` in which it has neither arrived nor failed.

        A start that does not move at all counts as arrived.
        """
        starts, at = self.starts, (rows, np.broadcast_to(start, rows.shape))
        self.start[rows] = at[1]
        alive = starts.outcome[at] == Outcome.OK
        period = np.where(alive, starts.period[at], 0)
        cycles = find_cycles(self.members.take(rows), starts.state[at], period, **self.exact)
        self.cycles.put(rows, cycles)
        unsettled = ~cycles.attracting & (starts.gap[at] > 0.0) & alive
        starts.ended[at[0][unsettled], at[1][unsettled]] = np.inf
        return rows[unsettled]

    def follow(self, rows: npt.NDArray[np.intp], begin: Array, end: Array, share: float) -> npt.NDArray[np.intp]:
        """Follows the first starts in rounds, each as long as all before, and returns the ``rows`` still under way."""
        until, rounds = np.minimum(begin, end), doublings(begin[rows], end[rows])
        for _ in range(rounds):
            more = rows[until[rows] < end[rows]]
            if not more.size:
                break
            until = np.minimum(2.0 * until, end)
            self.advance(more, slice(0, 1), until, share / rounds)
            rows = np.setdiff1d(rows, np.setdiff1d(more, self.under_way(more)))
        return rows


def doublings(begin: Array, end: Array) -> int:
    """The number of doublings from ``begin`` to ``end``, the most of all members."""
    return int(np.ceil(np.log2(np.maximum(end / begin, 1.0))).max(initial=0.0))


def search(
    members: Members,
    states: Array,
    *,
    transient: float | None = None,
    patience: float | None = None,
    progress: Progress = None,
    **flow_options: Any,
) -> Search:
    """Follow damped members from ``states`` (members, N) at phase 0 until each has arrived, at most for ``patience``.

    ``transient`` and ``patience`` as in `gelcone.regime`, except that the default patience for chaos is
    `CHAOS_TRANSIENTS`; ``flow_options`` go to `integrate`.
    """
    counted = Counted(progress)
    member_search = Search(members, Starts.at(states, 2), counted, **flow_options)
    duration, rows = transient_of(members, transient), np.arange(members.size)
    if rows.size:
        member_search.begin(rows, duration, 0.5)
        unsettled, longest = member_search.under_way(rows), patience_of(members, patience)
        if patience is None:
            chaotic = np.isfinite(member_search.starts.apart)
            longest = np.where(chaotic, np.minimum(longest, CHAOS_TRANSIENTS * duration), longest)
        member_search.follow(unsettled, duration, longest, 0.5)
    counted.finish()
    return member_search


def integration(options: dict[str, Any]) -> dict[str, Any]:
    """The options of a search that go to `integrate`."""
    return {name: value for name, value in options.items() if name not in ("transient", "patience")}


def cycles_reached(members: Members, states: Array, **flow_options: Any) -> Cycles:
    """Find the cycles near motions that return, from ``states`` at phase 0."""
    returns, _ = follow(members, states, np.full(members.size, WINDOW), **flow_options)
    return find_cycles(members, returns.final, returns.period, **flow_options)
