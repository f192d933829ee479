"""Measured devices: predictions with their intervals, what is refused, and the pages that ship."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.errors import InputError
from gelcone.lab import page as module
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


class Made:
    """A problem with three free fields, whose predictions are a sum of weights times logarithms of factors."""

    free = {"a": 0.1, "b": 0.2, "c": 0.05}


def numbers(**kinds):
    return {name: module.Number(1.0, Made.free[name], kind) for name, kind in kinds.items()}


def weights(monkeypatch, *own):
    asked = module.Asked("stroke@1 kV", "stroke", 1e3)
    monkeypatch.setattr(module, "predicted_values", lambda problem, logs, asked: np.asarray(logs) @ np.array(own))
    return asked


def test_assumed_numbers_are_blamed_for_more_than_half_of_a_variance_the_strongest_first(monkeypatch):
    """Shares of the variance are (weight x deviation)^2: here 1, 4 and 9 of 14."""
    asked = weights(monkeypatch, 10.0, 10.0, 60.0)
    kinds = {"a": "assumed", "b": "stated", "c": "assumed"}
    assert module._assumed(Made, numbers(**kinds), asked) == ["c 64%", "a 7%"]
    assert module._assumed(Made, numbers(a="assumed", b="assumed", c="stated"), asked) == []
    assert module._assumed(Made, numbers(a="stated", b="stated", c="assumed"), asked) == ["c 64%"]
    asked = weights(monkeypatch, 10.0, 5.0, 0.0)  # one half each
    assert module._assumed(Made, numbers(a="assumed", b="stated", c="stated"), asked) == []
    asked = weights(monkeypatch, 10.0, 4.99, 0.0)
    assert module._assumed(Made, numbers(a="assumed", b="stated", c="assumed"), asked) == ["a 50%"]


def compared(monkeypatch, drawn, value, deviation="10 %"):
    monkeypatch.setattr(module, "predicted_values", lambda problem, logs, asked: np.asarray(drawn))
    monkeypatch.setattr(module, "_assumed", lambda *given: [])
    entry = {"quantity": "stroke@1 kV", "value": value, "unit": "mm", "kind": "stated", "sentence": "s",
             "deviation": deviation}  # fmt: skip
    return module._compared(Path("p.toml"), Made, {}, np.zeros((2, 3)), 1, entry)


def test_an_interval_holds_95_per_cent_of_the_draws_and_counts_on_the_side_of_what_was_measured(monkeypatch):
    """Draws from 0 to 2 below their middle and to 6 above it, so that the sides differ."""
    drawn = 1e-3 * np.concatenate([np.linspace(0.0, 2.0, 201), np.linspace(2.0, 6.0, 201)[1:]])
    found = compared(monkeypatch, drawn, 2.0)
    assert (found.low, found.predicted, found.high) == pytest.approx((1e-4, 2e-3, 5.8e-3))
    assert (found.measured, found.unit, found.verdict, found.quantity) == (2e-3, "m", "inside", "stroke@1 kV")
    above = np.hypot(3.8, 1.96 * 0.1 * 6.0)  # of a value of 6 mm
    assert above < 4.0 < np.hypot(3.8, 1.96 * 0.2 * 6.0)
    assert compared(monkeypatch, drawn, 6.0).verdict == "outside"
    assert compared(monkeypatch, drawn, 6.0, "20 %").verdict == "inside"
    assert compared(monkeypatch, drawn, 0.05, "1 %").verdict == "outside"
    assert compared(monkeypatch, drawn, 0.15, "1 %").verdict == "inside"
    lost = compared(monkeypatch, [1e-3, np.nan, 1e-3, 1e-3], 1.0)
    assert lost.verdict == "not compared: 25% of the draws have no such state"
    assert np.isnan(compared(monkeypatch, [np.nan] * 4, 1.0).predicted)


def test_free_fields_are_those_that_are_not_certain_by_their_relative_deviation(page, monkeypatch):
    seen = {}

    def made(path, problem, numbers, logs, k, entry):
        seen.update(free=dict(problem.free), logs=logs, numbers=numbers, device=problem.device)
        return module.Comparison("q", 1.0, 0.5, 1.5, 1.0, "m", "inside")

    monkeypatch.setattr(module, "_compared", made)
    page(PUMP + measured("stroke@1.5 kV", 1.0, "mm"))
    assert seen["free"]["moving_mass"] == pytest.approx(0.3)
    assert seen["free"]["spring_rate"] == pytest.approx(0.03)
    assert seen["free"]["disc_radius"] == pytest.approx(0.01)
    assert seen["numbers"]["moving_mass"] == module.Number(pytest.approx(5e-3), pytest.approx(1.5e-3), "assumed")
    assert seen["logs"].shape == (256, len(seen["free"]))
    spread = seen["logs"].std(axis=0) / np.array(list(seen["free"].values()))
    assert ((spread > 0.8) & (spread < 1.2)).all()
    assert (seen["device"].name, seen["device"].film) == ("page", "taut")


def test_a_coupon_is_inside_where_nine_tenths_of_its_samples_are_within_the_band_of_its_own_stress(monkeypatch):
    """The band is 0.1 of each test's largest stress: 4 and 2 kPa."""
    stress = np.array([*np.linspace(0.0, 4.0, 10), *np.linspace(0.0, -2.0, 10), 1.0])
    off = np.array([0.39] * 9 + [0.41] + [0.19] * 8 + [0.21] * 2 + [0.0])
    off[18] = 3.0  # in the second test: neither its first nor its last sample has the largest stress predicted
    found = xr.Dataset(
        {
            "sample_test": ("sample", [0] * 10 + [1] * 10 + [2]),
            "stress": ("sample", stress),
            "left_out": ("sample", np.where(np.arange(21) == 20, np.nan, stress + off)),
            "largest_stress": ("test", [4.0, 2.0, 1.0]),
            "test_name": ("test", ["a", "b", "c"]),
        },
        attrs={"band": 0.1},
    )
    asked = {}
    monkeypatch.setattr(module, "read_tests", lambda path: asked.update(path=path) or "tests")
    monkeypatch.setattr(
        module, "fit_material", lambda tests, known, **options: asked.update(known=known, options=options) or found
    )
    given = {"tests": "t.toml", "material": "gel", "law": "yeoh", "branches": 2}
    first, second = module._coupons(Path("folder", "p.toml"), given, None)
    assert (first.quantity, first.verdict) == ("a: largest stress", "inside (90% of 10 samples)")
    assert second.verdict == "outside (80% of 10 samples)"
    assert (first.predicted, first.low, first.high, first.measured) == pytest.approx((4410.0, 4010.0, 4810.0, 4000.0))
    assert (second.predicted, second.measured) == pytest.approx((-1790.0, -2000.0))
    assert second.high - second.low == pytest.approx(400.0)
    assert asked["path"] == Path("folder", "t.toml")
    assert asked["known"] == {"name": "gel"}
    assert asked["options"] == {"laws": ["yeoh"], "branches": [2], "draws": 0, "progress": None}
    module._coupons(Path("folder", "p.toml"), {"tests": "t.toml"}, None)
    assert (asked["known"], asked["options"]["laws"], asked["options"]["branches"]) == ({"name": "p"}, None, None)
