"""The scales of a device, the SI values of its dimensionless units.

With the film's volume Vol = pi (b^2 - a^2) H, shear modulus mu and permittivity eps, the units of the dimensionless
model are the length b - a, the time 1/Omega0 = sqrt(m (b-a)^2 / (mu Vol)), the energy mu Vol and the field
sqrt(mu/eps).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

# CODATA 2022, F/m
VACUUM_PERMITTIVITY = 8.8541878188e-12


HEAT_CAPACITY = 1.8e6
"""Default volumetric heat capacity of a gel, J/(m^3 K), an estimate between polymer and plasticiser."""


class Measure(NamedTuple):
    """The SI unit of a quantity, the unit ``shown`` in results, and the number of these ``per_unit`` in SI."""

    unit: str
    shown: str
    per_unit: float


MEASURES: Mapping[str, Measure] = {
    "length": Measure("m", "mm", 1e3),
    "time": Measure("s", "ms", 1e3),
    "velocity": Measure("m/s", "m/s", 1.0),
    "force": Measure("N", "N", 1.0),
    "stiffness": Measure("N/m", "N/m", 1.0),
    "cubic stiffness": Measure("N/m^3", "N/m^3", 1.0),
    "energy": Measure("J", "mJ", 1e3),
    "power": Measure("W", "mW", 1e3),
    "apparent power": Measure("VA", "mVA", 1e3),
    "voltage": Measure("V", "V", 1.0),
    "current": Measure("A", "mA", 1e3),
    "resistance": Measure("ohm", "Mohm", 1e-6),
    "resistivity": Measure("ohm m", "Gohm m", 1e-9),
    "slew rate": Measure("V/s", "V/ms", 1e-3),
    "gain": Measure("m/V", "mm/kV", 1e6),
    "admittance": Measure("S", "uS", 1e6),
    "charge": Measure("C", "uC", 1e6),
    "capacitance": Measure("F", "nF", 1e9),
    "thickness": Measure("m", "mm", 1e3),
    "field": Measure("V/m", "MV/m", 1e-6),
    "stress": Measure("Pa", "kPa", 1e-3),
    "frequency": Measure("Hz", "Hz", 1.0),
    "rate": Measure("1/s", "1/s", 1.0),
    "heating": Measure("K/s", "mK/s", 1e3),
    "energy density": Measure("J/m^3", "J/m^3", 1.0),
    "power density": Measure("W/m^3", "W/m^3", 1.0),
    "specific energy": Measure("J/kg", "mJ/kg", 1e3),
    "specific power": Measure("W/kg", "mW/kg", 1e3),
}
"""Quantities with a scale, of variables, parameters and options."""


@dataclass(frozen=True)
class Scales:
    """The SI value of one dimensionless unit: ``x_in_metres = x * scales.length``; arrays for an ensemble.

    Attributes
    ----------
    length : b - a, m.
    time : 1/Omega0, s.
    velocity : (b-a) Omega0, m/s.
    force : mu Vol/(b-a), N.
    energy : mu Vol, J.
    power : mu Vol Omega0, W.
    voltage : H sqrt(mu/eps), V.
    current : power/voltage, A.
    field : sqrt(mu/eps), V/m.
    stress : mu, Pa.
    frequency : Omega0/(2 pi), Hz: the ordinary frequency of one unit of the angular omega.
    heat_capacity : of the gel over its volume, J/(m^3 K).
    """

    length: Any
    time: Any
    velocity: Any
    force: Any
    energy: Any
    power: Any
    voltage: Any
    current: Any
    field: Any
    stress: Any
    frequency: Any
    heat_capacity: Any

    def size(self, quantity: str) -> Any:
        """The SI value of one dimensionless unit of a quantity of `MEASURES`."""
        derived = _DERIVED.get(quantity)
        return getattr(self, quantity) if derived is None else derived(self)

    def shown(self, quantity: str) -> Any:
        """One dimensionless unit of a quantity, in the unit of results."""
        return self.size(quantity) * MEASURES[quantity].per_unit

    def dimensionless(self, quantity: str, value: Any) -> Any:
        """A value in SI over the scale of its quantity; pure numbers (``"1"``) stay unchanged."""
        match quantity:
            case "1":
                return value
            case "stiffness":
                return value * self.length / self.force
            case "cubic stiffness":
                return value * self.length**3 / self.force
        return value / self.size(quantity)

    @classmethod
    def of(cls, get: Callable[[str], Any], xp: Any = np) -> Scales:
        """Compute the scales from the fields of a device, the material's under dotted names: numbers, arrays or, with a
        graph as ``xp``, expressions."""
        capacity = get("material.heat_capacity")
        a, b, mu = get("disc_radius"), get("film_radius"), get("material.shear_modulus")
        length = b - a
        energy = mu * (np.pi * (b**2 - a**2) * get("film_thickness"))
        rate = xp.sqrt(energy / carried_mass(get)) / length
        field = xp.sqrt(mu / (get("material.relative_permittivity") * VACUUM_PERMITTIVITY))
        voltage = get("film_thickness") * field
        return cls(
            length=length,
            time=1.0 / rate,
            velocity=length * rate,
            force=energy / length,
            energy=energy,
            power=energy * rate,
            voltage=voltage,
            current=energy * rate / voltage,
            field=field,
            stress=mu,
            frequency=rate / (2.0 * np.pi),
            heat_capacity=HEAT_CAPACITY if capacity is None else capacity,
        )


_DERIVED: Mapping[str, Callable[[Scales], Any]] = {
    "stiffness": lambda s: s.force / s.length,
    "cubic stiffness": lambda s: s.force / s.length**3,
    "apparent power": lambda s: s.power,
    "gain": lambda s: s.length / s.voltage,
    "admittance": lambda s: s.current / s.voltage,
    "heating": lambda s: s.stress / (s.time * s.heat_capacity),
    "resistance": lambda s: s.voltage / s.current,
    "charge": lambda s: s.current * s.time,
    "capacitance": lambda s: s.current * s.time / s.voltage,
    "thickness": lambda s: s.voltage / s.field,
    "rate": lambda s: 1.0 / s.time,
    "resistivity": lambda s: s.time * s.field**2 / s.stress,
    "slew rate": lambda s: s.voltage / s.time,
    "energy density": lambda s: s.stress,
    "power density": lambda s: s.stress / s.time,
    "specific energy": lambda s: s.velocity**2,
    "specific power": lambda s: s.velocity**2 / s.time,
}


def carried_mass(get: Callable[[str], Any]) -> Any:
    """The moving mass and the payload, kg."""
    payload = get("payload")
    return get("moving_mass") if payload is None else get("moving_mass") + payload
