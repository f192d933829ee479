"""What claims read off studies, on cases worked by hand."""

import numpy as np
import pytest

from gelcone.paper.reading import chaotic, finite_positive, first_chaos, fixed_branch, positive, share, share_number
from tests.paper.made_up import cells, diagram

VALUES = [1.0, 2.0, 3.0, 4.0, 5.0]


def test_chaos_is_the_regime_and_not_the_exponent():
    study = cells({"voltage": VALUES}, [0, 1, 0, 0, 1], exponent=np.ones(5))
    assert chaotic(study).tolist() == [False, True, False, False, True]


@pytest.mark.parametrize(
    ("exponent", "error", "certain"),
    [(0.031, 0.01, True), (0.029, 0.01, False), (-0.5, 0.01, False), (0.031, 0.02, False)],
)
def test_an_exponent_is_positive_by_three_standard_errors(exponent, error, certain):
    study = cells({"voltage": [1.0]}, [False], exponent=[exponent], error=error)
    assert positive(study).tolist() == [certain]


def test_over_a_window_whatever_is_above_zero_is_positive():
    study = cells({"voltage": [1.0, 2.0, 3.0]}, [0, 0, 0], finite=[1e-9, 0.0, -1e-9])
    assert finite_positive(study).tolist() == [True, False, False]


def test_the_branch_from_the_fixed_state_is_read():
    assert str(fixed_branch(diagram("voltage", VALUES, [0, 0, 0, 1, 1]))["branch"].values) == "from 1,0"


def test_shares():
    assert share([True, False, False, False]) == 0.25
    assert np.isnan(share([]))


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
    number = share_number("share", np.arange(of) < count)
    assert number.value == count / of
    assert (number.low, number.high) == pytest.approx((low, high), abs=1e-4)


def test_no_chaos_is_no_threshold():
    assert first_chaos(diagram("voltage", VALUES, np.zeros(5)), "voltage") is None


@pytest.mark.parametrize(
    ("falling", "low", "high", "which"), [(False, 2.0, 3.0, "smallest"), (True, 4.0, 5.0, "largest")]
)
def test_a_threshold_lies_between_the_edge_of_chaos_and_its_neighbour_outside(falling, low, high, which):
    number = first_chaos(diagram("stretch_limit", VALUES, [0, 0, 1, 1, 0]), "stretch_limit", falling=falling)
    assert (number.value, number.low, number.high) == (0.5 * (low + high), low, high)
    assert number.meaning == f"{which} stretch limit with chaos"


@pytest.mark.parametrize(("chaos", "falling", "edge"), [([1, 0, 0, 0, 0], False, 1.0), ([0, 0, 0, 0, 1], True, 5.0)])
def test_chaos_up_to_the_end_of_the_range_is_no_interval(chaos, falling, edge):
    number = first_chaos(diagram("voltage", VALUES, chaos), "voltage", falling=falling)
    assert (number.value, number.error, number.low) == (edge, 0.0, None)
    assert number.meaning == "chaos at the end of the range, voltage"


def test_bisection_narrows_the_interval_down_where_it_is_that_of_the_same_branch_and_edge():
    there = [("up", 2.1, 2.2), ("from 1,0", 3.4, 3.5), ("from 1,0", 2.4, 2.5), ("from 1,0", 2.6, 2.7)]
    number = first_chaos(diagram("voltage", VALUES, [0, 0, 1, 1, 1], thresholds=there), "voltage")
    assert (number.value, number.low, number.high) == (pytest.approx(2.45), 2.4, 2.5)
