"""Bifurcation diagrams: the motion along one parameter, swept up, down and from fixed states."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import reduce
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.atlas.branches.attached import attach
from gelcone.atlas.branches.continuation import continue_branch
from gelcone.atlas.plan import DEFAULT_INITIAL, STATES, Plan, about
from gelcone.atlas.store import fill_of
from gelcone.atlas.threshold import WANDERING, Threshold, changes, refine
from gelcone.codes import Outcome, Regime
from gelcone.devices.analysis import analysis, plain
from gelcone.devices.device import Device
from gelcone.devices.points import read_state
from gelcone.devices.si import device_attributes
from gelcone.errors import InputError, check_result
from gelcone.motion.attractor.classification import Evidence, classify
from gelcone.motion.attractor.search import NEARBY, transient_of
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.regime import label_evidence
from gelcone.motion.settle import check_budgets, repeats_lasting, settle
from gelcone.motion.start import complete, nudge, start_states
from gelcone.motion.stepping import NUDGE
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.progress import Counted, Progress, weighted
from gelcone.quantity import Array, Time

if TYPE_CHECKING:
    import xarray as xr

CHUNK = 256
"""Members computed together: enough to fill lanes and threads, few enough for progress and interrupts."""
BISECTIONS = 8
PATHS = 4
"""States of a motion that differs from run to run, from each of which a change is narrowed down."""
WALK = 0.25
"""Share of the progress of a sweep for its serial part, in which each value needs the state of the one before."""
BRANCHES_SHARE = 0.9
"""Share of the progress for the branches; the rest is for the thresholds."""


@analysis(
    answers="grids",
    file_only=("section", "followed_orbit"),
    over="The parameter to sweep, or the field of a device: name=from:to:count or name=v1,v2,...",
    single=True,
    takes="device",
    examples=(
        "--over voltage=0:2:401 --set drive_frequency=0.1 --out results",
        'paper-table1 --over "voltage_amplitude=0 kV:10 kV:101" --sweeps up --json',
    ),
)
def bifurcation(
    model: ConeModel | Device,
    parameter: str,
    values: npt.ArrayLike,
    initial: npt.ArrayLike = DEFAULT_INITIAL,
    *,
    sweeps: Sequence[str] = ("up", "down"),
    bisections: int = BISECTIONS,
    branches: bool = False,
    transient: Time | None = None,
    patience: Time | None = None,
    budget: Time = 20_000.0,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Compute section, extent, exponents and regime at each value of a parameter, by sweeps and from fixed states.

    Parameters
    ----------
    model : a single model, or a device; the swept parameter replaces its own.
    parameter, values : the name of a parameter of the model, or of a field of the device, and its increasing values, at
        least two.
    initial : displacement and velocity at time 0, shape (2,), or several initial states, shape (states, 2): each gives
        one branch over all values, and the sweeps start from the first. Default (1, 0), or that of the device.
    sweeps : any of ``"up"`` and ``"down"``: each point starts where the one before was after the transient, its
        displacement moved by 1e-4, so that hysteresis shows. Default both.
    bisections : the range of each change of regime is narrowed down to 2 to the power of minus this number, unless it
        stops changing before. Default 8.
    branches : whether branches of periodic orbits, stable and unstable, are followed too. See `continue_branch`.
        Default no.
    transient, patience, budget, tolerance : as in `regime`.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over ``branch`` (``up``, ``down``, ``from x,u``) and the parameter with the variables of `regime`, and over
    ``threshold`` each change of regime: ``threshold_branch``, ``threshold_from`` and ``threshold_to`` (codes of
    `Regime`), ``threshold_low`` and ``threshold_high``: the last value up to which all 16 starts within 1e-9 are of the
    one kind, and the first from which on none is; ``threshold_cascade`` (1: chaos begins by doublings of the period);
    and ``threshold_of_one_path`` (1: chaos takes part, and the range stays wide, a sweep came to it through chaos, or
    chaos ends; that of another path, as one from a start 1e-12 away, may lie elsewhere). A change out of chaos is
    narrowed down from 4 states of it. Values of which no actuator can be made have the outcome ``impossible``, and
    ``attrs["impossible"]`` states why the first of them has.

    Raises
    ------
    InputError : for an unknown parameter, too few or unsorted values, unknown sweeps, budgets that are not positive, no
        initial state, one given twice, or none inside the stretch limit.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(spring_stiffness=0.5, drive_frequency=0.5)
    >>> diagram = gelcone.bifurcation(model, "voltage", [0.4, 0.5, 0.6], (0.01, 0.0), sweeps=["up"])
    >>> change = gelcone.thresholds_of(diagram)[0]
    >>> change["from"], change["to"], round(change["low"], 3)
    ('rest', 'periodic', 0.599)
    """
    states = _states(model, initial)
    for sweep in sweeps:
        if sweep not in ("up", "down"):
            raise InputError(f"sweeps = {sweep!r}: must be 'up' or 'down'")
    if bisections < 0:
        raise InputError(f"bisections = {bisections}: must be at least 0")
    if parameter in STATES:
        raise InputError(f"{parameter}: belongs to the initial state; a bifurcation diagram sweeps a parameter")
    options = {"transient": transient, "patience": patience, "budget": budget, "tolerance": tolerance}
    plans = {_name(state): Plan(model, {parameter: values}, state, options=options) for state in states}
    next(iter(plans.values())).check_order("a bifurcation diagram")
    if len(plans) < len(states):
        raise InputError(f"initial = {states}: holds a state twice; remove duplicates")
    whole = next(iter(plans.values()))
    plans = _possible(plans)
    first = next(iter(plans.values()))
    check_budgets(**{name: first.options.get(name) for name in ("transient", "patience", "budget")})
    counted, once = Counted(progress), tuple(dict.fromkeys(sweeps))
    part = BRANCHES_SHARE / (len(once) + len(plans))
    runs: dict[str, Evidence] = {}
    for name, plan in plans.items():
        members, starts = _fixed(plan, plan.grid)
        runs[name] = _classify(plan, members, starts, threads, weighted(counted, part))
    runs = _sweep(first, once, threads, lambda share: counted(share * part)) | runs
    result = _label(first, runs)
    every, left = whole.over[parameter], 1.0 - BRANCHES_SHARE
    thresholds = _thresholds(plans, runs, every, bisections, threads, lambda share: counted(left * share))
    made = result.assign(thresholds)
    result = made if first.size == whole.size else _with_impossible(made, whole)
    if branches:
        ends = float(first.over[parameter][0]), float(first.over[parameter][-1])
        followed = plain(continue_branch)(model, parameter, *ends, first.initial, start=made, threads=threads)
        result = attach(result, followed)
    counted.finish()
    return result


def _possible(plans: dict[str, Plan]) -> dict[str, Plan]:
    """The plans over those values that make an actuator; `InputError` for fewer than two, and where none can start."""
    possible_plans = [plan.possible() for plan in plans.values()]
    for _, models, states in possible_plans:
        start_states(models, states)
    cells = reduce(np.intersect1d, [cells for cells, _, _ in possible_plans])
    first = next(iter(plans.values()))
    if cells.size < 2:
        raise InputError(first.refusal(int(np.setdiff1d(np.arange(first.size), cells)[0])))
    if cells.size == first.size:
        return plans
    over = {name: values[cells] for name, values in first.over.items()}
    return {name: replace(plan, over=over) for name, plan in plans.items()}


def _with_impossible(result: xr.Dataset, plan: Plan) -> xr.Dataset:
    """The diagram over all values of the plan: those that make no actuator have the outcome ``impossible``, and the
    attribute ``impossible`` states the reason of the first."""
    ((name, values),) = plan.over.items()
    lacking = np.setdiff1d(np.arange(values.size), np.searchsorted(values, result[name].values))
    blank = {str(label): fill_of(variable.dtype) for label, variable in result.items() if name in variable.dims}
    spread = result.reindex({name: values}, fill_value=blank | {"outcome": Outcome.IMPOSSIBLE.value})
    return spread.assign_attrs(impossible=plan.refusal(int(lacking[0])))


def _states(model: ConeModel | Device, initial: Any) -> list[Any]:
    """The initial states of the branches; None for that of the device."""
    if initial is None:
        return [None if isinstance(model, Device) else DEFAULT_INITIAL]
    if isinstance(model, Device) and np.ndim(initial) < 2:
        return [read_state(initial)]
    states = np.atleast_2d(np.asarray(initial, dtype=float))
    if not states.size:
        raise InputError("initial: is empty; give at least one initial state")
    return [tuple(map(float, state)) for state in states]


def _options(plan: Plan) -> dict[str, Any]:
    """The options that are recorded with a branch."""
    return {"initial": plan.initial, **plan.options}


def _classify(plan: Plan, members: Members, states: Array, threads: int | None, progress: Progress = None) -> Evidence:
    """Kinds of motion of some members with the plan's options, chunk by chunk."""
    parts = []
    for first in range(0, members.size, CHUNK):
        rows = np.arange(first, min(first + CHUNK, members.size))
        share = weighted(progress, rows.size / members.size)
        parts.append(classify(members.take(rows), states[rows], threads=threads, progress=share, **plan.options))
    return Evidence.join(parts)


def _name(state: Sequence[float] | None) -> str:
    """The name of the branch from a fixed initial state."""
    return "from its own start" if state is None else "from " + ",".join(f"{component:g}" for component in state)


def _sweep(
    plan: Plan, sweeps: Sequence[str], threads: int | None, progress: Callable[[float], None]
) -> dict[str, Evidence]:
    """One branch per sweep: a walk over the values that only settles, then the evidence of all points from the states
    that the walk reached.

    The shares with which ``progress`` is called add up to the number of sweeps.
    """
    if not sweeps:
        return {}
    (name, values), count = next(iter(plan.over.items())), plan.size
    order = {"up": np.arange(count), "down": np.arange(count)[::-1]}
    members, first = _fixed(plan, {name: np.tile(values, len(sweeps))})
    starts = np.empty((len(sweeps), count, first.shape[1]))
    state = first[: len(sweeps)]
    for k in range(count):
        at = [order[sweep][k] for sweep in sweeps]
        starts[np.arange(len(sweeps)), at] = state
        part, fallback = _fixed(plan, {name: values[at]})
        repeats = repeats_lasting(part, transient_of(part, plan.options["transient"]))
        after, outcome = settle(part, state, repeats, tolerance=plan.options["tolerance"], threads=threads)
        state = np.where((outcome != Outcome.OK)[:, None], fallback, nudge(after, NUDGE))
        progress(len(sweeps) * WALK / count)
    share = len(sweeps) * (1.0 - WALK)
    evidence = _classify(plan, members, starts.reshape(len(first), -1), threads, lambda part: progress(share * part))
    return {sweep: evidence.take(slice(i * count, (i + 1) * count)) for i, sweep in enumerate(sweeps)}


def _fixed(plan: Plan, values: dict[str, Array]) -> tuple[Members, Array]:
    """The members at some values of the parameter, and the plan's initial state for each, (values, N)."""
    model, states = plan.at(values)
    members = model.members()
    return members, complete(members, states)


def _label(plan: Plan, branches: dict[str, Evidence]) -> xr.Dataset:
    import xarray as xr

    name, values = next(iter(plan.over.items()))
    model, _ = plan.at(plan.grid)
    attrs = about(plan, name)
    labelled = []
    for evidence in branches.values():
        branch = label_evidence(model.members(), evidence, _options(plan), "bifurcation diagram")
        branch = branch.drop_vars([str(c) for c in branch.coords]).rename({"member": name})
        labelled.append(branch.assign_coords({name: (name, values, attrs)}))
    followed = dataset.attributes("direction of the sweep, or the state that every point starts from", "code")
    result = xr.concat(labelled, dim=xr.DataArray(list(branches), dims="branch", name="branch", attrs=followed))
    errors, title = dataset.film_errors(model), "bifurcation diagram"
    result.attrs = dataset.label(plan.cone, {}, options=_options(plan), title=title, errors=errors).attrs
    return result.assign_attrs(parameter=name, **({} if plan.device is None else device_attributes(plan.device)))


def _thresholds(
    plans: dict[str, Plan],
    branches: dict[str, Evidence],
    whole: Array,
    bisections: int,
    threads: int | None,
    progress: Callable[[float], None],
) -> dict[str, Any]:
    """Every change of regime between neighbours, without those that any of the ``whole`` values lies between, narrowed
    down from the state on the side where it began."""
    plan = next(iter(plans.values()))
    (name, values) = next(iter(plan.over.items()))
    lacking = np.setdiff1d(whole, values)
    thresholds = [
        change
        for branch, evidence in branches.items()
        for change in changes(branch, values, evidence)
        if not ((lacking > change.low) & (lacking < change.high)).any()
    ]
    met = {id(change): _met(plans, change, branches[change.branch], values) for change in thresholds}
    for change in thresholds:
        change.out_of_chaos = change.branch not in plans and len(met[id(change)]) > 1

    def classified(owners: list[Threshold], tried: Array) -> list[Evidence]:
        counts = np.array([len(met[id(owner)]) for owner in owners])
        members = plan.at({name: np.repeat(tried, counts)})[0].members()
        evidence = _classify(plan, members, np.concatenate([met[id(owner)] for owner in owners]), threads)
        first = np.cumsum(counts) - counts
        return [evidence.take(first + path % counts) for path in range(counts.max())]

    refine(thresholds, classified, bisections, progress)

    def column(field: str, kind: Any) -> Any:
        return np.array([getattr(threshold, field) for threshold in thresholds], dtype=kind)

    swept = about(plan, name)
    table: dataset.Table = {
        "threshold_branch": (column("branch", str), "branch on which the regime changes", "code"),
        "threshold_from": (column("below", np.int8), "regime below the change", Regime),
        "threshold_to": (column("above", np.int8), "regime above the change", Regime),
        "threshold_low": (column("low", float), "last value up to which all starts are of the one kind", swept),
        "threshold_high": (column("high", float), "first value from which on none is any more", swept),
        "threshold_cascade": (column("cascade", np.int8), "1 if chaos begins by doublings of the period", "code"),
        "threshold_of_one_path": (
            column("of_one_path", np.int8),
            "1 if that of another path may lie elsewhere",
            "code",
        ),
    }
    return dataset.columns("threshold", table)


def _met(plans: dict[str, Plan], threshold: Threshold, evidence: Evidence, values: Array) -> Array:
    """The states (paths, N) from which a change of a branch is narrowed down: one of a motion that repeats, several of
    one that does not."""
    plan = plans.get(threshold.branch, next(iter(plans.values())))
    before = int(np.searchsorted(values, threshold.high if threshold.branch == "down" else threshold.low))
    _, fixed = _fixed(plan, {next(iter(plan.over)): values[[before]]})
    if threshold.branch in plans or not np.isfinite(evidence.final[before]).all():
        count = PATHS if threshold.wandering else 1
        return np.concatenate([nudge(fixed, NEARBY * path) for path in range(count)])
    if evidence.regime[before] not in WANDERING:
        return nudge(evidence.final[[before]], NUDGE)
    section = evidence.section[before]
    return nudge(section[len(section) // PATHS - 1 :: len(section) // PATHS], NUDGE)


def thresholds_of(diagram: xr.Dataset) -> list[dict[str, Any]]:
    """The thresholds of a diagram as a list of plain records, in the order of the parameter's values.

    Parameters
    ----------
    diagram : of `gelcone.bifurcation`.

    Returns
    -------
    A dict for each change of regime: ``branch``, ``from`` and ``to`` in words, ``low`` and ``high``, between which it
    lies, whether it begins a ``cascade``, and whether it is ``of_one_path``.

    Raises
    ------
    InputError : for a Dataset that is not a bifurcation diagram.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(spring_stiffness=0.5, drive_frequency=0.5)
    >>> diagram = gelcone.bifurcation(model, "voltage", [0.4, 0.5, 0.6], (0.01, 0.0), sweeps=["up"])
    >>> [(change["from"], change["to"], round(change["low"], 3)) for change in gelcone.thresholds_of(diagram)]
    [('rest', 'periodic', 0.599), ('rest', 'periodic', 0.599)]
    """
    check_result("thresholds_of", diagram)
    if "threshold_branch" not in diagram:
        raise InputError("thresholds_of: was given another result; give one of gelcone.bifurcation")
    columns = [diagram[f"threshold_{n}"].values for n in ("branch", "from", "to", "low", "high")]
    none = np.zeros(len(columns[0]))  # files of earlier versions lack these variables
    columns += [np.asarray(diagram.get(f"threshold_{n}", none)) for n in ("cascade", "of_one_path")]
    rows = [
        {
            "parameter": diagram.attrs["parameter"],
            "branch": str(branch),
            "from": Regime(int(a)).label,
            "to": Regime(int(b)).label,
            "low": float(low),
            "high": float(high),
            "cascade": bool(cascade),
            "of_one_path": bool(of_one),
        }
        for branch, a, b, low, high, cascade, of_one in zip(*columns, strict=True)
    ]
    return sorted(rows, key=lambda row: (row["branch"], row["low"]))
