"""Checks of branches by runs: what is flagged, and next to which orbits runs start."""

from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.atlas.branches import check
from gelcone.atlas.branches.branch import EventKind
from gelcone.atlas.branches.journal import Journal
from gelcone.motion.orbit import Kind
from gelcone.physics.model import ConeModel
from tests.recorded import numbers, record


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
        (3.0, 5.0, [(check.LEAVES, "its basin is narrower")]),  # within rounding, from 1e-8 on
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


@pytest.mark.parametrize(("reflected", "periods"), [(False, 7), (True, 4)])
def test_runs_last_whole_periods_until_all_that_is_off_has_decayed_to_a_hundredth(reflected, periods):
    """A symmetric orbit comes to its mirror image first: half a period halves what is off."""
    tangents, ones = np.array([np.diag([0.5, 0.25])]), np.ones(2)
    shooting = SimpleNamespace(
        run=lambda nodes, values: SimpleNamespace(tangents=tangents), kind=Kind(1, reflected),
        signs=-ones if reflected else ones,
    )  # fmt: skip
    point = SimpleNamespace(nodes=np.ones((1, 2)), value=1.0, stable=True)
    assert check._periods(SimpleNamespace(shooting=shooting), point) == periods


def test_an_orbit_that_repeats_sooner_than_its_branch_is_recognised():
    nodes = np.random.default_rng(1).normal(size=(4, 2))
    for path, sooner in ((nodes, False), (np.tile(nodes[:2], (2, 1)), True)):
        beside = SimpleNamespace(branch=branch([True]), point=SimpleNamespace(nodes=path))
        assert check._repeats_sooner(beside) is sooner


def covered(monkeypatch, points, known=(), attracting=True, arrived=True, symmetric=False):
    """`cover` of runs at 0, 1, ... on whose cycles these points lie (None: none is found), of which some are known."""
    grown = []
    monkeypatch.setattr(check, "polished", lambda shooting, runs, k, scale, **flow: (shooting, points[k]))
    monkeypatch.setattr(check, "shortest", lambda shooting, point, scale: (shooting, point))
    monkeypatch.setattr(check, "follow", lambda shooting, point, walk: point.value)
    shooting = SimpleNamespace(symmetric=symmetric)
    shooting.of_kind = lambda kind: shooting
    tree = SimpleNamespace(
        walk=SimpleNamespace(scale=1.0),
        holds=lambda own, point: point.value in known,
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


# --- what is handed on ------------------------------------------------------------------------------------------------


class Stand:
    """Stands for shooting whose members are those of a damped film at some voltages."""

    size = 2

    def __init__(self, damping=0.1):
        self.damping = damping

    def members_at(self, values):
        (volts,) = values
        return ConeModel(damping_ratio=np.broadcast_to(self.damping, volts.shape).copy(), voltage=volts).members()


def test_brute_force_settles_from_each_start_at_each_value_and_takes_the_cycles_that_it_finds(monkeypatch):
    """Of six motions the first has no damping; the others are: on a cycle, near one that is another's, on none, on one
    that is its own mirror image, and on a mirrored one of odd period."""
    found = np.array([True, True, False, True, True])
    cycles = SimpleNamespace(
        found=found, point=numbers(5, 2, at=5.0), period=np.array([1, 2, 4, 2, 3]), attracting=np.array([1, 0, 1, 1,
        1]) > 0,
        symmetric=np.array([0, 0, 1, 1, 1]) > 0,
    )  # fmt: skip
    asked = record(monkeypatch, check, search=SimpleNamespace(cycles=cycles, state=numbers(5, 2, at=7.0)))
    damping = np.array([0.0, 0.1, 0.1, 0.1, 0.1, 0.1])
    values, starts = np.array([0.2, 0.4, 0.6]), numbers(2, 2)
    walk = SimpleNamespace(journal=Journal())
    runs = check.brute_force(walk, Stand(damping), values, starts, tolerance=2e-9, threads=5)
    (call,) = asked["search"]
    assert call["members"].number("voltage").tolist() == [0.2, 0.4, 0.4, 0.6, 0.6]
    np.testing.assert_array_equal(call["states"], np.tile(starts, (3, 1))[1:])
    assert (call["tolerance"], call["threads"]) == (2e-9, 5)
    assert runs.values.tolist() == [0.2, 0.2, 0.4, 0.4, 0.6, 0.6]
    own = np.where(found[:, None], numbers(5, 2, at=5.0), numbers(5, 2, at=7.0))
    np.testing.assert_array_equal(runs.section[:, 0], [[np.nan] * 2, *own])
    assert runs.period.tolist() == [0, 1, 2, 0, 2, 3]
    assert runs.symmetric.tolist() == [False, False, False, False, True, False]
    assert runs.arrived.tolist() == [False, True, False, True, True, True]
    assert runs.attracting


def test_a_run_begins_at_its_distance_from_its_own_orbit_and_lasts_for_its_own_periods(monkeypatch):
    """Distances are shares of the orbits' sizes; what ended has left, however near it was."""
    branches_ = [SimpleNamespace(shooting=Stand(), map=Kind(*kind)) for kind in ((2, False), (1, True), (1, False))]
    points = [SimpleNamespace(value=0.1 * k + 0.1, nodes=np.full((3, 2), 0.5 + k)) for k in range(3)]
    runs = [check._Perturbed(k, *pair, None, 4 + k) for k, pair in enumerate(zip(branches_, points, strict=True))]
    ends = np.array([[0.5, 0.5 + 2e-3], [1.5, 1.5 - 3e-3], [2.5, 2.5]])
    asked = record(monkeypatch, check, settle=(ends, np.array([0, 0, 4], dtype=np.int8)))
    found = check._apart(Journal(), runs, 1e-3, tolerance=2e-9, threads=5)
    (call,) = asked["settle"]
    assert call["members"].number("voltage").tolist() == pytest.approx([0.1, 0.2, 0.3])
    assert call["repeats"].tolist() == [8, 10, 6]
    assert (call["tolerance"], call["threads"]) == (2e-9, 5)
    off = np.linalg.norm(call["states"] - np.array([[0.5] * 2, [1.5] * 2, [2.5] * 2]), axis=1)
    np.testing.assert_allclose(off, 1e-3 * np.array([0.5, 1.5, 2.5]))
    np.testing.assert_allclose(found, [2.0 / 0.5, 3.0 / 1.5, np.inf])
    assert check._apart(Journal(), [], 1e-3).size == 0


def test_all_stable_orbits_count_that_runs_started_from(monkeypatch):
    """Also those that they have not left; closer runs start from those that were left alone."""
    own = branch([True] * 5)
    monkeypatch.setattr(check, "_periods", lambda branch, point: 3)
    asked = []

    def apart(journal, runs, distance, **flow):
        asked.append((len(runs), distance, flow))
        return np.where(np.arange(len(runs)) == 0, 3.0, 0.1) if distance == check.DISTANCE else np.full(len(runs), 3.0)

    monkeypatch.setattr(check, "_apart", apart)
    tree = SimpleNamespace(branches=[own], walk=SimpleNamespace(journal=Journal()))
    found = check.run_perturbed(tree, tolerance=2e-9)
    assert found.orbits == 3
    flow = {"tolerance": 2e-9}
    closer = [(1, at, flow) for at in check.CLOSER]
    assert asked[: 1 + len(closer)] == [(3, check.DISTANCE, flow), *closer]
    assert all(call == (0, check.DISTANCE, flow) for call in asked[1 + len(closer) :])  # no branch loses stability
    assert [flag.value for flag in found.flags if flag.kind == check.LEAVES] == [pytest.approx(0.1)]
