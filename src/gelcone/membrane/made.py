"""Tables of films, each made once: kept in memory and in the disk cache."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from gelcone import disk_cache
from gelcone.errors import InputError
from gelcone.membrane.gel import Array, Gel
from gelcone.membrane.table import names, table

KIND = "membranes"
DIGITS, MOST = 13, 4096
"""Of what tables are made for; and tables held in memory."""


def numbers_of(law: Any, law_numbers: Mapping[str, Any], ratio: Any, A: Any, B: Any) -> dict[str, Array]:
    """The numbers of the tables of films, each an array of the shape that the arguments broadcast to.

    ``law`` is the strain-energy law, ``law_numbers`` are its numbers by name, ``ratio`` is a/b, A and B are the squared
    pre-stretches. Raises `InputError` for a ratio that is not below 1, and for films of which there is no table.
    """
    given = np.broadcast_arrays(ratio, A, B, *law_numbers.values())
    shape = given[0].shape
    rows = np.stack([_rounded(value) for value in given], axis=1)
    if np.any(rows[:, 0] >= 1.0):
        raise InputError(f"radius_ratio = {rows[:, 0].max():g}: must be below 1; the disc is smaller than its ring")
    each, place = np.unique(rows, axis=0, return_inverse=True)
    made = np.array([_made(law, tuple(law_numbers), tuple(map(float, row))) for row in each])
    return {name: made[place.ravel(), k].reshape(shape)[()] for k, name in enumerate(names())}


def _rounded(values: Any) -> Array:
    """To `DIGITS`: devices that differ in rounding alone, such as in their units, share a table."""
    return np.array([float(f"{value:.{DIGITS}g}") for value in np.ravel(np.asarray(values, dtype=float))])


@lru_cache(maxsize=MOST)
def _made(law: Any, law_names: tuple[str, ...], row: tuple[float, ...]) -> tuple[float, ...]:
    """The numbers of one table, in the order of their names."""
    ratio, A, B, *own = row

    def make() -> bytes:
        with np.errstate(all="ignore"):
            found = table(Gel(law, dict(zip(law_names, own, strict=True)), A, B), ratio)
        return np.array([found[name] for name in names()]).tobytes()

    parts = (type(law), law, law_names, row)
    return tuple(np.frombuffer(disk_cache.made(KIND, parts, make, (Path(__file__).parent, type(law)))).tolist())
