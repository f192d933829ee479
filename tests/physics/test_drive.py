"""Waveforms: the voltage, its rate, the smallest period of its square, and its peak."""

import itertools
from dataclasses import dataclass

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from gelcone.physics.drive import PHASE_SPEED, PHASES, PIECE, VOLTAGE, Pieced, Pieces, Waveform
from gelcone.physics.waveforms import WAVEFORMS, Sine, Triangle
from gelcone.quantity import Quantity

SINE = Sine()
frequencies = st.floats(1e-3, 1e3)
amplitudes = st.floats(0.01, 10.0)
biases = st.one_of(st.just(0.0), st.floats(0.01, 10.0), st.floats(-10.0, -0.01))


def numbers(amplitude=1.0, bias=0.0, frequency=1.0, **own):
    return {"voltage": amplitude, "voltage_bias": bias, "drive_frequency": frequency, **own}


class ThreeHarmonics(Waveform):
    """sin + b2 sin(2 phase) + b3 cos(3 phase): with b2 = 0 antiperiodic, which its class does not claim."""

    name = "three harmonics"
    parameters = VOLTAGE | {"second": Quantity("b2", "second harmonic", 0.5), "third": Quantity("b3", "third", 0.2)}

    def shape(self, phase, n, xp=np):
        return xp.sin(phase) + n["second"] * xp.sin(2.0 * phase) + n["third"] * xp.cos(3.0 * phase)

    def shape_rate(self, phase, n, xp=np):
        return xp.cos(phase) + 2.0 * n["second"] * xp.cos(2.0 * phase) - 3.0 * n["third"] * xp.sin(3.0 * phase)


class OddHarmonics(Waveform):
    """sin + b3 cos(3 phase), which changes its sign half a period on."""

    name = "odd harmonics"
    antiperiodic = True
    parameters = VOLTAGE | {"third": Quantity("b3", "third harmonic", 0.2)}

    def shape(self, phase, n, xp=np):
        return xp.sin(phase) + n["third"] * xp.cos(3.0 * phase)

    def shape_rate(self, phase, n, xp=np):
        return xp.cos(phase) - 3.0 * n["third"] * xp.sin(3.0 * phase)


CASES = [
    (SINE, {}),
    (Triangle(), {}),
    (ThreeHarmonics(), {"second": 0.5, "third": 0.2}),
    (OddHarmonics(), {"third": 0.3}),
]
smooth_waveform = pytest.mark.parametrize(
    ("waveform", "own"), [case for case in CASES if not case[0].pieced], ids=lambda value: getattr(value, "name", "")
)
every_waveform = pytest.mark.parametrize(("waveform", "own"), CASES, ids=[case[0].name for case in CASES])


# --- the voltage and its rate -----------------------------------------------------------------------------------------


def test_the_waveform_is_a_biased_sine():
    tau, a, b, w = sympy.symbols("tau a b omega", real=True)
    assert SINE.voltage(tau, numbers(a, b, w), sympy) == b + a * sympy.sin(w * tau)
    assert SINE.voltage(0.0, numbers(2.0, 0.3, 5.0)) == 0.3
    assert SINE.voltage(np.pi / 10.0, numbers(2.0, 0.3, 5.0)) == pytest.approx(2.3)


@smooth_waveform
def test_the_rate_is_the_derivative_of_the_voltage(waveform, own):
    tau, a, b, w = sympy.symbols("tau a b omega", real=True)
    n = numbers(a, b, w, **{name: sympy.Symbol(name) for name in own})
    difference = sympy.diff(waveform.voltage(tau, n, sympy), tau) - waveform.voltage_rate(tau, n, sympy)
    assert sympy.simplify(sympy.nsimplify(difference, rational=True)) == 0


@settings(deadline=None)
@given(st.floats(-100.0, 100.0), amplitudes, biases, st.floats(1e-3, 30.0))
def test_the_rate_is_the_derivative_in_numpy_too(tau, a, b, w):
    h = 1e-30
    n = numbers(a, b, w)
    complex_step = SINE.voltage(tau + 1j * h, n).imag / h
    assert SINE.voltage_rate(tau, n) == pytest.approx(complex_step, rel=1e-12, abs=1e-12 * a * w)


# --- periods ----------------------------------------------------------------------------------------------------------


@settings(deadline=None)
@given(amplitudes, biases, frequencies)
def test_the_forcing_period_is_a_period_of_the_squared_voltage_and_no_part_of_it_is(a, b, w):
    numbers_ = numbers(a, b, w)
    period = SINE.forcing_period(numbers_)
    n = 64
    tau = np.arange(n) / n * period
    force = SINE.voltage(tau, numbers_) ** 2
    scale = (a + abs(b)) ** 2
    np.testing.assert_allclose(SINE.voltage(tau + period, numbers_) ** 2, force, rtol=0.0, atol=1e-13 * scale)
    # A smaller period would be this one over a whole number, and then the fundamental would vanish.
    fundamental = 2.0 * abs(np.fft.rfft(force)[1]) / n
    expected = 2.0 * a * abs(b) if b != 0.0 else 0.5 * a * a
    assert fundamental == pytest.approx(expected, rel=1e-9, abs=1e-13 * scale)
    assert fundamental > 1e-7 * scale


@settings(deadline=None)
@given(frequencies)
def test_a_bias_doubles_the_forcing_period(w):
    for b, halves in ((0.0, 1.0), (1e-9, 2.0), (-1e-9, 2.0)):
        assert SINE.forcing_period(numbers(bias=b, frequency=w)) == pytest.approx(halves * np.pi / w, rel=1e-15)
    assert SINE.period(numbers(frequency=w)) == pytest.approx(2.0 * np.pi / w, rel=1e-15)


def test_only_an_antiperiodic_waveform_without_bias_forces_twice_a_period():
    """With even harmonics the squared voltage has the period of the voltage; the odd ones alone have half of it."""
    tau = np.linspace(0.0, 7.0, 50)
    for bias, halves in ((0.0, 1.0), (0.2, 2.0)):
        n = numbers(1.5, bias, 0.8, third=0.3)
        period = OddHarmonics().forcing_period(n)
        assert period == pytest.approx(halves * np.pi / 0.8, rel=1e-15)
        squares = (OddHarmonics().voltage(tau + shift, n) ** 2 for shift in (0.0, period))
        np.testing.assert_allclose(*squares, rtol=0.0, atol=1e-13)
    n = numbers(1.5, 0.0, 0.8, second=0.5, third=0.2)
    assert ThreeHarmonics().forcing_period(n) == pytest.approx(2.0 * np.pi / 0.8, rel=1e-15)
    half = ThreeHarmonics().voltage(tau + np.pi / 0.8, n) ** 2 - ThreeHarmonics().voltage(tau, n) ** 2
    assert np.abs(half).max() > 0.5


@smooth_waveform
def test_a_waveform_is_antiperiodic_exactly_where_it_says_so(waveform, own):
    phase = np.linspace(0.0, 2.0 * np.pi, 37)
    changes_sign = np.allclose(waveform.shape(phase + np.pi, own), -waveform.shape(phase, own), atol=1e-14)
    assert changes_sign == waveform.antiperiodic


# --- peak -------------------------------------------------------------------------------------------------------------


@every_waveform
@pytest.mark.parametrize("bias", [0.0, 0.7, -0.4])
def test_the_peak_is_that_of_the_voltage(waveform, own, bias):
    n = numbers(1.3, bias, 0.6, **own)
    period = float(waveform.period(n))
    peak = np.abs(waveform.voltage(np.linspace(0.0, period, 200_001), n)).max()
    assert waveform.peak(n) == pytest.approx(peak, rel=2e-4)


def test_the_sines_closed_form_is_that_of_its_samples():
    rng = np.random.default_rng(1)
    n = numbers(rng.uniform(0.0, 2.0, (3, 4)), rng.uniform(-1.0, 1.0, 4), 2.0)
    np.testing.assert_allclose(SINE.peak(n), Waveform.peak(SINE, n), rtol=1e-12)
    assert SINE.peak(n).shape == (3, 4)
    assert SINE.peak(numbers(2.0, -0.3)) == 2.3


def test_arrays_broadcast():
    n = numbers(1.0, np.array([0.0, 0.5, -0.5]), np.array([[1.0], [2.0]]))
    np.testing.assert_allclose(SINE.forcing_period(n) / np.pi, [[1.0, 2.0, 2.0], [0.5, 1.0, 1.0]], rtol=1e-15)
    n = numbers(np.ones((3, 1)), np.zeros((3, 1)), 2.0)
    assert SINE.voltage(np.linspace(0.0, 1.0, 4), n).shape == (3, 4)


def test_the_table_of_waveforms():
    for name, waveform in WAVEFORMS.items():
        assert waveform.name == name
        assert waveform.parameters.keys() >= VOLTAGE.keys()
    assert isinstance(WAVEFORMS["sine"], Sine)


# --- corners ----------------------------------------------------------------------------------------------------------


@given(start=st.floats(-50.0, 50.0), length=st.floats(0.0, 40.0), frequency=st.floats(0.05, 5.0))
@settings(max_examples=50, deadline=None)
def test_the_corners_between_two_times_are_all_there_is(start, length, frequency):
    waveform, n = Triangle(), Triangle().numbers(numbers(frequency=frequency))
    found = waveform.corners_between(np.array([start]), np.array([start + length]), n)
    inner = found.later[0][np.isfinite(found.later[0])]
    begin = found.passed[0, 0]
    every = np.array([begin, *inner])
    assert begin <= start < (begin + np.pi / frequency) * (1 + 1e-12) + 1e-12
    np.testing.assert_allclose(np.diff(every), np.pi / frequency, rtol=1e-9)
    assert (every[-1] + np.pi / frequency) * (1 + 1e-12) + 1e-12 > start + length
    # behind each corner the voltage goes the other way
    slopes = waveform.voltage_rate(every + 0.4 * np.pi / frequency, n)
    np.testing.assert_array_equal(np.sign(slopes), np.sign(found.passed[0, 2]) * (-1.0) ** np.arange(every.size))
    np.testing.assert_allclose(np.abs(waveform.voltage(every, n)), 1.0, rtol=0.0, atol=1e-12 * (1 + 100.0 * frequency))


def test_the_triangle_is_what_a_generator_gives():
    n = Triangle().numbers(numbers(0.7, 0.2, 2.0))
    tau = np.linspace(0.0, 20.0, 301)
    expected = 0.2 + 0.7 * (2.0 / np.pi) * np.arcsin(np.sin(2.0 * tau))
    np.testing.assert_allclose(Triangle().voltage(tau, n), expected, rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(Triangle().voltage_rate(tau, n), 0.7 * 2.0 * (2.0 / np.pi) * np.sign(np.cos(2.0 * tau)))


def test_a_waveform_with_corners_takes_them_as_a_program_does():
    waveform = Triangle()
    n = waveform.numbers(numbers(0.7, 0.2, 2.0))
    tau = np.linspace(0.0, 20.0, 301)
    passed = waveform.corners_between(tau, tau, {**n, "drive_frequency": np.full(301, 2.0)})
    told = {**n, **dict(zip(PIECE, passed.passed.T, strict=True)), "since": 2.0 * (tau - passed.passed[:, 0])}
    np.testing.assert_allclose(0.2 + 0.7 * waveform.shape(2.0 * tau, told), waveform.voltage(tau, n), atol=1e-13)


@pytest.mark.parametrize("waveform", [w for w in WAVEFORMS.values() if w.pieced], ids=lambda w: w.name)
def test_the_rate_of_a_piece_is_the_derivative_of_its_cubic(waveform):
    terms = dict(zip(PIECE, (0.0, 0.3, -0.7, 0.9, -1.1, 0.0), strict=True))
    n = {**waveform.numbers(waveform.complete({"drive_frequency": 0.7})), **terms}
    for since in (0.0, 0.4, 1.3):
        ahead, behind = (float(waveform.shape(0.0, n | {"since": since + h})) for h in (1e-6, -1e-6))
        rate = float(waveform.shape_rate(0.0, n | {"since": since}))
        assert rate == pytest.approx((ahead - behind) / 2e-6, abs=1e-8)
        assert rate == pytest.approx(-0.7 + 1.8 * since - 3.3 * since**2, rel=1e-12)


# --- pieces -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Drawn(Pieced):
    """Pieces from a table of begins (pieces,) and terms (..., pieces, 5)."""

    begins: np.ndarray
    terms: np.ndarray
    repeat: bool = True

    name = "drawn"

    def table(self, n):
        return Pieces(self.begins, self.terms)


def drawn(degree, repeat, closed=False, seed=5):
    """Five random pieces of a degree; those that are ``closed`` begin where the one before ends, but for the first."""
    rng = np.random.default_rng(seed)
    begins = np.sort(rng.uniform(0.3, 6.0, 5)) - (1.7 if repeat else 0.0)
    begins[0] = begins[0] if repeat else 0.0
    terms = np.zeros((5, 5))
    terms[:, : degree + 1] = rng.uniform(-1.0, 1.0, (5, degree + 1))
    lengths = np.append(begins[1:], begins[0] + 2.0 * np.pi) - begins
    ends = [np.polynomial.polynomial.polyval(length, row[:4]) for length, row in zip(lengths, terms, strict=True)]
    for k in range(1, 5) if closed else ():
        terms[k, 0] = ends[k - 1]
        ends[k] = np.polynomial.polynomial.polyval(lengths[k], terms[k, :4])
    return Drawn(begins, terms, repeat), lengths, ends[-1]


every_table = pytest.mark.parametrize(("degree", "repeat"), list(itertools.product(range(4), (True, False))))


@every_table
def test_pieces_are_looked_up_where_they_lie_and_from_their_corners_on(degree, repeat):
    """At a corner itself the piece that begins there counts. With one table for all, and with one for each member."""
    waveform, lengths, _ = drawn(degree, repeat)
    n = numbers(0.7, 0.2, 1.0)
    tau = np.concatenate([waveform.begins, waveform.begins + 0.3 * lengths, waveform.begins + 0.99 * lengths])
    piece, since = np.tile(np.arange(5), 3), np.concatenate([0.0 * lengths, 0.3 * lengths, 0.99 * lengths])
    rows = [np.polynomial.Polynomial(waveform.terms[k, :4]) for k in piece]
    volts = np.array([0.2 + 0.7 * row(s) for row, s in zip(rows, since, strict=True)])
    rates = np.array([0.7 * row.deriv()(s) for row, s in zip(rows, since, strict=True)])
    several = Drawn(waveform.begins, np.stack([waveform.terms, -waveform.terms]), repeat)
    turn = 2.0 * np.pi if repeat else 0.0
    for shift in (0.0, turn, -3.0 * turn):
        later = slice(None) if shift == 0.0 else slice(5, None)  # rounding may put a corner before or behind
        np.testing.assert_allclose(waveform.voltage(tau + shift, n)[later], volts[later], atol=1e-12)
        np.testing.assert_allclose(waveform.voltage_rate(tau + shift, n)[later], rates[later], atol=1e-12)
        both = several.voltage(np.tile(tau + shift, (2, 1)).T, numbers(0.7, np.array([0.2, -0.2]), 1.0))
        np.testing.assert_allclose(both.T[:, later], [volts[later], -volts[later]], atol=1e-12)
    if not repeat:
        beyond = waveform.voltage(waveform.begins[-1] + 9.0, n)
        assert beyond == pytest.approx(0.2 + 0.7 * np.polynomial.polynomial.polyval(9.0, waveform.terms[-1, :4]))


@every_table
def test_the_peak_of_pieces_is_that_of_their_polynomials(degree, repeat):
    for seed in range(6):
        waveform, lengths, _ = drawn(degree, repeat, seed=seed)
        polynomials = [np.polynomial.Polynomial(row[:4]) for row in waveform.terms]
        places = [np.linspace(0.0, length, 4001) for length in lengths]
        values = np.concatenate([one(s) for one, s in zip(polynomials, places, strict=True)])
        for bias in (0.2, -0.9):
            n = numbers(0.7, bias, 3.0)
            assert waveform.peak(n) == pytest.approx(np.abs(bias + 0.7 * values).max(), rel=1e-5)


@pytest.mark.parametrize("repeat", [True, False])
@pytest.mark.parametrize("degree", [1, 2, 3])
def test_a_voltage_jumps_where_its_pieces_do_not_meet(degree, repeat):
    """The end of a repeat counts where it is repeated."""
    waveform, _, end = drawn(degree, repeat, closed=True)
    n = numbers()
    assert waveform.jumps(n) == repeat
    closed, apart = waveform.terms.copy(), waveform.terms.copy()
    closed[-1, 1] += (closed[0, 0] - end) / (waveform.begins[0] + 2.0 * np.pi - waveform.begins[-1])
    assert not Drawn(waveform.begins, closed, repeat).jumps(n)
    apart[2, 0] += 1e-6
    assert Drawn(waveform.begins, apart, repeat).jumps(n)
    assert Drawn(waveform.begins, np.stack([closed, apart]), repeat).jumps(n)


@every_table
def test_what_programs_load_is_what_a_time_gives(degree, repeat):
    """The numbers of the piece, and the corners ahead, of members at several frequencies; there are no more of them
    than were announced."""
    waveform, _, _ = drawn(degree, repeat)
    start, omega = np.array([0.4, 2.3, 11.7]), np.array([0.5, 1.0, 1.9])
    n = numbers(0.7, 0.2, omega)
    end = start + np.array([0.1, 9.0, 17.0])
    found, places = waveform.corners_between(start, end, n), waveform.switches(start, n)
    np.testing.assert_allclose(found.passed.T, [places[name] for name in PIECE], atol=1e-12)
    count = np.isfinite(found.later).sum(axis=1)
    assert (count <= waveform.corner_count(start, end, n)).all()
    for i in range(3):
        corners = waveform.begins + 2.0 * np.pi * np.arange(-3 if repeat else 0, 9 if repeat else 1)[:, None]
        times = corners.ravel() / omega[i]
        np.testing.assert_allclose(found.later[i, : count[i]], times[(times > start[i]) & (times <= end[i])])
        after = waveform.switches(found.later[i, : count[i]] + 1e-9, numbers(0.7, 0.2, omega[i]))
        pieces = (found.first[i] + np.arange(count[i])) % 5
        np.testing.assert_allclose(after["piece_0"], found.terms[i, pieces, 0])


@pytest.mark.parametrize("repeat", [True, False])
def test_each_member_gets_the_corners_between_its_own_two_times(repeat):
    """By a list of all corners of a member; of those that do not repeat there are no more than the pieces."""
    waveform, _, _ = drawn(2, repeat)
    start, end = np.array([0.1, 2.9, -0.5 if repeat else 0.0, 1.2, 1.3]), np.array([1.4, 3.4, 2.6, 1.25, 2.6])
    omega = np.array([1.0, 2.0, 3.0, 0.5, 3.0])
    found = waveform.corners_between(start, end, {**numbers(0.7, 0.2), "drive_frequency": omega})
    for k in range(5):
        turns = 2.0 * np.pi * np.arange(-4, 5) if repeat else np.zeros(1)
        every = np.sort((turns[:, None] + waveform.begins).ravel()) / omega[k]
        within = every[(every > start[k]) & (every <= end[k])]
        later = found.later[k]
        np.testing.assert_allclose(later[: within.size], within, rtol=1e-12)
        assert np.isinf(later[within.size :]).all()
        before = np.flatnonzero(every <= start[k])
        passed = before[-1] if before.size else 0
        assert found.passed[k, 0] == pytest.approx(every[passed])
        np.testing.assert_array_equal(found.passed[k, 1:], waveform.terms[passed % 5])
        assert found.first[k] == (passed + 1) % 5


@pytest.mark.parametrize("name", ["sine", "triangle", "chirp", "harmonics"])
def test_over_the_phase_the_rate_of_the_voltage_is_that_by_time(name):
    waveform, times = WAVEFORMS[name], np.array([0.3, 1.1, 2.6])
    n = waveform.numbers(waveform.complete({"voltage": 0.7, "voltage_bias": 0.2, "drive_frequency": 0.8}))
    by_phase = {**n, "drive_frequency": 1.0, PHASE_SPEED: 0.8}
    np.testing.assert_allclose(waveform.voltage(0.8 * times, by_phase), waveform.voltage(times, n), rtol=1e-13)
    rates = [waveform.voltage(times + s * 1e-6, n) for s in (1.0, -1.0)]
    rates = (rates[0] - rates[1]) / 2e-6
    np.testing.assert_allclose(waveform.voltage_rate(times, n), rates, rtol=1e-8)
    np.testing.assert_allclose(waveform.voltage_rate(0.8 * times, by_phase), rates, rtol=1e-8)


def test_a_gate_that_opens_where_its_carrier_vanishes_does_not_make_the_voltage_jump():
    for name, jumps in (("burst", False), ("half_wave", False), ("triangle", False), ("square", False)):
        waveform = WAVEFORMS[name]
        n = waveform.numbers(waveform.complete({"voltage_bias": 0.0} if name == "half_wave" else {}))
        assert waveform.jumps(n) == jumps, name
    square = WAVEFORMS["square"]
    assert square.jumps(square.numbers(square.complete({"rise": 0.0})))
    chirp = WAVEFORMS["chirp"]
    assert not chirp.jumps(chirp.numbers(chirp.complete({"end_frequency": np.array([1.0, 2.2, 3.7])})))


def test_at_a_corner_the_piece_that_begins_there_has_been_passed():
    waveform = WAVEFORMS["triangle"]
    n = {name: np.ones(1) * value for name, value in waveform.numbers(waveform.complete({})).items()}
    corner = waveform.corners_between(np.zeros(1), np.full(1, 9.0), n).later[:, 0]
    found = waveform.corners_between(corner, np.full(1, 9.0), n)
    assert found.passed[0, 0] == corner[0]
    np.testing.assert_allclose(found.passed[0, 1:3], [1.0, -2.0 / np.pi], rtol=1e-14)  # it falls from its top
    assert found.later[0, 0] == pytest.approx(corner[0] + np.pi, rel=1e-14)


def test_a_corner_at_the_very_end_is_one_of_those_up_to_it():
    waveform = WAVEFORMS["triangle"]
    n = {name: np.ones(1) * value for name, value in waveform.numbers(waveform.complete({})).items()}
    later = waveform.corners_between(np.zeros(1), np.full(1, 9.0), n).later[0]
    again = waveform.corners_between(np.zeros(1), later[1:2], n).later[0]
    np.testing.assert_array_equal(again[np.isfinite(again)], later[:2])


def test_samples_of_members_stand_in_rows_and_the_detail_counts_pieces_by_four():
    n = {
        "voltage": np.array([0.5, 0.7, 0.2]),
        "voltage_bias": np.array([0.1, -0.3, 0.0]),
        "drive_frequency": np.ones(3),
    }
    for waveform in (SINE, WAVEFORMS["harmonics"]):
        rows = waveform.samples(n)
        assert rows.shape == (3, PHASES)
        for k in range(3):
            own = {name: value[k] for name, value in n.items()}
            np.testing.assert_allclose(rows[k], waveform.samples(own), rtol=1e-14)
            np.testing.assert_allclose(
                rows[k], waveform.voltage(2.0 * np.pi * np.arange(PHASES) / PHASES, own), atol=1e-14
            )
    assert WAVEFORMS["triangle"].detail({}) == 1.0
    assert WAVEFORMS["staircase"].detail({}) == 2.0


def test_a_corner_at_the_very_start_has_been_passed_and_is_none_of_those_to_come():
    waveform = WAVEFORMS["triangle"]
    n = {name: np.ones(1) * value for name, value in waveform.numbers(waveform.complete({})).items()}
    later = waveform.corners_between(np.zeros(1), np.full(1, 9.0), n).later[0]
    again = waveform.corners_between(later[:1], np.full(1, 9.0), n).later[0]
    np.testing.assert_array_equal(again[np.isfinite(again)], later[1:])


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_peak_within_a_piece_is_found_at_either_turn(sign):
    """s^3 - 7.5 s^2 + 12 s has its top 5.5 at 1 and its bottom -8 at 4; from 4.5 on it goes back to 0."""
    last = 4.5**3 - 7.5 * 4.5**2 + 12.0 * 4.5
    back = -last / (2.0 * np.pi - 4.5)
    terms = sign * np.array([[0.0, 12.0, -7.5, 1.0, 0.0], [last, back, 0.0, 0.0, 0.0]])
    waveform = Drawn(np.array([0.0, 4.5]), terms)
    for bias in (9.0, -9.0):
        extreme = {1.0: 5.5, -1.0: -8.0}[sign * np.sign(bias)]
        assert waveform.peak(numbers(1.0, bias)) == pytest.approx(abs(bias + sign * extreme), rel=1e-12)


@dataclass(frozen=True, eq=False)
class Gated(Drawn):
    """A cosine that is let pass in the middle of a repeat: it jumps where its gate opens and closes."""

    @property
    def gated(self):
        return True

    def carrier(self, phase, n, xp=np):
        return 2.0 * xp.cos(phase)

    def carrier_rate(self, phase, n, xp=np):
        return -2.0 * xp.sin(phase)


def test_what_a_gate_lets_pass_counts_for_jumps_and_peaks():
    """It opens at 1 and closes at 5; where both are turns of the cosine through 0 nothing jumps."""
    terms = np.zeros((2, 5))
    terms[0, 4] = 1.0
    for begins, jumps in ((np.array([1.0, 5.0]), True), (np.array([0.5, 1.5]) * np.pi, False)):
        waveform = Gated(begins, terms)
        assert waveform.jumps(numbers()) == jumps
        phases = np.linspace(0.0, 2.0 * np.pi, 4001)
        volts = np.where((phases >= begins[0]) & (phases < begins[1]), 2.0 * np.cos(phases), 0.0)
        np.testing.assert_allclose(waveform.voltage(phases[1:-1], numbers()), volts[1:-1], atol=1e-12)
        for bias in (0.3, -0.3):
            peak = np.abs(bias + 0.7 * volts).max()
            assert waveform.peak(numbers(0.7, bias)) == pytest.approx(peak, rel=1e-3)
