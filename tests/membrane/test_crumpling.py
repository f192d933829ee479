"""A film without tension: the turning points of its voltage."""

import numpy as np
import pytest

from gelcone.membrane.crumpling import crumpling, slope_within, turnings
from gelcone.physics.laws import LAWS


def test_hump_and_valley_of_the_crumpling_voltage_are_its_turning_points():
    """Against a fine grid: it rises to the hump, falls to the valley, and rises on to the stretch limit; a gel that
    stiffens early has neither, one without limit no valley."""
    limits = np.array([5.0, 7.2, 8.0, 20.0, 50.0, 200.0, np.inf])
    law = LAWS["gent"]
    hump, valley = turnings(law, law.numbers({"stretch_limit": limits}))
    assert hump.shape == valley.shape == limits.shape
    for k, limit in enumerate(limits):
        n = law.numbers({"stretch_limit": limit})
        t = np.exp(np.linspace(1e-6, np.log(min(0.5 * (limit + 3.0), 1e4)), 200_001))
        t = t[2.0 * t + t**-2 - 3.0 < limit]
        Vb = crumpling(law, t, n)
        turns = np.flatnonzero(np.diff(np.sign(np.diff(Vb)))) + 1
        found = [place for place in (hump[k], valley[k]) if np.isfinite(place)]
        assert len(found) == turns.size == (0 if limit < 7.3 else 1 if np.isinf(limit) else 2), limit
        np.testing.assert_allclose(found, t[turns], rtol=1e-4)
        for place in found:
            assert float(slope_within(law, place, n)) == pytest.approx(0.0, abs=1e-9)
        middle = np.array([1.2, 0.3 + min(hump[k], 3.0)])
        slopes = (crumpling(law, middle + 1e-6, n) - crumpling(law, middle - 1e-6, n)) / 2e-6
        np.testing.assert_allclose(slope_within(law, middle, n), slopes, rtol=1e-5, atol=1e-8)
    yeoh, values = LAWS["yeoh"], {"yeoh_c2": np.array([[0.02], [-0.002]]), "yeoh_c3": np.array([0.001, 0.0])}
    assert turnings(yeoh, yeoh.numbers(values))[0].shape == (2, 2)
    assert [float(one) for one in turnings(LAWS["neo-hookean"], {})] == [
        pytest.approx(4.0 ** (1 / 3)),
        np.inf,
    ]


def test_turnings_are_those_of_each_film_whatever_the_order_of_films_and_numbers():
    yeoh, c2, c3 = LAWS["yeoh"], np.array([[0.02], [-0.002]]), np.array([0.001, 0.0, -0.0005])
    both = turnings(yeoh, {"yeoh_c2": c2, "yeoh_c3": c3})
    for found, other in zip(both, turnings(yeoh, {"yeoh_c3": c3, "yeoh_c2": c2}), strict=True):
        np.testing.assert_array_equal(found, other)
    for i, j in np.ndindex(2, 3):
        own = turnings(yeoh, {"yeoh_c2": c2[i, 0], "yeoh_c3": c3[j]})
        assert [found[i, j] for found in both] == [pytest.approx(float(one)) for one in own]
    assert len(np.unique(both[0])) > 3
