"""Events and the branches that are born at them: on which side, of which map, with which multipliers."""

import numpy as np
import pytest

from gelcone.atlas.branches.branch import Event, EventKind, Walk, born_map, multipliers_of_period
from gelcone.atlas.branches.event import DOUBLE, FOLD, Born, Singular
from gelcone.motion.orbit import Kind

ONCE = Kind(1)


def event(kind, at, curvature=1.0, unstable=1.0, of=ONCE):
    nodes = np.zeros((1, 2))
    orbit = Singular(nodes, np.array([0.7, 0.1]), np.zeros(2), nodes, nodes, np.ones(2, complex), at)
    born = None if curvature is None else Born(curvature, nodes)
    return Event(kind, orbit, born, unstable, 3, of)


@pytest.mark.parametrize(
    ("curvature", "unstable", "supercritical"),
    [(2.0, 1.0, True), (-2.0, 1.0, False), (2.0, -1.0, False), (-2.0, -1.0, True), (None, 1.0, None), (2.0, 0.0, None)],
)
def test_a_birth_is_supercritical_where_the_born_branch_lies_on_the_unstable_side(curvature, unstable, supercritical):
    one = event(EventKind.PERIOD_DOUBLING, DOUBLE, curvature, unstable)
    assert one.supercritical is supercritical
    assert one.value == 0.7


def test_what_is_born_has_twice_the_period_or_the_mirror_image():
    assert born_map(event(EventKind.LOSS_OF_REST, DOUBLE)) == Kind(1, True)
    assert born_map(event(EventKind.LOSS_OF_REST, FOLD)) == Kind(1, False)
    assert born_map(event(EventKind.PERIOD_DOUBLING, DOUBLE, of=Kind(2))) == Kind(4)
    assert born_map(event(EventKind.SYMMETRY_BREAKING, DOUBLE, of=Kind(1, True))) == Kind(2)


def test_multipliers_of_a_symmetric_orbit_are_squared_over_its_period():
    half = np.array([0.5 + 0.5j, -0.8])
    np.testing.assert_allclose(multipliers_of_period(Kind(1, True), half), half**2)
    np.testing.assert_array_equal(multipliers_of_period(Kind(2), half), half)
    assert Walk(0.3, 0.8).scale == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        (EventKind.FOLD, "fold"), (EventKind.LOSS_OF_REST, "loss of rest"),
        (EventKind.DEGENERATE_SYMMETRY_BREAKING, "degenerate symmetry breaking"),
    ],
)  # fmt: skip
def test_events_are_named_in_words(kind, words):
    assert kind.words == words
