"""Checkpoints of a continuation in one direction along a branch, and their arrays in a journal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any

import numpy as np

from gelcone.atlas.branches.branch import Ending, Event, EventKind
from gelcone.atlas.branches.event import Born, Singular
from gelcone.atlas.branches.point import Direction, Point
from gelcone.motion.orbit import Kind
from gelcone.quantity import Array

POINT = ("nodes", "value", "multipliers", "tangent.nodes", "tangent.value")
EVENT = ("kind", "unstable", "after", "resolved")
SINGULAR = ("nodes", "values", "errors", "null", "left", "multipliers", "at")
BORN = ("curvature", "bend", "coefficient")


@dataclass
class Checkpoint:
    """Points and events so far, the length of the next ``step``, how the branch ``ended`` (None: it has not), and the
    orbit of half the period with which it merged."""

    points: list[Point]
    step: float
    events: list[Event] = field(default_factory=list)
    ended: Ending | None = None
    merge: tuple[Kind, Singular] | None = None

    def finish(self, ended: Ending, *last: Point) -> Checkpoint:
        """Ends the branch, after a last point if one is given."""
        self.points += last
        self.ended = ended
        return self

    def arrays(self) -> dict[str, Array]:
        """Arrays by name from which `of` makes the checkpoint again."""
        entry = {"step": np.array(self.step), "ended": np.array(-1 if self.ended is None else self.ended)}
        entry |= _columns("point", self.points, POINT)
        if self.events:
            blank = Born(np.nan, np.zeros_like(self.events[0].orbit.nodes))
            entry |= _columns("event", self.events, EVENT)
            entry |= _columns("orbit", [event.orbit for event in self.events], SINGULAR)
            entry |= _columns("born", [event.born or blank for event in self.events], BORN)
            entry["event has born"] = np.array([event.born is not None for event in self.events])
        if self.merge is not None:
            entry |= _columns("merge", [self.merge[1]], SINGULAR) | {"merge kind": np.array(self.merge[0])}
        return entry

    @classmethod
    def of(cls, entry: Mapping[str, Any], kind: Kind) -> Checkpoint:
        """The checkpoint with these `arrays`, of a branch of orbits of one kind."""
        points = [
            Point(nodes, value, multipliers, Direction(*tangent))
            for nodes, value, multipliers, *tangent in _rows(entry, "point", POINT)
        ]
        checkpoint = cls(points, float(entry["step"]))
        if entry["ended"] >= 0:
            checkpoint.ended = Ending(int(entry["ended"]))
        if "event kind" in entry:
            tables = (_rows(entry, *table) for table in (("event", EVENT), ("orbit", SINGULAR), ("born", BORN)))
            for row, orbit, born, has in zip(*tables, entry["event has born"], strict=True):
                name, unstable, after, resolved = row
                leaves = Born(*born) if has else None
                checkpoint.events.append(
                    Event(EventKind(name), Singular(*orbit), leaves, unstable, after, kind, resolved)
                )
        if "merge kind" in entry:
            repeats, reflected = entry["merge kind"].tolist()
            checkpoint.merge = Kind(repeats, bool(reflected)), Singular(*_rows(entry, "merge", SINGULAR)[0])
        return checkpoint


def _columns(prefix: str, items: Sequence[Any], names: Sequence[str]) -> dict[str, Array]:
    return {f"{prefix} {name}": np.array([attrgetter(name)(item) for item in items]) for name in names}


def _rows(entry: Mapping[str, Any], prefix: str, names: Sequence[str]) -> list[tuple[Any, ...]]:
    """The rows of the columns with these names; scalars as Python numbers."""
    columns = (entry[f"{prefix} {name}"] for name in names)
    return list(zip(*(c.tolist() if c.ndim == 1 else c for c in columns), strict=True))
