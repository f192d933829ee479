"""Motions along frequencies: when one has jumped, and all that was met, in order."""

from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.codes import Outcome
from gelcone.motion import stepping as module
from gelcone.motion.stepping import FINEST, JUMPED, NEGLIGIBLE, NUDGE, SURE, Trail, jumped, walk
from gelcone.motion.swing import Swing
from gelcone.physics.model import ConeModel
from tests.recorded import record


def swings(*rows):
    """Motions by (lowest, highest, period)."""
    found = Swing.blank(len(rows), states=2)
    found.lowest[:], found.highest[:], found.period[:] = zip(*rows, strict=True)
    found.outcome[:] = Outcome.OK
    found.final[:] = np.arange(2.0 * len(rows)).reshape(-1, 2)
    return found


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        ((-1.0, 1.0, 1), False),
        ((-1.0 - 0.9 * JUMPED, 1.0 + 0.9 * JUMPED, 1), False),
        ((-1.0 - 1.5 * JUMPED, 1.0 + 1.5 * JUMPED, 1), True),
        ((-1.0 + 1.5 * JUMPED, 1.0 + 1.5 * JUMPED, 1), True),
        ((-1.0, 1.0, 0), True),
    ],
)
def test_a_motion_has_jumped_where_amplitude_or_middle_changed_much_or_it_is_lost(other, expected):
    one = swings((-1.0, 1.0, 1))
    assert jumped(one, swings(other), np.array([1.0])).tolist() == [expected]


def test_what_is_negligible_failed_or_was_not_periodic_has_not_jumped():
    tiny = NEGLIGIBLE * 0.4
    assert jumped(swings((-tiny, tiny, 1)), swings((0.0, 0.0, 1)), np.array([1.0])).tolist() == [False]
    assert jumped(swings((-tiny, tiny, 1)), swings((0.0, 0.0, 1)), np.array([tiny])).tolist() == [True]
    assert jumped(swings((-1.0, 1.0, 0)), swings((-3.0, 3.0, 1)), np.ones(1)).tolist() == [False]
    failed = swings((np.nan, np.nan, 0))
    failed.outcome[:] = Outcome.PULLED_IN
    assert jumped(swings((-1.0, 1.0, 1)), failed, np.ones(1)).tolist() == [False]


def test_what_was_met_is_sorted_by_frequency_for_each_member():
    trail = Trail()
    trail.add(np.array([0, 1]), np.array([2.0, 5.0]), swings((-1.0, 1.0, 1), (-2.0, 2.0, 3)), 2)
    trail.add(np.array([1]), np.array([4.0]), swings((-3.0, 3.0, 2)), 2)
    trail.add(np.array([0]), np.array([1.0]), swings((-4.0, 4.0, 5)), 2)
    frequency, amplitude, period, final = trail.sorted()
    np.testing.assert_array_equal(frequency, [[1.0, 2.0, np.nan], [4.0, 5.0, np.nan]])
    np.testing.assert_array_equal(amplitude, [[4.0, 1.0, np.nan], [3.0, 2.0, np.nan]])
    assert period.tolist() == [[5, 1, 0], [2, 3, 0]]
    np.testing.assert_array_equal(final[:, 0], [[0.0, 1.0], [0.0, 1.0]])
    assert final.shape == (2, 3, 2)


def test_a_walk_reaches_each_frequency_and_reports_all_of_it():
    """Alike up and down where nothing jumps: the linear amplitude of a stiff spring."""
    model = ConeModel(
        film="taut", spring_stiffness=[8.0, 9.0], rest_height=0.4, voltage=0.05, voltage_bias=0.3, damping_ratio=0.2
    ).members()
    up = np.tile([1.0, 2.0, 2.5], (2, 1))
    told: list[float] = []
    start = model.start_states((0.3, 0.0))
    found, back = (walk(model, grid, start, told.append, {}) for grid in (up, up[:, ::-1]))
    assert sum(told) == pytest.approx(2.0)
    assert (found.reached.outcome == Outcome.OK).all()
    assert (found.reached.period == 1).all()
    np.testing.assert_allclose(found.reached.amplitude, back.reached.amplitude[:, ::-1], rtol=1e-6)
    assert np.isnan(found.falls.start).all()
    frequency, *_ = found.trail.sorted()
    for k in range(2):
        assert set(up[k]) <= set(frequency[k])


# --- made-up motions --------------------------------------------------------------------------------------------------

FOLD = 1.5312
"""The frequency at which a large motion ends; each step near it leaves its shrinking basin early."""


@pytest.fixture
def world(monkeypatch):
    """A small motion at all frequencies and a large one up to the fold, from states above a half; runs near 0.7 fail.
    What was settled is listed as (frequency, state)."""
    settled = []

    def of(large, omegas):
        found = Swing.blank(omegas.size, states=2)
        found.highest[:] = np.where(large, 1.0 + 0.1 * omegas, 0.2)
        found.lowest[:], found.period[:] = -found.highest, np.where(large, 2, 1)
        found.final[:] = np.column_stack([found.highest, omegas])
        found.outcome[:] = np.where(np.abs(omegas - 0.7) < 0.05, Outcome.PULLED_IN, Outcome.OK)
        found.final[found.outcome != Outcome.OK] = np.nan
        return found

    def settle(members, states, only_extent, **search):
        omegas = members.values["drive_frequency"]
        settled.extend(zip(omegas.tolist(), states[:, 0].tolist(), strict=True))
        return of((states[:, 0] > 0.5) & (omegas < FOLD - 0.01), omegas)

    def on_cycles(members, before, search):
        omegas = members.values["drive_frequency"]
        rows = np.flatnonzero((before.amplitude < 0.5) | (omegas <= FOLD))
        return rows, of(before.amplitude[rows] > 0.5, omegas[rows])

    monkeypatch.setattr(module, "settled_swing", settle)
    monkeypatch.setattr(module, "on_their_cycles", on_cycles)
    return settled


def members(count):
    return ConeModel(voltage=np.full(count, 0.3)).members()


def test_a_motion_is_followed_to_its_fold_and_its_fall_is_bracketed(world):
    """Members go at their own pace: one is large from the start, one small."""
    grid = np.tile([1.0, 1.3, 1.7, 2.0], (2, 1))
    found = walk(members(2), grid, np.array([[0.9, 0.0], [0.1, 0.0]]), None, {})
    np.testing.assert_allclose(found.reached.amplitude, [[1.1, 1.13, 0.2, 0.2], [0.2] * 4])
    np.testing.assert_allclose(found.reached.final[..., 1], grid)
    start, end = found.falls.start[0], found.falls.end[0]
    assert np.isnan(start[[0, 1, 3]]).all()
    assert start[2] <= FOLD <= end[2]
    assert end[2] - start[2] <= SURE * FINEST * 0.4 * (1.0 + 1e-9)
    before = found.falls.before.take((0, 2))
    assert float(before.amplitude) == pytest.approx(1.0 + 0.1 * start[2])
    assert np.isnan(found.falls.start[1]).all()
    frequency, amplitude, period, _ = found.trail.sorted()
    own = np.isfinite(frequency[0])
    assert (np.diff(frequency[0][own]) > 0.0).all()
    np.testing.assert_array_equal(amplitude[0][own] > 0.5, frequency[0][own] <= start[2])
    np.testing.assert_array_equal(period[0][own] == 2, frequency[0][own] <= start[2])


def test_after_a_motion_that_failed_the_next_begins_anew(world):
    found = walk(members(1), np.array([[0.5, 0.7, 0.9, 1.2]]), np.array([[0.8, 0.0]]), None, {})
    assert found.reached.outcome[0].tolist() == [Outcome.OK, Outcome.PULLED_IN, Outcome.OK, Outcome.OK]
    begun = [state for omega, state in world if omega == 0.9]
    assert begun[0] == 0.8
    onwards = [state for omega, state in world if omega == 1.2]
    assert onwards == [pytest.approx(1.09, abs=2 * NUDGE)]
    assert onwards[0] != 1.09  # each step is nudged


def test_motions_are_carried_and_continued_as_their_cycles_are(world):
    large, small = swings((-1.15, 1.15, 2)), swings((-0.2, 0.2, 1))
    large.final[:, 0], small.final[:, 0] = 1.15, 0.2
    ends = (
        members(1).replace(drive_frequency=np.array([FOLD - 0.005])),
        members(1).replace(drive_frequency=np.array([1.6])),
    )
    assert [float(module.carried(at, large, np.ones(1), {}).amplitude[0]) > 0.5 for at in ends] == [True, False]
    now, going = module.continued(ends[0], large, np.ones(1), {})
    assert (going.tolist(), float(now.amplitude[0]) > 1.0) == ([True], True)
    now, going = module.continued(ends[1], large, np.ones(1), {})
    assert going.tolist() == [False]
    assert float(now.amplitude[0]) == 1.15  # as it was
    now, going = module.continued(ends[1], small, np.ones(1), {})
    assert (going.tolist(), float(now.amplitude[0])) == ([True], pytest.approx(0.2))
    chaotic = swings((-1.15, 1.15, 0))
    chaotic.final[:, 0] = 1.15
    now, going = module.continued(ends[1], chaotic, np.ones(1), {})
    assert (going.tolist(), float(now.amplitude[0])) == ([True], pytest.approx(0.2))


# --- what is handed on ------------------------------------------------------------------------------------------------

SEARCH = {"transient": 11.0, "patience": 12.0, "tolerance": 2e-9, "threads": 5}
FLOW = {"tolerance": 2e-9, "threads": 5}


def test_cycles_are_sought_from_where_the_motions_were_and_those_that_attract_and_run_are_taken(monkeypatch):
    """Of four cycles the second does not attract, the third may, and the last ends."""
    before, swung = swings(*[(-1.0, 1.0, k) for k in (1, 2, 3, 1)]), swings((-0.5, 0.5, 1), (-0.25, 0.25, 1))
    swung.outcome[:] = Outcome.OK, Outcome.PULLED_IN
    cycles = SimpleNamespace(sign=np.array([-1, 1, 0, -1]), take=lambda rows: ("cycles", rows.tolist()))
    asked = record(monkeypatch, module, find_cycles=cycles, swing_of=swung)
    rows, found = module.on_their_cycles(members(4), before, SEARCH)
    assert rows.tolist() == [0]
    assert found.highest.tolist() == [0.5]
    (sought,), (taken,) = asked["find_cycles"], asked["swing_of"]
    np.testing.assert_array_equal(sought["states"], before.final)
    assert sought["period"].tolist() == [1, 2, 3, 1]
    assert taken["cycles"] == ("cycles", [0, 3])
    np.testing.assert_array_equal(taken["states"], before.final[[0, 3]])
    assert taken["only_extent"] is True
    for call in (sought, taken):
        assert {name: call[name] for name in FLOW} == FLOW
        assert not {"transient", "patience"} & call.keys()


def test_a_step_begins_on_the_motion_before_nudged_or_anew_and_searches_with_all_options(monkeypatch):
    before, tried = swings((-1.0, 1.0, 1), (-1.0, 1.0, 1)), swings((-1.0, 1.0, 1), (-1.0, 1.0, 1))
    asked = record(monkeypatch, module, settled_swing=tried)
    initial = np.array([[7.0, 8.0], [9.0, 10.0]])
    found, changed = module._tried(members(2), before, initial, np.array([False, True]), np.ones(2), SEARCH)
    assert found is tried
    assert changed.tolist() == [False, False]
    (call,) = asked["settled_swing"]
    np.testing.assert_allclose(call["states"], [[0.0 + NUDGE, 1.0], [9.0, 10.0]])
    assert {name: call[name] for name in SEARCH} == SEARCH
    assert call["only_extent"] is True
    chaotic = swings((-1.0, 1.0, 0), (-1.0, 1.0, 0))
    module.continued(members(2), chaotic, np.ones(2), SEARCH)
    (_, call) = asked["settled_swing"]
    np.testing.assert_array_equal(call["states"], chaotic.final)
    assert {name: call[name] for name in SEARCH} == SEARCH


def test_a_motion_that_failed_twice_begins_anew_each_time(world):
    """Runs near 0.7 fail, at two frequencies in a row."""
    found = walk(members(1), np.array([[0.5, 0.68, 0.72, 0.9]]), np.array([[0.8, 0.0]]), None, {})
    assert found.reached.outcome[0].tolist() == [Outcome.OK, Outcome.PULLED_IN, Outcome.PULLED_IN, Outcome.OK]
    assert [state for omega, state in world if omega in (0.72, 0.9)] == [0.8, 0.8]


def test_a_jump_is_judged_by_the_largest_amplitude_that_the_walk_has_met(monkeypatch):
    """Of 3, 1 and 2, which a failure does not lessen."""
    amplitudes, asked = iter([3.0, 1.0, np.nan, 2.0]), []

    def tried(members, before, initial, fresh, largest, search):
        size = next(amplitudes)
        asked.append(float(largest[0]))
        found = swings((-size, size, 1))
        found.outcome[:] = Outcome.OK if np.isfinite(size) else Outcome.PULLED_IN
        return found, np.zeros(1, dtype=bool)

    monkeypatch.setattr(module, "_tried", tried)
    walk(members(1), np.array([[0.5, 0.6, 0.7, 0.8]]), np.array([[0.8, 0.0]]), None, {})
    assert asked == [0.0, 3.0, 3.0, 3.0]
