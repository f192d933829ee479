"""Tables of films, each made once and stored in memory and in the disk cache."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from gelcone import bracket, disk_cache
from gelcone.errors import DoubtfulInput, InputError
from gelcone.membrane.gel import Array, Gel
from gelcone.membrane.table import names, table

KIND = disk_cache.MEMBRANES
Film = tuple[Any, tuple[str, ...], tuple[float, ...]]
"""Law, names of its numbers, and the ratio, the squared pre-stretches and these numbers."""
MANY, SECONDS = 16, (3, 8)
"""Number of films to be made above which a warning says so, and the time that each takes."""
DIGITS, MOST = 13, 4096
"""Digits of the numbers that tables are made for, and number of tables held in memory."""

_asked: set[Film] = set()
"""Films asked for in this process."""


def numbers_of(law: Any, law_numbers: Mapping[str, Any], ratio: Any, A: Any, B: Any) -> dict[str, Any]:
    """The numbers of the tables of films, each an array of the shape that the arguments broadcast to, or one number
    where all share a film; among several films NaN for those without a table.

    ``law`` is the strain-energy law, ``law_numbers`` are its numbers by name, ``ratio`` is a/b, A and B are the squared
    pre-stretches. Raises `InputError` for a ratio that is not below 1, and for a single film without a table.
    """
    given = np.broadcast_arrays(ratio, A, B, *law_numbers.values())
    shape = given[0].shape
    rows = np.stack([rounded(value) for value in given], axis=1)
    if np.any(rows[:, 0] >= 1.0):
        raise InputError(f"radius_ratio = {rows[:, 0].max():g}: must be below 1; the disc is smaller than its ring")
    each, place = np.unique(rows, axis=0, return_inverse=True)
    films = [(law, tuple(law_numbers), tuple(map(float, row))) for row in each]
    _say_what_it_costs(films)
    tables = [_made(*film) for film in films]
    if not shape and isinstance(tables[0], str):
        raise InputError(tables[0])
    none = (math.nan,) * len(names())
    made = [none if isinstance(table, str) else table for table in tables]
    if len(made) == 1:
        return dict(zip(names(), made[0], strict=True))
    matrix = np.array(made)
    return {name: matrix[place.ravel(), k].reshape(shape) for k, name in enumerate(names())}


def _say_what_it_costs(films: Sequence[Film]) -> None:
    """Warn that more than `MANY` of the films have to be made first."""
    asked = [film for film in films if film not in _asked]
    _asked.update(asked)
    missing = 0 if len(asked) <= MANY else sum(not disk_cache.holds(KIND, *_stored(*film)) for film in asked)
    if missing > MANY:
        warnings.warn(
            f"{missing} membranes that differ are made first, in {SECONDS[0]} to {SECONDS[1]} s of one core each, "
            f"{missing * SECONDS[0] / 60.0:.0f} to {missing * SECONDS[1] / 60.0:.0f} min in all, and stored for later "
            "runs; film = wrinkling needs none",
            DoubtfulInput,
            stacklevel=2,
        )


def _stored(law: Any, law_names: tuple[str, ...], row: tuple[float, ...]) -> tuple[object, disk_cache.Sources]:
    """The parts that identify a table in the disk cache, and the sources that it follows from."""
    return (type(law), law, law_names, row), (Path(__file__).parent, Path(bracket.__file__), type(law))


def refusal(law: Any, law_numbers: Mapping[str, Any], ratio: Any, A: Any, B: Any) -> str:
    """The reason why one film has no table; empty where it has one."""
    row = np.concatenate([rounded(value) for value in (ratio, A, B, *law_numbers.values())])
    outcome = _made(law, tuple(law_numbers), tuple(row.tolist()))
    return outcome if isinstance(outcome, str) else ""


def rounded(values: Any) -> Array:
    """Values rounded to `DIGITS`, so that devices that differ in rounding alone, such as in units, share a table."""
    return np.array([float(f"{value:.{DIGITS}g}") for value in np.ravel(np.asarray(values, dtype=float))])


@lru_cache(maxsize=MOST)
def _made(law: Any, law_names: tuple[str, ...], row: tuple[float, ...]) -> tuple[float, ...] | str:
    """The numbers of one table, in the order of their names, or the reason why there is none."""
    ratio, A, B, *law_numbers = row

    def make() -> bytes:
        try:
            with np.errstate(all="ignore"):
                numbers = table(Gel(law, dict(zip(law_names, law_numbers, strict=True)), A, B), ratio)
        except InputError as refusal:  # stored like a table, since finding it takes seconds, too
            return str(refusal).encode()
        return np.array([numbers[name] for name in names()]).tobytes()

    parts, sources = _stored(law, law_names, row)
    content = disk_cache.made(KIND, parts, make, sources)
    if len(content) != np.dtype(float).itemsize * len(names()):
        return content.decode()
    return tuple(np.frombuffer(content).tolist())
