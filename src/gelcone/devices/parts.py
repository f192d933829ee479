"""Components of a device and of its material: by name, as an instance, or as a table with their data and numbers.

A component that ships is stored by its name. A user-defined component, ``"module:Class"``, adds fields: its parameters,
in SI units where they have a scale (`gelcone.quantity.Quantity`).
"""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from gelcone.devices.record import Field
from gelcone.devices.scales import MEASURES
from gelcone.devices.units import DIMENSIONS, FieldError
from gelcone.errors import InputError
from gelcone.physics.bias import Bias, Together
from gelcone.physics.component import Component, to_record
from gelcone.physics.drive import VOLTAGE
from gelcone.physics.laws import StrainEnergyLaw
from gelcone.physics.model import PARAMETERS
from gelcone.physics.records import COMPONENTS, bias_record, find_bias, find_part
from gelcone.quantity import Quantity

PARTS = ("film", "waveform", "bias", "circuit")
"""Fields of a device that hold a component."""
_OF_ITS_OWN = re.compile(r"[\w.]+:[A-Za-z_][\w.]*")


def read_part(name: str, given: Any) -> tuple[Any, dict[str, Any]]:
    """Read a component; return it, or its name if it ships, and the numbers in its table.

    Raises `FieldError` for anything but a component of that kind, and for data that no file can hold.
    """
    tables = [entry for entry in (given if isinstance(given, list) else [given]) if isinstance(entry, Mapping)]
    if name == "film" and (taken := [key for entry in tables for key in entry if key in ("law", "prestretch_mode")]):
        raise FieldError("film", f"film: {taken[0]} is a field of the material or of the device; leave it out here")
    try:
        component: Component = _own_bias(given) if name == "bias" else find_part(name, given)
    except FieldError:
        raise
    except InputError as error:
        raise FieldError(name, f"{name}: {error}") from None
    members: list[Any] = [*component.parts] if isinstance(component, Together) else [component]
    data = {field.name for part in members if dataclasses.is_dataclass(part) for field in dataclasses.fields(part)}
    numbers = {str(key): value for table in tables for key, value in table.items() if key not in {"component", *data}}
    shipped = COMPONENTS[name][1]
    if component == shipped.get(component.name):
        return component.name, numbers
    if isinstance(given, str) and given in shipped:
        return given, numbers
    _check_data(name, component)
    return component, numbers


def _own_bias(given: Any) -> Bias:
    """Read a user-defined bias, which acts in addition to spring, beam, weight and force."""
    remedy = "spring, beam, weight and force have fields of their own, and a constant voltage is voltage_offset"
    if isinstance(given, str) and not all(_OF_ITS_OWN.fullmatch(part.strip()) for part in given.split("+")):
        raise FieldError("bias", f'bias = {given!r}: must be a component of one\'s own, "module:Class"; {remedy}')
    bias = given if isinstance(given, Bias) else find_bias(given)
    taken = [name for name in bias.parameters if name in PARAMETERS]
    if taken:
        raise FieldError("bias", f"bias: has the parameter {taken[0]}, which is one that ships; {remedy}")
    return bias


def _check_data(name: str, component: Component) -> None:
    try:
        json.dumps(part_record(name, component))
    except (TypeError, ValueError):
        raise FieldError(
            name, f"{name}: {component!r} holds data that no file can hold; give numbers, texts or tuples of them"
        ) from None


def component_of(name: str, value: Any) -> Any:
    """The component in a field, given as an instance or by its name."""
    return COMPONENTS[name][1][value] if isinstance(value, str) else value


def part_record(name: str, value: Any) -> Any:
    """The value of a field as plain data, for `read_part`."""
    if not isinstance(value, Component):
        return value
    record = bias_record(value) if isinstance(value, Bias) else to_record(value, COMPONENTS[name][1])
    if name == "film" and isinstance(record, dict):  # the law is the material's, and the mode the device's
        record = {key: datum for key, datum in record.items() if key not in ("law", "prestretch_mode")}
    return record


def own_fields(name: str, value: Any) -> dict[str, Field]:
    """The fields that a user-defined component adds, by the names of its parameters."""
    if name == "waveform" and value is not None:
        value = component_of(name, value)
    if not isinstance(value, Component):
        return {}
    law = getattr(value, "law", None)
    shared = {"law": set(), "circuit": set(), "waveform": VOLTAGE.keys()}  # what the device has fields for
    others = set(shared.get(name, PARAMETERS.keys()))
    others = others | (law.parameters.keys() if isinstance(law, StrainEnergyLaw) else set())
    return {number: field_of(number, quantity) for number, quantity in value.parameters.items() if number not in others}


def field_of(name: str, quantity: Quantity) -> Field:
    """Make the field of a parameter, in the SI unit of its scale, with the bounds that are the same in SI."""
    pure = quantity.scale == "1"
    unit = "1" if pure else MEASURES[quantity.scale].unit if quantity.scale in MEASURES else ""
    if unit not in DIMENSIONS:
        known = ", ".join(scale for scale, measure in MEASURES.items() if measure.unit in DIMENSIONS)
        raise InputError(f"{name}: scale = {quantity.scale!r} must be '1' or one of {known}")
    bounded = not quantity.positive and np.isfinite(quantity.lower) and (pure or quantity.lower == 0.0)
    return Field(
        quantity.meaning,
        unit,
        default=None,
        unset=f"{quantity.default:g}" if pure else f"{quantity.default:g} times the device's unit of {quantity.scale}",
        typical=quantity.typical,
        near=quantity.near,
        above=0.0 if quantity.positive else None,
        least=quantity.lower if bounded else None,
        infinite=quantity.infinite,
        example=quantity.default if pure else None,
    )
