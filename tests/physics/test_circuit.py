"""Circuits: the ideal source changes nothing, and a circuit of one's own has the defaults of the contract."""

import numpy as np
import pytest

from gelcone.physics.circuit import CIRCUITS, Circuit, IdealSource
from gelcone.physics.model import ConeModel
from tests.toys import FilteredVoltage


def test_the_ideal_source_gives_the_film_the_commanded_voltage():
    source = IdealSource()
    commanded = np.linspace(-1.0, 1.0, 5)
    assert source.voltage(commanded, [], {}) is commanded
    assert source.rates(commanded, [], {}) == []
    assert source.states == ()
    assert source.parameters == {}
    assert source.gain(3.0, {}) == 1.0


def test_the_table_of_circuits():
    assert all(circuit.name == name for name, circuit in CIRCUITS.items())
    assert isinstance(CIRCUITS["ideal"], IdealSource)


def test_a_circuit_without_a_voltage_cannot_be_made():
    class Unfinished(Circuit):
        name = "unfinished"

    with pytest.raises(TypeError, match="voltage"):
        Unfinished()


def test_a_filters_gain_is_that_of_its_own_rates():
    """y' = (v - y)/t under v = exp(i w tau): y = gain v solves it, and a constant voltage passes."""
    n = {"filter_time": 0.7}
    circuit = FilteredVoltage()
    for frequency in (0.0, 0.3, 4.0):
        gain = circuit.gain(frequency, n)
        (rate,) = circuit.rates(1.0, [gain], n)
        assert rate == pytest.approx(1j * frequency * gain, abs=1e-14)


def test_a_circuit_with_states_has_the_period_of_the_voltage_itself():
    """Its states follow the voltage's sign: after half a period they are not where they were."""
    ideal, filtered = ConeModel(drive_frequency=0.8), ConeModel(drive_frequency=0.8, circuit=FilteredVoltage())
    assert ideal.forcing_period == pytest.approx(np.pi / 0.8, rel=1e-15)
    assert filtered.forcing_period == pytest.approx(2.0 * np.pi / 0.8, rel=1e-15)
    assert [state.name for state in filtered.system.states] == ["displacement", "velocity", "film_voltage"]
    assert filtered.filter_time == 0.3


def test_the_voltage_on_a_filtered_film_follows_the_closed_form():
    """After its transient: gain |G| and phase of the RC filter, along a motion that heyoka integrates."""
    pytest.importorskip("heyoka")
    from gelcone.motion.flow import integrate

    model = ConeModel(circuit=FilteredVoltage(), filter_time=0.6, voltage=0.5, voltage_bias=0.2, drive_frequency=1.7)
    times = np.linspace(30.0, 40.0, 101)
    states = integrate(model, (0.3, 0.0), times).states[0]
    gain = model.system.circuit.gain(1.7, {"filter_time": 0.6})
    expected = 0.2 + 0.5 * np.imag(gain * np.exp(1j * 1.7 * times))
    np.testing.assert_allclose(states[:, 2], expected, atol=1e-12)
