"""Derivatives of formulas: graphs differentiated node by node, and evaluated by NumPy.

A formula that runs on the nodes of a `gelcone.physics.trace.Graph` has exact derivatives, whether a program is compiled
from them or they are evaluated for arrays. Griewank and Walther, Evaluating Derivatives (2008), chapter 3.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from gelcone.physics.trace import Graph, Node, ordered
from gelcone.quantity import taken

ENOUGH = 1e-9
"""Relative size of the last correction: Newton's method squares its error, so that the next is below rounding."""
MOST_STEPS = 60
_NUMPY = {
    "add": np.add,
    "subtract": np.subtract,
    "multiply": np.multiply,
    "divide": np.divide,
    "power": np.power,
    "sqrt": np.sqrt,
    "exp": np.exp,
    "log": np.log,
    "log1p": np.log1p,
    "sin": np.sin,
    "cos": np.cos,
}


def derivatives(values: Sequence[Node], by: Node, fixed: Sequence[Node] = ()) -> list[Node]:
    """Partial derivatives of ``values`` with respect to the leaf ``by`` (a state, a number, a root or the time).

    Forward mode, node by node; quotients, roots and exponentials reuse the value itself, so that the derivative of a
    film's force shares its division. Roots of equations are differentiated implicitly, except those in ``fixed``.
    """
    return directional(values, {by: by.graph.constant(1.0)}, fixed)


def directional(values: Sequence[Node], along: Mapping[Node, Node], fixed: Sequence[Node] = ()) -> list[Node]:
    """Derivatives of ``values`` along the direction in which leaves change at the rates ``along``; see
    `derivatives`."""
    graph = next(iter(along)).graph
    zero = graph.constant(0.0)
    slope = {node.index: zero for node in fixed} | {leaf.index: rate for leaf, rate in along.items()}
    for node in ordered(values):
        if node.index not in slope and node.operation == "root":
            block = [root for root in block_of(node) if root.index not in slope]
            held, equations = (*fixed, *block), [graph.equations[root.index] for root in block]
            changes = directional(equations, along, held)
            if all(change is zero for change in changes):
                slope |= {root.index: zero for root in block}
                continue
            columns = [derivatives(equations, root, (*held, *along)) for root in block]
            if len(block) == 1:
                slope[node.index] = -(changes[0] / columns[0][0])
                continue
            (a, c), (b, d) = columns
            determinant = a * d - b * c
            slope[block[0].index] = (b * changes[1] - d * changes[0]) / determinant
            slope[block[1].index] = (c * changes[0] - a * changes[1]) / determinant
        elif node.index not in slope:
            inner = [slope[a.index] for a in node.arguments]
            moving = any(d is not zero for d in inner)
            slope[node.index] = _rule(graph, node, inner) if moving else zero
    return [slope[value.index] for value in values]


def block_of(root: Node) -> tuple[Node, ...]:
    """The roots that depend on each other, at most two, ``root`` among them."""

    def within(of: Node) -> list[Node]:
        return [node for node in ordered([of.graph.equations[of.index]]) if node.operation == "root"]

    block = [root, *(other for other in within(root) if other is not root and root in within(other))]
    if len(block) > 2:
        raise ValueError(f"root {root.value!r}: more than two roots depend on each other")
    return tuple(sorted(block, key=lambda node: node.index))


def _rule(graph: Graph, node: Node, inner: Sequence[Node]) -> Node:
    """The chain rule: the derivative of ``node`` from its arguments' derivatives."""
    a, da = node.arguments[0], inner[0]
    b, db = (node.arguments[1], inner[1]) if len(inner) == 2 else (a, da)
    match node.operation:
        case "add":
            return da + db
        case "subtract":
            return da - db
        case "multiply":
            return da * b + a * db
        case "divide":
            return (da - node * db) / b
        case "power":  # (a^b)' = b a^b a'/a + a^b log(a) b'
            rate = b * (node / a) * da
            return rate if b.fixed and db.value == 0.0 else rate + node * graph.log(a) * db
        case "sqrt":
            return 0.5 * da / node
        case "exp":
            return node * da
        case "log":
            return da / a
        case "log1p":
            return da / (1.0 + a)
        case "sin":
            return graph.cos(a) * da
        case "cos":
            return -(graph.sin(a) * da)
    raise ValueError(f"no derivative is known for {node.operation!r}")


def jacobian(values: Sequence[Node], by: Sequence[Node]) -> list[list[Node]]:
    """The derivatives d value_i / d by_j, (values, by)."""
    columns = [derivatives(values, leaf) for leaf in by]
    return [[column[i] for column in columns] for i in range(len(values))]


def evaluated(nodes: Sequence[Node], leaves: Mapping[int, Any]) -> list[Any]:
    """Evaluate ``nodes`` by NumPy from the values of ``leaves`` (states, numbers, switches, time) by node index."""
    return _computed(nodes, _unknown(nodes, leaves), leaves)


def _unknown(nodes: Sequence[Node], known: Mapping[int, Any]) -> list[Node]:
    """The nodes that must be computed for ``nodes``, in order, given the ``known`` ones."""
    needed, waiting = set[int](), list(nodes)
    while waiting:
        node = waiting.pop()
        if node.index not in needed and node.index not in known:
            needed.add(node.index)
            waiting += node.arguments
    return [node for node in nodes[0].graph.in_order(nodes) if node.index in needed] if needed else []


def _computed(nodes: Sequence[Node], unknown: Sequence[Node], known: Mapping[int, Any]) -> list[Any]:
    values = dict(known)
    for node in unknown:
        if node.operation in ("constant", "array"):
            values[node.index] = node.value
        elif node.operation == "root":
            values[node.index] = _root(node, values)
        else:
            values[node.index] = _NUMPY[node.operation](*(values[a.index] for a in node.arguments))
    return [values[node.index] for node in nodes]


def _root(node: Node, values: Mapping[int, Any]) -> Any:
    """Solve the equation of a root, given ``values`` of its other leaves."""
    equation = node.graph.equations[node.index]
    (first,) = evaluated([node.graph.guesses[node.index]], values)
    held = [other for other in block_of(node) if other is not node and other.index in values]
    key = node.index, bool(held)  # the other root of a block is held while this one is found for it
    if key not in node.graph.root_slopes:
        (node.graph.root_slopes[key],) = derivatives([equation], node, held)
    slope = node.graph.root_slopes[key]
    known = _needed([equation, slope], node, values)

    def of(target: Node) -> Callable[[Any, Mapping[int, Any]], Any]:
        unknown = _unknown([target], {**known, node.index: None})
        return lambda y, known: _computed([target], unknown, {**known, node.index: y})[0]

    return newton(of(equation), of(slope), first, known)


def _needed(nodes: Sequence[Node], root: Node, values: Mapping[int, Any]) -> dict[int, Any]:
    """The ``values``, and the arrays in nodes, from which ``nodes`` are computed in addition to ``root``."""
    needed_values, seen, waiting = {}, {root.index}, list(nodes)
    while waiting:
        node = waiting.pop()
        if node.index in seen:
            continue
        seen.add(node.index)
        if node.index in values or node.operation == "array":
            needed_values[node.index] = values.get(node.index, node.value)
        elif node.operation == "root":
            waiting += [node.graph.equations[node.index], node.graph.guesses[node.index]]
        else:
            waiting += node.arguments
    return needed_values


def newton(
    residual: Callable[[Any, Mapping[int, Any]], Any],
    slope: Callable[[Any, Mapping[int, Any]], Any],
    first: Any,
    known: Mapping[int, Any] = MappingProxyType({}),
) -> Any:
    """Solve ``residual(y, known)`` = 0 elementwise by Newton's method from ``first``.

    ``known`` holds all other numbers or arrays that residual and slope depend on. It is reduced to the elements that
    still move each time half of them have converged; elements without a root, as on the other side of a border, take
    `MOST_STEPS` steps. Without ``known`` all elements are computed until the last converges.
    """
    with np.errstate(all="ignore"):
        value = residual(first, known)
        roots = np.asarray(first + np.zeros(np.shape(value)))
        places, y = np.arange(roots.size), roots
        moving = np.ones(roots.shape, dtype=bool)
        for _ in range(MOST_STEPS):
            step = value / slope(y, known)
            y = np.where(moving, y - step, y)
            moving = moving & (np.abs(step) > ENOUGH * np.abs(y))
            if not moving.any():
                break
            if known and 2 * np.count_nonzero(moving) <= moving.size:
                roots.flat[places] = y.ravel()
                known = {key: taken(value, moving) for key, value in known.items()}
                places, y, moving = places[moving.ravel()], y[moving], moving[moving]
            value = residual(y, known)
        roots.flat[places] = y.ravel()
    return roots[()]


def gradients(
    function: Callable[..., Sequence[Any]], at: Sequence[Any], n: Mapping[str, Any] | None = None
) -> list[list[Any]]:
    """Partial derivatives [i][j] of the i-th value of ``function(variables, xp)`` by the j-th variable, at numbers or
    arrays ``at``. The function is traced, so that switches choose the side of its borders. With numbers ``n``, which
    may be arrays, it is ``function(variables, n, xp)``."""
    if n is None:
        return Gradients(lambda z, n, xp: function(z, xp), len(at))(at, {})
    return Gradients(function, len(at), tuple(n))(at, n)


class Gradients:
    """The `gradients` of ``function(variables, n, xp)``, traced once for many calls, by its ``count`` variables;
    ``names`` are those of its numbers."""

    def __init__(self, function: Callable[..., Sequence[Any]], count: int, names: Sequence[str] = ()) -> None:
        graph = Graph()
        self._leaves = [graph.state(i) for i in range(count)]
        self._numbers = {name: graph.switch(name) for name in names}
        nodes = [graph.node(value) for value in function(list(self._leaves), self._numbers, graph)]
        self._slopes = jacobian(nodes, self._leaves)

    def __call__(self, at: Sequence[Any], n: Mapping[str, Any]) -> list[list[Any]]:
        """The derivatives at numbers or arrays ``at``."""
        values = {leaf.index: np.asarray(value)[()] for leaf, value in zip(self._leaves, at, strict=True)}
        values |= {leaf.index: n[name] for name, leaf in self._numbers.items()}
        with np.errstate(all="ignore"):
            flat = evaluated([slope for row in self._slopes for slope in row], values)
        return [flat[i * len(at) : (i + 1) * len(at)] for i in range(len(self._slopes))]


def derivative(function: Callable[[Any, Any], Any], at: Any) -> Any:
    """Derivative of ``function(variable, xp)`` by its variable."""
    return gradients(lambda variables, xp: [function(variables[0], xp)], [at])[0][0]
