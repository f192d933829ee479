"""Points of a sweep over fields: the devices there, their models and starts."""

import numpy as np
import pytest

from gelcone.devices.device import find_device
from gelcone.devices.points import (
    at,
    device_at,
    dimensionless_state,
    field_attributes,
    own_states,
    point_fields,
    read_state,
    read_swept,
    unit_of,
)  # fmt: skip
from gelcone.errors import InputError
from gelcone.physics.component import State

PUMP = find_device("biased-pump").replace(film="taut")
SLOW = PUMP.replace(series_resistance="1 Mohm")


def test_models_and_starts_are_those_of_each_device():
    values = {"film_thickness": np.array([1.8e-4, 2.2e-4]), "voltage_amplitude": np.array([300.0, 500.0])}
    model, states = device_at(PUMP, values)
    for k in range(2):
        alone = PUMP.replace(
            film_thickness=values["film_thickness"][k], voltage_amplitude=values["voltage_amplitude"][k]
        )
        own = alone.to_model()
        for name in ("voltage", "damping_ratio", "drive_frequency", "spring_stiffness"):
            assert np.broadcast_to(model.values[name], 2)[k] == pytest.approx(float(own.values[name]), rel=1e-13)
        np.testing.assert_allclose(states[k], alone.initial_state(), rtol=1e-9)


def test_a_sweep_of_starts_alone_has_the_damping_of_the_device():
    values = {"displacement": np.array([1e-3, 2e-3, 3e-3]), "velocity": np.array([0.0, 0.1, 0.2])}
    model, states = device_at(PUMP, values)
    assert np.unique(model.damping_ratio).tolist() == [PUMP.to_model().damping_ratio]
    np.testing.assert_allclose(states[:, 0] * PUMP.scales.length, values["displacement"])
    np.testing.assert_allclose(states[:, 1] * PUMP.scales.velocity, values["velocity"])


def test_what_a_point_has_no_start_of_comes_from_the_given_one_or_the_devices_own():
    values = {"displacement": np.array([1e-3, 2e-3])}
    _, given = device_at(PUMP, values, (5e-3, 0.3))
    np.testing.assert_allclose(given[:, 0] * PUMP.scales.length, values["displacement"])
    np.testing.assert_allclose(given[:, 1] * PUMP.scales.velocity, 0.3)
    moving = PUMP.replace(release_height="4 mm", release_velocity="0.2 m/s")
    _, own = device_at(moving, {"velocity": np.array([0.5, 0.6])})
    np.testing.assert_allclose(own[:, 0] * PUMP.scales.length, 4e-3)
    np.testing.assert_allclose(own[:, 1] * PUMP.scales.velocity, [0.5, 0.6])


def test_states_are_read_with_their_units_and_divided_by_their_scales():
    assert read_state(("5 mm", "0.1 m/s")) == (5e-3, 0.1)
    states = own_states(SLOW)
    assert [unit_of(state) for state in states] == ["V"]
    full = read_state(("5 mm", "0 m/s", "300 V"), SLOW)
    assert full == (5e-3, 0.0, 300.0)
    s = SLOW.scales
    np.testing.assert_allclose(dimensionless_state(SLOW, full), [5e-3 / s.length, 0.0, 300.0 / s.voltage], rtol=1e-13)
    np.testing.assert_allclose(dimensionless_state(SLOW, full[:2]), [5e-3 / s.length, 0.0], rtol=1e-13)
    with pytest.raises(InputError, match="must be a displacement and a velocity"):
        read_state(("5 mm",), SLOW)
    with pytest.raises(InputError, match="or all of them: displacement, velocity"):
        read_state(("5 mm", "0 m/s", "1 V", "2 V"), SLOW)


def test_fields_are_read_in_si_and_described():
    assert read_swept(PUMP, "film_thickness", ["0.2 mm", 3e-4]).tolist() == [2e-4, 3e-4]
    assert field_attributes(PUMP, "film_thickness")["units"] == "m"
    assert field_attributes(PUMP, "velocity")["units"] == "m/s"
    assert set(point_fields(PUMP)) - set(PUMP.swept_fields()) == {"displacement", "velocity"}
    with pytest.raises(InputError, match="film: is not numeric and cannot be swept"):
        read_swept(PUMP, "film", ["taut"])


def test_the_device_at_points_takes_their_fields_and_not_their_states():
    points = at(PUMP, {"frequency": np.array([8.0, 9.0]), "displacement": np.array([0.0, 1e-3])})
    assert points.frequency.tolist() == [8.0, 9.0]
    assert at(PUMP, {"displacement": np.array([0.0, 1e-3])}) is PUMP


def test_points_that_differ_in_size_have_states_over_their_own_scales():
    values = {"film_radius": np.array([0.03, 0.05]), "displacement": np.array([2e-3, 2e-3])}
    model, states = device_at(PUMP, values, (9.0, 0.3))
    devices = [PUMP.replace(film_radius=radius) for radius in values["film_radius"]]
    np.testing.assert_allclose(states[:, 0], [2e-3 / own.scales.length for own in devices])
    np.testing.assert_allclose(states[:, 1], [0.3 / own.scales.velocity for own in devices])
    assert model.shape == (2,)


def test_two_states_are_enough_of_a_device_that_has_more_and_of_any_other():
    assert read_state(("5 mm", "0.1 m/s"), SLOW) == (5e-3, 0.1)
    assert read_state(np.array([5e-3, 0.1])) == (5e-3, 0.1)
    with pytest.raises(InputError, match=r"such as \('5 mm', '0 m/s'\)$"):
        read_state("5 mm", PUMP)
    creeping = SLOW.replace({"material.viscous_modulus_1": "4 kPa", "material.relaxation_time_1": "2 s"})
    assert [unit_of(state) for state in own_states(creeping)] == ["1", "1", "V"]
    full = read_state((5e-3, 0.1, 0.8, 0.9, "20 V"), creeping)
    assert full == (5e-3, 0.1, 0.8, 0.9, 20.0)
    s = creeping.scales
    own = [5e-3 / s.length, 0.1 / s.velocity, 0.8, 0.9, 20.0 / s.voltage]
    np.testing.assert_allclose(dimensionless_state(creeping, full), own)
    both = creeping.replace(film_thickness=[1e-4, 2e-4])
    rows = dimensionless_state(both, full)
    np.testing.assert_allclose(rows[:, 4], 20.0 / both.scales.voltage)
    assert rows.shape == (2, 5)


def test_a_state_is_read_in_si_and_the_volts_of_a_charge_in_coulomb():
    """Not in the units that results are read in."""
    for quantity, unit in (("charge", "C"), ("length", "m"), ("voltage", "V"), ("share", "1"), ("energy", "J")):
        assert unit_of(State("s", "a state", quantity)) == unit


def test_gels_are_taken_by_their_names():
    assert read_swept(PUMP, "material", ["PVC-DBA 6:1"]).tolist() == ["PVC-DBA 6:1"]
    assert field_attributes(PUMP, "material") == {"long_name": "gel", "units": "1", "quantity": "device field"}
    two = at(PUMP, {"material": np.array(["PVC-DBA 6:1", "PVC-DBA 6:1"])})
    assert two.material.shear_modulus == PUMP.material.shear_modulus
    with pytest.raises(InputError, match="colour"):
        read_swept(PUMP, "colour", [1.0])
