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
from gelcone.atlas.cells import Plan
from gelcone.errors import unknown_name
from gelcone.model import ConeModel
from gelcone.motion.equilibrium import pitchfork_voltage, pull_in_voltage
from gelcone.motion.floquet import onset_voltage
from gelcone.motion.flow import Outcome
from gelcone.motion.lyapunov import average, default_transient
from gelcone.motion.regime import label_evidence
from gelcone.motion.section import repeats_lasting, settle
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

Analysis = Callable[[Plan, ConeModel, Array], "xr.Dataset"]


def regimes(plan: Plan, model: ConeModel, states: Array) -> xr.Dataset:
    """Kind of motion with its evidence, as `gelcone.regime` gives it, without the section."""
    return sections(plan, model, states).drop_vars("section")


def sections(plan: Plan, model: ConeModel, states: Array) -> xr.Dataset:
    """Kind of motion with its evidence and 64 points of its Poincare section."""
    return label_evidence(model, plan.classify(model, states, threads=1), {}, "regime")


def exponents(plan: Plan, model: ConeModel, states: Array) -> xr.Dataset:
    """Both Lyapunov exponents in the long run, averaged after one transient, with their error."""
    duration = default_transient(model) if plan.transient is None else np.full(model.size, plan.transient)
    repeats = repeats_lasting(model, duration)
    settled, outcome = settle(model, states, repeats, tolerance=plan.tolerance, threads=1)
    found = average(model, settled, budget=plan.budget, tolerance=plan.tolerance, threads=1)
    outcome = np.where(outcome == Outcome.OK, found.outcome, outcome)
    variables = {
        "lyapunov": (("exponent",), found.values, "Lyapunov exponents per unit time", "rate"),
        "standard_error": (("exponent",), found.standard_error, "standard error of the exponents", "rate"),
        "sign": ((), found.sign, "sign of the largest exponent, 0 if uncertain", "code"),
        "averaged_time": ((), found.time, "averaging time behind the exponents", "time"),
    }
    return dataset.label(model, variables, outcome=outcome, options={}, title="exponents")


def limits(plan: Plan, model: ConeModel, states: Array) -> xr.Dataset:
    """Voltages that bound the use: loss of stability of rest under the drive, static pitchfork, pull-in."""
    inside = np.flatnonzero(model.strain(np.zeros(model.size)) < model.strain_limit())
    found = np.full((4, model.size), np.nan)
    outcome = np.full(model.size, Outcome.OUTSIDE)
    if inside.size:
        part = model.take(inside)
        onset = onset_voltage(part, tolerance=plan.tolerance, threads=1)
        pull_in = pull_in_voltage(part)
        found[:, inside] = [
            onset["onset_voltage"],
            onset["onset_error"],
            np.broadcast_to(pitchfork_voltage(part), part.shape),
            pull_in["pull_in_voltage"],
        ]
        outcome[inside] = onset["outcome"]
    variables = {
        "onset_voltage": ((), found[0], "voltage amplitude at which rest loses stability", "voltage"),
        "onset_error": ((), found[1], "width to which the onset is known", "voltage"),
        "pitchfork_voltage": ((), found[2], "constant voltage at which the flat film loses stability", "voltage"),
        "pull_in_voltage": ((), found[3], "constant voltage at which the equilibrium is lost", "voltage"),
    }
    return dataset.label(model, variables, outcome=outcome, options={}, title="limits")


ANALYSES: Mapping[str, Analysis] = {
    "regime": regimes,
    "section": sections,
    "lyapunov": exponents,
    "limits": limits,
}


def find_analysis(name: str) -> Analysis:
    """The analysis of that name; `InputError` with the nearest name when there is none."""
    if name not in ANALYSES:
        raise unknown_name("analysis", name, ANALYSES)
    return ANALYSES[name]


def compute(plan: Plan, analysis: str, cells: npt.NDArray[np.intp]) -> xr.Dataset:
    """An analysis of some cells of the flattened grid, over ``member`` in the order given."""
    model, states = plan.at(plan.values(cells))
    result = find_analysis(analysis)(plan, model.take(slice(None)), states)
    return result.reset_coords(drop=True)
