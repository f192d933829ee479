"""Singular orbits and the branches born there, on maps where both are known by formulas."""

import numpy as np
import pytest

from gelcone.atlas.branches import event
from gelcone.atlas.branches.event import DOUBLE, FOLD, Singular, bordered, born, locate
from gelcone.motion.orbit import Kind
from tests.atlas.branches import maps

NULL = {FOLD: (1.0, 1.0), DOUBLE: (1.0, -1.0)}
"""Of the first node; of the second half and a quarter of these."""


def located(at, s):
    world = maps.Maps(maps.s_curve)
    guess = maps.nodes_of(maps.AWAY + s + 0.02)
    return world, locate(world, guess, np.array([maps.value_of(s) + 0.03]), at, 0.5)


@pytest.mark.parametrize(
    ("at", "s"), [(FOLD, 1.0), (FOLD, -1.0), (DOUBLE, maps.DOUBLES_AT), (DOUBLE, -maps.DOUBLES_AT)]
)
def test_a_singular_orbit_is_where_the_formula_has_it(at, s):
    """Its value within the error, its null vector with a largest entry of 1, its multipliers -1 or 1 and the rest."""
    _, found = located(at, s)
    assert abs(found.values[0] - maps.value_of(s)) <= 3.0 * found.errors[0] < 1e-12
    np.testing.assert_allclose(found.nodes, maps.nodes_of(maps.AWAY + s), rtol=1e-9)
    null = np.array([NULL[at], maps.HALFWAY * NULL[at]])
    np.testing.assert_allclose(found.null, null * np.sign(found.null[0, 0]), atol=1e-9)
    np.testing.assert_allclose(found.multipliers, [at, at * maps.SHRINKS], rtol=1e-9)


def test_errors_are_those_of_rounding_in_the_ends_of_segments(monkeypatch):
    """A segment that ends a little off moves the event by no more."""
    for at, s in ((FOLD, 1.0), (DOUBLE, maps.DOUBLES_AT)):
        _, exact = located(at, s)
        run = maps.Maps.run
        for sign in (1.0, -1.0):
            noise = 1.0 + sign * 2e-15 * 1e6

            def rounded(self, nodes, values, run=run, noise=noise):
                found = run(self, nodes, values)
                return found._replace(ends=found.ends * noise)

            with monkeypatch.context() as patched:
                patched.setattr(maps.Maps, "run", rounded)
                _, off = located(at, s)
            moved = abs(off.values[0] - exact.values[0])
            assert 0.0 < moved < 1e6 * exact.errors[0]


@pytest.mark.parametrize("s", [1.0, -1.0])
def test_at_a_fold_the_branch_itself_leaves_with_its_curvature(s):
    world, found = located(FOLD, s)
    own = born(world, found)
    assert own.curvature == pytest.approx(3.0 * s, rel=1e-8)
    assert own.coefficient == pytest.approx(found.quadratic, rel=1e-6)
    assert not own.bend.any()


@pytest.mark.parametrize("s", [maps.DOUBLES_AT, -maps.DOUBLES_AT])
def test_cycles_of_two_leave_as_the_formula_says(s):
    """Those of the map at small amplitudes: their value and their mean displacement."""
    world, found = located(DOUBLE, s)
    own = born(world, found)
    h = 1e-2
    x, value = maps.cycle_of(h)
    assert np.sign(s) * own.curvature * h * h == pytest.approx(value - maps.value_of(maps.DOUBLES_AT), rel=1e-3)
    middle = np.sign(s) * (np.mean(x) - maps.AWAY)
    assert own.bend[0] * h * h == pytest.approx(np.full(2, middle - s), rel=1e-3)
    np.testing.assert_allclose(own.bend[1], own.bend[0] * maps.HALFWAY)


@pytest.mark.parametrize(("rule", "at"), [(maps.pitchfork, FOLD), (maps.mirrored_pitchfork, DOUBLE)])
def test_at_rest_the_next_order_gives_the_curvature(rule, at):
    world, nodes = maps.Maps(rule, symmetric=True), np.zeros((2, 2))
    system = bordered(world, nodes, np.zeros(1), at, None, None)
    assert abs(system.g) < 1e-12
    rest = Singular(nodes, np.zeros(1), np.zeros(1), system.null, system.left, np.ones(2, complex), at)
    own = born(world, rest)
    assert own.curvature == pytest.approx(1.0, rel=1e-6)
    assert not own.bend.any()


def test_of_mirrored_orbits_the_symmetry_breaks():
    """At p = 2, where cycles of displacements of the ratio r leave at p = 2 (r + 1/r - 1)."""
    world = maps.Maps(maps.mirrored_pitchfork, Kind(1, True), symmetric=True)
    x = np.sqrt(1.95)
    guess = np.array([[x, -x], [0.5 * x, -0.25 * x]])
    found = locate(world, guess, np.array([1.95]), DOUBLE, 0.5)
    assert abs(found.values[0] - 2.0) <= 3.0 * found.errors[0] < 1e-12
    assert abs(found.nodes[0, 0]) == pytest.approx(np.sqrt(2.0), rel=1e-9)
    assert born(world, found).curvature == pytest.approx(4.0, rel=1e-6)
    np.testing.assert_allclose(found.multipliers, [-1.0, -maps.SHRINKS], rtol=1e-9)


def test_no_orbit_is_located_from_far_away():
    world = maps.Maps(maps.s_curve)
    assert locate(world, maps.nodes_of(maps.AWAY + 0.1), np.array([0.0]), FOLD, 0.01) is None


def test_rounding_in_the_tangents_counts_by_the_share_that_the_event_has_in_them(monkeypatch):
    """And in the ends by the weights of their equations; neither takes from the other."""
    world, nodes = maps.Maps(maps.s_curve), maps.nodes_of(maps.AWAY + 1.0)
    found = bordered(world, nodes, np.array([maps.value_of(1.0)]), FOLD, None, None)
    rows, corner, errors = found.by_nodes[None], found.by_values[None], []
    for weights, share in ((0.0, -3.0), (-2.0, 0.0), (-2.0, -3.0)):
        monkeypatch.setattr(event, "left_weights", lambda *_, w=weights, s=share: (np.full_like(nodes, w), s))
        errors.append(event._errors(world, found, rows, corner)[0])
    here = found.here
    each = np.abs(found.left)[:, :, None] * np.abs(here.tangents) * np.abs(found.null)[:, None, :]
    ends = np.abs(here.ends) + np.abs(here.tangents).max(axis=2)
    np.testing.assert_allclose(errors[:2], 2e-15 * np.array([3.0 * each.sum(), 2.0 * ends.sum()]))
    assert errors[2] == pytest.approx(sum(errors[:2]))
