"""The drive: the voltage, its rate, and the smallest period of its square."""

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from gelcone.physics import drive

frequencies = st.floats(1e-3, 1e3)
amplitudes = st.floats(0.01, 10.0)
biases = st.one_of(st.just(0.0), st.floats(0.01, 10.0), st.floats(-10.0, -0.01))


def test_the_waveform_is_a_biased_sine():
    tau, a, b, w = sympy.symbols("tau a b omega", real=True)
    assert drive.voltage(tau, a, b, w, sympy) == b + a * sympy.sin(w * tau)
    assert drive.voltage(0.0, 2.0, 0.3, 5.0) == 0.3
    assert drive.voltage(np.pi / 10.0, 2.0, 0.3, 5.0) == pytest.approx(2.3)


def test_the_rate_is_the_derivative_of_the_voltage():
    tau, a, b, w = sympy.symbols("tau a b omega", real=True)
    difference = sympy.diff(drive.voltage(tau, a, b, w, sympy), tau) - drive.voltage_rate(tau, a, w, sympy)
    assert sympy.simplify(difference) == 0


@settings(deadline=None)
@given(st.floats(-100.0, 100.0), amplitudes, biases, st.floats(1e-3, 30.0))
def test_the_rate_is_the_derivative_in_numpy_too(tau, a, b, w):
    h = 1e-30
    complex_step = drive.voltage(tau + 1j * h, a, b, w).imag / h
    assert drive.voltage_rate(tau, a, w) == pytest.approx(complex_step, rel=1e-12, abs=1e-12 * a * w)


@settings(deadline=None)
@given(amplitudes, biases, frequencies)
def test_the_repeat_is_a_period_of_the_squared_voltage_and_no_part_of_it_is(a, b, w):
    period = drive.repeat(w, b)
    n = 64
    tau = np.arange(n) / n * period
    force = drive.voltage(tau, a, b, w) ** 2
    scale = (a + abs(b)) ** 2
    np.testing.assert_allclose(drive.voltage(tau + period, a, b, w) ** 2, force, rtol=0.0, atol=1e-13 * scale)
    # A smaller period would be the repeat over a whole number, and then the fundamental would vanish.
    fundamental = 2.0 * abs(np.fft.rfft(force)[1]) / n
    expected = 2.0 * a * abs(b) if b != 0.0 else 0.5 * a * a
    assert fundamental == pytest.approx(expected, rel=1e-9, abs=1e-13 * scale)
    assert fundamental > 1e-7 * scale


@settings(deadline=None)
@given(frequencies)
def test_a_bias_doubles_the_repeat(w):
    assert drive.repeat(w, 0.0) == pytest.approx(np.pi / w, rel=1e-15)
    assert drive.repeat(w, 1e-9) == pytest.approx(2.0 * np.pi / w, rel=1e-15)
    assert drive.repeat(w, -1e-9) == pytest.approx(2.0 * np.pi / w, rel=1e-15)


def test_arrays_broadcast():
    repeat = drive.repeat(np.array([[1.0], [2.0]]), np.array([0.0, 0.5, -0.5]))
    np.testing.assert_allclose(repeat / np.pi, [[1.0, 2.0, 2.0], [0.5, 1.0, 1.0]], rtol=1e-15)
    voltage = drive.voltage(np.linspace(0.0, 1.0, 4), np.ones((3, 1)), np.zeros((3, 1)), 2.0)
    assert voltage.shape == (3, 4)
