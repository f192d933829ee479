"""Roots of one number."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from gelcone.physics.bracket import sign_change


@given(st.floats(-20.0, 20.0), st.floats(0.0, 3.0), st.integers(1, 9))
def test_root_is_known_to_rounding(root: float, curvature: float, power: int) -> None:
    def function(x: float) -> float:
        return (x - root) ** power if power % 2 else math.expm1(curvature * (x - root)) + (x - root)

    found = sign_change(function, root - 3.0, root + 7.0)
    assert abs(found - root) <= 4e-16 * abs(root) + 1e-300 or function(found) == 0.0


def test_as_scipy() -> None:
    for k in range(1, 40):
        function = lambda x, k=k: math.cos(x) - k * x**3  # noqa: E731
        assert sign_change(function, 0.0, 4.0) == pytest.approx(brentq(function, 0.0, 4.0, xtol=1e-300), rel=4e-16)


def test_few_evaluations_where_smooth_and_bisection_where_not() -> None:
    counted: list[float] = []

    def jump(x: float) -> float:
        counted.append(x)
        return math.copysign(np.inf, x - 1.0 / 3.0)

    assert sign_change(jump, -1.0, 1.0) == pytest.approx(1.0 / 3.0, abs=2e-16)
    assert len(counted) < 62
    counted.clear()

    def smooth(x: float) -> float:
        counted.append(x)
        return x**3 - 2.0 * x - 5.0

    assert smooth(sign_change(smooth, 2.0, 3.0)) == pytest.approx(0.0, abs=1e-14)
    assert len(counted) < 15


def test_ends_that_are_roots_and_ends_that_are_not_apart() -> None:
    assert sign_change(lambda x: x, 0.0, 1.0) == 0.0
    assert sign_change(lambda x: x - 1.0, 0.0, 1.0) == 1.0
    assert sign_change(lambda x: x - 1e-300, -1.0, 1.0) == pytest.approx(1e-300, rel=1e-7)
    with pytest.raises(ArithmeticError, match="one sign"):
        sign_change(lambda x: 1.0, 0.0, 1.0)
    with pytest.raises(ArithmeticError, match="no value"):
        sign_change(lambda x: math.nan if abs(x) < 0.5 else x, -1.0, 1.0)
