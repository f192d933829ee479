"""Results in words, the same in figures and on the command line."""

import re

import pytest
import xarray as xr

from gelcone import words
from gelcone.codes import Outcome, Regime
from gelcone.words import lasting_in_words, motion_in_words


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
