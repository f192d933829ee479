"""Studies behind claims alone: the linear limit, small stretch limits, and the fixed-step integrator."""

import json
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import quad

from gelcone.codes import Outcome
from gelcone.dataset import model_of
from gelcone.motion.attractor.classification import Evidence
from gelcone.motion.swing import Swing
from gelcone.paper.effort import QUICK
from gelcone.paper.fixed_step import fixed_step
from gelcone.paper.studies import limits
from gelcone.paper.studies.limits import (
    STARTS,
    STEP,
    beyond,
    limit_map,
    linear_limit,
)
from gelcone.paper.studies.study import reach_of
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


def test_the_free_oscillator_has_the_film_that_was_asked_for():
    found = computed(linear_limit, replace(TINY, film="wrinkling"))
    model = model_of(found)
    assert (model.film.name, float(model.stretch_limit), float(model.damping_ratio)) == ("wrinkling", np.inf, 0.0)
    assert found["period_ratio"].values[0] == pytest.approx(1.0, abs=1e-5)


def test_the_reach_is_where_the_film_meets_its_limit():
    model = find_preset("fast").model.replace(stretch_limit=np.array([0.5, 10.0]))
    reach = reach_of(model)
    np.testing.assert_allclose(model.strain(reach), [0.5, 10.0], rtol=1e-12)
    assert reach[0] == pytest.approx(1.0)  # q + 1/q - 2 = 1/2 at q = 2


def test_small_limits_start_from_half_of_what_they_allow():
    found = computed(beyond)
    limits = found["stretch_limit"].values
    assert (limits[0], limits[-1], limits.size) == (pytest.approx(0.02), pytest.approx(2.0), 4)
    np.testing.assert_allclose(found["initial_strain"], 0.5)
    np.testing.assert_allclose(
        2.0 * found["inside_start"], reach_of(find_preset("fast").model.replace(stretch_limit=limits))
    )
    assert (found["fixed_step_beyond"].values[limits < 0.5] > 0.0).all()
    assert (found["outcome"] == Outcome.OK).all()
    run = fixed_step(find_preset("fast").model.replace(stretch_limit=limits), (1.0, 0.0), STEP, 800)
    np.testing.assert_array_equal(found["fixed_step_exponent"], run.exponent)


def test_the_map_of_limits_covers_its_ranges(monkeypatch):
    seen = {}

    def mapped(model, over, initial, **options):
        seen.update(model=model, over=over, initial=initial, options=options)
        from gelcone.paper.studies.study import merged

        options["progress"](1.0)
        return merged()

    monkeypatch.setattr(f"gelcone.atlas.maps.{NAME}", mapped)
    found = computed(limit_map)
    assert found.attrs["preset"] == "fast"
    assert seen["initial"] == find_preset("fast").initial
    assert seen["options"]["patience"] == 300.0
    for name, low, high in (("voltage", 0.7, 1.6), ("stretch_limit", 0.52, 50.0)):
        assert (seen["over"][name][0], seen["over"][name][-1]) == pytest.approx((low, high))
    assert list(seen["over"]) == ["voltage", "stretch_limit"]


NAME = "map"
"""Of the public function that computes a map."""


def test_large_limits_are_followed_from_nearby_starts(monkeypatch):
    """Below the loss of stability of rest the motion dies out at every limit and from every start."""
    monkeypatch.setattr(limits, "LARGE", (100.0, 1000.0))
    monkeypatch.setattr(limits, "OWN_VOLTAGE", 0.4)
    model = find_preset("fast").model.replace(voltage=np.array([0.3, 0.4]))
    found = limits._extents(model, (1.0, 0.0), TINY)
    assert found["extent"].dims == ("member", "limit", "start")
    assert found["extent"].shape == (2, 2, STARTS)
    assert found["extent"].values.max() < 1e-3


def test_an_extent_is_the_farthest_on_either_side(monkeypatch):
    """Of each voltage, limit and start, in this order."""

    def made(members, states):
        own = Swing.blank(members.size)
        own.lowest[:] = -members.values["voltage"] * np.where(members.values["stretch_limit"] > 200.0, 3.0, 0.1)
        own.highest[:] = np.linspace(0.4, 0.5, members.size)
        return own

    def classified(members, states, **options):
        evidence = Evidence.blank(members.size)
        evidence.regime[:] = np.arange(members.size) % 4
        return evidence

    monkeypatch.setattr(limits, "LARGE", (100.0, 1000.0))
    monkeypatch.setattr(limits, "swing", made)
    monkeypatch.setattr(limits, "classify", classified)
    model = find_preset("fast").model.replace(voltage=np.array([0.3, 0.4]))
    found = limits._extents(model, (1.0, 0.0), TINY)
    sizes = np.linspace(0.4, 0.5, 4 * STARTS).reshape(2, 2, STARTS)
    sizes[:, 1] = [[0.9] * STARTS, [1.2] * STARTS]
    np.testing.assert_allclose(found["extent"], sizes)
    np.testing.assert_array_equal(found["regime"].values.ravel(), np.arange(4 * STARTS) % 4)


def test_the_window_of_small_limits_is_that_of_the_effort_and_all_are_of_the_members_own(monkeypatch):
    """The integrator takes the paper's start and its own step; the true motion begins at half the reach of each."""
    asked, shares = {}, []
    count = TINY.limit_map[1]
    numbers = np.arange(1.0, count + 1.0)

    class Run:
        exponent, beyond = numbers, 0.1 * numbers

    def fixed(model, initial, step, steps):
        asked.update(fixed=(initial, step, steps), model=model)
        return Run()

    def classified(members, states, **options):
        asked.update(states=states, options=options)
        found = Evidence.blank(members.size)
        found.exponents[:] = numbers[:, None] * [1.0, -1.0]
        found.standard_error[:] = numbers[:, None] * [0.01, 0.02]
        found.regime[:] = numbers
        return found

    monkeypatch.setattr(limits, "fixed_step", fixed)
    monkeypatch.setattr(limits, "classify", classified)
    found = beyond(replace(TINY, window=41.0), shares.append)
    preset = find_preset("fast")
    assert asked["fixed"] == (preset.initial, STEP, 820)
    half = 0.5 * reach_of(asked["model"])
    np.testing.assert_allclose(asked["states"], np.stack([half, np.zeros(count)], axis=1))
    assert asked["options"] == {"patience": 300.0}
    np.testing.assert_array_equal(found["fixed_step_exponent"], numbers)
    np.testing.assert_array_equal(found["fixed_step_beyond"], 0.1 * numbers)
    np.testing.assert_array_equal(found["lyapunov"], numbers[:, None] * [1.0, -1.0])
    np.testing.assert_array_equal(found["standard_error"], numbers[:, None] * [0.01, 0.02])
    np.testing.assert_array_equal(found["regime"], numbers)
    assert sum(shares) == pytest.approx(1.0)
    assert json.loads(found.attrs["options"]) == {"step": STEP, "window": 41.0}


def test_large_limits_have_a_sample_of_other_voltages_and_the_papers_own(monkeypatch):
    asked, shares = {}, []

    class Run:
        states = np.arange(3.0 * 2001 * 2).reshape(3, 2001, 2)

    def sampled(samples, effort, progress, read):
        asked.update(samples=samples, read=read)
        progress(1.0)
        return xr.Dataset({"extent": (("point", "limit", "start"), np.ones((4, 3, 2)))})

    def integrate(model, states, times):
        asked.update(model=model, states=states, times=times)
        return Run()

    def extents(model, initial, effort):
        asked.update(own=(model.size, float(model.voltage[0]), initial))
        at = ("member", "limit", "start")
        return xr.Dataset({"extent": (at, np.full((1, 3, 2), 7.0)), "regime": (at, np.full((1, 3, 2), 2))})

    monkeypatch.setattr(limits, "sampled", sampled)
    monkeypatch.setattr(limits, "integrate", integrate)
    monkeypatch.setattr(limits, "_extents", extents)
    found = limits.large_limits(TINY, shares.append)
    preset = find_preset("fast")
    assert sum(shares) == pytest.approx(1.0)
    (sample,) = asked["samples"]
    assert (sample.preset, dict(sample.drawn), sample.costly) == ("fast", {"voltage": (0.5, 1.7)}, True)
    assert asked["read"] is extents
    np.testing.assert_array_equal(asked["model"].stretch_limit, [100.0, 300.0, 1000.0])
    np.testing.assert_array_equal(asked["model"].voltage, [1.005] * 3)
    np.testing.assert_array_equal(asked["states"], [preset.initial] * 3)
    np.testing.assert_allclose(asked["times"], np.linspace(0.0, 40.0, 2001))
    assert asked["own"] == (1, 1.005, preset.initial)
    np.testing.assert_array_equal(found["displacement"], Run.states[..., 0])
    assert (found["own_extent"] == 7.0).all()
    assert (found["own_regime"] == 2).all()
    assert found["own_extent"].dims == ("limit", "start")
    np.testing.assert_array_equal(found["limit"], [100.0, 300.0, 1000.0])


def test_extents_start_on_both_sides_and_fail_where_any_start_does(monkeypatch):
    asked = {}

    def classified(members, states, **options):
        asked.update(states=states, members=members, options=options)
        found = Evidence.blank(members.size)
        found.outcome[3] = Outcome.STRETCH_LIMIT
        return found

    monkeypatch.setattr(limits, "LARGE", (100.0, 1000.0))
    monkeypatch.setattr(limits, "classify", classified)
    monkeypatch.setattr(limits, "swing", lambda members, states: Swing.blank(members.size))
    model = find_preset("fast").model.replace(voltage=np.array([0.3, 0.4]))
    found = limits._extents(model, (1.0, 0.5), TINY)
    rows = STARTS * 4
    offsets = np.tile(limits.NEARBY * np.linspace(-1.0, 1.0, STARTS), 4)
    np.testing.assert_allclose(asked["states"], np.array([1.0, 0.5]) + offsets[:, None], rtol=1e-15)
    np.testing.assert_array_equal(asked["members"].values["voltage"], np.repeat([0.3, 0.4], 2 * STARTS))
    np.testing.assert_array_equal(
        asked["members"].values["stretch_limit"], np.tile(np.repeat([100.0, 1000.0], STARTS), 2)
    )
    assert asked["options"] == {"patience": 300.0, "budget": limits.SIGN_BUDGET}
    np.testing.assert_array_equal(found["outcome"], [Outcome.STRETCH_LIMIT, Outcome.OK])
    assert rows == asked["members"].size
