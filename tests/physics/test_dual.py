"""Dual numbers: exact derivatives against SymPy, over floats, arrays, symbols and compiled expressions."""

from types import SimpleNamespace

import numpy as np
import pytest
import sympy

from gelcone.physics.dual import Dual, Functions, derivative, gradients

SYMBOLIC = SimpleNamespace(
    log1p=lambda z: sympy.log(1 + z), **{name: getattr(sympy, name) for name in ("sin", "cos", "exp", "log", "sqrt")}
)
FUNCTIONS = ("sin", "cos", "exp", "log", "log1p", "sqrt")
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
        lambda z, xp: one(z, xp) * other(z, xp),
        lambda z, xp: one(z, xp) / (1.0 + other(z, xp)),
        lambda z, xp: number / (number + one(z, xp)),
        lambda z, xp: 9.0 - xp.sin(one(z, xp)) - xp.cos(number * other(z, xp)),
        lambda z, xp: xp.exp(-one(z, xp) * number) + other(z, xp),
        lambda z, xp: xp.log1p(one(z, xp)) * number + xp.log(1.0 + other(z, xp)),
        lambda z, xp: xp.sqrt(one(z, xp)) + other(z, xp) ** 2,
        lambda z, xp: (1.0 + one(z, xp)) ** -1.5,
        lambda z, xp: 4.0 - (-one(z, xp)) / number,
    ][int(rng.integers(11))]


def evaluated(expression, point):
    return float(expression.subs(dict(zip(VARIABLES, point, strict=True))).evalf(30))


@pytest.mark.parametrize("seed", [*range(12), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(12, 25))])
def test_gradients_of_random_formulas_are_sympys(seed):
    rng = np.random.default_rng(seed)
    formula = random_formula(rng)
    exact = formula(VARIABLES, SYMBOLIC)
    for point in rng.uniform(0.2, 2.0, (3, 3)):
        ((*parts,),) = gradients(lambda z, xp: [formula(z, xp)], list(point))
        expected = [evaluated(sympy.diff(exact, variable), point) for variable in VARIABLES]
        np.testing.assert_allclose(parts, expected, rtol=1e-12, atol=1e-14)
        value = formula([Dual(z, [0.0]) for z in point], Functions(np))
        assert getattr(value, "value", value) == pytest.approx(evaluated(exact, point), rel=1e-13)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_each_function_has_its_derivative(name):
    x = sympy.Symbol("x")
    exact = sympy.diff(getattr(SYMBOLIC, name)(x), x)
    for at in (0.3, 1.7):
        found = derivative(lambda z, xp: getattr(xp, name)(z), at)
        assert found == pytest.approx(float(exact.subs(x, at)), rel=1e-14)
    symbolic = gradients(lambda z, xp: [getattr(xp, name)(z[0])], [x], SYMBOLIC)[0][0]
    assert sympy.simplify(symbolic - exact) == 0
    assert getattr(Functions(np), name)(0.5) == getattr(np, name)(0.5)  # what is no dual passes through


@pytest.mark.parametrize(
    ("formula", "slope"),
    [
        (lambda z: 3.0 - z, -1.0),
        (lambda z: z - 3.0, 1.0),
        (lambda z: -z, -1.0),
        (lambda z: 2.0 * z, 2.0),
        (lambda z: z / 4.0, 0.25),
        (lambda z: 3.0 / z, -0.75),
        (lambda z: z / z, 0.0),
        (lambda z: z**3, 12.0),
        (lambda z: z**0.5, 0.5 / np.sqrt(2.0)),
        (lambda z: z**-2, -0.25),
        (lambda z: (z * z - z) / (1.0 + z), 7.0 / 9.0),
        (lambda z: z - z, 0.0),
    ],
)
def test_each_operation_by_hand_at_two(formula, slope):
    assert derivative(lambda z, xp: formula(z), 2.0) == pytest.approx(slope, rel=1e-15)


def test_an_array_on_the_left_leaves_the_operation_to_the_dual():
    numbers = np.array([1.0, 2.0, 5.0])
    for formula, slope in (
        (lambda z: numbers + z, np.ones(3)),
        (lambda z: numbers - z, -np.ones(3)),
        (lambda z: numbers * z, numbers),
        (lambda z: numbers / z, -numbers / 9.0),
        (lambda z: np.float64(2.0) * z, 2.0),
        (lambda z: np.float64(2.0) / z, -2.0 / 9.0),
    ):
        dual = formula(Dual(3.0, [1.0]))
        assert isinstance(dual, Dual)
        np.testing.assert_allclose(np.broadcast_to(dual.parts[0], np.shape(slope)), slope, rtol=1e-15)


def test_arrays_give_the_derivatives_of_their_elements():
    a, b = np.random.default_rng(2).uniform(0.2, 2.0, (2, 4, 3))
    formula = random_formula(np.random.default_rng(12))
    together = gradients(lambda z, xp: [formula([*z, z[0]], xp)], [a, b])[0]
    for index in np.ndindex(a.shape):
        alone = gradients(lambda z, xp: [formula([*z, z[0]], xp)], [a[index], b[index]])[0]
        for part, single in zip(together, alone, strict=True):
            assert np.broadcast_to(part, a.shape)[index] == pytest.approx(single, rel=1e-13)


def test_a_zero_part_stays_the_float_zero_and_costs_no_operation():
    """The compiled program then has no term for it; a 0 times a symbol would be one."""
    x, y = sympy.symbols("x y")
    rows = gradients(
        lambda z, xp: [xp.sin(z[0]) * 3.0 + z[0] / 2.0, z[1], 5.0, 1.0 / (1.0 + z[1] ** 2), z[0] * z[1]],
        [x, y],
        SYMBOLIC,
    )
    assert all(isinstance(rows[i][j], float) and rows[i][j] == 0.0 for i, j in ((0, 1), (1, 0), (2, 0), (2, 1), (3, 0)))
    assert rows[1][1] == 1.0
    assert isinstance(rows[1][1], float)
    assert rows[4] == [y, x]


def test_symbols_and_the_compiled_programs_expressions():
    hk = pytest.importorskip("heyoka")
    from heyoka_backend import functions

    formula = random_formula(np.random.default_rng(7))
    names = [hk.expression(name) for name in "abc"]
    parts = gradients(lambda z, xp: [formula(z, xp)], names, functions())[0]
    compiled = hk.cfunc([hk.expression(part) if isinstance(part, float) else part for part in parts], vars=names)
    exact = formula(VARIABLES, SYMBOLIC)
    point = np.array([0.4, 1.3, 0.9])
    expected = [evaluated(sympy.diff(exact, variable), point) for variable in VARIABLES]
    np.testing.assert_allclose(compiled(point), expected, rtol=1e-12)
