"""Studies behind figure 13: bifurcation diagrams with exponents in the long run and over a finite window."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.atlas.bifurcation import bifurcation
from gelcone.atlas.branches.attached import attached_branches
from gelcone.atlas.plan import Plan
from gelcone.dataset import Table, attributes, columns
from gelcone.motion.floquet import floquet_multipliers
from gelcone.motion.lyapunov import finite_exponents
from gelcone.motion.start import complete
from gelcone.paper.effort import Effort
from gelcone.paper.films import WRINKLING
from gelcone.paper.studies.cascade import cascade
from gelcone.paper.studies.study import OF_MOTION, Progress, Study
from gelcone.physics.members import Members
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

PANELS: dict[tuple[str, str], float] = {
    ("base", "damping_ratio"): 0.5,
    ("base", "voltage"): 0.5,
    ("base", "prestretch"): 1.0,
    ("base", "stretch_limit"): 1.04,
    ("fast", "damping_ratio"): 1.005,
    ("fast", "voltage"): 1.005,
    ("fast", "prestretch"): 1.005,
    ("fast", "stretch_limit"): 1.005,
}
"""Parameter set and swept parameter -> voltage of the panel (reconstructed; unused if the voltage is swept)."""


def values_of(preset: str, parameter: str, effort: Effort) -> Array:
    """Values of a swept parameter: the paper's ranges for damping and voltage (text), the others reconstructed.

    The voltage at the base set has twice the resolution, as the paper's threshold lies there.
    """
    count = 2 * effort.diagram_values - 1 if (preset, parameter) == ("base", "voltage") else effort.diagram_values
    if parameter == "stretch_limit":
        # Below 0.5 the initial state (1, 0) lies beyond the stretch limit.
        return np.geomspace(0.52, 100.0, count)
    begin, end = {"damping_ratio": (0.0, 2.0), "voltage": (0.0, 2.0), "prestretch": (0.4, 2.0)}[parameter]
    return np.linspace(begin, end, count)


def diagram_name(preset: str, parameter: str) -> str:
    """Name of the study of one panel."""
    return f"diagram-{preset}-{parameter.replace('_', '-')}"


def diagram(preset_name: str, parameter: str, effort: Effort, progress: Progress) -> xr.Dataset:
    """The diagram of one panel, with exponents over the window from the start: ``finite`` (parameter, exponent).

    Over the voltage, branches of periodic orbits are attached (`gelcone.atlas.branches.attached`), and the doublings
    that lead to chaos (`gelcone.paper.studies.cascade`).
    """
    preset = effort.preset(preset_name)
    model = preset.model.replace(voltage=PANELS[preset_name, parameter])
    values = values_of(preset_name, parameter, effort)
    result = bifurcation(
        model,
        parameter,
        values,
        initial=preset.initial,
        sweeps=effort.sweeps,
        bisections=effort.bisections,
        branches=parameter == "voltage" and effort.film == "taut",
        patience=effort.patience,
        progress=progress,
    )
    result = result.assign(over_plan(Plan(model, {parameter: values}, preset.initial), effort))
    followed = attached_branches(result)
    if followed is not None:
        result = result.assign(cascade(model, followed))
    return result.assign_attrs(preset=preset_name, window=effort.window)


def over_plan(plan: Plan, effort: Effort) -> dict[str, Any]:
    """Exponents ``finite`` of every cell over the window from the start, and the stability of its rest."""
    model, states = plan.at(plan.grid)
    members = model.members()
    values, *_ = finite_exponents(members, complete(members, states), effort.window, {})
    about = attributes("Lyapunov exponents over the window from the start", "rate")
    finite = (*plan.over, "exponent"), values.reshape((*plan.shape, -1)), about
    return {"finite": finite} | rest_stability(members, tuple(plan.over), plan.shape)


def rest_stability(members: Members, dims: tuple[str, ...], shape: tuple[int, ...]) -> dict[str, Any]:
    """Stability of rest at every value by theory: growth rate under the drive, and stiffness at the peak voltage."""
    growth = floquet_multipliers(members)["growth_rate"].values.reshape(shape)
    static = np.asarray(members.stiffness(np.zeros(members.size), members.voltage)).reshape(shape)
    table: Table = {
        "rest_growth": (growth, "growth rate of deviations from rest under the drive", "rate"),
        "static_stiffness": (static, "small-signal stiffness of rest at the peak voltage", "stiffness"),
    }
    return columns(dims, table)


FOLLOWED = (("base", "voltage"), ("fast", "voltage"), ("base", "damping_ratio"))
"""Panels also computed with the creeping film, for claims judged with it."""

STUDIES = tuple(
    Study(
        diagram_name(*panel),
        partial(diagram, *panel),
        # Half of the voltages of the base set are chaotic, with many windows between.
        work=14.0 if panel == ("base", "voltage") else 2.5,
        films=OF_MOTION if panel in FOLLOWED else (WRINKLING,),
    )
    for panel in PANELS
)
