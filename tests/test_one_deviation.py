"""A deviation is read, and refused, in one manner, whoever asks for it."""

import pytest

import gelcone
from gelcone.atlas.distribution import in_numbers
from gelcone.devices.units import parse_share
from gelcone.errors import InputError
from gelcone.lab.device import read_free

PUMP = gelcone.find_device("biased-pump")


@pytest.mark.parametrize("text", ["3 %", "3%", "5 um", "2e-3 mm"])
def test_a_prior_is_the_deviation_of_an_uncertain_field(text):
    own = in_numbers("film_thickness", gelcone.Normal(f"{PUMP.film_thickness} m", text))
    prior = read_free([f"film_thickness~{text}"], PUMP)["film_thickness"]
    assert prior * PUMP.film_thickness == pytest.approx(own.deviation, rel=1e-15)
    if text.endswith("%"):
        assert prior == pytest.approx(parse_share("own", text), rel=1e-15)


@pytest.mark.parametrize("text", ["0 %", "-3 %", "0 um", "-5 um", "5 V", "5"])
def test_what_is_not_a_deviation_is_refused_in_the_same_words(text):
    found = []
    for read in (
        lambda: in_numbers("film_thickness", gelcone.Normal(f"{PUMP.film_thickness} m", text)),
        lambda: read_free([f"film_thickness~{text}"], PUMP),
    ):
        with pytest.raises(InputError) as refused:
            read()
        found.append(str(refused.value).replace("free ", ""))
    assert found[0] == found[1]
