"""Searches for attractors: budgets, returns, and where motions go."""

import numpy as np
import pytest

from gelcone import frequency
from gelcone.codes import Regime
from gelcone.motion.attractor import search as module
from gelcone.motion.attractor.search import (
    LONGEST_PERIOD,
    WINDOW,
    Starts,
    cycles_reached,
    default_transient,
    follow,
    patience_of,
    period_of,
    search,
)
from gelcone.motion.flow import integrate
from gelcone.motion.regime import regime
from gelcone.motion.settled import settled
from gelcone.motion.start import start_states
from gelcone.motion.swing import settled_swing
from gelcone.physics.model import ConeModel
from gelcone.presets import find_preset
from tests.toys import FilteredVoltage

MIRRORED = {"spring_stiffness": 0.5, "damping_ratio": 0.05, "drive_frequency": 0.3}


# --- budgets ----------------------------------------------------------------------------------------------------------


def test_transients_last_decay_times_periods_and_a_least_time():
    model = ConeModel(damping_ratio=[0.05, 0.0, 1.0, 0.5], drive_frequency=[1.0, 1.0, 1.0, 0.05]).members()
    np.testing.assert_allclose(default_transient(model), [400.0, 5000.0, 200.0, 30.0 * np.pi / 0.05])
    np.testing.assert_allclose(patience_of(model, None), [1e5, 1e5, 1e5, 1e5])


def test_a_slow_state_of_a_component_is_waited_for():
    """A filter of time constant 800 charges to a constant voltage; the 400 time units of the damping are too few."""
    slow = ConeModel(
        circuit=FilteredVoltage(), filter_time=800.0, voltage=0.0, voltage_bias=0.5, rest_height=0.5, damping_ratio=0.05
    )
    members = slow.members()
    assert default_transient(members).tolist() == [20.0 * 800.0]
    assert patience_of(members.replace(filter_time=1e5), None).tolist() == [5.0 * 20.0 * 1e5]
    both = search(members, members.start_states((0.5, 0.0)), patience=1.0)
    assert both.cycles.attracting.tolist() == [True]
    ideal = ConeModel(voltage=0.0, voltage_bias=0.5, rest_height=0.5, damping_ratio=0.05).members()
    rest = search(ideal, np.array([[0.5, 0.0]])).cycles.point[0]
    np.testing.assert_allclose(both.cycles.point[0], [*rest, 0.5], atol=1e-12)


# --- returns ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("repeats", [1, 2, 7, 40, LONGEST_PERIOD])
def test_every_period_up_to_the_longest_is_recognised(repeats):
    rng = np.random.default_rng(repeats)
    cycle = rng.normal(size=(repeats, 4))
    series = cycle[np.arange(WINDOW) % repeats][None]
    noise = rng.normal(size=series.shape)
    periods, gaps = period_of(np.concatenate([series, series + 1e-6 * noise, series + 1e-2 * noise]))
    assert periods.tolist() == [repeats, repeats, 0]
    assert gaps[0] == 0.0
    assert 0.0 < gaps[1] < 1e-4 < gaps[2]


def test_one_point_that_returns_is_no_period():
    series = np.random.default_rng(2).normal(size=(1, WINDOW, 4))
    series[0, -1] = series[0, -6]
    assert period_of(series)[0].tolist() == [0]


def test_a_run_says_since_when_a_motion_is_on_its_cycle():
    """A start on the cycle is there at once; one from far arrives, later with less damping."""
    model = ConeModel(**MIRRORED | {"damping_ratio": [0.05, 0.1]}, voltage=0.8).members()
    repeats = np.full(2, 300)
    far, _ = follow(model, np.tile([1.0, 0.0], (2, 1)), repeats)
    there, _ = follow(model, far.final, repeats)
    assert (far.period > 0).all()
    assert there.away.tolist() == [0.0, 0.0]
    assert far.away[0] > far.away[1] > 0.0
    for name in ("lowest", "highest"):  # those of the cycle, without the way to it
        np.testing.assert_allclose(getattr(far, name), getattr(there, name), atol=1e-3)
    assert np.abs(far.highest).max() < 0.999


def test_members_of_a_run_do_not_depend_on_their_blocks(monkeypatch):
    model = ConeModel(**MIRRORED | {"voltage": np.linspace(0.3, 1.0, 6)}).members()
    states, repeats = np.tile([1.0, 0.0], (6, 1)), np.array([30, 30, 200, 200, 400, 400])
    together, apart = follow(model, states, repeats, abreast=2)
    monkeypatch.setattr(module, "BLOCK_SAMPLES", 1)
    split, apart_split = follow(model, states, repeats, abreast=2)
    for name, values in vars(together).items():
        np.testing.assert_array_equal(values, getattr(split, name), name)
    np.testing.assert_array_equal(apart, apart_split)


def test_the_cycle_that_a_motion_is_on_has_an_exact_point():
    model = ConeModel(**MIRRORED, voltage=0.8).members()
    settled, _ = follow(model, np.array([[1.0, 0.0]]), np.array([400]), tolerance=1e-6)
    found = cycles_reached(model, settled.final)
    again, _ = follow(model, found.point, np.array([2]))
    assert found.attracting.tolist() == [True]
    np.testing.assert_allclose(again.final, found.point, atol=1e-12)


# --- searches ---------------------------------------------------------------------------------------------------------


def test_a_motion_that_has_not_arrived_is_followed_for_as_long_as_before_again_and_again(monkeypatch):
    """Chaos, of which a start nearby comes apart, for 32 transients, or for as long as asked."""
    chaos = ConeModel(spring_stiffness=0.9, damping_ratio=0.1, drive_frequency=1.5, voltage=2.5).members()
    followed = []

    def watched(members, states, repeats, **options):
        followed.append(float((repeats * members.forcing_period)[0]))
        return follow(members, states, repeats, **options)

    monkeypatch.setattr(module, "follow", watched)
    found = search(chaos, np.array([[1.0, 0.0]]))
    assert (found.cycles.found.tolist(), np.isfinite(found.starts.apart).tolist()) == ([False], [True])
    np.testing.assert_allclose(followed, [200.0, 200.0, 400.0, 800.0, 1600.0, 3200.0], atol=4.0)
    followed.clear()
    search(chaos, np.array([[1.0, 0.0]]), patience=700.0)
    np.testing.assert_allclose(followed, [200.0, 200.0, 300.0], atol=4.0)


@pytest.mark.parametrize("first", [(), (30.0,), (20.0, 30.0)])
def test_times_count_from_the_start_however_often_a_motion_is_advanced(first):
    """Chaos, whose starts separate after 30 time units, and a motion that is on its cycle some time after."""
    members = ConeModel(
        damping_ratio=[0.1, 0.3], spring_stiffness=0.9, drive_frequency=1.5, voltage=[2.5, 0.5]
    ).members()
    starts, period = Starts.at(np.tile([1.0, 0.0], (2, 1)), 2), members.forcing_period[0]
    for until in (*first, 200.0):
        starts.advance(members, np.arange(2), slice(0, 2), np.full(2, until), compared=True)
        np.testing.assert_allclose(starts.followed, np.ceil(until / period) * period)
    np.testing.assert_allclose(starts.apart, [16.0 * period, np.inf])
    np.testing.assert_allclose(starts.ended, [[np.inf] * 2, [18.0 * period] * 2])
    np.testing.assert_array_equal(starts.escaped, [[False] * 2, [True] * 2])
    assert starts.period.tolist() == [[0, 0], [1, 1]]
    before = starts.state.copy()
    starts.advance(members, np.arange(2), slice(1, 2), np.full(2, 300.0))  # the second start, where it has not ended
    moved = (starts.state != before).any(axis=2)
    assert moved.tolist() == [[False, True], [False, False]]
    assert (starts.followed > 250.0).tolist() == moved.tolist()


def test_a_motion_that_has_arrived_is_followed_no_further():
    model = ConeModel(**MIRRORED | {"damping_ratio": [0.05, 0.1]}, voltage=0.8).members()
    shares = []
    far = search(model, np.tile([1.0, 0.0], (2, 1)))
    assert far.cycles.attracting.all()
    there = search(model, far.cycles.point, progress=shares.append)
    whole_periods = np.ceil(default_transient(model) / model.forcing_period - 1e-4) * model.forcing_period
    np.testing.assert_allclose(there.starts.followed[:, 0], whole_periods)
    assert (far.starts.followed[:, 0] >= whole_periods).all()
    assert sum(shares) == pytest.approx(1.0)


# --- one question, one answer -----------------------------------------------------------------------------------------


def test_settled_regime_and_frequency_agree_on_the_period_of_random_models():
    """But where chaos ends: the regime is then that of most of 16 starts, and a single one may end elsewhere."""
    rng, count = np.random.default_rng(2), 200
    biased = np.arange(count) % 2
    model = ConeModel(
        damping_ratio=rng.uniform(0.05, 0.4, count),
        spring_stiffness=rng.uniform(0.1, 1.5, count),
        drive_frequency=np.exp(rng.uniform(np.log(0.3), np.log(3.0), count)),
        voltage=rng.uniform(0.1, 2.5, count),
        voltage_bias=biased * rng.uniform(-0.6, 0.6, count),
        rest_height=biased * rng.uniform(0.0, 0.5, count),
    )
    named = regime(model, patience=5000.0, budget=2000.0)
    kinds, periods = named["regime"].values, named["period"].values
    assert set(kinds) >= {Regime.REST, Regime.PERIODIC, Regime.CHAOTIC}
    assert len(set(periods[kinds == Regime.PERIODIC])) > 4
    lasting = kinds != Regime.TRANSIENT_CHAOS
    assert lasting.mean() > 0.95
    found = settled_swing(model.members(), start_states(model, (1.0, 0.0)), patience=5000.0)
    np.testing.assert_array_equal(found.forcing_periods[lasting], periods[lasting])
    np.testing.assert_array_equal(found.resting[lasting], kinds[lasting] == Regime.REST)
    repeating = np.flatnonzero(kinds == Regime.PERIODIC)
    again = regime(model.take(repeating), found.final[repeating], patience=5000.0, budget=2000.0)
    for name in ("lowest", "highest"):
        np.testing.assert_allclose(getattr(found, name)[repeating], again[name], rtol=0.0, atol=1e-7)
    some = np.flatnonzero(lasting & (kinds != Regime.CHAOTIC))[::20]
    swept = model.take(some).replace(drive_frequency=1.0)
    frequencies = model.drive_frequency[some, None] * [1.0, 1.0001]
    response = frequency(swept, frequencies, patience=5000.0)
    np.testing.assert_array_equal(response["period"].sel(branch="up").isel(step=0), periods[some])


def test_a_cycle_whose_deviations_alternate_slowly_is_not_doubled():
    """Short of a doubling the multiplier is near -1: every second point is closer than every one, and yet the period
    is 1. The motion's own point is mapped onto itself by one forcing period."""
    base = find_preset("base").model
    model = base.replace(voltage=np.append(np.linspace(0.94, 1.0276, 24), 1.0000784))
    result, named = settled(model), regime(model)
    np.testing.assert_array_equal(result["period"], named["period"])
    assert int(result["period"][-1]) == 1
    # a cycle and its doublings, in their order
    assert set(result["period"].values) >= {1, 2, 4}
    assert (np.diff(result["period"][:-1]) >= 0).all()
    members = model.take([24]).members()
    point = settled_swing(members, np.array([[1.0, 0.0]])).final
    after = integrate(members, point, members.forcing_period[:, None]).states[:, 0]
    np.testing.assert_allclose(after, point, atol=1e-9)
    swept = frequency(base.replace(voltage=1.0000784), [0.0999, 0.1, 0.1001])
    assert (swept["period"] == 1).all()
