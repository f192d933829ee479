"""Controls follow from what the parts of a subject say of themselves."""

import pytest

from gelcone.analyses.subject import Subject
from gelcone.physics.model import ConeModel
from gelcone.studio.controls import controls_of
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
    assert (found["voltage_offset"].value, found["voltage_offset"].unit) == (1.0, "kV")
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


def test_only_what_the_model_has(shelf):
    gent = by_name(shelf.subject(Setting(preset="base")))
    yeoh = by_name(shelf.subject(Setting(preset="base", values={"law": "yeoh"})))
    assert "stretch_limit" in gent
    assert "yeoh_c2" not in gent
    assert "yeoh_c2" in yeoh
    assert "stretch_limit" not in yeoh
