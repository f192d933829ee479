"""Measured columns from MATLAB files: their vectors, within bounds."""

from __future__ import annotations

import struct
import zlib
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from gelcone.devices.units import DIMENSIONS
from gelcone.errors import InputError
from gelcone.files import read_data
from gelcone.quantity import Array

MOST_VALUES = 2_000_000
"""Most values of all vectors of a file."""
MOST_NAMES = 64
HDF5 = b"\x89HDF\r\n\x1a\n"
KINDS = {"double", "single", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"}
UNITS = {unit for dimension in DIMENSIONS.values() for unit in dimension.powers if unit}


def read_vectors(path: Path, remedy: str) -> dict[str, tuple[Array, str | None]]:
    """Read the vectors of a MATLAB file up to version 7.2: name -> values, and the unit.

    The unit is what follows the last underscore of a name where that is a unit, as in ``stress_kPa``. What is not a
    vector of numbers is left out.

    Raises
    ------
    InputError : for a file that is damaged or too large, without vectors, or with vectors of several lengths.
    """
    from scipy.io.matlab import MatReadError

    data = read_data(path, remedy)
    if HDF5 in data[:1024]:
        raise InputError(f"{path.name}: is of MATLAB 7.3 (HDF5), which is not read; save it with -v7, or export CSV")
    try:
        found = _matlab(data)
    except InputError as error:
        raise InputError(f"{path.name}: {error}") from None
    except (ValueError, TypeError, KeyError, IndexError, OSError, RuntimeError, EOFError, AttributeError,
            NotImplementedError, MemoryError, ArithmeticError, struct.error, zlib.error, MatReadError):  # fmt: skip
        raise InputError(f"{path.name}: is damaged, or no MATLAB file; export it again, or as CSV") from None
    vectors = {name: np.asarray(values, dtype=float).ravel() for name, values in found.items()}
    if not vectors:
        raise InputError(f"{path.name}: has no vectors of numbers; store each column as a vector")
    lengths = {name: values.size for name, values in vectors.items()}
    if len(set(lengths.values())) > 1:
        shown = ", ".join(f"{name} {size}" for name, size in list(lengths.items())[:4])
        raise InputError(f"{path.name}: its vectors have several lengths ({shown}); store one test in a file")
    return dict(_unit_of(name, values) for name, values in vectors.items())


def _unit_of(name: str, values: Array) -> tuple[str, tuple[Array, str | None]]:
    before, _, after = name.rpartition("_")
    return (before, (values, after)) if before and after in UNITS else (name, (values, None))


def _matlab(data: bytes) -> dict[str, Any]:
    """Vectors of numbers, refused where there are too many."""
    from scipy.io import loadmat, whosmat

    shapes = {name: tuple(map(int, shape)) for name, shape, kind in whosmat(BytesIO(data)) if kind in KINDS}
    sizes = {name: float(np.prod(shape, dtype=float)) for name, shape in shapes.items()}
    names = [name for name, shape in shapes.items() if shape and 1 < max(shape) == sizes[name]]
    total = sum(sizes[name] for name in names)
    if len(names) > MOST_NAMES or total > MOST_VALUES:
        most = f"give at most {MOST_NAMES} of {MOST_VALUES:.3g}"
        raise InputError(f"has {len(names)} vectors of {total:.3g} values; {most}")
    found = loadmat(BytesIO(data), variable_names=names) if names else {}
    return {name: found[name] for name in names if np.isrealobj(found[name])}
