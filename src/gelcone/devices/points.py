"""Points of a sweep over a device's fields: their values read, and the model and the start of each point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gelcone.devices.device import SWEPT_FIELDS, Device
from gelcone.devices.record import Field, unknown_field
from gelcone.devices.units import parse
from gelcone.errors import InputError
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

STATE_FIELDS: Mapping[str, Field] = {
    "displacement": Field("initial displacement of the disc", "m", near=("height", "release_height", "x")),
    "velocity": Field("initial velocity of the disc", "m/s", near=("release_velocity", "u")),
}
"""Components of the initial state, which a sweep takes beside the fields of the device."""
POINT_FIELDS: Mapping[str, Field] = {**SWEPT_FIELDS, **STATE_FIELDS}
"""All that can be swept, mapped and uncertain with a device."""


def read_swept(device: Device, name: str, values: Any) -> Any:
    """Values of a field in SI, from numbers or texts with units; `InputError` for an unknown one or out of bounds."""
    if name not in POINT_FIELDS:
        raise refused(device, name)
    return POINT_FIELDS[name].read(name, values)


def refused(device: Device, name: str) -> InputError:
    """Why a name cannot be swept."""
    if name in device.field_names():
        return InputError(f"{name}: is no number, and cannot be swept; set it, and run once for each")
    return unknown_field("device", name, POINT_FIELDS)


def read_state(initial: Sequence[Any]) -> tuple[float, float]:
    """A displacement and a velocity in m and m/s, from numbers or texts with units."""
    if isinstance(initial, str) or np.shape(initial) != (2,):
        raise InputError(f"initial = {initial!r}: must be a displacement and a velocity, such as ('5 mm', '0 m/s')")
    x, u = initial
    return parse("initial displacement", x, "m"), parse("initial velocity", u, "m/s")


def at(device: Device, values: Mapping[str, Array]) -> Device:
    """The device at some points, an ensemble where ``values`` hold fields; a state is none."""
    fields = {name: value for name, value in values.items() if name not in STATE_FIELDS}
    return device.replace_quietly(fields) if fields else device


def device_at(
    device: Device, values: Mapping[str, Array], initial: Sequence[float] | None = None
) -> tuple[ConeModel, Array]:
    """Models and initial states, (points, 2), at some points.

    Parameters
    ----------
    values : field, ``displacement`` or ``velocity`` -> values in SI, (points,) each.
    initial : displacement and velocity in m and m/s at points that have none of their own. Default: the device's own.
    """
    count = len(next(iter(values.values())))
    points = at(device, values)
    model = points.to_model()
    if not model.shape:
        model = model.replace(damping_ratio=np.full(count, model.damping_ratio))
    scales = (points.scales.length, points.scales.velocity)
    needed = initial is None and not set(STATE_FIELDS) <= set(values)
    own = points.initial_state() if needed else (0.0, 0.0)
    states = np.broadcast_to(own, (count, 2)).copy()
    for column, (name, scale) in enumerate(zip(STATE_FIELDS, scales, strict=True)):
        if name in values:
            states[:, column] = values[name] / scale
        elif initial is not None:
            states[:, column] = initial[column] / scale
    return model, states


def field_attributes(name: str) -> dict[str, str]:
    """The attributes of a coordinate over a field: what it is, and its SI unit."""
    field = POINT_FIELDS[name]
    return {"long_name": field.meaning, "units": field.unit, "quantity": "device field"}
