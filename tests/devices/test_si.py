"""Results of a device in the units that its users read."""

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.devices.si import device_of, in_device_words, in_field_units, shown_values, to_si


@pytest.fixture(scope="module")
def device():
    return gelcone.find_device("soft-film")


@pytest.mark.parametrize(("unit", "size"), [("mm", 1e-3), ("kPa", 1e3), ("V", 1.0), ("kHz", 1e3), ("1", 1.0)])
def test_a_coordinate_over_a_field_goes_to_the_si_unit_of_the_field(unit, size):
    values = xr.DataArray([2.0, 3.0], dims="at", attrs={"units": unit, "quantity": "device field"})
    np.testing.assert_allclose(in_field_units(values), [2.0 * size, 3.0 * size])
    xr.testing.assert_identical(
        in_field_units(values.assign_attrs(quantity="length")), values.assign_attrs(quantity="length")
    )


def test_variables_and_coordinates_are_scaled_up_and_others_left_alone(device):
    data = xr.Dataset(
        {
            "length": ("t", [1, 2], {"units": "1", "quantity": "length"}),
            "done": ("t", [1.0, 2.0], {"units": "mm", "quantity": "length"}),
            "ratio": ("t", [1.0, 2.0], {"units": "1", "quantity": "ratio"}),
            "plain": ("t", [1.0, 2.0]),
        },
        coords={"t": ("t", [0.0, 3.0], {"units": "1", "quantity": "time", "long_name": "time"})},
    )
    found = to_si(data, device)
    np.testing.assert_allclose(found["length"], 1e3 * device.scales.length * np.array([1.0, 2.0]))
    np.testing.assert_allclose(found["t"], 1e3 * device.scales.time * np.array([0.0, 3.0]))
    assert found["t"].attrs == {"units": "ms", "quantity": "time", "long_name": "time"}
    for name in ("done", "ratio", "plain"):
        np.testing.assert_array_equal(found[name].values, data[name].values)
    assert found.attrs["device"] == device.name
    assert device_of(found) == device
    assert data["length"].attrs["units"] == "1"


def test_results_of_a_device_are_scaled_once():
    device = gelcone.find_device("soft-film").replace(frequency=[8.0, 10.0])
    result = gelcone.simulate(device.to_model(), device.initial_state(), periods=2)
    shown = gelcone.to_si(result, device)
    scales = {"displacement": 1e3 * device.scales.length, "drive_voltage": device.scales.voltage, "hoop_stretch": 1.0}
    for name, scale in scales.items():
        np.testing.assert_allclose(shown[name], result[name] * scale, rtol=1e-15)
    np.testing.assert_allclose(shown.time, result.time * 1e3 * device.scales.time, rtol=1e-15)
    assert [shown[name].attrs["units"] for name in ("time", "displacement", "hoop_stretch")] == ["ms", "mm", "1"]
    assert "device" not in result.attrs
    xr.testing.assert_identical(gelcone.to_si(shown, device), shown)


@pytest.mark.parametrize(
    "over", [{"frequency": [8.0, 9.0, 10.0]}, {"frequency": [8.0, 9.0, 10.0], "film_thickness": [1e-4, 2e-4]}]
)
def test_the_model_of_a_sweep_has_the_numbers_of_each_device(over):
    device = gelcone.find_device("biased-pump").replace(film="taut")
    cells = gelcone.sweep(gelcone.Plan(device, over), "limits")
    model = gelcone.model_of(cells)
    shape = tuple(len(values) for values in over.values())
    assert np.shape(model.drive_frequency) == shape
    for place in np.ndindex(shape):
        own = device.replace(
            {name: values[k] for (name, values), k in zip(over.items(), place, strict=True)}
        ).to_model()
        for name in ("drive_frequency", "voltage", "spring_stiffness"):
            value = np.broadcast_to(model.values[name], shape)[place]
            assert value == pytest.approx(float(own.values[name]), rel=1e-12)


def test_messages_are_said_in_fields_and_units_of_the_device(device):
    """A parameter by the name of its field, with its value in SI; sizes in sentences too; defaults are left out."""
    s = device.scales
    two, three, four = (repr(float(k * 1e-3 / s.length)) for k in (2, 3, 4))
    cases = {
        f"voltage = {float(2.0 / s.voltage)!r}: is too high": "voltage_amplitude = 2 V: is too high",
        f"rest_height = {three}: raise it": "initial_height = 3 mm: raise it",
        "rest_height: raise it": "initial_height: raise it",
        "hoop_prestretch = 1.25: lower it": "hoop_prestretch = 1.25: lower it",
        "the voltage of the film": "the voltage of the film",
        "damping_ratio = 0: give it some": "damping_coefficient = 0: give it some",
        "damping_ratio = 0.1: is small": "damping_coefficient: is small",
        f"initial displacement {two} is far": "initial displacement 2 mm is far",
        f"budget = {float(1.5 / s.time)!r}: must be a positive time": "budget = 1.5 s: must be a positive time",
        f"voltages = {float(250.0 / s.voltage)!r}: are not": "voltages = 250 V: are not",
        f"push = {float(0.5 / s.force)!r}: is far; its default is 0.1": "constant_force = 500 mN: is far",
        f"displacements from {two} to {four}: none is reached; stay within {three}": "displacements from 2 mm to 4 mm: "
        "none is reached; stay within 3 mm",
    }
    for plain, told in cases.items():
        assert in_device_words(plain, device) == told


def test_values_of_cells_are_shown_by_the_scales_of_each(device):
    """Behind the cells they may have any axes; a state has a factor for each of its numbers."""
    several = device.replace(film_radius=[0.02, 0.03], moving_mass=[1e-3, 4e-3]).scales
    length = {"units": "1", "quantity": "length", "long_name": "displacement x = h/(b-a)"}
    values = np.arange(1.0, 7.0).reshape(2, 3)
    found, attrs = shown_values(values, length, several)
    np.testing.assert_allclose(found, values * 1e3 * several.length[:, None])
    assert (attrs["units"], attrs["long_name"]) == ("mm", "displacement")
    assert length["units"] == "1"
    states = np.arange(1.0, 9.0).reshape(2, 1, 4)
    found, attrs = shown_values(states, {"units": "1", "quantity": "state", "long_name": "state"}, several)
    expected = states.copy()
    expected[..., 0] *= 1e3 * several.length[:, None]
    expected[..., 1] *= several.velocity[:, None]
    np.testing.assert_allclose(found, expected)
    assert attrs["units"] == "mm, m/s, 1, 1"
    for own in ({"units": "mm", "quantity": "length"}, {"units": "1", "quantity": "code"}):
        same, taken = shown_values(values, own, several)
        assert same is values
        assert taken == own
