"""Events on a branch, at which orbits fold or lose stability, located by Newton's method on the extended system.

At an event the ring of tangent maps, closed with the multiplier +1 (fold) or -1 (period doubling, or symmetry breaking
for a symmetric orbit), is singular. The bordered system of the ring measures the singularity by one number g (Govaerts,
Numerical Methods for Bifurcations of Dynamical Equilibria, 2000, chapter 4). Since second derivatives are symmetric,
derivatives of g follow from the tangent maps at two orbits displaced along the null vector. Third derivatives give the
curvature of the branch that is born, and whether it is super- or subcritical (Kuznetsov, Elements of Applied
Bifurcation Theory, 2004, section 5.4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gelcone.motion.cyclic import left_weights, solve_ring
from gelcone.motion.orbit import Pass, Shooting
from gelcone.quantity import Array

FOLD, DOUBLE = 1.0, -1.0
"""The multiplier at which an event happens."""
SIDE = 1e-5
"""Displacement for second derivatives by differences of tangent maps, as a share of the orbit's size."""
FAR_SIDE = 5e-4
"""Displacement for third derivatives."""
LOCATING = 12
"""Most iterations of Newton's method."""
LOCATED = 1e-10
"""Newton's method ends with a step smaller than this, as a share of states and of values."""
SMALLEST_VALUE = 1e-3
"""Least scale of steps of values, which are otherwise relative to the values."""
SEGMENT_ROUNDING = 2e-15
"""Error of the end of a segment and of its tangent map, relative to their size."""


@dataclass(frozen=True)
class Singular:
    """A singular orbit: ``nodes`` (n, N) at ``values`` of the free parameters, with their ``errors``.

    ``null`` and ``left`` (n, N), the right and left null vectors of the ring (largest entry of ``null`` 1);
    ``multipliers`` (N,) of the map; ``at``, the multiplier at which the ring is singular. With two free parameters
    ``ahead`` is the tangent (nodes, values) of the curve of such orbits; ``quadratic`` is the coefficient that passes 0
    at a cusp.
    """

    nodes: Array
    values: Array
    errors: Array
    null: Array
    left: Array
    multipliers: npt.NDArray[np.complex128]
    at: float
    ahead: tuple[Array, Array] | None = None
    quadratic: float = np.nan


@dataclass(frozen=True)
class Bordered:
    """The singularity of the ring at an orbit.

    ``g`` passes 0 at the event; ``by_nodes`` (n, N) and ``by_values`` (P,) are its derivatives; ``null`` and ``left``
    the null vectors; ``here`` the pass over the orbit.
    """

    g: float
    by_nodes: Array
    by_values: Array
    null: Array
    left: Array
    here: Pass


def copied(found: Pass) -> Pass:
    """A pass whose arrays outlive the next run."""
    return Pass(found.ends.copy(), found.tangents.copy(), found.slopes.copy(), found.arrived)


def bordered(
    shooting: Shooting, nodes: Array, values: Array, at: float, null: Array | None, left: Array | None
) -> Bordered | None:
    """The bordered system at an orbit; None where it cannot be computed. ``null`` and ``left`` are guesses."""
    here = shooting.run(nodes, tuple(values))
    if not here.arrived:
        return None
    here = copied(here)
    signs = at * shooting.signs
    rounds = 1
    if null is None or left is None:
        random, rounds = np.random.default_rng(0), 3
        null, left = random.normal(size=nodes.shape), random.normal(size=nodes.shape)
    g = np.inf
    for _ in range(rounds):
        column = (-left / np.square(left).sum())[..., None]
        row = (null / np.square(null).sum())[None]
        none = np.zeros((1, 1))
        try:
            x, unknown = solve_ring(
                here.tangents, signs, np.zeros((*nodes.shape, 1)), column, row, none, np.ones((1, 1))
            )
            weights, _ = left_weights(here.tangents, signs, column, row, none)
        except np.linalg.LinAlgError:
            return None
        null, left, g = x[..., 0], weights, float(unknown[0, 0])
        if not (np.isfinite(null).all() and np.isfinite(left).all()):
            return None
        largest = np.abs(null).max()
        null, g = null / largest, g / largest
    by = SIDE * max(float(np.abs(nodes).max()), 1e-3)
    ahead, behind = (copied(shooting.run(nodes + side * null, tuple(values))) for side in (by, -by))
    if not (ahead.arrived and behind.arrived):
        return None
    by_nodes = np.einsum("kij,ki->kj", (ahead.tangents - behind.tangents) / (2.0 * by), left)
    by_values = np.einsum("kip,ki->p", ahead.slopes - behind.slopes, left) / (2.0 * by)
    return Bordered(g, by_nodes, by_values, null, left, here)


def locate(
    shooting: Shooting,
    nodes: Array,
    values: Array,
    at: float,
    reach: float,
    plane: tuple[Array, Array] | None = None,
    near: Singular | None = None,
) -> Singular | None:
    """The singular orbit nearest to a guess, or None.

    Parameters
    ----------
    shooting : with one free parameter, or with two and a ``plane``.
    nodes, values : the guess.
    at : the multiplier of the event.
    reach : longest step, as a share of the size of states.
    plane : row (n, N) and corner (P,) of a further condition: steps are orthogonal to it.
    near : a singular orbit nearby, whose null vectors are the first guess.
    """
    null, left = (None, None) if near is None else (near.null, near.left)
    before = np.inf
    size = max(float(np.abs(nodes).max()), 1e-3)
    for _ in range(LOCATING):
        system = bordered(shooting, nodes, values, at, null, left)
        if system is None:
            return None
        gaps = shooting.gaps(nodes, system.here.ends)
        rows, corner = system.by_nodes[None], system.by_values[None]
        top, right = np.array([[-system.g]]), gaps[..., None]
        if plane is not None:
            rows = np.concatenate([rows, plane[0][None]])
            corner = np.concatenate([corner, plane[1][None]])
            top = np.array([[-system.g, 0.0], [0.0, 1.0]])
            right = np.stack([gaps, np.zeros_like(gaps)], axis=-1)
        try:
            x, change = solve_ring(system.here.tangents, shooting.signs, right, system.here.slopes, rows, corner, top)
        except np.linalg.LinAlgError:
            return None
        x, ahead = x[..., 0], (x[..., -1], change[:, -1])
        off = float(np.abs(x).max()) / size
        # the step in the values counts, too: orbits may not depend on them
        step = max(off, float((np.abs(change[:, 0]) / np.maximum(np.abs(values), SMALLEST_VALUE)).max()))
        if not (off < reach and np.isfinite(change).all()) or (before < 1e-3 and step > before):
            if not (before < 1e3 * LOCATED):
                return None
            step = 0.0
        else:
            nodes, values = nodes + x, values + change[:, 0]
        null, left = system.null, system.left
        if step < LOCATED:
            errors = _errors(shooting, system, rows, corner)
            multipliers = _multipliers(shooting, system.here, values, at)
            quadratic = float(np.sum(system.by_nodes * system.null))
            return Singular(nodes, values, errors, system.null, system.left, multipliers, at, ahead, quadratic)
        before = step
    return None


def _multipliers(shooting: Shooting, here: Pass, values: Array, at: float) -> npt.NDArray[np.complex128]:
    """Multipliers of the map. A planar system has that of the event, and the other one follows from the determinant."""
    if not shooting.system.planar:
        return shooting.multipliers(here.tangents, tuple(values))
    other = np.exp(shooting.log_determinant(tuple(values))) / at
    return np.array(sorted((at, other), key=abs, reverse=True), dtype=complex)


def _errors(shooting: Shooting, system: Bordered, rows: Array, corner: Array) -> Array:
    """Errors of the values, (P,), by rounding in the ends and tangent maps of the segments."""
    if len(corner) > 1:  # the error across a curve of events is of this size; along it there is none
        return np.full(corner.shape[1], SEGMENT_ROUNDING * 1e2)
    weights, share = left_weights(system.here.tangents, shooting.signs, system.here.slopes, rows, corner)
    ends = SEGMENT_ROUNDING * (np.abs(system.here.ends) + np.abs(system.here.tangents).max(axis=2))
    maps = SEGMENT_ROUNDING * np.einsum("ki,kij,kj->", *map(np.abs, (system.left, system.here.tangents, system.null)))
    return np.array([float(np.sum(np.abs(weights) * ends) + abs(share) * maps)])


@dataclass(frozen=True)
class Born:
    """The branch that is born at an event, to second order in the amplitude a of the null vector: the value changes by
    ``curvature`` a^2, the nodes by a times the null vector and ``bend`` a^2 (n, N). For a fold it is the branch itself.
    The zeros of ``coefficient`` are points of codimension two: it is quadratic for a fold (a cusp), else cubic (where
    super- and subcritical meet)."""

    curvature: float
    bend: Array
    coefficient: float = np.nan


def born(shooting: Shooting, event: Singular, side: float = FAR_SIDE) -> Born:
    """The branch that is born (at a fold, the branch itself), to second order.

    ``side`` is the displacement for differences of tangent maps, as a share of the orbit's size. Default 5e-4.
    """
    nodes, null, left, values = event.nodes, event.null, event.left, tuple(event.values)
    by = side * max(float(np.abs(nodes).max()), float(np.abs(null).max()))
    here = copied(shooting.run(nodes, values))
    sides = [copied(shooting.run(nodes + share * by * null, values)) for share in (1.0, -1.0, 2.0, -2.0)]
    bend = _first([side.tangents for side in sides], by)
    slope = _first([side.slopes for side in sides], by)[..., 0]
    second = np.einsum("kij,kj->ki", bend, null)
    if event.at == FOLD and not _at_rest(nodes):
        quadratic = float(np.sum(left * second))
        curvature = -quadratic / (2.0 * float(np.sum(left * here.slopes[..., 0])))
        return Born(curvature, np.zeros_like(nodes), quadratic)
    third = np.einsum("kij,kj->ki", _second([here.tangents, *(side.tangents for side in sides)], by), null)
    moved = np.zeros((2, *nodes.shape))
    if not _at_rest(nodes):
        right = np.stack([0.5 * second, here.slopes[..., 0]], axis=-1)
        none = np.zeros((*nodes.shape, 0))
        x, _ = solve_ring(
            here.tangents, shooting.signs, right, none, np.zeros((0, *nodes.shape)), np.zeros((0, 0)), np.zeros((0, 2))
        )
        moved = np.moveaxis(x, -1, 0)
    cubic = np.sum(left * (np.einsum("kij,kj->ki", bend, moved[0]) + third / 6.0))
    crossing = np.sum(left * (np.einsum("kij,kj->ki", bend, moved[1]) + slope))
    curvature = -float(cubic / crossing)
    return Born(curvature, moved[0] + curvature * moved[1], float(cubic))


def _at_rest(nodes: Array) -> bool:
    """True if the disc rests."""
    return not np.abs(nodes[:, :2]).any()


def _first(sides: list[Array], by: float) -> Array:
    """First derivative from values at by, -by, 2 by and -2 by."""
    a, b, c, d = sides
    return np.asarray((8.0 * (a - b) - (c - d)) / (12.0 * by))


def _second(values: list[Array], by: float) -> Array:
    """Second derivative from values at 0, by, -by, 2 by and -2 by."""
    here, a, b, c, d = values
    return np.asarray((16.0 * (a + b) - (c + d) - 30.0 * here) / (12.0 * by * by))
