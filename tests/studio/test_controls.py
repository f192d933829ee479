"""Controls follow from what the parts of a subject say of themselves."""

import json
import math
from contextlib import suppress
from types import SimpleNamespace

import pytest

from gelcone import Device, find_device, static
from gelcone.analyses.request import Subject
from gelcone.devices.materials import load_materials
from gelcone.devices.record import Field
from gelcone.devices.units import DIMENSIONS
from gelcone.errors import InputError
from gelcone.physics.model import ConeModel
from gelcone.physics.records import FILMS
from gelcone.quantity import Quantity
from gelcone.studio.controls import _of_field, _of_quantity, _range, as_json, controls_of
from gelcone.studio.setting import Setting, Shelf
from tests.toys import CubicBias, ThreeHarmonics


@pytest.fixture(scope="module")
def shelf():
    shelf = Shelf()
    return shelf


def by_name(subject):
    return {control.name: control for control in controls_of(subject)}


def test_a_device_is_set_in_its_own_units(shelf):
    found = by_name(shelf.subject(Setting(device="biased-pump")))
    assert (found["disc_radius"].value, found["disc_radius"].unit) == (8.0, "mm")
    assert (found["voltage_offset"].value, found["voltage_offset"].unit) == (790.0, "V")
    assert found["release_height"].value is None
    assert "voltage" not in found


def test_every_number_of_a_setting_lies_within_its_slider(shelf):
    for setting in (Setting(device="biased-pump"), Setting(device="soft-film"), Setting(preset="base")):
        for control in controls_of(shelf.subject(setting)):
            if control.kind == "number":
                assert control.low < control.high
                assert control.value is None or control.low <= control.value <= control.high, control


@pytest.mark.slow
def test_every_slider_end_can_be_typed(shelf):
    """The ends of the sliders are inside the bounds of what they set."""
    for base in (Setting(device="biased-pump"), Setting(preset="base")):
        for control in controls_of(shelf.subject(base)):
            if control.name in ("disc_radius", "film_radius") or "stretch" in control.name:
                continue  # bounded by other parameters too
            for end in (control.low, control.high) if control.kind == "number" else ():
                text = f"{end:.6g} {control.unit}".strip()
                shelf.subject(Setting(base.device, base.preset, values={control.name: text}))


def test_a_component_of_ones_own_brings_its_controls():
    model = ConeModel(bias=CubicBias(), waveform=ThreeHarmonics())
    found = by_name(Subject(model))
    assert found["bias_cubic"].group == "Body"
    assert found["second_harmonic"].group == "Drive"


def test_a_waveform_that_ships_brings_its_controls_to_a_device(shelf):
    found = by_name(shelf.subject(Setting(device="soft-film", values={"waveform": "square"})))
    assert (found["waveform.duty"].value, found["waveform.duty"].group) == (0.5, "Drive")
    chirp = by_name(shelf.subject(Setting(device="soft-film", values={"waveform": "chirp"})))
    device = shelf.subject(Setting(device="soft-film")).device
    assert chirp["waveform.end_frequency"].unit == "Hz"
    assert chirp["waveform.end_frequency"].value == pytest.approx(3.0 * device.scales.frequency)


def test_only_what_the_model_has(shelf):
    gent = by_name(shelf.subject(Setting(preset="base")))
    yeoh = by_name(shelf.subject(Setting(preset="base", values={"law": "yeoh"})))
    assert "stretch_limit" in gent
    assert "yeoh_c2" not in gent
    assert "yeoh_c2" in yeoh
    assert "stretch_limit" not in yeoh


@pytest.mark.parametrize("device", ["biased-pump", "double-cone", "soft-film"])
def test_the_number_beside_a_slider_is_that_of_the_device(shelf, device):
    subject = shelf.subject(Setting(device=device))
    for name, control in by_name(subject).items():
        if control.kind == "number" and control.value is not None:
            about = subject.device.all_fields()[name]
            assert control.powers == (DIMENSIONS[about.unit].powers)
            shown = control.value * 10.0 ** control.powers[control.unit]
            assert shown == pytest.approx(float(subject.device.get(name)), rel=1e-11), name
            assert control.about == about.meaning
        elif control.kind == "choice" and name != "material":
            assert control.value == (subject.device.get(name) or {"second_film": "none"}[name])
            assert control.value in control.choices
    shown = {name for name in by_name(subject) if "." not in name}
    given = {name for name, field in Device.fields.items() if field.unit and subject.device.get(name) is not None}
    assert given <= shown


def test_the_number_beside_a_slider_is_that_of_the_model(shelf):
    subject = shelf.subject(Setting(preset="base", values={"displacement": "0.25", "velocity": "-0.5"}))
    found = by_name(subject)
    for name, value in subject.model.values.items():
        if name in found:
            assert found[name].value == float(value), name
    assert (found["displacement"].value, found["velocity"].value) == (0.25, -0.5)
    assert (found["law"].value, found["film"].value, found["waveform"].value) == ("gent", "taut", "sine")
    assert found["voltage"].high >= 4.0 * ConeModel().voltage  # chaos begins at twice the usual voltage


GROUPS = {
    "voltage_amplitude": "Drive", "voltage_offset": "Drive", "frequency": "Drive", "waveform": "Drive",
    "disc_radius": "Body", "spring_rate": "Body", "moving_mass": "Body", "initial_height": "Body",
    "material.shear_modulus": "Gel", "hoop_prestretch": "Gel", "film": "Gel", "dielectric_strength": "Gel",
    "material": "Gel", "release_height": "Start", "release_velocity": "Start",
}  # fmt: skip
MODEL_GROUPS = {
    "voltage": "Drive", "drive_frequency": "Drive", "waveform": "Drive", "spring_stiffness": "Body", "bias": "Body",
    "damping_ratio": "Body", "hoop_prestretch": "Gel", "prestretch": "Gel", "law": "Gel", "stretch_limit": "Gel",
    "displacement": "Start", "velocity": "Start",
}  # fmt: skip


def test_controls_stand_in_their_groups_one_after_the_other(shelf):
    for setting, groups in ((Setting(device="biased-pump"), GROUPS), (Setting(preset="base"), MODEL_GROUPS)):
        subject = shelf.subject(setting)
        found = {name: control.group for name, control in by_name(subject).items()}
        assert {name: found[name] for name in groups if name in found} == {
            name: group for name, group in groups.items() if name in found
        }
        assert len(found.keys() & groups.keys()) >= 10
        order = ["Drive", "Body", "Gel", "Start"]
        places = [order.index(control.group) for control in controls_of(subject)]
        assert places == sorted(places)


def test_a_label_is_the_name_in_words(shelf):
    found = by_name(shelf.subject(Setting(device="biased-pump")))
    assert found["voltage_amplitude"].label == "Voltage amplitude"
    assert found["material.shear_modulus"].label == "Shear modulus"


@pytest.mark.parametrize(
    ("value", "high"), [(0.3, 0.8), (1.0, 2.0), (1.2, 2.5), (20.0, 40.0), (45.0, 100.0), (2.4, 5.0)]
)
def test_a_slider_goes_to_a_round_number_above_twice_its_value(value, high):
    assert _range(value, 0.0) == (0.0, high)
    assert _range(-value, 0.0) == (-high, high)
    assert _range(0.0, 0.0) == (-1.0, 1.0)
    assert _range(float("inf"), value) == (0.0, high)


def test_bounds_of_a_field_bound_its_slider(shelf):
    subject = shelf.subject(Setting(device="biased-pump"))
    for control in controls_of(subject):
        about = subject.device.all_fields()[control.name]
        if about.above is not None and control.kind == "number":
            assert control.low * 10.0 ** control.powers[control.unit] > about.above, control.name
        if about.least is not None and control.kind == "number":
            assert control.low * 10.0 ** control.powers[control.unit] >= about.least - 1e-12, control.name
    for control in controls_of(shelf.subject(Setting(preset="base"))):
        known = shelf.subject(Setting(preset="base")).model.system.parameters.get(control.name)
        if known is not None:
            assert control.low >= known.lower, control.name
            assert control.low > 0.0 or not known.positive, control.name


def test_the_least_value_of_a_field_is_a_slider_end_in_its_unit():
    gap = _of_field("gap", Field("gap of a stop", "m", least=0.002), 0.01, 0.01, 0.01)
    assert (gap.unit, gap.low, gap.high) == ("mm", 2.0, 20.0)


def test_controls_travel_as_json(shelf):
    controls = controls_of(shelf.subject(Setting(device="biased-pump")))
    assert json.loads(json.dumps(as_json(controls))) == [
        {**vars(control), "choices": list(control.choices), "powers": dict(control.powers)} for control in controls
    ]


def test_a_length_of_zero_has_the_size_of_the_device_for_a_range():
    by = {control.name: control for control in Shelf().controls(Setting(device="snap-cone"))}
    height = by["beam_height"]
    assert (height.value, height.unit) == (0.0, "mm")
    assert -height.low == height.high == 50.0  # twice the film's radius of 25 mm


def test_a_voltage_of_zero_has_the_drive_s_own_for_a_range(shelf):
    offset = by_name(shelf.subject(Setting(device="soft-film")))["voltage_offset"]
    assert (offset.value, offset.unit) == (0.0, "V")
    assert -offset.low == offset.high >= 530.0  # the amplitude


SECOND = {"second_film": "taut", "film": "taut"}


def test_a_second_film_is_a_choice_and_brings_its_fields(shelf):
    def found(device, **values):
        controls = {control.name: control for control in shelf.controls(Setting(device=device, values=values))}
        return {name: control for name, control in controls.items() if name.startswith("second")}

    single, double = found("snap-cone"), found("snap-cone", **SECOND)
    assert {name: (c.value, c.choices[0]) for name, c in single.items()} == {"second_film": ("none", "none")}
    assert {name: c.value for name, c in double.items()} == {
        "second_film": "taut",
        "second_drive": "same",
        "second_flat_height": 0.0,
    }
    assert double["second_film"].choices[0] == "none"  # it may be taken back
    assert found("snap-cone", **SECOND, second_drive="constant")["second_voltage"].high > 100.0
    assert "none" not in found("double-cone")["second_film"].choices  # there it is the device's own


def test_a_single_cone_becomes_a_double_cone(shelf):
    values = SECOND | {"second_flat_height": "20 mm", "second_drive": "opposite"}
    device = shelf.subject(Setting(device="snap-cone", values=values)).device
    assert (device.second_film, device.second_flat_height, device.second_drive) == ("taut", 0.02, "opposite")
    for wrong in ({"second_drive": "same"}, {"second_film": "none"}, SECOND | {"second_voltage": "3 V"}):
        with pytest.raises(InputError):
            shelf.subject(Setting(device="snap-cone", values=wrong))


def test_a_release_height_that_is_not_set_has_the_rest_for_its_range(shelf):
    """From the plane of the film to about twice the height at which the disc rests."""
    subject = shelf.subject(Setting(device="biased-pump", values={"film": "taut"}))
    control = by_name(subject)["release_height"]
    rest = float(static(subject.model, [0.0])["rest_displacement"]) * subject.device.scales.length
    assert (control.low, control.unit) == (0.0, "mm")
    assert 2.0 <= 1e-3 * control.high / rest < 4.0


@pytest.mark.parametrize("film", FILMS)
def test_the_gels_that_are_offered_are_those_that_the_film_takes(film):
    device, known = find_device("soft-film").replace(film="taut"), set()
    for gel in load_materials():
        with suppress(InputError):
            device.replace(film=film, material=gel)
            known.add(gel)
    found = by_name(SimpleNamespace(device=device.replace_quietly({"film": film})))["material"]
    assert set(found.choices) == known >= {"PVC-DBA 6:1"}


def test_a_parameter_that_is_nothing_by_default_has_a_slider_within_its_bounds():
    """Of a component of one's own: its range goes to either side of 0 as far as it may."""
    for lower, low in ((-0.25, -0.25), (0.0, 0.0), (-9.0, -1.0), (-math.inf, -1.0)):
        control = _of_quantity("share", Quantity("s", "a share", 0.0, lower=lower), 0.0, "Body")
        assert (control.low, control.high, control.value, control.about) == (low, 1.0, 0.0, "a share")
