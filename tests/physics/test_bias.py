"""Biases: the spring's closed forms against the contract's numerical defaults, and a cubic bias by hand."""

import numpy as np
import pytest

from gelcone.physics.bias import BIASES, Bias, LinearSpring
from tests.toys import CubicBias

SPRING = LinearSpring()
X = np.array([-2.0, -0.3, 0.1, 0.7, 3.0])
NUMBERS = [{"spring_stiffness": kappa, "rest_height": x0} for kappa in (0.0, 1.7) for x0 in (0.0, 0.4, -0.2)]
every_spring = pytest.mark.parametrize("n", NUMBERS, ids=[f"{n}" for n in NUMBERS])


@every_spring
def test_the_springs_force_is_the_slope_of_its_energy(n):
    h = 1e-30
    force, slope = SPRING.force(X, [], n)
    np.testing.assert_allclose(force, np.imag(SPRING.energy(X + 1j * h, n)) / h, rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(np.broadcast_to(slope, X.shape), np.imag(SPRING.force(X + 1j * h, [], n)[0]) / h)


@every_spring
def test_the_springs_closed_forms_are_the_defaults_of_the_contract(n):
    own, rest = SPRING.energy(X, n), SPRING.energy(0.0, n)
    np.testing.assert_allclose(own - rest, Bias.energy(SPRING, X, n), rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(SPRING.turning(X, n), Bias.turning(SPRING, X, n), rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(SPRING.secant(X, n), Bias.secant(SPRING, X, n), rtol=1e-12, atol=1e-14)
    assert SPRING.stiffness_scale(n) == Bias.stiffness_scale(SPRING, n)


@every_spring
def test_at_the_flat_film_the_secant_is_its_limit(n):
    push = n["spring_stiffness"] * n["rest_height"]
    for bias in (SPRING.secant, lambda x, n: Bias.secant(SPRING, x, n)):
        found = bias(0.0, n)
        assert found == (n["spring_stiffness"] if push == 0.0 else -np.copysign(np.inf, push))


@every_spring
def test_at_its_free_height_a_bias_does_not_pull(n):
    assert SPRING.force(SPRING.free_height(n), [], n)[0] == 0.0
    assert SPRING.energy(n["rest_height"], n) == 0.0


def test_the_spring_pulls_the_disc_down_where_it_is_above_its_free_height():
    n = {"spring_stiffness": 2.0, "rest_height": 0.5}
    assert SPRING.force(0.75, [], n) == (0.5, 2.0)
    assert SPRING.energy(0.75, n) == 0.0625
    assert SPRING.turning(3.0, n) == 1.0
    assert SPRING.secant(2.0, n) == 1.5


def test_one_member_at_rest_height_zero_among_others_has_its_own_secant():
    n = {"spring_stiffness": np.array([1.0, 1.0]), "rest_height": np.array([0.0, 0.5])}
    np.testing.assert_array_equal(SPRING.secant(np.array([2.0, 2.0]), n), [1.0, 0.75])


def test_a_cubic_bias_by_hand():
    """F = k1 x + k3 x^3 from its force alone: E = k1 x^2/2 + k3 x^4/4, x F' - F = 2 k3 x^3, F/x = k1 + k3 x^2."""
    bias, n = CubicBias(), {"bias_stiffness": -0.8, "bias_cubic": 0.5}
    np.testing.assert_allclose(bias.energy(X, n), -0.4 * X**2 + 0.125 * X**4, rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(bias.turning(X, n), X**3, rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(bias.secant(X, n), -0.8 + 0.5 * X**2, rtol=1e-13)
    assert bias.secant(0.0, n) == -0.8
    assert bias.free_height(n) == 0.0
    assert bias.stiffness_scale(n) == 0.8
    assert bias.rates(0.1, 0.2, [], n) == []
    assert bias.states == ()


def test_the_table_of_biases():
    assert all(bias.name == name for name, bias in BIASES.items())
    assert isinstance(BIASES["spring"], LinearSpring)
