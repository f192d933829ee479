"""The lines of a data sheet: names of its rows, values in the units in which they read well, and the first limit."""

from itertools import pairwise

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.amounts import sized
from gelcone.codes import Outcome
from gelcone.devices.scales import MEASURES
from gelcone.words import SHEET_ROWS, sheet_limits, sheet_rows
from tests.analyses.said import NAN, said
from tests.edited import edited, made

VOLTS = {"units": "V", "quantity": "voltage"}


@pytest.mark.parametrize("quantity", [name for name, own in MEASURES.items() if own.unit in ("N", "m", "W", "V", "A")])
def test_a_number_is_the_same_in_the_unit_in_which_it_reads_well(quantity):
    own = MEASURES[quantity]
    shown = sized(xr.DataArray(0.0125 * own.per_unit, attrs={"units": own.shown, "quantity": quantity}))
    assert shown in ("12.5 mN", "12.5 mm", "12.5 mW", "12.5 mV", "12.5 mA", "12.5 mVA")


def test_rows_have_the_names_of_their_numbers():
    sheet = xr.Dataset(
        {name: ("constant_voltage", [0.0, float(k)]) for k, name in enumerate(SHEET_ROWS, start=1)},
        {"constant_voltage": ("constant_voltage", [0.0, 500.0], VOLTS)},
    )
    rows = dict(sheet_rows(sheet))
    assert rows["constant voltage"] == ["500 V"]
    values = list(SHEET_ROWS)
    for words, name in (
        ("blocked force", "blocked_force"),
        ("  half width at half power", "half_width"),
        ("coupling factor, squared", "coupling"),
        ("power over moving mass", "mass_power"),
        ("rise time of a small step", "rise_time"),
    ):
        assert rows[words] == [f"{values.index(name) + 1}"]


def test_columns_stand_apart_where_their_words_are_long():
    """Of two films no capacitance is known."""
    device = gelcone.find_device("double-cone").replace(film="taut", second_film="taut")
    text = gelcone.in_words(gelcone.datasheet(device, ["0.5 kV", "1.2 kV"]))
    assert "unknown of two films  unknown of two films" in text


def test_the_half_width_has_the_unit_of_the_frequency():
    attrs = {"units": "Hz", "quantity": "frequency"}
    numbers = {name: ("constant_voltage", [0.0, 1.0]) for name in SHEET_ROWS}
    numbers |= {"natural_frequency": ("constant_voltage", [13.0, 13.15], attrs),
                "half_width": ("constant_voltage", [0.9, 0.982], attrs)}  # fmt: skip
    rows = dict(sheet_rows(xr.Dataset(numbers, {"constant_voltage": ("constant_voltage", [0.0, 500.0], VOLTS)})))
    assert (rows["natural frequency"], rows["  half width at half power"]) == (["13.15 Hz"], ["0.982 Hz"])


@pytest.mark.parametrize(
    ("first", "words"), [("driven pull-in", "pull-in of the drive"), ("pull-in", "pull-in on a slow ramp")]
)
def test_the_first_limit_is_that_of_the_drive_or_of_a_ramp(first, words):
    names = ("pull_in_voltage", "first_limit_voltage", "safe_peak_voltage", "dielectric_breakdown_voltage")
    numbers = zip(names, (3000.0, 1800.0, 1500.0, float("nan")), strict=True)
    sheet = xr.Dataset({name: ((), value, VOLTS) for name, value in numbers}, attrs={"first_limit": first})
    assert sheet_limits(sheet) == [
        "pull-in under constant voltage: 3 kV",
        f"first limit: {words}, at a peak of 1.8 kV",
        "below every limit: peaks up to 1.5 kV",
        "dielectric strength: unknown, breakdown is not accounted for",
    ]


@pytest.mark.parametrize(
    ("first", "words"),
    [
        ("driven pull-in", "membrane pull-in of the drive"),
        ("membrane pull-in", "membrane pull-in on a slow ramp"),
        ("pull-in", "cone pull-in on a slow ramp"),
    ],
)
def test_of_a_cone_every_pull_in_says_whose_it_is(first, words):
    names = ("pull_in_voltage", "membrane_pull_in_voltage", "first_limit_voltage", "safe_peak_voltage")
    numbers = zip((*names, "dielectric_breakdown_voltage"), (3000.0, 2000.0, 1800.0, 1500.0, 9000.0), strict=True)
    sheet = xr.Dataset({name: ((), value, VOLTS) for name, value in numbers}, attrs={"first_limit": first})
    assert sheet_limits(sheet.assign_attrs(pull_in_of="membrane")) == [
        "pull-in of the membrane under constant voltage: 2 kV",
        "pull-in of the cone under constant voltage: 3 kV",
        f"first limit: {words}, at a peak of 1.8 kV",
        "below every limit: peaks up to 1.5 kV",
    ]


@pytest.mark.parametrize(
    ("first", "words"),
    [("driven pull-in", "pull-in of the drive"), ("pull-in", "pull-in of the drive held at its peak")],
)
def test_below_the_columns_of_films_in_opposite_phase_pull_in_is_at_their_bias_and_peaks_in_proportion(first, words):
    numbers = {"pull_in_voltage": 2246.0, "ramp_begin_voltage": 1130.0, "first_limit_voltage": 2386.0}
    numbers |= {"safe_peak_voltage": 2300.0, "proportional_pull_in_voltage": 2386.0}
    numbers |= {"proportional_dielectric_breakdown_voltage": float("nan")}
    sheet = xr.Dataset({name: ((), value, VOLTS) for name, value in numbers.items()}, attrs={"first_limit": first})
    assert sheet_limits(sheet) == [
        "pull-in under constant voltage at the bias of 1.13 kV: 2.246 kV",
        f"first limit: {words}, at a peak of 2.386 kV, bias and amplitude in proportion",
        "below every limit: peaks up to 2.3 kV, bias and amplitude in proportion",
        "dielectric strength: unknown, breakdown is not accounted for",
    ]


@pytest.mark.parametrize(("draws", "last"), [(False, []), (True, ["95 % at 2 kV"])])
def test_the_columns_of_a_data_sheet_are_those_of_the_voltages_above_0(draws, last):
    from gelcone.analyses.datasheet import COLUMN_WIDTH, INTERVAL_WIDTH, NAME_WIDTH, datasheet_words

    along = "constant_voltage"
    own = {name: (along, [0.0, 1.0 + k, 100.0 + k]) for k, name in enumerate(SHEET_ROWS)}
    own |= {f"{name}_{end}": (along, [0.0, 0.0, v]) for name in SHEET_ROWS for end, v in (("low", 5.0), ("high", 7.0))}
    own |= {"outcome": 0, "rest_displacement": 3.0, "apparent_power": NAN, "pull_in_voltage": 9.0}
    own |= {f"{name}_{end}": 4.0 for name in ("rest_displacement", "pull_in_voltage") for end in ("low", "high")}
    attrs = {"drawn": "{}", "failed": 0, "draws": 8} if draws else {}
    shown = made(own, {along: (along, [0.0, 1000.0, 2000.0], "V")}, **attrs)
    shown[along].attrs["quantity"] = "voltage"
    lines = said(datasheet_words, shown)
    widths = [COLUMN_WIDTH] * 2 + [INTERVAL_WIDTH] * draws

    def cells(line):
        assert len(line) == NAME_WIDTH + sum(widths)
        ends = np.cumsum([NAME_WIDTH, *widths])
        return [line[:NAME_WIDTH].rstrip(), *(line[a:b].strip() for a, b in pairwise(ends))]

    assert cells(lines[0]) == ["constant voltage", "1 kV", "2 kV", *last]
    for k, (name, line) in enumerate(zip(SHEET_ROWS.values(), lines[1:], strict=False)):
        assert cells(line) == [name, f"{1 + k}", f"{100 + k}", *(["5 to 7"] if draws else [])]
    rest = lines[1 + len(SHEET_ROWS) :]
    assert [line.split() for line in rest[:2]] == [
        ["rest", "height", "3", *(["(4)"] if draws else [])],
        ["stiffness", "at", "rest", "0", *(["(0)"] if draws else [])],
    ]
    assert rest[2] == f"pull-in under constant voltage: 9{', 95 % within 4' if draws else ''}"
    failed = said(datasheet_words, edited(shown, outcome=int(Outcome.PULLED_IN)))
    assert failed == [f"failed: {Outcome.PULLED_IN.meaning}", *lines]
