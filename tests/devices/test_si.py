"""Results of a device in the units that its users read."""

import json

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.devices import si
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
        **{
            f"{name} = {float(1.5 / s.time)!r}: a positive time of at most {float(9.0 / s.time)!r}": (
                f"{name} = 1.5 s: a positive time of at most 9 s"
            )
            for name in ("budget", "transient", "patience", "window", "duration")
        },
        f"times: {float(0.2 / s.time)!r} comes after {float(0.3 / s.time)!r}": "times: 200 ms comes after 300 ms",
        f"before = {float(2500.0 / s.voltage)!r}: is high": "before = 2.5 kV: is high",
        f"voltages = [{float(3.0 / s.voltage)!r}, nan]: each once": "voltages = [3 V, nan]: each once",
        f"displacements = [{two}, -{three}]: each once": "displacements = [2 mm, -3 mm]: each once",
        f"displacements from {two} on: no film spans them within its stretch limit; give |x| below {three} or": (
            "displacements from 2 mm on: no film spans them within its stretch limit; give |x| below 3 mm or"
        ),
        f"window = {float(9.0 / s.time)!r}: is longer than {float(6.0 / s.time)!r}; give": (
            "window = 9 s: is longer than 6 s; give"
        ),
        f"8 time constants of the slowest state last {float(9.0 / s.time)!r}, longer than {float(6.0 / s.time)!r}": (
            "8 time constants of the slowest state last 9 s, longer than 6 s"
        ),
        f"8 decay times last {float(9.0 / s.time)!r}, longer": "8 decay times last 9 s, longer",
        f"frequencies: {float(-5.0 / s.frequency)!r} is among them": "frequencies: -5 Hz is among them",
        f"voltages = {float(250.0 / s.voltage)!r}: are not": "voltages = 250 V: are not",
        f"push = {float(0.5 / s.force)!r}: is far; its default is 0.1": "constant_force = 500 mN: is far",
        f"displacements from {two} to {four}: none is reached; stay within {three}": "displacements from 2 mm to 4 mm: "
        "none is reached; stay within 3 mm",
        f"must be less than {three} times film_radius - disc_radius either way": "must be less than 3 mm "
        f"({three} times film_radius - disc_radius) either way",
    }
    for plain, expected in cases.items():
        assert in_device_words(plain, device) == expected


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


def of(quantity, name="a name"):
    return {"units": "1", "quantity": quantity, "long_name": name}


def test_a_parameter_is_read_as_its_field_and_a_pure_number_stays():
    device = gelcone.find_device("biased-pump").replace(film="taut")
    data = xr.Dataset(
        {"stroke": ("member", [1.0, 2.0], of("length", "stroke x = h/(b-a)"))},
        coords={
            "voltage": ("member", [0.1, 0.2], of("parameter", "amplitude v")),
            "rest_height": ("member", [0.3, 0.4], of("parameter")),
            "hoop_prestretch": ("member", [1.1, 1.2], of("parameter", "hoop")),
        },
    )
    found = to_si(data, device)
    np.testing.assert_allclose(found["voltage"], np.array([0.1, 0.2]) * device.scales.voltage)
    assert found["voltage"].attrs == {
        "units": "V", "quantity": "parameter", "long_name": device.all_fields()["voltage_amplitude"].meaning,
    }  # fmt: skip
    np.testing.assert_allclose(found["rest_height"], np.array([0.3, 0.4]) * 1e3 * device.scales.length)
    assert found["rest_height"].attrs["units"] == "mm"
    assert found["hoop_prestretch"].attrs["units"] == "1"
    assert found["stroke"].attrs["long_name"] == "stroke"
    assert json.loads(found.attrs["device_fields"]) == device.parameters()
    assert device_of(found) == device


def test_an_axis_that_comes_to_differ_over_devices_is_a_coordinate_over_samples(device):
    """Of devices that differ in their time; what lies along it keeps its order of axes. Where there are samples already
    it is called after itself."""
    several = device.replace(moving_mass=[1e-3, 4e-3])
    for taken, dim in ((), "sample"), (("sample",), "time_sample"):
        more = {name: (name, [1.0, 2.0, 3.0], of("code")) for name in taken}
        data = xr.Dataset(
            {"height": (("member", "time"), [[1.0, 2.0], [3.0, 4.0]], of("length")), **more},
            coords={"time": ("time", [0.0, 10.0], of("time"))},
        )
        found = to_si(data, several)
        assert found["height"].dims == ("member", dim)
        assert set(found["time"].dims) == {"member", dim}
        expected = np.outer(1e3 * several.scales.time, [0.0, 10.0])
        np.testing.assert_allclose(found["time"].transpose("member", dim), expected)
        np.testing.assert_allclose(found["moving_mass"], [1.0, 4.0])
        assert found["moving_mass"].attrs["units"] == "g"


@pytest.mark.parametrize(
    ("name", "unit"), [("rest_height", "mm"), ("voltage", "V"), ("spring_stiffness", "N/m"), ("prestretch", "1")]
)
def test_the_model_of_a_result_over_a_parameter_is_that_of_the_analysis(device, name, unit):
    """The coordinate has the unit of the device's field."""
    plain = device.replace(film="taut", initial_height="6 mm").to_model()
    model = plain.replace(**{name: plain.values[name] * np.array([1.0, 1.05])})
    shown = to_si(gelcone.limits(model), device)
    assert shown[name].attrs["units"] == unit
    back = gelcone.model_of(shown)
    for own, value in model.values.items():
        np.testing.assert_allclose(back.values[own], value, rtol=1e-12)


def test_results_over_the_youngs_modulus_have_the_scales_of_a_gel_a_third_as_stiff_in_shear(device):
    modulus = {"long_name": "modulus", "units": "Pa", "quantity": "device field"}
    data = xr.Dataset(
        {name: ((), 1.0, of(name)) for name in ("stress", "force", "time", "voltage")},
        coords={"material.young_modulus": ("material.young_modulus", [30e3, 60e3], modulus)},
    )
    found = to_si(data, device)
    np.testing.assert_allclose(found["stress"], [10.0, 20.0])  # kPa
    for k, value in enumerate((30e3, 60e3)):
        scales = device.replace({"material.young_modulus": value}).scales
        for name in data:
            assert float(found[name][k]) == pytest.approx(float(scales.shown(name)), rel=1e-12)


def test_numbers_of_all_cells_become_those_of_each_behind_their_own_axes(device):
    """A variable without the swept axis, whose scale hangs on it."""
    thickness = {"long_name": "thickness", "units": "m", "quantity": "device field"}
    data = xr.Dataset(
        {"volts": ("time", [1.0, 2.0, 3.0], of("voltage"))},
        coords={"film_thickness": ("film_thickness", [1e-4, 2e-4], thickness)},
    )
    found = to_si(data, device)
    assert found["volts"].dims == ("time", "film_thickness")
    scales = [device.replace(film_thickness=value).scales.voltage for value in (1e-4, 2e-4)]
    np.testing.assert_allclose(found["volts"], np.outer([1.0, 2.0, 3.0], scales))
    np.testing.assert_array_equal(found["film_thickness"], [0.1, 0.2])
    assert found["film_thickness"].attrs["units"] == "mm"


def test_members_bear_the_names_of_gels_of_which_there_is_one_each(device):
    gels = ["PVC-DBA 4:1", "PVC-DBA 8:1"]
    several = device.replace(material=gels, film="taut")
    shown = si._with_member_fields(xr.Dataset({"x": ("member", np.ones(2))}), several)
    assert shown["material"].values.tolist() == gels
    np.testing.assert_allclose(shown["material.shear_modulus"], several.material.shear_modulus)


def test_a_variable_along_fields_of_its_own_has_their_scales(device):
    """Over draws, whose values of a field another variable holds; all others have the device's."""
    data = xr.Dataset(
        {
            "drawn": ("draw", [2e-4, 1e-4], {"units": "m", "quantity": "device field", "long_name": "drawn"}),
            "volts": ("draw", [1.0, 1.0], of("voltage") | {"along": "film_thickness=drawn"}),
            "plain": ("draw", [1.0, 1.0], of("voltage")),
        }
    )
    found = to_si(data, device)
    scales = [device.replace(film_thickness=value).scales.voltage for value in (2e-4, 1e-4)]
    np.testing.assert_allclose(found["volts"], scales)
    np.testing.assert_allclose(found["plain"], device.scales.voltage)


def test_a_gel_whose_name_looks_like_several_is_one(device):
    gel = gelcone.Material(name="a / b", shear_modulus=9e3, relative_permittivity=5.0)
    several = device.replace(material=gel, film="taut", moving_mass=[1e-3, 2e-3, 3e-3])
    shown = si._with_member_fields(xr.Dataset({"x": ("member", np.ones(3))}), several)
    assert "material" not in shown.coords
    np.testing.assert_array_equal(shown["moving_mass"], [1e-3, 2e-3, 3e-3])
