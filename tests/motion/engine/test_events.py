"""Borders: found to the last digits, never jumped, never found twice, also where they are touched or meet."""

import ctypes
import math
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
import pytest
from bracketing import reference
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from gelcone.motion.engine import compile as compiler
from gelcone.motion.engine.events import Event, crossing_function
from gelcone.motion.engine.plan import ARRIVED, TERMINAL_EVENT
from gelcone.motion.engine.program import Program

# --- the search on a polynomial --------------------------------------------------------------------------------------

DEGREE = 8


@pytest.fixture(scope="module")
def crossing():
    f = crossing_function(DEGREE, 1)
    text = "\n".join([*sorted(f.intrinsics), f.text().replace("internal", "").replace("noinline", "")])
    library = compiler.Library(compiler.object_code(text, compiler.host()), compiler.host())
    function = library.function("crossing", ctypes.c_double, ctypes.c_void_p, ctypes.c_double, ctypes.c_double)

    def call(coefficients, step=1.0, sign=1.0):
        padded = np.zeros(DEGREE + 1)
        padded[: len(coefficients)] = [float(c) for c in coefficients]
        return function(padded.ctypes.data, sign, step)

    call.library = library
    return call


def expanded(roots, factor=1):
    """Exact coefficients of factor * prod (root - t)."""
    polynomial = [Fraction(factor)]
    for root in roots:
        shifted = [Fraction(0), *polynomial]
        polynomial = [Fraction(root) * c for c in [*polynomial, Fraction(0)]]
        polynomial = [p - s for p, s in zip(polynomial, shifted, strict=True)]
    return polynomial


separate = st.lists(st.integers(1, 400), min_size=1, max_size=5, unique=True).map(sorted)


@settings(max_examples=200, deadline=None)
@given(places=separate, middle=st.integers(-300, 700), away=st.integers(1, 300))
def test_the_first_falling_zero_is_found(crossing, places, middle, away):
    """Multiples of 1/320 and a complex pair as roots: positive before the first, which is the one that counts.

    It is as exact as rounding of the coefficients lets it be. One at the very end of the step may be left to the next.
    """
    roots = [Fraction(place, 320) for place in places]
    real, imaginary = Fraction(middle, 320), Fraction(away, 320)
    quadratic = [real**2 + imaginary**2, -2 * real, Fraction(1)]
    line = expanded(roots)
    product = [Fraction(0)] * (len(line) + 2)
    for i, a in enumerate(line):
        for j, b in enumerate(quadratic):
            product[i + j] += a * b
    first = roots[0]
    slope = abs(sum(k * c * first ** (k - 1) for k, c in enumerate(product) if k))
    size = sum(abs(c) * first**k for k, c in enumerate(product))
    bound = 1e-14 * float(size / slope) + 1e-15
    assume(bound < 1e-4 / 320)
    found = crossing(product)
    if first != 1 or found <= 1.0:
        assert abs(found - float(first)) < bound if first <= 1 else math.isinf(found)
    assert math.isinf(crossing(product, step=float(first) - bound))


@settings(max_examples=50, deadline=None)
@given(places=separate, lift=st.sampled_from([1e-6, 1e-9, 1e-12]))
def test_a_border_that_is_almost_touched_is_passed_by_and_one_just_crossed_is_not(crossing, places, lift):
    """Double roots lifted a little above or below zero."""
    place = Fraction(places[0], 401)
    square = expanded([place, place])
    above = crossing([square[0] + Fraction(lift), *square[1:]])
    below = crossing([square[0] - Fraction(lift), *square[1:]])
    assert math.isinf(above)
    width = math.sqrt(lift)
    assert below == pytest.approx(float(place) - width, abs=1e-3 * width) if float(place) > width else True


def test_a_zero_at_the_start_counts_by_where_it_leads(crossing):
    assert math.isinf(crossing([0.0, 1.0]))  # leaves the border
    assert crossing([0.0, 1.0, -2.0]) == pytest.approx(0.5, rel=1e-15)  # and comes back
    assert crossing([-1e-17, 1.0, -2.0]) == pytest.approx(0.5, rel=1e-15)
    assert crossing([0.0, -1.0]) == 0.0
    assert crossing([-1e-17, -1.0]) == 0.0
    assert crossing([0.0, 0.0, -1.0]) == 0.0
    assert math.isinf(crossing([0.0, 0.0, 1.0]))
    assert math.isinf(crossing([0.0]))
    assert math.isinf(crossing([math.nan, 1.0]))
    assert crossing([0.0, 0.0, 1.0, -4.0]) == pytest.approx(0.25, rel=1e-15)
    assert crossing([-1.0, 4.0, -2.0], sign=-1.0) == pytest.approx(1.0 - math.sqrt(0.5), rel=1e-15)


# --- terminal events -------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Harmonic:
    """x = cos t from (1, 0)."""

    states = ("x", "u")
    numbers = ("level", "gain")

    def rates(self, time, state, n, xp):
        x, u = state
        return [u, -x]

    def flow(self, time, state, n, xp):
        return self.rates(time, state, n, xp), [[0.0, 1.0], [-1.0, 0.0]]


def level(time, state, n, xp):
    return state[0] - n["level"]


@pytest.mark.parametrize("keep", ["states", "tangents"])
@pytest.mark.parametrize(("tolerance", "bound"), [(1e-15, 5e-15), (1e-6, 1e-6)])
def test_a_terminal_event_ends_a_member_at_its_time(keep, tolerance, bound):
    levels = np.linspace(-0.99, 0.99, 50)
    times = np.tile([0.01, 1.0, 2.0, 3.5, 6.2], (50, 1))
    states0 = np.tile([1.0, 0.0], (50, 1))
    falls, rises = np.arccos(levels), 2.0 * np.pi - np.arccos(levels)
    for direction, exact in ((-1, falls), (1, rises), (0, falls)):
        program = Program(Harmonic(), keep, tolerance, [Event(level, direction)])
        raw = program.run({"level": levels, "gain": 0.0}, states0, 0.0, times)
        hit = exact < 6.2
        np.testing.assert_array_equal(raw.status, np.where(hit, TERMINAL_EVENT, ARRIVED))
        np.testing.assert_allclose(raw.end_time[hit], exact[hit], rtol=0.0, atol=10.0 * bound)
        np.testing.assert_allclose(raw.end_state[hit, 0], levels[hit], rtol=0.0, atol=bound)
        reached = times <= raw.end_time[:, None]
        np.testing.assert_array_equal(np.isfinite(raw.states[..., 0]), reached)
        np.testing.assert_allclose(raw.states[..., 0][reached], np.cos(times)[reached], rtol=0.0, atol=bound)


def test_a_member_goes_on_from_a_border_without_finding_it_again():
    """Ten returns to a section, each run started where the last one ended."""
    program = Program(Harmonic(), "states", 1e-15, [Event(level, -1)])
    levels = np.linspace(-0.9, 0.9, 37)
    numbers = {"level": levels, "gain": 0.0}
    state, time = np.tile([1.0, 0.0], (37, 1)), np.zeros(37)
    for turn in range(10):
        raw = program.run(numbers, state, time, time[:, None] + 20.0)
        assert (raw.status == TERMINAL_EVENT).all()
        state, time = raw.end_state, raw.end_time
        np.testing.assert_allclose(time, np.arccos(levels) + 2.0 * np.pi * turn, rtol=0.0, atol=1e-13)


def test_the_first_of_several_borders_counts_and_others_are_told_apart():
    events = [Event(level, -1), Event(lambda t, s, n, xp: s[1] + 0.5, -1), Event(lambda t, s, n, xp: 3.0 - t, -1)]
    raw = Program(Harmonic(), "states", 1e-15, events).run(
        {"level": [0.99, 0.0, -2.0, -2.0], "gain": 0.0},
        [[1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.1, 0.0]],
        0.0,
        np.full((4, 1), 10.0),
    )
    np.testing.assert_array_equal(raw.status, [4, 5, 5, 6])
    np.testing.assert_allclose(raw.end_time, [math.acos(0.99), math.pi / 6, math.pi / 6, 3.0], rtol=0.0, atol=1e-15)


@pytest.mark.parametrize(("tolerance", "bound"), [(1e-6, 1e-5), (1e-15, 3e-14)])
def test_a_border_that_is_seldom_near_is_found_as_exactly_as_another(tolerance, bound):
    """g = x^4 + x u - level falls through its zero, or misses it by a little or by far."""

    def quartic(time, state, n, xp):
        return state[0] ** 4 + state[0] * state[1] - n["level"]

    along = np.linspace(0.0, 1.5, 100_001)
    valley = (np.cos(along) ** 4 - np.cos(along) * np.sin(along)).min()
    levels = np.concatenate([np.linspace(-0.15, 0.9, 40), [valley - 1e-3, valley - 1e-6, -5.0]])
    states0, times = np.tile([1.0, 0.0], (43, 1)), np.full((43, 1), 1.5)
    raws = [
        Program(Harmonic(), "states", tolerance, [Event(quartic, -1, inside=True, seldom=seldom)]).run(
            {"level": levels, "gain": 0.0}, states0, 0.0, times
        )
        for seldom in (False, True)
    ]
    np.testing.assert_array_equal(raws[1].status, raws[0].status)
    np.testing.assert_allclose(raws[1].end_time, raws[0].end_time, rtol=0.0, atol=bound)
    assert raws[1].steps[-1] <= raws[0].steps[-1]
    assert (raws[1].steps < raws[0].steps + 40).all()


@pytest.mark.parametrize(("tolerance", "bound"), [(1e-6, 1e-7), (1e-15, 3e-14)])
def test_borders_that_are_seldom_near_have_their_own_sides(tolerance, bound):
    """The first border holds a member above it, the second below."""

    def far(time, state, n, xp):
        return 20.0 + state[0] * state[1]

    def quartic(time, state, n, xp):
        return n["level"] - state[0] ** 4 - state[0] * state[1]

    levels = np.linspace(-0.15, 0.9, 40)
    given = {"level": levels, "gain": 0.0}, np.tile([1.0, 0.0], (40, 1)), 0.0, np.full((40, 1), 1.5)
    events = [Event(far, -1, inside=True, seldom=True), Event(quartic, 1, inside=True, seldom=True)]
    exact = Program(Harmonic(), "states", 1e-15, [Event(quartic, 1)]).run(*given)
    raw = Program(Harmonic(), "states", tolerance, events).run(*given)
    np.testing.assert_array_equal(raw.status, TERMINAL_EVENT + 1)
    np.testing.assert_allclose(raw.end_time, exact.end_time, rtol=0.0, atol=bound)


def test_an_event_at_the_last_sample_comes_too_late():
    program = Program(Harmonic(), "states", 1e-15, [Event(lambda t, s, n, xp: 1.0 - t, -1)])
    raw = program.run({"level": 0.0, "gain": 0.0}, [[1.0, 0.0]], 0.0, [[0.5, 1.0]])
    assert raw.status[0] == ARRIVED


def test_a_border_without_its_switch_flips_only_where_it_counts():
    """x'' = -x, and w' = gain, where gain flips each time that x falls through 0."""

    @dataclass(frozen=True)
    class Counter:
        states = ("x", "u", "w")
        numbers = ("gain",)

        def rates(self, time, state, n, xp):
            return [state[1], -state[0], n["gain"]]

    program = Program(Counter(), "states", 1e-15, [Event(lambda t, s, n, xp: s[0], -1, "gain")])
    times = np.linspace(0.5, 700.0, 200)[None]
    raw = program.run({"gain": 1.0}, [[1.0, 0.0, 0.0]], 0.0, times)
    phase = np.mod(times[0] - 0.5 * np.pi, 4.0 * np.pi)
    saw = 0.5 * np.pi - np.minimum(phase, 4.0 * np.pi - phase)
    np.testing.assert_allclose(raw.states[0, :, 2], saw, rtol=0.0, atol=2e-12)


def test_events_that_cannot_be_used_are_refused():
    with pytest.raises(ValueError, match="direction = 2"):
        Event(level, 2)
    with pytest.raises(ValueError, match="direction = 0: a border with a side where members belong takes -1 or 1"):
        Event(level, 0, inside=True)
    with pytest.raises(ValueError, match="inside=True"):
        Event(level, -1, seldom=True)
    with pytest.raises(ValueError, match="switch = 'side'"):
        Program(Harmonic(), "states", 1e-6, [Event(level, -1, "side")])
    with pytest.raises(ValueError, match="direction = 0"):
        Program(Harmonic(), "states", 1e-6, [Event(lambda t, s, n, xp: n["gain"] * s[0], 0, "gain")])


# --- switches against a bracketing reference --------------------------------------------------------------------------


@dataclass(frozen=True)
class TwoStops:
    """A driven oscillator with a second spring beyond d1 and a third one beyond d2."""

    states = ("x", "u")
    numbers = ("z", "f", "w", "K1", "K2", "d1", "d2", "s1", "s2")

    def rates(self, time, state, n, xp):
        return self.flow(time, state, n, xp)[0]

    def flow(self, time, state, n, xp):
        x, u = state
        k1, k2 = n["K1"] * (0.5 - 0.5 * n["s1"]), n["K2"] * (0.5 - 0.5 * n["s2"])
        rate = k1 * (n["d1"] - x) + k2 * (n["d2"] - x) - x - 2.0 * n["z"] * u + n["f"] * xp.sin(n["w"] * time)
        return [u, rate], [[0.0, 1.0], [-1.0 - k1 - k2, -2.0 * n["z"]]]


STOPS = [
    Event(lambda t, s, n, xp: n["s1"] * (n["d1"] - s[0]), -1, "s1"),
    Event(lambda t, s, n, xp: n["s2"] * (s[0] - n["d2"]), 1, "s2"),
]


def stops(kind, members):
    """Random members; d2 lies apart from d1, on it, or beside it by as little as rounding."""
    rng = np.random.default_rng(17)
    apart = {
        "apart": rng.uniform(0.05, 0.3, members),
        "together": np.zeros(members),
        "beside": 10.0 ** rng.uniform(-17.0, -6.0, members) * rng.choice([-1.0, 1.0], members),
    }[kind]
    d1 = rng.uniform(0.1, 0.4, members)
    return {
        "z": 0.1,
        "f": rng.uniform(0.3, 0.8, members),
        "w": rng.uniform(0.4, 1.2, members),
        "K1": rng.uniform(1.0, 4.0, members),
        "K2": rng.uniform(0.5, 3.0, members),
        "d1": d1,
        "d2": d1 + apart,
    }


def errors_by_brackets(numbers, times, tolerances):
    """Largest error of each member's states, for each tolerance, and the number of switches of each member."""
    members = numbers["f"].size
    exact, switches = reference(
        numbers["z"],
        numbers["f"],
        numbers["w"],
        np.array([numbers["K1"], numbers["K2"]]),
        np.array([numbers["d1"], numbers["d2"]]),
        times,
    )
    errors = []
    for tolerance in tolerances:
        program = Program(TwoStops(), "states", tolerance, STOPS)
        # s2 (x - d2) rises where the border is passed, so that both switches start at 1
        start = np.zeros((members, 2))
        raw = program.run(numbers | {"s1": 1.0, "s2": 1.0}, start, 0.0, np.tile(times, (members, 1)))
        assert (raw.status == ARRIVED).all()
        errors.append(np.abs(raw.states - exact).max(axis=(1, 2)))
    return errors, switches


@pytest.mark.parametrize("kind", ["apart", "together", "beside"])
def test_switches_agree_with_bracketing(kind):
    (tight, loose), switches = errors_by_brackets(stops(kind, 50), np.linspace(5.0, 30.0, 6), (1e-15, 1e-6))
    assert switches.mean() > 12
    assert tight.max() < 1e-11
    assert loose.max() < 1e-6


def test_laws_apart_are_the_laws_of_the_switches():
    """Code made for each sign of the switches apart gives the same motion, and the same bits in any company."""
    members = 200
    numbers, times = stops("apart", members), np.tile(np.linspace(1.0, 20.0, 20), (members, 1))
    start, apart = {"s1": 1.0, "s2": 1.0}, [replace(event, divides=True) for event in STOPS]
    together = Program(TwoStops(), "states", 1e-10, STOPS).run(numbers | start, np.zeros((members, 2)), 0.0, times)
    program = Program(TwoStops(), "states", 1e-10, apart)
    assert len(program._plan(8).laws) == 4
    raw = program.run(numbers | start, np.zeros((members, 2)), 0.0, times, threads=2)
    np.testing.assert_allclose(raw.states, together.states, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(raw.dwell, together.dwell, rtol=0.0, atol=1e-9)
    for some in (slice(3, 4), slice(60, 7, -9)):
        own = {name: np.broadcast_to(value, (members,))[some] for name, value in numbers.items()}
        again = program.run(own | start, np.zeros_like(raw.states[some, 0]), 0.0, times[some])
        np.testing.assert_array_equal(again.states, raw.states[some])
        np.testing.assert_array_equal(again.dwell, raw.dwell[some])


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["apart", "together", "beside"])
def test_ten_thousand_members_agree_with_bracketing_after_100_switches(kind):
    errors, switches = errors_by_brackets(stops(kind, 10_000), np.linspace(20.0, 240.0, 12), (1e-15, 1e-10, 1e-6))
    assert np.median(switches) > 100
    for error, bound in zip(errors, (1e-11, 1e-9, 1e-5), strict=True):
        assert error.max() < bound


def grazing_borders(shares):
    """Borders at the first peak of the free motion, times ``shares``."""
    numbers = {"z": 0.1, "f": 0.5, "w": 0.9, "K1": 0.0, "K2": 0.0, "d1": 9.0, "d2": 9.0, "s1": 1.0, "s2": 1.0}
    times = np.linspace(0.0, 30.0, 30001)[None]
    x = Program(TwoStops(), "states", 1e-15).run(numbers, [[0.0, 0.0]], 0.0, times).states[0, :, 0]
    peak = x.max()
    return peak * shares


def test_touching_borders_agree_with_bracketing():
    """Borders just above, at and just below the highest point of the motion."""
    small = 10.0 ** np.linspace(-16.0, -1.0, 61)
    shares = np.concatenate([1.0 - small, 1.0 + small, [1.0]])
    d1 = grazing_borders(shares)
    members = d1.size
    numbers = {"z": 0.1, "f": np.full(members, 0.5), "w": np.full(members, 0.9)}
    numbers |= {"K1": np.full(members, 4.0), "K2": np.full(members, 1.0), "d1": d1, "d2": d1 + 1e-9}
    (tight, loose), _ = errors_by_brackets(numbers, np.linspace(5.0, 30.0, 6), (1e-15, 1e-6))
    assert tight.max() < 1e-11
    assert loose.max() < 1e-5


def test_a_run_goes_on_from_the_state_and_the_switches_of_another():
    numbers = stops("apart", 20) | {"s1": 1.0, "s2": 1.0}
    program = Program(TwoStops(), "states", 1e-15, STOPS)
    half = program.run(numbers, np.zeros((20, 2)), 0.0, np.full((20, 1), 10.3))
    assert {-1.0, 1.0} == set(half.switches["s1"])
    rest = program.run(numbers | half.switches, half.end_state, half.end_time, np.full((20, 1), 30.0))
    whole = program.run(numbers, np.zeros((20, 2)), 0.0, np.full((20, 1), 30.0))
    np.testing.assert_allclose(rest.states, whole.states, rtol=0.0, atol=1e-13)
    np.testing.assert_array_equal(rest.switches["s2"], whole.switches["s2"])


def test_tangents_pass_switches_of_a_continuous_force():
    numbers = {"z": 0.1, "f": 0.6, "w": 0.8, "K1": 2.0, "K2": 1.0, "d1": 0.2, "d2": 0.3, "s1": 1.0, "s2": 1.0}
    start = np.array([0.05, 0.1])
    raw = Program(TwoStops(), "tangents", 1e-15, STOPS).run(numbers, start[None], 0.0, [[10.0, 25.0]])
    small = 1e-6
    moved = np.concatenate([start + small * np.eye(2), start - small * np.eye(2)])
    ends = Program(TwoStops(), "states", 1e-15, STOPS).run(numbers, moved, 0.0, [[25.0]] * 4).states[:, 0]
    np.testing.assert_allclose(
        raw.tangents[0, 1] @ raw.tangents[0, 0], (ends[:2] - ends[2:]).T / (2.0 * small), rtol=0.0, atol=1e-6
    )


def test_events_keep_their_bits():
    numbers = stops("beside", 60) | {"s1": 1.0, "s2": 1.0}
    times = np.tile(np.linspace(5.0, 40.0, 8), (60, 1))
    results = []
    host = compiler.host()
    machines = [None, compiler.Machine(host.triple, "haswell", "")] if host.triple.startswith("x86_64") else [None]
    for machine in machines:
        for width in (4, 8, 16):
            program = Program(TwoStops(), "states", 1e-6, STOPS, width=width, machine=machine)
            results.append(program.run(numbers, np.zeros((60, 2)), 0.0, times, threads=2).states)
    order = np.arange(60)[::-1]
    turned = {k: v[order] if np.ndim(v) else v for k, v in numbers.items()}
    results.append(program.run(turned, np.zeros((60, 2)), 0.0, times).states[order])
    for result in results[1:]:
        np.testing.assert_array_equal(result, results[0])
