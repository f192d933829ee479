"""What is swept, from text, and the words of what cannot be."""

import numpy as np
import pytest

import gelcone
from gelcone import ConeModel, InputError, find_device
from gelcone.analyses.request import read_subject
from gelcone.analyses.swept import example, increasing, read_over, read_states


def test_over_reads_ranges_and_lists_in_their_order():
    swept = read_over(["voltage=0:2:5", "stretch_limit=1, 10, inf"])
    assert list(swept) == ["voltage", "stretch_limit"]
    assert swept["voltage"].tolist() == [0.0, 0.5, 1.0, 1.5, 2.0]
    assert swept["stretch_limit"].tolist() == [1.0, 10.0, np.inf]


def test_with_a_device_its_fields_are_swept_in_si():
    device = find_device("paper-table1")
    swept = read_over(
        ["voltage_amplitude=0 V:1 kV:3", "frequency=1,2", "material.shear_modulus=10 kPa,0.02 MPa"], device
    )
    np.testing.assert_allclose(swept["voltage_amplitude"], [0.0, 500.0, 1000.0])
    np.testing.assert_allclose(swept["frequency"], [1.0, 2.0])
    np.testing.assert_allclose(swept["material.shear_modulus"], [1e4, 2e4])


@pytest.mark.parametrize(
    ("over", "message"),
    [
        ("voltage=0:1:3", "^--over voltage: 'voltage' is not a device field; did you mean 'voltage_amplitude'"),
        ("drive_frequency=1,2", "did you mean 'frequency'"),
        ("stretch_limit=1,2", "did you mean 'material.stretch_limit'"),
        ("damping=1,2", "did you mean 'damping_coefficient', 'damping_ratio' or 'quality_factor'"),
        ("prestretch_mode=1,2", "^--over prestretch_mode: is not numeric and cannot be swept"),
        ("film_thickness=0:1 mm:3", "must be greater than 0 m"),
        ("film_thickness=0.1:1 mm:3", "0.1 has no unit, but the others do"),
        ("voltage_amplitude=0 Hz,1 Hz", "Hz is a unit of frequency, not of voltage"),
        ("film_radius=10 mm,1 km", "'km' is not a unit of length"),
        ("frequency=1:inf:3", "must be finite"),
        ("displacement=1 mm,2 mm", "displacement"),
    ],
)
def test_with_a_device_only_its_own_words_are_understood(over, message):
    with pytest.raises(InputError, match=message):
        read_over([over], find_device("paper-table1"))


@pytest.mark.parametrize(
    ("over", "message"),
    [
        ("voltage", "must be name=from:to:count"),
        ("=1,2", "must be name=from:to:count"),
        ("voltage=", "must be name=from:to:count"),
        ("voltge=0:1:3", "did you mean 'voltage'"),
        ("law=1,2", "not a numeric model parameter"),
        ("voltage=1", "has one point"),
        ("voltage=0:1:1", "has 1 points"),
        ("voltage=2:0:5", "empty or reversed"),
        ("voltage=1:1:5", "empty or reversed"),
        ("voltage=0,2,1", "must increase"),
        ("voltage=0,1,1", "must increase"),
        ("voltage=0:1", "must be a range from:to:count"),
        ("voltage_amplitude=0,1", "is a field of a device; without a device, set 'voltage'"),
        ("film_thickness=0,1", "is a field of a device; give a device to set it"),
        ("voltage=0:1:10000000", "a range takes 2 to 100000"),
        ("voltage=0:inf:3", "must be finite"),
        ("voltage=-1,1", "must be at least 0"),
        ("voltage=0 V:1 V:3", "must be a number"),
        ("drive_frequency=0,1", "must be greater than 0"),
    ],
)
def test_over_refuses_what_is_no_sweep(over, message):
    with pytest.raises(InputError, match=message):
        read_over([over])


def test_over_refuses_a_name_given_twice_and_a_unit_of_another_kind():
    with pytest.raises(InputError, match="given twice"):
        read_over(["voltage=0,1", "voltage=0,2"])


def test_an_axis_of_a_basin_that_is_not_given_takes_its_default():
    swept = read_states(["velocity=-1,0,2"], None)
    np.testing.assert_array_equal(swept["displacement"], np.linspace(-2.0, 2.0, 81))
    np.testing.assert_array_equal(swept["velocity"], [-1.0, 0.0, 2.0])
    device = find_device("soft-film")
    in_mm = read_states(["displacement=-5 mm:5 mm:3"], device)["displacement"]
    np.testing.assert_allclose(in_mm, [-5e-3, 0.0, 5e-3], atol=1e-18)
    ends = read_states([], device)["velocity"][[0, -1]]
    np.testing.assert_allclose(ends, np.array([-2.0, 2.0]) * device.scales.velocity)


def test_a_basin_varies_two_of_the_states():
    system = ConeModel(viscous_modulus_1=0.5, relaxation_time_1=3.0).system
    assert list(read_states(["viscous_hoop_1=0.8,1.2"], None, system)) == ["displacement", "viscous_hoop_1"]
    two = read_states(["viscous_hoop_1=0.8,1.2", "viscous_meridional_1=1,2"], None, system)
    assert list(two) == ["viscous_meridional_1", "viscous_hoop_1"]
    with pytest.raises(InputError, match="vary two of them"):
        read_states([f"{name}=0,1" for name in ("displacement", "velocity", "viscous_hoop_1")], None, system)


@pytest.mark.parametrize(
    ("device", "name", "shown"),
    [
        (None, "voltage", "--over voltage=0:2:401"), ("soft-film", "frequency", '--over "frequency=5 Hz:20 Hz:31"'),
        ("soft-film", "displacement", '--over "displacement=5 mm:20 mm:31"'),
        ("soft-film", "velocity", '--over "velocity=5 m/s:20 m/s:31"'),
        ("soft-film", "voltage_amplitude", '--over "voltage_amplitude=5 V:20 V:31"'),
    ],
)  # fmt: skip
def test_an_example_has_the_unit_of_its_name(device, name, shown):
    assert example(None if device is None else find_device(device), name) == shown


@pytest.mark.parametrize(
    ("values", "why"),
    [
        ([1.0], "has one point; a sweep takes at least two values"),
        ([1.0, 1.0], "must increase; sort the values and remove duplicates"),
        ([2.0, 1.0], "must increase; sort the values and remove duplicates"),
    ],
)
def test_values_of_a_sweep_increase(values, why):
    with pytest.raises(InputError) as error:
        increasing("--over a", np.array(values))
    assert str(error.value) == f"--over a: {why}"
    assert increasing("--over a", np.array([1.0, 2.0])).tolist() == [1.0, 2.0]


def test_examples_of_axes_have_the_units_of_their_names():
    device = gelcone.find_device("biased-pump")
    for name, unit in (("frequency", "Hz"), ("displacement", "mm"), ("velocity", "m/s"), ("voltage_amplitude", "V")):
        assert example(device, name) == f'--over "{name}=5 {unit}:20 {unit}:31"'
    assert example(None, "voltage") == "--over voltage=0:2:401"
    assert read_subject().over([example(None, "voltage").removeprefix("--over ")])["voltage"].size == 401
