"""Lifetimes of chaos from starts nearby, on made-up ends."""

import numpy as np
import pytest
from scipy.stats import poisson

from gelcone.codes import Outcome, Regime
from gelcone.motion.attractor.lifetime import SETTLING, STARTS, Nearby, chaos_of, lifetimes
from gelcone.motion.attractor.search import NEARBY

# --- lifetimes --------------------------------------------------------------------------------------------------------


def test_the_interval_of_a_lifetime_holds_the_true_one_as_often_as_it_says():
    """16 exponential lifetimes of mean 1, censored early and late: 95 % of the intervals hold 1, at least 93 %."""
    rng = np.random.default_rng(3)
    for horizon in (0.05, 0.5, 5.0):
        times = rng.exponential(size=(4000, STARTS))
        mean, low, high = lifetimes((times < horizon).sum(axis=1), np.minimum(times, horizon).sum(axis=1))
        held = (low <= 1.0) & (high >= 1.0)
        assert 0.93 < held.mean() <= 1.0
        ended = np.isfinite(mean)
        assert (low[ended] < mean[ended]).all()
        assert (mean[ended] < high[ended]).all()


def test_of_chaos_that_never_ended_only_the_least_lifetime_is_known():
    mean, low, high = lifetimes(np.array([0]), np.array([2e5]))
    assert (mean[0], high[0]) == (np.inf, np.inf)
    # exp(-T/L) = 2.5 %
    assert low[0] == pytest.approx(2e5 / np.log(40.0))


def test_the_ends_of_a_lifetime_are_those_of_a_poisson_number():
    """At the upper end 3 or more have ended with a chance of 2.5 %, at the lower end 3 or fewer."""
    _, low, high = lifetimes(np.array([3]), np.array([10.0]))
    assert poisson.sf(2, 10.0 / high[0]) == pytest.approx(0.025)
    assert poisson.cdf(3, 10.0 / low[0]) == pytest.approx(0.025)


# --- nearby starts ----------------------------------------------------------------------------------------------------


def made_up(ended, followed):
    """Starts of one member that ended at some times (infinite: not yet)."""
    nearby = Nearby.at(np.zeros((1, 2)), STARTS)
    nearby.ended[0], nearby.followed[0] = ended, followed
    nearby.period[0] = np.isfinite(nearby.ended[0])
    nearby.lowest[0], nearby.highest[0] = -1.0, 1.0
    return nearby


def test_starts_lie_around_the_motions_own():
    nearby = Nearby.at(np.array([[1.0, -2.0, 0.3]]), STARTS)
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
    several = Nearby.at(np.zeros((4000, 2)), STARTS)
    several.followed[:] = 1000.0
    several.ended[:] = np.where(ends + 200.0 < 1000.0, ends + 100.0, np.inf)
    mean, low, high = lifetimes(several.escaped.sum(axis=1), several.times(np.full(4000, 100.0)).sum(axis=1))
    assert np.median(mean) == pytest.approx(300.0, rel=0.05)
    assert ((low <= 300.0) & (high >= 300.0)).mean() > 0.93


def test_starts_that_failed_are_counted_neither_as_chaotic_nor_as_ended():
    """Of 16 starts 4 left the domain, 3 ended on a cycle, and 9 are still chaotic: 9 of 12."""
    nearby = made_up(np.where(np.arange(STARTS) < 3, 500.0, np.inf), 1000.0)
    nearby.outcome[0, -4:] = Outcome.NOT_FINITE
    found = chaos_of(nearby, np.array([0]), np.array([0.1]), np.array([False]))
    assert found["followed"].tolist() == [12]
    assert found["share_chaotic"].tolist() == [0.75]
    assert found["fate_regime"].tolist() == [[Regime.CHAOTIC, Regime.PERIODIC, -1]]
    assert found["fate_share"].tolist() == [[0.75, 0.25, 0.0]]
    assert found["chaotic_until"].tolist() == [500.0]
    lasting = chaos_of(made_up(np.full(STARTS, np.inf), 1000.0), np.array([0]), np.array([0.1]), np.array([False]))
    assert lasting["chaotic_until"].tolist() == [1000.0]


def test_starts_that_may_have_been_settling_all_the_time_are_no_evidence_of_chaos():
    """Next to a doubling motions settle so slowly that those which have not returned say nothing: of a periodic motion
    they are not counted; of a chaotic one they are all there is."""
    nearby, rate = made_up(np.where(np.arange(STARTS) < 10, 500.0, np.inf), 1000.0), np.array([SETTLING / 600.0])
    found = chaos_of(nearby, np.array([0]), rate, np.array([False]))
    assert (found["followed"].tolist(), found["share_chaotic"].tolist()) == ([10], [0.0])
    assert found["fate_regime"].tolist() == [[Regime.PERIODIC, -1, -1]]
    assert found["fate_share"].tolist() == [[1.0, 0.0, 0.0]]
    assert all(np.isnan(found[name]).all() for name in ("lifetime", "lifetime_low", "lifetime_high"))
    chaotic = chaos_of(nearby, np.array([0]), rate, np.array([True]))
    assert (chaotic["followed"].tolist(), chaotic["share_chaotic"].tolist()) == ([16], [6 / 16])
