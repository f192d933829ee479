"""The controls of a subject, derived from the parameters, device fields and components of its parts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from gelcone.analyses.request import Subject
from gelcone.devices.device import Device
from gelcone.devices.fields import ELECTRIC
from gelcone.devices.materials import load_materials
from gelcone.devices.parts import PARTS, component_of, own_fields
from gelcone.devices.record import Field
from gelcone.devices.units import DIMENSIONS, format_si
from gelcone.physics.bias import BIASES
from gelcone.physics.film.gel import PRESTRETCH_MODES, BranchedFilm
from gelcone.physics.laws import LAWS
from gelcone.physics.model import PARAMETERS
from gelcone.physics.placed import DRIVES
from gelcone.physics.records import CIRCUITS, FILMS, bias_record
from gelcone.physics.waveforms import WAVEFORMS
from gelcone.quantity import Quantity

CHOICES: Mapping[str, Iterable[str]] = {
    "film": FILMS,
    "law": LAWS,
    "bias": BIASES,
    "waveform": WAVEFORMS,
    "circuit": CIRCUITS,
    "prestretch_mode": PRESTRETCH_MODES,
    "material": load_materials(),
    "second_film": FILMS,
    "second_drive": DRIVES,
}
"""Allowed texts by the last part of a control's name."""
NOT_SHOWN = ("name", "sources", "relative_permittivity_range", "shear_modulus_range", "young_modulus", "material")
WIDER: Mapping[str, float] = {"voltage": 2.0}
"""Factor on the slider's usual upper end (twice the default) for parameters that are interesting beyond it."""
DRIVE, BODY, GEL, START = "Drive", "Body", "Gel", "Start"
STARTS = ("displacement", "velocity")
"""Controls of the start of a model."""
ADDED = ("periods",)
"""Controls that a page adds to those of a subject."""
NONE = "none"
"""Choice for a part that the device does not have; choosing it again removes the part."""


@dataclass(frozen=True)
class Control:
    """One control of a page.

    ``kind`` is ``number`` or ``choice``. A number has a start ``value`` (None: automatic) and a slider from ``low`` to
    ``high``, in ``unit`` (empty: dimensionless); ``powers`` gives the power of ten of each unit that may be typed. A
    choice is one of ``choices``.
    """

    name: str
    label: str
    group: str
    kind: str
    value: float | str | None
    about: str = ""
    unit: str = ""
    low: float = 0.0
    high: float = 1.0
    choices: tuple[str, ...] = ()
    powers: Mapping[str, int] = field(default_factory=dict)


def controls_of(subject: Subject) -> list[Control]:
    """The controls of a device, in its display units, or of a model's parameters."""
    return _of_device(subject.device) if subject.device is not None else _of_model(subject)


def leaf(name: str) -> str:
    """The last part of a dotted name."""
    return name.rpartition(".")[2]


def is_name(name: str) -> bool:
    """Whether a name is that of a control of a page: a field of devices or of their parts, a parameter of models, or
    one that a page adds."""
    whole, _, part = name.partition(".")
    if part.isidentifier():
        return whole in (*PARTS, "material")
    return name in {*Device.fields, *CHOICES, *PARAMETERS, *STARTS, *ADDED}


def as_json(controls: Iterable[Control]) -> list[dict[str, Any]]:
    """The controls as plain data."""
    return [asdict(control) for control in controls]


# --- the model's parameters ------------------------------------------------------------------------------------------


def _of_model(subject: Subject) -> list[Control]:
    model, system = subject.model, subject.model.system
    parts = {DRIVE: (system.waveform, system.circuit), BODY: (system.bias,), GEL: (system.film,)}
    group_of = {name: group for group, components in parts.items() for part in components for name in part.parameters}
    controls = [
        _of_quantity(name, quantity, float(model.values[name]), group_of.get(name, BODY))
        for name, quantity in system.parameters.items()
        if name in model.values
    ]
    law = None if model.law is None else model.law.name
    kinds = {
        "waveform": (system.waveform.name, DRIVE),
        "circuit": (system.circuit.name, DRIVE),
        "bias": (bias_record(system.bias), BODY),
        "film": (system.film.name, GEL),
        "law": (law, GEL),
        "prestretch_mode": (model.prestretch_mode, GEL),
    }
    controls += [
        _choice(name, value, group, CHOICES[name]) for name, (value, group) in kinds.items() if value is not None
    ]
    start = zip(STARTS, subject.initial, strict=False)
    controls += [
        Control(name, _label(name), START, "number", value, "at time 0", "", -2.0, 2.0) for name, value in start
    ]
    return _in_groups(controls)


def _of_quantity(name: str, quantity: Quantity, value: float, group: str) -> Control:
    low, high = _range(value, WIDER.get(name, 1.0) * quantity.default)
    if quantity.positive:
        low = high / 200.0
    elif quantity.lower > -math.inf:
        low = max(low, quantity.lower)
    return Control(name, _label(name), group, "number", value, quantity.meaning, "", low, high)


def _range(value: float, default: float) -> tuple[float, float]:
    """The slider's ends: from 0 if value or default is positive, else symmetric about 0; to a round number above twice
    the larger of the two."""
    size = max(abs(number) if math.isfinite(number) else 0.0 for number in (value, default))
    high = _round_up(2.0 * size) if size else 1.0
    return (0.0 if value > 0.0 or default > 0.0 else -high), high


def _round_up(value: float) -> float:
    """The next of 1, 2, 2.5, 4, 5, 8 or 10 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(float(f"{step * power:.6g}") for step in (1.0, 2.0, 2.5, 4.0, 5.0, 8.0, 10.0) if step * power >= value)


# --- a device's fields -----------------------------------------------------------------------------------------------


def _of_device(device: Device) -> list[Control]:
    defaults = _of_components(device) | _of_second(device)
    values = {
        name: defaults.get(name) if (value := device.get(name)) is None else value for name in device.all_fields()
    }
    values = {name: value for name, value in values.items() if value is not None and name != "material"}
    shown = _shown_anyway(device) | values
    controls = []
    for name, about in device.all_fields().items():
        last = leaf(name)
        if last in NOT_SHOWN or name not in shown:
            continue
        value = values.get(name)
        if last in CHOICES:
            controls.append(_choice(name, shown[name], _group(name), CHOICES[last], about.meaning))
        elif about.unit:
            # a field of 0 has no size of its own: the radius or the drive's amplitude sets its range
            usual = shown[name] or {"m": device.film_radius, "V": device.voltage_amplitude}.get(about.unit, 0.0)
            controls.append(_of_field(name, about, value, usual, shown[name]))
    creeps = isinstance(component_of("film", device.film), BranchedFilm)
    gels = [name for name, gel in load_materials().items() if creeps or not gel.branches]
    controls.append(_choice("material", device.material.name, GEL, gels))
    return _in_groups(controls)


def _shown_anyway(device: Device) -> dict[str, Any]:
    """Fields shown even if unset, with the values that then apply."""
    height, strength = device.initial_state()[0] * device.scales.length, device.material.dielectric_strength
    return {"release_height": height} | ({} if strength is None else {"dielectric_strength": strength})


def _of_second(device: Device) -> dict[str, Any]:
    """Defaults of a second film's unset fields, or the choice `NONE` without a second film."""
    if device.second_film is None:
        return {"second_film": NONE}
    defaults: dict[str, Any] = {"second_flat_height": 0.0, "second_drive": "same"}
    return defaults | ({"second_voltage": 0.0} if device.second_drive == "constant" else {})


def _of_components(device: Device) -> dict[str, float]:
    """Default parameters of components, in SI units."""
    defaults = {}
    for part in PARTS:
        component = getattr(device, part)
        fields = own_fields(part, component)
        for name, quantity in component_of(part, component).parameters.items() if fields else ():
            defaults[f"{part}.{name}"] = float(quantity.default / device.scales.dimensionless(quantity.scale, 1.0))
    return defaults


def _of_field(name: str, about: Field, value: Any, usual: float, start: float) -> Control:
    unit, powers = _display_unit(usual, about.unit), DIMENSIONS[about.unit].powers
    scale = 10.0 ** powers[unit]

    def shown(number: float) -> float:
        return float(f"{number / scale:.12g}")

    low, high = _range(shown(usual), 0.0)
    low = low if start else -high
    if about.least is not None:
        low = max(low, shown(about.least))
    if about.above is not None:
        low = max(low, high / 50.0) if about.above == 0.0 else low
    displayed = None if value is None else shown(float(value))
    return Control(name, _label(name), _group(name), "number", displayed, about.meaning, unit, low, high, powers=powers)


def _display_unit(value: float, unit: str) -> str:
    """The unit that `format_si` chooses for a value; empty for a pure number."""
    if unit == "1":
        return ""
    text = format_si(value, unit) if math.isfinite(value) else ""
    return text.partition(" ")[2] or unit


def _group(name: str) -> str:
    first, last = name.partition(".")[0], leaf(name)
    if first in ("waveform", "circuit", "second_drive", "second_voltage", *ELECTRIC) or last.startswith(
        ("voltage", "frequency")
    ):
        return DRIVE
    if first in ("material", "film") or "stretch" in last or last == "dielectric_strength":
        return GEL
    return START if last.startswith("release") else BODY


# --- both ------------------------------------------------------------------------------------------------------------


def _choice(name: str, value: Any, group: str, choices: Iterable[str], about: str = "") -> Control:
    names = tuple(choices)
    if not isinstance(value, str):  # a component with data: its name alone is that of one with the default ones
        value = f"{value.name}, of the file"
    names = names if value in names else (value, *names)
    return Control(name, _label(name), group, "choice", value, about, choices=names)


def _label(name: str) -> str:
    text = leaf(name).replace("_", " ")
    return text[:1].upper() + text[1:]


def _in_groups(controls: list[Control]) -> list[Control]:
    """The controls sorted by group, without choices that have one entry."""
    order = (DRIVE, BODY, GEL, START)
    kept = [c for c in controls if c.kind == "number" or len(c.choices) > 1]
    return sorted(kept, key=lambda c: order.index(c.group))
