"""Performance numbers of a settled motion: stroke, mean height, lag, current, power, field, pull-in."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from gelcone.analyses.request import Subject
from gelcone.codes import Regime
from gelcone.devices.scales import MEASURES
from gelcone.devices.units import format_si
from gelcone.motion.electrical import electrical
from gelcone.motion.extent import extent
from gelcone.motion.job import Trajectories
from gelcone.motion.static_bifurcations import jump_voltages
from gelcone.motion.swing import HARMONICS, harmonics_of
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel

DIGITS = 3
MOST_SAMPLES = 2000
"""Most samples of a settled motion for current, power and field."""
SMALLEST_SHARE = 1e-9
"""Rounding bound: lengths below this share of b - a are 0, and so are mean heights and harmonics below this share of
the stroke."""
QUANTITIES: Mapping[str, str] = {
    "stroke": "length",
    "mean height": "length",
    "lag": "",
    "current": "current",
    "power": "power",
    "field": "",
    "static pull-in of the cone": "voltage",
    "static pull-in of the membrane": "voltage",
}
"""Numbers in the order shown -> quantity that gives the unit; empty without one."""
PULL_INS = {film: f"static pull-in of the {film}" for film in ("cone", "membrane")}
MULTIPLES = ("", " at twice the drive's frequency", " at three times the drive's frequency", " at four times it")


def motion(members: Members, run: Trajectories, regime: Regime, turns: int) -> dict[str, float]:
    """Numbers of the settled motion of a single actuator along ``run``, over ``turns`` forcing periods, by name.

    ``stroke`` and ``mean height`` are in the model's units. ``lag`` is in degrees: by how much the largest harmonic of
    the height follows the voltage's sine at the multiple ``harmonic`` of the drive frequency. ``field`` is the largest
    true field over the dielectric strength. Numbers that are unknown or do not apply are left out.
    """
    x = run.states[:, 1:, 0]
    lowest, highest = extent(members, run.times, run.states)
    numbers = {"stroke": float(highest[0] - lowest[0]), "mean height": float(x.mean())}
    for name, value in numbers.items():
        numbers[name] = 0.0 if abs(value) <= SMALLEST_SHARE * max(numbers["stroke"], 1.0) else value
    if regime is Regime.PERIODIC:
        # an even number of forcing periods is a whole number of drive periods
        whole = np.concatenate([x, x], axis=1) if turns % 2 else x
        own = harmonics_of(members, whole, x.shape[1] // turns)[0]
        k = int(np.argmax(np.abs(own)))
        if abs(own[k]) > SMALLEST_SHARE * max(numbers["stroke"], 1.0):
            numbers |= {"harmonic": HARMONICS[k], "lag": -float(np.degrees(np.angle(own[k]))) % 360.0}
    if "dielectric_strength" in members.values:
        times, states = _thinned(run)
        fields = [own.true_field for own in members.film_states(states, members.voltages(times, states))]
        strength = float(np.ravel(members.values["dielectric_strength"])[0])
        largest_fields = [float(np.nanmax(field)) for field in fields if np.isfinite(field).any()]
        numbers |= {"field": max(largest_fields) / strength} if largest_fields else {}
    return numbers


def of_source(members: Members, run: Trajectories) -> dict[str, float]:
    """The peak ``current`` of a source and the mean ``power`` of the source, along a run as in `motion`.

    Left out where a film's charge is unknown.
    """
    numbers = electrical(members, *_thinned(run), run.states[:, 0])
    return {name: float(numbers[name][0]) for name in ("current", "power") if np.isfinite(numbers[name][0])}


def _thinned(run: Trajectories) -> tuple[Any, Any]:
    """About `MOST_SAMPLES` times (1, samples) and states (1, samples, N) of a run, without its last sample."""
    step = max(1, (run.times.shape[1] - 1) // MOST_SAMPLES)
    return run.times[:, :-1:step], run.states[:, :-1:step]


def pull_in(model: ConeModel) -> float:
    """The constant voltage at which a single actuator jumps or pulls in on a slow ramp; infinite if it never does.

    Takes up to a second for films that wrinkle.
    """
    return float(jump_voltages(model)[0][0])


def in_words(numbers: Mapping[str, float], subject: Subject) -> list[dict[str, Any]]:
    """The numbers as the page shows them, in order.

    Each has ``name``, ``place`` (its rank), ``text``, and ``value`` in the units of the page's axes (lag in degrees,
    field as a share). Pull-in has also ``peak``, the drive's peak voltage over the pull-in voltage.
    """
    entries: list[dict[str, Any]] = []
    for place, (name, quantity) in enumerate(QUANTITIES.items()):
        if name not in numbers or not np.isfinite(numbers[name]):
            continue
        value = float(numbers[name])
        if name == "lag":
            text = f"{value:.{DIGITS}g}°{MULTIPLES[int(numbers['harmonic']) - 1]}"
        elif name == "field":
            text = f"{_percent(value)} of breakdown"
        else:
            text, value = _with_unit(value, quantity, subject)
        entries.append({"name": name, "place": place, "text": text, "value": value})
        if name in PULL_INS.values():
            entries[-1]["peak"] = peak = float(subject.model.peak_voltage) / numbers[name]
            bias = " at this bias" if subject.model.system.in_opposite_phase else ""
            entries[-1]["text"] += f"{bias} (peak at {_percent(peak)})"
    return entries


def _with_unit(value: float, quantity: str, subject: Subject) -> tuple[str, float]:
    if subject.device is None:
        return f"{value:.{DIGITS}g}", value
    si = value * float(getattr(subject.device.scales, quantity))
    text = format_si(si, MEASURES[quantity].unit, DIGITS) if si else f"0 {MEASURES[quantity].shown}"
    return text, si * MEASURES[quantity].per_unit


def _percent(share: float) -> str:
    """A share in percent: two digits below 100 %, three above."""
    return f"{100.0 * share:.{2 if share < 0.995 else 3}g} %"
