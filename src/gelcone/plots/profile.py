"""Figure of the membrane: its profile coloured by field, stretches and field along the radius, and its capacitance."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.amounts import measured
from gelcone.plots.style import BLACK, CYCLE, GREY, VERMILION, axis_label, name_axes, styled
from gelcone.words import members_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_STATES = 6
"""Most states drawn."""
WRINKLED = 1e-9


def profile_figure(result: xr.Dataset) -> Figure:
    """The held states of the first actuator; with several heights and voltages also the capacitance over both."""
    member = members_of(result, [0])[0][1]
    prefix = "" if "held" in member else "second_"
    two = "second_held" in member and not prefix
    sensing = min(member.sizes["height"], member.sizes["constant_voltage"]) > 1

    def draw(figure: Figure) -> None:
        grid = figure.add_gridspec(2, 6, height_ratios=[1.2, 1.0])
        states = _states(member, prefix)
        cone_profile(member, states, prefix, figure, figure.add_subplot(grid[0, :]))
        if two:
            figure.axes[0].set_title("above: both films; below: the first film alone", loc="left", fontsize=7.0)
        columns = [grid[1, :2], grid[1, 2:4], grid[1, 4:]] if sensing else [grid[1, :3], grid[1, 3:]]
        stretches(member, states, prefix, figure.add_subplot(columns[0]))
        fields(member, states, prefix, figure.add_subplot(columns[1]))
        if sensing:
            capacitances(member, prefix, figure.add_subplot(columns[2]))

    return styled(7.4, 4.8, draw, result)


def _states(member: xr.Dataset, prefix: str) -> list[tuple[int, int]]:
    """Indices (height, voltage) of some held states."""
    own = np.argwhere(member[f"{prefix}held"].values == 0)
    chosen = np.unique(np.linspace(0, max(len(own) - 1, 0), MOST_STATES).round().astype(int))
    return [(int(i), int(k)) for i, k in own[chosen[: len(own)]]]


def _label(member: xr.Dataset, state: tuple[int, int]) -> str:
    i, k = state
    height = measured(member["displacement"].isel(height=i, constant_voltage=k), 3)
    return f"{height}, {measured(member['constant_voltage'][k])}"


def cone_profile(member: xr.Dataset, states: list[tuple[int, int]], prefix: str, figure: Figure, axes: Axes) -> None:
    """Cross-sections of film and disc, coloured by the true field, with a wide grey line where the film is wrinkled."""
    from matplotlib.collections import LineCollection

    prefixes = [one for one in ("", "second_") if f"{one}held" in member]
    fields = np.concatenate(
        [_row(member, one + "true_field", state) for one in prefixes for state in states] or [np.zeros(1)]
    )
    low, top = float(np.min(fields)), float(np.max(fields))
    lines: Any = None
    for one in prefixes:
        for state in states:
            r, z, field, excess = (
                _row(member, one + name, state)
                for name in ("ring_radius", "ring_height", "true_field", "wrinkle_excess")
            )
            z = (
                z
                if not one
                else float(member["displacement"][state]) + float(_row(member, one + "ring_height", state)[0]) - z
            )
            for side in (-1.0, 1.0):
                place = np.stack([side * r, z], axis=-1)
                wrinkled = np.where((excess > WRINKLED)[:, None], place, np.nan)
                axes.plot(*wrinkled.T, color=GREY, lw=6.0, alpha=0.35, solid_capstyle="butt")
                pieces = np.stack([place[:-1], place[1:]], axis=1)
                lines = LineCollection(
                    list(pieces), cmap="viridis", clim=(low, top if top > low else low + 1.0), lw=2.0
                )
                lines.set_array(0.5 * (field[:-1] + field[1:]))
                axes.add_collection(lines)
            axes.plot([-r[0], r[0]], [z[0], z[0]], color=BLACK, lw=2.5, solid_capstyle="butt")
    if lines is None:
        axes.text(0.5, 0.5, "no state is held in tension", transform=axes.transAxes, ha="center")
        axes.set_axis_off()
        return
    figure.colorbar(lines, ax=axes, label=axis_label(member[f"{prefix}true_field"], "true field"), pad=0.01)
    if any((_row(member, one + "wrinkle_excess", state) > WRINKLED).any() for one in prefixes for state in states):
        axes.plot([], [], color=GREY, lw=6.0, alpha=0.35, label="wrinkled")
        axes.legend(loc="upper right", fontsize=7.0)
    axes.autoscale()
    axes.set_aspect("equal", adjustable="datalim")
    name_axes(axes, member[f"{prefix}ring_radius"], member["displacement"], "radius", "height")


def stretches(member: xr.Dataset, states: list[tuple[int, int]], prefix: str, axes: Axes) -> None:
    """Meridional stretch, and hoop stretch dashed, over the mounted radius."""
    radius = member[f"{prefix}mounted_radius"].values
    for colour, state in zip(CYCLE, states, strict=False):
        axes.plot(radius, _row(member, prefix + "meridional_stretch", state), color=colour, label=_label(member, state))
        axes.plot(radius, _row(member, prefix + "hoop_stretch", state), color=colour, ls="--", lw=0.8)
    axes.set_xlabel(axis_label(member[f"{prefix}mounted_radius"], "mounted radius"))
    axes.set_ylabel("stretch (dashed: hoop)")
    if states:
        axes.legend(fontsize=6.0, handlelength=1.0)


def fields(member: xr.Dataset, states: list[tuple[int, int]], prefix: str, axes: Axes) -> None:
    """True field over the mounted radius, with the dielectric strength dotted if it is near."""
    radius, top, strength = member[f"{prefix}mounted_radius"].values, 0.0, np.inf
    for colour, state in zip(CYCLE, states, strict=False):
        field = _row(member, prefix + "true_field", state)
        axes.plot(radius, field, color=colour)
        top = max(top, float(np.nanmax(field)))
        share = float(member[f"{prefix}breakdown_share"][state])
        strength = float(member[f"{prefix}largest_field"][state]) / share if share > 0.0 else strength
    if strength < 2.0 * top:
        axes.axhline(strength, color=VERMILION, ls=":", lw=1.0, label="dielectric strength")
        axes.legend(fontsize=6.0, handlelength=1.0)
    axes.set_ylim(bottom=0.0)
    name_axes(axes, member[f"{prefix}mounted_radius"], member[f"{prefix}true_field"], "mounted radius", "true field")


def capacitances(member: xr.Dataset, prefix: str, axes: Axes) -> None:
    """Capacitance over the height, a curve for each of some voltages."""
    capacitance = member[f"{prefix}capacitance"]
    chosen = np.unique(np.linspace(0, member.sizes["constant_voltage"] - 1, MOST_STATES).round().astype(int))
    for colour, k in zip(CYCLE, chosen, strict=False):
        label = measured(member["constant_voltage"][k], 3)
        axes.plot(member["height"], capacitance.isel(constant_voltage=k), color=colour, label=label, marker=".", ms=3.0)
    name_axes(axes, member["height"], capacitance, y="capacitance")
    axes.legend(fontsize=6.0, handlelength=1.0)


def _row(member: xr.Dataset, name: str, state: tuple[int, int]) -> np.ndarray[Any, Any]:
    found: np.ndarray[Any, Any] = member[name].values[state]
    return found
