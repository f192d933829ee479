"""Figures 4, 5, 7, 10 and 11: motions at three values of one parameter, over a window and in the long run."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

from gelcone.codes import Regime
from gelcone.paper.figures.figure import paper_figure
from gelcone.paper.figures.marks import SYMBOLS, film_legend, fixed_parameters, listed, mark_slack
from gelcone.paper.studies.triples import TRIPLES
from gelcone.plots.regime import REGIME_COLOURS, motion_colour
from gelcone.plots.style import BLACK, GREY, styled
from gelcone.words import motion_in_words

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LATE_SPAN = 200.0
"""Time of the long run shown over time; the phase plane shows twice as much."""
LITTLE = 0.1
SMALLEST_ERROR = 0.0001
SQUAREST = 0.25
"""Least ratio of height to width of a section, and of width to height, so that rounding does not fill the panel."""


def draw(name: str, studies: Mapping[str, xr.Dataset]) -> Figure:
    """Time response at first and in the long run, phase portrait and section, one column per value."""
    study = studies[name]
    parameter = study.attrs["parameter"]

    def fill(figure: Figure) -> None:
        rows = figure.subplots(4, study.sizes[parameter], height_ratios=[1.0, 0.8, 1.25, 1.25])
        for k, column in enumerate(rows.T):
            member = study.isel({parameter: k})
            column[0].set_title(f"{SYMBOLS[parameter]} = {float(member[parameter]):.4g}", loc="left", pad=40.0)
            column[0].annotate(
                caption(member), (0.0, 1.0), (0.0, 6.0), "axes fraction", "offset points", fontsize=7.5, va="bottom"
            )
            from_the_start(member, column[0])
            in_the_long_run(member, column[1])
            if not driven_little(member):
                column[1].set_ylim(column[0].get_ylim())
            phase_portrait(member, column[2])
            poincare_section(member, column[3])
            for axes in column:
                axes.tick_params(labelsize=7.5)
                axes.xaxis.label.set_size(8.0)
        words = ("displacement", "displacement", "phase portrait\nvelocity", "Poincaré section\nvelocity")
        for axes, label in zip(rows[:, 0], words, strict=True):
            axes.set_ylabel(label)
        figure.align_ylabels(rows[:, 0])
        figure.suptitle(fixed_parameters(study), fontsize=8.0, color=GREY)
        film_legend(figure, [Regime(int(kind)) for kind in study["regime"].values])

    return styled(7.2, 8.6, fill)


def caption(member: xr.Dataset) -> str:
    """The largest exponent over the window, and the regime with its exponent in the long run, in words."""
    kind = motion_in_words(int(member["regime"]), int(member["period"]))
    window, long_run, error = (float(member[n][0]) for n in ("finite", "lyapunov", "standard_error"))
    spread = f"\\pm {error:.4f}" if error >= SMALLEST_ERROR else f"\\pm{{}}<{SMALLEST_ERROR:g}"
    return f"window: $\\lambda_1 = {window:+.4f}$\nlong run: {kind},\n$\\lambda_1 = {long_run:+.4f} {spread}$"


def driven_little(member: xr.Dataset) -> bool:
    """Whether the long run is too small to show on the scale of the window."""
    late, window = (float(member[f"{n}_highest"] - member[f"{n}_lowest"]) for n in ("late", "window"))
    return Regime(int(member["regime"])) is not Regime.REST and late < LITTLE * window


def from_the_start(member: xr.Dataset, axes: Axes) -> None:
    """Displacement over the window, with the share of it in which the film is slack."""
    mark_slack(axes, member["time"], member["displacement"], member["slack"], BLACK)
    slack_share(axes, float(member["window_validity_slack"]))
    axes.margins(x=0.0, y=0.18)
    axes.set_xlabel("time from the start")


def in_the_long_run(member: xr.Dataset, axes: Axes) -> None:
    """Displacement over part of the long run, with the share of all of it in which the film is slack."""
    shown = member.sel(late_time=slice(0.0, LATE_SPAN))
    mark_slack(axes, shown["late_time"], shown["late_displacement"], shown["late_slack"], motion_colour(member))
    slack_share(axes, float(member["late_validity_slack"]))
    axes.margins(x=0.0, y=0.3)
    axes.set_xlabel("after the transient" + (" (enlarged)" if driven_little(member) else ""))


def slack_share(axes: Axes, share: float) -> None:
    """Writes the share of time with slack film into a panel."""
    text = f"slack {100.0 * share:.0f} %"
    axes.annotate(text, (1.0, 1.0), xycoords="axes fraction", ha="right", va="top", fontsize=7.0, color=GREY)


def phase_portrait(member: xr.Dataset, axes: Axes) -> None:
    """Velocity over displacement: the window in grey, the long run in the colour of its regime."""
    colour = motion_colour(member)
    axes.plot(member["displacement"], member["velocity"], color=GREY, lw=0.5, alpha=0.7, rasterized=True)
    shown = member.sel(late_time=slice(0.0, 2.0 * LATE_SPAN))
    x, u = shown["late_displacement"], shown["late_velocity"]
    axes.plot(x, u, color=colour, lw=0.6, rasterized=True)
    if Regime(int(member["regime"])) is Regime.REST or driven_little(member):
        axes.plot(x[-1:], u[-1:], "o", color=colour, ms=5.0)
    axes.set_xlabel("displacement")


def poincare_section(member: xr.Dataset, axes: Axes) -> None:
    """Velocity over displacement once per forcing period: crosses for the window, dots for the long run."""
    early = member["early_section_displacement"].values, member["early_section_velocity"].values
    late = member["section_displacement"].values, member["section_velocity"].values
    axes.plot(*early, "x", color=GREY, ms=3.5, mew=0.8)
    kind = Regime(int(member["regime"]))
    size = 1.4 if kind in (Regime.CHAOTIC, Regime.QUASI_PERIODIC, Regime.TRANSIENT) else 5.0
    axes.plot(*late, "o", color=REGIME_COLOURS[kind], ms=size, mew=0.0, rasterized=True)
    axes.margins(0.12)
    axes.set_xlabel("displacement")
    keep_open(axes)


def keep_open(axes: Axes) -> None:
    """Widens the limits of a phase plane that is much longer than wide."""
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    width, height = max(right - left, SQUAREST * (high - low)), max(high - low, SQUAREST * (right - left))
    axes.set_xlim(0.5 * (left + right - width), 0.5 * (left + right + width))
    axes.set_ylim(0.5 * (low + high - height), 0.5 * (low + high + height))


FIGURES = tuple(
    paper_figure(number, (name,), partial(draw, name), values=listed(TRIPLES[name][2]))
    for number, name in ((4, "damping"), (5, "limit"), (7, "voltage"), (10, "prestretch"), (11, "spring"))
)
