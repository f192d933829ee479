"""When two orbits are one: up to shifts by repeats and mirror images, as a share of their size."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.atlas.branches import tree
from gelcone.atlas.branches.branch import Ending, EventKind, Walk
from gelcone.atlas.branches.follow import follow
from gelcone.atlas.branches.point import Direction, Point
from gelcone.atlas.branches.tree import Tree, _passing, distance, kind_of, whole_period
from gelcone.motion.orbit import Kind
from tests.atlas.branches import maps
from tests.recorded import numbers, record

WALK = Walk(-3.0, 3.0)
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
    tangent = Direction(np.array([[1.0, 0.0]]), 1.0)
    points = [Point(np.array([[v, 0.0]]), v, np.ones(2, complex), tangent) for v in (0.1, 0.2, 0.4)]
    branch = SimpleNamespace(points=points, values=np.array([0.1, 0.2, 0.4]))
    ((before, share),) = _passing(branch, 0.3, 1.0)
    assert before == 1
    assert share == pytest.approx(0.5, abs=0.02)
    assert _passing(branch, 0.9, 1.0) == []


def test_a_branch_passes_twice_a_value_beyond_two_points_between_which_it_turns():
    """Values -x^2, up to a fold halfway between two points of one value."""
    places = np.array([-0.9, -0.3, 0.3, 0.9])
    points = [Point(np.array([[x, 1.0]]), -x * x, np.ones(2, complex), Direction(np.array([[1.0, 0.0]]), -2.0 * x))
              for x in places]  # fmt: skip
    branch = SimpleNamespace(points=points, values=-(places**2))
    found = _passing(branch, -0.01, 1.0)
    assert [before for before, _ in found] == [1, 1]
    np.testing.assert_allclose([share for _, share in found], [0.2 / 0.6, 0.4 / 0.6], atol=0.02)
    assert _passing(branch, 0.05, 1.0) == []


# --- made-up maps: what is born where is known by formulas ------------------------------------------------------------


def grown(rule, value, *x, walk=WALK, switch=1, kind=maps.ONCE, **own):
    world = maps.Maps(rule, kind, symmetric=own.pop("symmetric", False))
    tree = Tree(walk, switch)
    tree.add(follow(world, maps.orbit_at(world, value, *x), walk, **own), 0)
    tree.grow()
    return tree


@pytest.mark.parametrize(("switch", "levels"), [(0, [0]), (1, [0, 1, 1]), (2, [0, 1, 1, 2, 2])])
def test_branches_are_born_at_doublings_as_often_as_is_asked_for(switch, levels):
    """The nearest first; each knows the event at which it is born, and that event its number."""
    tree = grown(maps.s_curve, maps.value_of(1.2), maps.AWAY + 1.2, switch=switch)
    assert [branch.level for branch in tree.branches] == levels
    assert [branch.map.repeats for branch in tree.branches] == [2**level for level in levels]
    for number, branch in enumerate(tree.branches[1:], 1):
        assert branch.parent.born_branch == number
        assert branch.ended == (Ending.MERGED, Ending.LIMIT)
        assert branch.points[0].value == branch.parent.value
        assert tree.branches[branch.parent.branch].level == branch.level - 1
    for branch in tree.branches[1:3]:
        sign = np.sign(branch.values[-1])
        for point in branch.points:
            h = 0.5 * abs(point.nodes[0, 0] - point.nodes[2, 0])
            assert sign * point.value == pytest.approx(maps.cycle_of(h)[1], abs=1e-9)
        for event in branch.events:  # the event lies between its points, behind the one that was put before them
            ends = np.sort(branch.values[event.after : event.after + 2])
            assert ends[0] <= event.value <= ends[1]


@pytest.mark.parametrize("rule", [maps.pitchfork, maps.mirrored_pitchfork])
def test_what_is_born_at_rest_is_always_followed(rule):
    walk = Walk(-1.0, 1.0)
    tree = grown(rule, -1.0, 0.0, walk=walk, switch=0, symmetric=True, both_ways=False, resting=True)
    rest, child = tree.branches
    assert (rest.resting, child.resting, child.level) == (True, False, 0)
    assert child.parent is rest.events[0]
    assert child.ended == (Ending.REST, Ending.LIMIT)
    assert child.map.reflected == (rule is maps.mirrored_pitchfork)
    np.testing.assert_allclose(child.values, [p.nodes[0, 0] ** 2 for p in child.points], atol=1e-12)


def test_a_branch_that_merges_leads_to_the_one_that_it_comes_from():
    """Which is followed from there, and takes the level of the first."""
    x, value = maps.cycle_of(0.3)
    tree = grown(maps.s_curve, value, *x, switch=0, kind=Kind(2))
    first, second = tree.branches
    assert second.map == Kind(1)
    assert (first.level, second.level) == (0, 0)
    assert first.parent in second.events
    assert first.parent.value == pytest.approx(maps.value_of(maps.DOUBLES_AT), abs=1e-11)
    assert first.parent.born_branch == 0
    assert [event.branch for event in second.events] == [1] * 4


def test_a_branch_that_shrinks_to_rest_ends_where_rest_loses_its_stability():
    walk = Walk(-1.0, 1.0)
    tree = Tree(walk, 0)
    world = maps.Maps(maps.pitchfork, symmetric=True)
    tree.add(follow(world, maps.orbit_at(world, -1.0, 0.0), walk, both_ways=False, resting=True), 0)
    start = maps.orbit_at(world, 0.5, np.sqrt(0.5))
    tree.add(follow(world, replace(start, tangent=-start.tangent), walk), 0)
    last = tree.branches[1].points[-1]
    assert not last.nodes.any()
    assert last.value == pytest.approx(0.0, abs=1e-12)
    assert tree.branches[0].events[0].born_branch == 1
    tree.grow()
    assert len(tree.branches) == 2  # it is there already


def test_an_orbit_is_found_between_its_two_points():
    tree = grown(maps.s_curve, maps.value_of(1.2), maps.AWAY + 1.2, switch=0)
    world = maps.Maps(maps.s_curve)
    for s in (-1.7, 0.3, 1.05, 1.9):
        here = maps.orbit_at(world, maps.value_of(s), maps.AWAY + s)
        assert tree.holds(world, here)
        assert not tree.holds(world, replace(here, nodes=np.add(here.nodes, [1e-3, 0.0])))
    x, value = maps.cycle_of(0.3)
    cycles = world.of_kind(Kind(2))
    assert not tree.holds(cycles, maps.orbit_at(cycles, value, *x))


def test_a_branch_belongs_to_the_event_where_it_is_born_and_ends_at_another():
    """Both know its number; it is followed once."""
    tree = grown(maps.bubble, -0.5, maps.AWAY, walk=Walk(-1.0, 2.0))
    parent, child = tree.branches
    assert sorted(event.value for event in parent.events) == pytest.approx([0.0, 1.0], abs=1e-11)
    assert [event.born_branch for event in parent.events] == [1, 1]
    assert child.parent is parent.events[0]
    assert child.ended == (Ending.MERGED, Ending.MERGED)
    assert child.values[[0, -1]] == pytest.approx([0.0, 1.0], abs=1e-11)
    h = np.array([0.5 * (point.nodes[0, 0] - point.nodes[2, 0]) for point in child.points])
    np.testing.assert_allclose(h**2, child.values * (1.0 - child.values), atol=1e-9)


def test_a_branch_ends_at_its_own_event_and_not_at_one_that_is_near():
    """Values count to a ten-millionth of the interval."""
    world = maps.Maps(maps.s_curve)
    nodes = numbers(2, 2)
    events = [
        SimpleNamespace(
            kind=EventKind.PERIOD_DOUBLING, value=value, orbit=SimpleNamespace(nodes=nodes, at=-1.0), map=Kind(1)
        )
        for value in (0.5 - 1e-5, 0.5, 0.5 + 1e-5)
    ]
    tree = Tree(Walk(0.0, 1.0), 1, [SimpleNamespace(events=events, shooting=world)])
    merge, branch = SimpleNamespace(nodes=nodes, values=np.array([0.5 + 1e-8])), SimpleNamespace(map=Kind(2))
    assert tree._met(merge, branch) is events[1]
    assert tree._met(SimpleNamespace(nodes=nodes, values=np.array([0.5 + 5e-6])), branch) is None


# --- where branches are born ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "level", "switch", "ended", "grows"),
    [
        (EventKind.LOSS_OF_REST, 1, 1, Ending.REST, 1), (EventKind.PERIOD_DOUBLING, 0, 1, Ending.MERGED, 1),
        (EventKind.PERIOD_DOUBLING, 1, 1, None, None), (EventKind.PERIOD_DOUBLING, 1, 2, Ending.MERGED, 2),
    ],
)  # fmt: skip
def test_a_branch_begins_at_the_event_at_which_it_is_born(monkeypatch, kind, level, switch, ended, grows):
    """Its own events lie one point further on; births at rest are followed at any level, others up to the asked one."""
    world, start, point = maps.Maps(maps.s_curve), SimpleNamespace(), SimpleNamespace(nodes=None, value=0.5)
    event = SimpleNamespace(kind=kind, born_branch=-1, branch=0, born=object())
    inner = SimpleNamespace(kind=EventKind.FOLD, after=3, born=None)
    child = SimpleNamespace(
        points=["first"], events=[inner], ended=(Ending.WALL, Ending.STEP), merges=[], level=None, parent=None
    )
    asked = record(monkeypatch, tree, first_points=("child", start, point), follow=child)
    own = Tree(WALK, switch)
    own.branches, own.holds = [SimpleNamespace(shooting=world)], lambda *given: False
    own.waiting.append((event, level))
    own.grow()
    assert not own.waiting
    if ended is None:
        assert len(own.branches) == 1
        return
    assert own.branches[1] is child
    assert (child.ended, child.points, inner.after) == ((ended, Ending.STEP), [start, "first"], 4)
    assert (child.level, child.parent, event.born_branch, inner.branch) == (grows, event, 1, 1)
    (sought,), (followed,) = asked["first_points"], asked["follow"]
    assert (sought["shooting"], sought["event"], sought["walk"]) == (world, event, WALK)
    assert (followed["shooting"], followed["start"], followed["both_ways"]) == ("child", point, False)


def test_a_branch_that_shrinks_to_rest_is_born_where_the_amplitude_it_had_left_fits_best(monkeypatch):
    """At the second of two events: at 2, of curvature 8 and amplitude 1/8, it is to be at 2.125."""

    def event(value, curvature):
        orbit = SimpleNamespace(null=np.array([[0.5, -2.0]]), multipliers=np.array([value, 0.5]))
        return SimpleNamespace(value=value, born=SimpleNamespace(curvature=curvature), orbit=orbit, born_branch=-1)

    events = [event(2.1, 8.0), event(2.0, 8.0), event(2.5, 8.0)]
    rest = SimpleNamespace(resting=True, events=events)
    last = Point(np.array([[0.25, -0.125]]), 2.125, np.array([0.9, 0.8]), Direction(np.ones((1, 2)), 1.0))
    branch = SimpleNamespace(ended=(Ending.LIMIT, Ending.REST), points=[last], map="map", resting=False, events=[])
    monkeypatch.setattr(tree, "born_map", lambda event: "map")
    Tree(SimpleNamespace(scale=4.0), 1, [rest, branch])._ends_at_rest(branch, 7)
    assert [event.born_branch for event in events] == [-1, 7, -1]
    assert (branch.points[-1].value, branch.points[-1].multipliers.tolist()) == (2.0, [2.0, 0.5])
    assert not branch.points[-1].nodes.any()


def test_a_branch_that_another_merges_with_is_followed_at_the_same_level(monkeypatch):
    added, metric = [], "metric"
    monkeypatch.setattr(tree, "at_value", lambda *given: SimpleNamespace(point=("start", given)))
    monkeypatch.setattr(tree, "follow", lambda *given: given)
    monkeypatch.setattr(tree.Metric, "of", lambda nodes, scale: (metric, nodes, scale))
    monkeypatch.setattr(Tree, "holds", lambda own, shooting, point: False)
    monkeypatch.setattr(Tree, "add", lambda own, branch, level: added.append((branch, level)))
    monkeypatch.setattr(Tree, "_met", lambda own, merge, branch: (merge, branch))
    own, walk = SimpleNamespace(of_kind=lambda kind: ("shooting", kind)), SimpleNamespace(scale=4.0)
    merge, branch = SimpleNamespace(nodes="nodes", values=[1.5, 9.0]), SimpleNamespace(level=3, shooting=own)
    assert Tree(walk, 1)._parent(branch, "kind", merge) == (merge, branch)
    start = ("start", (("shooting", "kind"), "nodes", 1.5, (metric, "nodes", 4.0)))
    assert added == [((("shooting", "kind"), start, walk), 3)]
