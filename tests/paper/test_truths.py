"""Truths that stay open, and shares with their intervals, on cases worked by hand."""

import numpy as np
import pytest

from gelcone.paper.truths import Share, entries, every, share, some
from gelcone.statistics import wilson


def test_shares_count_what_holds_fails_and_is_open():
    assert share([True, False, None, True]) == Share(2, 1, 1)
    assert share(np.array([1.0, 0.0, np.nan, 1.0])) == Share(2, 1, 1)
    assert Share(2, 1, 1).value == pytest.approx(2.0 / 3.0)
    assert np.isnan(share([]).value)


@pytest.mark.parametrize(
    ("count", "of", "low", "high"),
    [
        (8, 10, 0.4902, 0.9433),  # Wilson (1927), by hand: (p + z^2/2n -+ z sqrt(p(1-p)/n + z^2/4n^2))/(1 + z^2/n)
        (0, 10, 0.0, 0.2775),
        (10, 10, 0.7225, 1.0),
        (50, 100, 0.4038, 0.5962),
    ],
)
def test_a_share_has_its_wilson_interval(count, of, low, high):
    number = Share(count, of - count).number("share")
    assert number.value == count / of
    assert (number.low, number.high) == pytest.approx((low, high), abs=1e-4)


def test_what_is_open_widens_the_interval_to_both_sides():
    low, high = Share(8, 2, open=10).interval
    assert low == pytest.approx(wilson(8 / 20, 20)[0])
    assert high == pytest.approx(wilson(18 / 20, 20)[1])
    assert Share(0, 0).interval == (0.0, 1.0)


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
    assert some(False, None) is None
    assert some(True, None) is True
    assert some() is False
    assert entries(np.array([1.0, 0.0, np.nan])) == [True, False, None]
