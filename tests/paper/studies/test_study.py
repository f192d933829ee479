"""Every study is computed with the film that it is asked for."""

from dataclasses import replace

import pytest

from gelcone.dataset import model_of
from gelcone.paper.effort import QUICK
from gelcone.paper.films import OTHER_FILMS, film_of_device
from gelcone.paper.studies import STUDIES, practical


@pytest.mark.parametrize("film", ["taut", "wrinkling", "membrane"])
@pytest.mark.parametrize("name", ["static", "linear-limit"])
def test_the_film_is_the_one_that_was_asked_for(name, film):
    result = STUDIES[name].compute(replace(QUICK, film=film), lambda share: None)
    assert model_of(result).film.name == film


@pytest.mark.parametrize("film", ["taut", *OTHER_FILMS])
def test_the_device_has_the_film_that_was_asked_for(film, monkeypatch):
    class Seen(Exception):
        pass

    def stop(device, *_):
        raise Seen(device)

    monkeypatch.setattr(practical, "_practical", stop)
    with pytest.raises(Seen) as seen:
        practical.practical(replace(QUICK, film=film), lambda share: None)
    (device,) = seen.value.args
    assert device.film == ("wrinkling" if film == "creeping" else film)
    assert device.series_resistance == film_of_device(film).series_resistance
    assert (device.series_resistance is None) == (film != "creeping")


def test_the_membrane_is_a_film_of_claims_about_force_and_pull_in():
    assert {name for name, study in STUDIES.items() if "membrane" in study.films} == {
        "static", "continuum", "corrected", "linear-limit", "practical",
    }  # fmt: skip
