"""Branches of periodic orbits attached to the diagram along the same parameter, in one Dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

PREFIX = "followed_"
"""Prefix of the names of all variables and dims of the branches."""
KEPT = ("mirror", "parameter")
"""Attributes that are attached, too."""


def attach(diagram: xr.Dataset, followed: xr.Dataset) -> xr.Dataset:
    """The diagram with the branches of `gelcone.continue_branch` attached."""
    names = [*map(str, followed.variables), *map(str, followed.dims)]
    renamed = followed.rename({name: PREFIX + name for name in names})
    for variable in renamed.variables.values():
        if "along" in variable.attrs:
            variable.attrs["along"] = variable.attrs["along"].replace("=", f"={PREFIX}")
    return diagram.merge(renamed).assign_attrs({PREFIX + name: followed.attrs[name] for name in KEPT})


def attached_branches(diagram: xr.Dataset) -> xr.Dataset | None:
    """The branches attached to a diagram, as `gelcone.continue_branch` gave them; None where there are none."""
    attached_names = [str(name) for name in diagram.variables if str(name).startswith(PREFIX)]
    if not attached_names:
        return None
    taken = diagram[attached_names]
    names = [*attached_names, *(str(dim) for dim in taken.dims if str(dim).startswith(PREFIX))]
    followed = taken.rename({name: name.removeprefix(PREFIX) for name in names})
    for variable in followed.variables.values():
        if "along" in variable.attrs:
            variable.attrs["along"] = variable.attrs["along"].replace(f"={PREFIX}", "=")
    # files of earlier versions lack the parameter: it is that of the diagram
    kept = {name: diagram.attrs.get(PREFIX + name, diagram.attrs.get(name)) for name in KEPT}
    return followed.assign_attrs(kept)
