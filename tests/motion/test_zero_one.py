"""The 0-1 test: maps whose answer is known, at the lengths that the classification uses."""

import numpy as np
import pytest

from gelcone.motion import zero_one as module
from gelcone.motion.zero_one import without_bands, zero_one


def logistic(growth, points, discard=3000):
    """Series of the logistic map, one a growth parameter, (members, points)."""
    growth = np.asarray(growth, dtype=float)
    x, series = np.full(growth.shape, 0.3), []
    for k in range(discard + points):
        x = growth * x * (1.0 - x)
        if k >= discard:
            series.append(x)
    return np.stack(series, axis=1)


@pytest.mark.parametrize("points", [200, 800])
def test_chaos_of_the_logistic_map(points):
    """One band at 3.7 and above; two, four and eight bands below 3.68."""
    assert (zero_one(logistic([3.7, 3.9, 3.99999, 3.62, 3.59, 3.575], points)) > 0.9).all()


@pytest.mark.parametrize("points", [200, 800])
def test_cycles_of_the_logistic_map(points):
    """Periods 1, 2, 4, 8 and the window of period 3: what is left without the bands is rounding, no chaos."""
    assert (np.abs(zero_one(logistic([2.8, 3.2, 3.5, 3.55, 3.83], points))) < 0.1).all()


def test_a_decaying_spiral_is_regular():
    k = np.arange(800)
    series = 0.99**k * np.cos(0.7 * k)
    assert zero_one(series[None])[0] < 0.2


def test_rotations_are_regular():
    turns = np.random.default_rng(1).random((40, 1)) * 2.0 * np.pi
    k = np.arange(800)
    assert zero_one(np.cos(turns * k) + 0.3 * np.cos(2.0 * turns * k + 0.5)).max() < 0.2


def test_noise_is_not_regular():
    assert (zero_one(np.random.default_rng(2).normal(size=(5, 200))) > 0.9).all()


def test_a_dominant_order_of_visits_does_not_hide_chaos():
    """A small chaos on a large period-4 motion, as of narrow bands visited in turn."""
    order = np.tile([5.0, -2.0, -4.0, 1.0], 50)
    assert (zero_one(order + 0.05 * logistic([3.8, 3.95], 200)) > 0.9).all()


def test_a_constant_series_is_regular():
    assert zero_one(np.full((1, 200), 0.7))[0] == pytest.approx(0.0, abs=1e-12)


def test_offset_and_size_do_not_matter():
    series = logistic([3.8, 3.5], 200)
    np.testing.assert_allclose(zero_one(1e3 * series - 5.0), zero_one(series), atol=1e-6)


def test_nan_gives_nan_and_leaves_the_others():
    series = logistic([3.8, 3.9, 3.5], 200)
    expected = zero_one(series)
    series[1, 120] = np.nan
    found = zero_one(series)
    assert np.isnan(found[1])
    np.testing.assert_array_equal(found[[0, 2]], expected[[0, 2]])


def test_series_one_by_one_give_the_same_to_the_last_bit():
    series = logistic(np.linspace(3.5, 4.0, 37), 200)
    together = zero_one(series)
    np.testing.assert_array_equal(together, [zero_one(row[None])[0] for row in series])


def test_no_series_give_no_answers():
    assert zero_one(np.empty((0, 200))).shape == (0,)


def test_without_bands_takes_out_what_repeats_exactly():
    order = np.tile([5.0, -2.0, -4.0], 70)
    rest = np.random.default_rng(3).normal(size=(2, 210))
    np.testing.assert_allclose(without_bands(order + 0.0 * rest), 0.0, atol=1e-12)
    left = without_bands(order + rest)
    assert left.std() == pytest.approx(rest.std(), rel=0.05)


def growth_by_hand(series, angles):
    """K as the paper defines it, one series and one frequency at a time, over lags up to a tenth of the points."""
    found, points = [], len(series)
    for angle in angles:
        walk, path = 0.0 + 0.0j, []
        for k, value in enumerate(series, start=1):
            walk += value * complex(np.cos(angle * k), np.sin(angle * k))
            path.append(walk)
        lags = range(1, points // 10 + 1)
        window = points - points // 10
        spread = [np.mean([abs(path[j + lag] - path[j]) ** 2 for j in range(window)]) for lag in lags]
        found.append(np.corrcoef(list(lags), spread)[0, 1])
    return float(np.median(found))


@pytest.mark.parametrize("seed", [1, 7])
def test_the_growth_rate_is_that_of_the_definition(seed):
    """With other random frequencies for another seed, and the means of the bands taken out beforehand."""
    series = logistic([3.9], 200)
    angles = np.random.default_rng(seed).uniform(np.pi / 5, 4 * np.pi / 5, 9)
    expected = growth_by_hand(without_bands(series)[0], angles)
    assert zero_one(series, frequencies=9, seed=seed)[0] == pytest.approx(expected, abs=1e-10)


def test_more_bands_are_not_taken_for_a_better_fit_because_they_are_more():
    """A second mean always leaves less; only if it leaves less for each degree of freedom are there two bands."""
    noise = np.random.default_rng(11).normal(size=24)
    by_two = noise.reshape(12, 2)
    noise = (by_two - by_two.mean(axis=0)).ravel()
    level = np.sqrt((noise @ noise) / (22 * 24))  # an alternation as large as a degree of freedom of noise
    faint, clear = (noise + share * level * np.tile([1.0, -1.0], 12) for share in (0.9, 1.1))
    one, two = without_bands(np.stack([faint, clear]))
    np.testing.assert_allclose(one, faint, atol=1e-12)
    np.testing.assert_allclose(two, noise, atol=1e-12)


def test_other_frequencies_give_another_growth_and_their_median_counts(monkeypatch):
    series = np.random.default_rng(2).normal(size=(2, 200))
    assert (zero_one(series, seed=1) != zero_one(series, seed=2)).all()
    asked = []
    growth = np.array([[0.1, 0.2, 0.9]])
    monkeypatch.setattr(module, "_mean_square_displacement", lambda walk, lags: asked.append(walk.shape) or None)
    monkeypatch.setattr(module, "_correlation", lambda lags, displacement: growth)
    assert module._median_growth(series[:1], np.array([0.7, 0.8, 0.9])).tolist() == [0.2]
    assert asked == [(1, 3, 200)]


def test_fewer_bands_count_where_more_leave_hardly_less():
    """Each mean that is taken off makes the variance smaller by itself, which does not count."""
    series = np.tile([1.0, 1.0, -1.0, -1.0], 6) + 0.05 * np.tile([1.0, -1.0], 12)
    np.testing.assert_allclose(without_bands(series[None]), [series])
    visits = series + np.tile([0.5, -0.5], 12)  # of two bands
    np.testing.assert_allclose(without_bands(visits[None]), [np.tile([1.0, 1.0, -1.0, -1.0], 6)])
