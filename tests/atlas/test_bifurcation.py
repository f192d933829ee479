"""Diagrams: walks up and down, the states from which changes are narrowed down, and the list of changes."""

import numpy as np
import pytest
import xarray as xr

from gelcone.atlas import bifurcation as module
from gelcone.atlas.bifurcation import thresholds_of
from gelcone.atlas.plan import Plan
from gelcone.atlas.threshold import Threshold
from gelcone.codes import Outcome, Regime
from gelcone.errors import InputError
from gelcone.motion.attractor.classification import Evidence
from gelcone.motion.start import nudge
from gelcone.physics.model import ConeModel

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
        assert found.tolist() == [0.7, 0.1]
    else:
        np.testing.assert_allclose(found, nudge(np.full((1, 2), expected), module.NUDGE)[0])
    evidence.final[:] = np.nan
    assert module._met({"fixed": PLAN}, change, evidence, VALUES).tolist() == [0.7, 0.1]


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
    assert [row["cascade"] for row in earlier] == [False] * 3
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

    def thresholds(plans, runs, bisections, threads, progress):
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
