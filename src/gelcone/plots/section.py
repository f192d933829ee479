"""Figures of Poincaré sections: the stroboscopic one in the phase plane, extrema over the phase of the drive."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.plots.regime import MARKERS
from gelcone.plots.response import members, picked
from gelcone.plots.style import CYCLE, REST_ROOM, axis_label, name_axes, styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CELLS = 400
"""Points in the same cell of a grid of this many cells per axis count as one."""


def section_figure(section: xr.Dataset) -> Figure:
    """A stroboscopic section or extrema, whichever the result holds; up to six members of an ensemble."""
    draw_points = section_points if "repeat" in section.dims else extremum_points

    def draw(figure: Figure) -> None:
        from matplotlib.collections import PathCollection

        axes = figure.add_subplot()
        draw_points(section, axes)
        name = "Poincaré section: once every forcing period" if "repeat" in section.dims else "turning points"
        axes.set_title(name, loc="left", fontsize=8.0)
        if axes.get_legend_handles_labels()[1]:
            legend = axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
            for points in legend.findobj(PathCollection):
                points.set(sizes=[14.0])

    longest = max(len(_label(name, member)) for name, member in members(section))
    return styled(
        3.5 if not longest and "repeat" in section.dims else 4.1 + 0.065 * longest, 3.3, draw, section, picked(section)
    )


def section_points(section: xr.Dataset, axes: Axes) -> None:
    """Velocity over displacement, one point per forcing period."""
    x, u = section["displacement"].values, section["velocity"].values
    set_room(axes, x, u)
    for i, (name, member) in enumerate(members(section)):
        scatter(axes, member["displacement"].values, member["velocity"].values, i, _label(name, member))
    name_axes(axes, section["displacement"], section["velocity"])


def extremum_points(extrema: xr.Dataset, axes: Axes) -> None:
    """Displacement at the turning points over the phase of the drive, with maxima and minima distinguished."""
    set_room(axes, np.array([0.0, 1.0]), extrema["displacement"].values)
    shown = members(extrema)
    for i, (name, member) in enumerate(shown):
        for kind, word in ((1, "maxima"), (-1, "minima")):
            at = member["maximum"].values == kind
            phase, x = member["phase"].values[at], member["displacement"].values[at]
            if len(shown) == 1:
                scatter(axes, phase, x, int(kind < 0), failure(member) or word)
            else:
                scatter(axes, phase, x, i, _label(name, member) if kind == 1 else "", filled=kind == 1)
    if len(shown) > 1:
        axes.set_title("filled: maxima, open: minima", loc="right", fontsize=8.0)
    axes.set_xlabel("phase within the forcing period")
    axes.set_ylabel(axis_label(extrema["displacement"], "displacement"))


def _label(name: str, member: xr.Dataset) -> str:
    return ", ".join(filter(None, [name, failure(member)]))


def failure(member: xr.Dataset) -> str:
    """The failure of a member's run, for a label; empty if it did not fail."""
    code = int(member["outcome"])
    return f"failed: {Outcome(code).words}" if code else ""


def scatter(
    axes: Axes, x: npt.NDArray[np.float64], y: npt.NDArray[np.float64], i: int, label: str, filled: bool = True
) -> None:
    """Points of member ``i``, larger if few of them are distinct."""
    inside = np.isfinite(x) & np.isfinite(y)
    x, y = x[inside], y[inside]
    left, right = axes.get_xlim()
    low, high = axes.get_ylim()
    cells = np.rint(CELLS * np.stack([(x - left) / (right - left), (y - low) / (high - low)]))
    size = float(np.clip(300.0 / max(1, np.unique(cells, axis=1).shape[1]), 1.5, 18.0))
    colour = CYCLE[i % len(CYCLE)]
    axes.scatter(
        x,
        y,
        s=size,
        marker=MARKERS[i % len(MARKERS)] if size > 4.0 else "o",
        facecolors=colour if filled else "none",
        edgecolors="none" if filled else colour,
        linewidths=0.0 if filled else 0.6,
        label=label or None,
        rasterized=True,
    )


def set_room(axes: Axes, x: npt.NDArray[np.float64], y: npt.NDArray[np.float64]) -> None:
    """Limits that contain all points, without magnifying rounding where all points coincide."""
    for values, set_limits in ((x, axes.set_xlim), (y, axes.set_ylim)):
        finite = values[np.isfinite(values)]
        low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
        largest = max(abs(low), abs(high))
        half = max(0.54 * (high - low), 0.1 * largest if high - low < 1e-3 * largest else 0.0)
        half = half if half > REST_ROOM else 1.0
        set_limits(0.5 * (low + high) - half, 0.5 * (low + high) + half)
