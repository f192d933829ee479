"""Picture of an operating envelope: limits over drive frequency, statics over voltage, stroke within the window."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.plots.style import BLACK, BLUE, CYCLE, GREEN, GREY, SKY, axis_label, styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MARKERS = "os^vDP"


def envelope_figure(envelope: xr.Dataset) -> Figure:
    """Limits and recommended window over drive frequency; beside it statics and the stroke of the driven motion."""

    def draw(figure: Figure) -> None:
        grid = figure.add_gridspec(2, 2, width_ratios=[1.6, 1.0])
        limits = figure.add_subplot(grid[:, 0])
        driven_limits(envelope, limits)
        static_curves(envelope, figure.add_subplot(grid[0, 1]))
        driven_stroke(envelope, figure.add_subplot(grid[1, 1]))
        figure.legend(*limits.get_legend_handles_labels(), loc="outside lower center", ncols=3)
        figure.suptitle(envelope.attrs.get("device", ""), fontsize=9.0)

    return styled(7.4, 5.0, draw)


def driven_limits(envelope: xr.Dataset, axes: Axes) -> None:
    """Each limit of the driven motion over drive frequency, quasi-static ones as level lines, the window shaded."""
    frequency = envelope["drive_frequency"].values
    highest = float(envelope["driven_peak"].max())
    window = envelope["recommended_peak"].values
    axes.fill_between(frequency, 0.0, window, color=GREEN, alpha=0.18, lw=0, label="recommended window")
    looks = zip(envelope["driven_limit"].values, CYCLE, MARKERS, strict=True)
    for row, (name, colour, marker) in enumerate(looks):
        low, high = envelope["limit_low"].values[row], envelope["limit_high"].values[row]
        middle = np.where(np.isfinite(high), 0.5 * (low + high), np.nan)
        if np.isfinite(middle).any():
            axes.plot(frequency, middle, color=colour, marker=marker, ms=3.5, lw=0.9, label=f"{name}, driven")
        elif np.isnan(low).all() and name == "dielectric breakdown":
            axes.plot(
                [], [], color=colour, marker=marker, ms=3.5, label="dielectric breakdown: unknown, no strength given"
            )
    styles = ("-", "--", "-.", ":", (0, (5, 1)), (0, (1, 1)))
    voltages = envelope["static_limit_voltage"].values
    for name, voltage, style in zip(envelope["static_limit"].values, voltages, styles, strict=True):
        if np.isfinite(voltage) and voltage <= 1.2 * highest:
            axes.axhline(voltage, color=GREY, ls=style, lw=0.8, label=f"{name}, quasi-static")
    axes.set_xscale("log")
    axes.xaxis.set_minor_formatter("")
    axes.set_ylim(0.0, 1.05 * highest)
    axes.set_xlabel(axis_label(envelope["drive_frequency"], "drive frequency"))
    axes.set_ylabel(axis_label(envelope["driven_peak"], "peak voltage"))


def static_curves(envelope: xr.Dataset, axes: Axes) -> None:
    """Stroke and blocked force over the constant voltage."""
    volts = envelope["peak_voltage"].values
    axes.plot(volts, envelope["stroke"], color=BLUE)
    axes.set_xlabel(axis_label(envelope["peak_voltage"], "constant voltage"))
    axes.set_ylabel(axis_label(envelope["stroke"], "static stroke"), color=BLUE)
    other = axes.twinx()
    other.plot(volts, envelope["blocked_force"], color=BLACK, ls="--")
    other.set_ylabel(axis_label(envelope["blocked_force"], "blocked force"))
    other.spines["right"].set_visible(True)


def driven_stroke(envelope: xr.Dataset, axes: Axes) -> None:
    """Stroke of the driven motion over frequency and peak voltage, with the edge of the recommended window."""
    frequency, peaks = envelope["drive_frequency"].values, envelope["driven_peak"].values
    image = axes.pcolormesh(frequency, peaks, envelope["driven_stroke"].values.T, cmap="cividis", rasterized=True)
    axes.plot(frequency, envelope["recommended_peak"], color=SKY, lw=1.2)
    axes.set_xscale("log")
    axes.xaxis.set_minor_formatter("")
    axes.set_xlabel(axis_label(envelope["drive_frequency"], "drive frequency"))
    axes.set_ylabel(axis_label(envelope["driven_peak"], "peak voltage"))
    assert axes.figure is not None
    axes.figure.colorbar(image, ax=axes, label=axis_label(envelope["driven_stroke"], "driven stroke"))
