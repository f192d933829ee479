"""Studies behind claims alone: the linear limit, small stretch limits, and the fixed-step integrator."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from gelcone.codes import Outcome
from gelcone.paper.effort import QUICK
from gelcone.paper.fixed_step import fixed_step
from gelcone.paper.studies.limits import (
    STARTS,
    STEP,
    _quarter,
    _reach,
    beyond,
    damping_map,
    large_limits,
    limit_map,
    linear_limit,
)
from gelcone.physics.model import ConeModel
from gelcone.presets import find_preset

TINY = replace(QUICK, name="tiny", limit_map=(2, 4), patience=300.0, window=40.0)


def computed(study, effort=TINY):
    """A study, whose shares of progress add up to one."""
    shares = []
    found = study(effort, shares.append)
    assert sum(shares) == pytest.approx(1.0, abs=1e-6)
    return found


def test_the_period_of_the_free_oscillator_is_that_of_its_energy():
    """T = 4 int_0^a dx/sqrt(2 (E(a) - E(x))), with x = a sin(s)."""
    found = computed(linear_limit)
    kappa = float(find_preset("base").model.spring_stiffness)
    model = ConeModel(damping_ratio=0.0, voltage=0.0, stretch_limit=np.inf, spring_stiffness=kappa)

    def quarter(a):
        def slowness(s):
            return a * np.cos(s) / np.sqrt(2.0 * (float(model.energy(a)) - float(model.energy(a * np.sin(s)))))

        return quad(slowness, 0.0, 0.5 * np.pi - 1e-6)[0]

    amplitudes = found["amplitude"].values
    assert (amplitudes[0], amplitudes[-1], amplitudes.size) == (1e-3, 1.0, 31)
    ratio = found["period_ratio"].values
    assert ratio[0] == pytest.approx(1.0, abs=1e-5)
    for k in (20, 30):
        assert ratio[k] == pytest.approx(4.0 * quarter(amplitudes[k]) / (2.0 * np.pi / np.sqrt(kappa)), rel=1e-4)
    assert (found["outcome"] == Outcome.OK).all()


def test_a_quarter_is_where_a_line_crosses_zero():
    assert _quarter(np.array([0.0, 1.0, 2.0, 3.0]), np.array([4.0, 3.0, -1.0, -2.0])) == 1.75


def test_the_reach_is_where_the_film_meets_its_limit():
    model = find_preset("fast").model.replace(stretch_limit=np.array([0.5, 10.0]))
    reach = _reach(model)
    np.testing.assert_allclose(model.strain(reach), [0.5, 10.0], rtol=1e-12)
    assert reach[0] == pytest.approx(1.0)  # q + 1/q - 2 = 1/2 at q = 2


def test_small_limits_start_from_half_of_what_they_allow():
    found = computed(beyond)
    limits = found["stretch_limit"].values
    assert (limits[0], limits[-1], limits.size) == (pytest.approx(0.02), pytest.approx(2.0), 4)
    np.testing.assert_allclose(found["initial_strain"], 0.5)
    np.testing.assert_allclose(
        2.0 * found["inside_start"], _reach(find_preset("fast").model.replace(stretch_limit=limits))
    )
    assert (found["fixed_step_beyond"].values[limits < 0.5] > 0.0).all()
    assert (found["outcome"] == Outcome.OK).all()
    run = fixed_step(find_preset("fast").model.replace(stretch_limit=limits), (1.0, 0.0), STEP, 800)
    np.testing.assert_array_equal(found["fixed_step_exponent"], run.exponent)


def test_a_fixed_step_is_of_the_fourth_order_and_counts_what_lies_beyond():
    model = ConeModel(damping_ratio=np.array([0.1]), voltage=0.5)
    exact = fixed_step(model, (1.0, 0.0), 0.0025, 1600)
    errors = [
        np.abs(fixed_step(model, (1.0, 0.0), h, n).states[0, -1] - exact.states[0, -1]).max()
        for h, n in ((0.1, 40), (0.05, 80))
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.3)
    assert exact.times[-1] == pytest.approx(4.0)
    assert exact.beyond[0] == 0.0
    outside = fixed_step(model.replace(stretch_limit=0.2), (1.0, 0.0), 0.01, 1)
    assert outside.beyond[0] == 1.0


def test_the_exponent_of_a_fixed_step_run_is_the_growth_of_its_tangent():
    """Overdamped without voltage: the slower rate -zeta + sqrt(zeta^2 - kappa), per unit time."""
    model = ConeModel(damping_ratio=np.array([2.0]), voltage=0.0, spring_stiffness=1.0, law="neo-hookean")
    run = fixed_step(model, (0.0, 0.0), 0.01, 4000)
    assert run.exponent[0] == pytest.approx(-2.0 + np.sqrt(3.0), abs=0.03)


@pytest.mark.parametrize(
    ("study", "preset", "first", "second"),
    [
        (limit_map, "fast", ("voltage", 0.7, 1.6), ("stretch_limit", 0.52, 50.0)),
        (damping_map, "base", ("voltage", 0.5, 2.0), ("damping_ratio", 0.02, 2.0)),
    ],
)
def test_maps_cover_their_ranges(study, preset, first, second, monkeypatch):
    seen = {}

    def mapped(model, over, initial, **options):
        seen.update(model=model, over=over, initial=initial, options=options)
        from gelcone.paper.studies.study import merged

        options["progress"](1.0)
        return merged()

    monkeypatch.setattr(f"gelcone.atlas.maps.{NAME}", mapped)
    found = computed(study)
    assert found.attrs["preset"] == preset
    assert seen["initial"] == find_preset(preset).initial
    assert seen["options"]["patience"] == 300.0
    for name, low, high in (first, second):
        assert (seen["over"][name][0], seen["over"][name][-1]) == pytest.approx((low, high))
    assert seen["over"]["voltage"].size == (3 if study is damping_map else 2)
    assert list(seen["over"]) == [first[0], second[0]]


NAME = "map"
"""Of the public function that computes a map."""


@pytest.mark.slow
def test_large_limits_are_followed_from_nearby_starts():
    found = computed(large_limits)
    assert found["highest"].dims[-1] == "start"
    assert found.sizes["start"] == STARTS
    size = np.fmax(np.abs(found["highest"].values), np.abs(found["lowest"].values))
    # at the lowest voltage the motion is regular, and the same from each start
    np.testing.assert_allclose(size[0], np.broadcast_to(size[0, :, :1], size[0].shape), rtol=1e-6, atol=1e-9)
