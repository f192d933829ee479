"""Intervals of shares, and of numbers over draws.

There are two intervals of shares: `wilson` takes any share and number of standard errors, and covers the truth at its
nominal rate on average; `share_interval` takes counts, and covers every truth at least at its nominal rate.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.quantity import Array

CONFIDENCE = 0.95
"""Probability with which a stated interval contains the truth."""
Z = 1.959963984540054
"""Standard errors on either side that contain 95 % of a normal distribution."""

QUANTILES = (0.5 - 0.5 * CONFIDENCE, 0.5, 0.5 + 0.5 * CONFIDENCE)
"""The ends of a 95 % interval and the median."""


def spread(values: npt.ArrayLike) -> Array:
    """The `QUANTILES` over the first axis, (3, ...), of the draws that have a value.

    Infinite values count as the largest. NaN if fewer than half of the draws have a value, as these do not represent
    the others.
    """
    numbers = np.asarray(values, dtype=float)
    quantiles = np.full((len(QUANTILES), *numbers.shape[1:]), np.nan)
    enough = (~np.isnan(numbers)).mean(axis=0) >= 0.5
    if np.any(enough):
        columns = numbers[:, enough]
        with np.errstate(invalid="ignore"):  # interpolates between infinite values
            between = np.nanquantile(columns, QUANTILES, axis=0)
        quantiles[:, enough] = np.where(
            np.isnan(between), np.nanquantile(columns, QUANTILES, axis=0, method="nearest"), between
        )
    return quantiles


def wilson(share: npt.ArrayLike, count: npt.ArrayLike, z: float = Z) -> tuple[Array, Array]:
    """The interval of a share observed in ``count`` trials (Wilson, J. Am. Stat. Assoc. 22 (1927) 209).

    ``z`` standard errors on either side, by default those of 95 %. 0 and 1 for no trials at all.
    """
    p, n = np.asarray(share, dtype=float), np.asarray(count, dtype=float)
    known = n > 0
    n, p = np.where(known, n, 1.0), np.where(known, p, 0.5)
    centre = (p + z * z / (2.0 * n)) / (1.0 + z * z / n)
    half: Any = z / (1.0 + z * z / n) * np.sqrt(p * (1.0 - p) / n + z * z / (4.0 * n * n))
    low, high = np.clip(centre - half, 0.0, p), np.clip(centre + half, p, 1.0)  # rounding leaves the share within
    return np.where(known, low, 0.0), np.where(known, high, 1.0)


def share_interval(hits: npt.ArrayLike, count: npt.ArrayLike, confidence: float = CONFIDENCE) -> tuple[Array, Array]:
    """The interval of a share, from ``hits`` of ``count`` independent draws; 0 and 1 without draws.

    Clopper and Pearson, Biometrika 26 (1934) 404.
    """
    from scipy.special import betaincinv

    k, n = np.asarray(hits), np.asarray(count)
    tail = 0.5 * (1.0 - confidence)
    low = np.where(k > 0, betaincinv(np.maximum(k, 1), n - k + 1, tail), 0.0)
    high = np.where(k < n, betaincinv(k + 1, np.maximum(n - k, 1), 1.0 - tail), 1.0)
    return low, high
