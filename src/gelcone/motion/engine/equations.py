"""Equations of roots: the nodes of each residual, by their dependence on the root, and their derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gelcone.physics.differentiate import block_of, derivatives
from gelcone.physics.trace import Node, ordered


@dataclass(frozen=True)
class Equation:
    """The equation ``residual`` = 0 of a ``root``, searched from ``first``.

    ``dependents`` are the nodes of the residual that change with the root, the residual among them, ``slopes`` their
    derivatives with respect to the root, and ``slope`` that of the residual. ``others`` are the nodes in these that do
    not change with the root. ``block``: the one or two roots that are found together; derivatives by one hold the
    other. ``longest`` step of the search, over the root or 1.
    """

    root: Node
    residual: Node
    first: Node
    slope: Node
    dependents: tuple[Node, ...]
    slopes: tuple[Node, ...]
    others: tuple[Node, ...]
    block: tuple[Node, ...]
    longest: float

    def slope_of(self, residual: Node) -> Node | None:
        """The derivative of another residual of the block with respect to this root; None if it does not depend on
        it."""
        return next((s for node, s in zip(self.dependents, self.slopes, strict=True) if node is residual), None)


def equations_of(roots: Sequence[Node]) -> tuple[Equation, ...]:
    """The equations of all roots that nodes depend on."""
    equations = []
    for root in ordered(roots):
        if root.operation == "root":
            residual, block = root.graph.equations[root.index], block_of(root)
            dependents = _moved(ordered([residual]), root)
            if residual not in dependents:
                raise ValueError(f"root {root.value!r}: its equation does not contain it")
            slopes = derivatives(dependents, root, block)
            slope = slopes[dependents.index(residual)]
            needed = ordered([residual, *slopes] if len(block) > 1 else [residual, slope])
            moved = {node.index for block_root in block for node in (block_root, *_moved(needed, block_root))}
            others = tuple(node for node in needed if not node.fixed and node.index not in moved)
            first = root.graph.guesses[root.index]
            longest = root.graph.longest[root.index]
            equations.append(
                Equation(root, residual, first, slope, tuple(dependents), tuple(slopes), others, block, longest)
            )
    return tuple(equations)


def _moved(nodes: Sequence[Node], root: Node) -> list[Node]:
    """The nodes, of ordered ones, that change with a root."""
    moved = {root.index}
    dependents = []
    for node in nodes:
        if node is not root and any(argument.index in moved for argument in node.arguments):
            moved.add(node.index)
            dependents.append(node)
    return dependents
