"""The cone compared with the film as a continuum: the forces of figure 3, and corrected thresholds."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gelcone import dataset
from gelcone.codes import Outcome, Regime
from gelcone.errors import MissingDependency
from gelcone.motion.attractor.classification import classify
from gelcone.motion.floquet import onset_voltage
from gelcone.motion.static_bifurcations import pitchfork_voltages, pull_in_voltage
from gelcone.paper.effort import Effort
from gelcone.paper.studies.statics import STATIC_VOLTAGES
from gelcone.paper.studies.study import OF_FORCE, Progress, Study
from gelcone.paper.unwrinkled import UnwrinkledFilm
from gelcone.physics.model import ConeModel
from gelcone.physics.statics import every_balance
from gelcone.presets import find_preset
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr


RADIUS_RATIOS = (0.2, 0.5)
"""Radius ratio of the paper's Table 1, and that of a larger disc."""
ELEMENTS = 30
FARTHEST = 1.3
"""Largest displacement, from figure 3."""
CHAOS = (0.9, 1.1)
"""Voltages between which the cone at the base set becomes chaotic; the corrected film is examined up to the lower
one."""
SOFT = 0.1
"""Smallest spring stiffness of figure 12."""
HIGH_PRESTRETCH = 1.5
DIGITS, ERROR_DIGITS = 8, 3
"""Stored digits of finite-element results, and of their error estimates."""
TAUT, CORRECTED = "taut", "thresholds in the corrected model"
MISSING = "missing"
"""Attribute with the reason why a study could not be computed."""


class Threshold(NamedTuple):
    """A threshold in the cone and in the corrected model, each an interval; ``lost`` is the voltage at which the
    corrected film loses its last state before, NaN if it does not."""

    name: str
    cone: tuple[float, float]
    corrected: tuple[float, float]
    lost: float


def continuum(effort: Effort, progress: Progress) -> xr.Dataset:
    """Force of film and field over displacement at the voltages of figure 3, cone and continuum, for both radius
    ratios; both wrinkle with another film than the paper's. Without scikit-fem an empty Dataset with the reason."""
    from gelcone.continuum.compare import compare

    model = find_preset("table1").model.replace(voltage=0.0)
    relaxed = effort.film != TAUT
    few = 5 if relaxed else 8  # the search for pull-in takes most of the time
    x = np.linspace(0.1, FARTHEST, few if effort.name == "quick" else 15)
    try:
        result = compare(
            model,
            RADIUS_RATIOS,
            displacements=x,
            voltages=STATIC_VOLTAGES,
            wrinkles="relax" if relaxed else "mark",
            elements=ELEMENTS,
            progress=progress,
        )
    except MissingDependency as error:
        return _missing(model, error)
    rounded = {name: _rounded(values) for name, values in result.data_vars.items() if values.dtype.kind == "f"}
    return result.assign(rounded).assign_attrs(preset="table1", film=effort.film)


def _rounded(values: xr.DataArray) -> xr.DataArray:
    """Values rounded to significant digits: the last bits of linear algebra differ between processors, but the report
    must not."""
    size = float(np.nanmax(np.abs(values.values), initial=0.0))
    if not 0.0 < size < np.inf:
        return values
    digits = ERROR_DIGITS if str(values.name).endswith("_error") else DIGITS
    return values.copy(data=np.round(values.values, digits - 1 - math.floor(math.log10(size))))


def corrected(effort: Effort, progress: Progress) -> xr.Dataset:
    """The paper's thresholds in the cone and with the continuum film of a/b = 0.2 instead; for the taut film alone."""
    base = find_preset("base").model
    if effort.film != TAUT:
        nothing = dataset.label(base, {}, options={}, title=CORRECTED)
        return nothing.assign_attrs(preset="base", threshold_names="[]", fit_errors="{}")
    try:
        rows, errors = _thresholds(effort, progress)
    except MissingDependency as error:
        return _missing(base, error)
    names, cone, corrected, lost = zip(*rows, strict=True)
    ends = ("threshold", "end")
    numbers: dict[str, dataset.Variable] = {
        "cone": (ends, cone, "threshold in the homogeneous cone", "voltage"),
        "corrected": (ends, corrected, "threshold with the continuum film", "voltage"),
        "lost": (ends[:1], lost, "voltage at which the continuum film has no state any more", "voltage"),
    }
    result = dataset.label(base, numbers, options={}, title=CORRECTED)
    return result.assign_attrs(preset="base", threshold_names=json.dumps(names), fit_errors=json.dumps(errors))


def _thresholds(effort: Effort, progress: Progress) -> tuple[list[Threshold], dict[str, float]]:
    """The thresholds in both models, and the errors of the fit at the base set."""
    base, fast = find_preset("base").model, find_preset("fast").model
    stretched = base.replace(prestretch=HIGH_PRESTRETCH, prestretch_mode="equibiaxial")
    film = _film(base)
    progress(0.3)
    tight = _film(stretched)
    progress(0.3)
    start = np.array(find_preset("base").initial)
    rows = [
        _pitchfork("static pitchfork, set base", base, film),
        _pitchfork("static pitchfork, set fast", fast, film),
        _pitchfork(f"static pitchfork, spring stiffness {SOFT:g}", base.replace(spring_stiffness=SOFT), film),
        _pitchfork(f"static pitchfork, set base with equi-biaxial pre-stretch {HIGH_PRESTRETCH:g}", stretched, tight),
        _onset("loss of stability of rest under the drive, set base", base, film),
        _onset("loss of stability of rest under the drive, set fast", fast, film),
        _chaos("chaos, set base", base, film, start, 9 if effort.name == "quick" else 33),
    ]
    progress(0.4)
    return rows, dict(film.errors)


def _film(model: ConeModel) -> UnwrinkledFilm:
    """The continuum of the paper's film, which bears compression."""
    from gelcone.paper.unwrinkled_fit import fit_unwrinkled

    return fit_unwrinkled(model, RADIUS_RATIOS[0])


def _missing(model: ConeModel, error: MissingDependency) -> xr.Dataset:
    return dataset.label(model, {}, options={}, title="continuum").assign_attrs({MISSING: str(error)})


def _pitchfork(name: str, model: ConeModel, film: UnwrinkledFilm) -> Threshold:
    cone = float(pitchfork_voltages(every_balance(model))[0])
    fitted = model.replace(film=film)
    voltage = float(pitchfork_voltages(every_balance(fitted))[0])
    if not np.isfinite(voltage):
        return Threshold(name, (cone, cone), (np.nan, np.nan), float(pull_in_voltage(fitted)["pull_in_voltage"]))
    return Threshold(name, (cone, cone), _with_fit_error(model, film, voltage), np.nan)


def _with_fit_error(model: ConeModel, film: UnwrinkledFilm, voltage: float) -> tuple[float, float]:
    """The interval of a threshold due to the error of the fit, from the membrane at a small height and that voltage."""
    from gelcone.continuum.membrane import membrane

    x = 0.02
    state = membrane(model, film.radius_ratio, displacements=x, voltages=voltage, elements=ELEMENTS)
    difference = float(state["force"].values.ravel()[0]) / x - float(film.stiffness(x * x, voltage**2)[0]) + voltage**2
    off = abs(difference) / (2.0 * voltage * float(film.gain(0.0, voltage**2)))
    return voltage - off, voltage + off


def _onset(name: str, model: ConeModel, film: UnwrinkledFilm) -> Threshold:
    cone, fitted = (onset_voltage(m) for m in (model, model.replace(film=film)))
    ends = [_interval(onset) for onset in (cone, fitted)]
    lost = np.nan if np.isfinite(ends[1][0]) else float(np.sqrt(film.highest_squared(0.0, {})))
    return Threshold(name, ends[0], ends[1], lost)


def _interval(found: xr.Dataset) -> tuple[float, float]:
    onset, error = float(found["onset_voltage"]), float(found["onset_error"])
    return onset - error, onset + error


def _chaos(name: str, model: ConeModel, film: UnwrinkledFilm, start: Array, count: int) -> Threshold:
    """The interval between evenly spaced voltages in which chaos first occurs from the paper's start."""
    voltages = np.linspace(*CHAOS, count)
    cone = _first(voltages, classify(model.replace(voltage=voltages).members(), start).regime == Regime.CHAOTIC)
    lower = np.linspace(0.1, CHAOS[0], count)
    seen = classify(model.replace(voltage=lower, film=film).members(), start)
    corrected = _first(lower, seen.regime == Regime.CHAOTIC)
    lost = _first(lower, seen.outcome == Outcome.PULLED_IN)
    return Threshold(name, cone, corrected, lost[1])


def _first(voltages: Array, met: Any) -> tuple[float, float]:
    indices = np.flatnonzero(met)
    if not indices.size:
        return np.nan, np.nan
    k = int(indices[0])
    return float(voltages[max(k - 1, 0)]), float(voltages[k])


STUDIES = (
    Study("continuum", continuum, work=3.0, films=OF_FORCE),
    Study("corrected", corrected, work=8.0, films=OF_FORCE),
)
