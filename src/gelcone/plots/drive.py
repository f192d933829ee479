"""Figure of the best drive: the recommended window, two periods of the motion, and the sensitivities."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import measured
from gelcone.plots.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    VERMILION,
    axis_label,
    log_ticks,
    name_axes,
    second_axes,
    styled,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_BARS = 8
"""Most sensitivities drawn, largest first."""


def drive_figure(result: xr.Dataset) -> Figure:
    """The recommended window over frequency with the best drive, its motion, and the sensitivity of the stroke."""

    def draw(figure: Figure) -> None:
        grid = figure.add_gridspec(2, 2, width_ratios=[1.3, 1.0])
        window = figure.add_subplot(grid[0, 0])
        window_curve(result, window)
        value_curve(result, figure.add_subplot(grid[1, 0], sharex=window))
        motion_curves(result, figure.add_subplot(grid[0, 1]))
        sensitivity_bars(result, figure.add_subplot(grid[1, 1]))

    return styled(7.4, 4.8, draw, result)


def window_curve(result: xr.Dataset, axes: Axes) -> None:
    """The recommended peak voltages, the best drive, and the limit above it."""
    frequency, peak = result["frequency"].values, result["window_peak"].values
    axes.fill_between(frequency, 0.0, peak, color=GREEN, alpha=0.18, lw=0, label="recommended window")
    axes.plot(frequency, peak, color=GREEN, lw=1.0)
    place = float(result["drive_frequency"]), float(result["peak_voltage"])
    label = f"best drive, {measured(result['drive_frequency'])}, {measured(result['peak_voltage'])}"
    axes.plot(*place, "*", color=BLACK, ms=9.0, ls="none", label=label, zorder=4)
    limit = float(result["limit_voltage"])
    if np.isfinite(limit):
        axes.plot(place[0], limit, "x", color=VERMILION, ms=6.0, ls="none", label=f"limit: {result.attrs['limit']}")
    log_ticks(axes)
    axes.set_xlim(frequency[0], frequency[-1])
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel(axis_label(result["peak_voltage"], "peak voltage"))
    axes.legend(loc="lower left", fontsize=6.5)


def value_curve(result: xr.Dataset, axes: Axes) -> None:
    """The maximised number along the edge of the window."""
    largest = result.attrs["largest"]
    axes.plot(result["frequency"], result["window_value"], color=BLUE, marker=".", ms=3.0)
    axes.plot(result["drive_frequency"], result[largest], "*", color=BLACK, ms=9.0, ls="none")
    axes.set_ylim(bottom=0.0)
    name_axes(axes, result["frequency"], result["window_value"], "drive frequency", f"{largest} at the window's edge")


def motion_curves(result: xr.Dataset, axes: Axes) -> None:
    """Displacement and voltage over two drive periods."""
    axes.plot(result["time"], result["displacement"], color=BLUE)
    axes.set_xlabel(axis_label(result["time"], "time"))
    axes.set_xlim(0.0, float(result["time"].max()))
    other = second_axes(axes, result["displacement"], "displacement", result["drive_voltage"], "voltage")
    other.plot(result["time"], result["drive_voltage"], color=VERMILION, ls="--", lw=0.9)


def sensitivity_bars(result: xr.Dataset, axes: Axes) -> None:
    """The largest sensitivities of the stroke, sorted."""
    change = np.nan_to_num(result["sensitivity"].values)
    order = np.argsort(-np.abs(change))[:MOST_BARS][::-1]
    names = [str(result["field"].values[k]).removeprefix("material.").replace("_", " ") for k in order]
    axes.barh(names, change[order], color=[BLUE if value > 0.0 else VERMILION for value in change[order]])
    axes.axvline(0.0, color=GREY, lw=0.8)
    axes.tick_params(axis="y", labelsize=6.5)
    axes.set_xlabel("change of the stroke, % per %")
