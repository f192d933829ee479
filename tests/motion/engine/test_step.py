"""How long a step is, by the rule of Jorba and Zou from known series; and which steps may cross a border."""

import math
from dataclasses import dataclass, field

import numpy as np
import pytest
from engine_systems import Decay

from gelcone.motion.engine.events import Event
from gelcone.motion.engine.plan import ARRIVED, NOT_FINITE, TERMINAL_EVENT, TOO_MANY_STEPS
from gelcone.motion.engine.program import Program
from gelcone.motion.engine.step import LONGEST_STEP_BITS, SMALLEST_NORM

TOLERANCE = 1e-6
ROUGH = 1e-3
"""Step sizes are computed with logarithms of four digits."""


def rule(program, size, coefficient):
    """min over k = p - 1, p of (tolerance size/|x_k|)^(1/k), with the coefficient x_k."""
    orders = (program.order - 1, program.order)
    return min((program.label * size / coefficient(k)) ** (1.0 / k) for k in orders)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-9, 1e-15])
@pytest.mark.parametrize("rate", [0.3, 5.0])
def test_a_step_is_as_long_as_the_last_two_coefficients_allow(tolerance, rate):
    """x_k = x_0 r^k/k!."""
    program = Program(Decay(), "states", tolerance)
    wanted = rule(program, 1.0, lambda k: rate**k / math.factorial(k))
    raw = program.run({"rate": rate}, [[7.0]], 0.0, [[3.5 * wanted]])
    assert raw.smallest_step[0] == pytest.approx(wanted, rel=ROUGH)
    assert raw.steps[0] == 4
    assert raw.states[0, 0, 0] == pytest.approx(7.0 * math.exp(-3.5 * rate * wanted), rel=10.0 * tolerance, abs=1e-14)


def test_errors_of_small_states_are_relative_to_a_least_size():
    program, start = Program(Decay(), "states", TOLERANCE), 1e-4 * SMALLEST_NORM
    wanted = rule(program, SMALLEST_NORM, lambda k: start / math.factorial(k))
    raw = program.run({"rate": 1.0}, [[start]], 0.0, [[0.9 * wanted]])
    assert raw.smallest_step[0] == pytest.approx(wanted, rel=ROUGH)
    assert raw.steps[0] == 1


@dataclass(frozen=True)
class Turning:
    """x'' = -w^2 x and y' = 0: y, where it is large, is the size that errors are relative to."""

    states = ("x", "u", "y")
    numbers = ("w",)

    def rates(self, time, state, n, xp):
        x, u, _ = state
        return [n["w"] * u, -n["w"] * x, 0.0 * x]


def test_of_several_states_the_largest_and_its_largest_coefficient_count():
    program = Program(Turning(), "states", TOLERANCE)
    for large in (0.0, 50.0):
        # |x_k| + |u_k| of cos and sin: the larger of both
        wanted = rule(program, max(1.0, large), lambda k: 2.0**k / math.factorial(k))
        raw = program.run({"w": 2.0}, [[1.0, 0.0, large]], 0.0, [[0.9 * wanted]])
        assert raw.smallest_step[0] == pytest.approx(wanted, rel=ROUGH)


@dataclass(frozen=True)
class Still:
    """x' = v: straight lines, on which nothing bounds a step but borders."""

    states = ("x",)
    numbers = ("v", "c", "d", "e", "w", "s")

    def rates(self, time, state, n, xp):
        return [n["v"] + 0.0 * state[0]]


NUMBERS = {"v": 0.0, "c": 0.0, "d": 0.0, "e": 0.0, "w": 0.0, "s": 1.0}


def test_where_nothing_bounds_a_step_it_is_2_to_the_40():
    raw = Program(Still(), "states", TOLERANCE).run(NUMBERS, [[3.0]], 0.0, [[1e9]])
    assert raw.steps[0] == 1
    assert raw.smallest_step[0] == pytest.approx(2.0**LONGEST_STEP_BITS, rel=ROUGH)


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("size", [0.2, 4.0])
def test_borders_bound_a_step_relative_to_1_and_smooth_ones_by_the_root_of_the_tolerance(smooth, size):
    """g = 3 + sin(w t): g_k = w^k/k! at most; both of the last two are not zero between 0 and pi/2."""
    event = Event(lambda t, z, n, xp: 3.0 + xp.sin(n["w"] * t), -1, inside=True, smooth=smooth)
    program, w, at = Program(Still(), "states", TOLERANCE, [event]), 2.0, 0.3
    tolerance = math.sqrt(program.label) if smooth else program.label
    trig = (abs(math.cos(w * at)), abs(math.sin(w * at)))
    wanted = min(
        (tolerance / (w**k / math.factorial(k) * trig[(k + 1) % 2])) ** (1.0 / k)
        for k in (program.order - 1, program.order)
    )
    raw = program.run(NUMBERS | {"w": w}, [[size]], at, [[at + 0.5 * wanted]])
    assert raw.smallest_step[0] == pytest.approx(wanted, rel=ROUGH)


@dataclass(frozen=True)
class Charged:
    """A state at x, and the integral of a power sin(w t) (or of two, of which the first bounds the steps)."""

    bounding_powers: int = 0
    states = ("x",)
    numbers = ("w",)

    def rates(self, time, state, n, xp):
        return [0.0 * state[0]]

    def powers(self, time, state, n, xp):
        return (xp.sin(n["w"] * time),)


@pytest.mark.parametrize("bounding", [0, 1])
def test_integrals_bound_a_step_only_at_rest(bounding):
    """Relative to 1; those that bear on the steps do so as states, at any size."""
    program, at, w = Program(Charged(bounding), "work", TOLERANCE), 0.3, 2.0
    trig = (abs(math.sin(w * at)), abs(math.cos(w * at)))

    def power(k):  # of the integral: sin^(k - 1)/k!
        return w ** (k - 1) / math.factorial(k) * trig[(k - 1) % 2]

    own = rule(program, 1.0, power)
    resting = program.run({"w": w}, [[0.0]], at, [[at + 0.1]]).smallest_step[0]
    moving = program.run({"w": w}, [[5.0]], at, [[at + 0.1]]).smallest_step[0]
    if bounding:
        assert resting == pytest.approx(rule(program, SMALLEST_NORM, power), rel=ROUGH)
        assert moving == pytest.approx(rule(program, 5.0, power), rel=ROUGH)
    else:
        assert resting == pytest.approx(own, rel=ROUGH)
        assert moving == pytest.approx(2.0**LONGEST_STEP_BITS, rel=ROUGH)


@dataclass(frozen=True)
class OfARoot:
    """x' = 0 and y with y = 2 + sin(w t), which nothing but a border far away takes."""

    states = ("x",)
    numbers = ("w",)

    def rates(self, time, state, n, xp):
        return [0.0 * state[0]]

    def border(self, time, state, n, xp):
        y = xp.root("y", lambda y, t, xp: y - 2.0 - xp.sin(n["w"] * t), [time], lambda t, xp: 2.0 + 0.0 * t)
        return 9.0 + 1e-12 * y


@pytest.mark.parametrize("size", [0.2, 4.0])
def test_roots_bound_a_step_relative_to_themselves(size):
    system, at, w = OfARoot(), 0.3, 2.0
    program = Program(system, "states", TOLERANCE, [Event(system.border, -1, inside=True)])
    trig = (abs(math.sin(w * at)), abs(math.cos(w * at)))
    root = 2.0 + math.sin(w * at)
    wanted = rule(program, root, lambda k: w**k / math.factorial(k) * trig[k % 2])
    raw = program.run({"w": w}, [[size]], at, [[at + 0.5 * wanted]])
    assert raw.smallest_step[0] == pytest.approx(wanted, rel=ROUGH)


def test_the_time_of_many_steps_keeps_its_last_digits():
    """Ten thousand steps of lengths that no digits are spared of; then an event at a time of a border."""
    event = Event(lambda t, z, n, xp: n["c"] - t, -1)

    @dataclass(frozen=True)
    class Quick:
        states = ("x",)
        numbers = ("c",)

        def rates(self, time, state, n, xp):
            return [50.0 * xp.cos(50.0 * time)]

    raw = Program(Quick(), "states", 1e-15, [event]).run({"c": 400.1}, [[1.0]], 0.1, [[500.0]])
    assert raw.status[0] == TERMINAL_EVENT
    assert raw.steps[0] > 5000
    assert abs(raw.end_time[0] - 400.1) <= 2.0 * np.spacing(400.1)
    assert raw.end_state[0, 0] == pytest.approx(1.0 + math.sin(50.0 * 400.1) - math.sin(5.0), abs=1e-10)


# --- which steps may cross a border: all of a run is one step ---------------------------------------------------------


def crossed(coefficients, direction=-1, start=0.0, **event):
    """End times of members whose border is c_0 + c_1 t + ..., (members, terms), in one step from 0 to 1; infinite where
    it is not crossed."""
    terms = np.asarray(coefficients, dtype=float)
    names = tuple(f"c{k}" for k in range(terms.shape[1]))

    @dataclass(frozen=True)
    class Held:
        states: tuple[str, ...] = ("x",)
        numbers: tuple[str, ...] = field(default=names)

        def rates(self, time, state, n, xp):
            return [0.0 * state[0]]

    def border(time, state, n, xp):
        value = n[names[-1]]
        for name in names[-2::-1]:
            value = n[name] + time * value
        return value

    program = Program(Held(), "states", 1e-15, [Event(border, direction, **event)])
    members = len(terms)
    numbers = dict(zip(names, terms.T, strict=True))
    raw = program.run(numbers, np.ones((members, 1)), start, np.ones((members, 1)))
    assert set(np.unique(raw.status)) <= {ARRIVED, TERMINAL_EVENT}
    assert (raw.steps <= 2).all()  # one more where it is crossed in the direction that does not count
    return np.where(raw.status == TERMINAL_EVENT, raw.end_time, np.inf)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_valley_that_reaches_below_zero_within_a_step_is_seen_and_one_that_does_not_is_not(sign):
    """(t - m)^2 - e, of both signs: falling from the positive side, or rising from the negative one."""
    m, e = (part.ravel() for part in np.meshgrid(np.linspace(0.13, 1.33, 13), [0.01, 1e-3, 1e-9, -1e-9, -0.2]))
    terms = sign * np.stack([m * m - e, -2.0 * m, np.ones(m.size)], axis=1)
    lower = m - np.sqrt(np.maximum(e, 0.0))
    right = np.where((e > 0.0) & (lower < 1.0), lower, np.inf)
    np.testing.assert_allclose(crossed(terms, -1 if sign > 0.0 else 1), right, rtol=1e-6, atol=1e-9)
    away = crossed(terms, 1 if sign > 0.0 else -1)
    upper = m + np.sqrt(np.maximum(e, 0.0))
    np.testing.assert_allclose(away, np.where((e > 0.0) & (upper < 1.0), upper, np.inf), rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(crossed(terms, 0), right, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("inside", [False, True])
def test_the_first_of_the_zeros_of_random_polynomials_ends_the_step(inside):
    """Degree 7, positive at 0; NumPy finds the zeros."""
    rng = np.random.default_rng(4)
    terms = rng.normal(size=(400, 8)) * 2.0 ** -np.arange(8)
    terms[:, 0] = rng.uniform(0.05, 0.6, 400)
    right = []
    for row in terms:
        zeros = np.roots(row[::-1])
        real = zeros[(abs(zeros.imag) < 1e-9) & (zeros.real > 0.0) & (zeros.real < 1.0)].real
        right.append(real.min() if real.size else np.inf)
    assert 50 < np.isfinite(right).sum() < 350
    np.testing.assert_allclose(crossed(terms, inside=inside), right, rtol=1e-8)


@pytest.mark.parametrize("place", [1, 2, 3])
def test_a_short_dip_of_a_border_anywhere_in_a_step_is_found(place):
    """Quartics whose only negative Bernstein coefficient is one; NumPy finds the zeros."""
    terms, right = [], []
    for depth in (0.5, 0.9, 1.0, 1.1, 2.0):
        heights = [0.01 if k == 2 else 1.0 for k in range(5)]
        heights[place] = -depth
        terms.append(
            [
                math.comb(4, i) * sum((-1.0) ** (i - k) * math.comb(i, k) * heights[k] for k in range(i + 1))
                for i in range(5)
            ]
        )
        zeros = np.roots(terms[-1][::-1])
        real = zeros[(abs(zeros.imag) < 1e-9) & (zeros.real > 0.0) & (zeros.real < 1.0)].real
        right.append(real.min() if real.size else np.inf)
    assert np.isfinite(right).any()
    np.testing.assert_allclose(crossed(terms, inside=True), right, rtol=1e-8)


def test_a_member_on_the_wrong_side_of_a_border_crosses_it_at_once_and_else_where_it_comes_back():
    terms = np.array([[-0.5, 1.0, 0.0], [-0.25, 2.0, -2.0]])
    np.testing.assert_array_equal(crossed(terms, inside=True), [0.0, 0.0])
    np.testing.assert_allclose(crossed(terms), [np.inf, 0.5 + np.sqrt(0.125)], rtol=1e-12)


def test_a_step_that_leaves_all_numbers_ends_where_it_began():
    program = Program(Decay(), "states", 1e-10)
    raw = program.run({"rate": -1.0}, [[1e300]], 0.0, [[100.0]])
    assert raw.status[0] == NOT_FINITE
    assert np.isfinite(raw.end_state[0, 0])
    assert raw.end_state[0, 0] == pytest.approx(1e300 * math.exp(raw.end_time[0]), rel=1e-6)


def test_a_member_makes_no_more_steps_than_it_may():
    program = Program(Decay(), "states", TOLERANCE)
    for most in (1, 3):
        raw = program.run({"rate": 5.0}, [[1.0]], 0.0, [[50.0]], most_steps=most)
        assert (raw.status[0], raw.steps[0]) == (TOO_MANY_STEPS, most)


def test_a_border_within_a_step_is_found_also_where_tangents_begin_anew_at_samples():
    event = Event(lambda t, z, n, xp: z[0] - 0.5, -1)
    raw = Program(Decay(), "tangents", 1e-12, [event]).run({"rate": 2.0}, [[1.0]], 0.0, [[0.1, 3.0]])
    assert raw.status[0] == TERMINAL_EVENT
    assert raw.end_time[0] == pytest.approx(0.5 * math.log(2.0), rel=1e-12)
    assert raw.end_state[0, 0] == pytest.approx(0.5, rel=1e-12)
    assert raw.tangents[0, 0, 0, 0] == pytest.approx(math.exp(-0.2), rel=1e-11)


@pytest.mark.parametrize("direction", [-1, 1])
def test_a_polynomial_of_low_order_hides_no_crossing_on_either_side_of_a_border(direction):
    """x^8 = e^(-8 t) falls through levels: over a step of a half its series needs far more than four terms."""
    levels = np.linspace(0.02, 0.95, 40)
    event = Event(lambda t, z, n, xp: -direction * (z[0] ** 8 - n["c"]), direction, inside=True, seldom=True)

    @dataclass(frozen=True)
    class Falling:
        states = ("x",)
        numbers = ("c",)

        def rates(self, time, state, n, xp):
            return [-state[0]]

    raw = Program(Falling(), "states", TOLERANCE, [event]).run({"c": levels}, np.ones((40, 1)), 0.0, np.ones((40, 1)))
    assert (raw.status == TERMINAL_EVENT).all()
    np.testing.assert_allclose(raw.end_time, -np.log(levels) / 8.0, rtol=0.0, atol=1e-5)
