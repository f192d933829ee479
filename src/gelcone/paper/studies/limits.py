"""Studies behind claims alone: the linear limit, small and large stretch limits, and the fixed-step integrator."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone import dataset
from gelcone.atlas import maps
from gelcone.motion.attractor.classification import classify
from gelcone.motion.flow import integrate
from gelcone.motion.settled import swing
from gelcone.paper.effort import Effort
from gelcone.paper.fixed_step import fixed_step
from gelcone.paper.studies.study import Progress, Study
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

STARTS = 4
NEARBY = 1e-9
STEP = 0.05
"""Step of the fixed-step runs: about 120 steps to a small oscillation, usual in this field."""


def linear_limit(effort: Effort, progress: Progress) -> xr.Dataset:
    """Period of the free undamped neo-Hookean oscillator over its amplitude, against 2 pi/sqrt(kappa)."""
    amplitudes = np.geomspace(1e-3, 1.0, 31)
    stiffness = float(effort.preset("base").model.spring_stiffness)
    free = ConeModel(damping_ratio=0.0, voltage=0.0, stretch_limit=np.inf)
    model = free.replace(spring_stiffness=np.full(len(amplitudes), stiffness))
    linear = 2.0 * np.pi / np.sqrt(stiffness)
    times = linear * np.linspace(0.0, 1.2, 4001)
    states = np.stack([amplitudes, np.zeros_like(amplitudes)], axis=1)
    run = integrate(model, states, times)
    period = np.array([_quarter(times, x) * 4.0 for x in run.states[..., 0]])
    progress(1.0)
    return dataset.label(
        model,
        {"period_ratio": ((), period / linear, "period over that of the linear oscillator", "share")},
        coords={"amplitude": ((), amplitudes, "initial displacement", "length")},
        outcome=run.outcome,
        options={},
        title="linear limit",
    )


def _quarter(times: Any, displacement: Any) -> float:
    """First time at which the displacement is zero, by linear interpolation between close samples."""
    k = int(np.flatnonzero(displacement <= 0.0)[0])
    before, after = displacement[k - 1], displacement[k]
    return float(times[k - 1] + (times[k] - times[k - 1]) * before / (before - after))


def limit_map(effort: Effort, progress: Progress) -> xr.Dataset:
    """Regimes over voltage and stretch limit, at the fast set."""
    voltages, limits = effort.limit_map
    over = {"voltage": np.linspace(0.7, 1.6, voltages), "stretch_limit": np.geomspace(0.52, 50.0, limits)}
    return _map("fast", over, effort, progress)


def damping_map(effort: Effort, progress: Progress) -> xr.Dataset:
    """Regimes over voltage and damping ratio, at the base set."""
    over = {"voltage": np.linspace(0.5, 2.0, 2 * effort.limit_map[0] - 1), "damping_ratio": np.linspace(0.02, 2.0, 34)}
    return _map("base", over, effort, progress)


def _map(name: str, over: dict[str, Array], effort: Effort, progress: Progress) -> xr.Dataset:
    preset = effort.preset(name)
    result = maps.map(preset.model, over, preset.initial, patience=effort.patience, progress=progress)
    return result.assign_attrs(preset=name)


def beyond(effort: Effort, progress: Progress) -> xr.Dataset:
    """Small stretch limits: the paper's integrator from the paper's initial state, which lies beyond the limit for
    J < 0.5, and the true motion from half the displacement that the limit allows."""
    preset = effort.preset("fast")
    limits = np.geomspace(0.02, 2.0, effort.limit_map[1])
    model = preset.model.replace(stretch_limit=limits)
    run = fixed_step(model, preset.initial, STEP, int(effort.window / STEP))
    progress(0.5)
    half, start = 0.5 * _reach(model), np.full(len(limits), preset.initial[0])
    inside = np.stack([half, np.zeros_like(half)], axis=1)
    evidence = classify(model.members(), inside, patience=effort.patience)
    progress(0.5)
    return dataset.label(
        model,
        {
            "fixed_step_exponent": ((), run.exponent, "largest exponent of the fixed-step run over the window", "rate"),
            "fixed_step_beyond": ((), run.beyond, "share of its steps beyond the stretch limit", "share"),
            "initial_strain": ((), model.strain(start), "I1 - 3 at the start", "share"),
            "inside_start": ((), half, "displacement from which the true motion starts", "length"),
            "lyapunov": (("exponent",), evidence.exponents, "Lyapunov exponents of the true motion", "rate"),
            "standard_error": (("exponent",), evidence.standard_error, "standard error of the exponents", "rate"),
            "regime": ((), evidence.regime, "kind of motion of the true motion", "code"),
        },
        outcome=evidence.outcome,
        options={"step": STEP, "window": effort.window},
        title="beyond the stretch limit",
    )


def _reach(model: ConeModel) -> Any:
    """Largest displacement inside the stretch limit, by bisection, per member."""
    low, high = np.zeros(model.size), np.full(model.size, 100.0)
    for _ in range(60):
        middle = 0.5 * (low + high)
        inside = model.strain(middle) < model.strain_limit()
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return low


def large_limits(effort: Effort, progress: Progress) -> xr.Dataset:
    """Displacement over a window for large stretch limits, and its extent in the long run, at the fast set.

    The long run is that of `STARTS` starts within `NEARBY` of the paper's: where the start decides, they differ.

    The voltages go around 1.005, that of the paper's own picture, which is among them.
    """
    preset = effort.preset("fast")
    limits = np.array([100.0, 300.0, 1000.0])
    voltages = np.sort([*np.linspace(0.5, 1.7, 12), 1.005])[:, None]
    model = preset.model.replace(stretch_limit=limits, voltage=voltages)
    times = np.linspace(0.0, effort.window, 2001)
    run = integrate(model, np.tile(preset.initial, (model.size, 1)), times)
    progress(0.1)
    offsets = NEARBY * np.linspace(-1.0, 1.0, STARTS)
    nearby = model.replace(stretch_limit=limits[:, None] + 0.0 * offsets, voltage=voltages[:, None])
    starts = np.asarray(preset.initial) + np.stack([np.tile(offsets, model.size)] * 2, axis=1)
    evidence = classify(nearby.members(), starts, patience=effort.patience)
    progress(0.8)
    late = swing(nearby.members(), evidence.final)
    progress(0.1)
    regime = evidence.regime.reshape(model.size, STARTS)
    ends = {name: getattr(late, name).reshape(model.size, STARTS) for name in ("lowest", "highest")}
    return dataset.label(
        model,
        {
            "displacement": (("time",), run.states[..., 0], "displacement x = h/(b-a)", "length"),
            "highest": (("start",), ends["highest"], "highest displacement in the long run, nearby starts", "length"),
            "lowest": (("start",), ends["lowest"], "lowest displacement in the long run, nearby starts", "length"),
            "regime": (("start",), regime, "kind of motion in the long run", "code"),
        },
        coords={"time": (("time",), times, "time", "time")},
        outcome=run.outcome,
        options={"window": effort.window, "nearby": NEARBY},
        title="large stretch limits",
    )


STUDIES = (
    Study("linear-limit", linear_limit, work=0.1),
    Study("limit-map", limit_map, work=3.5),
    Study("damping-map", damping_map, work=1.5),
    Study("beyond", beyond, work=3.0, any_film=False),
    Study("large-limits", large_limits, work=1.5),
)
