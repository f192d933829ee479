"""Small signals: state-space model and frequency response about a biased equilibrium."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from gelcone.devices.device import find_device
from gelcone.errors import InputError
from gelcone.motion.flow import integrate
from gelcone.motion.linear import equilibrium_under_bias, small_signal_response, state_space
from gelcone.physics.model import ConeModel

BIASED = ConeModel(
    damping_ratio=0.1, voltage=1e-4, voltage_bias=0.6, drive_frequency=1.3, rest_height=0.8, hoop_prestretch=1.4
)


def test_python_control_takes_the_matrices_as_they_are():
    control = pytest.importorskip("control")
    system = control.StateSpace(*state_space(BIASED))
    found = small_signal_response(BIASED, [0.3, 1.0, 1.7])
    response = control.frequency_response(system, [0.3, 1.0, 1.7])
    np.testing.assert_allclose(np.abs(np.ravel(response.frdata)), found["gain"], rtol=1e-12)


# SciPy warns of every transfer function whose numerator is of lower order than its denominator.
@pytest.mark.filterwarnings("ignore:Badly conditioned filter coefficients")
def test_scipy_takes_the_matrices_and_agrees_with_the_gain():
    omega = np.array([0.3, 1.0, 1.7])
    _, response = signal.StateSpace(*state_space(BIASED)).freqresp(omega)
    found = small_signal_response(BIASED, omega)
    np.testing.assert_allclose(found["gain"], np.abs(response), rtol=1e-12)
    np.testing.assert_allclose(found["phase"], np.degrees(np.angle(response)), rtol=1e-12)


def test_the_gain_is_that_of_a_small_motion_of_the_full_model():
    place = equilibrium_under_bias(BIASED, 0.6)
    period = float(BIASED.drive_period)
    times = np.concatenate([[60 * period], 60 * period + period * np.arange(1, 65) / 64])
    x = integrate(BIASED, (place, 0.0), times).states[0, 1:, 0]
    amplitude = abs(np.fft.rfft(x - x.mean())[1]) / 32
    gain = float(small_signal_response(BIASED, [1.3])["gain"][0])
    assert amplitude == pytest.approx(1e-4 * gain, rel=1e-3)


def test_a_device_has_its_poles_in_radians_per_second():
    device = find_device("biased-pump")
    model = device.to_model()
    plain, scaled = state_space(model), state_space(model, device)
    poles = np.linalg.eigvals(plain.A) / device.scales.time
    np.testing.assert_allclose(np.sort_complex(np.linalg.eigvals(scaled.A)), np.sort_complex(poles), rtol=1e-12)
    static = -(scaled.C @ np.linalg.solve(scaled.A, scaled.B))[0, 0]
    unscaled = -(plain.C @ np.linalg.solve(plain.A, plain.B))[0, 0]
    assert static == pytest.approx(unscaled * device.scales.length / device.scales.voltage)


def test_without_a_bias_the_voltage_has_no_first_order_effect():
    assert (state_space(ConeModel(rest_height=0.5)).B == 0.0).all()


@pytest.mark.parametrize("frequencies", [[0.0], [-1.0], [np.nan]])
def test_frequencies_are_positive(frequencies):
    with pytest.raises(InputError, match="positive"):
        small_signal_response(BIASED, frequencies)


def test_an_ensemble_has_no_single_state_space():
    with pytest.raises(InputError, match="single"):
        state_space(ConeModel(voltage=[0.1, 0.2]))
