"""Curves of singular orbits in two parameters, on maps where they and their special points are known by formulas."""

import numpy as np
import pytest

from gelcone.atlas.branches.branch import Ending, EventKind
from gelcone.atlas.branches.curve import Window, follow_curve
from gelcone.atlas.branches.event import DOUBLE, FOLD
from tests.atlas.branches import maps


def curve_of(rule, kind, at, s, values, low, high, most=500):
    window = Window(np.array(low), np.array(high), most)
    return follow_curve(maps.Maps(rule), kind, maps.nodes_of(maps.AWAY + s), np.array(values), at, window)


@pytest.fixture(scope="module")
def folds():
    s = np.sqrt(1.0 / 3.0)
    values = -2.0 * s**3 + 0.05, 1.0
    return curve_of(maps.cusp, EventKind.FOLD, FOLD, s + 0.02, values, [-1.0, -0.5], [1.0, 2.0])


def test_a_curve_of_folds_passes_its_cusp_and_ends_at_the_rectangle(folds):
    """3 s^2 = q, p = -2 s^3: from p = -1 to p = 1, through the cusp at p = q = 0, where its coefficient passes 0."""
    s = np.array([point.nodes[0, 0] for point in folds.points]) - maps.AWAY
    values = np.array([point.values for point in folds.points])
    assert (np.diff(s) < 0.0).all() or (np.diff(s) > 0.0).all()
    np.testing.assert_allclose(values, np.stack([-2.0 * s**3, 3.0 * s * s], axis=1), atol=1e-10)
    assert sorted(values[[0, -1], 0]) == pytest.approx([-1.0, 1.0], abs=1e-12)
    assert folds.ended == (Ending.LIMIT, Ending.LIMIT)
    tests = np.array(folds.tests) / s
    np.testing.assert_allclose(tests, tests[0], rtol=0.3)  # 3 s times what normalises the left vector
    ((cusp, after),) = folds.special
    assert (np.abs(cusp.values) <= 3.0 * cusp.errors + 1e-14).all()
    assert (cusp.errors < 1e-9).all()
    assert s[after] * s[after + 1] < 0.0


def test_a_curve_of_doublings_turns_subcritical_where_its_coefficient_passes_zero():
    """Along p = 0 at q = 0, whatever the first point; the second parameter of the first point is the given one."""
    found = curve_of(maps.doubling_line, EventKind.PERIOD_DOUBLING, DOUBLE, 0.01, (0.02, 0.6), [-1.0, -1.0], [1.0, 2.0])
    values = np.array([point.values for point in found.points])
    np.testing.assert_allclose(values[:, 0], 0.0, atol=1e-12)
    assert sorted(values[[0, -1], 1]) == pytest.approx([-1.0, 2.0], abs=1e-12)
    assert np.abs(values[:, 1] - 0.6).min() < 1e-12
    assert np.abs(np.diff(values[:, 1])).max() < 3.0 * 0.041
    ((point, after),) = found.special
    assert (np.abs(point.values) <= 3.0 * point.errors + 1e-14).all()
    assert values[after, 1] * values[after + 1, 1] < 0.0
    signs = np.sign(np.array(found.tests) * values[:, 1])
    assert len(set(signs)) == 1


def test_a_closed_curve_ends_where_it_began():
    found = curve_of(maps.sphere, EventKind.FOLD, FOLD, 0.02, (0.97, 0.1), [-3.0, -2.0], [3.0, 2.0])
    values = np.array([point.values for point in found.points])
    assert found.ended == (Ending.CLOSED, Ending.CLOSED)
    np.testing.assert_allclose(np.hypot(*values.T), 1.0, atol=1e-10)
    assert abs(np.ptp(np.unwrap(np.arctan2(*values.T)))) == pytest.approx(2.0 * np.pi)
    assert values[0, 1] == values[-1, 1] == pytest.approx(0.1, abs=1e-12)
    assert found.special == []


def test_a_curve_has_at_most_so_many_points_each_way():
    found = curve_of(maps.sphere, EventKind.FOLD, FOLD, 0.02, (0.97, 0.1), [-3.0, -2.0], [3.0, 2.0], most=6)
    assert found.ended == (Ending.POINTS, Ending.POINTS)
    assert len(found.points) == 11


def test_there_is_no_curve_where_nothing_is_singular():
    assert curve_of(maps.sphere, EventKind.FOLD, FOLD, 0.0, (0.0, 0.0), [-3.0, -2.0], [3.0, 2.0]) is None
