"""Rests of many actuators at once: those of the search of each alone."""

import math

import numpy as np
import pytest

from gelcone.physics import rests
from gelcone.physics.balance import rest_of, single_balance
from gelcone.physics.bias import Bias
from gelcone.physics.model import ConeModel
from gelcone.physics.rests import single_rests
from gelcone.quantity import Quantity
from tests.toys import PowerFilm

SPREAD = np.random.default_rng(5)
COUNT = rests.AT_ONCE + 3


def searched(model):
    """The rests of members, each searched alone."""
    members = model.members()
    balances = [single_balance(members.system, members.numbers_at(k)) for k in range(members.size)]
    return [rest_of(balance, None) if balance.reachable else math.nan for balance in balances]


def at_once(model):
    return single_rests(model.members(), np.arange(model.size))


def between(low, high):
    return SPREAD.uniform(low, high, COUNT)


@pytest.fixture
def alone(monkeypatch):
    """The balances that are searched one by one."""
    found = []
    monkeypatch.setattr(rests, "rest_of", lambda balance, near: found.append(balance) or rest_of(balance, near))
    return found


SPRINGS = {"rest_height": between(-0.5, 1.5), "spring_stiffness": between(0.1, 2.0), "hoop_prestretch": between(0.8, 2)}
TIGHT = {"rest_height": between(0.1, 1), "stretch_limit": between(0.2, 2), "meridional_prestretch": between(0.4, 1.4)}
BEAMS = {
    "bias": "spring+beam", "beam_stiffness": between(-4.0, -1.0), "beam_cubic": between(1.0, 8.0),
    "beam_height": between(0.05, 0.5), "rest_height": between(0.1, 1.0), "spring_stiffness": 0.1,
}  # fmt: skip


@pytest.mark.parametrize("numbers", [SPRINGS, TIGHT, BEAMS], ids=["springs", "tight", "beams"])
def test_rests_of_many_are_those_of_each_alone_to_the_rounding_of_the_force(numbers, alone):
    """Springs, films with few displacements or none within their stretch limit, and beams that snap."""
    model = ConeModel(film="taut", **numbers)
    found = at_once(model)
    assert not alone
    np.testing.assert_allclose(found, searched(model), rtol=1e-13)


def test_a_rest_does_not_depend_on_the_others_to_the_last_bit():
    members = ConeModel(film="taut", **SPRINGS).members()
    apart = [single_rests(members, np.array([k]))[0] for k in range(COUNT)]
    assert single_rests(members, np.arange(COUNT)) == apart


def test_wrinkling_films_rest_at_once(alone):
    model = ConeModel(film="wrinkling", rest_height=[0.1, 0.4, 0.9], meridional_prestretch=[0.8, 1.0, 1.3])
    found = at_once(model)
    assert not alone
    np.testing.assert_allclose(found, searched(model), rtol=1e-13)


def test_of_rests_that_mirror_each_other_that_above_counts(alone):
    """Flat these films are beyond their stretch limit, and a spring without a side of its own holds both rests."""
    model = ConeModel(
        film="taut", meridional_prestretch=[0.4, 0.5], rest_height=0.0, spring_stiffness=0.1, stretch_limit=1.0
    )
    found = at_once(model)
    assert not alone
    assert min(found) > 1.0
    np.testing.assert_allclose(found, searched(model), rtol=1e-13)


def test_a_flat_film_in_balance_is_searched_alone(alone):
    """It is a rest, and the force has no sign there."""
    model = ConeModel(rest_height=[0.0, 0.3], spring_stiffness=1.5)
    assert at_once(model) == pytest.approx(searched(model), rel=1e-13)
    assert len(alone) == 1


class Dip(Bias):
    """F = (x - 1/2)^2 - d^2 less the force of a power film, x^3: stable at 1/2 + d, which is close to 1/2 - d."""

    name = "dip"
    parameters = {"half_width": Quantity("d", "half the distance of its zeros", 0.1)}

    def force(self, x, y, n, xp=np):
        away = x - 0.5
        return away * away - n["half_width"] * n["half_width"] - x * x * x, 2.0 * away - 3.0 * x * x

    def odd(self, n):
        return False


class Cubic(PowerFilm):
    """F = (1 - V) x^3."""

    name = "cubic"

    def force(self, x, squared, y, n, xp=np):
        stiffness = 1.0 - squared
        return stiffness * x * x * x, 3.0 * stiffness * x * x


@pytest.mark.parametrize("half_width", [0.1, 1e-6])
def test_two_zeros_between_neighbouring_points_are_not_missed(half_width, alone):
    (found,) = at_once(ConeModel(film=Cubic(), bias=Dip(), half_width=[half_width]))
    assert found == pytest.approx(0.5 + half_width, abs=1e-4 * half_width)
    assert len(alone) == (half_width < 1e-3)


class NoState(Cubic):
    """Pulled in without a voltage above x = 1."""

    name = "no state"

    def highest_squared(self, x, n):
        return np.where(np.asarray(x) > 1.0, -1.0, 2.0)[()]


def test_no_film_rests_where_it_has_pulled_in():
    numbers = {"bias": "spring", "spring_stiffness": 1.0, "rest_height": [0.5, 5.0]}
    held, gone = at_once(ConeModel(film=NoState(), **numbers))
    assert held == pytest.approx(at_once(ConeModel(film=Cubic(), **numbers))[0], rel=1e-14)
    assert math.isnan(gone)
