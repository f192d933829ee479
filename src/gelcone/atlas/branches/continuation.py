"""Continuation of periodic orbits along one parameter, with branch switching and a check by brute force."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from hashlib import sha256
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone import dataset
from gelcone._version import __version__
from gelcone.atlas.branches.branch import Branch, Ending, Event, EventKind, Walk, multipliers_of_period
from gelcone.atlas.branches.check import FLAGS, Checked, Runs, brute_force, cover, polished, run_perturbed, shortest
from gelcone.atlas.branches.follow import follow
from gelcone.atlas.branches.journal import journal_in
from gelcone.atlas.branches.point import Metric, Point, at_value
from gelcone.atlas.branches.tree import Tree, whole_period
from gelcone.atlas.branches.varied import Varied, vary
from gelcone.atlas.plan import DEFAULT_INITIAL
from gelcone.codes import Outcome, Regime
from gelcone.devices.analysis import analysis
from gelcone.devices.device import Device
from gelcone.devices.si import in_field_units
from gelcone.errors import InputError, unknown_name
from gelcone.motion.attractor.search import DECAY_TIMES
from gelcone.motion.extent import extent
from gelcone.motion.flow import DEFAULT_TOLERANCE, check_flow, integrate
from gelcone.motion.orbit import Shooting
from gelcone.motion.validity import unknown, validity, validity_variables
from gelcone.physics.model import ConeModel
from gelcone.progress import Counted, Progress
from gelcone.quantity import Array, check_count

if TYPE_CHECKING:
    import xarray as xr

STARTS = ("rest", "settled")
CHECKS = 24
"""Values of the parameter at which brute force settles."""
MOST_NODES = 16
"""Nodes of an orbit that are stored, at most; of longer ones every second, fourth and so on."""
FOLLOWING = 0.4
"""Share of the progress that goes to following branches from their start."""
MOST_SECTIONS = 64
"""Points of the section of a settled motion that are stored."""
SAMPLES = 128
"""Samples of a forcing period, at least."""
TITLE = "branches"
PLACES = {"branch": "value", "event": "event_value", "run": "run_value"}
"""First dim of variables -> the variable that holds the value of the parameter they belong to."""


@analysis(
    arguments={"parameter": "PARAMETER", "low": "FROM", "high": "TO"},
    flags={"start": ("--from",), "store": ("--store",)},
    answers="branches",
    file_only=("orbit", "event_orbit"),
    single=True,
    takes="device",
    examples=(
        "voltage 0.9 1.4 --preset base --out results",
        'biased-pump film_thickness "0.15 mm" "0.25 mm" --from settled --json',
        "drive_frequency 0.1 3 --preset spring --set damping_ratio=0.01 --from settled --switch 0",
    ),
)
def continue_branch(
    model: ConeModel | Device,
    parameter: str,
    low: Any,
    high: Any,
    initial: Any = DEFAULT_INITIAL,
    *,
    start: Any = "rest",
    switch: int = 1,
    checks: int = CHECKS,
    points: int = 2000,
    tolerance: float = DEFAULT_TOLERANCE,
    store: str | Path | None = None,
    resume: bool = False,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Branches of periodic orbits along one parameter, stable and unstable, with their bifurcations.

    Orbits are followed by pseudo-arclength continuation. Folds, period doublings, symmetry breakings and losses of
    stability of rest are located, and the branches born there are followed in turn. Brute force checks the branches: a
    settled cycle on no branch starts one, and each disagreement is reported as a flag.

    Parameters
    ----------
    model : a single model, or a device; the parameter replaces its own.
    parameter : the parameter of the model, or the field of the device, that changes.
    low, high : its interval; ``low`` is below ``high``. Of a device in SI, or texts with units.
    initial : displacement and velocity from which brute force settles. Default (1, 0), or that of the device.
    start : where branches begin: "rest", "settled" (the settled motions at the ends of the interval), or a result of
        bifurcation or continue, whose cycles it takes. At rest: the flat film and what is born there; where it is not
        an equilibrium, the response near equilibrium. Default "rest".
    switch : levels of branches born at doublings and symmetry breakings that are followed. Default 1.
    checks : values of the parameter at which brute force settles, at least 2. Default 24.
    points : most points of a branch, at least 2. Default 2000.
    tolerance : relative error of one step of the integrator. Default 1e-15.
    store : folder that stores what is found as it is found. Default none.
    resume : continues with what ``store`` holds of the same run, with the same bits. Default no.
    threads : worker threads of brute force; default one a core.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over ``branch``, ``point``, ``node``, ``state``, ``multiplier`` and ``event``, padded with NaN (counts with
    0, other whole numbers with -1): ``value`` of the parameter and ``orbit`` at each point, its nodes over one period
    from phase 0 on (``nodes_per_repeat`` of them to a forcing period); ``multiplier_real`` and ``multiplier_imag`` over
    the period, ``stable``, ``lyapunov`` (the largest exponent), ``lowest`` and ``highest`` displacement, and
    ``validity_*`` as in `regime`; of each branch ``period`` in forcing periods, ``symmetric``, ``resting``, ``ended``
    at either ``end`` (codes of `Ending`), ``level`` and the event at which it is ``born``. Of each event
    ``event_kind``, ``event_value`` with ``event_error``, ``event_branch``, ``event_point`` (before it),
    ``event_born_branch``, ``event_supercritical`` (-1: none is born), ``event_curvature``, ``event_resolved`` (1 where
    it converged), ``event_orbit``, ``event_multiplier_real`` and ``event_multiplier_imag``. Of brute force
    ``run_value``, ``run_period`` and ``run_section``; of the contradictions ``flag_kind``, ``flag_explanation``,
    ``flag_branch`` and ``flag_value``; and how much was compared: ``checked_cycles``, ``checked_orbits`` and
    ``seeded``, the branches that a cycle of brute force started. Where the interval ends at values of which no actuator
    can be made, it is cut before them, to a thousandth, and ``attrs["impossible"]`` states the value and the reason.

    Raises
    ------
    InputError : for an unknown parameter, an interval that is empty or reversed, counts that are too small, a start
        that is not an orbit, a store of another run, or one that exists without ``resume``.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(damping_ratio=0.1, spring_stiffness=0.5, drive_frequency=0.5)
    >>> found = gelcone.continue_branch(model, "voltage", 0.4, 0.7, checks=2)
    >>> f"at {found.event_value.item():.5f}, supercritical: {bool(found.event_supercritical.item())}"
    'at 0.65809, supercritical: True'
    """
    varied = vary(model, {parameter: (low, high)}, initial)
    counts = {"switch": switch, "checks": checks, "points": points}
    check_following(counts, tolerance, threads)
    options = {
        "parameter": parameter,
        "low": float(varied.low[0]),
        "high": float(varied.high[0]),
        "initial": varied.plan.initial,
        "start": start if isinstance(start, str) else "result",
        **counts,
        "tolerance": tolerance,
    }
    flow = {"tolerance": tolerance, "threads": threads}
    (bottom,), (top,) = varied.ends
    states = varied.starts([0.5 * (bottom + top)])
    counted = Counted(progress)
    with journal_in(store, _plan(varied, options, start), resume=resume) as journal:
        walk = Walk(float(bottom), float(top), points, point_by_point(counted, FOLLOWING), journal)
        shooting = varied.shooting(tolerance)
        tree = grown(shooting, varied, walk, start, states, switch, flow)
        runs = _runs(start, varied) or brute_force(
            walk, shooting, np.linspace(bottom, top, checks), np.concatenate([states, 0.05 * states]), **flow
        )
        counted(0.2)
        covered = cover(tree, shooting, runs, **flow)
        counted(0.2)
        perturbed = run_perturbed(tree, **flow)
    if not tree.branches:
        raise InputError(
            f"start = {start!r}: is not an orbit: neither the motion at {parameter} = {varied.said(bottom)} nor any "
            "other is periodic; take another interval or start"
        )
    checked = Checked(covered.cycles, covered.seeded, perturbed.orbits, covered.flags + perturbed.flags)
    result = _label(varied, tree, runs, checked, options)
    counted.finish()
    return result


def _plan(varied: Varied, options: Mapping[str, Any], start: Any) -> dict[str, Any]:
    """All that determines the numbers, as plain data; a start that is a result is represented by its digest."""
    begin = {} if isinstance(start, str) else {"start": f"result {_digest(start)}"}
    return {
        "gelcone_version": __version__,
        "analysis": "continue_branch",
        "model": json.loads(json.dumps(dataset.single_values(varied.plan.cone))),
        "device": None if varied.device is None else varied.device.parameters(),
        "options": {**options, **begin},
    }


def _digest(start: Any) -> str:
    """A digest of the orbits or motions that a run begins with."""
    values = vars(start) if isinstance(start, Runs) else {str(name): start[name].values for name in start.variables}
    whole = sha256()
    for name in sorted(values):
        column = np.asarray(values[name])
        whole.update(name.encode() + (column.astype(str) if column.dtype.hasobject else column).tobytes())
    return whole.hexdigest()[:16]


def check_following(counts: Mapping[str, int], tolerance: float, threads: int | None) -> None:
    """Raises `InputError` for counts of a continuation that are too small, and for the options of `check_flow`."""
    for name, count in counts.items():
        check_count(name, count, 0 if name == "switch" else 2)
    check_flow(tolerance, threads)


def point_by_point(counted: Counted, share: float) -> Callable[[Point], None]:
    """A function that counts points for the progress. Their number is unknown, so that each counts as 1/500 of the rest
    of the ``share`` of the work."""
    left = share

    def tick(point: Point) -> None:
        nonlocal left
        counted(0.002 * left)
        left *= 0.998

    return tick


def grown(
    shooting: Shooting, varied: Varied, walk: Walk, start: Any, states: Array, switch: int, flow: dict[str, Any]
) -> Tree:
    """The tree of the branches that begin at ``start`` and of those born from them."""
    tree = Tree(walk, switch)
    for branch in _roots(shooting, varied, walk, start, states, flow):
        tree.add(branch, 0)
    tree.grow()
    return tree


# --- first branches ---------------------------------------------------------------------------------------------------


def _roots(
    shooting: Shooting, varied: Varied, walk: Walk, start: Any, states: Array, flow: dict[str, Any]
) -> list[Branch]:
    """The branches from which the others grow."""
    if isinstance(start, str) and start not in STARTS:
        raise unknown_name("start of branches", start, STARTS)
    if shooting.symmetric and (not isinstance(start, str) or start == "rest"):
        nodes = _resting(shooting, walk.low)
        rest_orbit = at_value(shooting, nodes, walk.low, Metric.of(nodes, walk.scale)).point
        if rest_orbit is None:
            raise InputError(
                f"start = rest: the flat film is not an orbit at {varied.names[0]} = {varied.said(walk.low)}"
            )
        return [follow(shooting, rest_orbit, walk, both_ways=False, resting=True)]
    if not isinstance(start, str):
        return []
    if start == "rest":
        n = shooting.numbers_at((walk.low,))
        states = states.copy()
        states[:, 0], states[:, 1] = shooting.system.bias.free_height(n), 0.0
    runs = brute_force(walk, shooting, np.array([walk.low, walk.high]), states, **flow)
    roots: list[Branch] = []
    for k in np.flatnonzero(runs.period > 0):
        cycle_shooting, point = polished(shooting, runs, k, walk.scale, **flow)
        if point is None or not point.stable:
            continue
        cycle_shooting, point = shortest(cycle_shooting, point, walk.scale)
        if not Tree(walk, 0, roots).holds(cycle_shooting, point):
            roots.append(follow(cycle_shooting, point, walk))
    if not roots and start == "settled":
        raise InputError(
            f"start = settled: is not an orbit: the motion is periodic neither at {varied.names[0]} = "
            f"{varied.said(walk.low)} nor at {varied.said(walk.high)}; take another interval or start from rest"
        )
    return roots


def _resting(shooting: Shooting, value: float) -> Array:
    """Nodes of rest: the disc on the flat film, other states with the period of the drive."""
    members = shooting.members_at((value,))
    states = members.start_states((0.0, 0.0))
    if shooting.size > 2:
        period = float(members.forcing_period[0])
        whole = max(200.0, np.ceil(DECAY_TIMES * float(members.time_constant[0]) / period))
        states = integrate(members, states, [whole * period]).states[:, -1]
    times = members.forcing_period[:, None] * (np.arange(shooting.count) / shooting.segments)
    return np.asarray(integrate(members, states, times).states[0])


def _runs(start: Any, varied: Varied) -> Runs | None:
    """The settled motions of a bifurcation diagram, or the orbits of earlier branches; None for a start by name, and
    for a result in which the disc only rests."""
    if isinstance(start, str):
        return None
    if isinstance(start, Runs):
        return start
    name = varied.names[0]
    if start.attrs.get("parameter") != name:
        raise InputError(f"start: is a result along {start.attrs.get('parameter')!r}; give one along {name!r}")
    if start.attrs["title"] == TITLE:
        return _orbits_of(start, varied)
    if not {"section", "period", "regime"} <= set(start.variables):
        raise InputError("start: holds no section of settled motions; give a result of bifurcation or continue")
    flat = start.transpose("branch", name, ...)
    values = np.tile(in_field_units(flat[name]).values, flat.sizes["branch"])
    section = flat["section"].values.reshape(values.size, *flat["section"].shape[2:])
    cyclic = np.isin(flat["regime"].values.ravel(), (Regime.PERIODIC, Regime.REST))
    period = np.where(cyclic, np.maximum(flat["period"].values.ravel(), 1), 0).astype(np.int64)
    return Runs(
        values / varied.scales[0],
        varied.without_units(section, flat["section"].attrs, values),
        period,
        flat["symmetric"].values.ravel().astype(bool) & (period % 2 == 0),
        cyclic,
    )


def _orbits_of(start: xr.Dataset, varied: Varied) -> Runs | None:
    """The middle orbit of each earlier branch on which the disc moves; None without such a branch."""
    along, orbit = in_field_units(start["value"]).values, start["orbit"].values
    known_points = [np.flatnonzero(np.isfinite(values)) for values in along]
    middles = [(k, indices[indices.size // 2]) for k, indices in enumerate(known_points) if indices.size]
    moving = [middle for middle in middles if orbit[(*middle, 0, 0)]]
    if not moving:
        return None
    rows, points = np.array(moving).T
    at, period, symmetric = along[rows, points], start["period"].values[rows], start["symmetric"].values[rows]
    section = varied.without_units(orbit[rows, points, :1], start["orbit"].attrs, at)
    cyclic = np.ones(at.size, dtype=bool)
    return Runs(at / varied.scales[0], section, period.astype(np.int64), symmetric.astype(bool), cyclic, False)


# --- labels -----------------------------------------------------------------------------------------------------------


def _label(varied: Varied, tree: Tree, runs: Runs, checked: Checked, options: dict[str, Any]) -> xr.Dataset:
    branches, scale, along = tree.branches, float(varied.scales[0]), varied.attributes()
    attributes = dataset.of_states(branches[0].shooting.system)
    events = [event for branch in branches for event in branch.events]
    nodes = max(_kept(branch.shooting)[1] for branch in branches)
    kinds = np.array([FLAGS.index(flag.kind) for flag in checked.flags], dtype=np.int8)
    explanations, section = _of(checked.flags, "explanation", str), runs.section[:, -MOST_SECTIONS:]
    variables: dict[str, dataset.Variable] = {
        **_point_variables(branches, nodes, scale, along),
        **_branch_variables(branches, events),
        **_event_variables(branches, events, nodes, scale, along),
        "run_value": (("run",), scale * runs.values, "", along),
        "run_period": (("run",), runs.period, "period of the settled motion, 0 for none", "count"),
        "run_section": (("run", "repeat", "state"), section, "settled motion once every forcing period", attributes),
        "flag_kind": (("flag",), kinds, "contradiction between branches and brute force", "flag"),
        "flag_explanation": (("flag",), explanations, "explanation of the contradiction", "code"),
        "flag_branch": (("flag",), _of(checked.flags, "branch", int), "branch of the contradiction", "count"),
        "flag_value": (("flag",), scale * _of(checked.flags, "value", float), "", along),
        "checked_cycles": ((), checked.cycles, "settled cycles that were compared with the branches", "count"),
        "checked_orbits": ((), checked.orbits, "stable orbits near which runs started", "count"),
        "seeded": ((), checked.seeded, "branches that a settled cycle started", "count"),
    }
    errors = dataset.film_errors(varied.ensemble([np.concatenate([branch.values for branch in branches])]))
    outcome = np.array(Outcome.OK)
    result = dataset.label(varied.plan.cone, variables, outcome=outcome, options=options, title=TITLE, errors=errors)
    for variable in result.variables.values():
        place = PLACES.get(str(next(iter(variable.dims), "")))
        if place:
            variable.attrs |= varied.along(place)
    result["flag_kind"].attrs |= dataset.flags_of([flag.replace(" ", "_") for flag in FLAGS])
    name = varied.names[0]
    return result.assign_attrs(parameter=name, mirror=int(branches[0].shooting.symmetric), **varied.about)


def _of(items: Sequence[Any], field: str, kind: Any) -> Any:
    """A field of each item, given by its dotted name."""
    return np.array([attrgetter(field)(item) for item in items], dtype=kind)


def _point_variables(
    branches: Sequence[Branch], nodes: int, scale: float, along: Mapping[str, Any]
) -> dict[str, dataset.Variable]:
    """Variables over the points of the branches; up to ``nodes`` nodes of each orbit are stored."""
    size, system = branches[0].shooting.size, branches[0].shooting.system
    shape = len(branches), max(len(branch.points) for branch in branches)
    value, lowest, highest, growth = (np.full(shape, np.nan) for _ in range(4))
    stable, holds = np.full(shape, -1, dtype=np.int8), unknown(*shape)
    orbit, multiplier = np.full((*shape, nodes, size), np.nan), np.full((*shape, size), np.nan, dtype=complex)
    for k, branch in enumerate(branches):
        cells = k, slice(len(branch.points))
        floquet = np.array([multipliers_of_period(branch.map, p.multipliers) for p in branch.points])
        periods = np.array([branch.map.period * branch.shooting.repeat_time((p.value,)) for p in branch.points])
        value[cells], multiplier[cells], stable[cells] = scale * branch.values, floquet, np.abs(floquet[:, 0]) < 1.0
        growth[cells] = np.log(np.maximum(np.abs(floquet[:, 0]), 1e-300)) / periods
        kept = np.stack([_kept_nodes(branch.shooting, p.nodes) for p in branch.points])
        orbit[(*cells, slice(kept.shape[1]))] = kept
        lowest[cells], highest[cells], holds[cells] = _extent(branch)
    at = ("branch", "point")
    return {
        "value": (at, value, "", along),
        "orbit": ((*at, "node", "state"), orbit, "states over one period, from phase 0 on", dataset.of_states(system)),
        "multiplier_real": ((*at, "multiplier"), multiplier.real, "real part of the multiplier", "multiplier"),
        "multiplier_imag": ((*at, "multiplier"), multiplier.imag, "imaginary part of the multiplier", "multiplier"),
        "stable": (at, stable, "whether the orbit is stable, -1 where there is none", "flag"),
        "lyapunov": (at, growth, "largest Lyapunov exponent", "rate"),
        "lowest": (at, lowest, "lowest displacement", "length"),
        "highest": (at, highest, "highest displacement", "length"),
        **validity_variables(holds, np.zeros(shape, dtype=np.int8), system, at, "orbit"),
    }


def _branch_variables(branches: Sequence[Branch], events: Sequence[Event]) -> dict[str, dataset.Variable]:
    """Variables over the branches."""
    number, at = {id(event): k for k, event in enumerate(events)}, ("branch",)
    born = [-1 if branch.parent is None else number[id(branch.parent)] for branch in branches]
    nodes = [branch.shooting.segments // _kept(branch.shooting)[0] for branch in branches]
    return {
        "period": (at, _of(branches, "map.period", int), "period in forcing periods", "count"),
        "symmetric": (at, _of(branches, "map.reflected", np.int8), "own mirror image", "flag"),
        "resting": (at, _of(branches, "resting", np.int8), "whether the disc rests", "flag"),
        "nodes_per_repeat": (at, np.array(nodes), "nodes in one forcing period", "count"),
        "level": (at, _of(branches, "level", int), "switches since the first branch", "count"),
        "born": (at, np.array(born), "event at which the branch is born, -1 for none", "count"),
        "ended": ((*at, "end"), _of(branches, "ended", np.int8), "why the branch ends", Ending),
    }


def _event_variables(
    branches: Sequence[Branch], events: Sequence[Event], nodes: int, scale: float, along: Mapping[str, Any]
) -> dict[str, dataset.Variable]:
    """Variables over the events of the branches."""
    shooting, over_states = branches[0].shooting, dataset.of_states(branches[0].shooting.system)
    orbit = np.full((len(events), nodes, shooting.size), np.nan)
    multiplier = np.full((len(events), shooting.size), np.nan, dtype=complex)
    for k, event in enumerate(events):
        kept = _kept_nodes(branches[event.branch].shooting, event.orbit.nodes)
        orbit[k, : len(kept)] = kept
        multiplier[k] = multipliers_of_period(event.map, event.orbit.multipliers)
    side = np.array([-1 if event.supercritical is None else event.supercritical for event in events], dtype=np.int8)
    curvature = scale * np.array([np.nan if event.born is None else event.born.curvature for event in events])
    error, at = scale * np.array([event.orbit.errors[0] for event in events]), ("event",)
    return {
        "event_kind": (at, _of(events, "kind", np.int8), "kind of event", EventKind),
        "event_value": (at, scale * _of(events, "value", float), "", along),
        "event_error": (at, error, "error of the value", along),
        "event_branch": (at, _of(events, "branch", int), "branch of the event", "count"),
        "event_point": (at, _of(events, "after", int), "point of the branch before it", "count"),
        "event_born_branch": (at, _of(events, "born_branch", int), "branch born there", "count"),
        "event_supercritical": (at, side, "1 supercritical, 0 subcritical, -1 none", "flag"),
        "event_curvature": (at, curvature, "curvature of the branch that is born", along),
        "event_resolved": (at, _of(events, "resolved", np.int8), "whether it converged", "flag"),
        "event_orbit": ((*at, "node", "state"), orbit, "states over one period at the event", over_states),
        "event_multiplier_real": ((*at, "multiplier"), multiplier.real, "real part", "multiplier"),
        "event_multiplier_imag": ((*at, "multiplier"), multiplier.imag, "imaginary part", "multiplier"),
    }


def _kept_nodes(shooting: Shooting, nodes: Array) -> Array:
    """The nodes of an orbit that are stored, over its whole period."""
    return whole_period(shooting, nodes)[:: _kept(shooting)[0]]


def _kept(shooting: Shooting) -> tuple[int, int]:
    """Stride and number of the nodes that are stored."""
    count, stride = shooting.segments * shooting.kind.period, 1
    while count // stride > MOST_NODES and stride < shooting.segments:
        stride *= 2
    return stride, count // stride


def _extent(branch: Branch) -> tuple[Array, Array, Array]:
    """Lowest and highest displacement of every orbit of a branch, each (points,), and `validity` (points, ...)."""
    shooting, points = branch.shooting, len(branch.points)
    n, samples = shooting.count, max(8, SAMPLES // shooting.segments)
    values = np.repeat([point.value for point in branch.points], n)
    nodes = np.concatenate([point.nodes for point in branch.points])
    members = shooting.members_at((values,))
    start = np.tile(np.arange(n) % shooting.segments, points) / shooting.segments
    length = shooting.phase / members.number("drive_frequency")
    times = (start[:, None] + np.arange(1, samples + 1) / (samples * shooting.segments)) * length[:, None]
    run = integrate(members, nodes, times, start=start * length, tolerance=1e-9)
    from_nodes = np.hstack([(start * length)[:, None], times]), np.concatenate([nodes[:, None], run.states], axis=1)
    low, high = (of.reshape(points, -1) for of in extent(members, *from_nodes, tolerance=1e-9))
    low, high = np.nanmin(low, axis=1), np.nanmax(high, axis=1)
    if shooting.kind.reflected:
        high = np.maximum(high, -low)
        low = -high
    first, whole = (slice(None), slice(1)), np.tile(np.arange(n) // shooting.segments, points)[:, None]
    times = times + whole * length[:, None]
    holds = validity(
        shooting.members_at((branch.values,)),
        np.hstack([np.zeros((points, 1)), times.reshape(points, -1)]),
        np.hstack([nodes.reshape(points, n, -1)[first], run.states.reshape(points, n * samples, -1)]),
        whole=True,
        film_times=run.film_times.reshape(points, n, *run.film_times.shape[1:]).sum(axis=1),
    )
    return low, high, holds
