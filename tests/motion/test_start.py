"""Initial states: those that are given, those that are not, and refusals."""

import numpy as np
import pytest

from gelcone.errors import InputError
from gelcone.motion.start import nudge, start_states
from gelcone.physics.model import ConeModel
from tests.toys import FilteredVoltage


def test_states_that_are_not_given_start_from_their_own_values():
    model = ConeModel(voltage=[0.1, 0.2], circuit=FilteredVoltage())
    begin = FilteredVoltage().states[0].start
    assert start_states(model, (0.3, 0.1)).tolist() == [[0.3, 0.1, begin]] * 2
    assert start_states(model, (0.3, 0.1, 0.9)).tolist() == [[0.3, 0.1, 0.9]] * 2
    each = start_states(model, [[0.3, 0.1], [0.2, 0.0]])
    assert each.tolist() == [[0.3, 0.1, begin], [0.2, 0.0, begin]]


def test_another_number_of_states_is_refused():
    message = r"a displacement and a velocity, or displacement, velocity, \w+, shape \(2,\) or shape \(3,\)"
    with pytest.raises(InputError, match=message):
        start_states(ConeModel(circuit=FilteredVoltage()), (1.0, 0.0, 0.0, 0.0))


def test_with_two_states_a_third_is_refused():
    with pytest.raises(InputError, match=r"must be a displacement and a velocity, shape \(2,\)"):
        start_states(ConeModel(), (1.0, 0.0, 0.0))


def test_a_nudge_moves_the_displacement_alone():
    assert nudge(np.array([[1.0, 2.0, 3.0]]), 0.25).tolist() == [[1.25, 2.0, 3.0]]
