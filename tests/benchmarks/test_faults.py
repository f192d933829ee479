"""A run that is killed loses nothing: the small version of ``benchmarks/faults.py``."""

import importlib.util
from pathlib import Path

import pytest


@pytest.mark.slow
@pytest.mark.parametrize("kills", [1, 4])
def test_a_killed_run_is_resumed_to_the_same_bytes(kills, tmp_path, capsys, monkeypatch):
    path = Path(__file__).parents[2] / "benchmarks" / "faults.py"
    spec = importlib.util.spec_from_file_location("faults", path)
    faults = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(faults)
    small = {"voltage=0:2:96": "voltage=0:1.2:8", "prestretch=0.4:2:80": "prestretch=0.8:2:8", "16": "4"}
    monkeypatch.setattr(faults, "MAP", [small.get(argument, argument) for argument in faults.MAP])
    code = faults.main(kills, tmp_path)
    printed = capsys.readouterr().out
    assert code == 0, printed
    assert f"{kills} kills" in printed
    assert "the making of the store" in printed
