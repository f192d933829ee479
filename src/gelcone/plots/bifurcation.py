"""Figures of bifurcation diagrams: section points, largest exponent or extent, slack film and regime over a
parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from gelcone.amounts import rate_unit
from gelcone.atlas.branches.attached import attached_branches
from gelcone.codes import Regime
from gelcone.errors import check_name
from gelcone.plots.branches import BRUTE_FORCE, draw_branches
from gelcone.plots.branches import legend as branch_legend
from gelcone.plots.regime import (
    cell_legend,
    edges,
    invalid_cells,
    mark_failed,
    mark_flagged,
    regime_cells,
    state_labels,
)
from gelcone.plots.response import SLACK
from gelcone.plots.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    REST_ROOM,
    SKY,
    VERMILION,
    YELLOW,
    axis_label,
    coordinate_axis,
    shade,
    styled,
)
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Colours of no regime, drawn in this order: small marks lie on top of large ones.
SWEEP_STYLES = {"down": (ORANGE, "v", 1.5), "up": (BLACK, "^", 1.0)}
FIXED_MARKERS = ("o", "s", "D", "P", "X")
SMALLEST_SHAPE = 1.5
PALE = 0.6
"""Share of white in the colour of points at which the model does not hold."""
NARROW = 0.01
"""Thresholds narrower than this share of the parameter's range are drawn as lines."""
MOST_LINES = 12
"""Most thresholds drawn through all panels; more are marked only on the strip of their branch."""


MIDDLES = ("exponent", "extent")
"""Contents of the panel between section points and regimes."""


def bifurcation_figure(diagram: xr.Dataset, middle: Literal["exponent", "extent"] = "exponent") -> Figure:
    """Section points over the parameter, above the largest exponent (or the extent of the motion) and the regime."""
    check_name("middle", middle, MIDDLES)
    name = diagram.attrs["parameter"]
    rows, followed = diagram.sizes["branch"], attached_branches(diagram)
    slack = slack_states(diagram)
    heights = [2.4 if followed is None else 5.0, 1.5, *([0.7] if slack else []), 0.22 * rows]

    def draw(figure: Figure) -> None:
        every = list(figure.subplots(len(heights), 1, sharex=True, height_ratios=heights))
        panels = [*every[:2], every[-1]]
        if slack:
            slack_shares(diagram, slack, every[2])
        section_points(diagram, panels[0], grey=followed is not None)
        (largest_exponent if middle == "exponent" else extent)(diagram, panels[1])
        if followed is not None:
            draw_branches(followed, panels[0], panels[1] if middle == "exponent" else None)
        regime_strip(diagram, panels[2])
        thresholds(diagram, panels)
        panels[0].set_xlim(*edges(diagram[name])[[0, -1]])
        named = None if followed is None else branch_legend(followed)
        panels[0].legend(handles=named, loc="upper left", bbox_to_anchor=(1.02, 1.0))
        handles = cell_legend(*marks(diagram), diagram["outcome"])
        panels[1].legend(
            handles=handles, loc="upper left", bbox_to_anchor=(1.02, 1.0), title="regime", alignment="left"
        )

    return styled(7.2, (4.4 if followed is None else 6.0) + 0.2 * rows + (0.7 if slack else 0.0), draw, diagram)


def branch_styles(diagram: xr.Dataset) -> dict[str, tuple[str, str, float]]:
    """Colour, marker and relative size of each branch in drawing order, fixed states first."""
    branches = [str(b) for b in diagram["branch"].values]
    fixed = [b for b in branches if b not in SWEEP_STYLES]
    styles = {b: (PURPLE, FIXED_MARKERS[i % len(FIXED_MARKERS)], 2.0) for i, b in enumerate(fixed)}
    return styles | {b: style for b, style in SWEEP_STYLES.items() if b in branches}


def marks_of(style: tuple[str, str, float], size: float) -> dict[str, Any]:
    """Marker keywords of a branch: the smallest markers are filled, larger ones open, so that those below show.

    Markers too small to show a shape are dots, larger for the branches drawn first.
    """
    colour, marker, scale = style
    if size < SMALLEST_SHAPE:
        return {"color": colour, "marker": "o", "ms": size * (0.5 + 0.7 * scale), "mfc": colour, "mew": 0.0}
    filled = scale == 1.0
    return {
        "color": colour,
        "marker": marker,
        "ms": size * scale,
        "mfc": colour if filled else "none",
        "mew": 0.0 if filled else 0.5,
    }


def marker_size(diagram: xr.Dataset) -> float:
    """Size of the smallest marker in points, small enough to separate neighbouring values where possible."""
    return float(np.clip(120.0 / diagram.sizes[diagram.attrs["parameter"]], 0.55, 2.4))


def section_points(diagram: xr.Dataset, axes: Axes, *, grey: bool = False) -> None:
    """Displacement once per forcing period over the parameter, grey below branches; failed runs are marked by a cross
    at the bottom."""
    name = diagram.attrs["parameter"]
    size = marker_size(diagram)
    for branch, style in branch_styles(diagram).items():
        sweep = diagram.sel(branch=branch)
        x = sweep["section"].isel(state=0).transpose(name, ...).values
        values = np.broadcast_to(diagram[name].values[:, None], x.shape)
        fails = invalid_cells(sweep, name)
        for chosen, pale in ((fails, True), (~fails, False)):
            look = marks_of((shade(style[0], PALE) if pale else style[0], *style[1:]), size)
            if grey:
                look = {"marker": ".", "color": BRUTE_FORCE, "ms": 1.5, "mec": "none"}
            axes.plot(values[chosen].ravel(), x[chosen].ravel(), ls="", rasterized=True, **look)
        axes.plot(
            [], [], ls="", label=branch, **marks_of(style, 3.0) | ({"marker": "o"} if size < SMALLEST_SHAPE else {})
        )
    if invalid_cells(diagram, "branch", name).any():
        axes.plot([], [], "o", color=shade(BLACK, PALE), ms=3.0, mew=0.0, label="pale: model\ndoes not hold")
    failed = (diagram["outcome"] != 0).any("branch").values
    if failed.any():
        at = diagram[name].values[failed]
        foot = axes.get_xaxis_transform()
        axes.plot(at, np.full(at.size, 0.04), "x", ms=4.0, color=BLACK, transform=foot, label="a run failed")
    if not np.nanmax(np.abs(diagram["section"].isel(state=0).values), initial=0.0) > REST_ROOM:
        axes.set_ylim(-REST_ROOM, REST_ROOM)
    axes.set_ylabel(f"{state_labels(diagram)[0]}\nonce per forcing period")


def largest_exponent(diagram: xr.Dataset, axes: Axes) -> None:
    """Largest exponent with its standard error, and the zero line."""
    axes.axhline(0.0, color=GREY, lw=0.8)
    size = marker_size(diagram)
    for branch, style in branch_styles(diagram).items():
        sweep = diagram.sel(branch=branch)
        value, error = (sweep[n].isel(exponent=0) for n in ("lyapunov", "standard_error"))
        along = sweep[diagram.attrs["parameter"]]
        if size < SMALLEST_SHAPE:
            axes.fill_between(along, value - error, value + error, color=style[0], alpha=0.35, lw=0.0)
            axes.plot(along, value, color=style[0], lw=0.5 + 0.4 * style[2])
        else:
            axes.errorbar(along, value, error, lw=0.5, elinewidth=0.7, **marks_of(style, size))
    axes.set_ylabel(f"largest exponent\n({rate_unit(diagram['lyapunov'])})")


def extent(diagram: xr.Dataset, axes: Axes) -> None:
    """Lowest and highest displacement."""
    size = marker_size(diagram)
    for branch, style in branch_styles(diagram).items():
        sweep = diagram.sel(branch=branch)
        for end in ("lowest", "highest"):
            axes.plot(sweep[diagram.attrs["parameter"]], sweep[end], lw=0.5, **marks_of(style, size))
    axes.set_ylabel(axis_label(diagram["lowest"], "lowest and highest\ndisplacement"))


def slack_states(diagram: xr.Dataset) -> list[str]:
    """The variables ``film_state_NAME`` of the slack states of a wrinkling film that occur in a diagram."""
    names = [f"{film}film_state_{state}" for film in ("", "second_") for state in SLACK]
    return [name for name in names if name in diagram and float(diagram[name].max()) > 0.0]


def slack_shares(diagram: xr.Dataset, names: list[str], axes: Axes) -> None:
    """The share of time in each slack state of the film, on the branch drawn on top."""
    (*_, branch) = branch_styles(diagram)
    sweep = diagram.sel(branch=branch)
    for colour, name in zip((SKY, GREEN, VERMILION, BLUE, YELLOW, GREY), names, strict=False):
        prefix = "2: " if name.startswith("second") else ""
        axes.plot(sweep[diagram.attrs["parameter"]], sweep[name], ".-", color=colour, ms=3.0, lw=0.8)
        axes.plot([], [], color=colour, label=prefix + SLACK[name.partition("film_state_")[2]])
    axes.set_ylim(-0.05, 1.05)
    axes.set_ylabel("share of\nthe time")
    axes.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0), title="film", alignment="left")


def regime_strip(diagram: xr.Dataset, axes: Axes) -> None:
    """The regime over the parameter, one row per branch."""
    name = diagram.attrs["parameter"]
    rows = np.arange(diagram.sizes["branch"])
    regime, failed, flagged = marks(diagram)
    for row, branch in enumerate(diagram["branch"].values):
        borders = refined_edges(diagram, str(branch)), np.array([row - 0.5, row + 0.5])
        regime_cells(axes, *borders, regime[[row]])
        mark_failed(axes, *borders, failed[[row]])
        mark_flagged(axes, *borders, flagged[[row]])
    axes.set_yticks(rows, [str(b) for b in diagram["branch"].values])
    axes.set_ylim(rows[-1] + 0.5, -0.5)
    axes.tick_params(axis="y", length=0.0)
    coordinate_axis(axes.xaxis, diagram, name)


def marks(diagram: xr.Dataset) -> tuple[Any, Any, Any]:
    """Regimes, failed runs, and runs with evidence against their regime, each (branch, value)."""
    ordered = diagram.transpose("branch", diagram.attrs["parameter"], ...)
    failed = ordered["outcome"].values != 0
    regime = ordered["regime"].values
    return regime, failed, (ordered["doubtful"].values != 0) & (regime != Regime.TRANSIENT) & ~failed


def refined_edges(diagram: xr.Dataset, branch: str) -> Array:
    """Borders of a branch's cells: halfway between values, or at the change of regime found by bisection."""
    values = diagram[diagram.attrs["parameter"]].values
    borders = edges(values)
    is_on_branch = diagram["threshold_branch"].values == branch
    low, high = diagram["threshold_low"].values[is_on_branch], diagram["threshold_high"].values[is_on_branch]
    borders[np.searchsorted(values, high)] = 0.5 * (low + high)
    return borders


def thresholds(diagram: xr.Dataset, panels: list[Axes]) -> None:
    """Intervals in which the regime changes: bars on the strip, and lines through the other panels if they are few."""
    styles = branch_styles(diagram)
    rows = {str(b): i for i, b in enumerate(diagram["branch"].values)}
    count = diagram.sizes["threshold"]
    across = float(np.ptp(diagram[diagram.attrs["parameter"]].values))
    for i in range(count):
        branch = str(diagram["threshold_branch"].values[i])
        low, high = float(diagram["threshold_low"][i]), float(diagram["threshold_high"][i])
        # a wide interval is a bar at the foot of its row, so that the regimes stay visible
        top = rows[branch] - 0.5 if high - low < NARROW * across else rows[branch] + 0.35
        panels[2].fill_betweenx([top, rows[branch] + 0.5], low, high, color=BLACK, lw=0.8)
        if count <= MOST_LINES:
            for axes in panels[:2]:
                axes.axvspan(low, high, color=styles[branch][0], alpha=0.5, lw=0.8, zorder=0.5)
    if count:
        shown = "vertical lines" if count <= MOST_LINES else "black on the strip below"
        panels[1].set_title(f"changes of regime: {count}, {shown}", loc="right", fontsize=8.0, color=GREY)
