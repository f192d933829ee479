"""Devices: SI in, model out, and back; files; and what is refused, in which words."""

import dataclasses
import json
import math
import pickle
import re
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gelcone.devices.device import Device, find_device
from gelcone.devices.fields import DEVICE_FIELDS, DRIVE_NUMBERS, SWEPT_FIELDS
from gelcone.devices.files import shipped_devices
from gelcone.devices.materials import Material
from gelcone.devices.scales import VACUUM_PERMITTIVITY
from gelcone.devices.template import field_table, first_file
from gelcone.errors import DoubtfulInput, InputError

BASE = {
    "disc_radius": "10 mm",
    "film_radius": "50 mm",
    "film_thickness": "0.5 mm",
    "spring_rate": 60.0,
    "moving_mass": "20 g",
    "damping_coefficient": "0.04 N s/m",
    "material": "PVC-DBA 4:1",
    "voltage_amplitude": "8 kV",
    "frequency": 7.5,
}
TOML = """
disc_radius = "10 mm"
film_radius = 0.05
film_thickness = "0.5 mm"   # film_raduis = 3
spring_rate = 60
moving_mass = "20 g"
damping_coefficient = 0.04
voltage_amplitude = ["8 kV", 9e3]
frequency = 7.5

[material]
shear_modulus = "20 kPa"
relative_permittivity = 5
law = "neo-hookean"
"""


@pytest.fixture
def device():
    return Device(**BASE)


# --- numbers ----------------------------------------------------------------------------------------------------------


def test_model_parameters_are_those_of_the_scaling_table(device):
    device = device.replace(initial_height="8 mm", voltage_offset=-500.0, hoop_prestretch=1.2)
    model, gel = device.to_model(), device.material
    a, b, H, m, k, c = 0.01, 0.05, 0.0005, 0.02, 60.0, 0.04
    energy = gel.shear_modulus * math.pi * (b**2 - a**2) * H
    omega0 = math.sqrt(energy / (m * (b - a) ** 2))
    volt = math.sqrt(gel.relative_permittivity * 8.8541878188e-12 / gel.shear_modulus) / H
    assert model.damping_ratio == pytest.approx(c / (2 * m * omega0), rel=1e-14)
    assert model.spring_stiffness == pytest.approx(k * (b - a) ** 2 / energy, rel=1e-14)
    assert model.voltage == pytest.approx(8000 * volt, rel=1e-14)
    assert model.voltage_bias == pytest.approx(-500 * volt, rel=1e-14)
    assert model.drive_frequency == pytest.approx(2 * math.pi * 7.5 / omega0, rel=1e-14)
    assert model.rest_height == pytest.approx(0.2, rel=1e-14)
    assert model.stretches == (1.0, 1.2)
    assert model.stretch_limit == 50.0


@pytest.mark.filterwarnings("ignore::gelcone.errors.DoubtfulInput")
@settings(max_examples=50, deadline=None)
@given(
    st.floats(1e-3, 0.1), st.floats(1e-3, 0.5), st.floats(1e-5, 1e-2), st.floats(1e-4, 1.0), st.floats(1e2, 1e6),
    st.floats(0.0, 1e4), st.floats(0.0, 10.0), st.floats(1.0, 20.0), st.floats(0.0, 1e4), st.floats(0.1, 1e3),
)  # fmt: skip
def test_si_to_model_and_back(a, width, H, m, mu, k, c, eps, volts, hertz):
    device = Device(
        disc_radius=a,
        film_radius=a + width,
        film_thickness=H,
        spring_rate=k,
        moving_mass=m,
        damping_coefficient=c,
        material=Material(shear_modulus=mu, relative_permittivity=eps),
        voltage_amplitude=volts,
        frequency=hertz,
    )
    model, s = device.to_model(), device.scales
    assert model.voltage * s.voltage == pytest.approx(volts, rel=1e-12)
    assert model.drive_frequency * s.frequency == pytest.approx(hertz, rel=1e-12)
    assert model.spring_stiffness * s.force / s.length == pytest.approx(k, rel=1e-12)
    assert model.damping_ratio * 2 * s.force / s.velocity == pytest.approx(c, rel=1e-12)
    assert s.force * s.length == pytest.approx(s.energy, rel=1e-12)
    assert s.force * s.velocity == pytest.approx(s.power, rel=1e-12)
    assert m * s.velocity**2 == pytest.approx(s.energy, rel=1e-12)
    assert s.field * H == pytest.approx(s.voltage, rel=1e-12)
    assert VACUUM_PERMITTIVITY * eps * s.field**2 == pytest.approx(s.stress, rel=1e-12)


ELECTRIC = {
    "series_resistance": "2 Mohm",
    "damping_coefficient": 0.01,
    "release_height": "4 mm",
    "release_velocity": 0.1,
}
DOUBLE = ELECTRIC | {
    "film": "taut", "second_film": "taut", "second_drive": "constant", "second_voltage": "500 V",
    "second_prestretch": 1.2, "spring_rate": 10.0, "initial_height": "5 mm", "beam_rate": 30.0, "beam_cubic_rate": 1e5,
    "beam_height": "3 mm", "constant_force": "10 mN", "gravity": 9.81,
    "material.resistivity": "1 Gohm m", "material.resistivity_field": "9 V/um",
}  # fmt: skip
LOSSY = ELECTRIC | {
    "film": "taut", "slew_rate": "1 V/us", "current_limit": "1 mA", "filter_frequency": "2 kHz",
    "material.dielectric_share": 0.2, "material.dielectric_time": "20 ms", "material.viscous_modulus_1": "2 kPa",
    "material.relaxation_time_1": "0.3 s", "material.viscous_stretch_limit_1": 20.0,
}  # fmt: skip
VOLT, TIME = (0, -2, 0, -1, 1), (0, 1, -1, 1, 0)
SIZES = {
    "damping_ratio": ("damping_coefficient", (0, -1, -1, -1, 0)),
    "spring_stiffness": ("spring_rate", (0, -2, 0, -2, 0)),
    "beam_stiffness": ("beam_rate", (0, -2, 0, -2, 0)),
    "beam_cubic": ("beam_cubic_rate", (4, -2, 0, -2, 0)),
    "push": ("constant_force", (-2, -2, 0, -2, 0)),
    "weight": ("gravity", (-2, -2, 2, -2, 0)),
    "rest_height": ("initial_height", (-2, 0, 0, 0, 0)),
    "beam_height": ("beam_height", (-2, 0, 0, 0, 0)),
    "second_flat_height": ("second_flat_height", (-2, 0, 0, 0, 0)),
    "x": ("release_height", (-2, 0, 0, 0, 0)),
    "u": ("release_velocity", (-2, -1, 1, -1, 0)),
    "voltage": ("voltage_amplitude", VOLT),
    "voltage_bias": ("voltage_offset", VOLT),
    "second_voltage": ("second_voltage", VOLT),
    "drive_frequency": ("frequency", (0, -1, 1, -1, 0)),
    "relaxation_time_1": ("material.relaxation_time_1", TIME),
    "dielectric_time": ("material.dielectric_time", TIME),
    "filter_time": ("1/filter_frequency", TIME),
    "leakage_time": ("material.resistivity", (0, 1, -1, 1, 2)),
    "leakage_field": ("material.resistivity_field", (0, 0, 0, -1, 1)),
    "dielectric_strength": ("dielectric_strength", (0, 0, 0, -1, 1)),
    "slew_rate": ("slew_rate", (0, -3, 1, -2, 1)),
    "series_resistance": ("series_resistance", (4, -1, -1, 1, 2)),
    "current_limit": ("current_limit", (-4, -1, 1, -2, -1)),
    "viscous_modulus_1": ("material.viscous_modulus_1", (0, 0, 0, -2, 0)),
    "viscous_limit_1": ("material.viscous_stretch_limit_1", (0, 0, 0, 0, 0)),
    "dielectric_share": ("material.dielectric_share", (0, 0, 0, 0, 0)),
    "stretch_limit": ("material.stretch_limit", (0, 0, 0, 0, 0)),
    "second_stretch_limit": ("material.stretch_limit", (0, 0, 0, 0, 0)),
    "meridional_prestretch": ("meridional_prestretch", (0, 0, 0, 0, 0)),
    "hoop_prestretch": ("hoop_prestretch", (0, 0, 0, 0, 0)),
    "second_prestretch": ("second_prestretch", (0, 0, 0, 0, 0)),
}


@pytest.mark.filterwarnings("ignore::gelcone.errors.DoubtfulInput")
@pytest.mark.parametrize(("name", "changes"), [("double-cone", DOUBLE), ("biased-pump", LOSSY)])
def test_each_field_changes_exactly_the_numbers_that_hold_it(name, changes):
    """`SIZES`: the field in each number of the model, and twice the power at which it holds both radii, the thickness,
    the mass, the modulus and the permittivity: by hand from energy, mass and field."""

    def numbers(device):
        values = {n: float(v) for n, v in device.to_model().values.items() if np.isfinite(v) and v}
        return values | dict(zip("xu", device.initial_state(), strict=True))

    device = find_device(name).replace(changes)
    before, radii = numbers(device), ("disc_radius", "film_radius")
    assert set(before) - {"radius_ratio", "second_radius_ratio"} <= set(SIZES)
    shared = (
        radii,
        ("film_thickness",),
        ("moving_mass",),
        ("material.shear_modulus",),
        ("material.relative_permittivity",),
    )
    held = [name for name, (field, _) in SIZES.items() if device.get(field.removeprefix("1/"))]
    held = [name for name in held if name != "second_stretch_limit" or device.second_film]
    for k, fields in enumerate(shared):
        after = numbers(device.replace({field: 1.0201 * device.get(field) for field in fields}))
        for number in held:
            power = SIZES[number][1][k] / 2.0
            assert after[number] == pytest.approx(before[number] * 1.0201**power, rel=1e-12), (fields, number)
    for field in {SIZES[number][0] for number in held}:
        own, inverse = field.removeprefix("1/"), field.startswith("1/")
        after = numbers(device.replace({own: 1.01 * device.get(own)}))
        for number in held:
            factor = 1.0 if SIZES[number][0] != field else 1.0 / 1.01 if inverse else 1.01
            assert after[number] == pytest.approx(before[number] * factor, rel=1e-12), (field, number)


def test_strings_and_numbers_agree(device):
    assert Device(**device.parameters()) == device
    assert device.film_radius == 0.05


def test_drive_arrays_make_an_ensemble(device):
    volts = np.linspace(1e3, 8e3, 5)
    ensemble = device.replace(voltage_amplitude=volts, frequency=[5, 6, 7, 8, "9 Hz"])
    model = ensemble.to_model()
    assert model.shape == (5,)
    np.testing.assert_allclose(model.voltage * ensemble.scales.voltage, volts, rtol=1e-14)
    np.testing.assert_allclose(model.drive_frequency * ensemble.scales.frequency, [5, 6, 7, 8, 9], rtol=1e-14)
    volts[0] = 0.0
    assert ensemble.voltage_amplitude[0] == 1e3, "the device keeps its own copy"
    assert ensemble.initial_state() == (0.0, 0.0)
    assert Device(**json.loads(json.dumps(ensemble.parameters()))) == ensemble
    assert ensemble != device


def test_breakdown_field(device):
    assert device.breakdown_field() is None
    strong = device.replace({"material.dielectric_strength": "30 kV/mm"})
    assert strong.breakdown_field() * strong.scales.field == pytest.approx(3e7)
    weaker = strong.replace(dielectric_strength="20 V/um")
    assert weaker.breakdown_field() * weaker.scales.field == pytest.approx(2e7)


# --- the initial state ------------------------------------------------------------------------------------------------


def test_release(device):
    x, u = device.replace(release_height="40 mm", release_velocity="100 mm/s").initial_state()
    assert x == pytest.approx(1.0, rel=1e-15)
    assert u * device.scales.velocity == pytest.approx(0.1, rel=1e-15)


def test_a_spring_free_at_zero_leaves_the_disc_flat(device):
    assert device.initial_state() == (0.0, 0.0)
    assert device.replace(spring_rate=0.0).initial_state() == (0.0, 0.0)


LAWS = ("gent", "neo-hookean", "yeoh")
STRETCHES = ({}, {"hoop_prestretch": 1.4}, {"prestretch": 1.3, "prestretch_mode": "equibiaxial"})
MADE = ({}, {"meridional_prestretch": 1.4}, STRETCHES[2])
"""Membranes that are quickly made."""
RESTS = [
    *((high, "wrinkling", stretches, law) for high in ("20 mm", "400 mm") for stretches in STRETCHES for law in LAWS),
    *((high, "membrane", *pair) for high in ("20 mm", "-20 mm") for pair in zip(MADE, LAWS, strict=True)),
]


@pytest.mark.parametrize(("height", "film", "stretches", "law"), RESTS, ids=str)
def test_rest_is_a_stable_equilibrium_short_of_the_initial_height(device, height, film, stretches, law):
    raised = device.replace({"initial_height": height, "material.law": law, "film": film, **stretches})
    model = raised.to_model()
    x, _ = raised.initial_state()
    assert 0.0 < x / model.rest_height < 1.0
    assert model.stiffness(x) > 0.0
    assert abs(model.force(x)) < 1e-13 * model.spring_stiffness * abs(model.rest_height)


def test_a_compressed_film_rests_buckled_on_the_side_of_the_initial_height(device):
    slack = device.replace(prestretch=0.5, prestretch_mode="equibiaxial", spring_rate=1.0, film="taut")
    assert slack.to_model().stiffness(0.0) < 0.0
    for height in (0.0, 1e-3, -1e-3):
        raised = slack.replace(initial_height=height)
        x, _ = raised.initial_state()
        assert x < 0.0 if height < 0.0 else x > 0.0
        assert raised.to_model().force(x) == pytest.approx(0.0, abs=1e-12)
        assert raised.to_model().stiffness(x) > 0.0


def test_the_limit_height_named_in_the_message_is_the_stretch_limit(device):
    with pytest.raises(InputError, match=r"release_height = 1 m: must be less than 285\.6 mm, where the film reaches"):
        device.replace(release_height=1.0)
    device.replace(release_height=0.2855)
    model = device.replace(film="wrinkling").to_model()
    assert model.strain(0.2855 / 0.04) < 50.0 < model.strain(0.2857 / 0.04)


# --- variants ---------------------------------------------------------------------------------------------------------


def test_replace(device):
    softer = device.replace({"material.shear_modulus": "10 kPa"}, film_radius="60 mm")
    assert (softer.material.shear_modulus, softer.film_radius) == (1e4, 0.06)
    assert softer.material.name == "PVC-DBA 4:1, changed"
    assert device.film_radius == 0.05
    assert softer.replace(material="PVC-DBA 4:1", film_radius=0.05) == device
    direct = device.replace(prestretch=1.2).replace(hoop_prestretch=1.3)
    assert (direct.prestretch, direct.to_model().stretches) == (None, (1.0, 1.3))
    assert direct.replace(prestretch=1.1).to_model().stretches == (1.0, 1.1)
    assert device.replace(release_height=0.01).replace(release_height=None) == device


def test_a_waveform_begins_with_its_own_numbers_and_keeps_them_while_it_stays(device):
    brief = device.replace({"waveform": "square", "waveform.duty": 0.3})
    assert brief.replace(frequency=8.0).to_model().values["duty"] == 0.3
    assert brief.replace(waveform="square") == device.replace(waveform="square")
    assert brief.replace(waveform="square").to_model().values["duty"] == 0.5
    for other in ("sine", "trapezoid", None):
        assert brief.replace(waveform=other) == device.replace(waveform=other)


def test_a_device_survives_pickling(device):
    assert pickle.loads(pickle.dumps(device)) == device
    with pytest.raises(InputError) as caught:
        device.replace(film_radius=0)
    # Without the call stack, which a library that pickles tracebacks (dask.distributed does) would follow to its end.
    error = caught.value.with_traceback(None)
    error.__cause__ = error.__context__ = None
    copy = pickle.loads(pickle.dumps(error))
    assert (str(copy), copy.field) == (str(caught.value), "film_radius")


# --- what is refused --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"voltage_amplitude": "1,2 kV"}, "voltage_amplitude = '1,2 kV': holds a comma; write decimals with a point"),
        (
            {"film_radius": "50 MM"},
            "film_radius = '50 MM': 'MM' is not a unit of length; give a number in m or a strin",
        ),
        ({"film_radius": math.nan}, "film_radius = nan: must be finite"),
        ({"frequency": math.inf}, "frequency = inf: must be finite"),
        ({"film_radius": None}, "film_radius: is missing; give the radius at which the film is clamped in m"),
        ({"film_radius": 0}, "film_radius = 0: must be greater than 0 m"),
        ({"film_thickness": "-1 mm"}, "film_thickness = '-1 mm': must be greater than 0 m"),
        ({"film_thickness": 0.0}, "film_thickness = 0.0: must be greater than 0 m"),
        ({"moving_mass": 0.0}, "moving_mass = 0.0: must be greater than 0 kg"),
        ({"damping_coefficient": -1}, "damping_coefficient = -1: must be at least 0 N s/m"),
        (
            {"disc_radius": "60 mm"},
            "disc_radius = 60 mm: must be less than film_radius = 50 mm; make the disc smaller or the film larger",
        ),
        ({"film_raduis": 1}, "'film_raduis' is not a device field; did you mean 'film_radius'?"),
        ({"voltage": 1}, "'voltage' is not a device field; did you mean 'voltage_amplitude'?"),
        (
            {"stretch_limit": 1},
            "'stretch_limit' is not a device field; did you mean 'material.stretch_limit'?",
        ),
        ({"material": "PVC-DBA 4:2"}, "material: 'PVC-DBA 4:2' is not a material; did you mean 'PVC-DBA 4:1'?"),
        ({"material": 5}, "material = 5: must be the name of a library material or a table of its numbers"),
        (
            {"material": {"shear_modulus": 1}},
            "material.relative_permittivity: is missing; give the relative permittivi",
        ),
        ({"material.shear_modulus": "3 V"}, "material.shear_modulus = '3 V': V is a unit of voltage, not of pressure"),
        ({"material.shear_modulis": 3}, "'shear_modulis' is not a material field; did you mean 'shear_modulus'?"),
        (
            {"materal.shear_modulus": 3},
            "'materal.shear_modulus' is not a device field; did you mean 'material.shear_mo",
        ),
        ({"voltage_amplitude": [1, -2]}, "voltage_amplitude[1] = -2: must be at least 0 V"),
        ({"voltage_amplitude": []}, "voltage_amplitude = []: is empty; give at least one value"),
        (
            {"voltage_amplitude": [1, 2, 3], "frequency": [1, 2]},
            "voltage_amplitude has 3, frequency has 2 values; give lists of one length",
        ),
        ({"prestretch": 1.2, "hoop_prestretch": 1.3}, "prestretch and meridional_prestretch/hoop_prestretch are both"),
        ({"prestretch_mode": "radail"}, "prestretch_mode: 'radail' is not a pre-stretch mode; did you mean 'radial'?"),
        (
            {"prestretch": 8},
            "prestretch: mounted flat, the film has I1 - 3 = 62.02, which must be less than its stretch",
        ),
        ({"prestretch": 1e-200}, "prestretch: mounted flat, the film has I1 - 3 = inf"),
        (
            {"film_thickness": "1e-300 nm"},
            "film_thickness = 1e-300 nm: gives no finite time and energy; usual is 0.02 to 2 mm",
        ),
        ({"moving_mass": 1e-320}, "gives no finite time and energy; usual is 0.1 to 500 g"),
        ({"name": ""}, "name = '': must be a non-empty text in quotes"),
    ],
)
def test_bad_input_is_one_line(changes, message):
    with pytest.raises(InputError) as caught:
        Device(**BASE | changes)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("thickness", "'film_thickness'"),
        ("mass", "'moving_mass'"),
        ("damping", "'damping_coefficient', 'damping_ratio' or 'quality_factor'"),
        ("voltage", "'voltage_amplitude'"),
        ("spring_stiffness", "'spring_rate'"),
        ("drive_frequency", "'frequency'"),
        ("Radius", "'disc_radius' or 'film_radius'"),
        ("modulus", "'material.shear_modulus' or 'material.young_modulus'"),
        ("breakdown", "'dielectric_strength' or 'material.dielectric_strength'"),
    ],
)
def test_names_that_people_use_name_the_right_one(typed, meant):
    with pytest.raises(InputError) as caught:
        Device(**BASE, **{typed: 1})
    assert str(caught.value) == f"{typed!r} is not a device field; did you mean {meant}?"


def test_every_wrong_field_has_a_line_of_its_own():
    """A missing field that a near-miss name stands for is not told twice."""
    values = {name: value for name, value in BASE.items() if name not in ("film_thickness", "moving_mass")}
    with pytest.raises(InputError) as caught:
        Device(**values | {"thickness": "0.5 mm", "frequency": "7 mm", "damping_coefficient": None})
    lines = str(caught.value).splitlines()
    assert [line.split(" ")[0].strip(":'") for line in lines] == ["thickness", "moving_mass", "frequency"]
    assert pickle.loads(pickle.dumps(caught.value.with_traceback(None))).errors[1].field == "moving_mass"


# --- files ------------------------------------------------------------------------------------------------------------


def test_from_toml(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(TOML, encoding="utf-8")
    device = Device.from_toml(path)
    assert (device.name, device.film_radius, device.material.law) == ("mine", 0.05, "neo-hookean")
    np.testing.assert_array_equal(device.voltage_amplitude, [8e3, 9e3])
    assert find_device(path) == find_device(str(path)) == device


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TOML + "x = = 3", "mine.toml: broken TOML: Invalid value (at line 15, column 5)"),
        (TOML.replace("film_radius", "film_raduis"), "mine.toml, line 3: 'film_raduis' is not a device field; did you"),
        (TOML.replace("0.05", "'50 MM'"), "mine.toml, line 3: film_radius = '50 MM': 'MM' is not a unit of length"),
        (TOML.replace("0.05", "1979-05-27"), "mine.toml, line 3: film_radius = datetime.date(1979, 5, 27): must be a"),
        (TOML.replace('"8 kV"', '"8 mm"'), "mine.toml, line 8: voltage_amplitude[0] = '8 mm': mm is a unit of length"),
        (TOML.replace("20 kPa", "20 kV"), "mine.toml, line 12: material.shear_modulus = '20 kV': kV is a unit of volt"),
        (TOML.replace("frequency = 7.5", ""), "mine.toml: frequency: is missing; give the frequency of the drive in H"),
        (TOML.replace("[material]", "[materiel]"), "mine.toml, line 11: 'materiel' is not a device field; did you mea"),
    ],
)
def test_bad_files_are_told_with_the_line(tmp_path, text, message):
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        Device.from_toml(path)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(
        InputError,
        match=r"none\.toml: there is no such file; give a TOML file or a name; devices that ship: .*paper-table1",
    ):
        find_device(tmp_path / "none.toml")
    with pytest.raises(InputError, match=r"is a folder; give a TOML file or a name; devices that ship"):
        find_device(tmp_path)
    with pytest.raises(
        InputError,
        match=r"paper-tabel1: there is no such file; did you mean 'paper-table1', which ships\?",
    ):
        find_device("paper-tabel1")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match=r"bytes\.toml: is not UTF-8 text \(byte 0\); save it as UTF-8"):
        find_device(tmp_path / "bytes.toml")
    with pytest.raises(InputError, match="cannot be read"):
        find_device("a\0b")


# --- the devices that ship --------------------------------------------------------------------------------------------


SHIPPED = ["paper-table1", "soft-film", "biased-pump", "weight-cone", "beam-cone", "double-cone", "snap-cone"]


def test_seven_devices_ship():
    assert set(shipped_devices()) == set(SHIPPED)


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_devices_say_where_each_number_comes_from(name):
    device = find_device(name)
    assert Device(**device.parameters()) == device
    assert 0.01 <= device.to_model().damping_ratio <= 0.05
    for line in shipped_devices()[name].read_text(encoding="utf-8").splitlines():
        if "=" in line and not line.startswith(("#", "name", "prestretch_mode")):
            assert "# " in line, line


def test_a_file_of_a_shipped_devices_name_wins_over_it(tmp_path, monkeypatch):
    name = next(iter(shipped_devices()))
    shipped = find_device(name)
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_text(TOML)
    own = find_device(name)
    assert own.frequency == 7.5
    assert own.spring_rate == 60.0
    (tmp_path / name).unlink()
    assert find_device(name) == shipped
    (tmp_path / name).mkdir()  # a folder is no file
    assert find_device(name) == shipped


def test_table1_device():
    device = find_device("paper-table1")
    model = device.to_model()
    assert (device.disc_radius, device.film_radius, device.film_thickness) == (0.01, 0.05, 0.0005)
    assert device.material.name == "PVC-DBA 4:1"
    assert model.spring_stiffness == pytest.approx(1.5, rel=1e-9)
    assert (model.rest_height, model.stretch_limit, model.stretches) == (0.0, 50.0, (1.0, 1.0))
    assert model.voltage == pytest.approx(0.9, abs=0.01)
    assert device.initial_state() == pytest.approx((1.0, 0.0), rel=1e-15)


def test_the_biased_pump_rests_out_of_plane():
    device = find_device("biased-pump")
    x, _ = device.initial_state()
    assert x * device.scales.length == pytest.approx(0.0132, abs=1e-4)
    assert device.to_model().voltage_bias > 0.0


def test_a_file_wins_over_a_shipped_device_of_that_name(tmp_path, monkeypatch):
    """Whoever writes a file of that name into the folder means it."""
    monkeypatch.chdir(tmp_path)
    shipped = find_device("soft-film")
    text = shipped_devices()["soft-film"].read_text(encoding="utf-8")
    (tmp_path / "soft-film").write_text(text.replace(shipped.name, "my own film"), encoding="utf-8")
    assert find_device("soft-film").name == "my own film"
    (tmp_path / "soft-film").unlink()
    (tmp_path / "soft-film").mkdir()  # a folder is no device
    assert find_device("soft-film").name == shipped.name


@pytest.mark.parametrize("prestretch", [{}, {"prestretch": 1.4, "prestretch_mode": "equibiaxial"}])
def test_a_release_is_refused_where_the_film_reaches_its_stretch_limit(prestretch):
    """The largest height by the strain itself, without the formula for its root."""
    from scipy.optimize import brentq

    material = {"shear_modulus": "20 kPa", "relative_permittivity": 5, "stretch_limit": 4.0}
    device = Device(**BASE | {"material": material} | prestretch)
    model = device.replace(film="taut").to_model()
    highest = brentq(lambda x: float(model.strain(x)) - 4.0, 0.1, 20.0) * device.scales.length
    device.replace(release_height=0.999 * highest)
    for side in (1.0, -1.0):
        with pytest.raises(InputError, match="where the film reaches its stretch limit 4; start lower"):
            device.replace(release_height=side * 1.001 * highest)


def test_scales_follow_from_energy_mass_and_field():
    """Energy mu Vol; rate sqrt(energy/mass)/length; voltage H sqrt(mu/eps)."""
    device = Device(**BASE)
    scales, mu = device.scales, device.material.shear_modulus
    volume = math.pi * (0.05**2 - 0.01**2) * 0.5e-3
    rate = math.sqrt(mu * volume / 0.02) / 0.04
    field = math.sqrt(mu / (device.material.relative_permittivity * VACUUM_PERMITTIVITY))
    expected = {
        **{"length": 0.04, "time": 1.0 / rate, "velocity": 0.04 * rate, "energy": mu * volume},
        **{"force": mu * volume / 0.04, "power": mu * volume * rate, "voltage": 0.5e-3 * field, "field": field},
        **{"current": mu * volume * rate / (0.5e-3 * field), "stress": mu, "frequency": rate / (2.0 * math.pi)},
        "heat_capacity": 1.8e6,
    }
    assert dataclasses.asdict(scales) == pytest.approx(expected, rel=1e-12)


# --- damping ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["paper-table1", "soft-film", "biased-pump"])
def test_three_forms_of_damping_are_one(name):
    """c = 2 zeta m omega and Q = 1/(2 zeta), with omega from the stiffness about the rest, a difference of forces."""
    device = find_device(name)
    if name == "paper-table1":
        device = device.replace(release_height=None)
    model, scales = device.to_model(), device.scales
    rest, step = device.replace(release_height=None).initial_state()[0], 1e-5
    slope = (model.force(rest + step) - model.force(rest - step)) / (2.0 * step) * scales.force / scales.length
    ratio = device.damping_coefficient / (2.0 * math.sqrt(device.moving_mass * slope))
    for form in ({"damping_ratio": ratio}, {"quality_factor": 0.5 / ratio}):
        other = device.replace(form)
        assert other.damping_coefficient is None
        assert other.to_model().damping_ratio == pytest.approx(model.damping_ratio, rel=1e-7)
        assert other.replace(damping_coefficient=device.damping_coefficient) == device


def test_damping_is_given_once_and_needs_a_free_vibration(device):
    with pytest.raises(
        InputError, match=r"damping_coefficient: is missing; give .* or damping_ratio or quality_factor"
    ):
        device.replace(damping_coefficient=None)
    with pytest.raises(InputError, match="damping_coefficient and damping_ratio are both given"):
        Device(**BASE, damping_ratio=0.1)
    with pytest.raises(InputError, match=r"damping_ratio: refers to the free vibration .* give damping_coefficient"):
        device.replace(damping_ratio=0.1, spring_rate=0.0)


# --- loads, beam and second film --------------------------------------------------------------------------------------


def newtons(device, height, volts=0.0):
    """Static force at a height in m."""
    s = device.scales
    return float(device.to_model().force(height / s.length, volts / s.voltage)) * s.force


def test_loads_and_beam_add_their_newtons(device):
    alone = newtons(device, 0.006)
    assert newtons(device.replace(gravity=9.81), 0.006) - alone == pytest.approx(device.moving_mass * 9.81, rel=1e-9)
    carrying = device.replace(gravity="9.81 m/s^2", payload="5 g")
    weight = (device.moving_mass + 0.005) * 9.81
    assert newtons(carrying, 0.006) - alone == pytest.approx(weight, rel=1e-9)
    assert newtons(device.replace(constant_force="3 mN"), 0.006) - alone == pytest.approx(-0.003, rel=1e-9)
    beam = {"beam_rate": "-20 N/m", "beam_cubic_rate": "60 kN/m^3", "beam_height": "2 mm"}
    expected = -20.0 * 0.004 + 6e4 * 0.004**3
    assert newtons(device.replace(**beam), 0.006) - alone == pytest.approx(expected, rel=1e-9)
    together = device.replace(gravity=9.81, constant_force=0.003, **beam)
    expected += device.moving_mass * 9.81 - 0.003
    assert newtons(together, 0.006) - alone == pytest.approx(expected, rel=1e-9)


def test_a_payload_slows_the_disc_down_also_where_it_does_not_weigh(device):
    heavy = device.replace(payload=3.0 * device.moving_mass)
    assert heavy.scales.time == pytest.approx(2.0 * device.scales.time, rel=1e-14)
    assert heavy.to_model().system == device.to_model().system
    ratio = device.damping_coefficient / (2.0 * 4.0 * device.moving_mass) * heavy.scales.time
    assert heavy.to_model().damping_ratio == pytest.approx(ratio, rel=1e-14)


def test_a_spring_lowered_by_a_weight_rests_m_g_over_k_lower(device):
    stiff = device.replace(spring_rate="20 kN/m", initial_height="5 mm", gravity="9.81 m/s^2", prestretch=1.0)
    free, down = stiff.replace(gravity=None), stiff
    drop = (free.initial_state()[0] - down.initial_state()[0]) * stiff.scales.length
    assert drop == pytest.approx(device.moving_mass * 9.81 / 2e4, rel=1e-2)


def test_the_second_film_pulls_like_the_first_from_its_own_plane(device):
    device = device.replace(film="taut")
    both = device.replace(second_film="taut", second_flat_height="16 mm", spring_rate=0.0)
    one = device.replace(spring_rate=0.0)
    assert newtons(both, 0.006, 300.0) == pytest.approx(newtons(one, 0.006, 300.0) - newtons(one, 0.010, 300.0))
    held = both.replace(second_drive="constant", second_voltage="400 V", second_hoop_prestretch=1.4)
    other = one.replace(hoop_prestretch=1.4)
    assert newtons(held, 0.006, 300.0) == pytest.approx(newtons(one, 0.006, 300.0) - newtons(other, 0.010, 400.0))
    x, velocity = both.replace(voltage_offset="300 V", second_drive="opposite").initial_state()
    assert (x * both.scales.length, velocity) == (pytest.approx(0.008, rel=1e-12), 0.0)
    assert Device(**json.loads(json.dumps(held.parameters()))) == held


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"beam_height": "2 mm"}, "beam_height: there is no beam_rate; give beam_rate, or leave beam_height out"),
        (
            {"second_drive": "same"},
            "second_drive: there is no second_film; give second_film, or leave second_drive out",
        ),
        (
            {"second_film": "taut", "second_voltage": 10.0},
            'second_voltage: is taken where second_drive is "constant" alone; give that',
        ),
        ({"second_film": "tuat"}, "second_film: 'tuat' is not a second film; did you mean 'taut'?"),
        ({"payload": "-1 g"}, "payload = '-1 g': must be at least 0"),
        (
            {"second_film": "taut", "second_flat_height": "9 m"},
            "second_flat_height = {}: so far from 0 that no displacement lies inside the stretch limits of both films",
        ),
    ],
)
def test_loads_and_second_films_that_do_not_fit_are_refused(device, changes, message):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with pytest.raises(InputError) as error:
            device.replace(**changes)
    for part in message.split("{}"):
        assert part in str(error.value)


# --- ensembles over any field -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SWEPT_FIELDS)
def test_every_number_makes_an_ensemble_of_single_devices(device, name):
    """Each member has the model, the scales and the start of a device with its value alone."""
    law = {"material.law": "yeoh"} if "yeoh" in name else {}
    owner = {"beam_rate": "-20 N/m"} if name.startswith("beam_") else {}
    owner |= {"second_film": "taut", "second_drive": "constant"} if name.startswith("second_") else {}
    if name in ("slew_rate", "current_limit", "material.resistivity_field"):
        owner |= {"filter_frequency": 1e3, "series_resistance": 1e6, "material.resistivity": 1e9}
    if name in ("material.dielectric_share", "material.dielectric_time"):
        owner |= {"material.dielectric_share": 0.3, "material.dielectric_time": "0.2 s"}
    if name.startswith(("material.viscous", "material.relaxation")):
        for k in (1, 2, 3):
            owner |= {f"material.viscous_modulus_{k}": "9 kPa", f"material.relaxation_time_{k}": "0.3 s"}
            owner |= {f"material.viscous_stretch_limit_{k}": 60.0}
    # The rest of a wrinkling film takes longer to find than that of a taut one: two fields of the film have it.
    film = {"film": "wrinkling" if name in ("hoop_prestretch", "material.shear_modulus") else "taut"}
    start = device.replace({"initial_height": "8 mm", "dielectric_strength": "20 kV/mm", **film, **law, **owner})
    own = start.get(name)
    usual = {"material.young_modulus": 5e4, "material.dielectric_strength": 2e7, "voltage_offset": 100.0}
    usual |= {
        "series_resistance": 1e6,
        "beam_cubic_rate": 1e4,
        "beam_height": 0.01,
        "second_flat_height": 0.01,
        "second_voltage": 500.0,
    }
    values = np.array([1.3, 1.0]) * (own or usual.get(name, 0.03 if name.startswith("release") else 1.01))
    if name == "material.dielectric_strength":
        start = start.replace(dielectric_strength=None)
    ensemble = start.replace({name: values})
    assert ensemble.shape == ensemble.to_model().shape == (2,)
    states = np.broadcast_to(ensemble.initial_state(), (2, 2))
    for i, value in enumerate(values):
        alone = start.replace({name: value})
        assert {k: np.broadcast_to(v, 2)[i] for k, v in ensemble.to_model().values.items()} == pytest.approx(
            alone.to_model().values, rel=1e-14
        )
        assert [np.broadcast_to(s, 2)[i] for s in dataclasses.astuple(ensemble.scales)] == pytest.approx(
            dataclasses.astuple(alone.scales), rel=1e-14
        )
        assert tuple(states[i]) == pytest.approx(alone.initial_state(), rel=1e-12)
        assert np.broadcast_to(ensemble.breakdown_field(), 2)[i] == pytest.approx(alone.breakdown_field(), rel=1e-14)
    assert Device(**json.loads(json.dumps(ensemble.parameters()))) == ensemble


def test_lists_of_unlike_length_are_refused(device):
    with pytest.raises(
        InputError, match=r"film_thickness has 2, material.shear_modulus has 3 values; give lists of one"
    ):
        device.replace({"film_thickness": [1e-3, 2e-3], "material.shear_modulus": [1e4, 2e4, 3e4]})


def test_an_array_is_checked_at_its_extremes(device):
    with pytest.raises(InputError, match=r"film_thickness\[1\] = -0.001: must be greater than 0 m"):
        device.replace(film_thickness=np.array([1e-3, -1e-3]))
    with pytest.raises(InputError, match=r"frequency\[0\] = nan: must be finite"):
        device.replace(frequency=np.array([np.nan, 3.0]))
    with pytest.raises(InputError, match="disc_radius = 60 mm: must be less than film_radius = 50 mm"):
        device.replace(disc_radius=np.array([0.01, 0.06]))


# --- what can hardly be meant -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        (
            {"film_thickness": "0.2 m", "film_radius": "30 mm"},
            r"film_thickness = 200 mm is outside the usual range, 0.02 to",
        ),
        ({"film_thickness": "21 mm"}, "film_thickness = 21 mm is outside"),
        ({"film_thickness": "15 mm", "film_radius": "30 mm"}, "too thick for the membrane model on a ring 20 mm wide"),
        ({"moving_mass": "20 kg"}, "moving_mass = 20 kg is outside the usual range"),
        ({"gravity": 81.0}, "gravity = 81 m/s\\^2 is outside the usual range"),
        ({"series_resistance": 5.0}, "series_resistance = 5 ohm is outside the usual range, 0.001 to 100 Mohm"),
        ({"material.shear_modulus": "20 MPa"}, "material.shear_modulus = 20 MPa is outside"),
    ],
)
def test_an_implausible_size_warns(device, changes, told):
    with pytest.warns(DoubtfulInput, match=told):
        odd = device.replace(changes)
    odd.replace_quietly(frequency=8.0)


# --- files of devices -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["paper-table1", "soft-film", "biased-pump"])
def test_a_device_survives_its_own_file(tmp_path, name):
    shipped = find_device(name)
    variants = [
        shipped,
        shipped.replace({"material.shear_modulus": 12345.6789, "film_thickness": 1.0 / 3e3, "quality_factor": 15.0}),
        shipped.replace({"frequency": [5.0, 6.5], "material.stretch_limit": math.inf, "name": 'a "quoted" name'}),
        shipped.replace({"material.law": "yeoh", "material.yeoh_c2": [-0.01, 0.02]}),
    ]
    for k, device in enumerate(variants):
        path = tmp_path / f"{k}.toml"
        path.write_text(device.to_toml(), encoding="utf-8")
        assert Device.from_toml(path) == device


def test_a_first_file_explains_every_field_and_is_the_device_it_starts_from(tmp_path):
    path = tmp_path / "mine.toml"
    text = first_file("mine.toml", find_device("biased-pump"), find_device("biased-pump").material)
    path.write_text(text, encoding="utf-8")
    own, start = Device.from_toml(path), find_device("biased-pump")
    assert own.replace(name=start.name) == start
    for name, field in DEVICE_FIELDS.items():
        if name != "material.sources":
            assert field.meaning in text, name
            assert f"{name.removeprefix('material.')} = " in text, name
            assert field.unit in text
    # what is commented out is right too: a gel of one's own, without what another law or another form takes
    head, table = text.split("# [material]")
    lines = [line.removeprefix("# ") for line in table.splitlines() if re.match(r"# \w+ = ", line)]
    others = ("shear_modulus =", "yeoh", "viscous", "relaxation", "flow")
    own_gel = "\n".join(line for line in lines if not line.startswith(others))
    path.write_text(f"{head.replace('material =', '# material =')}[material]\n{own_gel}\n", encoding="utf-8")
    assert Device.from_toml(path).material.replace(name=start.material.name).shear_modulus == own.material.shear_modulus


def test_the_list_of_fields_names_all_of_them():
    text = field_table(Device.fields)
    for name, field in DEVICE_FIELDS.items():
        assert f"  {name.removeprefix('material.')} " in text
        assert field.meaning in text


@pytest.mark.parametrize("name", shipped_devices())
def test_another_drive_makes_the_device_that_replace_makes(name):
    device = find_device(name)
    assert device.scales  # which is kept
    changes = dict(zip(DRIVE_NUMBERS, ("1.1 kV", "-0.2 kV", "7 Hz"), strict=True))
    driven, replaced = device.redriven(changes), device.replace_quietly(changes)
    assert driven == replaced != device
    assert driven.scales == replaced.scales
    assert driven.to_model().parameters() == replaced.to_model().parameters()
    assert driven.initial_state() == replaced.initial_state()
    for wrong in ({"frequency": "0 Hz"}, {"voltage_amplitude": "1 mm"}):
        messages = []
        for change in (device.redriven, device.replace_quietly):
            with pytest.raises(InputError) as refused:
                change(wrong)
            messages.append(str(refused.value))
        assert messages[0] == messages[1]
