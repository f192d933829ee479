"""The voltage that crumples a film without tension, and its turnings.

Without tension a film lies at one squared stretch t in both directions, at V G = Vb(t). A law may have a hump, the
first maximum of Vb, where such a film pulls in, and a valley, the minimum behind it.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from gelcone.bracket import rise
from gelcone.quantity import Array

SAME_STRETCH = 1e-12
"""Squared stretches that differ by less, relatively, count as equal."""
GRID = 2000
"""Squared stretches among which the first turning of Vb is searched."""


MOST_STRETCHED = 1e4
"""Largest squared stretch up to which turnings of the crumpling voltage are searched."""


class Law(Hashable, Protocol):
    """A strain-energy law W(I1 - 3), as the membrane needs it."""

    def compliance(self, strain: Any, n: Any, xp: Any = np) -> Any:
        """1/(2 dW/dI1)."""

    def stiffening(self, strain: Any, n: Any, xp: Any = np) -> Any:
        """Minus the derivative of the compliance with respect to I1."""

    def response(self, strain: Any, n: Any, xp: Any = np) -> Any:
        """2 dW/dI1."""

    def response_slope(self, strain: Any, n: Any, xp: Any = np) -> Any:
        """The derivative of the response with respect to I1."""

    def strain_limit(self, n: Any) -> Any:
        """The largest I1 - 3."""


def crumpling(law: Law, t: Any, n: Mapping[str, Any]) -> Any:
    """Vb(t) = R (1 - t^-3)/t, the V G that cancels the stress of a film stretched equibiaxially by t^(1/2), with the
    response R(I1) of its law; infinite at and beyond the stretch limit."""
    t = np.asarray(t, dtype=float)
    strain = 2.0 * t + t**-2.0 - 3.0
    with np.errstate(all="ignore"):
        found = (1.0 - t**-3.0) / (t * law.compliance(strain, n))
    return np.where(strain >= law.strain_limit(n), np.inf, found)[()]


def slope_within(law: Law, t: Any, n: Mapping[str, Any]) -> Any:
    """Derivative of Vb(t) below the stretch limit."""
    inverse = 1.0 / t
    square = inverse * inverse
    strain, strain_slope = 2.0 * t + square - 3.0, 2.0 - 2.0 * square * inverse
    shape, shape_slope = inverse - square * square, 4.0 * square * square * inverse - square
    return law.response_slope(strain, n) * strain_slope * shape + law.response(strain, n) * shape_slope


def turnings(law: Law, n: Mapping[str, Any]) -> tuple[Array, Array]:
    """The t of the first maximum of Vb and of the minimum behind it; infinity where there is none. In the shape of the
    law's numbers."""
    arrays = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in n.values())) if n else [np.zeros(())]
    rows, place = np.unique(np.stack([array.ravel() for array in arrays]), axis=1, return_inverse=True)
    hump, valley = _turnings_of(law, tuple(n), rows.tobytes(), rows.shape[1])
    return hump[place].reshape(arrays[0].shape), valley[place].reshape(arrays[0].shape)


@lru_cache(maxsize=256)
def _turnings_of(law: Law, names: tuple[str, ...], rows: bytes, count: int) -> tuple[Array, Array]:
    """The turnings of films of one law, (count,); ``rows`` holds the law's numbers, (names, count). They are cached,
    since they change with the gel alone and take longer than many a motion."""
    values = np.frombuffer(rows).reshape(-1, count)
    numbers = {name: row[:, None] for name, row in zip(names, values, strict=False)}

    def slope(t: Any) -> Any:
        return slope_within(law, t[:, None], numbers)[:, 0]

    with np.errstate(all="ignore"):
        limit = np.broadcast_to(law.strain_limit(numbers), (count, 1))
        most = np.minimum(0.5 * (limit + 3.0), MOST_STRETCHED)
        t = np.exp(np.log(most) * np.linspace(0.0, 1.0, GRID)[1:-1])
        falls = slope_within(law, t, numbers) < 0.0
        first = np.argmax(falls, axis=1)
        low = np.where(first > 0, np.take_along_axis(t, np.maximum(first - 1, 0)[:, None], 1)[:, 0], 1.0)
        high = np.take_along_axis(t, first[:, None], 1)[:, 0]
        hump = rise(lambda t: -slope(t), low, high)
        # Vb falls from the hump to the valley and rises from there to the stretch limit
        end = most[:, 0]
        valley = rise(slope, hump * (1.0 + SAME_STRETCH), end)
    turns = falls.any(axis=1)
    hump = np.where(turns, hump, np.inf)
    valley = np.where(turns & (valley < end * (1.0 - SAME_STRETCH)), valley, np.inf)
    hump.flags.writeable = valley.flags.writeable = False
    return hump, valley
