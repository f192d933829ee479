"""Diagrams: walks up and down, the states from which changes are narrowed down, and the list of changes."""

import json

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.atlas import bifurcation as module
from gelcone.atlas.bifurcation import thresholds_of
from gelcone.atlas.plan import Plan
from gelcone.atlas.threshold import Threshold
from gelcone.codes import Outcome, Regime
from gelcone.errors import InputError
from gelcone.motion.attractor.classification import Evidence
from gelcone.motion.start import nudge
from gelcone.physics.model import ConeModel
from tests.recorded import numbers, record

VALUES = np.array([0.1, 0.2, 0.3, 0.4])
OPTIONS = {"transient": None, "patience": None, "budget": 1.0, "tolerance": 1e-9}
PLAN = Plan(ConeModel(), {"voltage": VALUES}, (0.7, 0.1), options=OPTIONS)


def test_each_sweep_walks_in_its_order_from_where_it_was_and_anew_where_it_failed(monkeypatch):
    """A motion settles at its voltage; at 0.3 every one fails."""
    walked, starts = [], []

    def settle(members, states, repeats, **options):
        volts = members.values["voltage"]
        walked.append(volts.tolist())
        failed = np.isclose(volts, 0.3)
        return np.stack([volts, 0.0 * volts], axis=1), np.where(failed, Outcome.PULLED_IN, Outcome.OK)

    def classify(plan, members, states, threads, progress=None):
        starts.append(states)
        evidence = Evidence.blank(members.size)
        evidence.final[:] = members.values["voltage"][:, None]
        return evidence

    monkeypatch.setattr(module, "settle", settle)
    monkeypatch.setattr(module, "_classify", classify)
    found = module._sweep(PLAN, ["up", "down"], None, lambda share: None)
    assert walked == [[0.1, 0.4], [0.2, 0.3], [0.3, 0.2], [0.4, 0.1]]
    up, down = starts[0].reshape(2, 4, 2)
    moved = {v: nudge(np.array([[v, 0.0]]), module.NUDGE)[0] for v in VALUES.tolist()}
    np.testing.assert_allclose(up, [[0.7, 0.1], moved[0.1], moved[0.2], [0.7, 0.1]])
    np.testing.assert_allclose(down, [moved[0.2], [0.7, 0.1], moved[0.4], [0.7, 0.1]])
    for name in ("up", "down"):
        np.testing.assert_allclose(found[name].final[:, 0], VALUES)
    assert module._sweep(PLAN, [], None, lambda share: None) == {}


@pytest.mark.parametrize(("branch", "expected"), [("up", 0.2), ("down", 0.3), ("fixed", None)])
def test_a_change_is_narrowed_down_from_the_side_from_which_it_is_reached(branch, expected):
    evidence = Evidence.blank(4)
    evidence.final[:] = VALUES[:, None]
    change = Threshold(branch, Regime.REST, Regime.PERIODIC, 0.2, 0.3)
    found = module._met({"fixed": PLAN}, change, evidence, VALUES)
    if expected is None:
        assert found.tolist() == [[0.7, 0.1]]
    else:
        np.testing.assert_allclose(found, nudge(np.full((1, 2), expected), module.NUDGE))
    evidence.final[:] = np.nan
    assert module._met({"fixed": PLAN}, change, evidence, VALUES).tolist() == [[0.7, 0.1]]


def test_a_change_out_of_chaos_is_narrowed_down_from_several_of_its_states(monkeypatch):
    """Four section points of a sweep, four starts 1e-9 apart of a fixed state, and the one state of a cycle."""
    evidence = Evidence.blank(4)
    evidence.regime[:] = Regime.PERIODIC, Regime.PERIODIC, Regime.CHAOTIC, Regime.CHAOTIC
    evidence.final[:] = VALUES[:, None]
    evidence.section[:] = numbers(4, 64, 2)
    down = Threshold("down", Regime.PERIODIC, Regime.CHAOTIC, 0.2, 0.3)
    found = module._met({"fixed": PLAN}, down, evidence, VALUES)
    np.testing.assert_allclose(found, nudge(evidence.section[2, [15, 31, 47, 63]], module.NUDGE))
    up = Threshold("up", Regime.PERIODIC, Regime.CHAOTIC, 0.2, 0.3)
    assert module._met({"fixed": PLAN}, up, evidence, VALUES).shape == (1, 2)
    fixed = Threshold("fixed", Regime.PERIODIC, Regime.CHAOTIC, 0.2, 0.3)
    found = module._met({"fixed": PLAN}, fixed, evidence, VALUES)
    np.testing.assert_allclose(found - [0.7, 0.1], np.outer(1e-9 * np.arange(4), [1.0, 0.0]), rtol=0, atol=1e-15)


def test_changes_are_listed_by_branch_and_value():
    diagram = xr.Dataset(
        {
            "threshold_branch": ("threshold", ["up", "down", "up"]),
            "threshold_from": ("threshold", [Regime.REST, Regime.CHAOTIC, Regime.PERIODIC]),
            "threshold_to": ("threshold", [Regime.PERIODIC, Regime.REST, Regime.CHAOTIC]),
            "threshold_low": ("threshold", [0.5, 0.7, 0.2]),
            "threshold_high": ("threshold", [0.6, 0.8, 0.3]),
            "threshold_cascade": ("threshold", [0, 1, 0]),
        },
        attrs={"parameter": "voltage"},
    )
    found = thresholds_of(diagram)
    assert [(row["branch"], row["from"], row["to"], row["low"], row["high"], row["cascade"]) for row in found] == [
        ("down", "chaotic", "rest", 0.7, 0.8, True),
        ("up", "periodic", "chaotic", 0.2, 0.3, False),
        ("up", "rest", "periodic", 0.5, 0.6, False),
    ]
    assert {row["parameter"] for row in found} == {"voltage"}
    earlier = thresholds_of(diagram.drop_vars("threshold_cascade"))
    assert [row["cascade"] for row in earlier] == [row["of_one_path"] for row in earlier] == [False] * 3
    with pytest.raises(InputError, match="was given another result"):
        thresholds_of(diagram.drop_vars("threshold_branch"))


def test_branches_have_the_names_of_their_starts():
    assert module._name((1.0, -0.25)) == "from 1,-0.25"
    assert module._name(None) == "from its own start"
    assert module._states(ConeModel(), None) == [(1.0, 0.0)]
    assert module._states(ConeModel(), [(0.1, 0.0), (0.2, 0.3)]) == [(0.1, 0.0), (0.2, 0.3)]
    with pytest.raises(InputError, match="initial: is empty"):
        module._states(ConeModel(), [])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"sweeps": ("left",)}, "must be 'up' or 'down'"), ({"bisections": -1}, "must be at least 0"),
        ({"parameter": "displacement"}, "belongs to the initial state"),
        ({"initial": [(1.0, 0.0), (1.0, 0.0)]}, "holds a state twice"),
    ],
)  # fmt: skip
def test_diagrams_that_cannot_be_are_refused(arguments, message):
    given = {"parameter": "voltage", "values": [0.1, 0.2]} | arguments
    with pytest.raises(InputError, match=message):
        module.bifurcation(ConeModel(), **given)


@pytest.mark.parametrize("sweeps", [(), ("up",), ("up", "down", "up")])
def test_each_branch_has_its_share_of_the_progress(monkeypatch, sweeps):
    """Two fixed states and each sweep once; what is left goes to the thresholds."""
    shares, before = [], []

    def classify(plan, members, states, threads, progress=None):
        progress(1.0)
        before.append(sum(shares))
        return Evidence.blank(members.size)

    def sweep(plan, once, threads, progress):
        for _ in once:
            progress(1.0)
        return {}

    def thresholds(plans, runs, whole, bisections, threads, progress):
        before.append(sum(shares))
        progress(1.0)
        return {}

    for name, stand_in in (("_classify", classify), ("_sweep", sweep), ("_thresholds", thresholds)):
        monkeypatch.setattr(module, name, stand_in)
    states = [(0.7, 0.1), (0.2, 0.0)]
    module.bifurcation(ConeModel(), "voltage", VALUES, initial=states, sweeps=sweeps, progress=shares.append)
    branches = 2 + len(set(sweeps))
    assert before == pytest.approx([module.BRANCHES_SHARE * done / branches for done in (1, 2, branches)])
    assert sum(shares) == pytest.approx(1.0)


def test_no_bisection_is_a_number_of_bisections():
    """What is refused then is something else."""
    with pytest.raises(InputError, match="displacement: belongs to the initial state"):
        module.bifurcation(ConeModel(), "displacement", [0.1, 0.2], bisections=0)


# --- what is handed on ------------------------------------------------------------------------------------------------


def test_a_walk_settles_for_the_transient_with_the_tolerance_and_the_threads_of_the_diagram(monkeypatch):
    """The forcing period is pi/0.5 of a sine at 0.5; a walk of two sweeps is two times a quarter of their work."""
    shares = []
    settled = np.zeros((2, 2)), np.zeros(2, dtype=np.int8)
    asked = record(
        monkeypatch, module, settle=settled, transient_of=np.array([20.0, 40.0]), _classify=Evidence.blank(8)
    )
    plan = Plan(ConeModel(drive_frequency=0.5), {"voltage": VALUES}, (0.7, 0.1), options=OPTIONS | {"transient": 11.0})
    module._sweep(plan, ["up", "down"], 5, shares.append)
    assert {call["transient"] for call in asked["transient_of"]} == {11.0}
    for call in asked["settle"]:
        assert call["repeats"].tolist() == [4, 7]
        assert (call["tolerance"], call["threads"]) == (1e-9, 5)
    (kinds,) = asked["_classify"]
    assert (kinds["threads"], kinds["plan"] is plan) == (5, True)
    kinds["progress"](1.0)
    assert shares == pytest.approx([2.0 * module.WALK / 4.0] * 4 + [2.0 * (1.0 - module.WALK)])


def test_a_diagram_hands_each_part_what_it_was_asked_for(monkeypatch):
    """Two starts of their own, and sweeps from the first of them; branches are seeded by the diagram."""
    states, options = [(0.7, 0.1), (0.2, 0.3)], {"transient": 11.0, "patience": 12.0, "budget": 13.0, "tolerance": 2e-9}
    swept, labelled = {"up": Evidence.blank(4)}, xr.Dataset({"made": 1.0})
    own = [Evidence.blank(4), Evidence.blank(4)]
    asked = record(
        monkeypatch, module, _classify=lambda *given: own[len(asked["_classify"]) - 1], _sweep=swept, _label=labelled,
        _thresholds={"found": 2.0}, attach=lambda diagram, followed: diagram.assign(followed=3.0),
    )  # fmt: skip
    followed = []
    monkeypatch.setattr(
        module, "plain", {module.continue_branch: lambda *given, **more: followed.append((given, more))}.__getitem__
    )
    model = ConeModel()
    found = module.bifurcation(
        model, "voltage", VALUES, states, sweeps=("down",), bisections=3, branches=True, threads=5, **options
    )
    assert {name: float(found[name]) for name in found} == {"made": 1.0, "found": 2.0, "followed": 3.0}
    for call, state in zip(asked["_classify"], states, strict=True):
        np.testing.assert_array_equal(call["states"], [state] * 4)
        assert call["members"].number("voltage").tolist() == VALUES.tolist()
        assert (call["threads"], dict(call["plan"].options), call["plan"].initial) == (5, options, state)
    (sweep,), (label,), (thresholds,) = asked["_sweep"], asked["_label"], asked["_thresholds"]
    assert (sweep["sweeps"], sweep["threads"], sweep["plan"].initial) == (("down",), 5, (0.7, 0.1))
    assert list(label["branches"]) == ["up", "from 0.7,0.1", "from 0.2,0.3"]
    assert [label["branches"][name] for name in label["branches"]] == [swept["up"], *own]
    assert label["plan"] is sweep["plan"]
    assert thresholds["branches"] is label["branches"]
    assert {name: plan.initial for name, plan in thresholds["plans"].items()} == {
        "from 0.7,0.1": (0.7, 0.1), "from 0.2,0.3": (0.2, 0.3),
    }  # fmt: skip
    assert (thresholds["bisections"], thresholds["threads"]) == (3, 5)
    assert thresholds["whole"].tolist() == VALUES.tolist()
    (((given), more),) = followed
    assert given == (model, "voltage", 0.1, 0.4, (0.7, 0.1))
    assert more["threads"] == 5
    assert {name: float(more["start"][name]) for name in more["start"]} == {"made": 1.0, "found": 2.0}


def test_a_diagram_holds_the_evidence_of_each_branch_over_the_values():
    """With the numbers of the start and the budgets as its options."""
    up, fixed = Evidence.blank(4), Evidence.blank(4)
    up.lowest[:], fixed.lowest[:] = numbers(4, at=1.0), numbers(4, at=2.0)
    found = module._label(PLAN, {"up": up, "from 0.7,0.1": fixed})
    assert found["branch"].values.tolist() == ["up", "from 0.7,0.1"]
    np.testing.assert_array_equal(found["voltage"], VALUES)
    np.testing.assert_array_equal(found["lowest"], [numbers(4, at=1.0), numbers(4, at=2.0)])
    assert found.attrs["parameter"] == "voltage"
    assert json.loads(found.attrs["options"]) == {"initial": [0.7, 0.1], **OPTIONS}


def test_thresholds_are_narrowed_down_with_the_evidence_from_the_state_that_each_was_met_in(monkeypatch):
    """Two changes on two branches; each tried value starts from its own change's state."""
    one = Threshold("up", Regime.REST, Regime.PERIODIC, 0.1, 0.2)
    other = Threshold("down", Regime.CHAOTIC, Regime.REST, 0.3, 0.4)

    def refined(found, classified, halvings, progress):
        asked["paths"] = classified([other, one, other], np.array([0.31, 0.11, 0.32]))
        one.low, one.high, other.low, other.high = 0.12, 0.13, 0.34, 0.35
        progress(1.0)

    met = {0.1: np.array([[0.1, 9.0]]), 0.3: np.array([[0.3, 9.0], [0.35, 9.0]])}  # two paths out of chaos
    five = Evidence.blank(5)
    five.lowest[:] = np.arange(5.0)
    asked = record(
        monkeypatch, module, changes=lambda branch, values, evidence: [{"up": one, "down": other}[branch]],
        _met=lambda plans, change, evidence, values: met[change.low], refine=refined, _classify=five,
    )  # fmt: skip
    branches = {"up": Evidence.blank(4), "down": Evidence.blank(4)}
    shares = []
    found = xr.Dataset(module._thresholds({"fixed": PLAN}, branches, VALUES, 3, 5, shares.append))
    assert [call["evidence"] for call in asked["changes"]] == [branches["up"], branches["down"]]
    assert [call["evidence"] for call in asked["_met"]] == [branches["up"], branches["down"]]
    (kinds,), (narrowing,) = asked["_classify"], asked["refine"]
    np.testing.assert_allclose(kinds["states"], [[0.3, 9.0], [0.35, 9.0], [0.1, 9.0], [0.3, 9.0], [0.35, 9.0]])
    np.testing.assert_allclose(kinds["members"].number("voltage"), [0.31, 0.31, 0.11, 0.32, 0.32])
    assert (kinds["threads"], narrowing["halvings"]) == (5, 3)
    assert [path.lowest.tolist() for path in asked["paths"]] == [[0.0, 2.0, 3.0], [1.0, 2.0, 4.0]]
    assert shares == [1.0]
    expected = {
        "branch": ["up", "down"], "from": [Regime.REST, Regime.CHAOTIC], "to": [Regime.PERIODIC, Regime.REST],
        "low": [0.12, 0.34], "high": [0.13, 0.35], "cascade": [0, 0], "of_one_path": [0, 1],
    }  # fmt: skip
    assert {name: found[f"threshold_{name}"].values.tolist() for name in expected} == expected


def test_kinds_are_found_chunk_by_chunk_with_the_options_of_the_plan(monkeypatch):
    monkeypatch.setattr(module, "CHUNK", 3)

    def classify(members, states, **options):
        options["progress"](1.0)
        evidence = Evidence.blank(members.size)
        evidence.lowest[:] = states[:, 0] + members.number("voltage")
        return evidence

    asked, shares = record(monkeypatch, module, classify=classify), []
    members, states = ConeModel(voltage=VALUES).members(), numbers(4, 2)
    found = module._classify(PLAN, members, states, 5, shares.append)
    np.testing.assert_allclose(found.lowest, states[:, 0] + VALUES)
    assert shares == [0.75, 0.25]
    for call in asked["classify"]:
        assert {name: call[name] for name in (*OPTIONS, "threads")} == OPTIONS | {"threads": 5}


def test_values_that_make_no_actuator_are_passed_over_and_the_reason_is_stated(monkeypatch):
    """At an end and in between: what is computed is that of the other values; no change is sought across a gap."""
    voltages = np.linspace(0.4, 1.0, 7)
    made = Plan.at

    def without(self, values):
        if np.isin(values["voltage"], voltages[[3, 6]]).any():
            raise InputError("voltage: cannot be; take another")
        return made(self, values)

    few = {"transient": 300.0, "patience": 600.0, "budget": 300.0, "sweeps": ["up"], "bisections": 1}
    model = ConeModel(damping_ratio=0.1, spring_stiffness=0.5, drive_frequency=0.5)
    plain = module.bifurcation(model, "voltage", np.delete(voltages, [3, 6]), **few)
    monkeypatch.setattr(Plan, "at", without)
    found = module.bifurcation(model, "voltage", voltages, **few)
    assert found["voltage"].values.tolist() == voltages.tolist()
    assert found.attrs["impossible"] == "voltage: cannot be; take another"
    assert (found["outcome"].values[:, [3, 6]] == Outcome.IMPOSSIBLE).all()
    rest = found.isel(voltage=[0, 1, 2, 4, 5])
    for name in plain.data_vars:
        if "voltage" in plain[name].dims:
            assert found[name].dtype == plain[name].dtype, name
            np.testing.assert_array_equal(rest[name].values, plain[name].values, str(name))
    assert len(thresholds_of(plain)) == 2
    assert thresholds_of(found) == []
    assert "the first that cannot be made: voltage: cannot be; take another" in gelcone.in_words(found)
    with pytest.raises(InputError, match=r"^voltage: cannot be"):
        module.bifurcation(model, "voltage", voltages[[3, 5]], **few)
