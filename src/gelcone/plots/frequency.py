"""Figure of a frequency response: stroke in sweeps up and down, and its phase, compared with linear theory."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.atlas.branches.attached import attached_branches
from gelcone.motion.validity import invalid
from gelcone.plots.branches import (
    BRUTE_FORCE,
    DASHED,
    colour_of,
    ends_stability,
    event_marks,
    flags,
    stability_parts,
    with_neighbours,
)
from gelcone.plots.style import BLACK, BLUE, GREY, REST_ROOM, VERMILION, axis_label, log_ticks, say, styled
from gelcone.words import event_label, failed_in_words, kinds_of_motion

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
"""Phases of the sweeps below branches, whose colours mean periods."""
LINEAR: dict[str, Any] = {"color": GREY, "lw": 1.1, "ls": "--", "zorder": 1.5}
ORBITS: dict[str, dict[str, Any]] = {
    "stable": {"ls": "-", "lw": 1.5, "zorder": 2.5},
    "unstable": {"ls": DASHED, "lw": 1.0, "zorder": 2.2},
}
FEW = 60
"""Up to this many points are marked individually."""
FAINT = 0.3
UNHELD = "faint: the model does not hold"
WIDE = 5.0
"""Frequencies that span more than this ratio are drawn on a log scale."""


def frequency_figure(response: xr.Dataset) -> Figure:
    """Stroke over drive frequency above the phase of the driven harmonic, for a single actuator; with branches,
    the sweeps grey below them."""
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
        handles_and_labels = [
            one + other for one, other in zip(*(a.get_legend_handles_labels() for a in (stroke, phase)), strict=True)
        ]
        figure.legend(*handles_and_labels, loc="outside lower center", ncols=3)

    return styled(6.4, 5.0, draw, response)


def strokes(response: xr.Dataset, axes: Axes) -> None:
    """Both sweeps with their jumps, the motions that do not repeat with the drive, and the stroke by linear theory."""
    frequency = response["drive_frequency"].values
    for branch, look in LOOKS.items():
        own = response.sel(branch=branch)
        shown = look if frequency.size <= FEW else look | {"marker": ""}
        curve(own, axes, shown | {"label": f"swept {branch}"})
        failed = own["outcome"].values > 0
        at, label = frequency[failed], f"{failed_in_words(own['outcome'])}, {branch}"
        if at.size:
            mark = {"color": look["color"], "marker": "x", "ms": 4.5, "ls": "", "clip_on": False}
            axes.plot(at, np.zeros(at.size), **mark, label=label)
        for (label, which), fill in zip(kinds_of_motion(own).items(), ("white", BLACK), strict=True):
            axes.plot(
                frequency,
                own["stroke"].where(which),
                ls="",
                marker="o",
                ms=4.5,
                mfc=fill,
                mec=look["color"],
                mew=0.8,
                zorder=2.5,
                label=f"{label}, swept {branch}" if bool(which.any()) else None,
            )
        peak = 2.0 * own["peak_amplitude"]
        peak = peak.where(peak > REST_ROOM)
        named = f"highest, {branch}" if bool(peak.notnull().any()) else None
        axes.plot(own["peak_frequency"], peak, "D", ms=5.0, mfc="none", mec=look["color"], label=named)
    axes.plot(frequency, response["linear_stroke"], **LINEAR, label="linear theory")
    arrows(response, axes)
    top = float(np.nanmax([*response["stroke"].values.ravel(), *(2.0 * response["peak_amplitude"].values)]))
    # An unbounded linear resonance would compress everything else.
    if top > REST_ROOM:
        axes.set_ylim(0.0, 1.1 * top)
    else:
        axes.set_ylim(0.0, 1.0)
        axes.set_yticks([0.0])
        say(axes, "the disc stays at rest")
    axes.set_ylabel(axis_label(response["stroke"], "stroke, peak to peak"))


def branch_strokes(response: xr.Dataset, followed: xr.Dataset, axes: Axes) -> None:
    """Branches by their stroke, solid where stable, dashed where not, faint where the model does not hold; brute force
    grey below, and a marker for every event at an end of a stable part."""
    frequency = response["drive_frequency"].values
    grey: dict[str, Any] = {"ls": "", "marker": ".", "color": BRUTE_FORCE, "ms": 5.0, "mec": "none", "zorder": 1.0}
    brute = [*response["stroke"].values, *response["fixed_stroke"].values]
    for k, values in enumerate(brute):
        axes.plot(frequency, values, **grey, label=None if k else "brute force")
    labelled: set[str] = set()
    for k in range(followed.sizes["branch"]):
        own = followed.isel(branch=k)
        value, height = own["value"].values, (own["highest"] - own["lowest"]).values
        fails = invalid(own)
        held = np.ones(value.size, dtype=bool) if fails is None else ~fails.values
        period = int(own["period"])
        what = "rest" if bool(own["resting"]) else f"period {period}"
        for which, style in zip(stability_parts(own["stable"].values), ("stable", "unstable"), strict=True):
            look = {"color": colour_of(own), **ORBITS[style]}
            name = f"{what}, {style}"
            axes.plot(
                value,
                np.where(which & held, height, np.nan),
                **look,
                label=name if which.any() and name not in labelled else None,
            )
            # faint lines reach the next points that hold
            axes.plot(value, np.where(which & with_neighbours(~held), height, np.nan), **look | {"alpha": FAINT})
            if which.any():
                labelled.add(name)
        if not held[np.isfinite(value)].all() and UNHELD not in labelled:
            axes.plot([], [], color=BLACK, alpha=FAINT, lw=1.4, label=UNHELD)
            labelled.add(UNHELD)
    for k in range(followed.sizes["event"]):
        event = followed.isel(event=k)
        branch = followed.isel(branch=int(event["event_branch"]))
        if not ends_stability(branch, event):
            continue
        kind, at = event_label(event["event_kind"]), int(event["event_point"])
        beside = (branch["highest"] - branch["lowest"]).values[at : at + 2]
        marks = event_marks(kind, colour_of(branch), int(event["event_supercritical"]) != 0)
        label = None if kind in labelled else kind
        axes.plot([float(event["event_value"])], [beside.mean()], **marks, label=label)
        labelled.add(kind)
    axes.plot(frequency, response["linear_stroke"], **LINEAR, label="linear theory")
    flags(followed, axes)
    top = np.nanmax(
        [np.nanmax(response["stroke"].values), np.nanmax((followed["highest"] - followed["lowest"]).values)]
    )
    axes.set_ylim(0.0, 1.1 * float(top) if top > 0.0 else None)
    axes.set_ylabel(axis_label(response["stroke"], "stroke, peak to peak"))


def curve(own: xr.Dataset, axes: Axes, look: dict[str, Any]) -> None:
    """The strokes of one sweep through its refined peak, strong where the model holds and faint where it does not."""
    frequency, stroke = own["drive_frequency"].values, own["stroke"].values
    where = invalid(own)
    fails = np.zeros(frequency.size, dtype=bool) if where is None else where.values
    peak = float(own["peak_frequency"]), 2.0 * float(own["peak_amplitude"])
    at = int(np.searchsorted(frequency, peak[0]))
    new = np.isfinite(peak).all() and not np.isclose(frequency, peak[0], rtol=1e-12).any()
    if new:
        beside = fails[np.clip([at - 1, at], 0, frequency.size - 1)]
        frequency, stroke = (np.insert(old, at, value) for old, value in zip((frequency, stroke), peak, strict=True))
        fails = np.insert(fails, at, beside.any())
    marked = np.delete(np.arange(frequency.size), at) if new else np.arange(frequency.size)
    # each line continues to the next point of the other kind, so that no gaps are left
    holds = ~fails
    holds[1:] |= ~fails[:-1]
    axes.plot(frequency, stroke, **look | {"alpha": FAINT, "label": None}, markevery=marked.tolist())
    axes.plot(frequency, np.where(holds, stroke, np.nan), **look, markevery=marked.tolist())
    if fails.any() and not any(label == UNHELD for label in axes.get_legend_handles_labels()[1]):
        axes.plot([], [], color=BLACK, alpha=FAINT, lw=1.4, label=UNHELD)


def arrows(response: xr.Dataset, axes: Axes) -> None:
    """An arrow for each jump, in the colour of the sweep that jumps."""
    columns = (response[f"jump_{name}"].values for name in ("branch", "low", "high", "from", "to"))
    for branch, low, high, before, after in zip(*columns, strict=True):
        at = 0.5 * (low + high)
        style = {"arrowstyle": "->", "color": LOOKS[str(branch)]["color"], "lw": 1.2, "shrinkA": 0.0, "shrinkB": 0.0}
        axes.annotate("", (at, after), (at, before), arrowprops=style)


def phases(response: xr.Dataset, axes: Axes, looks: Mapping[str, dict[str, Any]] = LOOKS) -> None:
    """Phase of the harmonic that the drive excites most by linear theory."""
    harmonic = int(response["linear_amplitude"].max("drive_frequency").fillna(0.0).argmax("harmonic"))
    own = response.isel(harmonic=harmonic)
    frequency = response["drive_frequency"].values
    for branch, look in looks.items():
        values = _without_turns(own["harmonic_phase"].sel(branch=branch).values)
        axes.plot(frequency, values, **{name: look[name] for name in ("color", "lw", "ls", "label") if name in look})
    axes.plot(frequency, _without_turns(own["linear_phase"].values), **LINEAR)
    multiple = int(own["harmonic"])
    name = "phase" if multiple == 1 else f"phase at {multiple} x\nthe drive frequency"
    axes.set_ylabel(f"{name}\n(degrees)")
    axes.set_ylim(-315.0, 45.0)
    axes.set_yticks(np.arange(-270.0, 1.0, 90.0))


def _without_turns(phase: Any) -> Any:
    """Phases between -315 and 45 degrees, with a gap where the line would cross from one end to the other."""
    phase = (np.asarray(phase) + 315.0) % 360.0 - 315.0
    jumps = np.abs(np.diff(phase, append=phase[-1:])) > 180.0
    return np.where(jumps, np.nan, phase)
