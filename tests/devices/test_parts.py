"""Components of one's own in devices: files, Python, records of results, units, and what is refused."""

import json
import math
from dataclasses import dataclass

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone import Device, InputError, Quantity
from gelcone.devices.parts import field_of
from gelcone.devices.si import device_of
from gelcone.physics.bias import Together
from gelcone.physics.film.wrinkling import WrinklingCone
from tests.devices.own import Band, Filter, Harmonics, PowerFilm

TOML = """
disc_radius = "8 mm"
film_radius = "30 mm"
film_thickness = "0.2 mm"
meridional_prestretch = 1.1
hoop_prestretch = 1.4
initial_height = "20 mm"
spring_rate = "15 N/m"
moving_mass = "5 g"
damping_coefficient = "10 mN s/m"
voltage_amplitude = "0.4 kV"
voltage_offset = "0.5 kV"
frequency = "10 Hz"
film = "taut"
material = "PVC-DBA 6:1"

[waveform]
component = "tests.devices.own:Harmonics"
shares = [1.0, 0.0, 0.3]
second = 0.2

[circuit]
component = "tests.devices.own:Filter"
filter_time = "2 ms"

[bias]
component = "tests.devices.own:Band"
band_rate = "3 N/m"
band_cubic = "20 kN/m^3"
band_height = "5 mm"
"""


@pytest.fixture(scope="module")
def device(tmp_path_factory):
    path = tmp_path_factory.mktemp("own") / "mine.toml"
    path.write_text(TOML)
    return gelcone.find_device(path)


def test_a_file_holds_components_with_their_data_and_numbers(device):
    model, scales = device.to_model(), device.scales
    assert model.system.waveform == Harmonics((1.0, 0.0, 0.3))
    assert model.system.circuit == Filter()
    assert [part.name for part in model.system.bias.parts] == ["spring", "band"]
    expected = {
        "second": 0.2,
        "filter_time": 2e-3 / scales.time,
        "band_rate": 3.0 * scales.length**2 / scales.energy,
        "band_cubic": 2e4 * scales.length**4 / scales.energy,
        "band_height": 5e-3 / scales.length,
    }
    assert {name: model.values[name] for name in expected} == pytest.approx(expected, rel=1e-14)


def test_the_file_the_record_and_python_give_the_same_device(device, tmp_path):
    (tmp_path / "mine.toml").write_text(device.to_toml())
    same = {
        "text": Device.from_toml(tmp_path / "mine.toml"),
        "record": Device(**json.loads(json.dumps(device.parameters()))),
        "names": device.replace(waveform=Harmonics((1.0, 0.0, 0.3)), circuit="tests.devices.own:Filter", bias=Band())
        .replace({"waveform.second": 0.2, "circuit.filter_time": "2 ms", "bias.band_rate": "3 N/m"})
        .replace({"bias.band_cubic": "20 kN/m^3", "bias.band_height": "5 mm"}),
    }
    for way, other in same.items():
        assert other == device, way
        assert other.to_model().parameters() == device.to_model().parameters(), way


def test_a_result_holds_what_was_used(device):
    shown = gelcone.simulate(device, periods=2)
    assert device_of(shown) == device
    assert gelcone.model_of(shown).parameters() == device.to_model().parameters()
    np.testing.assert_array_less(abs(shown.film_voltage[1:]).max(), abs(shown.drive_voltage).max())  # filtered
    assert shown.film_voltage.attrs["units"] == "V"
    direct = gelcone.to_si(gelcone.simulate(device.to_model(), device.initial_state(), periods=2), device)
    xr.testing.assert_identical(shown, direct)


@pytest.mark.parametrize(
    ("name", "values", "unit"),
    [
        ("circuit.filter_time", ["1 ms", "3 ms"], "s"),
        ("bias.band_rate", [2.0, "4 N/m"], "N/m"),
        ("bias.band_height", ["4 mm", "6 mm"], "mm"),
        ("waveform.second", [0.1, 0.3], "1"),
    ],
)
def test_its_numbers_are_swept_as_each_device_alone(device, name, values, unit):
    swept = gelcone.sweep(gelcone.Plan(device, {name: values}), "settled")
    assert swept[name].attrs["units"] == unit
    for k, value in enumerate(values):
        alone = gelcone.settled(device.replace({name: value}))
        assert float(swept.stroke[k]) == pytest.approx(float(alone.stroke), rel=1e-9)
    models = gelcone.model_of(swept)
    for k, value in enumerate(values):
        one = device.replace({name: value}).to_model()
        own = name.partition(".")[2]
        assert np.broadcast_to(models.values[own], models.shape)[k] == pytest.approx(one.values[own], rel=1e-14)


def test_a_film_of_ones_own_needs_no_law(device):
    own = device.replace(
        film={"component": "tests.devices.own:PowerFilm", "exponent": 2.0, "film_modulus": "6 kPa"},
        meridional_prestretch=None,
        hoop_prestretch=None,
    )
    model = own.to_model()
    assert model.film == PowerFilm(2.0)
    assert model.values["film_modulus"] == pytest.approx(6e3 / own.material.shear_modulus, rel=1e-14)
    assert "stretch_limit" not in model.values
    assert Device(**json.loads(json.dumps(own.parameters()))) == own
    assert device_of(gelcone.simulate(own, periods=1)) == own
    with pytest.raises(InputError, match="hoop_prestretch"):
        own.replace(hoop_prestretch=1.2)


def test_the_file_of_a_film_of_ones_own_leaves_law_and_mode_to_the_device(device):
    """As an instance the film holds both; a file that says them twice is refused."""
    own = device.replace(film=WrinklingCone(pull_in="snap"))
    record = own.parameters()["film"]
    assert record["pull_in"] == "snap"
    assert not {"law", "prestretch_mode"} & set(record)
    assert Device.from_text(own.to_toml()) == own


def test_several_biases_act_together(device):
    class Second(Band):
        name = "second"
        parameters = {"second_push": Quantity("p", "push", 0.0, scale="force")}

        def force(self, x, y, n, xp=np):
            return 0.0 * x - n["second_push"], 0.0 * x

        def free_height(self, n):
            return 0.0

    both = device.replace({"bias": Together((Band(), Second())), "bias.second_push": "2 mN"})
    assert [part.name for part in both.to_model().system.bias.parts] == ["spring", "band", "second"]
    push = device.replace({"bias": Band(), "constant_force": "2 mN"})
    assert both.initial_state() == pytest.approx(push.initial_state(), rel=1e-9)


@dataclass(frozen=True)
class Steps(Band):
    """A band with data of its own."""

    steps: tuple[float, ...] = (1.0,)

    name = "steps"


def test_a_bias_with_data_is_held_whole(device, tmp_path):
    own = device.replace({"bias": Steps((1.0, 2.0)), "bias.band_rate": "3 N/m"})
    (tmp_path / "mine.toml").write_text(own.to_toml())
    assert Device.from_toml(tmp_path / "mine.toml") == own
    shown = gelcone.simulate(own, periods=1)
    assert device_of(shown) == own
    assert gelcone.model_of(shown).system.bias.parts[1].steps == (1.0, 2.0)


def test_a_component_that_changes_starts_from_its_own_defaults(device):
    again = device.replace(circuit=Filter())
    assert again.get("circuit.filter_time") is None
    assert again.to_model().values["filter_time"] == 0.3
    assert "circuit.filter_time" not in device.replace(circuit=None).all_fields()


def test_bounds_and_words_are_those_of_the_device(device):
    for changes, message in {
        "circuit.filter_time": ("0 ms", "circuit.filter_time = '0 ms': must be greater than 0 s"),
        "bias.band_rate": (-1.0, "bias.band_rate = -1.0: must be at least 0 N/m"),
        "bias.band_height": ("3 N", "N is a unit of force, not of length"),
        "bias.band_hieght": (1.0, "'bias.band_hieght' is not a device field; did you mean 'bias.band_height'?"),
    }.items():
        with pytest.raises(InputError, match="".join(c if c.isalnum() else "." for c in message[1])):
            device.replace({changes: message[0]})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"waveform": "tests.devices.own:Missing"}, "waveform: .*cannot be imported"),
        ({"waveform": "tests.devices.own:Filter"}, "waveform: .*derive its class from gelcone.Waveform"),
        ({"waveform": "tests.devices.own:Harmonics"}, "waveform: .*shares"),
        ({"waveform": Harmonics(np.array([1.0, 0.5]))}, "waveform: harmonics: shares is an array; hold a tuple of num"),
        (
            {"waveform": Harmonics(frozenset({1.0, 0.5}))},
            "holds data that no file can hold; give numbers, texts or tupl",
        ),
        ({"circuit": 3}, "circuit: circuit = 3: must be a circuit"),
        ({"film": {"component": "taut", "law": "gent"}}, "film: law is a field of the material or of the device"),
        ({"film": {"component": "taut", "prestretch_mode": "equal"}}, "film: prestretch_mode is a field of"),
        ({"bias": "beam"}, "bias = 'beam': must be a component of one's own, .*spring, beam, weight and force have"),
        ({"bias": "1 kV"}, "a constant voltage is voltage_offset"),
        ({"bias": gelcone.physics.bias.LinearSpring()}, "bias: has the parameter spring_stiffness, which is one that"),
    ],
)
def test_what_cannot_be_used_is_refused(device, changes, message):
    with pytest.raises(InputError, match=message) as caught:
        device.replace(changes)
    assert "\n" not in str(caught.value)


def test_a_field_has_the_bounds_of_its_parameter():
    field = field_of("x", Quantity("x", "meaning", 0.3, positive=True, infinite=True, typical=(1.0, 2.0), near=("y",)))
    assert (field.unit, field.above, field.least, field.infinite) == ("1", 0.0, None, True)
    assert (field.typical, field.near, field.unset, field.example) == ((1.0, 2.0), ("y",), "0.3", 0.3)
    scaled = field_of("x", Quantity("x", "meaning", 0.3, lower=0.0, scale="voltage"))
    assert (scaled.unit, scaled.above, scaled.least, scaled.example) == ("V", None, 0.0, None)
    # a bound other than 0 has another value in SI for each device: the model checks it
    assert field_of("x", Quantity("x", "meaning", 0.3, lower=-1.0, scale="voltage")).least is None
    assert field_of("x", Quantity("x", "meaning", 0.3, lower=-1.0)).least == -1.0
    assert field_of("x", Quantity("x", "meaning", 0.3)).least is None
    assert math.isinf(Quantity("x", "meaning", 0.3).lower)
    with pytest.raises(InputError, match="x: scale = 'volts' must be '1' or one of length, time, velocity"):
        field_of("x", Quantity("x", "meaning", 0.3, scale="volts"))
