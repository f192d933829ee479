"""Linear equations of shooting: a ring of nodes, each mapped to the next, with a few unknowns and conditions beside it.

    X[k+1] - A[k] X[k] - sum_q C[q, k] L[q] = R[k],  k = 0 ... n-1,  X[n] = S X[0]
    sum_k rows[q, k] . X[k] + sum_p corner[q, p] L[p] = top[q]

with diagonal signs S. Neighbouring segments are merged in pairs, which eliminates every second node, as long as their
product does not grow so much that digits are lost; what remains is solved as one dense system. Merging all is the
"condensing" of Bock and Plitt, IFAC Proceedings 17 (1984) 1603, which for strongly unstable orbits fails like single
shooting. Leading axes of all arrays stand for members.
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
"""Segments are merged as long as no product has larger entries."""
UNSCALED = 1e100
"""Products with smaller entries are multiplied on without scaling."""
SCALED_AFTER = 8
"""Planar products are scaled after so many maps."""


def solve_ring(
    tangents: Array,
    signs: Array,
    right: Array,
    columns: Array,
    rows: Array,
    corner: Array,
    top: Array,
    growth: float = GROWTH,
) -> tuple[Array, Array]:
    """Solutions X (..., n, N, K) and L (..., Q, K) for K right-hand sides.

    ``tangents`` (..., n, N, N), ``signs`` (N,), ``right`` (..., n, N, K), ``columns`` (..., n, N, Q), ``rows``
    (..., Q, n, N), ``corner`` (..., Q, Q), ``top`` (..., Q, K). Segments are merged while no product grows beyond
    ``growth``; with infinity the solution of a member does not depend on its neighbours. Raises
    `numpy.linalg.LinAlgError` for a singular one.
    """
    n, size = tangents.shape[-3:-1]
    merged = _merged(tangents, growth) if n * size > DENSE and n % 2 == 0 else None
    if merged is None:
        return _dense(tangents, signs, right, columns, rows, corner, top)
    even, odd = slice(0, None, 2), slice(1, None, 2)
    first, second = tangents[..., even, :, :], tangents[..., odd, :, :]
    skipped = rows[..., odd, :]
    short_rows = rows[..., even, :] + (skipped[..., None, :] @ first[..., None, :, :, :])[..., 0, :]
    short_corner = corner + np.einsum("...qki,...kip->...qp", skipped, columns[..., even, :, :])
    short_top = top - np.einsum("...qki,...kic->...qc", skipped, right[..., even, :, :])
    x, unknowns = solve_ring(
        merged,
        signs,
        second @ right[..., even, :, :] + right[..., odd, :, :],
        second @ columns[..., even, :, :] + columns[..., odd, :, :],
        short_rows,
        short_corner,
        short_top,
        growth,
    )
    whole = np.empty((*x.shape[:-3], n, *x.shape[-2:]))
    whole[..., even, :, :] = x
    whole[..., odd, :, :] = first @ x + right[..., even, :, :] + columns[..., even, :, :] @ unknowns[..., None, :, :]
    return whole, unknowns


def left_weights(tangents: Array, signs: Array, columns: Array, rows: Array, corner: Array) -> tuple[Array, float]:
    """Weights (n, N) of the equations of one ring and the weight g of its one condition, with which all sums over the
    nodes vanish while the sum over the column is -1 - g corner. Where the ring is singular g = 0, and the weights are
    its left null vector."""
    n, size = tangents.shape[-3:-1]
    merged = _merged(tangents) if n * size > DENSE and n % 2 == 0 else None
    if merged is None:
        right = np.zeros(n * size + 1)
        right[-1] = 1.0
        found = np.linalg.solve(_matrix(tangents, signs, columns, rows, corner).T, right)
        return np.asarray(found[:-1].reshape(n, size)), float(found[-1])
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


def _merged(tangents: Array, growth: float = GROWTH) -> Array | None:
    """Products of neighbouring pairs; None where they grow too much."""
    products = tangents[..., 1::2, :, :] @ tangents[..., 0::2, :, :]
    return products if growth == np.inf or np.abs(products).max(initial=0.0) < growth else None


def _dense(
    tangents: Array, signs: Array, right: Array, columns: Array, rows: Array, corner: Array, top: Array
) -> tuple[Array, Array]:
    n, size = tangents.shape[-3:-1]
    lead, count, extra = right.shape[:-3], right.shape[-1], columns.shape[-1]
    matrix = _matrix(tangents, signs, columns, rows, corner)
    whole = np.concatenate([right.reshape(*lead, n * size, count), top], axis=-2)
    solution = np.linalg.solve(matrix, whole) if lead else _solved(matrix, whole)
    return solution[..., : n * size, :].reshape(*lead, n, size, count), solution[..., n * size : n * size + extra, :]


def _solved(matrix: Array, right: Array) -> Array:
    """What `numpy.linalg.solve` gives for one small system, in half its time."""
    from scipy.linalg.lapack import dgesv  # takes long to import, and regimes need none of it

    _, _, solution, singular = dgesv(matrix, right, overwrite_a=1)
    if singular:
        raise np.linalg.LinAlgError("Singular matrix")
    return np.asarray(solution)


def _matrix(tangents: Array, signs: Array, columns: Array, rows: Array, corner: Array) -> Array:
    """The dense matrix of a ring with its border, (..., n N + Q, n N + Q), stored column by column."""
    n, size = tangents.shape[-3:-1]
    lead, extra, nodes = tangents.shape[:-3], columns.shape[-1], n * size
    whole = nodes + extra
    blank, at = _layout(n, size, extra, tuple(signs.tolist()))
    stored = np.empty((*lead, whole * whole))
    stored[...] = blank
    # of a ring of one segment the map and the next node share their places
    stored[..., at] = blank[at] - tangents.reshape(*lead, -1)
    matrix = stored.reshape(*lead, whole, whole).swapaxes(-1, -2)
    if extra:
        np.negative(columns.reshape(*lead, nodes, extra), out=matrix[..., :nodes, nodes:])
        matrix[..., nodes:, :nodes] = rows.reshape(*lead, extra, nodes)
        matrix[..., nodes:, nodes:] = corner
    return matrix


@lru_cache(maxsize=64)
def _layout(n: int, size: int, extra: int, signs: tuple[float, ...]) -> tuple[Array, npt.NDArray[np.intp]]:
    """The flat matrix with the next nodes alone, column by column, and the places of the tangent maps in it."""
    k, i, j = (a.ravel() for a in np.indices((n, size, size)))
    whole, unknown = n * size + extra, np.arange(n * size)
    ahead = np.ones((n, size))
    ahead[-1] = signs
    blank = np.zeros((whole, whole))
    blank[(unknown + size) % (n * size), unknown] = ahead.ravel()
    return blank.ravel(), (k * size + j) * whole + k * size + i


def scaled_product(tangents: Array) -> tuple[Array, Array]:
    """Product (..., N, N) of tangent maps (..., n, N, N), the first applied first, with entries of at most 1, and the
    logarithm (...,) of the scale that it lost."""
    if tangents.ndim == 3 and tangents.shape[-1] == 2:
        return _planar_product(tangents)
    product, scale = tangents, np.zeros(tangents.shape[:-3])
    while True:
        largest = np.abs(product).max(axis=(-2, -1))
        # one product more would stay far from overflow: scaling each time would take longer than the products
        if product.shape[-3] == 1 or not largest.max() < UNSCALED:
            scale = scale + np.log(largest).sum(axis=-1)
            product = product / largest[..., None, None]
        if product.shape[-3] == 1:
            return product[..., 0, :, :], scale
        last = product[..., -1:, :, :] if product.shape[-3] % 2 else None
        even = product.shape[-3] // 2 * 2
        product = product[..., 1:even:2, :, :] @ product[..., 0:even:2, :, :]
        if last is not None:
            product = np.concatenate([product, last], axis=-3)


def _planar_product(tangents: Array) -> tuple[Array, Array]:
    """`scaled_product` of one ring with two states, on plain numbers: several times as fast."""
    a, b, c, d, scale = 1.0, 0.0, 0.0, 1.0, 0.0
    for k, (p, q, r, s) in enumerate(tangents.reshape(-1, 4).tolist(), 1):
        a, b, c, d = p * a + q * c, p * b + q * d, r * a + s * c, r * b + s * d
        if k % SCALED_AFTER == 0 or k == len(tangents):
            largest = max(abs(a), abs(b), abs(c), abs(d)) or math.nan
            a, b, c, d = a / largest, b / largest, c / largest, d / largest
            scale += math.log(largest)
    return np.array([[a, b], [c, d]]), np.array(scale)
