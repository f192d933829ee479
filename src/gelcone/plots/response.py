"""Pictures of a time response: displacement and voltage over time, phase portrait."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.plots.style import BLUE, CYCLE, GREY, VERMILION, axis_label, styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_LINES = 6


def response_figure(response: xr.Dataset) -> Figure:
    """Time response over the voltage, with the phase portrait beside; up to six members of an ensemble."""

    def draw(figure: Figure) -> None:
        grid = figure.add_gridspec(2, 2, width_ratios=[2.2, 1.0], height_ratios=[2.0, 1.0])
        top = figure.add_subplot(grid[0, 0])
        bottom = figure.add_subplot(grid[1, 0], sharex=top)
        side = figure.add_subplot(grid[:, 1])
        time_response(response, top)
        top.set_xlabel("")
        top.tick_params(labelbottom=False)
        drive_voltage(response, bottom)
        phase_portrait(response, side)
        if len(members(response)) > 1:
            side.legend(*top.get_legend_handles_labels(), loc="upper center", bbox_to_anchor=(0.5, -0.18))
        figure.suptitle(response.attrs.get("device", ""), fontsize=9.0)

    return styled(7.2, 3.6, draw)


def members(response: xr.Dataset) -> list[tuple[str, xr.Dataset]]:
    """The members to draw, each with its label; evenly picked where there are more than `MOST_LINES`."""
    dims = list(response["outcome"].dims)
    if not dims:
        return [("", response)]
    stacked = response.stack(flat=dims)
    picks = np.unique(np.linspace(0, stacked.sizes["flat"] - 1, MOST_LINES).astype(int))
    names = [str(n) for n, c in response.coords.items() if c.attrs.get("quantity") == "parameter"]
    chosen = [stacked.isel(flat=i) for i in picks]
    return [(", ".join(f"{n} {float(m[n]):.4g}" for n in names), m) for m in chosen]


def time_response(response: xr.Dataset, axes: Axes) -> None:
    """Displacement over time; spans during which the film is slack are shaded when there is one member."""
    lines = members(response)
    for colour, (name, member) in zip(CYCLE, lines, strict=False):
        axes.plot(member["time"], member["displacement"], color=colour, label=name)
    if len(lines) == 1:
        only = lines[0][1]
        slack = np.minimum(only["hoop_stress"].values, only["meridional_stress"].values) < 0.0
        axes.fill_between(
            only["time"], 0, 1, where=slack, transform=axes.get_xaxis_transform(), color=GREY, alpha=0.2, lw=0
        )
        if slack.any():
            axes.set_title("shaded: film slack, the model does not hold", color=GREY, loc="right", fontsize=8)
    axes.set_xlabel(axis_label(response["time"], "time"))
    axes.set_ylabel(axis_label(response["displacement"], "displacement"))
    axes.margins(x=0)


def drive_voltage(response: xr.Dataset, axes: Axes) -> None:
    """Voltage across the film over time."""
    for colour, (_, member) in zip((VERMILION, *CYCLE[1:]), members(response), strict=False):
        axes.plot(member["time"], member["drive_voltage"], color=colour)
    axes.set_xlabel(axis_label(response["time"], "time"))
    axes.set_ylabel(axis_label(response["drive_voltage"], "voltage"))


def phase_portrait(response: xr.Dataset, axes: Axes) -> None:
    """Velocity over displacement, the first quarter of the run faint."""
    for colour, (_, member) in zip(CYCLE, members(response), strict=False):
        x, u = member["displacement"].values, member["velocity"].values
        settled = len(x) // 4
        axes.plot(x[: settled + 1], u[: settled + 1], color=GREY if colour == BLUE else colour, alpha=0.4, lw=0.6)
        axes.plot(x[settled:], u[settled:], color=colour, lw=0.8)
    axes.set_xlabel(axis_label(response["displacement"], "displacement"))
    axes.set_ylabel(axis_label(response["velocity"], "velocity"))
