"""The footnote of every figure: the parameters that all of its data share."""

from __future__ import annotations

import json
import textwrap
from typing import TYPE_CHECKING, Any

from gelcone.devices.numbers import numbers_of
from gelcone.devices.si import device_of
from gelcone.devices.template import fields_in_words
from gelcone.plots.style import GREY

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

LETTERS_AN_INCH = 19
"""Letters of the footnote per inch of figure width."""
LONGEST_NAME = 20
"""Longest name of a component in letters; longer texts are descriptions, and left out."""
TIED = "\N{NO-BREAK SPACE}"
TERMS = "terms: gelcone help glossary"
LINE = 0.115
"""Line height in inches."""


def fixed_parameters(result: xr.Dataset) -> str:
    """The numbers that are constant over a result, and the components other than the default ones."""
    attrs = result.attrs
    if "model" not in attrs:
        return ""
    swept = {*map(str, result.coords), *map(str, result.dims), attrs.get("parameter", "")}
    swept |= set(str(attrs.get("parameters", "")).split(","))
    swept |= {name.removeprefix("drawn_") for name in swept}
    if (device := device_of(result)) is not None:
        swept |= {number.field for name, number in numbers_of(device).items() if name in swept}
        film = [f"film {device.film}"] if "film" not in swept and isinstance(device.film, str) else []
        return "fixed: " + ", ".join([*fields_in_words(device, swept), *film])
    usual = {"prestretch_mode": "radial", "law": "gent", "film": "taut", "bias": "spring"}
    usual |= {"waveform": "sine", "circuit": "ideal"}
    parts = []
    for name, value in json.loads(attrs["model"]).items():
        if name in swept or usual.get(name) == value:
            continue
        if isinstance(value, dict):  # a component with data
            value = value["component"]
        if isinstance(value, int | float):
            parts.append(f"{name.replace('_', ' ')} {value:.4g}")
        elif isinstance(value, str) and len(value) < LONGEST_NAME:
            parts.append(f"{name.replace('_', ' ')} {value}")
    return "fixed (dimensionless): " + ", ".join(parts) if parts else ""


def add_footnote(figure: Figure, text: str) -> None:
    """Writes the footnote below a figure, which grows by its height; it ends with where the terms are explained."""
    text = f"{text}. {TERMS}" if text else TERMS
    width, height = figure.get_size_inches()
    tied = text.replace(" ", TIED).replace(f",{TIED}", ", ")  # names stay with their values and units
    lines = [line.replace(TIED, " ") for line in textwrap.wrap(tied, int(LETTERS_AN_INCH * width))]
    room = LINE * len(lines) + 0.06
    figure.set_size_inches(width, height + room)
    share = room / (height + room)
    engine: Any = figure.get_layout_engine()
    engine.set(rect=(0.0, share, 1.0, 1.0 - share))
    for legend in figure.legends:
        legend_box: Any = legend
        if legend_box._outside_loc == "lower":  # a legend outside stays at the figure's edge, not at the layout's
            legend_box.borderaxespad += 72.0 * room / legend_box.prop.get_size_in_points()
    figure.text(0.01, 0.04 / (height + room), "\n".join(lines), fontsize=6.0, color=GREY, va="bottom", linespacing=1.1)
