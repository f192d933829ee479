"""Points of a sweep over a device's fields: reading of their values, and model and initial state of each point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gelcone.devices.device import Device
from gelcone.devices.materials import find_material
from gelcone.devices.record import Field, unknown_field
from gelcone.devices.scales import MEASURES
from gelcone.devices.units import format_si, parse
from gelcone.errors import InputError
from gelcone.physics.component import State
from gelcone.physics.model import ConeModel
from gelcone.physics.structure import DISC
from gelcone.quantity import Array

STATE_FIELDS: Mapping[str, Field] = {
    "displacement": Field("initial displacement of the disc", "m", near=("height", "release_height", "x")),
    "velocity": Field("initial velocity of the disc", "m/s", near=("release_velocity", "u")),
}
"""Components of the initial state, which a sweep takes in addition to the fields of the device."""
STATES = {state.name: state.quantity for state in DISC}
"""Components of the initial state -> their quantities."""


GELS = "material"
"""The field whose values in a sweep are names, in the order given."""


def point_fields(device: Device) -> dict[str, Field]:
    """The fields and components of the initial state that can be swept, mapped and uncertain."""
    return {**device.swept_fields(), **STATE_FIELDS}


def shown_value(device: Device | None, name: str, value: float) -> str:
    """The text of a varied value for messages: with the unit of its field if there is a device."""
    return f"{value:g}" if device is None else format_si(value, point_fields(device)[name].unit)


def read_swept(device: Device, name: str, values: Any) -> Any:
    """Read values of a field in SI from numbers or texts with units, or names of gels; `InputError` for unknown fields
    and for values out of bounds."""
    if name == GELS:
        return np.array([find_material(str(gel)).name for gel in np.atleast_1d(values)])
    return swept_field(device, name).read(name, values)


def swept_field(device: Device, name: str, option: str = "") -> Field:
    """Return a field that can be swept; `InputError` for any other name, which begins with the option that names it."""
    fields = point_fields(device)
    if name in fields:
        return fields[name]
    if name in device.all_fields():
        raise InputError(f"{option or name}: is not numeric and cannot be swept; set it and run once per value")
    unknown = unknown_field("device", name, fields)
    raise InputError(f"{option}: {unknown}") if option else unknown


def read_state(initial: Sequence[Any], device: Device | None = None) -> tuple[float, ...]:
    """Read a displacement and a velocity in m and m/s from numbers or texts with units; or all states of the components
    of a ``device``, in SI."""
    states = () if device is None or np.shape(initial) == (2,) else own_states(device)
    if isinstance(initial, str) or np.shape(initial) not in ((2,), (2 + len(states),)):
        longer_form = (
            f", or all of them: {', '.join(['displacement', 'velocity', *(s.name for s in states)])}" if states else ""
        )
        raise InputError(
            f"initial = {initial!r}: must be a displacement and a velocity, such as ('5 mm', '0 m/s'){longer_form}"
        )
    x, u, *others = initial
    other_states = [parse(f"initial {s.name}", value, unit_of(s)) for s, value in zip(states, others, strict=False)]
    return parse("initial displacement", x, "m"), parse("initial velocity", u, "m/s"), *other_states


def own_states(device: Device) -> tuple[State, ...]:
    """The states that components of a device add to displacement and velocity, such as its gel and its amplifier."""
    return device.to_model().system.states[2:]


def unit_of(state: State) -> str:
    """The SI unit of a state; "1" for a pure number."""
    return MEASURES[state.quantity].unit if state.quantity in MEASURES else "1"


def dimensionless_state(device: Device, state: Sequence[Any]) -> Array:
    """States in SI over their scales: (N,), or (members, N) of several devices."""
    more = own_states(device) if len(state) > len(STATES) else ()
    quantities = [*STATES.values(), *(s.quantity for s in more)]
    sizes = [device.scales.size(q) if q in MEASURES else 1.0 for q in quantities]
    return np.stack(np.broadcast_arrays(*(value / size for value, size in zip(state, sizes, strict=True))), axis=-1)


def at(device: Device, values: Mapping[str, Array]) -> Device:
    """Make the device at some points: an ensemble if ``values`` hold fields; states in it are ignored."""
    fields: dict[str, Any] = {name: value for name, value in values.items() if name not in STATE_FIELDS}
    if GELS in fields:
        fields[GELS] = [find_material(str(gel)) for gel in fields[GELS]]
    return device.replace_quietly(fields) if fields else device


def device_at(
    device: Device, values: Mapping[str, Array], initial: Sequence[float] | None = None
) -> tuple[ConeModel, Array]:
    """Make the models and initial states, (points, 2), at some points.

    Parameters
    ----------
    values : field, ``displacement`` or ``velocity`` -> values in SI, (points,) each.
    initial : displacement and velocity in m and m/s where ``values`` have none. Default: that of the device.
    """
    count = len(next(iter(values.values())))
    points = at(device, values)
    model = points.to_model()
    if not model.shape:
        model = model.replace(damping_ratio=np.full(count, model.damping_ratio))
    needed = initial is None and not set(STATE_FIELDS) <= set(values)
    default_state = points.initial_state() if needed else (0.0, 0.0)
    states = np.broadcast_to(default_state, (count, 2)).copy()
    for column, (name, quantity) in enumerate(STATES.items()):
        if name in values or initial is not None:
            state = values[name] if name in values else initial[column]  # type: ignore[index]
            states[:, column] = points.scales.dimensionless(quantity, state)
    return model, states


def field_attributes(device: Device, name: str) -> dict[str, str]:
    """The attributes of a coordinate over a field: its meaning and its SI unit."""
    if name == GELS:
        return {"long_name": "gel", "units": "1", "quantity": "device field"}
    field = point_fields(device)[name]
    return {"long_name": field.meaning, "units": field.unit, "quantity": "device field"}
