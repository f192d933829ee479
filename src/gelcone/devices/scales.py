"""The SI values of the dimensionless units of a device.

With the film's volume Vol = pi (b^2 - a^2) H, shear modulus mu and permittivity eps, the units of the dimensionless
model are the length b - a, the time 1/Omega0 = sqrt(m (b-a)^2 / (mu Vol)), the energy mu Vol and the field
sqrt(mu/eps).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from gelcone.devices.materials import VACUUM_PERMITTIVITY


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

    @classmethod
    def of(cls, get: Callable[[str], Any]) -> Scales:
        """The scales by the fields of a device, its material's under dotted names; each a number or an array."""
        a, b, mu = get("disc_radius"), get("film_radius"), get("material.shear_modulus")
        length = b - a
        energy = mu * (np.pi * (b**2 - a**2) * get("film_thickness"))
        rate = np.sqrt(energy / carried_mass(get)) / length
        field = np.sqrt(mu / (get("material.relative_permittivity") * VACUUM_PERMITTIVITY))
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
        )


def carried_mass(get: Callable[[str], Any]) -> Any:
    """All that moves: the moving mass and the payload, kg."""
    payload = get("payload")
    return get("moving_mass") if payload is None else get("moving_mass") + payload
