"""Components as records: by name where they ship as they are, with what differs where they do not."""

import pytest

from gelcone.errors import InputError
from gelcone.physics.bias import BIASES, Together
from gelcone.physics.film.taut import TautCone
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.model import ConeModel
from gelcone.physics.records import FILMS, bias_record, film_record, find_bias, find_film, system_record
from tests.toys import CubicBias, PowerFilm


@pytest.mark.parametrize(
    "film", [*FILMS.values(), WrinklingCone(branches=2), TautCone(branches=1, flow="linear"), PowerFilm()]
)
def test_a_film_comes_back_from_its_record(film):
    assert find_film(film_record(film)) == film


def test_films_that_ship_are_written_by_name_and_what_else_they_were_given():
    assert film_record(TautCone()) == "taut"
    assert film_record(WrinklingCone(branches=2)) == {"component": "wrinkling", "branches": 2}
    assert film_record(PowerFilm())["component"] == "tests.toys:PowerFilm"


@pytest.mark.parametrize("given", ["continuum", '{"a": 1}', "  {", "film.json"])
def test_fitted_films_of_earlier_versions_are_refused_with_the_remedy(given):
    with pytest.raises(InputError, match=r"is a fitted film of gelcone 0.1 or 0.2.*take film = membrane"):
        find_film(given)


def test_biases_together_are_joined_by_a_plus_or_listed():
    spring, weight = BIASES["spring"], BIASES["weight"]
    assert bias_record(spring) == "spring"
    assert bias_record(Together((spring, weight))) == "spring+weight"
    mixed = bias_record(Together((spring, CubicBias())))
    assert mixed == "spring+tests.toys:CubicBias"
    assert find_bias(mixed) == Together((spring, CubicBias()))
    assert find_bias(" spring + weight ") == find_bias(["spring", "weight"]) == Together((spring, weight))


def test_a_system_is_written_with_its_law_and_its_second_film():
    model = ConeModel(
        film="taut", law="yeoh", second_film="wrinkling", second_drive="opposite", prestretch_mode="equibiaxial"
    )
    record = system_record(model.system)
    assert record["law"] == "yeoh"
    assert record["prestretch_mode"] == "equibiaxial"
    assert (record["film"], record["second_film"], record["second_drive"]) == ("taut", "wrinkling", "opposite")
    assert (record["bias"], record["waveform"], record["circuit"]) == ("spring", "sine", "ideal")
    own = system_record(ConeModel(film=PowerFilm()).system)
    assert "law" not in own
    assert "second_film" not in own


@pytest.mark.parametrize(
    ("tables", "same"),
    [
        ({"waveform": {"component": "square", "duty": 0.3}}, {"waveform": "square", "duty": 0.3}),
        ({"circuit": {"component": "amplifier", "series_resistance": 0.3}}, {"series_resistance": 0.3}),
        ({"circuit": {"component": "amplifier", "filter_time": 0.3}}, {"circuit": "amplifier", "filter_time": 0.3}),
        (
            {"bias": [{"component": "spring", "spring_stiffness": 2.0}, "weight"]},
            {"bias": "spring+weight", "spring_stiffness": 2.0},
        ),
        ({"film": {"component": "wrinkling", "hoop_prestretch": 1.2}}, {"film": "wrinkling", "hoop_prestretch": 1.2}),
    ],
    ids=["waveform", "circuit", "electrics", "bias", "film"],
)
def test_numbers_in_tables_of_components_are_parameters(tables, same):
    model, other = ConeModel(**tables), ConeModel(**same)
    assert (model.system, model.values) == (other.system, other.values)
    assert ConeModel(voltage=0.7).replace(**tables).values == other.replace(voltage=0.7).values


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (
            {"waveform": {"component": "burst", "cyclez": 3}},
            "'cyclez' is not a field of the waveform 'burst'; did you mean 'cycles'?",
        ),
        (
            {"waveform": {"component": "sine", "duty": 0.3}},
            "'duty' is not a field of the waveform 'sine'; known: voltage, voltage_bias, drive_frequency",
        ),
        (
            {"waveform": {"component": "square", "duty": 0.3}, "duty": 0.2},
            "duty: stands in the table of the waveform and as a parameter; give it once",
        ),
        (
            {"circuit": {"component": "amplifier", "series_resistanc": 0.3}},
            "'series_resistanc' is not a field of the circuit 'amplifier'; did you mean 'series_resistance'?",
        ),
    ],
)
def test_what_a_table_does_not_take_is_refused(given, words):
    for make in (ConeModel, ConeModel().replace):
        with pytest.raises(InputError) as error:
            make(**given)
        assert str(error.value) == words


@pytest.mark.parametrize("film", FILMS)
def test_a_film_of_a_gel_is_written_with_its_law_and_the_meaning_of_its_pre_stretch(film):
    record = system_record(ConeModel(film=film, law="yeoh", prestretch_mode="equibiaxial").system)
    assert (record["film"], record["law"], record["prestretch_mode"]) == (film, "yeoh", "equibiaxial")
