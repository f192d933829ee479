"""Figures of basins of attraction: the attractor that each initial state ends on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.codes import Regime
from gelcone.plots.map import borders_of, mark_cells, marks
from gelcone.plots.map import legend as cell_legend
from gelcone.plots.regime import REGIME_COLOURS, code_cells, regime_cells
from gelcone.plots.style import shade, styled
from gelcone.words import attractor_in_words

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_ATTRACTORS = 8
"""Most attractors with a colour and legend entry of their own; the others share one."""
SHADES = (0.0, 0.55, -0.45, 0.8, -0.7)
"""Attractors of one regime: its colour, mixed by these shares with white (above 0) or black (below 0)."""
OTHERS = "#FFFFFF"


def basin_figure(cells: xr.Dataset) -> Figure:
    """The attractor of each initial state, with its regime, period, extent and share of the grid."""
    order = {"displacement": -2, "velocity": -1}  # then other states
    cells = cells.transpose(*sorted(cells["attractor"].dims, key=lambda name: order.get(str(name), 0)), ...)
    handles = legend(cells)

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        attractor_map(cells, axes)
        axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.0, 1.0), labelspacing=0.7)

    return styled(6.2, max(3.4, 0.6 + 0.36 * len(handles)), draw, cells)


def attractor_map(cells: xr.Dataset, axes: Axes) -> None:
    """Cells in the colour of their attractor, or of their regime where they have none; failed ones hatched."""
    regime, borders = marks(cells)[0], borders_of(cells)
    regime_cells(axes, *borders, regime)
    number = cells["attractor"].values.T
    colours = attractor_colours(cells)
    if colours:
        code_cells(axes, *borders, np.minimum(number, len(colours) - 1), colours)
    mark_cells(cells, axes, regime != Regime.TRANSIENT)
    axes.set_xlabel(f"initial {axes.get_xlabel()}")
    axes.set_ylabel(f"initial {axes.get_ylabel()}")


def attractor_colours(cells: xr.Dataset) -> list[str]:
    """A shade of the regime's colour for each attractor, and one colour for all beyond `MOST_ATTRACTORS`."""
    regimes = [Regime(int(r)) for r in cells["attractor_regime"].values]
    shown = regimes[:MOST_ATTRACTORS]
    colours = [shade(REGIME_COLOURS[r], SHADES[shown[:i].count(r) % len(SHADES)]) for i, r in enumerate(shown)]
    return colours + [OTHERS] * (len(regimes) > len(shown))


def legend(cells: xr.Dataset) -> list[Artist]:
    """A patch for each attractor, and handles of the other marks that occur."""
    from matplotlib.patches import Patch

    colours, count = attractor_colours(cells), cells.sizes["attractor_number"]
    handles: list[Artist] = [
        Patch(facecolor=colours[n], label=attractor_in_words(cells.isel(attractor_number=n)))
        for n in range(min(count, MOST_ATTRACTORS))
    ]
    if count > MOST_ATTRACTORS:
        share = float(cells["attractor_share"][MOST_ATTRACTORS:].sum())
        label = f"{count - MOST_ATTRACTORS} more attractors: {100.0 * share:.3g} %"
        handles.append(Patch(facecolor=OTHERS, edgecolor="black", lw=0.5, label=label))
    unsettled = cells["regime"].where(cells["regime"] == Regime.TRANSIENT, -1)
    return handles + cell_legend(cells.assign(regime=unsettled), marks(cells)[0] != Regime.TRANSIENT)
