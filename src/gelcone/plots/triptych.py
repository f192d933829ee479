"""Figure of motions side by side: one column per motion, in the colour of its regime."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import rate_unit
from gelcone.codes import Outcome, Regime
from gelcone.plots.regime import motion_colour
from gelcone.plots.response import members
from gelcone.plots.section import set_room
from gelcone.plots.style import BLACK, GREY, axis_label, say, styled
from gelcone.words import motion_in_words

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMN, LEAST = 2.4, 3.6
"""Width of a column, and least width of the figure, in inches."""
SHORT = 16
"""Most distinct section points that are drawn large."""


def triptych_figure(result: xr.Dataset) -> Figure:
    """Run from the start, settled motion, phase portrait and section, one row each."""
    shown = members(result)

    def draw(figure: Figure) -> None:
        rows = figure.subplots(4, len(shown), height_ratios=[1.0, 1.0, 1.25, 1.25], squeeze=False)
        for column, (name, member) in zip(rows.T, shown, strict=True):
            column[0].set_title(f"{name}\n{_caption(member)}".lstrip(), loc="left", fontsize=8.0)
            _over_time(column[0], member, "", BLACK)
            _over_time(column[1], member, "late_", motion_colour(member))
            _phase_plane(column[2], member)
            _section(column[3], member)
            for axes in column:
                axes.tick_params(labelsize=7.5)
        length, speed = (axis_label(result[name], name) for name in ("displacement", "velocity"))
        labels = (f"from the start\n{length}", f"settled\n{length}", f"phase portrait\n{speed}", f"section\n{speed}")
        for axes, label in zip(rows[:, 0], labels, strict=True):
            axes.set_ylabel(label)
        figure.align_ylabels(rows[:, 0])

    return styled(max(COLUMN * len(shown) + 0.6, LEAST), 8.0, draw, result)


def _caption(member: xr.Dataset) -> str:
    """The regime, and the largest exponent with its error."""
    if outcome := int(member["outcome"]):
        return Outcome(outcome).words
    value, error = (float(member[name].isel(exponent=0)) for name in ("lyapunov", "standard_error"))
    kind = motion_in_words(int(member["regime"]), int(member["period"]))
    return f"{kind}\n$\\lambda_1$ = {value:.3g} ± {error:.1g} {rate_unit(member['lyapunov'])}"


def _over_time(axes: Axes, member: xr.Dataset, prefix: str, colour: str) -> None:
    """Displacement over time, or a note if the motion has ended before."""
    time, x = member[f"{prefix}time"], member[f"{prefix}displacement"]
    axes.set_xlabel(axis_label(time, "time" if not prefix else "time, settled"), fontsize=8.0)
    if not np.isfinite(x).any():
        say(axes, "none: the motion has ended")
        return
    set_room(axes, time.values, x.values)
    axes.plot(time, x, color=colour, lw=0.8)
    axes.set_xlim(float(time.min()), float(time.max()))


def _phase_plane(axes: Axes, member: xr.Dataset) -> None:
    """Velocity over displacement: the run pale, the settled motion in the colour of the regime."""
    axes.plot(member["displacement"], member["velocity"], color=GREY, lw=0.5, alpha=0.6, rasterized=True)
    x, u = member["late_displacement"], member["late_velocity"]
    axes.plot(x, u, color=motion_colour(member), lw=0.9, rasterized=True)
    if int(member["regime"]) == Regime.REST:
        axes.plot(x[-1:], u[-1:], "o", color=motion_colour(member), ms=4.0)
    axes.set_xlabel(axis_label(x, "displacement"), fontsize=8.0)


def _section(axes: Axes, member: xr.Dataset) -> None:
    """Velocity over displacement once per forcing period; rounding is not magnified."""
    x, u = (member[f"section_{name}"].values for name in ("displacement", "velocity"))
    axes.set_xlabel(axis_label(member["section_displacement"], "displacement"), fontsize=8.0)
    if not np.isfinite(x).any():
        say(axes, "none: the motion has ended")
        return
    set_room(axes, x, u)
    few = np.unique(np.round(x[np.isfinite(x)] / max(np.ptp(axes.get_xlim()), 1e-300), 3)).size <= SHORT
    axes.plot(x, u, "o", color=motion_colour(member), ms=4.0 if few else 1.4, mew=0.0, rasterized=True)
