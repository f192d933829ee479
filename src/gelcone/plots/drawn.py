"""Figures of draws: median and 95 % interval over the drive frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.plots.style import CYCLE, axis_label, log_ticks, styled
from gelcone.statistics import spread

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

VARIABLES = {"envelope": "recommended_peak", "frequency": "stroke"}
"""Analysis -> the variable that is drawn."""


def drawn_figure(result: xr.Dataset) -> Figure:
    """The band of all draws over the drive frequency; one for each sweep of a frequency response."""
    name = VARIABLES[result.attrs["analysis"]]
    frequency, whole = result["drive_frequency"], result[name]

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        branches = list(map(str, whole["branch"].values)) if "branch" in whole.dims else [""]
        for colour, branch in zip(CYCLE, branches, strict=False):
            values = (whole.sel(branch=branch) if branch else whole).transpose("draw", "drive_frequency").values
            lost = 1.0 - float(np.isfinite(values).mean())
            low, middle, high = spread(np.where(np.isfinite(values), values, np.nan))
            swept = f", swept {branch}" * bool(branch) + f", without a value in {lost:.2g} of them" * bool(lost)
            axes.fill_between(frequency, low, high, color=colour, alpha=0.25, lw=0.0, label=f"95 % of the draws{swept}")
            axes.plot(frequency, middle, color=colour, lw=1.2, label=f"median{swept}")
        log_ticks(axes)
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel(axis_label(frequency, "drive frequency"))
        axes.set_ylabel(axis_label(whole, str(whole.attrs["long_name"]).partition(",")[0]))
        axes.legend(loc="best")

    return styled(5.6, 3.4, draw, result)
