"""How the command line ends and warns: an exit code and a line for each kind of error."""

import re
import sys
import warnings

import click
import pytest

import gelcone
from gelcone import cli
from gelcone.cli import COMMANDS, OWN_COMMANDS, QUIET, SPECIAL
from gelcone.cli.options import Place
from gelcone.errors import DoubtfulInput, InputError, LostWorker, MissingDependency
from gelcone.register.analyses import ANALYSES
from gelcone.register.analyses import COMMANDS as REGISTERED


@pytest.fixture
def ended(monkeypatch, capsys):
    """Runs the command line where its commands raise or give something: exit code and standard error."""

    def of(result):
        def command(prog_name, standalone_mode):
            assert (prog_name, standalone_mode) == ("gelcone", False)
            if callable(result):
                return result()
            if isinstance(result, BaseException):
                raise result
            return result

        monkeypatch.setattr(sys, "path", list(sys.path))
        monkeypatch.setattr(cli.group, "main", command)
        with warnings.catch_warnings(), pytest.raises(SystemExit) as left:
            cli.main()
        assert sys.path[-1] == ""
        return left.value.code, capsys.readouterr().err

    return of


@pytest.mark.parametrize(
    ("result", "code", "said"),
    [
        (None, 0, ""),
        (0, 0, ""),
        (1, 1, ""),
        ("done", 0, ""),
        (InputError("a = 1: must be 2\n  and   b, too"), 2, "Error: a = 1: must be 2\nError: and b, too\n"),
        (click.UsageError("No such option."), 2, "Error: No such option; see gelcone --help\n"),
        (click.ClickException("lost"), 1, "Error: lost\n"),
        (MissingDependency("pip install it"), 1, "Error: pip install it\n"),
        (OSError("disk full"), 1, "Error: disk full\n"),
        (MemoryError(), 1, "Error: out of memory; use fewer members or samples\n"),
        (click.Abort(), 130, "interrupted\n"),
        (KeyboardInterrupt(), 130, "interrupted\n"),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, BaseException) else None,
)
def test_every_ending_has_its_code_and_line(result, code, said, ended):
    assert ended(result) == (code, said)


def test_a_wrong_option_leads_to_the_help_of_its_command(command_line):
    code, _, said = command_line("static", "--no-such-thing", "1")
    assert code == 2
    assert re.fullmatch(r"Error: No such option:? '?--no-such-thing'?; see gelcone static --help\n", said)


@pytest.mark.parametrize("option", ["--over", "--uncertain"])
def test_an_option_of_grids_leads_to_the_command_that_takes_it(option, command_line):
    _, _, said = command_line("settled", option, "voltage=1:2:3")
    assert re.fullmatch(rf"Error: No such option.*{option}.*; gelcone sweep --analysis settled takes it\n", said)
    _, _, said = command_line("section", option, "voltage=1:2:3")
    other = "see gelcone section --help" if option == "--over" else "gelcone datasheet and sweep take it"
    assert said.endswith(f"; {other}\n")


def test_draws_are_given_as_a_table_where_distributions_are_not_taken(command_line):
    _, _, said = command_line("envelope", "--uncertain", "damping_ratio=0.1:0.2")
    assert said == "Error: No such option '--uncertain'; give a table of draws, --samples FILE\n"


def test_an_option_of_some_commands_leads_to_all_that_take_it(command_line):
    _, _, said = command_line("section", "--samples", "draws.csv")
    names = re.fullmatch(r"Error: No such option '--samples'; gelcone (.*) take it\n", said)[1]
    takers = set(re.split(", | and ", names))
    assert {"sweep", "datasheet", "envelope", "limits", "frequency"} <= takers
    for name in COMMANDS:
        own = command_line(name, "--samples")[2]
        assert (name in takers) == ("'--samples' requires an argument" in own), own


def test_doubts_are_said_once_as_they_were_typed_and_lost_workers_every_time(ended, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["gelcone", "limits", "--a", "3 m"])

    def doubtful():
        for _ in range(2):
            warnings.warn("a = 3: is\n   unusual", DoubtfulInput, stacklevel=1)
            warnings.warn("worker lost", LostWorker, stacklevel=1)
            warnings.showwarning(RuntimeWarning("divide by zero encountered in divide"), RuntimeWarning, "numpy.py", 1)

    lines = ["Warning: --a '3 m': is unusual", "Warning: worker lost", "Warning: worker lost"]
    assert ended(doubtful) == (0, "".join(f"{line}\n" for line in lines))


def test_every_command_is_listed_with_its_own_line():
    assert set(COMMANDS) == {*REGISTERED, *OWN_COMMANDS}
    for name, analysis in REGISTERED.items():
        assert COMMANDS[name] == ANALYSES.summaries[analysis]
    context = click.Context(cli.group)
    for name in COMMANDS:
        command = cli.group.get_command(context, name)
        assert command.name == name
        assert command.callback is not None
    assert cli.group.get_command(context, "simulat") is None
    assert set(SPECIAL) <= set(REGISTERED)
    shown = cli.group.get_help(context)
    for title, names in cli.SECTIONS.items():
        part = shown.split(f"{title}:\n")[1].split("\n\n")[0]
        first = [line.split()[0] for line in part.splitlines() if line[2:3].strip()]
        assert first == names.split()


@pytest.mark.parametrize("name", COMMANDS)
def test_placeholders_are_words_in_capitals_or_those_to_type_and_a_place_is_one(name):
    places = {"FILE", "STORE", "DIR", "CSV", "PAGE", "WISH", "nc", "toml"}
    for parameter in cli.group.get_command(click.Context(cli.group), name).params:
        words = [word for word in re.split(r"[|=~, .\[\]]+", parameter.metavar or "") if word]
        assert all(re.fullmatch("[A-Z]+|[a-z]+", word) for word in words), parameter.metavar
        if isinstance(parameter.type, Place):
            assert places.issuperset(words), parameter.metavar


def test_the_list_of_commands_says_which_one_answers_how_high_the_voltage_may_go():
    assert "constant voltage" in COMMANDS["limits"]
    assert "own frequency" in COMMANDS["operating-limits"]
    assert "every frequency" in COMMANDS["envelope"]
    assert all(COMMANDS[name].startswith("How high") for name in ("limits", "operating-limits", "envelope"))
    assert "largest" in COMMANDS["drive"]


@pytest.mark.parametrize("name", ["studio", "paper", "devices"])
def test_commands_that_say_themselves_what_one_waits_for_are_left_to_it(name, monkeypatch):
    from contextlib import contextmanager

    heard = []

    @contextmanager
    def said_before(command):
        heard.append(command)
        yield

    monkeypatch.setattr(cli, "said_before", said_before)
    command = click.Command(name, callback=lambda: heard.append("ran"))
    monkeypatch.setattr(cli.LazyGroup, "get_command", lambda self, context, own: command)
    cli.group.main([name], standalone_mode=False)
    assert heard == (["ran"] if name in QUIET else [name, "ran"])
    assert QUIET == ("studio", "paper")


def test_without_a_command_the_help_is_shown(command_line):
    code, out, err = command_line()
    assert (code, err) == (0, "")
    assert out == command_line("--help")[1]
    assert command_line("-h")[1] == out
    assert command_line("--version")[1] == f"gelcone, version {gelcone.__version__}\n"


def test_an_unknown_command_suggests_the_nearest(command_line):
    assert command_line("simulat")[::2] == (2, "Error: 'simulat' is not a command; did you mean 'simulate'?\n")


@pytest.mark.parametrize(
    ("typed", "message", "said"),
    [
        ("envelope --margin 2", "margin = 2.0: must be below 1", "--margin 2: must be below 1"),
        ("envelope --margin=2", "margin = 2.0: must be below 1", "--margin 2: must be below 1"),
        (
            "drive --lowest-frequency=5;Hz",
            "lowest_frequency = 5.0: must increase",
            "--lowest-frequency '5 Hz': must increase",
        ),
        (
            "drive --lowest-frequency= 5",
            "lowest_frequency = 0.0: must increase",
            "--lowest-frequency '': must increase",
        ),
        (
            "drive --lowest-frequency 5",
            "lowest_frequency: is given alone; give both ends of the frequencies",
            "--lowest-frequency: is given alone; give both ends of the frequencies",
        ),
        ("section --discard-time 1", "discard_time = 1.0: ends late", "--discard-time 1: ends late"),
        ("fit --free a~3% --free b", "free b = 0: is small", "--free b = 0: is small"),
        ("fit --predict x@1", "predict 'x@1': takes no voltage", "--predict 'x@1': takes no voltage"),
        ("fit --free a --free b", "free = 3: is few", "--free = 3: is few"),
        ("fit --profile mass", "profile: 'mass' is not free", "--profile: 'mass' is not free"),
        ("design --samples a.nc", "samples: [tolerances] holds a, too", "--samples: [tolerances] holds a, too"),
        ("envelope", "margin = 2.0: must be below 1", "margin = 2.0: must be below 1"),
        ("drive --low 5", "lowest_frequency = 5.0: must increase", "lowest_frequency = 5.0: must increase"),
        ("export --drive own", "drive numbers stay free: leave them out", "drive numbers stay free: leave them out"),
        ("map --over voltage=0:1:3", "voltage = -1.0: is low", "voltage = -1.0: is low"),
    ],
)
def test_an_error_of_an_option_is_said_as_it_was_typed(typed, message, said):
    assert cli.as_typed(message, [word.replace(";", " ") for word in typed.split()]) == said


def test_errors_and_doubts_are_said_as_they_were_typed(command_line):
    assert command_line("simulate", "--periods", "-3")[2] == (
        "Error: --periods -3: must be a positive number of drive periods\n"
    )


def test_a_message_stays_as_it_is_where_nothing_was_typed():
    assert cli.as_typed("margin = 2.0: must be below 1", []) == "margin = 2.0: must be below 1"


@pytest.mark.parametrize("name", [name for name in COMMANDS if "-" in name])
def test_a_command_is_also_found_by_its_name_in_python(name, command_line):
    assert command_line(name.replace("-", "_"), "--help") == command_line(name, "--help")
    assert command_line(name, "--help")[0] == 0


OF_DEVICE = {"frequencies": "frequency", "tongues voltages": "voltage_amplitude"}
"""Axes that a device has under another name than a model."""
AXES = [(name, keyword) for name, own in REGISTERED.items() for keyword in ANALYSES[own].axes]


@pytest.mark.parametrize(("name", "keyword"), AXES)
def test_a_keyword_of_python_leads_to_the_axis_that_over_takes(name, keyword, command_line):
    """By its name for a model, and by that for a device where it is another."""
    _, _, said = command_line(name, f"--{keyword}", "1")
    axis = ANALYSES[REGISTERED[name]].axes[keyword]
    remedy = f"give --over {axis.of_model}=..."
    if own := OF_DEVICE.get(keyword) or OF_DEVICE.get(f"{name} {keyword}"):
        remedy += f", with a device --over {own}=..."
    assert said == f"Error: No such option '--{keyword}'; {remedy}\n"
