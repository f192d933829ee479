"""Cells, maps, bifurcation diagrams and basins."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from gelcone import dataset
from gelcone.atlas.bifurcation import bifurcation, thresholds_of
from gelcone.atlas.cells import Plan, join
from gelcone.atlas.grid import basin, parameter_map
from gelcone.errors import InputError
from gelcone.model import ConeModel
from gelcone.motion.floquet import onset_voltage
from gelcone.motion.regime import Evidence, Regime

FAST = ConeModel(damping_ratio=0.05, spring_stiffness=0.5, drive_frequency=0.3)
QUICK = {"transient": 300.0, "budget": 1500.0, "rounds": 2}


def test_cells_do_not_depend_on_order_or_grouping():
    plan = Plan(FAST, {"voltage": np.linspace(0.3, 1.7, 5), "stretch_limit": np.array([0.3, 1.2, 50.0])}, **QUICK)
    whole = plan.run(threads=2)
    order = np.random.default_rng(1).permutation(plan.size)
    parts = join([plan.compute(order[:4], threads=1), plan.compute(order[4:], threads=1)])
    for field in fields(Evidence):
        np.testing.assert_array_equal(getattr(parts, field.name), getattr(whole, field.name)[order])


def test_cells_outside_the_stretch_limit_do_not_stop_the_map():
    plane = parameter_map(FAST, {"stretch_limit": [0.3, 5.0, 50.0], "voltage": [0.3, 1.2]}, **QUICK)
    assert (plane["regime"].sel(stretch_limit=0.3) == Regime.LEFT_THE_DOMAIN).all()
    assert (plane["outcome"].sel(stretch_limit=[5.0, 50.0]) == 0).all()
    assert plane["regime"].dims == ("stretch_limit", "voltage")
    model = dataset.model_of(plane)
    np.testing.assert_array_equal(model.voltage, [[0.3, 1.2]] * 3)


def test_the_first_threshold_is_the_onset_of_rest():
    onset = float(onset_voltage(FAST)["onset_voltage"])
    values = onset * np.array([0.8, 0.9, 1.1, 1.2])
    diagram = bifurcation(FAST, "voltage", values, initial=((0.01, 0.0),), sweeps=(), bisections=5, **QUICK)
    first = thresholds_of(diagram)[0]
    assert first["from"] == "rest"
    assert first["low"] - 0.01 * onset < onset < first["high"] + 0.01 * onset
    assert first["high"] - first["low"] == pytest.approx(0.2 * onset / 2**5)


def test_sweeps_up_and_down_show_hysteresis():
    """Between its folds a lifted film of small stiffness keeps the side it comes from."""
    model = ConeModel(
        damping_ratio=0.1,
        spring_stiffness=0.3,
        hoop_prestretch=1.0,
        voltage=0.05,
        voltage_bias=1.2,
        drive_frequency=0.5,
    )
    heights = np.linspace(-0.6, 0.6, 9)
    diagram = bifurcation(
        model, "rest_height", heights, initial=((-0.8, 0.0),), sweeps=("up", "down"), bisections=0, **QUICK
    )
    middle = 0.5 * (diagram["lowest"] + diagram["highest"])
    gap = (middle.sel(branch="up") - middle.sel(branch="down")).values
    assert np.abs(gap[4]) > 0.3
    assert np.abs(gap[[0, -1]]).max() < 1e-3


def test_a_double_well_has_two_mirror_attractors_with_equal_shares():
    model = ConeModel(damping_ratio=0.2, spring_stiffness=1.5, voltage=0.0, voltage_bias=1.5)
    axis = np.linspace(-1.5, 1.5, 8)
    found = basin(model, {"displacement": axis, "velocity": axis}, **QUICK)
    assert found["attractor_share"].values.tolist() == [0.5, 0.5]
    numbers = found["attractor"].values
    assert (numbers != numbers[::-1, ::-1]).all()
    np.testing.assert_allclose(np.sort(found["attractor_highest"]), [-0.98583, 0.98583], atol=1e-4)


def test_results_read_back_as_they_were(tmp_path):
    diagram = bifurcation(FAST, "voltage", [0.2, 0.3], sweeps=(), **QUICK)
    dataset.save(diagram, tmp_path / "diagram.nc")
    assert dataset.load(tmp_path / "diagram.nc").identical(diagram)


@pytest.mark.parametrize(
    ("over", "options", "message"),
    [
        ({"voltge": [0.0, 1.0]}, {}, "did you mean 'voltage'"),
        ({"voltage": [1.0]}, {}, "at least 2"),
        ({"voltage": [1.0, 0.5]}, {}, "must increase"),
        ({"voltage": [-1.0, 0.5]}, {}, "at least 0"),
        ({"voltage": [0.0, 1.0]}, {"budget": 0.0}, "budget"),
        ({"stretch_limit": [0.1, 0.2]}, {}, "must exceed"),
    ],
)
def test_bad_plans_are_refused(over, options, message):
    with pytest.raises(InputError, match=message):
        parameter_map(FAST, over, **options)


def test_sweeps_and_states_are_checked():
    with pytest.raises(InputError, match="'sideways'"):
        bifurcation(FAST, "voltage", [0.1, 0.2], sweeps=("sideways",))
    with pytest.raises(InputError, match="initial"):
        bifurcation(FAST, "voltage", [0.1, 0.2], initial=())
