"""What may be free in a fit of a device and what is asked of it, from texts."""

import pytest

import gelcone
from gelcone.errors import DoubtfulInput, InputError
from gelcone.lab.device import PREDICTIONS, WIDE, Asked, read_free, read_predictions

PUMP = gelcone.find_device("biased-pump").replace(film="taut")


def test_priors_are_shares_of_the_value_and_wide_where_none_is_given():
    found = read_free(["spring_rate~3%", "film_thickness ~ 5 um"], PUMP)
    assert found == {"spring_rate": pytest.approx(0.03), "film_thickness": pytest.approx(5e-6 / 2e-4)}
    with pytest.warns(DoubtfulInput, match="spring_rate: has no prior"):
        assert read_free(["spring_rate"], PUMP) == {"spring_rate": WIDE}


def test_predictions_have_a_voltage_where_they_take_one():
    found = read_predictions(["stroke@1.5 kV", "pull-in", "natural frequency @ 200 V"])
    assert found == [
        Asked("stroke@1.5 kV", "stroke", 1500.0), Asked("pull-in", "pull-in", 0.0),
        Asked("natural frequency @ 200 V", "natural frequency", 200.0),
    ]  # fmt: skip
    assert list(PREDICTIONS.values()) == ["m", "N", "Hz", "V"]


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        (["spring_rate~3%", "spring_rate~4%"], "spring_rate: is given twice"),
        (["spring_rate~0%"], "spring_rate"), (["spring_rate~5 V"], "spring_rate"), (["spring~3%"], "spring"),
        (["film_thickness~-5 um"], "film_thickness"),
    ],
)  # fmt: skip
def test_priors_that_cannot_be_are_refused(texts, message):
    with pytest.raises(InputError, match=message):
        read_free(texts, PUMP)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("stroke", "give a voltage, stroke@1 kV"), ("pull-in@1 kV", "takes no voltage"), ("strok@1 kV", "did you mean"),
        ("stroke@0 V", "stroke"), ("stroke@3 mm", "stroke"),
    ],
)  # fmt: skip
def test_predictions_that_cannot_be_are_refused(text, message):
    with pytest.raises(InputError, match=message):
        read_predictions([text])
