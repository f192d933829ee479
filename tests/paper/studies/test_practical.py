"""A device at practical voltages: what is asked of each part, and its numbers in volts and millimetres."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from gelcone.motion.settled import Swing
from gelcone.paper.effort import QUICK
from gelcone.paper.films import film_of_device
from gelcone.paper.studies import practical as module
from gelcone.physics.model import ConeModel

TINY = replace(QUICK, window=40.0, patience=77.0)
DEVICE = film_of_device("taut").replace(initial_height="20 mm", voltage_amplitude=[10.0, 30.0, 50.0])


class Evidence:
    """What a made-up classification gives."""

    final = np.array([[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]])


def test_the_start_is_a_window_and_the_long_run_what_has_settled(monkeypatch):
    """Of three voltages; the times are those of the effort, and the run settles for 40 times the slowest decay."""
    asked, shares = {}, []
    times = np.linspace(0.0, 40.0, 801)
    waves = 0.1 * np.array([[1.0], [2.0], [3.0]]) * np.sin(times) + np.array([[-0.05], [0.1], [0.9]])
    fields = np.array([[0.3], [0.2], [0.1]]) * (1.0 + np.cos(times))

    def simulate(model, state, times, progress):
        asked.update(model=model, state=state, times=times)
        progress(1.0)
        at = ("member", "time")
        of = {"units": "1", "quantity": "length", "long_name": "displacement"}
        return xr.Dataset(
            {
                "displacement": (at, waves, of),
                "true_field": (at, fields),
                "validity_slack": ("member", [0.1, 0.2, 0.3]),
                "validity_breakdown": ("member", [0.4, 0.5, 0.6]),
                "velocity": (at, waves),
            },
            coords={"time": ("time", times, {"units": "1", "quantity": "time", "long_name": "time"})},
        )

    def classify(members, states, **options):
        asked.update(options=options, states=states)
        return Evidence()

    def settled(members, states):
        asked.update(final=states)
        late = Swing.blank(3)
        late.lowest[:], late.highest[:] = [0.0, -0.2, 0.1], [0.2, 0.6, 0.9]
        return late

    def label(model, evidence, options, title):
        asked.update(evidence=evidence)
        values = np.array([1.0, 2.0, 3.0])
        return xr.Dataset(dict.fromkeys(("section", "lowest", "highest", "regime"), ("member", values)))

    monkeypatch.setattr(module, "simulate", simulate)
    monkeypatch.setattr(module, "classify", classify)
    monkeypatch.setattr(module, "swing", settled)
    monkeypatch.setattr(module, "label_evidence", label)
    monkeypatch.setattr(module, "_thresholds", lambda model: {"pull_in_voltage": ((), 2.0, "ramp", "voltage")})
    found = module._practical(DEVICE, TINY, shares.append)
    model, scales = DEVICE.to_model(), DEVICE.scales
    assert sum(shares) == pytest.approx(1.0)
    np.testing.assert_allclose(asked["times"], times)
    np.testing.assert_array_equal(asked["state"], DEVICE.initial_state())
    np.testing.assert_allclose(asked["states"], np.broadcast_to(DEVICE.initial_state(), (3, 2)))
    assert asked["options"] == {"transient": 40.0 / float(np.min(model.damping_ratio)), "patience": 77.0}
    assert isinstance(asked["evidence"], Evidence)
    np.testing.assert_array_equal(asked["final"], Evidence.final)
    millimetres = 1e3 * scales.length
    assert found["displacement"].dims == ("voltage_amplitude", "time")
    np.testing.assert_allclose(found["displacement"], waves * millimetres)
    np.testing.assert_allclose(found["time"], times * 1e3 * scales.time)
    np.testing.assert_allclose(found["window_amplitude"], 0.5 * np.ptp(waves, axis=1) * millimetres)
    np.testing.assert_allclose(found["late_amplitude"], np.array([0.1, 0.4, 0.4]) * millimetres)
    np.testing.assert_allclose(found["late_middle"], np.array([0.1, 0.2, 0.5]) * millimetres)
    np.testing.assert_allclose(
        found["largest_field"], [0.6e-6 * scales.field, 0.4e-6 * scales.field, 0.2e-6 * scales.field]
    )
    np.testing.assert_allclose(found["dielectric_strength"], 1e-6 * DEVICE.dielectric_strength)
    np.testing.assert_allclose(found["pull_in_voltage"], 2.0 * scales.voltage)
    np.testing.assert_array_equal(found["window_validity_slack"], [0.1, 0.2, 0.3])
    np.testing.assert_array_equal(found["window_validity_breakdown"], [0.4, 0.5, 0.6])
    np.testing.assert_array_equal(found["regime"], [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(found["voltage_amplitude"], [10.0, 30.0, 50.0])
    assert found["voltage_amplitude"].attrs == {"long_name": "voltage amplitude", "units": "V"}
    assert not {"section", "lowest", "highest", "velocity", "true_field"} & set(found.variables)


@pytest.mark.parametrize("height", [0.0, 0.1])
def test_thresholds_are_those_of_one_member_and_of_flat_rest_only_where_the_film_is_flat(monkeypatch, height):
    seen = []

    def found(**numbers):
        def of(model):
            seen.append((model.size, float(model.voltage[0])))
            return xr.Dataset({name: ("member", [value]) for name, value in numbers.items()})

        return of

    monkeypatch.setattr(module, "pitchfork_voltages", lambda model: np.array([1.5]))
    monkeypatch.setattr(module, "onset_voltage", found(onset_voltage=2.5))
    monkeypatch.setattr(module, "pull_in_voltage", found(pull_in_voltage=3.5, rest_displacement=0.7))
    thresholds = module._thresholds(ConeModel(voltage=[0.3, 0.4], rest_height=height))
    values = {name: float(value) for name, (dims, value, _, _) in thresholds.items() if dims == ()}
    onset = 2.5 if height == 0.0 else np.nan
    wanted = {"pitchfork_voltage": 1.5, "onset_voltage": onset, "pull_in_voltage": 3.5, "rest_displacement": 0.7}
    np.testing.assert_equal(values, wanted)
    assert [thresholds[name][3] for name in values] == ["voltage", "voltage", "voltage", "length"]
    assert seen == [(1, 0.3)] * (1 + (height == 0.0))


def test_both_heights_are_one_study_over_voltage_and_height(monkeypatch):
    devices, shares = [], []

    def part(device, effort, progress):
        devices.append(device)
        progress(1.0)
        return xr.Dataset({"late_amplitude": ("voltage_amplitude", module.VOLTS + 100.0 * len(devices))})

    monkeypatch.setattr(module, "_practical", part)
    found = module.practical(replace(TINY, film="wrinkling"), shares.append)
    assert sum(shares) == pytest.approx(1.0)
    assert [device.initial_height for device in devices] == [0.0, 0.02]
    for device in devices:
        np.testing.assert_array_equal(device.voltage_amplitude, module.VOLTS)
        assert device.film == "wrinkling"
    assert found["late_amplitude"].dims == ("initial_height", "voltage_amplitude")
    np.testing.assert_allclose(found["late_amplitude"], module.VOLTS + np.array([[100.0], [200.0]]))
    np.testing.assert_allclose(found["initial_height"], [0.0, 20.0])
    assert found["initial_height"].attrs["units"] == "mm"
    assert (found.attrs["preset"], found.attrs["parameter"]) == ("table1", "voltage_amplitude")
    assert found.attrs["device"] == devices[0].name
    assert found.attrs["window"] == 40.0
    options = '{"release_height_mm": 40.0, "window": 40.0, "settled_decays": 40.0}'
    assert (found.attrs["options"], found.attrs["title"]) == (options, "a device at practical voltages")
