"""What is asked of a fitted device, from texts, and how predictions spread by what the fit leaves."""

import json

import numpy as np
import pytest
import xarray as xr

from gelcone.errors import InputError
from gelcone.lab import predictions
from gelcone.lab.predictions import PREDICTIONS, Asked, read_predictions
from tests.lab.made_up_fit import COVARIANCE, FREE, POWERS, PUMP, by_powers, made_up_problem


@pytest.fixture
def powers(monkeypatch):
    return by_powers(monkeypatch)


def test_predictions_have_a_voltage_where_they_take_one():
    found = read_predictions(["stroke@1.5 kV", "pull-in", "natural frequency @ 200 V"])
    assert found == [
        Asked("stroke@1.5 kV", "stroke", 1500.0), Asked("pull-in", "pull-in", 0.0),
        Asked("natural frequency @ 200 V", "natural frequency", 200.0),
    ]  # fmt: skip
    assert list(PREDICTIONS.values()) == ["m", "N", "Hz", "V"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("stroke", "give a voltage, stroke@1 kV"), ("pull-in@1 kV", "takes no voltage"), ("strok@1 kV", "did you mean"),
        ("stroke@0 V", "stroke"), ("stroke@3 mm", "stroke"),
    ],
)  # fmt: skip
def test_predictions_that_cannot_be_are_refused(text, message):
    with pytest.raises(InputError, match=message):
        read_predictions([text])


def test_predictions_spread_by_what_the_fit_and_the_priors_leave(powers):
    """Their slopes are value times power; the covariance counts with its off-diagonals, priors are independent."""
    logs = np.array([0.1, -0.05, 0.7])
    asked = [Asked("stroke@1 kV", "stroke", 1000.0), Asked("pull-in", "pull-in", 0.0)]
    found = predictions.predictions_of(made_up_problem(), logs, COVARIANCE, asked)
    for k, (factor, own) in enumerate(((2.0, POWERS["stroke"]), (3.0, POWERS["pull-in"]))):
        value = factor * np.exp(own @ logs[:2])
        assert float(found["predicted_value"][k]) == pytest.approx(value, rel=1e-12)
        assert float(found["predicted_spread"][k]) == pytest.approx(
            value * np.sqrt(own @ COVARIANCE[:2, :2] @ own), rel=0.02
        )
        assert float(found["predicted_prior"][k]) == pytest.approx(value * np.hypot(*(own * [0.1, 0.2])), rel=0.02)
        np.testing.assert_allclose(powers[k], [*(value * own), 0.0], rtol=0.02)
    assert found["prediction"].values.tolist() == ["stroke@1 kV", "pull-in"]
    assert json.loads(found.attrs["next"]) == [[["do 1", 0.5]], [["do 2", 0.25]]]


def test_each_prediction_is_the_one_that_is_asked_for(monkeypatch):
    class Variants:
        rest = np.array([[0.5], [0.7]])
        device = "variants"

        def __init__(self, device, names, factors, gains):
            assert (device, names, gains) == (PUMP, list(FREE), {})
            np.testing.assert_allclose(factors, np.exp(logs))

        def stroke(self, volts):
            return np.array([[1.0], [2.0]]) * volts

        def natural_frequency(self, volts):
            return np.array([3.0, 4.0]) * volts

        def squared(self, volts):
            return np.array([[5.0]]) * volts

        def force(self, x, squared):
            return 100.0 * x - squared, None

        def scale(self, quantity):
            return {"force": np.array([[2.0], [3.0]])}[quantity]

    logs = np.array([[0.1, 0.2], [0.3, 0.4]])
    monkeypatch.setattr(predictions, "Variants", Variants)
    volts = xr.Dataset({"pull_in_voltage": ("member", [7.0, np.inf])})
    monkeypatch.setattr(predictions, "pull_in_voltage", lambda device: volts)
    expected = {"stroke": [10.0, 20.0], "natural frequency": [30.0, 40.0], "pull-in": [7.0, np.nan]}
    expected["blocked force"] = [100.0, 150.0]  # what the voltage adds: 50 times the scale of each
    assert set(expected) == set(PREDICTIONS)
    for kind, values in expected.items():
        found = predictions.predicted_values(made_up_problem(), logs, Asked(kind, kind, 10.0))
        np.testing.assert_allclose(found, values, err_msg=kind)


def test_predictions_are_read():
    assert [one.voltage for one in read_predictions(["stroke@1.5 kV", "pull-in"])] == [1500.0, 0.0]
    for text, message in (
        ("strok@1 V", "'strok' is not a prediction; did you mean 'stroke'"),
        ("stroke", "give a voltage, stroke@1 kV"),
        ("pull-in@1 V", "takes no voltage"),
        ("stroke@1", "has no unit"),
    ):
        with pytest.raises(InputError, match=message):
            read_predictions([text])


def test_of_what_cannot_be_predicted_no_experiment_is_the_next(powers, monkeypatch):
    """A device that does not pull in has no pull-in voltage to be known better."""
    monkeypatch.setattr(predictions, "predicted_values", lambda problem, logs, one: np.full(len(logs), np.nan))
    asked = [Asked("pull-in", "pull-in", 0.0)]
    found = predictions.predictions_of(made_up_problem(), np.zeros(3), COVARIANCE, asked)
    assert np.isnan(found["predicted_value"]).all()
    assert (json.loads(found.attrs["next"]), powers) == ([[]], [])
