"""Sign changes of functions, to rounding, by Chandrupatla's method (Adv. Eng. Softw. 28 (1997) 145): inverse quadratic
interpolation where that is safe, else bisection. (SciPy's solvers take half a second to import, and solve one by one.)
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any, SupportsFloat

import numpy as np

from gelcone.quantity import Array

RESOLVED = 2.0 * sys.float_info.epsilon
"""Relative width at which a bracket is resolved."""
NEARBY = 1e-6
"""Distance from a sign change, as a share of the bracket, at which the size of the function shows a pole."""
SMALLER = 1e-3
"""A function is at a pole if its size at that distance is less than this share of the size at the change."""
MOST_STEPS = 2000
"""More steps than bisection takes from the largest double to the smallest."""


def rise(function: Callable[[Any], Any], low: Any, high: Any) -> Any:
    """Find the places where ``function`` of an array rises through zero between ``low`` and ``high`` (arrays of one
    shape), element by element; ``low`` where it is positive already, ``high`` where it never is. It may jump and be
    infinite.

    Raises `ArithmeticError` for NaN inside a bracket.
    """
    a, b = np.array(low, dtype=float), np.array(high, dtype=float)
    with np.errstate(all="ignore"):
        return _rise(function, a, b, function(a), function(b))


def _rise(function: Callable[[Any], Any], a: Any, b: Any, of_a: Any, of_b: Any) -> Any:
    """`rise` within brackets at whose ends the function is known; a is the newer end."""
    with np.errstate(all="ignore"):
        found = np.where(of_a >= 0.0, a, b)
        open_ = np.logical_and(of_a < 0.0, of_b > 0.0)
        share = np.full(a.shape, 0.5)
        for _ in range(MOST_STEPS):
            if not open_.any():
                break
            x = a + share * (b - a)
            of_x = function(x)
            lost = open_ & np.isnan(of_x)
            if lost.any():
                raise ArithmeticError(f"the function has no value at {float(x[lost][0])!r}")
            same = np.sign(of_x) == np.sign(of_a)
            c, of_c = np.where(same, a, b), np.where(same, of_a, of_b)
            b, of_b = np.where(same, b, a), np.where(same, of_b, of_a)
            a, of_a = x, of_x
            best = np.where(np.abs(of_a) < np.abs(of_b), a, b)
            found = np.where(open_, best, found)
            least = (RESOLVED * np.abs(best) + sys.float_info.min) / np.abs(b - a)
            open_ = open_ & (least <= 0.5) & (of_x != 0.0)
            # inverse quadratic interpolation where it is monotone, else bisection
            place, height = (a - b) / (c - b), (of_a - of_b) / (of_c - of_b)
            monotone = (height * height < place) & ((1.0 - height) ** 2 < 1.0 - place)
            quadratic = of_a / (of_b - of_a) * of_c / (of_b - of_c)
            quadratic = quadratic + (c - a) / (b - a) * of_a / (of_c - of_a) * of_b / (of_c - of_b)
            taken = monotone & np.isfinite(quadratic)
            share = np.where(taken, np.minimum(np.maximum(quadratic, least), 1.0 - least), 0.5)
    return found[()]


def sign_changes(function: Callable[[Any], Any], a: Any, b: Any) -> Any:
    """Find the points between ``a`` and ``b`` (arrays of one shape) where ``function`` of an array changes sign; NaN
    where its signs at both are equal, or change at a pole.

    Raises `ArithmeticError` for NaN inside a bracket.
    """
    a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    low, high = np.minimum(a, b), np.maximum(a, b)
    with np.errstate(all="ignore"):
        of_b, of_a = function(b), function(a)
        sign, across = np.sign(of_b), np.sign(of_a)
        roots = _rise(lambda x: sign * function(x), a, b, sign * of_a, sign * of_b)
        nearby = roots + NEARBY * np.where(roots - low > high - roots, low - high, high - low)
        pole = np.abs(function(nearby)) < SMALLER * np.abs(function(roots))
        apart = np.where((sign * across < 0.0) & ~pole, roots, np.nan)
    return np.where(across == 0.0, a, np.where(sign == 0.0, b, apart))[()]


def sign_change(function: Callable[[float], SupportsFloat], a: float, b: float) -> float:
    """Find a point between ``a`` and ``b`` where ``function`` of one number changes sign.

    Raises `ArithmeticError` for NaN, for equal signs at ``a`` and ``b``, and at a pole.
    """
    root = float(sign_changes(lambda x: np.float64(function(float(x))), a, b))
    if root != root:
        raise ArithmeticError(f"the function has one sign at {a!r} and {b!r}, or a pole between")
    return root


def halved(before: Callable[[Any], Any], low: Any, high: Any, rounds: int) -> tuple[Any, Any]:
    """Halve the brackets ``low`` to ``high`` (arrays of one shape) ``rounds`` times around the place up to which
    ``before`` is true."""
    for _ in range(rounds):
        middle = 0.5 * (low + high)
        below = before(middle)
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return low, high


def crossing(times: Array, values: Array, level: float) -> float:
    """Time at which values first reach a level, linear between samples; NaN if they never do."""
    above = np.flatnonzero(values >= level)
    if not above.size:
        return np.nan
    k = int(above[0])
    if k == 0:
        return float(times[0])
    return float(np.interp(level, values[k - 1 : k + 1], times[k - 1 : k + 1]))
