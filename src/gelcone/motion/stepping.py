"""Stepping along settled motions in frequency: where a motion jumps, the step is halved until the jump is bracketed.

The basin of a motion that ends at a fold shrinks towards the fold, so that a large step leaves it too early. Where the
motion has changed, its cycle is therefore computed by Newton's method. As long as the cycle exists and attracts, the
motion continues on it, as in a sweep without noise that is slow enough. Steps are so short that the motion hardly
changes; it jumps where even the smallest step changes it and the cycle has ended.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.motion.attractor.cycle import find_cycles
from gelcone.motion.attractor.search import integration
from gelcone.motion.start import nudge
from gelcone.motion.swing import Swing, settled_swing, swing_of
from gelcone.physics.members import Members
from gelcone.progress import Progress, advance
from gelcone.quantity import Array

NUDGE = 1e-4
"""Displacement by which each step moves the state, so that it leaves a motion that has become unstable."""
JUMPED = 0.2
"""Change of the amplitude or the middle of a motion, over its amplitude, at which it has jumped."""
NEGLIGIBLE = 1e-3
"""Share of the largest amplitude so far below which changes are negligible, and strokes equal."""
FINEST = 2.0**-7
"""The smallest step, over the distance between two given frequencies."""
SURE = 4.0
"""Steps within which a motion ends if Newton's method does not follow it over one step, since the method follows over a
larger share of the way to a fold."""
MOST_STEPS = 64
"""Most tries to reach a given frequency."""
ALMOST = 1.0 - 1e-9
"""Share of the way to the next given frequency from which on a step goes there."""


@dataclass
class Trail:
    """The settled motions met on the way, step by step: ``frequency``, ``amplitude``, ``period`` (steps, members) and
    ``final`` states (steps, members, N); NaN and 0 for members that did not move."""

    frequency: list[Array] = field(default_factory=list)
    amplitude: list[Array] = field(default_factory=list)
    period: list[npt.NDArray[np.int64]] = field(default_factory=list)
    final: list[Array] = field(default_factory=list)

    def add(self, rows: npt.NDArray[np.intp], frequency: Array, met: Swing, count: int) -> None:
        """Adds the motions that ``rows`` of ``count`` members met at their frequencies."""
        blank = Swing.blank(count, states=met.final.shape[1])
        blank.put(rows, met)
        self.frequency.append(np.full(count, np.nan))
        self.frequency[-1][rows] = frequency
        self.amplitude.append(blank.amplitude)
        self.period.append(blank.period)
        self.final.append(blank.final)

    def sorted(self) -> tuple[Array, Array, npt.NDArray[np.int64], Array]:
        """The trail as arrays (members, steps, ...), by rising frequency of each member, padded with NaN."""
        order = np.argsort(np.stack(self.frequency, axis=1), axis=1, kind="stable")
        rows = np.arange(len(order))[:, None]
        frequency, amplitude, final = (
            np.stack(part, axis=1)[rows, order] for part in (self.frequency, self.amplitude, self.final)
        )
        return frequency, amplitude, np.stack(self.period, axis=1)[rows, order], final


@dataclass(frozen=True)
class Falls:
    """The last jump on the way to each frequency (members, steps): between the frequencies ``start``, with the motion
    ``before``, and ``end``; NaN where there is none."""

    start: Array
    end: Array
    before: Swing

    def take(self, where: Any) -> Falls:
        """The jumps of some members and steps."""
        return Falls(self.start[where], self.end[where], self.before.take(where))


@dataclass(frozen=True)
class Walk:
    """The motions ``reached`` at each frequency (members, steps), their ``falls`` and the ``trail`` on the way."""

    reached: Swing
    falls: Falls
    trail: Trail


def walk(model: Members, grids: Array, initial: Array, progress: Progress, search: dict[str, Any]) -> Walk:
    """The settled motions at frequencies ``grids`` (members, steps), each reached from the one before, with their
    extent alone.

    A member starts from ``initial`` (members, N), and again after a motion that failed. Members take steps of their own
    and are integrated together, which does not change a bit of them.
    """
    count, steps = grids.shape
    blank = Swing.blank(*grids.shape, states=initial.shape[1])
    reached, trail = blank.take(...), Trail()
    falls = Falls(np.full(grids.shape, np.nan), np.full(grids.shape, np.nan), blank)
    now = Swing.blank(count, states=initial.shape[1])
    place, tries, fresh = np.zeros(count, dtype=int), np.zeros(count, dtype=int), np.ones(count, dtype=bool)
    at, step, distance, largest = (np.zeros(count) for _ in range(4))
    while (active := np.flatnonzero(place < steps)).size:
        there = grids[active, place[active]]
        rest = there - at[active]
        pace = np.where(np.abs(step[active]) < ALMOST * np.abs(rest), step[active], rest)
        fresh_ones, spent = fresh[active], tries[active] == MOST_STEPS
        last = fresh_ones | spent | (pace == rest)
        target = np.where(last, there, at[active] + pace)
        before, members = now.take(active), model.take(active).replace(drive_frequency=target)
        tried, changed = _tried(members, before, initial[active], fresh_ones, largest[active], search)
        tries[active] += 1
        finest = np.abs(pace) <= FINEST * distance[active]
        far = changed & ~finest & ~spent
        step[active] = np.where(far, 0.5, 2.0) * pace
        fell = np.flatnonzero(changed & ~far)
        ways = active[fell], place[active[fell]]
        start = at[active[fell]]
        falls.start[ways], falls.end[ways] = start, start + SURE * (target[fell] - start)
        falls.before.put(ways, before.take(fell))
        arrived = active[~far]
        now.put(arrived, tried.take(~far))
        at[arrived] = target[~far]
        trail.add(arrived, at[arrived], now.take(arrived), count)
        # After a jump the motion is a new one, with steps as long as at first.
        step[active[fell]] = there[fell] - target[fell]
        done = active[~far & (last | (now.outcome[active] != Outcome.OK))]
        reached.put((done, place[done]), now.take(done))
        largest[done] = np.fmax(largest[done], now.amplitude[done])
        at[done] = grids[done, place[done]]
        fresh[done] = now.outcome[done] != Outcome.OK
        place[done] += 1
        tries[done] = 0
        more = done[place[done] < steps]
        step[more] = grids[more, place[more]] - at[more]
        distance[more] = np.abs(step[more])
        if done.size:
            advance(progress, done.size / grids.size)
    return Walk(reached, falls, trail)


def _tried(
    members: Members,
    before: Swing,
    initial: Array,
    fresh: npt.NDArray[np.bool_],
    largest: Array,
    search: dict[str, Any],
) -> tuple[Swing, npt.NDArray[np.bool_]]:
    """Motions reached from those ``before``, or from ``initial`` where ``fresh``; and the mask of those that have
    jumped."""
    starts = np.where(fresh[:, None], initial, nudge(before.final, NUDGE))
    tried = settled_swing(members, starts, only_extent=True, **search)
    changed = ~fresh & jumped(before, tried, largest)
    rows = np.flatnonzero(changed)
    if rows.size:
        cycle_rows, on_cycles = on_their_cycles(members.take(rows), before.take(rows), search)
        at = rows[cycle_rows]
        # where the cycle near the motion before equals the motion now, it has changed without a jump
        apart = jumped(before.take(at), on_cycles, largest[at]) & jumped(tried.take(at), on_cycles, largest[at])
        tried.put(at[~apart], on_cycles.take(~apart))
        changed[at] = apart
    return tried, changed


def carried(members: Members, before: Swing, largest: Array, search: dict[str, Any]) -> Swing:
    """Motions reached from those ``before`` at frequencies nearby, with their extent alone."""
    return _tried(members, before, before.final, np.zeros(members.size, dtype=bool), largest, search)[0]


def continued(
    members: Members, before: Swing, largest: Array, search: dict[str, Any]
) -> tuple[Swing, npt.NDArray[np.bool_]]:
    """Continuations of the motions ``before``, and the mask of those that persist: a periodic one if its cycle exists
    and attracts. (The motion itself does not show it: just past a fold it stays so long near the former cycle that it
    seems to have settled.)"""
    now, persists = before.take(...), before.period == 0
    cycling, others = np.flatnonzero(~persists), np.flatnonzero(persists)
    if cycling.size:
        cycle_rows, on_cycles = on_their_cycles(members.take(cycling), before.take(cycling), search)
        at = cycling[cycle_rows]
        same = ~jumped(before.take(at), on_cycles, largest[at])
        now.put(at[same], on_cycles.take(same))
        persists[at[same]] = True
    if others.size:
        now.put(others, settled_swing(members.take(others), before.final[others], only_extent=True, **search))
    return now, persists


def on_their_cycles(members: Members, before: Swing, search: dict[str, Any]) -> tuple[npt.NDArray[np.intp], Swing]:
    """Indices of the motions with an attracting cycle near the one ``before``, and the motions on these cycles."""
    cycles = find_cycles(members, before.final, before.period, **integration(search))
    rows = np.flatnonzero(cycles.sign < 0)
    swings = swing_of(
        members.take(rows), cycles.take(rows), before.final[rows], only_extent=True, **integration(search)
    )
    ran = swings.outcome == Outcome.OK
    return rows[ran], swings.take(ran)


def jumped(one: Swing, other: Swing, largest: Array) -> npt.NDArray[np.bool_]:
    """Mask of the periodic motions from which the ``other`` differs by more than a small step explains, or is not
    periodic; False where one failed."""
    size = np.fmax(one.amplitude, other.amplitude)
    change = np.fmax(np.abs(one.amplitude - other.amplitude), np.abs(one.middle - other.middle))
    with np.errstate(invalid="ignore"):
        apart = change > np.fmax(JUMPED * size, NEGLIGIBLE * np.fmax(largest, size))
        lost = (other.period == 0) & (other.outcome == Outcome.OK)
    return np.asarray((apart | lost) & (one.period > 0))
