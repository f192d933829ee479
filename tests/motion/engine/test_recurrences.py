"""Taylor coefficients of each operation and of sums of products, against those of mpmath with 40 digits."""

import pytest

from gelcone.motion.engine.recurrences import held_values
from gelcone.physics.trace import Graph
from tests.motion.engine.jets import assert_rows, compiled

FORMULAS = {
    "sum": lambda x, u, t, n, xp: 2.0 * x - 3.0 * u + t - n["a"],
    "product": lambda x, u, t, n, xp: x * u,
    "square": lambda x, u, t, n, xp: x * x,
    "square taken away": lambda x, u, t, n, xp: n["a"] - x * x,
    "products in a sum": lambda x, u, t, n, xp: n["a"] * x + x * u - u * u,
    "a fixed factor taken away": lambda x, u, t, n, xp: x * u - n["a"] * (x * x),
    "products taken away": lambda x, u, t, n, xp: (x - x * u) - (u * t - (x + u * n["b"])),
    "sums in sums": lambda x, u, t, n, xp: (x * u + t) - ((u - t * x) + (x - u)),
    "a shared product": lambda x, u, t, n, xp: (x * u + t) * (x * u - t),
    "quotient": lambda x, u, t, n, xp: (x + t) / (3.0 + u * t),
    "reciprocal": lambda x, u, t, n, xp: n["a"] / (2.0 + x * x),
    "over the same": lambda x, u, t, n, xp: x / (2.0 + u) + (t - u) / (2.0 + u),
    "root": lambda x, u, t, n, xp: xp.sqrt(2.0 + x * u),
    "root of time": lambda x, u, t, n, xp: xp.sqrt(3.0 + t) * x,
    "exp": lambda x, u, t, n, xp: xp.exp(x - 0.5 * t * u),
    "exp of time": lambda x, u, t, n, xp: xp.exp(n["b"] * t),
    "log": lambda x, u, t, n, xp: xp.log(3.0 + x + t),
    "log1p": lambda x, u, t, n, xp: xp.log1p(0.25 * (x * u) + 0.1 * t),
    "logs of the same": lambda x, u, t, n, xp: xp.log1p(x * x) / (1.0 + x * x),
    "sine": lambda x, u, t, n, xp: xp.sin(x + t * u),
    "cosine": lambda x, u, t, n, xp: xp.cos(2.0 * x),
    "sine and cosine": lambda x, u, t, n, xp: xp.sin(x) * xp.cos(x) - xp.cos(u),
    "sine of time": lambda x, u, t, n, xp: xp.sin(n["a"] * t),
    "power": lambda x, u, t, n, xp: (2.0 + x) ** n["a"],
    "power of time": lambda x, u, t, n, xp: (3.0 + t) ** n["b"] - x,
    "cube": lambda x, u, t, n, xp: (x - t) ** 3,
    "negative power": lambda x, u, t, n, xp: (2.0 + x) ** -2,
    "half power": lambda x, u, t, n, xp: (2.0 + x * x) ** 1.5,
    "exponent that moves": lambda x, u, t, n, xp: (2.0 + x) ** (u + t),
    "fixed functions": lambda x, u, t, n, xp: xp.exp(n["b"]) * x + xp.sin(n["a"]) * u + xp.log1p(n["b"]) * t,
    "a fixed divisor": lambda x, u, t, n, xp: x * u / (1.0 + n["b"]),
    "a number alone": lambda x, u, t, n, xp: n["a"] * n["b"],
    "time": lambda x, u, t, n, xp: t * t - 2.0 * t,
}  # fmt: skip


@pytest.fixture(scope="module")
def all_rows():
    """All formulas in one function, as a step holds them: they share nodes."""
    return dict(zip(FORMULAS, compiled(FORMULAS.values())[0], strict=True))


@pytest.mark.parametrize("name", FORMULAS)
def test_coefficients_of_each_operation(name, all_rows):
    assert_rows(all_rows[name], FORMULAS[name])


@pytest.mark.parametrize("name", ["products in a sum", "a fixed factor taken away", "square taken away", "log1p"])
def test_coefficients_of_an_operation_alone(name):
    """Where nothing else takes its parts these become links of one chain."""
    found, states, _, _ = compiled([FORMULAS[name]])
    assert_rows(found[0], FORMULAS[name])
    assert_rows(states[0], lambda x, u, t, n, xp: x)
    assert_rows(states[1], lambda x, u, t, n, xp: u)


def test_held_values_are_those_that_what_moves_takes():
    graph = Graph()
    x, a, b = graph.state(0), graph.number("a"), graph.number("b")
    inner, outer = a * b, graph.exp(a * b)
    assert held_values([x * outer + 3.0]) == [outer]
    assert set(held_values([x * outer + inner, b])) == {outer, inner, b}
    assert held_values([x + 1.0]) == []
