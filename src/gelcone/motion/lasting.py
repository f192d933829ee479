"""Does it last? Nearby starts, followed side by side: how many are still chaotic, and where the others have ended.

Chaos that ends looks like chaos that lasts until it does. Starts that no measurement tells apart (`NEARBY`) follow
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

from gelcone.codes import Outcome
from gelcone.motion.course import AWAY, RETURN, SMALLEST_SIZE, course
from gelcone.physics.members import Members
from gelcone.quantity import Array

STARTS = 16
"""Starts followed side by side, the motion's own among them."""
NEARBY = 1e-9
"""Distance of the others from the motion's own start, in displacement or velocity."""
SAME = 1e-3
"""Cycles are one when their lowest and highest points agree to this share of their size."""
SETTLING = np.log(1.0 / AWAY)
"""A motion comes within `AWAY` of a cycle in so many times over its rate of attraction, and from there returns."""
assert RETURN == AWAY**2
CONFIDENCE = 0.95
EARLY, MISSED = 0.25, 3.0
"""Chaos that persists beside an attractor loses starts to it at first only: none have ended in the last three quarters
of the time in which at least three would have at the pace of the first."""


@dataclass(frozen=True)
class Nearby:
    """Starts side by side, as far as they were followed; arrays (members, `STARTS`, ...), the motion's own start first.

    ``state`` (members, starts, N) now, at phase 0; ``followed`` so long; ``ended``, the time at which a start had
    settled (infinite: not yet), on a cycle of ``period`` forcing periods between ``lowest`` and ``highest`` (both of
    the states at two phases of the drive); the ``outcome``. ``apart`` (members,) is when chaos had pulled them apart.
    """

    state: Array
    followed: Array
    ended: Array
    period: npt.NDArray[np.int64]
    lowest: Array
    highest: Array
    outcome: npt.NDArray[np.int8]
    gap: Array
    apart: Array

    @classmethod
    def at(cls, states: Array) -> Nearby:
        """Starts around ``states`` (members, N), of which displacement and velocity differ by `NEARBY`."""
        count, size = states.shape
        angles = 2.0 * np.pi * np.arange(STARTS - 1) / (STARTS - 1)
        around = np.zeros((STARTS, size))
        around[1:, 0], around[1:, 1] = NEARBY * np.cos(angles), NEARBY * np.sin(angles)
        shape = (count, STARTS)
        return cls(
            state=states[:, None] + around,
            followed=np.zeros(shape),
            ended=np.full(shape, np.inf),
            period=np.zeros(shape, dtype=np.int64),
            lowest=np.full((*shape, 2 * size), np.nan),
            highest=np.full((*shape, 2 * size), np.nan),
            outcome=np.zeros(shape, dtype=np.int8),
            gap=np.full(shape, np.nan),
            apart=np.full(count, np.inf),
        )

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
        """Follows some ``starts`` of the members ``rows`` that have not ended to the time ``until`` (members,), or a
        little longer: to whole forcing periods. ``compared`` from their beginning, they tell when they came apart."""
        part, columns = np.broadcast_arrays(rows[:, None], np.arange(STARTS)[starts])
        left = np.rint((until[part] - self.followed[part, columns]) / members.forcing_period[part] + 0.4999)
        going = np.isinf(self.ended[part, columns]) & (self.outcome[part, columns] == Outcome.OK) & (left >= 1.0)
        abreast = part.shape[1] if compared else 1
        row, column, repeats = part[going], columns[going], left[going].astype(np.int64)
        if not row.size:
            return
        some = members.take(row)
        run, apart = course(some, self.state[row, column], repeats, abreast=abreast, **flow_options)
        settled = run.period > 0
        self.ended[row, column] = np.where(settled, self.followed[row, column] + run.away, np.inf)
        self.followed[row, column] += repeats * some.forcing_period
        self.state[row, column], self.outcome[row, column] = run.final, run.outcome
        self.period[row, column], self.gap[row, column] = run.period, run.gap
        self.lowest[row, column], self.highest[row, column] = run.lowest, run.highest
        np.minimum.at(self.apart, row, apart)

    def times(self, settling: Array | float = 0.0) -> Array:
        """How long each start was chaotic, (members, starts), from when they had come apart.

        From the end of chaos to within `AWAY` of a cycle a motion takes the time ``settling`` (members,), and as long
        again until it is seen to return: the time of one that has not ended counts up to twice that before.
        """
        since = np.where(np.isfinite(self.apart), self.apart, 0.0)[:, None]
        lag = np.broadcast_to(settling, self.apart.shape)[:, None]
        chaotic = np.where(self.escaped, self.ended - lag, self.followed - 2.0 * lag)
        return np.asarray(np.maximum(chaotic - since, 0.0))

    @property
    def escaped(self) -> npt.NDArray[np.bool_]:
        """The starts that have settled, (members, starts)."""
        return np.isfinite(self.ended)

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
