"""What is said of a device in its title and in answers: everything that is set, once."""

import tomllib

import numpy as np
import pytest

import gelcone
from gelcone.devices.template import _terms, _value, component_in_words, fields_in_words, first_file
from gelcone.devices.units import parse
from gelcone.physics.bias import LinearSpring, Together, Weight
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.laws import LAWS

PUMP = gelcone.find_device("biased-pump")
DOUBLE = gelcone.find_device("double-cone").replace(film="taut", second_film="taut")


def test_what_is_set_is_said_with_its_unit_and_what_is_usual_is_not():
    told = dict(text.split(" ", 1) for text in fields_in_words(DOUBLE))
    usual = {"initial_height", "release_velocity", "film", "name", "waveform", "prestretch_mode"}
    assert set(told) == {name for name, value in DOUBLE if value is not None} - usual
    assert (told["film_radius"], told["frequency"], told["second_drive"]) == ("25 mm", "14 Hz", "opposite")
    assert (told["material"], told["hoop_prestretch"], told["spring_rate"]) == ("PVC-DBA 6:1", "1.3", "0 N/m")


@pytest.mark.parametrize("swept", [("frequency",), ("hoop_prestretch", "second_flat_height")])
def test_what_is_swept_is_left_out(swept):
    told, fewer = fields_in_words(DOUBLE), fields_in_words(DOUBLE, swept)
    assert [text for text in told if text.split()[0] not in swept] == fewer
    assert len(fewer) == len(told) - len(swept)


def test_a_law_and_a_waveform_that_are_not_the_usual_ones_are_said():
    own = DOUBLE.replace({"material.law": "neo-hookean"}, waveform="triangle", initial_height="3 mm")
    assert set(fields_in_words(own)) - set(fields_in_words(DOUBLE)) == {
        "material PVC-DBA 6:1, changed", "law neo-hookean", "waveform triangle", "initial_height 3 mm",
    }  # fmt: skip


def test_a_changed_number_of_a_gel_that_ships_is_said_and_the_others_are_not():
    changed = DOUBLE.replace({"material.shear_modulus": "9 kPa", "material.viscous_modulus_1": "3 kPa",
                              "material.relaxation_time_1": "50 ms"})  # fmt: skip
    assert set(fields_in_words(changed)) - set(fields_in_words(DOUBLE)) == {
        "material PVC-DBA 6:1, changed", "shear_modulus 9 kPa", "viscous_modulus_1 3 kPa", "relaxation_time_1 50 ms",
    }  # fmt: skip
    assert "shear_modulus 9 kPa" not in fields_in_words(changed, ["material.shear_modulus"])


def test_all_numbers_of_a_gel_of_ones_own_are_said_once():
    gel = {"name": "own gel", "shear_modulus": "9 kPa", "relative_permittivity": 5.5, "law": "yeoh", "yeoh_c2": 0.01,
           "dielectric_strength": "22 MV/m", "resistivity": "2 Gohm m", "flow": "linear",
           "viscous_modulus_1": "5 kPa", "relaxation_time_1": "50 ms"}  # fmt: skip
    own = DOUBLE.replace(material=gel, dielectric_strength=None)
    said = [
        "material own gel", "shear_modulus 9 kPa", "relative_permittivity 5.5", "law yeoh", "yeoh_c2 0.01",
        "dielectric_strength 22 MV/m", "viscous_modulus_1 5 kPa", "relaxation_time_1 50 ms", "flow linear",
        "resistivity 2 Gohm m",
    ]  # fmt: skip
    assert [text for text in fields_in_words(own) if text in said] == said
    assert set(fields_in_words(own)) - set(said) < set(fields_in_words(DOUBLE))
    both = fields_in_words(own.replace(dielectric_strength="20 MV/m"))
    assert [text for text in both if "strength" in text] == ["dielectric_strength 20 MV/m"]


@pytest.mark.parametrize(
    ("part", "value", "texts"),
    [
        ("waveform", {"component": "samples", "shares": [0, 0.5, 1], "values": [0, 1, -1], "interpolation": "pchip"},
         ["waveform samples (3 values, interpolation pchip)"]),
        ("waveform", {"component": "staircase", "levels": [0, 1], "rise": 0.05, "repeat": False},
         ["waveform staircase (2 levels, rise 0.05, no repeat)"]),
        ("waveform", {"component": "square", "duty": 0.3}, ["waveform square", "waveform.duty 0.3"]),
        ("waveform", "samples", ["waveform samples"]),
        ("bias", {"component": "tests.toys:CubicBias", "bias_cubic": 0.4}, ["bias cubic", "bias.bias_cubic 0.4"]),
        ("circuit", "charge", ["circuit charge"]),
    ],
)  # fmt: skip
def test_a_component_is_said_with_its_data_and_its_numbers(part, value, texts):
    own, before = PUMP.replace({part: value}), fields_in_words(PUMP)
    assert [text for text in fields_in_words(own) if text not in before] == texts


def test_parts_and_data_of_a_component_are_said_but_not_the_gel_s():
    assert component_in_words(Together((LinearSpring(), Weight()))) == "spring + weight"
    assert component_in_words(WrinklingCone(LAWS["yeoh"], "equibiaxial", pull_in="snap")) == "wrinkling (pull_in snap)"


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (True, "", "true"), (3, "", "3"), (0.1, "m", '"100 mm"'), (0.1 + 0.2, "1", "0.30000000000000004"),
        (0.0, "m", "0.0"), ([1e-3, 2e-3], "m", '["1 mm", "2 mm"]'), ("a", "", '"a"'),
        ({"a": [1, 2.5]}, "", "{a = [1, 2.5]}"),
        (np.inf, "m", "inf"), (1.0 / 3.0, "m", "0.3333333333333333"),
    ],
)  # fmt: skip
def test_values_are_written_as_toml_that_reads_back_to_the_same(value, unit, text):
    assert _value(value, unit) == text
    (again,) = tomllib.loads(f"x = {text}").values()
    if isinstance(value, float) and unit == "m":
        assert parse("x", again, unit, infinite=True) == value
    elif not isinstance(value, list):
        assert again == value


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.123456789, "m", '"123.456789 mm"'), (2e-4, "m", '"200 um"'), (56100.0 / 3.0, "Pa", '"18.7 kPa"'),
        (0.5, "1", "0.5"), (0.0, "m", "0.0"), (np.inf, "s", "inf"), ([1.0, 2.5], "V", '["1 V", "2.5 V"]'),
        (True, "", "true"), ("a \u03bc", "", '"a \u03bc"'),
    ],
)  # fmt: skip
def test_a_value_is_written_with_its_unit_and_all_its_digits(value, unit, text):
    assert _value(value, unit) == text


def test_a_field_says_whether_it_is_needed_its_unit_and_its_usual_range():
    fields = gelcone.Device.fields
    assert _terms(fields["disc_radius"])[:2] == ["required", "SI unit m"]
    assert _terms(fields["damping_ratio"])[0] == "required, or give damping_coefficient or quality_factor"
    assert _terms(fields["initial_height"])[0].startswith("optional, ")
    assert _terms(fields["beam_rate"])[0] == "optional, no beam when left out"
    assert [term for term in _terms(fields["disc_radius"]) if term.startswith("usual ")] == ["usual 1 to 50 mm"]
    assert _terms(fields["name"])[0] == "optional, the file's name when left out"
    assert not any(term.startswith(("SI unit", "usual")) for term in _terms(fields["name"]))


def test_the_proposals_of_a_first_file_are_written_as_one_would_and_can_be_taken():
    lines = [line.removeprefix("# ") for line in first_file("a.toml", PUMP, PUMP.material).splitlines()]
    assert 'circuit = "charge"' in lines
    assert 'shear_modulus = "8.233 kPa"' in lines
    assert 'young_modulus = "24.7 kPa"' in lines
    assert PUMP.replace(film="taut", circuit="charge").circuit == "charge"


def test_a_first_file_leaves_out_what_is_its_default():
    text = first_file("mine.toml", PUMP, PUMP.material)
    written = tomllib.loads(text)
    assert written
    assert not [name for name, value in written.items() if value == PUMP.fields[name].default]
    assert '# release_velocity = "100 mm/s"' in text.splitlines()
    assert '# prestretch_mode = "radial"' in text.splitlines()


def test_the_gravity_of_a_first_file_is_that_of_the_earth():
    """The middle of its usual range, 3 m/s^2, would be taken over as it stands."""
    assert gelcone.Device.fields["gravity"].example_text() == "9.81 m/s^2"
