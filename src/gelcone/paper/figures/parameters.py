"""Figures 13 and 14: bifurcation diagrams with exponents, stacked sections, maps over voltage and pre-stretch."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.atlas.branches.attached import attached_branches
from gelcone.codes import Regime
from gelcone.paper.figures.figure import paper_figure
from gelcone.paper.reading import fixed_branch
from gelcone.paper.studies.diagrams import PANELS, diagram_name
from gelcone.paper.studies.samples import MODES
from gelcone.plots.branches import DASHED, sections_of, stability_parts
from gelcone.plots.style import BLACK, BLUE, GREEN, GREY, ORANGE, SKY, VERMILION, styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHORT = 2
"""Longest period of the branches drawn."""
LABELS = {
    "damping_ratio": r"damping ratio $\zeta$",
    "voltage": r"voltage $v$",
    "prestretch": r"pre-stretch $\lambda_p$",
    "stretch_limit": r"stretch limit $J$",
}
SETS = ("base", "fast")


def diagrams_figure(studies: Mapping[str, xr.Dataset]) -> Figure:
    """Sections over each parameter above the largest exponents (long run and window), for both sets."""

    def draw(figure: Figure) -> None:
        axes = figure.subplots(4, 4, sharex="col", gridspec_kw={"height_ratios": [1.5, 1, 1.5, 1]})
        for row, preset in enumerate(SETS):
            for column, parameter in enumerate(LABELS):
                study = studies[diagram_name(preset, parameter)]
                top, bottom = axes[2 * row, column], axes[2 * row + 1, column]
                _sections(study, parameter, top)
                _exponents(study, parameter, bottom)
                voltage = PANELS[preset, parameter]
                at = "" if parameter == "voltage" else f", v = {voltage:g}"
                top.set_title(f"set {preset}{at}", fontsize=8)
                if parameter == "stretch_limit":
                    bottom.set_xscale("log")
                if row == 1:
                    bottom.set_xlabel(LABELS[parameter])
                if column == 0:
                    top.set_ylabel("section $x$")
                    bottom.set_ylabel("largest\nexponent")
        handles, labels = axes[1, 0].get_legend_handles_labels()
        extra, names = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles + extra, labels + names, loc="outside lower center", ncols=2, markerscale=5)

    return styled(7.6, 8.4, draw)


def _sections(study: xr.Dataset, parameter: str, axes: Axes) -> None:
    values = study[parameter].values
    unstable, buckled = study["rest_growth"].values > 0.0, study["static_stiffness"].values < 0.0
    _shade(axes, values, unstable, SKY, "rest unstable under the drive (Floquet)")
    _shade(axes, values, buckled, GREY, "rest unstable at the constant peak voltage (static pitchfork)")
    looks = (
        (fixed_branch(study)["branch"].item(), BLACK, 0.5, "from the fixed state"),
        ("up", BLUE, 0.4, "swept up"),
        ("down", VERMILION, 0.4, "down"),
    )
    for branch, colour, size, label in looks:
        if branch in study["branch"].values:
            points = study["section"].sel(branch=branch).values[:, -32:, 0]
            at = np.broadcast_to(values[:, None], points.shape)
            axes.plot(at.ravel(), points.ravel(), ".", ms=size, color=colour, mec="none", rasterized=True, label=label)
    followed = attached_branches(study)
    if followed is not None:
        _branches(followed, axes)
    if "cascade_end" in study:
        _cascade(study, axes)


def _cascade(study: xr.Dataset, axes: Axes) -> None:
    """Marks the end of the period doublings that lead to chaos, with their branch."""
    end, born = float(study["cascade_end"]), study["cascade_born"]
    axes.axvline(end, color=GREEN, lw=0.7, ls=":")
    text = f"doublings end at {end:.4f}"
    if np.isfinite(float(born)):
        text += f"\nof the branch from the\n{born.attrs['born']} at {float(born):.4f}"
    place: dict[str, Any] = {"xycoords": axes.get_xaxis_transform(), "textcoords": "offset points"}
    axes.annotate(text, (end, 0.03), (3.0, 0.0), fontsize=4.5, color=GREEN, va="bottom", **place)


def _branches(followed: xr.Dataset, axes: Axes) -> None:
    """Orbits of short periods as thin lines, unstable ones dashed, and their bifurcations as ticks at the top."""
    colour = GREEN
    for k in np.flatnonzero(followed["period"].values <= SHORT):
        branch = followed.isel(branch=k)
        inside, outside = stability_parts(branch["stable"].values)
        lines = sections_of(branch)
        for which, style in ((inside, "-"), (outside, DASHED)):
            axes.plot(
                branch["value"], np.where(which[:, None], lines, np.nan), color=colour, ls=style, lw=0.4, alpha=0.8
            )
    short = followed["period"].values[followed["event_branch"].values] <= SHORT
    at = followed["event_value"].values[short]
    axes.plot(at, np.full(at.size, 0.98), "|", ms=3.0, mew=0.5, color=colour, transform=axes.get_xaxis_transform())


def _exponents(study: xr.Dataset, parameter: str, axes: Axes) -> None:
    branch = fixed_branch(study)
    values, exponent = study[parameter].values, branch["lyapunov"].values[:, 0]
    error = branch["standard_error"].values[:, 0]
    axes.axhline(0.0, color=GREY, lw=0.6)
    axes.plot(values, study["finite"].values[:, 0], color=ORANGE, lw=0.7, label="over the window from the start")
    axes.plot(values, exponent, color=BLACK, lw=0.8, label="in the long run, with 3 standard errors")
    axes.fill_between(values, exponent - 3 * error, exponent + 3 * error, color=BLUE, alpha=0.35, lw=0)
    lowest = max(float(np.nanmin(exponent)), -0.12)
    axes.set_ylim(1.15 * min(lowest, -0.02), 1.25 * max(float(np.nanmax(exponent + 3 * error)), 0.02))


def _shade(axes: Axes, values: Any, mask: Any, colour: str, label: str) -> None:
    over = axes.get_xaxis_transform()
    axes.fill_between(values, 0, 1, where=mask, transform=over, color=colour, alpha=0.25, lw=0, label=label)


def maps_figure(studies: Mapping[str, xr.Dataset]) -> Figure:
    """Stacked sections and largest exponents (long run and window), for both meanings of pre-stretch."""

    def draw(figure: Figure) -> None:
        axes = figure.subplots(3, 2, sharex=True, gridspec_kw={"height_ratios": [1.1, 1, 1]})
        bound = 0.12
        for column, mode in enumerate(MODES):
            plane = studies[f"map-{mode}"].transpose("prestretch", "voltage", ...)
            _stack(studies[f"map-{mode}"], axes[0, column])
            axes[0, column].set_title(f"{mode.replace('equib', 'equi-b')} pre-stretch", fontsize=9)
            shown = (
                ("lyapunov", "in the long run"),
                ("finite", f"over the first {plane.attrs['window']:g} time units"),
            )
            for row, (name, label) in enumerate(shown, start=1):
                image = _exponent_map(plane, name, bound, axes[row, column])
                axes[row, column].set_title(f"largest exponent {label}", fontsize=8)
            axes[2, column].set_xlabel(LABELS["voltage"])
        for row in (1, 2):
            axes[row, 0].set_ylabel(LABELS["prestretch"])
        axes[0, 0].set_ylabel(r"section $x$, offset by $\lambda_p$")
        figure.colorbar(
            image, ax=axes[1:, :], label="largest Lyapunov exponent per unit time", extend="both", shrink=0.8
        )
        figure.legend(*axes[1, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3)

    return styled(7.2, 8.2, draw)


def _stack(study: xr.Dataset, axes: Axes) -> None:
    spacing = 10.0
    voltage = study["voltage"].values
    stacked = study["stacked_prestretch"].values
    for k in range(stacked.size):
        points = study["section"].isel(stacked_prestretch=k).transpose("voltage", ...).values[:, -32:, 0]
        at = np.broadcast_to(voltage[:, None], points.shape)
        axes.plot(at.ravel(), (points + k * spacing).ravel(), ".", ms=1.8, color=BLACK, mec="none", rasterized=True)
        axes.axhline(k * spacing, color=GREY, lw=0.3, zorder=0)
    axes.set_yticks(spacing * np.arange(stacked.size), [f"{stretch:.3g}" for stretch in stacked])


def _exponent_map(plane: xr.Dataset, name: str, bound: float, axes: Axes) -> Any:
    voltage, stretch = plane["voltage"].values, plane["prestretch"].values
    values = plane[name].values[..., 0]
    image = axes.pcolormesh(voltage, stretch, values, cmap="RdBu_r", vmin=-bound, vmax=bound, rasterized=True)
    failed = plane["regime"].values == Regime.LEFT_THE_DOMAIN
    if failed.any():
        axes.contourf(voltage, stretch, failed, levels=[0.5, 1.5], colors="none", hatches=["////"])
    for variable, style, label in (
        ("rest_growth", "-", "rest loses stability under the drive (Floquet)"),
        ("static_stiffness", "--", "static pitchfork at the peak voltage"),
    ):
        values = plane[variable].values
        if np.nanmin(values) < 0.0 < np.nanmax(values):
            axes.contour(voltage, stretch, values, levels=[0.0], colors=BLACK, linestyles=style, linewidths=1.0)
        axes.plot([], [], color=BLACK, ls=style, lw=1.0, label=label)
    return image


FIGURES = (
    paper_figure(13, tuple(diagram_name(*panel) for panel in PANELS), diagrams_figure),
    paper_figure(14, tuple(f"map-{mode}" for mode in MODES), maps_figure),
)
