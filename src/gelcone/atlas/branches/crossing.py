"""Events between two neighbouring points of a branch: detected by signs of test functions, located and classified."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from gelcone.atlas.branches.branch import Event, EventKind, Walk
from gelcone.atlas.branches.event import FOLD, Singular, bordered, born, locate
from gelcone.atlas.branches.point import Direction, Metric, Point, at_value, between, point_between, way
from gelcone.motion.orbit import Shooting

SECTIONS = 30
"""Most bisections of the interval of an event before it counts as unresolved."""
TORUS_WIDTH = 1e-11
"""Width of the interval of a torus bifurcation, over that of the parameter, at which its bisection ends."""
ROUNDING_AT_TORUS = 1e-12
"""Error by rounding of the value at a torus bifurcation, over the interval of the parameter."""


def events_between(shooting: Shooting, a: Point, b: Point, after: int, walk: Walk, resting: bool) -> list[Event]:
    """The events between two neighbouring points, in their order along the branch."""
    tests = [(at, first, b.tests[at]) for at, first in a.tests.items()]
    crossed = [(at, first / (first - second)) for at, first, second in tests if (first < 0.0) != (second < 0.0)]
    torus = shooting.size > 2 and _pairs_outside(a) != _pairs_outside(b)
    if not (crossed or torus):
        return []
    candidates = [_event(shooting, a, b, at, share, after, walk, resting) for at, share in crossed]
    events = [event for event in candidates if event is not None]
    if torus:
        events.append(_torus(shooting, a, b, after, walk))
    metric = Metric.of(a.nodes, walk.scale)

    def place(event: Event) -> float:
        return metric.inner(Direction(event.orbit.nodes - a.nodes, event.value - a.value), a.tangent)

    return sorted(events, key=place)


def _event(
    shooting: Shooting, a: Point, b: Point, at: float, share: float, after: int, walk: Walk, resting: bool
) -> Event | None:
    """One event between two points, by Newton's method from a guess in a bracket that narrows until it converges."""
    side = _unstable_side(a, b, at)
    metric = Metric.of(a.nodes, walk.scale)
    width = metric.length(way(a, b))
    for _ in range(SECTIONS):
        if resting:
            orbit = _at_rest(shooting, a, b, at)
        else:
            guess = between(a, b, share, walk.scale)
            orbit = locate(shooting, guess.nodes, np.array([guess.value]), at, 0.5)
        if orbit is not None:
            off = Direction(orbit.nodes - a.nodes, float(orbit.values[0]) - a.value)
            chord = way(a, b)
            place = metric.inner(off, chord) / metric.inner(chord, chord)
            if resting or (-1e-6 <= place <= 1.0 + 1e-6 and metric.length(off) < 2.0 * width):
                return _named(shooting, orbit, side, after, resting, True)
        middle = point_between(shooting, a, b, share, metric) or point_between(shooting, a, b, 0.5, metric)
        if middle is None:
            return None
        one, other, here = (p.tests[at] for p in (a, b, middle))
        if (one < 0.0) != (here < 0.0):
            b, other = middle, here
        else:
            a, one = middle, here
        before, width = width, metric.length(way(a, b))
        # linear interpolation alone would move only one end
        share = min(max(one / (one - other), 0.1), 0.9) if width < 0.5 * before else 0.5
        if width < 1e-10:
            break
    return _named(shooting, _bracketed(a, b, 1e-12, a.multipliers, at), side, after, resting, False)


def _bracketed(a: Point, b: Point, rounding: float, multipliers: npt.NDArray[np.complex128], at: float) -> Singular:
    """The orbit in the middle of two points, of which only the value and its error are known."""
    none, width = np.zeros_like(a.nodes), abs(b.value - a.value)
    value, error = np.array([0.5 * (a.value + b.value)]), np.array([width + rounding])
    return Singular(a.nodes, value, error, none, none, multipliers, at)


def _named(shooting: Shooting, orbit: Singular, side: float, after: int, resting: bool, resolved: bool) -> Event:
    """The event at a singular orbit, with its kind and the branch that is born there."""
    doubling = EventKind.SYMMETRY_BREAKING if shooting.kind.reflected else EventKind.PERIOD_DOUBLING
    kind = EventKind.LOSS_OF_REST if resting else EventKind.FOLD if orbit.at == FOLD else doubling
    leaves = None
    if resolved:
        try:
            leaves = born(shooting, orbit)
        except np.linalg.LinAlgError:
            resolved = False
    return Event(kind, orbit, leaves, 0.0 if kind == EventKind.FOLD else side, after, shooting.kind, resolved)


def _unstable_side(a: Point, b: Point, at: float) -> float:
    """The side of the event, in the parameter, on which a multiplier is beyond ``at``: 1 above, -1 below."""
    inner, outer = (b, a) if a.tests[at] < 0.0 else (a, b)
    return float(np.sign(outer.value - inner.value))


def _at_rest(shooting: Shooting, a: Point, b: Point, at: float) -> Singular | None:
    """The orbit of rest at which it loses stability between two points, by Brent's method on the test function."""
    from scipy.optimize import brentq

    def resting(value: float) -> Point:
        nodes = a.nodes + (b.nodes - a.nodes) * ((value - a.value) / (b.value - a.value))
        if shooting.size == 2:
            multipliers = shooting.multipliers(shooting.run(nodes, (value,)).tangents, (value,))
            return Point(nodes, value, multipliers, a.tangent)
        return at_value(shooting, nodes, value, Metric.of(a.nodes, 1.0)).point or a

    low, high = sorted((a.value, b.value))
    value = float(brentq(lambda value: resting(value).tests[at], low, high, xtol=1e-15, rtol=1e-15))
    point = resting(value)
    system = bordered(shooting, point.nodes, np.array([value]), at, None, None)
    if system is None:
        return None
    rounding = 1e-14 * (1.0 + np.abs(system.here.tangents).sum() / np.abs(system.by_values[0]))
    return Singular(
        point.nodes, np.array([value]), np.array([rounding]), system.null, system.left, point.multipliers, at
    )


def _pairs_outside(point: Point) -> int:
    """Number of complex multipliers outside the unit circle."""
    return int(((np.abs(point.multipliers) > 1.0) & _complex(point)).sum())


def _complex(point: Point) -> npt.NDArray[np.bool_]:
    return np.asarray(np.abs(point.multipliers.imag) > 1e-9)


def _torus(shooting: Shooting, a: Point, b: Point, after: int, walk: Walk) -> Event:
    """The Neimark-Sacker bifurcation between two points, where a pair of multipliers leaves the unit circle. The
    interval is cut down to `TORUS_WIDTH`. The torus that is born there is not followed."""
    outside = a if _pairs_outside(a) > _pairs_outside(b) else b
    side = float(np.sign(outside.value - (b if outside is a else a).value))
    pairs, low, high = _pairs_outside(a), a, b
    while abs(high.value - low.value) > TORUS_WIDTH * walk.scale:
        middle = point_between(shooting, low, high, _crossing(low, high), Metric.of(low.nodes, walk.scale))
        if middle is None:
            break
        low, high = (middle, high) if _pairs_outside(middle) == pairs else (low, middle)
    multipliers = (low if _complex(low).any() else high).multipliers
    orbit = _bracketed(low, high, ROUNDING_AT_TORUS * walk.scale, multipliers, FOLD)
    return Event(EventKind.TORUS, orbit, None, side, after, shooting.kind)


def _crossing(a: Point, b: Point) -> float:
    """The share of the way between two points at which a pair passes the unit circle, by the modulus of the nearest
    pair, a little beyond so that both ends of the interval move; 0.5 where not both points have a pair."""
    if not (_complex(a).any() and _complex(b).any()):
        return 0.5
    one, other = (min(np.log(np.abs(p.multipliers[_complex(p)])), key=abs) for p in (a, b))
    if one * other >= 0.0:
        return 0.5
    share = float(one / (one - other))
    share += np.copysign(min(0.1 * min(share, 1.0 - share), 0.05), 0.5 - share)
    return min(max(share, 1e-3), 1.0 - 1e-3)
