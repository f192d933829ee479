"""Does it last? Nearby starts, followed side by side: how many are still chaotic, and where the others have ended.

Chaos that ends looks like chaos that lasts until it does. Starts that no measurement distinguishes (`NEARBY`) follow
their own ways once chaos has pulled them apart, and each then stands for the same motion: the share of them that is
still chaotic, and their times together, give the mean lifetime. Chaos forgets, so that it ends in any moment as likely
as in any other; the lifetimes are exponential, those that have not ended yet are censored, and the mean is the time of
all starts together over the number that have ended, with the interval that the chi-square distribution gives (Lai and
Tel, Transient Chaos (2011), chapter 1; Epstein and Sobel, J. Am. Stat. Assoc. 48 (1953) 486).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome, Regime
from gelcone.motion.attractor.cycle import REST_TOLERANCE, SMALLEST_SIZE, Cycles
from gelcone.motion.attractor.search import AWAY, Search, Starts, doublings
from gelcone.motion.tangents import FLOOR
from gelcone.quantity import Array
from gelcone.statistics import CONFIDENCE

STARTS = 16
"""Starts followed side by side, the motion's own among them."""
SAME = 1e-3
"""Cycles are one when their lowest and highest points agree to this share of their size."""
SETTLING = np.log(1.0 / AWAY)
"""A motion comes within `AWAY` of a cycle in this number over its rate of attraction, and from there returns."""
FATES = 3
"""Attractors that are distinguished, at most, among those that nearby starts end on."""
EARLY, MISSED = 0.25, 3.0
"""Chaos that coexists with an attractor loses starts to it at first only: none have ended in the last three quarters
of the time in which at least three would have at the pace of the first."""


class Nearby(Starts):
    """Starts side by side: how long each was chaotic, and where they end."""

    def times(self, settling: Array | float = 0.0) -> Array:
        """The time for which each start was chaotic, (members, starts), from when they had come apart.

        From the end of chaos to within `AWAY` of a cycle a motion takes the time ``settling`` (members,), and as long
        again until it is observed to return: the time of one that has not ended counts up to twice that before.
        """
        since = np.where(np.isfinite(self.apart), self.apart, 0.0)[:, None]
        lag = np.broadcast_to(settling, self.apart.shape)[:, None]
        chaotic = np.where(self.escaped, self.ended - lag, self.followed - 2.0 * lag)
        return np.asarray(np.maximum(chaotic - since, 0.0))

    def persists(self) -> npt.NDArray[np.bool_]:
        """Members (members,) of which some starts ended soon and the others, against the odds, not at all."""
        times = self.times()
        early = EARLY * times[:, 1:].max(axis=1, keepdims=True)
        soon = (self.escaped & (times <= early)).sum(axis=1)
        late = (self.escaped & (times > early)).sum(axis=1)
        before, after = np.minimum(times, early).sum(axis=1), np.maximum(times - early, 0.0).sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray((late == 0) & (soon > 0) & (soon * after / before > MISSED))

    def fates(self, row: int) -> list[npt.NDArray[np.intp]]:
        """The starts of one member that have ended, by the cycle they ended on, the most frequent first."""
        groups: list[list[int]] = []
        for start in np.flatnonzero(self.escaped[row]):
            for group in groups:
                if self._same(row, int(start), group[0]):
                    group.append(int(start))
                    break
            else:
                groups.append([int(start)])
        return [np.array(group, dtype=np.intp) for group in sorted(groups, key=len, reverse=True)]

    def _same(self, row: int, one: int, other: int) -> bool:
        if self.period[row, one] != self.period[row, other]:
            return False
        ends = np.stack([self.lowest[row], self.highest[row]])
        size = max(float(np.abs(ends[:, other]).max()), SMALLEST_SIZE)
        return bool(np.abs(ends[:, one] - ends[:, other]).max() <= SAME * size)


@dataclass(frozen=True)
class Lifetimes:
    """Mean lifetimes of chaos, arrays (members,): the ``mean`` (infinite where none has ended) between ``low`` and
    ``high``."""

    mean: Array
    low: Array
    high: Array


def lifetimes(ended: npt.NDArray[Any], time: Array) -> Lifetimes:
    """Mean lifetimes (members,) from how many starts have ``ended`` in how much ``time`` of all together.

    The interval, of `CONFIDENCE`, is exact for a time that was fixed before; its upper end is infinite where none has
    ended.
    """
    if not time.size:  # a regular motion need not wait for the library
        return Lifetimes(time, time, time)
    from scipy.special import chdtri

    outside = 0.5 * (1.0 - CONFIDENCE)
    with np.errstate(divide="ignore", invalid="ignore"):
        low = 2.0 * time / chdtri(2.0 * ended + 2.0, outside)
        high = np.where(ended > 0, 2.0 * time / chdtri(2.0 * np.maximum(ended, 1), 1.0 - outside), np.inf)
        return Lifetimes(np.where(ended > 0, time / ended, np.inf), low, high)


# --- starts nearby ----------------------------------------------------------------------------------------------------


def follow_starts(
    search: Search, nearby: Nearby, rows: npt.NDArray[np.intp], duration: Array, longest: Array
) -> npt.NDArray[np.intp]:
    """Follows the members ``rows`` of a search until they have arrived, or the time ``longest`` (members,) ends, and
    where chaos takes part the starts nearby, all of them together for as long; the members still under way."""
    if not rows.size:
        return rows
    together = np.maximum(longest / (STARTS - 1), duration)
    search.begin(rows, duration, 0.2)
    going = search.follow(search.under_way(rows), duration, np.minimum(together, longest), 0.1)
    chaotic = rows[np.isfinite(nearby.apart[rows]) | np.isin(rows, going)]
    search.advance(chaotic, slice(1, STARTS), duration, 0.1)
    until, rounds = duration, doublings(duration[chaotic], together[chaotic])
    for _ in range(rounds):
        until = np.minimum(2.0 * until, together)
        search.advance(chaotic, slice(1, STARTS), until, 0.2 / rounds)
    return search.follow(_ending_nowhere(search, nearby, going), together, longest, 0.2)


def _ending_nowhere(search: Search, nearby: Nearby, rows: npt.NDArray[np.intp]) -> npt.NDArray[np.intp]:
    """Those of ``rows``, all under way, of which no nearby start shows what they will end in.

    Where most of the starts end stands for the motion. Not where those that have not ended seem to persist.
    """
    tried = rows[np.isfinite(nearby.apart[rows]) & ~nearby.persists()[rows]]
    for _ in range(FATES):
        tried = tried[nearby.escaped[tried].any(axis=1)]
        if not tried.size:
            break
        start = np.array([nearby.fates(int(row))[0][0] for row in tried])
        going = search.under_way(tried, start)
        rows, tried = rows[~np.isin(rows, np.setdiff1d(tried, going))], going
    again = rows[search.start[rows] > 0]
    search.start[again] = 0
    search.cycles.put(again, Cycles.blank(again.size, states=search.cycles.point.shape[1]))
    return rows


def chaos_of(nearby: Nearby, rows: npt.NDArray[np.intp], attraction: Array) -> dict[str, npt.NDArray[Any]]:
    """Lifetimes of the chaos of the members ``rows``, and where their starts end, by the names of the evidence.

    ``attraction`` (members,) is the rate at which they settle once chaos has ended.
    """
    times = nearby.times(SETTLING / np.maximum(attraction, FLOOR))[rows]
    escaped, valid = nearby.escaped[rows], nearby.outcome[rows] == Outcome.OK
    ended, count = (escaped & valid).sum(axis=1), valid.sum(axis=1)
    lasting = lifetimes(ended, np.where(valid, times, 0.0).sum(axis=1))
    fates = np.array([_fates(int(row), nearby) for row in rows]).reshape(rows.size, FATES, 3)
    return {
        "lifetime": lasting.mean,
        "lifetime_low": lasting.low,
        "lifetime_high": lasting.high,
        "followed": count,
        "share_chaotic": 1.0 - ended / count,
        "seen_until": np.minimum(nearby.ended, nearby.followed)[rows, 0],
        "coexisting": nearby.persists()[rows],
        "fate_regime": fates[..., 0],
        "fate_period": fates[..., 1],
        "fate_share": fates[..., 2] / count[:, None],
    }


def _fates(row: int, nearby: Nearby) -> list[tuple[int, int, int]]:
    """Regime, period and number of the starts of one member that end alike, the most frequent first, (`FATES`, 3)."""
    found: list[tuple[int, int, int]] = []
    for group in nearby.fates(row):
        still = float((nearby.highest[row, group[0]] - nearby.lowest[row, group[0]]).max()) < REST_TOLERANCE
        period = 0 if still else int(nearby.period[row, group[0]])
        found.append((Regime.REST if still else Regime.PERIODIC, period, group.size))
    left = int(((nearby.outcome[row] == Outcome.OK) & ~nearby.escaped[row]).sum())
    found += [(Regime.CHAOTIC, 0, left)] * (left > 0) + [(-1, 0, 0)] * FATES
    return sorted(found, key=lambda fate: -fate[2])[:FATES]
