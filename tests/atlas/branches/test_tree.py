"""When two orbits are one: up to shifts by repeats and mirror images, as a share of their size."""

from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.atlas.branches.point import Direction, Point
from gelcone.atlas.branches.tree import _passing, distance, kind_of, whole_period
from gelcone.motion.orbit import Kind

NODES = np.random.default_rng(2).normal(size=(8, 2))
MIRROR = np.array([-1.0, -1.0])


def shooting(kind, symmetric=True):
    system = SimpleNamespace(mirror=MIRROR)
    signs = MIRROR if kind.reflected else np.ones(2)
    return SimpleNamespace(kind=kind, symmetric=symmetric, size=2, system=system, segments=4, signs=signs)


def test_orbits_are_one_up_to_shifts_by_repeats():
    own = shooting(Kind(2), symmetric=False)
    assert distance(own, NODES, np.roll(NODES, 4, axis=0)) == 0.0
    assert distance(own, NODES, np.roll(NODES, 2, axis=0)) > 0.1
    assert distance(own, NODES, -NODES) > 0.1
    assert distance(own, NODES, NODES[:4]) == np.inf


def test_orbits_are_one_up_to_mirror_images_where_the_system_has_one():
    own = shooting(Kind(2))
    assert distance(own, NODES, -np.roll(NODES, 4, axis=0)) == 0.0
    assert distance(own, NODES, np.array([1.0, -1.0]) * NODES) > 0.1


def test_distances_are_shares_of_the_largest_of_each_state():
    other = NODES.copy()
    other[3, 1] += 0.01
    assert distance(shooting(Kind(2)), NODES, other) == pytest.approx(0.01 / np.abs(NODES[:, 1]).max())


def test_a_symmetric_orbit_is_followed_by_its_mirror_image():
    half = NODES[:4]
    np.testing.assert_array_equal(whole_period(shooting(Kind(1, True)), half), np.concatenate([half, -half]))
    assert whole_period(shooting(Kind(1)), half) is half
    assert distance(shooting(Kind(1, True)), half, -half) == 0.0


@pytest.mark.parametrize(
    ("period", "symmetric", "kind"),
    [(1, False, Kind(1)), (2, True, Kind(1, True)), (2, False, Kind(2)), (3, True, Kind(3)), (6, True, Kind(3, True))],
)
def test_the_map_of_an_orbit_takes_its_mirror_image_where_it_can(period, symmetric, kind):
    assert kind_of(period, symmetric) == kind


def test_a_branch_passes_a_value_between_its_points_on_either_side_of_it():
    tangent = Direction(np.zeros((1, 2)), 1.0)
    points = [Point(np.array([[v, 0.0]]), v, np.ones(2, complex), tangent) for v in (0.1, 0.2, 0.4)]
    branch = SimpleNamespace(points=points, values=np.array([0.1, 0.2, 0.4]))
    ((before, share),) = _passing(branch, 0.3)
    assert before == 1
    assert share == pytest.approx(0.5, abs=0.02)
    assert _passing(branch, 0.9) == []
