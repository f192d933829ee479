"""Figures of regimes: their colours, grids of cells, and section points with their evidence."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.codes import Regime
from gelcone.motion.validity import invalid
from gelcone.plots.response import members, picked
from gelcone.plots.style import BLACK, BLUE, CRIMSON, GREEN, GREY, SKY, VERMILION, YELLOW, styled
from gelcone.quantity import Array
from gelcone.words import evidence_in_words, failed_in_words

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Blues for regular motion, reds for chaos: distinct for all kinds of colour vision, by lightness within a hue.
REGIME_COLOURS = {
    Regime.REST: SKY,
    Regime.PERIODIC: BLUE,
    Regime.QUASI_PERIODIC: GREEN,
    Regime.CHAOTIC: VERMILION,
    Regime.TRANSIENT: YELLOW,
    Regime.LEFT_THE_DOMAIN: GREY,
    Regime.TRANSIENT_CHAOS: CRIMSON,
}
MARKERS = ("o", "s", "^", "D", "v", "P")
INVALID, VEIL = "#DDDDDD", 0.62
"""Colour and opacity of the veil over cells in which the model does not hold."""
NOWHERE = "the model holds\nnowhere here"


def regime_figure(result: xr.Dataset) -> Figure:
    """Section points in the colour of their regime, with the evidence; up to six members of an ensemble."""

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        regime_points(result, axes)
        axes.set_title("Poincaré section: once every forcing period", loc="left", fontsize=8.0)
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), labelspacing=0.9)

    return styled(7.2, max(3.2, 0.6 + 0.62 * len(members(result))), draw, result, picked(result))


def regime_points(result: xr.Dataset, axes: Axes) -> None:
    """Velocity over displacement once per forcing period, one marker per member; periodic motions are drawn larger."""
    for marker, (name, member) in zip(MARKERS, members(result), strict=False):
        regime = Regime(int(member["regime"]))
        x, u = member["section"].values[:, 0], member["section"].values[:, 1]
        axes.scatter(
            x,
            u,
            s=9.0 if regime in (Regime.CHAOTIC, Regime.QUASI_PERIODIC, Regime.TRANSIENT) else 28.0,
            marker=marker,
            facecolors=REGIME_COLOURS[regime],
            edgecolors=BLACK,
            linewidths=0.4,
            label="\n".join(filter(None, [name, *evidence_in_words(member)])),
            zorder=3.0 if regime in (Regime.REST, Regime.PERIODIC) else 2.0,
        )
    keep_in_proportion(axes)
    displacement, velocity = state_labels(result)
    axes.set_xlabel(displacement)
    axes.set_ylabel(velocity)


def state_labels(result: xr.Dataset) -> tuple[str, str]:
    """Labels of displacement and velocity in ``section``, with units if it is in SI units (``mm, m/s``, and those of
    further states)."""
    units = result["section"].attrs["units"]
    if "," in units:
        length, velocity, *_ = units.split(",")
        return f"displacement ({length.strip()})", f"velocity ({velocity.strip()})"
    if result["lowest"].attrs["units"] == "1":
        return "displacement", "velocity"
    return "displacement / (b - a)", "velocity / ((b - a) $\\Omega_0$)"


def keep_in_proportion(axes: Axes) -> None:
    """Widens limits that would magnify rounding errors."""
    for limits, set_limits in ((axes.get_xlim(), axes.set_xlim), (axes.get_ylim(), axes.set_ylim)):
        centre, least = 0.5 * (limits[0] + limits[1]), max(0.1 * max(map(abs, limits)), 1e-2)
        if limits[1] - limits[0] < 2.0 * least:
            set_limits(centre - least, centre + least)


# --- grids of cells ----------------------------------------------------------------------------------------------


def edges(values: Any) -> Array:
    """Borders of cells around increasing values."""
    values = np.asarray(values, dtype=float)
    if values.size < 2:
        return values[0] + np.array([-0.5, 0.5])
    middles = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([[2.0 * values[0] - middles[0]], middles, [2.0 * values[-1] - middles[-1]]])


def motion_colour(member: xr.Dataset) -> str:
    """The colour of a motion's regime."""
    return REGIME_COLOURS[Regime(int(member["regime"]))]


def regime_cells(axes: Axes, x: Array, y: Array, regime: Any) -> None:
    """Cells in the colour of their regime: codes (y, x) between the borders ``x`` and ``y``; -1 is blank."""
    code_cells(axes, x, y, regime, [REGIME_COLOURS[r] for r in Regime])


def code_cells(axes: Axes, x: Array, y: Array, codes: Any, colours: list[str]) -> None:
    """Cells in the colour of their code from 0 on, (y, x), between the borders ``x`` and ``y``; -1 is blank."""
    from matplotlib.colors import BoundaryNorm, ListedColormap

    norm = BoundaryNorm(np.arange(len(colours) + 1) - 0.5, len(colours))
    axes.pcolormesh(x, y, np.ma.masked_less(codes, 0), cmap=ListedColormap(colours), norm=norm, rasterized=True)


def mark_failed(axes: Axes, x: Array, y: Array, failed: Any) -> None:
    """Hatches the cells whose run failed, (y, x), between the borders ``x`` and ``y``."""
    if not np.any(failed):
        return
    from matplotlib.collections import PolyCollection

    corners = [
        [(x[i], y[j]), (x[i + 1], y[j]), (x[i + 1], y[j + 1]), (x[i], y[j + 1])]
        for j, i in zip(*np.nonzero(failed), strict=True)
    ]
    cells = PolyCollection(corners, facecolors=GREY, edgecolors=BLACK, linewidths=0.0, hatch="////", rasterized=True)
    axes.add_collection(cells, autolim=False)


def mark_flagged(axes: Axes, x: Array, y: Array, flagged: Any) -> None:
    """Dots the cells whose evidence disagrees, (y, x), between the borders ``x`` and ``y``."""
    rows, columns = np.nonzero(flagged)
    size = float(np.clip(150.0 / np.shape(flagged)[1], 1.0, 3.0))
    across, up = 0.5 * (x[1:] + x[:-1])[columns], 0.5 * (y[1:] + y[:-1])[rows]
    axes.plot(across, up, ".", color=BLACK, ms=size, mew=0.0, rasterized=True)


def invalid_cells(cells: xr.Dataset, *dims: str) -> Any:
    """The cells in which the model does not hold, over ``dims``; none if the result does not state it."""
    where = invalid(cells)
    return np.zeros([cells.sizes[dim] for dim in dims], dtype=bool) if where is None else where.transpose(*dims).values


def mark_invalid(axes: Axes, x: Array, y: Array, where: Any) -> None:
    """Veils the cells in which the model does not hold, (y, x), unless these are all cells."""
    from matplotlib.colors import ListedColormap

    if np.any(where) and not np.all(where):
        veil = ListedColormap([INVALID])
        axes.pcolormesh(x, y, np.ma.masked_equal(where, False), cmap=veil, alpha=VEIL, rasterized=True, lw=0.0)


def invalid_legend(where: Any, failed: Any) -> list[Artist]:
    """The legend of cells in which the model does not hold, or the statement that these are all cells; failed cells
    have a mark of their own."""
    from matplotlib.patches import Patch

    if np.all(where) and np.size(where):
        return [Patch(facecolor="none", edgecolor="none", label=NOWHERE)]
    return [Patch(facecolor=INVALID, alpha=VEIL, label="model does not hold")] if np.any(where & ~failed) else []


def cell_legend(regime: Any, failed: Any, flagged: Any, outcome: Any) -> list[Artist]:
    """Legend handles for the regimes and marks that occur; failures are named by their outcomes."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Artist] = [
        Patch(facecolor=colour, label=kind.label)
        for kind, colour in REGIME_COLOURS.items()
        if np.any((np.asarray(regime) == kind) & ~np.asarray(failed))
    ]
    if np.any(failed):
        handles.append(Patch(facecolor=GREY, edgecolor=BLACK, lw=0.0, hatch="////", label=failed_in_words(outcome)))
    if np.any(flagged):
        handles.append(Line2D([], [], color=BLACK, marker=".", ms=4.0, ls="", label="evidence disagrees"))
    return handles
