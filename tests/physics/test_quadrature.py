"""The quadrature: exact for polynomials, elementwise, and as good as SciPy's for smooth functions."""

import numpy as np
import pytest
from scipy.integrate import quad

from gelcone.physics.quadrature import POINTS, integral


@pytest.mark.parametrize("power", [0, 1, 2, 7, 2 * POINTS - 1])
def test_polynomials_up_to_twice_the_points_are_exact(power):
    assert integral(lambda x: x**power, 1.3) == pytest.approx(1.3 ** (power + 1) / (power + 1), rel=1e-13)


def test_a_power_beyond_is_not():
    assert abs(integral(lambda x: (2.0 * x - 1.0) ** (8 * POINTS), 1.0) * (8 * POINTS + 1) - 1.0) > 1e-3


def test_smooth_functions_and_signs_elementwise():
    ends = np.array([[-2.0, 0.0, 0.3], [1.0, 2.5, -0.7]])
    found = integral(lambda x: np.exp(-x) / (1.0 + x * x), ends)
    assert found.shape == ends.shape
    for index in np.ndindex(ends.shape):
        assert found[index] == pytest.approx(quad(lambda x: np.exp(-x) / (1.0 + x * x), 0.0, ends[index])[0], rel=1e-10)
