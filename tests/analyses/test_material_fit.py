"""Fitted materials in words, of made-up fits."""

import pytest

from gelcone.analyses import (
    material_fit,
)  # fmt: skip
from tests.analyses.said import NAN
from tests.edited import edited, made


def test_the_quality_of_a_fitted_material():
    law = ("law", "branch_count")
    found = made(
        {"fit_error": (law, [[0.02, 0.01]]), "prediction_error": (law, [[0.05, NAN]])},
        {"law": ("law", ["gent"]), "branch_count": ("branch_count", [0, 1])},
        chosen_law="gent", chosen_branches=0, band=0.125, band_mean=0.95, band_least=0.85,
    )  # fmt: skip
    assert material_fit._quality_lines(found) == [
        "mean error 2.00% of a test's largest stress; each test predicted from the others: 5.00%",
        "a prediction is within +-12.5% of a test's largest stress; this band, from the other tests, covers a test "
        "to 95% in "
        "the mean and 85% at worst",
    ]
    few = material_fit._quality_lines(found.assign_attrs(chosen_branches=1))
    assert few == [
        "mean error 1.00% of a test's largest stress; too few tests to leave one out: the error of a prediction is "
        "not known"
    ]
    _, counts, row, chosen = material_fit._compared_lines(found)
    assert (counts.split(), row.split()) == (["0", "1"], ["gent", "5.00", "-"])
    assert chosen.startswith("chosen: gent, 0: the fewest branches")
    assert material_fit._compared_lines(edited(found, prediction_error=NAN)) == []


def test_the_tests_and_notes_of_a_fitted_material():
    own = {"error": [0.0125, NAN, 0.5], "left_out_error": [0.25, NAN, NAN], "voltage": [0.0, 1500.0, 0.0],
           "test_use": ["fit", "check", "leave out"], "test_mode": ["uniaxial", "pure shear", "equibiaxial"],
           "test_kind": ["ramp", "hold", "ramp"], "test_name": ["a.csv", "b.csv", "c.csv"]}  # fmt: skip
    found = made({n: ("test", v) for n, v in own.items()}, reading='[["in percent", ["a.csv", "b.csv"]]]')
    head, *rows = material_fit._test_lines(found)
    assert head == "tests: error, and predicted from the others, % of the largest stress"
    assert [" ".join(row.split()) for row in rows] == [
        "a.csv 1.25 25.00 uniaxial ramp",
        "b.csv - - pure shear hold, 1500 V, predicted only",
        "c.csv 50.00 - equibiaxial ramp, left out",
    ]
    assert material_fit.note_lines(found) == ["read as:", "  a.csv, b.csv: in percent"]
    assert material_fit.note_lines(found.assign_attrs(reading="[]")) == []
    many = material_fit._test_lines(found.isel(test=[0] * (material_fit.MOST_TESTS + 2)))
    assert many[-1] == "  and 2 more (all with --json or --out)"


@pytest.mark.parametrize(
    ("branches_", "flow", "rule"),
    [
        (0, None, "gent with 0 Maxwell branches"),
        (1, None, "gent with 1 Maxwell branch, logarithmic flow"),
        (2, "log", "gent with 2 Maxwell branches, logarithmic flow"),
        (2, "linear", "gent with 2 Maxwell branches, linear flow"),
    ],
)
def test_a_fitted_material_names_its_law_its_numbers_and_their_intervals(branches_, flow, rule, monkeypatch):
    from types import SimpleNamespace

    gel = SimpleNamespace(law="gent", branches=branches_, flow=flow, relative_permittivity=4.5)
    monkeypatch.setattr(material_fit, "fitted_material", lambda result: gel)
    for name in ("_quality_lines", "_compared_lines", "_test_lines", "note_lines"):
        monkeypatch.setattr(material_fit, name, lambda result, name=name: [name])
    own = {"value": [20e3, 50.0], "low": [18e3, NAN], "high": [24e3, NAN]}
    found = made(
        {n: ("parameter", v) for n, v in own.items()} | {"test_use": ("test", ["fit", "check", "fit"])},
        {"parameter": ("parameter", ["shear_modulus", "stretch_limit"])},
        title="material fit: a gel", temperature=NAN, permittivity_note="",
    )  # fmt: skip
    lines = [
        f"a gel: {rule}", "  fitted to 2 tests", "  shear_modulus 20 kPa (95 %: 18 to 24 kPa)",
        "  stretch_limit 50",
        "  relative_permittivity 4.5", "_quality_lines", "_compared_lines", "_test_lines", "note_lines",
    ]  # fmt: skip
    assert material_fit.fit_words(found).splitlines() == lines
    warm = material_fit.fit_words(found.assign_attrs(temperature=296.15, permittivity_note="stated")).splitlines()
    assert (warm[1], warm[4]) == ("  fitted to 2 tests at 23 degC", "  relative_permittivity 4.5 (stated)")
