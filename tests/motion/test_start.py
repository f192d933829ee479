"""Initial states: those that are given, those that are not, and refusals."""

from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.errors import InputError
from gelcone.motion.start import complete, nudge, start_states
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


def test_what_is_not_given_follows_from_what_is_given_of_each_member():
    """Of four states two or three; a third that is given stays."""

    def starts(given):
        return np.column_stack([given, 10.0 * given[:, 0], 100.0 * given[:, 1]])

    members = SimpleNamespace(system=SimpleNamespace(states=range(4)), start_states=starts)
    given = np.array([[0.3, 0.1], [0.6, 0.2]])
    np.testing.assert_allclose(complete(members, given), [[0.3, 0.1, 3.0, 10.0], [0.6, 0.2, 6.0, 20.0]])
    three = np.column_stack([given, [7.0, 8.0]])
    np.testing.assert_allclose(complete(members, three), [[0.3, 0.1, 7.0, 10.0], [0.6, 0.2, 8.0, 20.0]])
    whole = starts(given)
    assert complete(members, whole) is whole


def test_one_member_that_can_start_is_enough():
    model = ConeModel(stretch_limit=[1e-3, 50.0])
    assert start_states(model, (0.3, 0.0)).tolist() == [[0.3, 0.0]] * 2
    with pytest.raises(InputError, match="stretch_limit"):
        start_states(model.replace(stretch_limit=1e-3), (0.3, 0.0))


def test_one_member_whose_branch_can_start_is_enough():
    """The branch of the first may be stretched less than the disc stretches it; the second is beyond its own limit."""
    model = ConeModel(film="wrinkling", viscous_modulus_1=0.5, relaxation_time_1=10.0, viscous_limit_1=[0.01, 50.0])
    assert start_states(model, (0.8, 0.0)).tolist() == [[0.8, 0.0, 1.0, 1.0]] * 2
    for changes in ({"viscous_limit_1": [0.01, 0.02]}, {"stretch_limit": [50.0, 1e-3]}):
        with pytest.raises(InputError, match=r"^initial displacement 0\.8: stretches a Maxwell branch beyond"):
            start_states(model.replace(**changes), (0.8, 0.0))
    assert start_states(model.replace(viscous_limit_1=0.01), (0.01, 0.0))[0].tolist() == [0.01, 0.0, 1.0, 1.0]


@pytest.mark.parametrize(
    ("initial", "message"),
    [
        ([[0.1, 0.0], [np.nan, 0.5]], r"^initial = \[nan, 0\.5\]: must be finite$"),
        ([0.1, -np.inf], r"^initial = \[0\.1, -inf\]: must be finite$"),
        ([[0.1, 0.0]] * 3, r"velocity, shape \(2,\) or shape \(2, 2\)$"),
        ("high", r"^initial = 'high': must be a displacement and a velocity, shape"),
    ],
)
def test_other_starts_of_two_members_are_refused(initial, message):
    with pytest.raises(InputError, match=message):
        start_states(ConeModel(voltage=[0.1, 0.2]), initial)
