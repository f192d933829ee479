"""Tables of films, made once: kept in memory, and in the user's cache."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from gelcone.errors import InputError
from gelcone.files import write_whole
from gelcone.membrane.gel import Gel
from gelcone.membrane.table import names, table
from gelcone.quantity import Array


def numbers_of(law: Any, law_numbers: dict[str, Any], ratio: Any, A: Any, B: Any) -> dict[str, Array]:
    """The numbers of the tables of films, each an array of the shape that the arguments broadcast to.

    ``law`` is the strain-energy law, ``law_numbers`` are its numbers by name, ``ratio`` is a/b, A and B are the squared
    pre-stretches. Raises `InputError` for a ratio that is not below 1, and for films of which there is no table.
    """
    given = np.broadcast_arrays(ratio, A, B, *law_numbers.values())
    shape, rows = given[0].shape, np.stack([np.asarray(value, dtype=float).ravel() for value in given], axis=1)
    if np.any(rows[:, 0] >= 1.0):
        raise InputError(f"radius_ratio = {rows[:, 0].max():g}: must be below 1; the disc is smaller than its ring")
    each, place = np.unique(rows, axis=0, return_inverse=True)
    made = np.array([_made(law, tuple(law_numbers), tuple(map(float, row))) for row in each])
    return {name: made[place.ravel(), k].reshape(shape) for k, name in enumerate(names())}


@lru_cache(maxsize=512)
def _made(law: Any, law_names: tuple[str, ...], row: tuple[float, ...]) -> tuple[float, ...]:
    """The numbers of one table, from the user's cache if they are there."""
    key = json.dumps([type(law).__qualname__, law_names, [value.hex() for value in row], _program()])
    folder = _folder()
    path = None if folder is None else folder / f"{hashlib.sha256(key.encode()).hexdigest()[:24]}.json"
    if path is not None:
        with contextlib.suppress(OSError, ValueError, TypeError):
            known = json.loads(path.read_text(encoding="utf-8"))
            if len(known) == len(names()):
                return tuple(float.fromhex(value) for value in known)
    ratio, A, B, *own = row
    values = tuple(table(Gel(law, dict(zip(law_names, own, strict=True)), A, B), ratio).numbers().values())
    if path is not None:
        text = json.dumps([value.hex() for value in values])
        with contextlib.suppress(InputError, OSError):  # no place to keep it: it is made again next time
            path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(path, lambda to: _write(to, text), force=True)
    return values


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


@cache
def _program() -> str:
    """What tables depend on beside their film: the files of this folder."""
    files = sorted(Path(__file__).parent.glob("*.py"))
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()


def _folder() -> Path | None:
    """Where tables are kept; None where there is no place."""
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(base) / "gelcone" / "membranes" if os.path.isabs(base) else None
