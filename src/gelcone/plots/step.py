"""Figure of voltage steps: displacement over time, one line per voltage."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.amounts import measured
from gelcone.codes import Outcome
from gelcone.plots.regime import invalid_cells
from gelcone.plots.style import CYCLE, GREY, UNHELD, name_axes, name_faint, styled
from gelcone.words import evenly

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHOWN = 6
"""Most voltages drawn."""


def step_figure(result: xr.Dataset) -> Figure:
    """Displacement after the step, faint where the model does not hold; dashed the end of a slow ramp, dotted the
    settling time."""

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        for one, look in voltages(result):
            outcome = int(one["outcome"])
            ended = f", {Outcome(outcome).words}" if outcome else ""
            axes.plot(result["time"], one["displacement"], **look, label=measured(one["constant_voltage"]) + ended)
            mark_equilibrium(one, axes, look["color"])
            if np.isfinite(one["settling_time"]):
                axes.axvline(float(one["settling_time"]), color=look["color"], lw=0.8, ls=":")
        axes.axhline(float(result["initial_displacement"][0]), color=GREY, lw=0.6)
        axes.set_xlim(0.0, float(result["time"].max()))
        name_axes(axes, result["time"], result["displacement"], "time after the step")
        axes.set_title("dashed: end of a slow ramp; dotted: settling time", loc="left", fontsize=8.0)
        name_faint(axes, [look["alpha"] < 1.0 for _, look in voltages(result)])
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))

    return styled(6.0, 3.4, draw, result)


def voltages(result: xr.Dataset) -> Iterator[tuple[xr.Dataset, dict[str, Any]]]:
    """Some of the constant voltages, with the look of their lines: faint where the model does not hold."""
    fails = invalid_cells(result, "constant_voltage")
    for k, pick in enumerate(evenly(result.sizes["constant_voltage"], SHOWN)):
        yield result.isel(constant_voltage=int(pick)), {"color": CYCLE[k], "alpha": UNHELD if fails[pick] else 1.0}


def mark_equilibrium(one: xr.Dataset, axes: Axes, colour: str) -> None:
    """A dashed line at the end of a slow ramp to one of the voltages."""
    if np.isfinite(one["equilibrium_displacement"]):
        axes.axhline(float(one["equilibrium_displacement"]), color=colour, lw=0.6, ls="--", alpha=0.7)
