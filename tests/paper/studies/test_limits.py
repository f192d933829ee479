"""Studies behind claims alone: the linear limit, small stretch limits, and the fixed-step integrator."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from gelcone.codes import Outcome
from gelcone.motion.attractor.classification import Evidence
from gelcone.motion.swing import Swing
from gelcone.paper.effort import QUICK
from gelcone.paper.fixed_step import fixed_step
from gelcone.paper.studies import limits
from gelcone.paper.studies.limits import (
    STARTS,
    STEP,
    _reach,
    beyond,
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
