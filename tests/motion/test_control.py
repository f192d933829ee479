"""Feed-forward and self-sensing: the voltage of a known motion is found again, and the height of a capacitance."""

from __future__ import annotations

import json

import numpy as np
import pytest

import gelcone
from gelcone.errors import InputError
from gelcone.motion import control as module
from tests.recorded import record
from tests.toys import VoltageBehindResistor

FILMS = {
    "taut": {"film": "taut"},
    "wrinkling": {"film": "wrinkling", "meridional_prestretch": 1.0, "hoop_prestretch": 1.05, "voltage_offset": 800.0},
}


def device(kind="taut"):
    return gelcone.find_device("biased-pump").replace(FILMS[kind])


@pytest.mark.parametrize("kind", FILMS)
def test_the_voltage_of_a_known_motion_is_found_again(kind):
    """A motion of simulate is followed by the absolute value of its voltage, since the force goes with the square."""
    own, times = device(kind), np.linspace(0.2, 0.5, 1201)
    run = gelcone.simulate(own, times=times, tolerance=1e-12)
    found = gelcone.follow(own, times, 1e-3 * run.displacement.values)
    inner = slice(20, -20)  # at the ends a spline knows less
    right = np.abs(run.drive_voltage.values)
    assert np.abs(found.voltage.values - right)[inner].max() < 2e-3 * right.max()
    assert found.reachable.values[inner].all()
    assert found.voltage.attrs["units"] == "V"
    assert float(found.largest_error) < 5e-3 * float(np.ptp(run.displacement.values))


def test_a_smooth_rise_is_followed():
    own = device()
    rest = own.initial_state()[0] * own.scales.length
    times = np.linspace(0.0, 1.0, 501)
    share = np.clip(times / 0.8, 0.0, 1.0)
    rise = share**4 * (35.0 - 84.0 * share + 70.0 * share**2 - 20.0 * share**3)
    found = gelcone.follow(own, times, rest + 0.4e-3 * rise)
    assert found.reachable.values[1:].all()
    assert float(found.largest_error) < 2e-3  # mm, of 0.4
    static = gelcone.stroke_and_blocked_force(own, [float(found.voltage[-1])])
    assert float(static.displacement[0]) == pytest.approx(1e3 * (rest + 0.4e-3), abs=1e-2)


def test_what_no_voltage_gives_is_said_and_the_largest_voltage_kept():
    own, times = device(), np.linspace(0.0, 0.2, 101)
    rest = own.initial_state()[0] * own.scales.length
    down = gelcone.follow(own, times, rest - 2e-3 * (1.0 - np.cos(20.0 * times)))
    assert not down.reachable.values.all()
    assert (down.voltage.values[~down.reachable.values] == 0.0).any()
    up = gelcone.follow(own, times, rest + 2e-3 * (1.0 - np.cos(20.0 * times)), most="900 V")
    assert float(up.voltage.max()) == pytest.approx(900.0)
    assert not up.reachable.values.all()
    for found in (down, up):
        error = found.followed.values - found.displacement.values
        np.testing.assert_allclose(found.error.values, error, atol=1e-12)
        assert float(found.largest_error) == pytest.approx(np.abs(error).max(), rel=1e-12)
        assert float(found.largest_error) > 0.1


@pytest.mark.parametrize(
    ("changes", "times", "match"),
    [
        ({"circuit": VoltageBehindResistor()}, np.linspace(0.0, 1.0, 9), "voltage_on_film"),
        ({"film_thickness": [1.9e-4, 2e-4]}, np.linspace(0.0, 1.0, 9), "one actuator"),
        ({"second_film": "taut", "second_flat_height": 0.02}, np.linspace(0.0, 1.0, 9), "one film"),
        ({}, np.linspace(0.0, 1.0, 5), "at least 6"),
        ({}, np.zeros(9), "must increase"),
    ],
)
def test_what_cannot_be_followed_is_refused(changes, times, match):
    with pytest.raises(InputError, match=match):
        gelcone.follow(device().replace(changes), times, 0.012 + 0.0 * times)


@pytest.mark.parametrize("kind", [*FILMS, "membrane"])
def test_a_capacitance_tells_the_height(kind):
    own = gelcone.find_device("biased-pump") if kind == "membrane" else device(kind)
    model, s, volts = own.to_model(), own.scales, 600.0
    heights = np.array([5e-3, 12e-3, 18e-3])
    x = heights / s.length
    known = np.asarray(model.film.capacitance(x, (volts / s.voltage) ** 2 + 0.0 * x, [], model.numbers()))
    farads = known * s.size("capacitance")
    found = gelcone.sense(own, farads, voltage=volts, uncertainty=1e-12)
    np.testing.assert_allclose(found.displacement.values, 1e3 * heights, rtol=1e-7)
    again = gelcone.sense(own, farads + 1e-12, voltage=volts)
    np.testing.assert_allclose(
        np.abs(again.displacement.values - found.displacement.values), found.displacement_error.values, rtol=1e-2
    )
    assert found.displacement_error.attrs["units"] == "mm"


def test_a_capacitance_that_no_height_has_gives_none():
    found = gelcone.sense(device(), ["1 pF", "1 mF"])
    assert np.isnan(found.displacement.values).all()
    with pytest.raises(InputError, match="at least 0"):
        gelcone.sense(device(), ["1 nF"], uncertainty=-1e-12)


@pytest.mark.parametrize("kind", FILMS)
def test_heights_are_found_wherever_the_film_has_a_state(kind):
    """From just above its plane to the largest height that is searched, in the model's own units."""
    model = device(kind).to_model()
    high = min(2.99, model.film.reach(model.numbers())[1] - 1e-3)
    x = np.array([1e-3, 0.2, 1.0, 2.0, high])
    known = np.asarray(model.film.capacitance(x, 0.0 * x, [], model.numbers()))
    found = gelcone.sense(model, known, uncertainty=1e-3)
    np.testing.assert_allclose(found.displacement.values, x, rtol=1e-6)
    slope = np.gradient(np.asarray(model.film.capacitance(np.linspace(0.9, 1.1, 3), np.zeros(3), [], model.numbers())))
    assert float(found.displacement_error[2]) == pytest.approx(1e-3 / (slope[1] / 0.1), rel=1e-2)
    beyond = gelcone.sense(model, [known[0] - 0.1, known[-1] * 1.5])
    assert np.isnan(beyond.displacement.values).all()
    assert np.isnan(beyond.displacement_error.values).all()


def test_a_motion_is_followed_from_its_own_start_and_the_largest_error_is_that_of_all_samples(monkeypatch):
    """The disc moves from the first sample on; the film pulls against damping, acceleration and bias."""
    model = gelcone.ConeModel(rest_height=0.8, hoop_prestretch=1.4, damping_ratio=0.2)
    times = np.linspace(0.0, 3.0, 301)
    wanted = 0.6 + 0.05 * np.sin(times)
    error = 0.01 * np.where(times == times[100], -5.0, np.cos(times))
    asked = record(monkeypatch, module, _integrated=wanted + error)
    found = gelcone.follow(model, times + 7.0, wanted)
    (call,) = asked["_integrated"]
    assert call["start"] == pytest.approx((0.6, 0.05), abs=1e-6)
    np.testing.assert_allclose(call["tau"], times, atol=1e-12)
    np.testing.assert_allclose(found["error"], error, atol=1e-12)
    assert float(found["largest_error"]) == pytest.approx(0.05)
    n, film = model.numbers(), model.system.films[0]
    v, x, u, a = found["voltage"].values, wanted, 0.05 * np.cos(times), -0.05 * np.sin(times)
    left = a + 2.0 * 0.2 * u + film.force(x, v * v, [], n)[0] + model.system.bias.force(x, [], n)[0]
    assert np.abs(left[10:-10]).max() < 1e-6


def test_a_sense_of_height_says_with_which_error():
    model = gelcone.ConeModel(rest_height=0.8, hoop_prestretch=1.4)
    found = gelcone.sense(model, [1.3, 1.5], voltage=0.2, uncertainty=0.01)
    x = found["displacement"].values
    np.testing.assert_allclose(1.0 + x * x, [1.3, 1.5], rtol=1e-9)  # of the cone
    np.testing.assert_allclose(found["displacement_error"], 0.01 / (2.0 * x), rtol=1e-6)
    assert json.loads(found.attrs["options"]) == {"voltage": 0.2, "uncertainty": 0.01}
    assert (gelcone.sense(model, [1.3])["displacement_error"] == 0.0).all()
