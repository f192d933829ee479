"""Bifurcation diagrams: what the motion is along one parameter, swept up, down and from fixed states."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.atlas.cells import CHUNK, Plan, join, meaning_of, quantity_of
from gelcone.errors import InputError
from gelcone.model import ConeModel
from gelcone.motion.flow import DEFAULT_TOLERANCE, Outcome
from gelcone.motion.regime import ROUNDS, Evidence, Regime, label_evidence

if TYPE_CHECKING:
    import xarray as xr

NUDGE = 1e-4
"""A sweep moves each state by this much before it goes on, lest it stays on a motion that has become unstable."""
BISECTIONS = 8


def bifurcation(
    model: ConeModel,
    parameter: str,
    values: npt.ArrayLike,
    *,
    initial: Sequence[tuple[float, float]] = ((1.0, 0.0),),
    sweeps: Sequence[str] = ("up", "down"),
    bisections: int = BISECTIONS,
    transient: float | None = None,
    budget: float = 20_000.0,
    tolerance: float = DEFAULT_TOLERANCE,
    rounds: int = ROUNDS,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Section points, extent, exponents and regime at each value of a parameter, by sweeps and from fixed states.

    Parameters
    ----------
    model : a single model; the swept parameter replaces its own.
    parameter, values : the parameter's name and its increasing values, at least two.
    initial : fixed initial states, each giving one branch over all values; the sweeps start from the first.
        Default ((1, 0),).
    sweeps : any of ``"up"`` and ``"down"``: each point starts from the last state of the one before, moved by
        `NUDGE`, so that hysteresis shows. Default both.
    bisections : how often each change of regime between neighbours is narrowed down by half. Default 8.
    transient, budget, tolerance : as in `regime`.
    rounds : how often a motion that has not settled is looked at again. Default 5.

    Returns
    -------
    Dataset over ``branch`` (``up``, ``down``, ``from x,u``) and the parameter with the variables of `regime`, and over
    ``threshold`` each change of regime: ``threshold_branch``, ``threshold_from`` and ``threshold_to`` (codes of
    `Regime`), ``threshold_low`` and ``threshold_high`` (the interval in which it lies).

    Raises
    ------
    InputError : for an unknown parameter, too few or unsorted values, unknown sweeps, budgets that are not positive, no
        initial state, or none inside the stretch limit.
    """
    if not initial:
        raise InputError("initial: is empty; give at least one initial state")
    for sweep in sweeps:
        if sweep not in ("up", "down"):
            raise InputError(f"sweeps = {sweep!r}: must be 'up' or 'down'")
    if bisections < 0:
        raise InputError(f"bisections = {bisections}: must be at least 0")
    plans = [
        Plan(model, {parameter: np.asarray(values)}, state, transient, budget, tolerance, rounds) for state in initial
    ]
    report = progress or (lambda share: None)
    parts = 2 * bool(sweeps) + len(plans)
    branches: dict[str, Evidence] = {}
    if sweeps:
        branches |= _sweep(plans[0], sweeps, threads, lambda share: report(2 * share / parts))
    for plan in plans:
        branches[f"from {plan.initial[0]:g},{plan.initial[1]:g}"] = plan.run(
            threads=threads, progress=lambda share: report(share / parts)
        )
    result = _label(plans[0], branches)
    return result.assign(_thresholds(plans, branches, bisections, threads))


def _sweep(
    plan: Plan, sweeps: Sequence[str], threads: int | None, progress: Callable[[float], None]
) -> dict[str, Evidence]:
    """The sweeps side by side, one value at a time."""
    (name, values), count = next(iter(plan.over.items())), plan.size
    order = {"up": np.arange(count), "down": np.arange(count)[::-1]}
    state = np.tile(np.asarray(plan.initial, dtype=float), (len(sweeps), 1))
    steps: list[Evidence] = []
    for k in range(count):
        here = np.array([values[order[sweep][k]] for sweep in sweeps])
        model, _ = plan.at({name: here})
        step = plan.classify(model, state, threads)
        steps.append(step)
        lost = step.outcome != Outcome.OK
        state = np.where(lost[:, None], plan.initial, step.final + np.array([NUDGE, 0.0]))
        progress(1.0 / count)
    together = join(steps)
    # Row k of the steps holds the k-th value of each sweep; back to the order of the values.
    return {
        sweep: _take(together, np.arange(count) * len(sweeps) + i, np.argsort(order[sweep]))
        for i, sweep in enumerate(sweeps)
    }


def _take(evidence: Evidence, rows: Any, order: Any) -> Evidence:
    return Evidence(**{f.name: getattr(evidence, f.name)[rows][order] for f in fields(Evidence)})


def _label(plan: Plan, branches: dict[str, Evidence]) -> xr.Dataset:
    import xarray as xr

    name, values = next(iter(plan.over.items()))
    model, _ = plan.at(plan.grid)
    attrs = {"long_name": meaning_of(name), "units": "1", "quantity": quantity_of(name)}
    labelled = []
    for evidence in branches.values():
        branch = label_evidence(model.take(slice(None)), evidence, plan.options(), "bifurcation diagram")
        branch = branch.drop_vars([str(c) for c in branch.coords]).rename({"member": name})
        labelled.append(branch.assign_coords({name: (name, values, attrs)}))
    result = xr.concat(labelled, dim=xr.DataArray(list(branches), dims="branch", name="branch"))
    result.attrs = dataset.label(plan.model, {}, options=plan.options(), title="bifurcation diagram").attrs
    return result.assign_attrs(parameter=name)


def _thresholds(
    plans: list[Plan], branches: dict[str, Evidence], bisections: int, threads: int | None
) -> dict[str, Any]:
    """Every change of regime between neighbours, narrowed down from the state on the side it is met from."""
    (name, values) = next(iter(plans[0].over.items()))
    rows: list[tuple[str, int, int, float, float]] = []
    by_state = {f"from {p.initial[0]:g},{p.initial[1]:g}": p for p in plans}
    for branch, evidence in branches.items():
        codes = evidence.regime
        changes = np.flatnonzero(codes[1:] != codes[:-1])
        low, high = values[changes].copy(), values[changes + 1].copy()
        if branch in by_state:
            states = np.tile(np.asarray(by_state[branch].initial, dtype=float), (len(changes), 1))
        else:
            met = changes if branch == "up" else changes + 1
            states = np.where(
                np.isfinite(evidence.final[met]), evidence.final[met] + np.array([NUDGE, 0.0]), plans[0].initial
            )
        for _ in range(bisections if len(changes) else 0):
            middle = 0.5 * (low + high)
            found = np.empty(len(changes), dtype=np.int8)
            for first in range(0, len(changes), CHUNK):
                part = slice(first, first + CHUNK)
                model, _ = plans[0].at({name: middle[part]})
                found[part] = plans[0].classify(model, states[part], threads).regime
            # What is neither kind lies between them too; the side that keeps its kind moves up.
            below = found == codes[changes]
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        rows += [
            (branch, int(a), int(b), float(lo), float(hi))
            for a, b, lo, hi in zip(codes[changes], codes[changes + 1], low, high, strict=True)
        ]
    columns = list(zip(*rows, strict=True)) if rows else [(), (), (), (), ()]

    def column(i: int, kind: Any, long_name: str, quantity: str) -> tuple[str, Any, dict[str, str]]:
        return (
            "threshold",
            np.array(columns[i], dtype=kind),
            {"long_name": long_name, "units": "1", "quantity": quantity},
        )

    return {
        "threshold_branch": column(0, str, "branch on which the regime changes", "code"),
        "threshold_from": column(1, np.int8, "regime below the change", "code"),
        "threshold_to": column(2, np.int8, "regime above the change", "code"),
        "threshold_low": column(3, float, "change lies above this value", quantity_of(name)),
        "threshold_high": column(4, float, "change lies at or below this value", quantity_of(name)),
    }


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
