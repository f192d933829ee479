"""Options that belong together: what a recording of the drive sets is not set a second time."""

import re

import pytest

from gelcone.cli import options
from gelcone.cli.options import subject_parameters
from gelcone.devices.device import find_device
from gelcone.physics.records import FILMS
from gelcone.presets import load_presets
from gelcone.register import analyses
from tests.answers import answer

RECORDING = "time (s),voltage (V)\n0,0\n0.1,100\n0.2,0\n"


@pytest.mark.parametrize(
    ("subject", "setting"),
    [
        *((["biased-pump"], own) for own in ("voltage_amplitude=1 V", "voltage_offset=1 V", "frequency=9 Hz")),
        (["biased-pump"], "waveform=square"),
        *((["--preset", "base"], own) for own in ("voltage=1", "voltage_bias=0.1", "drive_frequency=0.3")),
    ],
)
def test_what_a_recording_sets_is_set_once(subject, setting, command_line, tmp_path):
    (tmp_path / "drive.csv").write_text(RECORDING.replace(" (s)", "").replace(" (V)", "") if subject[1:] else RECORDING)
    code, _, err = command_line("simulate", *subject, "--drive", "drive.csv", "--set", setting)
    name = setting.partition("=")[0]
    assert code == 2
    assert f"--set {name}: the recording of --drive sets it; leave it out, or give --drive-scale" in err


def test_options_of_a_recording_need_one(command_line):
    code, _, err = command_line("simulate", "biased-pump", "--drive-scale", "2")
    assert code == 2
    assert "--drive-scale: there is no --drive; name a CSV file" in err


def test_what_was_interpreted_in_a_recording_is_a_warning_and_in_the_json(command_line, tmp_path):
    (tmp_path / "drive.csv").write_text(RECORDING.replace(",", ";"))
    typed = ("simulate", "biased-pump", "--film", "taut", "--drive", "drive.csv", "--over", "time=1 ms,2 ms", "--json")
    code, out, err = command_line(*typed)
    found = answer(out)["warnings"]
    assert (code, err) == (0, "".join(f"Warning: {line}\n" for line in found))
    assert found == ["drive.csv: cells are separated by semicolons"]
    assert answer(command_line("devices", "--json")[1])["warnings"] == []


@pytest.mark.parametrize("command", [name for name, own in analyses.COMMANDS.items() if own in analyses.ANALYSES])
def test_the_help_of_an_analysis_says_what_a_device_is_and_names_no_function_of_python(command, command_line):
    text = " ".join(command_line(command, "--help")[1].split())
    assert ("[DEVICE]" in text) == ("DEVICE is a device file (`gelcone init` writes one)" in text)
    assert "continue_branch" not in text
    assert "shape (" not in text


def test_the_help_names_every_preset_and_film():
    preset, film = (next(o for o in subject_parameters() if o.name == name) for name in ("preset", "film"))
    named = re.fullmatch(r"Start from a parameter set of the source paper: (.*) or (\w+)\.", preset.help).groups()
    assert [*named[0].split(", "), named[1]] == list(load_presets())
    assert sorted(film.metavar.split("|")) == sorted(FILMS)


def test_a_device_that_a_recording_drives_is_the_one_that_is_answered_for(tmp_path):
    """Also where the device itself is computed on, or its fields are printed, and not the model."""
    (tmp_path / "drive.csv").write_text(RECORDING)
    given = dict.fromkeys(options.SUBJECT) | {"device": "biased-pump", "film": "taut", "settings": ()}
    subject = options.subject_of(given | {"recording": tmp_path / "drive.csv", "drive_scale": 2.0})
    assert subject.device.waveform == "samples"
    assert subject.device.voltage_amplitude == pytest.approx(2.0 * 100.0)
    assert subject.device.to_model().parameters() == subject.model.parameters()
    assert subject.device.spring_rate == find_device("biased-pump").spring_rate


@pytest.mark.parametrize("empty", ["", " "])
def test_a_place_without_a_name_is_refused(empty, command_line):
    code, _, err = command_line("limits", "--out", empty)
    assert (code, err) == (
        2,
        "Error: Invalid value for '--out': is empty; name a file or folder; see gelcone limits --help\n",
    )


def test_a_default_is_called_dimensionless_where_the_option_has_a_unit_with_a_device():
    for own in set(analyses.COMMANDS.values()) & set(analyses.ANALYSES):
        for option in analyses.find_analysis(own).options.values():
            said = "dimensionless]" in options._help(option)
            assert said == bool(option.quantity and option.default is not None), (own, option.name)


def test_a_default_is_said_as_it_would_be_typed():
    said = {}
    for own in set(analyses.COMMANDS.values()):
        for option in analyses.find_analysis(own).options.values():
            if found := re.search(r"\[default: (.*?)(, dimensionless)?\]$", options._help(option)):
                given = option.default if isinstance(option.default, list | tuple) else [option.default]
                if option.default is None:
                    assert found[1] == option.unset
                elif all(isinstance(one, float) for one in given):
                    assert [float(one) for one in found[1].split(",")] == pytest.approx(given, rel=1e-5)
                else:
                    assert found[1] == ",".join(map(str, given))
                said[own, option.name] = found[1]
            else:
                assert not any((option.default, option.unset))
    assert said["bifurcation", "sweeps"] == "up,down"
