"""Voltages and starts of static analyses: those of the model, those that are given, and refusals."""

import json

import numpy as np
import pytest

import gelcone
from gelcone import ConeModel, InputError, Outcome
from gelcone.motion.static_results import constant_voltages, label_static, own_levels, padded, rests_near
from tests.motion.balances import Balance


@pytest.mark.parametrize(
    ("voltage", "bias", "levels"),
    [
        (0.3, 0.0, [0.3]), (0.3, 0.2, [0.2, 0.5]), (0.3, -0.2, [0.2, 0.5]), (0.0, -0.2, [0.2]),
        ([0.3, 0.5], [-0.25, 0.0], [0.25, 0.5, 0.55]),
    ],
)  # fmt: skip
def test_the_levels_of_a_model_are_its_peaks_and_its_offsets_of_either_sign(voltage, bias, levels):
    np.testing.assert_allclose(own_levels(ConeModel(voltage=voltage, voltage_bias=bias)), levels)


@pytest.mark.parametrize(("bias", "levels"), [(-0.3, [0.2]), (-0.6, [0.0]), (0.3, [0.3, 0.8])])
def test_a_half_wave_has_no_offset_below_0(bias, levels):
    model = ConeModel(waveform="half_wave", voltage=0.5, voltage_bias=bias)
    np.testing.assert_allclose(own_levels(model), levels)


@pytest.mark.parametrize(("bias", "levels"), [(0.1, [0.1, 0.6]), (-0.1, [0.1]), (-0.4, [0.4]), (0.0, [0.5])])
def test_films_in_opposite_phase_have_levels_of_the_sign_of_their_bias(bias, levels):
    """A staircase from 0 to 0.5 about a negative bias has no voltage of its sign beyond it."""
    pair = {"second_film": "taut", "second_drive": "opposite", "second_flat_height": 1.4}
    np.testing.assert_allclose(
        own_levels(ConeModel(**pair, waveform="staircase", voltage=0.5, voltage_bias=bias)), levels
    )


def test_voltages_that_are_given_stay_in_their_order():
    assert constant_voltages(0.5).tolist() == [0.5]
    assert constant_voltages([0.5, 0.0, 0.25]).tolist() == [0.5, 0.0, 0.25]


@pytest.mark.parametrize(
    ("voltages", "message"),
    [
        ([0.5, -0.25], "voltages = -0.25: must be at least 0; leave out the sign, on which no force depends"),
        ("1 kV", "voltages = '1 kV': must be a number or an array of numbers; write it without units"),
        (np.inf, "voltages = inf: must be finite"),
        ([[0.1, 0.2]], "voltages has the shape (1, 2): must be a number or one-dimensional; ravel it"),
    ],
)
def test_other_voltages_are_refused(voltages, message):
    with pytest.raises(InputError) as error:
        constant_voltages(voltages)
    assert str(error.value) == message


def test_each_member_starts_from_the_rest_near_the_displacement_that_is_given_for_it(balances):
    """The made-up balances rest at 0.5 and 1, and at where they are started from."""
    model, own = ConeModel(damping_ratio=[0.1, 0.2]), [Balance(1.0), Balance(2.0)]
    for start, rests in ((None, [0.5, 1.0]), (0.25, [0.25, 0.25]), ([0.25, -0.5], [0.25, -0.5])):
        assert rests_near(model, own, start) == rests


@pytest.mark.parametrize(
    ("start", "message"),
    [
        ([0.1, np.nan], "start = nan: must be finite"), (-np.inf, "start = -inf: must be finite"),
        ([0.1, 0.2, 0.3], "start = [0.1, 0.2, 0.3]: must be a displacement, or one a member (shape (2,))"),
        ("high", "start = 'high': must be a displacement, or one a member (shape (2,))"),
    ],
)  # fmt: skip
def test_other_starts_are_refused(start, message):
    with pytest.raises(InputError) as error:
        rests_near(ConeModel(damping_ratio=[0.1, 0.2]), [Balance(1.0), Balance(2.0)], start)
    assert str(error.value) == message


def test_a_result_states_its_options_and_which_members_reach_no_displacement():
    own = [Balance(1.0), Balance(2.0)]
    own[1].reachable = False
    variables = {"place": ((), np.array([1.0, np.nan]), "place of the disc", "length")}
    model = ConeModel(damping_ratio=[0.1, 0.2])
    for start, stated in ((None, None), (np.array([0.5, 0.25]), [0.5, 0.25]), (0.5, 0.5)):
        found = label_static(model, own, variables, start=start, title="places")
        assert found["outcome"].values.tolist() == [Outcome.OK, Outcome.OUTSIDE]
        assert json.loads(found.attrs["options"]) == {"search_range": 1000.0, "start": stated}
        assert found.attrs["title"] == "places"
    np.testing.assert_array_equal(found["place"], [1.0, np.nan])


@pytest.mark.parametrize(
    ("compute", "title"),
    [
        (gelcone.pitchfork_voltage, "pitchfork"), (gelcone.fold_voltages, "folds of the equilibria"),
        (gelcone.pull_in_voltage, "pull-in"), (gelcone.onset_voltage, "onset voltage of rest"),
        (gelcone.floquet_multipliers, "Floquet multipliers of rest"),
        (lambda model: gelcone.stroke_and_blocked_force(model, [0.2]), "stroke and blocked force"),
    ],
)  # fmt: skip
def test_the_title_of_a_result_without_a_figure_names_what_was_computed(compute, title):
    assert compute(ConeModel()).attrs["title"] == title


def test_rows_are_padded_to_the_longest_and_to_one_column():
    np.testing.assert_array_equal(padded([np.array([1.0]), np.array([2.0, 3.0])]), [[1.0, np.nan], [2.0, 3.0]])
    np.testing.assert_array_equal(padded([np.array([]), np.array([])]), [[np.nan], [np.nan]])
