"""Small motions about a rest, and motions of one harmonic, against the rates of the model."""

import numpy as np
import pytest

from gelcone.lab.periodic import at_rest, balanced, linear_motion, small_motion
from gelcone.motion.settled import settled
from gelcone.physics.model import ConeModel

CREEPS = {"film": "taut", "viscous_modulus_1": 0.4, "rest_height": 0.6, "voltage_bias": 0.3, "voltage": 0.0}


@pytest.mark.parametrize("time", [1e-2, 1.0, 1e3])
def test_small_motions_swing_as_the_eigenvalues_of_differences_say(time):
    """Of all eigenvalues the pair that swings counts, however slowly or fast the film creeps."""
    members = ConeModel(**CREEPS | {"voltage_bias": 0.0}, relaxation_time_1=time, damping_ratio=0.05).members()
    z, slopes = at_rest(members, np.array([0.35]), np.zeros(1))
    moved = z + 1e-6 * np.concatenate([np.eye(z.shape[1]), -np.eye(z.shape[1])])
    rates = np.stack(members.take(np.zeros(len(moved), int)).flow(np.zeros(len(moved)), moved)[0], axis=-1)
    by_differences = (rates[: z.shape[1]] - rates[z.shape[1] :]).T / 2e-6
    np.testing.assert_allclose(slopes[0], by_differences, atol=1e-6 * max(1.0, 1.0 / time))
    swings = [value for value in np.linalg.eigvals(by_differences) if value.imag > 1e-3]
    frequency, decay = small_motion(members, np.array([0.35]))
    assert len(swings) == 1
    assert frequency[0] == pytest.approx(swings[0].imag, rel=1e-4)
    assert decay[0] == pytest.approx(-swings[0].real, rel=1e-3, abs=1e-5)


def test_an_overdamped_disc_does_not_swing():
    members = ConeModel(film="taut", rest_height=0.3, damping_ratio=5.0).members()
    assert np.isnan(small_motion(members, np.array([0.2]))).all()


def test_a_balanced_motion_has_the_amplitude_and_phase_of_the_settled_one():
    model = ConeModel(
        film="taut", rest_height=0.6, voltage_bias=0.4, voltage=0.02, drive_frequency=0.9, damping_ratio=0.05
    )
    found = settled(model)
    rest = 0.5 * float(found["highest"] + found["lowest"])
    mean, sine, cosine = balanced(model.members(), linear_motion(model.members(), np.array([rest])))[0, 0]
    assert mean == pytest.approx(rest, rel=1e-3)
    assert 2.0 * np.hypot(sine, cosine) == pytest.approx(float(found["stroke"]), rel=1e-3)
    linear = linear_motion(model.members(), np.array([mean]))[0]
    assert linear[0, 1:] == pytest.approx([sine, cosine], rel=0.02)
    np.testing.assert_allclose(linear[1, 1:], 0.9 * np.array([-linear[0, 2], linear[0, 1]]), rtol=1e-9)
