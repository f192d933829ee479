"""What claims read off studies, on cases worked by hand."""

import numpy as np
import pytest

from gelcone.codes import Regime
from gelcone.motion.attractor.search import PATIENCE
from gelcone.paper.reading import (
    about_six,
    all_of,
    any_of,
    chaotic,
    finite_not_positive,
    finite_positive,
    first_chaos,
    fixed_branch,
    largest_in,
    nearly_all_of,
    not_positive,
    positive,
    regular,
    slack_of,
    without_chaos,
)
from tests.paper.made_up import CHAOTIC, PERIODIC, REST, cells, diagram, triple

VALUES = [1.0, 2.0, 3.0, 4.0, 5.0]


def test_chaos_is_the_regime_and_not_the_exponent():
    study = cells({"voltage": VALUES}, [0, 1, 0, 0, 1], exponent=np.ones(5))
    assert chaotic(study).tolist() == [0, 1, 0, 0, 1]
    assert regular(study).tolist() == [1, 0, 1, 1, 0]


def test_a_motion_that_has_not_settled_is_neither_chaotic_nor_regular():
    study = cells({"voltage": [1.0, 2.0]}, [0, 0], kinds=[Regime.TRANSIENT, PERIODIC])
    np.testing.assert_equal(chaotic(study), [np.nan, 0.0])
    np.testing.assert_equal(regular(study), [np.nan, 1.0])


def test_chaos_that_may_outlast_the_patience_is_open_and_other_that_ends_is_none():
    """Whether an end is seen of chaos whose mean lifetime may be longer than the patience is chance."""
    study = cells({"voltage": [1.0, 2.0]}, [0, 0], kinds=[Regime.TRANSIENT_CHAOS] * 2)
    study = study.assign(lifetime_high=("voltage", [2.0 * PATIENCE, 0.5 * PATIENCE]))
    np.testing.assert_equal(chaotic(study), [np.nan, 0.0])


def test_where_nearby_starts_do_not_agree_nothing_is_said():
    study = cells({"voltage": VALUES}, [1, 1, 1, 0, 0], share_chaotic=[1.0, 15 / 16, np.nan, 1 / 16, 0.0])
    np.testing.assert_equal(chaotic(study), [1.0, np.nan, 1.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("exponent", "error", "kind", "certain"),
    [
        (0.031, 0.01, CHAOTIC, 1.0),
        (0.029, 0.01, CHAOTIC, np.nan),
        (0.029, 0.01, Regime.TRANSIENT, np.nan),
        (0.029, 0.01, PERIODIC, 0.0),
        (0.029, 0.01, REST, 0.0),
        (-0.5, 0.01, Regime.TRANSIENT, 0.0),
        (0.031, 0.02, CHAOTIC, np.nan),
    ],
)
def test_an_exponent_is_positive_by_three_standard_errors(exponent, error, kind, certain):
    """Within three of zero it is not positive where the motion is known to be regular, and open elsewhere."""
    study = cells({"voltage": [1.0]}, [False], exponent=[exponent], error=error, kinds=[int(kind)])
    np.testing.assert_equal(positive(study), [certain])


def test_the_time_that_the_film_is_slack_is_that_of_chaos():
    (one, other) = slack_of(triple("voltage"), "voltage")
    assert (one.value, other.value) == (0.8, 0.7)
    assert one.meaning == "share of the time that the film is slack in the chaos at voltage 2"


def test_over_a_window_whatever_is_above_zero_is_positive():
    study = cells({"voltage": [1.0, 2.0, 3.0]}, [0, 0, 0], finite=[1e-9, 0.0, -1e-9])
    assert finite_positive(study).tolist() == [1.0, 0.0, 0.0]


def test_over_a_window_what_regular_motions_reach_is_not_positive():
    """log(T)/T of a window of 100: 0.046."""
    study = cells({"voltage": [1.0, 2.0, 3.0]}, [0, 0, 0], finite=[0.045, 0.047, np.nan]).assign_attrs(window=100.0)
    assert finite_positive(study).tolist() == [0.0, 1.0, 0.0]
    np.testing.assert_equal(finite_not_positive(study), [1.0, 0.0, np.nan])


def test_a_run_that_ended_is_no_motion_of_any_kind():
    """False where a claim promises motion, open where it denies a kind of motion."""
    study = cells({"voltage": [1.0, 2.0]}, [0, 0], kinds=[Regime.LEFT_THE_DOMAIN, PERIODIC], exponent=[np.nan, -0.1])
    for read, truths in (
        (chaotic, [0.0, 0.0]),
        (positive, [0.0, 0.0]),
        (regular, [0.0, 1.0]),
        (without_chaos, [np.nan, 1.0]),
        (not_positive, [np.nan, 1.0]),
    ):
        np.testing.assert_equal(read(study), truths)


NAN = np.nan


@pytest.mark.parametrize(
    ("row", "some", "every", "nearly"),
    [
        ([1] * 10, 1, 1, 1),
        ([1] * 9 + [0], 1, 0, 1),
        ([1] * 8 + [0] * 2, 1, 0, 0),
        ([1] * 8 + [0, NAN], 1, 0, NAN),
        ([1] * 9 + [NAN], 1, NAN, 1),
        ([0] * 9 + [NAN], NAN, 0, 0),
        ([0] * 10, 0, 0, 0),
    ],
)
def test_rows_are_judged_at_their_places(row, some, every, nearly):
    rows = np.array([row], dtype=float)
    np.testing.assert_equal([any_of(rows)[0], all_of(rows)[0], nearly_all_of(rows)[0]], [some, every, nearly])


@pytest.mark.parametrize(("largest", "holds"), [(5.49, 0.0), (5.5, 1.0), (6.49, 1.0), (6.5, 0.0), (NAN, 0.0)])
def test_about_six_is_what_rounds_to_it(largest, holds):
    chaos = np.array([[1.0, 0.0]]) if largest == largest else np.zeros((1, 2))
    extent = np.array([[largest, 9.0]])
    assert about_six(largest_in(chaos, extent), chaos).tolist() == [holds]
    unsettled = np.array([[NAN, 0.0]])
    np.testing.assert_equal(about_six(largest_in(unsettled, extent), unsettled), [NAN])


def test_the_branch_from_the_fixed_state_is_read():
    assert str(fixed_branch(diagram("voltage", VALUES, [0, 0, 0, 1, 1]))["branch"].values) == "from 1,0"


def test_no_chaos_is_no_threshold():
    assert first_chaos(diagram("voltage", VALUES, np.zeros(5)), "voltage") is None


@pytest.mark.parametrize(
    ("falling", "low", "high", "which"), [(False, 2.0, 3.0, "smallest"), (True, 4.0, 5.0, "largest")]
)
def test_a_threshold_lies_between_the_edge_of_chaos_and_its_neighbour_outside(falling, low, high, which):
    number = first_chaos(diagram("stretch_limit", VALUES, [0, 0, 1, 1, 0]), "stretch_limit", falling=falling)
    assert (number.value, number.low, number.high) == (low if falling else high, low, high)
    assert number.meaning == f"{which} stretch limit at which chaos was seen"


@pytest.mark.parametrize(("chaos", "falling", "edge"), [([1, 0, 0, 0, 0], False, 1.0), ([0, 0, 0, 0, 1], True, 5.0)])
def test_chaos_up_to_the_end_of_the_range_is_no_interval(chaos, falling, edge):
    number = first_chaos(diagram("voltage", VALUES, chaos), "voltage", falling=falling)
    assert (number.value, number.error, number.low) == (edge, None, None)
    assert number.meaning == "chaos at the end of the range, voltage"


def test_bisection_narrows_the_interval_down_where_it_is_that_of_the_same_branch_and_edge():
    there = [("up", 2.1, 2.2), ("from 1,0", 3.4, 3.5), ("from 1,0", 2.4, 2.5), ("from 1,0", 2.6, 2.7)]
    number = first_chaos(diagram("voltage", VALUES, [0, 0, 1, 1, 1], thresholds=there), "voltage")
    assert (number.value, number.low, number.high) == (2.5, 2.4, 2.5)


@pytest.mark.parametrize(("third", "low", "high"), [(Regime.TRANSIENT, 2.0, 4.0), (PERIODIC, 3.4, 3.5)])
def test_a_threshold_next_to_an_open_value_is_not_narrowed_by_that_of_another_change(third, low, high):
    """Bisection found where the motion changes, from open to chaotic too; what is open may be chaos already."""
    kinds = [PERIODIC, PERIODIC, third, CHAOTIC, CHAOTIC]
    study = diagram("voltage", VALUES, [0, 0, 0, 1, 1], kinds=kinds, thresholds=[("from 1,0", 3.4, 3.5)])
    number = first_chaos(study, "voltage")
    assert (number.low, number.high) == (low, high)


def test_the_sign_of_the_largest_exponent_has_its_own_error():
    """Not that of the second one."""
    study = cells({"voltage": [1.0, 2.0]}, [True, True], exponent=[0.1, -0.1], error=0.01)
    study["standard_error"][:, 1] = 9.0
    assert positive(study).tolist() == [1.0, 0.0]
    study["standard_error"][:] = [[9.0, 0.01]] * 2
    np.testing.assert_equal(positive(study), [np.nan, np.nan])
