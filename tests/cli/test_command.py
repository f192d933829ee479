"""The command of an analysis: what it takes, when it refuses, and how it answers, with nothing computed."""

from pathlib import Path

import click
import pytest

import gelcone
from gelcone.analyses.ask import answers_of, drawn_answers
from gelcone.atlas import drawn
from gelcone.cli import command, group
from gelcone.register.analyses import ANALYSES, COMMANDS, find_analysis

TABLE, THICKNESS = "prestretch\n1.0\n1.1\n", "film_thickness (m)\n2e-4\n2.1e-4\n"


@pytest.fixture
def delivered(monkeypatch, tmp_path):
    """What is computed and delivered of it, in order; ``fails``, the error of the analysis in place of its result."""
    (tmp_path / "draws.csv").write_text(TABLE)
    monkeypatch.chdir(tmp_path)
    story, fails = [], []

    def compute(*given, **keywords):
        story.append(("computed", keywords))
        if fails:
            raise fails[0]
        return "result"

    def deliver(answers, result, subject, out, force, as_json, draw):
        story.append(("delivered", answers, result, out))
        return 0

    monkeypatch.setattr(command, "plain", lambda call: compute)
    monkeypatch.setattr(drawn, "over_draws", compute)
    monkeypatch.setattr(command, "deliver", deliver)
    monkeypatch.setattr(command, "check_folder", lambda *given: story.append(("checked", *given)))
    return story, fails


@pytest.mark.parametrize("samples", [(), ("--samples", "draws.csv")])
def test_a_folder_is_checked_before_anything_is_computed(samples, delivered, command_line):
    story, _ = delivered
    assert command_line("limits", "--out", "there", "--force", *samples)[0] == 0
    assert [event for event, *_ in story] == ["checked", "computed", "delivered"]
    assert story[0] == ("checked", Path("there"), "sweep" if samples else "limits", True)
    assert story[2][2:] == ("result", Path("there"))


@pytest.mark.parametrize("samples", [(), ("--samples", "draws.csv")])
def test_files_that_exist_are_overwritten_where_that_was_asked_for_alone(samples, delivered, command_line):
    story, _ = delivered
    assert command_line("limits", "--out", "there", *samples)[0] == 0
    assert story[0] == ("checked", Path("there"), "sweep" if samples else "limits", False)


def test_words_of_a_command_are_in_their_places_behind_the_device():
    """`gelcone continue` alone takes several."""
    own = find_analysis("continue_branch")
    places = {"parameter": "voltage", "low": "1", "high": "2"}
    assert command._in_places(own, ("voltage", "1", "2")) == {"device": None, **places}
    assert command._in_places(own, ("biased-pump", "voltage", "1", "2")) == {"device": "biased-pump", **places}
    form = "continue: takes [DEVICE] PARAMETER FROM TO, "
    example = ", as in gelcone continue voltage 0.9 1.4 --preset base --out results"
    for words, said in (
        (
            ("biased-pump", "voltage", "1"),
            f"and behind the device biased-pump one of PARAMETER, FROM, TO is missing{example}",
        ),
        (
            ("own.toml", "voltage", "1"),
            f"and behind the device own.toml one of PARAMETER, FROM, TO is missing{example}",
        ),
        (("voltage", "1"), "not 2 words: voltage 1"),
        (("own.toml", "voltage", "1", "2", "3"), "not 5 words: own.toml voltage 1 2 3"),
        ((), "not 0 words: none"),
    ):
        with pytest.raises(gelcone.InputError) as error:
            command._in_places(own, words)
        assert str(error.value) == form + said


@pytest.mark.parametrize(
    ("typed", "initial"),
    [((), (1.0, 0.0)), (("--initial", "0.5,0.1"), (0.5, 0.1)), (("biased-pump", "--film", "taut"), None),
     (("biased-pump", "--film", "taut", "--initial", "5 mm,0.1 m/s"), (0.005, 0.1))],
)  # fmt: skip
def test_draws_start_where_it_was_said_and_those_of_a_device_at_its_own_rest(typed, initial, delivered, command_line):
    story, _ = delivered
    Path("draws.csv").write_text(THICKNESS if "biased-pump" in typed else TABLE)
    assert command_line("settled", *typed, "--samples", "draws.csv")[0] == 0
    found = story[1][1]["initial"]
    assert found == (None if initial is None else pytest.approx(initial))


PUMP = ("biased-pump", "--film", "taut")
DRAWN = {
    "limits": ((), TABLE, lambda: answers_of(find_analysis("sweep"))),  # as a sweep over draws does
    "frequency": (("--over", "drive_frequency=0.5:1:3"), TABLE, lambda: drawn_answers("frequency")),
    "envelope": (PUMP, THICKNESS, lambda: drawn_answers("envelope")),
}


@pytest.mark.parametrize("name", DRAWN)
def test_what_draws_show_is_said_in_the_words_of_draws(name, delivered, command_line):
    story, _ = delivered
    typed, table, right = DRAWN[name]
    Path("draws.csv").write_text(table)
    code, _, err = command_line(name, *typed, "--samples", "draws.csv")
    assert code == 0, err
    answers = story[-1][1]
    assert (answers.command, answers.words) == (right().command, right().words)
    assert command_line(name, *typed)[0] == 0
    assert story[-1][1].words == answers_of(find_analysis(name)).words != answers.words


def test_draws_of_a_table_are_not_drawn_again(delivered, command_line):
    """What would be drawn of distributions is in the table already; both together are refused, not one ignored."""
    story, _ = delivered
    Path("draws.csv").write_text(THICKNESS)
    typed = ("datasheet", *PUMP, "--samples", "draws.csv")
    assert command_line(*typed)[0] == 0
    assert [event for event, *_ in story] == ["checked", "computed", "delivered"]
    story.clear()
    for name, said in (("film_thickness=0.1 mm:0.2 mm", "hold it already"), ("moving_mass=5 g~1%", "hold all that is")):
        code, _, err = command_line(*typed, "--uncertain", name)
        assert (code, story) == (2, [])
        both = f"--samples draws.csv and --uncertain {name.partition('=')[0]}"
        assert err.startswith(f"Error: {both}: the samples {said}")


def test_distributions_are_drawn_as_was_typed(delivered, command_line, monkeypatch):
    """How many, in which order, and from which seed; those of a model or a device, for whichever points they are."""
    drawn = []
    monkeypatch.setattr(command, "read_draws", lambda *given, **how: drawn.append((given, how)) or {})
    uncertain = ("--uncertain", "film_thickness=0.1 mm:0.2 mm", "--uncertain", "moving_mass=5 g~1%")
    for typed, how in (
        ((), {"count": 64, "method": "sobol", "seed": 0}),
        (("--count", "8", "--method", "latin-hypercube", "--seed", "5"),
         {"count": 8, "method": "latin-hypercube", "seed": 5}),
    ):  # fmt: skip
        assert command_line("datasheet", *PUMP, *uncertain, *typed)[0] == 0
        (texts, subject), found = drawn.pop()
        assert (texts, subject.device.film) == (uncertain[1::2], "taut")
        assert found == {"indices": False, **how}


def test_draws_are_of_one_actuator(delivered, command_line):
    code, _, err = command_line("limits", "--set", "voltage=0.1,0.2", "--samples", "draws.csv")
    assert code == 2
    assert "limits: takes one actuator, not an ensemble of 2; give every field and parameter one value" in err
    assert delivered[0] == []


@pytest.mark.parametrize("samples", [False, True])
def test_an_error_of_an_analysis_is_in_the_words_of_the_device(samples, delivered, command_line):
    story, fails = delivered
    fails.append(gelcone.InputError("drive_frequency = 1: is too large"))
    Path("draws.csv").write_text(THICKNESS)
    more = ("--samples", "draws.csv") if samples else ()
    for typed, word in (((*PUMP, *more), " frequency"), ((), " drive_frequency")):
        if typed or not samples:
            code, _, err = command_line("limits", *typed)
            assert (code, story[-1][0]) == (2, "computed")
            assert f"error:{word}" in " ".join(err.split()).lower(), err


@pytest.mark.parametrize("value", ["0", "0.0"])
def test_a_zero_that_was_typed_reaches_the_analysis(value, delivered, command_line):
    story, _ = delivered
    assert command_line("section", "--discard", value.partition(".")[0])[0] == 0
    assert story[0][0] == "checked"
    assert story[1][1]["discard"] == 0
    assert command_line("regime", "--transient", value)[0] == 0
    assert story[-2][1]["transient"] == 0.0


def test_draws_and_drives_are_offered_where_they_can_be_used():
    """Draws of what can be swept or takes them itself, drives of what takes a model; of a store neither."""
    for name, own in COMMANDS.items():
        analysis = ANALYSES[own]
        found = group.get_command(click.Context(group), name)
        if not isinstance(found, click.Command) or name in ("map", "sweep", "show", "datasheet"):
            continue  # with commands of their own
        options = {parameter.name for parameter in found.params}
        assert ("samples" in options) == (analysis.drawn or (analysis.swept and analysis.takes == "model")), name
        assert ("recording" in options) == (analysis.takes in ("model", "device")), name
