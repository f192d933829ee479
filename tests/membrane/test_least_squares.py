"""Least squares by products of Chebyshev polynomials of u and q."""

import numpy as np
import pytest
from numpy.polynomial import polynomial

from gelcone.membrane.least_squares import chebyshev_to_powers, line, products, products_with_slope, solved

U, Q = np.random.default_rng(3).uniform([[-1.0], [0.0]], [[1.0], [1.1]], (2, 60))


def test_products_are_fitted_and_converted_to_powers():
    exact = np.array([[1.0, -2.0, 0.5], [0.3, 0.0, -1.0]])
    values = polynomial.polyval2d(U, Q, exact)
    found = solved(products(U, Q, (3, 4)), values, np.ones(U.size))
    powers = chebyshev_to_powers(found.reshape(4, 5))
    np.testing.assert_allclose(powers, np.pad(exact, ((0, 2), (0, 2))), atol=1e-12)


def test_trailing_zeros_keep_their_places_among_the_powers():
    rows = np.zeros((3, 4))
    rows[0, 0] = 2.0
    powers = chebyshev_to_powers(rows)
    assert powers.shape == rows.shape
    assert (powers[0, 0], np.count_nonzero(powers)) == (2.0, 1)


def test_slopes_by_q_are_those_of_the_products():
    value, by_q = products_with_slope(U, Q, (3, 4))
    np.testing.assert_array_equal(value, products(U, Q, (3, 4)))
    h = 1e-6
    expected = (products(U, Q + h, (3, 4)) - products(U, Q - h, (3, 4))) / (2.0 * h)
    np.testing.assert_allclose(by_q, expected, atol=1e-7)


def test_a_line_follows_the_values_of_the_larger_weight():
    u = np.array([-1.0, 0.0, 0.5, 1.0])
    np.testing.assert_allclose(line(u, 1.0 - 2.0 * u + u**3, 3, np.ones(4)), [1.0, -2.0, 0.0, 1.0], atol=1e-12)
    weight = np.array([1.0, 1.0, 1.0, 1e5])
    assert polynomial.polyval(1.0, line(u, u**2, 1, weight)) == pytest.approx(1.0, abs=1e-8)
    assert polynomial.polyval(1.0, line(u, u**2, 1, np.ones(4))) < 0.9
