"""Stepping along settled motions in frequency: where a motion jumps, the step is halved until the jump is bracketed.

A motion that ends at a fold has a basin that shrinks towards it, and a large step leaves it early. The way to the next
frequency is therefore gone in steps over which the motion hardly changes; only where even the smallest step changes it
does it jump.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.motion.settle import nudge
from gelcone.motion.settled import Swing, settled_swing
from gelcone.physics.members import Members
from gelcone.progress import Progress
from gelcone.quantity import Array

NUDGE = 1e-4
"""A step moves each state by this much, so that it leaves a motion that has become unstable."""
JUMPED = 0.2
"""A motion has jumped when its amplitude or its middle changed by this share of the amplitude."""
NEGLIGIBLE = 1e-3
"""Changes below this share of the largest amplitude so far are none."""
FINEST = 2.0**-7
"""The smallest step, as a share of the distance between two frequencies that were asked for."""
MOST_STEPS = 64


@dataclass
class Trail:
    """All settled motions met on the way, step by step: ``frequency``, ``amplitude`` (steps, members) and ``final``
    states (steps, members, N); NaN for members that did not move."""

    frequency: list[Array] = field(default_factory=list)
    amplitude: list[Array] = field(default_factory=list)
    final: list[Array] = field(default_factory=list)

    def add(self, rows: npt.NDArray[np.intp], count: int, frequency: Array, met: Swing) -> None:
        """What ``rows`` of so many members met at their frequencies."""
        columns = (np.full(count, np.nan), np.full(count, np.nan), np.full((count, met.final.shape[1]), np.nan))
        for kept, column, values in zip(
            (self.frequency, self.amplitude, self.final), columns, (frequency, met.amplitude, met.final), strict=True
        ):
            column[rows] = values
            kept.append(column)

    def sorted(self) -> tuple[Array, Array, Array]:
        """The same as arrays (members, steps, ...), each member by rising frequency, NaN at the end."""
        frequency = np.stack(self.frequency, axis=1)
        order = np.argsort(frequency, axis=1, kind="stable")
        amplitude, final = np.stack(self.amplitude, axis=1), np.stack(self.final, axis=1)
        return (
            np.take_along_axis(frequency, order, axis=1),
            np.take_along_axis(amplitude, order, axis=1),
            np.take_along_axis(final, order[..., None], axis=1),
        )


def walk(model: Members, grids: Array, initial: Array, progress: Progress, flow: dict[str, Any]) -> tuple[Swing, Trail]:
    """The settled motions at frequencies ``grids`` (members, steps), each reached from the one before; their extent
    alone (`gelcone.motion.settled.extent`). And all that was met on the way.

    A member begins from ``initial`` (members, N), and again where the motion before failed. Members go at their own
    pace and are settled together, which changes no bit of any.
    """
    count, steps = grids.shape
    found, trail = Swing.blank(*grids.shape, states=initial.shape[1]), Trail()
    now = Swing.blank(count, states=initial.shape[1])
    place, tries, fresh = np.zeros(count, dtype=int), np.zeros(count, dtype=int), np.ones(count, dtype=bool)
    at, step, distance, largest = (np.zeros(count) for _ in range(4))
    while (going := np.flatnonzero(place < steps)).size:
        there = grids[going, place[going]]
        rest = there - at[going]
        pace = np.where(np.abs(step[going]) < np.abs(rest), step[going], rest)
        free = fresh[going] | (tries[going] == MOST_STEPS)
        last = free | (pace == rest)
        target = np.where(last, there, at[going] + pace)
        before = now.take(going)
        begin = np.where(fresh[going, None], initial[going], nudge(before.final, NUDGE))
        tried = settled_swing(model.take(going).replace(drive_frequency=target), begin, only_extent=True, **flow)
        trail.add(going, count, target, tried)
        tries[going] += 1
        finest = np.abs(pace) <= FINEST * distance[going]
        far = ~free & ~finest & jumped(before, tried, largest[going])
        step[going[far]] = 0.5 * pace[far]
        gone = going[~far]
        now.put(gone, tried.take(~far))
        at[gone] = target[~far]
        # A fallen motion is a new one, along which the steps are as long as at first.
        fell = going[~far & finest]
        step[fell] = there[~far & finest] - at[fell]
        done = going[~far & (last | (now.outcome[going] != Outcome.OK))]
        found.put((done, place[done]), now.take(done))
        largest[done] = np.fmax(largest[done], now.amplitude[done])
        at[done] = grids[done, place[done]]
        fresh[done] = now.outcome[done] != Outcome.OK
        place[done] += 1
        tries[done] = 0
        more = done[place[done] < steps]
        step[more] = grids[more, place[more]] - at[more]
        distance[more] = np.abs(step[more])
        if progress is not None and done.size:
            progress(done.size / grids.size)
    return found, trail


def jumped(one: Swing, other: Swing, largest: Array) -> npt.NDArray[np.bool_]:
    """Whether periodic motions differ by more than a small step explains; not where one is chaotic or failed."""
    size = np.fmax(one.amplitude, other.amplitude)
    change = np.fmax(np.abs(one.amplitude - other.amplitude), np.abs(one.middle - other.middle))
    with np.errstate(invalid="ignore"):
        apart = change > np.fmax(JUMPED * size, NEGLIGIBLE * np.fmax(largest, size))
    return np.asarray(apart & (one.period > 0) & (other.period > 0))
