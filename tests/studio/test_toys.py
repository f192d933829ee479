"""Components of one's own, with parameters and states, show in the studio without a line in its sources."""

import json

import numpy as np
import pytest

import gelcone
from gelcone import find_device
from gelcone.devices.files import shipped_devices
from gelcone.studio import exports, grids, look, settled
from gelcone.studio.controls import as_json
from gelcone.studio.frames import pack
from gelcone.studio.grids import Source
from gelcone.studio.setting import Setting, Shelf, names_in, typed

pytestmark = pytest.mark.usefixtures("no_membranes")
DEVICES = {
    "waveform": ('waveform = "tests.toys:ThreeHarmonics"', {"waveform.second_harmonic": "Drive"}),
    "circuit": ('circuit = "tests.toys:FilteredVoltage"', {"circuit.filter_time": "Drive"}),
    "states": ('bias = "tests.toys:TurningBias"', {"bias.wheel_growth": "Body", "bias.wheel_turning": "Body"}),
    "bias in SI units": ('bias = "tests.toys:Plate"', {"bias.bias_stiffness": "Body", "bias.bias_cubic": "Body"}),
    "law": (
        'material = {name = "g", shear_modulus = "15 kPa", relative_permittivity = 6.1, law = "tests.toys:Quadratic"}\n'
        'film = "wrinkling"',
        {"material.law_growth": "Gel"},
    ),
    "film": ('film = {component = "tests.toys:PowerFilm", exponent = 1.4}', {"film.film_modulus": "Gel"}),
    "creeping film": (
        'film = {component = "taut", branches = 1, relaxation_time_1 = "0.6 s"}',
        {"film.viscous_modulus_1": "Gel", "film.relaxation_time_1": "Gel"},
    ),
}
"""What is added to a device, and the groups of the controls that this brings."""


def shelf_of(line, folder):
    """The shelf of a studio that was started with a device with this line."""
    text = shipped_devices()["biased-pump"].read_text(encoding="utf-8")
    head, mark, rest = text.partition("[")  # before the first table
    given = folder / "mine.toml"
    part = line.partition("=")[0]
    others = "prestretch" if part == "film " else part  # a film of one's own has none
    rows = [row for row in head.splitlines() if not row.startswith(part) and others not in row]
    given.write_text("\n".join([*rows, line, ""]) + mark + rest)
    return Shelf(given, names_in(find_device(given)))


@pytest.fixture(scope="module", params=DEVICES)
def toy(request, tmp_path_factory):
    """The shelf of such a device, and the groups."""
    line, groups = DEVICES[request.param]
    return shelf_of(line, tmp_path_factory.mktemp("toy")), groups


BASE = Setting(device="mine")


def moved(shelf, name):
    """The setting with a control moved by a twentieth of its range."""
    control = next(c for c in shelf.controls(BASE) if c.name == name)
    value = control.value + 0.05 * (control.high - control.low)
    return Setting(device="mine", values={name: f"{value:.6g} {control.unit}".strip()})


def test_its_parameters_are_controls_in_the_groups_of_their_parts(toy):
    shelf, groups = toy
    found = {control.name: control for control in shelf.controls(BASE)}
    pack({"controls": as_json([*found.values()])})
    for name, group in groups.items():
        control = found[name]
        assert (control.kind, control.group) == ("number", group)
        assert control.about
        assert control.low <= control.value <= control.high
        json.dumps(control.value)


@pytest.mark.parametrize(
    ("line", "name", "shown"),
    [
        ('waveform = {component = "burst", cycles = 4, period_in_cycles = 9}', "waveform", "burst, of the file"),
        (DEVICES["law"][0], "material.law", "quadratic, of the file"),
    ],
)
def test_a_component_of_the_file_can_be_left_for_one_that_ships(tmp_path, line, name, shown):
    """The page resets a control to the component of the file; as a choice it cannot be sent."""
    shelf = shelf_of(line, tmp_path)
    (control,) = [one for one in shelf.controls(BASE) if one.name == name]
    assert (control.value, control.choices[0]) == (shown, shown)
    json.dumps(as_json([control]))
    other = Setting(device="mine", values={name: control.choices[1]})
    (control,) = [one for one in shelf.controls(other) if one.name == name]
    assert control.value == other.values[name]
    assert shown not in control.choices
    with pytest.raises(gelcone.InputError, match="of the file"):
        shelf.subject(Setting(device="mine", values={name: shown}))


def test_numbers_of_a_component_are_shown_in_their_units(tmp_path):
    device = find_device(shelf_of(DEVICES["bias in SI units"][0], tmp_path).given)
    stiffness = device.scales.force / device.scales.length
    found = {control.name: control for control in Shelf(tmp_path / "mine.toml", names_in(device)).controls(BASE)}
    k1 = found["bias.bias_stiffness"]
    assert k1.value * 10.0 ** k1.powers[k1.unit] == pytest.approx(1.2 * stiffness)


def test_a_control_moves_what_it_names_and_the_pictures_follow(toy):
    shelf, groups = toy
    plain = shelf.subject(BASE)
    for name in groups:
        subject = shelf.subject(moved(shelf, name))
        own = name.partition(".")[2]
        assert subject.model.values[own] != plain.model.values[own]
        response = look.response(subject, 3)
        assert np.isfinite(response.arrays["x"]).all()
        assert not np.array_equal(response.arrays["x"], look.response(plain, 3).arrays["x"]) or own.startswith("wheel")
        kind = settled.kind(subject)
        assert kind.words["lines"]
        assert kind.words["numbers"]
        assert len(settled.spectrum(subject).arrays["amplitude"]) > 10
        for parts in (response, kind, look.glance(subject)):
            pack({"words": parts.words, "about": look.about(subject)}, parts.arrays)


def test_it_is_swept_saved_and_repeated(toy):
    shelf, groups = toy
    name = next(iter(groups))
    control = next(c for c in shelf.controls(BASE) if c.name == name)
    over = grids.axis(shelf.controls(BASE), [name, control.low + 0.1, control.high], 3)
    source = Source(shelf.path(BASE), None, {"settings": []})
    found = grids.kinds(source, {name: over.texts(range(3))})
    assert found["regime"].shape == (3,)
    assert np.isfinite(found["low"]).any()
    setting = moved(shelf, name)
    wanted = exports.Wanted.read("simulate", {"periods": 3}, ())
    subject = shelf.subject(setting)
    result = exports.compute(subject, wanted)
    again = gelcone.model_of(result)
    assert again.values[name.partition(".")[2]] == subject.model.values[name.partition(".")[2]]
    assert f"--set '{name}=" in exports.command(setting, wanted, shelf.called(setting)) or (
        f"--set {name}=" in exports.command(setting, wanted, shelf.called(setting))
    )
    assert typed(setting)["settings"] == [f"{name}={setting.values[name]}"]
