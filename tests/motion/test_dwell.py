"""How long functions are positive along motions, by exact times: against the same integration at many more times."""

import numpy as np
import pytest

from gelcone.motion.dwell import Path, dwell_times
from gelcone.motion.flow import integrate
from gelcone.physics.model import ConeModel

MODEL = ConeModel(damping_ratio=[0.05, 0.2], voltage=0.4, rest_height=0.3, spring_stiffness=2.0, drive_frequency=0.7)
TIMES = np.linspace(0.0, 20.0, 201)


@pytest.fixture(scope="module")
def motion():
    members = MODEL.members()
    run = integrate(MODEL, (0.6, 0.0), np.broadcast_to(TIMES, (2, TIMES.size)))
    return Path(members, run.times, run.states)


def lasted(path, level):
    """Of x above and of x below a level."""

    def functions(members, times, states):
        return np.stack([states[..., 0] - level, level - states[..., 0]])

    return dwell_times(path, functions, functions(path.members, path.times, path.states))


def test_times_above_a_level_are_those_of_a_fine_sampling(motion):
    fine = np.linspace(0.0, 20.0, 400_001)
    x = integrate(MODEL, (0.6, 0.0), np.broadcast_to(fine, (2, fine.size))).states[..., 0]
    found, error = lasted(motion, 0.31)
    np.testing.assert_allclose(found.sum(axis=2)[0], (x > 0.31).mean(axis=1) * 20.0, atol=5e-4)
    np.testing.assert_allclose(found.sum(axis=0), np.broadcast_to(np.diff(TIMES), (2, TIMES.size - 1)), rtol=1e-13)
    assert (error < 1e-4).all()
    halved, _ = lasted(Path(motion.members, motion.times[:, ::2], motion.states[:, ::2]), 0.31)
    assert (np.abs(halved.sum(axis=2) - found.sum(axis=2)) < 1e-4).all()


def test_a_passing_between_two_samples_is_found_from_either_side(motion):
    """Levels just inside of the turning points, by the parabola with the acceleration there; the samples miss it."""
    x, u = motion.states[0, :, 0], motion.states[0, :, 1]
    k = int(np.flatnonzero((u[1:-1] > 0.0) & (u[2:] < 0.0))[2]) + 1
    fine = np.linspace(TIMES[k], TIMES[k + 1], 20_001)
    near = integrate(MODEL.take(0), motion.states[0, k], fine[None], start=TIMES[k]).states[0, :, 0]
    level = 0.5 * (near.max() + max(x[k], x[k + 1]))
    above, below = lasted(motion, level)[0][:, 0, k]
    width = (near > level).mean() * (TIMES[k + 1] - TIMES[k])
    assert 0.0 < width < 0.1
    assert above == pytest.approx(width, abs=1e-5)
    assert below == pytest.approx(TIMES[k + 1] - TIMES[k] - width, abs=1e-5)


def test_where_a_motion_has_ended_nothing_lasts(motion):
    states = motion.states.copy()
    states[1, 50:] = np.nan
    found, _ = lasted(Path(motion.members, motion.times, states), 0.31)
    assert (found[:, 1, 49:] == 0.0).all()
    np.testing.assert_array_equal(found[:, 0], lasted(motion, 0.31)[0][:, 0])
