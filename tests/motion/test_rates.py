"""The equation of motion for other integrators: its motion is that of simulate, its Jacobian that of differences."""

from __future__ import annotations

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gelcone
from gelcone.errors import InputError
from tests.toys import VoltageBehindResistor

DEVICES = {
    "taut": {"film": "taut", "gravity": 9.81},
    "wrinkling": {"film": "wrinkling", "meridional_prestretch": 1.0, "hoop_prestretch": 1.05, "voltage_offset": 800.0},
    "creeping": {"film": "wrinkling", "material.viscous_modulus_1": 1e4, "material.relaxation_time_1": 0.1},
    "circuit": {"film": "taut", "circuit": VoltageBehindResistor()},
    "membrane": {"film": "membrane"},
    "reduced": {"film": "taut", "series_resistance": 3e5, "reduced": "series_resistance"},
}


def device(kind):
    return gelcone.find_device("biased-pump").replace(DEVICES[kind])


@pytest.mark.parametrize("kind", ["taut", "wrinkling", "circuit", "reduced"])
def test_another_integrator_gives_the_motion_of_simulate(kind):
    f, times = gelcone.rates(device(kind)), np.linspace(0.01, 0.15, 15)
    run = solve_ivp(f, (0.0, times[-1]), f.start, t_eval=times, rtol=1e-10, atol=1e-13, method="DOP853", max_step=1e-3)
    right = 1e-3 * gelcone.simulate(device(kind), times=times).displacement.values
    assert np.abs(run.y[0] - right).max() < 1e-7 * np.ptp(right)


@pytest.mark.parametrize("kind", DEVICES)
def test_the_jacobian_is_that_of_differences(kind):
    f = gelcone.rates(device(kind))
    y = f.start * np.linspace(1.02, 1.05, f.start.size) + np.array([0.0, 0.05] + [0.0] * (f.start.size - 2))
    given = {"voltage": 800.0, "force": 1e-3}
    exact = f.jacobian(0.0, y, **given)
    for k in range(y.size):
        step = 1e-6 * max(abs(y[k]), 1e-3)
        up, down = (f(0.0, y + sign * step * np.eye(y.size)[k], **given) for sign in (1.0, -1.0))
        size = np.abs(exact).max(axis=1) + 1e-9
        assert (np.abs((up - down) / (2.0 * step) - exact[:, k]) <= 2e-5 * size).all(), k


def test_the_input_is_a_number_a_function_or_the_drive():
    own = device("taut")
    f = gelcone.rates(own)
    t = 0.013
    volts = own.voltage_offset + own.voltage_amplitude * np.sin(2.0 * np.pi * own.frequency * t)
    expected = f(t, f.start, voltage=volts)
    np.testing.assert_allclose(f(t, f.start), expected, rtol=1e-13)
    np.testing.assert_allclose(f(t, f.start, voltage=lambda _: volts), expected, rtol=1e-13)
    pushed = f(t, f.start, voltage=volts, force=lambda _: 2e-3)
    assert pushed[1] - expected[1] == pytest.approx(2e-3 / own.moving_mass, rel=1e-10)


def test_many_points_at_once_are_each_alone():
    f = gelcone.rates(device("wrinkling"))
    y = f.start[:, None] * np.linspace(0.8, 1.1, 5) + np.array([[0.0], [0.02]])
    together = f(0.0, y, voltage=900.0)
    for k in range(5):
        np.testing.assert_allclose(together[:, k], f(0.0, y[:, k], voltage=900.0), rtol=1e-13)


def test_rest_is_at_rest():
    f = gelcone.rates(device("taut"))
    assert f.states == ("displacement", "velocity")
    assert np.abs(f(0.0, f.start, voltage=0.0)[1]) < 1e-9


@pytest.mark.parametrize("kind", ["taut", "wrinkling", "circuit"])
def test_python_control_linearises_the_function_as_gelcone_does(kind):
    own = device(kind)
    linear = gelcone.state_space(own, voltage=800.0, inputs=("voltage", "force"))
    system = gelcone.rates(own).to_control()
    found = control.linearize(system, _rest(own, linear), [800.0, 0.0])
    for one, other in ((found.A, linear.A), (found.B, linear.B)):
        np.testing.assert_allclose(one, other, rtol=5e-6, atol=1e-5 * np.abs(other).max())
    assert system.state_labels == system.output_labels == list(linear.states)


def _rest(own, linear):
    """The states at rest under 800 V."""
    z = gelcone.rates(own).start.copy()
    z[0] = linear.place
    if "voltage_on_film" in linear.states:
        z[linear.states.index("voltage_on_film")] = 800.0
    return z


def test_python_control_integrates_the_device_as_simulate_does():
    own, times = device("taut"), np.linspace(0.0, 0.1, 51)
    volts = own.voltage_offset + own.voltage_amplitude * np.sin(2.0 * np.pi * own.frequency * times)
    system, f = gelcone.rates(own).to_control(), gelcone.rates(own)
    found = control.input_output_response(system, times, [volts, 0.0 * times], f.start)
    right = gelcone.simulate(own, times=times).displacement.values
    assert np.abs(1e3 * found.outputs[0] - right).max() < 3e-3 * np.ptp(right), "inputs are joined by straight lines"


def test_an_ensemble_and_other_states_are_refused():
    with pytest.raises(InputError, match="takes one actuator, not an ensemble of 2"):
        gelcone.rates(device("taut").replace(film_thickness=[1.9e-4, 2e-4]))
    with pytest.raises(InputError, match="must have 2 states"):
        gelcone.rates(device("taut"))(0.0, [0.0, 0.0, 1.0])


def test_a_voltage_and_a_force_may_be_functions_of_the_time_in_seconds_or_numbers():
    f = gelcone.rates(device("taut"))
    t, own = 0.4, device("taut")
    at = f(t, f.start, voltage=300.0, force=2e-3)
    asked = []
    given = {name: lambda time, value=value: asked.append(time) or value for name, value in
             (("voltage", 300.0), ("force", 2e-3))}  # fmt: skip
    np.testing.assert_allclose(f(t, f.start, **given), at, rtol=1e-13)
    assert asked == [t, t]
    still = f(t, f.start, voltage=300.0)
    assert at[1] - still[1] == pytest.approx(2e-3 / own.moving_mass, rel=1e-10)


def test_the_inputs_of_python_control_are_voltage_and_force():
    f = gelcone.rates(device("taut"))
    system = f.to_control()
    assert (system.input_labels, system.output_labels) == (["voltage", "force"], list(f.states))
    np.testing.assert_allclose(
        system.updfcn(0.4, f.start, np.array([300.0, 2e-3]), {}), f(0.4, f.start, voltage=300.0, force=2e-3), rtol=1e-13
    )


@pytest.mark.parametrize("kind", ["taut", "circuit", "reduced"])
def test_the_drive_as_a_function_is_the_drive(kind):
    own = device(kind)
    f = gelcone.rates(own)
    y = np.array([0.013, 0.2, *f.start[2:]])

    def voltage(t):
        return own.voltage_offset + own.voltage_amplitude * np.sin(2.0 * np.pi * own.frequency * t)

    for t in (0.0, 0.013, 0.037):
        np.testing.assert_allclose(f(t, y, voltage=voltage), f(t, y), rtol=1e-8, atol=1e-9)


def test_a_voltage_that_a_resistance_takes_the_rate_of_is_asked_for_no_time_before_the_start():
    """The rate of a straight line is exact from the start on."""
    own = device("reduced")
    f, asked = gelcone.rates(own), []

    def line(t):
        asked.append(t)
        return 300.0 + 2e4 * t

    y = f.start + np.array([1e-4, 0.2])
    found = f(0.0, y, voltage=line)
    assert min(asked) == 0.0 < max(asked)
    np.testing.assert_allclose(found, f(1e-9, y, voltage=line), rtol=1e-6)
