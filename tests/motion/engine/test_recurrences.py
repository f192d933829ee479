"""Taylor coefficients of each operation, of sums of products and of roots, against those of mpmath with 40 digits."""

import ctypes
import math
from types import SimpleNamespace

import mpmath
import numpy as np
import pytest

from gelcone.motion.engine import compile as compiler
from gelcone.motion.engine.code import Function
from gelcone.motion.engine.machine_code import aligned
from gelcone.motion.engine.recurrences import Jet, equations_of, evaluate, held_values
from gelcone.physics.trace import Graph, ordered

WIDTH, ORDER = 4, 9
NUMBERS = {"a": np.array([0.7, 1.3, -0.4, 2.1]), "b": np.array([0.3, 0.2, 0.9, 0.5])}
STATES = np.array([[0.4, -0.3, 0.8, 0.1], [0.2, 0.6, -0.5, 0.9]])
TIME = np.array([0.5, 0.0, 1.7, -0.2])
MPMATH = SimpleNamespace(
    sin=mpmath.sin, cos=mpmath.cos, exp=mpmath.exp, log=mpmath.log, sqrt=mpmath.sqrt, log1p=lambda z: mpmath.log(1 + z)
)


def rates(x, u, t, n, xp):
    """A turning motion, of which each Taylor coefficient is known: x = x_0 cos h + u_0 sin h."""
    return [u, -x]


def compiled(formulas, rates=rates, order=ORDER, highest=None, found=math.nan):
    """Coefficients of formulas and roots (rows, order + 1, lanes), and of the states; ``found``, the roots' last
    values."""
    graph, f = Graph(), Function("jet", ["ptr %given", "ptr %roots", "ptr %out"], "void", WIDTH, external=True)
    x, u = graph.state(0), graph.state(1)
    n = {name: graph.number(name) for name in NUMBERS}
    own = [graph.node(rate) for rate in rates(x, u, graph.time, n, graph)]
    wanted = [graph.node(formula(x, u, graph.time, n, graph)) for formula in formulas]
    equations = equations_of([*own, *wanted])
    parts = [node for equation in equations for node in (*equation.slopes, equation.first)]
    values = {}
    for node in ordered(held_values([*own, *wanted, *parts])):
        if node.operation == "number":
            values[node.index] = f.load(f.place("%given", (3 + list(NUMBERS).index(node.value)) * WIDTH))
        elif node.fixed:
            values[node.index] = evaluate(f, node, [values[a.index] for a in node.arguments])
    states = [f.load(f.place("%given", k * WIDTH)) for k in range(2)]
    time = f.load(f.place("%given", 2 * WIDTH))
    addresses = [f.place("%roots", k * WIDTH) for k in range(len(equations))]
    highest = highest or [order] * len(wanted)
    jet = Jet(f, own, list(zip(wanted, highest, strict=True)), order, states, time, values, equations, addresses)
    rows = [*jet.states, *jet.borders, *jet.roots]
    for k, row in enumerate(rows):
        for j, value in enumerate(row):
            f.store(f.real(0.0) if value is None else value, f.place("%out", (k * (order + 1) + j) * WIDTH))
    f.finish()
    text = "\n".join([*sorted(f.intrinsics), f.text()])
    library = compiler.Library(compiler.object_code(text, compiler.host(), compiler.COLD), compiler.host())
    given, roots, out = aligned(5, WIDTH), aligned(2, WIDTH), aligned(len(rows), order + 1, WIDTH)
    given[:2], given[2], given[3:] = STATES, TIME, list(NUMBERS.values())
    roots[: len(equations)] = np.reshape(found, (-1, 1)) if np.ndim(found) < 2 else found
    library.function("jet", None, *[ctypes.c_void_p] * 3)(given.ctypes.data, roots.ctypes.data, out.ctypes.data)
    return out[2:], out[:2], roots[: len(equations)], rows


def exact(formula, lane, order=ORDER):
    """The Taylor coefficients of a formula along the turning motion, with 40 digits."""
    with mpmath.workdps(40):
        x, u, t = (mpmath.mpf(float(value[lane])) for value in (*STATES, TIME))
        n = {name: mpmath.mpf(float(value[lane])) for name, value in NUMBERS.items()}

        def along(h):
            at = x * mpmath.cos(h) + u * mpmath.sin(h), u * mpmath.cos(h) - x * mpmath.sin(h)
            return formula(*at, t + h, n, MPMATH)

        return [float(c) for c in mpmath.taylor(along, 0, order)]


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


def assert_rows(found, formula, order=ORDER):
    for lane in range(WIDTH):
        right = exact(formula, lane, order)
        np.testing.assert_allclose(found[: order + 1, lane], right, rtol=1e-12, atol=1e-13 * max(map(abs, right)))


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


def test_a_border_of_low_order_has_no_more_coefficients_than_it_asks_for():
    product, other = FORMULAS["product"], FORMULAS["exp"]
    found, _, _, rows = compiled([product, other], highest=[3, ORDER])
    assert [len(row) for row in rows] == [ORDER + 1, ORDER + 1, 4, ORDER + 1]
    assert_rows(found[0], product, 3)
    assert_rows(found[1], other)


def test_a_part_has_the_order_of_the_longest_of_what_is_made_of_it():
    def product(x, u, t, n, xp):
        return x * u - t

    def made(*at):
        return at[4].exp(product(*at))

    for formulas, highest in (([made, product], [ORDER, 3]), ([product, made], [3, ORDER])):
        found, _, _, rows = compiled(formulas, highest=highest)
        assert [len(row) for row in rows[2:]] == [order + 1 for order in highest]
        for row, formula, order in zip(found, formulas, highest, strict=True):
            assert_rows(row, formula, order)


def test_coefficients_known_to_be_zero_cost_nothing():
    time = (
        lambda x, u, t, n, xp: t * t * t - t,
        lambda x, u, t, n, xp: n["a"] - 3.0 * t,
        lambda x, u, t, n, xp: n["a"],
    )
    _, _, _, rows = compiled(time)
    for row, terms in zip(rows[2:], (4, 2, 1), strict=True):
        assert [k for k, value in enumerate(row) if value is not None] == list(range(terms))


# --- roots ------------------------------------------------------------------------------------------------------------


CIRCLE = 0.25 * np.exp(2j * np.pi * np.arange(64) / 64)


def on_circle(formula):
    """The Taylor coefficients (order + 1, lanes) of a formula from its values around the start, in complex numbers."""
    h, (x, u) = CIRCLE[:, None], STATES
    n = {name: value + 0.0 * h for name, value in NUMBERS.items()}
    at = x * np.cos(h) + u * np.sin(h), u * np.cos(h) - x * np.sin(h)
    terms = np.fft.fft(formula(*at, TIME + h, n, np), axis=0).real / CIRCLE.size
    return terms[: ORDER + 1] / 0.25 ** np.arange(ORDER + 1)[:, None]


def solved(residuals, guesses):
    """The roots of equations by Newton's method with differences, in complex numbers."""
    roots = np.stack(guesses)
    for _ in range(30):
        value, columns = np.stack(residuals(*roots)), []
        for k in range(len(roots)):
            moved = roots.copy()
            moved[k] += 1e-7
            columns.append((np.stack(residuals(*moved)) - value) / 1e-7)
        matrix = np.moveaxis(np.array(columns), (0, 1), (-1, -2))
        roots = roots - np.moveaxis(np.linalg.solve(matrix, np.moveaxis(value, 0, -1)[..., None])[..., 0], -1, 0)
    return roots


def cubic(y, x, u, n, xp):
    """Sums that contain the root, products of it, and functions of it."""
    return y + y * y * y / 3.0 + xp.sin(y) * x * 0.1 - u * n["b"] - 0.2 * xp.exp(0.1 * y)


def of_cubic(x, u, t, n, xp):
    return xp.root("y", lambda y, x, u, xp: cubic(y, x, u, n, xp), [x, u], lambda x, u, xp: 0.0 * x + 0.3)


@pytest.mark.parametrize(
    "found", [math.nan, 0.25, np.array([[math.nan, 0.4, math.nan, -3.0]])], ids=["new", "near", "mixed"]
)
def test_coefficients_of_a_root_and_of_what_is_made_of_it(found):
    """From its first guess, from a value near it, and with lanes of both kinds."""

    def root(x, u, t, n, xp):
        return solved(lambda y: [cubic(y, x, u, n, xp)], [0.3 + 0.0 * x])[0]

    made = (
        (of_cubic, root),
        (lambda *at: of_cubic(*at) * at[0] - at[2], lambda *at: root(*at) * at[0] - at[2]),
        (lambda *at: at[4].cos(of_cubic(*at)), lambda *at: np.cos(root(*at))),
    )
    rows, _, last, _ = compiled([traced for traced, _ in made], found=found)
    for row, (_, formula) in zip(rows, made, strict=False):
        np.testing.assert_allclose(row, on_circle(formula), rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(row[:4], on_circle(formula)[:4], rtol=1e-12, atol=1e-13)
    np.testing.assert_array_equal(rows[len(made)], rows[0])
    np.testing.assert_array_equal(last[0], rows[0, 0])


def of_two_values(x, u, t, n, xp):
    """sqrt(2 + x) or the opposite."""
    return xp.root("y", lambda y, x, xp: y * y - 2.0 - x, [x], lambda x, xp: 1.0 + 0.0 * x)


def test_a_root_that_has_a_value_follows_it_and_one_without_begins_at_the_guess():
    found = np.array([[-1.5, math.nan, 1.2, -1.2]])
    rows, _, _, _ = compiled([of_two_values], found=found)
    signs = np.array([-1.0, 1.0, 1.0, -1.0])
    np.testing.assert_allclose(rows[0, 0], signs * np.sqrt(2.0 + STATES[0]), rtol=1e-14)
    np.testing.assert_allclose(rows[0, 1], STATES[1] / (2.0 * rows[0, 0]), rtol=1e-13)


def test_a_root_has_the_same_bits_however_long_its_neighbours_take():
    """Of (y - 1)^3 multiplied out, whose rounding moves a root by more than its last digits with each correction."""

    def noisy(x, u, t, n, xp):
        return xp.root(
            "y", lambda y, x, xp: ((y - 3.0) * y + 3.0) * y - 1.0 - 0.001 * (2.0 + x), [x], lambda x, xp: 1.2 + 0.0 * x
        )

    far, near = 1e6, 1.0 + np.cbrt(0.001 * (2.0 + STATES[0])) + 1e-7
    _, _, together, _ = compiled([noisy], found=np.array([near]))
    np.testing.assert_allclose(together[0], near, atol=1e-6)
    for lane in range(WIDTH):
        others = np.array([np.where(np.arange(WIDTH) == lane, near, far)])
        _, _, last, _ = compiled([noisy], found=others)
        assert last[0, lane] == together[0, lane]


def test_rates_may_contain_roots():
    """x' = s with s^2 = 1 + x: 1 + x = (sqrt(1 + x_0) + h/2)^2."""

    def flow(x, u, t, n, xp):
        return [xp.root("s", lambda s, x, xp: s * s - 1.0 - x, [x], lambda x, xp: 1.0 + 0.0 * x), 0.0 * u]

    _, states, _, _ = compiled([], rates=flow)
    start = np.sqrt(1.0 + STATES[0])
    np.testing.assert_allclose(states[0, :3], [STATES[0], start, 0.25 * np.ones(WIDTH)], rtol=1e-13)
    np.testing.assert_allclose(states[0, 3:], 0.0, atol=1e-13)


def test_coefficients_of_two_roots_that_depend_on_each_other():
    """y + z y^2/2 = u + 1 and z + sin(z)/3 - y = x^2."""

    def both(x, u, t, n, xp):
        def second(y):
            return xp.root(
                "z", lambda z, y, x, xp: z + xp.sin(z) / 3.0 - y - x * x, [y, x], lambda y, x, xp: 1.0 + x * x
            )

        y = xp.root("y", lambda y, u, xp: y + 0.5 * second(y) * y * y - u - 1.0, [u], lambda u, xp: 0.7 + 0.0 * u)
        return y, second(y)

    def pair(x, u, t, n, xp):
        return solved(
            lambda y, z: [y + z * y * y / 2.0 - u - 1.0, z + np.sin(z) / 3.0 - y - x * x], [0.7 + 0.0 * x, 1.0 + x * x]
        )

    made = (lambda y, z, x: y, lambda y, z, x: z, lambda y, z, x: y * z + x)
    rows, _, _, _ = compiled([lambda *at, of=of: of(*both(*at), at[0]) for of in made])
    for row, of in zip(rows, made, strict=False):
        right = on_circle(lambda *at, of=of: of(*pair(*at), at[0]))
        np.testing.assert_allclose(row, right, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(row[:4], right[:4], rtol=1e-12, atol=1e-12)


def searched(residual, start, longest):
    """The root of a residual of y alone in each lane, from a start."""
    rows, _, _, _ = compiled(
        [lambda x, u, t, n, xp: xp.root(
            "y", lambda y, x, xp: residual(y, x, xp), [x], lambda x, xp: 0.0 * x + start, longest
        )]
    )  # fmt: skip
    return rows[0, 0]


def test_a_search_in_short_steps_meets_the_first_of_several_roots():
    """Of y (x + 2 - 1.5 sin(3 y)) = 4: without a bound Newton's method leaps over some."""

    def residual(y, x, xp):
        return y * (x + 2.0 - 1.5 * xp.sin(3.0 * y)) - 4.0

    grid = np.linspace(0.05, 6.0, 200_001)
    values = residual(grid, STATES[0][:, None], np)
    first = np.array([grid[np.argmax(row > 0.0)] for row in values])
    found = searched(residual, 0.05, 0.05)
    np.testing.assert_allclose(found, first, atol=1e-4)
    assert not np.allclose(searched(residual, 0.05, math.inf), first, atol=1e-4)


def test_a_bounded_search_is_lost_where_the_residual_over_the_root_does_not_rise():
    def residual(y, x, xp):
        return y * (4.0 - y) - 1.0 - x

    assert np.isnan(searched(residual, 9.0, 0.1)).all()
    lower = 2.0 - np.sqrt(3.0 - STATES[0])
    np.testing.assert_allclose(searched(residual, 0.1, math.inf), lower, rtol=1e-12)


def test_an_equation_without_its_root_is_refused():
    graph = Graph()
    with pytest.raises(ValueError, match="root 'y': its equation does not contain it"):
        equations_of([graph.root("y", lambda y, x, xp: x, [graph.state(0)], lambda x, xp: x)])


def test_held_values_are_those_that_what_moves_takes():
    graph = Graph()
    x, a, b = graph.state(0), graph.number("a"), graph.number("b")
    inner, outer = a * b, graph.exp(a * b)
    assert held_values([x * outer + 3.0]) == [outer]
    assert set(held_values([x * outer + inner, b])) == {outer, inner, b}
    assert held_values([x + 1.0]) == []
