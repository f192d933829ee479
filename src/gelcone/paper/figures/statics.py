"""Figures 3 and 6: static force with its equilibria, and energies."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from gelcone.continuum.path import Ending
from gelcone.dataset import model_of
from gelcone.paper.figures.figure import paper_figure
from gelcone.paper.figures.marks import fixed_parameters, listed
from gelcone.paper.studies.continuum import MISSING
from gelcone.paper.studies.statics import LIMITS, STATIC_VOLTAGES, SURFACES
from gelcone.plots.style import BLACK, BLUE, CYCLE, GREY, VERMILION, styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEVELS = 16
"""Level lines of an energy surface."""
HIGHEST_FILM, HIGHEST_SURFACE = 4.0, 6.0
BEYOND = "#dddddd"


def force_figure(studies: Mapping[str, xr.Dataset]) -> Figure:
    """Force over displacement at three voltages with the equilibria, and the equilibria over the voltage."""
    study = studies["static"]

    def fill(figure: Figure) -> None:
        left, right = figure.subplots(1, 2, width_ratios=[1.25, 1.0])
        force_over_displacement(study, left)
        continuum_markers(studies["continuum"], study, left)
        equilibria_over_voltage(study, right)
        figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
        figure.suptitle(
            fixed_parameters(study, "spring_stiffness", "stretch_limit", "prestretch"), fontsize=8.0, color=GREY
        )

    return styled(7.2, 3.9, fill)


def force_over_displacement(study: xr.Dataset, axes: Axes) -> None:
    """One curve per voltage, faint where the film is slack, with stable (filled) and unstable (open) equilibria."""
    axes.axhline(0.0, color=GREY, lw=0.6)
    # sizes differ so that coinciding equilibria show as rings
    for colour, voltage, size in zip(CYCLE, study["constant_voltage"].values, (11.0, 8.0, 5.0), strict=False):
        curve = study.sel(constant_voltage=voltage)
        slack = curve["slack"].values != 0
        axes.plot(curve["displacement"], curve["force"].where(~slack), color=colour, lw=1.6)
        axes.plot(curve["displacement"], curve["force"].where(slack), color=colour, lw=1.2, ls=(0, (4, 1.5)))
        axes.plot([], [], color=colour, lw=1.6, label=f"$v$ = {float(voltage):g}")
        stable, x = curve["stable"].values, curve["equilibrium_displacement"].values
        for kind, fill in ((stable, colour), (~stable & np.isfinite(x), "white")):
            axes.plot(x[kind], 0.0 * x[kind], "o", ms=size, mfc=fill, mec=colour, mew=1.2, zorder=4.0)
    axes.plot([], [], "o", ms=6.0, color=BLACK, label="stable equilibrium")
    axes.plot([], [], "o", ms=6.0, mfc="white", mec=BLACK, mew=1.2, label="unstable equilibrium")
    axes.plot([], [], color=BLACK, lw=1.2, ls=(0, (4, 1.5)), label="film slack: the model does not hold")
    axes.margins(x=0.0)
    axes.set_xlabel("displacement $x$")
    axes.set_ylabel("static force on the disc")


def continuum_markers(continuum: xr.Dataset, study: xr.Dataset, axes: Axes) -> None:
    """Force of continuum and spring at the paper's radius ratio: filled in tension, open in compression, nothing
    without a state or without the study."""
    if MISSING in continuum.attrs:
        return
    spring = float(model_of(study).spring_stiffness)
    member = continuum.isel(member=0)
    for colour, voltage in zip(CYCLE, member["constant_voltage"].values, strict=False):
        curve = member.sel(constant_voltage=voltage)
        force = curve["continuum_force"] + spring * curve["displacement"]
        for ending, fill in ((Ending.CONVERGED, colour), (Ending.COMPRESSED, "white")):
            shown = force.where((curve["ending"] == ending) & (curve["folds"] == 0))
            for side in (1.0, -1.0):
                axes.plot(
                    side * curve["displacement"], side * shown, "s", ms=4.0, mfc=fill, mec=colour, mew=1.0, ls="none"
                )
    axes.plot([], [], "s", ms=4.0, color=BLACK, label="continuum in tension")
    axes.plot([], [], "s", ms=4.0, mfc="white", mec=BLACK, label="continuum, compressed")


def equilibria_over_voltage(study: xr.Dataset, axes: Axes) -> None:
    """Displacement of all equilibria over a constant voltage: solid where stable, dashed where not."""
    voltage, x, slope = (study[f"branch_{n}"].values for n in ("voltage", "displacement", "slope"))
    axes.plot(voltage, np.where(slope >= 0.0, x, np.nan), color=BLUE, lw=1.4, label="stable")
    axes.plot(voltage, np.where(slope <= 0.0, x, np.nan), color=VERMILION, lw=1.2, ls="--", label="unstable")
    pitchfork = float(study["pitchfork_voltage"])
    axes.annotate(
        f"pitchfork\nat $v$ = {pitchfork:.4g}",
        (pitchfork, 0.0),
        (0.25, 0.8),
        textcoords="axes fraction",
        ha="center",
        fontsize=8.0,
        arrowprops={"arrowstyle": "->", "lw": 0.7},
    )
    for colour, level in zip(CYCLE, study["constant_voltage"].values, strict=False):
        axes.axvline(level, color=colour, lw=0.8, alpha=0.6, zorder=0.5)
    axes.set_xlim(-0.05, float(np.nanmax(voltage)))
    axes.set_xlabel("constant voltage $v$")
    axes.set_ylabel("equilibrium displacement")
    axes.legend(loc="lower left")


def energy_figure(studies: Mapping[str, xr.Dataset]) -> Figure:
    """Strain energy over displacement for seven stretch limits, and the energy over the phase plane for two."""
    study = studies["energy"]

    def fill(figure: Figure) -> None:
        top, bottom = cast(Any, figure.subfigures)(2, 1, height_ratios=[1.0, 1.05])
        film_energies(study, top.subplots())
        surfaces(study, bottom)
        figure.suptitle(fixed_parameters(study, "spring_stiffness", "prestretch"), fontsize=8.0, color=GREY)

    return styled(7.2, 6.6, fill)


def film_energies(study: xr.Dataset, axes: Axes) -> None:
    """One curve per stretch limit, with the displacement at which the film ends."""
    import matplotlib as mpl

    limits = study["stretch_limit"].values
    colours = mpl.colormaps["viridis"](np.linspace(0.0, 0.85, limits.size))
    for colour, limit in zip(colours, limits, strict=True):
        curve = study.sel(stretch_limit=limit)
        axes.plot(curve["displacement"], curve["film_energy"], color=colour, lw=1.4, label=f"$J$ = {limit:g}")
        for side in (-1.0, 1.0):
            axes.axvline(side * float(curve["reach"]), color=colour, lw=0.7, ls=":")
    axes.set_ylim(-0.1, HIGHEST_FILM)
    axes.set_xlim(*study["displacement"].values[[0, -1]])
    axes.legend(
        loc="center left",
        bbox_to_anchor=(1.0, 0.5),
        title="dotted: where the\nfilm would reach $J$",
        title_fontsize=8.0,
    )
    axes.set_xlabel("displacement $x$")
    axes.set_ylabel("strain energy of the film")


def surfaces(study: xr.Dataset, figure: Figure) -> None:
    """Energy of film, spring and motion without voltage; its level lines are the free undamped motions."""
    limits = study["surface_limit"].values
    panels = figure.subplots(1, limits.size, sharey=True)
    start = study["surface_energy"].sel(surface_displacement=1.0, surface_velocity=0.0, method="nearest")
    for axes, limit in zip(panels, limits, strict=True):
        surface = study.sel(surface_limit=limit)
        x, u, energy = surface["surface_displacement"], surface["surface_velocity"], surface["surface_energy"].values.T
        levels = np.linspace(0.0, HIGHEST_SURFACE, LEVELS + 1)
        filled = axes.contourf(x, u, energy, levels=levels, cmap="cividis", extend="max")
        filled.set_rasterized(True)
        axes.contour(x, u, energy, levels=levels, colors="white", linewidths=0.3)
        axes.contour(x, u, energy, levels=[float(start.sel(surface_limit=limit))], colors=VERMILION, linewidths=1.4)
        axes.plot(1.0, 0.0, "o", color=VERMILION, ms=5.0)
        axes.plot(
            [], [], color=VERMILION, lw=1.4, marker="o", ms=5.0, label="free motion without damping from the start"
        )
        axes.set_facecolor(BEYOND)
        axes.set_title(f"$J$ = {limit:g}", loc="left")
        axes.set_xlabel("displacement $x$")
        if np.isnan(energy).any():
            axes.text(-2.15, 0.0, "beyond the\nstretch limit", rotation=90.0, ha="center", va="center", fontsize=8.0)
    panels[0].set_ylabel("velocity")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center")
    figure.colorbar(filled, ax=list(panels), label="energy without voltage")


FIGURES = (
    paper_figure(3, ("static", "continuum"), force_figure, voltages=listed(STATIC_VOLTAGES)),
    paper_figure(6, ("energy",), energy_figure, limits=listed(LIMITS), surfaces=listed(SURFACES)),
)
