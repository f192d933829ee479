"""The equation of motion: its Jacobian, and Newton's law."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.physics.component import State
from gelcone.physics.differentiate import evaluated, gradients
from gelcone.physics.drive import PIECE
from gelcone.physics.film.taut import TautCone
from gelcone.physics.model import ConeModel
from gelcone.physics.trace import Graph
from gelcone.quantity import Quantity
from tests.toys import CubicBias, FilteredVoltage, PowerFilm, SaturatingAmplifier, ThreeHarmonics


@dataclass(frozen=True)
class ViscousFilm(PowerFilm):
    """A spring and a dashpot beside the power film; the dashpot's strain y follows x, faster under voltage."""

    name = "viscous"
    states = (State("dashpot", "displacement of the dashpot", "length", 0.1, True),)
    parameters = PowerFilm.parameters | {"branch": Quantity("g", "stiffness of the branch", 0.4)}

    def force(self, x, squared, y, n, xp=np):
        force, slope = super().force(x, squared, y, n, xp)
        lag = x - (y[0] if y else x)
        return force + n["branch"] * lag, slope + (n["branch"] if y else 0.0)

    def rates(self, x, velocity, squared, y, n, xp=np):
        return [(x - y[0]) * (1.0 + squared) + 0.2 * xp.sin(velocity)]


class Lagging(CubicBias):
    """A cubic bias with a mass point hung on it by a damper: its height w follows the disc."""

    name = "lagging"
    states = (State("hung_height", "height of the mass point", "length", 0.2, True),)

    def force(self, x, y, n, xp=np):
        force, slope = super().force(x, y, n, xp)
        return force + 0.3 * (x - (y[0] if y else x)), slope + (0.3 if y else 0.0)

    def rates(self, x, velocity, y, n, xp=np):
        return [n["bias_stiffness"] * (x - y[0]) - 0.1 * velocity]


MODELS = {
    "gent": ConeModel(prestretch=1.2, rest_height=0.3, voltage_bias=0.2, stretch_limit=9.0),
    "yeoh": ConeModel(law="yeoh", yeoh_c2=0.1, yeoh_c3=0.02, hoop_prestretch=1.2),
    "toys": ConeModel(film=PowerFilm(1.3), bias=CubicBias(), waveform=ThreeHarmonics(), voltage_bias=0.1),
    "filter": ConeModel(circuit=FilteredVoltage(), voltage=0.9, rest_height=0.1),
    "viscous": ConeModel(film=ViscousFilm(), voltage=0.9),
    "five": ConeModel(film=ViscousFilm(), bias=Lagging(), waveform=ThreeHarmonics(), circuit=FilteredVoltage()),
}
PAIRS = {
    "pair": ConeModel(film="taut", second_film="taut", second_flat_height=0.6, second_prestretch=1.3, voltage=0.8),
    "opposite": ConeModel(
        film="taut", second_film="taut", second_flat_height=0.6, second_drive="opposite", circuit=FilteredVoltage()
    ),
}
every_model = pytest.mark.parametrize("name", MODELS)


def points(system, count=5):
    rng = np.random.default_rng(3)
    return [(rng.uniform(0.0, 9.0), rng.uniform(-0.8, 0.8, len(system.states))) for _ in range(count)]


# --- rates and their Jacobian -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [*MODELS, *PAIRS])
def test_the_jacobian_is_that_of_the_traced_rates_and_of_central_differences(name):
    model = (MODELS | PAIRS)[name]
    system, n, h = model.system, model.own_numbers, 1e-5
    for tau, z in points(system):
        rates, jacobian = system.flow(tau, z, n)
        np.testing.assert_array_equal(rates, system.rates(tau, z, n))
        exact = gradients(lambda at, xp, tau=tau: system.rates(tau, at, n, xp), list(z))
        np.testing.assert_allclose(
            np.array(jacobian, dtype=float), np.array(exact, dtype=float), rtol=1e-12, atol=1e-13
        )
        for j, step in enumerate(h * np.eye(len(z))):
            ahead, behind = (np.array(system.rates(tau, z + sign * step, n), dtype=float) for sign in (1.0, -1.0))
            column = [row[j] for row in jacobian]
            np.testing.assert_allclose(column, (ahead - behind) / (2.0 * h), rtol=1e-7, atol=1e-8)


@every_model
def test_the_rates_are_newtons_law_of_its_parts(name):
    """x'' = -2 zeta x' - F_film - F_bias, with each part called by hand."""
    model = MODELS[name]
    system, n = model.system, model.own_numbers
    for tau, z in points(system):
        film_y, bias_y, circuit_y = (system.states_of(z, *owner) for owner in (("film", 0), ("bias",), ("line", "")))
        commanded = system.waveform.voltage(tau, n)
        volts = circuit_y[0] if circuit_y else commanded
        film, bias = system.film.force(z[0], volts**2, film_y, n)[0], system.bias.force(z[0], bias_y, n)[0]
        rates = system.rates(tau, z, n)
        assert rates[0] == z[1]
        assert rates[1] == pytest.approx(-2.0 * n["damping_ratio"] * z[1] - film - bias, rel=1e-13)
        own = [
            *system.film.rates(z[0], z[1], volts**2, film_y, n),
            *system.bias.rates(z[0], z[1], bias_y, n),
            *system.circuit.rates(SimpleNamespace(command=commanded), circuit_y, n),
        ]
        assert rates[2:] == own
        np.testing.assert_array_equal(system.under(commanded, z, n).rates(), rates)
        assert system.voltages(tau, z, n) == [volts]


# --- statics ----------------------------------------------------------------------------------------------------------


def test_a_system_is_planar_where_displacement_and_velocity_are_all():
    assert MODELS["gent"].system.planar
    assert not MODELS["five"].system.planar


def test_a_circuit_with_borders_has_the_period_of_the_voltage_itself():
    """Where it saturates on one side alone the square of its voltage differs from half to half."""
    model = ConeModel(circuit=SaturatingAmplifier(), drive_frequency=0.8)
    assert model.system.forcing_period(model.own_numbers) == pytest.approx(2.0 * np.pi / 0.8, rel=1e-15)
    assert ConeModel(drive_frequency=0.8).system.forcing_period(ConeModel(drive_frequency=0.8).own_numbers) == (
        pytest.approx(np.pi / 0.8, rel=1e-15)
    )


@pytest.mark.parametrize(("drive", "sign"), [("same", 1.0), ("opposite", -1.0), ("constant", 0.0)])
def test_the_rate_of_a_second_films_voltage_is_that_of_its_drive(drive, sign):
    pair = ConeModel(film="taut", second_film="taut", second_drive=drive, voltage=0.7, drive_frequency=0.8)
    rate = 0.7 * 0.8 * np.cos(0.8 * 1.3)
    found = pair.system.voltage_rates(1.3, [0.2, 0.1], pair.own_numbers)
    np.testing.assert_allclose(found, [rate, sign * rate], rtol=1e-13, atol=1e-15)


def test_a_current_charges_the_film_and_what_leaks_through_it():
    """(C v)' + C v/te, C = 1 + x^2; and each line's charge is that of its own film."""
    x, u, tau = np.array([0.3, -0.6]), np.array([0.5, 0.2]), 1.3
    model = ConeModel(film="taut", voltage=0.7, drive_frequency=0.8, leakage_time=4.0)
    v, rate, area = 0.7 * np.sin(0.8 * tau), 0.7 * 0.8 * np.cos(0.8 * tau), 1.0 + x**2
    (found,) = model.system.currents(tau, [x, u], model.own_numbers)
    np.testing.assert_allclose(found, area * rate + 2.0 * x * u * v + area * v / 4.0, rtol=1e-12)
    pair = model.replace(second_film="taut", second_drive="opposite", second_flat_height=0.9, voltage_bias=0.2)
    found = pair.system.source_charges(tau, [x, u], pair.own_numbers)
    expected = [(0.2 + v) * area, (0.2 - v) * (1.0 + (0.9 - x) ** 2)]
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_mechanical_states_are_those_of_disc_film_and_bias_and_move_at_held_voltages():
    model = MODELS["five"]
    system, n, z = model.system, model.own_numbers, [0.3, -0.2, 0.1, 0.25, 0.6]
    assert system.mechanical == [0, 1, 2, 3]
    assert MODELS["filter"].system.mechanical == [0, 1]
    rates = system.rates(0.7, z, n)
    np.testing.assert_allclose(system.rates_held([0.36], z, n), rates[:4], rtol=1e-14)


def test_deviations_behind_a_resistance_are_those_of_a_system_of_charges():
    """x' = u, u' = ..., Q' = (v_s - v)/rho with v = Q/(1 + x^2): the Jacobian by x, u and Q, from differences."""
    model = ConeModel(film="taut", series_resistance=0.4, voltage=0.7, rest_height=0.3, prestretch=1.1)
    system, n, tau, z = model.system, model.own_numbers, 1.1, np.array([0.4, -0.3, 0.5])
    assert list(system.charged) == [2]
    graph = Graph()
    leaves = [graph.state(k) for k in range(3)]
    numbers = {name: graph.number(name) for name in system.numbers}
    rates, slopes = system.flow(graph.time, leaves, numbers, graph)
    known = {leaf.index: value for leaf, value in zip(leaves, z, strict=True)} | {graph.time.index: tau}
    known |= {numbers[name].index: n[name] for name in system.numbers}
    found = evaluated([graph.node(value) for row in (rates, *slopes) for value in row], known)
    np.testing.assert_allclose(found[:3], system.rates(tau, list(z), n), rtol=1e-12)

    def area(x):
        return system.films[0].capacitance(x, 0.0, [], n)

    def flow(x, u, charge):
        v = charge / area(x)
        acceleration = system.rates(tau, [x, u, v], n)[1]
        return np.array([u, acceleration, (0.7 * np.sin(tau) - v) / 0.4])

    at, h = np.array([z[0], z[1], z[2] * area(z[0])]), 1e-6
    columns = [(flow(*(at + step)) - flow(*(at - step))) / (2.0 * h) for step in h * np.eye(3)]
    np.testing.assert_allclose(np.reshape(found[3:], (3, 3)), np.transpose(columns), rtol=1e-7, atol=1e-9)


def test_a_voltage_that_follows_the_disc_leaves_no_plane():
    assert not ConeModel(film="taut", circuit="charge").system.planar
    assert not ConeModel(film="taut", circuit="amplifier", series_resistance=0.3).system.planar
    fast = {"viscous_modulus_1": 0.5, "relaxation_time_1": 0.01, "reduced": "relaxation_time_1"}
    assert not ConeModel(film="taut", **fast).system.planar
    assert ConeModel(film="taut", second_film="taut", second_drive="opposite").system.planar


def test_where_a_minimum_ends_at_a_held_voltage_a_film_behind_a_resistance_has_a_border_of_its_charge():
    creeping = {"film": "wrinkling", "viscous_modulus_1": 0.5, "relaxation_time_1": 3.0}
    held, behind = ConeModel(**creeping).system, ConeModel(**creeping, series_resistance=0.4).system
    folds = [border for border in held.films[0].borders if border.folds]
    assert folds
    assert len(held.borders) == len(held.films[0].borders)
    assert len(behind.borders) == len(held.borders) - len(folds) + 1
    assert (behind.borders[-1][0], behind.borders[-1][1].seldom, behind.borders[-1][1].switch) == (0, True, None)


def test_of_two_films_behind_one_resistance_each_has_the_end_of_its_own_minimum():
    """At states of its own it is where the film alone would have it."""
    creeping = {"film": "wrinkling", "viscous_modulus_1": 0.5, "relaxation_time_1": 3.0, "series_resistance": 0.4}
    single, pair = ConeModel(**creeping), ConeModel(**creeping, second_film="taut", second_flat_height=0.6)
    z = dict.fromkeys([state.name for state in pair.system.states], 1.0)
    z |= {"displacement": 0.4, "velocity": 0.1, "film_voltage": 0.3}
    values = []
    for model in (single, pair):
        own = [np.asarray(z[state.name]) for state in model.system.states]
        n = model.own_numbers
        n = n | model.system.switches(0.0, own, n)
        border = [border for k, border in model.system.borders if k == 0][-1]
        values.append(float(border.value(0.0, own, n, np)))
    assert values[0] == pytest.approx(values[1], rel=1e-12)
    assert 0.0 < values[0] < 2.0


class Fitted(PowerFilm):
    """A film whose charge is known to a program by a fit alone."""

    name, linear_charge, traced_charge, fitted_charge = "fitted", True, True, True

    def capacitance(self, x, squared, y, n, xp=np):
        return 1.0 + x * x


class Known(Fitted):
    name, fitted_charge = "known", False


def test_the_source_of_a_charge_that_is_fitted_counts_only_where_the_circuit_loses_power():
    assert ConeModel(film=Known()).system.causes == ("motion", "damper", "source")
    assert ConeModel(film=Fitted()).system.causes == ("motion", "damper")
    lossy = ConeModel(film=Fitted(), series_resistance=0.3).system
    assert lossy.causes == ("motion", "damper", "source", "resistor")
    assert ConeModel(film=PowerFilm(), filter_time=0.3).system.causes == ("motion", "damper")
    assert lossy.bounding_powers == 2


def test_switches_of_the_drive_are_among_those_of_the_system():
    model = ConeModel(waveform="triangle", drive_frequency=0.8)
    found = model.system.switches(np.array([3.0]), [np.zeros(1), np.zeros(1)], model.members().numbers())
    assert list(found) == list(PIECE)
    assert found["piece_1"] == pytest.approx(-2.0 / np.pi, rel=1e-14)


def test_the_power_that_a_film_loses_bears_on_the_length_of_steps():
    creeping = ConeModel(film="taut", viscous_modulus_1=0.5, relaxation_time_1=3.0).system
    assert creeping.causes[:3] == ("motion", "damper", "film")
    assert creeping.bounding_powers == 3


def test_the_current_of_a_film_that_creeps_is_that_of_its_charge_at_its_states():
    """By the difference of v C along the motion, behind an ideal source, of a film whose hoop is slack."""
    model = ConeModel(film="wrinkling", viscous_modulus_1=0.8, relaxation_time_1=2.0, hoop_prestretch=1.05, voltage=0.7)
    system, n, tau, h = model.system, model.own_numbers, 0.9, 1e-5
    z = np.array([0.7, 0.2, 0.6, 0.9])

    def charge(tau, z):
        v = system.voltages(tau, z, n)[0]
        return v * system.film.capacitance(z[0], v * v, list(z[2:]), n)

    rates = np.array(system.rates(tau, [*z], {**n, **system.switches(tau, [*z], n)}), dtype=float)
    assert float(system.switches(tau, [*z], n)["width_held"]) < 0.0
    slope = (charge(tau + h, z + h * rates) - charge(tau - h, z - h * rates)) / (2.0 * h)
    (found,) = system.currents(tau, [*z], n)
    assert float(found) == pytest.approx(float(slope), rel=1e-6)


def test_a_line_has_the_voltage_of_its_films_and_its_source_that_before_the_resistance():
    """y' = (v_s - y)/t_f, C v' + C' v = (y - v)/rho: states, and the rates of either voltage along the motion."""
    model = ConeModel(film="taut", filter_time=0.3, series_resistance=0.4, voltage=0.7)
    system, n, z = model.system, model.own_numbers, [0.4, -0.3, 0.5, 0.2]
    tau, (line,) = 0.8, system.lines
    command, rate = 0.7 * np.sin(tau), 0.7 * np.cos(tau)
    v, *rates = system.electric(line, command, rate, z, n)
    assert v == 0.2
    assert rates[0] == pytest.approx((command - 0.5) / 0.3, rel=1e-13)
    assert rates[1] == pytest.approx(((0.5 - 0.2) / 0.4 + 2.0 * 0.4 * 0.3 * 0.2) / 1.16, rel=1e-12)
    assert system.source_rates(tau, z, n) == [pytest.approx(rates[0], rel=1e-13)]
    assert system.voltage_rates(tau, z, n) == [pytest.approx(rates[1], rel=1e-12)]
    assert (system.source_voltages(tau, z, n), system.voltages(tau, z, n)) == ([0.5], [0.2])


def test_films_behind_one_resistance_leak_each_by_its_own_capacitance_and_lines_have_borders_of_their_own():
    own = {"film": "taut", "second_film": "taut", "second_flat_height": 0.9, "series_resistance": 0.5}
    pair = ConeModel(**own, leakage_time=4.0)
    x = np.array([0.2, 0.7])
    found = pair.system.leaking_at_rest(x, [0.6, 0.6], pair.own_numbers)
    for leak, place in zip(found, (x, 0.9 - x), strict=True):
        np.testing.assert_allclose(leak, 0.36 * (1.0 + place**2) / 4.0, rtol=1e-12)
    limited = ConeModel(**own, current_limit=0.3, second_drive="opposite").system
    names = [f"{prefix}current_limit_{side}" for prefix in ("", "second_") for side in ("above", "below")]
    assert [border.switch for _, border in limited.borders] == names


def test_the_field_that_pulls_is_that_of_what_has_followed_of_a_permittivity_that_is_late():
    """(1 - chi) v^2 + chi w^2 with the late charge C w over its share."""
    model = ConeModel(film="taut", dielectric_share=0.4, dielectric_time=2.0, voltage=0.5)
    system, n, area = model.system, model.own_numbers, 1.0 + 0.6**2
    z = [0.6, 0.1, area * 0.2]
    v = 0.5 * np.sin(1.1)
    expected = 0.6 * v * v + 0.4 * 0.04
    assert system.squares(1.1, z, n) == [pytest.approx(expected, rel=1e-13)]
    assert system.squared_at(v, z, n) == pytest.approx(expected, rel=1e-13)
    assert system.stored(1.1, z, n) == pytest.approx(area * (0.6 * v + 0.4 * 0.2), rel=1e-13)
    assert system.rates(1.1, z, n)[1] == pytest.approx(
        -0.1 * 0.1 - system.film.force(0.6, expected, [], n)[0] - 1.5 * 0.6, rel=1e-12
    )


def test_what_a_second_film_alone_loses_counts_and_the_last_state_of_a_circuit_carries_the_voltage():
    pair = ConeModel(film="taut", second_film=TautCone(branches=1), second_viscous_modulus_1=0.4)
    assert "film" in pair.system.causes
    behind = ConeModel(film="taut", filter_time=0.3, series_resistance=0.4).system
    assert [behind.states[place].name for place in behind.charged] == ["film_voltage"]


@pytest.mark.parametrize(
    ("drive", "lines"),
    [({"second_drive": "same"}, [[0, 1]]), ({"second_drive": "constant", "second_voltage": 0.4}, [[0], [1]])],
)
def test_the_current_of_a_source_is_that_into_all_its_films(drive, lines):
    model = ConeModel(second_film="taut", **drive, second_prestretch=1.3, second_flat_height=0.4)
    z = [np.array([0.3, 0.1]), np.array([0.2, -0.4])]
    currents = model.system.currents(np.array([0.5, 1.7]), z, model.own_numbers)
    found = model.system.source_currents(np.array([0.5, 1.7]), z, model.own_numbers)
    assert (np.abs(currents) > 0.0).any(axis=1).all()
    np.testing.assert_array_equal(found, [sum(currents[k] for k in line) for line in lines])
