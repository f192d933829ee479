"""`gelcone design`: each design has a file of its own, next to the table and the figure."""

import json

import pytest

import gelcone
from gelcone.lab import design as designs
from tests.lab.quick_design import quick_wish
from tests.plots.made_up import result


def test_each_design_has_its_own_file(command_line, tmp_path, monkeypatch, undrawn):
    devices = [gelcone.find_device("biased-pump").replace(name=f"pump {k}", spring_rate=10.0 * k) for k in (1, 2)]
    numbers = ("stroke", "peak_voltage", "apparent_power", "recommended", "probability", "relaxed")
    numbers += ("probability_low", "probability_high", "distance")
    found = result(
        {name: ("design", [1.0, 2.0]) for name in numbers}
        | {"spring_rate": ("design", [10.0, 20.0])}
        | {name: ("design", ["pull-in", "stroke"]) for name in ("first_limit", "binding_requirement")},
        {"design": ("design", [1, 2])},
        {"spring_rate": "N/m"},
        {
            "title": "designs: pump", "gelcone_version": gelcone.__version__,
            "film": "membrane", "frequency": 10.0, "margin": 0.2, "confidence": 0.9, "nominal_probability": 0.4,
                "nominal_probabilities": '{"apparent_power": 0.4}',
            "free": '["spring_rate"]', "objectives": '["apparent_power"]', "left_out": "[]",
            "devices": json.dumps([device.to_toml() for device in devices]),
        },
    )  # fmt: skip
    asked = []
    monkeypatch.setattr(designs, "design", lambda wish, **options: asked.append(options) or found)
    (tmp_path / "wish.toml").write_text(quick_wish(), encoding="utf-8")
    code, out, err = command_line("design", "wish.toml", "--out", "made")
    assert code == 0, err
    for k, device in enumerate(devices, start=1):
        assert f"design-{k}.toml" in out
        assert gelcone.Device.from_toml(tmp_path / "made" / f"design-{k}.toml") == device
    assert command_line("design", "wish.toml", "--out", "made")[0] == 2  # nothing is overwritten
    (tmp_path / "draws.csv").write_text("moving_mass [g]\n5\n6\n7\n")
    assert command_line("design", "wish.toml", "--samples", "draws.csv", "--nominal", "--seed", "3")[0] == 0
    first, last = asked
    assert (first["samples"], first["nominal"], first["seed"]) == (None, False, 0)
    assert (last["nominal"], last["seed"]) == (True, 3)
    assert {name: values.tolist() for name, values in last["samples"].items()} == {
        "moving_mass": pytest.approx([5e-3, 6e-3, 7e-3])
    }
