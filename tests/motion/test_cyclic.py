"""Linear equations of shooting: solutions satisfy the equations as written, however many segments are merged."""

import numpy as np
import pytest

from gelcone.motion.cyclic import left_weights, scaled_product, solve_ring

N = 3


def ring(n, growth=1.0, seed=0):
    random = np.random.default_rng(seed)
    tangents = growth * random.normal(size=(n, N, N))
    right, columns = random.normal(size=(n, N, 2)), random.normal(size=(n, N, 1))
    rows, corner, top = random.normal(size=(1, n, N)), random.normal(size=(1, 1)), random.normal(size=(1, 2))
    return tangents, np.array([-1.0, 1.0, -1.0]), right, columns, rows, corner, top


@pytest.mark.parametrize("n", [1, 5, 8, 24, 64])
@pytest.mark.parametrize("growth", [0.3, 30.0])
def test_solution_satisfies_the_equations(n, growth):
    tangents, signs, right, columns, rows, corner, top = ring(n, growth)
    x, unknowns = solve_ring(tangents, signs, right, columns, rows, corner, top)
    ahead = np.concatenate([x[1:], signs[:, None] * x[:1]])
    scale = np.abs(x).max() * max(growth, 1.0)
    np.testing.assert_allclose(ahead - tangents @ x - columns @ unknowns, right, atol=1e-11 * scale)
    np.testing.assert_allclose(np.einsum("qki,kic->qc", rows, x) + corner @ unknowns, top, atol=1e-11 * scale)


@pytest.mark.parametrize("n", [4, 32])
def test_weights_annihilate_the_equations(n):
    tangents, signs, _, columns, rows, corner, _ = ring(n, 0.4)
    weights, last = left_weights(tangents, signs, columns, rows, corner)
    before = np.concatenate([signs * weights[-1:], weights[:-1]])
    # what every node meets in the equations, and the column
    np.testing.assert_allclose(before - np.einsum("kij,ki->kj", tangents, weights) + last * rows[0], 0.0, atol=1e-10)
    assert -np.sum(weights * columns[..., 0]) + last * corner[0, 0] == pytest.approx(1.0, abs=1e-10)


@pytest.mark.parametrize("size", [2, N])
def test_product_of_any_number_of_maps_keeps_its_scale(size):
    tangents = np.random.default_rng(3).normal(size=(4, 7, size, size)) * 1e30
    whole, scales = scaled_product(tangents)
    for maps, product, scale in zip(tangents, whole, scales, strict=True):
        expected = np.eye(size)
        for k in range(7):
            expected = maps[k] / 1e30 @ expected
        alone, own = scaled_product(maps)
        for found, lost in ((product, scale), (alone, own)):
            np.testing.assert_allclose(found * np.exp(lost - 7 * np.log(1e30)), expected, rtol=1e-12)
            assert np.abs(found).max() == pytest.approx(1.0)
