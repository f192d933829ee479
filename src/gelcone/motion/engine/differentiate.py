"""Derivatives of graphs: tangents, and systems that carry their sensitivities along."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gelcone.motion.engine.trace import Graph, Node, ordered


def derivatives(values: Sequence[Node], by: Node, fixed: Sequence[Node] = ()) -> list[Node]:
    """Partial derivatives of ``values`` with respect to the leaf ``by`` (a state, a number, a root or the time).

    Forward mode, node by node; quotients, roots and exponentials reuse the value itself, so that the derivative of a
    film's force shares its division. Roots of equations change with what these depend on, but for those in ``fixed``.
    """
    graph = by.graph
    zero = graph.constant(0.0)
    slope: dict[int, Node] = {by.index: graph.constant(1.0)} | {node.index: zero for node in fixed if node is not by}
    for node in ordered(values):
        if node.index not in slope and node.operation == "root":
            equation = [graph.equations[node.index]]
            (change,) = derivatives(equation, by, (*fixed, node))
            (own,) = derivatives(equation, node, (*fixed, node))
            slope[node.index] = zero if change is zero else -(change / own)
        elif node.index not in slope:
            inner = [slope[a.index] for a in node.arguments]
            moving = any(d is not zero for d in inner)
            slope[node.index] = _rule(graph, node, inner) if moving else zero
    return [slope[value.index] for value in values]


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
    """d value_i / d by_j, shape (values, by)."""
    columns = [derivatives(values, leaf) for leaf in by]
    return [[column[i] for column in columns] for i in range(len(values))]


@dataclass(frozen=True)
class Sensitivities:
    """A system whose states are those of ``system``, followed by their derivatives with respect to the numbers ``by``.

    The derivative s = d state / d number obeys s' = J s + d rates / d number, with J the Jacobian, and starts from the
    derivative of the initial state (zero where that does not depend on the number). Of order 2 the second derivatives
    follow: those of each pair of numbers in the order (0, 0), (0, 1), ..., (1, 1), ..., N values a pair. It runs on
    the engine's graph only, as ``keep="states"``.

    Parameters
    ----------
    system : the system, with ``states``, ``numbers`` and ``flow``.
    by : names among its numbers, none of which an event switches.
    order : 1 or 2.
    """

    system: Any
    by: tuple[str, ...]
    order: int = 1

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states: "displacement", ..., "d displacement / d voltage", ..."""
        base = tuple(self.system.states)
        first = tuple(f"d {state} / d {name}" for name in self.by for state in base)
        second = tuple(f"d2 {state} / d {p} d {q}" for p, q in self._pairs() for state in base)
        return base + first + second

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the numbers, which are the system's."""
        return tuple(self.system.numbers)

    def _pairs(self) -> list[tuple[str, str]]:
        if self.order < 2:
            return []
        return [(p, q) for i, p in enumerate(self.by) for q in self.by[i:]]

    def rates(self, time: Node, state: Sequence[Node], n: Mapping[str, Node], xp: Graph) -> list[Node]:
        """Rates of change of the states and of their derivatives."""
        size = len(self.system.states)
        flow, slopes = self.system.flow(time, list(state[:size]), n, xp)
        rates = [xp.node(rate) for rate in flow]
        blocks = [list(state[size * (k + 1) : size * (k + 2)]) for k in range(len(self.by))]

        def total(values: Sequence[Node], number: str, direction: Sequence[Node]) -> list[Node]:
            """Derivatives of ``values`` along a change of the number and the states that follow it."""
            change = derivatives(values, n[number])
            for i in range(size):
                partial = derivatives(values, state[i])
                change = [c + p * direction[i] for c, p in zip(change, partial, strict=True)]
            return change

        first: dict[str, list[Node]] = {}
        for name, block in zip(self.by, blocks, strict=True):
            own = derivatives(rates, n[name])
            first[name] = [
                sum((slope * s for slope, s in zip(row, block, strict=True)), own_rate)
                for row, own_rate in zip(slopes, own, strict=True)
            ]
        result = rates + [rate for name in self.by for rate in first[name]]
        for k, (p, q) in enumerate(self._pairs()):
            start = size * (1 + len(self.by) + k)
            second = list(state[start : start + size])
            # the first derivative's rate, differentiated along q, with the first derivative itself held, and then moved
            held = total(first[p], q, blocks[self.by.index(q)])
            result += [
                sum((slope * s for slope, s in zip(row, second, strict=True)), rate)
                for row, rate in zip(slopes, held, strict=True)
            ]
        return result
