"""Figure of a frequency response: stroke in sweeps up and down, its phase, and linear theory."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.atlas.branches.attached import attached_branches
from gelcone.plots.branches import BRUTE_FORCE, branches_of, colour_of, events, flags
from gelcone.plots.branches import legend as branch_legend
from gelcone.plots.regime import invalid_cells
from gelcone.plots.style import (
    BLACK,
    BLUE,
    GREY,
    REST_ROOM,
    UNHELD,
    VERMILION,
    axis_label,
    log_ticks,
    name_faint,
    say,
    styled,
)
from gelcone.quantity import Array
from gelcone.words import failed_in_words, kinds_of_motion

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOOKS: dict[str, dict[str, Any]] = {
    "up": {"color": BLUE, "lw": 1.4, "marker": "^", "ms": 3.0},
    "down": {"color": VERMILION, "lw": 0.9, "marker": "v", "ms": 3.0},
}
GREYS: dict[str, dict[str, Any]] = {
    "up": {"color": BRUTE_FORCE, "lw": 1.6, "label": "phase, swept up"},
    "down": {"color": BLACK, "lw": 0.7, "ls": ":", "label": "phase, swept down"},
}
"""Phases of the sweeps in figures with branches, whose colours mean periods."""
RINGS: dict[str, Any] = {"ls": "", "marker": "o", "ms": 4.5, "mew": 0.8, "zorder": 2.5}
"""Motions that do not repeat with the drive."""
LINEAR: dict[str, Any] = {"color": GREY, "lw": 1.1, "ls": "--", "zorder": 1.5}
FEW = 60
"""Most points that are marked individually."""
WIDE = 5.0
"""Frequencies that span more than this ratio have a log axis."""


def frequency_figure(response: xr.Dataset) -> Figure:
    """Stroke over drive frequency above the phase of the driven harmonic, of a single actuator; with branches the
    sweeps are grey behind them."""
    followed = attached_branches(response)

    def draw(figure: Figure) -> None:
        stroke, phase = figure.subplots(2, 1, sharex=True, height_ratios=[2.2 if followed is None else 3.0, 1.0])
        if followed is None:
            strokes(response, stroke)
        else:
            branch_strokes(response, followed, stroke)
        phases(response, phase, LOOKS if followed is None else GREYS)
        frequency = response["drive_frequency"]
        if float(frequency[-1] / frequency[0]) > WIDE:
            log_ticks(phase)
        phase.set_xlim(float(frequency[0]), float(frequency[-1]))
        phase.set_xlabel(axis_label(frequency, "drive frequency"))
        handles = [] if followed is None else branch_legend(followed, mirrored=False)
        handles += [handle for axes in (stroke, phase) for handle in axes.get_legend_handles_labels()[0]]
        figure.legend(handles=handles, loc="outside lower center", ncols=3)

    return styled(6.4, 5.0, draw, response)


def strokes(response: xr.Dataset, axes: Axes) -> None:
    """Both sweeps with their jumps, motions that do not repeat with the drive, and the stroke of linear theory."""
    frequency = response["drive_frequency"].values
    for branch, look in LOOKS.items():
        sweep = response.sel(branch=branch)
        shown = look if frequency.size <= FEW else look | {"marker": ""}
        curve(sweep, axes, shown | {"label": f"swept {branch}"})
        failed = sweep["outcome"].values > 0
        at, label = frequency[failed], f"{failed_in_words(sweep['outcome'])}, {branch}"
        if at.size:
            mark = {"color": look["color"], "marker": "x", "ms": 4.5, "ls": "", "clip_on": False}
            axes.plot(at, np.zeros(at.size), **mark, label=label)
        for (label, which), fill in zip(kinds_of_motion(sweep).items(), ("white", BLACK), strict=True):
            name = f"{label}, swept {branch}" if bool(which.any()) else None
            axes.plot(frequency, sweep["stroke"].where(which), **RINGS, mfc=fill, mec=look["color"], label=name)
        peak = 2.0 * sweep["peak_amplitude"]
        peak = peak.where(peak > REST_ROOM)
        named = f"highest, {branch}" if bool(peak.notnull().any()) else None
        axes.plot(sweep["peak_frequency"], peak, "D", ms=5.0, mfc="none", mec=look["color"], label=named)
    linear_strokes(response, axes)
    arrows(response, axes)
    strokes = np.array([*response["stroke"].values.ravel(), *(2.0 * response["peak_amplitude"].values)])
    top = float(strokes[np.isfinite(strokes)].max(initial=0.0))
    # linear theory may be unbounded at resonance, and must not set the scale
    if top > REST_ROOM:
        axes.set_ylim(0.0, 1.1 * top)
    else:
        axes.set_ylim(0.0, 1.0)
        axes.set_yticks([0.0])
        say(axes, "the disc stays at rest" if np.isfinite(strokes).any() else "no motion is found")
    axes.set_ylabel(axis_label(response["stroke"], "stroke, peak to peak"))


def branch_strokes(response: xr.Dataset, followed: xr.Dataset, axes: Axes) -> None:
    """The stroke of each branch, faint where the model does not hold, with events and flags, over grey brute force."""
    frequency = response["drive_frequency"].values
    grey: dict[str, Any] = {"ls": "", "marker": ".", "color": BRUTE_FORCE, "ms": 5.0, "mec": "none", "zorder": 1.0}
    for values in (*response["stroke"].values, *response["fixed_stroke"].values):
        axes.plot(frequency, values, **grey)
    for branch, parts in branches_of(followed):
        for which, style, width, alpha in parts:
            height = np.where(which, stroke_of(branch), np.nan)
            look = {"color": colour_of(branch), "ls": style, "lw": width, "alpha": alpha}
            axes.plot(branch["value"], height, **look, zorder=2.2 + 0.3 * (style == "-"))
    events(followed, axes, stroke_of_event)
    linear_strokes(response, axes)
    flags(followed, axes)
    top = np.nanmax([np.nanmax(response["stroke"].values), np.nanmax(stroke_of(followed))])
    axes.set_ylim(0.0, 1.1 * float(top) if top > 0.0 else None)
    axes.set_ylabel(axis_label(response["stroke"], "stroke, peak to peak"))


def linear_strokes(response: xr.Dataset, axes: Axes) -> None:
    """The strokes by linear theory, through the largest of them also between the frequencies."""
    frequency, stroke = response["drive_frequency"].values, response["linear_stroke"].values
    if "linear_peak_stroke" in response:  # not in files of 0.2
        peak = float(response["linear_peak_frequency"]), float(response["linear_peak_stroke"])
        frequency, stroke, _ = through(frequency, stroke, peak)
    axes.plot(frequency, stroke, **LINEAR, label="linear theory")


def through(frequency: Array, stroke: Array, peak: tuple[float, float]) -> tuple[Array, Array, int | None]:
    """Strokes over the frequency with a ``peak`` between them, and its place; None for one that is unknown or there."""
    if not np.isfinite(peak).all() or np.isclose(frequency, peak[0], rtol=1e-12).any():
        return frequency, stroke, None
    at = int(np.searchsorted(frequency, peak[0]))
    return np.insert(frequency, at, peak[0]), np.insert(stroke, at, peak[1]), at


def stroke_of(branch: xr.Dataset) -> Array:
    """Stroke of each orbit."""
    return np.asarray((branch["highest"] - branch["lowest"]).values)


def stroke_of_event(branch: xr.Dataset, event: xr.Dataset) -> Array:
    """Stroke at an event, (1,): the mean of its neighbouring points."""
    at = int(event["event_point"])
    return stroke_of(branch)[at : at + 2].mean(keepdims=True)


def curve(own: xr.Dataset, axes: Axes, look: dict[str, Any]) -> None:
    """The strokes of one sweep through its refined peak; faint where the model does not hold."""
    frequency, stroke = own["drive_frequency"].values, own["stroke"].values
    fails = invalid_cells(own, "drive_frequency")
    peak = float(own["peak_frequency"]), 2.0 * float(own["peak_amplitude"])
    frequency, stroke, at = through(frequency, stroke, peak)
    marked = np.arange(frequency.size)
    if at is not None:
        fails = np.insert(fails, at, fails[np.clip([at - 1, at], 0, fails.size - 1)].any())
        marked = np.delete(marked, at)
    # each line continues to the next point of the other kind, so that no gaps are left
    holds = ~fails
    holds[1:] |= ~fails[:-1]
    axes.plot(frequency, stroke, **look | {"alpha": UNHELD, "label": None}, markevery=marked.tolist())
    axes.plot(frequency, np.where(holds, stroke, np.nan), **look, markevery=marked.tolist())
    name_faint(axes, fails)


def arrows(response: xr.Dataset, axes: Axes) -> None:
    """An arrow for each jump, in the colour of the sweep."""
    columns = (response[f"jump_{name}"].values for name in ("branch", "low", "high", "from", "to"))
    for branch, low, high, before, after in zip(*columns, strict=True):
        at = 0.5 * (low + high)
        style = {"arrowstyle": "->", "color": LOOKS[str(branch)]["color"], "lw": 1.2, "shrinkA": 0.0, "shrinkB": 0.0}
        axes.annotate("", (at, after), (at, before), arrowprops=style)


def phases(response: xr.Dataset, axes: Axes, looks: Mapping[str, dict[str, Any]] = LOOKS) -> None:
    """Phase of the harmonic that the drive excites most according to linear theory."""
    harmonic = int(response["linear_amplitude"].max("drive_frequency").fillna(0.0).argmax("harmonic"))
    at_harmonic = response.isel(harmonic=harmonic)
    frequency = response["drive_frequency"].values
    for branch, look in looks.items():
        values = _without_turns(at_harmonic["harmonic_phase"].sel(branch=branch).values)
        axes.plot(frequency, values, **{name: look[name] for name in ("color", "lw", "ls", "label") if name in look})
    axes.plot(frequency, _without_turns(at_harmonic["linear_phase"].values), **LINEAR)
    multiple = int(at_harmonic["harmonic"])
    name = "phase" if multiple == 1 else f"phase at {multiple} x\nthe drive frequency"
    axes.set_ylabel(f"{name}\n(degrees)")
    axes.set_ylim(-315.0, 45.0)
    axes.set_yticks(np.arange(-270.0, 1.0, 90.0))


def _without_turns(phase: Any) -> Any:
    """Phases between -315 and 45 degrees, with gaps where the line would wrap."""
    phase = (np.asarray(phase) + 315.0) % 360.0 - 315.0
    jumps = np.abs(np.diff(phase, append=phase[-1:])) > 180.0
    return np.where(jumps, np.nan, phase)
