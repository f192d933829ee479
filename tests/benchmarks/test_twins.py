"""Twins have one answer: the small version of ``benchmarks/twins.py``."""

import numpy as np
import pytest
import random_models
import twins
import xarray as xr

from gelcone import ConeModel

PUMP = {"rest_height": 0.8, "hoop_prestretch": 1.4, "damping_ratio": 0.25, "voltage": 0.2, "voltage_bias": 0.4}


def report(twin, monkeypatch, capsys):
    """The number of differences of a twin, and the lines that are printed."""
    monkeypatch.setattr(twins, "KINDS", {"made up": lambda draw: twin})
    return twins.main(1, 5, []), capsys.readouterr().out.splitlines()


def test_a_model_is_its_own_twin(monkeypatch, capsys):
    one = ConeModel(**PUMP)
    wrong, lines = report(twins.Twin(one, one, ("run", "step"), bound=twins.EXACT), monkeypatch, capsys)
    assert wrong == 0
    assert "at most 0.0e+00 of the bound" in lines[0]


def test_a_difference_of_a_number_a_flag_or_a_refusal_is_counted(monkeypatch, capsys):
    one = ConeModel(**PUMP)
    wrong, lines = report(twins.Twin(one, one.replace(voltage_bias=0.4001), ("run",)), monkeypatch, capsys)
    assert wrong == len(lines) - 1 > 10
    assert any("made up 5: run: displacement, " in line for line in lines)
    slack = one.replace(hoop_prestretch=1.05)
    _, lines = report(twins.Twin(one, slack, ("run",), but=("displ",)), monkeypatch, capsys)
    assert any("run: validity_hoop_slack" in line for line in lines)
    burst = one.replace(waveform="samples")
    wrong, lines = report(twins.Twin(one, burst, ("settled",)), monkeypatch, capsys)
    assert wrong == 1
    assert "made up 5: settled: " in lines[0]
    assert "inf times the bound" in lines[0]


def test_numbers_are_compared_in_the_units_of_each_model():
    """A stiffness, and a phase whose amplitude vanishes."""

    def answer(stiffness, phase):
        values = {"stiffness": (stiffness, "stiffness"), "gain": (0.0, "gain"), "phase": (phase, "angle")}
        return xr.Dataset({name: ((), value, {"quantity": of}) for name, (value, of) in values.items()})

    units = dict.fromkeys("ltevcf", 1.0) | {"e": 8.0, "l": 2.0}
    one, other = answer(3.0, 10.0), answer(6.0, 20.0)
    assert {away for _, away in twins.apart(one, other, units, ())} == {0.0}
    found = dict(twins.apart(one, other, units | {"e": 4.0}, ()))
    assert found["stiffness, [3.] [6.]"] == pytest.approx(1.0)
    assert [away for _, away in twins.apart(one, other.drop_vars("gain").drop_vars("phase"), units, ("phase",))] == [
        np.inf,
        0.0,
    ]


@pytest.mark.parametrize("kind", ["mirrored", "another size"])
def test_twins_of_a_static_question_agree(kind, monkeypatch, capsys):
    draws = (twins.KINDS[kind](random_models.Draw(number)) for number in range(40, 44))
    made = next(twin for twin in draws if getattr(twin.one, "film", "membrane") != "membrane")
    made.ask = ("limits",)
    wrong, lines = report(made, monkeypatch, capsys)
    assert wrong == 0, lines


def test_parts_are_the_same_for_numbers_in_a_row_and_their_numbers_differ():
    first = random_models.SAME * 11
    one, other, again = (random_models.actuator(random_models.Draw(first + k)) for k in (0, 1, 0))
    assert one == again
    assert one.keys() == other.keys()
    assert one["spring_stiffness"] != other["spring_stiffness"]


def test_waveforms_of_both_signs_and_of_two_forms_are_those():
    tau = np.linspace(0.0, 7.0, 200)
    for number in range(0, 40, random_models.SAME):
        draw = random_models.Draw(number)
        one, other = (ConeModel(waveform=wave) for wave in random_models.waves_of_both_signs(draw))
        voltages = [own.system.waveform.voltage(tau, own.members().numbers()) for own in (one, other)]
        np.testing.assert_allclose(voltages[0], -voltages[1], atol=1e-12)
