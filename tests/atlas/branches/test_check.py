"""Checks of branches by runs: what is flagged, and next to which orbits runs start."""

from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.atlas.branches import check
from gelcone.atlas.branches.branch import EventKind
from gelcone.atlas.branches.journal import Journal
from gelcone.motion.orbit import Kind


def branch(stable, events=()):
    points = [
        SimpleNamespace(stable=one, value=0.1 * k, nodes=np.full((4, 2), 1.0 + k)) for k, one in enumerate(stable)
    ]
    of = [SimpleNamespace(kind=kind, after=after, value=0.1 * after + 0.05) for kind, after in events]
    shooting = SimpleNamespace(kind=Kind(2), segments=2)
    return SimpleNamespace(points=points, events=of, shooting=shooting, map=Kind(2))


def test_runs_start_next_to_the_unstable_orbit_at_each_event_that_changes_stability(monkeypatch):
    monkeypatch.setattr(check, "_periods", lambda branch, point: 9999 if point.value > 0.55 else 3)
    own = branch(
        [True, True, False, False, True, True, True, False],
        [
            (EventKind.FOLD, 1),
            (EventKind.PERIOD_DOUBLING, 2),
            (EventKind.FOLD, 3),
            (EventKind.TORUS, 3),
            (EventKind.FOLD, 6),
        ],
    )
    found = list(check._lost(4, own))
    assert [(run.number, run.event.after, run.point) for run in found] == [(4, 1, own.points[2]), (4, 3, own.points[3])]
    assert not any(run.point.stable for run in found)


def test_stable_orbits_are_chosen_evenly_but_for_the_ends(monkeypatch):
    monkeypatch.setattr(check, "_periods", lambda branch, point: 9999 if point.value == 0.1 * 3 else 3)
    own = branch([True] * 6 + [False, True])
    chosen = [own.points.index(run.point) for run in check._stable(0, own)]
    assert set(chosen) == {1, 2, 4, 5}
    assert chosen == sorted(chosen)


@pytest.mark.parametrize(
    ("apart", "closer", "flags"),
    [
        (0.1, 0.1, []), (3.0, np.inf, [(check.LEAVES, "")]), (3.0, 0.01, [(check.LEAVES, "its basin is narrower")]),
    ],
)  # fmt: skip
def test_runs_that_leave_a_stable_orbit_are_flagged(monkeypatch, apart, closer, flags):
    """With a reason where they return from closer by; an event whose unstable orbit nothing leaves is flagged, too."""
    own = branch([True, True, True, False], [(EventKind.FOLD, 2)])
    monkeypatch.setattr(check, "_periods", lambda branch, point: 3)
    monkeypatch.setattr(check, "ORBITS", 1)
    monkeypatch.setattr(
        check,
        "_apart",
        lambda journal, runs, distance, **flow: np.full(len(runs), apart if distance == check.DISTANCE else closer),
    )
    monkeypatch.setattr(check, "_staying", lambda journal, runs, **flow: list(runs))
    tree = SimpleNamespace(branches=[own], walk=SimpleNamespace(journal=Journal()))
    found = check.run_perturbed(tree)
    assert [(flag.kind, flag.explanation[:21]) for flag in found.flags if flag.kind == check.LEAVES] == flags
    (lost,) = [flag for flag in found.flags if flag.kind == check.NOT_BRACKETED]
    assert (lost.branch, lost.value) == (0, pytest.approx(0.25))
    assert found.orbits == 1


def test_an_orbit_that_repeats_sooner_than_its_branch_is_recognised():
    nodes = np.random.default_rng(1).normal(size=(4, 2))
    for path, sooner in ((nodes, False), (np.tile(nodes[:2], (2, 1)), True)):
        beside = SimpleNamespace(branch=branch([True]), point=SimpleNamespace(nodes=path))
        assert check._repeats_sooner(beside) is sooner


def covered(monkeypatch, points, known=(), attracting=True, arrived=True, symmetric=False):
    """`cover` of runs at 0, 1, ... on whose cycles these points lie (None: none is found), of which some are known."""
    grown = []
    monkeypatch.setattr(check, "polished", lambda shooting, state, value, scale, **flow: points[int(value)])
    monkeypatch.setattr(check, "shortest", lambda shooting, point, scale: (shooting, point))
    monkeypatch.setattr(check, "follow", lambda shooting, point, walk: point.value)
    shooting = SimpleNamespace(symmetric=symmetric)
    shooting.of_kind = lambda kind: shooting
    tree = SimpleNamespace(
        walk=SimpleNamespace(scale=1.0),
        find=lambda own, nodes, value: 0 if value in known else None,
        add=lambda branch, level: grown.append((branch, level)),
        grow=lambda: grown.append("grown"),
    )
    count = len(points)
    section = np.ones((count, 2, 2))
    section[0] = 0.0
    runs = check.Runs(
        np.arange(float(count)), section, np.where(np.arange(count) == 1, 0, 2), np.zeros(count, bool),
        np.full(count, arrived), attracting,
    )  # fmt: skip
    return check.cover(tree, shooting, runs), grown


def orbit(value, stable=True, size=1.0):
    return SimpleNamespace(value=value, stable=stable, nodes=np.full((4, 2), size))


def test_each_settled_cycle_is_on_a_branch_or_seeds_one(monkeypatch):
    """The second run is not periodic; the first is at rest, which counts where the film has a mirror image alone."""
    points = [orbit(0.0), orbit(1.0), orbit(2.0), orbit(3.0), orbit(4.0, size=1e-9)]
    found, grown = covered(monkeypatch, points, known=(2.0,))
    assert (found.cycles, found.seeded, found.orbits, found.flags) == (4, 3, 0, [])
    assert grown == [(0.0, 0), "grown", (3.0, 0), "grown", (4.0, 0), "grown"]
    found, grown = covered(monkeypatch, points, known=(2.0,), symmetric=True)
    assert (found.cycles, found.seeded) == (2, 1)  # neither the rest nor what decays to it
    assert grown == [(3.0, 0), "grown"]


@pytest.mark.parametrize(
    ("attracting", "arrived", "flagged", "cycles"),
    [(True, True, [2.0, 3.0], 1), (True, False, [], 1), (False, True, [2.0], 2)],
)
def test_an_attractor_without_a_stable_orbit_is_flagged_once_it_has_arrived(
    monkeypatch, attracting, arrived, flagged, cycles
):
    """Orbits of earlier branches may be unstable."""
    points = [orbit(0.0), orbit(1.0), None, orbit(3.0, stable=False)]
    found, _ = covered(monkeypatch, points, known=(0.0, 3.0), attracting=attracting, arrived=arrived)
    assert [(flag.kind, flag.branch, flag.value) for flag in found.flags] == [
        (check.NO_ORBIT, -1, value) for value in flagged
    ]
    assert found.cycles == cycles


def test_what_comes_back_to_an_unstable_orbit_by_chance_has_left_it(monkeypatch):
    """A run that is near after the first time has to be near half as many periods later, too."""
    asked = []

    def apart(journal, runs, distance, **flow):
        asked.append([run.periods for run in runs])
        near = {4: [0.1, 1.9, 2.1], 6: [5.0, 0.1]}[runs[0].periods]
        return np.array(near)

    monkeypatch.setattr(check, "_apart", apart)
    runs = [check._Perturbed(k, None, None, None, 4) for k in range(3)]
    assert [run.number for run in check._staying(None, runs)] == [1]
    assert asked == [[4, 4, 4], [6, 6]]
