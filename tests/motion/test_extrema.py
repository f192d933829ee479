"""Extrema: turning points against SciPy, and what the search for them is given."""

import importlib
import json
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from gelcone.motion.extrema import extrema
from gelcone.motion.flow import integrate
from gelcone.motion.turning import turning_share
from gelcone.physics.model import ConeModel
from tests.motion.sampled import CHAOTIC, PERIODIC, pieces_of
from tests.recorded import numbers, record

extrema_module = importlib.import_module("gelcone.motion.extrema")


def scipy_extrema(model, initial, span):
    """Turning points from a fine SciPy run and root finding on its dense output."""

    def slope(t, state):
        voltage = float(model.voltage_bias) + float(model.voltage) * np.sin(float(model.drive_frequency) * t)
        return [state[1], -float(model.force(state[0], voltage)) - 2.0 * float(model.damping_ratio) * state[1]]

    run = solve_ivp(slope, (0.0, span), initial, "DOP853", rtol=1e-13, atol=1e-14, dense_output=True, max_step=0.05)
    times = np.linspace(0.0, span, 20_001)[1:]
    velocity = run.sol(times)[1]
    at = np.flatnonzero(np.sign(velocity[1:]) != np.sign(velocity[:-1]))
    roots = [brentq(lambda t: run.sol(t)[1], times[i], times[i + 1], xtol=1e-14) for i in at]
    return np.array(roots), run.sol(np.array(roots))[0]


@pytest.mark.parametrize(("model", "repeats"), [(PERIODIC, 8), (CHAOTIC, 1), (PERIODIC.replace(voltage_bias=0.3), 4)])
def test_extrema_agree_with_a_fine_scipy_run(model, repeats):
    times, displacements = scipy_extrema(model, (1.0, 0.0), repeats * float(model.forcing_period))
    result = extrema(model, repeats=repeats, discard=0)
    assert int(result["count"]) == len(times)
    np.testing.assert_allclose(result.time, times, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(result.displacement, displacements, rtol=0.0, atol=1e-8)


def test_extrema_have_no_velocity_and_alternate():
    result = extrema(CHAOTIC, repeats=60, discard=20)
    assert result.sizes["extremum"] > 300
    assert float(abs(result.velocity).max()) < 1e-10
    assert (np.diff(result.time) > 0.0).all()
    assert set(result.maximum.values.tolist()) == {1, -1}
    assert (np.diff(result.maximum) != 0).all()
    assert (np.sign(np.diff(result.displacement)) == result.maximum[1:]).all()
    assert result.time.min() >= 20 * CHAOTIC.forcing_period
    np.testing.assert_allclose((result.time / CHAOTIC.forcing_period) % 1.0, result.phase, rtol=0.0, atol=1e-9)


def test_the_film_turning_the_motion_round_like_a_wall_is_an_extremum():
    """Near the stretch limit the velocity flips within a small part of a sample: Newton's steps leave the bracket."""
    model = ConeModel(
        damping_ratio=0.194,
        spring_stiffness=1.87,
        voltage=2.38,
        voltage_bias=0.5,
        drive_frequency=1.69,
        stretch_limit=4.654,
        prestretch=0.893,
    )
    result = extrema(model, (0.3, 0.0), repeats=40, discard=20)
    assert float(model.strain(result.displacement).max()) > 0.99 * float(model.strain_limit())
    assert float(abs(result.velocity).max()) < 1e-9
    assert (np.diff(result.maximum) != 0).all()


def test_velocity_really_vanishes_where_extrema_say():
    result = extrema(PERIODIC, repeats=3, discard=0)
    states = integrate(PERIODIC, (1.0, 0.0), result.time.values).states[0]
    assert np.abs(states[:, 1]).max() < 1e-10
    np.testing.assert_allclose(states[:, 0], result.displacement, rtol=0.0, atol=1e-12)


def test_a_start_at_rest_is_no_turning_point_but_an_exact_zero_later_is():
    """Released at its amplitude, an undamped motion turns once each half period, also where a sample hits the zero."""
    free = ConeModel(damping_ratio=0.0, voltage=0.0, spring_stiffness=1.0, law="neo-hookean", drive_frequency=1.0)
    result = extrema(free, (1e-3, 0.0), repeats=6, discard=0)
    assert result.maximum.values[:4].tolist() == [-1, 1, -1, 1]
    np.testing.assert_allclose(result.time[:4], np.pi * np.arange(1, 5), rtol=1e-5)
    np.testing.assert_allclose(abs(result.displacement), 1e-3, rtol=1e-11)


def test_a_disc_that_rises_from_a_standstill_turns_at_the_top_first():
    free = ConeModel(damping_ratio=0.0, voltage=0.0, spring_stiffness=1.0, rest_height=0.5, drive_frequency=1.0)
    result = extrema(free, (0.05, 0.0), repeats=4, discard=0)
    assert result.maximum.values[:4].tolist() == [1, -1, 1, -1]
    assert result.time[0] > 1.0
    np.testing.assert_allclose(result.displacement[1::2], 0.05, atol=1e-11)


def test_rest_has_no_extrema():
    result = extrema(ConeModel(damping_ratio=0.5, voltage=0.0), (0.0, 0.0), repeats=5, discard=0)
    assert int(result["count"]) == 0
    assert result.displacement.isnull().all()
    settled = extrema(ConeModel(damping_ratio=0.5, voltage=0.0, rest_height=0.3), (1.0, 0.0), repeats=20)
    assert int(settled["count"]) == 0


def test_a_motion_turns_where_its_velocity_changes_sign_also_from_a_standstill(monkeypatch):
    """Velocity -(1 - t)^3 up to its end at t = 1, where the acceleration is 0 too, and (t - 1)^3 after it; a motion of
    rounding turns nowhere."""
    times = np.array([[0.5, 1.0, 1.5], [0.25, 0.75, 1.25], [0.25, 0.75, 1.25]])
    off = times - 1.0
    size = np.array([[1.0], [1.0], [1e-14]])
    states = np.stack([0.25 * size * off**4, size * off**3], axis=-1)
    monkeypatch.setattr(extrema_module, "acceleration_at", lambda members, t, z: 3.0 * size * (t - 1.0) ** 2)

    def on_quintics(turning, starts, sides, kind):
        begin, end = sides[0].T
        return begin + (end - begin) * turning_share(end - begin, *sides[1:]), starts

    monkeypatch.setattr(extrema_module, "turning_points", on_quintics)
    members = SimpleNamespace(take=lambda rows: SimpleNamespace(forcing_period=2.0))
    piece = SimpleNamespace(times=times, states=states)
    which, rows = extrema_module._turning_points(members, piece, {})
    assert which.tolist() == [0, 1]
    assert rows[:, 3].tolist() == [-1.0, -1.0]  # both fall before
    assert rows[0, 0] == pytest.approx(0.5, abs=1e-3)
    assert rows[1, 0] == pytest.approx(0.5, abs=0.02)


def test_turning_points_of_each_block_are_those_of_its_members_counted_from_the_start_of_the_run(monkeypatch):
    """Members 1 and 2 are sampled alike, and member 0 otherwise; of each block there are two pieces."""
    model = ConeModel(damping_ratio=0.1, drive_frequency=[0.5, 1.0, 1.0], voltage_bias=0.3)
    groups = {16: [0], 32: [1, 2]}
    monkeypatch.setattr(extrema_module, "samples_per_repeat", lambda members, per: np.array([16, 32, 32]))
    states, told = {1: numbers(1, 2, at=3.0), 2: numbers(2, 2, at=4.0)}, []

    def settled(members, states0, repeats, *, progress, tolerance, threads):
        progress(1.0)
        return states[members.size], np.full(members.size, members.size, dtype=np.int8)

    def run(members, begin, repeats, at, *, outcome, progress, tolerance, threads):
        progress(1.0)
        size = members.size
        yield pieces_of(0, 2, f"{size} first", [0] * size)
        yield pieces_of(2, 1, f"{size} second", [size] * size)

    def turning(members, piece, flow):
        return np.arange(members.size), np.column_stack(
            [0.25 + np.zeros(members.size), numbers(members.size, 3, at=9.0)]
        )

    asked = record(monkeypatch, extrema_module, settle=settled, pieces=run, _turning_points=turning)
    found = extrema(model, numbers(3, 2), repeats=3, discard=6, tolerance=2e-9, threads=5, progress=told.append)
    flow = {"tolerance": 2e-9, "threads": 5}
    for before, after, (samples, rows) in zip(asked["settle"], asked["pieces"], groups.items(), strict=True):
        np.testing.assert_array_equal(before["states"], numbers(3, 2)[rows])
        np.testing.assert_array_equal(after["states"], states[len(rows)])
        assert after["outcome"].tolist() == [len(rows)] * len(rows)
        np.testing.assert_allclose(after["shares"], np.arange(samples) / samples)
        assert (before["repeats"], after["repeats"]) == (6, 3)
        for call in (before, after):
            assert {name: call[name] for name in flow} == flow
    assert [call["flow"] for call in asked["_turning_points"]] == [flow] * 4
    assert [call["piece"].states for call in asked["_turning_points"]] == ["1 first", "1 second", "2 first", "2 second"]
    assert sum(told) == pytest.approx(1.0)
    period = 2.0 * np.pi / model.drive_frequency[:, None]
    np.testing.assert_allclose(found["time"], period * [6.25, 8.25])
    np.testing.assert_allclose(found["phase"], 0.25)
    own = np.array([numbers(1, 3, at=9.0)[0], *numbers(2, 3, at=9.0)])
    np.testing.assert_array_equal(found["displacement"], own[:, :1] + [[0.0, 0.0]])
    np.testing.assert_array_equal(found["velocity"], own[:, 1:2] + [[0.0, 0.0]])
    assert found["count"].values.tolist() == [2, 2, 2]
    assert found["outcome"].values.tolist() == [1, 2, 2]
    assert json.loads(found.attrs["options"]) == {"repeats": 3, "discard": 6, "tolerance": 2e-9}
