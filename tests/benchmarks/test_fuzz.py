"""A hundred of the inputs of `benchmarks/fuzz.py`, and that its judgement sees what it is to see."""

import json

import fuzz
import pytest


def test_a_hundred_bad_inputs_are_a_clear_line_each(monkeypatch):
    monkeypatch.setattr(fuzz, "COMPUTED", 0.0)
    monkeypatch.setattr(fuzz, "ALWAYS_COMPUTED", ("devices", "materials", "help"))
    failures = fuzz.run(100, seed=1, processes=0.0, files=0.0)
    assert failures == []


@pytest.mark.parametrize(
    ("code", "out", "err", "told"),
    [
        (0, "", "", ""),
        (2, "", "Error: no\n", ""),
        (2, "", "Warning: odd\nError: no\nError: neither\n", ""),
        (3, "", "Error: no", "exit code"),
        (2, "", "no", "not a line each"),
        (2, "", "", "not a line each"),
        (1, "", "Traceback (most recent call last):\nError: x", "traceback"),
        (0, json.dumps({"outcome": "ok", "displacement": [1.0, None]}), "", "no number"),
        (0, json.dumps({"outcome": "ok", "result": {"displacement": [None]}}), "", "no number"),
        (0, json.dumps({"outcome": "outside", "displacement": [None]}), "", ""),
        (0, '{"x": NaN}', "", "NaN in JSON"),
    ],
)
def test_the_judgement(code, out, err, told):
    found = fuzz.judge(code, out, err)
    assert told in found if told else found == ""


def test_a_fault_is_seen(monkeypatch):
    monkeypatch.setattr("gelcone.cli.command.arguments_of", lambda *_: 1 / 0)
    assert fuzz.try_line(["simulate"]).startswith("ZeroDivisionError")
