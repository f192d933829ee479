"""Self-sensing: the height of a known capacitance is found again."""

from __future__ import annotations

import json

import numpy as np
import pytest

import gelcone
from gelcone.errors import InputError
from tests.motion.pumps import FILMS, device


@pytest.mark.parametrize("kind", FILMS)
def test_a_capacitance_tells_the_height(kind):
    own = device(kind)
    model, s, volts = own.to_model(), own.scales, 600.0
    heights = np.array([5e-3, 12e-3, 18e-3])
    x = heights / s.length
    known = np.asarray(model.film.capacitance(x, (volts / s.voltage) ** 2 + 0.0 * x, [], model.numbers()))
    farads = known * s.size("capacitance")
    found = gelcone.sense(own, farads, voltage=volts, uncertainty=1e-12)
    np.testing.assert_allclose(found.displacement.values, 1e3 * heights, rtol=1e-7)
    again = gelcone.sense(own, farads - 1e-12, voltage=volts)  # the capacitance rises the faster, the higher the disc
    np.testing.assert_allclose(
        np.abs(again.displacement.values - found.displacement.values), found.displacement_error.values, rtol=1e-2
    )
    assert found.displacement_error.attrs["units"] == "mm"


@pytest.mark.parametrize("name", ["weight-cone", "biased-pump"])
@pytest.mark.parametrize("volts", [0.0, 1000.0])
def test_the_capacitance_of_a_membrane_that_film_gives_means_its_height_within_the_error(name, volts):
    """The fit on which devices run is off by up to half a millimetre here."""
    own, heights = gelcone.find_device(name), np.array([0.0, 0.2, 2.0, 5.0, 8.0, 10.0, 40.0])
    farads = 1e-9 * gelcone.film(own, 1e-3 * heights, [volts])["capacitance"].values.ravel()
    found = gelcone.sense(own, farads, voltage=volts)
    distance, error = np.abs(found["displacement"].values - heights), found["displacement_error"].values
    assert (distance <= error).all()
    assert (error[2:] < 0.03).all()
    wider = gelcone.sense(own, farads, voltage=volts, uncertainty=2e-12)["displacement_error"].values
    rate = np.diff(farads[3:6]) / np.diff(heights[3:6])
    assert wider[4] - error[4] == pytest.approx(2e-12 / rate.mean(), rel=0.2)


@pytest.mark.parametrize(("name", "volts"), [("biased-pump", 1400.0), ("snap-cone", 1400.0)])
def test_the_height_is_within_its_error_next_to_states_that_are_not_found_and_where_the_capacitance_bends(name, volts):
    own, heights = gelcone.find_device(name), np.array([0.1, 0.2, 1.0, 9.0, 30.606])
    farads = 1e-9 * gelcone.film(own, 1e-3 * heights, [volts])["capacitance"].values.ravel()
    there = np.isfinite(farads)
    assert there[:3].all()
    found = gelcone.sense(own, farads[there], voltage=volts)
    assert (np.abs(found["displacement"] - heights[there]) <= found["displacement_error"]).all()


def test_a_membrane_that_has_pulled_in_at_every_height_gives_none():
    found = gelcone.sense(gelcone.find_device("biased-pump"), ["0.6 nF"], voltage="9 kV")
    assert np.isnan(found["displacement"]).all()


def test_a_capacitance_that_no_height_has_gives_none():
    found = gelcone.sense(device(), ["1 pF", "1 mF"])
    assert np.isnan(found.displacement.values).all()
    with pytest.raises(InputError, match="at least 0"):
        gelcone.sense(device(), ["1 nF"], uncertainty=-1e-12)


@pytest.mark.parametrize("kind", FILMS)
def test_heights_are_found_wherever_the_film_has_a_state(kind):
    """From just above its plane to the largest height that is searched, in the model's own units."""
    model = device(kind).to_model()
    high = min(2.99, model.film.reach(model.numbers())[1] - 1e-3)
    x = np.array([1e-3, 0.2, 1.0, 2.0, high])
    known = np.asarray(model.film.capacitance(x, 0.0 * x, [], model.numbers()))
    found = gelcone.sense(model, known, uncertainty=1e-3)
    np.testing.assert_allclose(found.displacement.values, x, rtol=1e-6)
    slope = np.gradient(np.asarray(model.film.capacitance(np.linspace(0.9, 1.1, 3), np.zeros(3), [], model.numbers())))
    assert float(found.displacement_error[2]) == pytest.approx(1e-3 / (slope[1] / 0.1), rel=1e-2)
    beyond = gelcone.sense(model, [known[0] - 0.1, known[-1] * 1.5])
    assert np.isnan(beyond.displacement.values).all()
    assert np.isnan(beyond.displacement_error.values).all()


def test_a_sense_of_height_says_with_which_error():
    model = gelcone.ConeModel(rest_height=0.8, hoop_prestretch=1.4)
    found = gelcone.sense(model, [1.3, 1.5], voltage=0.2, uncertainty=0.01)
    x = found["displacement"].values
    np.testing.assert_allclose(1.0 + x * x, [1.3, 1.5], rtol=1e-9)  # of the cone
    np.testing.assert_allclose(found["displacement_error"], x - np.sqrt(x * x - 0.01), rtol=1e-6)
    assert json.loads(found.attrs["options"]) == {"voltage": 0.2, "uncertainty": 0.01}
    assert (gelcone.sense(model, [1.3])["displacement_error"] == 0.0).all()


def test_next_to_the_flat_film_the_height_is_within_its_error_of_the_plane():
    """Where the capacitance does not rise with the height at first, its error is not that of a slope."""
    model = gelcone.ConeModel(rest_height=0.8, hoop_prestretch=1.4)
    found = gelcone.sense(model, [1.0001, 0.999, 0.98], uncertainty=0.01)
    np.testing.assert_allclose(found["displacement"], [0.01, 0.0, np.nan], atol=1e-9)
    np.testing.assert_allclose(found["displacement_error"], [np.sqrt(0.0101) - 0.01, np.sqrt(0.009), np.nan], atol=1e-9)
