"""Lifetime of chaos, from nearby starts: how many are still chaotic, and which attractors the others have reached.

Transient chaos looks like lasting chaos until it ends. Starts too close for any measurement to distinguish (`NEARBY`)
become independent once chaos has separated them. Chaos ends at the same rate at any time: lifetimes are exponential,
those that have not ended are censored, and the mean is the total time of all starts over the number that have ended,
with an interval from the chi-square distribution (Lai and Tel, Transient Chaos (2011), chapter 1; Epstein and Sobel, J.
Am. Stat. Assoc. 48 (1953) 486).
"""

from __future__ import annotations

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
"""Starts followed together, that of the motion itself among them."""
SAME = 1e-3
"""Largest difference of the lowest and highest points of equal cycles, over their size."""
SETTLING = np.log(1.0 / AWAY)
"""Time in which a motion comes within `AWAY` of a cycle, times its rate of attraction."""
FATES = 3
"""Largest number of attractors that are distinguished among those that nearby starts end on."""
EARLY, MISSED = 0.25, 3.0
"""Share of the time in which chaos that coexists with an attractor loses starts to it, and the least number of starts
that would end in the rest of the time at the same rate, although none did."""


class Nearby(Starts):
    """Nearby starts: how long each was chaotic, and the attractors that they end on."""

    def times(self, settling: Array | float = 0.0) -> Array:
        """Time for which each start was chaotic, (members, starts), since the starts had separated.

        From the end of chaos a motion takes the time ``settling`` (members,) to within `AWAY` of a cycle, and as long
        again until it is observed to return: a start that has not returned counts only up to twice that time earlier.
        """
        since = np.where(np.isfinite(self.apart), self.apart, 0.0)[:, None]
        lag = np.broadcast_to(settling, self.apart.shape)[:, None]
        chaotic = np.where(self.escaped, self.ended - lag, self.followed - 2.0 * lag)
        return np.asarray(np.maximum(chaotic - since, 0.0))

    def persists(self) -> npt.NDArray[np.bool_]:
        """Mask (members,): some starts ended early, and later fewer than that rate makes likely."""
        times = self.times()
        early = EARLY * times[:, 1:].max(axis=1, keepdims=True)
        soon = (self.escaped & (times <= early)).sum(axis=1)
        late = (self.escaped & (times > early)).sum(axis=1)
        before, after = np.minimum(times, early).sum(axis=1), np.maximum(times - early, 0.0).sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray((late == 0) & (soon > 0) & (soon * after / before > MISSED))

    def fates(self, row: int) -> list[npt.NDArray[np.intp]]:
        """Groups the ended starts of one member by the cycle that they ended on, the most frequent first."""
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


def lifetimes(ended: npt.NDArray[Any], time: Array) -> tuple[Array, Array, Array]:
    """Mean lifetimes of chaos (members,) from the number of starts that have ``ended`` and the total ``time`` of all
    starts, and the lower and upper end of their interval.

    The interval, of `CONFIDENCE`, is exact for a time fixed in advance; mean and upper end are infinite if none has
    ended.
    """
    if not time.size:  # saves the import
        return time, time, time
    from scipy.special import chdtri

    outside = 0.5 * (1.0 - CONFIDENCE)
    with np.errstate(divide="ignore", invalid="ignore"):
        low = 2.0 * time / chdtri(2.0 * ended + 2.0, outside)
        high = np.where(ended > 0, 2.0 * time / chdtri(2.0 * np.maximum(ended, 1), 1.0 - outside), np.inf)
        return np.where(ended > 0, time / ended, np.inf), low, high


# --- starts nearby ----------------------------------------------------------------------------------------------------


def follow_starts(
    search: Search, nearby: Nearby, rows: npt.NDArray[np.intp], duration: Array, longest: Array
) -> npt.NDArray[np.intp]:
    """Follows the members ``rows`` of a search until they arrive, at most for ``longest`` (members,), and returns
    those that have not. The nearby starts of chaotic members are followed for as long, all together."""
    if not rows.size:
        return rows
    together = np.maximum(longest / (STARTS - 1), duration)
    search.begin(rows, duration, 0.2)
    unsettled = search.follow(search.under_way(rows), duration, np.minimum(together, longest), 0.1)
    chaotic = rows[np.isfinite(nearby.apart[rows]) | np.isin(rows, unsettled)]
    search.advance(chaotic, slice(1, STARTS), duration, 0.1)
    until, rounds = duration, doublings(duration[chaotic], together[chaotic])
    for _ in range(rounds):
        until = np.minimum(2.0 * until, together)
        search.advance(chaotic, slice(1, STARTS), until, 0.2 / rounds)
    return search.follow(_without_fate(search, nearby, unsettled), together, longest, 0.2)


def _without_fate(search: Search, nearby: Nearby, rows: npt.NDArray[np.intp]) -> npt.NDArray[np.intp]:
    """Those ``rows``, all under way, whose attractor no nearby start shows.

    The most frequent attractor of the nearby starts counts as that of the motion, unless the others seem to persist.
    """
    tried = rows[np.isfinite(nearby.apart[rows]) & ~nearby.persists()[rows]]
    for _ in range(FATES):
        tried = tried[nearby.escaped[tried].any(axis=1)]
        if not tried.size:
            break
        start = np.array([nearby.fates(int(row))[0][0] for row in tried])
        unsettled = search.under_way(tried, start)
        rows, tried = rows[~np.isin(rows, np.setdiff1d(tried, unsettled))], unsettled
    again = rows[search.start[rows] > 0]
    search.start[again] = 0
    search.cycles.put(again, Cycles.blank(again.size, states=search.cycles.point.shape[1]))
    return rows


def chaos_of(
    nearby: Nearby, rows: npt.NDArray[np.intp], attraction: Array, chaotic: npt.NDArray[np.bool_]
) -> dict[str, npt.NDArray[Any]]:
    """Lifetimes of the chaos of the members ``rows`` and attractors of their starts, by the names of the evidence.

    ``attraction`` (members,) is the rate at which they settle once chaos has ended, ``chaotic`` the mask of the members
    whose own motion is. Of others a start that may have been settling ever since it separated shows no chaos,
    and is not counted; without any evidence the lifetime is NaN.
    """
    times = nearby.times(SETTLING / np.maximum(attraction, FLOOR))[rows]
    escaped, valid = nearby.escaped[rows], nearby.outcome[rows] == Outcome.OK
    still_chaotic = (valid & ~escaped & (chaotic[rows, None] | (times > 0.0))).sum(axis=1)
    ended = (escaped & valid).sum(axis=1)
    count = ended + still_chaotic
    estimates = lifetimes(ended, np.where(valid, times, 0.0).sum(axis=1))
    mean, low, high = (np.where(estimates[0] > 0.0, values, np.nan) for values in estimates)
    fates = np.array([_fates(int(row), nearby, int(n)) for row, n in zip(rows, still_chaotic, strict=True)])
    fates = fates.reshape(rows.size, FATES, 3)
    with np.errstate(invalid="ignore"):
        share_chaotic, fate_share = still_chaotic / count, fates[..., 2] / count[:, None]
    return {
        "lifetime": mean,
        "lifetime_low": low,
        "lifetime_high": high,
        "followed": count,
        "share_chaotic": share_chaotic,
        "chaotic_until": np.minimum(nearby.ended, nearby.followed)[rows, 0],
        "coexisting": nearby.persists()[rows],
        "fate_regime": fates[..., 0],
        "fate_period": fates[..., 1],
        "fate_share": fate_share,
    }


def _fates(row: int, nearby: Nearby, left: int) -> list[tuple[int, int, int]]:
    """Regime, period and number of starts of each attractor of one member, the most frequent first, (`FATES`, 3), with
    the number ``left`` of those that are still chaotic."""
    fates: list[tuple[int, int, int]] = []
    for group in nearby.fates(row):
        still = float((nearby.highest[row, group[0]] - nearby.lowest[row, group[0]]).max()) < REST_TOLERANCE
        period = 0 if still else int(nearby.period[row, group[0]])
        fates.append((Regime.REST if still else Regime.PERIODIC, period, group.size))
    fates += [(Regime.CHAOTIC, 0, left)] * (left > 0) + [(-1, 0, 0)] * FATES
    return sorted(fates, key=lambda fate: -fate[2])[:FATES]
