"""Wilson's interval of a share: its defining equation, and how often it holds the true share; intervals over draws."""

import numpy as np
import pytest
from scipy.stats import binom, binomtest

from gelcone.statistics import share_interval, spread, wilson


@pytest.mark.parametrize(("successes", "count"), [(0, 16), (3, 16), (16, 16), (40, 100), (1, 1)])
def test_both_ends_lie_1_96_standard_errors_of_their_own_from_the_share(successes, count):
    """(p - q)^2 = z^2 q (1 - q)/n at each end q."""
    share = successes / count
    for end in wilson(share, count):
        if 0.0 < end < 1.0:
            assert (share - end) ** 2 == pytest.approx(1.959964**2 * end * (1.0 - end) / count, rel=1e-5)


def test_both_intervals_hold_the_share_itself():
    """Also where all or none were seen, and rounding would leave 1 or 0 outside."""
    for count in range(1, 300):
        hits = np.arange(count + 1)
        for z in (1.0, 1.959964, 2.5, 3.0):
            low, high = wilson(hits / count, count, z)
            assert ((low <= hits / count) & (hits / count <= high)).all()
        low, high = share_interval(hits, count)
        assert ((low <= hits / count) & (hits / count <= high)).all()


def test_it_holds_the_true_share_about_as_often_as_it_says():
    seen = np.arange(41)
    low, high = wilson(seen / 40, 40)
    truths = np.linspace(0.05, 0.95, 91)
    held = [binom.pmf(seen, 40, p)[(low <= p) & (p <= high)].sum() for p in truths]
    assert np.mean(held) == pytest.approx(0.95, abs=0.01)
    assert min(held) > 0.89


@pytest.mark.parametrize("confidence", [0.8, 0.95])
def test_the_exact_interval_holds_every_true_share_at_least_as_often_as_it_says(confidence):
    seen = np.arange(13)
    low, high = share_interval(seen, 12, confidence)
    for hits in seen:
        exact = binomtest(int(hits), 12).proportion_ci(confidence, method="exact")
        assert (low[hits], high[hits]) == pytest.approx((exact.low, exact.high), abs=1e-12)
    for p in np.linspace(0.02, 0.98, 25):
        assert binom.pmf(seen, 12, p)[(low <= p) & (p <= high)].sum() >= confidence
    assert share_interval(0, 0) == (0.0, 1.0)


def test_without_trials_nothing_is_known():
    assert wilson(np.nan, 0) == (0.0, 1.0)
    low, high = wilson([0.5, 0.5], [0, 4])
    assert (low[0], high[0]) == (0.0, 1.0)
    assert 0.0 < low[1] < 0.5 < high[1] < 1.0


def test_95_percent_of_the_draws_lie_between_the_ends_of_their_interval():
    np.testing.assert_allclose(spread(np.arange(201.0)), [5.0, 100.0, 195.0])
    np.testing.assert_allclose(spread(np.arange(201.0)[:, None] * [1.0, -1.0]), [[5, -195], [100, -100], [195, -5]])


def test_draws_without_a_value_are_left_out_and_infinite_ones_are_the_largest():
    values = np.concatenate([np.arange(41.0), np.full(3, np.nan)])
    np.testing.assert_allclose(spread(values), [1.0, 20.0, 39.0])
    values[38:41] = np.inf
    np.testing.assert_allclose(spread(values), [1.0, 20.0, np.inf])
    assert spread([np.inf, np.inf, np.inf]).tolist() == [np.inf] * 3


def test_where_most_draws_have_no_value_no_interval_is_stated():
    """Three quarters, half and a quarter of the draws have a value."""
    values = np.array([[1.0, 1.0, 1.0], [1.0, 1.0, np.nan], [1.0, np.nan, np.nan], [np.nan, np.nan, np.nan]])
    np.testing.assert_array_equal(spread(values), np.broadcast_to([1.0, 1.0, np.nan], (3, 3)))
    assert np.isnan(spread([np.nan, np.nan])).all()
    assert spread(np.zeros((4, 2, 5))).shape == (3, 2, 5)
