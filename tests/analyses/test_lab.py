"""The answers of files of fits and designs: each by its own text and JSON."""

import pytest
import xarray as xr

import gelcone
from gelcone.analyses import lab
from gelcone.analyses.answer import plain
from tests.edited import made
from tests.recorded import record

KINDS = {"device fit": "device_fit", "material fit": "fit", "designs": "design"}


@pytest.mark.parametrize("title", KINDS)
def test_each_file_is_answered_by_its_own_command(monkeypatch, title):
    parts = {f"{name}_{form}": f"{name} {form}" for name in KINDS.values() for form in ("words", "json")}
    asked = record(monkeypatch, lab, fitted_device="the device", **parts)
    result = xr.Dataset(attrs={"title": f"{title}: soft film"})
    words, content = lab.lab_answer(result)
    name = KINDS[title]
    assert (words(), content()) == (f"{name} words", f"{name} json")
    for form in ("words", "json"):
        (call,) = asked[f"{name}_{form}"]
        assert call["result"] is result
    assert ("the device" in asked[f"{name}_words"][0].values()) == (title == "device fit")


def test_draws_say_of_which_device_they_are_and_every_field():
    draws = made({"spring_rate": ("draw", [20.0, 21.0], "N/m")}, title="draws of pump: as built", seed=5)
    draws["spring_rate"].attrs.update(long_name="spring rate", quantity="parameter")
    words, content = lab.lab_answer(draws)
    assert words().splitlines() == ["draws of pump: as built", "spring rate: 20 N/m, 21 N/m"]
    assert plain(content()) == {"seed": 5, "spring_rate": [20.0, 21.0]}


def test_a_plan_is_that_of_the_device_in_it(monkeypatch):
    asked = record(monkeypatch, lab, device_plan_words="the plan", device_fit_json="numbers")
    device = gelcone.find_device("biased-pump").replace(spring_rate=21.0)
    result = xr.Dataset(attrs={"title": "device plan: pump", "planned": device.to_toml()})
    words, content = lab.lab_answer(result)
    assert (words(), content()) == ("the plan", "numbers")
    assert [call["result"] is result for calls in asked.values() for call in calls] == [True, True]
    assert device in asked["device_plan_words"][0].values()


@pytest.mark.parametrize("title", ["parameter map", "device plan: of an older version", ""])
def test_another_result_has_no_answer_here(title):
    assert lab.lab_answer(xr.Dataset(attrs={"title": title})) is None
