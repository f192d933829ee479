"""The end of chaos: the number of chaotic voltages over the series resistance and over a branch's modulus and time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gelcone.paper.figures.figure import Table, paper_figure
from gelcone.paper.films import CREEPING, TAKEN, film_of_model
from gelcone.paper.reading import chaotic, finite_positive, positive
from gelcone.paper.studies.ends import COUNTED_OVER, MODULI, MODULUS, NAME, RESISTANCES, TIME, TIMES, VOLTAGES, Case
from gelcone.paper.truths import Share, share
from gelcone.plots.style import BLUE, GREY, VERMILION, styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class Row(NamedTuple):
    """A case with three shares of the voltages (with chaos, with positive exponents in the long run, and over the first
    window) and the count of an earlier version, NaN without one."""

    case: Case
    chaos: Share
    exponents: Share
    window: Share
    before: float


def rows_of(study: xr.Dataset) -> list[Row]:
    """The shares of each case."""
    numbers = (study[name].values for name in TAKEN)
    added = [Case(*map(float, case)) for case in zip(*numbers, strict=True)]
    shares = [map(share, read(study)) for read in (chaotic, positive, finite_positive)]
    return [Row(*row) for row in zip(added, *shares, map(float, study["counted"].values), strict=True)]


def table(studies: Mapping[str, xr.Dataset]) -> Table:
    """The counts in words, one row per case."""
    study = studies[NAME]
    head = (
        "added to the film",
        f"chaotic, of {study.sizes['voltage']} voltages",
        "with a positive exponent",
        f"positive over the first {study.attrs['window']:g} time units",
        f"positive over {COUNTED_OVER:g}, counted before",
    )
    rows = tuple(
        (words(row.case), *map(counted, row[1:4]), f"{row.before:.0f}" if np.isfinite(row.before) else "")
        for row in rows_of(study)
    )
    return Table(head, rows)


def counted(voltages: Share) -> str:
    """The number of voltages at which a statement holds, up to that with those at which it is open."""
    certain, most = voltages.holding, voltages.holding + voltages.open
    return f"{certain} to {most}" if voltages.open else str(certain)


def words(case: Case) -> str:
    """A case in words."""
    if case.resistance:
        return f"resistance rho = {case.resistance:g}"
    return f"branch g = {case.modulus:g}, tau = {case.time:g}" if case.modulus else "nothing"


def draw(studies: Mapping[str, xr.Dataset]) -> Figure:
    """Counts over the resistance, the modulus and the relaxation time of a branch."""
    rows = sorted(rows_of(studies[NAME]))
    nothing = next(row for row in rows if row.case == Case())
    panels = (
        (r"series resistance $\rho$", "resistance", [row for row in rows if row.case.resistance]),
        (rf"modulus $g$ at $\tau$ = {TIME:g}", "modulus", [row for row in rows if row.case.time == TIME]),
        (rf"time $\tau$ at $g$ = {MODULUS:g}", "time", [row for row in rows if row.case.modulus == MODULUS]),
    )

    def fill(figure: Figure) -> None:
        for axes, (label, over, shown) in zip(figure.subplots(1, 3, sharey=True), panels, strict=True):
            _panel(axes, over, shown, nothing.chaos)
            axes.set_xlabel(label)
        figure.axes[0].set_ylabel(f"chaotic voltages of {studies[NAME].sizes['voltage']}")
        figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)

    return styled(7.2, 2.7, fill)


def _panel(axes: Axes, over: str, rows: list[Row], nothing: Share) -> None:
    values = [getattr(row.case, over) for row in rows]
    top = nothing.holding + nothing.open
    axes.axhspan(nothing.holding - 0.1, top + 0.1, color=GREY, alpha=0.4, lw=0, label="elastic film, ideal source")
    certain, above = [row.chaos.holding for row in rows], [[0.0] * len(rows), [row.chaos.open for row in rows]]
    look: dict[str, Any] = {"fmt": "o", "ms": 3.5, "color": BLUE, "capsize": 2.5}
    axes.errorbar(values, certain, yerr=above, label="chaotic, with what is not decided", **look)
    axes.plot(values, [row.before for row in rows], "s", ms=7.0, mfc="none", color=VERMILION, label="counted before")
    axes.set_xscale("log")
    axes.set_ylim(-0.5, VOLTAGES.size + 0.5)


FIGURES = (
    paper_figure(
        "end-of-chaos",
        (NAME,),
        draw,
        table,
        voltages=VOLTAGES.size,
        lowest=float(VOLTAGES[0]),
        highest=float(VOLTAGES[-1]),
        megohm=film_of_model(CREEPING)["series_resistance"],
        resistances=f"{min(RESISTANCES):g} to {max(RESISTANCES):g}",
        moduli=f"{min(MODULI):g} to {max(MODULI):g}",
        times=f"{min(TIMES):g} to {max(TIMES):g}",
        modulus=MODULUS,
        time=TIME,
        counted_over=COUNTED_OVER,
    ),
)
