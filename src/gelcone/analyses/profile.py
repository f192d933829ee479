"""Answers about the membrane from disc to rim."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import measured, unit_of
from gelcone.analyses.answer import heading
from gelcone.motion.profile import Held
from gelcone.words import UNKNOWN_STRENGTH, event_label, members_of, shortened

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject

MOST_COLUMNS = 8
"""Voltages of a table of capacitances."""
OWN = ("voltage_amplitude", "voltage_offset", "frequency", "voltage", "voltage_bias", "drive_frequency")


def film_words(shown: xr.Dataset, subject: Subject) -> str:
    """The states of the film, and its capacitance over heights and voltages."""
    lines = heading(subject, OWN)
    for name, member in members_of(shown):
        for prefix in ("", "second_"):
            if f"{prefix}held" in member:
                lines += [f"{one}:" for one in (name, "second film" if prefix else "") if one]
                lines += _film_lines(member, prefix)
    return "\n".join(lines)


def _film_lines(member: xr.Dataset, prefix: str) -> list[str]:
    """One film of one actuator."""
    film = member[[prefix + name for name in _NAMES]].rename({prefix + name: name for name in _NAMES if prefix})
    film["displacement"] = member["displacement"]
    cells = [
        film.isel(height=i, constant_voltage=k)
        for i in range(member.sizes["height"])
        for k in range(member.sizes["constant_voltage"])
    ]
    lines = _state_lines(cells[0]) if len(cells) == 1 else shortened([_state_line(cell) for cell in cells])
    if np.isfinite(film["largest_field"]).any() and not np.isfinite(film["breakdown_share"]).any():
        lines.append(UNKNOWN_STRENGTH)
    if min(member.sizes[dim] for dim in ("height", "constant_voltage")) > 1:
        lines += _capacitances(member, film["capacitance"])
    return lines


_NAMES = (
    "held", "film_state", "force", "charge", "capacitance", "pull_in_film_voltage", "largest_field",
    "largest_field_radius", "breakdown_share", "largest_limit_share", "least_tangent_stiffness",
    "least_tangent_stiffness_radius",
    "wrinkled_share", "film_error", "meridional_stretch", "thickness",
)  # fmt: skip


def _place(cell: xr.Dataset) -> str:
    where = "no rest" if np.isnan(float(cell["displacement"])) else measured(cell["displacement"])
    return f"{where} at {measured(cell['constant_voltage'])}"


def _state(cell: xr.Dataset) -> str:
    """Name the state of the film, or the reason why it is not held."""
    if int(cell["held"]) != Held.HELD:
        return Held(int(cell["held"])).meaning
    share = float(cell["wrinkled_share"])
    return event_label(cell["film_state"]) + (f", {share:.0%} of its area" if 0.0 < share < 1.0 else "")


def _strength(cell: xr.Dataset) -> str:
    share = float(cell["breakdown_share"])
    return (
        ""
        if np.isnan(share)
        else f", {share:.0%} of the dielectric strength" + (": breaks down" if share > 1.0 else "")
    )


def _state_line(cell: xr.Dataset) -> str:
    """A state in one line."""
    if int(cell["held"]) != Held.HELD:
        return f"  {_place(cell)}: {_state(cell)}"
    return (
        f"  {_place(cell)}: {_state(cell)}; force {measured(cell['force'], 3)}, capacitance "
        f"{measured(cell['capacitance'], 3)}, field {measured(cell['largest_field'], 3)}{_strength(cell)}"
    )


def _state_lines(cell: xr.Dataset) -> list[str]:
    """A single state in full."""
    lines = [f"{_place(cell)}: {_state(cell)}"]
    if np.isfinite(float(cell["force"])):
        lines.append(
            f"  force {measured(cell['force'])}, charge {measured(cell['charge'])}, capacitance "
            f"{measured(cell['capacitance'])} (exact; other commands use fits: force within "
            f"{float(cell['film_error']):.1%})"
        )
    if int(cell["held"]) != Held.HELD:
        return lines
    stretch, thickness = cell["meridional_stretch"], cell["thickness"]
    return [
        *lines,
        f"  largest field {measured(cell['largest_field'])} at the mounted radius "
        f"{measured(cell['largest_field_radius'])}{_strength(cell)}",
        f"  meridional stretch {float(stretch.min()):.4g} to {float(stretch.max()):.4g}, thickness "
        f"{float(thickness.min()):.4g} to {float(thickness.max()):.4g}{unit_of(thickness)}; at most "
        f"{float(cell['largest_limit_share']):.2g} of the stretch limit",
        f"  least tangent stiffness {measured(cell['least_tangent_stiffness'])} at the mounted radius "
        f"{measured(cell['least_tangent_stiffness_radius'])} (0: localisation); pulls in at this height at "
        f"{measured(cell['pull_in_film_voltage'])}",
    ]


def _capacitances(member: xr.Dataset, values: xr.DataArray) -> list[str]:
    """A table of capacitances, a row for each height."""
    chosen = np.unique(np.linspace(0, member.sizes["constant_voltage"] - 1, MOST_COLUMNS).round().astype(int))
    voltages = member["constant_voltage"].values[chosen]
    rows = [
        "  ".join([f"{float(height):10.4g}", *(_number(value) for value in row)])
        for height, row in zip(member["height"], values.values[:, chosen], strict=True)
    ]
    units = [unit_of(one) for one in (values, member["height"], member["constant_voltage"])]
    title = "capacitance{} over height{} and voltage{}:".format(*units)
    return [title, "  ".join([" " * 10, *(f"{v:10.4g}" for v in voltages)]), *shortened(rows)]


def _number(value: float) -> str:
    return f"{value:10.4g}" if np.isfinite(value) else f"{'-':>10}"
