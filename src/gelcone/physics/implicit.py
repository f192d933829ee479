"""Numbers that are roots of equations without a closed form.

A compiled program solves the equation inside each step; equations of arrays are solved here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gelcone.physics.differentiate import derivatives, evaluated, newton
from gelcone.physics.trace import Graph

Residual = Callable[..., Any]
"""Residual as a function of the root, its other arguments and ``xp``."""
First = Callable[..., Any]
"""First guess of the root as a function of the other arguments of the residual and ``xp``."""
Slope = Callable[..., Any]
"""Derivative of the residual by the root as a function of the root and the other arguments, all of them arrays."""


def root(
    xp: Any,
    name: str,
    residual: Residual,
    at: Sequence[Any],
    first: First,
    longest: float = math.inf,
    slope: Slope | None = None,
) -> Any:
    """Solve ``residual(y, *at, xp)`` = 0 for y by Newton's method from ``first(*at, xp)``.

    ``at`` holds floats, arrays or the expressions of a compiled program. In a program ``name`` identifies the root, and
    a Newton step is at most ``longest`` times the larger of the root and 1; see `gelcone.physics.trace.Graph.root`.
    ``slope`` serves arrays; by default the residual is traced and differentiated at each call.
    """
    if traced(xp):
        return xp.root(name, residual, at, first, longest)
    begin = first(*at, np) + np.zeros(np.broadcast_shapes(*map(np.shape, at)))
    by_root = _differentiated(residual, at) if slope is None else slope
    return newton(lambda y, _: residual(y, *at, np), lambda y, _: by_root(y, *at), begin)


def _differentiated(residual: Residual, at: Sequence[Any]) -> Slope:
    graph = Graph()
    leaf = graph.state(0)
    (slope,) = derivatives([graph.node(residual(leaf, *at, graph))], leaf)
    return lambda y, *at: evaluated([slope], {leaf.index: y})[0]


def traced(xp: Any) -> bool:
    """Whether ``xp`` traces formulas on the nodes of a graph, which branch on switches instead of on values."""
    return xp is not np and hasattr(xp, "root")  # NumPy looks long for what it does not have


def known(value: Any) -> float | None:
    """The value of a constant expression; None for one that changes, and for arrays."""
    return value.value if getattr(value, "operation", None) == "constant" else None
