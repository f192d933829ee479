"""Figures of branches: orbits over the parameter with brute force behind them, and their exponents with the events."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone.amounts import rate_unit
from gelcone.motion.validity import invalid
from gelcone.plots.regime import NOWHERE
from gelcone.plots.style import BLACK, CYCLE, GREY, UNHELD, UNHELD_LABEL, VERMILION, axis_label, styled
from gelcone.quantity import Array
from gelcone.words import event_label

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Which = npt.NDArray[np.bool_]
"""Mask of points along a line."""
LIGHTER = 0.35
"""Opacity of a branch's mirror image, relative to the branch."""
DASHED = (0, (2.5, 1.5))
MARKERS = {
    "fold": "s",
    "period doubling": "D",
    "symmetry breaking": "P",
    "loss of rest": "o",
    "torus": "h",
    "cusp": "*",
    "generalised doubling": "X",
    "degenerate symmetry breaking": "d",
}
BRUTE_FORCE = "#aaaaaa"
FEW = 2
"""Longest period with full lines and markers; unstable orbits of longer periods are faint, and their events ticks
alone."""
FAINT = 0.25


def branches_figure(result: xr.Dataset) -> Figure:
    """Displacement once per forcing period over the parameter, and the largest exponent of every orbit."""

    def draw(figure: Figure) -> None:
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2.2, 1.0])
        brute_force(result, above)
        draw_branches(result, above, below)
        above.set_ylabel(axis_label(result["lowest"], "displacement\nonce per forcing period"))
        values = result["value"].values
        above.set_xlim(np.nanmin(values), np.nanmax(values))
        below.set_xlabel(axis_label(result["value"], result.attrs["parameter"]))
        above.legend(handles=legend(result), loc="upper left", bbox_to_anchor=(1.02, 1.0))

    return styled(7.2, 5.2, draw, result)


def draw_branches(result: xr.Dataset, above: Axes, below: Axes | None) -> None:
    """Orbits with their events and flags, and their exponents below, if asked."""
    orbits(result, above)
    events(result, above)
    if below is not None:
        exponents(result, below)
    event_ticks(result, (above,) if below is None else (above, below))
    flags(result, above)


def brute_force(result: xr.Dataset, axes: Axes) -> None:
    """Settled motions as grey dots behind everything."""
    section = result["run_section"].values[..., 0]
    at = np.broadcast_to(result["run_value"].values[:, None], section.shape)
    axes.plot(at.ravel(), section.ravel(), ".", ms=2.0, color=BRUTE_FORCE, mec="none", zorder=1.0, rasterized=True)


def colour_of(branch: xr.Dataset) -> str:
    """The colour of a branch: black for rest, otherwise by period."""
    if bool(branch["resting"]):
        return BLACK
    return CYCLE[int(np.log2(int(branch["period"]))) % len(CYCLE)]


def sections_of(branch: xr.Dataset) -> Array:
    """Displacement at the beginning of each repeat, (points, period)."""
    per, period = int(branch["nodes_per_repeat"]), int(branch["period"])
    return np.asarray(branch["orbit"].values[:, : per * period : per, 0])


def stability_parts(stable: Array) -> tuple[Which, Which]:
    """Masks of the points drawn as stable and as unstable; the unstable line reaches the first stable points."""
    inside, outside = stable == 1, stable == 0
    return inside, outside | (inside & with_neighbours(outside))


def with_neighbours(which: Which) -> Which:
    """The mask extended by one point on either side."""
    extended = which.copy()
    extended[1:] |= which[:-1]
    extended[:-1] |= which[1:]
    return extended


def orbits(result: xr.Dataset, axes: Axes) -> None:
    """All branches, solid where stable and dashed where unstable; mirror images in a lighter tone."""
    for branch, parts in branches_of(result):
        colour, value, lines = colour_of(branch), branch["value"].values, sections_of(branch)
        image = has_mirror(result) and not bool(branch["symmetric"]) and not bool(branch["resting"])
        for which, style, width, alpha in parts:
            shown, look = np.where(which[:, None], lines, np.nan), {"color": colour, "ls": style, "lw": width}
            axes.plot(value, shown, **look, alpha=alpha, zorder=2.0 + (style == "-"))
            if image:
                axes.plot(value, -shown, **look, alpha=LIGHTER * alpha, zorder=1.9)


Part = tuple[Which, Any, float, float]
"""Points of a branch that are drawn alike, with line style, width and opacity."""


def branches_of(result: xr.Dataset) -> Iterator[tuple[xr.Dataset, list[Part]]]:
    """Each branch with its parts."""
    fails = unheld(result)
    for k in range(result.sizes["branch"]):
        branch = result.isel(branch=k)
        yield branch, list(_parts(branch, fails[k]))


def _parts(branch: xr.Dataset, fails: Which) -> Iterator[Part]:
    """The stable and the unstable part of a branch, and their faint parts where the model fails."""
    faint = 1.0 if int(branch["period"]) <= FEW else FAINT
    inside, outside = stability_parts(branch["stable"].values)
    for which, style, width, alpha in ((inside, "-", 1.3, 1.0), (outside, DASHED, 0.7 * np.sqrt(faint), faint)):
        yield which & ~fails, style, width, alpha
        if (which & fails).any():  # reaches the next points that hold, so that no gaps are left
            yield which & with_neighbours(fails), style, width, UNHELD * alpha


def holds_nowhere(result: xr.Dataset) -> bool:
    """Whether the model holds at no point of any branch."""
    fails = invalid(result)
    return fails is not None and bool(fails.values[np.isfinite(result["value"].values)].all())


def unheld(result: xr.Dataset) -> Which:
    """Mask of the points at which the model does not hold, (branches, points), unless it holds nowhere."""
    fails = invalid(result)
    return np.zeros(result["value"].shape, dtype=bool) if fails is None or holds_nowhere(result) else fails.values


def has_mirror(result: xr.Dataset) -> bool:
    """Whether motions have mirror images, which is where the flat film is at rest."""
    return bool(result.attrs.get("mirror", 0))


def section_of_event(branch: xr.Dataset, event: xr.Dataset) -> Array:
    """Displacement of an event's orbit at the beginning of each repeat, (period,)."""
    per, period = int(branch["nodes_per_repeat"]), int(branch["period"])
    return np.asarray(event["event_orbit"].values[: per * period : per, 0])


def events(
    result: xr.Dataset, axes: Axes, heights: Callable[[xr.Dataset, xr.Dataset], Array] = section_of_event
) -> None:
    """A marker for each event, open if subcritical, at the ``heights`` of its branch and event."""
    for k in range(result.sizes["event"]):
        event = result.isel(event=k)
        branch = result.isel(branch=int(event["event_branch"]))
        kind, period = event_label(event["event_kind"]), int(branch["period"])
        if period > FEW and not ends_stability(branch, event):
            continue
        at = heights(branch, event)
        filled = int(event["event_supercritical"]) != 0
        axes.plot(np.full(at.size, float(event["event_value"])), at, **event_marks(kind, colour_of(branch), filled))


def ends_stability(branch: xr.Dataset, event: xr.Dataset) -> bool:
    """Whether a stable part of the branch ends at an event."""
    at = int(event["event_point"])
    return bool((branch["stable"].values[at : at + 2] == 1).any())


def event_marks(kind: str, colour: str, filled: bool = True) -> dict[str, Any]:
    """Marker keywords of an event."""
    face = colour if filled else "white"
    return {"marker": MARKERS[kind], "ms": 4.0, "ls": "", "color": colour, "mfc": face, "mew": 0.8, "zorder": 3.0}


def exponents(result: xr.Dataset, axes: Axes) -> None:
    """Largest exponent of each orbit, and the zero line."""
    axes.axhline(0.0, color=GREY, lw=0.8)
    for branch, parts in branches_of(result):
        value, growth = branch["value"].values, branch["lyapunov"].values
        for which, style, width, alpha in parts:
            axes.plot(value, np.where(which, growth, np.nan), color=colour_of(branch), ls=style, lw=width, alpha=alpha)
    growth = result["lyapunov"].values
    low, high = np.nanquantile(growth, [0.01, 0.99])
    low, high = min(low, 0.0), max(high, 0.0)
    room = 0.08 * max(high - low, 1e-9)
    axes.set_ylim(low - room, high + room)
    axes.set_ylabel(f"largest exponent\n({rate_unit(result['lyapunov'])})")


def event_ticks(result: xr.Dataset, panels: tuple[Axes, ...]) -> None:
    """A thin line through all panels at each event that ends a stable part; a short tick at every event."""
    for k in range(result.sizes["event"]):
        event = result.isel(event=k)
        branch = result.isel(branch=int(event["event_branch"]))
        value, colour = float(event["event_value"]), colour_of(branch)
        if ends_stability(branch, event):
            for axes in panels:
                axes.axvline(value, color=colour, lw=0.5, alpha=0.4, zorder=0.5)
        foot = panels[-1].get_xaxis_transform()
        panels[-1].plot([value, value], [0.0, 0.06], color=colour, lw=0.8, transform=foot)


def flags(result: xr.Dataset, axes: Axes) -> None:
    """Contradictions between branches and brute force, at the top: a cross, or a plus if explained."""
    top = axes.get_xaxis_transform()
    for k in range(result.sizes["flag"]):
        explained = bool(str(result["flag_explanation"][k].values))
        marker, colour = ("+", GREY) if explained else ("x", VERMILION)
        axes.plot([float(result["flag_value"][k])], [0.97], marker, ms=5.0, color=colour, transform=top)


def legend(result: xr.Dataset, *, mirrored: bool = True) -> list[Any]:
    """The legend of lines and markers."""
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], color=GREY, lw=1.3, label="stable"),
        Line2D([], [], color=GREY, lw=0.7, ls=DASHED, label="unstable"),
        Line2D([], [], color=BRUTE_FORCE, marker=".", ls="", label="brute force"),
    ]
    periods = sorted({int(p) for p, r in zip(result["period"].values, result["resting"].values, strict=True) if not r})
    for period in periods[:6]:
        colour = CYCLE[int(np.log2(period)) % len(CYCLE)]
        handles.append(Line2D([], [], color=colour, lw=1.3, label=f"period {period}"))
    if bool(result["resting"].values.any()):
        handles.append(Line2D([], [], color=BLACK, lw=1.3, label="rest"))
    if mirrored and has_mirror(result):
        handles.append(Line2D([], [], color=GREY, lw=1.3, alpha=LIGHTER, label="mirror image"))
    if holds_nowhere(result):
        handles.append(Line2D([], [], ls="", label=NOWHERE))
    elif unheld(result).any():
        handles.append(Line2D([], [], color=BLACK, lw=1.3, alpha=UNHELD, label=UNHELD_LABEL))
    kinds = dict.fromkeys(event_label(result["event_kind"][k]) for k in range(result.sizes["event"]))
    handles += [Line2D([], [], label=kind, **event_marks(kind, GREY)) for kind in kinds]
    if (result["event_supercritical"].values == 0).any():
        handles.append(Line2D([], [], label="open: subcritical", **event_marks("period doubling", GREY, False)))
    named = dict.fromkeys(event_label(kind) for kind in result["flag_kind"])
    handles += [Line2D([], [], color=VERMILION, marker="x", ls="", label=f"! {kind}") for kind in named]
    return handles
