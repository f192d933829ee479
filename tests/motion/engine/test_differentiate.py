"""Derivatives of graphs against differences, and sensitivities against runs with other numbers."""

import math

import numpy as np
import pytest
from engine_systems import Cone, cone_numbers
from hypothesis import given
from hypothesis import strategies as st

from gelcone.motion.engine.differentiate import Sensitivities, derivatives, jacobian
from gelcone.motion.engine.program import Program
from gelcone.motion.engine.trace import Graph, ordered

RULES = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "divide": lambda a, b: a / b,
    "power": lambda a, b: a**b,
    "sqrt": math.sqrt,
    "exp": math.exp,
    "log": math.log,
    "log1p": math.log1p,
    "sin": math.sin,
    "cos": math.cos,
}


def value(node, leaves):
    """The value of a node, for values of the leaves by index."""
    values = dict(leaves)
    for each in ordered([node]):
        if each.index not in values:
            arguments = [values[a.index] for a in each.arguments]
            values[each.index] = each.value if each.operation == "constant" else RULES[each.operation](*arguments)
    return values[node.index]


FORMULAS = {
    "arithmetic": lambda x, p, g: (x * x - 3.0 * p) / (1.0 + x * p) + x,
    "powers": lambda x, p, g: (1.0 + x * x) ** 1.3 + (1.0 + x * x) ** p - x**-2,
    "roots": lambda x, p, g: g.sqrt(1.0 + p * x) * x,
    "exponential": lambda x, p, g: g.exp(-0.3 * x * p) + g.log(1.0 + x * x) + g.log1p(p * x),
    "circular": lambda x, p, g: g.sin(p * x) * g.cos(x) - g.sin(p),
}


@pytest.mark.parametrize("name", FORMULAS)
@given(x=st.floats(0.2, 2.0), p=st.floats(0.2, 2.0))
def test_derivatives_agree_with_differences(name, x, p):
    graph = Graph()
    leaves = graph.state(0), graph.number("p")
    formula = FORMULAS[name](*leaves, graph)
    at = {leaves[0].index: x, leaves[1].index: p}
    small = 1e-5
    for leaf in leaves:
        (slope,) = derivatives([formula], leaf)
        up = value(formula, at | {leaf.index: at[leaf.index] + small})
        down = value(formula, at | {leaf.index: at[leaf.index] - small})
        assert value(slope, at) == pytest.approx((up - down) / (2.0 * small), rel=1e-5, abs=1e-7)


def test_what_does_not_depend_on_a_leaf_has_no_derivative():
    graph = Graph()
    x, y = graph.state(0), graph.state(1)
    assert [[d.value for d in row] for row in jacobian([x, 2.0 * y], [x, y])] == [[1.0, 0.0], [0.0, 2.0]]


def test_the_traced_jacobian_is_the_one_that_the_system_gives():
    cone, graph = Cone(), Graph()
    state = [graph.state(0), graph.state(1)]
    n = {name: graph.number(name) for name in cone.numbers}
    rates, slopes = cone.flow(graph.time, state, n, graph)
    traced = jacobian([graph.node(rate) for rate in rates], state)
    numbers = cone_numbers(voltage=0.7, stretch_limit=10.0)
    at = {n[name].index: float(numbers[name]) for name in cone.numbers}
    at |= {state[0].index: 0.6, state[1].index: -0.3, graph.time.index: 4.0}
    for i in range(2):
        for j in range(2):
            assert value(traced[i][j], at) == pytest.approx(value(graph.node(slopes[i][j]), at), rel=1e-13)


def test_sensitivities_of_both_orders_agree_with_other_numbers():
    """Central differences of the end in amplitude and frequency, and the differences of the differences."""
    by, small = ("amplitude", "frequency"), 1e-4
    times, start = np.array([[3.0, 8.0]]), np.array([[0.6, -0.1]])
    numbers = cone_numbers(voltage=0.8, frequency=0.9)
    system = Sensitivities(Cone(), by, 2)
    assert system.states[2:4] == ("d displacement / d amplitude", "d velocity / d amplitude")
    assert len(system.states) == 2 + 2 * 2 + 2 * 3
    raw = Program(system, "states", 1e-10).run(numbers, np.hstack([start, np.zeros((1, 10))]), 0.0, times)
    plain = Program(Cone(), "states", 1e-15)

    def end(**change):
        moved = {name: numbers[name] + small * change.get(name, 0.0) for name in numbers}
        return plain.run(moved, start, 0.0, times).states[0]

    np.testing.assert_array_less(np.abs(raw.states[0, :, :2] - end()), 1e-9)
    for k, name in enumerate(by):
        difference = (end(**{name: 1.0}) - end(**{name: -1.0})) / (2.0 * small)
        np.testing.assert_allclose(raw.states[0, :, 2 + 2 * k : 4 + 2 * k], difference, rtol=0.0, atol=2e-5)
    for k, (p, q) in enumerate([(0, 0), (0, 1), (1, 1)]):
        first, second = by[p], by[q]
        if p == q:
            difference = (end(**{first: 1.0}) - 2.0 * end() + end(**{first: -1.0})) / small**2
        else:
            both = [end(**{first: s, second: t}) for s, t in ((1, 1), (1, -1), (-1, 1), (-1, -1))]
            difference = (both[0] - both[1] - both[2] + both[3]) / (4.0 * small**2)
        np.testing.assert_allclose(raw.states[0, :, 6 + 2 * k : 8 + 2 * k], difference, rtol=1e-4, atol=1e-4)
