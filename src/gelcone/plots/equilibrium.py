"""Figures of the statics: force over displacement, and the equilibria over the voltage."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.amounts import measured, unit_of
from gelcone.physics.balance import PullIn
from gelcone.plots.branches import with_neighbours
from gelcone.plots.regime import invalid_cells
from gelcone.plots.response import members
from gelcone.plots.section import failure
from gelcone.plots.style import BLACK, BLUE, CYCLE, GREY, UNHELD, VERMILION, name_axes, name_faint, styled
from gelcone.words import evenly

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_CURVES = 5
MARKER_SIZES = (8.5, 7.0, 5.5, 4.5, 3.5)
MOST_ROWS = 3
HEADROOM = 1.6
"""Forces are shown up to this multiple of the largest one between the outermost equilibria: near the stretch limit they
grow far beyond."""


def static_figure(result: xr.Dataset) -> Figure:
    """Force over displacement next to the equilibria over voltage; one row for each of up to three members."""
    drawn = members(result)
    forces = force_curves if _option(result, "displacements") is None else delivered_force
    drawn = [drawn[i] for i in evenly(len(drawn), MOST_ROWS)]

    def draw(figure: Figure) -> None:
        grid = figure.subplots(len(drawn), 2, squeeze=False)
        for row, (name, member) in zip(grid, drawn, strict=True):
            forces(member, row[0])
            equilibrium_branches(member, row[1])
            if name:
                row[0].set_title(name, loc="left")
        for axes in grid[0]:
            axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0 if not drawn[0][0] else 1.1), ncols=2)

    return styled(7.2, 0.6 + 2.7 * len(drawn), draw, result)


def force_curves(member: xr.Dataset, axes: Axes) -> None:
    """The force that holds the disc, at up to five voltages: dashed where its slope is negative (unstable). On the line
    of zero force lie the equilibria, stable ones filled, unstable ones open."""
    axes.axhline(0.0, color=GREY, lw=0.8)
    chosen = evenly(member.sizes["constant_voltage"], MOST_CURVES)
    fails = invalid_cells(member, "constant_voltage", "equilibrium")
    mark: dict[str, Any] = {"ms": 4.0, "color": BLACK, "mew": 0.8, "ls": "none"}
    for colour, size, i in zip(CYCLE, MARKER_SIZES, chosen, strict=False):
        one = member.isel(constant_voltage=i)
        voltage = one["constant_voltage"]
        split_by_stability(one["displacement"], one["force"], one["stiffness"], axes, colour=colour, both=colour)
        axes.plot([], [], color=colour, label=f"voltage {float(voltage):.4g}{unit_of(voltage)}")
        mark_equilibria(axes, one["equilibrium_displacement"].values, one["stable"].values, colour, size)
        if fails[i].any():
            x = one["equilibrium_displacement"].values[fails[i]]
            axes.plot(x, 0.0 * x, "x", zorder=4, **mark)
    if fails.any():
        axes.plot([], [], "x", label="model does not hold", **mark)
    limit_forces(member, axes)
    name_axes(axes, member["displacement"], member["force"], y="force that holds the disc")
    axes.margins(x=0)
    note_failure(member, axes)


def _option(result: xr.Dataset, name: str) -> Any:
    """An option of the result; None in results of earlier versions without it."""
    return json.loads(result.attrs.get("options", "{}")).get(name)


def delivered_force(member: xr.Dataset, axes: Axes) -> None:
    """Force of the disc on a load over its displacement, at up to five voltages: blocked force at the rest without
    voltage, stroke at zero force, and the work of a cycle between zero and the highest voltage."""
    axes.axhline(0.0, color=GREY, lw=0.8)
    place = member["displacement"].values
    rest = float(member["rest_displacement"])
    chosen = evenly(member.sizes["constant_voltage"], MOST_CURVES)
    for colour, i in zip(CYCLE, chosen, strict=False):
        one = member.isel(constant_voltage=i)
        named = f"{measured(one['constant_voltage'])}: " + ", ".join(
            measured(one[name], 3) for name in ("blocked_force", "stroke", "cycle_work") if np.isfinite(one[name])
        )
        axes.plot(place, -one["force"].values, color=colour, label=named)
        axes.plot(rest, one["blocked_force"], "o", color=colour, ms=5.0, ls="none", clip_on=False)
        axes.plot(rest + one["stroke"], 0.0, "D", color=colour, ms=5.0, mfc="white", ls="none", clip_on=False)
    axes.plot([], [], "o", color=BLACK, ms=5.0, ls="none", label="blocked force")
    axes.plot([], [], "D", color=BLACK, ms=5.0, mfc="white", ls="none", label="stroke (no force)")
    last = member.isel(constant_voltage=int(chosen[-1]))
    end = rest + float(last["stroke"])
    without = member["constant_voltage"].values == 0.0
    if np.isfinite(end) and without.any():
        first = member.isel(constant_voltage=int(np.argmax(without)))
        inside = (place - rest) * (place - end) <= 0.0
        low, high = -first["force"].values, -last["force"].values
        axes.fill_between(place, low, high, where=inside, color=CYCLE[0], alpha=0.12, lw=0, label="work of a cycle")
    name_axes(axes, member["displacement"], member["force"], y="force on a load")
    axes.margins(x=0)
    note_failure(member, axes)


def mark_equilibria(axes: Axes, place: Any, stable: Any, colour: str, size: float) -> None:
    """Equilibria on the line of zero force; marker sizes differ so that coinciding ones show as rings."""
    for fill, chosen in ((colour, stable), ("white", ~stable)):
        x = place[chosen & np.isfinite(place)]
        axes.plot(x, 0.0 * x, "o", ms=size, mec=colour, mfc=fill, ls="none", zorder=3)


def limit_forces(member: xr.Dataset, axes: Axes) -> None:
    """Limits the force axis to the range between the equilibria, without the rise near the stretch limit."""
    farthest = float(np.abs(member["equilibrium_displacement"]).max())
    force = member["force"]
    near = force.where(np.abs(member["displacement"]) <= 1.1 * farthest) if farthest > 0.0 else force
    most = HEADROOM * float(np.abs(near).max())
    if np.isfinite(most) and most > 0.0:
        axes.set_ylim(-most, most)


def equilibrium_branches(member: xr.Dataset, axes: Axes) -> None:
    """Displacement of all equilibria over the voltage, unstable ones dashed, with pitchfork, folds and pull-in; faint
    where the model does not hold."""
    voltage, place = member["branch_voltage"], member["branch_displacement"]
    fails = np.asarray(member.get("branch_fails", np.zeros(voltage.size, dtype=bool)))  # files of 0.2 do not say
    for which, alpha in ((with_neighbours(fails), UNHELD), (~fails, 1.0)):
        if which.any():
            shown = np.where(which, place, np.nan)
            split_by_stability(voltage, shown, member["branch_slope"], axes, colour=BLUE, both=VERMILION, alpha=alpha)
    axes.plot([], [], color=BLUE, label="stable")
    if (member["branch_slope"] <= 0.0).any():
        axes.plot([], [], color=VERMILION, ls="--", label="unstable")
    pitchfork, traced = float(member["pitchfork_voltage"]), float(voltage.max())
    if pitchfork <= traced:
        named = f"pitchfork {pitchfork:.4g}{unit_of(voltage)}"
        left = float(member.get("pitchfork_displacement", 0.0))  # files of 0.2 have flat films alone
        axes.plot(pitchfork, left, "s", ms=5.0, color=BLACK, mfc="white", zorder=4, label=named)
    folds = member["fold_voltage"] <= traced
    if folds.any():
        axes.plot(member["fold_voltage"], member["fold_displacement"], "D", ms=4.0, color=BLACK, zorder=4, label="fold")
    mark_jump(member, axes)
    name_faint(axes, fails)
    name_axes(axes, voltage, place, "constant voltage", "displacement")
    axes.set_xlim(0.0, float(np.nanmax(voltage)) if np.isfinite(voltage).any() else 1.0)
    note_failure(member, axes)


def mark_jump(member: xr.Dataset, axes: Axes) -> None:
    """An arrow where a slow voltage ramp jumps to another equilibrium, a cross where there is none to jump to."""
    voltage, begin, end = (float(member[f"pull_in_{part}"]) for part in ("voltage", "from", "to"))
    if not np.isfinite([voltage, begin]).all() or np.isnan(end):
        return
    kind = PullIn(int(member["pull_in_kind"])).name.lower().replace("_", " ")
    named = f"pull-in at {voltage:.4g}{unit_of(member['branch_voltage'])} ({kind})"
    if not np.isfinite(end):
        axes.plot(voltage, begin, "X", ms=5.0, color=BLACK, ls="none", zorder=4, clip_on=False, label=named)
        return
    style = {"arrowstyle": "->", "color": BLACK, "shrinkA": 3.0, "shrinkB": 0.0}
    axes.annotate("", (voltage, end), (voltage, begin), arrowprops=style)
    axes.plot([], [], color=BLACK, marker=r"$\uparrow$", ls="none", label=named)


def split_by_stability(
    x: Any, y: Any, slope: Any, axes: Axes, *, colour: str, both: str, alpha: float | None = None
) -> None:
    """A line, solid where ``slope`` is not negative, and dashed in the colour ``both`` where it is not positive."""
    x, y, slope = (np.asarray(values, dtype=float) for values in (x, y, slope))
    axes.plot(x, np.where(slope >= 0.0, y, np.nan), color=colour, alpha=alpha)
    axes.plot(x, np.where(slope <= 0.0, y, np.nan), color=both, alpha=alpha, ls="--")


def note_failure(member: xr.Dataset, axes: Axes) -> None:
    """Writes the reason of a failed member."""
    if words := failure(member):
        axes.text(0.5, 0.5, words, transform=axes.transAxes, ha="center", color=VERMILION)
