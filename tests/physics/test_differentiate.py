"""Derivatives of formulas against differences and SymPy, and their values by NumPy."""

import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from gelcone.physics.differentiate import Gradients, derivative, derivatives, evaluated, gradients, jacobian
from gelcone.physics.trace import Graph, ordered

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
@settings(deadline=None)
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


# --- values by NumPy --------------------------------------------------------------------------------------------------

SYMBOLIC = SimpleNamespace(
    log1p=lambda z: sympy.log(1 + z), **{name: getattr(sympy, name) for name in ("sin", "cos", "exp", "log", "sqrt")}
)
VARIABLES = sympy.symbols("a b c", positive=True)


def random_formula(rng, depth=4):
    """A random formula of three positive variables that stays positive: ``formula(variables, xp)``."""
    if depth == 0:
        pick = int(rng.integers(3))
        return lambda z, xp: z[pick]
    one, other = (random_formula(rng, depth - 1) for _ in range(2))
    number = float(rng.integers(1, 9)) / 4.0
    return [
        lambda z, xp: one(z, xp) + other(z, xp),
        lambda z, xp: one(z, xp) - 0.125 * other(z, xp) * one(z, xp) / (1.0 + other(z, xp)),
        lambda z, xp: one(z, xp) / (1.0 + other(z, xp)),
        lambda z, xp: number / (number + one(z, xp)),
        lambda z, xp: 9.0 - xp.sin(one(z, xp)) - xp.cos(number * other(z, xp)),
        lambda z, xp: xp.exp(-one(z, xp) * number) + other(z, xp),
        lambda z, xp: xp.log1p(one(z, xp)) * number + xp.log(1.0 + other(z, xp)),
        lambda z, xp: xp.sqrt(one(z, xp)) + other(z, xp) ** 2,
        lambda z, xp: (1.0 + one(z, xp)) ** -1.5,
        lambda z, xp: 4.0 - (-one(z, xp)) / number,
    ][int(rng.integers(10))]


@pytest.mark.parametrize("seed", range(12))
def test_gradients_of_random_formulas_are_sympys(seed):
    rng = np.random.default_rng(seed)
    formula = random_formula(rng)
    exact = formula(VARIABLES, SYMBOLIC)
    points = rng.uniform(0.2, 2.0, (3, 4))
    (parts,) = gradients(lambda z, xp: [formula(z, xp)], list(points))
    for variable, part in zip(VARIABLES, parts, strict=True):
        slope = sympy.diff(exact, variable)
        expected = [float(slope.subs(dict(zip(VARIABLES, point, strict=True))).evalf(30)) for point in points.T]
        np.testing.assert_allclose(np.broadcast_to(part, 4), expected, rtol=1e-12, atol=1e-14)


def test_gradients_are_traced_once_for_many_places_and_numbers():
    traced = []

    def values(z, n, xp):
        traced.append(xp)
        return [n["a"] * z[0] * z[1], xp.exp(z[0])]

    slopes = Gradients(values, 2, ("a",))
    for a in (2.0, np.array([3.0, -1.0])):
        (by_first, by_second), (other, none) = slopes([0.5, np.array([1.0, 4.0])], {"a": a})
        np.testing.assert_allclose(by_first, a * np.array([1.0, 4.0]), rtol=1e-15)
        np.testing.assert_allclose(by_second, 0.5 * a, rtol=1e-15)
        assert (other, none) == (np.exp(0.5), 0.0)
    assert len(traced) == 1


def test_arrays_that_a_formula_holds_leave_their_arithmetic_to_nodes():
    numbers = np.array([1.0, 2.0, 5.0])
    for formula, slope in (
        (lambda z: numbers + z, np.ones(3)),
        (lambda z: numbers - z, -np.ones(3)),
        (lambda z: z * numbers, numbers),
        (lambda z: numbers / z, -numbers / 9.0),
    ):
        found = derivative(lambda z, xp, formula=formula: formula(z), 3.0)
        np.testing.assert_allclose(np.broadcast_to(found, 3), slope, rtol=1e-15)


def test_a_root_of_a_graph_is_evaluated_with_what_it_depends_on():
    graph = Graph()
    a = graph.number("a")
    root = graph.root("y", lambda y, at, xp: y * xp.exp(y) - at, [a], lambda at, xp: xp.log1p(at))
    (slope,) = derivatives([root * root], a)
    wanted = np.array([0.1, 0.7, 2.0])
    found = evaluated([root, slope], {a.index: wanted * np.exp(wanted)})
    np.testing.assert_allclose(found[0], wanted, rtol=1e-15)
    np.testing.assert_allclose(found[1], 2.0 * wanted / (np.exp(wanted) * (1.0 + wanted)), rtol=1e-13)


def test_roots_of_an_array_are_those_of_its_elements_though_some_have_none():
    """w is the root of w + w^3 = a + y within the equation of y; the equations and their beginnings hold arrays."""
    shift, low = np.linspace(0.0, 1.0, 7)[:, None], np.linspace(0.0, 0.2, 40)

    def outer(graph, a, b, shift, low):
        def inner(y, a, xp):
            return xp.root("w", lambda w, y, a, xp: w + w * w * w - a - y, [y, a], lambda y, a, xp: a + xp.node(low))

        return graph.root(
            "y",
            lambda y, a, b, xp: xp.exp(y) + b * y * y - inner(y, a, xp) - xp.node(shift),
            [a, b],
            lambda a, b, xp: 0.5 * a + xp.node(low),
        )

    rng, graph = np.random.default_rng(3), Graph()
    a, b = graph.state(0), graph.state(1)
    values = {a.index: rng.uniform(-1.0, 3.0, 40), b.index: rng.uniform(0.0, 2.0, (7, 1))}
    together = evaluated([outer(graph, a, b, shift, low)], values)[0]
    some = np.arange(0, 40, 6)
    alone = np.full((7, 40), np.nan)
    for i, j in itertools.product(range(7), some):
        own = Graph()
        p, q = own.state(0), own.state(1)
        node = outer(own, p, q, float(shift[i, 0]), float(low[j]))
        alone[i, j] = evaluated([node], {p.index: values[a.index][j], q.index: values[b.index][i, 0]})[0]
    np.testing.assert_allclose(together[:, some], alone[:, some], rtol=1e-13, atol=1e-13)
    finite = np.isfinite(together)
    sums = np.where(finite, values[a.index] + np.where(finite, together, 0.0), 0.0)
    w = np.array([[np.roots([1.0, 0.0, 1.0, -t])[-1].real for t in row] for row in sums])
    with np.errstate(all="ignore"):
        exists = finite & (np.abs(np.exp(together) + values[b.index] * together**2 - w - shift) < 1e-12)
    assert 50 < exists.sum() < 200  # the others are of no use, and wander until the last step


def test_the_slopes_of_two_roots_that_depend_on_each_other_are_those_of_their_equations():
    """m n^2 = a and m + n = b: by hand, in the order in which they are made and in the other."""
    graph = Graph()
    a, b = graph.state(0), graph.state(1)

    def n_of(m, a, b, xp):
        return xp.root("n", lambda n, m, a, b, xp: m + n - b, (m, a, b), lambda m, a, b, xp: 0.4 * b)

    m = graph.root("m", lambda m, a, b, xp: m * n_of(m, a, b, xp) ** 2.0 - a, (a, b), lambda a, b, xp: 0.3 * b)
    n = n_of(m, a, b, graph)
    for of, by, exact in [
        (m, a, lambda m, n: 1.0 / (n * n - 2.0 * m * n)),
        (n, a, lambda m, n: -1.0 / (n * n - 2.0 * m * n)),
    ]:
        (slope,) = derivatives([of], by)
        values = {m.index: 0.5, n.index: 1.4, a.index: 0.5 * 1.4**2, b.index: 1.9}
        assert float(evaluated([slope], values)[0]) == pytest.approx(exact(0.5, 1.4), rel=1e-12)


def test_two_roots_that_depend_on_each_other_are_found_together():
    """m n^2 = a and m + n = b, whichever is asked for first."""

    def of(graph, first):
        a, b = graph.state(0), graph.state(1)

        def n_of(m, a, b, xp):
            return xp.root("n", lambda n, m, a, b, xp: m + n - b, (m, a, b), lambda m, a, b, xp: 0.7 * b)

        m = graph.root("m", lambda m, a, b, xp: m * n_of(m, a, b, xp) ** 2.0 - a, (a, b), lambda a, b, xp: 0.2 * b)
        n = n_of(m, a, b, graph)
        found = evaluated([m, n] if first == "m" else [n, m], {a.index: np.array([0.98, 0.5]), b.index: 1.9})
        slopes = evaluated(
            [derivatives([root], by)[0] for root in (m, n) for by in (a, b)],
            {a.index: np.array([0.98, 0.5]), b.index: 1.9},
        )
        return (found if first == "m" else found[::-1]), slopes

    for first in ("m", "n"):
        (m, n), slopes = of(Graph(), first)
        np.testing.assert_allclose(m * n**2, [0.98, 0.5], rtol=1e-12)
        np.testing.assert_allclose(m + n, 1.9, rtol=1e-14)
        determinant = n * n - 2.0 * m * n
        exact = [1.0 / determinant, -2.0 * m * n / determinant, -1.0 / determinant, n * n / determinant]
        np.testing.assert_allclose(slopes, exact, rtol=1e-11)


def test_more_than_two_roots_that_depend_on_each_other_are_refused():
    graph = Graph()
    a = graph.state(0)

    def third(y, x, a, xp):
        return xp.root("z", lambda z, x, y, a, xp: z + x * y - a, (x, y, a), lambda x, y, a, xp: a)

    def second(x, a, xp):
        return xp.root("y", lambda y, x, a, xp: y + x * third(y, x, a, xp) - a, (x, a), lambda x, a, xp: a)

    x = graph.root("x", lambda x, a, xp: x + second(x, a, xp) - a, (a,), lambda a, xp: a)
    with pytest.raises(ValueError, match="more than two roots depend on each other"):
        derivatives([x], a)
