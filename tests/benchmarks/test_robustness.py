"""No member is silently wrong: the small version of ``benchmarks/robustness.py``."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from gelcone.motion import heyoka

MEMBERS = 200


@pytest.fixture
def robustness(monkeypatch):
    path = Path(__file__).parents[2] / "benchmarks" / "robustness.py"
    spec = importlib.util.spec_from_file_location("robustness", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(heyoka, "SMALLEST_STEP", heyoka.SMALLEST_STEP)  # the benchmark changes it for a second run
    return module


def test_random_members_are_right_or_say_why_not(robustness, capsys):
    with np.errstate(all="ignore"):  # near the wall deviations grow beyond what squares of doubles hold
        code = robustness.main(MEMBERS)
    printed = capsys.readouterr().out
    assert code == 0, printed
    assert "ok members beyond the stretch limit: 0" in printed
