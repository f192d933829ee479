"""Figures of loci: curves of bifurcations in two parameters, with their points of codimension two."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.plots.branches import COLOURS, DASHED, MARKERS
from gelcone.plots.style import BLACK, GREY, axis_label, styled
from gelcone.words import event_label

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def locus_figure(result: xr.Dataset) -> Figure:
    """The curves over the first parameter, the second upwards."""

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        one, other = names_of(result)
        curves(result, axes)
        axes.set_xlabel(axis_label(result[one], one.replace("_", " ")))
        axes.set_ylabel(axis_label(result[other], other.replace("_", " ")))
        axes.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0))
        figure.suptitle(result.attrs.get("device", ""), fontsize=9.0)

    return styled(7.2, 4.2, draw)


def names_of(result: xr.Dataset) -> tuple[str, str]:
    """The two parameters."""
    one, other = result.attrs["parameters"].split(",")
    return one, other


def curves(result: xr.Dataset, axes: Axes, across: str | None = None) -> None:
    """The curves on any axes, such as those of a map or of tongues, with ``across`` along x (default the first
    parameter): by period, solid where the branch that is born lies above the first parameter's value, else dashed;
    folds are solid. Markers are the points of codimension two."""
    names = names_of(result)
    x, y = names if across in (None, names[0]) else names[::-1]
    told: set[str] = set()
    for k in range(result.sizes["curve"]):
        own = result.isel(curve=k)
        period = int(own["period"])
        label = f"{result.attrs['event']}, period {period}"
        below = own["curvature"].values < 0.0
        colour = COLOURS[int(np.log2(period)) % len(COLOURS)]
        at, up = own[x].values, own[y].values
        axes.plot(at, np.where(below, np.nan, up), color=colour, lw=1.2, label="" if label in told else label)
        if below.any():
            reach = below | np.roll(below, 1) | np.roll(below, -1)
            axes.plot(at, np.where(reach, up, np.nan), color=colour, lw=0.9, ls=DASHED)
        told.add(label)
    for e in range(result.sizes["event"]):
        own = result.isel(event=e)
        kind = event_label(own["event_kind"])
        place = {name: float(own[f"event_{p}"]) for p, name in zip(("first", "second"), names, strict=True)}
        label = "" if kind in told else kind
        axes.plot([place[x]], [place[y]], MARKERS[kind], ms=6.0, color=BLACK, mec="white", mew=0.4, label=label)
        told.add(kind)
    if (result["curvature"].values < 0.0).any():
        axes.plot([], [], color=GREY, lw=0.9, ls=DASHED, label="branch born below\nthe first parameter")
