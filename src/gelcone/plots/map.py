"""Figures of two-parameter maps: the largest exponent and the regime side by side."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.amounts import rate_unit
from gelcone.atlas.maps import ALSO
from gelcone.codes import Regime
from gelcone.errors import InputError, check_name
from gelcone.plots.regime import (
    cell_legend,
    edges,
    invalid_cells,
    invalid_legend,
    mark_failed,
    mark_flagged,
    mark_invalid,
    regime_cells,
)
from gelcone.plots.style import GREY, axis_label, coordinate_axis, styled
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh
    from matplotlib.figure import Figure

Lines = Mapping[str, tuple[Any, Any]]
"""Label -> values of the first and the second parameter along a line."""
COLOURS = ("exponent", "stroke", *ALSO)
"""Quantities of the left panel."""
LINE_STYLES = ("-", "--", "-.", ":")


def map_figure(cells: xr.Dataset, lines: Lines | None = None, colour: str = "exponent") -> Figure:
    """Largest exponent, or another number, next to the regime over two parameters, the first along x.

    ``lines`` are drawn over both, for example where rest loses stability; ``colour`` is ``"exponent"``, ``"stroke"``,
    or one of the numbers that the map was computed with by ``also``: ``"power"`` or ``"margin"``.
    """
    check_name("colour", colour, COLOURS)
    if colour in ALSO and colour not in cells:
        raise InputError(f"colour = {colour}: the map does not hold it; compute it with also = {colour!r}")
    from matplotlib.patches import Patch

    axes_names(cells)

    def draw(figure: Figure) -> None:
        left, right = figure.subplots(1, 2, sharex=True, sharey=True)
        if colour == "stroke":
            stroke = (cells["highest"] - cells["lowest"]).assign_attrs(cells["highest"].attrs)
            number_map(cells, stroke, "stroke, peak to peak", left)
        elif colour in ALSO:
            number_map(cells, cells[colour], _TITLES[colour], left)
        else:
            exponent_bar(exponent_map(cells, left), left, figure)
        regime_map(cells, right)
        right.set_ylabel("")
        for axes in (left, right):
            overlay(lines or {}, axes)
        handles = legend(cells) + right.get_legend_handles_labels()[0]
        if "status" in cells and not cells["status"].all():
            handles.append(Patch(facecolor="white", edgecolor=GREY, lw=0.6, label="not computed yet"))
        right.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.0, 1.0))

    return styled(7.2, 2.9, draw, cells)


def axes_names(cells: xr.Dataset) -> tuple[str, str]:
    """The parameters along x and y; `InputError` unless there are two."""
    names = [str(dim) for dim in cells["regime"].dims]
    if len(names) != 2:
        raise InputError(f"a map has two parameters, not {len(names)}; draw one with bifurcation_figure")
    return names[0], names[1]


def marks(cells: xr.Dataset) -> tuple[Any, Any, Any]:
    """Regimes, failed cells and cells whose evidence disagrees, each (y, x)."""
    turned = cells.transpose(*axes_names(cells)[::-1], ...)
    failed = turned["outcome"].values > 0
    return turned["regime"].values, failed, (turned["doubtful"].values > 0) & ~failed


def legend(cells: xr.Dataset, settled: Any = True) -> list[Any]:
    """Handles of the regimes and marks that occur: doubt about what has ``settled`` alone."""
    regime, failed, flagged = marks(cells)
    handles = cell_legend(regime, failed, flagged & settled, cells["outcome"])
    return handles + invalid_legend(invalid_cells(cells, *reversed(axes_names(cells))), failed)


def borders_of(cells: xr.Dataset) -> tuple[Array, Array]:
    """Borders of the cells along x and y."""
    x, y = axes_names(cells)
    return edges(cells[x]), edges(cells[y])


def mark_cells(cells: xr.Dataset, axes: Axes, shown: Any = True) -> None:
    """Greys cells where the model does not hold, hatches failed ones, dots doubtful ones that are ``shown``; names the
    axes."""
    (x, y), borders = axes_names(cells), borders_of(cells)
    _, failed, flagged = marks(cells)
    mark_invalid(axes, *borders, invalid_cells(cells, y, x))
    mark_failed(axes, *borders, failed)
    mark_flagged(axes, *borders, flagged & shown)
    axes.set_xlim(borders[0][0], borders[0][-1])
    axes.set_ylim(borders[1][0], borders[1][-1])
    coordinate_axis(axes.xaxis, cells, x)
    coordinate_axis(axes.yaxis, cells, y)


def coloured(cells: xr.Dataset, values: xr.DataArray, axes: Axes, colours: Any, norm: Any) -> QuadMesh:
    """Cells in the colour of a number, with their marks."""
    number = values.transpose(*reversed(axes_names(cells))).values
    mesh = axes.pcolormesh(*borders_of(cells), number, cmap=colours, norm=norm, rasterized=True)
    mark_cells(cells, axes)
    return mesh


def exponent_map(cells: xr.Dataset, axes: Axes) -> QuadMesh:
    """Largest exponent, blue below zero and red above; failed cells hatched.

    Both signs have the same scale, with the square root of the exponent, so that small exponents such as damping next
    to chaos stay visible.
    """
    from matplotlib import colormaps
    from matplotlib.colors import FuncNorm, ListedColormap

    # without the darkest ends, so that marks and lines stay visible
    colours = ListedColormap(colormaps["RdBu_r"](np.linspace(0.1, 0.9, 256)))
    exponent = cells["lyapunov"].isel(exponent=0)
    bound = largest(exponent) or 1.0
    axes.set_title(f"largest exponent ({rate_unit(cells['lyapunov'])})", loc="left")
    return coloured(cells, exponent, axes, colours, FuncNorm((signed_root, signed_square), -bound, bound))


_TITLES = {"power": "mean power of the source", "margin": "margin to pull-in at constant voltage"}


def number_map(cells: xr.Dataset, values: xr.DataArray, title: str, axes: Axes) -> None:
    """A number of each cell, failed cells hatched: from red to blue if some are negative, otherwise from zero; a power
    by its square root, as it grows with the square of the stroke."""
    from matplotlib.colors import Normalize, PowerNorm

    most, signed = largest(values), bool((values < 0.0).any())
    root = values.attrs.get("quantity") == "power" and not signed
    norm = PowerNorm(0.5, 0.0, most) if root else Normalize(-most if signed else 0.0, most)
    mesh = coloured(cells, values, axes, "RdBu" if signed else "viridis", norm)
    axes.figure.colorbar(mesh, ax=axes, pad=0.02)
    axes.set_title(axis_label(values, title), loc="left")


def largest(values: xr.DataArray) -> float:
    """The largest absolute value; 0 without any."""
    return float(np.abs(values.values[np.isfinite(values.values)]).max(initial=0.0))


def signed_root(values: Any) -> Any:
    """The root of the absolute value, with the sign."""
    return np.sign(values) * np.sqrt(np.abs(values))


def signed_square(values: Any) -> Any:
    """The inverse of `signed_root`."""
    return np.sign(values) * np.square(values)


def exponent_bar(mesh: QuadMesh, axes: Axes, figure: Figure) -> None:
    """The colour bar of an exponent map, cut to the values that occur and zero."""
    bar = figure.colorbar(mesh, ax=axes, pad=0.02)
    values: Array = np.ma.filled(np.ma.asarray(mesh.get_array()), np.nan)
    shown = np.append(values[np.isfinite(values)], 0.0)
    low, high = (shown.min(), shown.max()) if shown.any() else (-1.0, 1.0)
    bound = max(-low, high)
    decade = 10.0 ** np.floor(np.log10(bound))
    amounts = [digit * decade / 10**k for digit in (1, 2, 5) for k in (0, 1)]
    marked = [sign * amount for amount in amounts for sign in (-1, 1) if amount > 0.05 * bound]
    ticks = sorted([0.0, *(tick for tick in marked if low <= tick <= high)])
    bar.ax.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    bar.ax.minorticks_off()
    bar.ax.set_ylim(low, high)


def regime_map(cells: xr.Dataset, axes: Axes) -> None:
    """Regimes; failed cells hatched, doubtful ones dotted unless their colour already means not settled."""
    regime = marks(cells)[0]
    regime_cells(axes, *borders_of(cells), regime)
    mark_cells(cells, axes, regime != Regime.TRANSIENT)
    axes.set_title("regime", loc="left")


def overlay(lines: Lines, axes: Axes) -> None:
    """Lines over the cells, black with a white rim to show on every colour."""
    from matplotlib.patheffects import Normal, Stroke

    for i, (label, (x, y)) in enumerate(lines.items()):
        rim = [Stroke(linewidth=2.6, foreground="white"), Normal()]
        axes.plot(x, y, color="black", lw=1.2, ls=LINE_STYLES[i % len(LINE_STYLES)], label=label, path_effects=rim)
