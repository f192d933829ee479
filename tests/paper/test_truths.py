"""Truths that stay open, and shares with their intervals, on cases worked by hand."""

import numpy as np
import pytest
from scipy.stats import norm, qmc

from gelcone.paper.truths import Share, every, lengths, share, stratified, truth


def test_shares_count_what_holds_fails_and_is_open():
    assert share([True, False, None, True]) == Share(2, 1, 1)
    assert share(np.array([1.0, 0.0, np.nan, 1.0])) == Share(2, 1, 1)
    assert Share(2, 1, 1).value == pytest.approx(2.0 / 3.0)
    assert np.isnan(share([]).value)


@pytest.mark.parametrize(("count", "of"), [(8, 10), (0, 10), (10, 10), (50, 100)])
def test_a_share_has_its_wilson_interval(count, of):
    """Wilson (1927): at each end x the share lies z standard errors of x away; six looks share 5 %."""
    z = norm.ppf(1.0 - 0.05 / 12.0)
    number = Share(count, of - count).number("share")
    assert number.value == count / of
    for end, bound in ((number.low, 0.0), (number.high, 1.0)):
        at_bound = end == bound == count / of
        assert at_bound or (count / of - end) ** 2 == pytest.approx(z**2 * end * (1.0 - end) / of, rel=1e-9)
    assert number.low <= number.value <= number.high


def test_what_is_open_widens_the_interval_to_both_sides():
    low, high = Share(8, 2, open=10).interval
    assert low == Share(8, 12).interval[0]
    assert high == Share(18, 2).interval[1]
    assert Share(0, 0).interval == (0.0, 1.0)


@pytest.mark.parametrize(("edge", "count"), [(0.3, 32), (0.3, 128), (0.48, 128), (0.07, 64), (0.9, 64)])
def test_a_sharp_edge_in_strata_says_more_than_independent_draws_and_holds_the_truth(edge, count):
    for seed in range(40):
        at = qmc.Sobol(1, seed=seed).random(count)[:, 0]
        found = stratified(at, at < edge)
        low, high = found.interval
        assert low <= edge <= high
        alone_low, alone_high = Share(found.holding, found.failing).interval
        assert high - low <= alone_high - alone_low
    assert count < 128 or high - low < 0.7 * (alone_high - alone_low)


def test_a_sample_that_grows_until_it_is_certain_is_wrong_less_often_than_said():
    """Periodic windows of many widths, looked at after 16, 32, ... points: all looks hold in 95 of 100 or more."""
    rng = np.random.default_rng(5)
    held = 0
    for seed in range(200):
        edges = np.sort(rng.random(2 * int(rng.integers(1, 60))))
        truth = float((edges[1::2] - edges[::2]).sum())
        at = qmc.Sobol(1, seed=seed).random(512)[:, 0]
        holds = np.searchsorted(edges, at) % 2 == 1
        looks = [stratified(at[:count], holds[:count]).interval for count in (16, 32, 64, 128, 256, 512)]
        held += all(low <= truth <= high for low, high in looks)
    assert held >= 190


def test_strata_without_order_count_as_independent_draws():
    """Neighbours that differ by chance: no more is known than from as many draws."""
    at = np.linspace(0.0, 1.0, 64)
    holds = np.random.default_rng(1).random(64) < 0.5
    found = stratified(at, holds)
    assert found.interval == Share(found.holding, found.failing).interval
    assert found.apart == sum(a != b for a, b in zip(holds[::2], holds[1::2], strict=True))
    shuffled = np.random.default_rng(2).permutation(64)
    assert stratified(at[shuffled], holds[shuffled]) == found  # in any order


def test_lengths_between_edges_are_exact_and_edges_open():
    found = lengths(np.array([0.0, 1.0, 2.0, 4.0, 5.0]), [1, 1, 0, 0, np.nan])
    assert (found.holding, found.failing, found.open, found.sample) == (1.0, 2.0, 2.0, False)
    assert found.interval == pytest.approx((0.2, 0.6))


@pytest.mark.parametrize(
    ("one", "cut", "truth"),
    [
        (Share(18, 2), 0.5, True),
        (Share(2, 18), 0.5, False),
        (Share(12, 8), 0.5, None),
        (Share(12, 8, sample=False), 0.5, True),
        (Share(10, 10, sample=False), 0.5, False),
        (Share(10, 0, sample=False), 0.5, True),
        (Share(10, 0, open=11, sample=False), 0.5, None),
        (Share(0, 0), 0.5, None),
    ],
)
def test_a_share_exceeds_a_cut_when_its_whole_interval_does(one, cut, truth):
    assert one.exceeds(cut) is truth


def test_something_is_found_when_one_holds():
    assert Share(1, 9).found is True
    assert Share(0, 9, open=1).found is None
    assert Share(0, 9).found is False


def test_open_truths_decide_only_where_they_matter():
    assert every(True, None) is None
    assert every(False, None) is False
    assert every() is True
    assert [truth(value) for value in np.array([1.0, 0.0, np.nan])] == [True, False, None]
