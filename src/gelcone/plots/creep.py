"""Figure of creep: displacement and margin over the holding time, and the time to pull-in over the voltage."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.amounts import measured, time_unit
from gelcone.plots.step import mark_equilibrium, voltages
from gelcone.plots.style import BLUE, GREY, VERMILION, axis_label, name_faint, say, styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def creep_figure(result: xr.Dataset) -> Figure:
    """Displacement and margin over time, one line per voltage, faint where the model does not hold; and the time to
    pull-in between the thresholds."""
    size, unit = time_unit(float(result["time"][-1]), result["time"])

    def draw(figure: Figure) -> None:
        axes: Any = figure.subplot_mosaic([["place", "curve"], ["margin", "curve"]], width_ratios=[1.15, 1.0])
        time = result["time"].values[1:] / size
        for one, look in voltages(result):
            axes["place"].plot(time, one["displacement"].values[1:], **look)
            axes["margin"].plot(time, 100.0 * one["margin"].values[1:], **look, label=measured(one["constant_voltage"]))
            mark_equilibrium(one, axes["place"], look["color"])
            if np.isfinite(one["pull_in_time"]) and float(one["pull_in_time"]) > 0.0:
                for name in ("place", "margin"):
                    axes[name].axvline(float(one["pull_in_time"]) / size, color=look["color"], lw=0.8, ls=":")
        for name in ("place", "margin"):
            axes[name].set_xscale("log")
            axes[name].set_xlim(time[0], time[-1])
        axes["place"].set_ylabel(axis_label(result["displacement"], "displacement"))
        axes["place"].set_title("dashed: equilibrium; dotted: pull-in", loc="left", fontsize=8.0)
        axes["margin"].set_ylim(bottom=0.0)
        name_faint(axes["margin"], [look["alpha"] < 1.0 for _, look in voltages(result)])
        axes["margin"].legend(loc="best")
        axes["margin"].set_ylabel("margin (% of the voltage)")
        axes["margin"].set_xlabel(f"holding time{_bracketed(unit)}")
        _curve(axes["curve"], result, size)
        axes["curve"].set_ylabel(f"time to pull-in{_bracketed(unit)}")

    return styled(7.0, 3.8, draw, result)


def _curve(axes: Axes, result: xr.Dataset, size: float) -> None:
    """The time to pull-in over the voltage, with arrows where it exceeds the run, and the thresholds."""
    axes.set_xlabel(axis_label(result["held_voltage"], "constant voltage"))
    if not np.isfinite(result["long_term_pull_in_voltage"]):
        say(axes, "no voltage pulls it in")
        return
    voltage, time = result["held_voltage"].values, result["time_to_pull_in"].values / size
    late, longest = np.isfinite(time) & (time > 0.0), float(result["time"][-1]) / size
    axes.semilogy(voltage[late], time[late], ".-", color=VERMILION)
    held = np.isinf(time)
    axes.plot(voltage[held], np.full(held.sum(), longest), "^", color=BLUE, ms=4.0, label="held for the duration")
    for name, words in (("long_term_pull_in_voltage", "in the long run"), ("instantaneous_pull_in_voltage", "at once")):
        if np.isfinite(result[name]):
            axes.axvline(float(result[name]), color=GREY, lw=0.8, ls="--")
            axes.annotate(
                f" {words}", (float(result[name]), 0.02), xycoords=("data", "axes fraction"), rotation=90.0,
                ha="right", va="bottom", fontsize=7.0, color=GREY,
            )  # fmt: skip
    if held.any():
        axes.legend(loc="upper right")


def _bracketed(unit: str) -> str:
    return "" if unit == " time units" else f" ({unit.strip()})"
