"""Style shared by all figures: print size, a palette for colour-blind readers, atomic saving."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from gelcone.files import write_whole

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

# Okabe and Ito's palette (2008), which stays distinct for all common kinds of colour blindness.
BLUE, ORANGE, GREEN, VERMILION = "#0072B2", "#E69F00", "#009E73", "#D55E00"
PURPLE, SKY, YELLOW, BLACK, GREY = "#CC79A7", "#56B4E9", "#F0E442", "#000000", "#888888"
CRIMSON = "#9E0142"
"""Colour of chaos that ends: a dark red next to chaos's vermilion."""
CYCLE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)
UNHELD = 0.3
"""Opacity of lines where the model does not hold."""
UNHELD_LABEL = "faint: the model does not hold"

STYLE: Any = {
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.labelsize": 9.0,
    "legend.fontsize": 8.0,
    "legend.frameon": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 1.0,
    "svg.hashsalt": "gelcone",
    "figure.dpi": 200.0,
    "figure.constrained_layout.use": True,
}


_HASHED = re.compile(r'id="([a-z][0-9a-f]{10})"')


REST_ROOM = 1e-6
"""Motions smaller than this are drawn as a rest, not magnified."""


def shade(colour: str, share: float) -> str:
    """A colour mixed with white (``share`` above 0) or black (below 0)."""
    from matplotlib.colors import to_hex, to_rgb

    other = 1.0 if share > 0.0 else 0.0
    red, green, blue = ((1.0 - abs(share)) * part + abs(share) * other for part in to_rgb(colour))
    return to_hex((red, green, blue))


def say(axes: Axes, words: str) -> None:
    """Writes words in place of a curve."""
    axes.text(0.5, 0.5, words, transform=axes.transAxes, ha="center", va="center", color=GREY)


def name_faint(axes: Axes, fails: Any) -> None:
    """Names the faint lines in the legend, once, if the model ``fails`` (a mask) anywhere."""
    if np.any(fails) and UNHELD_LABEL not in axes.get_legend_handles_labels()[1]:
        axes.plot([], [], color=BLACK, alpha=UNHELD, label=UNHELD_LABEL)


def styled(
    width: float, height: float, draw: Callable[[Figure], None], result: xr.Dataset | None = None, more: str = ""
) -> Figure:
    """A figure of the given size in inches, drawn in gelcone's style and outside pyplot's global state; titled with the
    device of ``result`` and ``more``, if given."""
    import matplotlib as mpl

    from gelcone.plots.figure import ShownFigure

    with mpl.rc_context(STYLE):
        figure = ShownFigure(STYLE, figsize=(width, height), layout="constrained")
        draw(figure)
        if result is not None:
            figure.suptitle(", ".join(filter(None, [result.attrs.get("device", ""), more])), fontsize=9.0)
    return figure


def save_figure(figure: Figure, path: str | Path, *, force: bool = False) -> None:
    """Writes a figure (PNG, SVG or PDF by its suffix): the same bytes for the same figure, whole or not at all."""
    write_whole(Path(path), lambda to: draw_file(figure, to), force=force)


def draw_file(figure: Figure, path: Path) -> None:
    """Writes a figure to ``path``, for `save_figure`.

    PNG and SVG use their own canvases, as ``Figure.savefig`` draws each figure twice.
    """
    import matplotlib as mpl

    with mpl.rc_context(STYLE):
        if path.suffix == ".png":
            from matplotlib.backends.backend_agg import FigureCanvasAgg

            cast(Any, FigureCanvasAgg(figure)).print_png(path)
        elif path.suffix == ".svg":
            from matplotlib.backends.backend_svg import FigureCanvasSVG

            cast(Any, FigureCanvasSVG(figure)).print_svg(path, metadata={"Date": None})
            path.write_text(numbered(path.read_text(encoding="utf-8")), encoding="utf-8")
        else:
            figure.savefig(path, metadata={"CreationDate": None} if path.suffix == ".pdf" else None)


def numbered(svg: str) -> str:
    """An SVG with numbers in place of hashed names, which depend on the last bits of the layout."""
    numbers = {name: f"n{k}" for k, name in enumerate(dict.fromkeys(_HASHED.findall(svg)))}
    return re.sub(r'(id="|#)(\w+)', lambda match: match[1] + numbers.get(match[2], match[2]), svg)


def axis_label(variable: xr.DataArray, name: str) -> str:
    """``name`` in words, with the variable's unit, if it has one."""
    name, units = name.replace("_", " "), variable.attrs.get("units", "1")
    return name if units == "1" else f"{name} ({units})"


def name_axes(axes: Axes, across: xr.DataArray, up: xr.DataArray, x: str = "", y: str = "") -> None:
    """Labels both axes with their variables, by name unless another is given."""
    axes.set_xlabel(axis_label(across, x or str(across.name)))
    axes.set_ylabel(axis_label(up, y or str(up.name)))


def second_axes(axes: Axes, left: xr.DataArray, name: str, right: xr.DataArray, other_name: str) -> Axes:
    """Axes on the right for a second, dashed curve; both labels have the colour of their curve."""
    other = axes.twinx()
    axes.set_ylabel(axis_label(left, name), color=BLUE)
    other.set_ylabel(axis_label(right, other_name), color=VERMILION)
    other.spines["right"].set_visible(True)
    return other


def log_ticks(axes: Axes) -> None:
    """Sets a log scale with plain numbers along the bottom, for values that span a decade or two."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())


def coordinate_axis(axis: Axis, result: xr.Dataset, name: str) -> None:
    """Labels an axis with a swept coordinate, if the result has it."""
    if name in result.coords:
        axis.set_label_text(axis_label(result[name], name))
