"""Operating envelope of a device: which limit comes first on the way up, at rest and at every drive frequency.

The drive is scaled as a whole, so that its peak - bias plus amplitude - says how high it is. Quasi-static limits belong
to the constant peak voltage reached on a slow ramp; driven limits to the settled motion that grows out of rest.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.errors import InputError
from gelcone.model import ConeModel
from gelcone.motion.equilibrium import pitchfork_voltage, pull_in_voltage, stroke_and_blocked_force
from gelcone.motion.floquet import onset_voltage
from gelcone.motion.flow import Outcome
from gelcone.motion.regime import Regime, classify
from gelcone.motion.response import NEAR_LIMIT, simulate
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

STATIC_LIMITS = ("dielectric breakdown", "hoop slack", "meridional slack", "stretch limit", "pitchfork", "pull-in")
DRIVEN_LIMITS = ("dielectric breakdown", "hoop slack", "meridional slack", "stretch limit", "chaos", "onset of rest")
"""``onset of rest``: rest loses its stability under the drive (Floquet), where rest is flat."""
STATIC_POINTS = 400
BISECTIONS = 6
CHUNK = 128
PERIODS = 12.0
"""Drive periods of the settled motion that are looked at."""
NUDGE = 1e-3
"""Displacement by which each motion starts off its rest, so that an unstable rest shows."""


@dataclass(frozen=True)
class Drive:
    """The device's drive with its peak scaled to 1: shares of amplitude and bias."""

    amplitude: float
    bias: float

    @classmethod
    def of(cls, model: ConeModel) -> Drive:
        peak = abs(float(model.voltage_bias)) + float(model.voltage)
        if peak == 0.0:
            raise InputError("voltage = 0: the envelope scales the device's drive; give it an amplitude or a bias")
        return cls(float(model.voltage) / peak, float(model.voltage_bias) / peak)


def envelope(
    model: ConeModel,
    *,
    field_limit: float | None = None,
    peaks: npt.ArrayLike | None = None,
    frequencies: npt.ArrayLike | None = None,
    margin: float = 0.2,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Limits over peak voltage and drive frequency, which comes first, and the window that is recommended.

    Parameters
    ----------
    model : a single model; its drive gives the proportion of amplitude to bias, its frequency the point of operation.
    field_limit : dielectric strength over sqrt(mu/eps). Left out, breakdown is reported as unknown (NaN).
    peaks : increasing peak voltages of the driven plane; default 24 up to twice the model's own peak.
    frequencies : increasing drive frequencies; default 24 from a tenth to three times the natural frequency at rest.
    margin : share of the lowest limit that the recommended voltage stays below it. Default 0.2.

    Returns
    -------
    Dataset with, over ``peak_voltage`` (quasi-static): ``static_displacement``, ``stroke``, ``blocked_force``,
    ``natural_frequency``, ``static_field``, ``static_hoop_stress``, ``static_meridional_stress``; over
    ``static_limit``: ``static_limit_voltage`` (infinity: not reached, NaN: unknown). Over ``drive_frequency`` and
    ``driven_peak``: ``driven_stroke``, ``driven_power`` (mean power of the source), ``driven_field``, ``regime``,
    ``outcome``; over ``driven_limit`` and ``drive_frequency``: ``limit_low`` and ``limit_high``, the interval of the
    peak voltage in which the limit is first met (both infinite: not up to the highest peak; both NaN: unknown or not
    applicable); ``first_limit``, its index (-1: none), and ``recommended_peak``, the lowest known limit, driven or
    quasi-static, less the margin.

    Raises
    ------
    InputError : for an ensemble, a drive without voltage, a margin outside [0, 1), or axes that do not increase.
    """
    if model.shape:
        raise InputError(f"an envelope is that of a single device, not of an ensemble of shape {model.shape}")
    if not 0.0 <= margin < 1.0:
        raise InputError(f"margin = {margin:g}: must be at least 0 and below 1")
    drive = Drive.of(model)
    own_peak = float(model.voltage) + abs(float(model.voltage_bias))
    report = progress or (lambda share: None)
    rest = float(stroke_and_blocked_force(model, [0.0])["rest_displacement"])
    natural = float(np.sqrt(max(model.stiffness(rest), 0.0)))
    volts = _axis("peaks", peaks, np.linspace(own_peak / 12.0, 2.0 * own_peak, 24))
    omegas = _axis("frequencies", frequencies, np.geomspace(0.1 * natural, 3.0 * natural, 24))
    plane = _Plane(model, drive, rest, field_limit, threads)
    shape = (len(omegas), len(volts))
    grid_omega, grid_peak = (mesh.ravel() for mesh in np.meshgrid(omegas, volts, indexing="ij"))
    seen = plane.look(grid_omega, grid_peak, lambda share: report(0.6 * share))
    low, high = _driven_limits(plane, seen, omegas, volts, lambda share: report(0.4 * share))
    static, static_limits = _static(model, drive, field_limit, max(float(volts[-1]), own_peak))
    known = np.where(np.isnan(low), np.inf, low)
    lowest_static = np.nanmin(static_limits, initial=np.inf)
    first = np.where(np.isfinite(known.min(axis=0)), known.argmin(axis=0), -1)
    recommended = (1.0 - margin) * np.minimum(np.minimum(known.min(axis=0), lowest_static), volts[-1])
    of_peak, of_frequency, of_both = ("peak_voltage",), ("drive_frequency",), ("drive_frequency", "driven_peak")
    return dataset.label(
        model,
        {name: (of_peak, values, *_STATIC[name]) for name, values in static.items() if name != "peak_voltage"}
        | {name: (of_both, seen[name].reshape(shape), *_DRIVEN[name]) for name in _DRIVEN}
        | {
            "static_limit_voltage": (
                ("static_limit",),
                static_limits,
                "peak voltage of the quasi-static limit",
                "voltage",
            ),
            "limit_low": (("driven_limit", *of_frequency), low, "the limit lies above this peak voltage", "voltage"),
            "limit_high": (("driven_limit", *of_frequency), high, "and at or below this one", "voltage"),
            "first_limit": (of_frequency, first, "index of the limit that comes first, -1 if none", "code"),
            "recommended_peak": (of_frequency, recommended, "recommended highest peak voltage", "voltage"),
            "rest_displacement": ((), np.array(rest), "rest without voltage", "length"),
        },
        coords={
            "peak_voltage": (of_peak, static["peak_voltage"], "constant peak voltage", "voltage"),
            "drive_frequency": (of_frequency, omegas, "drive frequency", "frequency"),
            "driven_peak": (("driven_peak",), volts, "peak voltage of the drive", "voltage"),
            "static_limit": (("static_limit",), np.array(STATIC_LIMITS), "quasi-static limit", "code"),
            "driven_limit": (("driven_limit",), np.array(DRIVEN_LIMITS), "limit of the driven motion", "code"),
        },
        options={"field_limit": field_limit, "margin": margin},
        title="operating envelope",
    )


_STATIC = {
    "static_displacement": ("displacement on a slow voltage ramp", "length"),
    "stroke": ("displacement from the rest without voltage", "length"),
    "blocked_force": ("force on a stop at the rest position", "force"),
    "natural_frequency": ("natural frequency about the equilibrium", "frequency"),
    "static_field": ("true electric field", "field"),
    "static_hoop_stress": ("true hoop stress", "stress"),
    "static_meridional_stress": ("true meridional stress", "stress"),
}
_DRIVEN = {
    "driven_stroke": ("stroke of the settled motion, peak to peak", "length"),
    "driven_power": ("mean power of the voltage source", "power"),
    "driven_field": ("highest true field", "field"),
    "regime": ("kind of motion", "code"),
    "outcome": ("how the run ended", "code"),
}


def _axis(name: str, values: npt.ArrayLike | None, default: Array) -> Array:
    axis = default if values is None else np.atleast_1d(np.asarray(values, dtype=float))
    if axis.ndim != 1 or axis.size < 2 or not np.isfinite(axis).all() or axis[0] <= 0.0 or (np.diff(axis) <= 0.0).any():
        raise InputError(f"{name}: must be at least 2 positive numbers that increase")
    return axis


# --- driven ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Plane:
    """The device at any peak voltage and drive frequency, started off its rest."""

    model: ConeModel
    drive: Drive
    rest: float
    field_limit: float | None
    threads: int | None

    def at(self, omegas: Array, peaks: Array) -> ConeModel:
        return self.model.replace(
            drive_frequency=omegas, voltage=self.drive.amplitude * peaks, voltage_bias=self.drive.bias * peaks
        )

    def look(self, omegas: Array, peaks: Array, progress: Callable[[float], None]) -> dict[str, Any]:
        """What the settled motion does at pairs of frequency and peak, arrays (pairs,); and which limits it meets."""
        parts = []
        for first in range(0, len(omegas), CHUNK):
            part = slice(first, first + CHUNK)
            parts.append(self._look(self.at(omegas[part], peaks[part])))
            progress(len(parts[-1]["regime"]) / len(omegas))
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}

    def _look(self, model: ConeModel) -> dict[str, Any]:
        start = np.tile([self.rest + NUDGE, 0.0], (model.size, 1))
        evidence = classify(model, start, threads=self.threads)
        ran = evidence.outcome == Outcome.OK
        after = np.where(ran[:, None], evidence.final, start)
        run = simulate(model, after, periods=PERIODS, field_limit=self.field_limit, threads=self.threads)
        x = run["displacement"].values
        span = PERIODS * model.drive_period
        supplied = run["supplied_energy"].values[:, -1] - run["supplied_energy"].values[:, 0]
        shares = {
            name: run[f"validity_{name}"].values
            for name in ("hoop_slack", "meridional_slack", "breakdown", "near_limit")
        }

        def where_ran(values: Any) -> Array:
            return np.where(ran, values, np.nan)

        return {
            "driven_stroke": where_ran(np.ptp(x, axis=1)),
            "driven_power": where_ran(supplied / span),
            "driven_field": where_ran(run["true_field"].values.max(axis=1)),
            "regime": evidence.regime.astype(float),
            "outcome": evidence.outcome.astype(float),
            "dielectric breakdown": np.where(np.isnan(shares["breakdown"]), np.nan, ~ran | (shares["breakdown"] > 0.0)),
            "hoop slack": (~ran | (shares["hoop_slack"] > 0.0)).astype(float),
            "meridional slack": (~ran | (shares["meridional_slack"] > 0.0)).astype(float),
            "stretch limit": (~ran | (shares["near_limit"] > 0.0)).astype(float),
            "chaos": (evidence.regime == Regime.CHAOTIC).astype(float),
        }


def _driven_limits(
    plane: _Plane, seen: dict[str, Any], omegas: Array, volts: Array, progress: Callable[[float], None]
) -> tuple[Array, Array]:
    """Intervals of the peak voltage in which each limit is first met, (limits, frequencies) each."""
    low = np.full((len(DRIVEN_LIMITS), len(omegas)), np.nan)
    high = low.copy()
    for row, name in enumerate(DRIVEN_LIMITS[:-1]):
        met = seen[name].reshape(len(omegas), len(volts))
        unknown = np.isnan(met).any(axis=1)
        first = np.argmax(met > 0.0, axis=1)
        reached = (met > 0.0).any(axis=1)
        low[row] = np.where(reached, np.where(first > 0, volts[np.maximum(first - 1, 0)], 0.0), np.inf)
        high[row] = np.where(reached, volts[first], np.inf)
        low[row, unknown] = high[row, unknown] = np.nan
        open_ = np.flatnonzero(reached & ~unknown)
        for _ in range(BISECTIONS if open_.size else 0):
            middle = 0.5 * (low[row, open_] + high[row, open_])
            now = plane.look(omegas[open_], middle, lambda share: None)[name] > 0.0
            high[row, open_] = np.where(now, middle, high[row, open_])
            low[row, open_] = np.where(now, low[row, open_], middle)
        progress(1.0 / len(DRIVEN_LIMITS))
    low[-1], high[-1] = _onset(plane, omegas, float(volts[-1]))
    progress(1.0 / len(DRIVEN_LIMITS))
    return low, high


def _onset(plane: _Plane, omegas: Array, highest: float) -> tuple[Any, Any]:
    """Peak voltages at which flat rest loses stability under a pure sine; NaN where rest is not flat or biased."""
    model = plane.model
    if float(model.rest_height) * float(model.spring_stiffness) != 0.0 or plane.drive.bias != 0.0:
        return np.nan, np.nan
    found = onset_voltage(model.replace(drive_frequency=omegas), highest=highest)
    onset = np.where(np.isnan(found["onset_voltage"].values), np.inf, found["onset_voltage"].values)
    return onset, onset + np.nan_to_num(found["onset_error"].values)


# --- quasi-static ---------------------------------------------------------------------------------------------------


def _static(
    model: ConeModel, drive: Drive, field_limit: float | None, highest: float
) -> tuple[dict[str, Array], Array]:
    """Curves over the constant peak voltage, and the voltage of each of `STATIC_LIMITS`."""
    levels = np.linspace(0.0, highest, STATIC_POINTS + 1)
    ramp = stroke_and_blocked_force(model, levels)
    x = ramp["displacement"].values
    state = model.film_state(x, levels)
    stiffness = model.stiffness(x, levels)
    curves = {
        "peak_voltage": levels,
        "static_displacement": x,
        "stroke": ramp["stroke"].values,
        "blocked_force": ramp["blocked_force"].values,
        "natural_frequency": np.sqrt(np.maximum(stiffness, 0.0)),
        "static_field": state.true_field,
        "static_hoop_stress": state.hoop_stress,
        "static_meridional_stress": state.meridional_stress,
    }
    flat = float(model.rest_height) * float(model.spring_stiffness) == 0.0
    limits = [
        np.nan if field_limit is None else _first(levels, state.true_field - field_limit),
        _first(levels, -state.hoop_stress),
        _first(levels, -state.meridional_stress),
        _first(levels, state.limit_share - NEAR_LIMIT),
        float(pitchfork_voltage(model)) if flat else np.nan,
        float(pull_in_voltage(model)["pull_in_voltage"]),
    ]
    return curves, np.array(limits)


def _first(levels: Array, excess: Array) -> float:
    """Level at which ``excess`` first passes zero, linear between points; infinity if it never does."""
    over = np.flatnonzero(excess > 0.0)
    if not over.size:
        return np.inf
    k = int(over[0])
    if k == 0 or not np.isfinite(excess[k - 1]):
        return float(levels[k])
    before, after = excess[k - 1], excess[k]
    return float(levels[k - 1] + (levels[k] - levels[k - 1]) * before / (before - after))
