"""Numbers that an equation gives: roots for which there is no formula, with their exact derivatives.

A compiled program solves the equation inside of each step; arrays are solved here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gelcone.physics.dual import Dual, Functions, derivative, plain

ENOUGH = 1e-9
"""Newton's method squares its error: a correction by this share of the root leaves none that doubles hold."""
MOST_STEPS = 60

Residual = Callable[..., Any]
"""The residual as a function of the root and of what else it depends on."""
First = Callable[..., Any]
"""Where Newton's method begins, as a function of what else the residual depends on, and of the functions of ``xp``."""


def root(xp: Any, name: str, residual: Residual, at: Sequence[Any], first: First) -> Any:
    """The root y of ``residual(y, *at)`` that Newton's method finds from ``first(*at, xp)``.

    ``at`` holds floats, arrays, dual numbers or the expressions of a compiled program; ``name`` tells roots apart in
    a program.
    """
    own = getattr(xp, "root", None)
    if own is not None:
        return own(name, residual, at, first)
    if isinstance(xp, Functions):
        return _with_derivatives(xp.inner, name, residual, at, first)
    return _newton(residual, at, first)


def traced(xp: Any) -> bool:
    """Whether formulas run on the expressions of a compiled program, which branch by switches instead of by values."""
    return traced(xp.inner) if isinstance(xp, Functions) else hasattr(xp, "root")


def known(value: Any) -> float | None:
    """What an expression of a compiled program is at all times; None if it changes."""
    value = plain(value)
    return value.value if getattr(value, "operation", None) == "constant" else None


def _newton(residual: Residual, at: Sequence[Any], first: First) -> Any:
    y = first(*at, np) + np.zeros(np.broadcast_shapes(*map(np.shape, at)))
    moving = np.ones(y.shape, dtype=bool)
    with np.errstate(all="ignore"):
        for _ in range(MOST_STEPS):
            value, slope = _with_slope(residual, y, at)
            step = value / slope
            y = np.where(moving, y - step, y)
            moving = moving & (np.abs(step) > ENOUGH * np.abs(y))
            if not moving.any():
                break
    return y[()]


def _with_slope(residual: Residual, y: Any, at: Sequence[Any]) -> tuple[Any, Any]:
    dual = residual(Dual(y, [1.0]), *at)
    return dual.value, dual.parts[0]


def _with_derivatives(xp: Any, name: str, residual: Residual, at: Sequence[Any], first: First) -> Any:
    """dy = -(d residual by the others) / (d residual by y)."""
    values = [plain(part) for part in at]
    y = root(xp, name, residual, values, first)
    change = residual(y, *at)
    if not isinstance(change, Dual):
        return y
    slope = derivative(lambda own, _: residual(own, *values), y)
    return Dual(y, [0.0 if isinstance(part, float) and part == 0.0 else -part / slope for part in change.parts])
