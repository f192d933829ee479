"""Curves of bifurcations in two parameters, with the points of codimension two on them.

A singular orbit has one condition more than an orbit, and with one parameter more it is followed like one: the extended
system of `gelcone.atlas.branches.event` with the pseudo-arclength condition. On a curve of folds the quadratic
coefficient passes 0 at a cusp; on curves of period doublings and symmetry breakings the cubic one passes 0 where super-
and subcritical meet. Kuznetsov, Elements of Applied Bifurcation Theory (2004), chapters 8 and 9.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone import dataset
from gelcone.atlas.branches.branch import Ending, EventKind, Walk, multipliers_of_period
from gelcone.atlas.branches.check import brute_force, cover
from gelcone.atlas.branches.continuation import CHECKS, FOLLOWING, grown, point_by_point
from gelcone.atlas.branches.event import FOLD, Singular, born, locate
from gelcone.atlas.branches.point import SMALLEST, cubic_weights
from gelcone.atlas.branches.tree import distance
from gelcone.atlas.branches.varied import Varied, vary
from gelcone.atlas.plan import DEFAULT_INITIAL
from gelcone.codes import Outcome
from gelcone.devices.analysis import for_swept_devices
from gelcone.devices.device import Device
from gelcone.errors import InputError, unknown_name
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.orbit import Shooting
from gelcone.physics.model import ConeModel
from gelcone.progress import Counted, Progress
from gelcone.quantity import Array, check_count

if TYPE_CHECKING:
    import xarray as xr

FOLLOWED = {
    "fold": EventKind.FOLD,
    "period doubling": EventKind.PERIOD_DOUBLING,
    "symmetry breaking": EventKind.SYMMETRY_BREAKING,
}
"""Events that can be followed; rest's own curves are the tongues."""
SHORT_NAMES = {"doubling": "period doubling", "breaking": "symmetry breaking"}
FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 0.01, 0.04, 1e-7
AIM = 2e-3
"""How far a guess should be off; the steps are made so long."""
FARTHEST = 0.05
SAME_WAY = 0.8
SECANTS = 40
CURVES = 60
"""Most curves that are followed."""
AT_REST = 1e-4
"""Orbits smaller than this, as a share of the largest on their curve, are rest."""


@dataclass
class Curve:
    """A curve of singular orbits: the ``points`` in order, the points of codimension two, what ended it."""

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
        return self.high - self.low

    def holds(self, values: Array) -> bool:
        slack = 1e-9 * self.scale
        return bool((values >= self.low - slack).all() and (values <= self.high + slack).all())


@for_swept_devices
def locus(
    model: ConeModel | Device,
    event: str,
    over: Mapping[str, tuple[Any, Any]],
    initial: Any = DEFAULT_INITIAL,
    *,
    start: str = "rest",
    switch: int = 1,
    checks: int = CHECKS,
    points: int = 1000,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Curves of folds, period doublings or symmetry breakings in two parameters, with their points of codimension two.

    The branches along the first parameter, at the model's own value of the second, give the events; each is followed
    both ways until it leaves the rectangle, closes, or cannot be followed.

    Parameters
    ----------
    model : a single model, or a device; the two parameters replace its own.
    event : "fold", "period doubling" (or "doubling") or "symmetry breaking" (or "breaking").
    over : the two parameters of the model, or fields of the device, each with the ends of its interval, of a device in
        SI or texts with units; the second interval holds the model's own value.
    initial : displacement and velocity from which brute force settles. Default (1, 0), or the device's own.
    start, switch, checks : as in `continue_branch`.
    points : most points of a curve, at least 2. Default 1000.
    tolerance : relative error of one step of the integrator. Default 1e-15.
    threads : worker threads of brute force; default one a core.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over ``curve``, ``point``, ``state`` and ``event``, padded with NaN: the two parameters under their own
    names and the ``orbit`` at phase 0 (``curve``, ``point``), ``coefficient``, whose zeros are the points of
    codimension two, ``curvature`` (positive: the branch that is born lies above the value of the first parameter); of
    each curve ``period``, ``symmetric`` and ``ended``; of each event ``event_kind`` (cusp, generalised doubling,
    degenerate symmetry breaking), ``event_first`` and ``event_second`` with errors, ``event_curve``, and its
    multipliers.

    Raises
    ------
    InputError : for an unknown event, other than two parameters, intervals that are empty or reversed, or no such
        event.
    """
    kind = find_kind(event)
    names = list(over)
    if len(names) != 2:
        raise InputError(f"over: a locus takes two parameters, not {len(names)}; for one, use continue_branch")
    varied = vary(model, over, initial)
    for name, count, least in (("switch", switch, 0), ("checks", checks, 2), ("points", points, 2)):
        check_count(name, count, least)
    own = _own_value(varied)
    counted, flow = Counted(progress), {"tolerance": tolerance, "threads": threads}
    across = vary(varied.target_at(names[1], own), {names[0]: over[names[0]]}, initial)
    (low,), (high,) = across.ends
    states = across.starts([0.5 * (low + high)])
    line = across.shooting(tolerance)
    walk = Walk(float(low), float(high), tick=point_by_point(counted, FOLLOWING))
    tree = grown(line, across, walk, start, states, switch, flow)
    runs = brute_force(walk, line, np.linspace(low, high, checks), np.concatenate([states, 0.05 * states]), **flow)
    cover(tree, line, runs, **flow)
    seeds = [e for branch in tree.branches for e in branch.events if e.kind == kind and e.resolved]
    if not seeds:
        raise InputError(
            f"event = {event}: none lies on {names[0]} from {across.said(low)} to {across.said(high)} at "
            f"{names[1]} = {own:g}; take a wider interval, or see what there is with continue_branch"
        )
    own /= float(varied.scales[1])
    stretched = float(across.scales[0] / varied.scales[0])
    window = Window(*varied.ends, points)
    plane = varied.shooting(tolerance)
    curves: list[Curve] = []
    for seed in seeds:
        shooting = plane.of_kind(seed.map)
        if len(curves) >= CURVES or _known(curves, shooting, seed.orbit, stretched * seed.value, own):
            continue
        nodes = _renoded(tree.branches[seed.branch].shooting, shooting, seed.orbit.nodes, seed.value)
        curve = follow_curve(shooting, kind, nodes, np.array([stretched * seed.value, own]), seed.orbit.at, window)
        if curve is not None:
            curves.append(curve)
        counted((1.0 - FOLLOWING) / len(seeds))
    options = {
        "event": kind.label,
        "over": {n: [float(a), float(b)] for n, a, b in zip(names, varied.low, varied.high, strict=True)},
        "initial": varied.plan.initial,
        "start": start,
        "switch": switch,
        "checks": checks,
        "points": points,
        "tolerance": tolerance,
    }
    result = _label(varied, curves, options)
    counted.finish()
    return result


def find_kind(event: str) -> EventKind:
    """The kind of event of that name; `InputError` with the nearest when there is none."""
    name = event.replace("-", " ").replace("_", " ")
    name = SHORT_NAMES.get(name, name)
    if name == "loss of rest":
        raise InputError("event = loss of rest: its curves are the instability tongues; use tongues")
    if name not in FOLLOWED:
        raise unknown_name("event that can be followed", event, FOLLOWED)
    return FOLLOWED[name]


def _own_value(varied: Varied) -> float:
    """The actuator's own value of the second parameter, at which the events are looked for."""
    name, low, high = varied.names[1], float(varied.low[1]), float(varied.high[1])
    target = varied.target
    own = target.get(name) if isinstance(target, Device) else target.values[name]
    if own is None or not low <= float(own) <= high:
        what = "is not given" if own is None else f"is {float(own):g}"
        raise InputError(
            f"{name} from {low:g} to {high:g}: must hold the model's own value, which {what}, and at which the "
            "events are looked for; set it, or move the interval"
        )
    return float(own)


def _renoded(old: Shooting, new: Shooting, nodes: Array, value: float) -> Array:
    """The nodes of an orbit for another number of segments."""
    from gelcone.motion.flow import integrate

    if old.segments == new.segments:
        return nodes
    if new.segments < old.segments:
        return nodes[:: old.segments // new.segments]
    finer = new.segments // old.segments
    members = old.members_at((np.full(len(nodes), value),))
    start = np.tile(np.arange(old.segments) / old.segments, old.kind.repeats) * members.forcing_period
    step = members.forcing_period / new.segments
    times = start[:, None] + step[:, None] * np.arange(finer)
    return np.asarray(integrate(members, nodes, times, start=start).states.reshape(-1, nodes.shape[1]))


def _known(curves: list[Curve], shooting: Shooting, orbit: Singular, first: float, second: float) -> bool:
    """Whether an event lies on a curve that has been followed."""
    for curve in curves:
        if curve.shooting.kind != shooting.kind or curve.points[0].at != orbit.at:
            continue
        heights = np.array([point.values[1] for point in curve.points])
        for k in np.flatnonzero((heights[1:] - second) * (heights[:-1] - second) <= 0.0):
            a, b = curve.points[k], curve.points[k + 1]
            share = 0.5 if heights[k] == heights[k + 1] else (second - heights[k]) / (heights[k + 1] - heights[k])
            value = a.values[0] + share * (b.values[0] - a.values[0])
            width = abs(b.values[0] - a.values[0]) + 1e-3 * abs(value)
            nodes = a.nodes + share * (b.nodes - a.nodes)
            stride = max(len(nodes) // len(orbit.nodes), 1)
            same = nodes[::stride].shape == orbit.nodes.shape
            if abs(value - first) < 0.2 * width and same:
                close = distance(curve.shooting, nodes, nodes) == 0.0 and np.abs(nodes[::stride] - orbit.nodes).max()
                mirrored = np.abs(curve.shooting.system.mirror * nodes[::stride] - orbit.nodes).max()
                if min(float(close), float(mirrored)) < 0.1 * np.abs(orbit.nodes).max():
                    return True
    return False


def follow_curve(
    shooting: Shooting, kind: EventKind, nodes: Array, values: Array, at: float, window: Window
) -> Curve | None:
    """The curve of singular orbits through a guess, both ways; None where there is none."""
    across = (np.zeros_like(nodes), np.array([0.0, 1.0 / window.scale[1] ** 2]))
    first = locate(shooting, nodes, values, at, 0.5, across)
    if first is None or first.ahead is None:
        return None
    forward, ended = _walk(shooting, kind, first, window, 1.0)
    backward, began = [first], ended
    if ended != Ending.CLOSED:
        backward, began = _walk(shooting, kind, first, window, -1.0)
    points = [*backward[:0:-1], *forward]
    curve = Curve(shooting, kind, points, [], [], (began, ended))
    curve.tests = _tests(shooting, points)
    _find_special(curve, window)
    return curve


def _scaled(shooting: Shooting, point: Singular, window: Window) -> tuple[Array, Array]:
    """Weights of nodes and values in the length of a step."""
    states = np.maximum(np.abs(point.nodes).max(axis=0), SMALLEST)
    return 1.0 / (np.square(states) * len(point.nodes)), 1.0 / np.square(window.scale)


def _walk(
    shooting: Shooting, kind: EventKind, first: Singular, window: Window, way: float
) -> tuple[list[Singular], Ending]:
    """The curve from its first point one way."""
    points, step = [first], FIRST_STEP
    assert first.ahead is not None
    direction = way * first.ahead[0], way * first.ahead[1]
    before: tuple[Singular, tuple[Array, Array]] | None = None
    size = float(np.abs(first.nodes).max())
    while len(points) < window.most:
        here = points[-1]
        by_states, by_values = _scaled(shooting, here, window)

        def length(nodes: Array, values: Array, weights: tuple[Array, Array] = (by_states, by_values)) -> float:
            return float(np.sqrt(np.sum(weights[0] * nodes**2) + np.sum(weights[1] * values**2)))

        whole = length(*direction)
        tangent = direction[0] / whole, direction[1] / whole
        plane = by_states * tangent[0], by_values * tangent[1]
        guess = here.nodes + step * tangent[0], here.values + step * tangent[1]
        if before is not None:
            one, back = before
            apart, scale = length(here.nodes - one.nodes, here.values - one.values), length(*back)
            weights = cubic_weights(1.0 + step / apart) * np.array([1.0, 1.0, apart / scale, apart])
            guess = (
                weights[0] * one.nodes + weights[1] * here.nodes + weights[2] * back[0] + weights[3] * tangent[0],
                weights[0] * one.values + weights[1] * here.values + weights[2] * back[1] + weights[3] * tangent[1],
            )
        found = locate(shooting, guess[0], guess[1], here.at, 0.3, plane, here)
        good = found is not None and found.ahead is not None
        if good and found is not None and found.ahead is not None:
            off = length(found.nodes - guess[0], found.values - guess[1])
            ahead = length(*found.ahead)
            turn = (np.sum(plane[0] * found.ahead[0]) + np.sum(plane[1] * found.ahead[1])) / ahead
            good = off < 0.3 * step and float(turn) > SAME_WAY
        if not good or found is None or found.ahead is None:
            step *= 0.4
            if step < SHORTEST_STEP:
                return points, Ending.STEP
            continue
        if not window.holds(found.values):
            last = _at_border(shooting, here, found, window)
            return [*points, last] if last is not None else points, Ending.LIMIT
        if np.abs(found.nodes).max() < AT_REST * size:
            return points, Ending.REST
        points.append(found)
        size = max(size, float(np.abs(found.nodes).max()))
        if len(points) > 6 and length(found.nodes - first.nodes, found.values - first.values) < 0.7 * step:
            return [*points, first], Ending.CLOSED
        before, direction = (here, direction), found.ahead
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
    return locate(shooting, nodes, values, here.at, 0.3, (np.zeros_like(nodes), corner), here)


# --- points of codimension two ----------------------------------------------------------------------------------------


def _tests(shooting: Shooting, points: list[Singular]) -> list[float]:
    """The coefficient that passes 0 at a point of codimension two, with one orientation along the curve."""
    tests, sign = [], 1.0
    for k, point in enumerate(points):
        if k:
            sign *= _turned(points[k - 1], point)
        tests.append(sign * _coefficient(shooting, point))
    return tests


def _turned(one: Singular, other: Singular) -> float:
    """Sign by which the coefficient changes because null vector or weights turned round: the fold's is even in the null
    vector, the others' odd."""
    left = np.sign(np.sum(one.left * other.left))
    null = np.sign(np.sum(one.null * other.null))
    return float(left if one.at == FOLD else left * null)


def _coefficient(shooting: Shooting, point: Singular) -> float:
    """The quadratic coefficient of a fold, the cubic one of the others."""
    scale = float(np.linalg.norm(point.left)) or 1.0
    if point.at == FOLD:
        return point.quadratic / scale
    try:
        return born(shooting, point).cubic / scale
    except np.linalg.LinAlgError:
        return np.nan


_SPECIAL = {
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
        found = _zero(curve, int(k), window)
        if found is not None:
            curve.special.append((found, int(k)))


def _reverses(curve: Curve, k: int, window: Window) -> bool:
    """Whether the curve turns back between two points, as it does at a cusp."""
    values = np.array([point.values for point in curve.points[max(k - 1, 0) : k + 3]]) / window.scale
    steps = np.diff(values, axis=0)
    return bool(np.sum(steps[0] * steps[-1]) < 0.0)


def _zero(curve: Curve, k: int, window: Window) -> Singular | None:
    """The zero of the coefficient between two points: regula falsi with the Illinois rule along their chord."""
    shooting, a, b = curve.shooting, curve.points[k], curve.points[k + 1]
    by_states, by_values = _scaled(shooting, a, window)
    chord = by_states * (b.nodes - a.nodes), by_values * (b.values - a.values)
    low, high, below, above = 0.0, 1.0, _coefficient(shooting, a), _turned(a, b) * _coefficient(shooting, b)
    point, side, width = a, 0, np.inf
    for _ in range(SECANTS):
        share = (low * above - high * below) / (above - below)
        share = min(max(share, low + 1e-3 * (high - low)), high - 1e-3 * (high - low))
        nodes, values = a.nodes + share * (b.nodes - a.nodes), a.values + share * (b.values - a.values)
        found = locate(shooting, nodes, values, a.at, 0.5, chord, a)
        if found is None:
            return None
        width = float(np.abs((found.values - point.values) / window.scale).max())
        point, test = found, _turned(a, found) * _coefficient(shooting, found)
        if width < 1e-14 or high - low < 1e-13 or test == 0.0:
            break
        if test * below > 0.0:
            low, below, above, side = share, test, above * (0.5 if side == -1 else 1.0), -1
        else:
            high, above, below, side = share, test, below * (0.5 if side == 1 else 1.0), 1
    # at a pole, or where a vector turned round, the coefficient changes its sign without getting small
    least = min(abs(curve.tests[k]), abs(curve.tests[k + 1]))
    return point if abs(_coefficient(shooting, point)) < 1e-3 * least else None


# --- labels -----------------------------------------------------------------------------------------------------------


def _label(varied: Varied, curves: list[Curve], options: dict[str, Any]) -> xr.Dataset:
    names = varied.names
    special = [(number, point, after) for number, curve in enumerate(curves) for point, after in curve.special]
    longest = max(len(curve.points) for curve in curves)
    size = curves[0].shooting.size
    blank = np.full((len(curves), longest), np.nan)
    values = [blank.copy(), blank.copy()]
    coefficient, curvature = blank.copy(), blank.copy()
    orbit = np.full((*blank.shape, size), np.nan)
    for k, curve in enumerate(curves):
        count = len(curve.points)
        for axis in range(2):
            values[axis][k, :count] = [varied.scales[axis] * point.values[axis] for point in curve.points]
        coefficient[k, :count] = curve.tests
        orbit[k, :count] = [point.nodes[0] for point in curve.points]
        if curve.kind != EventKind.FOLD:
            curvature[k, :count] = [_curvature(curve.shooting, point) for point in curve.points]
    multipliers = np.array(
        [multipliers_of_period(curves[n].shooting.kind, p.multipliers) for n, p, _ in special], dtype=complex
    ).reshape(-1, size)
    kinds = [_SPECIAL[curves[number].kind] for number, _, _ in special]
    each, of, at = ("curve", "point"), ("curve",), ("event",)
    reflected = np.array([curve.shooting.kind.reflected for curve in curves], dtype=np.int8)
    states = np.array([point.nodes[0] for _, point, _ in special]).reshape(-1, size)
    variables: dict[str, dataset.Variable] = {
        "orbit": ((*each, "state"), orbit, "states at phase 0", "state"),
        "coefficient": (each, coefficient, "coefficient that passes 0 at a point of codimension two", "coefficient"),
        "curvature": (each, curvature, "curvature of the branch that is born", "coefficient"),
        "period": (of, np.array([c.shooting.kind.period for c in curves]), "period in forcing periods", "count"),
        "symmetric": (of, reflected, "own mirror image", "flag"),
        "ended": ((*of, "end"), np.array([c.ended for c in curves], dtype=np.int8), "why the curve ends", "flag"),
        "event_kind": (at, np.array(kinds, dtype=np.int8), "kind of point", "flag"),
        "event_curve": (at, np.array([n for n, _, _ in special], dtype=int), "its curve", "count"),
        "event_point": (at, np.array([k for _, _, k in special], dtype=int), "point of the curve before it", "count"),
        "event_orbit": ((*at, "state"), states, "states at phase 0", "state"),
        "event_multiplier_real": ((*at, "multiplier"), multipliers.real, "real part", "multiplier"),
        "event_multiplier_imag": ((*at, "multiplier"), multipliers.imag, "imaginary part", "multiplier"),
    }
    for k, (place, name) in enumerate(zip(("first", "second"), names, strict=True)):
        own = np.array([point.values[k] for _, point, _ in special])
        variables[name] = (each, values[k], "", "")
        variables[f"event_{place}"] = (at, varied.scales[k] * own, "", "")
        errors = varied.scales[k] * ERROR * np.maximum(np.abs(own), 1.0)
        variables[f"event_{place}_error"] = (at, errors, "error of the value", "")
    cone = varied.plan.cone
    result = dataset.label(cone, variables, outcome=np.array(Outcome.OK), options=options, title="locus")
    for k, (place, name) in enumerate(zip(("first", "second"), names, strict=True)):
        for own_name in (name, f"event_{place}", f"event_{place}_error"):
            told = result[own_name].attrs["long_name"]
            result[own_name].attrs |= varied.attributes(k) | ({"long_name": told} if told else {})
    result["orbit"].attrs |= varied.along(*names)
    result["event_orbit"].attrs |= varied.along("event_first", "event_second")
    result["ended"].attrs |= dataset.flags(Ending)
    result["event_kind"].attrs |= dataset.flags(EventKind)
    return result.assign_attrs(parameters=",".join(names), event=curves[0].kind.label, **varied.about)


ERROR = 1e-10
"""Error of a point of codimension two, relative to values of order 1: what differences leave of its coefficient."""


def _curvature(shooting: Shooting, point: Singular) -> float:
    """That of the branch born there."""
    try:
        return born(shooting, point).curvature
    except np.linalg.LinAlgError:
        return np.nan
