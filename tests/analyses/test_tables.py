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
        (12.3456789, "12.346 mW"), (0.01, "10 uW"), (-0.0099, "-9.9 uW"), (1234.5678, "1.2346 W"), (0.0, "0 W"),
        (np.nan, "unknown"), (np.inf, "infinite"),
    ],
)  # fmt: skip
def test_a_number_has_the_unit_in_which_it_reads_well(value, text):
    attrs = {"units": "mW", "quantity": "power", "long_name": "mean power"}
    assert tables._value(xr.DataArray(value, attrs=attrs)) == text


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.93920432123, 2.1e-8, "0.939204321 ± 2.1e-08"), (-93.920432123, 2.1e-5, "-93.920432 ± 2.1e-05"),
        (0.93920432123, 0.05, "0.939 ± 0.05"), (1.05, 0.09, "1.05 ± 0.09"), (0.93920432123, 2.0, "0.94 ± 2"),
        (0.93920432123, 0.0, "0.9392"), (0.93920432123, NAN, "0.9392"), (0.0, 1e-8, "0 ± 1e-08"),
        (NAN, 1e-8, "unknown"), (np.inf, 1e-8, "infinite"),
    ],
)  # fmt: skip
def test_a_voltage_has_its_error_and_the_digits_that_this_leaves_it(value, error, text):
    found = made({"onset_voltage": value, "onset_error": error, "other_voltage": 0.93920432123})
    for name in found.data_vars:
        found[name].attrs["long_name"] = name
    assert tables._rows(found) == {"onset_voltage": text, "other_voltage": "0.9392"}


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [(239.60092834, 7.9867e-6, "239.6009283 ± 8e-06 V"), (1239.60092834, 0.2, "1.2396 ± 0.0002 kV")],
)
def test_a_voltage_and_its_error_have_one_unit(value, error, text):
    found = made({"onset_voltage": ((), value, "V"), "onset_error": ((), error, "V")})
    for name in found.data_vars:
        found[name].attrs |= {"long_name": name, "quantity": "voltage"}
    assert tables._rows(found) == {"onset_voltage": text}


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
    rows = tables._rows(found) if apart is None else tables._rows(found, apart)
    states = {"the film_state_taut": "0.25", "the second_film_state_taut": "0.75"} if apart is None else {}
    assert rows == {"the power": "2.5", **states}


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
    assert said(tables.table_words, failed) == [f"failed: {Outcome.ERROR.meaning}"]
    stiffer = edited(found, large=9.0, resting=0)
    names = labelled(("voltage", [1.0, 2.0, 4.0], "V")).rename("voltage")
    three = xr.concat([found, failed, stiffer], names)
    three["voltage"].attrs.update(quantity="parameter", units="V")
    assert said(tables.table_words, three)[:7] == [
        f"1 of 3 runs failed: {Outcome.ERROR.meaning}",
        "voltage             1 V   4 V",
        "the disc rests      yes    no",
        "a number        12.5 mm  9 mm",
        "for each of the 2:",
        "  the kind: the cone",
        "  a small number: 5 um",
    ]
    assert said(tables.table_words, three)[7] == "failed: voltage 2 V"
    assert said(tables.table_words, three.isel(voltage=[1]))[1] == "failed: voltage 2 V"
    alone = said(tables.table_words, three.isel(voltage=[2]))
    assert [" ".join(line.split()) for line in alone[:3]] == ["voltage 4 V", "the disc rests no", "the kind the cone"]


def test_as_many_columns_as_fit_stand_side_by_side_and_long_words_are_wrapped():
    """Twenty members at most, and nothing is wider than the text around it."""
    count = 23
    words = ["a word that is too long for a column, and more" if k == 2 else f"{k}" for k in range(count)]
    rows = [["the name", *(f"{1000 + k} V" for k in range(count))], ["a label " * 8, *words]]
    lines = tables.side_by_side(rows)
    assert max(map(len, lines)) <= tables.WIDTH
    assert [line.rstrip() for line in lines] == lines
    assert " ".join(" ".join(line[:50] for line in lines if line.startswith("a label")).split()).startswith("a label a")
    assert [value for line in lines if line.startswith("the name") for value in line.split()[2::2]] == [
        f"{1000 + k}" for k in range(count)
    ]
    blanks = lines.count("")
    assert blanks == sum(line.startswith("the name") for line in lines) - 1 > 0


def test_a_long_ensemble_shows_its_beginning():
    number = xr.DataArray(np.arange(25.0), dims="voltage", attrs={"units": "mm", "long_name": "a number"})
    found = xr.Dataset({"outcome": ("voltage", np.zeros(25, int)), "number": number})
    found = found.assign_coords(voltage=("voltage", np.arange(25.0), {"quantity": "parameter", "units": "V"}))
    text = "\n".join([*tables._columns(found), *tables.shortened([], 25)])
    assert "19 mm" in text
    assert "20 mm" not in text
    assert text.endswith("  and 5 more (all with --json or --out)")


def test_members_that_differ_in_no_field_have_no_row_of_names():
    number = xr.DataArray([1.0, 2.0], dims="run", attrs={"units": "mm", "long_name": "a number"})
    found = xr.Dataset({"outcome": ("run", [0, 0]), "number": number})
    assert tables._columns(found) == ["a number  1 mm  2 mm"]
    assert tables._columns(found.assign(number=("run", [1.0, 1.0], number.attrs))) == [
        "for each of the 2:",
        "  a number: 1 mm",
    ]


@pytest.mark.parametrize(
    ("values", "attrs", "said"),
    [
        ([1.0, 2.5, 3.0, 4.0, 5.0, 6.0], {}, "1 mm, 2.5 mm, 3 mm, 4 mm, 5 mm, 6 mm"),
        ([3.0, 1.0, NAN, 4.0, 5.0, 9.0, 6.0], {}, "1 to 9 mm in 7 values"),
        ([[3.0, 1.0, 2.0, 4.0], [5.0, 9.0, 6.0, 7.0]], {}, "1 to 9 mm in 2 x 4 values"),
        ([[1.0, 2.0], [3.0, NAN]], {}, "1 mm, 2 mm, 3 mm, unknown"),
        ([NAN] * 7, {"nan_means": "not applicable"}, "not applicable in 7 values"),
        (["a", "b"], {}, "a, b"),
        (["a"] * 7, {}, "7 values"),
        ([True, False, True], {}, "yes, no, yes"),
        ([True, False] + [True] * 5, {}, "yes in 6 of 7, no in 1 of 7"),
        ([0, 1, 1, 1, 1, 1, 0], dict(coded("n", [0], ("rest", "period_doubling")).attrs),
         "rest in 2 of 7, period doubling in 5 of 7"),
    ],
)  # fmt: skip
def test_a_series_is_said_by_its_values_or_of_more_than_six_by_its_ends(values, attrs, said):
    values = np.array(values)
    dims, usual = ["at", "n"][-values.ndim :], {"long_name": "the height", "units": "mm", "quantity": "length"}
    shown = xr.Dataset({"height": (dims, values, usual | attrs), "single": 1.0, "none": ("k", [])})
    assert tables.series_lines(shown) == [f"the height: {said}"]
    (first, second) = tables.series_lines(shown.assign_coords(n=np.arange(values.shape[-1]) + 1.0))  # without a label
    assert (first.partition(": 1")[0], second) == ("n", f"the height: {said}")


@pytest.mark.parametrize(
    ("period", "resting", "outcome", "line"),
    [(0, 0, 0, True), (3, 0, 0, False), (0, 1, 0, False), (0, 0, int(Outcome.STEP_LIMIT), False)],
)
def test_a_motion_that_does_not_repeat_is_said_to_have_the_numbers_of_one_run(period, resting, outcome, line):
    own = {"period": period, "resting": resting, "outcome": outcome}
    text = "the motion does not repeat: numbers are of one run, those of another differ"
    assert tables._unrepeated_lines(made(own)) == [text] * line
    several = made({name: ("k", [value, int(name == "period"), int(name != "outcome")]) for name, value in own.items()})
    text = "1 of 3 motions do not repeat: numbers are of one run, those of another differ"
    assert tables._unrepeated_lines(several) == [text] * line
    assert tables._unrepeated_lines(made({"outcome": outcome})) == []
