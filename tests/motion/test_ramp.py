"""Slow ramps: stroke, blocked force and the work of a cycle."""

import json

import numpy as np
import pytest

from gelcone import (
    ConeModel,
    PullIn,
    static,
    stroke_and_blocked_force,
)
from gelcone.motion import ramp, static_bifurcations
from tests.motion.balances import MODEL, TABLE1


def test_stroke_and_blocked_force_are_those_of_the_rest_position():
    model = TABLE1.replace(rest_height=0.1)
    voltages = np.array([0.0, 0.5, 1.0])
    result = stroke_and_blocked_force(model, voltages)
    rest = float(result.rest_displacement)
    assert model.force(rest) == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(result.blocked_force, [-model.force(rest, v) for v in voltages], atol=1e-15)
    assert float(result.stroke[0]) == 0.0
    np.testing.assert_allclose(
        [model.force(x, v) for x, v in zip(result.displacement.values, voltages, strict=True)], 0.0, atol=1e-14
    )


@pytest.mark.parametrize("film", ["taut", "wrinkling"])
def test_the_work_of_a_cycle_is_the_area_between_the_forces(film):
    model = ConeModel(rest_height=0.4, spring_stiffness=0.8, hoop_prestretch=1.4, film=film)
    levels = [0.0, 0.2, 0.4]
    wide = static(model, levels)
    rest = float(wide["rest_displacement"])
    for k, level in enumerate(levels):
        end = rest + float(wide["stroke"][k])
        x = np.linspace(rest, end, 2001)
        force = static(model, [0.0, level], x)["force"] if end > rest else np.zeros((2, 2001))
        area = float(np.trapezoid(force[0] - force[-1], x))
        assert float(wide["cycle_work"][k]) == pytest.approx(area, rel=1e-6, abs=1e-15)
        if film == "taut":  # the field pushes by v^2 x
            assert area == pytest.approx(level**2 * (end**2 - rest**2) / 2.0, rel=1e-6)


def test_beyond_pull_in_there_is_no_work_of_a_cycle():
    result = static(ConeModel(film="wrinkling", rest_height=0.4), [0.1, 5.0])
    assert np.isnan(result["cycle_work"].values).tolist() == [False, True]


def test_a_ramp_starts_where_it_is_asked_to(balances):
    """For all members, or for each its own."""
    found = static_bifurcations.pull_in_voltage(MODEL, start=[0.25, 0.75])
    assert found["rest_displacement"].values.tolist() == [0.25, 0.75]
    assert found["pull_in_from"].values.tolist() == [8.25, 8.75]
    assert json.loads(found.attrs["options"])["start"] == [0.25, 0.75]
    found = ramp.stroke_and_blocked_force(MODEL, [0.5, 1.0], start=0.25)
    assert found["rest_displacement"].values.tolist() == [0.25] * 2
    assert found["displacement"].values.tolist() == [[0.5, 1.25]] * 2
    assert found["blocked_force"].values.tolist() == [[0.0625, 0.25]] * 2
    assert found["losses"].values.tolist() == [[1.0, 2.0], [2.0, 3.0]]
    voltage, kind = static_bifurcations.jump_voltages(MODEL)
    assert (voltage.tolist(), kind.tolist()) == ([0.625, 1.25], [PullIn.FOLD] * 2)


def test_the_ramp_of_a_drive_is_that_of_its_balance(balances):
    """The blocked force is that at rest; beyond the film there is no stiffness."""
    levels = np.array([0.5, 1.0])
    (balance,) = static_bifurcations.balances_of(ConeModel())
    found = ramp.drive_ramp(balance, levels)
    assert found.rest == 0.5
    assert found.displacement.tolist() == [0.75, 1.5]
    assert found.stroke.tolist() == [0.25, 1.0]
    assert found.blocked_force.tolist() == [0.125, 0.5]
    np.testing.assert_array_equal(found.stiffness, [3.75, np.nan])
    np.testing.assert_allclose(found.voltages, [levels])
    assert (found.pitchfork, found.pull_in) == (0.5, 0.625)
