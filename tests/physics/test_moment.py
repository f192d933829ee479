"""Powers and voltages at one time: the energy balance, and rates along the motion."""

import numpy as np
import pytest

from gelcone.physics.amplifier import Amplifier
from gelcone.physics.model import ConeModel
from tests.physics.test_system import MODELS, Lagging, ViscousFilm, every_model, points
from tests.toys import SaturatingAmplifier


@pytest.mark.parametrize("name", ["gent", "yeoh", "toys", "filter"])
def test_the_powers_change_the_energy(name):
    """d/dt (u^2/2 + E) = power of film and field - dissipated power, with E the energy of the bias."""
    model = MODELS[name]
    system, n = model.system, model.own_numbers
    for tau, z in points(system):
        power, dissipated = system.powers(tau, z, n)[:2]
        bias = system.bias.force(z[0], system.states_of(z, "bias"), n)[0]
        change = z[1] * (system.rates(tau, z, n)[1] + bias)
        assert change == pytest.approx(power - dissipated, rel=1e-11, abs=1e-13)
        assert dissipated == pytest.approx(2.0 * n["damping_ratio"] * z[1] ** 2, rel=1e-14)
        (volts,) = system.voltages(tau, z, n)
        if name != "toys":
            field = power + z[1] * system.film.force(z[0], 0.0, system.states_of(z, "film", 0), n)[0]
            assert field == pytest.approx(volts**2 * z[0] * z[1], rel=1e-12, abs=1e-13)


@every_model
def test_the_rate_of_the_film_voltage_is_its_slope_along_the_motion(name):
    model = MODELS[name]
    system, n, h = model.system, model.own_numbers, 1e-5
    for tau, z in points(system):
        rates = np.array(system.rates(tau, z, n), dtype=float)
        ahead, behind = (system.voltages(tau + s * h, z + s * h * rates, n)[0] for s in (1.0, -1.0))
        assert system.voltage_rates(tau, z, n)[0] == pytest.approx((ahead - behind) / (2.0 * h), rel=1e-7, abs=1e-9)


def test_a_branch_without_states_takes_power_like_a_damper():
    """2 zeta u^2 by the disc's damper, 4 g tau x^2 u^2/q^2 by the branch, of the film's power."""
    fast = {"viscous_modulus_1": 0.7, "relaxation_time_1": 0.01, "reduced": "relaxation_time_1"}
    model = ConeModel(film="taut", damping_ratio=0.3, voltage=0.4, **fast)
    system, n, tau, z = model.system, model.own_numbers, 0.4, np.array([0.6, 1.7])
    film, damper = system.powers(tau, z, n)[:2]
    force = system.film.force(z[0], system.waveform.voltage(tau, n) ** 2, [], n)[0]
    drag = 4.0 * 0.7 * 0.01 * (z[0] / (1.0 + z[0] ** 2)) ** 2
    assert film == pytest.approx(-(force + drag * z[1]) * z[1], rel=1e-12)
    assert damper == pytest.approx(0.6 * z[1] ** 2, rel=1e-14)
    bias = system.bias.force(z[0], [], n)[0]
    assert system.rates(tau, z, n)[1] == pytest.approx(-(force + bias + (drag + 0.6) * z[1]), rel=1e-12)


def test_both_films_behind_one_resistance_have_one_voltage_whose_rate_stands_once_among_the_rates():
    """(C1 + C2) v' + C' v = (v_s - v)/rho of two taut films, C = (1 + (place)^2) each."""
    pair = ConeModel(
        film="taut", second_film="taut", second_flat_height=0.5, circuit="amplifier", series_resistance=0.4,
        filter_time=0.3, voltage=0.7,
    )  # fmt: skip
    system, n, tau, z = pair.system, pair.own_numbers, 0.8, [0.3, -0.6, 0.5, 0.2]
    rates = system.rates(tau, z, n)
    assert len(rates) == len(system.states) == 4
    area, by_x = 2.0 + 0.3**2 + 0.2**2, 2.0 * 0.3 - 2.0 * 0.2
    assert rates[2] == pytest.approx((0.7 * np.sin(0.8) - 0.5) / 0.3, rel=1e-13)
    assert area * rates[3] + by_x * -0.6 * 0.2 == pytest.approx((0.5 - 0.2) / 0.4, rel=1e-12)


def test_a_circuit_is_on_the_side_of_its_border_that_the_command_says():
    model = ConeModel(circuit=SaturatingAmplifier(), voltage=0.9, voltage_limit=0.5)
    system, n, tau = model.system, model.own_numbers, np.linspace(0.0, 6.0, 25)
    (voltage,) = system.voltages(tau, [0.0 * tau, 0.0 * tau], n)
    np.testing.assert_allclose(voltage, np.clip(0.9 * np.sin(tau), -0.5, 0.5), rtol=1e-14, atol=1e-15)


def test_the_sources_of_two_lines_supply_and_lose_together():
    """Each (v_s - v)/rho through its resistance, of which v_s of that pays, and rho i^2 is lost."""
    pair = ConeModel(
        film="taut", second_film="taut", second_drive="opposite", series_resistance=0.4, voltage=0.7, voltage_bias=0.3
    )
    system, n, tau, z = pair.system, pair.own_numbers, 0.8, [0.3, -0.6, 0.2, 0.5]
    powers = dict(zip(system.causes, system.powers(tau, z, n), strict=True))
    commands = 0.3 + 0.7 * np.sin(0.8), 0.3 - 0.7 * np.sin(0.8)
    currents = [(command - v) / 0.4 for command, v in zip(commands, z[2:], strict=True)]
    assert powers["source"] == pytest.approx(sum(c * i for c, i in zip(commands, currents, strict=True)), rel=1e-12)
    assert powers["resistor"] == pytest.approx(0.4 * sum(i * i for i in currents), rel=1e-12)


@pytest.mark.parametrize("branches", [0, 1])
def test_the_rate_of_a_voltage_that_time_and_states_make_is_its_difference_along_the_motion(branches):
    """Of a resistance without a state, and a film with states of its own or without."""
    branch = {"viscous_modulus_1": 0.5, "relaxation_time_1": 3.0} if branches else {}
    model = ConeModel(
        film="taut", circuit=Amplifier(reduced=True), series_resistance=0.005, voltage=0.7, **branch
    )  # fmt: skip
    system, n, tau, h = model.system, model.own_numbers, 1.1, 1e-5
    z = np.array([0.4, -0.5, 1.1, 0.95][: 2 + 2 * branches])
    rates = np.array(system.rates(tau, z, n), dtype=float)
    ahead, behind = (system.voltages(tau + s * h, z + s * h * rates, n)[0] for s in (1.0, -1.0))
    (found,) = system.voltage_rates(tau, z, n)
    assert found == pytest.approx((ahead - behind) / (2.0 * h), rel=1e-6)
    assert found == pytest.approx(0.7 * np.cos(1.1), rel=0.05)


def test_each_films_states_move_under_its_own_voltage():
    pair = ConeModel(film=ViscousFilm(), second_film=ViscousFilm(), second_drive="constant", second_voltage=1.3)
    system, n, z = pair.system, pair.own_numbers, [0.4, 0.2, 0.1, -0.3]
    volts = 0.5 * np.sin(0.7)
    rates = system.rates(0.7, z, n)
    assert rates[2] == pytest.approx((0.4 - 0.1) * (1.0 + volts**2) + 0.2 * np.sin(0.2), rel=1e-13)
    assert rates[3] == pytest.approx((-0.4 + 0.3) * (1.0 + 1.3**2) - 0.2 * np.sin(0.2), rel=1e-13)


def test_a_resistance_without_a_state_delays_each_films_own_command():
    """v = c - rho ((1 + p^2) c' + 2 p p' c) with the command c = v0 +- v sin and the place p of either film."""
    rho = 0.004
    pair = ConeModel(
        film="taut", second_film="taut", second_drive="opposite", second_flat_height=0.9, voltage=0.7, voltage_bias=0.3,
        circuit=Amplifier(reduced=True), series_resistance=rho,
    )  # fmt: skip
    tau, x, u = 1.1, 0.4, -0.5
    for sign, p, found in zip(
        (1.0, -1.0), (x, 0.9 - x), pair.system.voltages(tau, [x, u], pair.own_numbers), strict=True
    ):
        command, rate = 0.3 + sign * 0.7 * np.sin(tau), sign * 0.7 * np.cos(tau)
        expected = command - rho * ((1.0 + p * p) * rate + 2.0 * p * sign * u * command)
        assert found == pytest.approx(expected, rel=1e-12)
    rates = pair.system.rates(tau, [x, u], pair.own_numbers)
    h = 1e-6
    ahead, behind = (
        pair.system.voltages(tau + s * h, [x + s * h * u, u + s * h * rates[1]], pair.own_numbers) for s in (1.0, -1.0)
    )
    slopes = [(a - b) / (2.0 * h) for a, b in zip(ahead, behind, strict=True)]
    np.testing.assert_allclose(pair.system.voltage_rates(tau, [x, u], pair.own_numbers), slopes, rtol=1e-7)


def test_the_slope_of_the_acceleration_counts_both_films_and_the_bias():
    pair = ConeModel(
        film="taut", second_film="taut", second_flat_height=0.6, hoop_prestretch=1.3, second_hoop_prestretch=1.1
    )
    system, n, h = pair.system, pair.own_numbers, 1e-6
    assert system.planar
    slopes = system.flow(0.7, [0.2, 0.1], n)[1]
    ahead, behind = (system.rates(0.7, [0.2 + s * h, 0.1], n)[1] for s in (1.0, -1.0))
    assert slopes[1][0] == pytest.approx((ahead - behind) / (2.0 * h), rel=1e-8)


def test_the_states_of_a_bias_move_once_behind_those_of_the_first_film():
    pair = ConeModel(film=ViscousFilm(), second_film=ViscousFilm(), bias=Lagging())
    system, n = pair.system, pair.own_numbers
    z = [0.3, -0.2, 0.1, 0.25, -0.4]
    assert [state.name for state in system.states[2:]] == ["dashpot", "hung_height", "second_dashpot"]
    rates = system.rates(0.4, z, n)
    assert len(rates) == 5
    assert rates[3] == pytest.approx(1.2 * (0.3 - 0.25) + 0.02, rel=1e-13)


def test_switches_are_those_of_films_and_of_each_lines_own_circuit():
    """The second line's current is beyond its limit, that of the first is not."""
    pair = ConeModel(
        film="wrinkling", second_film="wrinkling", second_drive="opposite", voltage=0.0, voltage_bias=0.3,
        series_resistance=0.4, current_limit=0.5,
    )  # fmt: skip
    z = [np.asarray(value) for value in (0.4, 0.0, 0.25, 0.02)]
    assert [state.name for state in pair.system.states[2:]] == ["film_voltage", "second_film_voltage"]
    found = pair.system.switches(0.0, z, pair.own_numbers)
    own = {name: float(value) for name, value in found.items() if "current" in name}
    names = ("current_limit_above", "current_limit_below")
    assert own == dict.fromkeys(names, 1.0) | {"second_current_limit_above": -1.0, "second_current_limit_below": 1.0}
    assert {"width_held", "second_width_held"} <= found.keys()


def test_what_films_lose_is_lost_by_both():
    pair = ConeModel(
        film="taut", second_film="taut", second_flat_height=0.8, viscous_modulus_1=0.6, relaxation_time_1=2.0
    )
    system, n, z = pair.system, pair.own_numbers, [0.4, 0.3, 0.8, 0.9, 1.1, 0.95]
    powers = dict(zip(system.causes, system.powers(0.5, z, n), strict=True))
    each = [
        system.film.viscous.dissipation(1.0 + place * place, 1.0, y, n) for place, y in ((0.4, z[2:4]), (0.4, z[4:6]))
    ]
    assert min(each) > 1e-3
    assert powers["film"] == pytest.approx(sum(each), rel=1e-12)


def test_the_charge_on_the_films_of_a_line_is_that_at_their_own_voltage_and_held_fields_pull_each_its_film():
    pair = ConeModel(
        film="taut", second_film="taut", second_flat_height=0.9, second_hoop_prestretch=1.2, series_resistance=0.4,
        voltage=0.7,
    )  # fmt: skip
    system, n, z = pair.system, pair.own_numbers, [0.3, -0.2, 0.25]
    assert system.stored(0.8, z, n) == pytest.approx(0.25 * (2.0 + 0.3**2 + 0.6**2), rel=1e-14)
    first, second = system.films
    expected = -first.force(0.3, 0.5, [], n)[0] - second.force(0.3, 0.1, [], n)[0]
    expected += 0.1 * 0.2 - system.bias.force(0.3, [], n)[0]
    assert system.rates_held([0.5, 0.1], z, n)[1] == pytest.approx(expected, rel=1e-12)


def test_the_voltage_of_a_source_is_that_before_the_resistance_and_after_the_filter():
    model = ConeModel(film="taut", filter_time=0.3, series_resistance=0.4, voltage=0.7)
    assert model.system.source_voltages(0.8, [0.3, 0.1, 0.5, 0.2], model.own_numbers) == [0.5]
    assert model.system.voltages(0.8, [0.3, 0.1, 0.5, 0.2], model.own_numbers) == [0.2]


def test_rates_stand_in_the_order_of_the_states_of_film_bias_and_circuit():
    model = MODELS["five"]
    system, n, tau = model.system, model.own_numbers, 0.7
    z = [0.3, -0.2, 0.1, 0.25, 0.6]
    rates = system.rates(tau, z, n)
    assert rates[2] == pytest.approx((0.3 - 0.1) * (1.0 + 0.36) + 0.2 * np.sin(-0.2), rel=1e-13)
    assert rates[3] == pytest.approx(1.2 * (0.3 - 0.25) + 0.02, rel=1e-13)
    assert rates[4] == pytest.approx((system.waveform.voltage(tau, n) - 0.6) / 0.3, rel=1e-13)
