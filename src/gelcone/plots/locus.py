"""Figures of loci: curves of bifurcations in two parameters, with their points of codimension two."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.devices.numbers import SHIPPED
from gelcone.errors import InputError
from gelcone.plots.branches import DASHED, MARKERS, with_neighbours
from gelcone.plots.style import BLACK, CYCLE, GREY, name_axes, styled
from gelcone.words import event_label

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


BELOW = "branch born below\nthe first parameter"
TONGUES = "instability tongues of rest"


def locus_figure(result: xr.Dataset, on: xr.Dataset | None = None) -> Figure:
    """The curves with the first parameter along x and the second along y; or drawn over ``on``, a map or tongues of the
    same parameters."""
    if on is not None:
        return _over(result, on)

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        one, other = names_of(result)
        curves(result, axes)
        name_axes(axes, result[one], result[other])
        axes.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0))

    return styled(7.2, 4.2, draw, result)


def _over(result: xr.Dataset, on: xr.Dataset) -> Figure:
    """The figure of a map or of tongues with the curves on its panels."""
    from gelcone.plots import figure_of

    across, _ = _axes_of(result, on)
    figure = figure_of(on)(on)
    panels = [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]
    for axes in panels:
        limits = axes.get_xlim(), axes.get_ylim()
        drawn = curves(result, axes, across, outlined=True)
        axes.set(xlim=limits[0], ylim=limits[1])
    named = dict(zip(*panels[0].get_legend_handles_labels()[::-1], strict=True))
    handles = {label: handle for label, handle in named.items() if label in drawn}
    figure.set_figheight(figure.get_figheight() + 0.3)
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3, fontsize=8.0, frameon=False)
    return figure


def _axes_of(result: xr.Dataset, on: xr.Dataset) -> tuple[str, str]:
    """The parameters of the curves along x and y of a map or of tongues; `InputError` if they do not match."""
    title = str(on.attrs.get("title", "")).partition(":")[0]
    names = ["drive_frequency", "voltage"] if title == TONGUES else [str(dim) for dim in on.get("regime", on).dims]
    same = {number.field: parameter for parameter, number in SHIPPED.items()} if title == TONGUES else {}
    pair = {same.get(name, name): name for name in names_of(result)}
    if title not in (TONGUES, "parameter map", "sweep") or set(names) != set(pair):
        raise InputError(
            f"on: is {title or 'no result'!r} over {', '.join(names)}; curves over {' and '.join(pair)} are drawn on a "
            "map or tongues over these two"
        )
    if [on[name].attrs.get("units") for name in names] != [result[pair[name]].attrs.get("units") for name in names]:
        raise InputError("on: is in other units than the curves; give both of the same device")
    return pair[names[0]], pair[names[1]]


def names_of(result: xr.Dataset) -> tuple[str, str]:
    """The names of the two parameters."""
    one, other = result.attrs["parameters"].split(",")
    return one, other


def curves(result: xr.Dataset, axes: Axes, across: str | None = None, *, outlined: bool = False) -> set[str]:
    """Draws the curves of a locus, and returns their labels; the parameter ``across`` is along x (default: the first).

    Colours show the period. Lines are solid where the new branch exists above the first parameter's value, and dashed
    where below; folds are solid. Markers are points of codimension two. ``outlined`` adds a white rim, for coloured
    maps.
    """
    from matplotlib.patheffects import withStroke

    effects = [withStroke(linewidth=2.6, foreground="white")] if outlined else []
    names = names_of(result)
    x, y = names if across in (None, names[0]) else names[::-1]
    named: set[str] = set()
    for k in range(result.sizes["curve"]):
        own = result.isel(curve=k)
        period = int(own["period"])
        label = f"{result.attrs['event']}, period {period}"
        below = own["curvature"].values < 0.0
        colour = CYCLE[int(np.log2(period)) % len(CYCLE)]
        at, up = own[x].values, own[y].values
        look: dict[str, Any] = {"color": colour, "path_effects": effects}
        axes.plot(at, np.where(below, np.nan, up), lw=1.2, label="" if label in named else label, **look)
        if below.any():
            axes.plot(at, np.where(with_neighbours(below), up, np.nan), lw=0.9, ls=DASHED, **look)
        named.add(label)
    for e in range(result.sizes["event"]):
        own = result.isel(event=e)
        kind = event_label(own["event_kind"])
        position = {name: float(own[f"event_{p}"]) for p, name in zip(("first", "second"), names, strict=True)}
        label = "" if kind in named else kind
        axes.plot([position[x]], [position[y]], MARKERS[kind], ms=6.0, color=BLACK, mec="white", mew=0.4, label=label)
        named.add(kind)
    if (result["curvature"].values < 0.0).any():
        axes.plot([], [], color=GREY, lw=0.9, ls=DASHED, label=BELOW)
    return named | {BELOW}
