"""Studies behind claims alone: the linear limit, small and large stretch limits, and the fixed-step integrator."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from gelcone import dataset
from gelcone.atlas import maps
from gelcone.bracket import crossing
from gelcone.dataset import attributes
from gelcone.motion.attractor.classification import classify
from gelcone.motion.attractor.search import NEARBY
from gelcone.motion.flow import integrate
from gelcone.motion.start import complete, start_states
from gelcone.motion.swing import swing
from gelcone.paper.effort import Effort
from gelcone.paper.fixed_step import fixed_step
from gelcone.paper.reading import STARTS
from gelcone.paper.sampling import SIGN_BUDGET, Sample, sampled
from gelcone.paper.studies.diagrams import PANELS
from gelcone.paper.studies.samples import half, rows_same
from gelcone.paper.studies.study import OF_FORCE, Progress, Study, reach_of
from gelcone.physics.model import ConeModel

if TYPE_CHECKING:
    import xarray as xr

LARGE = (100.0, 300.0, 1000.0)
OWN_VOLTAGE = PANELS["fast", "stretch_limit"]
STEP = 0.05
"""Step of the fixed-step runs: about 120 steps per small oscillation, usual in this field."""


def linear_limit(effort: Effort, progress: Progress) -> xr.Dataset:
    """Period of the free undamped neo-Hookean oscillator over its amplitude, relative to 2 pi/sqrt(kappa)."""
    amplitudes = np.geomspace(1e-3, 1.0, 31)
    stiffness = float(effort.preset("base").model.spring_stiffness)
    free = ConeModel(damping_ratio=0.0, voltage=0.0, stretch_limit=np.inf, film=effort.film)
    model = free.replace(spring_stiffness=np.full(len(amplitudes), stiffness))
    linear = 2.0 * np.pi / np.sqrt(stiffness)
    times = linear * np.linspace(0.0, 1.2, 4001)
    states = np.stack([amplitudes, np.zeros_like(amplitudes)], axis=1)
    run = integrate(model, states, times)
    period = np.array([crossing(times, -x, 0.0) * 4.0 for x in run.states[..., 0]])
    progress(1.0)
    return dataset.label(
        model,
        {"period_ratio": ((), period / linear, "period over that of the linear oscillator", "share")},
        coords={"amplitude": ((), amplitudes, "initial displacement", "length")},
        outcome=run.outcome,
        options={},
        title="linear limit",
    )


def limit_map(effort: Effort, progress: Progress) -> xr.Dataset:
    """Regimes over voltage and stretch limit, at the fast set."""
    voltages, limits = effort.limit_map
    over = {"voltage": np.linspace(0.7, 1.6, voltages), "stretch_limit": np.geomspace(0.52, 50.0, limits)}
    preset = effort.preset("fast")
    result = maps.map(preset.model, over, preset.initial, patience=effort.patience, progress=progress)
    return result.assign_attrs(preset="fast")


def beyond(effort: Effort, progress: Progress) -> xr.Dataset:
    """Small stretch limits: the paper's integrator from its initial state, which lies beyond the limit for J < 0.5, and
    the true motion from half the displacement that the limit allows."""
    preset = effort.preset("fast")
    limits = np.geomspace(0.02, 2.0, effort.limit_map[1])
    model = preset.model.replace(stretch_limit=limits)
    run = fixed_step(model, preset.initial, STEP, int(effort.window / STEP))
    progress(0.5)
    half, start = 0.5 * reach_of(model), np.full(len(limits), preset.initial[0])
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


def large_limits(effort: Effort, progress: Progress) -> xr.Dataset:
    """Long-run extents for three large ``limit``s, at the fast set: ``extent`` over a sample of other voltages and
    nearby ``start``s; ``own_extent`` and ``displacement`` over a window at the voltage of the paper's figure."""
    others = Sample("voltage", "fast", {"voltage": (0.5, 1.7)}, partial(half, rows_same), costly=True)
    result = sampled((others,), effort, lambda done: progress(0.8 * done), _extents)
    preset = effort.preset("fast")
    model = preset.model.replace(stretch_limit=np.array(LARGE), voltage=np.full(len(LARGE), OWN_VOLTAGE))
    times = np.linspace(0.0, effort.window, 2001)
    run = integrate(model, start_states(model, preset.initial), times)
    extents = _extents(model.take([0]), preset.initial, effort).isel(member=0)
    progress(0.2)
    return result.assign(
        displacement=(("limit", "time"), run.states[..., 0], attributes("displacement x = h/(b-a)", "length")),
        own_extent=extents["extent"],
        own_regime=extents["regime"],
    ).assign_coords(limit=("limit", np.array(LARGE), attributes("stretch limit", "parameter")))


def _extents(model: ConeModel, initial: tuple[float, float], effort: Effort) -> xr.Dataset:
    """Long-run extents of every member at the limits `LARGE`, from `STARTS` starts within `NEARBY`."""
    shape = (model.size, len(LARGE), STARTS)
    offsets = NEARBY * np.linspace(-1.0, 1.0, STARTS)
    members = model.members().take(np.repeat(np.arange(model.size), len(LARGE) * STARTS))
    limits = np.broadcast_to(np.array(LARGE)[:, None], shape).ravel()
    nearby = model.replace(voltage=members.number("voltage"), stretch_limit=limits)
    starts = np.asarray(initial) + np.tile(offsets, model.size * len(LARGE))[:, None]
    members = nearby.members()
    evidence = classify(members, complete(members, starts), patience=effort.patience, budget=SIGN_BUDGET)
    # mirror images count as the same motion: the start decides between them
    late = swing(members, evidence.final)
    extent = np.fmax(np.abs(late.highest), np.abs(late.lowest)).reshape(shape)
    described: dict[str, dataset.Variable] = {
        "extent": (("limit", "start"), extent, "largest displacement in the long run, nearby starts", "length"),
        "regime": (("limit", "start"), evidence.regime.reshape(shape), "kind of motion in the long run", "code"),
    }
    ended = evidence.outcome.reshape(shape).max(axis=(1, 2))
    return dataset.label(model, described, outcome=ended, options={"nearby": NEARBY}, title="large stretch limits")


STUDIES = (
    Study("linear-limit", linear_limit, work=0.1, films=OF_FORCE),
    Study("limit-map", limit_map, work=2.0),
    Study("beyond", beyond, work=3.0, films=()),
    Study("large-limits", large_limits, work=5.0),
)
