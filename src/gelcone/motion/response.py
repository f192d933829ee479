"""Time response: how the actuator moves, what the film bears, and where the model stops being true."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset, drive
from gelcone.errors import InputError
from gelcone.model import ConeModel, electric_energy, spring_energy, strain
from gelcone.motion.flow import DEFAULT_TOLERANCE, Outcome, Trajectories, integrate
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

SAMPLES_PER_PERIOD = 100
SAMPLES_PER_OSCILLATION = 24
MOST_SAMPLES = 20_000
NEAR_LIMIT = 0.99


def simulate(
    model: ConeModel,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    periods: float = 20.0,
    times: npt.ArrayLike | None = None,
    field_limit: float | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Motion, stretches, stresses, field, energies and power balance of every member, and the model's validity.

    Parameters
    ----------
    model : one actuator or an ensemble.
    initial : displacement and velocity at time 0, shape (2,) or ensemble shape + (2,). Default (1, 0).
    periods : length of the run in periods 2 pi/omega of the voltage, when ``times`` is not given. Default 20.
    times : dimensionless sample times, increasing from 0 or later; default even ones, at least 100 a drive period and
        24 an oscillation of the spring and film (at most 20,000 in all).
    field_limit : dielectric strength over sqrt(mu/eps), for the validity; unknown when left out.
    tolerance : relative error of one step. Default 1e-15.

    Returns
    -------
    Dataset over the ensemble's dims and ``time`` (``sample`` where the members' drive frequencies differ).
    Energies and powers are per mu Vol; the field energy v^2 q/2 belongs to what is stored, and ``supplied_energy`` is
    the work of the voltage source, the integral of v d(v q). ``validity_*`` are shares of the run's time during which
    the film is slack (a true stress is negative), the true field exceeds ``field_limit`` (NaN when unknown), or the
    strain is within 1 % of the stretch limit; they are taken on an even grid of times whichever samples are kept.

    Raises
    ------
    InputError : for a run of no length, times that do not increase, or an initial state of which no member lies inside
        its stretch limit.
    """
    if not (np.isfinite(periods) and periods > 0.0):
        raise InputError(f"periods = {periods:g}: must be a positive number of drive periods")
    states0 = start_states(model, initial)
    even = _even_times(model, periods, times)
    wanted = even if times is None else _wanted_times(times, model.size)
    both = [np.union1d(e, w) for e, w in zip(even, wanted, strict=True)]
    longest = max(len(t) for t in both)
    padded = np.stack([np.concatenate([t, t[-1] + np.arange(1, longest - len(t) + 1)]) for t in both])
    run = integrate(model, states0, padded, keep="work", tolerance=tolerance, threads=threads, progress=progress)
    variables = _variables(model.take(slice(None)), run)
    kept = np.stack([np.searchsorted(b, w) for b, w in zip(both, wanted, strict=True)])
    checked = np.stack([np.searchsorted(b, e) for b, e in zip(both, even, strict=True)])
    shares = _validity(model.take(slice(None)), variables, checked, field_limit)
    shared_times = (wanted == wanted[0]).all()
    dim = "time" if shared_times else "sample"
    result = dataset.label(
        model,
        {n: ((dim,), np.take_along_axis(v, kept, axis=1), *_MEANINGS[n]) for n, v in variables.items()}
        | {f"validity_{n}": ((), v, _VALIDITY[n], "share") for n, v in shares.items()},
        coords={"time": ((dim,), wanted[0] if shared_times else wanted, "time", "time")},
        outcome=run.outcome,
        options={"periods": periods, "tolerance": tolerance, "field_limit": field_limit},
        title="time response",
    )
    result["initial"] = (
        (*dataset.member_dims(model), "state"),
        states0.reshape((*model.shape, 2)),
        {"long_name": "initial displacement and velocity", "units": "1"},
    )
    return result


def start_states(model: ConeModel, initial: npt.ArrayLike) -> Array:
    """Initial states of all members, shape (members, 2); `InputError` when none can start."""
    try:
        states = np.broadcast_to(np.asarray(initial, dtype=float), (*model.shape, 2)).reshape(model.size, 2)
    except (TypeError, ValueError):
        raise InputError(
            f"initial = {initial!r}: must be a displacement and a velocity (shape (2,) or {(*model.shape, 2)})"
        ) from None
    if not np.isfinite(states).all():
        raise InputError(f"initial = {states[~np.isfinite(states).all(axis=1)][0].tolist()}: must be finite")
    members = model.take(slice(None))
    strains, limits = members.strain(states[:, 0]), np.broadcast_to(members.strain_limit(), members.shape)
    if (strains >= limits).all():
        raise InputError(
            f"stretch_limit = {limits[0]:g}: must exceed I1 - 3 = {strains[0]:.4g} at the initial displacement "
            f"{states[0, 0]:g}; start lower or raise it"
        )
    return states


def _even_times(model: ConeModel, periods: float, times: npt.ArrayLike | None) -> Array:
    """Even times for every member, shape (members, samples), from 0 to the end of the run."""
    members = model.take(slice(None))
    period = np.broadcast_to(members.drive_period, members.shape)
    span = periods * period if times is None else np.full(model.size, np.max(_wanted_times(times, model.size)))
    stiffness = np.broadcast_to(np.asarray(members.spring_stiffness) + members.coefficients().A, members.shape)
    spacing = min(
        float((period / SAMPLES_PER_PERIOD / span).min()),
        float((2.0 * np.pi / np.sqrt(stiffness) / SAMPLES_PER_OSCILLATION / span).min()),
    )
    count = int(np.clip(np.ceil(1.0 / spacing), 2, MOST_SAMPLES))
    return span[:, None] * np.linspace(0.0, 1.0, count + 1)


def _wanted_times(times: npt.ArrayLike, count: int) -> Array:
    wanted = np.atleast_1d(np.asarray(times, dtype=float))
    if wanted.size == 0 or not np.isfinite(wanted).all() or (wanted < 0).any() or (np.diff(wanted) <= 0).any():
        raise InputError(f"times = {np.asarray(times).tolist()}: must be finite, increasing and not negative")
    if wanted[-1] == 0.0:
        raise InputError("times = 0: the run has no length; give at least one later time")
    return np.broadcast_to(wanted, (count, wanted.shape[-1]))


_MEANINGS = {
    "displacement": ("displacement x = h/(b-a)", "length"),
    "velocity": ("velocity of the disc", "velocity"),
    "drive_voltage": ("voltage v(tau) across the film", "voltage"),
    "meridional_stretch": ("meridional stretch l1", "stretch"),
    "hoop_stretch": ("hoop stretch l2", "stretch"),
    "thickness_stretch": ("thickness stretch l3", "stretch"),
    "meridional_stress": ("true meridional stress s1", "stress"),
    "hoop_stress": ("true hoop stress s2", "stress"),
    "true_field": ("true electric field", "field"),
    "kinetic_energy": ("kinetic energy", "energy"),
    "film_energy": ("strain energy of the film", "energy"),
    "spring_energy": ("energy of the spring", "energy"),
    "field_energy": ("energy of the electric field", "energy"),
    "supplied_energy": ("energy put in by the voltage source since the start", "energy"),
    "dissipated_energy": ("energy dissipated since the start", "energy"),
    "input_power": ("power of the voltage source", "power"),
    "dissipated_power": ("power dissipated", "power"),
    "energy_residual": ("energy put in less stored and dissipated (zero in exact arithmetic)", "energy"),
}
_VALIDITY = {
    "hoop_slack": "share of the time with a compressive hoop stress (slack film)",
    "meridional_slack": "share of the time with a compressive meridional stress (slack film)",
    "breakdown": "share of the time with a true field above the dielectric strength",
    "near_limit": "share of the time within 1 % of the stretch limit",
}


def _variables(members: ConeModel, run: Trajectories) -> dict[str, Array]:
    """All time series, each (members, samples)."""
    x, u = run.states[..., 0], run.states[..., 1]
    assert run.work is not None
    supplied, dissipated = run.work[..., 0], run.work[..., 1]
    c = members.coefficients(trailing=1)
    lm, lh = (np.broadcast_to(stretch, members.shape)[:, None] for stretch in members.stretches)
    amplitude, bias, omega = (
        np.broadcast_to(v, members.shape)[:, None]
        for v in (members.voltage, members.voltage_bias, members.drive_frequency)
    )
    q = 1.0 + x * x
    e = strain(x, c)
    v = drive.voltage(run.times, amplitude, bias, omega)
    l1, l2 = lm * np.sqrt(q), np.broadcast_to(lh, x.shape)
    l3 = 1.0 / (l1 * l2)
    response = members.law.response(e, c.law)
    film = members.law.energy(e, c.law)
    spring = spring_energy(x, c) + 0.0 * x
    field = -electric_energy(x, v)
    stored = 0.5 * u * u + film + spring + field
    first = np.concatenate([stored[:, :1], supplied[:, :1], dissipated[:, :1]], axis=1)[..., None]
    change = drive.voltage_rate(run.times, amplitude, omega)
    return {
        "displacement": x,
        "velocity": u,
        "drive_voltage": v,
        "meridional_stretch": l1,
        "hoop_stretch": np.where(np.isnan(x), np.nan, l2),
        "thickness_stretch": l3,
        "meridional_stress": (l1 * l1 - l3 * l3) * response - v * v * q,
        "hoop_stress": (l2 * l2 - l3 * l3) * response - v * v * q,
        "true_field": np.abs(v) * np.sqrt(q),
        "kinetic_energy": 0.5 * u * u,
        "film_energy": film,
        "spring_energy": spring,
        "field_energy": field,
        "supplied_energy": supplied,
        "dissipated_energy": dissipated,
        "input_power": v * (change * q + 2.0 * v * x * u),
        "dissipated_power": 2.0 * c.zeta * u * u,
        "energy_residual": (supplied - first[:, 1]) - (dissipated - first[:, 2]) - (stored - first[:, 0]),
    }


def _validity(
    members: ConeModel, series: dict[str, Array], checked: Any, field_limit: float | None
) -> dict[str, Array]:
    """Shares of the run during which each assumption of the model fails, over the samples ``checked``."""
    c = members.coefficients(trailing=1)
    limit = np.asarray(members.law.strain_limit(c.law))

    def share(fails: Any) -> Array:
        ran = np.take_along_axis(~np.isnan(series["displacement"]), checked, axis=1)
        failed = np.take_along_axis(np.broadcast_to(fails, series["displacement"].shape), checked, axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            return (failed & ran).sum(axis=1) / ran.sum(axis=1)

    return {
        "hoop_slack": share(series["hoop_stress"] < 0.0),
        "meridional_slack": share(series["meridional_stress"] < 0.0),
        "breakdown": np.full(members.size, np.nan)
        if field_limit is None
        else share(series["true_field"] > field_limit),
        "near_limit": share(strain(series["displacement"], c) >= NEAR_LIMIT * limit),
    }


def failures(result: xr.Dataset) -> dict[str, int]:
    """How many members ended in each way other than ``ok``."""
    codes = result["outcome"].values.ravel()
    return {o.name.lower(): int((codes == o).sum()) for o in Outcome if o and (codes == o).any()}
