"""The first orbits of a branch that is born, on maps where it is known by a formula."""

import numpy as np
import pytest

from gelcone.atlas.branches import switching
from gelcone.atlas.branches.branch import Event, EventKind, Walk
from gelcone.atlas.branches.event import DOUBLE, born, locate
from gelcone.atlas.branches.follow import follow
from gelcone.atlas.branches.point import Corrected
from gelcone.atlas.branches.switching import LARGEST_AMPLITUDE, LARGEST_SHIFT, first_points
from gelcone.motion.orbit import Kind
from tests.atlas.branches import maps


def doubling(leaves=True):
    world, s = maps.Maps(maps.s_curve), maps.DOUBLES_AT
    orbit = locate(world, maps.nodes_of(maps.AWAY + s), np.array([maps.value_of(s)]), DOUBLE, 0.5)
    return world, Event(EventKind.PERIOD_DOUBLING, orbit, born(world, orbit) if leaves else None, 1.0, 3, Kind(1))


@pytest.mark.parametrize(("width", "share"), [(100.0, 0.4), (1.0, 1.0)])
def test_a_branch_begins_with_the_event_and_an_orbit_of_twice_the_period_next_to_it(width, share):
    """As far from it as an amplitude or a shift of the parameter allows, whichever is less; that amplitude would lie
    beyond the next doubling, and is taken smaller."""
    world, event = doubling()
    child, start, point = first_points(world, event, Walk(-0.5 * width, 0.5 * width))
    assert child.kind == Kind(2)
    np.testing.assert_array_equal(start.nodes, np.concatenate([event.orbit.nodes] * 2))
    assert start.value == event.value
    h = 0.5 * abs(point.nodes[0, 0] - point.nodes[2, 0])
    assert point.value == pytest.approx(maps.cycle_of(h)[1], abs=1e-12)
    size = maps.AWAY + maps.DOUBLES_AT
    expected = share * min(LARGEST_AMPLITUDE * size, np.sqrt(LARGEST_SHIFT * width / event.born.curvature))
    assert h == pytest.approx(expected, rel=1e-3)
    assert point.tangent.value > 0.0  # away from where it was born
    assert np.vdot(point.tangent.nodes, start.tangent.nodes) > 0.0


def test_the_orbits_born_at_rest_have_the_period_of_the_map_that_loses_its_stability():
    for rule, kind in ((maps.pitchfork, Kind(1)), (maps.mirrored_pitchfork, Kind(1, True))):
        world, walk = maps.Maps(rule, symmetric=True), Walk(-1.0, 1.0)
        rest = follow(world, maps.orbit_at(world, -0.0987, 0.0), walk, both_ways=False, resting=True)
        child, start, point = first_points(world, rest.events[0], walk)
        assert child.kind == kind
        assert not start.nodes.any()
        assert point.value == pytest.approx(point.nodes[0, 0] ** 2, abs=1e-12)
        assert abs(point.nodes[0, 0]) == pytest.approx(LARGEST_AMPLITUDE, rel=1e-3)


def test_the_first_guess_is_off_by_the_third_power_of_its_amplitude(monkeypatch):
    """It bends with the branch, both halves of it alike."""
    asked = []
    for smaller in (1.0, 0.5):
        world, event = doubling()
        monkeypatch.setattr(switching, "LARGEST_AMPLITUDE", 0.01 * smaller)
        monkeypatch.setattr(switching, "correct", lambda *given: asked.append(given[1]) or Corrected(None))
        monkeypatch.setattr(switching, "SMALLEST_AMPLITUDE", 0.009 * smaller)
        assert first_points(world, event, Walk(-50.0, 50.0)) is None
    off = []
    for guess in asked:
        x, value = maps.cycle_of(0.5 * abs(guess.nodes[0, 0] - guess.nodes[2, 0]))
        off.append([np.abs(np.sort(guess.nodes[[0, 2], 0]) - np.sort(x)).max(), abs(guess.value - value)])
    assert np.max(off[0]) < 1e-4
    np.testing.assert_array_less(off[1], np.maximum(np.array(off[0]) / 7.0, 1e-12))


def test_nothing_begins_where_nothing_is_born():
    world, event = doubling(leaves=False)
    assert first_points(world, event, Walk(-1.0, 1.0)) is None
