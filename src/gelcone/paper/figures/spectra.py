"""Figure 8: spectra at three voltages, from the start and in the long run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from gelcone.codes import Regime
from gelcone.paper.figures.figure import paper_figure
from gelcone.paper.figures.marks import listed
from gelcone.paper.studies.triples import TRIPLES
from gelcone.plots.regime import motion_colour
from gelcone.plots.style import BLACK, GREY, styled
from gelcone.words import motion_in_words

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SEEN = {"base": 26.0, "fast": 13.0}
"""Highest frequency shown, over that of the voltage."""
LOWEST, HIGHEST = 1e-7, 20.0


def draw(studies: Mapping[str, xr.Dataset]) -> Figure:
    """Amplitude over frequency; a row for each voltage, a column for each parameter set."""
    study = studies["spectra"]

    def fill(figure: Figure) -> None:
        panels = figure.subplots(study.sizes["voltage"], study.sizes["set"], sharex="col", sharey=True)
        for (i, k), axes in np.ndenumerate(panels):
            member = study.isel(voltage=i, set=k)
            both_spectra(member, axes)
            axes.set_xlim(0.0, SEEN[str(member["set"].values)])
        for axes in panels[-1]:
            axes.set_xlabel("frequency / frequency of the voltage")
        for axes in panels[:, 0]:
            axes.set_ylabel("amplitude")
        legend(figure)

    return styled(7.2, 6.6, fill)


def both_spectra(member: xr.Dataset, axes: Axes) -> None:
    """Spectra of the first periods and of the long run, with marks at the frequencies of the voltage and of its
    force."""
    axes.set_yscale("log")
    axes.set_ylim(LOWEST, HIGHEST)
    for ratio, style in ((1.0, ":"), (2.0, "--")):
        axes.axvline(ratio, color=BLACK, lw=0.6, ls=style, zorder=0.5)
    for prefix, colour, width in (("early_", GREY, 1.2), ("", motion_colour(member), 0.8)):
        frequency, amplitude = member[f"{prefix}frequency_ratio"], member[f"{prefix}amplitude"]
        # the first bin is the mean displacement
        axes.plot(frequency[1:], amplitude.where(amplitude > 0.0)[1:], color=colour, lw=width, rasterized=True)
    axes.set_title(f"set {member['set'].item()}, $v$ = {float(member['voltage']):g}", loc="left")
    kind = motion_in_words(int(member["regime"]), int(member["period"]))
    axes.set_title(f"long run: {kind}", loc="right", fontsize=8.0)
    if Regime(int(member["regime"])) is Regime.REST:
        axes.text(0.98, 0.92, "no motion is left", ha="right", va="top", fontsize=8.0, transform=axes.transAxes)


def legend(figure: Figure) -> None:
    """Names the two windows of the spectra."""
    from matplotlib.lines import Line2D

    figure.legend(
        handles=[
            Line2D([], [], color=GREY, lw=1.4, label="from the start"),
            Line2D([], [], color=BLACK, lw=1.0, label="long run (coloured by its kind)"),
            Line2D([], [], color=BLACK, lw=0.6, ls=":", label="frequency of the voltage"),
            Line2D([], [], color=BLACK, lw=0.6, ls="--", label="frequency of its force"),
        ],
        loc="outside lower center",
        ncols=2,
    )


FIGURES = (paper_figure(8, ("spectra",), draw, voltages=listed(TRIPLES["voltage"][2])),)
