"""A table says each number in the unit in which it reads well, codes as words, and yes or no."""

import numpy as np
import pytest
import xarray as xr

from gelcone.analyses import (
    tables,
)  # fmt: skip
from gelcone.codes import Outcome
from tests.analyses.said import NAN, said
from tests.analyses.test_motions import HOLDS
from tests.edited import coded, edited, labelled, made


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
    pulls = coded(None, 2, ("never", "pitchfork", "fold")).rename("pull_in_kind")
    assert tables._value(pulls) == "meets an unstable equilibrium in a fold and vanishes"


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


def test_a_table_says_yes_or_no_and_what_a_code_means():
    found = made({"outcome": 0, "resting": 1, "kind": coded(None, 1, ("none", "the_cone")), "small": (None, 0.005,
    "mm"),
                  "large": (None, 12.5, "mm"), "validity_near_limit": 0.0, "validity_breakdown": 0.0})  # fmt: skip
    for name, text in (("resting", "1 if the disc rests"), ("kind", "the kind"), ("small", "a small number"),
                       ("large", "a number"), ("outcome", "outcome")):  # fmt: skip
        found[name].attrs["long_name"] = text
    for name in ("small", "large"):
        found[name].attrs["quantity"] = "length"
    lines = ["the disc rests: yes", "the kind: the cone", "a small number: 5 um", "a number: 12.5 mm"]
    assert said(tables.table_words, found) == [*lines, HOLDS]
    assert said(tables.table_words, edited(found, resting=0))[0] == "the disc rests: no"
    failed = edited(found, outcome=int(Outcome.ERROR), validity_near_limit=NAN, validity_breakdown=NAN)
    assert said(tables.table_words, failed) == [f"1 of 1 run(s) failed: {Outcome.ERROR.meaning}", "failed"]
    names = labelled(("voltage", [1.0, 2.0], "V")).rename("voltage")
    two = xr.concat([found, failed], names)
    two["voltage"].attrs.update(quantity="parameter", units="V")
    members = said(tables.table_words, two)[1:3]
    assert members == [f"  voltage 1 V: {'; '.join(lines)}", "  voltage 2 V: failed"]
