"""Ranges of the frequency in which the sweeps up and down differ, and the jumps at their ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.motion.attractor.cycle import REST_TOLERANCE
from gelcone.motion.stepping import NEGLIGIBLE, SURE, Falls, continued
from gelcone.motion.swing import Swing, settled_swing
from gelcone.physics.members import Members
from gelcone.progress import Progress, advance
from gelcone.quantity import Array

BRANCHES = ("up", "down")
"""Directions of the sweeps."""
DIFFERENT = 0.02
"""Difference of the strokes of the sweeps, over the larger one, at which the sweeps differ."""
NARROWINGS_OF_JUMPS = 12
"""Steps towards the frequency at which a motion jumps; one that is too long is halved."""


@dataclass(frozen=True)
class Jumps:
    """Jumps of the sweeps at the ends of the ranges in which they differ, arrays (jumps,): ``member``, index of the
    ``branch`` that jumps, the frequencies between which it does, and its amplitude ``before`` and ``after``."""

    member: npt.NDArray[np.intp]
    branch: npt.NDArray[np.intp]
    low: Array
    high: Array
    before: Array
    after: Array


def differing(swept: Swing) -> npt.NDArray[np.bool_]:
    """Mask (members, steps) of different motions on the two sweeps (members, branches, steps). Two chaotic motions do
    not count, since their strokes always differ."""
    largest = np.nanmax(swept.amplitude, initial=0.0)
    return _differ(swept.take((slice(None), 0)), swept.take((slice(None), 1)), largest)


def _differ(up: Swing, down: Swing, largest: float = 0.0) -> npt.NDArray[np.bool_]:
    higher = np.fmax(up.amplitude, down.amplitude)
    apart = np.abs(up.amplitude - down.amplitude) > DIFFERENT * higher
    apart &= higher > max(NEGLIGIBLE * largest, REST_TOLERANCE)
    return np.asarray(apart & ((up.period != 0) | (down.period != 0)))


def jumps_of_sweeps(
    model: Members, grid: Array, swept: Swing, falls: Falls, progress: Progress, search: dict[str, Any]
) -> Jumps:
    """Both ends of each range in which the sweeps differ, narrowed down by following both motions outwards from the
    last place before the jump.

    The sweep down jumps at the lower end of the range, the sweep up at its upper end. The ends of all frequencies do
    not count.
    """
    differ = differing(swept)
    change = np.diff(differ.astype(int), axis=1)
    member, edge = np.nonzero(change)
    begins = change[member, edge] > 0
    branch = np.where(begins, BRANCHES.index("down"), BRANCHES.index("up"))
    inside, outside = np.where(begins, edge + 1, edge), np.where(begins, edge, edge + 1)
    flat = member * len(BRANCHES) + branch
    jumping, other = swept.take((member, branch, inside)), swept.take((member, 1 - branch, inside))
    ensemble, largest = model.take(member), np.fmax(jumping.amplitude, other.amplitude)
    inner, outer = grid[member, inside], grid[member, outside].copy()
    last, fall = outer.copy(), falls.take((flat, outside))
    fell = np.flatnonzero(~np.isnan(fall.start))
    if fell.size:
        there = ensemble.take(fell).replace(drive_frequency=fall.start[fell])
        now, persists = continued(there, fall.before.take(fell), largest[fell], search)
        fell, now = fell[persists], now.take(persists)
        inner[fell], outer[fell] = fall.start[fell], fall.end[fell]
        jumping.put(fell, now)
    step = 0.5 * (outer - inner)
    before, after = jumping.amplitude, other.amplitude
    for _ in range(NARROWINGS_OF_JUMPS if member.size else 0):
        tried = ensemble.replace(drive_frequency=inner + step)
        now, persists = continued(tried, jumping, largest, search)
        opposite = settled_swing(tried, other.final, only_extent=True, **search)
        apart = persists & _differ(now, opposite)
        inner, step = np.where(apart, inner + step, inner), np.where(apart, step, 0.5 * step)
        jumping.put(apart, now.take(apart))
        other.put(apart, opposite.take(apart))
        before, after = jumping.amplitude, other.amplitude
    outer = np.where(np.abs(SURE * step) < np.abs(last - inner), inner + SURE * step, last)
    advance(progress, 1.0)
    return Jumps(member, branch, np.minimum(inner, outer), np.maximum(inner, outer), before, after)


def jump_variables(jumps: Jumps, ensemble: bool) -> dict[str, Any]:
    """The variables of jumps, over ``jump``; of an ``ensemble`` with its member."""
    table: dict[str, tuple[Any, str, dataset.Of]] = {
        "jump_branch": (np.array(BRANCHES)[jumps.branch], "sweep that jumps", "code"),
        "jump_low": (jumps.low, "lower end of the interval of the frequency of the jump", "frequency"),
        "jump_high": (jumps.high, "upper end of the interval of the frequency of the jump", "frequency"),
        "jump_from": (2.0 * jumps.before, "stroke before the jump, peak to peak", "length"),
        "jump_to": (2.0 * jumps.after, "stroke after the jump, peak to peak", "length"),
    }
    if ensemble:
        table["jump_member"] = jumps.member, "member of the ensemble that jumps", "count"
    return dataset.columns("jump", table)
