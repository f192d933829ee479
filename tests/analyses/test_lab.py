"""The answers of files of fits and designs: each by its own text and JSON."""

import pytest
import xarray as xr

from gelcone.analyses import lab
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


@pytest.mark.parametrize("title", ["parameter map", ""])
def test_another_result_has_no_answer_here(title):
    assert lab.lab_answer(xr.Dataset(attrs={"title": title})) is None
