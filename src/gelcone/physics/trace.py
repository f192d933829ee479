"""Tracing: formulas that run on the nodes of a graph build it, with one node for equal expressions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from numbers import Real
from typing import Any

import numpy as np

LARGEST_INTEGER_POWER = 32
"""Largest integer power that becomes products; larger ones use the logarithm, like real powers."""


def _operator(name: str) -> tuple[Callable[[Node, Any], Node], Callable[[Node, Any], Node]]:
    """The methods of an operator for a node on its left and on its right; objects other than nodes and numbers have
    rules of their own."""

    def left(node: Node, other: Any) -> Node:
        return getattr(node.graph, name)(node, other) if isinstance(other, Node | Real | np.ndarray) else NotImplemented

    def right(node: Node, other: Any) -> Node:
        return getattr(node.graph, name)(other, node) if isinstance(other, Node | Real | np.ndarray) else NotImplemented

    return left, right


class Node:
    """One value of a graph.

    ``operation`` is "constant", "array", "number", "switch", "root", "time" or "state" for a leaf, with its value, name
    or index in ``value``; else "add", "subtract", "multiply", "divide", "power", "sqrt", "exp", "log", "log1p", "sin"
    or "cos". ``fixed``: the value depends on constants and numbers alone, and does not change during an integration.
    """

    __slots__ = ("arguments", "fixed", "graph", "index", "operation", "value")
    __array_ufunc__ = None  # NumPy scalars leave arithmetic with nodes to them

    def __init__(
        self, graph: Graph, index: int, operation: str, arguments: tuple[Node, ...], value: Any, fixed: bool
    ) -> None:
        self.graph: Graph = graph
        self.index: int = index
        self.operation: str = operation
        self.arguments: tuple[Node, ...] = arguments
        self.value: Any = value
        self.fixed: bool = fixed

    __add__, __radd__ = _operator("add")
    __sub__, __rsub__ = _operator("subtract")
    __mul__, __rmul__ = _operator("multiply")
    __truediv__, __rtruediv__ = _operator("divide")
    __pow__, __rpow__ = _operator("power")

    def __neg__(self) -> Node:
        return self.graph.multiply(-1.0, self)

    def __pos__(self) -> Node:
        return self

    def __bool__(self) -> bool:
        raise TypeError("a formula cannot branch on a value that changes with time: describe the border by an event")


class Graph:
    """The namespace that formulas are traced with: arithmetic on its nodes, and ``sin``, ``cos``, ``exp``, ``log``,
    ``log1p`` and ``sqrt``, as in NumPy."""

    def __init__(self) -> None:
        self._known: dict[tuple[Any, ...], Node] = {}
        self.equations: dict[int, Node] = {}
        self.guesses: dict[int, Node] = {}
        self.longest: dict[int, float] = {}
        self._orders: dict[tuple[int, ...], list[Node]] = {}
        self.root_slopes: dict[tuple[int, bool], Node] = {}
        self.time: Node = self._leaf("time", 0)

    # --- leaves --------------------------------------------------------------------------------------------------

    def state(self, index: int) -> Node:
        """The state of an index."""
        return self._leaf("state", index)

    def number(self, name: str) -> Node:
        """A number with a value for each member."""
        return self._leaf("number", name, fixed=True)

    def switch(self, name: str) -> Node:
        """A number that is constant between events and changes its sign at some."""
        return self._leaf("switch", name)

    def root(
        self,
        name: str,
        residual: Callable[..., Any],
        at: Sequence[Any],
        first: Callable[..., Any],
        longest: float = math.inf,
    ) -> Node:
        """The root y of ``residual(y, *at, graph)``, followed from step to step. The search begins at ``first(*at,
        graph)`` at the start of a member, and when a law that needs the root begins to hold.

        ``name`` identifies the root: an equal name with another equation raises `ValueError`. ``longest`` bounds a
        Newton step, over the larger of the root and 1: of several roots a search in short steps finds the first. It
        fails, and the root is NaN, where the residual does not rise with the root.
        """
        leaf = self._leaf("root", name)
        equation = self.node(residual(leaf, *at, self))
        if self.equations.setdefault(leaf.index, equation) is not equation:
            raise ValueError(f"root {name!r}: stands for two equations; give one of them another name")
        self.guesses[leaf.index], self.longest[leaf.index] = self.node(first(*at, self)), longest
        return leaf

    def constant(self, value: float) -> Node:
        """A number that all members share."""
        value = float(value)
        return self._intern("constant", (), value, True, (value.hex(),))

    def node(self, value: Any) -> Node:
        """The node of a value: itself, a constant, or a leaf of an array, which NumPy evaluates."""
        if isinstance(value, Node):
            return value
        if np.ndim(value):
            array = np.asarray(value)
            return self._intern("array", (), value, False, (array.shape, str(array.dtype), array.tobytes()))
        return self.constant(value)

    # --- arithmetic ----------------------------------------------------------------------------------------------

    def add(self, first: Any, second: Any) -> Node:
        """first + second."""
        a, b = self.node(first), self.node(second)
        if _is(a, 0.0):
            return b
        if _is(b, 0.0):
            return a
        if b.operation == "multiply" and _is(b.arguments[0], -1.0):
            return self.subtract(a, b.arguments[1])
        if a.operation == "multiply" and _is(a.arguments[0], -1.0):
            return self.subtract(b, a.arguments[1])
        return self._make("add", *_sorted(a, b))

    def subtract(self, first: Any, second: Any) -> Node:
        """first - second."""
        a, b = self.node(first), self.node(second)
        if _is(b, 0.0):
            return a
        if a is b:
            return self.constant(0.0)
        if _is(a, 0.0):
            return self.multiply(-1.0, b)
        if b.operation == "multiply" and _is(b.arguments[0], -1.0):
            return self.add(a, b.arguments[1])
        return self._make("subtract", a, b)

    def multiply(self, first: Any, second: Any) -> Node:
        """first * second; a constant comes first, and constant factors are combined."""
        a, b = _sorted(self.node(first), self.node(second))
        if _is(a, 0.0):
            return a
        if _is(a, 1.0):
            return b
        if a.operation == "constant" and b.operation == "multiply" and b.arguments[0].operation == "constant":
            return self.multiply(a.value * b.arguments[0].value, b.arguments[1])
        return self._make("multiply", a, b)

    def divide(self, first: Any, second: Any) -> Node:
        """first / second; division by a fixed node becomes multiplication by its reciprocal, computed once a member."""
        a, b = self.node(first), self.node(second)
        if _is(b, 1.0) or _is(a, 0.0):
            return a
        if b.fixed and not a.fixed:
            return self.multiply(a, self._make("divide", self.constant(1.0), b))
        return self._make("divide", a, b)

    def power(self, first: Any, second: Any) -> Node:
        """first ** second, by products for integers, a square root for halves of odd integers, else a real power."""
        base, exponent = self.node(first), self.node(second)
        if not exponent.fixed:
            return self.exp(self.multiply(exponent, self.log(base)))
        if exponent.operation == "constant":
            doubled = 2.0 * exponent.value
            if doubled.is_integer() and abs(exponent.value) <= LARGEST_INTEGER_POWER:
                return self._half_integer_power(base, int(doubled))
        return self._make("power", base, exponent)

    def _half_integer_power(self, base: Node, doubled: int) -> Node:
        if doubled < 0:
            return self.divide(1.0, self._half_integer_power(base, -doubled))
        if doubled % 2:
            return self.multiply(self.sqrt(base), self._half_integer_power(base, doubled - 1))
        result, factor, left = self.constant(1.0), base, doubled // 2
        while left:
            if left % 2:
                result = self.multiply(result, factor)
            left //= 2
            if left:
                factor = self.multiply(factor, factor)
        return result

    # --- functions -----------------------------------------------------------------------------------------------

    def sqrt(self, value: Any) -> Node:
        """The square root."""
        return self._make("sqrt", self.node(value))

    def exp(self, value: Any) -> Node:
        """The exponential function."""
        return self._make("exp", self.node(value))

    def log(self, value: Any) -> Node:
        """The natural logarithm."""
        return self._make("log", self.node(value))

    def log1p(self, value: Any) -> Node:
        """log(1 + value), exact for small values."""
        return self._make("log1p", self.node(value))

    def sin(self, value: Any) -> Node:
        """The sine of an angle in radians."""
        return self._make("sin", self.node(value))

    def cos(self, value: Any) -> Node:
        """The cosine of an angle in radians."""
        return self._make("cos", self.node(value))

    def maximum(self, first: Any, second: Any) -> Node:
        """The larger of two values."""
        difference = self.subtract(first, second)
        return self.multiply(0.5, self.add(self.add(first, second), self.sqrt(self.multiply(difference, difference))))

    def in_order(self, roots: Sequence[Node]) -> list[Node]:
        """`ordered`, cached for repeated evaluation."""
        key = tuple(root.index for root in roots)
        if key not in self._orders:
            self._orders[key] = ordered(roots)
        return self._orders[key]

    # --- nodes that exist once -----------------------------------------------------------------------------------

    def _leaf(self, operation: str, value: Any, fixed: bool = False) -> Node:
        return self._intern(operation, (), value, fixed, (value,))

    def _make(self, operation: str, *arguments: Node) -> Node:
        if operation in _EXACT and all(a.operation == "constant" for a in arguments):
            value = _fold(operation, [a.value for a in arguments])
            if math.isfinite(value):
                return self.constant(value)
        return self._intern(operation, arguments, None, all(a.fixed for a in arguments), ())

    def _intern(
        self, operation: str, arguments: tuple[Node, ...], value: Any, fixed: bool, content: tuple[Any, ...]
    ) -> Node:
        key = (operation, *content, *(a.index for a in arguments))
        if key not in self._known:
            self._known[key] = Node(self, len(self._known), operation, arguments, value, fixed)
        return self._known[key]


_EXACT: Mapping[str, Callable[..., float]] = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "divide": lambda a, b: a / b,
    "sqrt": math.sqrt,
}
"""Operations with equal results on every machine, which are computed while tracing."""


def _fold(operation: str, values: Sequence[float]) -> float:
    try:
        return _EXACT[operation](*values)
    except (ArithmeticError, ValueError):
        return math.nan


def _is(node: Node, value: float) -> bool:
    return node.operation == "constant" and node.value == value


def _sorted(a: Node, b: Node) -> tuple[Node, Node]:
    """The arguments of a commutative operation in a unique order: constants first, then older nodes."""
    if (b.operation != "constant", b.index) < (a.operation != "constant", a.index):
        return b, a
    return a, b


def ordered(roots: Iterable[Node]) -> list[Node]:
    """The ``roots`` and all nodes that they depend on, each once and after its arguments.

    Sine and cosine of an angle that changes need each other's Taylor coefficients, so that both are included. The
    equation of a root and its arguments follow directly after the root.
    """
    done: dict[int, Node] = {}
    waiting = list(roots)[::-1]
    while waiting:
        node = waiting.pop()
        missing = [a for a in node.arguments if a.index not in done]
        if node.index in done:
            continue
        if missing:
            waiting += [node, *missing[::-1]]
            continue
        done[node.index] = node
        if node.operation in ("sin", "cos") and not node.fixed:
            waiting.append(partner(node))
        if node.operation == "root":
            waiting.append(node.graph.equations[node.index])
    return list(done.values())


def partner(node: Node) -> Node:
    """The cosine of the angle of a sine, or the sine of the angle of a cosine."""
    (angle,) = node.arguments
    return node.graph.cos(angle) if node.operation == "sin" else node.graph.sin(angle)


def fingerprint(roots: Sequence[Node]) -> str:
    """A text that is equal for equal expressions, also between processes."""
    solved = [node for node in ordered(roots) if node.operation == "root"]
    definitions = [each[node.index] for node in solved for each in (node.graph.equations, node.graph.guesses)]
    nodes = ordered([*roots, *definitions])
    place = {node.index: i for i, node in enumerate(nodes)}
    values = [node.value.hex() if node.operation == "constant" else node.value for node in nodes]
    rows = [
        (n.operation, [place[a.index] for a in n.arguments], definitions)
        for n, definitions in zip(nodes, values, strict=True)
    ]
    longest = [node.graph.longest[node.index].hex() for node in solved]
    return repr((rows, [place[root.index] for root in roots], [place[node.index] for node in definitions], longest))
