"""What a page may ask about: devices and presets by name, values with the checks of the command line, never a path."""

import os
import re
import time
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

from gelcone import InputError, disk_cache, find_device
from gelcone.analyses.request import read_subject
from gelcone.devices.files import shipped_devices
from gelcone.membrane.table import names
from gelcone.studio import setting as module
from gelcone.studio.controls import NONE
from gelcone.studio.grids import Source, find_rests
from gelcone.studio.setting import Setting, Shelf, typed


@pytest.fixture
def shelf():
    shelf = Shelf()
    return shelf


def text_of(name="biased-pump"):
    return shipped_devices()[name].read_text(encoding="utf-8")


def test_a_setting_gives_what_the_command_line_gives(shelf):
    values = {"voltage_amplitude": "0.7 kV", "material.shear_modulus": "9 kPa"}
    found = shelf.subject(Setting.read({"device": "biased-pump", "values": values}))
    typed = read_subject("biased-pump", settings=[f"{name}={value}" for name, value in values.items()])
    assert found.model.parameters() == typed.model.parameters()
    assert found.initial == pytest.approx(typed.initial, rel=1e-12)
    preset = shelf.subject(Setting.read({"preset": "base", "values": {"voltage": "1.04", "displacement": "0.5"}}))
    assert (preset.model.voltage, preset.initial) == (1.04, (0.5, 0.0))


def test_the_text_of_a_file_is_read_as_the_file(shelf):
    found = shelf.subject(Setting.read({"file": text_of()}))
    assert found.model.parameters() == read_subject("biased-pump").model.parameters()


MEMBRANE = {"film": "membrane", "meridional_prestretch": "1.14"}


@pytest.mark.parametrize(
    ("device", "values"), [("biased-pump", MEMBRANE), ("biased-pump", {"film": "wrinkling"}), ("double-cone", MEMBRANE)]
)
def test_a_cone_stands_for_a_membrane_that_is_not_made(shelf, device, values, tmp_path, monkeypatch):
    base = find_device(device)  # with its own membranes, which others need, too
    monkeypatch.setenv("GELCONE_CACHE", str(tmp_path))
    setting = Setting.read({"device": device, "values": values})
    with disk_cache.heard(lambda kind: pytest.fail(f"made {kind}") if kind == disk_cache.MEMBRANES else nullcontext()):
        subject, found, stands = shelf.at_once(
            setting, lambda subject: [film.film.name for film in subject.model.system.films]
        )
    assert stands == (values["film"] == "membrane")
    if not stands:
        return
    cones = values | {"film": "wrinkling", "second_film": subject.device.second_film}
    assert subject.device.to_toml() == base.replace(cones).to_toml()
    assert set(found) == {"wrinkling"}
    assert next(one.value for one in shelf.controls(setting) if one.name == "film") == "membrane"


def test_what_is_made_or_is_no_membrane_needs_no_stand_in(shelf, tmp_path, monkeypatch):
    monkeypatch.setenv("GELCONE_CACHE", "")  # all is made at once
    made = []
    monkeypatch.setattr("gelcone.membrane.made.table", lambda gel, ratio: made.append(1) or dict.fromkeys(names(), 1.0))
    monkeypatch.setattr(Shelf, "_begin", lambda self, key, texts: np.array([0.5, 0.0]))
    setting = Setting.read({"device": "biased-pump", "values": MEMBRANE})
    _, found, stands = shelf.at_once(setting, lambda subject: subject.model.film.name)
    assert (found, stands) == ("membrane", False)


def test_nothing_stands_for_what_is_no_membrane_though_it_takes_long_to_make(shelf):
    asked = []

    def compute(subject):
        asked.append(subject.model.film.name)
        if len(asked) == 1:
            raise disk_cache.Unmade("pull-in")
        return "found"

    setting = Setting(device="biased-pump", values={"film": "wrinkling"})
    assert shelf.at_once(setting, compute)[1:] == ("found", False)
    assert asked == ["wrinkling"] * 2


def test_a_setting_is_checked_before_a_cone_stands_for_its_membrane(shelf, tmp_path, monkeypatch):
    monkeypatch.setenv("GELCONE_CACHE", str(tmp_path))
    for values in ({"film": "membrane", "waveform": "evil:K"}, {"film": "membrane", "no_such": "1 mm"}):
        with pytest.raises(InputError):
            shelf.at_once(
                Setting.read({"device": "biased-pump", "values": values}), lambda subject: pytest.fail("read")
            )


@pytest.mark.parametrize("name", ["/etc/passwd", "../biased-pump", "biased-pump.toml", "", "no-such"])
def test_a_page_names_no_path(shelf, name, tmp_path, monkeypatch):
    (tmp_path / "biased-pump.toml").write_text(text_of())
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="is not a device"):
        shelf.subject(Setting.read({"device": name}))


def test_a_shipped_name_does_not_open_a_file_of_that_name(shelf, tmp_path, monkeypatch):
    (tmp_path / "biased-pump").write_text("broken")
    monkeypatch.chdir(tmp_path)
    assert shelf.subject(Setting.read({"device": "biased-pump"})).device.name == "biased pumping cone"


@pytest.mark.parametrize(
    "values",
    [
        {"film": "/tmp/film.json"},
        {"film": "tests.toys:PowerFilm"},
        {"material": "/etc/passwd"},
        {"material.law": "os:system"},
        {"voltage_amplitude": "1 V, 2 V"},
        {"voltage_amplitude": "0 V:1 V:3"},
        {"material.sources": "a:b"},
    ],
)
def test_no_value_names_a_file_a_module_or_several_values(shelf, values):
    with pytest.raises(InputError):
        shelf.subject(Setting.read({"device": "biased-pump", "values": values}))


@pytest.mark.parametrize("value", ["1 V, 2 V", "1 V:2 V:3", "1 V ", "mine.csv"])
def test_a_number_is_one_with_its_unit_and_nothing_behind(shelf, value):
    with pytest.raises(InputError, match="must be one number, with its unit"):
        shelf.check(Setting(device="biased-pump", values={"film": "taut", "voltage_amplitude": value}))


@pytest.mark.parametrize("bias", ["os:system", "spring+os:system", "weight+taut"])
def test_each_of_several_biases_is_a_choice(shelf, bias):
    with pytest.raises(InputError, match=f"^'{re.escape(bias)}' is not a bias; "):
        shelf.check(Setting(preset="base", values={"bias": bias}))
    shelf.check(Setting(preset="base", values={"bias": "spring+weight"}))


@pytest.mark.parametrize(("device", "has"), [("biased-pump", False), ("double-cone", True)])
def test_a_second_film_goes_back_to_none_where_the_device_has_none(shelf, device, has):
    setting = Setting(device=device, values={"film": "taut", "second_film": "taut"})
    choices = next(control.choices for control in shelf.controls(setting) if control.name == "second_film")
    assert (choices[0] == NONE) == (NONE in choices) == (not has)


@pytest.mark.parametrize(
    "given",
    [
        None,
        [],
        {},
        {"device": 1},
        {"device": "biased-pump", "preset": "base"},
        {"device": "biased-pump", "more": 1},
        {"device": "biased-pump", "values": []},
        {"device": "biased-pump", "values": {"frequency": 3}},
        {"device": "biased-pump", "values": {"frequency": "9" * 50}},
        {"file": "x" * 40_000},
        {"device": "biased-pump", "values": {str(k): "1" for k in range(100)}},
    ],
)
def test_what_is_no_setting_is_refused(given):
    with pytest.raises(InputError):
        Setting.read(given)


FILE_LINE = "#" + "x" * 499


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"device": "x" * 41}, "device: must be a text of at most 40 characters"),
        ({"preset": 3}, "preset: must be a text of at most 40 characters"),
        ({"file": "\n" * 30_001}, "file: must be a text of at most 30000 characters"),
        ({"file": FILE_LINE + "x"}, "file: has a line of more than 500 characters; break it into several"),
        ({"device": "a", "values": {str(k): "1" for k in range(61)}}, "values: must be at most 60 names and texts"),
        ({"device": "a", "values": {"b" * 50: "9" * 41}},
         f"{'b' * 40}: must be a number with its unit, or one of its choices"),
        ({"device": "a", "values": {"b": ""}}, "b: must be a number with its unit, or one of its choices"),
        ({"device": "a", "file": "b"}, "the setting must hold one of device, preset and file"),
        ({"values": {}}, "the setting must hold one of device, preset and file"),
        ({"device": "a", "more": 1}, "the setting must hold device, preset or file, and values"),
    ],
)  # fmt: skip
def test_what_is_beyond_a_bound_is_refused_in_full_words(given, message):
    with pytest.raises(InputError) as error:
        Setting.read(given)
    assert str(error.value) == message


@pytest.mark.parametrize(
    "given",
    [
        {"device": "x" * 40}, {"file": "\n" * 30_000}, {"file": FILE_LINE}, {"preset": "base", "device": None},
        {"device": "a", "values": {str(k): "1" for k in range(60)}}, {"device": "a", "values": {"b": "9" * 40}},
    ],
)  # fmt: skip
def test_what_is_at_a_bound_is_read(given):
    found = Setting.read(given)
    wanted = {name: value for name, value in given.items() if value is not None}
    assert {name: value for name, value in vars(found).items() if value} == wanted


@pytest.mark.parametrize(
    "text",
    [
        "a." * 14_000 + "a = 1",
        "x = {" + "a." * 14_000 + "a = 1}",
        "[" + "a." * 14_000 + "a]",
        "x = " + "[\n" * 14_000,
        "\n".join(f"k{i}" + ".a" * 240 + " = 1" for i in range(60)),
        "film_radius = [" + "1,\n" * 9_000 + "]",
    ],
)
def test_a_file_made_to_take_long_is_refused_at_once(shelf, text):
    began = time.process_time()
    with pytest.raises(InputError):
        shelf.subject(Setting.read({"file": text}))
    assert time.process_time() - began < 1.0


def test_an_error_of_a_file_names_its_line(shelf):
    text = text_of().replace('disc_radius = "8 mm"', 'disc_radius = "80 mm"')
    line = [row.partition(" ")[0] for row in text.splitlines()].index("disc_radius") + 1
    with pytest.raises(InputError, match=f"^the device file, line {line}: disc_radius = 80 mm"):
        shelf.subject(Setting.read({"file": text}))


def test_a_device_that_is_several_is_refused_by_the_name_of_its_field(shelf):
    text = text_of().replace('film_thickness = "0.2 mm"', 'film_thickness = ["0.2 mm", "0.3 mm"]')
    assert text != text_of()
    with pytest.raises(InputError, match="film_thickness: holds 2 values") as refused:
        shelf.subject(Setting.read({"file": text}))
    assert refused.value.field == "film_thickness"


# --- caches: every input once changed, against what is computed without ----------------------------------------------


def test_a_file_that_changes_is_read_again(tmp_path):
    given = tmp_path / "mine.toml"
    given.write_text(text_of())
    shelf, setting = Shelf(given), Setting(device="mine")
    more = Setting(device="mine", values={"film_thickness": "0.21 mm"})
    before, with_more = shelf.subject(setting), shelf.subject(more)
    source = Source(shelf.path(setting), None, {"settings": []})
    assert source.subject().model.parameters() == before.model.parameters()
    given.write_text(text_of().replace('initial_height = "20 mm"', 'initial_height = "19 mm"'))
    os.utime(given, ns=(1, 1))
    assert shelf.subject(setting).device.initial_height == source.subject().device.initial_height == 0.019
    assert shelf.subject(setting).initial != before.initial
    assert shelf.subject(more).device.initial_height == 0.019
    assert with_more.device.initial_height == 0.02
    value = next(control.value for control in shelf.controls(setting) if control.name == "initial_height")
    assert value == 19.0


def test_a_file_is_found_wherever_the_studio_goes(tmp_path, monkeypatch):
    (tmp_path / "mine.toml").write_text(text_of())
    monkeypatch.chdir(tmp_path)
    shelf = Shelf(Path("mine.toml"))
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert shelf.path(Setting(device="mine")).read_text() == text_of()
    assert shelf.called(Setting(device="mine")) == "mine.toml"


def test_a_file_that_is_gone_is_said_to_be(tmp_path):
    given = tmp_path / "mine.toml"
    given.write_text(text_of())
    shelf = Shelf(given)
    given.unlink()
    with pytest.raises(InputError, match="there is no such file"):
        shelf.subject(Setting(device="mine"))


PUMP = Setting(device="biased-pump", values={"film": "taut"})
"""Of a film without a membrane: one of every other geometry takes seconds."""


@pytest.mark.parametrize("base", [PUMP, Setting(preset="base")], ids=["device", "preset"])
def test_every_control_sets_what_the_command_line_sets(shelf, base):
    controls = [control for control in shelf.controls(base) if control.kind == "number"]
    assert len(controls) >= 10
    shelf.subject(base)
    for control in controls:
        usual = control.high / 2 if control.value is None else control.value
        text = f"{1.01 * usual + 0.001 * (control.high - control.low):.6g} {control.unit}".strip()
        setting = Setting.read({**given_by(base), "values": {**base.values, control.name: text}})
        found, expected = shelf.subject(setting), read_subject(base.device, **typed(setting))
        assert found.model.parameters() == expected.model.parameters(), control.name
        np.testing.assert_allclose(found.initial, expected.initial, rtol=1e-12, err_msg=control.name)
        plain = shelf.subject(base)
        assert (found.model.parameters(), found.initial) != (plain.model.parameters(), plain.initial), control.name


def given_by(setting):
    return {name: value for name in ("device", "preset") if (value := getattr(setting, name))}


def test_every_choice_sets_what_the_command_line_sets(shelf):
    for base in (PUMP, Setting(preset="base")):
        for control in shelf.controls(base):
            for choice in control.choices:
                if choice == NONE:  # which the page takes back and does not send
                    continue
                setting = Setting.read({**given_by(base), "values": {**base.values, control.name: choice}})
                expected = read_subject(base.device, **typed(setting))
                assert shelf.subject(setting).model.parameters() == expected.model.parameters(), (control.name, choice)


def test_a_start_takes_what_is_not_given_from_the_preset(shelf):
    for values, initial in (({"displacement": "0.5"}, (0.5, 0.0)), ({"velocity": "0.5"}, (1.0, 0.5))):
        assert shelf.subject(Setting(preset="base", values=values)).initial == initial
    assert typed(Setting(preset="base", values={"displacement": "0.5", "velocity": "-1"}))["initial"] == "0.5,-1"
    assert "initial" not in typed(Setting(device="biased-pump"))


def test_what_a_device_is_called_on_the_command_line(tmp_path):
    given = tmp_path / "mine.toml"
    given.write_text(text_of())
    shelf = Shelf(given)
    assert shelf.called(Setting(device="mine")) == str(given)
    assert shelf.called(Setting(device="biased-pump")) == "biased-pump"
    assert shelf.called(Setting(file=text_of())) == "device.toml"
    assert shelf.called(Setting(preset="base")) == ""
    assert shelf.path(Setting(device="mine")) == given
    assert shelf.path(Setting(preset="base")) is shelf.path(Setting(file=text_of())) is None


def test_choices_alone_say_which_controls_there_are():
    setting = Setting(preset="base", values={"law": "yeoh", "voltage": "1", "film": "taut"})
    assert setting.chosen == Setting(preset="base", values={"law": "yeoh", "film": "taut"})
    assert setting.base == Setting(preset="base")
    device = Setting(device="soft-film", values={"material.law": "yeoh", "material.shear_modulus": "9 kPa"})
    assert device.chosen.values == {"material.law": "yeoh"}


def test_what_a_shelf_stores_is_bounded():
    full = dict.fromkeys(range(module.MOST_KEPT))
    assert module._bounded(full) is full
    assert full == {}
    some = dict.fromkeys(range(module.MOST_KEPT - 1))
    assert len(module._bounded(some)) == module.MOST_KEPT - 1


@pytest.mark.parametrize(("patient", "times"), [(True, 1), (False, 2)])
def test_the_patient_wait_for_what_takes_long_to_make(shelf, tmp_path, monkeypatch, patient, times):
    """The others are refused it first, and get it in the end where nothing can stand for it."""
    monkeypatch.setenv("GELCONE_CACHE", str(tmp_path))
    asked = []

    def compute(subject):
        asked.append(subject)
        return disk_cache.made("what takes long", 1, bytes, ())

    assert shelf.at_once(PUMP, compute, patient=patient)[1:] == (b"", False)
    assert len(asked) == times


@pytest.mark.parametrize(
    ("field", "name"),
    [
        ("film", "PowerFilm"), ("bias", "CubicBias"), ("waveform", "ThreeHarmonics"), ("circuit", "FilteredVoltage"),
        ("circuit", None),
    ],
)  # fmt: skip
def test_the_names_of_a_device_are_those_of_its_components_that_do_not_ship(field, name):
    device = find_device("biased-pump").replace(film="taut")
    own = {} if name is None else {field: f"tests.toys:{name}"}
    if field == "film":
        own |= {"meridional_prestretch": None, "hoop_prestretch": None}
    found = module.names_in(device.replace(own))
    assert {one for one in found if not one.startswith("{")} == {text for text in own.values() if text is not None}


# --- rests that continue the last one ---------------------------------------------------------------------------------


@pytest.mark.parametrize("device", sorted(shipped_devices()))
def test_a_rest_under_the_hand_is_that_of_a_search_without_one(shelf, device, monkeypatch):
    base = Setting(device=device)
    control = next(c for c in shelf.controls(base) if c.name == "spring_rate")
    value = control.value or 0.05 * control.high
    shelf.subject(base)
    monkeypatch.setattr("gelcone.physics.statics.every_balance", lambda *given: pytest.fail("searched"))
    settings = [Setting(device=device, values={"spring_rate": f"{s * value:.6g} N/m"}) for s in (1.01, 1.03, 1.06)]
    found = [shelf.subject(own) for own in settings]
    monkeypatch.undo()
    for given, own in zip(settings, found, strict=True):
        expected = read_subject(device, **typed(given))
        np.testing.assert_allclose(own.initial, expected.initial, rtol=1e-10, atol=1e-12)
        numbers = [model.parameters() for model in (own.model, expected.model)]
        one, other = ({n: v for n, v in some.items() if isinstance(v, float)} for some in numbers)
        assert one == pytest.approx(other, rel=1e-10)


def test_a_rest_that_a_search_finds_elsewhere_takes_the_place_of_the_guess(shelf):
    above, below = (Setting(device="snap-cone", values={"initial_height": f"{h} mm"}) for h in (2, -2))
    first = shelf.subject(above).initial[0]
    assert shelf.subject(below).initial[0] == pytest.approx(first)  # it stays in its well
    keys = shelf.guesses(below)
    found = find_rests(Source(shelf.path(below), None, typed(below)), list(keys))
    assert keys
    assert keys.keys() == found.keys()
    assert shelf.confirm(below, found) == pytest.approx(2.0 * first)
    assert shelf.subject(below).initial[0] == read_subject("snap-cone", **typed(below)).initial[0] < 0.0
    assert shelf.guesses(below) == {}
    assert shelf.confirm(below, {}) == 0.0


def test_rests_that_a_search_found_are_taken_over_from_the_process_that_found_them(shelf, monkeypatch):
    kept = []
    monkeypatch.setattr(module, "store_rests", kept.append)
    assert shelf.confirm(PUMP, {"key": 0.5}) == 0.0
    assert kept == [{"key": 0.5}]


def test_the_next_rest_continues_the_one_that_a_search_found(shelf):
    """Not the one in the well that the disc has left."""
    above, below, lower = (
        Setting(device="snap-cone", values={"initial_height": f"{h} mm"}) for h in (2.2, -2.2, -2.22)
    )
    shelf.subject(above)
    shelf.subject(below)
    shelf.confirm(below, find_rests(Source(shelf.path(below), None, typed(below)), list(shelf.guesses(below))))
    assert shelf.subject(lower).initial[0] == pytest.approx(read_subject("snap-cone", **typed(lower)).initial[0])


def test_a_rest_far_away_is_searched_for(shelf):
    shelf.subject(Setting(device="biased-pump"))
    far = Setting(device="biased-pump", values={"initial_height": "40 mm"})
    assert shelf.subject(far).initial == read_subject("biased-pump", **typed(far)).initial
    assert shelf.guesses(far) == {}
