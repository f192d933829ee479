"""An analysis as it is declared: its options from signature, annotations and docstring, and how they are checked."""

import pickle

import numpy as np
import pytest

import gelcone
from gelcone.errors import InputError
from gelcone.register.analyses import ANALYSES, find_analysis
from gelcone.register.analysis import NOT_OPTIONS, annotation_of, command_name, explanations


def test_settings_fill_in_defaults_and_refuse_what_is_no_option():
    regime = find_analysis("regime")
    assert regime.settings({"budget": 300}) == {
        "transient": None,
        "patience": None,
        "budget": 300.0,
        "tolerance": 1e-15,
    }
    with pytest.raises(InputError, match="'bugdet' is not an option of the analysis regime; did you mean 'budget'"):
        regime.settings({"bugdet": 1.0})
    with pytest.raises(InputError, match="budget = 'long': must be a number"):
        regime.settings({"budget": "long"})
    for name in ("threads", "initial"):
        with pytest.raises(InputError, match=f"'{name}' is not an option of the analysis regime"):
            regime.settings({name: 2})
    with pytest.raises(InputError, match="'thread' is not an option of the analysis regime") as refused:
        regime.settings({"thread": 2})
    assert "'threads'" not in str(refused.value)  # which would be refused, too
    assert regime.settings({"budget": 0.0, "transient": 0})["budget"] == 0.0
    assert regime.settings({"transient": 0, "patience": None})["transient"] == 0.0
    assert find_analysis("limits").settings({})["at_once"] is False
    assert find_analysis("limits").settings({"at_once": True})["at_once"] is True
    for wrong in (1, "yes", None):
        with pytest.raises(InputError, match=f"at_once = {wrong!r}: must be True or False"):
            find_analysis("limits").settings({"at_once": wrong})
    with pytest.raises(InputError, match="budget = True: must be a number"):
        regime.settings({"budget": True})
    assert [type(regime.settings({"budget": value})["budget"]) for value in (300, np.int64(300), 300.0)] == [float] * 3
    section = find_analysis("section")
    assert type(section.settings({"repeats": 8.0})["repeats"]) is int
    with pytest.raises(InputError, match=r"repeats = 1\.5: must be a whole number"):
        section.settings({"repeats": 1.5})
    with pytest.raises(InputError, match=r"repeats = -1\.5: must be a whole number"):
        section.settings({"repeats": -1.5})


def test_explanations_come_from_docstrings():
    def does():
        """Does it.

        Parameters
        ----------
        model : one actuator.
        budget, window : longest time; taken
            together. Default `all`.
        transient : as in `regime`.
        patience : as in `gelcone.regime`, in turns. Default 32 `transient`.
        threads : shares; default one a core. Does not matter.
        none : whether not.
        store, keep : folder; kept. Default: nothing
            is stored.

        Returns
        -------
        result : something.
        """

    def nothing():
        """No parameters."""

    found = explanations(does)
    assert list(found) == [
        "model", "budget", "window", "transient", "patience", "threads", "none", "store", "keep",
    ]  # fmt: skip
    assert found["budget"] == found["window"] == ("Longest time.", "all")
    assert found["transient"][0].startswith("Time after which")
    assert found["transient"][1].startswith("by damping")
    assert found["patience"] == (explanations(gelcone.regime)["patience"][0], "32 `transient`")
    assert explanations(gelcone.regime)["patience"][1] not in ("", found["patience"][1])
    assert found["threads"] == ("Shares.", "one a core")
    assert found["none"] == ("Whether not.", "")
    assert found["store"] == found["keep"] == ("Folder.", "nothing is stored")
    assert explanations(nothing) == {}


def test_quantities_come_from_annotations():
    assert annotation_of(gelcone.regime, "budget") == (float, "time")
    assert annotation_of(gelcone.regime, "transient") == (float, "time")
    assert annotation_of(gelcone.regime, "tolerance") == (float, "")
    assert annotation_of(gelcone.static, "displacements") == (None, "length")
    assert annotation_of(gelcone.section, "repeats") == (int, "")
    assert annotation_of(gelcone.regime, "initial") == (None, "")


def test_an_analysis_travels_by_its_name():
    analysis = find_analysis("regime")
    assert pickle.loads(pickle.dumps(analysis)).call is gelcone.regime
    assert len(pickle.dumps(analysis)) < 200


def test_options_leave_out_what_is_computed():
    for analysis in ANALYSES.values():
        assert not set(analysis.options) & set(NOT_OPTIONS) - set(analysis.flags)


def test_only_what_has_no_default_says_what_happens_without_it():
    """The help shows the default itself where there is one."""
    options = find_analysis("regime").options
    assert options["transient"].unset.startswith("by damping")
    assert {name: options[name].unset for name in ("budget", "tolerance")} == {"budget": "", "tolerance": ""}


def test_an_option_has_its_own_flags_or_those_of_its_name():
    flags = {name: option.flags for name, option in find_analysis("continue_branch").options.items()}
    assert (flags["start"], flags["store"]) == (("--from",), ("--store",))
    assert find_analysis("limits").options["at_once"].flags == ("--at-once",)
    assert not {"store", "resume"} & find_analysis("map").options.keys() - find_analysis("map").flags.keys()


@pytest.mark.parametrize(
    ("name", "command"),
    [
        ("regime", "regime"),
        ("operating_limits", "operating-limits"),
        ("continue_branch", "continue"),
        ("a_b_c", "a-b-c"),
    ],
)
def test_a_command_has_the_name_of_its_function_in_the_words_of_a_shell(name, command):
    assert command_name(name) == command


def test_what_cannot_be_swept_has_no_cells():
    with pytest.raises(InputError, match=r"static: cannot be swept; run `gelcone static` \(in Python gelcone.static\)"):
        _ = find_analysis("static").compute


def test_an_axis_has_its_name_and_its_quantity():
    """On the command line that of a model or of a device; the quantities of options and axes by their keywords."""
    envelope = find_analysis("envelope")
    names = {keyword: (axis.name(False), axis.name(True)) for keyword, axis in envelope.axes.items()}
    assert names == {"frequencies": ("drive_frequency", "frequency"), "peaks": ("peak_voltage", "peak_voltage")}
    measured = {name: quantity for name, quantity in envelope.quantities.items() if quantity}
    assert measured.items() >= {"frequencies": "frequency", "peaks": "voltage"}.items()
    assert find_analysis("regime").quantities["budget"] == "time"
    assert find_analysis("regime").quantities["tolerance"] == ""
