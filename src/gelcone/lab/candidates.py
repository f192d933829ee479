"""The numbers of many designs of a device at once, from closed forms of the homogeneous cone.

Statics are those of a slow voltage ramp, on which the voltage at a height is explicit. Motions are the linear response
about the mean height, with its second harmonic.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from gelcone.bracket import halved
from gelcone.devices.cone import critical_share
from gelcone.devices.device import Device
from gelcone.devices.fields import DAMPINGS
from gelcone.physics.film.gel import cone_reach
from gelcone.quantity import Array

HEIGHTS = 40
"""Number of heights of the ramp, in equal ratios from the rest to the stretch limit."""
GREATEST_HEIGHT = 6.0
"""Largest height over b - a if the law has no stretch limit."""
BISECTIONS = 40
PHASES = 16
"""Number of phases of a period at which a motion is evaluated."""
LIMITS = ("pull-in", "hoop slack", "meridional slack", "dielectric breakdown", "stretch limit")
"""Limits on the ramp, in the order of `Found.limits`."""


class Found(NamedTuple):
    """The numbers of designs, (designs, draws) each, in SI; NaN where a design has no state.

    ``limits`` holds peak voltages on the ramp, (limits, designs, draws), infinite for limits that are not met;
    ``failing`` the largest excess of a motion under a higher drive over a limit of the film, as a share.
    """

    values: Mapping[str, Array]
    limits: Array
    failing: Array


class Motion(NamedTuple):
    """A periodic motion over `PHASES` phases, (members, phases), dimensionless."""

    x: Array
    voltage: Array
    current: Array
    natural: Array


def examine(device: Device, changes: Mapping[str, Array], share: float) -> Found:
    """Compute the numbers of designs, each field (designs, draws) in SI; motions also under ``share`` times the
    drive."""
    shape = next(iter(changes.values())).shape
    members_of, damping = _undamped(device, {name: value.ravel() for name, value in changes.items()})
    model = members_of.to_model()
    members = model.members()
    n, system = members.numbers(trailing=1), members.system
    parameters = {name: np.broadcast_to(value, members.shape)[:, None] for name, value in members.values.items()}
    scales = members_of.scales

    def scale(quantity: str) -> Array:
        return np.broadcast_to(np.asarray(scales.size(quantity), dtype=float), members.shape)

    with np.errstate(all="ignore"):
        rest, highest = _rest(system, n, members.size)
        if damping is not None:
            parameters["damping_ratio"] = damping[:, None] * np.sqrt(system.static_force(rest, 0.0, n)[1])
        x, squared = _ramp(system, n, rest, highest)
        limits = _limits(system, n, parameters, x, squared) * scale("voltage")
        peak = (np.abs(parameters["voltage_bias"]) + parameters["voltage"])[:, 0]
        motion = _motion(system, n, parameters, x, squared, 1.0)
        harder = _motion(system, n, parameters, x, squared, share)
        values = {
            "stroke": np.ptp(motion.x, axis=1) * scale("length"),
            "peak_voltage": peak * scale("voltage"),
            "apparent_power": _rms(motion.voltage) * _rms(motion.current) * scale("apparent power"),
            "current": np.abs(motion.current).max(axis=1) * scale("current"),
            "natural_frequency": motion.natural * scale("frequency"),
            "rest_height": rest[:, 0] * scale("length"),
            "footprint": np.broadcast_to(2.0 * np.asarray(members_of.film_radius), members.shape),
            "blocked_force": system.film.voltage_force(rest[:, 0], peak**2, [], members.numbers()) * scale("force"),
        }
        failing = _failing(system, n, parameters, harder)
    return Found(
        {name: value.reshape(shape) for name, value in values.items()},
        limits.reshape(len(LIMITS), *shape),
        failing.reshape(shape),
    )


def _undamped(device: Device, changes: Mapping[str, Array]) -> tuple[Device, Array | None]:
    """The devices of designs, without damping where that is given over the critical one about the rest of each, and the
    shares given, (designs,); None where the damping does not depend on the rest."""
    share = critical_share(lambda name: changes.get(name, device.get(name)))
    if share is None:
        return device.replace_quietly(changes), None
    none = np.zeros(len(next(iter(changes.values()))))
    others = {name: values for name, values in changes.items() if name not in DAMPINGS}
    return device.replace_quietly(others | {"damping_coefficient": none}), share + none


def _rms(values: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(values**2, axis=1)))


def _rest(system: Any, n: Any, size: int) -> tuple[Array, Array]:
    """The rest without voltage, NaN if there is none, and the largest height below the stretch limit, (members, 1)."""
    film = system.film
    highest = cone_reach(film.strain_limit(n) * (1.0 - 1e-6), n)[1]
    most = np.minimum(np.broadcast_to(highest, (size, 1)), GREATEST_HEIGHT)
    low, high = np.full((size, 1), 1e-6), most.copy()
    held = (system.static_force(low, 0.0, n)[0] < 0.0) & (system.static_force(high, 0.0, n)[0] > 0.0)
    low, high = halved(lambda x: ~(system.static_force(x, 0.0, n)[0] > 0.0), low, high, BISECTIONS)
    return np.where(held, 0.5 * (low + high), np.nan), most


def _ramp(system: Any, n: Any, rest: Array, highest: Array) -> tuple[Array, Array]:
    """Heights from the rest to the highest, and the squared voltage of equilibrium at each, (members, heights)."""
    share = np.linspace(0.0, 1.0, HEIGHTS)
    x = rest * (highest / rest) ** share
    force = system.static_force(x, 0.0, n)[0]
    squared = force / system.film.voltage_gain(x, 0.0, n)
    squared[:, 0] = 0.0
    return x, squared


def _limits(system: Any, n: Any, own: Mapping[str, Array], x: Array, squared: Array) -> Array:
    """The voltage at which each of `LIMITS` is first met on the ramp, (limits, members); infinite if it is not."""
    falls = np.diff(squared, axis=1) <= 0.0
    fold = np.where(falls.any(axis=1), falls.argmax(axis=1), HEIGHTS - 1)
    voltage = np.sqrt(np.maximum(squared, 0.0))
    top = np.take_along_axis(voltage, fold[:, None], axis=1)[:, 0]
    limits = [np.where(falls.any(axis=1), top, np.inf)]
    limits += [
        _first(voltage, np.broadcast_to(limit, voltage.shape), fold) for limit in _beyond(system, n, own, x, voltage)
    ]
    return np.where(np.isfinite(x[:, 0]), np.array(limits), np.nan)


def _first(voltage: Array, beyond: Array, last: Array) -> Array:
    """The voltage at which ``beyond`` first rises through zero up to the column ``last``, linear between columns."""
    met = (beyond >= 0.0) & (np.arange(voltage.shape[1]) <= last[:, None])
    k = met.argmax(axis=1)
    before = np.maximum(k - 1, 0)
    rows = np.arange(len(voltage))
    low, high = beyond[rows, before], beyond[rows, k]
    share = np.where(k > 0, -low / (high - low), 0.0)
    at = voltage[rows, before] + share * (voltage[rows, k] - voltage[rows, before])
    return np.where(met.any(axis=1), at, np.inf)


def _motion(system: Any, n: Any, own: Mapping[str, Array], x: Array, squared: Array, share: float) -> Motion:
    """The linear response with two harmonics under ``share`` times the drive, about the equilibrium at its mean
    square."""
    offset, amplitude, omega = share * own["voltage_bias"], share * own["voltage"], own["drive_frequency"]
    mean = offset**2 + 0.5 * amplitude**2
    at = _on_ramp(x, squared, mean)
    for _ in range(3):
        force, slope = system.static_force(at, mean, n)
        at = at - np.clip(force / np.where(slope > 0.0, slope, np.nan), -0.1, 0.1)
    slope = system.static_force(at, mean, n)[1]
    gain, damping = system.film.voltage_gain(at, mean, n), 2.0 * own["damping_ratio"]
    theta = 2.0 * np.pi * np.arange(PHASES) / PHASES
    wave = amplitude * np.sin(theta)
    # (V0 + V1 sin)^2 = mean + 2 V0 V1 sin - V1^2/2 cos 2 theta
    first = 2.0 * offset * amplitude * gain / (slope - omega**2 + 1j * damping * omega)
    second = -0.5 * amplitude**2 * gain / (slope - 4.0 * omega**2 + 2j * damping * omega)
    moved = (first * np.exp(1j * theta)).imag + (second * np.exp(2j * theta)).real
    speed = (1j * first * np.exp(1j * theta)).imag + (2j * second * np.exp(2j * theta)).real
    height, volts = at + moved, offset + wave
    current = omega * (system.film.capacitance(height, mean, [], n) * amplitude * np.cos(theta))
    current = current + 2.0 * omega * speed * volts * system.film.voltage_gain(height, mean, n)
    return Motion(height, volts, current, np.sqrt(slope[:, 0]))


def _on_ramp(x: Array, squared: Array, mean: Array) -> Array:
    """The height on the ramp at squared voltages, (members, 1); NaN beyond its fold."""
    last = np.maximum.accumulate(squared, axis=1)
    k = (last < mean).sum(axis=1, keepdims=True)
    inside = k < x.shape[1]
    k = np.clip(k, 1, x.shape[1] - 1)
    low, high = np.take_along_axis(last, k - 1, axis=1), np.take_along_axis(last, k, axis=1)
    begin, end = np.take_along_axis(x, k - 1, axis=1), np.take_along_axis(x, k, axis=1)
    share = np.where(high > low, (mean - low) / (high - low), 0.0)
    rising = np.take_along_axis(squared, k, axis=1) >= low
    return np.where(inside & rising, begin + np.clip(share, 0.0, 1.0) * (end - begin), np.nan)


def _failing(system: Any, n: Any, own: Mapping[str, Array], motion: Motion) -> Array:
    """The largest excess of a motion over tension, dielectric strength, stretch limit or the flat film, as a share."""
    shares = (*_beyond(system, n, own, motion.x, motion.voltage), -motion.x)
    return np.max([np.broadcast_to(one, motion.x.shape).max(axis=1) for one in shares], axis=0)


def _beyond(system: Any, n: Any, own: Mapping[str, Array], x: Array, voltage: Array) -> tuple[Array, ...]:
    """The excess of a film over each of `LIMITS` but pull-in, positive beyond it."""
    state = system.film.state(x, voltage, [], n)
    strength = np.nan_to_num(own.get("dielectric_strength", np.inf), nan=np.inf, posinf=np.inf)
    return -state.hoop_stress, -state.meridional_stress, state.true_field / strength - 1.0, state.limit_share - 1.0


def draws_of(fields: int, count: int, seed: int) -> Array:
    """Draw Sobol samples of a standard normal distribution, (count, fields)."""
    from scipy.stats import norm, qmc

    if not fields:
        return np.zeros((1, 0))
    points = qmc.Sobol(fields, seed=seed).random(count)
    return np.asarray(norm.ppf(np.clip(points, 1e-9, 1.0 - 1e-9)))
