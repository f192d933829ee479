"""What a sweep can find out about its cells: analyses by name, each of a flat ensemble and its initial states.

An analysis is told the plan, the models of some cells and their initial states, and gives a Dataset over ``member``. A
member's numbers must depend on the member alone. Members that cannot start carry their outcome.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.atlas.plan import Plan
from gelcone.dataset import Findings
from gelcone.errors import unknown_name
from gelcone.motion.envelope import operating_limits_cells
from gelcone.motion.evidence import label_evidence
from gelcone.motion.limits import limits_cells
from gelcone.motion.lyapunov import lyapunov_cells
from gelcone.motion.settled import settled_cells
from gelcone.physics.members import Members
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

Analysis = Callable[[Plan, Members, Array], "xr.Dataset"]


def regimes(plan: Plan, model: Members, states: Array) -> xr.Dataset:
    """Kind of motion with its evidence, as `gelcone.regime` gives it, without the section."""
    return sections(plan, model, states).drop_vars("section")


def sections(plan: Plan, model: Members, states: Array) -> xr.Dataset:
    """Kind of motion with its evidence and 64 points of its Poincare section."""
    return label_evidence(model, plan.classify(model, states, threads=1), {}, "regime")


def exponents(plan: Plan, model: Members, states: Array) -> xr.Dataset:
    """All Lyapunov exponents, as `gelcone.lyapunov` gives them, without the running averages."""
    found = lyapunov_cells(
        model, states, transient=plan.transient, budget=plan.budget, tolerance=plan.tolerance, threads=1
    )
    return _labelled(model, found).drop_dims("window")


def limits(plan: Plan, model: Members, states: Array) -> xr.Dataset:
    """Voltages that bound the use, as `gelcone.motion.limits.limits` gives them."""
    return _labelled(model, limits_cells(model, states, tolerance=plan.tolerance, threads=1))


def responses(plan: Plan, model: Members, states: Array) -> xr.Dataset:
    """The settled motion at full drive, as `gelcone.motion.settled.settled` gives it."""
    return _labelled(model, settled_cells(model, states, tolerance=plan.tolerance, threads=1))


def envelopes(plan: Plan, model: Members, states: Array) -> xr.Dataset:
    """Peak voltages at which an operating envelope ends, as `gelcone.motion.envelope.operating_limits` gives them."""
    return _labelled(model, operating_limits_cells(model, states, field_limit=plan.field_limit, threads=1))


def _labelled(model: Members, found: Findings) -> xr.Dataset:
    return dataset.label(model, found.variables, outcome=found.outcome, options={}, title="sweep")


ANALYSES: Mapping[str, Analysis] = {
    "regime": regimes,
    "section": sections,
    "lyapunov": exponents,
    "limits": limits,
    "response": responses,
    "envelope": envelopes,
}


def find_analysis(name: str) -> Analysis:
    """The analysis of that name; `InputError` with the nearest name when there is none."""
    if name not in ANALYSES:
        raise unknown_name("analysis", name, ANALYSES)
    return ANALYSES[name]


def compute(plan: Plan, analysis: str, cells: npt.NDArray[np.intp]) -> xr.Dataset:
    """An analysis of some cells of the flattened grid, over ``member`` in the order given."""
    model, states = plan.at(plan.values(cells))
    result = find_analysis(analysis)(plan, model.members(), states)
    return result.reset_coords(drop=True)
