"""Jets of formulas compiled for the test motion, and their coefficients by mpmath with 40 digits."""

import ctypes
import math
from types import SimpleNamespace

import mpmath
import numpy as np

from gelcone.motion.engine import compile as compiler
from gelcone.motion.engine.code import Function
from gelcone.motion.engine.equations import equations_of
from gelcone.motion.engine.jet import Jet
from gelcone.motion.engine.machine_code import aligned
from gelcone.motion.engine.recurrences import evaluate, held_values
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


def assert_rows(found, formula, order=ORDER):
    for lane in range(WIDTH):
        right = exact(formula, lane, order)
        np.testing.assert_allclose(found[: order + 1, lane], right, rtol=1e-12, atol=1e-13 * max(map(abs, right)))
