"""The contract of a film: what a new one has without another line than its force."""

import numpy as np
import pytest

from gelcone.codes import Outcome
from gelcone.errors import InputError
from gelcone.physics.component import State
from gelcone.physics.film.film import Film
from gelcone.physics.model import ConeModel
from gelcone.physics.trace import Graph
from tests.toys import PowerFilm

X = np.array([-1.4, -0.3, 0.05, 0.6, 1.5])
N = {"film_modulus": 0.8}
FILM = PowerFilm(2.0)


def test_energies_of_a_power_law_by_hand():
    """F = c x ((1 + x^2)^2 - 1) - V x: work c (x^4/2 + x^6/6) - V x^2/2, area 1 + x^2."""
    for squared in (0.0, 0.7):
        work = 0.8 * (X**4 / 2.0 + X**6 / 6.0) - 0.5 * squared * X**2
        np.testing.assert_allclose(FILM.work(X, squared, [], N), work, rtol=1e-12, atol=1e-15)
        np.testing.assert_allclose(FILM.capacitance(X, squared, [], N), 1.0 + X**2, rtol=1e-13)
        np.testing.assert_allclose(FILM.voltage_gain(X, squared, N), X, rtol=1e-14)
        np.testing.assert_allclose(FILM.turning(X, squared, N), 0.8 * (4.0 * X**3 + 4.0 * X**5), rtol=1e-12)
        np.testing.assert_allclose(FILM.voltage_force(X, squared, [], N), squared * X, rtol=1e-13, atol=1e-15)


def test_the_balancing_voltage_by_hand():
    """V = c ((1 + x^2)^2 - 1) - pull, and its limit at the flat film."""
    for pull in (-1.0, 0.3):
        expected = 0.8 * ((1.0 + X**2) ** 2 - 1.0) - pull
        np.testing.assert_allclose(FILM.balancing(X, pull, N), expected, rtol=1e-12)
        assert FILM.balancing(0.0, pull, N) == pytest.approx(-pull, abs=1e-10)


def test_the_defaults_are_an_odd_film_without_limit_or_states():
    assert FILM.ending is Outcome.STRETCH_LIMIT
    assert FILM.odd(N)
    assert FILM.states == ()
    assert FILM.rates(0.1, 0.2, 0.3, [], N) == []
    assert FILM.reach(N) == (0.0, np.inf)
    assert FILM.strain_limit(N) == np.inf
    np.testing.assert_array_equal(FILM.strain(X, N), X**2)
    np.testing.assert_array_equal(FILM.highest_squared(X, N), np.full(5, np.inf))
    assert FILM.highest_squared(0.0, N) == np.inf
    assert FILM.describe() == ""
    assert "start lower" in FILM.outside(2.0, N)
    assert "change its parameters" in FILM.unreachable(N)
    assert FILM.stiffness_scale(N) == 0.0
    assert not FILM.limit_share(X, 0.3, [], N).any()


def test_the_state_of_a_film_that_does_not_know_it_is_not_a_number():
    state = FILM.state(np.zeros((4, 3)), np.zeros(3), [], N)
    assert all(np.isnan(value).all() and value.shape == (4, 3) for value in state[:-1])
    assert state.kind == -1


def test_a_film_without_a_force_cannot_be_made():
    class Unfinished(Film):
        name = "unfinished"

    with pytest.raises(TypeError, match="force"):
        Unfinished()


def test_statics_through_the_model():
    model = ConeModel(film=FILM, spring_stiffness=0.9, rest_height=0.2, film_modulus=[0.8, 1.6])
    x = np.array([0.5, 0.5])
    expected = np.array([0.8, 1.6]) * 0.5 * (1.25**2 - 1.0) - 0.36 * 0.5 + 0.9 * 0.3
    np.testing.assert_allclose(model.force(x, 0.6), expected, rtol=1e-13)
    h = 1e-5
    np.testing.assert_allclose(model.force(x), (model.energy(x + h) - model.energy(x - h)) / (2.0 * h), rtol=1e-8)
    assert model.law is None
    assert model.prestretch_mode is None
    assert model.stretches == (1.0, 1.0)


class Curved(Film):
    """F = c x^3 - V x/(1 + V) + V^2 x^5/4: not linear in V."""

    name = "curved"

    def force(self, x, squared, y, n, xp=np):
        weaker, stiffer = squared / (1.0 + squared), 0.25 * squared * squared
        force = n["c"] * (x * x * x) - weaker * x + stiffer * (x * x * x * x * x)
        return force, 3.0 * n["c"] * (x * x) - weaker + 5.0 * stiffer * (x * x * x * x)


def test_what_follows_from_a_force_that_is_not_linear_in_the_squared_voltage():
    """Turning, gain and area by hand at a voltage; no state above none, and none beyond a limit."""
    film, n = Curved(), {"c": 1.7}
    for V in (0.0, 0.6):
        np.testing.assert_allclose(film.turning(X, V, n), 3.4 * X**3 + V**2 * X**5, rtol=1e-12)
        gain = X / (1.0 + V) ** 2 - 0.5 * V * X**5
        np.testing.assert_allclose(film.voltage_gain(X, V, n), gain, rtol=1e-12, atol=1e-15)
        area = 1.0 + X**2 / (1.0 + V) ** 2 - V * X**6 / 6.0
        np.testing.assert_allclose(film.capacitance(X, V, [], n), area, rtol=1e-12)
        work = 1.7 * X**4 / 4.0 - 0.5 * V / (1.0 + V) * X**2 + V**2 * X**6 / 24.0
        np.testing.assert_allclose(film.work(X, V, [], n), work, rtol=1e-12, atol=1e-15)
        taken = V / (1.0 + V) * X - 0.25 * V**2 * X**5
        np.testing.assert_allclose(film.voltage_force(X, V, [], n), taken, rtol=1e-12, atol=1e-15)
        v, rate, u = V**0.5, 0.4, 0.7  # d(v area)/dt
        by_v = area + 2.0 * V * (-2.0 * X**2 / (1.0 + V) ** 3 - X**6 / 6.0)
        current = film.current(X, u, v, rate, n)
        by_x = 2.0 * X / (1.0 + V) ** 2 - V * X**5
        np.testing.assert_allclose(current, by_v * rate + v * by_x * u, rtol=1e-6, atol=1e-9)


class Worn(Curved):
    """A film with a state of its own, and a limit of its strain."""

    name = "worn"
    states = (State("wear", "its state", "share"),)

    def strain_limit(self, n):
        return np.asarray(4.0)

    def highest_squared(self, x, n):
        return 2.0 + 0.0 * x


def test_what_a_film_with_states_does_not_know_is_not_a_number():
    film, n = Worn(), {"c": 1.7}
    assert np.isnan(film.current(X, 0.3, 0.4, 0.5, n)).all()
    assert np.isfinite(Curved().current(X, 0.3, 0.4, 0.5, n)).all()
    assert np.isnan(film.work(X, 0.3, [0.5], n)).all()
    assert np.isfinite(film.work(X, 0.3, [], n)).all()
    np.testing.assert_allclose(film.limit_share(X, 0.3, [0.5], n), X**2 / 4.0)
    assert film.overstretched(X, [0.5], n).tolist() == [False] * 5
    np.testing.assert_array_equal(film.highest_squared_held(X, [0.5], n), [2.0] * 5)
    assert (film.drags, film.dissipates, film.traced_charge, film.folds) == (False, False, False, False)
    assert (film.drag(X, n) == 0.0).all()
    assert film.times_of_kinds(["a"], np.ones((3, 2))).shape == (3, 0)
    with pytest.raises(InputError, match="film 'worn': its charge is not known while a motion is computed"):
        film.capacitance(X, 0.3, [0.5], n, Graph())


class Stepped(Film):
    """F = c x - V x below V = 1 and F = c x - (3 V - 2) x above, up to V = 2; programs know the side by a switch."""

    name = "stepped"

    def force(self, x, squared, y, n, xp=np):
        if xp is np:
            taken = np.where(squared > 2.0, np.nan, np.where(squared > 1.0, 3.0 * squared - 2.0, squared))
        else:
            low = 0.5 + 0.5 * n["low"]
            taken = low * squared + (1.0 - low) * (3.0 * squared - 2.0)
        return (n["c"] - taken) * x, n["c"] - taken + 0.0 * x

    def switches(self, x, squared, y, n):
        return {"low": np.where(np.asarray(squared) > 1.0, -1.0, 1.0)}


def test_the_voltage_weakens_a_film_as_on_its_side_of_a_border_and_a_film_that_is_gone_by_nothing_known():
    film, n = Stepped(), {"c": -0.7, "low": 1.0}
    squared = np.array([0.0, 0.9, 1.1, 1.9, 2.1])
    gain = film.voltage_gain(0.5, squared, n)
    np.testing.assert_allclose(gain, 0.5 * np.array([1.0, 1.0, 3.0, 3.0, np.nan]))
    np.testing.assert_allclose(film.voltage_gain(0.5, squared, {**n, "low": -1.0}), gain)
    assert film.stiffness_scale(n) == 0.7  # of a film that pushes, too


def test_a_start_outside_is_named_with_its_sign():
    assert FILM.outside(-2.5, N).startswith("initial displacement -2.5: the film has no state there")


def test_a_film_loses_power_where_it_says_how_much():
    class Lossy(PowerFilm):
        name = "lossy"

        def dissipation(self, x, velocity, squared, y, n, xp=np):
            return 0.3 * velocity * velocity

    assert (Lossy().dissipates, PowerFilm().dissipates) == (True, False)
    assert PowerFilm().dissipation(X, 0.4, 0.3, [], N) == 0.0
