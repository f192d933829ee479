"""Gauss's quadrature of smooth functions, for energies that follow from forces."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

POINTS = 32


def integral(function: Callable[[Any], Any], end: Any) -> Any:
    """Integral of ``function`` from 0 to ``end``, elementwise."""
    places, weights = np.polynomial.legendre.leggauss(POINTS)
    total = 0.0
    for place, weight in zip(0.5 * (places + 1.0), 0.5 * weights, strict=True):
        total = total + weight * function(place * end)
    return total * end
