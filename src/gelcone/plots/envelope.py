"""Figure of an operating envelope: limits over drive frequency, statics over voltage, stroke and power at its edge."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.amounts import lasting, unit_of
from gelcone.codes import Outcome, Regime
from gelcone.motion.proportion import IN_PROPORTION, held_at_peak
from gelcone.plots.style import (
    BLACK,
    BLUE,
    CYCLE,
    GREEN,
    GREY,
    VERMILION,
    axis_label,
    log_ticks,
    name_axes,
    say,
    second_axes,
    styled,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MARKERS = "Xos^vDP"
JUMP = 0.15
"""Neighbouring limits that differ by more than this share are not joined by a line."""


def envelope_figure(envelope: xr.Dataset) -> Figure:
    """Limits and recommended window over drive frequency; statics, natural frequency, and stroke and power at the
    window's edge."""

    def draw(figure: Figure) -> None:
        grid = figure.add_gridspec(3, 2, width_ratios=[1.6, 1.0])
        limits = figure.add_subplot(grid[:, 0])
        driven_limits(envelope, limits)
        force = figure.add_subplot(grid[0, 1])
        static_curves(envelope, force)
        natural_frequency(envelope, figure.add_subplot(grid[1, 1], sharex=force))
        force.tick_params(labelbottom=False)
        window_yield(envelope, figure.add_subplot(grid[2, 1], sharex=limits))
        figure.legend(*limits.get_legend_handles_labels(), loc="outside lower center", ncols=3)

    return styled(7.4, 5.6, draw, envelope)


def driven_limits(envelope: xr.Dataset, axes: Axes) -> None:
    """Each limit of the driven motion over drive frequency, quasi-static ones as level lines, the window shaded."""
    frequency = envelope["drive_frequency"].values
    highest = float(envelope["peak_voltage"].max())
    window = envelope["recommended_peak"].values
    if (window > 0.0).any():
        has_window = window > 0.0  # a gap where there is no window, instead of a slope down to 0
        axes.fill_between(frequency, 0.0, window, has_window, color=GREEN, alpha=0.18, lw=0, label="recommended window")
    looks = zip(envelope["driven_limit"].values, (BLACK, *CYCLE), MARKERS, strict=False)
    for row, (name, colour, marker) in enumerate(looks):
        low, high = envelope["limit_low"].values[row], envelope["limit_high"].values[row]
        met = np.where(np.isfinite(high), low, np.nan)  # the safe end
        look: dict[str, Any] = {"color": colour, "marker": marker, "ms": 3.5 if frequency.size < 40 else 2.2, "lw": 0.9}
        if np.isfinite(met).any():
            label = f"{limit_label(envelope, name)}, driven"
            axes.plot(*broken_at_jumps(frequency, met), **look, label=label, clip_on=False)
        elif np.isnan(low).all() and name == "dielectric breakdown":
            axes.plot([], [], **look, label="dielectric breakdown: unknown,\nno strength given")
    styles = ("-", "--", "-.", ":", (0, (5, 1)), (0, (1, 1)))
    voltages = envelope["static_limit_voltage"].values
    static_words = "drive held at its peak" if held_at_peak(envelope) else "quasi-static"
    if (time := envelope.get("holding_time")) is not None:
        static_words = f"held for {lasting(float(time), time, 3)}"
    for name, voltage, style in zip(envelope["static_limit"].values, voltages, styles, strict=True):
        if np.isfinite(voltage) and voltage <= 1.05 * highest:
            axes.axhline(voltage, color=GREY, ls=style, lw=0.8, label=f"{limit_label(envelope, name)}, {static_words}")
    coexisting_motions(envelope, axes)
    operating_point = float(envelope["operating_frequency"]), float(envelope["operating_peak_voltage"])
    if frequency[0] <= operating_point[0] <= frequency[-1]:
        axes.plot(*operating_point, "*", color=BLACK, ms=8.0, ls="", label="the device's drive")
    frequency_axis(envelope, axes)
    axes.autoscale_view()
    axes.set_ylim(0.0, min(1.05 * highest, 1.1 * axes.dataLim.ymax))
    proportion = IN_PROPORTION if held_at_peak(envelope) else ""
    axes.set_ylabel(axis_label(envelope["peak_voltage"], f"peak voltage{proportion}"))


def limit_label(envelope: xr.Dataset, name: str) -> str:
    """The label of a limit; pull-in with the film that it is of, which results of gelcone 0.1 do not state."""
    of = envelope.attrs.get("pull_in_of")
    return f"{name} of the {of}" if of and name == "pull-in" else name


def broken_at_jumps(frequency: Any, values: Any) -> tuple[Any, Any]:
    """A line over the frequencies with gaps at jumps."""
    with np.errstate(invalid="ignore", divide="ignore"):
        jumps = np.flatnonzero(np.abs(np.diff(np.log(values))) > np.log1p(JUMP)) + 1
    return np.insert(frequency, jumps, frequency[jumps]), np.insert(values, jumps, np.nan)


def coexisting_motions(envelope: xr.Dataset, axes: Axes) -> None:
    """Rings at the frequencies at which other motions coexist with those at the window's edge."""
    others = np.flatnonzero(envelope["coexisting_motions"].values > 0)
    if not others.size:
        return
    at, peak = (envelope[name].values[others] for name in ("drive_frequency", "recommended_peak"))
    kicks = envelope["kick_high"]
    least = float(kicks.where(np.isfinite(kicks)).min())
    motions = envelope.isel(drive_frequency=others)
    ends = motions["motion_outcome"].values[motions["motion_regime"].notnull().values]
    where = "to pull-in" if (ends == Outcome.PULLED_IN).all() else "to another motion"
    words = f"a kick from {least:.2g}{unit_of(kicks)} on\nleads {where}"
    words = words if np.isfinite(least) else "another motion coexists"
    axes.plot(at, peak, "o", ms=7.0, mfc="none", mec=VERMILION, mew=1.2, ls="", label=words, zorder=4)


def frequency_axis(envelope: xr.Dataset, axes: Axes) -> None:
    """The drive frequencies on a log scale."""
    log_ticks(axes)
    axes.set_xlim(*envelope["drive_frequency"].values[[0, -1]])
    axes.set_xlabel(axis_label(envelope["drive_frequency"], "drive frequency"))


def static_curves(envelope: xr.Dataset, axes: Axes) -> None:
    """Stroke and blocked force over the constant voltage; the recommended range is shaded."""
    volts = envelope["constant_voltage"].values
    twin_curves(axes, volts, envelope["stroke"], "static stroke", envelope["blocked_force"], "blocked force")
    shade(envelope, axes)
    if not (np.abs(envelope["stroke"].values) > 1e-9).any():
        say(axes, "the film stays flat")


def natural_frequency(envelope: xr.Dataset, axes: Axes) -> None:
    """Natural frequency about the equilibrium over the constant voltage."""
    axes.plot(envelope["constant_voltage"], envelope["natural_frequency"], color=BLUE)
    shade(envelope, axes)
    axes.set_ylim(bottom=0.0)
    over = "peak held, bias in proportion" if held_at_peak(envelope) else "constant voltage"
    name_axes(axes, envelope["constant_voltage"], envelope["natural_frequency"], over, "natural freq.")


def shade(envelope: xr.Dataset, axes: Axes) -> None:
    """Shades the recommended constant voltages."""
    axes.axvspan(0.0, float(envelope["recommended_constant"]), color=GREEN, alpha=0.18, lw=0)
    axes.set_xlim(0.0, float(envelope["constant_voltage"].max()))


def window_yield(envelope: xr.Dataset, axes: Axes) -> None:
    """Stroke and mean power at the edge of the recommended window over drive frequency."""
    frequency = envelope["drive_frequency"].values
    twin_curves(axes, frequency, envelope["window_stroke"], "stroke", envelope["window_power"], "mean power supplied")
    frequency_axis(envelope, axes)
    axes.set_title("at the window's edge", fontsize=8.0, pad=2.0)
    if not (envelope["recommended_peak"].values > 0.0).any():
        say(axes, "no window")
    elif (envelope["window_regime"].values == Regime.REST).all():
        say(axes, "the film stays at rest")


def twin_curves(axes: Axes, x: np.ndarray, left: xr.DataArray, name: str, right: xr.DataArray, other_name: str) -> None:
    """One curve on the left axis and one, dashed, on the right; both axes start at 0 unless values are negative."""
    other = second_axes(axes, left, name, right, other_name)
    for panel, values, colour, style in ((axes, left, BLUE, "-"), (other, right, VERMILION, "--")):
        panel.plot(x, values, color=colour, ls=style)
        small = not (np.abs(np.nan_to_num(values.values)) > 1e-9).any()
        if small:
            panel.set_ylim(0.0, 1.0)
            panel.set_yticks([0.0])
        elif not (values.values < 0.0).any():
            panel.set_ylim(bottom=0.0)
