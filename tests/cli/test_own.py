"""First files and help: each subject gives its own text, and each file that of its kind."""

import inspect
import re

import click
import pytest

import gelcone
from gelcone import glossary
from gelcone.cli import group, own
from gelcone.cli.grids import COARSEST
from gelcone.devices.device import Device
from gelcone.devices.template import field_help, field_table, first_file, unit_table
from gelcone.export.fmu import VERSIONS
from gelcone.export.public import TOLERANCE
from gelcone.lab.device_tests import FIRST_TESTS
from gelcone.lab.wish import FIRST_WISH
from gelcone.paper import run
from gelcone.physics.film.branches import MOST_BRANCHES
from gelcone.physics.laws import LAWS


def test_a_first_file_holds_the_numbers_of_the_pump_under_its_own_name(command_line, tmp_path):
    pump = gelcone.find_device(own.START)
    for flags, then, text in (
        ((), "simulate mine.toml", first_file("mine.toml", pump, pump.material)),
        (("--wish",), "design mine.toml --out designs", FIRST_WISH.format(file="mine.toml")),
        (
            ("--tests",),
            "fit DEVICE --data mine.toml --free spring_rate~3% --plan",
            FIRST_TESTS.format(file="mine.toml"),
        ),
    ):
        said = f"wrote mine.toml: change its numbers, then `gelcone {then}`\n"
        assert command_line("init", "mine.toml", *flags) == (0, said, "")
        assert (tmp_path / "mine.toml").read_text(encoding="utf-8") == text
        (tmp_path / "mine.toml").unlink()
    assert own.START == "biased-pump"
    code, out, err = command_line("init", "mine.toml", "--wish", "--tests")
    assert (code, out, err) == (2, "", "Error: --wish and --tests: give one of them\n")
    assert list(tmp_path.iterdir()) == []


def test_a_first_file_is_written_over_another_by_force_alone(command_line, tmp_path):
    (tmp_path / "mine.toml").write_text("mine")
    for flags in ((), ("--wish",), ("--tests",)):
        code, out, err = command_line("init", "mine.toml", *flags)
        assert (code, out) == (2, "")
        assert err.startswith("Error: mine.toml: exists already; choose another name, or overwrite it with force")
        assert (tmp_path / "mine.toml").read_text() == "mine"
        assert command_line("init", "mine.toml", *flags, "--force")[0] == 0
        assert (tmp_path / "mine.toml").read_text() != "mine"
        (tmp_path / "mine.toml").write_text("mine")


def test_help_gives_each_subject_its_own_text(command_line):
    names = ("film", "frequency", "regime", "settled", "drive")
    of_commands = {name: command_line(name, "--help")[1].rstrip("\n") for name in names}
    texts = {
        "device": field_table(Device.fields),
        "units": unit_table(),
        "glossary": "\n".join(map(glossary.explain, glossary.GLOSSARY)),
        "kick": glossary.explain("kick"),
        "pull-in": f"{glossary.explain('pull-in')}\n\n{field_help(Device.fields, 'pull_in')}",
        "film": f"{field_help(Device.fields, 'film')}\n\n{of_commands['film']}",
        "frequency": f"{field_help(Device.fields, 'frequency')}\n\n{of_commands['frequency']}",
        "regime": f"{glossary.explain('regime')}\n\n{of_commands['regime']}",
        "settled": f"{glossary.explain('settled')}\n\n{of_commands['settled']}",
        "spring_rate": field_help(Device.fields, "spring_rate"),
        "spring-rate": field_help(Device.fields, "spring_rate"),
        "voltage": field_help(Device.fields, "voltage_amplitude"),
        "Q factor": field_help(Device.fields, "quality_factor"),
        "drive": of_commands["drive"],
        "DEVICE": field_table(Device.fields),
        "operating-limits": command_line("operating-limits", "--help")[1].rstrip("\n"),
        "operating_limits": command_line("operating-limits", "--help")[1].rstrip("\n"),
    }
    assert len(set(texts.values())) == len(texts) - 3
    for topic, text in texts.items():
        assert command_line("help", topic) == (0, f"{text}\n", ""), topic
    assert command_line("help")[1] == command_line("--help")[1]


@pytest.mark.parametrize(
    "near",
    [
        ("devize", "device"),
        ("unitz", "units"),
        ("glosary", "glossary"),
        ("sprng_rat", "spring_rate"),
        ("simulat", "simulate"),
        ("amplitute", "amplitude"),
    ],
)
def test_help_suggests_what_there_is(near, command_line):
    code, _, err = command_line("help", near[0])
    assert (code, err) == (2, f"Error: {near[0]!r} is not a subject of help; did you mean {near[1]!r}?\n")


def test_help_on_nothing_that_is_known_says_where_the_terms_are(command_line):
    code, _, err = command_line("help", "zzz")
    assert (code, err) == (2, "Error: 'zzz' is not a subject of help; `gelcone help glossary` lists the terms\n")
    for term in ("displacement", "height", "equilibrium"):
        assert command_line("help", term) == (0, f"{glossary.explain(term)}\n", "")


DEFAULTS = {
    ("studio", "--port"): "a free one",
    ("studio", "--host"): "127.0.0.1",
    ("paper", "--out"): "paper-results, with --quick paper-results-quick",
    ("fit", "--laws"): "all: gent,neo-hookean,yeoh",
    ("fit", "--branches"): "0,1,2,3,4",
    ("fit", "--flow"): "log",
    ("fit", "--draws"): "60",
    ("fit", "--seed"): "0",
    ("design", "--seed"): "0",
    ("measured", "--seed"): "0",
    ("export", "--fmi"): "2",
    ("export", "--tolerance"): "1e-07, which leaves about 1e-9 of the stroke",
    ("map", "--coarsest"): "64",
    ("map", "--colour"): "exponent",
    ("sweep", "--analysis"): "regime",
    ("sweep", "--indices"): "indices",
    ("sweep", "--count"): "64",
    ("sweep", "--method"): "sobol",
    ("sweep", "--workers"): "one a core for 1,024 cells or more, else threads",
    ("datasheet", "--count"): "64",
    ("datasheet", "--seed"): "0",
}
"""Defaults that are said in help; those of the options of analyses are compared with their functions elsewhere."""


@pytest.mark.parametrize(("command", "option"), DEFAULTS)
def test_help_states_the_default_of_an_option(command, option):
    context = click.Context(group)
    made = group.get_command(context, command)
    (own_,) = (parameter for parameter in made.params if option in parameter.opts)
    (text,) = re.findall(r"\[default: ([^\];]+)", own_.get_help_record(click.Context(made))[1])
    assert text == DEFAULTS[command, option]


def test_the_defaults_that_help_says_in_words_are_those_that_are_taken():
    fitted = inspect.signature(gelcone.fit_material).parameters
    assert (VERSIONS[0], TOLERANCE, COARSEST) == (2, 1e-7, 64)  # with these `export` asks its writers by default
    assert (fitted["laws"].default, fitted["branches"].default) == (None, None)
    assert (sorted(LAWS), MOST_BRANCHES) == (["gent", "neo-hookean", "yeoh"], 3)
    assert {name: str(folder) for name, folder in run.FOLDERS.items()} == {
        run.FULL.name: "paper-results", run.QUICK.name: "paper-results-quick",
    }  # fmt: skip


# --- how words and options are taken ----------------------------------------------------------------------------------

ARGUMENTS = {
    "design": ("wish", True, 1), "measured": ("pages", True, -1), "export": ("what", True, 1),
    "init": ("file", True, 1), "show": ("place", True, 1), "fit": ("subject", False, 1), "paper": ("names", False, -1),
    "help": ("topic", False, 1), "studio": ("device", False, 1), "devices": ("name", False, 1),
    "map": ("device", False, 1), "sweep": ("device", False, 1), "continue": ("words", False, -1),
    "simulate": ("device", False, 1),
}  # fmt: skip
BOUNDS = {("design", "seed"): (0, 2**31), ("measured", "seed"): (0, 2**31), ("studio", "port"): (0, 65535)}
REPEATED = {
    "fit": {"data", "free", "profile", "predict"}, "map": {"settings", "over"},
    "sweep": {"settings", "over", "uncertain", "keep"}, "datasheet": {"settings", "over", "uncertain"},
    "export": {"settings"}, "simulate": {"settings", "over"}, "frequency": {"settings", "over"},
    "design": set(), "measured": set(), "paper": set(),
}  # fmt: skip
FLAGS = {
    "fit": {"plan"}, "map": {"uniform"}, "sweep": {"indices", "at_once"}, "design": {"nominal"}, "paper": {"quick"},
    "init": {"wish", "tests"}, "studio": {"no_browser"}, "export": set(), "measured": set(),
}  # fmt: skip


def parameters(command):
    return group.get_command(click.Context(group), command).params


@pytest.mark.parametrize("command", ARGUMENTS)
def test_a_command_takes_as_many_words_as_it_needs(command):
    first, *more = (own_ for own_ in parameters(command) if isinstance(own_, click.Argument))
    assert (first.name, first.required, first.nargs) == ARGUMENTS[command]
    assert [(own_.name, own_.required) for own_ in more] == ([("place", False)] if command == "export" else [])


def test_whole_numbers_have_their_bounds():
    for command in ("design", "measured", "studio", "fit", "map", "sweep", "datasheet", "export"):
        for own_ in parameters(command):
            bounds = (own_.type.min, own_.type.max) if isinstance(own_.type, click.IntRange) else None
            assert bounds == BOUNDS.get((command, own_.name)), (command, own_.name)


@pytest.mark.parametrize("command", {**REPEATED, **FLAGS})
def test_an_option_is_repeated_or_a_flag_where_it_should_be(command):
    options = [own_ for own_ in parameters(command) if isinstance(own_, click.Option)]
    if command in REPEATED:
        assert {own_.name for own_ in options if own_.multiple} == REPEATED[command]
    if command in FLAGS:
        flags = {own_.name for own_ in options if own_.is_flag} - {"force", "as_json", "threads"}
        assert flags == FLAGS[command]


def test_what_is_missing_is_said(command_line):
    for command, word in (("measured", "PAGE"), ("design", "WISH"), ("init", "FILE"), ("show", "STORE")):
        code, _, err = command_line(command)
        assert code == 2
        assert err.startswith("Error: Missing argument")
        assert word in err
        assert f"see gelcone {command} --help" in err
