"""netCDF-4 files of results, which are read back only as they were written."""

from __future__ import annotations

import json
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

CHECKSUM = "checksum"
"""Attribute of a file that holds the digest of all its names, numbers and attributes."""


def write_netcdf(dataset: xr.Dataset, path: Path) -> None:
    """Write a Dataset with its checksum; `OSError` where that fails, such as on a full disk."""
    checked = dataset.assign_attrs({CHECKSUM: _digest(dataset)})
    try:
        checked.to_netcdf(path, engine="netcdf4")
    except RuntimeError as error:  # netCDF4 has no other for a write that fails
        raise OSError(str(error)) from None


def read_netcdf(path: Path) -> xr.Dataset:
    """Read a Dataset.

    Raises `InputError` where the contents do not match the checksum; files of version 0.2 and earlier have none. Errors
    of a damaged file are those of netCDF4 and xarray, of many kinds.
    """
    import xarray as xr

    dataset = xr.load_dataset(path, engine="netcdf4")
    for variable in dataset.variables.values():
        variable.encoding.clear()  # how the file held it
    expected = dataset.attrs.pop(CHECKSUM, None)
    if expected not in (None, _digest(dataset)):
        raise InputError("its contents do not match its checksum: the file was damaged, or another program changed it")
    return dataset


def _digest(dataset: xr.Dataset) -> str:
    """Digest of all that a file of the Dataset holds, in any order."""
    digest = blake2b(digest_size=16)
    digest.update(_text(dataset.attrs))
    for name in sorted(map(str, dataset.variables)):
        variable = dataset.variables[name]
        digest.update(_text({"name": name, "dims": variable.dims, "shape": variable.shape, **variable.attrs}))
        values = variable.values
        is_text = values.dtype.kind in "OU"
        digest.update(_text({"values": values.astype(str)}) if is_text else np.ascontiguousarray(values).tobytes())
    return digest.hexdigest()


def _text(attributes: dict[Any, Any]) -> bytes:
    """Attributes as text; netCDF does not distinguish an array of one element from a number."""
    plain = {str(key): np.ravel(np.asarray(value)).tolist() for key, value in attributes.items()}
    return json.dumps(plain, sort_keys=True).encode()
