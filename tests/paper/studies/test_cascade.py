"""The cascade that leads to chaos in the base set: where it ends, and on which branch."""

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.atlas.branches.branch import EventKind
from gelcone.dataset import flags
from gelcone.paper.studies import cascade as module
from gelcone.paper.studies.cascade import cascade
from gelcone.presets import find_preset
from gelcone.words import event_label


@pytest.mark.slow
def test_the_doublings_of_the_base_set_end_at_the_threshold_of_chaos():
    model = find_preset("base").model
    followed = gelcone.continue_branch(model, "voltage", 0.93, 1.003, switch=0, checks=2)
    found = cascade(model, followed)
    doublings = found["doubling"][1]
    assert doublings[:3] == pytest.approx([1.0012791592, 1.0249821545, 1.0276379323], abs=1e-9)
    end, error = found["cascade_end"][1], found["cascade_end_error"][1]
    assert abs(end - 1.02830633) < 2.0 * error < 1e-5
    _, value, about = found["cascade_born"]
    assert value == pytest.approx(0.9392035806, abs=1e-9)
    assert about["born"] == "loss of rest"


def test_without_doublings_there_is_no_cascade():
    model = find_preset("base").model
    followed = gelcone.continue_branch(model, "voltage", 0.945, 0.955, switch=0, checks=2)
    assert cascade(model, followed) == {}


def test_a_cascade_ends_where_feigenbaums_ratio_says():
    """Doublings whose distances shrink by exactly that ratio, towards 2: each level gives the same end."""
    ratio = 4.66920160910299
    doublings = [2.0 - ratio**-k for k in range(4)]
    followed = xr.Dataset({"event_value": ("event", [1.5]), "event_kind": ("event", [0])})
    found = module._cascade_variables(followed, doublings, None)
    assert found["cascade_end"][1] == pytest.approx(2.0, abs=1e-12)
    assert found["cascade_end_error"][1] < 1e-12
    assert np.isnan(found["cascade_born"][1])


FOLD, DOUBLING, LOSS = EventKind.FOLD, EventKind.PERIOD_DOUBLING, EventKind.LOSS_OF_REST
KINDS = [FOLD, DOUBLING, DOUBLING, FOLD, DOUBLING, DOUBLING, DOUBLING]
FOLLOWED = xr.Dataset(
    {
        "event_kind": ("event", KINDS, flags(EventKind)),
        "event_value": ("event", [0.5, 1.9, 1.2, 0.4, 1.1, 1.0, 0.9]),
        "event_branch": ("event", [0, 0, 1, 1, 0, 2, 0]),
        "event_point": ("event", [0, 1, 0, 1, 2, 0, 3]),
        "event_orbit": (("event", "point", "state"), np.arange(28.0).reshape(7, 2, 2)),
        "period": ("branch", [1, 1, 2]),
        "born": ("branch", [-1, 0, 1]),
        "stable": (("branch", "at"), [[1, 1, 1, 0], [1, 0, 0, 0], [1, 0, 0, 0]]),
    },
    attrs={"parameter": "drive_frequency"},
)
"""Stable doublings of period 1 at 1.9, 1.1 and 1.2; an unstable one at 0.9, and one of period 2 at 1."""


def test_the_first_cascade_is_that_of_the_lowest_stable_doubling_of_period_one_that_goes_on(monkeypatch):
    asked = []

    def chain(model, followed, first):
        asked.append(first)
        return [2.0, 2.2, 2.25, 2.26] if first == 2 else [1.0, 2.0]

    monkeypatch.setattr(module, "_chain", chain)
    followed = FOLLOWED.assign(born=("branch", [-1, 3, 1]))
    found = cascade("model", followed)
    assert asked == [4, 2]
    ends = [b + (b - a) / 3.66920160910299 for a, b in ((2.0, 2.2), (2.2, 2.25), (2.25, 2.26))]
    np.testing.assert_array_equal(found["doubling"][1], [2.0, 2.2, 2.25, 2.26])
    assert found["cascade_end"][1] == pytest.approx(ends[2])
    assert found["cascade_end_error"][1] == pytest.approx(ends[1] - ends[2])
    assert found["cascade_born"][1] == 0.4  # where branch 1 of that doubling leaves another; branch 0 begins at 0.5
    assert found["cascade_born"][2]["born"] == event_label(followed["event_kind"][3])


@pytest.mark.parametrize(("count", "there"), [(2, False), (3, True)])
def test_three_doublings_are_a_cascade(monkeypatch, count, there):
    monkeypatch.setattr(module, "_chain", lambda model, followed, first: [1.0, 1.2, 1.24][:count])
    assert bool(cascade("model", FOLLOWED)) == there


def test_a_branch_is_born_where_it_left_another_or_at_its_lowest_fold():
    assert module._birth(FOLLOWED, 1) == 0
    assert module._birth(FOLLOWED, 2) == 1
    several = FOLLOWED.assign(event_kind=("event", [FOLD, FOLD, FOLD, FOLD, FOLD, DOUBLING, LOSS]))
    assert module._birth(several, 0) == 0
    assert module._birth(several.assign(event_value=-several["event_value"]), 0) == 1
    assert module._birth(FOLLOWED.assign(event_kind=("event", [LOSS] * 7)), 0) is None


def test_a_chain_of_doublings_is_followed_from_each_branch_to_the_one_born_on_it(monkeypatch):
    """Those that lie on one branch in its order; it begins at the doubling itself, not at one next to it."""
    asked = {}
    own = xr.Dataset(
        {
            "event_kind": ("event", [DOUBLING, DOUBLING, FOLD, DOUBLING, DOUBLING, DOUBLING]),
            "event_value": ("event", [1.2001, 1.2, 1.21, 1.25, 1.23, 1.24]),
            "event_branch": ("event", [0, 0, 5, 5, 5, 6]),
            "event_point": ("event", [1, 2, 0, 9, 4, 0]),
            "event_born_branch": ("event", [9, 5, -1, 8, 6, -1]),
        }
    )

    def follow(model, parameter, low, high, start_orbit, **options):
        asked.update(model=model, parameter=parameter, ends=(low, high), orbit=start_orbit, options=options)
        return own

    monkeypatch.setattr(module, "continue_branch", follow)
    assert module._chain("model", FOLLOWED, 2) == [1.2, 1.23, 1.24]
    assert (asked["model"], asked["parameter"], asked["orbit"]) == ("model", "drive_frequency", (8.0, 9.0))
    assert asked["ends"] == pytest.approx((1.2 * 0.998, 1.2 * 1.1))
    assert asked["options"] == {"start": "settled", "switch": 4, "checks": 2}
