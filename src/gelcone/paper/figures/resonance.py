"""Figure 12: amplitude over drive frequency for six spring stiffnesses, and responses around a resonance."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from gelcone.paper.figures.figure import paper_figure
from gelcone.paper.figures.marks import SYMBOLS, fixed_parameters
from gelcone.paper.figures.triptych import from_the_start, in_the_long_run
from gelcone.paper.studies.resonance import RESPONSE_STIFFNESS, STIFFNESSES
from gelcone.plots.branches import with_neighbours
from gelcone.plots.style import BLACK, GREY, VERMILION, styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

SHOWN = 100.0
"""Shown time of the responses."""
DOWN = (0, (2.0, 1.2))
UNSTABLE = (0, (1.0, 0.8))


def draw(studies: Mapping[str, xr.Dataset]) -> Figure:
    """Amplitude over frequency, its peaks over the stiffness, and three responses."""
    sweeps, responses = studies["frequency"], studies["frequency-responses"]

    def fill(figure: Figure) -> None:
        top, bottom = cast(Any, figure.subfigures)(2, 1, height_ratios=[1.2, 1.0])
        panels = top.subplot_mosaic("aaf;aah", width_ratios=[1.0, 1.0, 0.9])
        amplitude_over_frequency(sweeps, panels["a"])
        peaks(sweeps, panels["f"], panels["h"])
        three_responses(responses, bottom)
        shared = ("damping_ratio", "voltage", "stretch_limit", "prestretch", "rest_height")
        figure.suptitle(fixed_parameters(sweeps, *shared), fontsize=8.0, color=GREY)

    return styled(7.2, 7.8, fill)


def colours(study: xr.Dataset) -> Any:
    """A colour for each stiffness, darker for softer springs."""
    import matplotlib as mpl

    return mpl.colormaps["viridis"](np.linspace(0.0, 0.85, study.sizes["spring_stiffness"]))


def logarithmic(axis: Axis, at: tuple[float, ...] = (1.0, 2.0, 5.0)) -> None:
    """Sets ticks of a log scale with plain numbers at these multiples in each decade."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    axis.set_major_locator(LogLocator(subs=at))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def amplitude_over_frequency(study: xr.Dataset, axes: Axes) -> None:
    """Sweeps up (solid) with sweeps down (dashed) on top; where both coincide there is no hysteresis."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    for colour, stiffness in zip(colours(study), study["spring_stiffness"].values, strict=True):
        sweeps = study.sel(spring_stiffness=stiffness)
        omega, up = sweeps["swept_frequency"].values, sweeps["amplitude"].sel(sweep="up").values
        axes.plot(omega, up, color=colour, lw=1.6)
        axes.plot(omega, sweeps["amplitude"].sel(sweep="down"), color=BLACK, lw=0.8, ls=DOWN)
        axes.plot(sweeps["peak_frequency"], sweeps["peak_amplitude"], "o", ms=4.5, color=colour, mec=BLACK, mew=0.6)
        name = f"{SYMBOLS['spring_stiffness']} = {stiffness:g}"
        left_of: Any = {"textcoords": "offset points", "ha": "right", "va": "center", "fontsize": 7.5}
        axes.annotate(name, (omega[0], up[0]), (-3.0, 0.0), color=colour, **left_of)
        if "branch_amplitude" in study:
            _branches(sweeps, axes)
    if "branch_amplitude" in study:
        axes.plot([], [], color=VERMILION, lw=0.9, ls=UNSTABLE, label="unstable orbits, up to period 2")
    axes.plot([], [], color=GREY, lw=1.6, label="swept up")
    axes.plot([], [], color=BLACK, lw=0.8, ls=DOWN, label="swept down")
    axes.plot([], [], "o", ms=4.5, color=GREY, mec=BLACK, mew=0.6, label="highest point")
    logarithmic(axes.xaxis)
    axes.set_xlim(left=0.5 * float(study["swept_frequency"].min()))
    axes.set_xlabel(r"drive frequency $\omega$")
    axes.set_ylabel("amplitude")
    axes.legend(loc="lower left", fontsize=7.5)


def _branches(own: xr.Dataset, axes: Axes) -> None:
    """The unstable orbits between the jumps, which no sweep reaches."""
    unstable = own["branch_stable"].values == 0.0
    amplitude = np.where(with_neighbours(unstable), own["branch_amplitude"].values, np.nan)
    axes.plot(own["branch_frequency"], amplitude, color=VERMILION, lw=0.9, ls=UNSTABLE, zorder=3.0)


def peaks(study: xr.Dataset, frequency: Axes, height: Axes) -> None:
    """Frequency and amplitude of the highest point over the stiffness, with half the natural frequency."""
    stiffness = study["spring_stiffness"]
    for axes, name in ((frequency, "peak_frequency"), (height, "peak_amplitude")):
        axes.set_xscale("log")
        axes.set_yscale("log")
        for sweep, marker in (("up", "^"), ("down", "v")):
            fill = colours(study) if sweep == "up" else "none"
            look: dict[str, Any] = {"marker": marker, "c": fill, "edgecolors": BLACK, "linewidths": 0.6, "zorder": 3.0}
            axes.scatter(stiffness, study[name].sel(sweep=sweep), s=28.0, label=f"swept {sweep}", **look)
        logarithmic(axes.xaxis, (1.0,))
        logarithmic(axes.yaxis)
        axes.margins(x=0.08, y=0.12)
    frequency.plot(stiffness, 0.5 * study["natural_frequency"], color=GREY, lw=0.8, label="half the natural\nfrequency")
    frequency.set_ylabel("at frequency")
    frequency.set_title("highest point", loc="left", fontsize=8.0)
    frequency.tick_params(labelbottom=False)
    frequency.legend(fontsize=7.0, handletextpad=0.4)
    height.set_ylabel("of amplitude")
    height.set_xlabel(r"spring stiffness $\kappa$")


def three_responses(study: xr.Dataset, figure: Figure) -> None:
    """Displacement from the start and in the long run, on shared scales."""
    parameter = study.attrs["parameter"]
    rows = figure.subplots(2, study.sizes[parameter], sharey="row")
    for k, (top, bottom) in enumerate(rows.T):
        member = study.isel({parameter: k})
        from_the_start(member.sel(time=slice(0.0, SHOWN)), top)
        in_the_long_run(member.sel(late_time=slice(0.0, SHOWN)), bottom)
        bottom.set_xlabel("time after the transient")
        top.set_title(f"{SYMBOLS[parameter]} = {float(member[parameter]):.3g}", loc="left")
    for axes in rows[:, 0]:
        axes.set_ylabel("displacement")
    figure.suptitle(f"responses for {SYMBOLS['spring_stiffness']} = {RESPONSE_STIFFNESS:g}", fontsize=9.0)


FIGURES = (
    paper_figure(12, ("frequency", "frequency-responses"), draw, lowest=STIFFNESSES[0], highest=STIFFNESSES[-1]),
)
