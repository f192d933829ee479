"""Measured columns from MATLAB and HDF5 files: their vectors, up to a largest size."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from gelcone.devices.hdf5 import MOST_VALUES, SIGNATURE, UNPACKED, Vector, gathered, too_much, vectors_of
from gelcone.devices.units import DIMENSIONS
from gelcone.errors import InputError
from gelcone.files import read_data
from gelcone.quantity import Array

MATRIX, COMPRESSED, COMPLEX = 14, 15, 0x0800
NUMERIC = range(6, 16)
"""Classes of arrays of numbers."""
STORED = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
"""Types of stored numbers, by their code."""
UNITS = {unit for dimension in DIMENSIONS.values() for unit in dimension.powers if unit}


def read_vectors(path: Path, file: str, remedy: str) -> dict[str, tuple[Array, str | None]]:
    """Read the vectors of a MATLAB or HDF5 file, called ``file`` in messages: name -> values, and the unit.

    The unit is that of an attribute ``units``, or the text after the last underscore of a name if that is a unit, as in
    ``stress_kPa``. Other data than vectors of numbers are left out; of HDF5 files the datasets of the root are read.

    Raises
    ------
    InputError : for a file that is damaged or too large, without vectors, or with vectors of several lengths.
    """
    data = read_data(path, remedy)
    try:
        vectors = vectors_of(data) if SIGNATURE in data[:2056] else gathered(_matlab(data))
    except InputError as error:
        raise InputError(f"{file}: {error}") from None
    except (ValueError, IndexError, struct.error, zlib.error):
        raise InputError(f"{file}: is damaged, or no MATLAB or HDF5 file; export it again, or as CSV") from None
    if not vectors:
        raise InputError(f"{file}: has no vectors of numbers; store each column as a vector")
    lengths = {name: vector.values.size for name, vector in vectors.items()}
    if len(set(lengths.values())) > 1:
        shown = ", ".join(f"{name} {size}" for name, size in list(lengths.items())[:4])
        raise InputError(f"{file}: its vectors have several lengths ({shown}); store one test in a file")
    columns = dict(_unit_of(name, *vector) for name, vector in vectors.items())
    if len(columns) < len(vectors):
        raise InputError(f"{file}: has two columns of one name with different units; leave one out or rename it")
    return columns


def _unit_of(name: str, values: Array, unit: str) -> tuple[str, tuple[Array, str | None]]:
    if unit:
        return name, (values, unit)
    before, _, after = name.rpartition("_")
    return (before, (values, after)) if before and after in UNITS else (name, (values, None))


def _matlab(data: bytes) -> Iterator[tuple[str, Vector | None]]:
    """Read the matrices of a MATLAB file: names, and vectors of numbers, None for other data.

    Its elements are read here, since `scipy.io.loadmat` ends the process at some damaged files.
    """
    order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
    if order is None:
        raise ValueError("no MATLAB 5 file")
    total = 0
    for kind, body in _elements(data[128:], order):
        if kind == COMPRESSED:
            unpacked = zlib.decompressobj().decompress(body, 8 * MOST_VALUES + 4096)
            total += len(unpacked)
            if total > UNPACKED * MOST_VALUES:
                raise too_much()
            (kind, body), *_ = _elements(unpacked, order)
        if kind == MATRIX:
            yield _vector(body, order)


def _elements(data: bytes, order: str) -> Iterator[tuple[int, bytes]]:
    """Type and data of the elements of a file or matrix."""
    at = 0
    while at + 8 <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, at)
        if kind >> 16:  # a small one: size and type share a word
            yield kind & 0xFFFF, data[at + 4 : at + 4 + min(kind >> 16, 4)]
            at += 8
            continue
        if at + 8 + size > len(data):
            raise ValueError("an element is longer than the file")
        yield kind, data[at + 8 : at + 8 + size]
        at += 8 + (size if kind == COMPRESSED else -(-size // 8) * 8)


def _vector(body: bytes, order: str) -> tuple[str, Vector | None]:
    """Name and content of a matrix that is a vector of real numbers; None for other data."""
    parts = [element for _, element in zip(range(4), _elements(body, order), strict=False)]
    if len(parts) < 4:
        return "", None
    (_, flags), (_, shape), (_, name), (kind, numbers) = parts
    (about,) = struct.unpack_from(f"{order}I", flags)
    if about & COMPLEX or about & 0xFF not in NUMERIC or kind not in STORED:
        return "", None
    dims = np.frombuffer(shape, f"{order}i4").astype(float)
    stored = np.dtype(f"{order}{STORED[kind]}")
    values = np.frombuffer(numbers[: len(numbers) // stored.itemsize * stored.itemsize], stored)
    if values.size < 2 or dims.max() != values.size or dims.prod() != values.size:
        return "", None
    return name.decode("ascii"), Vector(values.astype(float), "")
