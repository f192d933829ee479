"""The HTML of a device in a notebook: its cone, and its fields with their units."""

from __future__ import annotations

from typing import Any

import numpy as np

from gelcone import markup
from gelcone.devices.fields import GEL, DeviceFields
from gelcone.devices.record import Field
from gelcone.devices.units import format_range, format_si


def device_html(device: DeviceFields) -> str:
    """Return the drawing and the table of a device; of an ensemble the drawing is that of its means."""
    rows = [("material", str(device.material.name), "the gel")]
    skipped = {"name", "material", f"{GEL}name"}
    for name, field in device.all_fields().items():
        value = device.get(name)
        left_out = value is None or name in skipped or name.endswith(("_range", "sources"))
        if not left_out and (field.required or np.any(value != field.default)):
            rows.append((name, _with_unit(field, value), field.meaning))

    def mean(name: str) -> float:
        value = device.get(name)
        return 0.0 if value is None else float(np.mean(value))

    a, b, free = mean("disc_radius"), mean("film_radius"), mean("initial_height")
    second = None if device.second_film is None else mean("second_flat_height")
    held = mean("spring_rate") == 0.0 and second is not None  # by the films alone
    height = 0.5 * (second or 0.0) if held else free
    labels = [f"a = {format_si(a, 'm')}", f"b = {format_si(b, 'm')}", "" if held else f"h0 = {format_si(free, 'm')}"]
    drawing = markup.cone(a / b, height / b, labels, None if second is None else second / b)
    return markup.shown(str(device.name), drawing, rows)


def _with_unit(field: Field, value: Any) -> str:
    """A value with its unit as text; of an ensemble the range and the count."""
    if not field.unit or isinstance(value, str):
        return str(getattr(value, "name", None) or value)
    text = format_range(float(np.min(value)), float(np.max(value)), field.unit)
    return text if np.ndim(value) == 0 else f"{text} ({np.size(value)})"
