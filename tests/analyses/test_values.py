"""Numbers, lists and ranges from text, with the units of a device."""

import numpy as np
import pytest

from gelcone import InputError, find_device
from gelcone.analyses.values import (
    no_decimal_comma,
    of_field,
    parts_of,
    read_measures,
    read_numbers,
    read_pairs,
    read_value,
)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1.5", 1.5),
        ("-2e-3", -0.002),
        ("inf", np.inf),
        ("1,2.5", [1.0, 2.5]),
        ("0:2:5", [0.0, 0.5, 1.0, 1.5, 2.0]),
        ("-1:1:2", [-1.0, 1.0]),
        ("50 mm", "50 mm"),
        ("radial", "radial"),
        ("PVC-DBA 4:1", "PVC-DBA 4:1"),
    ],
)
def test_values_are_numbers_lists_ranges_or_text(text, value):
    np.testing.assert_array_equal(read_value(text), value)


def test_settings_keep_what_follows_the_first_equals_sign():
    assert read_pairs(("name=a=b", " voltage = 1 ")) == {"name": "a=b", "voltage": "1"}


@pytest.mark.parametrize(
    ("text", "quantity", "unit"),
    [("20 ms", "time", 0.02), ("1 s,2 s", "time", [1.0, 2.0]), ("0 V:1 kV:3", "voltage", [0.0, 500.0, 1000.0]),
     ("0, 5 mm", "length", [0.0, 0.005]),
     ("0 mm,5 mm", "length", [0.0, 0.005]), ("[0,5 mm]", "length", [0.0, 0.005]), ("0,5.5 mm", "length", [0.0, 0.0055]),
     ("0,2 mm,5 mm", "length", [0.0, 0.002, 0.005]), ("0,5e-3 m", "length", [0.0, 0.005])],
)  # fmt: skip
def test_a_measure_of_a_device_is_scaled_to_its_model(text, quantity, unit):
    device = find_device("soft-film")
    scale = getattr(device.scales, quantity)
    np.testing.assert_allclose(read_measures("--times", text, quantity, device) * scale, unit, rtol=1e-14)
    np.testing.assert_allclose(read_measures("--times", text, quantity, device, in_si=True), unit, rtol=1e-14)
    with pytest.raises(InputError, match="units need a device"):
        read_measures("--times", text, quantity, None)


@pytest.mark.parametrize("text", ["20", "20,40", "1:2:3", "20 ms,40"])
def test_a_bare_number_is_refused_with_a_device(text):
    with pytest.raises(InputError, match="has no unit"):
        read_measures("--times", text, "time", find_device("soft-film"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0:1:1", "--a '0:1:1': has 1 points; a range takes 2 to 100000"),
        ("0:1:100001", "--a '0:1:100001': has 100001 points; a range takes 2 to 100000"),
        ("0:1:x", "--a '0:1:x': must be a range from:to:count, for example 0:2:401"),
        ("0:inf:3", "--a '0:inf:3': the ends of a range must be finite"),
        ("nan:1:3", "--a 'nan:1:3': the ends of a range must be finite"),
        ("1:1:3", "--a '1:1:3': is empty or reversed; the first end must be below the second"),
        ("1:2", "--a '1:2': must be a range from:to:count, the last being the number of values: 1:2:21"),
        ("1,,2", "--a '1,,2': has an empty value; must be a number, a list v1,v2,... or a range from:to:count"),
        (",".join(["1"] * 100_001), "--a: has 100001 values; a list takes at most 100000"),
        (
            "1 mm,2",
            "--a '1 mm,2': 2 has no unit, but the others do; give each its unit, and write decimals with a point",
        ),
        (
            "-2, 1 mm",
            "--a '-2, 1 mm': -2 has no unit, but the others do; give each its unit, and write decimals with a point",
        ),
    ],
)
def test_numbers_that_cannot_be_are_refused_in_full_words(text, message):
    with pytest.raises(InputError) as error:
        read_numbers("--a", text, lambda option, part: float(part.removesuffix(" mm")))
    assert str(error.value) == message


def test_a_field_that_may_be_infinite_is_still_a_number():
    fields = find_device("soft-film").swept_fields()
    limit, radius = fields["material.stretch_limit"], fields["film_radius"]
    assert of_field("--set a", "inf", limit) == np.inf
    for text, field in (("nan", limit), ("-inf", limit), ("inf", radius)):
        with pytest.raises(InputError, match=rf"--set a {text}: must be finite"):
            of_field("--set a", text, field)


@pytest.mark.parametrize(
    ("text", "one", "two"),
    [
        ("0,3 mm", "0.3 mm", "0 mm,3 mm"), ("0,25mm", "0.25 mm", "0 mm,25 mm"), ("-0,5 mm", "-0.5 mm", "-0 mm,5 mm"),
        ("1,2 N s/m", "1.2 N s/m", "1 N s/m,2 N s/m"), ("0,2 mm,0,5 mm", "0.5 mm", "0 mm,5 mm"),
    ],
)  # fmt: skip
def test_a_decimal_comma_before_a_unit_is_refused_with_both_readings(text, one, two):
    with pytest.raises(InputError) as error:
        read_numbers("--a", text, lambda option, part: 0.0)
    remedy = f"looks like a decimal comma; write {one}, or of a list each unit: {two}"
    assert str(error.value) == f"--a {text!r}: {remedy}"


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("0:1:2", [0.0, 1.0]), ("0:1:100000", 100_000), (",".join(["1"] * 100_000), 100_000), ("0, 2 mm", [0.0, 2.0]),
        ("[1, 2]", [1.0, 2.0]), ("3", 3.0), ("[3]", 3.0), (" 0 : 1 mm : 2 ", [0.0, 1.0]),
    ],
)  # fmt: skip
def test_numbers_at_the_bound_are_read(text, values):
    found = read_numbers("--a", text, lambda option, part: float(part.removesuffix(" mm")))
    assert found.size == values if isinstance(values, int) else np.array_equal(found, values)


@pytest.mark.parametrize(
    ("text", "doubtful"),
    [
        ("0,5", True), ("-0,5", True), ("+1,2", True), ("[0,5]", False), ("0,5,1", False), ("0.5,1", False),
        ("1,-2", False), ("1,x", False),
    ],
)  # fmt: skip
def test_what_may_be_a_decimal_comma_is_asked_for(text, doubtful):
    parts = parts_of(text)
    if not doubtful:
        no_decimal_comma("--set a", text, parts)
        return
    one, two = ".".join(parts), ", ".join(parts)
    with pytest.raises(InputError) as error:
        no_decimal_comma("--set a", text, parts)
    assert (
        str(error.value) == f"--set a={text}: may be one number or two; write {one} with a point, or the list [{two}]"
    )
