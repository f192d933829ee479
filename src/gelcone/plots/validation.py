"""Figures that compare the cone model with the continuum: force over displacement, profiles and stretches."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import unit_of
from gelcone.continuum.path import Ending
from gelcone.plots.style import BLACK, CYCLE, GREY, axis_label, name_axes, say, styled
from gelcone.words import evenly, members_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_ROWS = 3
MOST_VOLTAGES = 4
MOST_SHAPES = 3
_CONTINUUM = (
    ("o", True, "continuum, taut"),
    ("o", False, "continuum, slack: not physical"),
    ("X", False, "continuum, pulled in"),
)
"""Marker, whether it is filled, and label of each kind of continuum force."""


def validation_figure(result: xr.Dataset) -> Figure:
    """Force, profiles and stretches side by side; a row for each of up to three members."""
    drawn = members_of(result, evenly(result["outcome"].size, MOST_ROWS))

    def draw(figure: Figure) -> None:
        grid = figure.subplots(len(drawn), 3, squeeze=False, width_ratios=[1.2, 1.0, 1.0])
        for row, (name, member) in zip(grid, drawn, strict=True):
            force_curves(member, row[0])
            profiles(member, row[1])
            stretch_curves(member, row[2])
            row[0].set_title(name, loc="left")
        for column in grid.T:
            entries = [pair for axes in column for pair in zip(*axes.get_legend_handles_labels(), strict=True)]
            handles = {label: handle for handle, label in reversed(entries)}
            order = list(dict.fromkeys(label for _, label in entries))
            column[0].legend(
                [handles[label] for label in order],
                order,
                loc="lower center",
                bbox_to_anchor=(0.5, 1.1 if drawn[0][0] else 1.0),
                ncols=2 if column[0] is grid[0][0] else 1,
            )

    return styled(9.6, 1.1 + 2.7 * len(drawn), draw, result)


def force_curves(member: xr.Dataset, axes: Axes) -> None:
    """The cone as a line and the continuum as markers: filled where the film is taut, open where a stress is
    compressive, crossed where it has pulled in."""
    axes.axhline(0.0, color=GREY, lw=0.8)
    seen: set[str] = set()
    for colour, i in zip(CYCLE, evenly(member.sizes["constant_voltage"], MOST_VOLTAGES), strict=False):
        one = member.isel(constant_voltage=i).sortby("displacement")
        voltage = one["constant_voltage"]
        label = f"cone, voltage {float(voltage):.4g}{unit_of(voltage)}"
        axes.plot(one["displacement"], one["cone_force"], color=colour, label=label)
        slack = (one["hoop_slack"] | one["meridional_slack"]).values
        pulled = one["folds"].values > 0
        kinds = (~slack & ~pulled, slack & ~pulled, pulled)
        for (marker, filled, label), chosen in zip(_CONTINUUM, kinds, strict=True):
            force = one["continuum_force"].where(chosen)
            fill = colour if filled else "white"
            axes.plot(one["displacement"], force, marker, ms=4.0, mec=colour, mfc=fill, mew=0.8, ls="none")
            if np.isfinite(force).any():
                seen.add(label)
    for marker, filled, label in _CONTINUUM:
        if label in seen:
            fill = BLACK if filled else "white"
            axes.plot([], [], marker, ms=4.0, mec=BLACK, mfc=fill, mew=0.8, ls="none", label=label)
    limit_forces(member, axes)
    name_axes(axes, member["displacement"], member["cone_force"], y="force on the disc, film and field")


def limit_forces(member: xr.Dataset, axes: Axes) -> None:
    """Limits of the force that ignore films that have pulled in."""
    near = member["continuum_force"].where(member["folds"] == 0)
    shown = np.concatenate([near.values.ravel(), member["cone_force"].values.ravel()])
    shown = shown[np.isfinite(shown)]
    if shown.size and np.ptp(shown) > 0.0:
        axes.set_ylim(shown.min() - 0.06 * np.ptp(shown), shown.max() + 0.06 * np.ptp(shown))


def shapes(member: xr.Dataset) -> xr.Dataset:
    """Some displacements at the lowest voltage with converged states."""
    is_converged = (member["ending"] == Ending.CONVERGED).values & (member["displacement"].values != 0.0)
    rows = np.flatnonzero(is_converged.any(axis=1))
    if rows.size == 0:
        return member.isel(constant_voltage=0, displacement=[])
    columns = np.flatnonzero(is_converged[rows[0]])
    picks = columns[evenly(columns.size, MOST_SHAPES)]
    return member.isel(constant_voltage=rows[0], displacement=picks)


def profiles(member: xr.Dataset, axes: Axes) -> None:
    """The film's profile: the continuum solid, the cone dashed."""
    shown = shapes(member)
    for colour, i in zip(CYCLE, range(shown.sizes["displacement"]), strict=False):
        one = shown.isel(displacement=i)
        x, radius = one["displacement"], one["mounted_radius"]
        axes.plot(one["radius"], one["height"], color=colour, label=f"displacement {float(x):.3g}{unit_of(x)}")
        axes.plot([float(radius[0]), float(radius[-1])], [float(x), 0.0], color=colour, ls="--", lw=0.8)
    note_missing(shown, axes)
    name_axes(axes, member["radius"], member["height"])


def stretch_curves(member: xr.Dataset, axes: Axes) -> None:
    """Meridional (solid) and hoop stretch (dotted) along the film; the cone's meridional stretch dashed."""
    shown = shapes(member)
    for colour, i in zip(CYCLE, range(shown.sizes["displacement"]), strict=False):
        one = shown.isel(displacement=i)
        axes.plot(one["mounted_radius"], one["meridional_stretch"], color=colour)
        axes.plot(one["mounted_radius"], one["hoop_stretch"], color=colour, ls=":")
        axes.axhline(float(one["cone_stretch"]), color=colour, ls="--", lw=0.8)
    for style, label in (("-", "meridional"), (":", "hoop"), ("--", "meridional, cone")):
        axes.plot([], [], color=BLACK, ls=style, label=label)
    note_missing(shown, axes)
    axes.set_xlabel(axis_label(member["mounted_radius"], "mounted radius"))
    axes.set_ylabel("stretch")


def note_missing(shown: xr.Dataset, axes: Axes) -> None:
    """Writes that no film was found, if so."""
    if shown.sizes["displacement"] == 0:
        say(axes, "no film in tension found")
