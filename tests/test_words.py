"""Results in words, the same in figures and on the command line."""

import re

import numpy as np
import pytest
import xarray as xr

from gelcone import words
from gelcone.codes import Outcome, Regime
from gelcone.words import lasting, lasting_in_words, motion_in_words, rate_unit, unit_of, with_error


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


@pytest.mark.parametrize(
    ("kind", "period", "symmetric", "text"),
    [
        (Regime.PERIODIC, 2, True, "periodic, period 2, symmetric"),
        (Regime.PERIODIC, 3, False, "periodic, period 3"),
        (Regime.QUASI_PERIODIC, 0, False, "quasi-periodic"),
        (Regime.REST, 1, True, "rest"),
    ],
)
def test_motions_in_words(kind, period, symmetric, text):
    assert motion_in_words(kind, period, symmetric) == text


def test_outcomes_in_words():
    assert Outcome.STRETCH_LIMIT.words == "stretch limit"
    assert Outcome.NOT_FINITE.words == "not finite"


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


def test_chaos_that_ends_has_its_lifetime_in_one_unit():
    times = {"lifetime": 3e6, "lifetime_low": 9e5, "lifetime_high": 9e6}
    member = xr.Dataset({name: ((), value, {"units": "ms"}) for name, value in times.items()})
    member = member.assign(starts=16, share_chaotic=0.25, fate_regime=("fate", [-1]), fate_period=("fate", [0]))
    member = member.assign({f"fate_share{end}": ("fate", [0.0]) for end in ("", "_low", "_high")})
    expected = "chaos lasts 50 [15, 1.5e+02] min in the mean; 4 of 16 nearby starts are still chaotic"
    assert lasting_in_words(member) == [expected]


@pytest.mark.parametrize("named", [words.SHEET_ROWS | words.SHEET_DRIVE, words.FAILINGS], ids=["sheet", "failings"])
def test_a_number_shares_more_words_with_its_own_phrase_than_with_any_other(named):
    """Two phrases that were exchanged would show."""
    said = {name: set(re.findall(r"[a-z]+", phrase)) for name, phrase in named.items()}
    for name, own in said.items():
        shared = {other: len(set(name.split("_")) & phrase) for other, phrase in said.items()}
        assert shared[name] == max(shared.values()) > 0, (name, own)
