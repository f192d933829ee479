"""The register: a sweep and the analysis itself give the same numbers, and options are read from signatures."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys

import numpy as np
import pytest

import gelcone
from gelcone.analyses.ask import answers_of
from gelcone.atlas.plan import Plan
from gelcone.atlas.sweep import sweep
from gelcone.errors import InputError
from gelcone.physics.model import ConeModel
from gelcone.register.analyses import ANALYSES, COMMANDS, find_analysis, sweepable

MODEL = ConeModel(damping_ratio=0.1, spring_stiffness=0.5, drive_frequency=0.6, voltage=0.6, dielectric_strength=0.8)
VOLTAGES = [0.4, 1.0, 1.4]
SHORT = {
    "lyapunov": {"window": 30.0, "transient": 60.0, "budget": 100.0},
    "regime": {"transient": 60.0, "patience": 120.0, "budget": 100.0},
}


@pytest.mark.parametrize("name", sweepable())
def test_a_sweep_gives_what_the_analysis_gives_to_the_last_bit_on_any_threads(name):
    analysis = find_analysis(name)
    options = SHORT.get(name, {})
    start = {"initial": (0.7, 0.1)} if "initial" in analysis.signature.parameters else {}
    plan = Plan(MODEL, {"voltage": VOLTAGES}, (0.7, 0.1), options=options)
    cells = sweep(plan, name, keep=analysis.bulky, threads=2)
    alone = getattr(gelcone, name)(MODEL.replace(voltage=VOLTAGES), **start, **options, threads=1)
    assert set(alone.data_vars) - {"initial"} == set(cells.data_vars) - {"status", "source"}
    for variable in set(alone.data_vars) - {"initial"}:
        np.testing.assert_array_equal(cells[variable].values, alone[variable].values, str(variable))
        for attribute in ("long_name", "units", "quantity"):
            assert cells[variable].attrs.get(attribute) == alone[variable].attrs.get(attribute)


@pytest.mark.parametrize("name", [name for name in sweepable() if find_analysis(name).bulky])
def test_what_a_sweep_leaves_out_is_all_that_it_leaves_out(name):
    plan = Plan(MODEL, {"voltage": [0.4, 0.5]}, options=SHORT.get(name, {}))
    few, all_ = sweep(plan, name), sweep(plan, name, keep=find_analysis(name).bulky)
    assert set(all_.data_vars) - set(few.data_vars) == set(find_analysis(name).bulky)


@pytest.mark.parametrize("name", ANALYSES)
def test_the_public_name_is_that_of_the_register(name):
    analysis = ANALYSES[name]
    public = getattr(gelcone, name)
    assert inspect.getdoc(public)
    assert analysis.name == name
    assert ANALYSES.summaries[name].endswith(".")
    answers = answers_of(analysis)
    assert callable(answers.words)
    assert callable(answers.json)
    assert analysis.call is public


@pytest.mark.parametrize("name", sweepable())
def test_cells_take_the_options_of_the_public_function(name):
    analysis = ANALYSES[name]
    cells = inspect.signature(analysis.compute).parameters
    assert set(list(cells)[2:]) - {"threads", "progress"} == set(analysis.settings({}))
    for option in analysis.settings({}):
        assert cells[option].default == analysis.options[option].default


@pytest.mark.parametrize("name", ANALYSES)
def test_every_option_is_explained(name):
    for option in ANALYSES[name].options.values():
        assert option.help, option.name
        assert option.help[0].isupper()
        assert option.default is not None or option.unset, option.name
        assert option.help.count("(") == option.help.count(")"), option.help
        assert not re.search(r"\b[A-Z_]{4,}\b", option.help), option.help
        assert not re.match(r"Of the|\w = ", option.help), option.help


@pytest.mark.parametrize("name", ANALYSES)
def test_several_values_of_a_quantity_are_an_axis_which_over_gives(name):
    """One manner on the command line: what takes a list or a range of a quantity is declared as an axis."""
    analysis = ANALYSES[name]
    assert not [n for n, option in analysis.options.items() if option.quantity and option.kind is None]
    for keyword, axis in analysis.axes.items():
        option = analysis.axis_options[keyword]
        assert option.help.endswith("."), keyword
        assert option.help.count("(") == option.help.count(")"), option.help
        assert option.unset or axis.default, keyword
        assert analysis.quantities[keyword] == option.quantity


@pytest.mark.parametrize("name", ANALYSES)
def test_the_help_of_an_option_names_every_choice(name):
    """All choices that an entry of the docstring quotes, wherever it does."""
    analysis = ANALYSES[name]
    for option in analysis.options.values():
        entry = re.search(rf"^{option.name} : .*(?:\n {{4}}.*)*", inspect.getdoc(analysis.call), re.MULTILINE)
        choices = set(re.findall(r'``"(\w+)"``', entry[0])) if entry else set()
        assert choices <= set(re.findall(r"\w+", option.help)), option.help


@pytest.mark.parametrize("name", ANALYSES)
def test_all_analyses_take_initial_threads_and_progress_alike(name):
    """Model and axes first, then the initial state, then options by keyword; threads and progress come last."""
    parameters = inspect.signature(getattr(gelcone, name)).parameters
    positional = [p for p in parameters.values() if p.kind is not inspect.Parameter.KEYWORD_ONLY]
    if "initial" in parameters:
        assert positional[-1].name == "initial"
        assert tuple(parameters["initial"].default) == (1.0, 0.0)
    named = [n for n in ("threads", "progress") if n in parameters]
    assert list(parameters)[len(parameters) - len(named) :] == named
    for n in named:
        assert parameters[n].default is None
        assert parameters[n].kind is inspect.Parameter.KEYWORD_ONLY


def test_analyses_are_in_the_order_of_the_listing_and_no_other_name_is_one():
    """So are the commands, and the analyses that can be swept."""
    listed = [name for name, (_, about) in gelcone._listing().items() if about]
    assert listed != sorted(listed)
    assert list(ANALYSES) == list(ANALYSES.summaries) == list(COMMANDS.values()) == listed
    assert list(sweepable()) == [name for name in listed if ANALYSES[name].swept]
    assert len(ANALYSES) == len(listed) > len(sweepable()) > 3
    for name in ("Plan", "find_device", "InputError", "no_such", "analyses"):
        assert name not in ANALYSES
        assert ANALYSES.get(name) is None
        with pytest.raises(KeyError):
            ANALYSES[name]
        with pytest.raises(InputError, match=f"'{name}' is not an analysis"):
            find_analysis(name)


def test_an_unknown_analysis_is_refused_with_the_nearest():
    with pytest.raises(InputError, match="did you mean 'regime'"):
        find_analysis("regimes")
    with pytest.raises(InputError, match="'operating-limits' is not an analysis; did you mean 'operating_limits'"):
        find_analysis("operating-limits")


def test_the_list_of_commands_loads_no_analysis():
    """`gelcone --help` and the names of the register come without the code of any analysis."""
    code = "import sys, gelcone.cli; list(gelcone.cli.COMMANDS); assert 'numpy' not in sys.modules, 'numpy'"
    subprocess.run([sys.executable, "-c", code], check=True)
