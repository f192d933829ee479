"""Natural frequencies of an oscillator with a known stiffness."""

import numpy as np
import pytest
from scipy.optimize import brentq

import gelcone
from gelcone.motion.natural import ROUNDING, frequency_of, natural_frequency


def test_the_frequency_is_the_root_of_the_stiffness_and_unknown_where_it_is_negative():
    """A stiffness that is negative by rounding is that of a fold."""
    found = frequency_of(np.array([4.0, 0.25, 0.0, -0.5 * ROUNDING, -2.0 * ROUNDING, -1.0, np.nan]))
    np.testing.assert_array_equal(found, [2.0, 0.5, 0.0, 0.0, np.nan, np.nan, np.nan])
    assert frequency_of(9.0) == 3.0


def test_a_flat_film_softens_with_the_square_of_the_voltage_until_its_pitchfork():
    """By V^2 of the stiffness at rest, whichever its sign."""
    model = gelcone.ConeModel(spring_stiffness=0.5, hoop_prestretch=1.3, stretch_limit=8.0)
    stiffness = float(model.stiffness(0.0))
    for share in (0.0, 0.5, 0.9):
        volts = share * np.sqrt(stiffness)
        for sign in (1.0, -1.0):
            expected = np.sqrt(stiffness - volts**2)
            assert float(natural_frequency(model, sign * volts, 0.0)) == pytest.approx(expected, rel=1e-9)
            assert float(natural_frequency(model, sign * volts)) == pytest.approx(expected, rel=1e-6)
    assert np.isnan(natural_frequency(model, 1.01 * np.sqrt(stiffness), 0.0))
    both = natural_frequency(model, np.array([0.0, 0.1]))
    np.testing.assert_allclose(both, np.sqrt(stiffness - np.array([0.0, 0.01])), rtol=1e-6)


def test_a_raised_disc_oscillates_about_where_the_voltage_holds_it():
    """By differences of the force at its root, which the voltage moves."""
    model = gelcone.ConeModel(spring_stiffness=2.0, rest_height=0.6, hoop_prestretch=1.3, stretch_limit=8.0)
    volts, step = np.array([0.0, 0.3, 0.5, -0.5]), 1e-5
    found = natural_frequency(model, volts)
    assert found.shape == volts.shape
    for own, v in zip(found, volts, strict=True):
        x = brentq(lambda x, v=v: float(model.force(x, v)), 0.1, 1.5, xtol=1e-13)
        slope = (float(model.force(x + step, v)) - float(model.force(x - step, v))) / (2.0 * step)
        assert own == pytest.approx(np.sqrt(slope), rel=1e-5)
        assert natural_frequency(model, v, x) == pytest.approx(np.sqrt(slope), rel=1e-6)
    assert found[0] > found[1] > found[2] == found[3]
