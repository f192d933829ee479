"""Arrays of many motions, one row a motion."""

from __future__ import annotations

from typing import Any, Self

import numpy as np


class Columns:
    """A dataclass whose fields are arrays (motions, ...)."""

    def take(self, rows: Any) -> Self:
        """Some of the motions."""
        return type(self)(**{name: np.array(values[rows]) for name, values in vars(self).items()})

    def put(self, rows: Any, other: Self) -> None:
        """Replaces some of the motions."""
        for name, values in vars(self).items():
            values[rows] = getattr(other, name)
