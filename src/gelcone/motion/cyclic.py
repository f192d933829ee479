"""Linear equations of shooting: a ring of nodes, each mapped to the next, bordered by a few unknowns and conditions.

    X[k+1] - A[k] X[k] - sum_q C[q, k] L[q] = R[k],  k = 0 ... n-1,  X[n] = S X[0]
    sum_k rows[q, k] . X[k] + sum_p corner[q, p] L[p] = top[q]

with diagonal signs S. Neighbouring segments are merged in pairs, which eliminates every second node, until their
products would grow so large that digits are lost; the rest is solved as one dense system. Merging all is the
"condensing" of Bock and Plitt, IFAC Proceedings 17 (1984) 1603, which for strongly unstable orbits fails like single
shooting.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from gelcone.quantity import Array

DENSE = 36
"""Largest number of node unknowns that are solved without merging segments."""
GROWTH = 1e5
"""Largest entry of the products of merged segments."""
SCALED_AFTER = 8
"""Number of maps after which planar products are scaled."""


def solve_ring(
    tangents: Array, signs: Array, right: Array, columns: Array, rows: Array, corner: Array, top: Array
) -> tuple[Array, Array]:
    """Solutions X (n, N, K) and L (Q, K) for K right-hand sides.

    ``tangents`` (n, N, N), ``signs`` (N,), ``right`` (n, N, K), ``columns`` (n, N, Q), ``rows`` (Q, n, N), ``corner``
    (Q, Q), ``top`` (Q, K). Raises `numpy.linalg.LinAlgError` where there is none.
    """
    n, size = tangents.shape[-3:-1]
    merged = _merged(tangents) if n * size > DENSE and n % 2 == 0 else None
    if merged is None:
        return _dense(tangents, signs, right, columns, rows, corner, top)
    first, second, skipped = tangents[0::2], tangents[1::2], rows[:, 1::2]
    x, unknowns = solve_ring(
        merged,
        signs,
        second @ right[0::2] + right[1::2],
        second @ columns[0::2] + columns[1::2],
        rows[:, 0::2] + (skipped[..., None, :] @ first)[..., 0, :],
        corner + np.einsum("qki,kip->qp", skipped, columns[0::2]),
        top - np.einsum("qki,kic->qc", skipped, right[0::2]),
    )
    whole = np.empty((n, *x.shape[1:]))
    whole[0::2] = x
    whole[1::2] = first @ x + right[0::2] + columns[0::2] @ unknowns
    return whole, unknowns


def left_weights(tangents: Array, signs: Array, columns: Array, rows: Array, corner: Array) -> tuple[Array, float]:
    """Weights (n, N) of the equations of a ring and the weight g of its condition: the solution of the transposed
    bordered system with right-hand side 1 in its last row. Where the ring is singular g = 0, and the weights are its
    left null vector."""
    n, size = tangents.shape[-3:-1]
    merged = _merged(tangents) if n * size > DENSE and n % 2 == 0 else None
    if merged is None:
        right = np.zeros(n * size + 1)
        right[-1] = 1.0
        solution = np.linalg.solve(_matrix(tangents, signs, columns, rows, corner).T, right)
        return np.asarray(solution[:-1].reshape(n, size)), float(solution[-1])
    first, second, skipped = tangents[0::2], tangents[1::2], rows[..., 1::2, :]
    short, weight = left_weights(
        merged,
        signs,
        second @ columns[0::2] + columns[1::2],
        rows[..., 0::2, :] + (skipped[..., None, :] @ first)[..., 0, :],
        corner + np.einsum("qki,kip->qp", skipped, columns[0::2]),
    )
    weights: Array = np.empty((n, size))
    weights[1::2] = short
    weights[0::2] = np.einsum("kij,ki->kj", second, short) - weight * skipped[0]
    return weights, weight


def _merged(tangents: Array) -> Array | None:
    """Products of neighbouring pairs; None where they grow too much."""
    products = tangents[1::2] @ tangents[0::2]
    return products if np.abs(products).max() < GROWTH else None


def _dense(
    tangents: Array, signs: Array, right: Array, columns: Array, rows: Array, corner: Array, top: Array
) -> tuple[Array, Array]:
    from scipy.linalg.lapack import dgesv  # takes long to import, and regimes do not need it

    n, size, count = right.shape
    nodes = n * size
    whole = np.empty((count, nodes + len(top))).T
    whole[:nodes], whole[nodes:] = right.reshape(nodes, count), top
    matrix = _matrix(tangents, signs, columns, rows, corner)
    # `numpy.linalg.solve` takes twice as long for one small system
    _, _, solution, singular = dgesv(matrix, whole, overwrite_a=1, overwrite_b=1)
    if singular:
        raise np.linalg.LinAlgError("Singular matrix")
    return solution[:nodes].reshape(n, size, count), solution[nodes:]


def _matrix(tangents: Array, signs: Array, columns: Array, rows: Array, corner: Array) -> Array:
    """The dense matrix of a ring with its border, (n N + Q, n N + Q), stored column by column."""
    n, size, extra = columns.shape
    nodes = n * size
    blank, at = _layout(n, size, extra, tuple(signs.tolist()))
    stored = blank.copy()
    # in a ring of one segment the map and the next node share their entries
    stored[at] -= tangents.ravel()
    matrix = stored.reshape(nodes + extra, nodes + extra).T
    if extra:
        np.negative(columns.reshape(nodes, extra), out=matrix[:nodes, nodes:])
        matrix[nodes:, :nodes] = rows.reshape(extra, nodes)
        matrix[nodes:, nodes:] = corner
    return matrix


@lru_cache(maxsize=64)
def _layout(n: int, size: int, extra: int, signs: tuple[float, ...]) -> tuple[Array, npt.NDArray[np.intp]]:
    """The flat matrix with the entries of the next nodes, column by column, and the indices of the tangent maps."""
    k, i, j = (a.ravel() for a in np.indices((n, size, size)))
    whole, unknown = n * size + extra, np.arange(n * size)
    ahead = np.ones((n, size))
    ahead[-1] = signs
    blank = np.zeros((whole, whole))
    blank[(unknown + size) % (n * size), unknown] = ahead.ravel()
    return blank.ravel(), (k * size + j) * whole + k * size + i


def scaled_product(tangents: Array) -> tuple[Array, Array]:
    """Product (..., N, N) of tangent maps (..., n, N, N), the first applied first, with entries of at most 1, and the
    logarithm (...,) of the factor removed from it. Leading axes are members, each of which depends on itself alone.
    """
    planar = tangents.shape[-1] == 2
    if planar and tangents.ndim == 3:
        return _planar_product(tangents)
    multiplied = _multiplied_in_the_plane if planar else np.matmul
    product, log_scale = _scaled(tangents)
    while product.shape[-3] > 1:  # all pairs of neighbours at once, so that few calls are made
        even = product.shape[-3] // 2 * 2
        both, scale = _scaled(multiplied(product[..., 1:even:2, :, :], product[..., :even:2, :, :]))
        scale += log_scale[..., 1:even:2] + log_scale[..., :even:2]
        product = np.concatenate([both, product[..., even:, :, :]], axis=-3)
        log_scale = np.concatenate([scale, log_scale[..., even:]], axis=-1)
    return product[..., 0, :, :], log_scale[..., 0]


def _scaled(maps: Array) -> tuple[Array, Array]:
    """Maps (..., N, N) divided by their largest entries, and the logarithms of these."""
    largest = np.abs(maps).max(axis=(-2, -1))
    return maps / largest[..., None, None], np.log(largest)


def _multiplied_in_the_plane(left: Array, right: Array) -> Array:
    product = np.empty(left.shape)
    for i in range(2):
        for j in range(2):
            product[..., i, j] = left[..., i, 0] * right[..., 0, j] + left[..., i, 1] * right[..., 1, j]
    return product


def _planar_product(tangents: Array) -> tuple[Array, Array]:
    """`scaled_product` of one ring with two states, on Python numbers, which is several times as fast."""
    a, b, c, d, scale = 1.0, 0.0, 0.0, 1.0, 0.0
    for k, (p, q, r, s) in enumerate(tangents.reshape(-1, 4).tolist(), 1):
        a, b, c, d = p * a + q * c, p * b + q * d, r * a + s * c, r * b + s * d
        if k % SCALED_AFTER == 0 or k == len(tangents):
            largest = max(abs(a), abs(b), abs(c), abs(d)) or math.nan
            a, b, c, d = a / largest, b / largest, c / largest, d / largest
            scale += math.log(largest)
    return np.array([[a, b], [c, d]]), np.array(scale)
