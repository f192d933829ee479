"""The mean length of a film: the squared length M of the homogeneous cone whose soft branches store as much energy.

With m and n the squared lengths of the rings over those of the film as it begins to pull, and w the mean over the
film's volume of m + n + 1/(m n) - 3, a homogeneous cone whose meridian has the squared length M stores as much where
M + 1/M - 2 = w. Branches that relax are stretched by M: their energy is that of the film's rings to first order,
and their force M' dpsi/dM is consistent with it.

    M = 1 + (s - s0) P(t),    t = (s - s0 - c)/(s - s0 + c),

with s = x^2, s0 where the film without voltage begins to pull, and the numbers that `fitted` returns.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from gelcone.errors import InputError
from gelcone.membrane.elements import Elements
from gelcone.membrane.gel import Array

Numbers = Mapping[str, Any]
DEGREE = 6
"""Degree of P."""
NAMES = ("mean_begin", "mean_scale", *(f"mean_length_{i}" for i in range(DEGREE + 1)))
LOWEST, NEXT, HEIGHTS = 0.01, 0.03, 40
"""Rise of the reference and of the next height above the height at which the film begins to pull, and the number of
heights after the reference."""
SCALE, FALLING = 0.5, 0.1
"""c, and c of films whose hoop is the stronger, whose lengths change most near the flat film."""
TOO_FEW = "film = membrane: its states without voltage are not found; take film = wrinkling"


def fitted(film: Elements, begin: float, reach: float) -> dict[str, float]:
    """The numbers of a film between the s at which it begins to pull and the largest.

    Raises `InputError` where too few states are found.
    """
    rise = np.append(LOWEST**2, np.geomspace(NEXT**2, reach - begin, HEIGHTS))
    length = mean_lengths(film, np.sqrt(begin + rise))
    rise, length = rise[1:] - rise[0], length[1:]
    is_known = np.isfinite(length)
    if is_known.sum() <= DEGREE:
        raise InputError(TOO_FEW)
    scale = FALLING if film.gel.has_rims else SCALE
    ratio = (length[is_known] - 1.0) / rise[is_known]
    place = (rise[is_known] - scale) / (rise[is_known] + scale)
    coefficients = chebyshev.cheb2poly(chebyshev.chebfit(place, ratio, DEGREE, w=1.0 / ratio))
    return dict(zip(NAMES, [begin, scale, *map(float, coefficients)], strict=True))


def mean_lengths(film: Elements, heights: Array) -> Array:
    """M without voltage at rising heights, relative to the first of them; NaN where no state is found."""
    at = film.unloaded(heights)
    l1, l2, _, _ = film.stretches(at)
    with np.errstate(all="ignore"):
        m, n = l1 * l1, film.gel.width(l1, l2, np.zeros_like(l1))
        along, across = m / m[:1], n / n[:1]
        w = np.sum(film.weights * (along + across + 1.0 / (along * across) - 3.0), axis=1)
        return np.where(at.found & at.found[0], 1.0 + 0.5 * (w + np.sqrt(w * (w + 4.0))), np.nan)


def mean_length(s: Any, n: Numbers) -> tuple[Any, Any, Any]:
    """M and its first two derivatives by s, of numbers, arrays or the expressions of a program."""
    rise = s - n["mean_begin"]
    ratio, slope, bend = _ratio(rise, n)
    return 1.0 + rise * ratio, ratio + rise * slope, 2.0 * slope + rise * bend


def height_of(length: Any, n: Numbers) -> Any:
    """The s at which M is about ``length``: by two corrections, to some per cent of s - s0."""
    rise: Any = n["mean_scale"]
    for _ in range(2):
        rise = (length - 1.0) / _ratio(rise, n)[0]
    return n["mean_begin"] + rise


def _ratio(rise: Any, n: Numbers) -> tuple[Any, Any, Any]:
    """P and its first two derivatives by s."""
    c = n["mean_scale"]
    below = 1.0 / (rise + c)
    place = (rise - c) * below
    value, by_place, twice = n[NAMES[-1]], 0.0, 0.0
    for name in NAMES[-2:1:-1]:
        twice = twice * place + 2.0 * by_place
        by_place = by_place * place + value
        value = value * place + n[name]
    slope = 2.0 * c * below * below
    return value, by_place * slope, (twice * slope - 2.0 * by_place * below) * slope
