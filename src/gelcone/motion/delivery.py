"""Deliveries of the source of a run: voltage, current and power that an amplifier must be built for."""

from __future__ import annotations

import numpy as np

from gelcone.dataset import Variable
from gelcone.motion.dwell import Path, dwell_times
from gelcone.physics.members import Members
from gelcone.physics.system import Line
from gelcone.quantity import Array

LIMITED = {"slew_rate": ("slew_limited", "slew rate"), "current_limit": ("current_limited", "current limit")}
"""By the limit of an amplifier: the name of the share of time at it, and words for it."""


def delivered(members: Members, times: Array, states: Array) -> dict[str, Variable]:
    """Root mean squares over the second half of motions at ``times`` and ``states`` (members, samples, N), peaks over
    all of them, and the shares of the time at the limits of each amplifier; a source of the second film's own is
    ``second_``."""
    system, n, z = members.system, members.numbers(trailing=1), list(np.moveaxis(states, -1, 0))
    shape, found = times.shape, dict[str, Variable]()
    with np.errstate(all="ignore"):
        currents = [np.broadcast_to(one, shape) for one in system.currents(times, z, n)]
        voltages, rates = system.source_voltages(times, z, n), system.source_rates(times, z, n)
    for line in system.lines:
        first, of = line.films[0], "the second film's source" if line.prefix else "the source"
        current = sum((currents[k] for k in line.films[1:]), currents[first])
        rms = [_root_mean_square(times, np.broadcast_to(one, shape)) for one in (voltages[first], current)]
        own = {
            "rms_voltage": (rms[0], f"root mean square voltage of {of} in the second half", "voltage"),
            "rms_current": (rms[1], f"root mean square current of {of} in the second half", "current"),
            "apparent_power": (rms[0] * rms[1], f"root mean square voltage times current of {of}", "apparent power"),
            "peak_current": (_peak(current), f"largest current of {of}", "current"),
            "peak_slew_rate": (_peak(np.broadcast_to(rates[first], shape)), f"fastest change of {of}", "slew rate"),
        }
        found |= {line.prefix + name: ((), *variable) for name, variable in own.items()}
        found |= _limited(members, line, times, states)
    return found


def _root_mean_square(times: Array, values: Array) -> Array:
    """Of the second half of samples (members, samples), by trapezoids."""
    half = times.shape[1] // 2
    along, squares = times[:, half:], np.square(values[:, half:])
    return np.sqrt(np.trapezoid(squares, along, axis=1) / (along[:, -1] - along[:, 0]))


def _peak(values: Array) -> Array:
    return np.asarray(np.fmax.reduce(np.abs(values), axis=1))


def _limited(members: Members, line: Line, times: Array, states: Array) -> dict[str, Variable]:
    """The shares of the time of a run at the limits of a line's amplifier, between the times at which it meets them."""

    def excess(some: Members, at: Array, z: Array) -> dict[str, Array]:
        return dict(some.system.saturations(line, at, list(np.moveaxis(z, -1, 0)), some.numbers(at.ndim - 1)))

    known = excess(members, times, states)
    if not known:
        return {}
    ran = ~np.isnan(states[..., 0])
    spans = np.where(ran[:, :-1] & ran[:, 1:], np.diff(times, axis=1), 0.0).sum(axis=1)
    values = np.stack([np.where(ran, np.broadcast_to(one, ran.shape), np.nan) for one in known.values()])
    lasted, _ = dwell_times(
        Path(members, times, states), lambda some, at, z: np.stack([*excess(some, at, z).values()]), values
    )
    lasted = np.where(np.isnan(lasted), 0.0, lasted).sum(axis=-1)
    return {
        line.prefix + LIMITED[name][0]: ((), own / spans, f"share of the time at the {LIMITED[name][1]}", "share")
        for name, own in zip(known, lasted, strict=True)
    }
