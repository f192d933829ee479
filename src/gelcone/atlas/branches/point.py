"""Points of a branch: an orbit at a value of the parameter, and the corrector that finds it.

A guess is corrected in a plane through it, so that a branch can be followed around its folds: the pseudo-arclength
method of Keller (1977), with Newton's method on all shooting nodes at once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.atlas.branches.event import DOUBLE, FOLD
from gelcone.motion.cyclic import solve_ring
from gelcone.motion.orbit import Pass, Shooting
from gelcone.quantity import Array

CLOSE = 1e-7
"""Newton's method ends with a step smaller than this, after which the error is about its square."""
CORRECTIONS = 7
"""Most iterations of Newton's method."""
CONTRACTION = 0.5
"""Largest ratio of a step of Newton's method to the one before; beyond it the guess was too far."""
SMALLEST = 1e-3
"""Least scale of a state, which is otherwise its largest value on the orbit."""


@dataclass(frozen=True)
class Direction:
    """A direction along a branch: changes of the ``nodes`` (n, N) and of the ``value``."""

    nodes: Array
    value: float

    def __neg__(self) -> Direction:
        return Direction(-self.nodes, -self.value)


@dataclass(frozen=True)
class Metric:
    """A measure of differences: ``states`` (N,) are the weights of the squares of the nodes' states, ``value`` the
    scale of the parameter."""

    states: Array
    value: float

    @classmethod
    def of(cls, nodes: Array, value: float) -> Metric:
        """The metric of an orbit: states are measured by the largest, and the mean over the nodes counts."""
        states = np.maximum(np.abs(nodes).max(axis=0), SMALLEST)
        return cls(1.0 / (len(nodes) * states * states), value)

    def inner(self, a: Direction, b: Direction) -> float:
        """Mean over the nodes of the product of the states, plus that of the values."""
        return float(np.vdot(a.nodes * self.states, b.nodes)) + a.value * b.value / self.value**2

    def length(self, a: Direction) -> float:
        """Length of a difference."""
        return math.sqrt(self.inner(a, a))

    def unit(self, a: Direction) -> Direction:
        """The direction of length 1."""
        by = 1.0 / self.length(a)
        return Direction(by * a.nodes, by * a.value)

    def row(self, a: Direction) -> tuple[Array, Array]:
        """Row (1, n, N) and corner (1, 1) of the condition that a step is orthogonal to ``a``."""
        return (a.nodes * self.states)[None], np.array([[a.value / self.value**2]])


@dataclass(frozen=True)
class Point:
    """An orbit on a branch.

    ``nodes`` (n, N) at ``value`` of the parameter, the first at phase 0; ``multipliers`` (N,) of the map, the largest
    modulus first; ``tangent``, the direction of the branch there, of length 1.
    """

    nodes: Array
    value: float
    multipliers: npt.NDArray[np.complex128]
    tangent: Direction

    @cached_property
    def tests(self) -> dict[float, float]:
        """Map 1 and -1 to a test function that passes 0 where a multiplier mu passes it: the product of
        (1 - mu)/(1 + |mu|) for 1, and of (1 + mu)/(1 + |mu|) for -1."""
        multipliers = self.multipliers.tolist()
        return {at: math.prod((1.0 - at * m) / (1.0 + abs(m)) for m in multipliers).real for at in (FOLD, DOUBLE)}

    @property
    def stable(self) -> bool:
        """True if all multipliers lie inside the unit circle."""
        return bool(np.abs(self.multipliers[0]) < 1.0)


@dataclass(frozen=True)
class Corrected:
    """The result of a correction: the ``point``, or None; ``left``, true if the orbit left the domain of the film; the
    length of the first ``step``, the error of the guess; and ``impossible``, true where the values make no actuator."""

    point: Point | None
    left: bool = False
    step: float = np.inf
    impossible: bool = False


def way(a: Point, b: Point) -> Direction:
    """The difference between two points."""
    return Direction(b.nodes - a.nodes, b.value - a.value)


def along(start: Point, direction: Direction, by: float) -> Direction:
    """The guess (nodes and value) at the distance ``by`` along a direction."""
    return Direction(start.nodes + by * direction.nodes, start.value + by * direction.value)


def correct(shooting: Shooting, guess: Direction, plane: Direction, metric: Metric) -> Corrected:
    """The orbit nearest to ``guess`` in the plane through it that is normal to ``plane``."""
    nodes, value, first, before = guess.nodes, guess.value, np.inf, np.inf
    rows, corner = metric.row(plane)
    top = np.array([[0.0, 1.0]])
    for _ in range(CORRECTIONS):
        orbit_pass = shooting.run(nodes, (value,))
        if not orbit_pass.arrived:
            return Corrected(None, True, first)
        step, tangent = _newton(shooting, orbit_pass, nodes, rows, corner, top)
        if step is None or tangent is None:
            return Corrected(None, False, first)
        nodes, value = nodes + step.nodes, value + step.value
        length = metric.length(step)
        first = min(first, length) if before == np.inf else first
        if length < CLOSE:
            if not shooting.inside(nodes, (value,)):
                return Corrected(None, True, first)
            multipliers = shooting.multipliers(orbit_pass.tangents, (value,))
            return Corrected(Point(nodes, value, multipliers, metric.unit(tangent)), False, first)
        if not length < CONTRACTION * before:
            return Corrected(None, False, first)
        before = length
    return Corrected(None, False, first)


def _newton(
    shooting: Shooting, found: Pass, nodes: Array, rows: Array, corner: Array, top: Array
) -> tuple[Direction | None, Direction | None]:
    """Newton's step in the plane, and the tangent of the branch; None where the system is singular."""
    gaps = shooting.gaps(nodes, found.ends)
    right = np.zeros((*gaps.shape, 2))
    right[..., 0] = gaps
    try:
        x, unknowns = solve_ring(found.tangents, shooting.signs, right, found.slopes, rows, corner, top)
    except np.linalg.LinAlgError:
        return None, None
    return Direction(x[..., 0], float(unknowns[0, 0])), Direction(x[..., 1], float(unknowns[0, 1]))


def at_value(shooting: Shooting, nodes: Array, value: float, metric: Metric) -> Corrected:
    """The orbit near ``nodes`` at a fixed value of the parameter; its tangent points to larger values."""
    return correct(shooting, Direction(nodes, value), Direction(np.zeros_like(nodes), metric.value), metric)


def between(a: Point, b: Point, share: float, scale: float) -> Direction:
    """The cubic through two points with the tangents there, at a share of the way; ``scale`` is that of the
    parameter."""
    weights = _cubic(a, b, np.array(share), scale)
    nodes = weights[0] * a.nodes + weights[1] * b.nodes + weights[2] * a.tangent.nodes + weights[3] * b.tangent.nodes
    return Direction(np.asarray(nodes), float(_values(a, b, weights)))


def facing(point: Point, way: Direction, metric: Metric) -> Point:
    """A point with its tangent turned so that it does not point against a direction."""
    return replace(point, tangent=-point.tangent) if metric.inner(point.tangent, way) < 0.0 else point


def point_between(shooting: Shooting, a: Point, b: Point, share: float, metric: Metric) -> Point | None:
    """The point of a branch between two others, at about a ``share`` of the way; None where none is found."""
    point = correct(shooting, between(a, b, share, metric.value), metric.unit(way(a, b)), metric).point
    return None if point is None else facing(point, a.tangent, metric)


def shares_at(a: Point, b: Point, value: float, scale: float) -> list[float]:
    """Shares of the way at which the cubic between two points passes a value of the parameter; two where it turns."""
    share = np.linspace(0.0, 1.0, 65)
    off = _values(a, b, _cubic(a, b, share, scale)) - value
    at = np.flatnonzero(off[1:] * off[:-1] <= 0.0)
    apart = np.where(off[at] == off[at + 1], 1.0, off[at] - off[at + 1])
    return list(share[at] + (share[1] - share[0]) * np.clip(off[at] / apart, 0.0, 1.0))


def _cubic(a: Point, b: Point, s: Array, scale: float) -> Array:
    """Weights (4, ...) of both points and their tangents, each as long as the way."""
    metric = Metric.of(a.nodes, scale)
    whole = metric.length(way(a, b))
    lengths = [whole / metric.length(point.tangent) for point in (a, b)]
    scales = np.array([1.0, 1.0, *lengths])
    return cubic_weights(s) * scales.reshape(4, *(1,) * np.ndim(s))


def cubic_weights(s: Any) -> Array:
    """Weights (4, ...) of two points and of the tangents there in the cubic through them, at shares of the way; shares
    above 1 extrapolate."""
    t = 1.0 - s
    return np.array([t * t * (1.0 + 2.0 * s), s * s * (3.0 - 2.0 * s), s * t * t, -s * s * t])


def _values(a: Point, b: Point, weights: Array) -> Array:
    interpolated = weights[0] * a.value + weights[1] * b.value
    return np.asarray(interpolated + weights[2] * a.tangent.value + weights[3] * b.tangent.value)
