"""Studies behind figures 4, 5, 7, 10 and 11: motions at three values of a parameter.

Everything that the paper shows over a window from the start is also computed in the long run.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Outcome
from gelcone.dataset import attributes
from gelcone.motion.lyapunov import finite_exponents
from gelcone.motion.response import simulate
from gelcone.motion.section import section
from gelcone.motion.start import start_states
from gelcone.paper.effort import Effort
from gelcone.paper.films import WRINKLING
from gelcone.paper.studies.study import OF_MOTION, Progress, Study, about, kinds_of, merged
from gelcone.physics.model import ConeModel
from gelcone.presets import Preset
from gelcone.progress import Progress as MaybeProgress
from gelcone.progress import weighted
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

SPACING = 0.05
"""Sampling interval of a time response; the fastest swings shown take about 2."""
LATE_REPEATS = 32
"""Densely stored forcing periods of the long run."""

TRIPLES: dict[str, tuple[str, str, tuple[float, float, float], dict[str, float]]] = {
    "damping": ("base", "damping_ratio", (0.001, 0.05, 0.5), {"voltage": 0.5}),
    "limit": ("fast", "stretch_limit", (1.0, 10.0, 100.0), {"voltage": 1.005}),
    "voltage": ("base", "voltage", (0.5, 1.04, 1.7), {}),
    "prestretch": ("base", "prestretch", (0.8, 1.0, 1.5), {"voltage": 1.0}),
    "spring": ("spring", "spring_stiffness", (1.0, 5.0, 10.0), {}),
}
"""Study -> parameter set, the parameter with its three values, and other changes of the set. Only the voltage 1.04 is
from the paper's text; the other values are reconstructed."""


def triple(name: str, effort: Effort, progress: Progress) -> xr.Dataset:
    """The motions at three values of a parameter, see `motions`."""
    preset_name, parameter, values, changes = TRIPLES[name]
    preset = effort.preset(preset_name)
    model = preset.model.replace(**changes, **{parameter: np.array(values)})
    return motions(preset, model, parameter, effort, progress)


def motions(preset: Preset, model: ConeModel, parameter: str, effort: Effort, progress: Progress) -> xr.Dataset:
    """Motions of an ensemble over one parameter: over a window from the start, and in the long run.

    Dataset over the parameter with

    * the window: ``displacement``, ``velocity`` and ``slack`` over ``time``; with the prefix ``window_`` the
      ``lowest`` and ``highest`` displacement and the shares ``validity_*`` of its time (``slack``: either stress);
      ``early_section_*`` over ``early_repeat``; ``finite`` exponents with their running estimate;
    * the long run, after the transient until the regime settled: the same with the prefix ``late_``, over
      ``late_time`` from a multiple of the forcing period on; the section ``section_*`` over ``repeat``;
    * the variables of `gelcone.regime` (its ``lowest`` and ``highest``, coarsely sampled, left out).
    """
    kinds = kinds_of(model, preset.initial, effort)
    progress(0.3)
    repeat = model.members().forcing_period
    settled = int(np.ceil((kinds["settled_time"].values / repeat).max()))
    early_repeats = int(effort.window / repeat.min()) + 1
    early = section(model, preset.initial, repeats=early_repeats, discard=0, progress=weighted(progress, 0.1))
    late = section(
        model, preset.initial, repeats=effort.section_points, discard=settled, progress=weighted(progress, 0.3)
    )
    finite = finite_exponents(model.members(), start_states(model, preset.initial), effort.window, {})
    parts = [
        kinds.drop_vars(["lowest", "highest", "section"]),
        _finite(model, finite),
        _points(early, "early_section", "early_repeat"),
        _points(late, "section", "repeat"),
        _window(model, preset.initial, effort.window, "window", weighted(progress, 0.2)),
        _long_run(model, late, preset, weighted(progress, 0.1)),
    ]
    result = merged(*parts).swap_dims(member=parameter)
    options = {"initial": list(preset.initial), "window": effort.window, "settled_repeats": settled}
    return about(result, kinds, preset.name, parameter, effort, options, f"motions at three values of {parameter}")


def _points(points: xr.Dataset, prefix: str, dim: str) -> xr.Dataset:
    """Section points over ``dim``, as ``prefix_displacement`` and ``prefix_velocity``."""
    named = points[["displacement", "velocity"]].drop_vars("time").rename(repeat=dim)
    return named.rename(displacement=f"{prefix}_displacement", velocity=f"{prefix}_velocity")


def _long_run(model: ConeModel, late: xr.Dataset, preset: Preset, progress: MaybeProgress) -> xr.Dataset:
    """The time response after the last point of a section; NaN for a member that has failed before."""
    names = [state.name for state in model.members().system.states]
    ends = np.stack([late[name].isel(repeat=-1).values for name in names], axis=-1)
    states = np.where(np.isfinite(ends), ends, start_states(model, preset.initial))
    run = _window(model, states, LATE_REPEATS * float(model.members().forcing_period.max()), "late", progress)
    ran = late["outcome"] == Outcome.OK
    return run if ran.all() else run.where(ran)


def _window(model: ConeModel, states: npt.ArrayLike, length: float, name: str, progress: MaybeProgress) -> xr.Dataset:
    """A time response from ``states`` with its extent and validity, with the prefix of its window."""
    times = np.linspace(0.0, length, round(length / SPACING) + 1)
    run = simulate(model, states, times=times, progress=progress)
    slack = (run["hoop_stress"] < 0.0) | (run["meridional_stress"] < 0.0)
    kept = run[["displacement", "velocity"]]
    kept = kept.assign(slack=slack.astype(np.int8).assign_attrs(attributes("1 where the film is slack", "code")))
    shares = {str(n): f"{name}_{n}" for n in run if str(n).startswith("validity_") and n != "validity_breakdown"}
    described = {
        f"{name}_validity_slack": (kept["slack"].mean("time"), "share of slack film", "share"),
        f"{name}_lowest": (run["displacement"].min("time"), "lowest displacement", "length"),
        f"{name}_highest": (run["displacement"].max("time"), "highest displacement", "length"),
    }
    ends = {n: values.assign_attrs(attributes(*of)) for n, (values, *of) in described.items()}
    if name == "late":
        kept = kept.rename({n: f"late_{n}" for n in ("displacement", "velocity", "slack", "time")})
    else:
        kept = kept.assign(initial=run["initial"])
    return merged(kept.assign(ends), run[list(shares)].rename(shares))


def _finite(model: ConeModel, finite: tuple[Array, ...]) -> xr.Dataset:
    """The exponents over the window from the start."""
    values, running, *_ = finite
    variables = {
        "finite": (("exponent",), values, "Lyapunov exponents per unit time over the window", "rate"),
        "finite_time": (("window",), running[..., 0], "window length, from the start", "time"),
        "finite_exponent": (("window",), running[..., 1], "largest exponent over that window", "rate"),
    }
    return dataset.label(model, variables, options={}, title="")


FOLLOWED = {"voltage": OF_MOTION, "prestretch": OF_MOTION}
"""Films other than the paper's, for studies with more than the wrinkling one."""

STUDIES = tuple(Study(name, partial(triple, name), films=FOLLOWED.get(name, (WRINKLING,))) for name in TRIPLES)
