"""Presets: the numbers of the paper's table, and `--preset` on the command line."""

import json
from dataclasses import replace

import pytest
from click.testing import CliRunner

from gelcone.cli import group
from gelcone.errors import InputError
from gelcone.presets import find_preset, load_presets

# Name -> drive frequency, spring stiffness, damping ratio as the project's table gives them; None: not in it.
TABLE = {
    "table1": (None, 1.5, None),
    "base": (0.1, 0.9, 0.01),
    "fast": (0.3, 0.5, 0.01),
    "spring": (None, None, 0.05),
}


def simulate(*arguments):
    """Exit code, or the error that the command line prints in one line, and the output."""
    result = CliRunner().invoke(group, ["simulate", "--periods", "2", *arguments])
    return (result.exception if isinstance(result.exception, InputError) else result.exit_code), result.output


@pytest.mark.parametrize("name", load_presets())
def test_presets_give_models_with_the_numbers_of_the_table(name):
    preset = find_preset(name)
    model = preset.model
    assert name in TABLE
    for parameter, expected in zip(("drive_frequency", "spring_stiffness", "damping_ratio"), TABLE[name], strict=True):
        assert expected is None or getattr(model, parameter) == expected
    assert (model.stretch_limit, model.prestretch, model.shape) == (50.0, 1.0, ())
    assert model.rest_height == (0.1 if name == "spring" else 0.0)
    assert preset.initial == (1.0, 0.0)


@pytest.mark.parametrize("name", load_presets())
def test_each_number_is_either_from_the_text_or_reconstructed(name):
    preset = find_preset(name)
    assert not preset.text.keys() & preset.reconstructed.keys()
    assert {"stretch_limit", "prestretch"} <= preset.text.keys()
    needed = {"spring_stiffness", "damping_ratio", "voltage", "drive_frequency", "stretch_limit", "rest_height"}
    assert needed <= preset.text.keys() | preset.reconstructed.keys()
    assert preset.purpose


def test_a_claim_is_judged_with_another_film_on_the_same_numbers():
    taut = find_preset("base")
    other = replace(taut, changes={"film": "wrinkling", "voltage": 0.25}).model
    numbers = taut.model.parameters() | {"film": "wrinkling", "voltage": 0.25}
    assert {name: other.parameters()[name] for name in numbers} == numbers
    assert (taut.model.system.film.name, other.system.film.name) == ("taut", "wrinkling")


def test_an_unknown_preset_suggests_the_near_one():
    with pytest.raises(InputError, match=r"^'bas' is not a preset of the paper; did you mean 'base'\?$"):
        find_preset("bas")


def test_simulate_starts_from_a_preset_and_settings_replace_its_numbers():
    code, output = simulate("--preset", "base", "--set", "voltage=1.04", "--json")
    result = json.loads(output)
    assert code == 0
    assert result["parameters"] == find_preset("base").model.replace(voltage=1.04).parameters()
    assert result["subject"]["initial"] == [1.0, 0.0]
    assert (result["result"]["displacement"][0], result["outcome"]) == (1.0, "ok")


def test_initial_and_the_other_prestretch_replace_those_of_a_preset():
    code, output = simulate("--preset", "fast", "--initial", "0.5,0.1", "--set", "hoop_prestretch=1.2", "--json")
    result = json.loads(output)
    assert code == 0
    assert (result["subject"]["initial"], result["parameters"]["hoop_prestretch"]) == ([0.5, 0.1], 1.2)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--preset", "fsat"], "'fsat' is not a preset of the paper; did you mean 'fast'?"),
        (
            ["paper-table1", "--preset", "base"],
            "--preset base and the device 'paper-table1' are both given; give one or the other",
        ),
    ],
)
def test_a_preset_that_cannot_be_used_is_refused_in_one_line(arguments, message):
    error, output = simulate(*arguments)
    assert (str(error), output) == (message, "")


def test_a_preset_is_forgotten_after_its_command():
    simulate("--preset", "fast")
    _, output = simulate("--json")
    assert json.loads(output)["parameters"]["drive_frequency"] == 1.0


@pytest.mark.parametrize("command", ["simulate", "section", "spectrum"])
def test_help_names_every_preset(command):
    output = " ".join(CliRunner().invoke(group, [command, "--help"]).output.split())
    assert "--preset NAME" in output
    assert all(name in output for name in load_presets())
