"""Points of branches: measures of differences, tests of multipliers, cubics between points."""

import numpy as np
import pytest

from gelcone.atlas.branches.point import (
    SMALLEST,
    Direction,
    Metric,
    Point,
    along,
    at_value,
    between,
    cubic_weights,
    shares_at,
)
from gelcone.atlas.branches.varied import vary
from gelcone.physics.model import ConeModel
from tests.atlas.branches import maps

RNG = np.random.default_rng(3)


def some(value=None):
    return Direction(RNG.normal(size=(4, 2)), RNG.normal() if value is None else value)


def test_differences_are_measured_by_the_largest_states_and_the_scale_of_the_value():
    nodes = np.array([[2.0, 0.0], [-4.0, 1e-9], [1.0, 0.0]])
    metric = Metric.of(nodes, 0.5)
    step = Direction(np.array([[0.4, 0.0], [0.0, 2e-3], [0.8, 0.0]]), 0.1)
    expected = (0.1**2 + 0.2**2) / 3.0 + (2e-3 / SMALLEST) ** 2 / 3.0 + (0.1 / 0.5) ** 2
    assert metric.length(step) ** 2 == pytest.approx(expected, rel=1e-12)
    assert metric.length(metric.unit(step)) == pytest.approx(1.0, rel=1e-14)
    a, b = Direction(RNG.normal(size=(3, 2)), 0.3), Direction(RNG.normal(size=(3, 2)), -0.7)
    row, corner = metric.row(a)
    assert metric.inner(a, b) == pytest.approx(float(np.vdot(row[0], b.nodes)) + float(corner[0, 0]) * b.value)
    assert metric.inner(a, b) == pytest.approx(metric.inner(b, a))
    assert (-a).value == -0.3
    np.testing.assert_array_equal((-a).nodes, -a.nodes)


@pytest.mark.parametrize(
    ("multipliers", "fold", "double", "stable"),
    [
        ((0.5, 0.2), (0.5 / 1.5) * (0.8 / 1.2), (1.5 / 1.5) * (1.2 / 1.2), True),
        ((1.5, 0.2), (-0.5 / 2.5) * (0.8 / 1.2), 1.0, False),
        ((-2.0, 0.2), (3.0 / 3.0) * (0.8 / 1.2), (-1.0 / 3.0) * 1.0, False),
        (
            (0.6 + 0.6j, 0.6 - 0.6j),
            (0.16 + 0.36) / (1.0 + 0.72**0.5) ** 2,
            (2.56 + 0.36) / (1.0 + 0.72**0.5) ** 2,
            True,
        ),
    ],
)
def test_tests_pass_zero_where_a_multiplier_passes_the_unit_circle(multipliers, fold, double, stable):
    point = Point(np.zeros((1, 2)), 0.0, np.array(multipliers, complex), some())
    assert point.tests == {1.0: pytest.approx(fold), -1.0: pytest.approx(double)}
    assert point.stable is stable


def test_a_cubic_has_both_points_and_their_tangents_and_is_a_line_through_points_on_one():
    a, b = (Point(RNG.normal(size=(4, 2)), value, np.ones(2, complex), some(1.0)) for value in (0.2, 0.5))
    for share, point in ((0.0, a), (1.0, b)):
        found = between(a, b, share, 0.7)
        np.testing.assert_allclose(found.nodes, point.nodes, atol=1e-12)
        assert found.value == pytest.approx(point.value)
        near = between(a, b, share + (1e-6 if share == 0.0 else -1e-6), 0.7)
        slope = (near.value - point.value) / (1e-6 if share == 0.0 else -1e-6)
        way = (near.nodes - point.nodes) / (1e-6 if share == 0.0 else -1e-6)
        np.testing.assert_allclose(way / slope, point.tangent.nodes / point.tangent.value, rtol=1e-3, atol=1e-4)
    s = np.linspace(0.0, 1.0, 5)
    np.testing.assert_allclose(cubic_weights(s)[:2].sum(axis=0), 1.0)
    p = lambda t: 0.3 + 0.4 * t + 0.3 * t**2 + 0.9 * t**3  # noqa: E731
    slope = lambda t: 0.4 + 0.6 * t + 2.7 * t**2  # noqa: E731
    np.testing.assert_allclose(np.array([p(0.0), p(1.0), slope(0.0), slope(1.0)]) @ cubic_weights(s), p(s), atol=1e-13)


def test_a_branch_passes_a_value_where_it_does():
    """Values 0.3 + 0.5 t + 0.1 t^2 in the length t of the branch."""

    def at(t):
        tangent = Direction(np.array([[1.0, 0.0]]), 0.5 + 0.2 * t)
        return Point(np.array([[1.0 + t, 0.5]]), 0.3 + 0.5 * t + 0.1 * t * t, np.ones(2, complex), tangent)

    for share in (0.0, 0.3, 0.8, 1.0):
        np.testing.assert_allclose(shares_at(at(0.0), at(1.0), at(share).value, 1.0), [share], atol=0.03)
    assert shares_at(at(0.0), at(1.0), 0.95, 1.0) == []
    assert along(at(0.0), Direction(np.array([[2.0, 1.0]]), -0.5), 0.1).value == pytest.approx(0.25)


def test_an_orbit_at_a_value_is_one_with_a_tangent_that_goes_up():
    model = ConeModel(damping_ratio=0.1, voltage=0.4, voltage_bias=0.3, rest_height=0.3, drive_frequency=0.8)
    shooting = vary(model, {"voltage": (0.3, 0.5)}, (0.3, 0.0)).shooting(1e-12)
    guess = np.tile([0.25, 0.0], (shooting.count, 1))
    low, middle, high = (at_value(shooting, guess, value, Metric.of(guess, 1.0)).point for value in (0.399, 0.4, 0.401))
    ends = shooting.run(middle.nodes, (0.4,)).ends
    np.testing.assert_allclose(ends, np.roll(middle.nodes, -1, axis=0), atol=1e-9)
    assert middle.tangent.value > 0.0
    slope = (high.nodes - low.nodes) / 0.002
    np.testing.assert_allclose(middle.tangent.nodes / middle.tangent.value, slope, rtol=1e-3, atol=1e-5)


@pytest.mark.parametrize("value", [0.31, 0.447, 0.6, 0.77, 0.89])
def test_the_cubic_has_the_value_at_the_share_where_it_passes_it(value):
    """Also twice, where the branch turns between two points."""
    rising = [
        Point(
            np.array([[t, 0.2]]),
            0.3 + 0.5 * t + 0.1 * t * t,
            np.ones(2, complex),
            Direction(np.array([[1.0, 0.0]]), 0.5 + 0.2 * t),
        )
        for t in (0.0, 1.0)
    ]
    (share,) = shares_at(*rising, value, 0.8)
    assert between(*rising, share, 0.8).value == pytest.approx(value, abs=2e-4)
    turning = [
        Point(np.array([[t, 0.2]]), 0.3, np.ones(2, complex), Direction(np.array([[1.0, 0.0]]), slope))
        for t, slope in ((0.0, 2.0), (1.0, -2.0))
    ]
    top = between(*turning, 0.5, 0.8).value
    passed = shares_at(*turning, 0.3 + (value - 0.3) * (top - 0.3), 0.8)
    assert [between(*turning, share, 0.8).value for share in passed] == pytest.approx(
        [0.3 + (value - 0.3) * (top - 0.3)] * 2, abs=1e-3 * (top - 0.3)
    )
    assert passed[0] == pytest.approx(1.0 - passed[1], abs=1e-12)
    assert 0.0 < passed[0] < 0.5


def test_a_correction_reports_how_far_its_guess_was_off_and_refuses_one_that_is_too_far():
    model = ConeModel(damping_ratio=0.1, voltage=0.4, voltage_bias=0.3, rest_height=0.3, drive_frequency=0.8)
    shooting = vary(model, {"voltage": (0.3, 0.5)}, (0.3, 0.0)).shooting(1e-12)
    start = np.tile([0.25, 0.0], (shooting.count, 1))
    orbit = at_value(shooting, start, 0.4, Metric.of(start, 1.0)).point.nodes
    metric = Metric.of(orbit, 1.0)
    for off in (1e-2, 1e-4):
        guess = orbit + off * np.array([1.0, -0.5])
        found = at_value(shooting, guess, 0.4, metric)
        assert not found.left
        np.testing.assert_allclose(found.point.nodes, orbit, atol=1e-9)
        assert found.step == pytest.approx(metric.length(Direction(guess - orbit, 0.0)), rel=0.1)
    assert at_value(shooting, orbit, 0.4, metric).step < 1e-6


@pytest.mark.parametrize("reach", [1.1, 0.9])
def test_an_orbit_between_whose_nodes_the_film_has_no_state_is_none(reach):
    """Though the guess for it lies within."""
    world = maps.Maps(maps.s_curve, reach=maps.AWAY + reach)
    guess = maps.nodes_of(maps.AWAY + 0.89)
    found = at_value(world, guess, maps.value_of(0.9 + 1e-3), Metric.of(guess, 1.0))
    assert (found.point is None) == found.left == (reach < 1.0)
