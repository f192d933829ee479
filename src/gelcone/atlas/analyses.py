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
from gelcone.codes import Outcome
from gelcone.errors import InputError, unknown_name
from gelcone.motion.driven import DRIVEN_LIMITS
from gelcone.motion.envelope import STATIC_LIMITS, limits_at
from gelcone.motion.equilibrium import pitchfork_voltage, pull_in_voltage
from gelcone.motion.floquet import onset_voltage
from gelcone.motion.linear import linear_response
from gelcone.motion.lyapunov import average, default_transient
from gelcone.motion.regime import label_evidence
from gelcone.motion.section import repeats_lasting, settle
from gelcone.motion.swing import Swing, settled_swing
from gelcone.physics.model import ConeModel
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


def responses(plan: Plan, model: ConeModel, states: Array) -> xr.Dataset:
    """The settled motion at full drive and the linear response to it: over drive frequencies, a frequency response.

    Each cell starts from its initial state; `gelcone.frequency_response` sweeps up and down. Without damping no motion
    settles, and the outcome says so.
    """
    damped = np.broadcast_to(model.damping_ratio, model.shape) > 0.0
    found, linear = Swing.blank(model.size), np.full(model.size, np.nan)
    found.outcome[~damped] = Outcome.ERROR
    if damped.any():
        found.put(damped, settled_swing(model.take(damped), states[damped], tolerance=plan.tolerance, threads=1))
    for cell in np.flatnonzero(found.outcome == Outcome.OK):
        alone = model.take(cell)
        linear[cell] = linear_response(alone, np.array([alone.drive_frequency])).stroke[0]
    phase = np.where(np.abs(found.harmonics) > 0.0, np.degrees(np.angle(found.harmonics)), np.nan)
    variables = {
        "stroke": ((), 2.0 * found.amplitude, "stroke of the settled motion, peak to peak", "length"),
        "lowest": ((), found.lowest, "lowest displacement", "length"),
        "highest": ((), found.highest, "highest displacement", "length"),
        "period": ((), found.period, "period in drive repeats, 0 if none", "count"),
        "harmonic_amplitude": (("harmonic",), np.abs(found.harmonics), "amplitudes of harmonics 1 to 4", "length"),
        "harmonic_phase": (("harmonic",), phase, "their phases, degrees ahead of the voltage's", "angle"),
        "linear_stroke": ((), linear, "stroke by linear theory", "length"),
    }
    return dataset.label(model, variables, outcome=found.outcome, options={}, title="responses")


def envelopes(plan: Plan, model: ConeModel, states: Array) -> xr.Dataset:
    """Peak voltages at which an operating envelope ends, quasi-static and at the cell's drive frequency.

    As `gelcone.envelope` finds them from rest, up to twice the cell's own peak voltage, which must not be 0; dielectric
    breakdown is unknown (NaN) and of no account where the plan has no ``field_limit``.
    """
    meanings = {"safe peak": "below every limit", "driven error": "width to which the driven limits are known"}
    meanings |= {name: f"quasi-static limit: {name}" for name in STATIC_LIMITS}
    meanings |= {f"driven {name}": f"limit at the drive frequency: {name}" for name in DRIVEN_LIMITS}
    found = {name: np.full(model.size, np.nan) for name in meanings}
    outcome = np.full(model.size, Outcome.OUTSIDE)
    for cell in np.flatnonzero(model.strain(np.zeros(model.size)) < model.strain_limit()):
        try:
            values, outcome[cell] = limits_at(model.take(cell), plan.field_limit), Outcome.OK
        except InputError:
            values, outcome[cell] = {}, Outcome.ERROR
        for name, value in values.items():
            found[name][cell] = value
    variables = {
        f"{name.replace(' ', '_').replace('-', '_')}_voltage": ((), values, meanings[name], "voltage")
        for name, values in found.items()
    }
    return dataset.label(model, variables, outcome=outcome, options={}, title="envelopes")


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
