"""Numbers with their units as text: digits, units in which they read well, and words for what is not finite."""

import numpy as np
import pytest
import xarray as xr

from gelcone.amounts import (
    lasting,
    measured,
    rate_unit,
    sized,
    sized_alike,
    sized_range,
    sized_with_error,
    time_unit,
    unit_of,
    with_error,
)

NAN = np.nan


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.0310, 0.0061, "+0.0310 ± 0.0061"),
        (-0.1, 1e-8, "-0.100000 ± 1e-08"),
        (1234.5, 12.0, "+1234 ± 12"),
        (0.05, 0.5, "+0.05 ± 0.50"),
        (3e-9, 1e-9, "+3.000e-09 ± 1.0e-09"),
        (0.25, 0.0, "+0.25"),
        (np.nan, 1.0, "unknown"),
        (np.inf, 1.0, "unknown"),
        (0.25, np.nan, "+0.25"),
        (0.25, np.inf, "+0.25"),
        (12345.6, 123.0, "+1.235e+04 ± 1.2e+02"),
        (0.123456789, 1.2e-7, "+0.123457 ± 1e-07"),
        (1.23456, 1.2e-4, "+1.23456 ± 0.00012"),
        (1e-8, 2e-7, "+0.00000001 ± 0.00000020"),
        (0.0, 0.5, "+0.00 ± 0.50"),
        (-0.01, 0.5, "-0.01 ± 0.50"),
        (1e5, 1.0, "+100000 ± 1"),
        (1e6, 1.0, "+1.000e+06 ± 1.0e+00"),
        (1.0, 9.9e-9, "+1.00000 ± 1e-08"),
    ],
)
def test_a_value_shows_the_digits_that_its_error_leaves(value, error, text):
    assert with_error(value, error) == text


def test_units_in_words():
    one, si = xr.DataArray(1.0, attrs={"units": "1"}), xr.DataArray(1.0, attrs={"units": "mm"})
    assert (unit_of(one), unit_of(si), unit_of(xr.DataArray(1.0))) == ("", " mm", "")
    assert (rate_unit(one), rate_unit(si), rate_unit(xr.DataArray(1.0))) == (
        "per unit time",
        "per second",
        "per unit time",
    )


@pytest.mark.parametrize(
    ("value", "units", "text"),
    [
        (1.539e6, "ms", "25.65 min"),
        (1999.0, "ms", "1999 ms"),
        (2000.0, "ms", "2 s"),
        (7.2e6, "ms", "2 h"),
        (1e12, "ms", "1.157e+04 days"),
        (600.0, "s", "10 min"),
        (1e5, "1", "1e+05 time units"),
        (np.inf, "ms", "infinite"),
    ],
)
def test_a_time_is_written_in_a_unit_that_one_can_imagine(value, units, text):
    assert lasting(value, xr.DataArray(value, attrs={"units": units}), 4) == text


@pytest.mark.parametrize(("value", "text"), [(999.999, "1000 ms"), (1540.0, "1500 ms"), (4.94e7, "14 h")])
def test_a_time_of_few_digits_has_no_exponent(value, text):
    assert lasting(value, xr.DataArray(value, attrs={"units": "ms"}), 2) == text


@pytest.mark.parametrize(
    ("value", "quantity", "unit", "text"),
    [
        (0.005, "length", "mm", "5 um"), (12.5, "length", "mm", "12.5 mm"), (1500.0, "voltage", "V", "1.5 kV"),
        (0.5, "power", "mW", "500 uW"), (12.5, "length", "1", "12.5"), (12.5, "none", "mm", "12.5 mm"),
        (NAN, "length", "mm", "unknown"), (np.inf, "length", "mm", "infinite"), (1.35e-51, "length", "mm", "0 mm"),
        (-9e-8, "length", "mm", "0 mm"), (2e-7, "length", "mm", "0.2 nm"), (9e-8, "power", "mW", "90 pW"),
        (1512.8, "apparent power", "mVA", "1.513 VA"), (1.904e-6, "force", "N", "1.904 uN"),
        (9.946e-10, "energy", "mJ", "0.9946 pJ"),
    ],
)  # fmt: skip
def test_a_number_with_the_unit_in_which_it_reads_well(value, quantity, unit, text):
    assert sized(xr.DataArray(value, attrs={"units": unit, "quantity": quantity})) == text


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [(0.123456, 3, "123 uW"), (0.123456, 5, "123.46 uW"), (12.3456, 3, "12.3 mW"), (-0.123456, 3, "-123 uW")],
)
def test_a_number_has_as_many_digits_as_are_asked_for(value, digits, text):
    attrs = {"units": "mW", "quantity": "power"}
    assert sized(xr.DataArray(value, attrs=attrs), digits) == text
    assert measured(xr.DataArray(value, attrs={"units": "N"}), digits) == f"{value:.{digits}g} N"


def test_a_number_has_four_digits_unless_others_are_asked_for():
    low, high = (xr.DataArray(value, attrs={"units": "mW", "quantity": "power"}) for value in (1.23456, 23.4567))
    assert (sized(low), measured(low)) == ("1.235 mW", "1.235 mW")
    assert sized_range(low, high) == "1.235 to 23.46 mW"


def test_a_text_is_itself_and_what_is_not_finite_is_said_in_its_own_words():
    assert measured(xr.DataArray("gent")) == "gent"
    own = {"units": "V", "nan_means": "not asked", "infinite_means": "never"}
    for value, usual, said in (
        (NAN, "unknown", "not asked"),
        (np.inf, "infinite", "never"),
        (-np.inf, "infinite", "never"),
    ):
        assert measured(xr.DataArray(value, attrs={"units": "V"})) == usual
        assert measured(xr.DataArray(value, attrs=own)) == said
        assert sized(xr.DataArray(value, attrs=own | {"quantity": "voltage"})) == said


@pytest.mark.parametrize(
    ("value", "unit", "size", "name"),
    [
        (1.0, "ms", 1.0, " ms"), (1e-3, "ms", 1.0, " ms"), (2e3, "ms", 1e3, " s"), (119e3, "ms", 1e3, " s"),
        (120e3, "ms", 6e4, " min"), (7.2e6, "ms", 3.6e6, " h"), (1.728e8, "ms", 8.64e7, " days"),
        (120.0, "s", 60.0, " min"), (1.0, "s", 1e-3, " ms"), (3.0, "h", 1.0, " h"), (5.0, "1", 1.0, " time units"),
        (5.0, "V", 1.0, " V"),
    ],
)  # fmt: skip
def test_the_unit_of_a_time_is_the_largest_of_which_there_are_two(value, unit, size, name):
    found = time_unit(value, xr.DataArray(value, attrs={"units": unit}))
    assert found == (pytest.approx(size), name)


def test_numbers_of_a_row_have_the_unit_of_the_largest_or_of_one_among_which_they_stand():
    lengths = xr.DataArray([0.02, 5.0, NAN], dims="k", attrs={"units": "mm", "quantity": "length"})
    assert sized_alike(lengths) == ["0.02 mm", "5 mm", "unknown"]
    assert sized_alike(lengths[:1]) == ["20 um"]
    assert sized_alike(lengths[:1], among=5.0) == ["0.02 mm"]  # 5 mm, in the unit of the variable


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (543.3, 41.2, "543 ± 41 uW"),
        (5433.0, 412.0, "5430 ± 410 uW"),
        (543.3, 412.0, "540 ± 410 uW"),
        (1.0, 30.0, "1 ± 30 uW"),
        (543.3456, 1e-7, "543.3456 ± 1e-07 uW"),
        (543.3, 0.0, "543.3 uW"),
        (543.3, NAN, "543.3 uW"),
        (NAN, 3.0, "unknown"),
    ],
)
def test_a_number_has_the_digits_that_its_error_leaves(value, error, text):
    number, its = (xr.DataArray(v, attrs={"units": "uW", "quantity": "power"}) for v in (value, error))
    assert sized_with_error(number, its, 5) == text
    assert sized_with_error(number, None, 5) == sized(number, 5)
