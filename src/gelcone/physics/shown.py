"""The HTML of a model in a notebook: its cone, its components and its parameters."""

from __future__ import annotations

from typing import Any

import numpy as np

from gelcone import markup
from gelcone.physics.members import Ensemble

INNER = 0.2
"""Radius of the disc over that of the rim in the drawing of a model without a ratio."""


def model_html(model: Ensemble) -> str:
    """Return the drawing, with the height at which the bias is free, and the table; of an ensemble its means."""
    system, values = model.system, model.values
    kinds = {"film": system.film, "law": getattr(system.film, "law", None), "bias": system.bias}
    kinds |= {"waveform": system.waveform, "circuit": system.circuit}
    rows = [(kind, str(part.name), "") for kind, part in kinds.items() if part is not None]
    for name, quantity in system.parameters.items():
        if name in values:
            rows.append((name, _text(values[name]), quantity.meaning))
    inner = float(np.mean(values.get("radius_ratio", INNER)))
    free = float(np.mean(values.get("rest_height", 0.0)))
    second = float(np.mean(values["second_flat_height"])) * (1.0 - inner) if "second_flat_height" in values else None
    labels = ["a", "b", f"x0 = {free:.4g}"]
    return markup.shown("ConeModel", markup.cone(inner, free * (1.0 - inner), labels, second), rows)


def _text(value: Any) -> str:
    """A number as text; of an ensemble the range and the count."""
    values = np.asarray(value)
    return f"{float(values):.6g}" if values.ndim == 0 else f"{values.min():.6g} to {values.max():.6g} ({values.size})"
