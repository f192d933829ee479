"""Roots without a formula, and their derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from gelcone.physics.dual import Dual, Functions
from gelcone.physics.implicit import root


def residual(y, a):
    return y + y * y * y - a


def zero(a, xp):
    return 0.0


def test_the_root_is_found_for_each_number_of_an_array():
    wanted = np.linspace(-2.0, 2.0, 41)
    found = root(np, "y", residual, [wanted + wanted**3], zero)
    np.testing.assert_allclose(found, wanted, rtol=1e-15, atol=1e-16)


def test_its_derivative_is_that_of_the_implicit_function():
    a = Dual(3.0, [1.0, 0.0])
    found = root(Functions(np), "y", residual, [a], zero)
    y = float(found.value)
    assert y + y**3 == pytest.approx(3.0, rel=1e-15)
    assert [float(part) for part in found.parts] == pytest.approx([1.0 / (1.0 + 3.0 * y * y), 0.0], rel=1e-14)
