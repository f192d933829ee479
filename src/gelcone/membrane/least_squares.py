"""Least squares by products of Chebyshev polynomials of u and q."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import chebyshev, polynomial

from gelcone.membrane.gel import Array

SMALLEST = 1e-6
"""Singular values below this share of the largest are left out of a fit by default."""


def products(u: Array, q: Array, degrees: tuple[int, int]) -> Array:
    """Products of Chebyshev polynomials of u and 2 q - 1, (places, products)."""
    terms: Array = chebyshev.chebvander2d(u, 2.0 * q - 1.0, degrees)
    return terms


def products_with_slope(u: Array, q: Array, degrees: tuple[int, int]) -> tuple[Array, Array]:
    """`products` and their derivatives by q."""
    slopes = 2.0 * chebyshev.chebval(2.0 * q - 1.0, chebyshev.chebder(np.eye(degrees[1] + 1))).T
    by_q = chebyshev.chebvander(u, degrees[0])[:, :, None] * slopes[:, None, :]
    return products(u, q, degrees), by_q.reshape(u.size, -1)


def solved(matrix: Array, values: Array, weight: Array, smallest: float = SMALLEST) -> Array:
    """The coefficients of the columns of ``matrix`` whose weighted sum of squared errors from ``values`` is least."""
    coefficients: Array = np.linalg.lstsq(matrix * weight[:, None], values * weight, rcond=smallest)[0]
    return coefficients


def line(u: Array, values: Array, degree: int, weight: Array) -> Array:
    """The polynomial of u through values, by rising powers."""
    powers: Array = chebyshev.cheb2poly(solved(chebyshev.chebvander(u, degree), values, weight))
    return powers


def chebyshev_to_powers(rows: Array) -> Array:
    """Converts coefficients of Chebyshev polynomials of u and 2 q - 1 to those of powers of u and q."""
    in_u = np.apply_along_axis(_padded, 0, rows)
    shifted = np.zeros_like(in_u)
    for row, coefficients in zip(shifted, in_u, strict=True):
        total = polynomial.Polynomial(_padded(coefficients))(polynomial.Polynomial([-1.0, 2.0])).coef
        row[: total.size] = total
    return shifted


def _padded(coefficients: Array) -> Array:
    """Coefficients of powers for those of Chebyshev polynomials, in equal number; NumPy drops trailing zeros."""
    powers = chebyshev.cheb2poly(coefficients)
    return np.pad(powers, (0, coefficients.size - powers.size))
