"""Studies of figure 12: where the frequencies of the sweeps lie."""

import numpy as np
import pytest

from gelcone.paper.studies.resonance import BAND, RESPONSES, STIFFNESSES, _around, _frequencies, natural_frequencies
from gelcone.presets import find_preset


def test_offsets_are_closer_together_in_the_middle():
    offsets = _around(2.0, 21)
    assert (offsets[0], offsets[10], offsets[-1]) == (-2.0, 0.0, 2.0)
    steps = np.diff(offsets)
    assert (steps > 0.0).all()
    assert steps[0] > 3.0 * steps[9]
    # u = 1/2: 0.3/2 + 0.7/8
    assert offsets[15] == pytest.approx(2.0 * (0.15 + 0.0875))


def test_frequencies_are_even_and_denser_around_half_the_natural_one_and_the_natural_one():
    natural = np.array([0.5, 3.0])
    grid = _frequencies(natural, 0.02, 100)
    assert grid.shape == (2, 100)
    for own, row in zip(natural, grid, strict=True):
        assert (np.diff(row) >= 0.0).all()
        assert (row.min(), row.max()) == (BAND[0], BAND[1])
        assert np.sum(np.abs(row - 0.5 * own) <= 0.08 + 1e-12) >= 35
        assert np.sum(np.abs(row - own) <= 0.16 + 1e-12) >= 25
        assert 0.5 * own in row
        assert own in row


def test_strong_damping_does_not_widen_the_bands_without_end():
    own = 1.0
    row = _frequencies(np.array([own]), 5.0, 100)[0]
    assert np.sum((row >= 0.5 - 0.35) & (row <= 0.5 + 0.35)) >= 35
    assert row.min() == BAND[0]


def test_natural_frequencies_rise_with_the_stiffness_and_are_those_of_the_mean_square_voltage():
    model = find_preset("spring").model.replace(spring_stiffness=np.array([5.0, 20.0]))
    found = natural_frequencies(model)
    v = float(np.asarray(model.voltage))
    for kappa, own in zip((5.0, 20.0), found, strict=True):
        one = find_preset("spring").model.replace(spring_stiffness=kappa)
        x = np.linspace(-1.0, 1.0, 200001)
        force = one.force(x, v / np.sqrt(2.0))
        k = np.flatnonzero(np.diff(np.sign(force)) > 0)[0]
        assert own**2 == pytest.approx((force[k + 1] - force[k]) / (x[1] - x[0]), rel=1e-3)
    assert (STIFFNESSES[0], STIFFNESSES[-1], len(STIFFNESSES)) == (0.1, 20.0, 6)
    assert RESPONSES == (0.7, 1.0, 1.5)
