"""Branches kept beside the bifurcation diagram that they belong to, in one Dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

PREFIX = "followed_"
"""Put before the names of all variables and dims of the branches."""
KEPT = ("mirror", "parameter")
"""Attributes that go along."""


def put_beside(diagram: xr.Dataset, followed: xr.Dataset) -> xr.Dataset:
    """The diagram with the branches of `gelcone.continue_branch` beside it."""
    names = [*map(str, followed.variables), *map(str, followed.dims)]
    beside = followed.rename({name: PREFIX + name for name in names})
    for variable in beside.variables.values():
        if "along" in variable.attrs:
            variable.attrs["along"] = variable.attrs["along"].replace("=", f"={PREFIX}")
    return diagram.merge(beside).assign_attrs({PREFIX + name: followed.attrs[name] for name in KEPT})


def branches_beside(diagram: xr.Dataset) -> xr.Dataset | None:
    """The branches beside a diagram, as `gelcone.continue_branch` gave them; None where there are none."""
    own = [str(name) for name in diagram.variables if str(name).startswith(PREFIX)]
    if not own:
        return None
    taken = diagram[own]
    names = [*own, *(str(dim) for dim in taken.dims if str(dim).startswith(PREFIX))]
    followed = taken.rename({name: name.removeprefix(PREFIX) for name in names})
    for variable in followed.variables.values():
        if "along" in variable.attrs:
            variable.attrs["along"] = variable.attrs["along"].replace(f"={PREFIX}", "=")
    # files of earlier versions do not say along which parameter: it is the diagram's
    kept = {name: diagram.attrs.get(PREFIX + name, diagram.attrs.get(name)) for name in KEPT}
    return followed.assign_attrs(kept)
