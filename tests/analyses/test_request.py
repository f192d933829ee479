"""What an analysis is asked about, read from text without the command line."""

import numpy as np
import pytest

from gelcone import InputError, Normal, Uniform, find_device
from gelcone.analyses import request
from gelcone.analyses.request import (
    read_measures,
    read_over,
    read_pairs,
    read_states,
    read_subject,
    read_uncertain,
    read_value,
)


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
        ("voltage=0:1:3", "'voltage' is not a device field; did you mean 'voltage_amplitude'"),
        ("drive_frequency=1,2", "did you mean 'frequency'"),
        ("stretch_limit=1,2", "did you mean 'material.stretch_limit'"),
        ("damping=1,2", "did you mean 'damping_coefficient', 'damping_ratio' or 'quality_factor'"),
        ("prestretch_mode=1,2", "prestretch_mode: is not numeric and cannot be swept"),
        ("film_thickness=0:1 mm:3", "must be greater than 0 m"),
        ("film_thickness=0.1:1 mm:3", "0.1 has no unit and others have"),
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


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1.5", 1.5),
        ("-2e-3", -0.002),
        ("inf", np.inf),
        ("1,2.5", [1.0, 2.5]),
        ("0:2:5", [0.0, 0.5, 1.0, 1.5, 2.0]),
        ("-1:1:2", [-1.0, 1.0]),
        ("50 mm", "50 mm"),
        ("radial", "radial"),
        ("PVC-DBA 4:1", "PVC-DBA 4:1"),
    ],
)
def test_values_are_numbers_lists_ranges_or_text(text, value):
    np.testing.assert_array_equal(read_value(text), value)


def test_settings_keep_what_follows_the_first_equals_sign():
    assert read_pairs(("name=a=b", " voltage = 1 ")) == {"name": "a=b", "voltage": "1"}


def test_an_axis_of_a_basin_that_is_not_given_takes_its_default():
    swept = read_states(["velocity=-1,0,2"], None)
    np.testing.assert_array_equal(swept["displacement"], np.linspace(-2.0, 2.0, 81))
    np.testing.assert_array_equal(swept["velocity"], [-1.0, 0.0, 2.0])
    device = find_device("soft-film")
    in_mm = read_states(["displacement=-5 mm:5 mm:3"], device)["displacement"]
    np.testing.assert_allclose(in_mm, [-5e-3, 0.0, 5e-3], atol=1e-18)
    ends = read_states([], device)["velocity"][[0, -1]]
    np.testing.assert_allclose(ends, np.array([-2.0, 2.0]) * device.scales.velocity)


CREEPING = ["viscous_modulus_1=0.5", "relaxation_time_1=3"]


def test_an_initial_state_names_any_state():
    def initial(text, **more):
        return read_subject(None, settings=CREEPING, initial=text, **more).beginning

    assert initial("0.5,0.1") == (0.5, 0.1)
    assert initial("0.5,0.1,0.9,1.2") == (0.5, 0.1, 0.9, 1.2)
    assert initial("viscous_hoop_1=1.2, displacement=0.5") == (0.5, 0.0, 1.0, 1.2)
    assert initial("displacement=0.5, velocity=0.1") == (0.5, 0.1)
    device = find_device("biased-pump").replace(
        film={"component": "taut", "branches": 1, "relaxation_time_1": "0.6 s"}, release_height="6 mm"
    )
    stated = read_subject(device, initial="displacement=5 mm,viscous_hoop_1=1.2")
    x = 5e-3 / device.scales.length
    np.testing.assert_allclose(stated.start, [5e-3, 0.0, 1.0 / (1.0 + x * x), 1.2])
    np.testing.assert_allclose(stated.initial, [x, 0.0, 1.0 / (1.0 + x * x), 1.2])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("charge=3", "'charge' is not a component of the initial state; known: displacement, velocity, viscous_mer"),
        ("1,0,3", "must be a displacement and a velocity, or all states"),
        ("displacement=1,displacement=2", "--initial displacement: is given twice"),
        ("displacement=1 mm", "must be a number"),
        ("1,viscous_hoop_1=2", "'1' is not a component of the initial state"),
    ],
)
def test_an_initial_state_that_cannot_be_is_refused(text, message):
    with pytest.raises(InputError, match=message):
        read_subject(None, settings=CREEPING, initial=text)


def test_a_basin_varies_two_of_the_states():
    system = read_subject(None, settings=CREEPING).model.system
    assert list(read_states(["viscous_hoop_1=0.8,1.2"], None, system)) == ["displacement", "viscous_hoop_1"]
    two = read_states(["viscous_hoop_1=0.8,1.2", "viscous_meridional_1=1,2"], None, system)
    assert list(two) == ["viscous_meridional_1", "viscous_hoop_1"]
    with pytest.raises(InputError, match="vary two of them"):
        read_states([f"{name}=0,1" for name in ("displacement", "velocity", "viscous_hoop_1")], None, system)


@pytest.mark.parametrize(
    ("text", "quantity", "unit"),
    [("20 ms", "time", 0.02), ("1 s,2 s", "time", [1.0, 2.0]), ("0 V:1 kV:3", "voltage", [0.0, 500.0, 1000.0]),
     ("0,5 mm", "length", [0.0, 0.005])],
)  # fmt: skip
def test_a_measure_of_a_device_is_scaled_to_its_model(text, quantity, unit):
    device = find_device("soft-film")
    scale = getattr(device.scales, quantity)
    np.testing.assert_allclose(read_measures("--times", text, quantity, device) * scale, unit, rtol=1e-14)
    np.testing.assert_allclose(read_measures("--times", text, quantity, device, in_si=True), unit, rtol=1e-14)
    with pytest.raises(InputError, match="units need a device"):
        read_measures("--times", text, quantity, None)


@pytest.mark.parametrize("text", ["20", "20,40", "1:2:3", "20 ms,40"])
def test_a_bare_number_is_refused_with_a_device(text):
    with pytest.raises(InputError, match="has no unit"):
        read_measures("--times", text, "time", find_device("soft-film"))


def test_a_subject_needs_no_command_line():
    device = read_subject("soft-film", settings=["voltage_amplitude=0.3 kV", "frequency=9"], initial="5 mm, 0")
    assert device.device == find_device("soft-film").replace(voltage_amplitude=300.0, frequency=9.0)
    assert device.model.parameters() == device.device.to_model().parameters()
    assert device.initial[0] * device.device.scales.length == pytest.approx(5e-3)
    assert (device.starts, device.start, device.target) == (True, (0.005, 0.0), device.device)
    assert read_subject("soft-film").beginning is None
    for setting in ("voltage=0.3", "circuit=x", "material=x"):
        with pytest.raises(InputError, match=f"{setting.partition('=')[0]}"):
            read_subject("soft-film", settings=[setting])
    preset = read_subject(preset="base", settings=["damping_ratio=0.2"])
    assert (preset.model.damping_ratio, preset.initial, preset.starts) == (0.2, (1.0, 0.0), False)
    with pytest.raises(InputError, match="are both given; give one or the other"):
        read_subject("soft-film", preset="base")


def test_an_ensemble_or_an_initial_state_is_refused_where_it_makes_no_sense():
    with pytest.raises(InputError, match="map starts from one actuator, not 2; sweep a parameter with --over"):
        read_subject(settings=["voltage=0.1,0.2"]).alone("map")
    with pytest.raises(InputError, match="--initial: a basin does not take it"):
        read_subject(initial="0.5,0").without_initial("a basin does not take it")
    read_subject().without_initial("never said")


def test_a_range_that_the_material_states_is_drawn_by_its_name():
    device = read_subject("biased-pump")
    spread = read_uncertain(["material.shear_modulus", "film_thickness=1e-4:2e-4"], device)
    low, high = device.device.material.shear_modulus_range
    assert spread["material.shear_modulus"] == Uniform(low, high)
    acrylic = read_subject("biased-pump", settings=["material=VHB 4910", "film=taut"])
    spread = read_uncertain(["material.relative_permittivity"], acrylic)
    assert spread["material.relative_permittivity"] == Uniform(3.59, 4.73)
    own = read_subject("biased-pump", settings=["material.shear_modulus=9 kPa"])
    with pytest.raises(InputError, match=r"states no range of it; give material\.shear_modulus=low:high"):
        read_uncertain(["material.shear_modulus"], own)
    for text in ("film_thickness", "material.stretch_limit", "material"):
        with pytest.raises(InputError, match="must be name=low:high or name=mean~deviation"):
            read_uncertain([text], device)


def test_uncertain_parameters_are_read():
    alone, device = read_subject(settings=["damping_ratio=0.1"]), read_subject("soft-film")
    spread = read_uncertain(["prestretch=1~0.02", "voltage=0.1:0.3"], alone)
    assert spread == {"prestretch": Normal(1.0, 0.02), "voltage": Uniform(0.1, 0.3)}
    for text in ("prestretch=1", "=1~0.1", "prestretch=a~b"):
        with pytest.raises(InputError, match=r"must be (name=|a number)"):
            read_uncertain([text], alone)
    spread = read_uncertain(["film_thickness=0.2 mm~10 um", "frequency=8:10"], device)
    assert spread == {"film_thickness": Normal(2e-4, 1e-5), "frequency": Uniform(8.0, 10.0)}
    for text, message in {
        "voltage=1~0.1": "did you mean 'voltage_amplitude'",
        "frequency=8:9 Hz": "8 has no unit and others have",
    }.items():
        with pytest.raises(InputError, match=message):
            read_uncertain([text], device)
    with pytest.raises(InputError, match="--set damping_ratio: is drawn by --uncertain"):
        read_uncertain(["damping_ratio=0.1:0.2"], alone)


# --- both sides of every bound ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0:1:1", "--a '0:1:1': has 1 points; a range takes 2 to 100000"),
        ("0:1:100001", "--a '0:1:100001': has 100001 points; a range takes 2 to 100000"),
        ("0:1:x", "--a '0:1:x': must be a range from:to:count, for example 0:2:401"),
        ("0:inf:3", "--a '0:inf:3': the ends of a range must be finite"),
        ("nan:1:3", "--a 'nan:1:3': the ends of a range must be finite"),
        ("1:1:3", "--a '1:1:3': is empty or reversed; the first end must be below the second"),
        ("1:2", "--a '1:2': must be a range from:to:count, the last being the number of values: 1:2:21"),
        ("1,,2", "--a '1,,2': has an empty value; must be a number, a list v1,v2,... or a range from:to:count"),
        (",".join(["1"] * 100_001), "--a: has 100001 values; a list takes at most 100000"),
        ("1 mm,2", "--a '1 mm,2': 2 has no unit and others have; give each its unit, and write decimals with a point"),
    ],
)
def test_numbers_that_cannot_be_are_refused_in_full_words(text, message):
    with pytest.raises(InputError) as error:
        request.read_numbers("--a", text, lambda option, part: float(part.removesuffix(" mm")))
    assert str(error.value) == message


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("0:1:2", [0.0, 1.0]), ("0:1:100000", 100_000), (",".join(["1"] * 100_000), 100_000), ("0, 2 mm", [0.0, 2.0]),
        ("[1, 2]", [1.0, 2.0]), ("3", 3.0), ("[3]", 3.0), (" 0 : 1 mm : 2 ", [0.0, 1.0]),
    ],
)  # fmt: skip
def test_numbers_at_the_bound_are_read(text, values):
    found = request.read_numbers("--a", text, lambda option, part: float(part.removesuffix(" mm")))
    assert found.size == values if isinstance(values, int) else np.array_equal(found, values)


@pytest.mark.parametrize(
    ("text", "doubtful"),
    [
        ("0,5", True), ("-0,5", True), ("+1,2", True), ("[0,5]", False), ("0,5,1", False), ("0.5,1", False),
        ("1,-2", False), ("1,x", False),
    ],
)  # fmt: skip
def test_what_may_be_a_decimal_comma_is_asked_for(text, doubtful):
    parts = request._parts(text)
    if not doubtful:
        request._no_decimal_comma("--set a", text, parts)
        return
    one, two = ".".join(parts), ", ".join(parts)
    with pytest.raises(InputError) as error:
        request._no_decimal_comma("--set a", text, parts)
    assert (
        str(error.value) == f"--set a={text}: may be one number or two; write {one} with a point, or the list [{two}]"
    )


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
    assert request.example(None if device is None else find_device(device), name) == shown


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
        request.increasing("--over a", np.array(values))
    assert str(error.value) == f"--over a: {why}"
    assert request.increasing("--over a", np.array([1.0, 2.0])).tolist() == [1.0, 2.0]


def test_a_drawn_column_is_in_the_unit_of_its_header():
    device, numbers = read_subject("soft-film", settings=["frequency=9"]), np.array([1.0, 2.0])
    np.testing.assert_allclose(request.read_drawn("d.csv: a", "film_thickness", numbers, "mm", device), [1e-3, 2e-3])
    assert request.read_drawn("d.csv: a", "prestretch", numbers, "1", device) is numbers
    assert request.read_drawn("d.csv: a", "voltage", numbers, "", read_subject()) is numbers
    for subject, name, unit, message in (
        (device, "frequency", "Hz", "--set frequency: is drawn by --uncertain d.csv; leave one of them out"),
        (device, "film_thickness", "",
         "d.csv: film_thickness: has no unit; write it into the header, as in film_thickness [um]"),
        (read_subject(), "voltage", "V",
         "d.csv: voltage [V]: a model without a device is dimensionless; leave the unit out"),
    ):  # fmt: skip
        with pytest.raises(InputError) as error:
            request.read_drawn(f"d.csv: {name}", name, numbers, unit, subject)
        assert str(error.value) == message
