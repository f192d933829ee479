"""The 0-1 test for chaos: a second opinion that needs no tangent vectors.

Gottwald and Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129: a walk that the series drives through the plane spreads
like a random one (K near 1: chaos) or stays bounded (K near 0: regular). They subtract the oscillation caused by the
mean of the series (their eq. (2.6)). Here the periodic part of the series is removed instead, so that chaos in narrow
bands that are visited in turn is recognised; no damping (their eq. (3.5)) is used.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from gelcone.quantity import Array

FREQUENCIES = 48
MOST_BANDS = 16
EXACT = 1e-9
"""Residual of a series without its periodic part, over its size, below which it repeats exactly."""
MEMBERS_AT_ONCE = 16
"""Series that are processed together, which bounds the memory."""


def zero_one(series: Array, *, frequencies: int = FREQUENCIES, seed: int = 1) -> Array:
    """Growth rate K of each series, shape (members, points) -> (members,): median over random frequencies.

    The points should be a Poincare section (no oversampling), 200 or more. NaN for a series with NaN.
    """
    angles = np.random.default_rng(seed).uniform(np.pi / 5, 4 * np.pi / 5, frequencies)
    parts = [series[first : first + MEMBERS_AT_ONCE] for first in range(0, len(series), MEMBERS_AT_ONCE)]
    return np.concatenate([np.empty(0), *(_median_growth(without_bands(part), angles) for part in parts)])


def without_bands(series: Array) -> Array:
    """Each series (members, points) less the mean of every p-th point, with the p of the smallest residual variance.

    Zero where the residual is rounding.
    """
    members, points = series.shape
    best, least = series, np.full(members, np.inf)
    for bands in range(1, min(MOST_BANDS, points // 12) + 1):
        left = series.copy()
        for band in range(bands):
            left[:, band::bands] -= left[:, band::bands].mean(axis=1, keepdims=True)
        # One mean per band was fitted, which alone reduces the residual.
        variance = (left * left).sum(axis=1) / (points - bands)
        better = variance < least
        best, least = np.where(better[:, None], left, best), np.where(better, variance, least)
    return np.where((least <= (EXACT * np.abs(series).max(axis=1)) ** 2)[:, None], 0.0, best)


def _median_growth(series: Array, angles: Array) -> Array:
    """K of each series (members, points): the median over frequencies of the correlation with time."""
    points = series.shape[1]
    walk = np.cumsum(series[:, None, :] * np.exp(1j * angles[:, None] * np.arange(1, points + 1)), axis=2)
    lags = np.arange(1, points // 10 + 1)
    return np.median(_correlation(lags.astype(float), _mean_square_displacement(walk, lags)), axis=1)


def _mean_square_displacement(walk: npt.NDArray[np.complex128], lags: npt.NDArray[np.int64]) -> Array:
    """Mean of |w(j + lag) - w(j)|^2, (..., lags), over the j that the longest lag allows.

    It is mean |w(j + lag)|^2 + mean |w(j)|^2 - 2 mean Re w(j + lag) w(j)*. The last term is a correlation, which
    Fourier transforms give for all lags at once. No sum reaches beyond the end, so that padding is not needed.
    """
    window = walk.shape[-1] - lags[-1]
    # differences do not depend on the origin, but cancellation in their squares is least about the mean
    walk = walk - walk.mean(axis=-1, keepdims=True)
    begins = walk.copy()
    begins[..., window:] = 0.0
    products = np.fft.ifft(np.fft.fft(walk) * np.fft.fft(begins).conj())[..., lags].real
    squares = np.cumsum(walk.real**2 + walk.imag**2, axis=-1)
    ends = squares[..., lags + window - 1] - squares[..., lags - 1]
    return np.asarray((ends + squares[..., window - 1, None] - 2.0 * products) / window)


def _correlation(x: Array, y: Array) -> Array:
    """Correlation of ``x`` (points,) with the last axis of ``y``; 0 where that is constant."""
    dx, dy = x - x.mean(), y - y.mean(axis=-1, keepdims=True)
    with np.errstate(invalid="ignore"):
        scale = np.sqrt((dx * dx).sum() * (dy * dy).sum(axis=-1))
        return np.where(scale == 0.0, 0.0, (dy * dx).sum(axis=-1) / np.where(scale == 0.0, 1.0, scale))
