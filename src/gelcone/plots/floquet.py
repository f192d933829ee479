"""Figures of the stability of rest under the drive: instability tongues."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import rate_unit
from gelcone.plots.style import BLACK, BLUE, GREY, name_axes, say, styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.contour import QuadContourSet
    from matplotlib.figure import Figure

LEVELS = 10
JUMP = 0.06
"""Largest change of the onset between neighbouring frequencies on one line, as a share of the voltage axis."""


def tongues_figure(result: xr.Dataset) -> Figure:
    """Growth rate of deviations from rest over drive frequency and voltage, with onset and static pitchfork."""

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        filled = growth_map(result, axes)
        if filled is not None:
            bar = figure.colorbar(filled, ax=axes, pad=0.02)
            bar.set_label(f"growth rate of deviations\nfrom rest ({rate_unit(result['growth_rate'])})")
        onset_lines(result, axes)
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)

    return styled(6.2, 3.6, draw, result)


def growth_map(result: xr.Dataset, axes: Axes) -> QuadContourSet | None:
    """Growth rate where rest is unstable, hatched where the growing deviation has twice the forcing period; white
    where rest is stable."""
    from matplotlib.ticker import MaxNLocator

    x, y = result["drive_frequency"].values, result["voltage"].values
    growth = result["growth_rate"].values.T
    margin = result["margin"].values.T
    unstable = margin > 0.0
    name_axes(axes, result["drive_frequency"], result["voltage"], "drive frequency", "voltage amplitude")
    axes.set_xlim(x[0], x[-1])
    axes.set_ylim(y[0], y[-1])
    if not unstable.any():
        say(axes, "rest is stable everywhere")
        return None
    levels = MaxNLocator(LEVELS).tick_values(0.0, float(growth[unstable].max()))
    filled = axes.contourf(x, y, growth, levels=levels, cmap="YlOrBr")
    # The growth rate is flat below onset; the margin locates the border better between grid points.
    axes.contourf(x, y, margin, levels=[-2.0, 0.0], colors="white")
    doubling = np.where(result["doubles"].values.T, margin, -1.0)
    if (doubling > 0.0).any():
        hatched = axes.contourf(x, y, doubling, levels=[0.0, 2.0], colors="none", hatches=["///"])
        hatched.set(edgecolor=GREY, linewidth=0.0)
        axes.fill_between([], [], fc="none", ec=GREY, hatch="///", lw=0.0, label="grows with period 2")
    return filled


def onset_lines(result: xr.Dataset, axes: Axes) -> None:
    """The border of stability, the lowest voltage on it, and the static pitchfork for comparison."""
    x, y = result["drive_frequency"].values, result["voltage"].values
    axes.contour(x, y, result["margin"].values.T, levels=[0.0], colors=BLACK, linewidths=0.8)
    onset = result["onset_voltage"].values
    # the line is broken at jumps from one tongue to the next
    jumps = 1 + np.flatnonzero(np.abs(np.diff(onset)) > JUMP * (y[-1] - y[0]))
    axes.plot(np.insert(x, jumps, np.nan), np.insert(onset, jumps, np.nan), ".-", color=BLUE, ms=3.0, label="onset")
    static = float(result["pitchfork_amplitude"])
    if np.isfinite(static):
        axes.axhline(static, color=GREY, ls="--", label="static pitchfork at the peak")
