"""Dataclasses of arrays with one row for each motion."""

from __future__ import annotations

from dataclasses import field, fields
from typing import Any, Self

import numpy as np


def column(empty: Any = np.nan, *dims: int | str, kind: Any = float) -> Any:
    """Declare a field of `Columns`: its value where nothing is known, its dims behind those of the motions (``"N"``:
    the number of states, ``"2N"``: twice that), and its type."""
    return field(metadata={"empty": empty, "dims": dims, "kind": kind})


class Columns:
    """A dataclass whose fields are arrays (motions, ...), each declared by `column`."""

    @classmethod
    def blank(cls, *shape: int, states: int = 2) -> Self:
        """Arrays in which nothing is known yet, for motions with this number of states."""
        made = {}
        for one in fields(cls):  # type: ignore[arg-type]
            dims = (states * int(d[:-1] or 1) if isinstance(d, str) else d for d in one.metadata["dims"])
            made[one.name] = np.full((*shape, *dims), one.metadata["empty"], dtype=one.metadata["kind"])
        return cls(**made)

    def take(self, rows: Any) -> Self:
        """Copies the rows of some motions."""
        return type(self)(**{name: np.array(values[rows]) for name, values in vars(self).items()})

    def put(self, rows: Any, other: Self) -> None:
        """Replaces the rows of some motions."""
        for name, values in vars(self).items():
            values[rows] = getattr(other, name)
