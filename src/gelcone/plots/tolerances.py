"""Figures of uncertain parameters: density of the stroke, risks, and the influence of each parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from gelcone.atlas.tolerances import base_draws, strokes_of, tolerances
from gelcone.errors import InputError
from gelcone.plots.style import BLUE, GREY, ORANGE, axis_label, coordinate_axis, styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

POINTS = 200
"""Points of a density curve."""


def tolerances_figure(cells: xr.Dataset) -> Figure:
    """Draws of the regime: density of the stroke, risks with intervals and Sobol indices; over one parameter quantiles
    and risks along it."""
    summary = tolerances(cells)
    dims = [str(dim) for dim in summary["decided"].dims if dim != "risk"]
    if len(dims) > 1:
        raise InputError("draws are drawn alone or over one parameter; take a slice of the others")
    if dims:
        return styled(5.6, 5.0, lambda figure: _along(summary, dims[0], figure))
    indices = "first_order" in summary and bool(summary["total_order"].notnull().all())

    def draw(figure: Figure) -> None:
        panels = figure.subplots(2 + indices, 1, gridspec_kw={"height_ratios": [2, 1.3, 1.3][: 2 + indices]})
        strokes = strokes_of(base_draws(cells)).values
        density(panels[0], strokes[strokes > 0.0])
        for value in summary["stroke"].values[np.isfinite(summary["stroke"].values)]:
            panels[0].axvline(value, color=ORANGE, lw=1.0)
        panels[0].set_xlabel(axis_label(summary["stroke"], "stroke"))
        still, ended = (f"{100.0 * np.mean(of):.3g} %" for of in (strokes == 0.0, np.isnan(strokes)))
        panels[0].set_title(f"motions; at rest {still}, without a long run {ended}; quantiles 5, 50, 95 %", loc="left")
        _bars(panels[1], summary["risk"].values, [summary[n].values for n in ("probability", "low", "high")], BLUE)
        panels[1].set_title("probability, with its 95 % interval", loc="left")
        if indices:
            order = np.argsort(summary["total_order"].sel(end="value").values)
            names = summary["parameter"].values[order]
            for name, colour, height in (("total_order", GREY, 0.7), ("first_order", BLUE, 0.35)):
                ends = summary[name].values[order].T
                _bars(panels[2], names, ends, colour, height)
            panels[2].set_title("share of its variance: alone (blue), with others (grey)", loc="left")

    return styled(5.6, 4.2 + 1.5 * indices, draw)


def _along(found: xr.Dataset, name: str, figure: Figure) -> None:
    upper, lower = figure.subplots(2, 1, sharex=True)
    at, low, middle, high = (found[name].values, *found["stroke"].transpose("quantile", name).values)
    upper.fill_between(at, low, high, color=BLUE, alpha=0.25, lw=0.0, label="from 5 to 95 % of the draws")
    upper.plot(at, middle, color=BLUE, marker="o", ms=2.5, lw=1.2, label="median")
    upper.set_ylabel(axis_label(found["stroke"], "stroke"))
    upper.legend(loc="best")
    for risk, colour in zip(found["risk"].values, (ORANGE, GREY, BLUE), strict=True):
        one = found.sel(risk=risk)
        if one["probability"].notnull().any():
            lower.fill_between(at, one["low"], one["high"], color=colour, alpha=0.2, lw=0.0)
            lower.plot(at, one["probability"], color=colour, marker="o", ms=2.5, lw=1.2, label=str(risk))
    lower.set_ylim(-0.03, 1.03)
    lower.set_ylabel("probability")
    lower.legend(loc="best")
    coordinate_axis(lower.xaxis, found, name)


def _bars(axes: Axes, names: npt.ArrayLike, ends: npt.ArrayLike, colour: str, height: float = 0.6) -> None:
    """Horizontal bars with intervals; unknown values have none."""
    labels = [str(name).replace("_", " ") for name in np.ravel(names)]
    value, low, high = np.asarray(ends, dtype=float)
    known = np.isfinite(value)
    places = np.arange(value.size)
    axes.barh(places[known], value[known], height, color=colour, alpha=0.5)
    off = np.abs(np.stack([value - low, high - value])[:, known])
    axes.errorbar(value[known], places[known], xerr=off, fmt="none", ecolor=colour, capsize=2.0, lw=1.0)
    axes.set_yticks(
        places, [f"{label}: not known" if not there else label for label, there in zip(labels, known, strict=True)]
    )
    axes.set_xlim(min(0.0, float(np.nanmin(low, initial=0.0))), max(1.0, float(np.nanmax(high, initial=1.0))))


def density(axes: Axes, values: npt.NDArray[np.float64]) -> None:
    """The density of some numbers by Gaussian kernels, with a tick for each number; only the ticks if all are equal."""
    from scipy.stats import gaussian_kde

    there = values[np.isfinite(values)]
    axes.set_yticks([])
    if there.size:
        axes.plot(there, np.zeros(there.size), "|", color=BLUE, ms=6.0, alpha=0.6)
    if there.size < 3 or np.ptp(there) <= 1e-9 * np.abs(there).max():
        return
    at = np.linspace(there.min(), there.max(), POINTS)
    kernel = gaussian_kde(there)(at)
    axes.fill_between(at, kernel, color=BLUE, alpha=0.25, lw=0.0)
    axes.plot(at, kernel, color=BLUE, lw=1.2)
