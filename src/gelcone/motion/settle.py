"""Runs over whole forcing periods, and clocks that divide these into stretches.

The forcing is the same in each period, so the clock of a run is set back to 0 at whole periods: the phase is as exact
after a million periods as in the first. In names of functions and results a *repeat* is one forcing period.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.errors import InputError
from gelcone.motion.flow import integrate
from gelcone.physics.members import Members
from gelcone.progress import Progress, weighted
from gelcone.quantity import Array, check_count

CLOCK_REPEATS = 1000
"""Most forcing periods between two returns of the clock to 0."""
CLOCK_SAMPLES = 8192
"""Most samples between two returns of the clock; bounds the memory."""
MOST_PER_REPEAT = 2**16
MOST_STRETCHES = 2**18
"""Most stretches of tangent maps in a forcing period; bounds the memory."""
BLOCK_SAMPLES = 2**22
"""Most samples of an ensemble held at once; larger ensembles are run in blocks of members."""
STRETCH = 16.0
"""Length of a tangent map, in fastest time scales: deviations grow so little that neither the step control nor their
volume loses digits."""
LONG_STRETCH = 64.0
"""Length of a tangent map from which only the largest growth is taken; the volume may be lost to rounding."""
BLOCK = 64.0
"""Shortest block of an average, longer than the correlation time of chaotic motions."""
STILL = 1e-12
"""Largest motion (in units of b-a and 1/Omega0) that counts as rounding."""
LONGEST_TIME = 1e9
"""Longest time of a run: half an hour of computing for a taut film, some hours for a membrane."""
FEWEST_SAMPLES, MOST_SAMPLES, PER_OSCILLATION = 2000, 40_000, 40
"""Fewest and most samples of a run under constant voltages, and samples of an oscillation at the fastest rate."""


# --- settling ---------------------------------------------------------------------------------------------------------


def check_budgets(**budgets: float | None) -> None:
    """Raises `InputError` for a time that is not positive or longer than `LONGEST_TIME`."""
    for name, value in budgets.items():
        if value is not None and not value > 0.0:
            raise InputError(f"{name} = {value:g}: must be positive; give a longer one")
        if value is not None and value > LONGEST_TIME:
            raise InputError(f"{name} = {value:g}: is longer than {LONGEST_TIME:g}; give a shorter one")


def check_default_duration(lasts: float, cause: str, remedy: str = "give a duration") -> None:
    """Raises `InputError` with ``cause`` and ``remedy`` for a default duration that is longer than `LONGEST_TIME`."""
    if lasts > LONGEST_TIME:
        raise InputError(f"{cause} last {lasts:.3g}, longer than {LONGEST_TIME:g}; {remedy}")


def times_of_run(members: Members, lasts: float) -> Array:
    """Even sample times from 0 to ``lasts`` of runs under constant voltages."""
    samples = np.clip(PER_OSCILLATION * float(members.rate.max()) * lasts / (2.0 * np.pi), FEWEST_SAMPLES, MOST_SAMPLES)
    return np.linspace(0.0, lasts, int(samples) + 1)


def check_forcing_periods(members: Members, least: int = 0, **repeats: int) -> None:
    """Raises `InputError` for a number of forcing periods below ``least``, or that lasts longer than `LONGEST_TIME` for
    every member; each counts as at least one unit of time, since it takes a step or more."""
    most = int(LONGEST_TIME / max(float(np.min(members.forcing_period)), 1.0))
    for name, count in repeats.items():
        check_count(name, count, least)
        if count > most:
            raise InputError(f"{name} = {count}: must be at most {most} forcing periods; lower it")


def repeats_lasting(members: Members, duration: Array | float) -> npt.NDArray[np.int64]:
    """The least number of forcing periods, (members,), that last at least ``duration``."""
    return np.ceil(duration / members.forcing_period).astype(np.int64)


def settle(
    members: Members, states: Array, repeats: int | npt.NDArray[np.int64], *, progress: Progress = None, **flow: Any
) -> tuple[Array, npt.NDArray[np.int8]]:
    """States (members, N) after ``repeats`` whole forcing periods, at phase 0 again, and the outcome of each member.

    ``repeats`` is a number or (members,); ``flow`` goes to `integrate`.
    """
    states, outcome = states.copy(), np.zeros(members.size, dtype=np.int8)
    left = np.broadcast_to(repeats, (members.size,)).copy()
    whole = int(left.sum())
    while (running := np.flatnonzero((left > 0) & (outcome == Outcome.OK))).size:
        step = np.minimum(left[running], CLOCK_REPEATS)
        part = members.take(running)
        share = weighted(progress, float(step.sum()) / whole)
        run = integrate(part, states[running], (step * part.forcing_period)[:, None], progress=share, **flow)
        states[running], outcome[running] = run.states[:, 0], run.outcome
        left[running] -= step
    return states, outcome


# --- sampled runs over whole forcing periods --------------------------------------------------------------------------


@dataclass(frozen=True)
class Piece:
    """Some forcing periods of a run.

    ``first`` period and number of periods ``repeats``; ``times`` (members, samples) since its beginning and ``states``
    (members, samples, N) there, the last sample at its end; ``outcome`` (members,) of the run so far.
    """

    first: int
    repeats: int
    times: Array
    states: Array
    outcome: npt.NDArray[np.int8]


def pieces(
    members: Members,
    states: Array,
    repeats: int,
    shares: Sequence[float] | Array,
    *,
    outcome: npt.NDArray[np.int8] | None = None,
    progress: Progress = None,
    **flow: Any,
) -> Iterator[Piece]:
    """Runs ``repeats`` forcing periods piece by piece, sampled at the given shares (0 to 1) of each period.

    ``states`` (members, N) are at phase 0; the clock of each piece starts at 0. ``outcome`` (members,) before the run;
    ``flow`` goes to `integrate`.
    """
    most = int(np.clip(CLOCK_SAMPLES // max(1, len(shares)), 1, CLOCK_REPEATS))
    outcome = np.zeros(members.size, dtype=np.int8) if outcome is None else outcome
    for first in range(0, repeats, most):
        count = min(most, repeats - first)
        ticks = np.append((np.arange(count)[:, None] + np.asarray(shares)).ravel(), count)
        times = ticks * members.forcing_period[:, None]
        run = integrate(members, states, times, progress=weighted(progress, count / repeats), **flow)
        # states of a failed member are NaN, from which `integrate` cannot start: its first outcome counts
        outcome = np.where(outcome == Outcome.OK, run.outcome, outcome)
        states = run.states[:, -1]
        yield Piece(first, count, run.times, run.states, outcome)


def samples_per_repeat(members: Members, per_oscillation: int) -> npt.NDArray[np.int64]:
    """Samples in a forcing period, (members,), at least ``per_oscillation`` in one at the fastest rate.

    A power of two from 16 to `MOST_PER_REPEAT`; it depends on the member alone, which is sampled alike in any ensemble.
    """
    oscillations = members.rate * members.forcing_period / (2.0 * np.pi)
    return np.minimum(next_power_of_two(np.maximum(per_oscillation * oscillations, 16.0)), MOST_PER_REPEAT)


LARGEST_POWER = 2.0**62


def next_power_of_two(least: Array) -> npt.NDArray[np.int64]:
    """The smallest power of two that is at least ``least``, at most `LARGEST_POWER`."""
    return 2 ** np.ceil(np.log2(np.minimum(least, LARGEST_POWER))).astype(np.int64)


def blocks(samples: npt.NDArray[np.int64], *keys: npt.NDArray[np.int64]) -> Iterator[tuple[Any, npt.NDArray[np.intp]]]:
    """Blocks of members with equal samples and keys: ((samples, *keys), indices of members).

    ``samples`` and ``keys`` are (members,). The size of a block bounds the memory.
    """
    for row, members in alike(samples, *keys):
        size = max(1, BLOCK_SAMPLES // max(row[0], CLOCK_SAMPLES))
        for first in range(0, members.size, size):
            yield row, members[first : first + size]


def alike(*keys: npt.NDArray[np.int64]) -> Iterator[tuple[tuple[int, ...], npt.NDArray[np.intp]]]:
    """Groups members by equal keys (members,): the keys, and the indices of the members."""
    rows, group = np.unique(np.stack(keys, axis=1), axis=0, return_inverse=True)
    for i, row in enumerate(rows.tolist()):
        yield tuple(row), np.flatnonzero(group.ravel() == i)


# --- clocks of tangent maps -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Clock:
    """Division of the time of each member into stretches.

    A forcing period has ``per_repeat`` stretches, or, if it is short, a stretch has ``repeats`` (members,) periods of
    length ``repeat`` (members,); a block of an average has ``block`` stretches, a whole number of periods.
    """

    per_repeat: int
    block: int
    repeat: Array
    repeats: Array

    @property
    def spacing(self) -> Array:
        """Length of a stretch, (members,)."""
        return self.repeat * self.repeats / self.per_repeat

    def take(self, index: Any) -> Clock:
        """The clock of some members."""
        return Clock(self.per_repeat, self.block, self.repeat[index], self.repeats[index])


def turns(members: Members, period: npt.NDArray[np.int64]) -> Iterator[tuple[npt.NDArray[np.intp], Clock, int]]:
    """Groups the members of a ``period`` (members,) of at least one forcing period by clock and period: the indices of
    each group, its clock, and the period."""
    for group, clock in clocks(members):
        for repeats in np.unique(period[group][period[group] > 0]).tolist():
            same = period[group] == repeats
            yield group[same], clock.take(same), repeats


def clocks(members: Members, stretch: float = STRETCH) -> list[tuple[npt.NDArray[np.intp], Clock]]:
    """Groups members by their stretches per period and per block: the indices of each group, and its clock.

    ``stretch`` is the longest, in fastest time scales; stretches are longer if a period would have more than
    `MOST_STRETCHES`.
    """
    repeat = members.forcing_period
    longest = stretch / members.fastest
    per_repeat = np.minimum(next_power_of_two(np.maximum(repeat / longest, 1.0)), MOST_STRETCHES)
    repeats = np.maximum(np.floor(longest / repeat), 1.0)
    block = per_repeat * np.ceil(BLOCK / (repeat * repeats)).astype(int)
    return [(group, Clock(key[0], key[1], repeat[group], repeats[group])) for key, group in alike(per_repeat, block)]
