"""Cycles by Newton's method: near a motion, with their smallest period, multipliers and symmetry."""

import numpy as np
import pytest

from gelcone.atlas.branches.branch import EventKind
from gelcone.atlas.branches.continuation import continue_branch
from gelcone.motion.attractor import cycle
from gelcone.motion.extent import extent
from gelcone.motion.regime import regime
from gelcone.motion.settle import repeats_lasting, settle
from gelcone.physics.model import ConeModel
from gelcone.presets import find_preset

SET = {"spring_stiffness": 0.5, "damping_ratio": 0.05, "drive_frequency": 0.3}


def test_the_sign_of_an_exponent_is_known_beyond_its_error_alone():
    """An exponent that is less certain than three errors, or less than what is resolved, has no sign."""
    cases = [(-0.1, 0.01, -1), (-0.1, 0.06, 0), (0.1, 0.01, 1), (0.1, 0.06, 0), (0.1 * cycle.FLOOR, 0.0, 0)]
    found = cycle.Cycles.blank(len(cases) + 1)
    found.found[:-1] = True
    found.exponents[:, 0], found.error[:, 0] = [*(c[0] for c in cases), -0.1], [*(c[1] for c in cases), 0.01]
    found.distance[:] = 0.0
    assert found.sign.tolist() == [*(c[2] for c in cases), 0]
    assert found.attracting.tolist() == [True, *[False] * len(cases)]


def test_newton_finds_the_cycle_from_a_distance_and_says_how_far_it_was():
    model = ConeModel(**SET, voltage=1.0).members()
    settled, _ = settle(model, np.array([[1.0, 0.0]]), repeats_lasting(model, 2000.0))
    off = settled + np.array([[3e-3, -2e-3]])
    exact, near = (cycle.find_cycles(model, states, np.array([1])) for states in (settled, off))
    size = 1e-3 / 3e-3 * near.distance[0]
    assert exact.found[0]
    assert near.found[0]
    assert exact.distance[0] < 1e-9
    assert 1e-4 < size < 3e-3
    np.testing.assert_allclose(near.exponents, exact.exponents, atol=10 * near.error.max())


def test_a_multiple_of_the_period_gives_the_period():
    model = ConeModel(**SET, voltage=0.8).members()
    settled, _ = settle(model, np.array([[1.0, 0.0]]), repeats_lasting(model, 2000.0))
    found = [cycle.find_cycles(model, settled, np.array([n])) for n in (2, 4, 6)]
    assert [c.period[0] for c in found] == [2, 2, 2]
    assert all(c.symmetric[0] for c in found)
    np.testing.assert_allclose(found[1].exponents, found[0].exponents, atol=1e-9)


@pytest.mark.parametrize("period", [1, 2, 3, 4, 6, 12])
def test_the_period_is_the_smallest_of_all_after_which_a_path_repeats(period):
    path = np.tile(np.random.default_rng(1).normal(size=(1, period, 5, 2)), (1, 12 // period, 1, 1))
    assert cycle._periods(path, np.array([1.0]))[0].tolist() == [period]


def test_no_cycle_is_found_in_the_middle_of_a_decay():
    model = ConeModel(**SET, voltage=1.0).members()
    assert not cycle.find_cycles(model, np.array([[2.5, 0.0]]), np.array([1])).found[0]


def test_the_exponents_of_a_cycle_are_taken_over_its_whole_period():
    model = ConeModel(**SET, voltage=0.8).members()
    settled, _ = settle(model, np.array([[1.0, 0.0]]), repeats_lasting(model, 2000.0))
    for period in (2, 4):
        found = cycle.find_cycles(model, settled, np.array([period]))
        assert found.time[0] == pytest.approx(period * np.pi / 0.3)
    result = regime(ConeModel(**SET, voltage=0.8))
    assert float(result["averaged_time"]) == pytest.approx(2.0 * np.pi / 0.3)


def test_a_cycle_far_from_the_motion_is_not_its_own():
    """Newton's method finds the rest of an undriven film from afar; a motion that has not arrived is not there yet."""
    model = ConeModel(voltage=0.0, damping_ratio=0.1).members()
    near, far = (
        cycle.find_cycles(model, np.array([[share * cycle.SMALLEST_SIZE, 0.0]]), np.array([1])) for share in (0.5, 2.0)
    )
    assert near.distance[0] == pytest.approx(0.5, rel=0.01)
    assert not near.found[0]
    assert not far.found[0]
    closer = cycle.find_cycles(model, np.array([[0.5 * cycle.NEAR * cycle.SMALLEST_SIZE, 0.0]]), np.array([1]))
    assert closer.found[0]
    assert not closer.attracting[0]  # near, but not arrived


def test_the_extremes_of_a_slow_drive_are_sampled_within_every_oscillation(monkeypatch):
    """However many forcing periods are examined, oscillations of period 2 pi / `rate` have 8 samples or more."""
    spacings = []

    def seen(members, times, states, **flow):
        spacings.append(float(np.diff(times).max()))
        return extent(members, times, states, **flow)

    monkeypatch.setattr(cycle, "extent", seen)
    model = ConeModel(spring_stiffness=1.0, damping_ratio=0.1, drive_frequency=0.02, voltage=0.5).members()
    for periods in (1, 3):
        motion = cycle.sampled(model, np.array([[0.5, 0.0]]), periods, 32)
        lowest, highest = cycle.extremes(model, np.array([[0.5, 0.0]]), periods, motion)
        assert -0.5 < lowest[0] < 0.0
        assert highest[0] == 0.5
        assert spacings[-1] <= 2.0 * np.pi / model.rate[0] / 8.0


@pytest.mark.parametrize(
    ("doubling", "period"), [(0.9764654866, 1), (1.0411981671, 8), (1.0413656372, 16)], ids=["1", "8", "16"]
)
def test_the_period_next_to_a_doubling_is_that_of_the_certified_side(doubling, period):
    """Two turns of the cycle that attracts are a cycle, too, where Newton's method almost divides by zero: 8 was 16."""
    fast = find_preset("fast").model
    voltages = doubling + np.array([-1e-5, -1e-6, -1e-6 - 1e-16, 1e-6, 1e-5])
    found = regime(fast.replace(voltage=voltages), transient=3000.0)
    known = found["doubtful"].values == 0
    assert known.sum() >= 4
    expected = np.array([period] * 3 + [2 * period] * 2)
    np.testing.assert_array_equal(found["period"].values[known], expected[known])
    one, other = found["lyapunov"].values[1:3, 0]
    assert one == pytest.approx(other, abs=1e-8), "one rounding apart"


LIGHT = {"spring_stiffness": 0.5, "drive_frequency": 0.3}
DOUBLE = {**LIGHT, "second_film": "taut", "second_flat_height": 0.0}


@pytest.mark.parametrize(
    ("parameters", "between", "distance"),
    [
        ({**LIGHT, "damping_ratio": 0.05}, (0.84, 0.856), 3e-6),
        ({**LIGHT, "damping_ratio": 0.01}, (0.836, 0.838), 3e-7),
        ({**DOUBLE, "damping_ratio": 0.05, "second_drive": "same"}, (0.595, 0.602), 1e-6),
    ],
    ids=["slow", "fast", "double cone"],
)
def test_the_symmetry_next_to_a_breaking_is_that_of_the_certified_side(parameters, between, distance):
    """Next to a breaking the map over the whole turn is almost singular, and Newton's method ended off its cycle."""
    model = ConeModel(**parameters, voltage=0.5)
    branches = continue_branch(model, "voltage", *between, (0.0, 0.12), start="settled", switch=0, checks=2)
    (event,) = np.flatnonzero(branches["event_kind"] == EventKind.SYMMETRY_BREAKING)
    breaking, orbit = float(branches["event_value"][event]), branches["event_orbit"].values[event, 0]
    offsets = 1e-3 * np.array([[1.0, 0.0], [1.0 + 1e-9, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    voltages = breaking + np.repeat([-30.0, -1.0, 1.0, 30.0], len(offsets)) * distance
    found = regime(model.replace(voltage=voltages), np.tile(orbit + offsets, (4, 1)))
    known = found["doubtful"].values == 0
    assert known[: 2 * len(offsets)].all()
    assert known.mean() > 0.8
    np.testing.assert_array_equal(found["symmetric"].values[known], (voltages < breaking)[known])
    assert (found["period"].values[known] == 2).all()
    one = found["lyapunov"].values[len(offsets) : 2 * len(offsets), 0]
    np.testing.assert_allclose(one, one[0], rtol=1e-3)
