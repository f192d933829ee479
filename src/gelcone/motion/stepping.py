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

    def take_over(self, rows: npt.NDArray[np.intp], count: int, other: Trail) -> None:
        """What another trail holds of ``rows`` of so many members."""
        for kept, columns in ((self.frequency, other.frequency), (self.amplitude, other.amplitude)):
            for values in columns:
                kept.append(np.full(count, np.nan))
                kept[-1][rows] = values
        for final in other.final:
            self.final.append(np.full((count, final.shape[1]), np.nan))
            self.final[-1][rows] = final

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


def step_to(
    model: Members, here: Array, there: Array, met: Swing, largest: Array, trail: Trail, flow: dict[str, Any]
) -> Swing:
    """The settled motions at the frequencies ``there`` (members,), reached from those ``met`` at ``here``; their extent
    alone (`gelcone.motion.settled.extent`).

    ``largest`` amplitudes so far (members,) tell what change is negligible; all that is met goes to the ``trail``.
    """
    count = model.size
    now, at = met.take(np.arange(count)), here.copy()
    step, least = there - here, FINEST * np.abs(there - here)
    going = np.arange(count)
    for _ in range(MOST_STEPS):
        rest = there[going] - at[going]
        next_step = np.where(np.abs(step[going]) < np.abs(rest), step[going], rest)
        target = np.where(next_step == rest, there[going], at[going] + next_step)
        before = now.take(going)
        nudged = nudge(before.final, NUDGE)
        tried = settled_swing(model.take(going).replace(drive_frequency=target), nudged, only_extent=True, **flow)
        trail.add(going, count, target, tried)
        far = jumped(before, tried, largest[going]) & (np.abs(next_step) > least[going])
        step[going] = np.where(far, 0.5 * next_step, step[going])
        gone = going[~far]
        now.put(gone, tried.take(~far))
        at[gone] = target[~far]
        # A fallen motion is a new one, along which the steps are as long as at first.
        fell = going[~far & (np.abs(next_step) <= least[going])]
        step[fell] = there[fell] - at[fell]
        going = going[(at[going] != there[going]) & (now.outcome[going] == Outcome.OK)]
        if not going.size:
            return now
    nudged = nudge(now.final[going], NUDGE)
    last = settled_swing(model.take(going).replace(drive_frequency=there[going]), nudged, only_extent=True, **flow)
    now.put(going, last)
    return now


def jumped(one: Swing, other: Swing, largest: Array) -> npt.NDArray[np.bool_]:
    """Whether periodic motions differ by more than a small step explains; not where one is chaotic or failed."""
    size = np.fmax(one.amplitude, other.amplitude)
    change = np.fmax(np.abs(one.amplitude - other.amplitude), np.abs(one.middle - other.middle))
    with np.errstate(invalid="ignore"):
        apart = change > np.fmax(JUMPED * size, NEGLIGIBLE * np.fmax(largest, size))
    return np.asarray(apart & (one.period > 0) & (other.period > 0))
