"""Roots between two ends: of arrays, and of one number."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from gelcone.bracket import crossing, halved, rise, sign_change, sign_changes


@settings(deadline=None)
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


def test_a_pole_is_no_root() -> None:
    poles = np.array([0.3, 1.0 / 3.0, 1e-6])
    assert np.isnan(sign_changes(lambda x: 1.0 / (x - poles), np.full(3, -1.0), np.full(3, 1.5))).all()
    found = sign_changes(lambda x: np.tan(x - poles), np.full(3, -1.0), np.full(3, 1.0))
    np.testing.assert_allclose(found, poles, rtol=1e-15)
    with pytest.raises(ArithmeticError, match="pole"):
        sign_change(lambda x: 1.0 / (x - 1.0 / 3.0) ** 3, -1.0, 2.0)


def test_each_root_is_the_nearest_double_or_one_beside_it() -> None:
    wanted = np.random.default_rng(1).uniform(0.01, 3.0, 500)
    for power in (1.0, 3.0, 9.0):
        found = rise(lambda x, p=power: x**p - wanted**p, np.zeros(500), np.full(500, 4.0))
        assert np.abs(found / wanted - 1.0).max() < 1e-15


def test_a_function_may_be_infinite_or_flat_inside_the_bracket() -> None:
    wanted = np.array([0.25, 0.999, 0.5])

    def wall(x):
        return np.where(x >= 1.0, np.inf, x / (1.0 - x)) - wanted / (1.0 - wanted)

    assert rise(wall, np.zeros(3), np.full(3, 2.0)) == pytest.approx(wanted, rel=1e-14)
    steps = rise(lambda x: np.where(x < wanted, -1.0, 1.0), np.zeros(3), np.ones(3))
    assert steps == pytest.approx(wanted, rel=1e-14)


def test_without_a_root_it_is_the_end_nearest_to_one() -> None:
    """Above zero throughout, below, and with a root at either end, also from the right to the left."""
    low, high = np.zeros(4), np.ones(4)
    assert rise(lambda x: x + np.array([1.0, -3.0, 0.0, -1.0]), low, high).tolist() == [0.0, 1.0, 0.0, 1.0]
    assert rise(lambda x: np.array([1.0, -3.0, 0.0, 2.0]) - x, high, low).tolist() == [1.0, 0.0, 0.0, 1.0]


def test_company_changes_no_bit() -> None:
    wanted = np.linspace(0.1, 2.9, 40)
    together = rise(lambda x: x * x * x - wanted * wanted * wanted, np.zeros(40), np.full(40, 3.0))
    alone = [rise(lambda x, w=w: x * x * x - w * w * w, np.zeros(1), np.full(1, 3.0))[0] for w in wanted]
    assert (together == alone).all()


def test_a_level_is_reached_where_it_is_equal():
    times = np.array([0.0, 1.0, 2.0, 3.0])
    assert crossing(times, np.array([-4.0, -3.0, 1.0, 2.0]), 0.0) == 1.75
    assert crossing(times, np.array([-4.0, 0.5, 0.0, 2.0]), 0.5) == 1.0
    assert crossing(times, np.array([1.0, -1.0, 1.0, 1.0]), 0.5) == 0.0
    assert np.isnan(crossing(times, np.array([np.nan, 1.0, 2.0, 3.0]), 4.0))


def test_what_lies_beyond_the_ends_of_one_element_does_not_concern_the_others() -> None:
    """The first has no sign change, and no value inside; the second has both."""
    wanted = np.array([np.nan, 0.3])

    def function(x):
        return np.where(np.isnan(wanted), np.where((x > 0.0) & (x < 1.0), np.nan, 1.0), x - wanted)

    np.testing.assert_allclose(rise(function, np.zeros(2), np.ones(2)), [0.0, 0.3], rtol=1e-15)


def test_halving_ends_around_where_a_condition_ends_of_each_element():
    low, high = halved(lambda x: x * x < np.array([2.0, 9.0]), np.zeros(2), np.array([2.0, 4.0]), 50)
    assert (low <= [2.0**0.5, 3.0]).all()
    assert (high >= [2.0**0.5, 3.0]).all()
    np.testing.assert_allclose(high - low, np.array([2.0, 4.0]) / 2.0**50, rtol=0.5)
