"""Feed-forward: the voltage of a known motion is found again."""

from __future__ import annotations

import numpy as np
import pytest

import gelcone
from gelcone.errors import InputError
from gelcone.motion import feed_forward as module
from tests.motion.pumps import FILMS, device
from tests.recorded import record
from tests.toys import VoltageBehindResistor


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
    assert (found.voltage.dims, found.voltage.attrs["units"]) == (("time",), "V")
    np.testing.assert_allclose(found.time, run.time - run.time[0], rtol=1e-12, atol=1e-9)
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
    up = gelcone.follow(own, times, rest + 2e-3 * (1.0 - np.cos(20.0 * times)), highest_voltage="900 V")
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
