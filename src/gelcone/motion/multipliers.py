"""Floquet multipliers of a ring of tangent maps by periodic QR decomposition.

The multipliers are the eigenvalues of the product of the maps. Formed as a matrix, the product holds those alone that
exceed 1e-16 of its largest: behind a filter whose deviations decay by exp(-280) in a forcing period all but the largest
would be rounding. Therefore orthonormal frames are carried around the ring, map by map, until they return to
themselves: the diagonals of the triangular factors then have the multipliers as products, each with all its digits.
Multipliers of similar moduli, such as complex pairs, mix in the frames; they are the eigenvalues of the product of the
diagonal blocks that they share. Bojanczyk, Golub and Van Dooren, Proceedings of SPIE 1770 (1992) 31.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone.motion.cyclic import scaled_product
from gelcone.motion.tangents import first_frames, resolved, rounding
from gelcone.quantity import Array

SWEEPS = 4
"""Times that frames are carried around the ring. Multipliers whose ratio is below 1e-4 are then apart by `APART`; the
others share a block, in which such a ratio costs 4 of 16 digits."""
APART = 1e-12
"""Largest entry by which frames that return to themselves mix directions of different multipliers."""


class Multipliers(NamedTuple):
    """Multipliers of rings, the largest modulus first, and NaN for a ring that is not finite.

    ``log_modulus`` (members, N), the natural logarithms of their moduli; ``direction`` (members, N), complex numbers of
    modulus 1; ``error`` (members, N), that of a log modulus by errors in the maps.
    """

    log_modulus: Array
    direction: npt.NDArray[np.complex128]
    error: Array


def multipliers_of_rings(tangents: Array, signs: Array, tolerance: float) -> Multipliers:
    """Multipliers of rings of ``tangents`` (members, n, N, N), the first applied first, that close with ``signs``
    (N,). ``tolerance`` is the error of the maps over their largest entries."""
    members, size = len(tangents), len(signs)
    log_modulus, error = np.full((2, members, size), np.nan)
    direction = np.full((members, size), np.nan, dtype=complex)
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        for k in np.flatnonzero(np.isfinite(tangents).all(axis=(1, 2, 3))):
            log_modulus[k], direction[k], error[k] = _of_ring(tangents[k], signs, tolerance)
    return Multipliers(log_modulus, direction, error)


def log_multipliers(
    tangents: Array, scaled: tuple[Array, Array], log_determinant: Array, tolerance: float
) -> tuple[Array, Array]:
    """Logarithms of the moduli of the multipliers of rings of ``tangents`` (members, n, N, N), the largest first, and
    their errors by errors in the maps, each (members, N).

    ``scaled`` is the `scaled_product` of the maps, ``log_determinant`` (members,) the exact logarithm of its
    determinant, by which two states have no such error. With more states a logarithm is NaN where it is lost to these
    errors; the last one alone then follows from the determinant.
    """
    if tangents.shape[-1] == 2:
        product, log_scale = scaled
        log_moduli, _, _ = moduli_in_the_plane(product[:, 0, 0] + product[:, 1, 1], log_scale, log_determinant)
        return log_moduli, np.zeros(log_moduli.shape)
    rings = multipliers_of_rings(tangents, np.ones(tangents.shape[-1]), tolerance)
    return resolved(rings.log_modulus, rings.error, log_determinant, tangents.shape[1])


def moduli_in_the_plane(trace: Array, log_scale: Array, log_determinant: Array) -> tuple[Array, Array, Array]:
    """Logarithms (members, 2) of the moduli of the multipliers of maps with two states, the larger first, from the
    trace over a scale and the logarithms of scale and determinant; half the modulus of that trace, and the square of
    half the difference of the multipliers over the scale, negative for a complex pair."""
    half = 0.5 * np.abs(trace)
    square = half * half - np.exp(log_determinant - 2.0 * log_scale)
    with np.errstate(divide="ignore"):
        apart = log_scale + np.log(half + np.sqrt(np.abs(square)))
    larger = np.where(square < 0.0, 0.5 * log_determinant, apart)
    return np.stack([larger, log_determinant - larger], axis=1), half, square


def _of_ring(tangents: Array, signs: Array, tolerance: float) -> tuple[Array, npt.NDArray[np.complex128], Array]:
    """`Multipliers` of one ring of ``tangents`` (n, N, N)."""
    closing, triangles = _returning(tangents, signs)
    growth = np.log(np.abs(np.diagonal(triangles, axis1=1, axis2=2)))
    errors = len(tangents) * rounding(tangents, growth, tolerance).max(axis=0)
    multipliers = []
    for first, last in _blocks(closing):
        block = slice(first, last)
        log_modulus, direction = _of_block(closing[block, block], triangles[:, block, block])
        # within a block errors are those of its largest eigenvalue
        error = errors[block].max() + tolerance * np.expm1(log_modulus.max() - log_modulus)
        multipliers.append((log_modulus, direction, error))
    log_moduli, directions, errors = (np.concatenate(parts) for parts in zip(*multipliers, strict=True))
    return log_moduli, directions, errors


def _returning(tangents: Array, signs: Array) -> tuple[Array, Array]:
    """Frames carried around a ring until they return: the turn of the frames in the last sweep (N, N), and the
    triangular factors (n, N, N) of the maps in it."""
    from scipy.linalg.lapack import dgeqrf, dorgqr  # for one small matrix a tenth of the time of `numpy.linalg.qr`

    factors = np.empty_like(tangents)
    start = frame = first_frames(tangents[:1, 0])[0]
    for _ in range(SWEEPS):
        start = frame
        for k, tangent in enumerate(tangents):
            factors[k], scales, _, _ = dgeqrf(tangent @ frame)
            frame = dorgqr(factors[k], scales)[0]
        frame = signs[:, None] * frame
    return start.T @ frame, np.triu(factors)


def _blocks(closing: Array) -> list[tuple[int, int]]:
    """First and last place of the directions that mix in frames that return to themselves."""
    size = len(closing)
    edges = [0, *(k for k in range(1, size) if np.abs(closing[k:, :k]).max() < APART), size]
    return list(pairwise(edges))


def _of_block(closing: Array, triangles: Array) -> tuple[Array, npt.NDArray[np.complex128]]:
    """Logarithms of moduli and directions of the eigenvalues, (m,), of diagonal blocks: the turn (m, m) times the
    product of the factors (n, m, m)."""
    if len(closing) == 1:
        heights = triangles[:, 0, 0]
        direction = np.prod(np.sign(heights)) * np.sign(closing[0])
        return np.log(np.abs(heights)).sum(keepdims=True), direction.astype(complex)
    product, log_scale = scaled_product(triangles)
    values = np.linalg.eigvals(closing @ product).astype(complex)
    values = values[np.argsort(-np.abs(values), kind="stable")]
    return log_scale + np.log(np.abs(values)), values / np.abs(values)
