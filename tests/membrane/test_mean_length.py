"""The mean length of a membrane: 1 at its reference, its polynomial with derivatives, its inverse, and a fit."""

import numpy as np
import pytest

from gelcone.membrane import mean_length as module
from gelcone.membrane.elements import Elements
from gelcone.membrane.gel import Gel
from gelcone.membrane.mean_length import NAMES, fitted, height_of, mean_length, mean_lengths
from gelcone.physics.laws import LAWS

NUMBERS = dict(zip(NAMES, (0.2, 0.5, 0.9, 0.1, -0.05, 0.02, 0.01, -0.01, 0.005), strict=True))
FILM = Elements(Gel(LAWS["gent"], LAWS["gent"].numbers({"stretch_limit": 50.0}), 1.2, 1.2), 0.25, 40)


def test_the_length_and_its_slopes_are_those_of_the_polynomial():
    s = np.array([0.2, 0.5, 1.4, 3.0])
    rise = s - 0.2
    place = (rise - 0.5) / (rise + 0.5)
    expected = 1.0 + rise * np.polynomial.polynomial.polyval(place, [NUMBERS[name] for name in NAMES[2:]])
    length, slope, bend = mean_length(s, NUMBERS)
    np.testing.assert_allclose(length, expected, rtol=1e-13)
    h = 1e-4
    ahead, here, behind = (mean_length(s + k * h, NUMBERS)[0] for k in (1, 0, -1))
    np.testing.assert_allclose(slope, (ahead - behind) / (2.0 * h), rtol=1e-6)
    np.testing.assert_allclose(bend, (ahead - 2.0 * here + behind) / h**2, rtol=1e-4, atol=1e-6)


def test_the_place_of_a_length_is_found_again():
    s = np.array([0.3, 0.7, 1.5])
    found = height_of(mean_length(s, NUMBERS)[0], NUMBERS)
    np.testing.assert_allclose(found - 0.2, s - 0.2, rtol=0.05)


def test_lengths_are_one_at_the_lowest_height_and_are_fitted():
    """A film all of whose rings are stretched alike along the meridian by l has W = l^2 + 1/l^2 - 2, and M = l^2."""
    heights = np.array([0.01, 0.2, 0.6, 1.0])
    found = mean_lengths(FILM, heights)
    assert found[0] == 1.0
    assert (np.diff(found) > 0.0).all()
    at = FILM.unloaded(heights)
    l1, l2, _, _ = FILM.stretches(at)
    m, n = l1**2, FILM.gel.width(l1, l2, np.zeros_like(l1))
    m, n = m / m[0], n / n[0]
    w = FILM.weights @ (m + n + 1.0 / (m * n) - 3.0).T
    np.testing.assert_allclose(found + 1.0 / found - 2.0, w, atol=1e-12)
    numbers = fitted(FILM, 0.0, 1.5)
    assert (numbers["mean_begin"], numbers["mean_scale"]) == (0.0, module.SCALE)
    for x, length in zip(heights[1:], found[1:], strict=True):
        assert mean_length(x * x - module.LOWEST**2, numbers)[0] == pytest.approx(length, rel=2e-3)


@pytest.mark.parametrize(
    ("A", "B", "scale", "error"), [(1.2, 1.2, 0.5, 2e-5), (1.0, 2.25, 0.1, 0.012), (1.21, 1.96, 0.1, 0.005)]
)
def test_lengths_are_fitted_closely_from_the_height_at_which_the_film_begins_to_pull(A, B, scale, error):
    """With a stronger hoop they change most next to the flat film, where the variable of the fit is finer."""
    film = Elements(Gel(LAWS["gent"], LAWS["gent"].numbers({"stretch_limit": 50.0}), A, B), 0.25, 40)
    own, rise = fitted(film, 0.0, 1.5), np.array([1e-4, 0.04, 0.36, 1.0])
    assert own["mean_scale"] == scale
    exact = mean_lengths(film, np.sqrt(rise))
    found = mean_length(rise - rise[0], own)[0]
    np.testing.assert_allclose(found, exact, rtol=error)
    places = np.array([0.05, 0.3, 1.0, 1.4])
    np.testing.assert_allclose(height_of(mean_length(places, own)[0], own), places, rtol=0.05)
