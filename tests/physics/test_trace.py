"""Tracing: one node for each value, constants drawn together, and nothing that depends on the machine folded."""

import itertools
import operator

import numpy as np
import pytest

from gelcone.physics.differentiate import evaluated
from gelcone.physics.trace import Graph, fingerprint, ordered


@pytest.fixture
def graph():
    return Graph()


def test_equal_expressions_exist_once(graph):
    x, y = graph.state(0), graph.state(1)
    assert x * y is y * x
    assert x + y is y + x
    assert 1.0 / (1.0 + x * x) is 1.0 / (x * x + 1)
    assert graph.sin(x) is graph.sin(x)
    assert x - y is not y - x
    assert graph.state(0) is x
    assert graph.number("a") is not graph.switch("a")


def test_arithmetic_that_does_nothing_leaves_no_nodes(graph):
    x = graph.state(0)
    assert x + 0.0 is x
    assert 0.0 + x is x
    assert x - 0.0 is x
    assert 1.0 * x is x
    assert x / 1.0 is x
    assert (0.0 * x).value == 0.0
    assert (x - x).value == 0.0
    negative = -x
    assert -negative is x
    assert +x is x
    assert (2.0 * x) * 3.0 is 6.0 * x
    assert x + -x * 1.0 is x - x


def test_numpy_scalars_leave_the_arithmetic_to_nodes(graph):
    x = graph.state(0)
    assert np.float64(2.0) * x is 2.0 * x
    assert np.float64(2.0) / x is 2.0 / x
    assert x - np.float64(2.0) is x - 2.0


def test_powers_are_products_and_roots_where_they_can_be(graph):
    x = graph.state(0)
    assert x**2 is x * x
    assert x**0 is graph.constant(1.0)
    assert x**3 is x * (x * x)
    assert x**-2 is 1.0 / (x * x)
    assert x**0.5 is graph.sqrt(x)
    assert x**1.5 is graph.sqrt(x) * x
    assert (x**1.3).operation == "power"
    assert (x ** graph.number("p")).operation == "power"
    assert (2.0**x).operation == "exp"
    assert x**x is graph.exp(x * graph.log(x))


def test_what_depends_on_numbers_alone_is_fixed(graph):
    x, a = graph.state(0), graph.number("a")
    assert (2.0 * a + graph.sin(a)).fixed
    assert not (a * x).fixed
    assert not graph.switch("side").fixed
    assert (x / a).operation == "multiply"  # by the reciprocal, taken once a member
    assert graph.sin(1.0).operation == "sin"  # a library's sine is not the same everywhere
    assert graph.sqrt(4.0).value == 2.0
    assert (1.0 / graph.constant(0.0)).operation == "divide"


def test_values_that_change_cannot_be_branched_on(graph):
    with pytest.raises(TypeError, match="cannot branch"):
        bool(graph.state(0))


def test_arguments_come_before_what_takes_them(graph):
    x = graph.state(0)
    root = graph.exp(graph.sin(x) * x) / (1.0 + x)
    nodes = ordered([root])
    assert len({node.index for node in nodes}) == len(nodes)
    seen = set()
    for node in nodes:
        assert {a.index for a in node.arguments} <= seen
        seen.add(node.index)
    assert graph.cos(x).index in seen  # the sine's coefficients need the cosine's


def test_a_fingerprint_does_not_depend_on_what_else_was_traced(graph):
    def formula(g):
        x, a = g.state(0), g.number("a")
        return [a * x + g.sin(x), 3.0 * x]

    first = fingerprint(formula(graph))
    other = Graph()
    other.exp(other.state(3) * 7.0)
    assert fingerprint(formula(other)) == first
    assert fingerprint([graph.number("b") * graph.state(0)]) != fingerprint([graph.number("a") * graph.state(0)])
    assert fingerprint([2.0 * graph.state(0)]) != fingerprint([np.nextafter(2.0, 3.0) * graph.state(0)])


def test_long_chains_need_no_deep_recursion(graph):
    x = graph.state(0)
    total = x
    for k in range(5000):
        total = total * x + float(k)
    assert len(ordered([total])) > 10_000


@pytest.mark.parametrize("operation", [operator.add, operator.sub, operator.mul, operator.truediv, operator.pow])
def test_what_is_drawn_together_has_the_value_of_what_was_written(graph, operation):
    """Of 0, 1, -1, numbers, states, their negatives and their multiples, in every pair."""
    x, y = graph.state(0), graph.state(1)
    values = {x.index: 1.7, y.index: 0.6}
    numbers = [(number, number) for number in (0.0, 1.0, -1.0, 2.0, 0.5)]
    terms = [(x, 1.7), (y, 0.6), (2.0 * y, 1.2), (x + y, 2.3), (1.0 / x, 1.0 / 1.7), *numbers]
    terms += [] if operation is operator.pow else [(-x, -1.7), (-2.0 * y, -1.2)]
    for (one, first), (other, second) in itertools.product(terms, terms):
        undefined = second == 0.0 if operation is operator.truediv else operation is operator.pow and first <= 0.0
        if not undefined:
            (found,) = evaluated([graph.node(operation(one, other))], values)
            assert found == pytest.approx(operation(first, second), rel=1e-12), (first, second)


def test_zeros_of_either_sign_and_arrays_of_other_shapes_are_not_drawn_together(graph):
    assert graph.constant(-0.0) is not graph.constant(0.0)
    assert np.signbit(graph.constant(-0.0).value)
    six = np.arange(6.0)
    assert graph.node(six) is graph.node(six.copy())
    assert graph.node(six.reshape(2, 3)) is not graph.node(six.reshape(3, 2))
    assert graph.node(six) is not graph.node(six.astype(np.float32))


def test_nothing_over_a_value_is_nothing_and_large_powers_go_by_logarithm(graph):
    x = graph.state(0)
    assert (0.0 / x).value == 0.0
    for exponent in (32, -32):
        assert (x**exponent).operation in ("multiply", "divide")
    for exponent in (33, -33, 40.5, -1000):
        assert (x**exponent).operation == "power"


def test_the_maximum_is_the_larger_one(graph):
    x, y = graph.state(0), graph.state(1)
    one, other = np.array([0.3, -2.0, 5.0, 1.0]), np.array([0.4, -3.0, -5.0, 1.0])
    found = evaluated([graph.maximum(x, y), graph.maximum(x, 0.5)], {x.index: one, y.index: other})
    np.testing.assert_allclose(found, [np.maximum(one, other), np.maximum(one, 0.5)], rtol=1e-15)


def rooted(graph, factor=1.0, begin=0.0, longest=0.5):
    x = graph.state(0)
    return graph.root("y", lambda y, x, xp: factor * y + y * y * y - x, [x], lambda x, xp: begin + x, longest)


def test_a_name_of_a_root_stands_for_one_equation(graph):
    assert rooted(graph) is rooted(graph)
    with pytest.raises(ValueError, match="root 'y': stands for two equations; give one of them another name"):
        rooted(graph, factor=2.0)


@pytest.mark.parametrize("other", [{"factor": 2.0}, {"begin": 0.1}, {"longest": 0.25}])
def test_a_fingerprint_tells_roots_of_another_equation_beginning_or_longest_step_apart(other):
    """A program that is stored under it would else solve another equation, or come to another root."""
    own, same, changed = (fingerprint([2.0 * rooted(Graph(), **more)]) for more in ({}, {}, other))
    assert own == same != changed
