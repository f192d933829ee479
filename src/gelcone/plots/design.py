"""Figure of designs: the front of the objectives, the probability of meeting all requirements, and voltages against
limits."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.plots.style import BLACK, BLUE, GREY, VERMILION, axis_label, name_axes, styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def design_figure(result: xr.Dataset) -> Figure:
    """The front over the first two objectives, the probability of each design, and its voltage below its limit."""

    def draw(figure: Figure) -> None:
        drawn = "probability" in result
        front, *shares, limit = figure.subplots(1, 3 if drawn else 2)
        _front(result, front)
        number = result["design"].values
        if drawn:
            _shares(result, shares[0])
        limit.bar(
            number, result["recommended"].values / (1.0 - result.attrs["margin"]), 0.6, color=GREY, label="first limit"
        )
        limit.bar(number, result["peak_voltage"].values, 0.35, color=VERMILION, label="peak of the drive")
        limit.set_ylabel(axis_label(result["peak_voltage"], "peak_voltage"))
        limit.set_ylim(0.0, 1.35 * limit.get_ylim()[1])
        limit.legend(loc="upper right")
        for axes in (*shares, limit):
            axes.set_xticks(number)
            axes.set_xlabel("design")
        figure.suptitle(result.attrs["title"], fontsize=9.0)

    return styled(9.0, 3.2, draw)


def _shares(result: xr.Dataset, share: Axes) -> None:
    low, high, middle = (result[f"probability{end}"].values for end in ("_low", "_high", ""))
    share.errorbar(result["design"].values, middle, [middle - low, high - middle], fmt="o", ms=4.0, color=BLUE)
    share.axhline(result.attrs["confidence"], color=GREY, ls="--", lw=0.8, label="required")
    share.set_ylabel("share of devices that meet all")
    share.margins(x=0.2, y=0.25)
    share.legend(loc="upper left")


def _front(result: xr.Dataset, axes: Axes) -> None:
    names = [name for name in json.loads(result.attrs["objectives"]) if name in result]
    first = names[0] if names else "apparent_power"
    second = names[1] if len(names) > 1 else "stroke" if first != "stroke" else "peak_voltage"
    x, y = result[second], result[first]
    axes.plot(x.values, y.values, "o-", color=BLACK, ms=4.0, lw=0.6)
    for k in range(x.size):
        place: Any = (float(x[k]), float(y[k]))
        axes.annotate(str(int(result["design"][k])), place, textcoords="offset points", xytext=(4, 4), fontsize=8.0)
    name_axes(axes, x, y, second, first)
    axes.set_ylim(0.0, 1.15 * float(np.max(y.values)))
