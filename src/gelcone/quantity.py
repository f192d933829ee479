"""A named quantity with its bounds, and the check that every number passes at the edge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.errors import InputError

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Quantity:
    """What a parameter means and which values it may take.

    ``lower`` is allowed itself unless ``positive`` is set; infinity only where ``infinite`` is.
    """

    symbol: str
    meaning: str
    default: float
    lower: float = -np.inf
    positive: bool = False
    infinite: bool = False

    def check(self, name: str, value: Any) -> float | Array:
        """``value`` as a float, or as a float array when it is one; `InputError` when out of bounds."""
        try:
            if isinstance(value, str | bytes | bool) or np.asarray(value).dtype.kind not in "iuf":
                raise TypeError
            array = np.asarray(value, dtype=float)
        except (TypeError, ValueError):
            raise InputError(f"{name} = {value!r}: must be a number or an array of numbers") from None
        if array.size == 0:
            raise InputError(f"{name} = []: is empty; give at least one value")
        if np.isnan(array).any():
            raise InputError(
                f"{name} = nan: must be a number; leave the parameter out to take its default {self.default:g}"
            )
        if not self.infinite and np.isinf(array).any():
            raise InputError(f"{name} = {array[np.isinf(array)][0]:g}: must be finite")
        smallest = float(array.min())
        if self.positive and smallest <= 0.0:
            raise InputError(f"{name} = {smallest:g}: must be greater than 0")
        if smallest < self.lower:
            raise InputError(f"{name} = {smallest:g}: must be at least {self.lower:g}")
        return float(array) if array.ndim == 0 else array.copy()
