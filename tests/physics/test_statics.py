"""Balances and rests of ensembles: searched once for what is alike, for each as for it alone."""

import numpy as np
import pytest

from gelcone.errors import InputError
from gelcone.physics import statics
from gelcone.physics.bias import Bias
from gelcone.physics.model import ConeModel
from gelcone.physics.rests import single_rests
from gelcone.physics.statics import (
    balances_of,
    continuing,
    each,
    every_balance,
    rest_displacement,
    rest_displacements,
    stable_near,
    switched_off,
)  # fmt: skip
from gelcone.quantity import Quantity
from tests.toys import CubicBias

MODEL = ConeModel(
    rest_height=[0.5, 0.2, 0.5, 0.2],
    voltage=[0.1, 0.2, 0.3, 0.4],
    spring_stiffness=0.7,
    drive_frequency=[0.1, 0.2, 0.3, 0.4],
)


def test_members_of_equal_films_and_bias_share_a_balance_and_each_has_its_own_rest(monkeypatch):
    found = every_balance(MODEL)
    assert found[0] is found[2]
    assert found[1] is found[3]
    assert found[0] is not found[1]
    statics._rests.clear()
    searched = []
    monkeypatch.setattr(
        statics, "single_rests", lambda members, chosen: searched.extend(chosen) or single_rests(members, chosen)
    )
    rests = rest_displacements(MODEL)
    assert sorted(searched) == [0, 1]
    for k in range(4):
        alone = rest_displacement(MODEL.take([k]))
        assert rests[k] == alone
        force, slope = (
            MODEL.take([k])
            .members()
            .system.static_force(np.array([alone]), np.zeros(1), MODEL.take([k]).members().own_numbers)
        )
        assert abs(force[0]) < 1e-12
        assert slope[0] > 0.0
    searched.clear()
    rest_displacements(MODEL)
    assert not searched


def test_a_rest_under_the_hand_continues_the_last_one_and_is_not_stored():
    statics._rests.clear()
    places = {}
    with continuing(places) as guessed:
        first = rest_displacements(ConeModel(rest_height=0.5))
        assert not guessed
        second = rest_displacements(ConeModel(rest_height=0.51))
        assert list(guessed.values()) == [second]
        assert not guessed.keys() & statics._rests.keys()
        far = rest_displacements(ConeModel(rest_height=1.5))
        assert len(guessed) == 1
    assert list(places.values()) == [far]
    assert second == pytest.approx(rest_displacements(ConeModel(rest_height=0.51)), rel=1e-10)
    assert 0.0 < first < second < far


def test_what_is_the_same_is_computed_once():
    computed, one, other = [], object(), object()
    found = each(lambda balance, x: computed.append(x) or (balance, x), [one, other, one, one], [1.0, 1.0, 1.0, 2.0])
    assert found == [(one, 1.0), (other, 1.0), (one, 1.0), (one, 2.0)]
    assert computed == [1.0, 1.0, 2.0]


def test_a_double_cone_rests_without_voltage_on_either_film():
    pair = ConeModel(
        film="taut",
        second_film="taut",
        second_flat_height=0.6,
        second_drive="constant",
        second_voltage=0.8,
        voltage_bias=0.5,
    )
    off = switched_off(pair)
    assert (off.voltage_bias, off.second_voltage) == (0.0, 0.0)
    assert rest_displacement(pair) == rest_displacement(off)
    assert switched_off(MODEL) is MODEL


def test_an_ensemble_that_reaches_nothing_is_refused():
    beyond = ConeModel(stretch_limit=[0.1, 0.2], prestretch=1.8)
    with pytest.raises(InputError, match="stretch"):
        balances_of(beyond)
    assert np.isnan(rest_displacements(beyond)).all()


def test_stable_equilibria_are_found_near_and_not_beyond_an_unstable_place():
    """The force x^3 - x: wells at -1 and 1; at 0.5, where the stiffness is negative, Newton's method would go to -1."""
    x, stiffness = stable_near(np.array([0.7, -2.0, 0.5, 0.0, np.nan]), lambda x: (x**3 - x, 3.0 * x * x - 1.0))
    np.testing.assert_allclose(x, [1.0, -1.0, np.nan, np.nan, np.nan], rtol=1e-15)
    np.testing.assert_allclose(stiffness, [2.0, 2.0, np.nan, np.nan, np.nan], rtol=1e-12)


def test_no_rest_is_continued_from_an_unstable_one():
    """A film whose meridian is compressed: flat it is in balance, and unstable."""
    member = ConeModel(film="taut", meridional_prestretch=0.7, hoop_prestretch=1.0, spring_stiffness=0.05).members()
    rest = float(rest_displacements(member)[0])
    assert rest > 0.5
    for near in (0.0, 0.01, -0.02, np.nan, None):
        assert statics._continued(member, 0, near) is None
    assert statics._continued(member, 0, 0.95 * rest) == pytest.approx(rest, rel=1e-12)
    assert statics._continued(member, 0, rest - 1.5 * statics.FARTHEST_REST) is None


def test_double_cones_that_differ_in_their_second_film_alone_rest_elsewhere():
    second = {"second_hoop_prestretch": [1.1, 1.4, 1.1], "second_flat_height": [0.8, 0.8, 0.5]}
    pair = ConeModel(film="taut", second_film="taut", hoop_prestretch=1.2, spring_stiffness=0.4, **second)
    found = every_balance(pair)
    assert len({id(balance) for balance in found}) == 3
    rests = rest_displacements(pair)
    for k in range(3):
        own = {name: values[k] for name, values in second.items()}
        alone = ConeModel(film="taut", second_film="taut", hoop_prestretch=1.2, spring_stiffness=0.4, **own)
        assert rests[k] == pytest.approx(rest_displacement(alone), rel=1e-12)
    assert np.unique(rests).size == 3


def test_under_the_hand_the_last_member_is_continued():
    statics._rests.clear()
    places = {}
    with continuing(places):
        rests = rest_displacements(ConeModel(rest_height=[0.4, 0.9]))
    assert rests[0] != rests[1]
    assert list(places.values()) == [rests[1]]


class Exponential(Bias):
    """F = exp(20 x) - exp(20 xr): Newton's method comes down to xr by steps of 1/20."""

    name = "exponential"
    parameters = {"free_place": Quantity("xr", "where it does not pull", 0.0)}

    def force(self, x, y, n, xp=np):
        rising = xp.exp(20.0 * x)
        return rising - xp.exp(20.0 * n["free_place"]), 20.0 * rising

    def odd(self, n):
        return False

    def free_height(self, n):
        return n["free_place"]


def test_a_rest_far_from_the_last_one_is_searched_for_however_short_the_steps_to_it():
    statics._rests.clear()
    model = ConeModel(bias=Exponential())
    with continuing({}) as guessed:
        first = rest_displacements(model.replace(free_place=0.6))
        near = rest_displacements(model.replace(free_place=0.53))
        assert list(guessed.values()) == [near]
        far = rest_displacements(model.replace(free_place=0.2))
        assert list(guessed.values()) == [near]
    assert first - near == pytest.approx(0.07, abs=0.001)
    assert far == pytest.approx(0.2, abs=0.002)


def test_balances_of_films_in_opposite_phase_take_the_share_of_the_voltage_that_is_the_bias():
    """With all of it the second film has the first's voltage, with half of it none."""
    pair = ConeModel(film="taut", second_film="taut", second_drive="opposite", voltage_bias=0.2)
    for share, second in ((None, 0.4 - 0.9), (0.5, 0.0), (1.0, 0.9)):
        (balance,) = every_balance(pair, share)
        assert balance.system.squares_at_rest(0.81, balance.n)[1] == pytest.approx(second**2, rel=1e-14, abs=1e-30)


def test_no_more_rests_are_held_than_there_is_room_for(monkeypatch):
    monkeypatch.setattr(statics, "MOST_RESTS", 5)
    statics._rests.clear()
    system = ConeModel().system
    for k in range(20):
        statics.store_rests({(system, bytes([k])): float(k)})
        assert len(statics._rests) <= 6
        assert statics.stored_rests([(system, bytes([k])), (system, b"other")]) == {(system, bytes([k])): float(k)}


def test_a_hand_within_a_hand_leaves_the_outer_ones_rests_as_they_were():
    statics._rests.clear()
    outer = {}
    with continuing(outer):
        first = rest_displacements(ConeModel(rest_height=0.5))
        with continuing({}):
            rest_displacements(ConeModel(rest_height=0.6))
        assert list(outer.values()) == [first]
        last = rest_displacements(ConeModel(rest_height=0.52))
        assert list(outer.values()) == [last]
    rest_displacements(ConeModel(rest_height=0.7))
    assert list(outer.values()) == [last]


def test_a_refused_ensemble_says_what_its_first_member_needs():
    with pytest.raises(InputError, match=r"stretch_limit = 0\.3: "):
        balances_of(ConeModel(stretch_limit=[0.3, 0.1, 0.2], prestretch=1.8))


def test_biases_of_equal_numbers_have_rests_of_their_own():
    """A spring that is free at 0.6, and a cubic bias whose cubic stiffness is 0.6."""
    statics._rests.clear()
    spring = ConeModel(spring_stiffness=0.9, rest_height=0.6)
    cubic = ConeModel(bias=CubicBias(), bias_stiffness=0.9, bias_cubic=0.6)
    assert rest_displacements(spring) > 0.1
    assert rest_displacements(cubic) == 0.0


def test_rests_have_the_shape_of_the_ensemble():
    model = ConeModel(rest_height=[[0.2], [0.5]], spring_stiffness=[0.5, 1.0, 2.0])
    rests = rest_displacements(model)
    assert rests.shape == (2, 3)
    for place in np.ndindex(2, 3):
        own = ConeModel(rest_height=[0.2, 0.5][place[0]], spring_stiffness=[0.5, 1.0, 2.0][place[1]])
        assert rests[place] == pytest.approx(rest_displacement(own), rel=1e-12)
