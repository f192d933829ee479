"""The tree of branches: every event is switched at, to a number of levels, and no branch is followed twice."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from gelcone.atlas.branches.branch import Branch, Ending, Event, EventKind, Walk, born_map
from gelcone.atlas.branches.event import Singular
from gelcone.atlas.branches.follow import follow
from gelcone.atlas.branches.point import SMALLEST, Metric, Point, at_value, between, shares_at
from gelcone.atlas.branches.switching import first_points
from gelcone.motion.orbit import Kind, Shooting
from gelcone.quantity import Array

SAME_ORBIT = 1e-6
"""Largest distance between the nodes of equal orbits, as a share of their size."""
SAME_EVENT = 1e-7
"""Largest difference between the values of equal events, as a share of the interval."""
MOST_BRANCHES = 200


@dataclass
class Tree:
    """Branches as they are found, and the events that are still to be switched at."""

    walk: Walk
    switch: int
    branches: list[Branch] = field(default_factory=list)
    waiting: deque[tuple[Event, int]] = field(default_factory=deque)

    def add(self, branch: Branch, level: int, parent: Event | None = None) -> int:
        """Adds a branch and returns its number."""
        number = len(self.branches)
        branch.level, branch.parent = level, parent
        self.branches.append(branch)
        for event in branch.events:
            event.branch = number
        for event in branch.events:
            if event.kind == EventKind.LOSS_OF_REST or (event.born is not None and event.kind != EventKind.FOLD):
                self.waiting.append((event, level))
        for kind, merge in branch.merges:
            met = self._met(merge, branch) or self._parent(branch, kind, merge)
            if met is not None and met.born_branch < 0:
                met.born_branch = number
                branch.parent = branch.parent or met
        self._ends_at_rest(branch, number)
        return number

    def _parent(self, branch: Branch, kind: Kind, merge: Singular) -> Event | None:
        """The event at which a branch ends on one that is not in the tree yet: follows that one, and adds it."""
        shooting = branch.shooting.of_kind(kind)
        start = at_value(shooting, merge.nodes, float(merge.values[0]), Metric.of(merge.nodes, self.walk.scale)).point
        if start is None or len(self.branches) >= MOST_BRANCHES or self.holds(shooting, start):
            return None
        self.add(follow(shooting, start, self.walk), branch.level)
        return self._met(merge, branch)

    def grow(self) -> None:
        """Switches at the waiting events, and adds the branches that are born there."""
        while self.waiting and len(self.branches) < MOST_BRANCHES:
            event, level = self.waiting.popleft()
            deep = event.kind != EventKind.LOSS_OF_REST
            if event.born_branch >= 0 or (deep and level >= self.switch):
                continue
            parent = self.branches[event.branch]
            birth = first_points(parent.shooting, event, self.walk)
            if birth is None or self.holds(birth[0], birth[2]):
                continue
            child, start, point = birth
            branch = follow(child, point, self.walk, both_ways=False)
            branch.points.insert(0, start)
            for branch_event in branch.events:
                branch_event.after += 1
            first = Ending.REST if event.kind == EventKind.LOSS_OF_REST else Ending.MERGED
            branch.ended = (first, branch.ended[1])
            event.born_branch = self.add(branch, level + deep, event)

    def holds(self, shooting: Shooting, point: Point) -> bool:
        """True if an orbit lies on a branch of the tree."""
        for branch in self.branches:
            if branch.map != shooting.kind:
                continue
            for k, share in _passing(branch, point.value, self.walk.scale):
                a, b = branch.points[k], branch.points[k + 1]
                guess = between(a, b, share, self.walk.scale)
                size = np.maximum(np.abs(a.nodes).max(axis=0), np.abs(b.nodes).max(axis=0))
                reach = (np.abs(b.nodes - a.nodes) / np.maximum(size, SMALLEST)).max() + 1e-3
                if distance(shooting, guess.nodes, point.nodes) > 2.0 * reach:
                    continue
                metric = Metric.of(guess.nodes, self.walk.scale)
                orbit = at_value(branch.shooting, guess.nodes, point.value, metric).point
                if orbit is not None and distance(shooting, orbit.nodes, point.nodes) < SAME_ORBIT:
                    return True
        return False

    def _met(self, merge: Singular, branch: Branch) -> Event | None:
        """The known event at which a merging branch ends."""
        value = float(merge.values[0])
        for other in self.branches:
            for event in other.events:
                if (
                    event.kind in (EventKind.PERIOD_DOUBLING, EventKind.SYMMETRY_BREAKING)
                    and born_map(event) == branch.map
                    and abs(event.value - value) < SAME_EVENT * self.walk.scale
                    and distance(other.shooting, event.orbit.nodes, merge.nodes) < 1e3 * SAME_ORBIT
                ):
                    return event
        return None

    def _ends_at_rest(self, branch: Branch, number: int) -> None:
        """Lets a branch that shrinks to rest end at the event at which rest loses its stability."""
        if branch.ended[1] != Ending.REST or not branch.points:
            return
        last = branch.points[-1]
        events = [
            event
            for other in self.branches
            if other.resting
            for event in other.events
            if born_map(event) == branch.map and event.born is not None
        ]
        if not events:
            return

        def off(event: Event) -> float:
            assert event.born is not None
            amplitude = np.abs(last.nodes).max() / np.abs(event.orbit.null).max()
            return float(abs(event.value + event.born.curvature * amplitude**2 - last.value))

        event = min(events, key=off)
        if off(event) < 0.02 * self.walk.scale:
            branch.points.append(Point(np.zeros_like(last.nodes), event.value, event.orbit.multipliers, last.tangent))
            if event.born_branch < 0:
                event.born_branch = number


def _passing(branch: Branch, value: float, scale: float) -> list[tuple[int, float]]:
    """Passages of a branch through a value of the parameter: the point before, and the share of the way to the next.

    Between points with opposite directions the branch turns, beyond the values of both.
    """
    values = branch.values
    low, high = np.minimum(values[1:], values[:-1]), np.maximum(values[1:], values[:-1])
    room = 0.5 * (high - low) + 1e-4 * (values.max() - values.min())
    up = np.array([point.tangent.value > 0.0 for point in branch.points])
    near = np.flatnonzero((value >= low - room) & (value <= high + room) | (up[1:] != up[:-1]))
    return [(int(k), share) for k in near for share in shares_at(branch.points[k], branch.points[k + 1], value, scale)]


def distance(shooting: Shooting, nodes: Array, other: Array) -> float:
    """Distance between two orbits of one kind, as a share of their size, up to shifts by repeats and mirror images."""
    if nodes.shape != other.shape:
        return np.inf
    whole, another = (whole_period(shooting, orbit) for orbit in (nodes, other))
    size = np.maximum(np.abs(whole).max(axis=0), 1e-6)
    mirrors: Sequence[Array] = (np.ones(shooting.size), shooting.system.mirror)[: 1 + shooting.symmetric]
    best = np.inf
    for shift in range(shooting.kind.period):
        for mirror in mirrors:
            apart = np.abs(np.roll(another, shift * shooting.segments, axis=0) * mirror - whole) / size
            best = min(best, float(apart.max()))
    return best


def whole_period(shooting: Shooting, nodes: Array) -> Array:
    """Nodes over a whole period; for a symmetric orbit its own and those of its mirror image."""
    return np.concatenate([nodes, shooting.signs * nodes]) if shooting.kind.reflected else nodes


def kind_of(period: int, symmetric: bool) -> Kind:
    """The map whose fixed point an orbit of that period is."""
    return Kind(period // 2, True) if symmetric and period % 2 == 0 else Kind(period)
