"""Bifurcation diagrams: what the motion is along one parameter, swept up, down and from fixed states."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.atlas.plan import STATES, Plan, meaning_of, quantity_of
from gelcone.codes import Outcome, Regime
from gelcone.errors import InputError
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.lyapunov import check_budgets, default_transient
from gelcone.motion.regime import ROUNDS, Evidence, classify, label_evidence
from gelcone.motion.response import start_states
from gelcone.motion.section import repeats_lasting, settle
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

CHUNK = 256
"""Members computed together: enough to fill lanes and threads, few enough for progress and interrupts."""
NUDGE = 1e-4
"""A sweep moves each state by this much before the next value, so that it leaves a motion that has become unstable."""
BISECTIONS = 8
WALK = 0.25
"""About the share of a sweep's work that cannot be done side by side."""


def bifurcation(
    model: ConeModel,
    parameter: str,
    values: npt.ArrayLike,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    sweeps: Sequence[str] = ("up", "down"),
    bisections: int = BISECTIONS,
    transient: float | None = None,
    budget: float = 20_000.0,
    rounds: int = ROUNDS,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Section points, extent, exponents and regime at each value of a parameter, by sweeps and from fixed states.

    Parameters
    ----------
    model : a single model; the swept parameter replaces its own.
    parameter, values : the parameter's name and its increasing values, at least two.
    initial : displacement and velocity at time 0, shape (2,), or several initial states, shape (states, 2): each gives
        one branch over all values, and the sweeps start from the first. Default (1, 0).
    sweeps : any of ``"up"`` and ``"down"``: each point starts where the one before was after the transient, moved by
        `NUDGE`, so that hysteresis shows. Default both.
    bisections : how often the interval of each change of regime is halved. Default 8.
    transient, budget, rounds, tolerance : as in `regime`.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over ``branch`` (``up``, ``down``, ``from x,u``) and the parameter with the variables of `regime`, and over
    ``threshold`` each change of regime: ``threshold_branch``, ``threshold_from`` and ``threshold_to`` (codes of
    `Regime`), ``threshold_low`` and ``threshold_high`` (the interval in which it lies).

    Raises
    ------
    InputError : for an unknown parameter, too few or unsorted values, unknown sweeps, budgets that are not positive, no
        initial state, one given twice, or none inside the stretch limit.
    """
    states = np.atleast_2d(np.asarray(initial, dtype=float))
    if not states.size:
        raise InputError("initial: is empty; give at least one initial state")
    for sweep in sweeps:
        if sweep not in ("up", "down"):
            raise InputError(f"sweeps = {sweep!r}: must be 'up' or 'down'")
    if bisections < 0:
        raise InputError(f"bisections = {bisections}: must be at least 0")
    if parameter in STATES:
        raise InputError(f"{parameter}: belongs to the initial state; a bifurcation diagram sweeps a parameter")
    check_budgets(transient=transient, budget=budget)
    options = {"transient": transient, "budget": budget, "rounds": rounds, "tolerance": tolerance}
    plans = {
        _name(state): Plan(model, {parameter: np.asarray(values)}, tuple(map(float, state)), options=options)
        for state in states
    }
    if len(plans) < len(states):
        raise InputError(f"initial = {states.tolist()}: holds a state twice; remove duplicates")
    report = progress or (lambda share: None)
    parts = len(dict.fromkeys(sweeps)) + len(plans)
    branches: dict[str, Evidence] = {}
    for name, plan in plans.items():
        start_states(*plan.at(plan.grid))
        branches[name] = _classify(plan, *plan.at(plan.grid), threads, lambda share: report(share / parts))
    first = next(iter(plans.values()))
    swept = _sweep(first, tuple(dict.fromkeys(sweeps)), threads, lambda share: report(share / parts))
    branches = swept | branches
    result = _label(first, branches)
    return result.assign(_thresholds(plans, branches, bisections, threads))


def _options(plan: Plan) -> dict[str, Any]:
    return {"initial": list(plan.initial), **plan.options}


def _classify(
    plan: Plan,
    model: ConeModel,
    states: Array,
    threads: int | None,
    progress: Callable[[float], None] = lambda share: None,
) -> Evidence:
    """Kinds of motion of some members with the plan's options, chunk by chunk."""
    parts = []
    for first in range(0, model.size, CHUNK):
        members = np.arange(first, min(first + CHUNK, model.size))
        parts.append(classify(model.take(members), states[members], threads=threads, **plan.options))
        progress(len(members) / model.size)
    return Evidence(**{f.name: np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(Evidence)})


def _name(state: Sequence[float]) -> str:
    """The name of the branch from a fixed initial state."""
    return "from " + ",".join(f"{component:g}" for component in state)


def _sweep(plan: Plan, sweeps: Sequence[str], threads: int | None, progress: Callable[[float], None]) -> dict[str, Evidence]:
    """One branch a sweep: a walk over the values that only settles, then all points from where the walk met them.

    ``progress`` receives a share of 1 for each sweep.
    """
    if not sweeps:
        return {}
    (name, values), count = next(iter(plan.over.items())), plan.size
    order = {"up": np.arange(count), "down": np.arange(count)[::-1]}
    starts = np.empty((len(sweeps), count, 2))
    state = np.tile(np.asarray(plan.initial, dtype=float), (len(sweeps), 1))
    for k in range(count):
        at = [order[sweep][k] for sweep in sweeps]
        starts[np.arange(len(sweeps)), at] = state
        model, _ = plan.at({name: values[at]})
        duration = default_transient(model) if plan.options["transient"] is None else np.full(model.size, plan.options["transient"])
        repeats = repeats_lasting(model, duration)
        after, outcome = settle(model, state, repeats, tolerance=plan.options["tolerance"], threads=threads)
        lost = outcome != Outcome.OK
        state = np.where(lost[:, None], plan.initial, after + np.array([NUDGE, 0.0]))
        progress(len(sweeps) * WALK / count)
    model, _ = plan.at({name: np.tile(values, len(sweeps))})
    share = len(sweeps) * (1.0 - WALK)
    evidence = _classify(plan, model, starts.reshape(-1, 2), threads, lambda part: progress(share * part))
    return {sweep: _take(evidence, slice(i * count, (i + 1) * count)) for i, sweep in enumerate(sweeps)}


def _take(evidence: Evidence, rows: Any) -> Evidence:
    return Evidence(**{f.name: getattr(evidence, f.name)[rows] for f in fields(Evidence)})


def _label(plan: Plan, branches: dict[str, Evidence]) -> xr.Dataset:
    import xarray as xr

    name, values = next(iter(plan.over.items()))
    model, _ = plan.at(plan.grid)
    attrs = {"long_name": meaning_of(name), "units": "1", "quantity": quantity_of(name)}
    labelled = []
    for evidence in branches.values():
        branch = label_evidence(model.take(slice(None)), evidence, _options(plan), "bifurcation diagram")
        branch = branch.drop_vars([str(c) for c in branch.coords]).rename({"member": name})
        labelled.append(branch.assign_coords({name: (name, values, attrs)}))
    result = xr.concat(labelled, dim=xr.DataArray(list(branches), dims="branch", name="branch"))
    result.attrs = dataset.label(plan.model, {}, options=_options(plan), title="bifurcation diagram").attrs
    return result.assign_attrs(parameter=name)


def _thresholds(
    plans: dict[str, Plan], branches: dict[str, Evidence], bisections: int, threads: int | None
) -> dict[str, Any]:
    """Every change of regime between neighbours, narrowed down from the state on the side it is met from."""
    plan = next(iter(plans.values()))
    (name, values) = next(iter(plan.over.items()))
    changes = {
        branch: np.flatnonzero(evidence.regime[1:] != evidence.regime[:-1]) for branch, evidence in branches.items()
    }
    names = np.repeat(list(changes), [len(at) for at in changes.values()])
    below = np.concatenate([branches[branch].regime[at] for branch, at in changes.items()])
    above = np.concatenate([branches[branch].regime[at + 1] for branch, at in changes.items()])
    low = np.concatenate([values[at] for at in changes.values()])
    high = np.concatenate([values[at + 1] for at in changes.values()])
    states = np.concatenate([_met(plans, branch, branches[branch], at) for branch, at in changes.items()])
    for _ in range(bisections if names.size else 0):
        middle = 0.5 * (low + high)
        model, _ = plan.at({name: middle})
        # What is neither kind lies between them too; the side that keeps its kind moves up.
        stays = _classify(plan, model, states, threads).regime == below
        low, high = np.where(stays, middle, low), np.where(stays, high, middle)

    def column(values: Any, kind: Any, long_name: str, quantity: str) -> tuple[str, Any, dict[str, str]]:
        attrs = {"long_name": long_name, "units": "1", "quantity": quantity}
        return "threshold", np.asarray(values, dtype=kind), attrs

    return {
        "threshold_branch": column(names, str, "branch on which the regime changes", "code"),
        "threshold_from": column(below, np.int8, "regime below the change", "code"),
        "threshold_to": column(above, np.int8, "regime above the change", "code"),
        "threshold_low": column(low, float, "change lies above this value", quantity_of(name)),
        "threshold_high": column(high, float, "change lies at or below this value", quantity_of(name)),
    }


def _met(plans: dict[str, Plan], branch: str, evidence: Evidence, changes: npt.NDArray[np.intp]) -> Array:
    """The states (changes, 2) from which the changes of a branch are narrowed down."""
    if branch in plans:
        return np.tile(np.asarray(plans[branch].initial, dtype=float), (len(changes), 1))
    met = evidence.final[changes if branch == "up" else changes + 1]
    fallback = next(iter(plans.values())).initial
    return np.where(np.isfinite(met), met + np.array([NUDGE, 0.0]), fallback)


def thresholds_of(diagram: xr.Dataset) -> list[dict[str, Any]]:
    """The thresholds of a diagram as a list of plain records, in the order of the parameter's values."""
    columns = [diagram[f"threshold_{n}"].values for n in ("branch", "from", "to", "low", "high")]
    rows = [
        {
            "parameter": diagram.attrs["parameter"],
            "branch": str(branch),
            "from": Regime(int(a)).label,
            "to": Regime(int(b)).label,
            "low": float(low),
            "high": float(high),
        }
        for branch, a, b, low, high in zip(*columns, strict=True)
    ]
    return sorted(rows, key=lambda row: (row["branch"], row["low"]))
