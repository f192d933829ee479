"""Branches and loci: what is typed, and what is said of made-up ones."""

import pytest

import gelcone
from gelcone.analyses import (
    branches,
)  # fmt: skip
from gelcone.analyses.answer import heading
from tests.analyses.said import EVENTS, NAN, SUBJECT
from tests.edited import coded, edited, made


def branches_of(**changes):
    own = {
        "value": (("branch", "point"), [[1.0, 1.5, 2.0, NAN], [1.25, 1.75, NAN, NAN]], "V"),
        "stable": (("branch", "point"), [[1, 0, 0, -1], [1, 1, -1, -1]]), "resting": ("branch", [1, 0]),
        "period": ("branch", [1, 2]), "symmetric": ("branch", [0, 1]),
        "ended": coded(("branch", "end"), [[0, 1], [2, 3]], ("limit", "wall", "merged", "step")),
        "event_branch": ("event", [0, 1]), "event_kind": coded("event", [1, 2], EVENTS),
        "event_value": ("event", [1.125, 1.625], "V"), "event_error": ("event", [2e-7, 3e-7]),
        "event_supercritical": ("event", [1, 0]), "event_born_branch": ("event", [1, -1]),
        "event_resolved": ("event", [1, 0]), "checked_cycles": 7, "checked_orbits": 5, "seeded": 2,
        "flag_explanation": ("flag", ["near a fold", ""]), "flag_branch": ("flag", [1, -1]),
        "flag_kind": coded("flag", [0, 1], ("lost_orbit", "another_motion")), "flag_value": ("flag", [1.4375, 1.9]),
    }  # fmt: skip
    return edited(made(own, parameter="voltage"), **changes)


def test_branches_of_orbits():
    lines = [
        "branch 0: rest, voltage 1 to 2 V, 3 points, 33.3 % of them stable; ends: the end of the interval, the "
        "stretch limit",
        "  period doubling at 1.125 ± 2e-07 V, supercritical, branch 1 is born",
        "branch 1: period 2, symmetric, voltage 1.25 to 1.75 V, 2 points, 100 % of them stable; ends: a branch of "
        "half its "
        "period or a symmetric one, the shortest step",
        "  symmetry breaking at 1.625 ± 3e-07 V, subcritical, unresolved",
        "brute force: 7 settled cycles, all on these branches (2 started one); 5 stable orbits run from 1e-5 away; 2 "
        "contradiction(s), 1 explained",
        "  lost orbit, branch 1, voltage 1.438 V: near a fold".replace("1.438", "1.4375"),
        "  another motion, branch none, voltage 1.9 V",
    ]
    assert branches.branch_lines(branches_of()) == lines
    assert branches.branch_lines(branches_of(event_supercritical=-1))[1].endswith("± 2e-07 V, branch 1 is born")
    none = branches_of(checked_orbits=0, flag_explanation=["", ""])
    assert branches.branch_lines(none)[4] == (
        "brute force: 7 settled cycles, all on these branches (2 started one); no stable orbit decays fast enough to "
        "be "
        "run; 2 contradiction(s)"
    )
    assert branches.branch_lines(branches_of(), "drive frequency")[0].startswith(
        "branch 0: rest, drive frequency 1 to 2 V"
    )


@pytest.mark.parametrize(
    ("low", "high", "word"), [("1", "1", "is empty"), ("2", "1", "is reversed"), ("1", "2", None), ("1 V", "0 V", None)]
)
def test_two_ends_in_the_wrong_order(low, high, word):
    if word is None:
        read = {"voltage": (1.0, 2.0)}
        assert branches._interval("voltage", low, high, lambda texts: read) == ("voltage", 1.0, 2.0)
        return
    with pytest.raises(gelcone.InputError, match=f"voltage from {low} to {high}: {word}; give the lower end first"):
        branches._interval("voltage", low, high, None)


@pytest.mark.parametrize(("low", "high", "word"), [("1.1", "0.9", "is reversed"), ("1", "1.0", "is empty")])
def test_ends_of_branches_and_curves_in_the_words_of_their_commands(low, high, word):
    said_ = f"voltage from {low} to {high}: {word}; give the lower end first"
    with pytest.raises(gelcone.InputError, match=said_):
        branches.continue_branch_arguments(SUBJECT, {"parameter": "voltage", "low": low, "high": high})
    over = (f"voltage={low}:{high}", "drive_frequency=0.1:0.2")
    with pytest.raises(gelcone.InputError, match=said_):
        branches.locus_arguments(SUBJECT, {"over": over})
    found = branches.locus_arguments(SUBJECT, {"over": ("voltage=0.9:1.1", over[1]), "points": 5})
    assert found == {"over": {"voltage": (0.9, 1.1), "drive_frequency": (0.1, 0.2)}, "points": 5}
    given = {"parameter": "voltage", "low": "0.9", "high": "1.1", "start": "settled", "points": 5}
    assert branches.continue_branch_arguments(SUBJECT, given) == {
        "parameter": "voltage", "low": 0.9, "high": 1.1, "start": "settled", "points": 5,
    }  # fmt: skip


def test_a_contradiction_on_the_first_branch_names_it_and_a_branch_may_turn_back():
    """The range of a branch is that of its values, not between its ends."""
    shown = branches_of(flag_branch=[0, -1], value=[[1.5, 2.0, 1.0, NAN], [1.75, 1.25, NAN, NAN]])
    lines = branches.branch_lines(shown)
    assert lines[-2].startswith("  lost orbit, branch 0, voltage")
    assert lines[0].startswith("branch 0: rest, voltage 1 to 2 V, 3 points, ")
    assert lines[2].startswith("branch 1: period 2, symmetric, voltage 1.25 to 1.75 V, ")


def test_a_locus():
    """Two curves, of which the first turns back in both parameters and holds the one event."""
    each = ("curve", "point")
    shown = made(
        {
            "voltage": (each, [[1.0, 2.0, 1.5], [3.0, 2.5, NAN]], "V"),
            "frequency": (each, [[9.0, 8.0, 10.0], [7.0, 6.0, NAN]], "Hz"), "period": ("curve", [2, 1]),
            "symmetric": ("curve", [1, 0]),
            "ended": coded(("curve", "end"), [[0, 1], [2, 3]], ("limit", "wall", "merged", "step")),
            "event_curve": ("event", [0]), "event_kind": coded("event", [1], EVENTS),
            "event_first": ("event", [1.25], "V"), "event_first_error": ("event", [2e-7], "V"),
            "event_second": ("event", [8.5], "Hz"), "event_second_error": ("event", [3e-6], "Hz"),
        },
        parameters="voltage,frequency", event="fold",
    )  # fmt: skip
    first, event, second = branches.locus_words(shown, SUBJECT).splitlines()[
        len(heading(SUBJECT, ["voltage", "frequency"])) :
    ]
    ends = "the end of the interval, the stretch limit"
    assert (
        first == f"curve 0: fold, period 2, symmetric, voltage 1 to 2 V, frequency 8 to 10 Hz, 3 points; ends: {ends}"
    )
    assert event == "  period doubling at voltage 1.25 ± 2e-07 V, frequency 8.5 ± 3e-06 Hz"
    assert second.startswith(
        "curve 1: fold, period 1, voltage 2.5 to 3 V, frequency 6 to 7 Hz, 2 points; ends: a branch"
    )


def test_the_arguments_of_branches_and_loci_are_the_numbers_that_were_typed():
    given = {"parameter": "voltage", "low": "0.25", "high": "0.75", "switch": 2, "start": "settled"}
    found = branches.continue_branch_arguments(SUBJECT, given)
    assert found == {"parameter": "voltage", "low": 0.25, "high": 0.75, "switch": 2, "start": "settled"}
    over = ["drive_frequency=0.5:1.5", "voltage=0.25:0.75:9"]
    found = branches.locus_arguments(SUBJECT, {"over": over, "event": "fold"})
    assert found == {"over": {"drive_frequency": (0.5, 1.5), "voltage": (0.25, 0.75)}, "event": "fold"}
