"""Figures of a time response: displacement, validity and voltage over time, and the phase portrait."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.codes import Outcome
from gelcone.plots.style import BLACK, BLUE, CYCLE, GREY, VERMILION, axis_label, name_axes, styled
from gelcone.words import evenly, members_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_LINES = 6
FAILINGS = {
    "film slack": ("hoop_slack", "meridional_slack"),
    "field too high": ("breakdown",),
    "near limit": ("near_limit",),
    "beyond membrane": ("beyond_membrane",),
}
"""Label of a failed assumption -> the flags of `gelcone.simulate` that report it."""

SLACK = {"hoop_slack": "hoop slack", "meridional_slack": "meridian slack", "crumpled": "crumpled"}
"""Label of each slack state of a wrinkling film."""


def response_figure(response: xr.Dataset) -> Figure:
    """Displacement and voltage over time, with the phase portrait; ensembles are drawn by `ensemble_figure`.

    Spans in which the model does not hold, or the film is slack, are marked between the two. A run that ended early is
    drawn to a little after its end.
    """
    (_, run), *others = members(response)
    if others:
        return ensemble_figure(response)
    response = up_to_end(run)
    failing = failings(response)
    heights = [1.8, 0.1 * len(failing), 0.8] if failing else [1.8, 0.8]

    def draw(figure: Figure) -> None:
        grid = figure.add_gridspec(len(heights), 2, width_ratios=[2.1, 1.0], height_ratios=heights)
        top = figure.add_subplot(grid[0, 0])
        bottom = figure.add_subplot(grid[-1, 0], sharex=top)
        time_response(response, top)
        top.set_xlabel("")
        top.tick_params(labelbottom=False)
        if failing:
            validity_strip(response, figure.add_subplot(grid[1, 0], sharex=top))
        voltages(response, bottom)
        figure.align_ylabels([top, bottom])
        phase_portrait(response, figure.add_subplot(grid[:, 1]))
        if "device" in response.attrs:
            figure.suptitle(response.attrs["device"], fontsize=9.0)

    return styled(7.2, 3.7, draw)


def ensemble_figure(response: xr.Dataset) -> Figure:
    """Displacement over time next to the phase portrait, a row for each of up to six members, on equal scales."""
    lines = members(response)

    def draw(figure: Figure) -> None:
        grid = figure.subplots(len(lines), 2, sharex="col", sharey="col", squeeze=False, width_ratios=[2.6, 1.0])
        for row, colour, (name, member) in zip(grid, CYCLE, lines, strict=False):
            row[0].plot(member["time"], member["displacement"], color=colour, lw=0.8)
            row[0].set_title(f"{name}{failure_note(member)}", loc="left", fontsize=7.5, pad=2.0)
            row[0].margins(x=0)
            halves(member, row[1], colour, colour, 0.4, 0.8)
        middle = grid[len(lines) // 2]
        middle[0].set_ylabel(axis_label(response["displacement"], "displacement"))
        middle[1].set_ylabel(axis_label(response["velocity"], "velocity"))
        grid[-1][0].set_xlabel(axis_label(response["time"], "time"))
        grid[-1][1].set_xlabel(axis_label(response["displacement"], "displacement"))

    return styled(7.2, 0.7 + 0.95 * len(lines), draw, response, picked(response))


def failure_note(member: xr.Dataset) -> str:
    """The failure of a member's run, or the assumptions that fail at times; empty if neither occurs."""
    if int(member["outcome"]):
        return f": failed, {Outcome(int(member['outcome'])).words}"
    unheld = [words for words, when in failings(member).items() if when.any()]
    return f" (at times {', '.join(unheld)})" if unheld else ""


def picked(response: xr.Dataset) -> str:
    """The number of members drawn, if not all are."""
    count = response["outcome"].size
    return f"{len(members(response))} of {count} members, evenly picked" if count > MOST_LINES else ""


def members(response: xr.Dataset) -> list[tuple[str, xr.Dataset]]:
    """The members to draw, each with its label; evenly picked if more than `MOST_LINES`."""
    chosen = members_of(response, evenly(response["outcome"].size, MOST_LINES))
    return [(name.replace("_", " "), member) for name, member in chosen]


def failings(response: xr.Dataset) -> dict[str, np.ndarray]:
    """Label -> samples of a single run at which it applies (time,): failed `FAILINGS` and slack states of wrinkling
    films, those that occur."""
    failing_samples = {
        words: np.any([response[flag].values for flag in flags if flag in response], axis=0)
        for words, flags in FAILINGS.items()
        if any(flag in response for flag in flags)
    }
    for name, prefix in (("film_state", ""), ("second_film_state", "2: ")):
        if name in response:
            for code, kind in enumerate(response[name].attrs["flag_meanings"].split()):
                if kind in SLACK:
                    failing_samples[prefix + SLACK[kind]] = response[name].values == code
    return {words: when for words, when in failing_samples.items() if when.any()}


def time_response(response: xr.Dataset, axes: Axes) -> None:
    """Displacement of a single run over time."""
    axes.plot(response["time"], response["displacement"], color=BLUE)
    if int(response["outcome"]):
        mark_end(response, axes)
    name_axes(axes, response["time"], response["displacement"])
    axes.margins(x=0)


def up_to_end(response: xr.Dataset) -> xr.Dataset:
    """A single run, cut a little after its end if it ended early."""
    ran = int(np.isfinite(response["displacement"].values).sum())
    return response.isel({response["displacement"].dims[-1]: slice(0, max(ran + ran // 8, 2))})


def mark_end(response: xr.Dataset, axes: Axes) -> None:
    """A cross where a single run ended early, with the reason."""
    ran = np.flatnonzero(np.isfinite(response["displacement"].values))
    if ran.size:
        at = float(response["time"][ran[-1]]), float(response["displacement"][ran[-1]])
        axes.plot(*at, "x", color=BLACK, ms=6.0, clip_on=False)
        words = Outcome(int(response["outcome"])).words.partition(":")[0]
        axes.annotate(words, at, (8.0, -2.0), textcoords="offset points", fontsize=8.0, va="top")


def validity_strip(response: xr.Dataset, axes: Axes) -> None:
    """A row of bars for each failed assumption or slack state during a single run, with its share of the samples."""
    time = response["time"].values
    ran = np.isfinite(response["displacement"].values)
    rows = failings(response)
    look: dict[str, Any] = {"va": "center", "fontsize": 6.5, "color": GREY}
    look |= {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
    for row, (words, when) in enumerate(rows.items()):
        axes.fill_between(time, row, row + 0.6, where=when, step="mid", color=GREY, lw=0.0)
        label = axes.annotate(words, (0.0, row + 0.3), (-4.0, 0.0), ha="right", **look)
        label.set_in_layout(False)  # the axis labels above and below already provide the room
        axes.annotate(f"{when[ran].mean():.0%}", (1.0, row + 0.3), (4.0, 0.0), **look)
    axes.set_ylim(len(rows), -0.4)
    axes.axis("off")


def voltages(response: xr.Dataset, axes: Axes) -> None:
    """Voltage on the film of a single run, that on the second film dashed; the commanded ones grey where they are
    others."""
    for film, style, width in (("", "-", 1.0), ("second_", "--", 0.8)):
        drive, on_film = f"{film}drive_voltage", f"{film}film_voltage"
        if on_film in response:
            axes.plot(response["time"], response[drive], color=GREY, ls=style, lw=0.6)
        if drive in response:
            axes.plot(response["time"], response.get(on_film, response[drive]), color=VERMILION, ls=style, lw=width)
    name_axes(axes, response["time"], response["drive_voltage"], y="voltage")


def phase_portrait(response: xr.Dataset, axes: Axes) -> None:
    """Velocity over displacement of a single run, with its first half faint."""
    halves(response, axes, GREY, BLUE, 0.5, 0.9)
    name_axes(axes, response["displacement"], response["velocity"])


def halves(run: xr.Dataset, axes: Axes, faint: str, colour: str, thin: float, wide: float) -> None:
    """Velocity over displacement: the first half of a run faint and thin, the second in full."""
    x, u = run["displacement"].values, run["velocity"].values
    settled = len(x) // 2
    axes.plot(x[: settled + 1], u[: settled + 1], color=faint, alpha=0.35, lw=thin)
    axes.plot(x[settled:], u[settled:], color=colour, lw=wide)
