"""A system at rest: its static force, the voltages on its films, and where these have a state."""

import numpy as np
import pytest

from gelcone.physics.at_rest import BIAS_SHARE
from gelcone.physics.model import ConeModel
from tests.physics.test_system import MODELS, PAIRS, every_model
from tests.toys import PowerFilm


class ReadSingly(dict):
    """Numbers of which no formula makes a copy: a pair of membranes has two thousand."""

    def keys(self):
        raise AssertionError("all numbers are read")

    __iter__ = keys


class NoStateAbove(PowerFilm):
    """A power film that pulls in at V = 2."""

    name = "no state above"

    def highest_squared(self, x, n):
        return np.full(np.shape(x), 2.0)[()]


@every_model
def test_the_static_force_is_what_the_rates_have_at_rest(name):
    """At rest under a constant voltage, film strains and circuit settled, x'' is the negative static force."""
    model = MODELS[name]
    system, n = model.system, model.own_numbers
    settled = [0.4, 0.0, *[0.4] * len(system.film.states + system.bias.states), *[0.7] * len(system.circuit.states)]
    force, slope = system.static_force(0.4, 0.49, n)
    assert system.under(0.7, settled, n).rates()[1] == pytest.approx(-force, rel=1e-13)
    assert force == pytest.approx(model.force(0.4, 0.7), rel=1e-13)
    if system.planar:
        h = 1e-6
        ahead, behind = (system.static_force(0.4 + s * h, 0.49, n)[0] for s in (1.0, -1.0))
        assert slope == pytest.approx((ahead - behind) / (2.0 * h), rel=1e-7)


@pytest.mark.parametrize(("limits", "share"), [((20.0, 30.0), True), ((20.0, np.inf), True), ((np.inf, np.inf), False)])
def test_the_strain_of_two_films_is_the_larger_share_of_their_limits_or_without_any_the_larger_strain(limits, share):
    pair = ConeModel(
        film="taut", second_film="taut", second_flat_height=1.5, second_hoop_prestretch=1.4,
        stretch_limit=limits[0], second_stretch_limit=limits[1],
    )  # fmt: skip
    x, n = np.array([0.1, 0.9, 1.4]), pair.own_numbers
    strains = np.array([film.strain(x, n) for film in pair.system.films])
    own = np.array([strain / limit for strain, limit in zip(strains, limits, strict=True)])
    np.testing.assert_allclose(pair.system.strain(x, n), (own if share else strains).max(axis=0), rtol=1e-14)
    q = np.array([1.0 + x * x, 1.0 + (1.5 - x) ** 2])
    np.testing.assert_allclose(strains, [q[0] + 1.0 / q[0] - 2.0, q[1] + 1.96 + 1.0 / (1.96 * q[1]) - 3.0], rtol=1e-12)


def test_a_double_cone_is_overstretched_where_one_of_its_films_is():
    """The second film's branch is stretched by 1 + (d - x)^2."""
    pair = ConeModel(
        film="taut", second_film="taut", second_flat_height=1.5,
        viscous_modulus_1=0.4, relaxation_time_1=2.0, viscous_limit_1=0.5,
    )  # fmt: skip
    n = pair.own_numbers
    names = [state.name for state in pair.system.states]
    for x in (0.1, 0.75, 1.4):
        z = [x, 0.0, 1.0, 1.0, 1.0, 1.0]
        assert len(names) == len(z)
        q = np.array([1.0 + x * x, 1.0 + (1.5 - x) ** 2])
        each = q + 1.0 / q - 2.0 >= 0.5
        assert bool(pair.system.overstretched(z, n)) == each.any()
    assert each.tolist() == [True, False]


def test_at_rest_films_in_opposite_phase_share_twice_the_bias_that_comes_through_the_circuit():
    """Behind a resistance that leaks, a flat film has 1/(1 + rho/te) of the command: the rates of both are at rest."""
    pair = ConeModel(
        film="taut", second_film="taut", second_drive="opposite", voltage_bias=0.6, rest_height=0.0,
        series_resistance=0.5, leakage_time=4.0,
    )  # fmt: skip
    system, n, command = pair.system, pair.own_numbers, 0.3
    gain = 1.0 / (1.0 + 0.5 / 4.0)
    on = [gain * command, gain * (1.2 - command)]
    assert max(map(abs, system.under(command, [0.0, 0.0, *on], n).rates()[2:])) < 1e-14
    assert system.squares_at_rest(on[0] ** 2, n)[1] == pytest.approx(on[1] ** 2, rel=1e-14)
    ahead, behind = (system.squares_at_rest((on[0] + h) ** 2, n)[1] for h in (1e-6, -1e-6))
    assert system.square_rates_at_rest(on[0], n)[1] == pytest.approx((ahead - behind) / 2e-6, rel=1e-8)


@pytest.mark.parametrize("share", [None, 0.3])
def test_formulas_read_the_numbers_that_they_take_and_no_others(share):
    pair = ConeModel(film="taut", second_film="taut", second_drive="opposite", voltage_bias=0.4, voltage=0.2)
    system, n = pair.system, dict(pair.own_numbers) | ({} if share is None else {BIAS_SHARE: share})
    own, z = ReadSingly(n), [0.1, 0.2]
    assert system.squares_at_rest(np.float64(0.25), own) == system.squares_at_rest(np.float64(0.25), n)
    assert system.square_rates_at_rest(0.5, own) == system.square_rates_at_rest(0.5, n)
    assert system.voltages(0.3, z, own) == system.voltages(0.3, z, n)


@pytest.mark.parametrize("share", [None, 0.0, 0.3, 1.0])
@pytest.mark.parametrize("drive", ["same", "opposite", "constant"])
def test_the_squares_at_rest_change_with_the_voltage_as_their_differences_do(drive, share):
    pair = ConeModel(film="taut", second_film="taut", second_drive=drive, voltage_bias=0.4)
    if drive == "constant":
        pair = pair.replace(second_voltage=0.7)
    n = pair.own_numbers | ({} if share is None else {BIAS_SHARE: share})
    h, voltage = 1e-6, 0.9
    ahead, behind = (pair.system.squares_at_rest(np.float64(voltage + s * h) ** 2, n) for s in (1.0, -1.0))
    slopes = [(a - b) / (2.0 * h) for a, b in zip(ahead, behind, strict=True)]
    np.testing.assert_allclose(pair.system.square_rates_at_rest(voltage, n), slopes, rtol=1e-8, atol=1e-9)
    second = {"same": voltage, "constant": 0.7, "opposite": (0.8 if share is None else 2.0 * share * voltage) - voltage}
    assert pair.system.squares_at_rest(voltage**2, n)[1] == pytest.approx(second[drive] ** 2, rel=1e-14, abs=1e-30)


def test_what_leaks_at_rest_is_the_square_of_the_voltage_over_the_resistance_of_each_film():
    """C v^2/te, C = 1 + x^2 of a taut film whose pre-stretches are 1, at each film's own displacement."""
    pair = ConeModel(
        film="taut", second_film="taut", second_drive="constant", second_voltage=0.4, second_flat_height=0.9,
        series_resistance=0.5, leakage_time=4.0,
    )  # fmt: skip
    x = np.array([0.2, 0.7])
    found = pair.system.leaking_at_rest(x, [0.6, 0.4], pair.own_numbers)
    for k, (place, voltage) in enumerate([(x, 0.6), (0.9 - x, 0.4)]):
        np.testing.assert_allclose(found[k], voltage**2 * (1.0 + place**2) / 4.0, rtol=1e-12)


@pytest.mark.parametrize("first", [True, False])
def test_a_pair_has_pulled_in_where_either_film_has(first):
    films = (NoStateAbove(), PowerFilm()) if first else (PowerFilm(), NoStateAbove())
    model = ConeModel(film=films[0], second_film=films[1])
    found = model.system.pulled_in(np.array([0.1, 0.2]), np.array([1.9, 2.1]), model.own_numbers)
    assert found.tolist() == [False, True]


def test_a_pair_has_pulled_in_at_each_films_own_voltage():
    """At a constant voltage on the second film, whatever that on the first."""
    own = {"film": PowerFilm(), "second_film": NoStateAbove(), "second_drive": "constant"}
    for volts, gone in ((1.4, False), (1.42, True)):
        model = ConeModel(**own, second_voltage=volts)
        assert bool(model.system.pulled_in(0.1, 0.0, model.own_numbers)) == gone
        assert bool(model.system.pulled_in(0.1, 9.0, model.own_numbers)) == gone


def test_a_start_outside_names_the_film_that_has_no_state_there():
    pair = ConeModel(film="taut", second_film="taut", second_flat_height=3.0, stretch_limit=4.0)
    n = pair.own_numbers
    assert pair.system.outside(0.2, n).startswith("second film, stretch_limit = 4: must exceed I1 - 3 = ")
    assert pair.system.outside(2.9, n).startswith("stretch_limit = 4: must exceed I1 - 3 = ")


def test_the_static_slope_of_a_pair_is_that_of_both_films_and_its_limit_that_of_any():
    pair, h = PAIRS["pair"], 1e-6
    n, x = pair.own_numbers, np.array([-0.4, 0.1, 0.9])
    force = [pair.system.static_force(x + s * h, 0.3, n)[0] for s in (1.0, -1.0)]
    np.testing.assert_allclose(pair.system.static_force(x, 0.3, n)[1], (force[0] - force[1]) / (2.0 * h), rtol=1e-7)
    for first, second, limit in ((20.0, np.inf, 1.0), (np.inf, 20.0, 1.0), (np.inf, np.inf, np.inf), (20.0, 30.0, 1.0)):
        own = pair.replace(stretch_limit=first, second_stretch_limit=second)
        assert own.system.strain_limit(own.own_numbers) == limit


def test_each_film_pulls_in_statics_at_its_own_voltage():
    pair = ConeModel(
        film="taut", second_film="taut", second_flat_height=0.6, second_drive="constant", second_voltage=0.9,
        second_hoop_prestretch=1.2, rest_height=0.2,
    )  # fmt: skip
    n, x = pair.own_numbers, 0.35
    first, second = pair.system.films
    expected = first.force(x, 0.3, [], n)[0] + second.force(x, 0.81, [], n)[0] + 1.5 * (x - 0.2)
    assert pair.system.static_force(x, 0.3, n)[0] == pytest.approx(expected, rel=1e-13)
    assert pair.system.force_under(x, [0.3, 0.81], n)[0] == pytest.approx(expected, rel=1e-13)
