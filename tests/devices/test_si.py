"""Results of a device in the units that its users read."""

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.devices.scales import MEASURES
from gelcone.devices.si import device_of, in_field_units, to_si
from gelcone.devices.units import DIMENSIONS, parse


@pytest.fixture(scope="module")
def device():
    return gelcone.find_device("soft-film")


@pytest.mark.parametrize(
    ("quantity", "unit", "scale"),
    [
        ("length", "mm", lambda s: 1e3 * s.length),
        ("time", "ms", lambda s: 1e3 * s.time),
        ("velocity", "m/s", lambda s: s.length / s.time),
        ("force", "N", lambda s: s.force),
        ("stiffness", "N/m", lambda s: s.force / s.length),
        ("energy", "mJ", lambda s: 1e3 * s.force * s.length),
        ("power", "mW", lambda s: 1e3 * s.force * s.length / s.time),
        ("apparent power", "mVA", lambda s: 1e3 * s.force * s.length / s.time),
        ("voltage", "V", lambda s: s.voltage),
        ("current", "mA", lambda s: 1e3 * s.force * s.length / s.time / s.voltage),
        ("field", "V/um", lambda s: 1e-6 * s.field),
        ("stress", "kPa", lambda s: 1e-3 * s.stress),
        ("frequency", "Hz", lambda s: 1.0 / (2.0 * np.pi * s.time)),
        ("rate", "1/s", lambda s: 1.0 / s.time),
        ("cubic stiffness", "N/m^3", lambda s: s.force / s.length**3),
        ("resistance", "Mohm", lambda s: 1e-6 * s.voltage**2 / s.power),
        ("charge", "uC", lambda s: 1e6 * s.energy / s.voltage),
        ("capacitance", "nF", lambda s: 1e9 * s.energy / s.voltage**2),
        ("resistivity", "Gohm m", lambda s: 1e-9 * s.time * s.field**2 / s.stress),
        ("slew rate", "V/ms", lambda s: 1e-3 * s.voltage / s.time),
        ("thickness", "mm", lambda s: 1e3 * s.voltage / s.field),
        ("gain", "mm/kV", lambda s: 1e6 * s.length / s.voltage),
        ("admittance", "uS", lambda s: 1e6 * s.energy / s.voltage**2 / s.time),
        ("heating", "mK/s", lambda s: 1e3 * s.stress / s.time / 1.8e6),
        ("energy density", "J/m^3", lambda s: s.stress),
        ("power density", "W/m^3", lambda s: s.stress / s.time),
        ("specific energy", "mJ/kg", lambda s: 1e3 * (s.length / s.time) ** 2),
        ("specific power", "mW/kg", lambda s: 1e3 * s.length**2 / s.time**3),
    ],
)
def test_a_quantity_has_its_unit_and_scale(device, quantity, unit, scale):
    assert MEASURES[quantity].shown == unit
    assert device.scales.shown(quantity) == pytest.approx(scale(device.scales), rel=1e-12)


@pytest.mark.parametrize(("unit", "size"), [("mm", 1e-3), ("kPa", 1e3), ("V", 1.0), ("kHz", 1e3), ("1", 1.0)])
def test_a_coordinate_over_a_field_goes_to_the_si_unit_of_the_field(unit, size):
    values = xr.DataArray([2.0, 3.0], dims="at", attrs={"units": unit, "quantity": "device field"})
    np.testing.assert_allclose(in_field_units(values), [2.0 * size, 3.0 * size])
    xr.testing.assert_identical(
        in_field_units(values.assign_attrs(quantity="length")), values.assign_attrs(quantity="length")
    )


def test_every_quantity_that_is_read_in_si_is_tested():
    assert len(MEASURES) == 28


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


@pytest.mark.parametrize("quantity", MEASURES)
def test_the_units_of_a_quantity_agree(device, quantity):
    """What is read, shown and scaled is one size: the shown unit is one of the SI unit's, where these can be read."""
    unit, shown, per_unit = MEASURES[quantity]
    if unit in DIMENSIONS:
        assert parse("", f"1 {shown}", unit) * per_unit == pytest.approx(1.0, rel=1e-15)
    value = 3.0 * device.scales.size(quantity)
    assert device.scales.dimensionless(quantity, value) == pytest.approx(3.0, rel=1e-14)
