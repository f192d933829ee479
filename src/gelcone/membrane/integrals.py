"""Integrals of the force over the height, by Gauss's quadrature between two of its kinks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from gelcone.membrane.force import Numbers, Pull

POINTS = 16
"""Quadrature points between two kinks of the force."""


def integrals(pull: Callable[..., Pull], low: Any, high: Any, V: Any, n: Numbers, c: Any) -> tuple[Any, Any]:
    """Integrals over s of k and of its derivative by V.

    The variable is log s where ``low`` is positive, since both vary there with V over the voltage of a slack film;
    elsewhere it is log(s + c).
    """
    add = np.where(low > 0.0, 0.0, c)
    start = np.log(low + add)
    length = np.log(np.maximum(high, low) + add) - start
    places, weights = np.polynomial.legendre.leggauss(POINTS)
    k = by_v = 0.0
    for place, weight in zip(0.5 * (places + 1.0), 0.5 * weights, strict=True):
        shifted = np.exp(start + place * length)
        integrand = pull(shifted - add, V, n)
        k, by_v = k + weight * shifted * integrand.k, by_v + weight * shifted * integrand.by_v
    return length * k, length * by_v
