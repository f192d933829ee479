"""A curve of singular orbits in two parameters, followed in both directions, with its points of codimension two."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from gelcone.atlas.branches.branch import Ending, EventKind
from gelcone.atlas.branches.event import FAR_SIDE, FOLD, Singular, born, locate
from gelcone.atlas.branches.follow import AIM, SAME_WAY
from gelcone.atlas.branches.point import SMALLEST, cubic_weights
from gelcone.errors import InputError
from gelcone.motion.orbit import Shooting
from gelcone.quantity import Array

FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 0.01, 0.04, 1e-7
"""Steps along a curve. Each costs several times one along a branch, hence the longer first and shortest ones."""
SECANTS = 40
"""Most iterations for a zero of the coefficient."""
AT_REST = 1e-4
"""Orbits smaller than this, as a share of the largest on their curve, are rest."""
OTHER_SIDE = 0.25 * FAR_SIDE
"""Second distance of the differences for the coefficient, for the error of a point of codimension two; rounding counts
sixteen times as much there."""
WIDTH = 1e-14
"""Share of the rectangle to which points of codimension two are located."""


@dataclass
class Curve:
    """A curve of singular orbits: the ``points`` in order with the coefficient ``tests`` at each, the ``special``
    points, those of codimension two, each with the index of the point before it, and how the curve ``ended``."""

    shooting: Shooting
    kind: EventKind
    points: list[Singular]
    tests: list[float]
    special: list[tuple[Singular, int]] = field(default_factory=list)
    ended: tuple[Ending, Ending] = (Ending.LIMIT, Ending.LIMIT)


@dataclass(frozen=True)
class Window:
    """The rectangle of the two parameters, and the most points of a curve."""

    low: Array
    high: Array
    most: int

    @property
    def scale(self) -> Array:
        """Widths of the intervals."""
        return self.high - self.low

    def holds(self, values: Array) -> bool:
        """True if values lie in the intervals."""
        slack = 1e-9 * self.scale
        return bool((values >= self.low - slack).all() and (values <= self.high + slack).all())


def follow_curve(
    shooting: Shooting, kind: EventKind, nodes: Array, values: Array, at: float, window: Window
) -> Curve | None:
    """The curve of singular orbits through a guess, both ways; None where there is none."""
    across = (np.zeros_like(nodes), np.array([0.0, 1.0 / window.scale[1] ** 2]))
    first = locate(shooting, nodes, values, at, 0.5, across)
    if first is None or first.ahead is None:
        return None
    forward, ended = _walk(shooting, first, window, 1.0)
    backward, began = [first], ended
    if ended != Ending.CLOSED:
        backward, began = _walk(shooting, first, window, -1.0)
    points = [*backward[:0:-1], *forward]
    curve = Curve(shooting, kind, points, [], [], (began, ended))
    curve.tests = _tests(shooting, points)
    _find_special(curve, window)
    return curve


def _scaled(point: Singular, window: Window) -> tuple[Array, Array]:
    """Weights of nodes and values in the length of a step."""
    states = np.maximum(np.abs(point.nodes).max(axis=0), SMALLEST)
    return 1.0 / (np.square(states) * len(point.nodes)), 1.0 / np.square(window.scale)


def _walk(shooting: Shooting, first: Singular, window: Window, way: float) -> tuple[list[Singular], Ending]:
    """The points of a curve from its first one in one direction, and how it ended there."""
    points, step = [first], FIRST_STEP
    assert first.ahead is not None
    direction = way * first.ahead[0], way * first.ahead[1]
    before: tuple[Singular, tuple[Array, Array]] | None = None
    size = float(np.abs(first.nodes).max())
    while len(points) < window.most:
        here = points[-1]
        by_states, by_values = _scaled(here, window)

        def length(nodes: Array, values: Array, weights: tuple[Array, Array] = (by_states, by_values)) -> float:
            return float(np.sqrt(np.sum(weights[0] * nodes**2) + np.sum(weights[1] * values**2)))

        whole = length(*direction)
        tangent = direction[0] / whole, direction[1] / whole
        plane = by_states * tangent[0], by_values * tangent[1]
        guess = here.nodes + step * tangent[0], here.values + step * tangent[1]
        if before is not None:
            prior, back = before
            apart, scale = length(here.nodes - prior.nodes, here.values - prior.values), length(*back)
            weights = cubic_weights(1.0 + step / apart) * np.array([1.0, 1.0, apart / scale, apart])
            guess = (
                weights[0] * prior.nodes + weights[1] * here.nodes + weights[2] * back[0] + weights[3] * tangent[0],
                weights[0] * prior.values + weights[1] * here.values + weights[2] * back[1] + weights[3] * tangent[1],
            )
        point, possible = _located(shooting, guess, here, plane)
        off, turn = np.inf, -1.0
        if point is not None and point.ahead is not None:
            off, ahead = length(point.nodes - guess[0], point.values - guess[1]), length(*point.ahead)
            turn = float(np.sum(plane[0] * point.ahead[0]) + np.sum(plane[1] * point.ahead[1])) / ahead
        if point is None or point.ahead is None or not (off < 0.3 * step and turn > SAME_WAY):
            step *= 0.4
            if step < SHORTEST_STEP:
                return points, Ending.STEP if possible else Ending.IMPOSSIBLE
            continue
        if not window.holds(point.values):
            last = _at_border(shooting, here, point, window)
            return [*points, last] if last is not None else points, Ending.LIMIT
        if np.abs(point.nodes).max() < AT_REST * size:
            return points, Ending.REST
        points.append(point)
        size = max(size, float(np.abs(point.nodes).max()))
        if len(points) > 6 and length(point.nodes - first.nodes, point.values - first.values) < 0.7 * step:
            return [*points, first], Ending.CLOSED
        before, direction = (here, direction), point.ahead
        factor = min(max((AIM / max(off, 1e-9)) ** 0.25, 0.5), 1.6)
        step = min(step * factor, LONGEST_STEP)
    return points, Ending.POINTS


def _at_border(shooting: Shooting, here: Singular, beyond: Singular, window: Window) -> Singular | None:
    """The point where the curve leaves the rectangle."""
    shares = []
    for k in range(2):
        for border in (window.low[k], window.high[k]):
            change = beyond.values[k] - here.values[k]
            if change and 0.0 <= (border - here.values[k]) / change <= 1.0:
                shares.append(((border - here.values[k]) / change, k, border))
    if not shares:
        return None
    share, k, border = min(shares)
    nodes = here.nodes + share * (beyond.nodes - here.nodes)
    values = here.values + share * (beyond.values - here.values)
    values[k] = border
    corner = np.zeros(2)
    corner[k] = 1.0 / window.scale[k] ** 2
    return _located(shooting, (nodes, values), here, (np.zeros_like(nodes), corner))[0]


def _located(
    shooting: Shooting, guess: tuple[Array, Array], here: Singular, plane: tuple[Array, Array]
) -> tuple[Singular | None, bool]:
    """The singular orbit next to a guess of nodes and values, and whether the values make an actuator."""
    try:
        return locate(shooting, *guess, here.at, 0.3, plane, here), True
    except InputError:
        return None, False


# --- points of codimension two ----------------------------------------------------------------------------------------


def _tests(shooting: Shooting, points: list[Singular]) -> list[float]:
    """The coefficient whose zeros are points of codimension two, with one orientation along the curve."""
    tests, sign = [], 1.0
    for k, point in enumerate(points):
        if k:
            sign *= _turned(points[k - 1], point)
        tests.append(sign * _coefficient(shooting, point))
    return tests


def _turned(one: Singular, other: Singular) -> float:
    """The sign by which the coefficient changes with the signs of null vector and weights; that of a fold is even in
    the null vector, the others are odd."""
    left = np.sign(np.sum(one.left * other.left))
    null = np.sign(np.sum(one.null * other.null))
    return float(left if one.at == FOLD else left * null)


def _coefficient(shooting: Shooting, point: Singular, over: float | None = None) -> float:
    """The quadratic coefficient of a fold, the cubic one of the others, by differences ``over`` a distance. By default
    that of a fold is the one with which the point was located."""
    scale = float(np.linalg.norm(point.left)) or 1.0
    if point.at == FOLD and over is None:
        return point.quadratic / scale
    try:
        return born(shooting, point, over or FAR_SIDE).coefficient / scale
    except np.linalg.LinAlgError:
        return np.nan


SPECIAL = {
    EventKind.FOLD: EventKind.CUSP,
    EventKind.PERIOD_DOUBLING: EventKind.GENERALISED_DOUBLING,
    EventKind.SYMMETRY_BREAKING: EventKind.DEGENERATE_SYMMETRY_BREAKING,
}


def _find_special(curve: Curve, window: Window) -> None:
    """Locates the zeros of the coefficient along the curve."""
    tests = np.array(curve.tests)
    for k in np.flatnonzero(tests[1:] * tests[:-1] < 0.0):
        if curve.kind == EventKind.FOLD and not _reverses(curve, int(k), window):
            continue
        zero = _zero(curve, int(k), window, FAR_SIDE)
        if zero is not None:
            curve.special.append((replace(zero, errors=_errors(curve, int(k), window, zero)), int(k)))


def _errors(curve: Curve, k: int, window: Window, found: Singular) -> Array:
    """Errors of the values at a zero of the coefficient: its change when differences are taken over another distance,
    and rounding. Without a zero there, the error is the distance of the two points."""
    other = _zero(curve, k, window, OTHER_SIDE)
    if other is None:
        return np.abs(curve.points[k + 1].values - curve.points[k].values)
    return np.asarray(np.abs(other.values - found.values) + found.errors + WIDTH * window.scale)


def _reverses(curve: Curve, k: int, window: Window) -> bool:
    """True if the curve turns back between two points, as it does at a cusp."""
    values = np.array([point.values for point in curve.points[max(k - 1, 0) : k + 3]]) / window.scale
    steps = np.diff(values, axis=0)
    return bool(np.sum(steps[0] * steps[-1]) < 0.0)


def _zero(curve: Curve, k: int, window: Window, over: float) -> Singular | None:
    """The zero of the coefficient between two points: regula falsi with the Illinois rule along their chord.

    ``over``: as in `_coefficient`.
    """
    shooting, a, b = curve.shooting, curve.points[k], curve.points[k + 1]
    by_states, by_values = _scaled(a, window)
    chord = by_states * (b.nodes - a.nodes), by_values * (b.values - a.values)
    low, high, below = 0.0, 1.0, _coefficient(shooting, a, over)
    above = _turned(a, b) * _coefficient(shooting, b, over)
    if not below * above < 0.0:
        return None
    point, side, width = a, 0, np.inf
    for _ in range(SECANTS):
        share = (low * above - high * below) / (above - below)
        share = min(max(share, low + 1e-3 * (high - low)), high - 1e-3 * (high - low))
        nodes, values = a.nodes + share * (b.nodes - a.nodes), a.values + share * (b.values - a.values)
        candidate = locate(shooting, nodes, values, a.at, 0.5, chord, a)
        if candidate is None:
            return None
        width = float(np.abs((candidate.values - point.values) / window.scale).max())
        point, test = candidate, _turned(a, candidate) * _coefficient(shooting, candidate, over)
        if width < WIDTH or high - low < 1e-13 or test == 0.0:
            break
        if test * below > 0.0:
            low, below, above, side = share, test, above * (0.5 if side == -1 else 1.0), -1
        else:
            high, above, below, side = share, test, below * (0.5 if side == 1 else 1.0), 1
    # at a pole, or where a vector changes its sign, the coefficient changes its sign without getting small
    least = min(abs(curve.tests[k]), abs(curve.tests[k + 1]))
    return point if abs(_coefficient(shooting, point, over)) < 1e-3 * least else None
