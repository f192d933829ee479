"""The wrinkling membrane at a held disc under rising voltage, until it falls slack or pulls in.

A film that bears no compression pulls in where one of its rings does: where the ring's tension no longer grows with its
length (loss of strong ellipticity of the relaxed energy along the meridian, the criterion of Greaney, Meere and Zurlo,
J. Mech. Phys. Solids 122 (2019) 84). Rings are in series, so that the strain concentrates in the soft one. With the
relaxed energy phi_r over the squared meridional length m, a ring is firm while

    d^2 phi_r/d(sqrt m)^2 = 2 phi_m + 4 m phi_mm > 0.

Lengths change continuously along the film: if the lengths of two neighbouring nodes lie on either side of a length that
is not firm, a ring between them has pulled in. A slack film pulls in at the voltage at which a free film does.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gelcone.continuum import density
from gelcone.continuum.mesh import SLACK_STIFFNESS, Film, stretches
from gelcone.continuum.path import Ending, Point, reach, settled, step
from gelcone.membrane.force import NEVER
from gelcone.physics.component import Numbers
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

TOLERANCE = 1e-3
"""Relative width of the bracket of the V at which a film pulls in."""
SHORTEST = 0.3
"""Share of a whole step below which a film that cannot be followed further has ended."""
SLACK_SHARE = 2e-3
"""Share of the force without voltage that, added to the force of the net, counts as no force."""
FIRST, FIRST_STEPS = 0.25, 4
"""Length of the first steps over that of the others, and their number: there hoops begin to fall slack."""
NEARLY_SLACK = 0.02
"""Share of the force without voltage below which a film that cannot be followed further is falling slack."""
NEARLY_SOFT = 0.05
"""Share of the tangent stiffness without voltage below which a film that cannot be followed further is pulling in."""
BETWEEN = 5
"""Intervals between the lengths of neighbouring nodes, at whose ends tangent stiffness is evaluated."""
NEAR = 0.3
"""Largest displacement, in b - a, between two voltages."""
LARGEST_JUMP = 0.1
"""Largest relative change of a squared length between two voltages of a film that was not followed by its tangent."""


class Charged(NamedTuple):
    """States in tension at one height, in order of rising voltage.

    ``end`` is the V at which they end, ``error`` half the width of its bracket. ``ending`` is `Ending.SLACK`,
    `Ending.PULLED_IN`, `Ending.NOT_CONVERGED` where they could not be followed further, or `Ending.CONVERGED` where
    they continue beyond the highest voltage.
    """

    points: list[Point]
    end: float
    error: float
    ending: Ending


def charged(film: Film, start: Point, highest: float, whole: float, *, tolerance: float = TOLERANCE) -> Charged:
    """The states of a relaxed film from ``start`` to V = ``highest`` in ``whole`` steps, or until it ends."""
    points, low, high, ending = [start], start.squared, np.inf, Ending.CONVERGED
    pace = whole
    weakest = SLACK_SHARE * start.force + 10.0 * SLACK_STIFFNESS * start.height
    if start.force <= weakest:
        return Charged(points, low, 0.0, Ending.SLACK)
    while low < highest * (1.0 - 1e-12) and (np.isinf(high) or high - low > tolerance * high):
        next_step = FIRST * pace if len(points) <= FIRST_STEPS else pace
        target = min(low + next_step, highest) if np.isinf(high) else 0.5 * (low + high)
        point = follow(film, points[-1], target)
        if point is None and np.isinf(high) and pace > SHORTEST * whole:
            pace *= 0.5
            continue
        if point is None and np.isinf(high):
            point = reach(film, points[-1], "squared", target)[0]
        if point is None:
            high, ending = target, Ending.NOT_CONVERGED
        elif tangent_stiffness(film, point, target) <= 0.0:
            high, ending = target, Ending.PULLED_IN
        elif point.force <= weakest:
            high, ending = target, Ending.SLACK
        else:
            low = target
            points.append(point)
    if np.isinf(high):
        return Charged(points, low, 0.0, Ending.CONVERGED)
    if ending == Ending.NOT_CONVERGED:
        ending = _why_lost(film, start, points[-1], high * (1.0 + tolerance))
    return Charged(points, 0.5 * (low + high), 0.5 * (high - low), ending)


def _why_lost(film: Film, start: Point, last: Point, beyond: float) -> Ending:
    """The ending of a film without a state found between the V of ``last`` and ``beyond``: pulled in if a ring is
    nearly soft, slack if the film nearly is."""
    if tangent_stiffness(film, last, beyond) < NEARLY_SOFT * tangent_stiffness(film, start, start.squared):
        return Ending.PULLED_IN
    return Ending.SLACK if last.force < NEARLY_SLACK * start.force else Ending.NOT_CONVERGED


def follow(film: Film, point: Point, target: float) -> Point | None:
    """The state at a nearby V = ``target``; None where none is found, or only after a jump of a ring in tension."""
    next_point = step(film, point, "squared", target)
    if next_point is None:
        next_point = settled(film, point.position, target, NEAR)
        if next_point is not None:
            before, after = (_lengths(film, state) for state in (point, next_point))
            tense = (
                density.relaxed_derivatives(film.model.gel_law(), film.coefficients, *before, point.squared, 0.0).m
                > 10.0 * SLACK_STIFFNESS
            )
            change = np.abs(after[0] / before[0] - 1.0)
            next_point = next_point if np.max(change, where=tense, initial=0.0) < LARGEST_JUMP else None
    return next_point


def _lengths(film: Film, point: Point) -> tuple[Array, Array]:
    """Squared meridional and hoop length over the mounted ones, along the film, at the nodes of each element."""
    along, up, hoop = (values[:, [0, 2, 1]].ravel() for values in stretches(film, point.position, film.at_nodes))
    return along * along + up * up, hoop * hoop


def tangent_stiffness(film: Film, point: Point, squared: float) -> float:
    """The smallest slope of the tension over the length of all rings in tension, at nodes and between them, at the
    V ``squared``. The film pulls in where it is not positive."""
    places = np.arange(len(film.unknowns) * 3)
    fine = np.linspace(0.0, places[-1], BETWEEN * places[-1] + 1)
    m, n = (np.interp(fine, places, lengths) for lengths in _lengths(film, point))
    d = density.relaxed_derivatives(film.model.gel_law(), film.coefficients, m, n, squared, 0.0)
    slope = np.where(d.m > 10.0 * SLACK_STIFFNESS, 2.0 * d.m + 4.0 * m * d.mm, np.inf)
    return float(np.min(np.where(np.isnan(d.m), -np.inf, slope)))


def slack_limit(model: ConeModel) -> float:
    """The V above which a slack film has pulled in; `NEVER` where it does not pull in."""
    return min(float(_numbers(model)["limit_squared"]), NEVER)


def _numbers(model: ConeModel) -> Numbers:
    """Numbers of the wrinkling cone of the same film."""
    cone = WrinklingCone(law=model.gel_law())
    lm, lh = model.stretches
    law_numbers = {name: model.values[name] for name in model.gel_law().parameters}
    return cone.numbers(cone.complete(law_numbers | {"meridional_prestretch": lm, "hoop_prestretch": lh}))
