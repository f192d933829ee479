"""Answers about the cone against the film as a continuum."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import unit_of
from gelcone.analyses.answer import heading
from gelcone.quantity import Array
from gelcone.words import members_of, shortened

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject

HOOP_SLACK = "converged, but compressed along the hoop: the film wrinkles there, and this state is not physical"
LIMITS = ("limit_displacement", "cone_limit_displacement")


def validate_words(shown: xr.Dataset, subject: Subject) -> str:
    """The text of the comparison on the terminal."""
    lines = heading(subject)
    for name, member in members_of(shown):
        text = [*_voltage_lines(member), *_pull_in_lines(member), *_limit_lines(member), *_mesh_lines(member)]
        lines += [*([f"{name}:"] if name else []), *text]
    return "\n".join(lines)


def _voltage_lines(member: xr.Dataset) -> list[str]:
    """At each voltage the deviation of the cone where the film is taut, and what became of it elsewhere."""
    from gelcone.continuum.path import Ending

    wrinkles = "pull_in_film_voltage" in member
    which = "finite elements, both wrinkling" if wrinkles else "finite elements where these are taut"
    ratio = f"radius of the disc over that of the film, a/b: {float(member['radius_ratio']):.4g}"
    lines = [ratio, f"relative difference of the cone's force from {which}:"]
    for i in range(member.sizes["constant_voltage"]):
        one = member.isel(constant_voltage=i)
        taut = (one["deviation"] if wrinkles else one["deviation"].where(~one["hoop_slack"])).values
        text = "no film in tension" if wrinkles else "the film is taut nowhere"
        if np.isfinite(taut).any():
            text = _ends(one, taut)
            if wrinkles and np.isfinite(one["membrane_deviation"]).any():
                text += f"; the membrane {_ends(one, one['membrane_deviation'].values, 2)}"
        lines.append(f"  {float(one['constant_voltage']):.4g}{unit_of(one['constant_voltage'])}: {text}")
        endings = [Ending(code) for code in one["ending"].values]
        wrinkled = 0 if wrinkles else int((one["hoop_slack"] & (one["ending"] == Ending.CONVERGED)).sum())
        if wrinkled:
            lines.append(f"    {wrinkled} of {len(endings)}: {HOOP_SLACK}")
        kinds = [ending for ending in Ending if ending and ending in endings]
        lines += [f"    {endings.count(ending)} of {len(endings)}: {ending.meaning}" for ending in kinds]
    return shortened(lines)


def _ends(one: xr.Dataset, share: Array, digits: int = 1) -> str:
    """The least and the largest of shares over the displacements, and where."""
    ends = dict.fromkeys((int(np.nanargmin(share)), int(np.nanargmax(share))))
    return " to ".join(f"{share[k]:+.{digits}%} at {_place(one, k)}" for k in ends)


def _pull_in_lines(member: xr.Dataset) -> list[str]:
    """Above which voltages continuum and cone have pulled in."""
    if "pull_in_film_voltage" not in member:
        return []
    own, cone, membrane = (member[f"{film}pull_in_film_voltage"] for film in ("", "cone_", "membrane_"))
    lines = [
        f"  at {_place(member, k)}: {float(v):.4g}{unit_of(own)}, the cone above {float(cone[k]):.4g}{unit_of(own)}, "
        f"the membrane above {float(membrane[k]):.4g}{unit_of(own)}"
        for k, v in enumerate(own.values)
        if np.isfinite(v)
    ]
    none = "no film has pulled in at the given voltages"
    return shortened(["the continuum has pulled in above:", *lines]) if lines else [none]


def _place(one: xr.Dataset, k: int) -> str:
    return f"{float(one['displacement'][k]):.4g}{unit_of(one['displacement'])}"


def _limit_lines(member: xr.Dataset) -> list[str]:
    """List the displacements at which continuum and cone reach shares of the stretch limit."""
    lines = []
    for k, share in enumerate(member["share"].values):
        continuum, cone = (float(member[name][k]) for name in LIMITS)
        if np.isfinite(continuum):
            unit = unit_of(member["limit_displacement"])
            lines.append(f"  {share:.0%} of the stretch limit at {continuum:.4g}{unit}, the cone at {cone:.4g}{unit}")
    return ["without voltage the film reaches, next to the disc:", *lines] if lines else []


def _mesh_lines(member: xr.Dataset) -> list[str]:
    """The mesh-convergence table."""
    if not np.isfinite(member["mesh_force"]).all():
        return []
    place = f"{float(member['mesh_displacement']):.4g}{unit_of(member['mesh_displacement'])}"
    lines = [f"mesh at {place}: elements, error of the force (order), of the shape (order)"]
    for k, count in enumerate(member["mesh_elements"].values):
        one = {n: float(member[f"mesh_{n}"][k]) for n in ("force_error", "force_order", "shape_error", "shape_order")}
        orders = [f" ({one[n]:.2f})" if np.isfinite(one[n]) else "" for n in ("force_order", "shape_order")]
        lines.append(f"  {count:4d}  {one['force_error']:.2e}{orders[0]}  {one['shape_error']:.2e}{orders[1]}")
    return lines
