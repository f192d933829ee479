"""Equilibria of a `Film` under growing loads: Newton with the consistent tangent, load steps, arc length past folds.

The loads are the height of the disc and v^2. A step follows the tangent of the path and is corrected by Newton's
method; it is halved where the correction is not small compared with it, so that no step jumps to another branch.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np

from gelcone.codes import Code
from gelcone.continuum.mesh import (
    BAND,
    SLACK_STIFFNESS,
    Film,
    Forces,
    electric_forces,
    energy,
    forces,
    reachable,
    tangent,
)
from gelcone.quantity import Array

Load = Literal["height", "squared"]
"""A load, an attribute of a `Point`."""

DISC_HEIGHT = 1
"""Index of the disc's height among the unknowns."""
FREE = slice(2, -2)
"""The unknowns that are neither on the disc nor on the rim."""
TOLERANCE = 1e-12
"""Residual forces of an equilibrium, over the largest force of a ring on a node."""
FORCE_ROUNDING = 1e-15
"""Residual forces that rounding leaves, over the largest stiffness."""
MOST_ITERATIONS, MOST_HALVINGS = 40, 12
"""Most iterations of Newton's method from a rough guess, and most halvings of one of its steps."""
STEP_ITERATIONS, STEP_HALVINGS = 8, 3
"""As before, from the prediction of a load step, where more would lead to another branch."""
LARGEST_CORRECTION = 0.3
"""Largest correction of a step, over its length; a larger one may lead to another branch."""
LONGEST_STEP = 0.5
"""Largest displacement of a step, in b - a."""
SMALLEST_STEP: dict[Load, float] = {"height": 1e-3, "squared": 3e-2}
"""Share of the way to the next load below which a path counts as ended; for the voltage the arc length takes over."""
MOST_ARC_STEPS = 100
MOST_ARC_ITERATIONS = 6
ARC_LENGTH = 0.05
"""First step along the arc, in the measure of `_size`."""
LONGEST_ARC = 0.5
ARC_TOLERANCE = 1e-8
"""As `TOLERANCE`, before the last Newton steps at a given voltage."""


NETS = tuple(SLACK_STIFFNESS * 10.0**k for k in (5, 4, 3, 2, 1, 0))
"""Stiffness of the nets on which an equilibrium of a slack film is found, one after the other."""
FIRST_NETS = (4, 0)
"""Indices of the net to begin with; the second is tried if the first fails."""


class Ending(Code):
    """The ending of the search for the film's state at one displacement and voltage."""

    CONVERGED = 0, "converged: in tension along the meridian, reached by raising the disc and then the voltage"
    COMPRESSED = 1, "converged, but compressed along the meridian: only a film that cannot wrinkle rests there"
    BEYOND_LIMIT = 2, "no film of this law spans that height within its stretch limit"
    TENSION_LOST = 3, "lost its tension along the meridian on the way: a slack film holds no such state"
    PULLED_IN = 4, "pulled in on the way: above a voltage the film has no state in tension there"
    NOT_CONVERGED = 5, "the path of equilibria could not be followed to this load"
    UNRESOLVED = 6, "found, but the mesh is too coarse for it: take more elements"
    SLACK = 7, "slack: wrinkled in all directions, the film does not pull the disc"


class Point(NamedTuple):
    """An equilibrium: the unknowns, v^2, the forces; ``stable`` if the energy has a minimum there."""

    position: Array
    squared: float
    forces: Forces
    stable: bool

    @property
    def height(self) -> float:
        """Height of the disc in b - a."""
        return float(self.position[DISC_HEIGHT])

    @property
    def force(self) -> float:
        """Force that holds the disc, per mu Vol/(b - a)."""
        return float(self.forces.internal[DISC_HEIGHT])


# --- one equilibrium -------------------------------------------------------------------------------------------------


def newton(film: Film, guess: Array, squared: float, within: float = math.inf) -> Point | None:
    """The equilibrium near a guess, with the ends held; None if Newton's method does not find one.

    ``within`` bounds the displacement from the guess; it also shortens the iteration.
    """
    if not reachable(film, guess):
        return None
    most, halvings = (MOST_ITERATIONS, MOST_HALVINGS) if math.isinf(within) else (STEP_ITERATIONS, STEP_HALVINGS)
    position, now = guess, forces(film, guess, squared)
    for _ in range(most):
        band = _regular(film, position, squared, now)
        step = np.zeros_like(position)
        step[FREE] = -_solved(band, now.internal)
        allowed = TOLERANCE * now.scale + FORCE_ROUNDING * float(np.abs(band).max()) * max(
            1.0, float(np.abs(position).max())
        )
        if _residual(now) <= allowed:
            return _polished(film, position, step, squared, now)
        damped = _damped(film, position, step, squared, max(allowed, _residual(now)), halvings)
        if damped is None or np.abs(damped[0] - guess).max() > within:
            return None
        position, now = damped
    return None


def _damped(
    film: Film, position: Array, step: Array, squared: float, most: float, halvings: int
) -> tuple[Array, Forces] | None:
    """The first of successively halved steps after which the residual forces are less than ``most``; None if none is.

    A film that may wrinkle rests in a minimum of its energy. A step that lowers the energy is accepted, too, since the
    residual forces may rise where rings tighten and their stiffness jumps.
    """
    before = None
    for _ in range(halvings):
        moved = position + step
        if reachable(film, moved):
            now = forces(film, moved, squared)
            if _residual(now) < most:
                return moved, now
            if film.relaxed:
                before = energy(film, position, squared) if before is None else before
                if energy(film, moved, squared) < before:
                    return moved, now
        step = 0.5 * step
    return None


def _polished(film: Film, position: Array, step: Array, squared: float, now: Forces) -> Point:
    """The point after one more step, if that lowers the residual forces: they are then exact to rounding."""
    moved = position + step
    if reachable(film, moved) and _residual(then := forces(film, moved, squared)) < _residual(now):
        position, now = moved, then
    return Point(position, squared, now, _positive(_regular(film, position, squared, now)))


def _residual(f: Forces) -> float:
    """The largest force on a free node."""
    return float(np.abs(f.internal[FREE]).max())


def _regular(film: Film, position: Array, squared: float, now: Forces) -> Array:
    """The tangent of the free unknowns. A flat film has its heights held at 0: by symmetry it is an equilibrium, even
    where no tension holds it."""
    band = tangent(film, position, squared, now)
    if not position[1::2].any():
        band[BAND, 1::2] = 1.0
    return band[:, FREE]


def _solved(band: Array, right: Array) -> Array:
    """The solution of the band system; NaN where it is singular."""
    from scipy.linalg import LinAlgError, solve_banded

    try:
        return np.asarray(solve_banded((BAND, BAND), band, right[FREE], check_finite=False))
    except LinAlgError:  # exactly singular: no step from here
        return np.full(right[FREE].shape, np.nan)


def _positive(band: Array) -> bool:
    """True if the tangent is positive definite: the equilibrium is stable against all axisymmetric motion."""
    from scipy.linalg import LinAlgError, cholesky_banded

    try:
        cholesky_banded(band[: BAND + 1], check_finite=False)
    except LinAlgError:
        return False
    return True


def settled(film: Film, guess: Array, square: float, within: float = math.inf) -> Point | None:
    """The equilibrium of a film that may wrinkle, from a guess, on successively weaker nets; None if none is found.

    It serves where rings fall slack or tighten within a step, so that the tangent does not lead there. The energy has a
    single minimum as long as every ring has a natural width, whichever net is the first: a weak one takes the fewest
    steps, a strong one converges from afar.
    """
    for first in FIRST_NETS if film.relaxed else ():
        point, start = None, guess
        for net in NETS[first:]:
            point = newton(dataclasses.replace(film, net=net), start, square, within)
            if point is None or not point.stable:
                point = None
                break
            start = point.position
        if point is not None:
            return point
    return None


# --- along a load ----------------------------------------------------------------------------------------------------


def flat(film: Film, squared: float) -> Point | None:
    """The flat film under v^2 in equilibrium in its plane; None where none is found.

    By symmetry it is an equilibrium even where no tension keeps it flat; ``stable`` states whether one does.
    """
    start = newton(film, np.zeros(film.size), 0.0)
    point = start if start is None or squared == 0.0 else reach(film, start, "squared", squared)[0]
    if point is None:
        return None
    return point._replace(stable=_positive(tangent(film, point.position, squared)[:, FREE]))


def cone(film: Film, height: float, below: Point | None = None) -> Array:
    """A guess: the homogeneous cone, with the radial displacements of ``below`` if given."""
    position = np.zeros(film.size) if below is None else below.position.copy()
    position[1::2] = height * (1.0 - film.place)
    return position


def reach(film: Film, start: Point, load: Load, target: float) -> tuple[Point | None, Point]:
    """The equilibrium at a load, reached in steps from ``start``, or None; and the last one found on the way.

    The path ends where a film that starts stable and in tension would lose either.
    """
    point, start_load = start, getattr(start, load)
    pace = target - start_load
    while getattr(point, load) != target:
        remaining = target - getattr(point, load)
        whole = abs(pace) >= abs(remaining)
        pace = remaining if whole else pace
        next_point = step(film, point, load, target if whole else getattr(point, load) + pace)
        if next_point is None:
            pace *= 0.5
            if abs(pace) < SMALLEST_STEP[load] * abs(target - start_load):
                return None, point
        else:
            point, pace = next_point, 2.0 * pace
    return point, point


def step(film: Film, point: Point, load: Load, target: float) -> Point | None:
    """The equilibrium at a load, by one step along the tangent; None if it is not close to the prediction."""
    way = (target - getattr(point, load)) * _rate(film, point, load)
    guess = point.position + way
    if load == "height":
        guess[DISC_HEIGHT] = target
    length = float(np.abs(way).max())
    if not length <= LONGEST_STEP:
        return None
    within = LARGEST_CORRECTION * length + 1e-9
    next_point = newton(film, guess, target if load == "squared" else point.squared, within)
    if next_point is None or (slackens(next_point) and not slackens(point)):
        return None
    # by symmetry a flat film stays flat through any loss of stability
    return next_point if next_point.stable == point.stable or next_point.height == 0.0 else None


def slackens(point: Point) -> bool:
    """True if the meridian of a raised film is compressed anywhere."""
    return point.height != 0.0 and point.forces.least < 0.0


def _rate(film: Film, point: Point, load: Load) -> Array:
    """Change of the unknowns with the load along the path."""
    rate = np.zeros(film.size)
    band = tangent(film, point.position, point.squared, point.forces)
    if load == "height":
        rate[DISC_HEIGHT] = 1.0
        pull = np.zeros(film.size)
        coupled = np.arange(min(BAND + DISC_HEIGHT + 1, film.size))
        pull[coupled] = band[BAND + coupled - DISC_HEIGHT, DISC_HEIGHT]
    else:
        pull = electric_forces(film, point.position, point.squared, point.forces)
    if not point.position[1::2].any():
        band[BAND, 1::2] = 1.0
    rate[FREE] = -_solved(band[:, FREE], pull)
    return rate


# --- past folds of the voltage, at a held disc -----------------------------------------------------------------------


class Arc(NamedTuple):
    """A point on a path, the direction of the path there, and the number of ``folds`` of the voltage passed so far."""

    point: Point
    position: Array
    squared: float
    folds: int


def arc(film: Film, start: Point) -> Iterator[Arc]:
    """Points at equal arc length along the equilibria of a held disc, from ``start`` towards higher voltage.

    Ends after `MOST_ARC_STEPS`, where no further point is found, where v^2 returns to 0, and after the point at which
    tension is lost.
    """
    here = _arc(film, start, None)
    length, shortest = ARC_LENGTH, 1e-6 * ARC_LENGTH
    for _ in range(MOST_ARC_STEPS):
        point = None
        while point is None:
            if length < shortest:
                return
            point = _corrected(film, here, length)
            length *= 0.5 if point is None else 1.0
        if point.squared < 0.0:
            return
        here = _arc(film, point, here)
        yield here
        if slackens(point):
            return
        length = min(2.0 * length, LONGEST_ARC)


def _size(position: Array, squared: float) -> float:
    """Length of a step: the root mean square of the displacements, combined with the change of v^2."""
    return math.sqrt(float(position @ position) / position.size + squared * squared)


def _arc(film: Film, point: Point, before: Arc | None) -> Arc:
    """The point with the direction in which the path leads on from ``before``; at first towards higher voltage."""
    rate = _rate(film, point, "squared")
    size = _size(rate, 1.0)
    position, squared = rate / size, 1.0 / size
    if before is None:
        return Arc(point, position, squared, 0)
    if float(position @ before.position) / position.size + squared * before.squared < 0.0:
        position, squared = -position, -squared
    return Arc(point, position, squared, before.folds + (squared * before.squared < 0.0))


def _corrected(film: Film, here: Arc, length: float) -> Point | None:
    """The equilibrium in the plane across the path at a distance; None if Newton's method does not converge nearby."""
    guess = here.point.position + length * here.position
    position, squared = guess.copy(), here.point.squared + length * here.squared
    for _ in range(MOST_ARC_ITERATIONS):
        if not reachable(film, position) or not math.isfinite(squared):
            return None
        now = forces(film, position, squared)
        if _residual(now) <= ARC_TOLERANCE * now.scale:
            return newton(film, position, squared, LARGEST_CORRECTION * length)
        band = _regular(film, position, squared, now)
        toward, along = np.zeros_like(position), np.zeros_like(position)
        toward[FREE] = -_solved(band, now.internal)
        along[FREE] = -_solved(band, electric_forces(film, position, squared, now))
        out = float((position - guess + toward) @ here.position) / position.size
        out += (squared - here.point.squared - length * here.squared) * here.squared
        change = -out / (float(along @ here.position) / position.size + here.squared)
        position, squared = position + toward + change * along, squared + change
    return None
