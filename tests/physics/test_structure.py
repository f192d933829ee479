"""The order of the states, the numbers, and names that two components claim."""

import numpy as np
import pytest

from gelcone.errors import InputError
from gelcone.physics.amplifier import Amplifier
from gelcone.physics.bias import Bias, LinearSpring
from gelcone.physics.circuit import IdealSource
from gelcone.physics.component import State
from gelcone.physics.film.taut import TautCone
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.model import ConeModel
from gelcone.physics.placed import PlacedFilm
from gelcone.physics.structure import Structure
from gelcone.physics.waveforms import Sine
from gelcone.quantity import Quantity
from tests.physics.test_system import MODELS, Lagging, ViscousFilm
from tests.toys import FilteredVoltage, PowerFilm


def test_states_stand_in_the_order_of_film_bias_and_circuit():
    system = MODELS["five"].system
    names = ["displacement", "velocity", "dashpot", "hung_height", "film_voltage"]
    assert [state.name for state in system.states] == names
    owners = ("film", 0), ("bias",), ("line", "")
    assert [system.states_of([1.0, 2.0, 3.0, 4.0, 5.0], *owner) for owner in owners] == [[3.0], [4.0], [5.0]]
    np.testing.assert_array_equal(system.mirror, [-1.0, -1.0, -1.0, -1.0, 1.0])


@pytest.mark.parametrize("model", [*MODELS.values(), ConeModel(film="membrane", second_film="membrane")])
def test_the_names_of_the_numbers_are_those_of_the_numbers(model):
    assert model.system.numbers == tuple(model.own_numbers)
    assert len(set(model.system.numbers)) == len(model.system.numbers)


def test_films_in_opposite_phase_are_so_about_a_voltage_of_the_drive():
    """The command of a half wave is never negative: about a negative bias both films, v and 2 v0 - v, rise together."""
    own = {"waveform": "half_wave", "voltage": 0.5}
    pair = {**own, "second_film": "taut", "second_drive": "opposite"}
    with pytest.raises(
        InputError,
        match=r"^second_drive = 'opposite': the waveform 'half_wave' stays .*voltage_offset\) at least 0",
    ):
        ConeModel(**pair, voltage_bias=[0.2, -0.3])
    ConeModel(**pair, voltage_bias=0.3), ConeModel(**{**pair, "second_drive": "same"}, voltage_bias=-0.3)
    ConeModel(**own, voltage_bias=-0.3), ConeModel(**pair | {"waveform": "sine"}, voltage_bias=-0.3)


def test_equal_systems_are_equal_and_others_are_not():
    one = ConeModel(film=PowerFilm(1.3), voltage=0.1).system
    assert one == ConeModel(film=PowerFilm(1.3), voltage=0.9).system
    assert hash(one) == hash(ConeModel(film=PowerFilm(1.3)).system)
    assert one != ConeModel(film=PowerFilm(1.4)).system
    assert ConeModel(law="yeoh").system != ConeModel().system
    assert ConeModel(circuit=FilteredVoltage()).system != ConeModel().system


class Pushing(Bias):
    """F = -p."""

    name = "pushing"

    def force(self, x, y, n, xp=np):
        return 0.0 * x - n["push"], 0.0 * x


class TakesVoltage(Pushing):
    parameters = {"voltage": Quantity("v", "of the drive", 1.0)}


class TakesDamping(Pushing):
    parameters = {"damping_ratio": Quantity("z", "of the disc", 1.0)}


class TakesState(Pushing):
    states = (State("velocity", "of the disc"),)


class GivesNumber(Pushing):
    parameters = {"push": Quantity("p", "push", 0.1)}

    def numbers(self, parameters):
        return {"push": parameters["push"], "A": 1.0}


@pytest.mark.parametrize(
    ("bias", "name"), [(TakesVoltage(), "voltage"), (TakesDamping(), "damping_ratio"), (TakesState(), "velocity")]
)
def test_a_name_that_two_components_use_is_refused(bias, name):
    with pytest.raises(InputError) as error:
        Structure((PlacedFilm(TautCone()),), bias, Sine(), IdealSource())
    assert str(error.value) == f"{name}: two components use this name; give one of them another"


def test_a_number_that_two_components_give_is_refused():
    system = Structure((PlacedFilm(TautCone()),), GivesNumber(), Sine(), IdealSource())
    with pytest.raises(InputError, match=r"^A: two components give a number of this name; give one of them another$"):
        system.numbers_of(system.complete({}))


def test_all_parameters_have_defaults_and_are_checked():
    system = Structure((PlacedFilm(TautCone()),), LinearSpring(), Sine(), IdealSource())
    assert system.complete({})["damping_ratio"] == 0.05
    assert system.complete({}).keys() <= system.parameters.keys()
    with pytest.raises(InputError, match="damping_ratio = -1: must be at least 0"):
        system.complete({"damping_ratio": -1.0})


def test_both_lines_of_a_double_cone_have_the_switches_of_their_circuit():
    limits = {"series_resistance": 0.3, "current_limit": 0.5, "filter_time": 0.2, "slew_rate": 2.0}
    model = ConeModel(film="taut", second_film="taut", second_drive="opposite", circuit="amplifier", **limits)
    own = [name for name in model.own_numbers if name.endswith(("_above", "_below"))]
    first = ["slew_rate_above", "slew_rate_below", "current_limit_above", "current_limit_below"]
    assert own == [*first, *("second_" + name for name in first)]
    assert model.system.numbers == tuple(model.own_numbers)
    assert [line.films for line in model.system.lines] == [(0,), (1,)]
    names = [state.name for state in model.system.states[2:]]
    assert names == ["amplifier_voltage", "film_voltage", "second_amplifier_voltage", "second_film_voltage"]
    assert [list(model.system.places_of(line)) for line in model.system.lines] == [[2, 3], [4, 5]]
    n = {"voltage_bias": 0.4, "second_voltage": 0.9}
    assert model.system.command_of(model.system.lines[1], 0.7, n) == pytest.approx(0.1)
    constant = model.replace(second_drive="constant").system
    assert constant.command_of(constant.lines[1], 0.7, n) == 0.9


class Unlike(TautCone):
    name, linear_charge = "unlike", False


@pytest.mark.parametrize("film", [Unlike(), WrinklingCone()])
def test_a_resistance_without_a_state_needs_films_whose_capacitance_the_voltage_does_not_change(film):
    """It may depend on the voltage, or change its law at a border."""
    reduced = {"circuit": Amplifier(reduced=True), "series_resistance": 0.003}
    for films in ({"film": film}, {"film": "taut", "second_film": film}):
        with pytest.raises(
            InputError, match=f"reduced: the capacitance of the film '{film.name}' depends on the voltage"
        ):
            ConeModel(**films, **reduced)
    assert ConeModel(film="taut", second_film="taut", **reduced).system.circuit.reduced
    with pytest.raises(InputError, match="reduced: the voltage of the waveform 'triangle' has corners"):
        ConeModel(film="taut", waveform="triangle", **reduced)


@pytest.mark.parametrize(
    ("drive", "lines"),
    [
        ("same", [("amplifier", (0, 1), None, "")]),
        ("opposite", [("amplifier", (0,), None, ""), ("amplifier", (1,), "opposite", "second_")]),
        ("constant", [("amplifier", (0,), None, ""), ("ideal", (1,), "constant", "second_")]),
    ],
)
def test_films_of_the_same_voltage_share_a_line_and_others_have_their_own(drive, lines):
    pair = ConeModel(film="taut", second_film="taut", second_drive=drive, circuit="amplifier").system
    assert [(line.circuit.name, line.films, line.drive, line.prefix) for line in pair.lines] == lines
    assert pair.film_lines == (pair.lines[0], pair.lines[-1])


def test_a_permittivity_that_follows_late_takes_a_single_taut_film():
    late = {"dielectric_share": 0.3, "dielectric_time": 2.0, "series_resistance": 0.1}
    assert ConeModel(film="taut", **late).system.circuit.delays
    for films in ({"film": "taut", "second_film": "taut"}, {"film": "wrinkling"}):
        with pytest.raises(InputError, match=r"^dielectric_share: only a single taut film takes one"):
            ConeModel(**films, **late)


def test_a_line_of_its_own_has_its_own_switches_and_the_first_has_those_without_a_prefix():
    limits = {"series_resistance": 0.3, "current_limit": 0.5}
    first, second = ConeModel(film="taut", second_film="taut", second_drive="opposite", **limits).system.lines
    n = {"current_limit": 0.5, "current_limit_above": 1.0, "current_limit_below": -1.0}
    n |= {"second_current_limit_above": -1.0, "second_current_limit_below": 2.0}
    assert first.own(n) is n
    assert second.own(n) == n | {"current_limit_above": -1.0, "current_limit_below": 2.0}


class Charging(FilteredVoltage):
    """It begins at its own number times the displacement."""

    name = "charging"

    def starts(self, x, n):
        return [n["filter_time"] * x]


def test_each_component_says_where_its_states_begin():
    model = ConeModel(film=ViscousFilm(), bias=Lagging(), circuit=Charging(), filter_time=0.25)
    assert model.system.starts(0.8, model.own_numbers) == [0.1, 0.2, 0.2]
    pair = ConeModel(film="taut", second_film="taut", second_drive="opposite", circuit=Charging(), filter_time=0.25)
    assert pair.system.starts(0.8, pair.own_numbers) == [0.2, 0.2]


def test_behind_a_filter_a_resistance_without_a_state_takes_corners_but_no_jumps():
    reduced = {"circuit": Amplifier(("filter_time", "series_resistance"), True), "film": "taut"}
    assert ConeModel(**reduced, waveform="triangle").system.circuit.reduced
    assert ConeModel(**reduced, waveform="square").system.circuit.reduced
    with pytest.raises(InputError, match="reduced: the voltage of the waveform 'square' jumps, and behind a filter"):
        ConeModel(**reduced, waveform="square", rise=0.0)


def test_in_a_pair_the_bias_stands_behind_the_first_film_and_a_held_circuit_begins_with_nothing():
    pair = ConeModel(
        film=ViscousFilm(), second_film=ViscousFilm(), bias=Lagging(), circuit=Charging(), filter_time=0.25,
        second_drive="constant",
    )  # fmt: skip
    names = ["dashpot", "hung_height", "film_voltage", "second_dashpot"]
    assert [state.name for state in pair.system.states[2:]] == names
    assert pair.system.starts(0.8, pair.own_numbers) == [0.1, 0.2, 0.2, 0.1]
    np.testing.assert_array_equal(pair.system.mirror, [-1.0, -1.0, -1.0, -1.0, 1.0, -1.0])


def test_a_bias_may_not_claim_the_dielectric_strength():
    class Claims(LinearSpring):
        name = "claims"
        parameters = dict(LinearSpring.parameters) | {"dielectric_strength": Quantity("E", "of its own", 1.0)}

    with pytest.raises(InputError, match="dielectric_strength: two components use this name"):
        ConeModel(bias=Claims())


def test_what_is_not_given_of_a_second_film_is_what_the_first_one_has():
    system = ConeModel(film="taut", second_film="taut", law="yeoh").system
    values = system.complete({"prestretch": 1.3, "yeoh_c2": 0.1, "second_yeoh_c2": 0.2})
    assert (values["second_prestretch"], values["second_yeoh_c2"], values["second_yeoh_c3"]) == (1.3, 0.2, 0.0)


def test_a_strength_that_is_none_is_refused():
    for wrong in (0.0, -1.0, np.nan):
        with pytest.raises(InputError, match="dielectric_strength"):
            ConeModel(dielectric_strength=wrong)
    assert ConeModel(dielectric_strength=2.0).values["dielectric_strength"] == 2.0
    assert "dielectric_strength" not in ConeModel().values


def test_each_film_of_a_pair_has_rested_at_its_own_place():
    pair = ConeModel(
        film="taut", second_film="taut", second_flat_height=0.9, rested="raised", viscous_modulus_1=0.4,
        relaxation_time_1=3.0,
    )  # fmt: skip
    starts = pair.system.starts(0.2, pair.own_numbers)
    assert starts == pytest.approx([1.0 / 1.04, 1.0, 1.0 / 1.49, 1.0])
