"""The device of a fit: draws correlated as the fit leaves its fields, and the band of heights over the voltage."""

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.errors import InputError
from gelcone.lab import fitted
from gelcone.lab.bench import Variants
from gelcone.lab.device import fit_device
from gelcone.lab.device_tests import DeviceTests
from gelcone.lab.fitted import fitted_band, fitted_device, fitted_draws
from tests.lab.certified import TAUT, problem
from tests.lab.made_up_fit import COVARIANCE, FREE, PUMP


def a_fit(value, covariance=COVARIANCE, device=PUMP, highest=900.0):
    """The result of a fit of `FREE`, and of the gain of an instrument."""
    known = {"device": "d", "film": "taut", "chi2": 1.0, "p_value": 0.5, "refused": 0, "highest_voltage": highest}
    return xr.Dataset(
        {"covariance": (("unknown", "other_unknown"), covariance), "value": ("field", value)},
        coords={"field": list(FREE)},
        attrs=known | {"fitted": device.to_toml()},
    )


def test_draws_of_a_fit_are_correlated_as_it_leaves_the_fields():
    value, size = np.array([20.0, 3e-4]), 4000
    result = a_fit(value)
    draws = gelcone.fitted_draws(result, size, seed=3)
    logs = np.log([draws[name].values for name in FREE] / value[:, None])
    np.testing.assert_allclose(np.cov(logs), COVARIANCE[:2, :2], rtol=0.1, atol=1e-3)
    assert np.abs(logs.mean(axis=1)).max() < 0.01
    assert [draws[name].attrs["units"] for name in FREE] == ["N/m", "m"]
    assert {draws[name].attrs["quantity"] for name in FREE} == {"device field"}
    assert draws["spring_rate"].attrs["long_name"] == "stiffness of the spring"
    again = gelcone.fitted_draws(result, size, seed=3)
    np.testing.assert_array_equal(draws["spring_rate"], again["spring_rate"])
    assert (gelcone.fitted_draws(result, size, seed=4)["spring_rate"] != draws["spring_rate"]).any()


def test_draws_are_correlated_as_the_fit_leaves_them():
    """Their stroke spreads as the fit predicts; independent draws would spread a natural frequency far more."""
    whole = problem(TAUT, "taut")
    asked = ["stroke@2.15 kV", "stroke@1.5 kV"]
    result = fit_device(whole.device, DeviceTests(whole.tests, whole.gains), whole.free, predict=asked)
    draws = fitted_draws(result, 400, seed=1)
    device, names = fitted_device(result), list(whole.free)

    def spread(values):
        variants = Variants(device, names, values / [device.get(name) for name in names], {})
        return np.std(variants.stroke(np.array([2150.0]))), np.std(variants.ring_down()[:, 0])

    table = np.stack([draws[name].values for name in names], axis=1)
    expected = float(result["predicted_spread"][0])
    stroke, frequency = spread(table)
    assert stroke == pytest.approx(expected, rel=0.2)
    rng = np.random.default_rng(0)
    alone = spread(np.stack([rng.permutation(column) for column in table.T], axis=1))
    volts, height, low, high = np.loadtxt(fitted_band(result).splitlines(), delimiter=",", skiprows=1).T
    rest = float(Variants(device, names, np.ones((1, len(names))), {}).rest[0, 0] * device.scales.length)
    own = Variants(device, names, np.ones((1, len(names))), {})
    np.testing.assert_allclose(height, 1e3 * (rest + own.stroke(volts)[0]), rtol=1e-5)
    assert volts[-1] == result.attrs["highest_voltage"] > 1500.0
    assert np.interp(1500.0, volts, high - low) == pytest.approx(3920.0 * float(result["predicted_spread"][1]), rel=0.4)
    assert alone[0] > 2.0 * stroke
    assert alone[1] > 4.0 * frequency
    assert {draws[name].attrs["units"] for name in names} >= {"Pa", "m", "N/m"}
    with pytest.raises(InputError, match="count = 1: must be at least 2"):
        fitted_draws(result, 1)
    with pytest.raises(InputError, match="was given no device fit"):
        fitted_draws(draws)


def test_draws_say_what_they_are_draws_of():
    draws = fitted_draws(a_fit(np.array([20.0, 3e-4])), 2, seed=7)
    known = {"device": "d", "film": "taut", "chi2": 1.0, "p_value": 0.5, "refused": 0, "seed": 7}
    assert draws.attrs == known | {"title": f"draws of {PUMP.name}"}
    assert (draws.sizes["draw"], fitted_draws(a_fit(np.ones(2))).sizes["draw"]) == (2, 64)
    assert "stiffness" in draws["spring_rate"].attrs["long_name"]


def height_of(device, volts):
    """The height at rest under constant voltages, in mm."""
    static = gelcone.stroke_and_blocked_force(device, volts)
    return float(gelcone.static(device, [0.0]).rest_displacement) + static["stroke"].values


@pytest.mark.parametrize(("highest", "last"), [(900.0, 1400.0), (1600.0, 1600.0)])
def test_a_band_is_the_height_over_a_ramp_up_to_the_drive_or_the_tests(highest, last):
    """Of a fit without spread, at rest under each voltage."""
    own = PUMP.replace(voltage_offset=-600.0, voltage_amplitude=800.0)
    text = fitted_band(a_fit([own.spring_rate, own.film_thickness], 1e-24 * COVARIANCE, own, highest))
    assert text.splitlines()[0] == "voltage (V),height (mm),height low (mm),height high (mm)"
    volts, *heights = np.loadtxt(text.splitlines(), delimiter=",", skiprows=1).T
    np.testing.assert_allclose(volts, np.linspace(0.0, last, 61), rtol=1e-5)
    np.testing.assert_allclose(heights, [height_of(own, volts)] * 3, rtol=1e-5)


def test_the_ends_of_a_band_are_those_of_its_draws(monkeypatch):
    """Of draws alone, among which the fitted device is not."""
    asked = []

    def ends(heights):
        asked.append(heights)
        return np.quantile(heights, [0.1, 0.5, 0.8], axis=0)

    monkeypatch.setattr(fitted, "spread", ends)
    result = a_fit([PUMP.spring_rate, PUMP.film_thickness], 0.01 * COVARIANCE)
    volts, height, low, high = np.loadtxt(fitted_band(result).splitlines(), delimiter=",", skiprows=1).T
    (heights,) = asked
    assert heights.shape == (200, volts.size)
    draws = fitted_draws(result, 200)
    for k in (0, 199):
        other = PUMP.replace({name: float(draws[name][k]) for name in FREE})
        np.testing.assert_allclose(heights[k], height_of(other, volts), rtol=1e-4)
    np.testing.assert_allclose([low, high], np.quantile(heights, [0.1, 0.8], axis=0), rtol=1e-5)
    np.testing.assert_allclose(height, height_of(PUMP, volts), rtol=1e-5)


def test_a_band_leaves_out_the_voltages_at_which_it_is_not_known(monkeypatch):
    def ends(heights):
        known = np.where(np.arange(heights.shape[1]) < 50, 1.0, np.nan)
        return np.stack([known, known, known])

    monkeypatch.setattr(fitted, "spread", ends)
    lines = fitted_band(a_fit([PUMP.spring_rate, PUMP.film_thickness], 1e-4 * COVARIANCE)).splitlines()
    assert len(lines) == 1 + 50
    assert not any("nan" in line for line in lines)
