"""Branches beside a bifurcation diagram: in one file, in its figure, in its JSON."""

import numpy as np
import pytest

import gelcone
from gelcone.analyses.answer import result_json
from gelcone.atlas.branches.attached import attached_branches
from gelcone.presets import find_preset

BASE = find_preset("base").model


@pytest.fixture(scope="module")
def diagram():
    values = [0.93, 0.95, 1.01]
    return gelcone.bifurcation(BASE, "voltage", values, sweeps=(), bisections=0, branches=True)


def test_every_settled_cycle_lies_on_a_branch(diagram):
    followed = attached_branches(diagram)
    assert int(followed["checked_cycles"]) == 2
    assert int(followed["seeded"]) == 0
    assert not followed.sizes["flag"]


def test_branches_survive_the_file(diagram, tmp_path):
    gelcone.save(diagram, tmp_path / "diagram.nc")
    again = attached_branches(gelcone.load(tmp_path / "diagram.nc"))
    np.testing.assert_array_equal(again["orbit"], attached_branches(diagram)["orbit"])
    assert (
        attached_branches(diagram.drop_vars([v for v in diagram.variables if str(v).startswith("followed_")])) is None
    )


def test_figure_and_json_hold_the_branches(diagram):
    lines = [line for line in gelcone.plot(diagram).axes[0].lines if len(line.get_xdata()) > 30]
    assert len(lines) > 3
    kinds = result_json(diagram)["followed_event_kind"]
    assert "loss_of_rest" in kinds
    assert "period_doubling" in kinds
