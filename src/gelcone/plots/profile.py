"""Figure of the membrane: its profile coloured by field, stretches and field along the radius, and its capacitance."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import measured
from gelcone.plots.style import BLACK, CYCLE, GREY, VERMILION, axis_label, name_axes, say, styled
from gelcone.quantity import Array
from gelcone.words import members_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_STATES = 6
"""Most states drawn."""
WRINKLED = 1e-9
SECOND = "second_"


def profile_figure(result: xr.Dataset) -> Figure:
    """The held states of the first actuator; with several heights and voltages also the capacitance over both."""
    member = members_of(result, [0])[0][1]
    films = films_of(member)
    first_film = next(iter(films.values()))
    sensing = min(member.sizes["height"], member.sizes["constant_voltage"]) > 1

    def draw(figure: Figure) -> None:
        grid = figure.add_gridspec(2, 6, height_ratios=[1.2, 1.0])
        states, top = _states(first_film), figure.add_subplot(grid[0, :])
        cone_profile(films, states, top)
        if len(films) > 1:
            top.set_title("above: both films; below: the first film alone", loc="left", fontsize=7.0)
        columns = [grid[1, :2], grid[1, 2:4], grid[1, 4:]] if sensing else [grid[1, :3], grid[1, 3:]]
        stretches(first_film, states, figure.add_subplot(columns[0]))
        fields(first_film, states, figure.add_subplot(columns[1]))
        if sensing:
            capacitances(first_film, figure.add_subplot(columns[2]))

    return styled(7.4, 4.8, draw, result)


def films_of(member: xr.Dataset) -> dict[str, xr.Dataset]:
    """The films by the prefix of their variables, which have the names of a first film here."""
    second = {name: str(name).removeprefix(SECOND) for name in member.variables if str(name).startswith(SECOND)}
    films = {"": member, SECOND: member.drop_vars(second.values(), errors="ignore").rename(second)}
    return {prefix: film for prefix, film in films.items() if f"{prefix}held" in member}


def _states(film: xr.Dataset) -> list[tuple[int, int]]:
    """Indices (height, voltage) of some held states."""
    held_cells = np.argwhere(film["held"].values == 0)
    return [(int(i), int(k)) for i, k in held_cells[_some(len(held_cells))[: len(held_cells)]]]


def _some(count: int) -> Array:
    """Places of at most `MOST_STATES` of some things."""
    return np.unique(np.linspace(0, max(count - 1, 0), MOST_STATES).round().astype(int))


def _label(film: xr.Dataset, state: tuple[int, int]) -> str:
    i, k = state
    height = measured(film["displacement"].isel(height=i, constant_voltage=k), 3)
    return f"{height}, {measured(film['constant_voltage'][k])}"


def cone_profile(films: Mapping[str, xr.Dataset], states: list[tuple[int, int]], axes: Axes) -> None:
    """Cross-sections of films and disc, coloured by the true field, with a wide grey line where a film is wrinkled."""
    from matplotlib.collections import LineCollection

    if not states:
        say(axes, "no state is held in tension")
        axes.set_axis_off()
        return
    first_film = next(iter(films.values()))
    every = np.concatenate([film["true_field"].values[state] for film in films.values() for state in states])
    low, top, wrinkled = float(np.min(every)), float(np.max(every)), False
    for (prefix, film), state in itertools.product(films.items(), states):
        r, z, field, excess = (
            film[name].values[state] for name in ("ring_radius", "ring_height", "true_field", "wrinkle_excess")
        )
        if prefix:  # hangs from above
            z = float(film["displacement"][state]) + float(z[0]) - z
        where = (excess > WRINKLED)[:, None]
        wrinkled = wrinkled or bool(where.any())
        for side in (-1.0, 1.0):
            place = np.stack([side * r, z], axis=-1)
            axes.plot(*np.where(where, place, np.nan).T, color=GREY, lw=6.0, alpha=0.35, solid_capstyle="butt")
            pieces = list(np.stack([place[:-1], place[1:]], axis=1))
            lines = LineCollection(pieces, cmap="viridis", clim=(low, top if top > low else low + 1.0), lw=2.0)
            lines.set_array(0.5 * (field[:-1] + field[1:]))
            axes.add_collection(lines)
        axes.plot([-r[0], r[0]], [z[0], z[0]], color=BLACK, lw=2.5, solid_capstyle="butt")
    axes.figure.colorbar(lines, ax=axes, label=axis_label(first_film["true_field"], "true field"), pad=0.01)
    if wrinkled:
        axes.plot([], [], color=GREY, lw=6.0, alpha=0.35, label="wrinkled")
        axes.legend(loc="upper right", fontsize=7.0)
    axes.autoscale()
    axes.set_aspect("equal", adjustable="datalim")
    name_axes(axes, first_film["ring_radius"], first_film["displacement"], "radius", "height")


def stretches(film: xr.Dataset, states: list[tuple[int, int]], axes: Axes) -> None:
    """Meridional stretch, and hoop stretch dashed, over the mounted radius."""
    radius = film["mounted_radius"]
    for colour, state in zip(CYCLE, states, strict=False):
        axes.plot(radius, film["meridional_stretch"].values[state], color=colour, label=_label(film, state))
        axes.plot(radius, film["hoop_stretch"].values[state], color=colour, ls="--", lw=0.8)
    axes.set_xlabel(axis_label(radius, "mounted radius"))
    axes.set_ylabel("stretch (dashed: hoop)")
    if states:
        axes.legend(fontsize=6.0, handlelength=1.0)


def fields(film: xr.Dataset, states: list[tuple[int, int]], axes: Axes) -> None:
    """True field over the mounted radius, with the dielectric strength dotted if it is near."""
    radius, top, strength = film["mounted_radius"], 0.0, np.inf
    for colour, state in zip(CYCLE, states, strict=False):
        field = film["true_field"].values[state]
        axes.plot(radius, field, color=colour)
        top = max(top, float(np.nanmax(field)))
        share = float(film["breakdown_share"][state])
        strength = float(film["largest_field"][state]) / share if share > 0.0 else strength
    if strength < 2.0 * top:
        axes.axhline(strength, color=VERMILION, ls=":", lw=1.0, label="dielectric strength")
        axes.legend(fontsize=6.0, handlelength=1.0)
    axes.set_ylim(bottom=0.0)
    name_axes(axes, radius, film["true_field"], "mounted radius", "true field")


def capacitances(film: xr.Dataset, axes: Axes) -> None:
    """Capacitance over the height, a curve for each of some voltages."""
    for colour, k in zip(CYCLE, _some(film.sizes["constant_voltage"]), strict=False):
        label, capacitance = measured(film["constant_voltage"][k], 3), film["capacitance"].isel(constant_voltage=k)
        axes.plot(film["height"], capacitance, color=colour, label=label, marker=".", ms=3.0)
    name_axes(axes, film["height"], film["capacitance"], y="capacitance")
    axes.legend(fontsize=6.0, handlelength=1.0)
