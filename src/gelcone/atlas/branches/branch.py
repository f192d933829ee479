"""One branch: orbits followed in a parameter from a start until something ends it, with the events on the way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from gelcone.atlas.branches.event import DOUBLE, FOLD, Born, Singular, born, locate
from gelcone.atlas.branches.point import (
    Corrected,
    Direction,
    Metric,
    Point,
    along,
    at_value,
    between,
    correct,
    cubic_weights,
)
from gelcone.motion.orbit import Kind, Shooting
from gelcone.quantity import Array

FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 0.005, 0.04, 1e-9
"""Steps along a branch, in units of the orbit's size and of the parameter's interval."""
AIM = 2e-3
"""How far a guess should be off; the steps are made so long."""
FARTHEST = 0.05
"""A guess that is off by more than this is not trusted: it may have led to another branch."""
COLLAPSED = 1e-6
"""An orbit, or the difference between its halves, that is this much smaller than before has collapsed."""
SAME_WAY = 0.8
"""Cosine of the largest turn from one point to the next."""
SECTIONS = 30
"""How often the interval of an event is cut before it counts as unresolved."""
LONGEST_STEP_AT_REST = 0.005
TORUS_WIDTH = 1e-11
"""The interval of a torus bifurcation is cut down to this share of the parameter's."""
ROUNDING_AT_TORUS = 1e-12


class Ending(IntEnum):
    """Why a branch ended."""

    LIMIT = 0
    REST = 1
    CLOSED = 2
    WALL = 3
    PULLED_IN = 4
    STEP = 5
    MERGED = 6
    POINTS = 7

    @property
    def meaning(self) -> str:
        """A line."""
        return _MEANINGS[self]


_MEANINGS = {
    Ending.LIMIT: "reached an end of the interval",
    Ending.REST: "shrank to rest",
    Ending.CLOSED: "closed: came back to where it began",
    Ending.WALL: "reached the stretch limit",
    Ending.PULLED_IN: "reached displacements at which the film pulls in",
    Ending.STEP: "could not be followed with the shortest step",
    Ending.MERGED: "merged with a branch of half its period, or a symmetric one",
    Ending.POINTS: "took as many points as were allowed",
}


class EventKind(IntEnum):
    """Kinds of events."""

    FOLD = 0
    PERIOD_DOUBLING = 1
    SYMMETRY_BREAKING = 2
    LOSS_OF_REST = 3
    CUSP = 4
    GENERALISED_DOUBLING = 5
    DEGENERATE_SYMMETRY_BREAKING = 6
    TORUS = 7

    @property
    def label(self) -> str:
        """The name in words."""
        return self.name.lower().replace("_", " ")


@dataclass(eq=False)
class Event:
    """An event on a branch.

    ``orbit``, singular; ``born``, how the branch leaves that is born (of a fold: the branch itself); ``unstable``, the
    side of the value on which the branch is less stable, 1 above, -1 below, 0 for a fold; ``after``, the index of the
    point before it; ``kind_of_orbit``, its map; ``branch`` and ``born_branch``, numbers once they are given;
    ``resolved``, whether Newton's method found it (else the value is a bracket).
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
        return float(self.orbit.values[0])

    @property
    def supercritical(self) -> bool | None:
        """Whether the branch that is born lies on the side where this one is unstable; None where none is born."""
        if self.born is None or self.unstable == 0.0:
            return None
        return bool(self.born.curvature * self.unstable > 0.0)


@dataclass(eq=False)
class Branch:
    """A branch: its map, its points in order, its events, what ended it at either end, and where it comes from.

    ``merges``: the orbits of half its period at which it ends, and their maps.
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
        return self.shooting.kind

    @property
    def values(self) -> Array:
        return np.array([point.value for point in self.points])


@dataclass(frozen=True)
class Walk:
    """What following a branch takes: the interval of the parameter, the most points, and what to do now and then.

    ``tick`` is called with every point; it may raise to interrupt.
    """

    low: float
    high: float
    most: int = 2000
    tick: Callable[[Point], None] = lambda point: None

    @property
    def scale(self) -> float:
        """Scale of the parameter."""
        return self.high - self.low


@dataclass
class _Followed:
    points: list[Point]
    events: list[Event]
    ended: Ending
    merge: tuple[Kind, Singular] | None = None


def follow(shooting: Shooting, start: Point, walk: Walk, *, both_ways: bool = True, resting: bool = False) -> Branch:
    """The branch through ``start``, whose tangent says which way is forward."""
    forward = _follow(shooting, start, walk, resting)
    if forward.ended == Ending.CLOSED or not both_ways:
        branch = Branch(shooting, forward.points, forward.events, (forward.ended, forward.ended), resting=resting)
        branch.merges = [forward.merge] if forward.merge else []
        return branch
    backward = _follow(shooting, Point(start.nodes, start.value, start.multipliers, -start.tangent), walk, resting)
    turned = [Point(p.nodes, p.value, p.multipliers, -p.tangent) for p in backward.points[:0:-1]]
    count = len(turned)
    for event in forward.events:
        event.after += count
    for event in backward.events:
        event.after = count - 1 - event.after
    events = [*reversed(backward.events), *forward.events]
    merges = [merge for merge in (backward.merge, forward.merge) if merge is not None]
    return Branch(shooting, turned + forward.points, events, (backward.ended, forward.ended), merges, resting=resting)


def _follow(shooting: Shooting, start: Point, walk: Walk, resting: bool) -> _Followed:
    """The branch from ``start`` onwards."""
    points: list[Point] = [start]
    events: list[Event] = []
    step, longest = FIRST_STEP, LONGEST_STEP_AT_REST if resting else LONGEST_STEP
    before: Point | None = None
    left = False
    if not walk.low <= start.value + 1e-12 * walk.scale * np.sign(start.tangent.value) <= walk.high:
        return _Followed(points, events, Ending.LIMIT)
    while len(points) < walk.most:
        here = points[-1]
        metric = Metric.of(here.nodes, walk.scale)
        tangent = metric.unit(here.tangent)
        guess = _ahead(before, here, tangent, metric, step)
        found = correct(shooting, guess, tangent, metric)
        point = found.point
        good = point is not None and found.step < FARTHEST * min(1.0, 20.0 * step)
        if good and point is not None:
            cosine = metric.inner(tangent, metric.unit(point.tangent))
            good = cosine > SAME_WAY and (resting or not _collapsed(shooting, here, point))
        if not good or point is None:
            left = found.left
            step *= 0.4
            if step < SHORTEST_STEP:
                return _Followed(
                    points, events, (Ending.PULLED_IN if shooting.pulled_in else Ending.WALL) if left else Ending.STEP
                )
            continue
        if not walk.low <= point.value <= walk.high:
            last = _at_border(shooting, here, point, walk, metric)
            if last is None:
                step *= 0.5
                if step < SHORTEST_STEP:
                    return _Followed(points, events, Ending.LIMIT)
                continue
            events += _events_between(shooting, here, last, len(points) - 1, walk, resting)
            return _Followed([*points, last], events, Ending.LIMIT)
        if not resting and len(points) > 1:
            if _passes_rest(shooting, here, point):
                return _Followed(points, events, Ending.REST)
            merge = _merge(shooting, here, point)
            if merge is not None:
                return _Followed([*points, _merged(shooting, *merge, point)], events, Ending.MERGED, merge)
        events += _events_between(shooting, here, point, len(points) - 1, walk, resting)
        points.append(point)
        walk.tick(point)
        if len(points) > 6 and _closes(points, metric, step):
            return _Followed([*points, start], events, Ending.CLOSED)
        before = here
        factor = min(max((AIM / max(found.step, 1e-12)) ** 0.25, 0.5), 1.7)
        step = min(step * factor, longest)
    return _Followed(points, events, Ending.POINTS)


def _ahead(before: Point | None, here: Point, tangent: Direction, metric: Metric, step: float) -> Direction:
    """The guess a step ahead: on the cubic through the last two points with the tangents there."""
    if before is None:
        return along(here, tangent, step)
    apart = metric.length(Direction(here.nodes - before.nodes, here.value - before.value))
    back = metric.unit(before.tangent)
    a, b, c, d = cubic_weights(1.0 + step / apart) * np.array([1.0, 1.0, apart, apart])
    nodes = a * before.nodes + b * here.nodes + c * back.nodes + d * tangent.nodes
    return Direction(nodes, float(a * before.value + b * here.value + c * back.value + d * tangent.value))


def _at_border(shooting: Shooting, here: Point, beyond: Point, walk: Walk, metric: Metric) -> Point | None:
    """The point at the end of the interval that a step passed."""
    border = walk.high if beyond.value > walk.high else walk.low
    if abs(here.value - border) < 1e-12 * walk.scale:
        return here
    share = (border - here.value) / (beyond.value - here.value)
    guess = between(here, beyond, share)
    found = at_value(shooting, guess.nodes, border, metric)
    if found.point is None or found.step > FARTHEST:
        return None
    tangent = found.point.tangent
    if metric.inner(tangent, beyond.tangent) < 0.0:
        tangent = -tangent
    return Point(found.point.nodes, border, found.point.multipliers, tangent)


# --- ends within the interval -----------------------------------------------------------------------------------------


def _passes_rest(shooting: Shooting, here: Point, point: Point) -> bool:
    """Whether the branch passes rest between two points, where it would go on as its own mirror image."""
    if not shooting.symmetric:
        return False
    return bool((here.nodes[:, :2] * point.nodes[:, :2]).sum() < 0.0)


def _collapsed(shooting: Shooting, here: Point, point: Point) -> bool:
    """Whether a step fell from a branch onto one that it comes from: rest, or half its period."""
    size = float(np.abs(here.nodes).max())
    if shooting.symmetric and size > COLLAPSED and np.abs(point.nodes[:, :2]).max() < COLLAPSED * size:
        return True
    pairs = zip(halves_apart(shooting, here.nodes), halves_apart(shooting, point.nodes), strict=True)
    return any(np.abs(after).max() < COLLAPSED * size < np.abs(before).max() for (_, before), (_, after) in pairs)


def halves_apart(shooting: Shooting, nodes: Array) -> list[tuple[Kind, Array]]:
    """For each map of half the repeats that the orbit may become a fixed point of, how far its halves are apart."""
    kind, half = shooting.kind, len(nodes) // 2
    if kind.repeats % 2 or kind.reflected:
        return []
    kinds = [Kind(kind.repeats // 2)] + [Kind(kind.repeats // 2, True)] * shooting.symmetric
    return [(k, nodes[half:] - shooting.of_kind(k).signs * nodes[:half]) for k in kinds]


def _merge(shooting: Shooting, here: Point, point: Point) -> tuple[Kind, Singular] | None:
    """Where the branch merges with one of half its period, and that one's map, if it does between two points."""
    for (kind, before), (_, after) in zip(
        halves_apart(shooting, here.nodes), halves_apart(shooting, point.nodes), strict=True
    ):
        if (before * after).sum() >= 0.0:
            continue
        one, other = np.abs(before).max(), np.abs(after).max()
        guess = between(here, point, one / (one + other))
        parent = shooting.of_kind(kind)
        half = len(guess.nodes) // 2
        nodes = 0.5 * (guess.nodes[:half] + parent.signs * guess.nodes[half:])
        found = locate(parent, nodes, np.array([guess.value]), DOUBLE, 0.5)
        if found is not None:
            return kind, found
    return None


def _merged(shooting: Shooting, kind: Kind, merge: Singular, beyond: Point) -> Point:
    """The last point of a branch that merges: the orbit of half the period, gone through twice."""
    nodes = np.concatenate([merge.nodes, shooting.of_kind(kind).signs * merge.nodes])
    return Point(nodes, float(merge.values[0]), beyond.multipliers, beyond.tangent)


def _closes(points: list[Point], metric: Metric, step: float) -> bool:
    """Whether the last step passed the start, going the same way."""
    start, here, before = points[0], points[-1], points[-2]
    if min(abs(here.value - start.value), abs(before.value - start.value)) > 2.0 * step * metric.value:
        return False
    apart = Direction(here.nodes - start.nodes, here.value - start.value)
    earlier = Direction(before.nodes - start.nodes, before.value - start.value)
    if metric.length(apart) > 2.0 * step or metric.length(earlier) > 2.0 * step:
        return False
    tangent = metric.unit(start.tangent)
    passed = metric.inner(apart, tangent) >= 0.0 >= metric.inner(earlier, tangent)
    return passed and metric.inner(here.tangent, tangent) > 0.0


# --- events -----------------------------------------------------------------------------------------------------------


def _events_between(
    shooting: Shooting, a: Point, b: Point, after: int, walk: Walk, resting: bool, depth: int = 0
) -> list[Event]:
    """The events between two neighbouring points, in the order in which the branch meets them."""
    crossed = []
    if a.fold * b.fold < 0.0:
        crossed.append((FOLD, a.fold / (a.fold - b.fold)))
    if a.double * b.double < 0.0:
        crossed.append((DOUBLE, a.double / (a.double - b.double)))
    torus = shooting.size > 2 and _pairs_outside(a) != _pairs_outside(b)
    if not (crossed or torus):
        return []
    found = [_event(shooting, a, b, at, share, after, walk, resting) for at, share in crossed]
    events = [event for event in found if event is not None]
    if torus:
        events.append(_torus(shooting, a, b, after, walk))
    metric = Metric.of(a.nodes, walk.scale)

    def place(event: Event) -> float:
        return metric.inner(Direction(event.orbit.nodes - a.nodes, event.value - a.value), a.tangent)

    return sorted(events, key=place)


def _event(
    shooting: Shooting, a: Point, b: Point, at: float, share: float, after: int, walk: Walk, resting: bool
) -> Event | None:
    """One event between two points: Newton's method from the interpolated guess, or from ever narrower brackets."""
    side = _unstable_side(a, b, at)
    metric = Metric.of(a.nodes, walk.scale)
    width = metric.length(Direction(b.nodes - a.nodes, b.value - a.value))
    for _ in range(SECTIONS):
        guess = between(a, b, share)
        if resting:
            orbit = _at_rest(shooting, a, b, at)
        else:
            orbit = locate(shooting, guess.nodes, np.array([guess.value]), at, 0.5)
        if orbit is not None:
            off = Direction(orbit.nodes - a.nodes, float(orbit.values[0]) - a.value)
            chord = Direction(b.nodes - a.nodes, b.value - a.value)
            place = metric.inner(off, chord) / metric.inner(chord, chord)
            if resting or (-1e-6 <= place <= 1.0 + 1e-6 and metric.length(off) < 2.0 * width):
                return _named(shooting, orbit, side, after, resting, True)
        chord = metric.unit(Direction(b.nodes - a.nodes, b.value - a.value))
        middle = correct(shooting, guess, chord, metric).point
        if middle is None:
            guess = between(a, b, 0.5)
            middle = correct(shooting, guess, chord, metric).point
        if middle is None:
            return None
        if metric.inner(middle.tangent, a.tangent) < 0.0:
            middle = Point(middle.nodes, middle.value, middle.multipliers, -middle.tangent)
        one, other, here = (p.fold if at == FOLD else p.double for p in (a, b, middle))
        if one * here <= 0.0:
            b, other = middle, here
        else:
            a, one = middle, here
        width = metric.length(Direction(b.nodes - a.nodes, b.value - a.value))
        share = min(max(one / (one - other), 0.1), 0.9)
        if width < 1e-10:
            break
    orbit = Singular(
        a.nodes,
        np.array([0.5 * (a.value + b.value)]),
        np.array([abs(b.value - a.value) + 1e-12]),
        np.zeros_like(a.nodes),
        np.zeros_like(a.nodes),
        a.multipliers,
        at,
    )
    return _named(shooting, orbit, side, after, resting, False)


def _named(shooting: Shooting, orbit: Singular, side: float, after: int, resting: bool, resolved: bool) -> Event:
    """The event at a singular orbit, with the branch that is born there."""
    kind = (
        EventKind.LOSS_OF_REST
        if resting
        else EventKind.FOLD
        if orbit.at == FOLD
        else EventKind.SYMMETRY_BREAKING
        if shooting.kind.reflected
        else EventKind.PERIOD_DOUBLING
    )
    leaves = None
    if resolved:
        try:
            leaves = born(shooting, orbit)
        except np.linalg.LinAlgError:
            resolved = False
    return Event(kind, orbit, leaves, 0.0 if kind == EventKind.FOLD else side, after, shooting.kind, resolved)


def _unstable_side(a: Point, b: Point, at: float) -> float:
    """On which side of the event, in the parameter, a multiplier is beyond ``at``: 1 above, -1 below."""
    one = a.fold if at == FOLD else a.double
    inner, outer = (a, b) if one > 0.0 else (b, a)
    return float(np.sign(outer.value - inner.value))


def _at_rest(shooting: Shooting, a: Point, b: Point, at: float) -> Singular | None:
    """Where rest loses stability between two values: bisection and secants on the test function."""
    from scipy.optimize import brentq

    from gelcone.atlas.branches.event import bordered

    def resting(value: float) -> Point:
        nodes = a.nodes + (b.nodes - a.nodes) * ((value - a.value) / (b.value - a.value))
        if shooting.size == 2:
            multipliers = shooting.multipliers(shooting.run(nodes, (value,)).tangents, (value,))
            return Point(nodes, value, multipliers, a.tangent)
        return at_value(shooting, nodes, value, Metric.of(a.nodes, 1.0)).point or a

    def test(value: float) -> float:
        point = resting(value)
        return point.fold if at == FOLD else point.double

    low, high = sorted((a.value, b.value))
    value = float(brentq(test, low, high, xtol=1e-15, rtol=1e-15))
    point = resting(value)
    system = bordered(shooting, point.nodes, np.array([value]), at, None, None)
    if system is None:
        return None
    rounding = 1e-14 * (1.0 + np.abs(system.here.tangents).sum() / np.abs(system.by_values[0]))
    return Singular(
        point.nodes, np.array([value]), np.array([rounding]), system.null, system.left, point.multipliers, at
    )


def _pairs_outside(point: Point) -> int:
    """Complex multipliers outside the unit circle."""
    return int(((np.abs(point.multipliers) > 1.0) & _complex(point)).sum())


def _complex(point: Point) -> npt.NDArray[np.bool_]:
    return np.asarray(np.abs(point.multipliers.imag) > 1e-9)


def _torus(shooting: Shooting, a: Point, b: Point, after: int, walk: Walk) -> Event:
    """A pair of multipliers that leaves the unit circle between two points (Neimark-Sacker bifurcation): the interval
    is cut until the value is known to `TORUS_WIDTH`. What is born there is no periodic orbit, and not followed."""
    outside = a if _pairs_outside(a) > _pairs_outside(b) else b
    side = float(np.sign(outside.value - (b if outside is a else a).value))
    pairs, low, high = _pairs_outside(a), a, b
    while abs(high.value - low.value) > TORUS_WIDTH * walk.scale:
        metric = Metric.of(low.nodes, walk.scale)
        chord = metric.unit(Direction(high.nodes - low.nodes, high.value - low.value))
        share = _crossing(low, high)
        middle = correct(shooting, between(low, high, share), chord, metric).point
        if middle is None:
            break
        if metric.inner(middle.tangent, low.tangent) < 0.0:
            middle = Point(middle.nodes, middle.value, middle.multipliers, -middle.tangent)
        low, high = (middle, high) if _pairs_outside(middle) == pairs else (low, middle)
    zeros = np.zeros_like(low.nodes)
    error = np.array([abs(high.value - low.value) + ROUNDING_AT_TORUS * walk.scale])
    value = np.array([0.5 * (low.value + high.value)])
    multipliers = (low if _complex(low).any() else high).multipliers
    orbit = Singular(low.nodes, value, error, zeros, zeros, multipliers, FOLD)
    return Event(EventKind.TORUS, orbit, None, side, after, shooting.kind)


def _crossing(a: Point, b: Point) -> float:
    """Where between two points a pair passes the unit circle, by the modulus of the pair that is nearest to it, a
    little beyond so that the intervals shrink from both ends; the middle where no pair is known on both sides."""
    if not (_complex(a).any() and _complex(b).any()):
        return 0.5
    one, other = (min(np.log(np.abs(p.multipliers[_complex(p)])), key=abs) for p in (a, b))
    if one * other >= 0.0:
        return 0.5
    share = float(one / (one - other))
    share += np.copysign(min(0.1 * min(share, 1.0 - share), 0.05), 0.5 - share)
    return min(max(share, 1e-3), 1.0 - 1e-3)


# --- the branch that is born ------------------------------------------------------------------------------------------

SMALLEST_AMPLITUDE = 1e-5
LARGEST_AMPLITUDE = 0.05
"""Amplitude of the first point of a branch that is born, as a share of the orbit's size."""
LARGEST_SHIFT = 0.01
"""And how far the parameter may move to it, as a share of its interval."""


def born_start(shooting: Shooting, event: Event, walk: Walk) -> tuple[Shooting, Point, Point] | None:
    """The first two points of the branch that is born at an event: the event, and an orbit beside it.

    The amplitude is taken smaller until the orbit lies before its own doubling; None where none is found.
    """
    if event.born is None:
        return None
    orbit, kind = event.orbit, born_map(event)
    child = shooting.of_kind(kind)
    turns = child.count // shooting.count
    nodes, null, bend = orbit.nodes, orbit.null, event.born.bend
    if turns == 2:
        nodes = np.concatenate([nodes, shooting.signs * nodes])
        null = np.concatenate([null, orbit.at * shooting.signs * null])
        bend = np.concatenate([bend, shooting.signs * bend])
    curvature, value = event.born.curvature, event.value
    metric = Metric.of(nodes + (null if event.kind == EventKind.LOSS_OF_REST else 0.0), walk.scale)
    tangent = metric.unit(Direction(null, 0.0))
    size = float(np.abs(nodes).max()) or 1.0
    amplitude = LARGEST_AMPLITUDE * size
    if curvature:
        amplitude = min(amplitude, np.sqrt(LARGEST_SHIFT * walk.scale / abs(curvature)))
    while amplitude > SMALLEST_AMPLITUDE * size:
        shift = amplitude * amplitude
        guess = Direction(nodes + amplitude * null + shift * bend, value + shift * curvature)
        found: Corrected = correct(child, guess, tangent, metric)
        if found.point is not None and found.step < 0.3 * amplitude and found.point.double > 0.0:
            start = Point(nodes, value, found.point.multipliers, tangent)
            point = found.point
            if metric.inner(point.tangent, tangent) < 0.0:
                point = Point(point.nodes, point.value, point.multipliers, -point.tangent)
            return child, start, point
        amplitude *= 0.4
    return None


def born_map(event: Event) -> Kind:
    """The map of the orbits that are born at an event."""
    if event.kind == EventKind.LOSS_OF_REST:
        return Kind(event.map.repeats, event.orbit.at == DOUBLE)
    return event.map.doubled


def multipliers_of_period(kind: Kind, multipliers: npt.NDArray[np.complex128]) -> npt.NDArray[np.complex128]:
    """Multipliers over a whole period of the orbit."""
    return np.square(multipliers) if kind.reflected else multipliers
