"""Branch switching: the first points of the branch that is born at an event."""

from __future__ import annotations

import numpy as np

from gelcone.atlas.branches.branch import Event, EventKind, Walk, born_map
from gelcone.atlas.branches.event import DOUBLE
from gelcone.atlas.branches.point import Corrected, Direction, Metric, Point, correct, facing
from gelcone.motion.orbit import Shooting

SMALLEST_AMPLITUDE = 1e-5
LARGEST_AMPLITUDE = 0.05
"""Amplitudes of the first point of a branch that is born, as a share of the orbit's size."""
LARGEST_SHIFT = 0.01
"""Largest change of the parameter to the first point, as a share of its interval."""


def first_points(shooting: Shooting, event: Event, walk: Walk) -> tuple[Shooting, Point, Point] | None:
    """The first two points of the branch that is born at an event: the event, and an orbit next to it.

    The amplitude is reduced until the orbit lies before its own doubling; None where none is found.
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
        corrected: Corrected = correct(child, guess, tangent, metric)
        if corrected.point is not None and corrected.step < 0.3 * amplitude and corrected.point.tests[DOUBLE] > 0.0:
            start = Point(nodes, value, corrected.point.multipliers, tangent)
            return child, start, facing(corrected.point, tangent, metric)
        amplitude *= 0.4
    return None
