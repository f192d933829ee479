"""Clocks and settling: forcing periods, the fastest rate, runs over whole periods."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.codes import Outcome
from gelcone.errors import InputError
from gelcone.motion import settle as module
from gelcone.motion.flow import integrate
from gelcone.motion.settle import (
    LONGEST_TIME,
    blocks,
    check_budgets,
    check_forcing_periods,
    clocks,
    pieces,
    repeats_lasting,
    settle,
)
from gelcone.physics.model import ConeModel
from tests.recorded import numbers, record

PERIODIC = ConeModel(damping_ratio=0.1, spring_stiffness=1.0, voltage=0.8, drive_frequency=1.0, rest_height=0.3)


# --- periods and rates ------------------------------------------------------------------------------------------------


def test_a_bias_doubles_the_forcing_period():
    model = ConeModel(drive_frequency=[0.5, 0.5], voltage_bias=[0.0, 0.1])
    np.testing.assert_allclose(model.forcing_period, [2.0 * np.pi, 4.0 * np.pi])


@pytest.mark.parametrize(
    "parameters",
    [
        {"damping_ratio": 2.0, "voltage": 0.0},
        {"spring_stiffness": 40.0, "voltage": 0.0},
        {"hoop_prestretch": 2.0, "meridional_prestretch": 1.8, "stretch_limit": 5.0, "voltage": 0.0},
        {"voltage": 0.0, "voltage_bias": 3.0},
    ],
)
def test_no_small_motion_at_rest_is_faster_than_the_fastest_rate(parameters):
    """Against the eigenvalues of the motion linearised about the flat film."""
    model = ConeModel(**parameters)
    stiffness = float(model.stiffness(0.0, float(model.voltage_bias)))
    linear = np.array([[0.0, 1.0], [-stiffness, -2.0 * float(model.damping_ratio)]])
    assert np.abs(np.linalg.eigvals(linear)).max() <= model.members().rate[0]


def test_the_fastest_rate_is_finite_at_the_stretch_limit():
    flat_at_limit = ConeModel(stretch_limit=0.5, hoop_prestretch=1.5)
    assert np.isfinite(flat_at_limit.members().rate).all()


def test_members_that_are_sampled_alike_share_a_block_of_bounded_memory(monkeypatch):
    monkeypatch.setattr(module, "BLOCK_SAMPLES", 2 * module.CLOCK_SAMPLES)
    samples = np.array([16, 32, 16, 16, 32])
    found = [(key, rows.tolist()) for key, rows in blocks(samples, np.array([1, 1, 1, 2, 1]))]
    assert found == [((16, 1), [0, 2]), ((16, 2), [3]), ((32, 1), [1, 4])]


def test_clocks_follow_from_the_longest_stretch():
    model = ConeModel(damping_ratio=[0.05, 0.05], drive_frequency=[0.1, 3.0]).members()
    for stretch in (16.0, 64.0):
        for members, clock in clocks(model, stretch):
            assert (clock.spacing * model.rate[members] <= stretch * (1.0 + 1e-12)).all()


# --- settling ---------------------------------------------------------------------------------------------------------


def test_nothing_of_the_discarded_run_is_kept(monkeypatch):
    samples = []

    def watched(model, initial, times, **options):
        samples.append(np.shape(times)[-1])
        return integrate(model, initial, times, **options)

    monkeypatch.setattr(module, "integrate", watched)
    settle(PERIODIC, np.array([[1.0, 0.0]]), 2500)
    assert samples == [1, 1, 1]


def test_members_settle_each_for_its_own_repeats():
    """Also across returns of the clock; one that cannot run keeps its state, and so does one that has no time."""
    model = PERIODIC.replace(stretch_limit=[50.0, 50.0, 0.1, 50.0])
    states = np.tile([1.0, 0.0], (4, 1))
    count = np.array([1203, 7, 5, 0])
    settled, outcome = settle(model, states, count)
    assert outcome.tolist() == [0, 0, Outcome.OUTSIDE, 0]
    for i in (0, 1, 3):
        np.testing.assert_array_equal(settle(model.take([i]), states[[i]], int(count[i]))[0][0], settled[i])
    assert settled[3].tolist() == [1.0, 0.0]
    by_hand, _ = settle(model.take([0]), settle(model.take([0]), states[[0]], 1000)[0], 203)
    np.testing.assert_array_equal(by_hand[0], settled[0])


def test_repeats_last_at_least_the_duration():
    model = ConeModel(drive_frequency=[1.0, 2.0])
    assert repeats_lasting(model, 10.0).tolist() == [4, 7]


def test_pieces_join_where_the_clock_returns(monkeypatch):
    """A run in pieces of two periods is the run in one piece, and a member that fails keeps its first outcome."""
    monkeypatch.setattr(module, "CLOCK_REPEATS", 2)
    model = PERIODIC.replace(stretch_limit=[50.0, 0.1])
    states = np.tile([0.9, 0.0], (2, 1))
    found = list(pieces(model.members(), states, 5, [0.0, 0.25]))
    assert [(p.first, p.repeats) for p in found] == [(0, 2), (2, 2), (4, 1)]
    assert found[-1].outcome.tolist() == [Outcome.OK, Outcome.OUTSIDE]
    late = integrate(PERIODIC, (0.9, 0.0), [(4 + 0.25) * np.pi]).states[0, 0]
    np.testing.assert_allclose(found[-1].states[0, 1], late, atol=1e-12)


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf, 1.0001 * LONGEST_TIME])
def test_a_time_that_is_not_positive_or_too_long_is_refused_by_its_name(value):
    too_long = value > LONGEST_TIME
    problem = f"is longer than {LONGEST_TIME:g}; give a shorter" if too_long else "must be positive; give a longer"
    with pytest.raises(InputError, match=re.escape(f"patience = {value:g}: {problem} one")):
        check_budgets(transient=None, budget=1e-9, window=LONGEST_TIME, patience=value)
    check_budgets(transient=None, budget=1e-9, window=LONGEST_TIME)


def test_the_longest_run_ends_while_somebody_waits():
    """Films take 1e5 to 1e6 units of time in a second."""
    assert LONGEST_TIME / 1e5 < 24 * 3600.0


@pytest.mark.parametrize(
    ("frequency", "most"), [(1.0, int(1e9 / np.pi)), ([1e-3, 1.0], int(1e9 / np.pi)), (1e4, 10**9)]
)
def test_numbers_of_forcing_periods_that_last_too_long_for_all_members_are_refused(frequency, most):
    members = ConeModel(damping_ratio=0.1, drive_frequency=frequency).members()
    check_forcing_periods(members, discard=0)
    check_forcing_periods(members, 1, repeats=most, discard=1)
    with pytest.raises(InputError, match=re.escape(f"repeats = {most + 1}: must be at most {most} forcing periods")):
        check_forcing_periods(members, 1, repeats=most + 1)
    with pytest.raises(InputError, match=re.escape("repeats = 0: must be at least 1")):
        check_forcing_periods(members, 1, repeats=0)


@pytest.mark.parametrize(
    "run",
    [
        lambda model: gelcone.simulate(model, periods=1e9),
        lambda model: gelcone.simulate(model, times=[0.0, 2e9]),
        lambda model: gelcone.step(model, [0.1], duration=2e9),
        lambda model: gelcone.settled(model, transient=2e9),
        lambda model: gelcone.settled(model, patience=2e9),
        lambda model: gelcone.regime(model, budget=2e9),
        lambda model: gelcone.section(model, repeats=10**9),
        lambda model: gelcone.section(model, discard=10**9),
        lambda model: gelcone.extrema(model, discard=10**9),
        lambda model: gelcone.spectrum(model, discard=10**9),
        lambda model: gelcone.spectrum(model, periods=10**9),
        lambda model: gelcone.triptych(model, periods=10**9),
    ],
)
def test_runs_that_nobody_can_wait_for_are_refused_at_once(run):
    with pytest.raises(InputError, match=r"at most|is longer than 1e\+09; give a shorter one"):
        run(ConeModel(damping_ratio=0.1, film="taut"))


# --- what is handed on ------------------------------------------------------------------------------------------------


def test_pieces_run_with_the_options_from_where_the_one_before_ended_and_the_first_failure_counts(monkeypatch):
    """The second member has failed before, the third fails in the first piece and another way in the second."""
    monkeypatch.setattr(module, "CLOCK_REPEATS", 2)
    outcomes, shares = iter([[0, 5, 3], [4, 5, 5]]), []

    def ran(members, states, times, *, progress, **flow):
        progress(1.0)
        made = np.array(next(outcomes), dtype=np.int8)
        return SimpleNamespace(
            times=times, states=numbers(*times.shape, 2, at=10.0 * len(asked["integrate"])), outcome=made
        )

    asked = record(monkeypatch, module, integrate=ran)
    members, states = PERIODIC.replace(drive_frequency=[1.0, 2.0, 0.5]).members(), numbers(3, 2)
    before = np.array([0, 1, 0], dtype=np.int8)
    found = list(
        pieces(members, states, 3, [0.25, 0.5], outcome=before, progress=shares.append, tolerance=2e-9, threads=5)
    )
    first, second = asked["integrate"]
    np.testing.assert_array_equal(first["initial"], states)
    np.testing.assert_array_equal(second["initial"], numbers(3, 5, 2, at=10.0)[:, -1])
    period = np.pi / np.array([1.0, 2.0, 0.5])[:, None]
    np.testing.assert_allclose(first["times"], period * [0.25, 0.5, 1.25, 1.5, 2.0])
    np.testing.assert_allclose(second["times"], period * [0.25, 0.5, 1.0])
    for call in (first, second):
        assert (call["tolerance"], call["threads"]) == (2e-9, 5)
    assert [piece.outcome.tolist() for piece in found] == [[0, 1, 3], [4, 1, 3]]
    assert [(piece.first, piece.repeats) for piece in found] == [(0, 2), (2, 1)]
    assert shares == pytest.approx([2.0 / 3.0, 1.0 / 3.0])


def test_members_settle_with_the_options_by_shares_of_all_their_periods(monkeypatch):
    """No longer at a time than the clock goes, and as long as each has to."""
    monkeypatch.setattr(module, "CLOCK_REPEATS", 10)
    shares = []

    def ran(members, states, times, *, progress, **flow):
        progress(1.0)
        return SimpleNamespace(states=states[:, None] + 1.0, outcome=np.zeros(len(states), dtype=np.int8))

    asked = record(monkeypatch, module, integrate=ran)
    members, states = PERIODIC.replace(drive_frequency=[1.0, 2.0, 0.5]).members(), numbers(3, 2)
    found, outcome = settle(members, states, np.array([4, 16, 0]), progress=shares.append, tolerance=2e-9, threads=5)
    np.testing.assert_allclose(found, states + np.array([[1.0], [2.0], [0.0]]))
    assert outcome.tolist() == [0, 0, 0]
    first, second = asked["integrate"]
    np.testing.assert_allclose(first["times"], [[4.0 * np.pi], [10.0 * np.pi / 2.0]])
    np.testing.assert_allclose(second["times"], [[6.0 * np.pi / 2.0]])
    assert {(call["tolerance"], call["threads"]) for call in (first, second)} == {(2e-9, 5)}
    assert shares == pytest.approx([0.7, 0.3])


def test_a_stretch_is_a_part_of_a_long_period_or_several_short_ones_and_a_block_is_whole_periods():
    """Of three drives: slow, as fast as the disc and far faster; blocks last at least 64."""
    model = PERIODIC.replace(drive_frequency=[0.01, 1.0, 40.0]).members()
    for rows, clock in clocks(model, 16.0):
        for k, row in enumerate(rows):
            period = float(model.forcing_period[row])
            longest = 16.0 / float(model.fastest[row])
            spacing = float(clock.spacing[k])
            assert spacing <= longest * (1.0 + 1e-12)
            if period > longest:
                assert clock.per_repeat > 1
                assert spacing * clock.per_repeat == pytest.approx(period)
                assert spacing > 0.5 * longest  # the next power of two
            else:
                assert clock.per_repeat == 1
                assert spacing / period == pytest.approx(np.floor(longest / period))
            lasts = clock.block * spacing
            assert lasts >= module.BLOCK
            assert lasts / period == pytest.approx(round(lasts / period))
            unit = period * float(clock.repeats[k])
            assert lasts < module.BLOCK + unit * (1.0 + 1e-12)
