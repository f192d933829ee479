"""The settled motion as a curve: over which times it is sampled, and how finely."""

from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.codes import Regime
from gelcone.motion.flow import integrate
from gelcone.physics.model import ConeModel
from gelcone.studio import orbit
from gelcone.studio.orbit import settled_orbit


def members(period=2.0, repeat=1.0, rate=1.0):
    """An actuator by its times alone."""
    return SimpleNamespace(drive_period=np.array([period]), forcing_period=np.array([repeat]), rate=np.array([rate]))


@pytest.mark.parametrize(
    ("period", "rate", "span", "count"),
    [
        (2.0, 1e-3, 2.0, 100),  # a period of a slow disc
        (2.0, 1e-3, 6.0, 300), (2.0, 1e-3, 0.5, 100), (2.0, np.pi, 4.0, 200), (2.0, 10.0 * np.pi, 2.0, 400),
        (2.0, 10.0 * np.pi, 2.001, 401),
    ],
)  # fmt: skip
def test_a_curve_has_samples_for_each_period_and_each_oscillation(period, rate, span, count):
    assert orbit.samples_over(members(period, rate=rate), span) == count


@pytest.fixture
def asked(monkeypatch):
    """What is integrated, without being so."""
    calls = []

    def record(given, start, times, **options):
        calls.append((start, times, options))
        return "run"

    monkeypatch.setattr(orbit, "integrate", record)
    return calls


@pytest.mark.parametrize(
    ("regime", "period", "repeat", "repeats"),
    [
        (Regime.PERIODIC, 3, 2.0, 3), (Regime.PERIODIC, 3, 1.0, 6), (Regime.PERIODIC, 4, 1.0, 4),
        (Regime.REST, 0, 1.0, 2), (Regime.REST, 0, 2.0, 1),
        (Regime.CHAOTIC, 0, 2.0, 64), (Regime.QUASI_PERIODIC, 0, 1.0, 64),
    ],
)  # fmt: skip
def test_an_orbit_lasts_whole_turns_and_whole_periods_of_the_drive(asked, regime, period, repeat, repeats):
    """Of a drive of period 2; what does not repeat is followed for a while."""
    found, places = settled_orbit(members(repeat=repeat), np.array([0.3, 0.1]), regime, period)
    ((start, times, options),) = asked
    assert (found, options) == ("run", {"threads": 1})
    np.testing.assert_array_equal(start, [[0.3, 0.1]])
    each = 100
    assert times.shape == (1, repeats * each + 1)
    np.testing.assert_allclose(times[0, [0, 1, -1]], [0.0, repeat / each, repeats * repeat])
    np.testing.assert_allclose(times[0, places], repeat * np.arange(repeats))


def test_what_oscillates_fast_is_followed_for_less_long_and_at_least_once(asked):
    fast = 2.0 * np.pi * 1000.0 / 40.0  # a thousand samples of a forcing period
    settled_orbit(members(rate=fast), np.zeros(2), Regime.CHAOTIC, 0)
    settled_orbit(members(rate=20.0 * fast), np.zeros(2), Regime.CHAOTIC, 0)
    settled_orbit(members(rate=20.0 * fast), np.zeros(2), Regime.PERIODIC, 10)
    settled_orbit(members(rate=200.0 * fast), np.zeros(2), Regime.REST, 0)
    counts = [(times.size - 1, times[0, -1]) for _, times, _ in asked]
    assert counts == [
        (orbit.MOST_SAMPLES, 8.0), (20_000, 1.0), (orbit.MOST_OF_ORBIT, 10.0), (orbit.MOST_OF_ORBIT, 2.0),
    ]  # fmt: skip


def test_an_orbit_closes():
    own = ConeModel(damping_ratio=0.3, voltage=0.3, voltage_bias=0.3, rest_height=0.4, drive_frequency=0.7).members()
    start = integrate(own, [[0.4, 0.0]], own.forcing_period[:, None] * np.array([0.0, 40.0])).states[0, -1]
    run, places = settled_orbit(own, start, Regime.PERIODIC, 1)
    np.testing.assert_allclose(run.states[0, -1], run.states[0, 0], atol=1e-4)
    assert np.ptp(run.states[0, :, 0]) > 0.01
    assert places == slice(0, run.times.size - 1, run.times.size - 1)
