"""The lowest and highest displacement between samples, against runs that are sampled finely."""

import numpy as np
import pytest

import gelcone
from gelcone.motion import extent as module
from gelcone.motion.extent import extent
from gelcone.motion.flow import integrate
from gelcone.motion.swing import settled_swing
from gelcone.presets import find_preset

SLOW = find_preset("base").model.replace(voltage=[0.97, 0.98])
WRINKLING = gelcone.ConeModel(film="wrinkling", voltage=[0.3, 0.5], drive_frequency=0.5, rest_height=0.3)


def fine(members, start, time):
    """The extent of motions by 200,000 samples, with the parabola that is left between them below 1e-12."""
    x = integrate(members, start, np.linspace(0.0, 1.0, 200_001)[None] * time[:, None]).states[..., 0]
    return x.min(axis=1), x.max(axis=1)


@pytest.mark.parametrize("model", [SLOW, WRINKLING], ids=["slow drive", "wrinkling"])
def test_the_extent_of_few_samples_is_that_of_many(model):
    members, start = model.members(), np.tile([0.4, 0.1], (2, 1))
    time = 2.0 * np.broadcast_to(members.drive_period, members.shape)
    run = integrate(members, start, np.linspace(0.0, 1.0, 513)[None] * time[:, None])
    for own, true in zip(extent(members, run.times, run.states), fine(members, start, time), strict=True):
        np.testing.assert_allclose(own, true, atol=2e-7)


def test_a_motion_that_has_ended_has_none():
    members = SLOW.members()
    times = np.tile([0.0, 1.0, 2.0], (2, 1))
    states = integrate(members, np.tile([0.4, 0.1], (2, 1)), times).states
    states[1, 2] = np.nan
    low, high = extent(members, times, states)
    assert np.isfinite([low[0], high[0]]).all()
    assert np.isnan([low[1], high[1]]).all()


def test_settled_motions_and_branches_have_the_same_extent():
    """A cycle of the slowly driven base set, whose branch is sampled from node to node."""
    model = SLOW.replace(voltage=0.97)
    swing = settled_swing(model.members(), np.array([[1.0, 0.0]]))
    low, high = fine(model.members(), swing.final, 2.0 * np.ravel(model.drive_period))
    assert (swing.lowest[0], swing.highest[0]) == pytest.approx((low[0], high[0]), abs=1e-9)
    branches = gelcone.continue_branch(model, "voltage", 0.9699, 0.9701, initial=swing.final[0])
    kept = branches.isel(branch=int(np.argmax(~branches["resting"].values.astype(bool))))
    order = np.argsort(kept["value"].values)
    value = kept["value"].values[order]
    shown = [np.interp(0.97, value, kept[name].values[order]) for name in ("lowest", "highest")]
    assert shown == pytest.approx([low[0], high[0]], abs=1e-6)


def test_a_turn_on_a_sample_is_that_sample_and_one_between_two_is_beyond_both(monkeypatch):
    """Of x = sin t, whose quintic is known."""
    times = np.array([[0.0, 0.5 * np.pi, 2.0, 3.0], [0.0, 1.0, 2.0, 3.0]])
    states = np.stack([np.sin(times), np.cos(times)], axis=-1)
    states[0, 1, 1] = 0.0
    asked = []

    def acceleration(members, at, z):
        asked.append(at.tolist())
        return -np.sin(at)

    monkeypatch.setattr(module, "acceleration_at", acceleration)
    monkeypatch.setattr(module, "UNSURE", -1.0)  # nothing is integrated
    low, high = extent(SLOW.members(), times, states)
    assert asked == [[[1.0, 2.0]]]
    np.testing.assert_array_equal(low, [0.0, 0.0])
    assert high[0] == 1.0
    assert high[1] == pytest.approx(1.0, abs=2e-4)
    assert high[1] > np.sin(2.0)


@pytest.mark.parametrize("samples", [32, 128])
def test_a_disc_that_the_stretch_limit_turns_like_a_wall_turns_there(samples, monkeypatch):
    """Its velocity changes by 30 within a hundredth of a forcing period: quintics miss its extremes."""
    model = gelcone.ConeModel(damping_ratio=0.06, spring_stiffness=0.3, drive_frequency=0.9, voltage=[2.1, 2.4])
    members, start = model.members(), np.tile([1.0, 0.0], (2, 1))
    time = 3.0 * np.broadcast_to(members.drive_period, members.shape)
    run = integrate(members, start, np.linspace(0.0, 1.0, 6 * samples + 1)[None] * time[:, None])
    true = fine(members, start, time)
    assert np.max(true) > 6.8
    found = extent(members, run.times, run.states)
    np.testing.assert_allclose(found, true, atol=3e-5)  # as many samples as a bounce would take show no more digits
    monkeypatch.setattr(module, "UNSURE", -1.0)  # nothing is integrated
    assert np.abs(np.subtract(extent(members, run.times, run.states), true)).max() > 1e-3


def test_only_turning_points_that_may_be_extremes_are_integrated(monkeypatch):
    """The lowest is at most the smallest upper bound of all turning points, the highest at least the largest lower."""
    found, apart = np.array([-2.0, 3.0, -1.5, 3.5, -0.5, 2.0]), np.array([0.6, 0.4, 0.2, 0.5, 0.01, 0.2])
    times = np.arange(7.0)[None]
    states = np.stack([np.zeros(7), (-1.0) ** np.arange(7)], axis=-1)[None]
    states[0, 0, 0], states[0, -1, 0] = -0.25, 0.25
    asked = []

    def reached(members, t, z, rows, first, flow):
        asked.append((rows.tolist(), first.tolist(), flow))
        return np.array([-1.2, 3.6, -1.7, 3.1])

    monkeypatch.setattr(module, "_on_quintics", lambda *given: (found.copy(), apart))
    monkeypatch.setattr(module, "_reached", reached)
    low, high = extent(SLOW.take([0]).members(), times, states, tolerance=0.5)
    # with twice the distance as the error: the lowest is at most -1.5 + 0.4, the highest at least 3.5 - 1.0
    assert asked == [([0] * 4, [0, 1, 2, 3], {"tolerance": 0.5})]
    assert (low[0], high[0]) == (-1.7, 3.6)
