"""Small signals: python-control, SciPy, the full model, the slopes of film and circuit."""

from __future__ import annotations

import control
import numpy as np
import pytest
from scipy import signal

import gelcone
from gelcone.devices.device import find_device
from gelcone.errors import InputError
from gelcone.motion import state_space as module
from gelcone.motion.flow import integrate
from gelcone.motion.state_space import equilibrium_under_bias, small_signal_response, state_space
from gelcone.physics.model import ConeModel
from tests.toys import FilteredVoltage, SeriesResistor

BIASED = ConeModel(
    damping_ratio=0.1, voltage=1e-4, voltage_bias=0.6, drive_frequency=1.3, rest_height=0.8, hoop_prestretch=1.4
)


def test_python_control_takes_the_matrices_as_they_are():
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


@pytest.mark.parametrize("voltage", [500.0, "0.5 kV"])
def test_a_voltage_of_a_device_is_in_volts_whichever_way_the_device_is_given(voltage):
    device = find_device("biased-pump").replace(film="taut")
    own = state_space(device.to_model(), voltage=500.0 / device.scales.voltage).A
    for found in (state_space(device, voltage=voltage), state_space(device.to_model(), device, voltage=voltage)):
        unscaled = found.A * [[device.scales.time, 1.0], [device.scales.time**2, device.scales.time]]
        np.testing.assert_allclose(unscaled, own, rtol=1e-12, atol=1e-12)
    with pytest.raises(InputError, match="voltage: 30 kV: beyond pull-in"):
        state_space(device.replace(film="wrinkling"), voltage="30 kV")


PAIR = {"second_film": "wrinkling", "second_flat_height": 1.5}


@pytest.mark.parametrize(
    ("second", "said"),
    [
        ({}, "voltage: 9: .*; lower it$"),
        (PAIR | {"second_drive": "opposite", "voltage_bias": 0.3}, "voltage: 9: .*; take one closer to voltage_bias$"),
        (PAIR | {"second_drive": "opposite", "voltage_bias": 8.0}, "voltage_bias = 8: .*; lower it$"),
        (PAIR | {"second_drive": "constant", "second_voltage": 7.0}, "second_voltage = 7: .*; lower it$"),
    ],
)
def test_a_voltage_beyond_pull_in_is_refused_with_what_is_to_be_changed(second, said):
    model = ConeModel(film="wrinkling", hoop_prestretch=1.4, rest_height=0.8, **second)
    with pytest.raises(InputError, match=said):
        equilibrium_under_bias(model, 9.0, "voltage:")


def test_without_a_bias_the_voltage_has_no_first_order_effect():
    assert (state_space(ConeModel(rest_height=0.5)).B == 0.0).all()


def test_a_half_wave_has_no_bias_below_0_and_the_linear_model_may_be_about_one():
    model = ConeModel(waveform="half_wave", voltage=0.5, voltage_bias=-0.3, rest_height=0.8, hoop_prestretch=1.4)
    assert not gelcone.state_space(model).B.any()
    pair = model.replace(second_film="taut", second_drive="opposite", second_flat_height=1.4, voltage_bias=0.3)
    here, there = (gelcone.state_space(pair, voltage=sign * 0.4) for sign in (1.0, -1.0))
    np.testing.assert_allclose(here.A, there.A, rtol=1e-12)
    np.testing.assert_allclose(here.B, -there.B, rtol=1e-12)


@pytest.mark.parametrize("frequencies", [[0.0], [-1.0], [np.nan], [np.inf]])
def test_frequencies_are_positive(frequencies):
    """The first wrong one is named."""
    message = f"^frequencies: {frequencies[0]:g} is among them; they must be positive and finite, leave it out$"
    with pytest.raises(InputError, match=message):
        small_signal_response(BIASED, [1.0, *frequencies, -7.0])


@pytest.mark.parametrize(
    ("frequencies", "message"),
    [
        ([], r"^frequencies = \[\]: is empty; give at"),
        ([[1.0], [2.0]], r"^frequencies: .* a list, not of shape \(2, 1\)"),
    ],
)
def test_frequencies_are_a_list_of_one_or_more(frequencies, message):
    with pytest.raises(InputError, match=message):
        small_signal_response(BIASED, frequencies)


def test_an_ensemble_has_no_single_state_space():
    with pytest.raises(InputError, match="one actuator"):
        state_space(ConeModel(voltage=[0.1, 0.2]))


def test_a_filter_multiplies_the_gain_by_its_own():
    """In modulus and phase: the filter stands in front of the same actuator."""
    omega = np.array([0.2, 0.9, 3.0])
    filtered = BIASED.replace(circuit=FilteredVoltage(), filter_time=0.6)
    own = filtered.system.circuit.gain(omega, {"filter_time": 0.6})
    plain, found = (small_signal_response(model, omega) for model in (BIASED, filtered))
    np.testing.assert_allclose(found["gain"], plain["gain"] * np.abs(own), rtol=1e-10)
    lag = (found["phase"] - plain["phase"] - np.degrees(np.angle(own)) + 180.0) % 360.0 - 180.0
    np.testing.assert_allclose(lag, 0.0, atol=1e-9)


def test_the_state_space_of_three_states_is_the_jacobian_at_the_equilibrium():
    model = BIASED.replace(circuit=FilteredVoltage(), filter_time=0.6, voltage=0.0)
    found = state_space(model)
    place = equilibrium_under_bias(model, 0.6)
    at = np.array([place, 0.0, 0.6])
    assert np.abs(np.array(model.system.rates(0.0, at, model.own_numbers))).max() < 1e-12
    h = 1e-6
    columns = [
        (
            np.array(model.system.rates(0.0, at + s, model.own_numbers))
            - model.system.rates(0.0, at - s, model.own_numbers)
        )
        / (2.0 * h)
        for s in h * np.eye(3)
    ]
    np.testing.assert_allclose(found.A, np.transpose(columns), rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(found.B, [[0.0], [0.0], [1.0 / 0.6]], rtol=1e-14)
    np.testing.assert_array_equal(found.C, [[1.0, 0.0, 0.0]])


ELECTRIC = ("displacement", "velocity", "charge", "capacitance")
FILMS = {
    "taut": {"film": "taut"},
    "hoop-slack": {"film": "wrinkling", "meridional_prestretch": 1.0, "hoop_prestretch": 1.05},
    "membrane": {"film": "membrane"},
}


@pytest.mark.parametrize("kind", FILMS)
def test_the_rows_of_charge_and_capacitance_are_the_slopes_of_the_film(kind):
    """Against differences of the film's own capacitance, and by reciprocity dQ/dx = - dF/dv."""
    device = find_device("biased-pump").replace(FILMS[kind])
    volts = 1690.0 if kind == "hoop-slack" else 1410.0
    model = device.replace(voltage_offset=volts).to_model()
    found = state_space(model, outputs=ELECTRIC)
    x, v, n = found.place, float(model.voltage_bias), model.numbers()
    assert kind != "hoop-slack" or int(model.film.state(x, v, [], n).kind) == 1

    def charge(x, v):
        return v * float(model.film.capacitance(x, v * v, [], n))

    step = 1e-5
    by_x = (charge(x + step, v) - charge(x - step, v)) / (2.0 * step)
    by_v = (charge(x, v + step) - charge(x, v - step)) / (2.0 * step)
    near = 5e-3 if kind == "membrane" else 1e-6  # a program's charge of a membrane is a fit
    assert found.C[2, 0] == pytest.approx(by_x, rel=near)
    assert found.D[2, 0] == pytest.approx(by_v, rel=near)
    assert found.C[2, 0] == pytest.approx(found.B[1, 0], rel=near)
    scaled = state_space(device, voltage=volts, outputs=ELECTRIC)
    s = device.scales
    assert scaled.C[2, 0] == pytest.approx(found.C[2, 0] * s.size("charge") / s.length, rel=1e-9)
    assert scaled.D[3, 0] == pytest.approx(found.D[3, 0] * s.size("capacitance") / s.voltage, rel=1e-9, abs=1e-25)
    assert scaled.place == pytest.approx(x * s.length)


def test_a_force_moves_the_disc_by_the_compliance():
    device = find_device("biased-pump").replace(film="taut")
    found = state_space(device, inputs=("voltage", "force"))
    static = -found.C @ np.linalg.solve(found.A, found.B) + found.D
    model, s = device.to_model(), device.scales
    stiffness = float(model.stiffness(found.place / s.length, model.voltage_bias)) * s.force / s.length
    assert static[0, 1] == pytest.approx(1.0 / stiffness, rel=1e-9)
    assert found.inputs == ("voltage", "force")


def test_behind_a_resistance_the_current_is_the_rate_of_the_charge():
    model = BIASED.replace(circuit=SeriesResistor(), series_resistance=0.4)
    found = state_space(model, outputs=("charge", "current"))
    for omega in (0.3, 1.1, 4.0):
        charge, current = found.C @ np.linalg.solve(1j * omega * np.eye(3) - found.A, found.B) + found.D
        assert current[0] == pytest.approx(1j * omega * charge[0], rel=1e-10)


@pytest.mark.parametrize("kind", ["taut", "hoop-slack"])
def test_behind_an_ideal_source_the_current_follows_the_rate_of_the_voltage(kind):
    device = find_device("biased-pump").replace(FILMS[kind])
    outputs = ("charge", "current", "displacement")
    found = state_space(device, voltage=1200.0, inputs=("voltage_rate", "voltage"), outputs=outputs)
    for omega in (30.0, 110.0, 4000.0):
        gains = found.C @ np.linalg.solve(1j * omega * np.eye(2) - found.A, found.B) + found.D
        charge, current, height = gains[:, 0] * 1j * omega + gains[:, 1]
        assert current == pytest.approx(1j * omega * charge, rel=1e-10)
        assert gains[0, 0] == gains[2, 0] == 0.0
        assert height == gains[2, 1]


@pytest.mark.parametrize("law", [{}, {"leakage_field": 0.5}])
def test_a_constant_voltage_drives_the_leak_alone_through_a_film(law):
    """The gain of the current at frequency 0 against differences of the currents at two rests."""
    model = BIASED.replace(leakage_time=20.0, **law)
    found = state_space(model, inputs=("voltage", "voltage_rate"), outputs=("current", "displacement"))
    gain = (found.D - found.C @ np.linalg.solve(found.A, found.B))[:, 0]
    leaks = []
    for volts in (0.6 - 1e-4, 0.6 + 1e-4):
        place = float(gelcone.stroke_and_blocked_force(model, volts)["displacement"].values[0])
        members = model.replace(voltage=0.0, voltage_bias=volts).members()
        rest = members.start_states((place, 0.0))[:, None]
        leaks.append(float(np.ravel(members.along(members.system.currents, np.zeros((1, 1)), rest)[0])[0]))
    assert leaks[0] > 0.01
    assert gain[0] == pytest.approx(np.diff(leaks)[0] / 2e-4, rel=1e-5)


def test_the_rate_of_the_voltage_is_an_input_of_an_ideal_source_alone():
    with pytest.raises(InputError, match="voltage_rate"):
        state_space(BIASED.replace(circuit=SeriesResistor(), series_resistance=0.4), inputs=("voltage_rate",))


def test_an_ideal_source_makes_the_current_jump():
    with pytest.raises(InputError, match="take charge"):
        state_space(BIASED, outputs=("current",))


@pytest.mark.parametrize("names", [{"outputs": ("height",)}, {"inputs": ("current",)}])
def test_unknown_inputs_and_outputs_are_refused(names):
    with pytest.raises(InputError, match="of a linear model"):
        state_space(BIASED, **names)


def test_python_control_takes_the_names():
    found = state_space(BIASED, inputs=("voltage", "force"), outputs=("displacement", "charge"))
    system = found.to_control()
    assert isinstance(system, control.StateSpace)
    assert system.output_labels == ["displacement", "charge"]
    assert system.input_labels == ["voltage", "force"]


def test_a_linear_model_of_a_device_is_that_of_its_model_times_its_scales():
    """Of two inputs and all that is known behind an ideal source, whose rate is the third input."""
    device = gelcone.find_device("biased-pump").replace(film="taut", voltage_offset="600 V")
    given = {
        "inputs": ("force", "voltage_rate", "voltage"),
        "outputs": ("velocity", "current", "charge", "capacitance"),
    }
    own, si = gelcone.state_space(device.to_model(), **given), gelcone.state_space(device, **given)
    scales, omega = device.scales, np.array([0.3, 2.0])
    u = np.array([float(scales.size(module.INPUTS[name])) for name in given["inputs"]])
    y = np.array([float(scales.size(module.OUTPUTS[name])) for name in given["outputs"]])
    np.testing.assert_allclose(si.transfer(omega / scales.time), own.transfer(omega) * y[:, None] / u, rtol=1e-9)
    x = np.array([float(scales.size("length")), float(scales.size("velocity"))])
    np.testing.assert_allclose(si.rest, np.array(own.rest) * x)
    assert si.place == pytest.approx(own.place * x[0])
    assert (si.inputs, si.outputs) == (given["inputs"], given["outputs"])
    jump = own.D[given["outputs"].index("current")]
    assert jump[1] == pytest.approx(1.0 + own.place**2)  # the capacitance, by which the rate of the voltage passes
    assert jump[[0, 2]].tolist() == [0.0, 0.0]


def test_the_phase_of_a_small_signal_is_in_degrees_and_its_gain_that_of_the_linear_model():
    model = ConeModel(voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4, damping_ratio=0.1)
    found = gelcone.small_signal_response(model, [0.5, 1.5])
    transfer = gelcone.state_space(model).transfer(np.array([0.5, 1.5]))[:, 0, 0]
    np.testing.assert_allclose(found["gain"] * np.exp(1j * np.radians(found["phase"])), transfer, rtol=1e-9)
    assert (found["phase"] < -1.0).all()
    assert found.attrs["title"] == "small-signal frequency response"
