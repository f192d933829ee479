"""The 0-1 test for chaos: a second opinion that needs no tangent vectors.

Gottwald and Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129, with the damped mean-square displacement of their
eq. (3.5) left out and the oscillatory term subtracted (their eq. (2.6)): K near 1 is chaos, near 0 is regular.
"""

from __future__ import annotations

import numpy as np

from gelcone.quantity import Array

FREQUENCIES = 48
LEAST_POINTS = 100


def zero_one(series: Array, *, frequencies: int = FREQUENCIES, seed: int = 1) -> Array:
    """Growth rate K of each series, shape (members, points) -> (members,): median over random frequencies.

    The points should be a Poincare section (no oversampling); NaN for a series that holds NaN.
    """
    members, points = series.shape
    rng = np.random.default_rng(seed)
    angles = rng.uniform(np.pi / 5, 4 * np.pi / 5, frequencies)
    lags = np.arange(1, points // 10 + 1)
    n = np.arange(1, points + 1)
    correlations = np.empty((frequencies, members))
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = series.mean(axis=1)
        for i, angle in enumerate(angles):
            walk = np.cumsum(series * np.exp(1j * angle * n), axis=1)
            spread = np.stack(
                [
                    np.mean(np.abs(walk[:, lag : lag + points - lags[-1]] - walk[:, : points - lags[-1]]) ** 2, axis=1)
                    for lag in lags
                ],
                axis=1,
            )
            oscillation = (mean**2)[:, None] * (1 - np.cos(lags * angle)) / (1 - np.cos(angle))
            correlations[i] = _correlation(lags.astype(float), spread - oscillation)
    return np.median(correlations, axis=0)


def _correlation(x: Array, y: Array) -> Array:
    """Correlation of ``x`` (points,) with each row of ``y``; 0 where a row is constant."""
    dx, dy = x - x.mean(), y - y.mean(axis=1, keepdims=True)
    scale = np.sqrt((dx @ dx) * (dy * dy).sum(axis=1))
    return np.where(scale > 0.0, dy @ dx / np.where(scale > 0.0, scale, 1.0), np.where(np.isnan(scale), np.nan, 0.0))
