"""Figure of voltage steps: displacement over time, one line per voltage."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import measured
from gelcone.codes import Outcome
from gelcone.motion.validity import invalid
from gelcone.plots.style import CYCLE, GREY, UNHELD, name_axes, name_faint, styled
from gelcone.quantity import Array
from gelcone.words import evenly

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

SHOWN = 6
"""Most voltages drawn."""


def step_figure(result: xr.Dataset) -> Figure:
    """Displacement after the step, faint where the model does not hold; dashed the end of a slow ramp, dotted the
    settling time."""

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        picks, opacity = evenly(result.sizes["constant_voltage"], SHOWN), opacities(result)
        for k, pick in enumerate(picks):
            one, colour = result.isel(constant_voltage=int(pick)), CYCLE[k % len(CYCLE)]
            outcome = int(one["outcome"])
            ended = f", {Outcome(outcome).words}" if outcome else ""
            look = {"color": colour, "alpha": opacity[pick], "label": measured(one["constant_voltage"]) + ended}
            axes.plot(result["time"], one["displacement"], **look)
            if np.isfinite(one["equilibrium_displacement"]):
                axes.axhline(float(one["equilibrium_displacement"]), color=colour, lw=0.6, ls="--", alpha=0.7)
            if np.isfinite(one["settling_time"]):
                axes.axvline(float(one["settling_time"]), color=colour, lw=0.8, ls=":")
        axes.axhline(float(result["initial_displacement"][0]), color=GREY, lw=0.6)
        axes.set_xlim(0.0, float(result["time"].max()))
        name_axes(axes, result["time"], result["displacement"], "time after the step")
        axes.set_title("dashed: end of a slow ramp; dotted: settling time", loc="left", fontsize=8.0)
        name_faint(axes, opacity[picks] < 1.0)
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))

    return styled(6.0, 3.4, draw, result)


def opacities(result: xr.Dataset) -> Array:
    """Opacities of the lines of each constant voltage: faint where the model does not hold."""
    where = invalid(result)
    return np.where(np.zeros(result.sizes["constant_voltage"], dtype=bool) if where is None else where, UNHELD, 1.0)
