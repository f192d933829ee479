"""Formulas as programs have them, evaluated by NumPy: quick, since nothing is compiled."""

import numpy as np

from gelcone.physics.differentiate import evaluated
from gelcone.physics.trace import Graph


def in_program(formula, n, switches, *at):
    """``formula(*at, n, graph)`` for numbers or arrays ``at`` (lists for states), with the ``switches`` fixed by the
    program, so that they are single numbers."""
    graph, known = Graph(), {}

    def leaf(value):
        node = graph.state(len(known))
        known[node.index] = np.asarray(value, dtype=float)
        return node

    leaves = [[leaf(one) for one in value] if isinstance(value, list) else leaf(value) for value in at]
    numbers = {name: graph.number(name) for name in n} | {k: graph.constant(float(v)) for k, v in switches.items()}
    known |= {numbers[name].index: np.asarray(value, float) for name, value in n.items() if name not in switches}
    found = formula(*leaves, numbers, graph)
    parts = found if isinstance(found, list | tuple) else [found]
    with np.errstate(all="ignore"):
        return evaluated([graph.node(part) for part in parts], known)
