"""Branches beside a bifurcation diagram: in one file, in its figure, in its JSON."""

import numpy as np
import pytest

import gelcone
from gelcone.analyses.answer import result_json
from gelcone.atlas.branches.attached import KEPT, attach, attached_branches
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
    assert (followed.attrs["mirror"], followed.attrs["parameter"]) == (1, "voltage")  # of a film flat at rest


def test_what_is_attached_comes_back_as_it_was(diagram):
    followed = gelcone.continue_branch(
        gelcone.find_device("biased-pump").replace(film="taut"),
        "frequency", "9.5 Hz", "10 Hz", start="settled", switch=0, checks=2,
    )  # fmt: skip
    assert any("along" in variable.attrs for variable in followed.variables.values())
    together = attach(diagram.drop_vars([v for v in diagram.variables if v.startswith("followed_")]), followed)
    again = attached_branches(together)
    assert together.attrs["parameter"] == diagram.attrs["parameter"] != followed.attrs["parameter"]
    assert set(again.variables) == set(followed.variables)
    for name, variable in followed.variables.items():
        assert again[name].dims == variable.dims
        assert again[name].attrs == variable.attrs, name
        np.testing.assert_array_equal(again[name].values, variable.values)
    for name in ("mirror", "parameter"):
        assert again.attrs[name] == followed.attrs[name]
    assert again.attrs["mirror"] == 0  # a spring pushes the disc to one side
    assert set(KEPT) == {"mirror", "parameter"}


def test_the_parameter_of_branches_in_earlier_files_is_that_of_the_diagram(diagram):
    earlier = diagram.assign_attrs()
    del earlier.attrs["followed_parameter"]
    assert attached_branches(earlier).attrs["parameter"] == "voltage"


def test_branches_survive_the_file(diagram, tmp_path):
    gelcone.save(diagram, tmp_path / "diagram.nc")
    again = attached_branches(gelcone.load(tmp_path / "diagram.nc"))
    np.testing.assert_array_equal(again["orbit"], attached_branches(diagram)["orbit"])
    assert (
        attached_branches(diagram.drop_vars([v for v in diagram.variables if str(v).startswith("followed_")])) is None
    )


def test_figure_and_json_hold_the_branches(diagram):
    axes = gelcone.plot(diagram).axes[0]
    lines = [line for line in axes.lines if len(line.get_xdata()) > 30]
    assert len(lines) > 3
    assert "mirror image" in [text.get_text() for text in axes.get_legend().get_texts()]
    kinds = result_json(diagram)["followed_event_kind"]
    assert "loss_of_rest" in kinds
    assert "period_doubling" in kinds
