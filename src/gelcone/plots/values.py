"""Figure of results without one of their own: numbers over a shared axis, and single numbers as bars or text."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import measured, missing, sized, unit_of
from gelcone.plots.style import BLUE, CYCLE, GREY, axis_label, styled
from gelcone.words import VARIED

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_PANELS = 8
MOST_CURVES = 6
LABEL_WIDTH = 20
"""Most letters per line of a label, so that it fits the height of a panel."""
STEM_DISTANCE = 0.1
"""Offset between the stems of two members at one harmonic."""
BAR_HEIGHT = 0.32
"""Inches from one bar to the next."""
FAR = 3.0
"""Ratio to the next shorter bar from which on bars leave the axis."""
WIDTHS = ("error", "step")
"""Words in the names of numbers that are widths of others and have no bars."""
BAR_LABEL = 44
"""Most letters per line of the name of a bar."""
LINE_WIDTH = 80
"""Most letters per line of text, so that it fits the figure."""
MOST_NUMBERS = 6
"""Most values of a variable that are written out."""


def values_figure(result: xr.Dataset) -> Figure:
    """A panel for each number that varies along the first axis of the result, or else all numbers that have a value: as
    bars where all have one unit, else as text.

    Numbers that are constant along the axis have panels only if all are constant.
    """
    numbers = {str(name): v for name, v in result.data_vars.items() if is_number(v)}
    axes_there = (axis_of(result, str(dim)) for v in numbers.values() for dim in v.dims)
    axis = next((one for one in axes_there if one is not None), None)
    along = None if axis is None else str(axis.dims[0])
    curves = {name: v for name, v in numbers.items() if along in v.dims and np.isfinite(v).any()}
    varying = [name for name, v in curves.items() if bool((v.max(along) > v.min(along)).any())]
    shown = (varying or list(curves))[:MOST_PANELS]
    known = {name: v for name, v in numbers.items() if np.isfinite(v).any()} or numbers
    bars = {name: v for name, v in known.items() if not set(name.split("_")) & set(WIDTHS)}
    if axis is None and are_bars(bars):
        return styled(6.4, 0.9 + BAR_HEIGHT * len(bars), lambda figure: draw_bars(result, bars, figure))
    texts = [
        "\n  ".join(textwrap.wrap(number_text(v, name), LINE_WIDTH, break_on_hyphens=False))
        for name, v in known.items()
    ]
    height = 0.25 * len(texts) + 0.13 * "".join(texts).count("\n") if axis is None else 1.4 * len(shown)

    def draw(figure: Figure) -> None:
        figure.suptitle(_title(result), fontsize=9.0)
        if axis is None:
            write_lines(texts, figure.add_subplot())
            return
        panels = figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
        for axes, name in zip(panels, shown, strict=True):
            draw_curves(curves[name], axis, axes)
        panels[-1].set_xlabel(axis_label(axis, str(axis.name)))

    return styled(5.6, 0.8 + height, draw)


def _title(result: xr.Dataset) -> str:
    return str(result.attrs.get("device", result.attrs.get("title", "")))


def are_bars(numbers: Mapping[str, xr.DataArray]) -> bool:
    """Whether numbers are bars of one axis: two or more single ones, all of one unit."""
    units = {unit_of(v) for v in numbers.values()}
    single = all(not v.dims and np.isfinite(v) for v in numbers.values())
    return single and len(numbers) > 1 and len(units) == 1 and "" not in units


def draw_bars(result: xr.Dataset, numbers: Mapping[str, xr.DataArray], figure: Figure) -> None:
    """A bar for each number, named by its meaning, with the number at its end."""
    figure.suptitle(_title(result), fontsize=9.0)
    axes = figure.add_subplot()
    values = [float(v) for v in numbers.values()]
    names = [textwrap.fill(str(v.attrs.get("long_name", name)), BAR_LABEL) for name, v in numbers.items()]
    end = end_of_bars(values)
    bars = axes.barh(range(len(names)), np.minimum(values, end), color=BLUE, height=0.5)
    texts = [sized(v) + (" →" if float(v) > end else "") for v in numbers.values()]
    axes.bar_label(bars, texts, fontsize=7.0, padding=3.0)
    axes.set_yticks(range(len(names)), names, fontsize=7.0)
    axes.invert_yaxis()
    axes.margins(x=0.2)
    quantity = next(iter(numbers.values())).attrs.get("quantity", "value")
    axes.set_xlabel(f"{quantity} ({unit_of(next(iter(numbers.values()))).strip()})")


def end_of_bars(values: Sequence[float]) -> float:
    """The longest bar within the axis: the last before the first step by `FAR` above the shorter half."""
    ordered = np.sort(values)
    far = np.flatnonzero(ordered[1:] > FAR * ordered[:-1]) + 1
    far = far[2 * far > ordered.size]
    return float(ordered[far[0] - 1] if far.size else ordered[-1])


def is_number(variable: xr.DataArray) -> bool:
    """Whether a variable holds numbers to draw: neither codes nor the initial state."""
    return variable.dtype.kind in "fiu" and "flag_values" not in variable.attrs and variable.name != "initial"


def axis_of(result: xr.Dataset, dim: str) -> xr.DataArray | None:
    """The axis of a dim: its coordinate, or the parameter that varies along it; None without either."""
    if dim in result.coords:
        return result[dim] if result[dim].dtype.kind in "fiu" else None
    along = (c for c in result.coords.values() if c.dims == (dim,) and c.attrs.get("quantity") in VARIED)
    return next((c for c in along if c.dtype.kind in "fiu" and np.ptp(c.values) > 0.0), None)


def draw_curves(variable: xr.DataArray, axis: xr.DataArray, axes: Axes) -> None:
    """One variable over the axis, a curve for each of its first entries along other dims."""
    from matplotlib.ticker import MaxNLocator

    along = str(axis.dims[0])
    rows = variable.transpose(along, ...).values.reshape(variable.sizes[along], -1)[:, :MOST_CURVES]
    counted = axis.dtype.kind in "iu"  # such as harmonics: no line joins them
    names = curve_names(variable, along)
    for i, (colour, row, name) in enumerate(zip(CYCLE, rows.T, names, strict=False)):
        at = axis.values + (STEM_DISTANCE * (i - 0.5 * (rows.shape[1] - 1)) if counted else 0.0)
        axes.plot(at, row, color=colour, marker=".", ms=3.0, ls="none" if counted else "-", label=name)
        if counted:
            axes.vlines(at, 0.0, row, color=colour)
    if rows.shape[1] > 1 and any(names):
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=7.0)
    if counted:
        axes.axhline(0.0, color=GREY, lw=0.5)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_ylabel("\n".join(textwrap.wrap(axis_label(variable, str(variable.name)), LABEL_WIDTH)))


def curve_names(variable: xr.DataArray, along: str) -> list[str]:
    """The label of each curve over ``along``: its entry along the other dims, such as a harmonic or device fields."""
    others = [str(dim) for dim in variable.dims if dim != along]
    if not others:
        return [""]
    entries = variable.isel({along: 0}).stack(curve=others)
    coordinates = {str(n): c for n, c in variable.coords.items() if along not in c.dims and c.dims}
    named = [n for n, c in coordinates.items() if n in others or c.attrs.get("quantity") in VARIED]
    return [", ".join(f"{n} {measured(entry[n])}" for n in named) for entry in entries.transpose("curve", ...)]


def number_text(variable: xr.DataArray, name: str) -> str:
    """Meaning, first values and unit of a number."""
    values = variable.values.ravel()[:MOST_NUMBERS].astype(float)
    named = [f"{value:.5g}" if np.isfinite(value) else missing(value, variable) for value in values]
    unit = unit_of(variable) if np.isfinite(values).any() else ""
    return f"{variable.attrs.get('long_name', name)}: {', '.join(named)}{unit}"


def write_lines(texts: list[str], axes: Axes) -> None:
    """Writes texts below one another, spaced by their number of lines."""
    axes.set_axis_off()
    ends = np.cumsum([2.0 + text.count("\n") for text in texts])
    for text, end in zip(texts, ends, strict=True):
        middle = end - 0.5 * (2.0 + text.count("\n"))
        axes.text(0.0, 1.0 - middle / ends[-1], text, transform=axes.transAxes, va="center")
