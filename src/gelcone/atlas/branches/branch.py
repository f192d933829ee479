"""Branches: their points, their events, and how they end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from gelcone.atlas.branches.event import DOUBLE, Born, Singular
from gelcone.atlas.branches.journal import Journal
from gelcone.atlas.branches.point import Point
from gelcone.codes import Code
from gelcone.motion.orbit import Kind, Shooting
from gelcone.quantity import Array


class Ending(Code):
    """Reasons for which a branch ends."""

    LIMIT = 0, "reached an end of the interval"
    REST = 1, "shrank to rest"
    CLOSED = 2, "closed: came back to where it began"
    WALL = 3, "reached the stretch limit"
    PULLED_IN = 4, "reached displacements at which the film pulls in"
    STEP = 5, "could not be followed with the shortest step"
    MERGED = 6, "merged with a branch of half its period, or a symmetric one"
    POINTS = 7, "took as many points as were allowed"
    IMPOSSIBLE = 8, "reached values of which no actuator can be made"


class EventKind(Code):
    """Kinds of events."""

    FOLD = 0
    PERIOD_DOUBLING = 1
    SYMMETRY_BREAKING = 2
    LOSS_OF_REST = 3
    CUSP = 4
    GENERALISED_DOUBLING = 5
    DEGENERATE_SYMMETRY_BREAKING = 6
    TORUS = 7


@dataclass(eq=False)
class Event:
    """An event on a branch.

    ``orbit`` is singular; ``born`` the branch that is born there (for a fold the branch itself); ``unstable`` the side
    of the value on which the branch is less stable, 1 above, -1 below, 0 for a fold; ``after`` the index of the point
    before it; ``map`` the map of the orbit; ``branch`` and ``born_branch`` numbers once they are known; ``resolved`` is
    False where Newton's method did not find it, so that the value is the middle of a bracket.
    """

    kind: EventKind
    orbit: Singular
    born: Born | None
    unstable: float
    after: int
    map: Kind
    resolved: bool = True
    branch: int = -1
    born_branch: int = -1

    @property
    def value(self) -> float:
        """Value of the parameter."""
        return float(self.orbit.values[0])

    @property
    def supercritical(self) -> bool | None:
        """True if the branch that is born lies on the side where this one is unstable; None where none is born."""
        if self.born is None or self.unstable == 0.0:
            return None
        return bool(self.born.curvature * self.unstable > 0.0)


@dataclass(eq=False)
class Branch:
    """A branch: its points in order, its events, and how it ``ended`` at either end.

    ``merges`` are the orbits of half its period at which it ends, and their maps; ``parent`` is the event at which it
    is born, ``level`` the number of switches before it.
    """

    shooting: Shooting
    points: list[Point]
    events: list[Event] = field(default_factory=list)
    ended: tuple[Ending, Ending] = (Ending.LIMIT, Ending.LIMIT)
    merges: list[tuple[Kind, Singular]] = field(default_factory=list)
    parent: Event | None = None
    resting: bool = False
    level: int = 0

    @property
    def map(self) -> Kind:
        """The map whose fixed points the orbits are."""
        return self.shooting.kind

    @property
    def values(self) -> Array:
        """Values of the parameter at the points."""
        return np.array([point.value for point in self.points])


@dataclass(frozen=True)
class Walk:
    """The settings of a continuation: the interval of the parameter, the most points, and where findings are stored.

    ``tick`` is called with every point; it may raise to interrupt.
    """

    low: float
    high: float
    most: int = 2000
    tick: Callable[[Point], None] = lambda point: None
    journal: Journal = field(default_factory=Journal)

    @property
    def scale(self) -> float:
        """Scale of the parameter."""
        return self.high - self.low


def born_map(event: Event) -> Kind:
    """The map of the orbits that are born at an event."""
    if event.kind == EventKind.LOSS_OF_REST:
        return Kind(event.map.repeats, event.orbit.at == DOUBLE)
    return event.map.doubled


def multipliers_of_period(kind: Kind, multipliers: npt.NDArray[np.complex128]) -> npt.NDArray[np.complex128]:
    """Multipliers over a whole period of the orbit."""
    return np.square(multipliers) if kind.reflected else multipliers
