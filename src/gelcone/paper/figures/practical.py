"""Figure 9: a device at practical voltages, in volts and millimetres."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.paper.figures.figure import paper_figure
from gelcone.paper.figures.marks import listed
from gelcone.plots.style import BLACK, BLUE, GREY, VERMILION, styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RESPONSES = (10.0, 30.0, 50.0)
"""Voltages of the responses, from the paper's text."""
SHOWN = 2500.0
"""Shown part of the responses in milliseconds."""
LOOKS = ((BLUE, "o"), (VERMILION, "s"))
LOWEST = 1e-7


def draw(studies: Mapping[str, xr.Dataset]) -> Figure:
    """Amplitude over voltage up to the thresholds, and responses at three voltages."""
    study = studies["practical"]

    def fill(figure: Figure) -> None:
        layout: Any = [["amplitude", f"{volts:g} V"] for volts in RESPONSES]
        panels = figure.subplot_mosaic(layout, width_ratios=[1.15, 1.0])
        amplitudes(study, panels.pop("amplitude"))
        for (name, axes), volts in zip(panels.items(), RESPONSES, strict=True):
            response(study.sel(voltage_amplitude=volts), axes)
            axes.set_title(name, loc="left")
            axes.set_ylabel("displacement\n(mm)")
            axes.tick_params(labelbottom=False)
        axes.tick_params(labelbottom=True)
        axes.set_xlabel("time from the release (s)")
        figure.suptitle(str(study.attrs["device"]), fontsize=8.0, color=GREY)

    return styled(7.2, 4.6, fill)


def amplitudes(study: xr.Dataset, axes: Axes) -> None:
    """Half the swing from the start and in the long run, and the thresholds of rest."""
    volts = study["voltage_amplitude"]
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylim(LOWEST, 1e3)
    for (colour, marker), height in zip(LOOKS, study["initial_height"].values, strict=True):
        motion = study.sel(initial_height=height)
        axes.plot(volts, motion["window_amplitude"], marker, ms=4.5, color=colour)
        late = motion["late_amplitude"].where(motion["late_amplitude"] > LOWEST)
        axes.plot(volts, late, marker, ms=4.5, color=colour, mfc="none")
        still = volts.where(late.isnull(), drop=True)
        if still.size:
            axes.plot(still, np.full(still.size, LOWEST), "v", ms=5.0, color=colour, mfc="none", clip_on=False)
    thresholds = (("onset_voltage", "--", "under the drive"), ("pitchfork_voltage", ":", "statically"))
    for name, style, words in thresholds:
        axes.axvline(float(study[name].max()), color=BLACK, lw=0.9, ls=style, label=f"rest is lost {words}")
    axes.set_xlim(7.0, 3e4)
    axes.set_xlabel("voltage amplitude (V)")
    axes.set_ylabel("amplitude (mm)")
    axes.axvspan(float(volts.min()), float(volts.max()), color=GREY, alpha=0.15, lw=0.0)
    legend(study, axes)


def legend(study: xr.Dataset, axes: Axes) -> None:
    """Names the initial heights."""
    from matplotlib.lines import Line2D

    looks = list(zip(LOOKS, study["initial_height"].values, strict=True))
    handles: list[Artist] = [
        Line2D([], [], ls="", marker=marker, color=colour, ms=4.5, label=f"initial height {height:g} mm")
        for (colour, marker), height in looks
    ]
    for marker, fill, words in (("o", BLACK, "filled: from the start"), ("o", "none", "open: long run")):
        handles.append(Line2D([], [], ls="", marker=marker, color=BLACK, mfc=fill, ms=4.5, label=words))
    handles.append(Line2D([], [], ls="", marker="v", color=BLACK, mfc="none", ms=5.0, label="long run: at rest"))
    handles += axes.get_legend_handles_labels()[0]
    # the gap between the study's voltages and the thresholds is empty
    axes.legend(handles=handles, loc="center", bbox_to_anchor=(0.53, 0.56), fontsize=7.0)


def response(study: xr.Dataset, axes: Axes) -> None:
    """Displacement over time for both initial heights."""
    shown = study.sel(time=slice(0.0, SHOWN))
    for (colour, _), height in zip(LOOKS, study["initial_height"].values, strict=True):
        motion = shown.sel(initial_height=height)
        axes.plot(1e-3 * motion["time"], motion["displacement"], color=colour, lw=0.9)
        axes.axhline(float(motion["rest_displacement"]), color=colour, lw=0.6, ls=":")
    axes.margins(x=0.0)


FIGURES = (paper_figure(9, ("practical",), draw, responses=listed(RESPONSES)),)
