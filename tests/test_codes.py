"""Outcomes and regimes: their numbers are written to files, their words are shown."""

import inspect
import json
import re

import numpy as np
import pytest
import xarray as xr

from gelcone.codes import FilmPullIn, Outcome, Regime, meanings
from gelcone.dataset import OUTCOME_ATTRIBUTES
from gelcone.physics.balance import PullIn
from tests.answers import SCHEMA


def test_numbers_in_files_keep_their_meaning():
    """Results on disk hold these numbers."""
    assert [outcome.name for outcome in sorted(Outcome)][:7] == [
        "OK",
        "OUTSIDE",
        "STRETCH_LIMIT",
        "STEP_LIMIT",
        "NOT_FINITE",
        "ERROR",
        "PULLED_IN",
    ]
    assert [int(kind) for kind in Regime] == [0, 1, 2, 3, 4, 5, 6]
    assert [kind.name for kind in Regime] == [
        "REST",
        "PERIODIC",
        "QUASI_PERIODIC",
        "CHAOTIC",
        "TRANSIENT",
        "LEFT_THE_DOMAIN",
        "TRANSIENT_CHAOS",
    ]


@pytest.mark.parametrize(
    ("kind", "label"),
    [
        (Regime.REST, "rest"),
        (Regime.QUASI_PERIODIC, "quasi-periodic"),
        (Regime.LEFT_THE_DOMAIN, "left the domain"),
        (Regime.CHAOTIC, "chaotic"),
    ],
)
def test_a_regime_in_words(kind, label):
    assert kind.label == label


def test_an_outcome_has_one_name_in_json_tables_and_the_schema_and_the_same_with_blanks_in_texts():
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))["properties"]["outcome"]["description"]
    labels = [outcome.label for outcome in Outcome]
    assert OUTCOME_ATTRIBUTES["flag_meanings"].split() == labels
    assert schema == f"How each run ended: {', '.join(labels)}."
    assert [outcome.words for outcome in Outcome] == [outcome.label.replace("_", " ") for outcome in Outcome]
    assert Outcome.PULLED_IN.words == "pulled in"


@pytest.mark.parametrize("kinds", [Outcome, Regime, PullIn])
def test_the_docstring_of_codes_lists_each_with_its_meaning(kinds):
    listed = re.findall(r"\* ``(\w+)``: (.*?) (?=\*|Examples)", " ".join(inspect.getdoc(kinds).split()))
    assert listed == [(kind.name, kind.meaning) for kind in kinds]


@pytest.mark.parametrize("kinds", [Outcome, Regime, PullIn, FilmPullIn])
def test_a_meaning_has_no_dimensionless_numbers_since_devices_have_units(kinds):
    assert not [kind.meaning for kind in kinds if re.search(r"\|x\||time unit|\bI1\b", kind.meaning)]


def test_every_outcome_says_in_one_line_of_its_own_what_happened():
    meanings = [outcome.meaning for outcome in Outcome]
    assert len(set(meanings)) == len(meanings)
    assert all(meaning and "\n" not in meaning for meaning in meanings)
    assert Outcome.OK.meaning == "ok"
    # what ends a run says what to do about it
    assert "raise stretch_limit" in Outcome.STRETCH_LIMIT.meaning
    assert "start lower" in Outcome.OUTSIDE.meaning
    assert "lower the voltage" in Outcome.PULLED_IN.meaning


def test_codes_have_the_words_of_their_variable_also_a_single_one_as_files_hold_it():
    several = xr.DataArray(
        [0, 3], attrs={"flag_values": np.array([0, 3], dtype=np.int8), "flag_meanings": "rest chaos"}
    )
    assert meanings(several) == {0: "rest", 3: "chaos"}
    assert meanings(xr.DataArray(3, attrs={"flag_values": np.int8(3), "flag_meanings": "chaos"})) == {3: "chaos"}
