"""Roots without a formula, and their derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from gelcone.physics.differentiate import derivative
from gelcone.physics.implicit import root
from gelcone.physics.trace import Graph


def residual(y, a, xp):
    return y + y * y * y + xp.exp(y) - 1.0 - a


def zero(a, xp):
    return 0.0


def test_the_root_is_found_for_each_number_of_an_array():
    wanted = np.linspace(-2.0, 2.0, 41)
    found = root(np, "y", residual, [residual(wanted, 0.0, np)], zero)
    np.testing.assert_allclose(found, wanted, rtol=1e-15, atol=1e-15)


def test_its_derivative_is_that_of_the_implicit_function():
    a = np.array([0.5, 3.0])
    y = root(np, "y", residual, [a], zero)
    slope = derivative(lambda at, xp: root(xp, "y", residual, [at], zero), a)
    np.testing.assert_allclose(slope, 1.0 / (1.0 + 3.0 * y * y + np.exp(y)), rtol=1e-14)
    assert derivative(lambda at, xp: root(xp, "y", residual, [at], zero), 3.0) == pytest.approx(slope[1], rel=1e-14)


def test_a_program_takes_the_longest_step_of_a_search():
    graph = Graph()
    found = [root(graph, name, residual, [graph.state(0)], zero, *more) for name, more in (("y", ()), ("z", (0.25,)))]
    assert [graph.longest[node.index] for node in found] == [np.inf, 0.25]


def test_a_root_has_the_shape_of_all_that_was_given():
    """Also of what its residual leaves out."""
    rows = np.zeros((3, 1))
    found = root(np, "y", lambda y, a, b, xp: residual(y, a, xp), [np.array([0.5, 3.0]), rows], lambda a, b, xp: 0.0)
    assert found.shape == (3, 2)
    np.testing.assert_array_equal(found, np.broadcast_to(root(np, "y", residual, [np.array([0.5, 3.0])], zero), (3, 2)))


def test_a_slope_that_is_given_takes_the_place_of_the_traced_one():
    wanted = np.linspace(-2.0, 2.0, 41)

    def of_arrays(y, a, xp):
        assert xp is np
        return residual(y, a, xp)

    found = root(
        np, "y", of_arrays, [residual(wanted, 0.0, np)], zero, slope=lambda y, a: 1.0 + 3.0 * y * y + np.exp(y)
    )
    np.testing.assert_allclose(found, wanted, rtol=1e-15, atol=1e-15)
