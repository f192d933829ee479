"""Numbers that an equation gives: roots for which there is no formula.

A compiled program solves the equation inside of each step; arrays are solved here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gelcone.physics.differentiate import derivatives, evaluated, newton
from gelcone.physics.trace import Graph

Residual = Callable[..., Any]
"""The residual as a function of the root, of what else it depends on, and of the functions of ``xp``."""
First = Callable[..., Any]
"""Where Newton's method begins, as a function of what else the residual depends on, and of the functions of ``xp``."""


def root(xp: Any, name: str, residual: Residual, at: Sequence[Any], first: First, longest: float = math.inf) -> Any:
    """The root y of ``residual(y, *at, xp)`` that Newton's method finds from ``first(*at, xp)``.

    ``at`` holds floats, arrays or the expressions of a compiled program; ``name`` identifies the root in a program,
    where a step of the search is at most ``longest`` times the root or 1; see `gelcone.physics.trace.Graph.root`.
    """
    if traced(xp):
        return xp.root(name, residual, at, first, longest)
    graph = Graph()
    leaf = graph.state(0)
    (slope,) = derivatives([graph.node(residual(leaf, *at, graph))], leaf)
    begin = first(*at, np) + np.zeros(np.broadcast_shapes(*map(np.shape, at)))
    return newton(lambda y, _: residual(y, *at, np), lambda y, _: evaluated([slope], {leaf.index: y})[0], begin)


def traced(xp: Any) -> bool:
    """Whether formulas run on the nodes of a graph, which branch by switches instead of by values."""
    return hasattr(xp, "root")


def known(value: Any) -> float | None:
    """The value of an expression that is the same at all times; None if it changes, or is an array's."""
    return value.value if getattr(value, "operation", None) == "constant" else None
