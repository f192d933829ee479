"""Answers: plain JSON, SI units, and the lines that all texts share."""

import json

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone import ConeModel, Outcome, Regime, dataset
from gelcone.analyses.answer import ending_lines, in_si, outcome_lines, parameters_json, plain, variable_json
from gelcone.analyses.request import Subject
from gelcone.codes import FilmPullIn


def test_plain_values_are_json():
    content = {"a": np.array([1.0, np.nan, np.inf]), 3: (np.float32(2.0), np.int8(1)), "x": xr.DataArray([True])}
    assert json.loads(json.dumps(plain(content), allow_nan=False)) == {
        "a": [1.0, None, None],
        "3": [2.0, 1],
        "x": [True],
    }
    assert parameters_json(ConeModel(stretch_limit=[2.0, np.inf]))["stretch_limit"] == [2.0, "inf"]


def test_outcomes_are_counted_with_their_remedy():
    codes = np.array([Outcome.OK, Outcome.OUTSIDE, Outcome.OUTSIDE], dtype=np.int8)
    result = xr.Dataset({"outcome": ("member", codes)})
    assert outcome_lines(result) == [f"2 of 3 run(s) failed: {Outcome.OUTSIDE.meaning}"]
    assert ending_lines(result) == ["  1 of 3: ok", f"  2 of 3: {Outcome.OUTSIDE.meaning}"]
    assert ending_lines(result.isel(member=0)) == []


def test_codes_and_periods_are_known_by_what_they_are_not_by_a_name_that_ends_alike():
    """A user may name a parameter as a variable of ours."""
    period = xr.DataArray([0, 2, np.nan], name="fate_period", attrs={"quantity": "count"})
    assert variable_json(period) == ["none", 2, "unknown"]
    for name in ("duty_cycle", "own_period", "own_regime", "sign", "own_outcome", "unstable"):
        own = xr.DataArray([0.3, 1.0], name=name, attrs={"quantity": "parameter", "units": "1"})
        assert variable_json(own) is own
    at = dataset.columns("limit", {
        "window_regime": ([3.0, np.nan], "kind of motion there", Regime),
        "run_outcome": (np.array([6, 0]), "how the run ended", Outcome),
        "kind": (np.array([1, 2]), "how it pulls in", FilmPullIn),
        "sign": (np.array([-1, 1], dtype=np.int8), "sign of the exponent", "code"),
        "resting": (np.array([0, 1], dtype=np.int8), "1 if at rest", "code"),
        "number": (np.array([0, 1], dtype=np.int8), "of the attractor", "code"),
    })  # fmt: skip
    found = {name: variable_json(variable) for name, variable in xr.Dataset(at).items()}
    assert found["window_regime"] == ["chaotic", "unknown"]
    assert found["run_outcome"] == [Outcome(6).label, "ok"]
    assert found["kind"] == ["minimum", "localisation"]
    assert found["sign"] == ["negative", "positive"]
    assert found["resting"] == [False, True]
    assert found["number"].values.tolist() == [0, 1]


def test_a_device_has_its_states_and_axes_in_si_units():
    device = gelcone.find_device("soft-film")
    model = device.to_model().replace(voltage=[0.1, 0.2])
    result = gelcone.regime(model, transient=60.0, budget=100.0)
    shown = in_si(result, Subject(model, device))
    assert shown["section"].attrs["units"] == "mm, m/s"
    scale = [1e3 * device.scales.length, device.scales.velocity]
    np.testing.assert_allclose(shown["section"], result["section"] * scale)
    np.testing.assert_allclose(shown["voltage"], np.array([0.1, 0.2]) * device.scales.voltage)
    assert shown["voltage"].attrs["units"] == "V"
    assert "amplitude of the drive" in shown["voltage"].attrs["long_name"]
    np.testing.assert_allclose(gelcone.model_of(shown).voltage, [0.1, 0.2], rtol=1e-14)
    assert in_si(result, Subject(model)) is result


def test_a_third_state_keeps_its_numbers():
    device = gelcone.find_device("soft-film")
    section = xr.DataArray(np.ones((4, 3)), dims=("point", "state"), attrs={"units": "1", "quantity": "state"})
    result = xr.Dataset({"section": section}, attrs={"title": "regime of motion"})
    shown = in_si(result, Subject(device.to_model(), device))["section"]
    assert shown.attrs["units"] == "mm, m/s, 1"
    assert float(shown[0, 2]) == 1.0
    assert float(shown[0, 0]) == pytest.approx(1e3 * device.scales.length)
