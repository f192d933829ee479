"""Units: what is read, what is refused and how, and the way back."""

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gelcone.devices.units import (
    DIMENSIONS,
    FieldError,
    format_si,
    parse,
    parse_deviation,
    parse_many,
    without_rounding,
)
from gelcone.errors import InputError

ALL_UNITS = [(si, unit) for si, dimension in DIMENSIONS.items() for unit in dimension.powers]


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("50 mm", "m", 0.05),
        ("50mm", "m", 0.05),
        ("0.3 mm", "m", 0.0003),
        ("5 um", "m", 5e-6),
        ("5 \u00b5m", "m", 5e-6),
        ("5 \u03bcm", "m", 5e-6),
        ("-2.5e-3 m", "m", -2.5e-3),
        (".5 cm", "m", 0.005),
        ("20 g", "kg", 0.02),
        ("1.2 kV", "V", 1200.0),
        ("3 mV", "V", 3e-3),
        ("3 MV", "V", 3e6),
        ("7.5 Hz", "Hz", 7.5),
        ("20 kPa", "Pa", 2e4),
        ("0.06 N/mm", "N/m", 60.0),
        ("60 mN/mm", "N/m", 60.0),
        ("0.04 N s/m", "N s/m", 0.04),
        ("0.04 N*s/m", "N s/m", 0.04),
        ("0.04 kg/s", "N s/m", 0.04),
        ("20 V/um", "V/m", 2e7),
        ("20 V/\u00b5m", "V/m", 2e7),
        ("20 kV/mm", "V/m", 2e7),
        ("20 MV/m", "V/m", 2e7),
        ("5 us", "s", 5e-6),
        ("10 mm/s", "m/s", 0.01),
        ("500 mN", "N", 0.5),
        ("1.2", "1", 1.2),
    ],
)
def test_a_string_is_read_to_the_nearest_double(text, unit, value):
    assert parse("field", text, unit) == value


@pytest.mark.parametrize("number", [0.05, 1, np.float64(0.05), np.float32(0.5), np.int64(3), np.array(0.05)])
def test_a_plain_number_means_si(number):
    result = parse("field", number, "m")
    assert type(result) is float
    assert result == float(number)


@pytest.mark.parametrize(
    "text",
    [
        *("", "mm", "fifty mm", "50", "nan mm", "inf", "inf mm", "1e9999 mm"),
        *("1,2 mm", "1_000 mm", "0x1 mm", "1/2 mm", "--1 mm", "1.2.3 mm", "1e mm", "5 0 mm", "\u0665 mm"),
        *("50  mm", " 50 mm", "50 mm ", "50\u00a0mm", "50 mm\n"),
        *("50 MM", "50 Mm", "50mm2", "50 m m", "50 meter", "50 kV", "50 V"),
    ],
)
def test_what_is_not_exact_is_refused_in_one_line(text):
    with pytest.raises(InputError) as caught:
        parse("film_radius", text, "m")
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(f"film_radius = {text!r}: ")
    assert "give a number in m or a string such as '50 mm' (units m, cm, mm, um, nm)" in message


@pytest.mark.parametrize(
    ("value", "unit", "reason"),
    [
        ("1,2 kV", "V", "holds a comma; write decimals with a point"),
        ("50 MM", "m", "'MM' is not a unit of length"),
        ("50", "m", "has no unit"),
        ("50 V", "m", "V is a unit of voltage, not of length"),
        ("", "m", "is not one decimal number and one unit"),
        ("x", "1", "is not one decimal number; give a plain number such as 1.2"),
        (math.nan, "m", "must be finite"),
        (-math.inf, "m", "must be finite"),
        (10**400, "m", "must be finite"),
        ("1e999 m", "m", "must be finite"),
        (True, "m", "must be a number or a string, not bool"),
        (None, "m", "must be a number or a string, not NoneType"),
        (1j, "m", "must be a number or a string, not complex"),
        (b"5 mm", "m", "must be a number or a string, not bytes"),
        ([1.0], "m", "must be one value, not several"),
    ],
)
def test_the_message_says_why(value, unit, reason):
    with pytest.raises(FieldError) as caught:
        parse("field", value, unit)
    assert reason in str(caught.value)
    assert caught.value.field == "field"


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ("5 Hz:10 Hz:3", "is a range, which only the command line reads; give a list such as ['5 Hz', '10 Hz'] or "
         "numpy.linspace(5, 10, 3), in Hz"),
        ("0.1 kHz:x:3", "is a range, which only the command line reads; give a list such as ['0.1 kHz', 'x']"),
        ("5 Hz,10 Hz", "lists several values, which only the command line reads; give a list: ['5 Hz', '10 Hz']"),
        ("5,10 Hz", "holds a comma; write decimals with a point; give a number in Hz or a string such as '8 Hz' "
         "(units Hz, kHz, mHz)"),
    ],
)  # fmt: skip
def test_several_values_in_one_text_are_refused_with_the_list_that_they_are(text, remedy):
    with pytest.raises(FieldError) as caught:
        parse_many("frequency", text, "Hz")
    assert str(caught.value) == f"frequency = {text!r}: {remedy}"


def test_bounds():
    assert parse("field", "0 m", "m", least=0.0) == 0.0
    assert parse("field", math.inf, "1", infinite=True) == math.inf
    with pytest.raises(InputError, match=r"field = '0 mm': must be greater than 0 m; give a larger one, such as 50 mm"):
        parse("field", "0 mm", "m", above=0.0)
    with pytest.raises(InputError, match="field = -1: must be at least 0 V"):
        parse("field", -1, "V", least=0.0)


def test_many_values():
    array = parse_many("field", ["1 kV", 2000, "3 kV"], "V")
    np.testing.assert_array_equal(array, [1000.0, 2000.0, 3000.0])
    assert not array.flags.writeable
    np.testing.assert_array_equal(parse_many("field", np.linspace(0, 1, 5), "V"), np.linspace(0, 1, 5))
    assert parse_many("field", "1 kV", "V") == 1000.0
    assert parse_many("field", np.float64(3.0), "V") == 3.0
    with pytest.raises(InputError, match=r"field\[1\] = '2 mm': mm is a unit of length, not of voltage"):
        parse_many("field", ["1 kV", "2 mm"], "V")
    with pytest.raises(InputError, match=r"field = \[\]: is empty; give at least one value"):
        parse_many("field", [], "V")
    with pytest.raises(InputError, match=r"the shape \(2, 3\): must be a number or one-dimensional"):
        parse_many("field", np.ones((2, 3)), "V")


@given(st.floats(1e-200, 1e200), st.sampled_from(["", "-", "+"]), st.sampled_from(ALL_UNITS), st.booleans())
def test_round_trip_of_unit_strings(size, sign, pair, spaced):
    si, unit = pair
    text = f"{sign}{size!r}{' ' if spaced and unit else ''}{unit}"
    expected = math.copysign(size, -1 if sign == "-" else 1) * 10.0 ** DIMENSIONS[si].powers[unit]
    assert parse("field", text, si) == pytest.approx(expected, rel=1e-14)


@given(st.floats(-1e12, 1e12), st.sampled_from(list(DIMENSIONS)), st.integers(1, 12))
def test_what_is_written_is_read_back(value, si, digits):
    written = format_si(value, si, digits)
    assert parse("field", written, si) == pytest.approx(value, rel=0.6 * 10.0 ** (1 - digits), abs=1e-300)


@pytest.mark.parametrize(
    ("value", "unit", "written"),
    [
        (0.0005, "m", "500 um"),
        (0.05, "m", "50 mm"),
        (0.99996, "m", "1 m"),
        (8400.0, "V", "8.4 kV"),
        (-0.0123, "m", "-12.3 mm"),
        (0.0, "N/m", "0 N/m"),
        (66.0912, "N/m", "66.09 N/m"),
        (2e7, "V/m", "20 MV/m"),
        (1.25, "1", "1.25"),
        (math.nan, "m", "nan m"),
    ],
)
def test_format(value, unit, written):
    assert format_si(value, unit) == written


WORTH = {
    **{"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "kg": 1.0, "g": 1e-3, "mg": 1e-6},
    **{"s": 1.0, "ms": 1e-3, "us": 1e-6, "Hz": 1.0, "kHz": 1e3, "mHz": 1e-3},
    **{"V": 1.0, "kV": 1e3, "mV": 1e-3, "MV": 1e6, "Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "N": 1.0, "mN": 1e-3},
    **{"m/s": 1.0, "mm/s": 1e-3, "N/m": 1.0, "kN/m": 1e3, "N/cm": 1e2, "N/mm": 1e3, "mN/mm": 1.0, "mN/m": 1e-3},
    **{"N s/m": 1.0, "N*s/m": 1.0, "kg/s": 1.0, "mN s/m": 1e-3, "g/s": 1e-3},
    **{"V/m": 1.0, "kV/m": 1e3, "V/mm": 1e3, "MV/m": 1e6, "kV/mm": 1e6, "V/um": 1e6},
    **{"m/s^2": 1.0, "m/s2": 1.0, "mm/s^2": 1e-3},
    **{"N/m^3": 1.0, "kN/m^3": 1e3, "MN/m^3": 1e6, "N/mm^3": 1e9, "mN/mm^3": 1e6},
    **{"F": 1.0, "mF": 1e-3, "uF": 1e-6, "nF": 1e-9, "pF": 1e-12},
    **{"A": 1.0, "mA": 1e-3, "uA": 1e-6, "nA": 1e-9, "C": 1.0, "mC": 1e-3, "uC": 1e-6, "nC": 1e-9},
    **{f"{k}{ohm}": worth for k, worth in (("", 1.0), ("k", 1e3), ("M", 1e6), ("G", 1e9)) for ohm in ("ohm", "Ohm")},
    **{"V/s": 1.0, "V/ms": 1e3, "V/us": 1e6, "kV/s": 1e3, "kV/ms": 1e6},
    **{"J/(m^3 K)": 1.0, "kJ/(m^3 K)": 1e3, "MJ/(m^3 K)": 1e6},
    **{"J": 1.0, "mJ": 1e-3, "uJ": 1e-6, "W": 1.0, "mW": 1e-3, "uW": 1e-6, "VA": 1.0, "mVA": 1e-3, "uVA": 1e-6},
    **{"nJ": 1e-9, "pJ": 1e-12, "nW": 1e-9, "pW": 1e-12, "nVA": 1e-9, "pVA": 1e-12, "uN": 1e-6, "nN": 1e-9},
    **{"pA": 1e-12, "pC": 1e-12},
}
"""What a unit is worth in SI units, by its prefixes."""
OHMS = [unit for unit in WORTH if unit.lower().endswith("ohm")]
WORTH |= {f"{ohm} {length}": WORTH[ohm] * WORTH[length] for ohm in OHMS for length in ("m", "cm")}


def test_long_times_are_given_in_minutes_and_hours():
    assert [parse("duration", given, "s") for given in ("90 min", "1.5h", "2e1 min")] == [5400.0, 5400.0, 1200.0]
    with pytest.raises(FieldError, match="min is a unit of time, not of length"):
        parse("field", "3 min", "m")


@pytest.mark.parametrize(("si", "unit"), [(si, unit) for si, unit in ALL_UNITS if unit])
def test_every_unit_is_worth_what_its_prefixes_say(si, unit):
    assert parse("field", f"3 {unit}", si) == pytest.approx(3.0 * WORTH[re.sub("[\u00b5\u03bc]", "u", unit)], rel=1e-15)


@pytest.mark.parametrize("values", [["1 mm", 0.002], ("1 mm", 0.002), np.array([0.001, 0.002])])
def test_lists_tuples_and_arrays_are_read_alike(values):
    found = parse_many("field", values, "m")
    np.testing.assert_array_equal(found, [0.001, 0.002])
    assert not found.flags.writeable


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.12345678, "123.5 mm"), (999.96e-3, "1 m"), (0.0, "0 m"), (math.inf, "inf m"), (-2.5e-6, "-2.5 um")],
)
def test_four_digits_are_shown(value, text):
    assert format_si(value, "m") == text


def test_a_message_lists_all_units_of_a_dimension_also_those_that_are_no_powers_of_ten():
    assert (
        DIMENSIONS["s"].accepted("s", "5 ms")
        == "give a number in s or a string such as '5 ms' (units s, ms, us, min, h)"
    )
    assert DIMENSIONS["1"].accepted("1", "1.2") == "give a plain number such as 1.2"


def test_a_deviation_is_a_share_of_the_value_or_has_its_unit():
    assert parse_deviation("rate", "3 %", "N/m", 20.0) == pytest.approx(0.6, rel=1e-15)
    assert parse_deviation("rate", " 3% ", "N/m", -20.0) == pytest.approx(0.6, rel=1e-15)
    assert parse_deviation("rate", "50 mN/m", "N/m", 20.0) == 0.05
    with pytest.raises(FieldError, match="rate = '3 %': is a share of 0; give the deviation with a unit"):
        parse_deviation("rate", "3 %", "N/m", 0.0)


@pytest.mark.parametrize("value", [[1.0], (1.0, 2.0), np.array([1.0, 2.0])])
def test_several_values_in_place_of_one_are_named_as_such(value):
    with pytest.raises(FieldError, match="must be one value, not several"):
        parse("thickness", value, "m")


def test_a_bound_that_may_be_infinite_is_so_upwards_alone():
    assert parse("limit", math.inf, "1", infinite=True) == math.inf
    for value, options in ((-math.inf, {"infinite": True}), (math.nan, {"infinite": True}), (math.inf, {})):
        with pytest.raises(InputError, match="must be finite"):
            parse("limit", value, "1", **options)


def test_a_message_has_the_example_that_is_given_or_that_of_the_dimension():
    with pytest.raises(InputError, match=r"such as '7 mm'"):
        parse("length", "wide", "m", example="7 mm")
    with pytest.raises(InputError, match=rf"such as '{DIMENSIONS['m'].example}'"):
        parse("length", "wide", "m")


def test_a_number_that_was_scaled_to_a_device_and_back_is_the_number_that_was_typed():
    scale, typed = np.linspace(900.0, 1100.0, 99)[:, None], np.array([700.0, 0.1, 1234.56789012, -3e-7, 0.0])
    scaled = typed / scale * scale
    assert (scaled != typed).any()
    typed = np.broadcast_to(typed, scaled.shape)
    np.testing.assert_array_equal(without_rounding(scaled), typed)
    assert without_rounding(700.0000000000001) == 700.0
    found = np.array([np.pi, 1.0 / 3.0, 700.0 + 1e-9, np.nan, np.inf])
    np.testing.assert_array_equal(without_rounding(found), found)
