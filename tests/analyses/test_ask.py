"""What was typed becomes the arguments of an analysis, and a result the words of the command that gave it."""

import inspect
import warnings
from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.analyses import ask, tables
from gelcone.analyses.answer import result_json
from gelcone.analyses.request import Subject, read_subject
from gelcone.errors import DoubtfulInput, InputError
from gelcone.register.analyses import ANALYSES


@pytest.fixture(scope="module")
def pump():
    return gelcone.find_device("biased-pump").replace(film="taut")


@pytest.mark.parametrize("name", ANALYSES)
def test_an_analysis_answers_in_its_own_words_or_as_a_table(name):
    from importlib import import_module

    analysis = ANALYSES[name]
    found = ask.answers_of(analysis)
    home = import_module(f"gelcone.analyses.{analysis.answers}")
    assert found.command == analysis.command
    assert found.words is getattr(home, f"{name}_words", tables.table_words)
    own = getattr(home, f"{name}_json", None)
    if own is None:
        assert (found.json.func, found.json.keywords) == (result_json, {"left_out": analysis.file_only})
    else:
        assert found.json is own
    of_draws = ask.drawn_answers(name)
    assert (of_draws.command, of_draws.json.keywords) == (analysis.command, {"left_out": analysis.file_only})
    assert of_draws.words.__name__ == "over_draws_words"


def made(name, *options):
    """An analysis with options of quantities: (name, quantity, many)."""
    own = {
        option: SimpleNamespace(flags=(f"--{option}",), quantity=quantity, kind=None if many else float)
        for option, quantity, many in options
    }
    return SimpleNamespace(name=name, options=own)


@pytest.mark.parametrize("in_si", [False, True])
def test_options_are_read_in_the_units_that_the_analysis_takes(in_si, pump):
    analysis = made("own", ("times", "time", True), ("volts", "voltage", False), ("count", "", False))
    given = {"times": "1 ms, 2 ms", "volts": " 1 kV ", "count": "3", "other": 4.0}
    found = ask.read_options(analysis, Subject(pump.to_model(), pump, None), given, in_si=in_si)
    time, volt = (1.0, 1.0) if in_si else (pump.scales.time, pump.scales.voltage)
    assert set(found) == {"times", "volts"}
    np.testing.assert_allclose(found["times"] * time, [1e-3, 2e-3], rtol=1e-12)
    assert found["volts"] * volt == pytest.approx(1000.0, rel=1e-12)
    assert ask.read_options(analysis, read_subject(), {"volts": "0.5", "times": 3.0}) == {"volts": 0.5}
    with pytest.raises(InputError, match=r"--volts 1: has no unit; with a device give one, such as '1\.2 kV'"):
        ask.read_options(analysis, Subject(pump.to_model(), pump, None), {"volts": "1"})


def test_a_result_is_answered_by_the_analysis_of_its_title():
    result = gelcone.limits(gelcone.ConeModel())
    answers, subject = ask.answer_to(result)
    assert (answers.command, subject.device, subject.initial) == ("limits", None, None)
    assert subject.model.parameters() == gelcone.ConeModel().parameters()
    for title, name in ask.TITLES.items():
        answers, _ = ask.answer_to(result.assign_attrs(title=f"{title}: more words"))
        assert answers.command == ANALYSES[name].command
    drawn = result.assign_attrs(title="draws: of it", analysis="operating_limits")
    assert ask.answer_to(drawn)[0].command == "operating-limits"
    other, _ = ask.answer_to(result.assign_attrs(title="folds of the equilibria"))
    assert (other.command, other.words) == ("folds-of-the-equilibria", tables.any_words)
    del result.attrs["model"]
    for title, shown in (("material: gel", "'material'"), ("", "'none of gelcone'")):
        with pytest.raises(InputError) as error:
            ask.answer_to(result.assign_attrs(title=title))
        assert str(error.value) == f"the result is {shown}, which has no words; read its variables in Python"


OF_THE_LAB = {"design", "fit_device", "fit_material", "fitted_draws", "plan_device"}
"""Functions whose results the tests of their commands print."""
AS_GIVEN = {"load", "show", "to_si", "over_draws"}
"""Functions that return the result of another."""


def made_by_hand(pump):
    """Function -> a small result, of the public functions that are no command."""
    lifted = gelcone.ConeModel(rest_height=0.8, hoop_prestretch=1.4)
    flat = gelcone.ConeModel(spring_stiffness=[0.5, 1.5], drive_frequency=0.5)
    draws = gelcone.draw({"damping_ratio": gelcone.Uniform(0.05, 0.1)}, 4)
    plan = gelcone.Plan(lifted.replace(voltage=0.3, voltage_bias=0.6), {"drive_frequency": [0.6, 0.8]}, draws=draws)
    cells = gelcone.sweep(plan)
    times, omega = np.linspace(0.0, 5e-3, 8), np.linspace(0.1, 1.0, 9)
    return {
        "pull_in_voltage": gelcone.pull_in_voltage(pump),
        "pitchfork_voltage": gelcone.pitchfork_voltage(flat),
        "fold_voltages": gelcone.fold_voltages(lifted.replace(rest_height=0.3, spring_stiffness=0.5)),
        "stroke_and_blocked_force": gelcone.stroke_and_blocked_force(pump, ["0.5 kV", "1 kV"]),
        "small_signal_response": gelcone.small_signal_response(lifted.replace(voltage_bias=0.6), omega),
        "onset_voltage": gelcone.onset_voltage(flat),
        "floquet_multipliers": gelcone.floquet_multipliers(flat),
        "follow": gelcone.follow(pump, times, 0.0127 + 1e-6 * np.sin(np.pi * times / 5e-3) ** 2),
        "sense": gelcone.sense(pump, ["0.6 nF"], voltage="0.5 kV"),
        "probability": gelcone.probability(cells, gelcone.Regime.PERIODIC),
        "tolerances": gelcone.tolerances(cells),
    }


def test_every_public_function_that_returns_a_result_has_words(pump):
    """What no command gives is printed by its names, numbers of a device in its units."""
    functions = {name for name in gelcone.__all__ if inspect.isfunction(getattr(gelcone, name))}
    returned = {n for n in functions if "Dataset" in str(inspect.signature(getattr(gelcone, n)).return_annotation)}
    made = made_by_hand(pump)
    assert returned - ANALYSES.keys() - OF_THE_LAB - AS_GIVEN == made.keys()
    words = {name: gelcone.in_words(result) for name, result in made.items()}
    for name, text in words.items():
        for variable in made[name].drop_vars("outcome", errors="ignore").data_vars.values():
            if variable.size and variable.name != "onset_error":  # stands next to its voltage
                assert " ".join(variable.attrs["long_name"].split()) in " ".join(text.split()), (name, variable.name)
    assert "constant voltage: 500 V, 1 kV" in words["stroke_and_blocked_force"]
    assert "phase of the displacement: -" in words["small_signal_response"]
    assert words["small_signal_response"].endswith(" degree in 9 values")
    assert "is there a voltage that gives the motion: yes in 6 of 8, no in 2 of 8" in words["follow"]


def test_the_start_of_a_result_is_dimensionless(pump):
    """As its variable holds it, in mm and m/s for a device; as its options say, in m; else that of the device."""
    model = gelcone.ConeModel()
    of_model = gelcone.simulate(model, (0.25, 0.125), periods=1)
    np.testing.assert_allclose(np.ravel(ask.answer_to(of_model)[1].initial), [0.25, 0.125])
    shown = gelcone.simulate(pump, ("11 mm", "0.2 m/s"), times=["10 ms"])
    wanted = [11e-3 / pump.scales.length, 0.2 / pump.scales.velocity]
    assert np.ravel(ask.answer_to(shown)[1].initial) == pytest.approx(wanted)
    unstated = shown.drop_vars("initial")
    stated = unstated.assign_attrs(options='{"initial": [0.011, 0.2]}')
    assert np.ravel(ask.answer_to(stated)[1].initial) == pytest.approx(wanted)
    unstated = unstated.assign_attrs(options="{}")
    assert np.ravel(ask.answer_to(unstated)[1].initial) == pytest.approx(np.ravel(pump.initial_state()))


def test_a_device_that_nothing_moves_is_said_once_where_no_start_was_given(pump):
    flat = pump.replace(initial_height=0.0)
    for subject, doubtful in (
        (Subject(flat.to_model(), flat, flat.initial_state()), True),
        (Subject(flat.to_model(), flat, flat.initial_state(), None, True), False),
        (Subject(pump.to_model(), pump, pump.initial_state()), False),
        (read_subject(), False),
    ):
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            ask.warn_at_rest(subject)
        assert [one.category for one in said] == [DoubtfulInput] * doubtful


@pytest.mark.parametrize("name", ["static", "simulate"])
def test_arguments_begin_where_was_said(name, pump):
    analysis = ANALYSES[name]
    started = read_subject(pump, initial="5 mm,0.1 m/s")
    if name == "static":
        with pytest.raises(InputError, match="--initial: static does not start from a state; leave it out"):
            ask.arguments_of(analysis, started, {})
        return
    found = ask.arguments_of(analysis, started, {"periods": 3.0})
    wanted = [5e-3 / pump.scales.length, 0.1 / pump.scales.velocity]
    assert (found["periods"], list(found["initial"])) == (3.0, pytest.approx(wanted))


def test_what_is_not_a_dataset_has_no_words():
    with pytest.raises(InputError, match="in_words: was given the number 3; give a Dataset that an analysis returned"):
        gelcone.in_words(3)
