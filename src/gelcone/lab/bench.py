"""Tests on a device, and predictions of their readings: statics, and responses at the amplitude of the test.

A response is computed by one-harmonic balance: mean, sine and cosine of the displacement balance the mean, sine and
cosine of the forces over a period. It holds at the amplitude of the test and across the borders of a film, where a
linear response jumps. Statics use relaxed films and settled circuits; responses, ring-downs and series follow the
states of both. All predictions are made for many variants of a device at once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from gelcone.devices.device import Device
from gelcone.devices.recorded import needed
from gelcone.errors import InputError
from gelcone.lab.periodic import (
    BASIS,
    LONGEST_STEP,
    NEWTON_STEPS,
    PHASES,
    WEIGHTS,
    balanced,
    linear_motion,
    small_motion,
)
from gelcone.motion.flow import integrate
from gelcone.motion.natural import frequencies_under
from gelcone.motion.regular import solved_where_regular
from gelcone.physics.commanded import under_commands
from gelcone.physics.members import Members
from gelcone.physics.statics import stable_near
from gelcone.physics.waveforms import Samples
from gelcone.quantity import Array

SIDE = 1e-9
"""Distance on both sides of a corner of the voltage at which the current is computed, over the length of a series."""
MOST_READ = 500
"""Most readings of a series that are compared, evenly spaced among all."""
TOLERANCE = 1e-12
"""Relative error of a step of a series, so small that differences between variants are those of their fields."""
LOAD_SHARES = (0.25, 0.5, 0.75, 1.0)
"""Shares of a load, and of a squared voltage, through which a balance is followed."""


class Reading(NamedTuple):
    """A number that a test measures: its SI ``unit``, and the ``instrument`` whose gain multiplies it, empty for
    none."""

    unit: str
    instrument: str


class Kind(NamedTuple):
    """A kind of test: the numbers that are ``set``, name -> SI unit, one for each row or for all; and the readings
    ``read``."""

    set: Mapping[str, str]
    read: Mapping[str, Reading]


KINDS: Mapping[str, Kind] = {
    "blocked force": Kind({"height": "m", "voltage": "V"}, {"force": Reading("N", "load cell")}),
    "stroke over voltage": Kind({"voltage": "V"}, {"stroke": Reading("m", "laser")}),
    "frequency response": Kind(
        {"voltage_offset": "V", "voltage_amplitude": "V", "frequency": "Hz"},
        {"in_phase": Reading("m", "laser"), "quadrature": Reading("m", "laser")},
    ),
    "stroke over load": Kind({"load": "N", "voltage": "V"}, {"stroke": Reading("m", "laser")}),
    "capacitance": Kind({"height": "m", "voltage": "V"}, {"capacitance": Reading("F", "capacitance meter")}),
    "ring-down": Kind({}, {"frequency": Reading("Hz", ""), "decay": Reading("1/s", "")}),
    "series": Kind(
        {"time": "s", "voltage": "V"}, {"stroke": Reading("m", "laser"), "current": Reading("A", "ammeter")}
    ),
}
"""Kinds of tests on a device. A response is in_phase sin + quadrature cos under a sine; a load pulls the disc down, and
its stroke is measured from the height without voltage. A series begins at rest without voltage, and may have one of its
two readings alone."""
AMPLIFIER = "amplifier"
"""The instrument whose gain multiplies all commanded voltages."""
INSTRUMENTS = ("load cell", "laser", "capacitance meter", "ammeter", AMPLIFIER)


@dataclass(frozen=True, eq=False)
class DeviceTest:
    """A test on a device, compared by identity.

    Attributes: the ``kind``, a key of `KINDS`; the numbers ``set`` and ``read``, (n,) each, in SI; the standard
    deviation of the ``noise`` of every reading, (n,) each; and ``notes`` about interpretations of its file.
    """

    name: str
    kind: str
    set: Mapping[str, Array]
    read: Mapping[str, Array]
    noise: Mapping[str, Array]
    notes: tuple[str, ...] = ()

    @property
    def values(self) -> Array:
        """All readings in a row."""
        return np.concatenate(list(self.read.values()))

    @property
    def deviations(self) -> Array:
        """The noise of all readings in a row."""
        return np.concatenate([self.noise[name] for name in self.read])

    @property
    def readings(self) -> list[Reading]:
        """Unit and instrument of every reading in a row."""
        return [KINDS[self.kind].read[name] for name, values in self.read.items() for _ in values]


def rows_read(rows: int) -> slice:
    """The rows of a series whose readings are compared."""
    return slice(None, None, -(-rows // MOST_READ))


class Variants:
    """Variants of a device, which are predicted together.

    ``fields`` are names, also dotted ones, of fields with positive values, which are multiplied by ``factors``
    (variants, fields). ``gains`` are factors of instruments, (variants,) each. ``near`` is a single variant close to
    all of these, from whose states the searches start.
    """

    def __init__(
        self,
        device: Device,
        fields: Sequence[str],
        factors: Array,
        gains: Mapping[str, Array],
        near: Variants | None = None,
    ) -> None:
        nominal = {name: field_value(device, name) for name in fields}
        changed: dict[str, Any] = {name: nominal[name] * factors[:, k] for k, name in enumerate(fields)}
        if not changed:
            changed = {"moving_mass": np.full(len(factors), float(device.moving_mass))}
        self.device = device.replace_quietly(changed | {"waveform": "sine"})
        members = self.device.to_model().members()
        if members.system.circuit.name == "charge":
            raise InputError("fit: takes a source of voltage, and circuit is 'charge'; leave it out")
        if any(film.drive == "opposite" for film in members.system.films):
            raise InputError("fit: takes no films in opposite phase, and second_drive is 'opposite'; leave it out")
        self.members: Members = members
        self.gains = {name: gains.get(name, np.ones(len(factors)))[:, None] for name in INSTRUMENTS}
        self.damping = np.broadcast_to(members.values["damping_ratio"], members.shape)[:, None]
        self.n = members.numbers(trailing=1)
        self._base, self._near = device, near
        self._states: dict[Any, Array] = {}

    def scale(self, quantity: str) -> Array:
        """The SI value of one dimensionless unit, (variants, 1)."""
        return np.broadcast_to(np.asarray(self.device.scales.size(quantity)), self.members.shape)[:, None]

    def force(self, x: Array, squared: Any, n: Mapping[str, Any] | None = None) -> tuple[Array, Array]:
        """Static force and its slope under squared commanded voltages, of arrays (variants, ...)."""
        balance = under_commands(self.members.system, self.n if n is None else n)
        force, slope = balance.force_and_slope(x, squared)
        return np.asarray(force), np.asarray(slope)

    def volts(self, commanded: Array) -> Array:
        """The dimensionless voltage of the source, (variants, rows), of a commanded one in V."""
        return self.gains[AMPLIFIER] * np.asarray(commanded, dtype=float) / self.scale("voltage")

    def squared(self, commanded: Array) -> Array:
        """The squared voltage of the source, (variants, rows), of a commanded one in V."""
        return np.asarray(self.volts(commanded) ** 2)

    def on_films(self, x: Array, squared: Array) -> list[Array]:
        """The squared voltages on the films at rest at x under squared commanded voltages, (variants, rows)."""
        return [np.asarray(square) for square in under_commands(self.members.system, self.n).films(x, squared)]

    @property
    def rest(self) -> Array:
        """The rest without voltage, (variants, 1); NaN if none is found near the rest of the device."""
        if "rest" not in self._states:
            start = self._start("rest", self.members.size)
            if start is None:
                start = _rest(self._base)
            at = self._balanced(np.array(np.broadcast_to(start, (self.members.size, 1)), dtype=float), 0.0)
            if np.isnan(at).any():
                at = self._balanced(np.array(np.broadcast_to(_rest(self.device), at.shape)), 0.0)
            self._states["rest"] = at
        return self._states["rest"]

    def _start(self, key: Any, *shape: int) -> Array | None:
        """The stored states of the nearby variant, broadcast to all; None if there are none."""
        if self._near is None or key not in self._near._states:
            return None
        known = self._near._states[key]
        return np.array(np.broadcast_to(known, (*shape, *known.shape[1:])), dtype=float)

    def _balanced(self, x: Array, squared: Any, load: Any = 0.0) -> Array:
        """Find the stable equilibrium near x at a squared voltage and under a load by Newton's method; NaN if that
        fails."""

        def balance(x: Array) -> tuple[Array, Array]:
            force, slope = self.force(x, squared)
            return force + load, slope

        return stable_near(x, balance, longest=LONGEST_STEP)[0]

    # --- the kinds of tests -------------------------------------------------------------------------------------------

    def predict(self, test: DeviceTest) -> Array:
        """Predict the readings of a test for all variants, (variants, readings); NaN where a variant has no state."""
        methods: Mapping[str, tuple[Callable[..., Array], Mapping[str, Any]]] = {
            "blocked force": (self.blocked_force, {}),
            "stroke over voltage": (self.stroke, {"key": test}),
            "frequency response": (self.response, {"key": test}),
            "stroke over load": (self.loaded_stroke, {"key": test}),
            "capacitance": (self.capacitance, {}),
            "ring-down": (self.ring_down, {"rows": test.values.size // 2}),
            "series": (self.series, {"names": tuple(test.read)}),
        }
        method, options = methods[test.kind]
        return method(**test.set, **options)

    def blocked_force(self, height: Array, voltage: Array) -> Array:
        """Force that holds the disc at heights under voltages."""
        x = np.asarray(height) / self.scale("length")
        force = self.force(x, self.squared(voltage))[0] * self.scale("force")
        return force * self.gains["load cell"]

    def stroke(self, voltage: Array, key: Any = None) -> Array:
        """Stroke from the rest on a slow ramp through the voltages; the states are stored under ``key``."""
        squared, count = self.squared(voltage), len(voltage)
        places = self._start(key, self.members.size)
        if places is not None:
            places = self._balanced(places, squared)
        else:
            x, places = self.rest, np.full((self.members.size, count), np.nan)
            for k in np.argsort(np.abs(voltage)):
                x = self._balanced(x, squared[:, k : k + 1])
                places[:, k : k + 1] = x
        self._states[key] = places
        return (places - self.rest) * self.scale("length") * self.gains["laser"]

    def loaded_stroke(self, load: Array, voltage: Array, key: Any = None) -> Array:
        """Stroke under loads that pull the disc down, from its height without voltage; the states are stored under
        ``key``."""
        pull, squared = np.asarray(load) / self.scale("force"), self.squared(voltage)
        start = self._start(key, self.members.size)
        if start is None:
            hanging = np.broadcast_to(self.rest, pull.shape)
            for share in LOAD_SHARES:
                hanging = self._balanced(hanging, 0.0, share * pull)
            lifted = hanging
            for share in LOAD_SHARES:
                lifted = self._balanced(lifted, share * squared, pull)
        else:
            hanging, lifted = self._balanced(start[..., 0], 0.0, pull), self._balanced(start[..., 1], squared, pull)
        self._states[key] = np.stack([hanging, lifted], axis=-1)
        return (lifted - hanging) * self.scale("length") * self.gains["laser"]

    def natural_frequency(self, voltage: float) -> Array:
        """Natural frequency about the rest under a constant voltage, (variants,)."""
        at = np.array([voltage])
        x, squared = self.rest + self.stroke(at) / (self.scale("length") * self.gains["laser"]), self.squared(at)
        volts = [np.sqrt(square) for square in self.on_films(x, squared)]
        frequencies = frequencies_under(self.members, self.force(x, squared)[1], x, volts)
        return np.asarray(frequencies * self.scale("frequency"))[:, 0]

    def capacitance(self, height: Array, voltage: Array) -> Array:
        """Capacitance, charge over voltage, of all films of the source at heights under voltages."""
        x, squared = np.asarray(height) / self.scale("length"), self.squared(voltage)
        films = [film for film in self.members.system.films if film.drive in (None, "same")]
        with np.errstate(all="ignore"):
            capacitance = sum(film.capacitance(x, self.on_films(x, squared)[0], [], self.n) for film in films)
        return np.asarray(capacitance) * self.scale("capacitance") * self.gains["capacitance meter"]

    def ring_down(self, rows: int = 1) -> Array:
        """Frequency and decay rate of small motions about the rest, both as often as they were read."""
        rate = 2.0 * np.pi * self.scale("frequency")
        if self.members.system.planar:
            with np.errstate(invalid="ignore"):
                swing, decay = np.sqrt(self.force(self.rest, 0.0)[1] - self.damping**2), self.damping
        else:
            swing, decay = (rates[:, None] for rates in small_motion(self.members, self.rest[:, 0]))
        return np.repeat(np.concatenate([rate * swing / (2.0 * np.pi), rate * decay], axis=1), rows, axis=1)

    def response(self, voltage_offset: Array, voltage_amplitude: Array, frequency: Array, key: Any = None) -> Array:
        """The in-phase and quadrature parts of the settled motion, by one-harmonic balance; the states are stored under
        ``key``."""
        offset, amplitude = self.volts(voltage_offset), self.volts(voltage_amplitude)
        offset, amplitude = (
            np.broadcast_to(volts, (self.members.size, len(frequency))) for volts in (offset, amplitude)
        )
        omega = np.asarray(frequency) / self.scale("frequency")
        start = self._start(key, self.members.size)
        if start is None:
            start = self._linear(offset, amplitude, omega)
        if self.members.system.planar:
            balance = self._balance(offset, amplitude, omega, start)
        else:
            driven = self._driven(offset, amplitude, omega)
            balance = balanced(driven, start.reshape(driven.size, *start.shape[-2:])).reshape(start.shape)
        self._states[key] = balance
        disc = balance if self.members.system.planar else balance[..., 0, :]
        size = (self.scale("length") * self.gains["laser"])[..., None]
        return np.concatenate(list(np.moveaxis((size * disc)[..., 1:], -1, 0)), axis=1)

    def _driven(self, offset: Array, amplitude: Array, omega: Array) -> Members:
        """The variants under every sine, (variants * rows,)."""
        variant = np.repeat(np.arange(self.members.size), omega.shape[1])
        driven = {"voltage_bias": offset, "voltage": amplitude, "drive_frequency": omega}
        return self.members.take(variant).replace(**{name: value.ravel() for name, value in driven.items()})

    def _linear(self, offset: Array, amplitude: Array, omega: Array) -> Array:
        """The linear motion about the equilibrium at the mean square of the voltage, as a first guess: mean, sine and
        cosine, (variants, rows, 3), or of all states, (variants, rows, states, 3), where there are more."""
        gain, n = self.members.system.circuit.gain, self.n
        mean = np.abs(gain(0.0, n) * offset) ** 2 + 0.5 * np.abs(gain(omega, n) * amplitude) ** 2
        x = self._raised(mean / np.abs(gain(0.0, n)) ** 2)
        motion = linear_motion(self._driven(offset, amplitude, omega), x.ravel())
        motion = motion.reshape(*offset.shape, *motion.shape[1:])
        return motion[..., 0, :] if self.members.system.planar else motion

    def _raised(self, squared: Array) -> Array:
        """The equilibrium under squared voltages, (variants, rows), continued from the rest."""
        x = np.broadcast_to(self.rest, squared.shape)
        for share in LOAD_SHARES:
            x = self._balanced(x, share * squared)
        return x

    def _under(self, time: Array, voltage: Array) -> Members:
        """The variants under a recorded voltage."""
        kept, peak = needed(time, voltage), float(np.abs(voltage).max()) or 1.0
        drive = Samples(tuple((time[kept] / time[-1]).tolist()), tuple((voltage[kept] / peak).tolist()))
        amplitude = peak * self.gains[AMPLIFIER][:, 0]
        changes = {
            "waveform": drive,
            "voltage_amplitude": amplitude,
            "voltage_offset": 0.0,
            "frequency": 1.0 / time[-1],
        }
        return self.device.replace_quietly(changes).to_model().members()

    def series(self, time: Array, voltage: Array, names: Sequence[str] = ("stroke",)) -> Array:
        """Stroke and current at times of a run from rest, under a voltage that is linear between the given ones."""
        driven_members = self._under(time - time[0], voltage)
        at = (time - time[0])[rows_read(len(time))] / self.scale("time")
        with np.errstate(all="ignore"):
            start = driven_members.start_states(np.concatenate([self.rest, np.zeros_like(self.rest)], axis=1))
            states = integrate(driven_members, start, at, tolerance=TOLERANCE).states
            z, readings = list(np.moveaxis(states, -1, 0)), {}
            if "current" in names:
                readings["current"] = _currents(driven_members, at, z) * self.scale("current") * self.gains["ammeter"]
        readings["stroke"] = (z[0] - self.rest) * self.scale("length") * self.gains["laser"]
        return np.concatenate([readings[name] for name in names], axis=1)

    def _balance(self, offset: Array, amplitude: Array, omega: Array, start: Array) -> Array:
        """Mean, sine and cosine, (variants, rows, 3), that balance the forces; NaN where Newton's method fails."""
        squared = ((offset[..., None] + amplitude[..., None] * BASIS[1]) ** 2).reshape(-1, PHASES)
        damping = (2.0 * self.damping * omega).ravel()
        inertia = np.zeros((omega.size, 3, 3))
        inertia[:, 1, 1] = inertia[:, 2, 2] = -(omega.ravel() ** 2)
        inertia[:, 1, 2], inertia[:, 2, 1] = -damping, damping
        variant = np.repeat(np.arange(self.members.size), omega.shape[1])
        n = {name: np.broadcast_to(value, (self.members.size, 1))[:, 0] for name, value in self.n.items()}
        c, moving = start.reshape(-1, 3).copy(), np.flatnonzero(np.isfinite(start.reshape(-1, 3)).all(axis=-1))
        size = np.full(len(c), np.nan)
        for _ in range(NEWTON_STEPS):
            numbers = {name: value[variant[moving], None] for name, value in n.items()}
            force, slope = self.force(c[moving] @ BASIS, squared[moving], numbers)
            residual = force @ WEIGHTS.T + np.einsum("rij,rj->ri", inertia[moving], c[moving])
            matrix = np.einsum("ip,rp,jp->rij", WEIGHTS, slope, BASIS) + inertia[moving]
            step = solved_where_regular(matrix, residual)
            size[moving] = np.abs(step).max(axis=-1)
            c[moving] -= step * np.minimum(1.0, LONGEST_STEP / np.maximum(size[moving], 1e-300))[:, None]
            moving = moving[size[moving] > 1e-12]
            if not moving.size:
                break
        return np.where(size[:, None] < 1e-8, c, np.nan).reshape(start.shape)


def _currents(members: Members, times: Array, z: list[Array]) -> Array:
    """Currents from the source; the mean of both sides where the slope of the voltage jumps."""
    n, step = members.numbers(trailing=1), SIDE * times[..., -1:]
    sides = [
        members.system.source_currents(np.clip(times + shift, step, times[..., -1:] - step), z, n)[0]
        for shift in (-step, step)
    ]
    return np.asarray(0.5 * (sides[0] + sides[1]))


def _rest(device: Device) -> Array:
    """The rest without voltage of a device, dimensionless, (members, 1)."""
    state = device.replace_quietly(release_height=None, release_velocity=0.0).initial_state()
    return np.asarray(state, dtype=float).reshape(-1, 2)[:, :1]


def field_value(device: Device, name: str) -> float:
    """Return the positive value of a device's field; `InputError` for a field that cannot be fitted."""
    fields = device.swept_fields()
    if name not in fields:
        from gelcone.errors import unknown_name

        usable = [field for field in fields if np.ndim(device.get(field)) == 0 and (device.get(field) or 0.0) > 0.0]
        raise unknown_name("field that can be fitted", name, usable)
    if name == "material.young_modulus":
        raise InputError(f"free {name}: a device has material.shear_modulus, a third of it; free that")
    value = device.get(name)
    if value is None or np.ndim(value) or not (np.isfinite(value) and value > 0.0):
        shown = "not set" if value is None else f"{np.asarray(value).tolist()}"
        raise InputError(f"free {name}: is {shown}; a field that is fitted must have one value greater than 0")
    return float(value)
