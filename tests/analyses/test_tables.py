"""A table says each number in the unit in which it reads well, codes as words, and yes or no."""

import numpy as np
import pytest
import xarray as xr

from gelcone.analyses import tables
from gelcone.codes import Outcome
from tests.edited import coded, made


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (12.3456789, "12.346 mW"), (0.01, "0.01 mW"), (0.0099, "9.9 uW"), (-0.0099, "-9.9 uW"), (-0.01, "-0.01 mW"),
        (0.0, "0 mW"), (np.nan, "unknown"), (np.inf, "infinite"),
    ],
)  # fmt: skip
def test_a_small_number_has_a_smaller_unit_whatever_its_sign(value, text):
    attrs = {"units": "mW", "quantity": "power", "long_name": "mean power"}
    assert tables._value(xr.DataArray(value, attrs=attrs)) == text


def test_yes_no_and_codes_are_words():
    rest = xr.DataArray(1, attrs={"long_name": "1 if the disc rests", "units": "1"})
    assert [tables._value(rest), tables._value(rest.copy(data=0))] == ["yes", "no"]
    assert tables._value(coded(None, 1, ("rest", "period_doubling"))) == "period doubling"


@pytest.mark.parametrize("apart", [None, tables.FILM_STATES])
def test_a_line_for_every_number_but_those_said_apart(apart):
    found = made(
        {"power": 2.5, "outcome": 0, "validity_breakdown": 0.5, "film_state_taut": 0.25, "second_film_state_taut": 0.75,
         "many": ("n", [1.0, 2.0])},
    )  # fmt: skip
    for name in found.data_vars:
        found[name].attrs["long_name"] = f"1 if {name}" if name == "flag" else f"the {name}"
    lines = tables._rows(found) if apart is None else tables._rows(found, apart)
    states = ["the film_state_taut: 0.25", "the second_film_state_taut: 0.75"] if apart is None else []
    assert lines == ["the power: 2.5", *states]
    found["outcome"] = int(Outcome.PULLED_IN)
    assert tables._rows(found) == ["failed"]
