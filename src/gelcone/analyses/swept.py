"""Swept quantities, read from text: parameters or fields with their values, and initial states."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.analyses.values import pairs, plain, read_field, read_measures, read_numbers
from gelcone.devices.points import GELS, STATES, point_fields, read_swept, swept_field
from gelcone.errors import InputError, check_names
from gelcone.physics.model import parameter_names, parameter_quantity
from gelcone.quantity import Array

if TYPE_CHECKING:
    from gelcone.devices.device import Device
    from gelcone.physics.system import ConeSystem

DEFAULT_STATES = (-2.0, 2.0, 81)
"""Initial displacements and velocities of a basin by default, dimensionless."""


def example(device: Device | None, name: str) -> str:
    """A value of ``--over``, for messages."""
    if device is None:
        return f"--over {name}=0:2:401"
    unit = {"frequency": "Hz", "displacement": "mm", "velocity": "m/s"}.get(name, "V")
    return f'--over "{name}=5 {unit}:20 {unit}:31"'


def read_over(over: Iterable[str], device: Device | None = None, system: ConeSystem | None = None) -> dict[str, Array]:
    """Swept name -> its values, in the order given: parameters of the model or, with a device, its fields in SI.

    Values are a range ``from:to:count`` or a list ``v1,v2,...``, increasing and at least two. ``system`` brings the
    parameters of its components.

    Raises
    ------
    InputError : for what is not ``name=values``, a name that is unknown (with the nearest one) or given twice, values
        that are empty, reversed, repeated or fewer than two, and values out of bounds.
    """
    swept: dict[str, Array] = {}
    name = "voltage" if device is None else "voltage_amplitude"
    form = f"name=from:to:count or name=v1,v2,..., for example {example(device, name)}"
    for name, text in pairs("--over", over, form).items():
        option = f"--over {name}"
        sweepable(option, name, device, system)  # refuses an unknown name before its values are read
        values = np.atleast_1d(_values(option, text, name, device, system))
        swept[name] = values if values.dtype.kind == "U" else increasing(option, values)
    return swept


def sweepable(option: str, name: str, device: Device | None, system: ConeSystem | None) -> None:
    """`InputError` for a name that cannot be swept."""
    if device is None:
        known = [*parameter_names(), *(system.parameters if system else {})]
        if name not in known:
            only_of_model([name])
        parameter_quantity(name, system)
        return
    from gelcone.devices.record import unknown_field

    if name == GELS:
        return
    swept_field(device, name, option)
    if name in STATES:
        raise InputError(f"{option}: {unknown_field('device', name, device.swept_fields())}")


def _values(option: str, text: str, name: str, device: Device | None, system: ConeSystem | None) -> Any:
    """The values of a parameter or field, within its bounds."""
    if device is None:
        numbers = read_numbers(option, text, plain)
        return np.asarray(parameter_quantity(name, system).check(name, numbers), dtype=float)
    if name == GELS:
        return read_swept(device, name, [part.strip() for part in text.split(",")])
    return read_swept(device, name, read_field(option, text, name, point_fields(device)))


def read_states(over: Iterable[str], device: Device | None, system: ConeSystem | None = None) -> dict[str, Array]:
    """The values of two initial states, with a device in m and m/s: displacement and velocity by default, without a
    device any of the states of a ``system``."""
    known = list(STATES) if system is None or device is not None else [state.name for state in system.states]
    given = pairs("--over", over, f"name=from:to:count, for example {example(device, 'displacement')}")
    check_names("component of the initial state", given, known)
    if len(given) > 2:
        raise InputError(f"--over: {', '.join(given)} are {len(given)} states; vary two of them")
    names = [*given, *(name for name in STATES if name not in given)][:2]
    return {name: _states(name, given.get(name), device) for name in known if name in names}


def _states(name: str, text: str | None, device: Device | None) -> Array:
    if text is None:
        scale = 1.0 if device is None else float(getattr(device.scales, STATES[name]))
        return scale * np.linspace(*DEFAULT_STATES)
    option = f"--over {name}"
    quantity = STATES.get(name, "1")
    return increasing(option, np.atleast_1d(read_measures(option, text, quantity, device, in_si=True)))


def increasing(option: str, values: Array, least: int = 2) -> Array:
    """``values``, refused where they are fewer than the ``least`` number of them or do not increase."""
    if values.size < least:
        raise InputError(f"{option}: has one point; a sweep takes at least two values")
    if not (values[1:] > values[:-1]).all():
        raise InputError(f"{option}: must increase; sort the values and remove duplicates")
    return values


def only_of_model(values: Iterable[str]) -> None:
    """`InputError` for a field of a device where there is none, with the parameter of the model of that meaning."""
    known = parameter_names()
    for name in values:
        if name in known or name.partition(".")[0] in known:
            continue
        from gelcone.devices.fields import DEVICE_FIELDS

        if name in DEVICE_FIELDS:
            same = [other for other in known if other in DEVICE_FIELDS[name].near]
            remedy = f"without a device, set {same[0]!r}, dimensionless" if same else "give a device to set it"
            raise InputError(f"--set {name}: is a field of a device; {remedy}")
