"""Thresholds of the corrected model: where they are read off, and what is lost with a film that pulls in."""

import numpy as np
import pytest
import xarray as xr

from gelcone import ConeModel
from gelcone.paper.studies import continuum as module
from tests.paper.test_unwrinkled import CONE, film_like_the_cone

VOLTAGES = np.array([0.1, 0.2, 0.4, 0.7])


@pytest.mark.parametrize(
    ("met", "interval"),
    [
        ([False, False, True, True], (0.2, 0.4)),
        ([False, True, False, True], (0.1, 0.2)),
        ([True, True, True, True], (0.1, 0.1)),
        ([False, False, False, True], (0.4, 0.7)),
    ],
)
def test_a_threshold_lies_between_the_last_voltage_without_and_the_first_with(met, interval):
    assert module._first(VOLTAGES, np.array(met)) == interval


def test_what_is_never_met_has_no_threshold():
    assert np.isnan(module._first(VOLTAGES, np.zeros(4, dtype=bool))).all()


def test_the_onset_of_a_film_that_is_the_cone_is_the_cones_and_nothing_is_lost():
    model = CONE.replace(damping_ratio=0.05, drive_frequency=0.3)
    found = module._onset("onset", model, film_like_the_cone())
    assert np.isnan(found.lost)
    np.testing.assert_allclose(found.corrected, found.cone, rtol=1e-9)
    assert found.cone[1] > found.cone[0] > 0.0


def test_a_film_that_pulls_in_before_rest_is_lost_says_at_which_voltage():
    """The flat film's highest V is 1/0.04; with a stiff spring rest is stable up to there."""
    film = film_like_the_cone(ceiling=(0.04,))
    model = CONE.replace(spring_stiffness=200.0, damping_ratio=0.2, drive_frequency=0.9)
    found = module._onset("onset", model, film)
    assert np.isnan(found.corrected).all()
    assert found.lost == pytest.approx(5.0, rel=1e-12)


def test_the_pitchfork_of_a_film_with_another_stiffness_carries_the_error_of_its_fit():
    pytest.importorskip("skfem")
    model = ConeModel(law="neo-hookean", spring_stiffness=0.09)
    found = module._pitchfork("pitchfork", model, film_like_the_cone(radius_ratio=0.2))
    assert found.cone == pytest.approx((0.3, 0.3), rel=1e-9)
    middle = 0.5 * sum(found.corrected)
    assert middle == pytest.approx(0.3, rel=1e-9)
    assert 0.0 < found.corrected[1] - found.corrected[0] < 0.1


def test_last_bits_of_the_linear_algebra_do_not_reach_the_report():
    """Values keep 8 digits of the largest one, estimates of error 3."""
    force = xr.DataArray(np.array([123.456789012345, 1e-9, np.nan]), name="force", attrs={"units": "1"})
    rounded = module._rounded(force)
    assert rounded.values[:2].tolist() == [123.45679, 0.0]
    assert np.isnan(rounded.values[2])
    assert rounded.attrs == force.attrs
    other = module._rounded(force * (1.0 + 1e-13))
    assert np.array_equal(other.values, rounded.values, equal_nan=True)
    assert module._rounded(force.rename("force_error")).values[0] == 123.0
    assert module._rounded(force * 0.0).values[0] == 0.0
