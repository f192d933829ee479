"""What is typed reaches the function that a command asks, keyword by keyword; the rest is left to its defaults.

One table over the register of commands: each call is recorded in place of being made, so that nothing is computed.
"""

import inspect
from pathlib import Path

import click
import numpy as np
import pytest

import gelcone
from gelcone.atlas import drawn
from gelcone.cli import command, group, output
from gelcone.cli import options as shared
from gelcone.presets import find_preset
from gelcone.register.analyses import ANALYSES, COMMANDS
from gelcone.register.analysis import annotation_of

ASKED = [name for name in COMMANDS if name not in ("map", "sweep", "show")]
"""Commands that run one analysis; maps, sweeps and stores have tests of their own."""
NEEDED = {
    "bifurcation": ("--over", "voltage=0.9:1.1:3"),
    "continue": ("voltage", "0.9", "1.1"),
    "locus": ("fold", "--over", "voltage=0.9:1.1", "--over", "drive_frequency=0.1:0.2"),
}
"""What a command does not do without."""
OF_DEVICE = {
    "bifurcation": ("--over", "voltage_amplitude=100 V:300 V:3"),
    "continue": ("voltage_amplitude", "100 V", "300 V"),
    "locus": ("fold", "--over", "voltage_amplitude=100 V:300 V", "--over", "frequency=9 Hz:10 Hz"),
}
WORDS = {
    "wrinkles": "relax", "limits_from": "settled", "largest": "work", "sweeps": "down", "start": "settled",
}  # fmt: skip
"""Values of options that are words, other than the usual ones."""
READ = {"sweeps": ["down"]}
SUBJECT = ("device", "words", "preset", "settings", "initial", "film")
DRIVE = ("recording", "drive_scale", "drive_repeat", "drive_interpolation")
DRAWS = ("uncertain", "count", "method", "seed", "samples")
OUTPUT = ("out", "force", "as_json")
OVER_DRAWS = drawn.over_draws
TABLE = "prestretch\n1.0\n1.1\n1.2\n"


class Asked(gelcone.InputError):
    """Ends a command where its function would begin."""


@pytest.fixture
def asked(monkeypatch, command_line):
    """Runs a command up to the call of its function: which function, of what, with which keywords."""
    calls = []

    def record(call):
        def ask(*given, **keywords):
            calls.append((call, given, keywords))
            raise Asked("asked")

        return ask

    monkeypatch.setattr(command, "plain", record)
    monkeypatch.setattr(drawn, "over_draws", record(drawn.over_draws))

    def run(*typed):
        calls.clear()
        code, _, err = command_line(*typed)
        assert (code, len(calls)) == (2, 1), err
        return calls[0]

    return run


def click_command(name):
    context = click.Context(group)
    return group.get_command(context, name)


def same(one, other):
    assert type(one) is type(other) or isinstance(one, float | np.ndarray | list | tuple)
    if isinstance(one, np.ndarray) or isinstance(other, float):
        np.testing.assert_allclose(one, other, rtol=1e-12)
    else:
        assert one == other


def typed_as(option):
    """A text for an option, not its default, and what it stands for without a device."""
    if option.name in WORDS:
        return WORDS[option.name], READ.get(option.name, WORDS[option.name])
    if option.kind is bool:
        return None, True
    if option.kind is Path:
        return "there.zarr", Path("there.zarr")
    if option.kind is int:
        return "7", 7
    if option.kind is float:
        return "0.0625", 0.0625
    assert option.quantity, f"{option.name}: give a word for it in WORDS"
    return "0.25,0.375", np.array([0.25, 0.375])


OPTIONS = [
    (name, option)
    for name in ASKED
    for option in ANALYSES[COMMANDS[name]].options.values()
    if option.name != "resume"  # names a store on the command line, see `test_branches.py`
]


def test_no_option_of_a_command_is_left_out():
    for name in ASKED:
        analysis = ANALYSES[COMMANDS[name]]
        own = [p.name for p in click_command(name).params]
        assert len(own) == len(set(own))
        samples = ("samples",) if analysis.drawn or (analysis.swept and analysis.takes == "model") else ()
        more = {"locus": ("on",), "datasheet": DRAWS}.get(name, samples)
        over = ("over",) if analysis.over or analysis.axes else ()
        first = "words" if analysis.arguments else "device"
        known = {first, *SUBJECT[2:], *DRIVE, *over, *analysis.options, *more, *OUTPUT}
        assert set(own) == known, name
        hidden = {"model", "initial", "progress", "over", "parameter", "values", *analysis.axes, *analysis.arguments}
        assert set(analysis.signature.parameters) - hidden == set(analysis.options) - hidden, name


@pytest.mark.parametrize("name", ASKED)
def test_what_is_not_typed_is_left_to_the_function(name, asked):
    call, given, keywords = asked(name, *NEEDED.get(name, ()))
    analysis = ANALYSES[COMMANDS[name]]
    assert call is getattr(gelcone, COMMANDS[name])
    assert [own.parameters() for own in given] == [gelcone.ConeModel().parameters()]
    assert not set(keywords) & set(analysis.options)
    assert set(keywords) <= set(inspect.signature(call).parameters)
    assert ("progress" in keywords) == ("progress" in inspect.signature(call).parameters)
    if "initial" in keywords:
        assert keywords["initial"] == inspect.signature(call).parameters["initial"].default
    assert ("initial" in keywords) == ("initial" in inspect.signature(call).parameters)


@pytest.mark.parametrize(("name", "option"), OPTIONS, ids=[f"{name} {option.flags[0]}" for name, option in OPTIONS])
def test_an_option_reaches_its_keyword_and_no_other(name, option, asked):
    text, value = typed_as(option)
    assert value != option.default if not isinstance(value, np.ndarray) else option.default is None
    before = asked(name, *NEEDED.get(name, ()))[2]
    for flag in option.flags:
        keywords = asked(name, *NEEDED.get(name, ()), flag, *([] if text is None else [text]))[2]
        same(keywords.pop(option.name), value)
        assert keywords.keys() == before.keys()


def per_si(quantity, device):
    """Dimensionless units in an SI unit of a device, from the model that the device is."""
    model = device.to_model()
    return {
        "time": 1.0 / device.scales.time,
        "voltage": model.voltage / device.voltage_amplitude,
        "frequency": model.drive_frequency / device.frequency,
        "length": 1.0 / device.scales.length,
    }[quantity]


UNITS = {"time": ("ms", 1e-3), "voltage": ("kV", 1e3), "frequency": ("kHz", 1e3), "length": ("mm", 1e-3)}
MEASURED = [(name, option) for name, option in OPTIONS if option.quantity]


@pytest.fixture(scope="module")
def pump():
    return gelcone.find_device("biased-pump").replace(film="taut")


@pytest.mark.parametrize(("name", "option"), MEASURED, ids=[f"{name} {option.flags[0]}" for name, option in MEASURED])
def test_an_option_of_a_device_is_read_with_its_unit(name, option, asked, pump):
    unit, size = UNITS[option.quantity]
    many = option.kind is None
    text = f"0.5 {unit},0.75 {unit}" if many else f"0.5 {unit}"
    typed = ("biased-pump", *OF_DEVICE.get(name, ()), "--film", "taut")
    keywords = asked(name, *typed, option.flags[0], text)[2]
    analysis = ANALYSES[COMMANDS[name]]
    factor = 1.0 if analysis.planned else per_si(option.quantity, pump)
    wanted = size * np.array([0.5, 0.75] if many else 0.5) * factor
    np.testing.assert_allclose(keywords[option.name], wanted, rtol=1e-9)
    assert option.quantity == annotation_of(analysis.call, option.name)[1]


AXES = [(name, keyword) for name in ASKED for keyword in ANALYSES[COMMANDS[name]].axes]


@pytest.mark.parametrize(("name", "keyword"), AXES)
def test_an_axis_reaches_its_keyword(name, keyword, asked, pump):
    axis = ANALYSES[COMMANDS[name]].axes[keyword]
    found = asked(name, "--over", f"{axis.of_model}=0.25:0.75:3")[2]
    assert found.pop(keyword).tolist() == [0.25, 0.5, 0.75]
    for other, own in ANALYSES[COMMANDS[name]].axes.items():
        if other != keyword:
            assert (other in found) == (own.default is not None)
    quantity = annotation_of(ANALYSES[COMMANDS[name]].call, keyword)[1]
    unit, size = UNITS[quantity]
    typed = (name, "biased-pump", "--film", "taut", "--over", f"{axis.of_device}=0.25 {unit}:0.75 {unit}:3")
    np.testing.assert_allclose(
        asked(*typed)[2][keyword], size * np.array([0.25, 0.5, 0.75]) * per_si(quantity, pump), rtol=1e-9
    )


@pytest.mark.parametrize("name", ASKED)
def test_an_initial_state_reaches_the_function_or_is_refused(name, asked, command_line):
    typed = (name, *NEEDED.get(name, ()), "--initial", "0.25,0.5")
    starts = "initial" in ANALYSES[COMMANDS[name]].signature.parameters
    assert ("--initial" in command_line(name, "--help")[1]) == starts
    if starts:
        assert asked(*typed)[2]["initial"] == (0.25, 0.5)
    else:
        code, _, err = command_line(*typed)
        assert code == 2
        assert "--initial" in err


@pytest.mark.parametrize("name", ASKED)
def test_the_subject_is_read_from_what_was_typed(name, monkeypatch, command_line):
    """Device or preset, film, settings and initial state, each under its own name."""
    calls = []

    def read(device, **keywords):
        calls.append({"device": device, **keywords})
        raise Asked("asked")

    monkeypatch.setattr(shared, "read_subject", read)
    nothing = {"device": None, "preset": None, "film": None, "settings": (), "initial": None}
    words = NEEDED[name] if ANALYSES[COMMANDS[name]].arguments else ()
    for typed, found in (
        ((*words, "--preset", "fast"), {"preset": "fast"}),
        ((*words, "--film", "taut"), {"film": "taut"}),
        ((*words, "--initial", "1,2"), {"initial": "1,2"}),
        ((*words, "--set", "a=1", "--set", "b=2"), {"settings": ("a=1", "b=2")}),
        (("soft-film", *words), {"device": "soft-film"}),
    ):
        calls.clear()
        assert command_line(name, *typed)[0] == 2
        assert calls == [nothing | found]


@pytest.mark.parametrize("name", ASKED)
def test_a_recording_is_read_with_its_options(name, monkeypatch, command_line, tmp_path):
    from gelcone.devices import recorded

    calls, known = [], set(inspect.signature(recorded.recorded).parameters)

    def read(target, path, **keywords):
        calls.append((str(path), keywords))
        raise Asked("asked")

    monkeypatch.setattr(recorded, "recorded", read)
    base = (name, *NEEDED.get(name, ()), "--drive", "drive.csv")
    for typed, found in (
        ((), {}),
        (("--drive-scale", "0.5"), {"scale": 0.5}),
        (("--drive-scale", "0"), {"scale": 0.0}),
        (("--drive-repeat",), {"repeat": True}),
        (("--drive-interpolation", "pchip"), {"interpolation": "pchip"}),
    ):
        calls.clear()
        assert command_line(*base, *typed)[0] == 2
        assert calls == [("drive.csv", found)]
        assert set(found) <= known


@pytest.mark.parametrize("name", ASKED)
def test_a_result_is_delivered_as_was_typed(name, monkeypatch, command_line):
    """--out, --force and --json, to the check before any work and to what prints and writes."""
    calls, checks = [], []
    result = object()

    def deliver(answers, found, subject, out, force, as_json, draw):
        calls.append((answers.command, found, out, force, as_json))
        return 0

    monkeypatch.setattr(command, "plain", lambda call: lambda *given, **keywords: result)
    monkeypatch.setattr(command, "deliver", deliver)
    monkeypatch.setattr(command, "check_folder", lambda *given: checks.append(given))
    for typed, found in (
        ((), (None, False, False)),
        (("--force",), (None, True, False)),
        (("--json",), (None, False, True)),
    ):
        calls.clear()
        checks.clear()
        assert command_line(name, *NEEDED.get(name, ()), *typed)[0] == 0
        assert calls == [(name, result, *found)]
        assert checks == [(found[0], name, found[1])]
    if name == "datasheet":
        return  # writes a page, too
    assert command_line(name, *NEEDED.get(name, ()), "--out", "there")[0] == 0
    assert calls[-1] == (name, result, Path("there"), False, False)
    assert checks[-1] == (Path("there"), name, False)


SAMPLED = [name for name in ASKED if {"samples"} & {p.name for p in click_command(name).params}]


@pytest.mark.parametrize("name", SAMPLED)
def test_draws_reach_the_analysis_with_its_options(name, asked, tmp_path):
    (tmp_path / "draws.csv").write_text(TABLE)
    analysis = ANALYSES[COMMANDS[name]]
    starts = "initial" in analysis.signature.parameters
    options = [option for option in analysis.options.values() if option.name != "threads"]
    typed = [part for option in options for part in (option.flags[0], typed_as(option)[0]) if part is not None]
    call, (model, draws, own), keywords = asked(name, "--preset", "fast", *typed, "--samples", "draws.csv")
    assert call is OVER_DRAWS
    assert model.parameters() == find_preset("fast").model.parameters()
    assert {k: v.tolist() for k, v in draws.items()} == {"prestretch": [1.0, 1.1, 1.2]}
    assert own == analysis.name
    assert keywords["initial"] == (find_preset("fast").initial if starts else None)
    for option in options:
        same(keywords[option.name], typed_as(option)[1])
    for keyword in analysis.axes:
        if analysis.axes[keyword].default is None:
            assert keyword not in keywords
    assert asked(name, "--threads", "3", "--samples", "draws.csv")[2]["threads"] == 3


def test_a_figure_is_that_of_the_result_and_its_options(monkeypatch, command_line, tmp_path):
    """The curves of a locus on a map that was named; without a place for the figure it is refused."""
    from gelcone.cli import branches

    drawn_with = []
    monkeypatch.setattr(command, "plain", lambda call: lambda *given, **keywords: "curves")
    monkeypatch.setattr(branches, "_below", lambda path: f"the map of {path}")
    monkeypatch.setattr(branches, "plot", lambda result, **how: drawn_with.append((result, how)))

    def deliver(answers, found, subject, out, force, as_json, draw):
        draw(found)
        return 0

    monkeypatch.setattr(command, "deliver", deliver)
    code, _, err = command_line("locus", *NEEDED["locus"], "--on", "map.nc")
    assert code == 2
    assert "--on map.nc: says what the curves are drawn on; give --out" in err
    assert command_line("locus", *NEEDED["locus"], "--on", "map.nc", "--out", "there")[0] == 0
    assert drawn_with == [("curves", {"on": "the map of map.nc"})]


@pytest.mark.parametrize("name", ASKED)
def test_the_help_states_the_defaults_and_units_of_the_function(name):
    units = {"time": "s or ms", "voltage": "V or kV", "frequency": "Hz", "length": "mm or m"}
    parameters = inspect.signature(getattr(gelcone, COMMANDS[name])).parameters
    by_name = {p.name: p for p in click_command(name).params if isinstance(p, click.Option)}
    for option in ANALYSES[COMMANDS[name]].options.values():
        said = by_name[option.name].help or ""
        default = parameters[option.name].default
        assert (f"With a device in {units.get(option.quantity)}." in said) == bool(option.quantity), said
        if isinstance(default, int | float) and not isinstance(default, bool):
            assert f"[default: {default:g}{', dimensionless' if option.quantity else ''}]" in said, said
        elif isinstance(default, str):
            assert f"[default: {default}]" in said


def test_an_answer_is_written_and_printed_in_the_units_of_its_device(monkeypatch, capsys):
    """`deliver`: what is written is what is shown; JSON in place of words; 1 where every run failed."""
    from types import SimpleNamespace

    import xarray as xr

    result, written, figure = xr.Dataset({"outcome": ("member", [3, 3])}), [], object()
    shown = result.assign(shown=1)
    monkeypatch.setattr(output, "in_si", lambda own, subject: shown)
    monkeypatch.setattr(output, "write_results", lambda *given: written.append(given) or (Path("a.nc"), Path("a.png")))
    monkeypatch.setattr(output, "answer_json", lambda name, content, own, subject: {"name": name, "content": content})
    answers = SimpleNamespace(command="settled", words=lambda own, subject: f"{own is shown} {subject}", json=str)
    code = output.deliver(answers, result, "subject", Path("there"), True, False, lambda own: own is shown and figure)
    assert code == 1
    assert written == [(Path("there"), "settled", shown, figure, True)]
    assert capsys.readouterr().out == "True subject\nwrote a.nc\nwrote a.png\n"
    answers.json = lambda own: own is shown
    assert output.deliver(answers, result.assign(outcome=("member", [0, 3])), "subject", None, False, True) == 0
    assert capsys.readouterr().out == '{"name": "settled", "content": true, "warnings": []}\n'
    assert len(written) == 1


def test_a_figure_that_fails_does_not_cost_the_result(monkeypatch, tmp_path):
    from types import SimpleNamespace

    result = gelcone.limits(find_preset("base").model)
    monkeypatch.setattr(output, "in_si", lambda own, subject: own)
    with pytest.raises(ZeroDivisionError):
        output.deliver(
            SimpleNamespace(command="limits"), result, None, tmp_path / "there", False, False, lambda own: 1 / 0
        )
    assert [path.name for path in (tmp_path / "there").iterdir()] == ["limits.nc"]
    assert gelcone.load(tmp_path / "there" / "limits.nc").identical(result)


@pytest.mark.parametrize("name", SAMPLED)
def test_draws_start_where_was_said_or_the_analysis_refuses_it(name, asked, command_line, tmp_path):
    (tmp_path / "draws.csv").write_text(TABLE)
    typed = (name, "--initial", "0.25,0.5", "--samples", "draws.csv")
    if "initial" in ANALYSES[COMMANDS[name]].signature.parameters:
        assert asked(*typed)[2]["initial"] == (0.25, 0.5)
    else:
        code, _, err = command_line(*typed)
        assert code == 2
        assert f"--initial: {name} does not start from a state; leave it out" in err


@pytest.mark.parametrize("name", [name for name in ASKED if "-" in name])
def test_a_command_is_found_by_the_name_in_python(name, asked):
    assert asked(name.replace("-", "_"))[0] is getattr(gelcone, COMMANDS[name])


def test_words_in_places_are_counted(asked, command_line):
    assert asked("continue", "voltage", "0.9", "1.1")[2]["parameter"] == "voltage"
    for typed, message in (
        (("continue", "voltage"), "continue: takes [DEVICE] PARAMETER FROM TO, not 1 words: voltage"),
        (("continue", *"abcde"), "continue: takes [DEVICE] PARAMETER FROM TO, not 5 words: a b c d e"),
        (("locus",), "locus: takes [DEVICE] EVENT, not 0 words: none"),
        (
            ("locus", "mine.toml"),
            "locus: takes [DEVICE] EVENT, and behind the device mine.toml EVENT is missing, as in gelcone locus fold ",
        ),
        (("continue", "soft-film", "1", "2"), "and behind the device soft-film one of PARAMETER, FROM, TO is missing"),
    ):
        code, _, err = command_line(*typed)
        assert code == 2
        assert message in err
