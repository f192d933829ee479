"""A branch as far as it has been followed one way: what a journal keeps of it, and how that becomes a branch again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gelcone.atlas.branches.branch import Ending, Event, EventKind
from gelcone.atlas.branches.event import Born, Singular
from gelcone.atlas.branches.point import Direction, Point
from gelcone.motion.orbit import Kind
from gelcone.quantity import Array

SINGULAR = ("nodes", "values", "errors", "null", "left", "multipliers", "at")


@dataclass
class Followed:
    """Points and events so far, the length of the next ``step``, why it ``ended`` (None: it goes on), and the orbit of
    half the period with which it merged."""

    points: list[Point]
    step: float
    events: list[Event] = field(default_factory=list)
    ended: Ending | None = None
    merge: tuple[Kind, Singular] | None = None

    def finish(self, ended: Ending, *last: Point) -> Followed:
        """The branch at its end, behind which a last point may lie."""
        self.points += last
        self.ended = ended
        return self

    def arrays(self) -> dict[str, Array]:
        """All of it as arrays by name."""
        entry = {
            "step": np.array(self.step),
            "ended": np.array(-1 if self.ended is None else self.ended),
            "point nodes": np.stack([point.nodes for point in self.points]),
            "point value": np.array([point.value for point in self.points]),
            "point multipliers": np.stack([point.multipliers for point in self.points]),
            "point ahead": np.stack([point.tangent.nodes for point in self.points]),
            "point ahead value": np.array([point.tangent.value for point in self.points]),
        }
        if self.events:
            born = [event.born for event in self.events]
            blank = Born(np.nan, np.zeros_like(self.events[0].orbit.nodes))
            entry |= _singular("event ", [event.orbit for event in self.events]) | {
                "event kind": np.array([event.kind for event in self.events]),
                "event unstable": np.array([event.unstable for event in self.events]),
                "event after": np.array([event.after for event in self.events]),
                "event resolved": np.array([event.resolved for event in self.events]),
                "event has born": np.array([one is not None for one in born]),
                **{
                    f"event born {name}": np.array([getattr(one or blank, name) for one in born])
                    for name in ("curvature", "bend", "coefficient")
                },
            }
        if self.merge is not None:
            entry |= _singular("merge ", [self.merge[1]]) | {"merge kind": np.array(self.merge[0])}
        return entry

    @classmethod
    def of(cls, entry: Mapping[str, Any], kind: Kind) -> Followed:
        """What `arrays` gave of a branch of orbits of one kind."""
        ahead = zip(entry["point ahead"], entry["point ahead value"].tolist(), strict=True)
        points = [
            Point(nodes, value, multipliers, Direction(*tangent))
            for nodes, value, multipliers, tangent in zip(
                entry["point nodes"], entry["point value"].tolist(), entry["point multipliers"], ahead, strict=True
            )
        ]
        followed = cls(points, float(entry["step"]))
        if entry["ended"] >= 0:
            followed.ended = Ending(int(entry["ended"]))
        for k in range(len(entry.get("event kind", ()))):
            names = ("curvature", "bend", "coefficient")
            curvature, bend, coefficient = (entry[f"event born {name}"][k] for name in names)
            followed.events.append(
                Event(
                    EventKind(int(entry["event kind"][k])),
                    _restored("event ", entry, k),
                    Born(float(curvature), bend, float(coefficient)) if entry["event has born"][k] else None,
                    float(entry["event unstable"][k]),
                    int(entry["event after"][k]),
                    kind,
                    bool(entry["event resolved"][k]),
                )
            )
        if "merge kind" in entry:
            repeats, reflected = entry["merge kind"].tolist()
            followed.merge = Kind(repeats, bool(reflected)), _restored("merge ", entry, 0)
        return followed


def _singular(prefix: str, orbits: Sequence[Singular]) -> dict[str, Array]:
    return {prefix + name: np.array([getattr(orbit, name) for orbit in orbits]) for name in SINGULAR}


def _restored(prefix: str, entry: Mapping[str, Any], k: int) -> Singular:
    fields = {name: entry[prefix + name][k] for name in SINGULAR}
    return Singular(**fields | {"at": float(fields["at"])})
