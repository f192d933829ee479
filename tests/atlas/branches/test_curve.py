"""Curves of singular orbits in two parameters, on maps where they and their special points are known by formulas."""

from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.atlas.branches import curve
from gelcone.atlas.branches.branch import Ending, EventKind
from gelcone.atlas.branches.curve import Window, follow_curve
from gelcone.atlas.branches.event import DOUBLE, FOLD, Singular
from gelcone.errors import InputError
from tests.atlas.branches import maps
from tests.recorded import record


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


def test_a_curve_ends_before_values_that_make_no_actuator():
    """Those of p above 0.5, within the rectangle."""

    def possible(x, p, q):
        if np.real(p) > 0.5:
            raise InputError("p: cannot be")
        return maps.cusp(x, p, q)

    s = np.sqrt(1.0 / 3.0)
    found = curve_of(possible, EventKind.FOLD, FOLD, s + 0.02, (-2.0 * s**3 + 0.05, 1.0), [-1.0, -0.5], [1.0, 2.0])
    assert sorted(found.ended) == sorted((Ending.LIMIT, Ending.IMPOSSIBLE))
    assert max(point.values[0] for point in found.points) == pytest.approx(0.5, abs=1e-5)


def test_there_is_no_curve_where_nothing_is_singular():
    assert curve_of(maps.sphere, EventKind.FOLD, FOLD, 0.0, (0.0, 0.0), [-3.0, -2.0], [3.0, 2.0]) is None


def test_a_curve_leaves_the_rectangle_at_the_first_border_that_its_step_passes(monkeypatch):
    """A step over a corner passes the border of the first parameter at a quarter of its way and that of the second at a
    half."""
    window = Window(np.array([0.0, 0.0]), np.array([1.0, 10.0]), 50)

    def singular(first, second):
        return Singular(
            np.full((2, 2), first),
            np.array([first, second]),
            np.zeros(2),
            np.ones((2, 2)),
            np.ones((2, 2)),
            np.ones(2),
            FOLD,
        )

    asked = record(monkeypatch, curve, locate="found")
    here, beyond = singular(0.5, 6.0), singular(2.5, 14.0)
    assert curve._at_border("shooting", here, beyond, window) == "found"
    (call,) = asked["locate"]
    np.testing.assert_allclose(call["values"], [1.0, 8.0])
    np.testing.assert_allclose(call["nodes"], 1.0)
    np.testing.assert_allclose(call["plane"][1], [1.0, 0.0])
    assert (call["at"], call["near"] is here) == (FOLD, True)
    back = curve._at_border("shooting", here, singular(0.4, -2.0), window)
    assert back == "found"
    np.testing.assert_allclose(asked["locate"][1]["values"], [0.5 - 0.1 * 0.75, 0.0])
    assert curve._at_border("shooting", here, singular(0.6, 7.0), window) is None


def test_a_point_of_codimension_two_is_known_as_far_as_another_distance_moves_it(monkeypatch):
    """And by rounding; where the other one finds none, to the points on both sides."""
    window = Window(np.array([0.0, 0.0]), np.array([1.0, 10.0]), 50)
    found = SimpleNamespace(values=np.array([0.5, 5.0]), errors=np.array([0.01, 0.02]))
    other = SimpleNamespace(values=np.array([0.45, 5.5]))
    monkeypatch.setattr(curve, "_zero", lambda own, k, window, over: other if over == curve.OTHER_SIDE else found)
    points = [SimpleNamespace(values=np.array([0.1 * k, 3.0 * k])) for k in range(4)]
    own = SimpleNamespace(points=points)
    np.testing.assert_allclose(curve._errors(own, 1, window, found), [0.06, 0.52])
    monkeypatch.setattr(curve, "_zero", lambda own, k, window, over: None)
    np.testing.assert_allclose(curve._errors(own, 1, window, found), [0.1, 3.0])


@pytest.mark.parametrize(
    ("coefficient", "place"),
    [(lambda x: x - 0.3, 0.3), (lambda x: np.sign(x - 0.3), None), (lambda x: 1.0 / (x - 0.3), None)],
    ids=["zero", "jump", "pole"],
)
def test_a_coefficient_that_changes_its_sign_without_getting_small_has_no_zero(monkeypatch, coefficient, place):
    def singular(x):
        return SimpleNamespace(nodes=np.array([[1.0 + x]]), values=np.array([x, 2.0 * x]), at=DOUBLE)

    monkeypatch.setattr(curve, "_coefficient", lambda shooting, point, over: float(coefficient(point.values[0])))
    monkeypatch.setattr(curve, "_turned", lambda one, other: 1.0)
    monkeypatch.setattr(curve, "locate", lambda shooting, nodes, values, *rest: singular(values[0]))
    points = [singular(0.0), singular(1.0)]
    own = SimpleNamespace(shooting=None, points=points, tests=[float(coefficient(x)) for x in (0.0, 1.0)])
    found = curve._zero(own, 0, Window(np.zeros(2), np.ones(2), 50), 5e-4)
    assert (found is None) == (place is None)
    if found is not None:
        np.testing.assert_allclose(found.values, [place, 2.0 * place], rtol=1e-12)


def test_each_way_of_a_curve_has_its_own_end():
    """One that starts next to the upper border of the second parameter, with few points allowed."""
    s = np.sqrt(1.99 / 3.0)
    own = curve_of(maps.cusp, EventKind.FOLD, FOLD, s, (-2.0 * s**3, 1.99), [-2.0, -0.5], [2.0, 2.0], most=5)
    assert set(own.ended) == {Ending.LIMIT, Ending.POINTS}
    values = np.array([point.values[1] for point in own.points])
    last = {Ending.LIMIT: 2.0}
    for end, at in zip(own.ended, (0, -1), strict=True):
        assert (values[at] == pytest.approx(last[end], abs=1e-9)) if end in last else values[at] < 1.9999


def test_the_sign_of_a_coefficient_is_that_of_the_direction_which_the_curve_keeps(monkeypatch):
    """Of a fold the left vector decides, of what is born both; sizes are shares of the left vector's."""

    def singular(at, left, null, quadratic=6.0):
        return Singular(np.zeros((1, 2)), np.zeros(2), np.zeros(2), null * np.array([[1.0, 0.0]]),
                        left * np.array([[3.0, 4.0]]), np.ones(2), at, None, quadratic)  # fmt: skip

    for at, turns in ((FOLD, [1.0, -1.0, 1.0, -1.0]), (DOUBLE, [1.0, -1.0, -1.0, 1.0])):
        others = [singular(at, *way) for way in ((1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0))]
        assert [curve._turned(singular(at, 1.0, 1.0), other) for other in others] == turns
    asked = record(monkeypatch, curve, born=SimpleNamespace(coefficient=20.0))
    assert curve._coefficient("shooting", singular(FOLD, 1.0, 1.0)) == pytest.approx(6.0 / 5.0)
    assert curve._coefficient("shooting", singular(DOUBLE, 2.0, 1.0)) == pytest.approx(20.0 / 10.0)
    assert curve._coefficient("shooting", singular(DOUBLE, 2.0, 1.0), 0.125) == pytest.approx(2.0)
    assert [list(call.values())[-1] for call in asked["born"]] == [curve.FAR_SIDE, 0.125]
    points = [singular(FOLD, 1.0, 1.0), singular(FOLD, -1.0, 1.0, 7.0), singular(FOLD, -1.0, -1.0, 8.0)]
    np.testing.assert_allclose(curve._tests("shooting", points), [1.2, -1.4, -1.6])
