"""Measured devices: predictions with their intervals, what is refused, and the pages that ship."""

from pathlib import Path

import numpy as np
import pytest

import gelcone
from gelcone.errors import InputError
from gelcone.lab.page import compare_measured, page_words

PAGES = Path(__file__).parents[2] / "docs" / "measured"
STATED = 'kind = "stated", sentence = "as stated"'
PUMP = f"""
title = "Bench cone"
source = "made up"
missing = ["breakdown"]
[device]
film = {{value = "taut", {STATED}}}
material = {{value = "PVC-DBA 6:1", {STATED}}}
disc_radius = {{value = 8, unit = "mm", {STATED}}}
film_radius = {{value = 30, unit = "mm", {STATED}}}
film_thickness = {{value = 0.2, unit = "mm", {STATED}}}
meridional_prestretch = {{value = 1.1, {STATED}}}
hoop_prestretch = {{value = 1.4, {STATED}}}
spring_rate = {{value = 15, unit = "N/m", kind = "derived", sentence = "of its wire"}}
initial_height = {{value = 20, unit = "mm", {STATED}}}
moving_mass = {{value = 5, unit = "g", kind = "assumed", sentence = "not stated", deviation = "30 %"}}
damping_coefficient = {{value = 10, unit = "mN s/m", {STATED}}}
voltage_amplitude = {{value = 60, unit = "V", {STATED}}}
voltage_offset = {{value = 1, unit = "kV", {STATED}}}
frequency = {{value = 10, unit = "Hz", {STATED}}}
"""


def measured(quantity, value, unit):
    said = {
        "quantity": f'"{quantity}"',
        "value": value,
        "unit": f'"{unit}"',
        "kind": '"digitised"',
        "sentence": '"fig."',
    }
    return "[[measured]]\n" + "".join(f"{name} = {own}\n" for name, own in said.items())


@pytest.fixture
def page(tmp_path):
    def read(text):
        (tmp_path / "page.toml").write_text(text, encoding="utf-8")
        return compare_measured(tmp_path / "page.toml")

    return read


def test_what_is_measured_is_inside_outside_or_rests_on_assumed_numbers(page):
    own = gelcone.find_device("biased-pump").replace(film="taut")
    known = float(gelcone.static(own, ["1.5 kV"])["stroke"][0])
    found = page(
        PUMP + measured("stroke@1.5 kV", known, "mm") + measured("stroke@1.5 kV", 2.0 * known, "mm")
        + measured("natural frequency@1 kV", 10.9, "Hz")
    )  # fmt: skip
    inside, outside, refused = found.compared
    assert (inside.verdict, outside.verdict) == ("inside", "outside")
    assert inside.low < 1e-3 * known < inside.high
    assert inside.predicted == pytest.approx(1e-3 * known, rel=0.02)
    assert refused.verdict == "not compared: it rests on assumed numbers (moving_mass 99%)"
    words = page_words(found)
    assert "1 of 2 inside the interval of their prediction" in words
    assert "missing: breakdown" in words


def test_a_measured_value_counts_with_its_own_deviation_and_half_of_a_variance_refuses(page):
    first = page(PUMP + measured("stroke@1.5 kV", 1.0, "mm")).compared[0]
    own = (first.high - first.predicted) / 1.96
    for share, verdict in ((1.7, "inside"), (2.2, "outside")):
        value = first.predicted
        for _ in range(20):  # the deviation is a share of the value
            value = first.predicted + share * np.hypot(own, 0.02 * value)
        found = page(PUMP + measured("stroke@1.5 kV", 1e3 * value, "mm")).compared[0]
        assert found.verdict == verdict
    for deviation, refused in (("30 %", True), ("80 %", False)):  # of the spring, next to which the mass is assumed
        text = PUMP.replace('kind = "derived"', f'kind = "derived", deviation = "{deviation}"')
        verdict = page(text + measured("natural frequency@1 kV", 10.9, "Hz")).compared[0].verdict
        assert verdict.startswith("not compared: it rests on assumed numbers (moving_mass") == refused


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('value = "taut"', 'value = "os:path"', "'os:path' is not a film"),
        ('value = "PVC-DBA 6:1"', 'value = "os:path"', "'os:path' is not a material"),
        ('unit = "N/m"', 'unit = "kV"', "kV is a unit of voltage, not of stiffness"),
        (', deviation = "30 %"', "", "is assumed; say how far off it may be"),
        ('kind = "derived"', 'kind = "guessed"', "'guessed' is not a kind of number; known: stated, derived"),
        ('sentence = "of its wire"', 'sentence = ""', "the sentence that states it is missing"),
        ("value = 15", 'value = "15"', "spring_rate"),
        ("spring_rate =", "spring_rat =", "did you mean 'spring_rate'"),
        ("value = 0.2", "value = -0.2", "must be greater than 0"),
        ('title = "Bench cone"', "", "title or source is missing"),
        ("[device]", "[devices]", "'devices' is not a key of a measured device"),
    ],
)
def test_a_page_that_cannot_be_used_is_refused_in_one_line(page, old, new, message):
    with pytest.raises(InputError, match=message) as caught:
        page(PUMP.replace(old, new, 1))
    assert "\n" not in str(caught.value)


def test_a_file_elsewhere_is_not_read(page):
    head = 'title = "a"\nsource = "b"\n'
    with pytest.raises(InputError, match="must lie in the folder of the list"):
        page(head + '[coupons]\ntests = "../tests.toml"\n')
    with pytest.raises(InputError, match="does not say what is missing"):
        page(head)


@pytest.mark.parametrize("name", ["cao-2018", "cao-2019", "huang-2020", "greaney-2019"])
def test_pages_of_which_numbers_are_missing_compare_nothing(name):
    found = compare_measured(PAGES / f"{name}.toml")
    assert not found.compared
    assert found.missing
    assert "nothing is compared" in page_words(found)


def test_tests_on_vhb_are_predicted_from_each_other():
    found = compare_measured(PAGES / "vhb.toml")
    inside = [one for one in found.compared if one.verdict.startswith("inside")]
    assert (len(found.compared), len(inside)) == (13, 11)
