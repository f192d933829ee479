"""The fields of a device: meaning, unit and bounds, read from its class."""

from __future__ import annotations

import inspect
from dataclasses import dataclass
from functools import cache
from typing import Any

from gelcone.devices.device import Device
from gelcone.devices.materials import Material


@dataclass(frozen=True)
class Field:
    meaning: str
    unit: str
    above: float | None
    least: float | None


@cache
def device_fields() -> dict[str, Field]:
    """All fields by name, those of the material behind ``material.``; ``unit`` is empty for a text."""
    own = {name: _field(info) for name, info in Device.model_fields.items() if name != "material"}
    return own | {f"material.{name}": _field(info) for name, info in Material.model_fields.items()}


def _field(info: Any) -> Field:
    unit, bounds = "", dict[str, Any]()
    for part in info.metadata:
        known = inspect.getclosurevars(part.func).nonlocals if hasattr(part, "func") else {}
        unit, bounds = known.get("unit", unit), known.get("bounds", bounds)
    return Field(info.description or "", unit, bounds.get("above"), bounds.get("least"))
