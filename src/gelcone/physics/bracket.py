"""Where a function of one number changes sign, to rounding. (SciPy's solvers take half a second to import.)"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import SupportsFloat

MOST_STEPS = 2000
"""More than bisection takes from the largest double to the smallest."""


def sign_change(function: Callable[[float], SupportsFloat], a: float, b: float) -> float:
    """A point between ``a`` and ``b``, at which ``function`` has different signs, where it changes sign.

    Inverse quadratic interpolation where that is safe, else bisection (Chandrupatla 1997, Advances in Engineering
    Software 28, 145), until the point is known to a few units in the last place; a jump or an infinite value does not
    matter. Raises `ArithmeticError` for a value that is no number, and where the signs at the ends are equal.
    """
    near, near_value = a, _number(function, a)
    across, across_value = b, _number(function, b)
    if near_value == 0.0 or across_value == 0.0:
        return near if near_value == 0.0 else across
    if (near_value > 0.0) == (across_value > 0.0):
        raise ArithmeticError(f"the function has one sign at {a!r} and {b!r}")
    share = 0.5
    for _ in range(MOST_STEPS):
        at = near + share * (across - near)
        value = _number(function, at)
        if (value > 0.0) == (near_value > 0.0):
            old, old_value = near, near_value
        else:
            old, old_value = across, across_value
            across, across_value = near, near_value
        near, near_value = at, value
        best = near if abs(near_value) < abs(across_value) else across
        width = abs(across - near)
        error = 2.0 * sys.float_info.epsilon * abs(best) + sys.float_info.min
        if near_value == 0.0 or error > 0.5 * width:
            return near if near_value == 0.0 else best
        share = _next_share(near, across, old, near_value, across_value, old_value)
        share = min(max(share, error / width), 1.0 - error / width)
    return best


def _next_share(a: float, b: float, c: float, fa: float, fb: float, fc: float) -> float:
    """The share of the way from ``a`` to ``b`` where inverse quadratic interpolation puts the root, if that is safe,
    else a half."""
    xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb)
    if not (phi * phi < xi and (1.0 - phi) * (1.0 - phi) < 1.0 - xi):
        return 0.5
    share = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
    return share if 0.0 < share < 1.0 else 0.5


def _number(function: Callable[[float], SupportsFloat], at: float) -> float:
    value = float(function(at))
    if value != value:
        raise ArithmeticError(f"the function has no value at {at!r}")
    return value
