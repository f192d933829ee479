"""netCDF-4 files: HDF5 datasets with dimension scales, as xarray writes them with h5netcdf.

h5netcdf finds every object by its path again at each access, about eighty times a variable; written and read directly a
file of forty variables takes a fifth of the time.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import h5py
    import xarray as xr

BARE = "This is a netCDF dimension but not a netCDF variable."
"""Name of the scale of a dim without a variable of its name."""
OF_THE_FORMAT = frozenset({"CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST", "_NCProperties"}) | {
    "_Netcdf4Dimid",
    "_Netcdf4Coordinates",
}
"""Attributes by which HDF5 and netCDF hold dims."""


def write_netcdf(dataset: xr.Dataset, path: Path) -> None:
    """Write a Dataset to ``path``."""
    import h5py
    from xarray.conventions import cf_encoder, encode_dataset_coordinates

    variables, attributes = cf_encoder(*encode_dataset_coordinates(dataset))
    sizes = {dim: size for variable in variables.values() for dim, size in variable.sizes.items()}
    numbers = {dim: np.int32(number) for number, dim in enumerate(sizes)}
    with h5py.File(path, "w", track_order=True) as file:
        for dim in (dim for dim in sizes if dim not in variables):
            scale = _create(file, dim, (sizes[dim],), ">f4")
            scale.attrs["_Netcdf4Dimid"] = numbers[dim]
            scale.make_scale(f"{BARE}{sizes[dim]:10}")
        for name, variable in variables.items():
            _write_variable(file, name, variable, numbers)
        for name, variable in variables.items():
            for place, dim in enumerate(variable.dims):
                if variable.dims != (name,):
                    file[name].dims[place].attach_scale(file[dim])
        _write_attributes(file, attributes)
        libraries = {"h5netcdf": version("h5netcdf"), "hdf5": h5py.version.hdf5_version, "h5py": h5py.__version__}
        file.attrs["_NCProperties"] = np.bytes_(",".join(["version=2", *(f"{k}={v}" for k, v in libraries.items())]))


def read_netcdf(path: Path) -> xr.Dataset:
    """Read a Dataset; the errors are those of h5py and xarray, of many kinds for a damaged file."""
    import h5py
    import xarray as xr

    with h5py.File(path) as file:
        parts = {name: part for name, part in file.items() if not _name_of_scale(part).startswith(BARE)}
        variables = {name: _read_variable(name, part) for name, part in parts.items()}
        return xr.decode_cf(xr.Dataset(variables, attrs=_read_attributes(file)))


def _create(file: h5py.File, name: Any, shape: tuple[int, ...], dtype: Any, **options: Any) -> h5py.Dataset:
    """Create an HDF5 dataset; a dim without elements may grow in netCDF."""
    if 0 in shape:
        options["maxshape"] = tuple(size or None for size in shape)
    return file.create_dataset(name, shape, dtype, track_order=True, **options)


def _write_variable(file: h5py.File, name: Any, variable: xr.Variable, numbers: Mapping[Any, np.int32]) -> None:
    """Write an encoded variable; ``numbers`` are those of the dims."""
    import h5py

    attributes, values = dict(variable.attrs), variable.values
    fill = attributes.pop("_FillValue", None)
    if values.dtype.kind in "OU":
        written = _create(file, name, values.shape, h5py.string_dtype(), data=values.astype(object))
    else:
        written = _create(file, name, values.shape, values.dtype, data=values, fillvalue=fill)
    if variable.dims:
        written.attrs["_Netcdf4Coordinates"] = np.array([numbers[dim] for dim in variable.dims])
        if variable.dims == (name,) or variable.shape[0]:
            written.attrs["_Netcdf4Dimid"] = numbers[variable.dims[0]]
    if fill is not None:
        attributes = {"_FillValue": values.dtype.type(fill)} | attributes
    _write_attributes(written, attributes)
    if variable.dims == (name,):
        written.make_scale(name)


def _read_variable(name: str, part: h5py.Dataset) -> xr.Variable:
    """Read a variable as it is encoded in the file."""
    import xarray as xr

    dims = [name] if part.is_scale else [dim[0].name.removeprefix("/") for dim in part.dims]
    values = part.asstr()[()] if part.dtype.kind == "O" else part[()]
    return xr.Variable(dims, values, _read_attributes(part))


def _write_attributes(to: h5py.HLObject, attributes: Mapping[Any, Any]) -> None:
    """Write attributes; numbers are arrays in netCDF."""
    for key, value in attributes.items():
        to.attrs[key] = value if isinstance(value, str) else np.atleast_1d(value)


def _read_attributes(part: h5py.HLObject) -> dict[str, Any]:
    """Read attributes; an array of one element is a number in netCDF."""
    found = {key: value for key, value in part.attrs.items() if key not in OF_THE_FORMAT}
    return {key: value[0] if np.shape(value) == (1,) else value for key, value in found.items()}


def _name_of_scale(part: h5py.Dataset) -> str:
    return part.attrs.get("NAME", b"").decode()
