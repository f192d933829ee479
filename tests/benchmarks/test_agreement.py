"""One question has one answer: the small version of ``benchmarks/agreement.py``."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

import gelcone


def loaded():
    path = Path(__file__).parents[2] / "benchmarks" / "agreement.py"
    spec = importlib.util.spec_from_file_location("agreement", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def agreement(monkeypatch):
    module = loaded()
    own = gelcone.find_device("biased-pump").replace(film="taut", voltage_amplitude=200.0)
    monkeypatch.setattr(module, "device", lambda rng: own)
    return module


def test_all_commands_give_one_answer_about_a_device(agreement, capsys):
    assert agreement.main(1, 7) == 0
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == len(agreement.QUESTIONS)
    without = [line for line in printed if " 0 compared" in line]
    assert len(without) == 2
    assert all("fitted charge" in line for line in without)  # of membranes alone


def test_a_difference_is_counted_and_printed_with_both_answers(agreement, capsys, monkeypatch):
    monkeypatch.setattr(
        agreement,
        "pairs",
        lambda own, ask: [("pull-in: static, limits", 2.0, 2.001), ("pull-in: static, limits", np.nan, np.nan),
                          ("stroke: settled, regime", np.nan, 1.0), ("stroke: settled, regime", np.inf, np.inf)],
    )  # fmt: skip
    assert agreement.main(2, 7) == 4
    printed = capsys.readouterr().out
    assert "device 8 (biased pumping cone, taut, sine): pull-in: static, limits: 2 and 2.001, 5.0e-04" in printed
    assert "pull-in: static, limits                       4 compared, at most 5.0e-04 apart" in printed


def test_a_refusal_is_counted_with_its_reason(agreement, capsys, monkeypatch):
    def refuse(own):
        raise gelcone.InputError("voltage = 3: is too much")

    refuse.__name__ = "settled"
    monkeypatch.setattr(agreement.gelcone, "settled", refuse)
    assert agreement.main(3, 7) == 0
    assert "refused 3 times by settled: voltage = 3: is too much" in capsys.readouterr().out


def test_random_devices_are_the_same_for_one_seed_and_differ_between_seeds():
    module = loaded()
    one, again, other = (module.device(np.random.default_rng(seed)) for seed in (3, 3, 4))
    assert one == again
    assert one != other
