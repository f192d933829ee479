"""netCDF-4 files of results, with a checksum that is verified on reading."""

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
"""Attribute with the digest of all names, numbers and attributes of a file."""


def write_netcdf(dataset: xr.Dataset, path: Path) -> None:
    """Writes a Dataset with its checksum; `OSError` if that fails, for example on a full disk."""
    checked = dataset.assign_attrs({CHECKSUM: _digest(dataset)})
    try:
        checked.to_netcdf(path, engine="netcdf4")
    except RuntimeError as error:  # netCDF4 raises it for failed writes
        raise OSError(str(error)) from None


def read_netcdf(path: Path) -> xr.Dataset:
    """Reads a Dataset.

    Raises `InputError` if the contents do not match the checksum; files of version 0.2 and earlier have none. Damaged
    files raise the various errors of netCDF4 and xarray.
    """
    import xarray as xr

    dataset = xr.load_dataset(path, engine="netcdf4")
    for variable in dataset.variables.values():
        variable.encoding.clear()  # encoding of the file
    expected = dataset.attrs.pop(CHECKSUM, None)
    if expected not in (None, _digest(dataset)):
        raise InputError("its contents do not match its checksum: the file was damaged, or another program changed it")
    return dataset


def _digest(dataset: xr.Dataset) -> str:
    """Digest of everything that a file of the Dataset holds, independent of order."""
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
    """Attributes as text; netCDF does not distinguish a number from an array of one."""
    plain = {str(key): np.ravel(np.asarray(value)).tolist() for key, value in attributes.items()}
    return json.dumps(plain, sort_keys=True).encode()
