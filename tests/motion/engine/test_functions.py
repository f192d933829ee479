"""Sine, cosine, exponential, logarithms and powers against 60-digit values."""

import ctypes
import math

import mpmath
import numpy as np
import pytest

from gelcone.motion.engine import compile as compiler
from gelcone.motion.engine import functions
from gelcone.motion.engine.code import Function
from gelcone.motion.engine.machine_code import aligned

WIDTH = 8
FUNCTIONS = {
    "sin": lambda f, a, b: functions.sine_cosine(f, a)[0],
    "cos": lambda f, a, b: functions.sine_cosine(f, a)[1],
    "exp": lambda f, a, b: functions.exponential(f, a),
    "log": lambda f, a, b: functions.logarithm(f, a)[0],
    "log1p": lambda f, a, b: functions.logarithm_of_one_plus(f, a),
    "power": functions.power,
    "rough_log2": lambda f, a, b: functions.rough_log2(f, a),
    "rough_exp2": lambda f, a, b: functions.rough_exp2(f, a),
}


@pytest.fixture(scope="module")
def compiled():
    """name -> a function on arrays."""
    made, declarations = [], set()
    for name, emit in FUNCTIONS.items():
        f = Function(f"all_{name}", ["ptr %a", "ptr %b", "ptr %result", "i64 %count"], "void", WIDTH, external=True)
        at = f.slot()
        f.store_whole("0", at)
        with f.repeat() as out:
            i = f.load_whole(at)
            f.leave(out, f.new(f"icmp sge i64 {i}, %count"))
            f.store(emit(f, f.load(f.place("%a", i)), f.load(f.place("%b", i))), f.place("%result", i))
            f.store_whole(f.new(f"add i64 {i}, {WIDTH}"), at)
        f.finish()
        made.append(f.text())
        declarations |= f.intrinsics
    library = compiler.Library(
        compiler.object_code("\n".join([*declarations, *made]), compiler.host()), compiler.host()
    )

    def caller(name):
        pointer = ctypes.c_void_p
        function = library.function(f"all_{name}", None, pointer, pointer, pointer, ctypes.c_int64)

        def call(a, b=1.0):
            a, b = np.broadcast_arrays(np.asarray(a, float), np.asarray(b, float))
            padded = -(-a.size // WIDTH) * WIDTH
            rooms = aligned(3, padded)
            rooms[0, : a.size], rooms[1, : a.size] = a, b
            function(*(room.ctypes.data for room in rooms), padded)
            return rooms[2, : a.size].copy()

        call.library = library
        return call

    return {name: caller(name) for name in FUNCTIONS}


def errors_in_last_places(values, exact):
    """|value - exact| in units of the last place of the exact value."""
    worst = 0.0
    for value, right in zip(values.tolist(), exact, strict=True):
        worst = max(worst, float(abs(mpmath.mpf(value) - right) / math.ulp(float(right))))
    return worst


def sample(low, high, count=2000):
    """Magnitudes spread evenly over their logarithms, both signs."""
    rng = np.random.default_rng(7)
    size = np.exp(rng.uniform(math.log(low), math.log(high), count))
    return size * rng.choice([-1.0, 1.0], count)


@pytest.mark.parametrize("name", ["sin", "cos"])
def test_sine_and_cosine_are_good_to_three_quarters_of_an_ulp_up_to_1e9(compiled, name):
    multiples = np.pi / 2 * np.arange(-500.0, 500.0)  # close to zeros, where the reduction loses most
    angles = np.concatenate([sample(1e-8, 1e9, 4000), multiples, multiples * 1e5, [0.0, math.pi / 4, -math.pi / 4]])
    with mpmath.workdps(60):
        exact = [getattr(mpmath, name)(mpmath.mpf(a)) for a in angles.tolist()]
        assert errors_in_last_places(compiled[name](angles), exact) < 0.75
    assert np.isnan(compiled[name]([np.inf, -np.inf, np.nan])).all()


def test_exponential_is_good_to_an_ulp_over_the_whole_range(compiled):
    arguments = np.concatenate([sample(1e-10, 708.0, 4000), [0.0, 709.5, -708.0]])
    with mpmath.workdps(60):
        exact = [mpmath.exp(mpmath.mpf(a)) for a in arguments.tolist()]
        assert errors_in_last_places(compiled["exp"](arguments), exact) < 1.0
    np.testing.assert_array_equal(compiled["exp"]([1e3, np.inf, -1e3, -np.inf, np.nan]), [np.inf, np.inf, 0, 0, np.nan])


def test_logarithm_is_good_to_an_ulp_and_nan_where_there_is_none(compiled):
    near = 1.0 + sample(1e-15, 0.5)
    arguments = np.concatenate([np.abs(sample(1e-307, 1e307, 3000)), near, [1.0, 2.0, 0.5, math.sqrt(0.5)]])
    with mpmath.workdps(60):
        exact = [mpmath.log(mpmath.mpf(a)) for a in arguments.tolist()]
        assert errors_in_last_places(compiled["log"](arguments), exact) < 1.0
        small = sample(1e-300, 0.5)
        exact = [mpmath.log1p(mpmath.mpf(a)) for a in small.tolist()]
        assert errors_in_last_places(compiled["log1p"](small), exact) < 1.6
    assert np.isnan(compiled["log"]([0.0, -1.0, np.inf, np.nan])).all()


def test_real_powers_keep_the_digits_of_the_product(compiled):
    rng = np.random.default_rng(3)
    bases, exponents = np.exp(rng.uniform(-20.0, 20.0, 3000)), rng.uniform(-30.0, 30.0, 3000)
    with mpmath.workdps(60):
        exact = [mpmath.mpf(a) ** mpmath.mpf(b) for a, b in zip(bases.tolist(), exponents.tolist(), strict=True)]
        assert errors_in_last_places(compiled["power"](bases, exponents), exact) < 1.5


def test_rough_logarithms_serve_for_step_sizes(compiled):
    arguments = np.abs(sample(1e-300, 1e300))
    np.testing.assert_allclose(compiled["rough_log2"](arguments), np.log2(arguments), atol=2e-3)
    powers = np.linspace(-900.0, 900.0, 999)
    np.testing.assert_allclose(compiled["rough_exp2"](powers), np.exp2(powers), rtol=2e-3)
    assert -2000.0 < compiled["rough_log2"]([0.0])[0] < -1000.0
