"""Curves of bifurcations in two parameters, with the points of codimension two on them.

A singular orbit meets one condition more than an orbit. With a second parameter it is followed like an orbit, by the
extended system of `gelcone.atlas.branches.event` with the pseudo-arclength condition. On a curve of folds the quadratic
coefficient passes 0 at a cusp; on curves of period doublings and symmetry breakings the cubic one passes 0 where super-
and subcritical meet. Kuznetsov, Elements of Applied Bifurcation Theory (2004), chapters 8 and 9.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone import dataset
from gelcone.atlas.branches.branch import Ending, EventKind, Walk, multipliers_of_period
from gelcone.atlas.branches.check import brute_force, cover
from gelcone.atlas.branches.continuation import CHECKS, FOLLOWING, check_following, grown, point_by_point
from gelcone.atlas.branches.curve import SPECIAL, Curve, Window, follow_curve
from gelcone.atlas.branches.event import Singular, born
from gelcone.atlas.branches.varied import Varied, vary
from gelcone.atlas.plan import DEFAULT_INITIAL
from gelcone.codes import Outcome
from gelcone.devices.analysis import analysis
from gelcone.devices.device import Device
from gelcone.errors import InputError, unknown_name
from gelcone.motion.flow import DEFAULT_TOLERANCE, integrate
from gelcone.motion.orbit import Shooting
from gelcone.physics.model import ConeModel
from gelcone.progress import Counted, Progress
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

FOLLOWED = {kind.words: kind for kind in SPECIAL}
"""Events that can be followed; `tongues` computes the curves at which rest loses stability."""
SHORT_NAMES = {"doubling": "period doubling", "breaking": "symmetry breaking"}
CURVES = 60
"""Most curves that are followed."""


@analysis(
    arguments={"event": "EVENT"},
    flags={"start": ("--from",)},
    answers="branches",
    file_only=("orbit", "event_orbit"),
    over="One of the two parameters, or fields of a device, NAME=from:to; the second interval holds the value that "
    "is set.",
    single=True,
    takes="device",
    examples=(
        "fold --preset base --over voltage=0.95:1.5 --over drive_frequency=0.07:0.13 --out results",
        "fold --preset base --over voltage=0.95:1.5 --over drive_frequency=0.07:0.13 --on map.nc --out results",
        "doubling --preset base --over voltage=0.9:1.8 --over hoop_prestretch=0.7:1.4 --set hoop_prestretch=1",
    ),
)
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

    The branches along the first parameter, at the model's value of the second, give the events; each is followed
    both ways until it leaves the rectangle, closes, or cannot be followed.

    Parameters
    ----------
    model : a single model, or a device; the two parameters replace its own.
    event : "fold", "period doubling" (or "doubling") or "symmetry breaking" (or "breaking").
    over : the two parameters of the model, or fields of the device, each with the ends of its interval, of a device in
        SI or texts with units; the second interval holds the model's value.
    initial : displacement and velocity from which brute force settles. Default (1, 0), or that of the device.
    start : where the branches begin that hold the events: "rest" and what is born there, or "settled", the motions at
        the ends of the first interval. Default "rest".
    switch, checks : as in `continue_branch`.
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
    multipliers. Values of which no actuator can be made are left out as in `continue_branch`: an interval is cut before
    them, at the model's value of the other, ``attrs["impossible"]`` states value and reason, and a curve ends where it
    meets others.

    Raises
    ------
    InputError : for an unknown event, other than two parameters, intervals that are empty or reversed, or no such
        event.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(
    ...     damping_ratio=0.01, voltage=0.06, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4, law="neo-hookean"
    ... )
    >>> over = {"drive_frequency": (1.4, 1.43), "voltage": (0.05, 0.07)}
    >>> curves = gelcone.locus(model, "fold", over, checks=2)
    >>> curves.sizes["curve"], [round(float(value), 4) for value in curves.event_first.values]
    (2, [])
    """
    kind = find_kind(event)
    names = list(over)
    if len(names) != 2:
        raise InputError(f"over: a locus takes two parameters, not {len(names)}; for one, use continue_branch")
    varied = vary(model, over, initial)
    counts = {"switch": switch, "checks": checks, "points": points}
    check_following(counts, tolerance, threads)
    second = _own_value(varied)
    counted, flow = Counted(progress), {"tolerance": tolerance, "threads": threads}
    across = vary(model, {names[0]: over[names[0]]}, initial)
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
            f"{names[1]} = {varied.worded(second, 1)}; take a wider interval, or see what there is with continue_branch"
        )
    second /= float(varied.scales[1])
    stretched = float(across.scales[0] / varied.scales[0])
    window = Window(*varied.ends, points)
    plane = varied.shooting(tolerance)
    curves: list[Curve] = []
    for seed in seeds:
        shooting = plane.of_kind(seed.map)
        if len(curves) >= CURVES or _known(curves, shooting, seed.orbit, stretched * seed.value, second):
            continue
        nodes = _renoded(tree.branches[seed.branch].shooting, shooting, seed.orbit.nodes, seed.value)
        curve = follow_curve(shooting, kind, nodes, np.array([stretched * seed.value, second]), seed.orbit.at, window)
        if curve is not None:
            curves.append(curve)
        counted((1.0 - FOLLOWING) / len(seeds))
    options = {
        "event": kind.words,
        "over": {n: [float(a), float(b)] for n, a, b in zip(names, varied.low, varied.high, strict=True)},
        "initial": varied.plan.initial,
        "start": start,
        **counts,
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
    """The actuator's value of the second parameter, at which events are searched."""
    name, low, high = varied.names[1], float(varied.low[1]), float(varied.high[1])
    target = varied.target
    second_value = target.get(name) if isinstance(target, Device) else target.values[name]
    if second_value is None or not low <= float(second_value) <= high:
        what = "is not given" if second_value is None else f"is {varied.worded(float(second_value), 1)}"
        whose = "model" if varied.device is None else "device"
        raise InputError(
            f"{name} from {varied.worded(low, 1)} to {varied.worded(high, 1)}: must hold the {whose}'s own value, "
            f"which {what}, and at which events are searched for; set it, or move the interval"
        )
    return float(second_value)


def _renoded(old: Shooting, new: Shooting, nodes: Array, value: float) -> Array:
    """The nodes of an orbit for the number of segments of another shooting."""
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
    """True if an event lies on a curve that has been followed."""
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
                apart = np.abs(nodes[::stride] - orbit.nodes).max()
                mirrored = np.abs(curve.shooting.system.mirror * nodes[::stride] - orbit.nodes).max()
                if min(float(apart), float(mirrored)) < 0.1 * np.abs(orbit.nodes).max():
                    return True
    return False


# --- labels -----------------------------------------------------------------------------------------------------------


def _label(varied: Varied, curves: list[Curve], options: dict[str, Any]) -> xr.Dataset:
    special = [(number, point, after) for number, curve in enumerate(curves) for point, after in curve.special]
    size, state_attributes = curves[0].shooting.size, dataset.of_states(varied.plan.cone.system)
    blank = np.full((len(curves), max(len(curve.points) for curve in curves)), np.nan)
    values, coefficient, curvature = np.stack([blank, blank]), blank.copy(), blank.copy()
    orbit = np.full((*blank.shape, size), np.nan)
    for k, curve in enumerate(curves):
        along = slice(len(curve.points))
        values[:, k, along] = (varied.scales * [point.values for point in curve.points]).T
        coefficient[k, along] = curve.tests
        orbit[k, along] = [point.nodes[0] for point in curve.points]
        if curve.kind != EventKind.FOLD:
            curvature[k, along] = [_curvature(curve.shooting, point) for point in curve.points]
    multipliers = np.array(
        [multipliers_of_period(curves[n].shooting.kind, p.multipliers) for n, p, _ in special], dtype=complex
    ).reshape(-1, size)
    kinds = np.array([SPECIAL[curves[number].kind] for number, _, _ in special], dtype=np.int8)
    each, of, at = ("curve", "point"), ("curve",), ("event",)
    states = np.array([point.nodes[0] for _, point, _ in special]).reshape(-1, size)
    periods, reflected = (np.array([getattr(c.shooting.kind, n) for c in curves]) for n in ("period", "reflected"))
    variables: dict[str, dataset.Variable] = {
        "orbit": ((*each, "state"), orbit, "states at phase 0", state_attributes),
        "coefficient": (each, coefficient, "coefficient that passes 0 at a point of codimension two", "coefficient"),
        "curvature": (each, curvature, "curvature of the branch that is born", "coefficient"),
        "period": (of, periods, "period in forcing periods", "count"),
        "symmetric": (of, reflected.astype(np.int8), "own mirror image", "flag"),
        "ended": ((*of, "end"), np.array([c.ended for c in curves], dtype=np.int8), "why the curve ends", Ending),
        "event_kind": (at, kinds, "kind of point", EventKind),
        "event_curve": (at, np.array([n for n, _, _ in special], dtype=int), "curve of the point", "count"),
        "event_point": (at, np.array([k for _, _, k in special], dtype=int), "point of the curve before it", "count"),
        "event_orbit": ((*at, "state"), states, "states at phase 0", state_attributes),
        "event_multiplier_real": ((*at, "multiplier"), multipliers.real, "real part", "multiplier"),
        "event_multiplier_imag": ((*at, "multiplier"), multipliers.imag, "imaginary part", "multiplier"),
    }
    for k, (place, name) in enumerate(zip(("first", "second"), varied.names, strict=True)):
        own_values, errors = (
            varied.scales[k] * np.array([getattr(point, field)[k] for _, point, _ in special])
            for field in ("values", "errors")
        )
        variables[name] = (each, values[k], "", varied.attributes(k))
        variables[f"event_{place}"] = (at, own_values, "", varied.attributes(k))
        variables[f"event_{place}_error"] = (at, errors, "error of the value", varied.attributes(k))
    points = np.concatenate([[point.values for point in curve.points] for curve in curves])
    errors = dataset.film_errors(varied.ensemble([*points.T]))
    cone, outcome = varied.plan.cone, np.array(Outcome.OK)
    result = dataset.label(cone, variables, outcome=outcome, options=options, title="locus", errors=errors)
    result["orbit"].attrs |= varied.along(*varied.names)
    result["event_orbit"].attrs |= varied.along("event_first", "event_second")
    return result.assign_attrs(parameters=",".join(varied.names), event=curves[0].kind.words, **varied.about)


def _curvature(shooting: Shooting, point: Singular) -> float:
    """The curvature of the branch that is born at a singular orbit; NaN where it cannot be computed."""
    try:
        return born(shooting, point).curvature
    except np.linalg.LinAlgError:
        return np.nan
