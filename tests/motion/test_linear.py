"""Linear theory: the motion under a weak drive, dynamic stiffness, loaded circuits, amplifiers."""

from __future__ import annotations

import numpy as np
import pytest

import gelcone
from gelcone.motion import linear as module
from gelcone.motion.flow import integrate
from gelcone.motion.linear import linear_response
from gelcone.motion.state_space import equilibrium_under_bias, small_signal_response
from gelcone.physics.model import ConeModel
from tests.physics.test_circuit import BRANCH, Lossy
from tests.toys import CubicBias, FilteredVoltage, PowerFilm, SeriesResistor, ThreeHarmonics

# --- circuits, waveforms and films of one's own -----------------------------------------------------------------------


@pytest.mark.parametrize(
    "parts",
    [
        {},
        {"waveform": ThreeHarmonics()},
        {"circuit": FilteredVoltage()},
        {"bias": CubicBias(), "film": PowerFilm(), "waveform": ThreeHarmonics(), "circuit": FilteredVoltage()},
    ],
    ids=["sine", "three harmonics", "filter", "all"],
)
def test_the_linear_response_is_the_motion_under_a_weak_drive(parts):
    """A small drive about a large constant force: stroke and first two harmonics against the full motion."""
    kept = {} if "film" in parts else {"hoop_prestretch": 1.4}
    own = {"bias_stiffness": -0.1} if "bias" in parts else {"rest_height": 0.8}
    model = ConeModel(damping_ratio=0.2, voltage=1e-4, voltage_bias=0.6, drive_frequency=0.7, **kept, **own, **parts)
    place = equilibrium_under_bias(model, 0.6)
    assert place > 0.1
    period = float(model.drive_period)
    times = np.concatenate([[40 * period], 40 * period + period * np.arange(1, 129) / 128])
    start = model.members().start_states((place, 0.0))
    if len(model.system.states) == 3:
        start[:, 2] = 0.6
    x = integrate(model, start, times).states[0, 1:, 0]
    found = linear_response(model, np.array([0.7]))
    assert np.ptp(x) == pytest.approx(float(found.stroke[0]), rel=1e-3)
    turn = np.exp(-1j * np.outer([1, 2], 0.7 * times[1:]))
    harmonics = 2j * (turn * x).mean(axis=1)
    np.testing.assert_allclose(found.harmonics[0, 0], harmonics[0], rtol=1e-3)
    if "waveform" in parts:
        np.testing.assert_allclose(found.harmonics[1, 0], harmonics[1], rtol=2e-3)


def test_harmonics_that_the_drive_lacks_are_exactly_zero():
    """The square of a sine has no part at its own frequency, only rounding."""
    model = ConeModel(voltage=0.3, rest_height=0.4, spring_stiffness=2.0, damping_ratio=0.1)
    first, second = linear_response(model, np.array([0.7])).harmonics[:, 0]
    assert first == 0.0 < abs(second)


# --- states that move with the disc -----------------------------------------------------------------------------------

OMEGA = np.array([0.6, 1.2, 3.0])
WEAK = {"rest_height": 0.7, "damping_ratio": 0.1, "voltage": 1e-4, "voltage_bias": 0.5}


def test_linear_theory_has_the_films_own_dynamic_stiffness():
    """A branch g s/(1 + s) stiffens the film over the frequency; statics know only its slope at rest."""
    model = ConeModel(film=Lossy(), **WEAK)
    place, s = equilibrium_under_bias(model, 0.5), 1j * OMEGA
    settled = float(model.stiffness(place, 0.5))
    expected = 2.0 * place * 0.5 / (s * s + 0.2 * s + settled + BRANCH * s / (1.0 + s))
    found = linear_response(model, OMEGA).harmonics[0] / 1e-4
    np.testing.assert_allclose(found, expected, rtol=1e-7)
    np.testing.assert_allclose(small_signal_response(model, OMEGA)["gain"], np.abs(expected), rtol=1e-9)


def test_linear_theory_has_the_circuits_loaded_gain():
    """A resistance in front of a film that leaks: the film rests at v/(1 + rho q/tau) and the motion pumps charge."""
    rho, leak = 0.8, 1.0 / 20.0
    model = ConeModel(circuit=SeriesResistor(), series_resistance=rho, leakage_time=20.0, **WEAK)
    x = 0.5
    for _ in range(100):
        v = 0.5 / (1.0 + rho * leak * (1.0 + x * x))
        x = equilibrium_under_bias(model.replace(circuit="ideal"), v)
    s, q, stiffness = 1j * OMEGA, 1.0 + x * x, float(model.stiffness(x, v))
    y = s + leak
    loaded = (s * s + 0.2 * s + stiffness) * (1.0 + rho * q * y) + 4.0 * x * x * v * v * rho * y
    found = linear_response(model, OMEGA).harmonics[0] / 1e-4
    np.testing.assert_allclose(found, 2.0 * x * v / loaded, rtol=1e-7)
    np.testing.assert_allclose(small_signal_response(model, OMEGA)["gain"], np.abs(2.0 * x * v / loaded), rtol=1e-8)


def test_linear_theory_is_that_of_an_amplifier_within_its_limit_also_where_the_drive_reaches_it():
    """At rest no current flows, and so none is limited."""
    device = gelcone.find_device("biased-pump").replace(film="wrinkling", series_resistance="1 MOhm")
    strokes = [
        float(gelcone.settled(device.replace(current_limit=limit))["linear_stroke"])
        for limit in ("1 uA", "0.02 mA", "10 mA")
    ]
    assert strokes == pytest.approx([strokes[-1]] * 3, rel=1e-12)
    assert strokes[-1] > 1.0


def test_there_is_no_linear_response_about_an_unstable_equilibrium(monkeypatch):
    """Nor about one whose stiffness is 0."""
    members = ConeModel(damping_ratio=[0.1] * 3, voltage=0.1, voltage_bias=0.3, rest_height=0.4).members()
    stiffness = np.array([[2.0], [0.0], [-2.0]])
    real = module._equilibria
    monkeypatch.setattr(module, "_equilibria", lambda own, squares: (real(own, squares)[0], stiffness))
    found = module.linear_response(members, np.array([0.5]))
    assert np.isfinite(found.stroke).tolist() == [[True], [False], [False]]
    assert np.isfinite(found.harmonics[:, 0, 0]).tolist() == [True, False, False]
    harmonic = np.abs(found.harmonics[0, :, 0])
    assert found.stroke[0, 0] == pytest.approx(2.0 * harmonic[0], rel=2.0 * harmonic[1] / harmonic[0])
