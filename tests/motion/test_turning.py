"""Turning points between samples: exact on polynomials, and on the flow where the velocity vanishes."""

import numpy as np
import pytest

from gelcone import ConeModel
from gelcone.motion.flow import integrate
from gelcone.motion.turning import acceleration_at, quintic, turning_points, turning_share


def test_the_quintic_meets_both_ends_with_slope_and_second_derivative():
    third, fourth, fifth = quintic(np.array([2.0]), np.array([3.0]), np.array([5.0]))
    at_end = third + fourth + fifth, 3 * third + 4 * fourth + 5 * fifth, 6 * third + 12 * fourth + 20 * fifth
    np.testing.assert_allclose(np.ravel(at_end), [2.0, 3.0, 5.0], rtol=1e-14)


@pytest.mark.parametrize("turn", [0.25, 0.6])
def test_the_share_at_which_a_quintic_turns_is_exact(turn):
    """x' = (t - turn)(t^3 + t^2 + 3), on intervals of any length; a rest at its begin is left with the acceleration."""
    velocity = np.polynomial.Polynomial([-turn, 1.0]) * np.polynomial.Polynomial([3.0, 0.0, 1.0, 1.0])
    place, acceleration, ends = velocity.integ(), velocity.deriv(), np.array([[0.0, 1.0], [0.0, 1.5]])
    found = turning_share(ends[:, 1] - ends[:, 0], place(ends), velocity(ends), acceleration(ends))
    np.testing.assert_allclose(found * ends[:, 1], turn, rtol=1e-11)
    still = velocity * np.polynomial.Polynomial([0.0, 1.0])
    at = np.array([[0.0, 1.0]])
    again = turning_share(np.ones(1), still.integ()(at), still(at), still.deriv()(at))
    assert again[0] == pytest.approx(turn, abs=0.05)  # of a velocity of fifth degree, not at its begin


def test_a_motion_is_followed_to_where_its_velocity_vanishes():
    """Of an undamped linear disc x = cos t without a film's stiffness: at pi, to the rounding of the time."""
    model = ConeModel(
        damping_ratio=0.02, spring_stiffness=0.4, voltage=[0.3, 2.4], drive_frequency=0.9, stretch_limit=[50.0, 8.0]
    )
    members = model.members()
    times = np.tile(np.linspace(0.0, 20.0, 201), (2, 1))
    run = integrate(members, np.tile([1.0, 0.0], (2, 1)), times)
    rows, first = np.nonzero(run.states[:, :-1, 1] * run.states[:, 1:, 1] < 0.0)
    both, kind = (rows[:, None], first[:, None] + np.arange(2)), np.sign(run.states[rows, first, 1])
    begin, end = times[both].T
    pulls = acceleration_at(members.take(rows), times[both], run.states[both])
    sides = times[both], *np.moveaxis(run.states[both], -1, 0), pulls
    at, states = turning_points(members.take(rows), run.states[rows, first], sides, kind, tolerance=1e-14)
    assert ((begin <= at) & (at <= end)).all()
    assert np.abs(states[:, 1]).max() < 1e-10
    again = integrate(members.take(rows), run.states[rows, first], at[:, None], start=begin).states[:, 0]
    np.testing.assert_allclose(states[:, 0], again[:, 0], atol=1e-12)
    a = acceleration_at(members.take(rows), at[:, None], again[:, None])[:, 0]
    assert (np.sign(a) == -kind).all()
    assert set(kind) == {-1.0, 1.0}
