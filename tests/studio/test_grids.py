"""Cells of maps and strips are those of the command line, whoever computes them."""

from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone import InputError, Outcome
from gelcone.analyses.request import read_subject
from gelcone.devices.files import shipped_devices
from gelcone.studio import grids
from gelcone.studio.controls import controls_of
from gelcone.studio.grids import IMPOSSIBLE, PULLED_IN, Source, axis, even_tasks, kinds, thresholds

PUMP = Source(shipped_devices()["biased-pump"], None, {"settings": []})


def test_cells_of_a_device_are_those_of_regime():
    found = kinds(PUMP, {"voltage_amplitude": ["300 V", "500 V"], "frequency": ["9 Hz", "11 Hz"]})
    for k, (volts, hertz) in enumerate([("300 V", "9 Hz"), ("500 V", "11 Hz")]):
        device = gelcone.find_device("biased-pump").replace(voltage_amplitude=volts, frequency=hertz)
        one = gelcone.to_si(gelcone.regime(device.to_model(), device.initial_state()), device)
        assert found["regime"][k] == int(one.regime)
        assert found["high"][k] == float(one.highest)
        assert found["exponent"][k] == float(one.lyapunov[0])


def test_only_a_film_that_pulls_in_has_that_kind(monkeypatch):
    outcome = np.array([Outcome.OK, Outcome.PULLED_IN, Outcome.STRETCH_LIMIT, Outcome.STEP_LIMIT])
    blank, one = np.zeros(4), np.full(4, int(gelcone.Regime.PERIODIC))
    made = {"regime": ("", one), "lowest": ("", blank), "highest": ("", blank)}
    made |= {"section": ("", np.zeros((4, 2, 2))), "lyapunov": ("", np.zeros((4, 2)))}
    regime = SimpleNamespace(compute=lambda *given, **options: SimpleNamespace(outcome=outcome, variables=made))
    monkeypatch.setattr(grids, "ANALYSES", {"regime": regime})
    found = kinds(PUMP, {"frequency": ["9 Hz", "10 Hz", "11 Hz", "12 Hz"]})
    left = int(gelcone.Regime.LEFT_THE_DOMAIN)
    assert found["regime"].tolist() == [int(gelcone.Regime.PERIODIC), PULLED_IN, left, left]


def test_any_field_of_a_device_is_an_axis_and_what_cannot_be_built_says_so():
    found = kinds(PUMP, {"disc_radius": ["6 mm", "40 mm"]})
    assert found["regime"].tolist() == [gelcone.Regime.PERIODIC, IMPOSSIBLE]
    device = gelcone.find_device("biased-pump").replace(disc_radius="6 mm")
    one = gelcone.to_si(gelcone.regime(device.to_model(), device.initial_state()), device)
    assert found["high"][0] == pytest.approx(float(one.highest), rel=1e-12)


def test_cells_of_a_preset_take_starts_too():
    found = kinds(Source(None, None, {"preset": "base", "settings": []}), {"displacement": ["0.5", "1"]})
    assert found["regime"].tolist() == [gelcone.Regime.REST] * 2


def test_an_axis_holds_numbers_of_a_control():
    controls = controls_of(read_subject("biased-pump"))
    found = axis(controls, ["frequency", 5, 15], 11)
    assert found.texts([0, 10]) == ["5 Hz", "15 Hz"]
    for bad in (
        ["nothing", 0, 1],
        ["material", 0, 1],
        ["frequency", 2, 1],
        ["frequency", 0, "x"],
        "frequency",
        [[], 0, 1],
    ):
        with pytest.raises(InputError):
            axis(controls, bad, 11)


def test_thresholds_are_those_of_limits():
    preset = Source(None, None, {"preset": "base", "settings": []})
    lines = thresholds(preset, {"spring_stiffness": ["0.5", "0.9"]})
    model = gelcone.ConeModel.from_parameters(preset.subject().model.parameters()).replace(spring_stiffness=[0.5, 0.9])
    limits = gelcone.limits(model)
    np.testing.assert_array_equal(lines["pull-in of the cone at the peak"], limits.pull_in_voltage)
    np.testing.assert_array_equal(lines["rest becomes unstable"], limits.onset_voltage)


@pytest.mark.parametrize(("count", "sizes"), [(0, []), (20, [20]), (130, [33, 33, 32, 32]), (600, [120] * 5)])
def test_the_tasks_of_a_level_are_even(count, sizes):
    parts = even_tasks(np.arange(count), workers=2, most=128)
    assert [part.size for part in parts] == sizes
    assert np.concatenate([np.zeros(0), *parts]).tolist() == list(range(count))


def test_cells_that_pull_in_are_a_kind_of_their_own():
    source = Source(None, None, {"preset": "base", "settings": ["film=wrinkling", "rest_height=1"]})
    found = kinds(source, {"voltage": ["0.1", "3"]})
    assert found["regime"].tolist()[1] == PULLED_IN != found["regime"].tolist()[0]
    outcome = gelcone.regime(source.subject().model.replace(voltage=3.0), source.subject().initial).outcome
    assert int(outcome) == gelcone.Outcome.PULLED_IN
