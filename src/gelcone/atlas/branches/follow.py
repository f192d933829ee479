"""Continuation of one branch of orbits in a parameter from a start to its ends, with the events on the way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gelcone.atlas.branches.branch import Branch, Ending, Walk
from gelcone.atlas.branches.checkpoint import Checkpoint
from gelcone.atlas.branches.crossing import events_between
from gelcone.atlas.branches.event import DOUBLE, FOLD, Singular, locate
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
    facing,
    point_between,
    way,
)
from gelcone.errors import InputError
from gelcone.motion.orbit import Kind, Shooting
from gelcone.quantity import Array

FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 0.005, 0.04, 1e-9
"""Steps along a branch, in units of the orbit's size and of the parameter's interval."""
AIM = 2e-3
"""Error of a guess at which the length of steps aims."""
LARGEST_GUESS_ERROR = 0.05
"""Largest error of a guess that is trusted; a larger one may have led to another branch."""
COLLAPSED = 1e-6
"""Ratio to its value before at which an orbit, or the difference between its halves, has collapsed."""
SAME_WAY = 0.8
"""Cosine of the largest turn from one point to the next."""
LONGEST_STEP_AT_REST = 0.005
CLOSE = 0.3
"""Share of its values at both points below which a parabola through a test function suggests two zeros in between."""


def follow(shooting: Shooting, start: Point, walk: Walk, *, both_ways: bool = True, resting: bool = False) -> Branch:
    """The branch through ``start``, whose tangent points forward."""
    forward = _follow(shooting, start, walk, resting)
    assert forward.ended is not None
    if forward.ended == Ending.CLOSED or not both_ways:
        branch = Branch(shooting, forward.points, forward.events, (forward.ended, forward.ended), resting=resting)
        branch.merges = [forward.merge] if forward.merge else []
        return branch
    backward = _follow(shooting, Point(start.nodes, start.value, start.multipliers, -start.tangent), walk, resting)
    assert backward.ended is not None
    turned = [Point(p.nodes, p.value, p.multipliers, -p.tangent) for p in backward.points[:0:-1]]
    count = len(turned)
    for event in forward.events:
        event.after += count
    for event in backward.events:
        event.after = count - 1 - event.after
    events = [*reversed(backward.events), *forward.events]
    merges = [merge for merge in (backward.merge, forward.merge) if merge is not None]
    return Branch(shooting, turned + forward.points, events, (backward.ended, forward.ended), merges, resting=resting)


def _follow(shooting: Shooting, start: Point, walk: Walk, resting: bool) -> Checkpoint:
    """The branch from ``start`` in the direction of its tangent, continued from the entry of the journal if any."""
    entry, whole = walk.journal.begin()
    way = Checkpoint.of(entry, shooting.kind) if entry else Checkpoint([start], FIRST_STEP)
    if whole:
        return way
    if not walk.low <= start.value + 1e-12 * walk.scale * np.sign(start.tangent.value) <= walk.high:
        way.finish(Ending.LIMIT)
    while way.ended is None:
        _take_step(shooting, way, walk, resting)
        walk.journal.note(way.arrays)
    walk.journal.end(way.arrays)
    return way


def _take_step(shooting: Shooting, way: Checkpoint, walk: Walk, resting: bool) -> None:
    """Takes a step to the next point or to an end; where neither is found, only shortens the step."""
    points, here = way.points, way.points[-1]
    metric = Metric.of(here.nodes, walk.scale)
    tangent = metric.unit(here.tangent)
    guess = _ahead(points[-2] if len(points) > 1 else None, here, tangent, metric, way.step)
    corrected = _corrected(shooting, guess, tangent, metric)
    point = corrected.point
    if point is None or not _trusted(shooting, here, corrected, tangent, metric, way.step, resting):
        way.step *= 0.4
        if way.step < SHORTEST_STEP:
            at_wall = Ending.PULLED_IN if shooting.pulled_in else Ending.WALL
            way.finish(Ending.IMPOSSIBLE if corrected.impossible else at_wall if corrected.left else Ending.STEP)
        return
    if not walk.low <= point.value <= walk.high:
        last = _at_border(shooting, here, point, walk, metric)
        if last is not None:
            way.events += events_between(shooting, here, last, len(points) - 1, walk, resting)
            way.finish(Ending.LIMIT, last)
            return
        way.step *= 0.5
        if way.step < SHORTEST_STEP:
            way.finish(Ending.LIMIT)
        return
    if not resting and len(points) > 1:
        if _passes_rest(shooting, here, point):
            way.finish(Ending.REST)
            return
        way.merge = _merge(shooting, here, point, walk.scale)
        if way.merge is not None:
            way.finish(Ending.MERGED, _merged(shooting, *way.merge, point))
            return
    between_them = _turned_back(shooting, points, point, metric)
    if between_them is not None:
        way.events += events_between(shooting, here, between_them, len(points) - 1, walk, resting)
        points.append(between_them)
        here = between_them
    way.events += events_between(shooting, here, point, len(points) - 1, walk, resting)
    points.append(point)
    walk.tick(point)
    if len(points) > 6 and _closes(points, metric, way.step):
        way.finish(Ending.CLOSED, points[0])
    elif len(points) >= walk.most:
        way.finish(Ending.POINTS)
    factor = min(max((AIM / max(corrected.step, 1e-12)) ** 0.25, 0.5), 1.7)
    way.step = min(way.step * factor, LONGEST_STEP_AT_REST if resting else LONGEST_STEP)


def _corrected(shooting: Shooting, guess: Direction, plane: Direction, metric: Metric) -> Corrected:
    """`correct`, also at values that make no actuator."""
    try:
        return correct(shooting, guess, plane, metric)
    except InputError:
        return Corrected(None, impossible=True)


def _trusted(
    shooting: Shooting,
    here: Point,
    found: Corrected,
    tangent: Direction,
    metric: Metric,
    step: float,
    resting: bool,
) -> bool:
    """True if the next point lies on the same branch."""
    point = found.point
    if point is None or not found.step < LARGEST_GUESS_ERROR * min(1.0, 20.0 * step):
        return False
    if not metric.inner(tangent, point.tangent) > SAME_WAY:
        return False
    return resting or not _collapsed(shooting, here, point)


def _turned_back(shooting: Shooting, points: list[Point], point: Point, metric: Metric) -> Point | None:
    """An orbit between the last point and the next at which a multiplier is beyond 1 or -1 although it is not at both:
    it has passed twice. Computed only where the parabola through the last three values of the test function comes close
    to zero in between; None where there is none."""
    if len(points) < 2:
        return None
    before, here = points[-2], points[-1]
    back, ahead = metric.length(way(before, here)), metric.length(way(here, point))
    for at in (FOLD, DOUBLE):
        first, middle, last = (float(np.prod(1.0 - at * p.multipliers).real) for p in (before, here, point))
        if middle * last <= 0.0:
            continue
        back_slope, ahead_slope = (middle - first) / back, (last - middle) / ahead
        bend = (ahead_slope - back_slope) / (back + ahead)
        slope = ahead_slope - bend * ahead
        share = -slope / (2.0 * bend * ahead) if bend * middle > 0.0 else 0.0
        if not 0.0 < share < 1.0 or (middle + 0.5 * slope * share * ahead) / middle > CLOSE * min(1.0, last / middle):
            continue
        orbit = point_between(shooting, here, point, share, metric)
        if orbit is not None and orbit.tests[at] * middle < 0.0:
            return orbit
    return None


def _ahead(before: Point | None, here: Point, tangent: Direction, metric: Metric, step: float) -> Direction:
    """The guess a step ahead: on the cubic through the last two points with the tangents there."""
    if before is None:
        return along(here, tangent, step)
    apart = metric.length(way(before, here))
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
    guess = between(here, beyond, share, metric.value)
    corrected = at_value(shooting, guess.nodes, border, metric)
    if corrected.point is None or corrected.step > LARGEST_GUESS_ERROR:
        return None
    return replace(facing(corrected.point, beyond.tangent, metric), value=border)


# --- ends within the interval -----------------------------------------------------------------------------------------


def _passes_rest(shooting: Shooting, here: Point, point: Point) -> bool:
    """True if the branch passes rest between two points, where it would continue as its own mirror image."""
    if not shooting.symmetric:
        return False
    return bool((here.nodes[:, :2] * point.nodes[:, :2]).sum() < 0.0)


def _collapsed(shooting: Shooting, here: Point, point: Point) -> bool:
    """True if a step led from a branch to one from which it was born: rest, or orbits of half the period."""
    size = float(np.abs(here.nodes).max())
    if shooting.symmetric and size > COLLAPSED and np.abs(point.nodes[:, :2]).max() < COLLAPSED * size:
        return True
    pairs = zip(halves_apart(shooting, here.nodes), halves_apart(shooting, point.nodes), strict=True)
    return any(np.abs(after).max() < COLLAPSED * size < np.abs(before).max() for (_, before), (_, after) in pairs)


def halves_apart(shooting: Shooting, nodes: Array) -> list[tuple[Kind, Array]]:
    """Differences between the halves of an orbit, for each map over half the repeats whose fixed point it may
    become."""
    kind, half = shooting.kind, len(nodes) // 2
    if kind.repeats % 2 or kind.reflected:
        return []
    kinds = [Kind(kind.repeats // 2)] + [Kind(kind.repeats // 2, True)] * shooting.symmetric
    return [(k, nodes[half:] - shooting.of_kind(k).signs * nodes[:half]) for k in kinds]


def _merge(shooting: Shooting, here: Point, point: Point, scale: float) -> tuple[Kind, Singular] | None:
    """The map and the orbit of half the period with which the branch merges between two points; None where it does
    not."""
    for (kind, before), (_, after) in zip(
        halves_apart(shooting, here.nodes), halves_apart(shooting, point.nodes), strict=True
    ):
        if (before * after).sum() >= 0.0:
            continue
        size_before, size_after = np.abs(before).max(), np.abs(after).max()
        guess = between(here, point, size_before / (size_before + size_after), scale)
        parent = shooting.of_kind(kind)
        half = len(guess.nodes) // 2
        nodes = 0.5 * (guess.nodes[:half] + parent.signs * guess.nodes[half:])
        orbit = locate(parent, nodes, np.array([guess.value]), DOUBLE, 0.5)
        if orbit is not None:
            return kind, orbit
    return None


def _merged(shooting: Shooting, kind: Kind, merge: Singular, beyond: Point) -> Point:
    """The last point of a branch that merges: the orbit of half the period, repeated."""
    nodes = np.concatenate([merge.nodes, shooting.of_kind(kind).signs * merge.nodes])
    return Point(nodes, float(merge.values[0]), beyond.multipliers, beyond.tangent)


def _closes(points: list[Point], metric: Metric, step: float) -> bool:
    """True if the last step passed the start in the direction of its tangent."""
    start, here, before = points[0], points[-1], points[-2]
    if min(abs(here.value - start.value), abs(before.value - start.value)) > 2.0 * step * metric.value:
        return False
    apart, earlier = way(start, here), way(start, before)
    if metric.length(apart) > 2.0 * step or metric.length(earlier) > 2.0 * step:
        return False
    tangent = metric.unit(start.tangent)
    passed = metric.inner(apart, tangent) >= 0.0 >= metric.inner(earlier, tangent)
    return passed and metric.inner(here.tangent, tangent) > 0.0
