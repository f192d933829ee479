"""Multipliers of rings of tangent maps: known ones, however small; what is lost to rounding; two states both ways."""

import numpy as np
import pytest

from gelcone.motion import multipliers as module
from gelcone.motion.cyclic import scaled_product
from gelcone.motion.multipliers import log_multipliers, multipliers_of_rings

TURN = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])


def spread(*blocks):
    """A matrix with numbers and matrices on its diagonal."""
    blocks = [np.atleast_2d(block) for block in blocks]
    whole, at = np.zeros((sum(len(block) for block in blocks),) * 2), 0
    for block in blocks:
        whole[at : at + len(block), at : at + len(block)] = block
        at += len(block)
    return whole


def ring(step, n, seed=3, signs=None):
    """Maps (n, N, N), each that step in other skew bases, whose product, closed by signs, is similar to step^n."""
    bases = np.eye(len(step)) + 0.3 * np.random.default_rng(seed).normal(size=(n, len(step), len(step)))
    maps = [bases[(k + 1) % n] @ step @ np.linalg.inv(bases[k]) for k in range(n)]
    maps[-1] = (np.ones(len(step)) if signs is None else signs)[:, None] * maps[-1]
    return np.stack(maps)


STEPS = {
    "two apart": (spread(0.9, 0.05), [0.9, 0.05]),
    "a pair and two that vanish": (spread(0.8 * TURN, 0.1, 1e-3), [0.8, 0.8, 0.1, 1e-3]),
    "a pair that vanishes": (spread(1.5, 1e-2 * TURN, 1e-5), [1.5, 1e-2, 1e-2, 1e-5]),
    "close and negative": (spread(-0.9, 0.89, -0.1, 0.099), [0.9, 0.89, 0.1, 0.099]),
}


@pytest.mark.parametrize("name", STEPS)
@pytest.mark.parametrize("n", [1, 7, 60])
def test_multipliers_have_all_their_digits_however_small(name, n):
    """1e-3 at each of 60 maps is 1e-180; as a matrix the product holds nothing below 1e-16 of its largest entry."""
    step, moduli = STEPS[name]
    found = multipliers_of_rings(ring(step, n)[None], np.ones(len(step)), 1e-15)
    np.testing.assert_allclose(found.log_modulus[0], n * np.log(moduli), rtol=0.0, atol=n * 1e-9)
    assert (np.abs(found.log_modulus[0] - n * np.log(moduli)) <= 10.0 * found.error[0] + 1e-14 * n).all()
    assert (found.error[0] <= n * 1e-9).all()
    once = np.linalg.eigvals(step)
    wanted = (once / np.abs(once)) ** n
    np.testing.assert_allclose(np.sort_complex(found.direction[0]), np.sort_complex(wanted), atol=1e-8)


def test_a_ring_that_closes_by_a_mirror_has_the_multipliers_of_both():
    signs, step = np.array([-1.0, -1.0, 1.0]), spread(-0.7, 0.2, 1e-4)
    found = multipliers_of_rings(ring(step, 9, signs=signs)[None], signs, 1e-15)
    values = np.exp(found.log_modulus[0]) * found.direction[0]
    np.testing.assert_allclose(values, np.array([-0.7, 0.2, 1e-4]) ** 9, rtol=1e-8)


def test_the_numbers_of_a_ring_do_not_depend_on_the_others():
    steps = [spread(0.9, 0.5, 0.01), spread(0.9 * TURN, 1e-4), spread(0.7, 1e-3 * TURN)]
    maps = np.stack([ring(step, 5, seed=k) for k, step in enumerate(steps)])
    together = multipliers_of_rings(maps, np.ones(3), 1e-15)
    for k in range(3):
        alone = multipliers_of_rings(maps[k : k + 1], np.ones(3), 1e-15)
        for one, other in zip(alone, together, strict=True):
            np.testing.assert_array_equal(one[0], other[k])


def test_a_ring_that_is_not_finite_has_none_and_leaves_the_others():
    maps = np.stack([ring(spread(3.0, 1.0, 0.2), 4)] * 2)
    maps[0, 1] = np.nan
    found = multipliers_of_rings(maps, np.ones(3), 1e-15)
    assert np.isnan(found.log_modulus[0]).all()
    np.testing.assert_allclose(found.log_modulus[1], 4.0 * np.log([3.0, 1.0, 0.2]), atol=1e-12)


def test_errors_bound_what_errors_of_the_maps_change():
    """Maps with random errors of 1e-12 of their largest entries; multipliers down to 1e-6 a map."""
    rng, tolerance = np.random.default_rng(4), 1e-12
    maps = np.stack([ring(spread(0.8 * TURN, 1e-2, 1e-6), 8, seed=k) for k in range(60)])
    found = multipliers_of_rings(maps, np.ones(4), tolerance)
    noise = tolerance * rng.uniform(-1.0, 1.0, maps.shape) * np.abs(maps).max(axis=(2, 3), keepdims=True)
    other = multipliers_of_rings(maps + noise, np.ones(4), tolerance)
    off = np.abs(found.log_modulus - other.log_modulus)
    assert (off[:, 3] > 1e-8).mean() > 0.5
    assert (off < 3.0 * found.error).mean() > 0.97


@pytest.mark.parametrize("n", [1, 8, 40])
def test_an_error_that_all_maps_share_adds_up_around_the_ring(n):
    """Maps that are all too large by their error multiply the largest multiplier by (1 + error)^n."""
    tolerance, maps = 1e-9, np.tile(np.diag([0.9, 0.3, 0.1]), (1, n, 1, 1))
    found = multipliers_of_rings(maps, np.ones(3), tolerance)
    other = multipliers_of_rings(maps * (1.0 + tolerance), np.ones(3), tolerance)
    off = other.log_modulus[0, 0] - found.log_modulus[0, 0]
    assert off == pytest.approx(n * tolerance, rel=1e-4)
    assert off <= 1.001 * found.error[0, 0]


def logs(maps, log_determinant, tolerance=1e-15):
    return log_multipliers(maps, scaled_product(maps), np.atleast_1d(log_determinant), tolerance)


def test_the_last_multiplier_follows_from_the_determinant_where_a_map_does_not_hold_it():
    """A pair of modulus 0.9, and 1e-30 in one map."""
    maps = np.tile(ring(spread(0.9 * TURN, 1e-30), 1)[None], (1, 7, 1, 1))
    found, error = logs(maps, 7 * np.log(0.9**2 * 1e-30))
    np.testing.assert_allclose(found[0], 7 * np.log([0.9, 0.9, 1e-30]), rtol=1e-10)
    assert (error < 1e-12).all()


def test_two_multipliers_that_the_maps_do_not_hold_are_unknown():
    maps = np.tile(ring(spread(0.9, 1e-20, 1e-30), 1)[None], (1, 7, 1, 1))
    found, error = logs(maps, 7 * np.log(0.9 * 1e-50))
    np.testing.assert_allclose(found[0, 0], 7 * np.log(0.9), rtol=1e-12)
    assert np.isnan(found[0, 1:]).all()
    assert np.isnan(error[0, 1:]).all()


# --- two states -------------------------------------------------------------------------------------------------------


def test_multipliers_of_two_states_are_the_same_by_both_formulas():
    maps = np.random.default_rng(2).normal(size=(60, 4, 2, 2))
    determinants = np.linalg.det(maps)
    positive = determinants.prod(axis=1) > 0.0
    fast, error = logs(maps, np.log(np.abs(determinants)).sum(axis=1))
    slow = multipliers_of_rings(maps, np.ones(2), 1e-15).log_modulus
    np.testing.assert_allclose(slow[positive], fast[positive], rtol=0.0, atol=1e-11)
    assert not error.any()


def test_log_multipliers_of_two_states_equal_eigenvalues_and_stay_exact_where_they_vanish():
    maps = np.random.default_rng(6).normal(size=(50, 5, 2, 2))
    whole = maps[:, 0]
    for k in range(1, 5):
        whole = maps[:, k] @ whole
    positive = np.linalg.det(whole) > 0.0
    found = logs(maps, np.log(np.abs(np.linalg.det(whole))))[0][positive]
    expected = np.sort(np.log(np.abs(np.linalg.eigvals(whole[positive]))), axis=1)[:, ::-1]
    np.testing.assert_allclose(found, expected, atol=1e-9)
    tiny = np.tile(np.diag([1e-3, 1e-9]), (1, 200, 1, 1))
    np.testing.assert_allclose(
        logs(tiny, 200 * np.log(1e-12))[0][0], [200 * np.log(1e-3), 200 * np.log(1e-9)], rtol=1e-12
    )


def test_multipliers_far_apart_do_not_share_a_block():
    """Their frames return to themselves; those of a pair do not."""
    closing, triangles = module._returning(ring(spread(0.9 * TURN, 0.1, 1e-4), 6), np.ones(4))
    assert module._blocks(closing) == [(0, 2), (2, 3), (3, 4)]
    assert (np.tril(triangles, -1) == 0.0).all()
