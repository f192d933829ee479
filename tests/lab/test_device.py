"""What may be free in a fit of a device and what is asked of it, from texts."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.errors import DoubtfulInput, InputError
from gelcone.lab import device as module
from gelcone.lab import predictions
from gelcone.lab.bench import DeviceTest
from gelcone.lab.device import WIDE, read_free
from gelcone.lab.predictions import PREDICTIONS, Asked, read_predictions

PUMP = gelcone.find_device("biased-pump").replace(film="taut")


def test_priors_are_shares_of_the_value_and_wide_where_none_is_given():
    found = read_free(["spring_rate~3%", "film_thickness ~ 5 um"], PUMP)
    assert found == {"spring_rate": pytest.approx(0.03), "film_thickness": pytest.approx(5e-6 / 2e-4)}
    with pytest.warns(DoubtfulInput, match="spring_rate: has no prior"):
        assert read_free(["spring_rate"], PUMP) == {"spring_rate": WIDE}


def test_predictions_have_a_voltage_where_they_take_one():
    found = read_predictions(["stroke@1.5 kV", "pull-in", "natural frequency @ 200 V"])
    assert found == [
        Asked("stroke@1.5 kV", "stroke", 1500.0), Asked("pull-in", "pull-in", 0.0),
        Asked("natural frequency @ 200 V", "natural frequency", 200.0),
    ]  # fmt: skip
    assert list(PREDICTIONS.values()) == ["m", "N", "Hz", "V"]


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        (["spring_rate~3%", "spring_rate~4%"], "spring_rate: is given twice"),
        (["spring_rate~0%"], "spring_rate"), (["spring_rate~5 V"], "spring_rate"), (["spring~3%"], "spring"),
        (["film_thickness~-5 um"], "film_thickness"),
    ],
)  # fmt: skip
def test_priors_that_cannot_be_are_refused(texts, message):
    with pytest.raises(InputError, match=message):
        read_free(texts, PUMP)


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


# --- a made-up problem: predictions are powers of the fields ----------------------------------------------------------

FREE = {"spring_rate": 0.1, "film_thickness": 0.2}
POWERS = {"stroke": np.array([1.0, -2.0]), "pull-in": np.array([-0.5, 1.0])}
COVARIANCE = np.array([[0.04, 0.006, 0.5], [0.006, 0.01, 0.4], [0.5, 0.4, 9.0]])
"""Of both fields and of a gain, on which no prediction depends."""


def made_up_problem(**own):
    tests = own.pop("tests", [])
    values = np.zeros(8)
    return SimpleNamespace(device=PUMP, free=FREE, priors=np.array([0.1, 0.2, 5.0]), tests=tests, values=values, **own)


def a_plan(*_):
    return SimpleNamespace(
        names=[*FREE, "gain of balance"], priors=np.array([0.1, 0.2, 5.0]), singular=np.array([3.0, 0.2]),
        directions=np.array([[1.0, 2.0]]), learnt=1, left=np.ones(3), covariance=COVARIANCE,
    )  # fmt: skip


@pytest.fixture
def powers(monkeypatch):
    """Predictions of 2 (kind 1) or 3 times their powers; ``asked``, which slopes next experiments are sought for."""
    asked = []

    def values(problem, logs, one):
        return (2.0 if one.kind == "stroke" else 3.0) * np.exp(logs @ POWERS[one.kind])

    def experiments(problem, row, logs):
        asked.append(row)
        return [SimpleNamespace(words=f"do {len(asked)}", ratio=0.5 / len(asked))]

    monkeypatch.setattr(predictions, "predicted_values", values)
    monkeypatch.setattr(predictions, "next_experiments", experiments)
    return asked


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


@pytest.mark.parametrize(("p_value", "wider"), [(0.5, 1.0), (1e-6, 3.0)])
def test_a_fit_says_what_it_leaves_and_more_where_chi2_refuses_it(monkeypatch, powers, p_value, wider):
    """Standard deviations are the roots of the diagonal, by the root of chi2 over the readings wider; of two
    structures the one with the smaller objective counts."""
    logs = np.array([0.1, -0.05, 0.7])
    problem = made_up_problem()
    fits = [
        SimpleNamespace(objective=one, p_value=p_value, chi2=72.0, covariance=COVARIANCE, logs=logs * one,
                        problem=problem, device=PUMP) for one in (2.0, 1.0)
    ]  # fmt: skip
    monkeypatch.setattr(module, "_fitted", lambda problems: (dict(zip(problems, fits, strict=True)), {}))
    monkeypatch.setattr(module, "_problem", lambda *_: problem)
    monkeypatch.setattr(module, "plan_of", a_plan)
    for name in ("_check_signs", "_checked"):
        monkeypatch.setattr(module, name, lambda own: own)
    for name in ("_readings", "_others"):
        monkeypatch.setattr(module, name, lambda *_: xr.Dataset())
    volts = [SimpleNamespace(set={"voltage": np.array([-900.0, 300.0]), "load": np.array([5000.0])})]
    tests = SimpleNamespace(measured=True, tests=volts, gains={})
    found = module.fit_device(PUMP, tests, FREE, films=["taut", "wrinkling"], predict=["stroke@1 kV"])
    np.testing.assert_allclose(found["left"], wider * np.sqrt([0.04, 0.01, 9.0]))
    np.testing.assert_allclose(found["covariance"], wider**2 * COVARIANCE)
    np.testing.assert_allclose(found["prior"], [0.1, 0.2, 5.0])
    np.testing.assert_allclose(found["deviation"], logs)
    nominal = np.array([PUMP.spring_rate, PUMP.film_thickness])
    np.testing.assert_allclose(found["nominal"], nominal)
    np.testing.assert_allclose(found["value"], nominal * np.exp(logs[:2]))
    own = POWERS["stroke"]
    spread = wider * float(found["predicted_value"][0]) * np.sqrt(own @ COVARIANCE[:2, :2] @ own)
    assert float(found["predicted_spread"][0]) == pytest.approx(spread, rel=0.02)
    attrs = found.attrs
    assert (attrs["chosen"], attrs["refused"], attrs["highest_voltage"]) == ("wrinkling film", int(wider > 1.0), 900.0)
    assert (attrs["chi2"], attrs["p_value"], attrs["readings"]) == (72.0, p_value, 8)


def test_draws_of_a_fit_are_correlated_as_it_leaves_the_fields():
    value, size = np.array([20.0, 3e-4]), 4000
    result = xr.Dataset(
        {"covariance": (("unknown", "other_unknown"), COVARIANCE), "value": ("field", value)},
        coords={"field": list(FREE)},
        attrs={"fitted": PUMP.to_toml(), "device": "d", "film": "taut", "chi2": 1.0, "p_value": 0.5, "refused": 0},
    )
    draws = gelcone.fitted_draws(result, size, seed=3)
    logs = np.log([draws[name].values for name in FREE] / value[:, None])
    np.testing.assert_allclose(np.cov(logs), COVARIANCE[:2, :2], rtol=0.1, atol=1e-3)
    assert np.abs(logs.mean(axis=1)).max() < 0.01
    assert [draws[name].attrs["units"] for name in FREE] == ["N/m", "m"]
    again = gelcone.fitted_draws(result, size, seed=3)
    np.testing.assert_array_equal(draws["spring_rate"], again["spring_rate"])
    assert (gelcone.fitted_draws(result, size, seed=4)["spring_rate"] != draws["spring_rate"]).any()


@pytest.mark.parametrize(
    ("kind", "given", "along", "name"),
    [
        ("stroke over voltage", {"voltage": [0.0, 1.0, 2.0]}, [0.0, 1.0, 2.0], "voltage (V)"),
        ("stroke over voltage", {"voltage": [1.0, 1.0, 1.0]}, [0.0, 1.0, 2.0], "row"),
        ("blocked force", {"voltage": [0.0, 1.0, 2.0], "height": [3.0, 4.0, 5.0]}, [3.0, 4.0, 5.0], "height (m)"),
        ("blocked force", {"voltage": [0.0, 1.0, 2.0], "height": [3.0, 3.0, 3.0]}, [0.0, 1.0, 2.0], "voltage (V)"),
    ],
)
def test_a_test_is_drawn_over_the_first_of_what_is_set_that_varies(kind, given, along, name):
    one = DeviceTest(kind, kind, {k: np.array(v) for k, v in given.items()}, {kind: np.zeros(3)}, {kind: np.ones(3)})
    found, words = module._along(one)
    np.testing.assert_array_equal(found, along)
    assert words == name


def test_a_structure_of_the_loss_has_a_damper_a_branch_or_both():
    """What is not there begins with a tenth of the modulus and the drive's time; what is not free of these is."""
    creeping = PUMP.replace({"material.viscous_modulus_1": 500.0, "material.relaxation_time_1": 0.2})
    own, free = module._with_loss(creeping, FREE, "damper")
    assert own.material.branches == 0
    assert own.damping_coefficient == PUMP.damping_coefficient
    assert free == {**FREE, "damping_coefficient": module.ANY}
    own, free = module._with_loss(PUMP, {**FREE, "damping_coefficient": 0.3}, "branch")
    assert own.damping_coefficient == 0.0
    assert own.material.viscous_modulus_1 == pytest.approx(0.1 * PUMP.material.shear_modulus)
    assert own.material.relaxation_time_1 == pytest.approx(1.0 / (2.0 * np.pi * PUMP.frequency))
    branch = dict.fromkeys(("material.viscous_modulus_1", "material.relaxation_time_1"), module.ANY)
    assert free == {**FREE, **branch}
    own, free = module._with_loss(creeping, {**FREE, "damping_coefficient": 0.3}, "both")
    assert (own.material.viscous_modulus_1, own.damping_coefficient) == (500.0, PUMP.damping_coefficient)
    assert free == {**FREE, "damping_coefficient": 0.3, **branch}


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
