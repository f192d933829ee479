"""Figures of device tests: how well they determine each unknown, and the fit to them."""

from __future__ import annotations

import itertools
import json
from typing import TYPE_CHECKING

import numpy as np

from gelcone.plots.style import BLACK, BLUE, CYCLE, GREY, VERMILION, styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

COLUMNS = 2


def device_plan_figure(result: xr.Dataset) -> Figure:
    """Bars: the standard deviation that the tests leave of each unknown, over its prior."""

    def draw(figure: Figure) -> None:
        left_bars(result, figure.subplots())
        figure.suptitle(result.attrs["title"], fontsize=9.0)

    return styled(6.0, 1.2 + 0.22 * result.sizes["unknown"], draw)


def device_fit_figure(result: xr.Dataset) -> Figure:
    """A panel for each test with measured and fitted readings, and bars of the standard deviations left."""
    names = json.loads(result.attrs["tests"])
    rows = -(-(len(names) + 1) // COLUMNS)

    def draw(figure: Figure) -> None:
        panels = figure.subplots(rows, COLUMNS, squeeze=False).ravel()
        for k, (name, axes) in enumerate(zip(names, panels, strict=False)):
            draw_test(result.isel(reading=np.flatnonzero(result["reading_test"].values == k)), name, axes)
        left_bars(result, panels[len(names)])
        for axes in panels[len(names) + 1 :]:
            axes.set_visible(False)
        mark = ": refused by chi2, not to be relied on" if result.attrs["refused"] else ""
        figure.suptitle(f"{result.attrs['title']}, {result.attrs['chosen']}{mark}", fontsize=9.0)

    return styled(7.4, 0.6 + 2.3 * rows, draw)


def draw_test(own: xr.Dataset, name: str, axes: Axes) -> None:
    """Measured readings with their noise, and the fitted device as lines; a single row as shares of fitted readings."""
    if len(np.unique(own["reading_along"])) == 1:
        draw_row(own, name, axes)
        return
    kinds = list(dict.fromkeys(map(str, own["reading_name"].values)))
    for colour, kind in zip(CYCLE, kinds, strict=False):
        one = own.isel(reading=np.flatnonzero(own["reading_name"].values == kind))
        x = one["reading_along"].values
        noise, label = one["noise"].values, kind.replace("_", " ")
        axes.errorbar(x, one["measured"].values, noise, color=colour, fmt=".", ms=4.0, lw=0.6, label=label)
        for part in _rising(x):
            axes.plot(x[part], one["predicted"].values[part], color=colour)
    axes.set_title(name, fontsize=8.0)
    axes.legend(fontsize=7.0)
    axes.tick_params(labelsize=7.0)
    units = dict.fromkeys(map(str, own["reading_unit"].values))
    along, _, unit = str(own["reading_axis"].values[0]).rstrip(")").partition(" (")
    in_prefixes(axes.xaxis, along, unit)
    in_prefixes(axes.yaxis, "", ", ".join(units))


def in_prefixes(axis: Axis, name: str, unit: str) -> None:
    """Labels an axis of SI numbers; lengths, forces, voltages and capacitances have ticks such as 0.2 mm."""
    from matplotlib.ticker import EngFormatter

    if unit in ("m", "N", "V", "F"):
        axis.set_major_formatter(EngFormatter(unit))
    else:
        name = f"{name} ({unit})" if name and unit else name or unit
    axis.set_label_text(name, fontsize=7.0)


def draw_row(own: xr.Dataset, name: str, axes: Axes) -> None:
    """Readings of different units, each over its fitted value."""
    fitted, places = own["predicted"].values, np.arange(own.sizes["reading"])
    share, noise = own["measured"].values / fitted, own["noise"].values / np.abs(fitted)
    axes.errorbar(places, share, noise, color=BLUE, fmt=".", ms=4.0, lw=0.6)
    axes.axhline(1.0, color=BLUE)
    shown = zip(own["reading_name"].values, own["measured"].values, own["reading_unit"].values, strict=True)
    axes.set_xticks(places, [f"{str(read).replace('_', ' ')}\n{value:.4g} {unit}" for read, value, unit in shown])
    axes.set_xlim(-0.6, places[-1] + 0.6)
    axes.set_title(name, fontsize=8.0)
    axes.tick_params(labelsize=7.0)
    axes.set_ylabel("measured over fitted", fontsize=7.0)


def _rising(x: np.ndarray) -> list[slice]:
    """Ranges of samples along which x rises: one curve for each voltage at which heights were measured."""
    ends = [0, *(np.flatnonzero(np.diff(x) < 0.0) + 1), len(x)]
    return [slice(begin, end) for begin, end in itertools.pairwise(ends)]


def left_bars(result: xr.Dataset, axes: Axes) -> None:
    """Standard deviation left by the tests over that of the prior, for each unknown."""
    names = [str(name).removeprefix("material.") for name in result["unknown"].values]
    share = (result["posterior"] / result["prior"]).values
    places = np.arange(len(names))[::-1]
    axes.barh(places, share, color=[BLUE if one < 0.5 else GREY for one in share], height=0.6)
    axes.plot(share, places, ".", color=BLACK, ms=3.0)
    axes.axvline(1.0, color=BLACK, lw=0.6)
    axes.set_yticks(places, names, fontsize=6.5)
    axes.set_xlabel("standard deviation left, over the prior", fontsize=7.0)
    axes.tick_params(axis="x", labelsize=7.0)
    for place, moved, prior in zip(places, result["deviation"].values, result["prior"].values, strict=True):
        if abs(moved) > 2.0 * prior:
            axes.text(0.02, place, "far from its prior", color=VERMILION, fontsize=6.0, va="center")
