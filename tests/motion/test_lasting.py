"""Lifetimes, nearby starts, and where motions go: on made-up lifetimes, made-up sections and known motions."""

import numpy as np
import pytest

from gelcone.motion import course as module
from gelcone.motion.course import LONGEST_PERIOD, WINDOW, course, cycles_reached, period_of
from gelcone.motion.lasting import NEARBY, STARTS, Nearby, lifetimes
from gelcone.physics.model import ConeModel

MIRRORED = {"spring_stiffness": 0.5, "damping_ratio": 0.05, "drive_frequency": 0.3}


# --- lifetimes --------------------------------------------------------------------------------------------------------


def test_the_interval_of_a_lifetime_holds_the_true_one_as_often_as_it_says():
    """16 exponential lifetimes of mean 1, censored early and late: 95 % of the intervals hold 1, at least 93 %."""
    rng = np.random.default_rng(3)
    for horizon in (0.05, 0.5, 5.0):
        times = rng.exponential(size=(4000, STARTS))
        found = lifetimes((times < horizon).sum(axis=1), np.minimum(times, horizon).sum(axis=1))
        held = (found.low <= 1.0) & (found.high >= 1.0)
        assert 0.93 < held.mean() <= 1.0
        ended = np.isfinite(found.mean)
        assert (found.low[ended] < found.mean[ended]).all()
        assert (found.mean[ended] < found.high[ended]).all()


def test_of_chaos_that_never_ended_only_the_least_lifetime_is_known():
    found = lifetimes(np.array([0]), np.array([2e5]))
    assert (found.mean[0], found.high[0]) == (np.inf, np.inf)
    # exp(-T/L) = 2.5 %
    assert found.low[0] == pytest.approx(2e5 / np.log(40.0))


# --- nearby starts ----------------------------------------------------------------------------------------------------


def made_up(ended, followed):
    """Starts of one member that ended at some times (infinite: not yet)."""
    nearby = Nearby.at(np.zeros((1, 2)))
    nearby.ended[0], nearby.followed[0] = ended, followed
    nearby.period[0] = np.isfinite(nearby.ended[0])
    nearby.lowest[0], nearby.highest[0] = -1.0, 1.0
    return nearby


def test_starts_lie_around_the_motions_own():
    nearby = Nearby.at(np.array([[1.0, -2.0, 0.3]]))
    apart = nearby.state[0] - np.array([1.0, -2.0, 0.3])
    assert (apart[0] == 0.0).all()
    np.testing.assert_allclose(np.hypot(apart[1:, 0], apart[1:, 1]), NEARBY, rtol=1e-5)
    assert (apart[:, 2] == 0.0).all()
    assert len({tuple(row) for row in apart.tolist()}) == STARTS


def test_chaos_that_persists_beside_an_attractor_is_told_from_chaos_that_ends():
    early = np.where(np.arange(STARTS) < 6, 300.0, np.inf)
    steady = np.where(np.arange(STARTS) < 8, 900.0 * np.arange(STARTS), np.inf)
    for ended, persists in ((early, True), (steady, False), (np.full(STARTS, np.inf), False)):
        assert made_up(ended, 8000.0).persists().tolist() == [persists]


def test_starts_that_end_on_the_same_cycle_are_one_fate():
    nearby = made_up(np.where(np.arange(STARTS) < 9, 100.0, np.inf), 1000.0)
    nearby.period[0, :3] = 2
    nearby.highest[0, 8] = 1.5
    assert [fate.tolist() for fate in nearby.fates(0)] == [[3, 4, 5, 6, 7], [0, 1, 2], [8]]


def test_time_counts_from_when_chaos_had_pulled_the_starts_apart():
    nearby = made_up(np.where(np.arange(STARTS) < 2, 500.0, np.inf), 1000.0)
    nearby.apart[0] = 200.0
    assert nearby.times()[0].tolist() == [300.0] * 2 + [800.0] * (STARTS - 2)


def test_time_to_settle_is_no_chaos_and_hides_ends_that_are_too_late_to_be_seen():
    """Starts that need 100 to come near a cycle, and as long again to be seen to return."""
    nearby = made_up(np.where(np.arange(STARTS) < 2, 500.0, np.inf), 1000.0)
    assert nearby.times(100.0)[0].tolist() == [400.0] * 2 + [800.0] * (STARTS - 2)
    rng = np.random.default_rng(4)
    ends = rng.exponential(300.0, (4000, STARTS))
    several = Nearby.at(np.zeros((4000, 2)))
    several.followed[:] = 1000.0
    several.ended[:] = np.where(ends + 200.0 < 1000.0, ends + 100.0, np.inf)
    found = lifetimes(several.escaped.sum(axis=1), several.times(np.full(4000, 100.0)).sum(axis=1))
    assert np.median(found.mean) == pytest.approx(300.0, rel=0.05)
    assert ((found.low <= 300.0) & (found.high >= 300.0)).mean() > 0.93


# --- courses ----------------------------------------------------------------------------------------------------------


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


def test_a_course_says_since_when_a_motion_is_on_its_cycle():
    """A start on the cycle is there at once; one from far arrives, later with less damping."""
    model = ConeModel(**MIRRORED | {"damping_ratio": [0.05, 0.1]}, voltage=0.8).members()
    repeats = np.full(2, 300)
    far, _ = course(model, np.tile([1.0, 0.0], (2, 1)), repeats)
    there, _ = course(model, far.final, repeats)
    assert (far.period > 0).all()
    assert there.away.tolist() == [0.0, 0.0]
    assert far.away[0] > far.away[1] > 0.0


def test_members_of_a_course_do_not_depend_on_their_blocks(monkeypatch):
    model = ConeModel(**MIRRORED | {"voltage": np.linspace(0.3, 1.0, 6)}).members()
    states, repeats = np.tile([1.0, 0.0], (6, 1)), np.array([30, 30, 200, 200, 400, 400])
    together, apart = course(model, states, repeats, abreast=2)
    monkeypatch.setattr(module, "BLOCK_SAMPLES", 1)
    split, apart_split = course(model, states, repeats, abreast=2)
    for name, values in vars(together).items():
        np.testing.assert_array_equal(values, getattr(split, name), name)
    np.testing.assert_array_equal(apart, apart_split)


def test_the_cycle_that_a_motion_is_on_has_an_exact_point():
    model = ConeModel(**MIRRORED, voltage=0.8).members()
    settled, _ = course(model, np.array([[1.0, 0.0]]), np.array([400]), tolerance=1e-6)
    found = cycles_reached(model, settled.final)
    again, _ = course(model, found.point, np.array([2]))
    assert found.attracting.tolist() == [True]
    np.testing.assert_allclose(again.final, found.point, atol=1e-12)
