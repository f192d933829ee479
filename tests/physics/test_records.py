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
