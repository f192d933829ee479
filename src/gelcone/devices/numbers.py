"""The parameters of a model, and the fields of a device from which they follow."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from gelcone.devices.fields import GEL, SECOND_PRESTRETCHES, DeviceFields
from gelcone.devices.parts import PARTS, component_of, own_fields
from gelcone.physics.component import Component
from gelcone.physics.film.gel import PRESTRETCHES
from gelcone.physics.model import PARAMETERS


class Number(NamedTuple):
    """The field of a device from which a parameter follows, and the quantity that scales it."""

    field: str
    quantity: str


_FIELDS = {
    "spring_stiffness": "spring_rate",
    "rest_height": "initial_height",
    "voltage": "voltage_amplitude",
    "voltage_bias": "voltage_offset",
    "drive_frequency": "frequency",
    "beam_stiffness": "beam_rate",
    "beam_cubic": "beam_cubic_rate",
    "push": "constant_force",
    "leakage_time": f"{GEL}resistivity",
    "leakage_field": f"{GEL}resistivity_field",
    "dielectric_share": f"{GEL}dielectric_share",
    "dielectric_time": f"{GEL}dielectric_time",
}
_QUANTITIES = {"leakage_time": "resistivity"}
_ELECTRIC = ("slew_rate", "series_resistance", "current_limit")
_SAME = (*_ELECTRIC, "beam_height", "second_flat_height", "second_voltage", *PRESTRETCHES, *SECOND_PRESTRETCHES)
SHIPPED: Mapping[str, Number] = {
    name: Number(_FIELDS.get(name, name), _QUANTITIES.get(name, PARAMETERS[name].scale)) for name in (*_FIELDS, *_SAME)
}
"""Parameters of the model -> fields of every device."""


def numbers_of(device: DeviceFields) -> dict[str, Number]:
    """Parameters of the model -> fields of a device, also of its law and of user-defined components.

    Damping, weight and dielectric strength, which follow from several fields, are not included.
    """
    law = device.material.strain_energy_law.parameters
    numbers = {**SHIPPED, **{name: Number(GEL + name, quantity.scale) for name, quantity in law.items()}}
    for k in range(1, device.material.branches + 1):
        numbers[f"viscous_modulus_{k}"] = Number(f"{GEL}viscous_modulus_{k}", "stress")
        numbers[f"relaxation_time_{k}"] = Number(f"{GEL}relaxation_time_{k}", "time")
        numbers[f"viscous_limit_{k}"] = Number(f"{GEL}viscous_stretch_limit_{k}", "1")
    for part in PARTS:
        value = getattr(device, part)
        if isinstance(value, Component) or part == "waveform":
            part_fields, parameters = own_fields(part, value), component_of(part, value).parameters
            numbers |= {name: Number(f"{part}.{name}", parameters[name].scale) for name in part_fields}
    return numbers
