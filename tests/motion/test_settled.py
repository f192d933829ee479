"""The settled motion and its harmonics: phases in degrees, and none of what does not move."""

import numpy as np
import pytest

from gelcone import frequency, settled
from gelcone.motion.state_space import small_signal_response
from gelcone.motion.swing import Swing
from gelcone.physics.model import ConeModel

SMALL = ConeModel(
    voltage=1e-4, voltage_bias=0.3, rest_height=0.3, spring_stiffness=2.0, damping_ratio=0.2, drive_frequency=0.8
)


def test_phases_are_degrees_ahead_of_the_voltage():
    """Of a small motion about a bias the first phase is that of linear theory; the third harmonic is rounding."""
    result = settled(SMALL, (0.3, 0.0))
    linear = small_signal_response(SMALL, [0.8])
    assert result["harmonic_phase"].attrs["units"] == linear["phase"].attrs["units"] == "degree"
    assert float(result["harmonic_phase"][0]) == pytest.approx(float(linear["phase"][0]), abs=1e-3)
    assert -179.0 < float(linear["phase"][0]) < -1.0
    assert np.isnan(result["harmonic_phase"].values[2:]).all()


def test_what_does_not_move_has_no_phase():
    still = ConeModel(voltage=0.2, damping_ratio=0.3, drive_frequency=[0.4, 0.8])
    at_rest = settled(still, (0.3, 0.0))
    assert at_rest["resting"].values.all()
    assert np.isnan(at_rest["harmonic_phase"].values).all()
    swept = frequency(still.replace(drive_frequency=0.4), [0.4, 0.5], (0.3, 0.0))
    assert np.isnan(swept["harmonic_phase"].values).all()
    assert np.isnan(small_signal_response(still.replace(drive_frequency=0.4), [0.4])["phase"].values).all()


def test_rounding_is_that_of_the_largest_displacement_on_either_side():
    found = Swing.blank(1)
    found.lowest[:], found.highest[:] = -1.0, 1e-3
    found.harmonics[:] = [0.5, 5e-13, 1e-3j, -1e-9]
    np.testing.assert_allclose(found.phases, [[0.0, np.nan, 90.0, 180.0]])
