"""Motions of viscous devices with circuits and waveforms by other formulas than gelcone's, and by SciPy.

The film is a sum of springs: the law and the branches, each with a response R and squared elastic stretches E1, E2, E3,
so that its true stresses are R (E1 - E3) and R (E2 - E3). The states of logarithmic branches are the logarithms of p1
and p2; behind a resistance the charge is a state, not the voltage. The lengths of a wrinkling film are found anew at
every evaluation, at a voltage or at a charge, as the minimum of the energy over m >= q and n >= 1 by Newton's method in
ln m and ln n; which of them are held follows from the stresses, so that there are no borders to be found but the end of
the minimum. The work of a source without resistance is the integral of v dQ by parts. DOP853 steps from corner to
corner of the waveform.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import DOP853
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

ARRIVED, PULLED_IN, FAILED = "arrived", "pulled in", "failed"
RELATIVE, ABSOLUTE = 1e-12, 1e-13
MOST_STEPS = 20_000
ENDED = 1e-4
"""The Hessian over the modulus, or over its square, at which a minimum counts as ended: some 1e-8 before."""
NEAR = 0.3
"""The margin below which the film may end within a step."""
JUMP = 0.05
"""Share by which the length changes within a step where it is taken to have jumped to another minimum."""
LEVELS = 40
"""Steps of V from 0 over which the minimum is followed at a start, and where the voltage jumps."""
Piece = tuple[float, float, Callable[[float], float], Callable[[float], float]]
"""Begin and end of a stretch of time, the voltage over it and its rate."""


# --- voltages ---------------------------------------------------------------------------------------------------------


def pieces(wave: dict[str, Any], n: dict[str, float], end: float) -> list[Piece]:
    """The smooth pieces of the commanded voltage from 0 to an end."""
    period, amplitude, bias = 2.0 * math.pi / n["drive_frequency"], n["voltage"], n["voltage_bias"]
    found = []
    for begin, stop, value, rate in _shapes(wave, n, period, end):
        if stop > 0.0 and begin < end and stop > begin:
            found.append(
                (
                    max(begin, 0.0),
                    min(stop, end),
                    lambda t, value=value: bias + amplitude * value(t),
                    lambda t, rate=rate: amplitude * rate(t),
                )
            )
    return found


def _shapes(wave: dict[str, Any], n: dict[str, float], period: float, end: float) -> list[Piece]:
    kind, omega = wave["component"], n["drive_frequency"]
    if kind == "sine":
        return [(0.0, end, lambda t: math.sin(omega * t), lambda t: omega * math.cos(omega * t))]
    if kind == "harmonics":
        terms = wave["terms"]
        return [
            (
                0.0,
                end,
                lambda t: sum(a * math.sin(k * omega * t + phi) for k, a, phi in terms),
                lambda t: sum(k * omega * a * math.cos(k * omega * t + phi) for k, a, phi in terms),
            )
        ]
    if kind == "half_wave":
        return _half_waves(n, period, end)
    if kind == "burst":
        quick, on = wave["period_in_cycles"] * omega, wave["cycles"] / wave["period_in_cycles"]
        found = []
        for k in range(int(end / period) + 1):
            begin = k * period
            found += [
                (begin, begin + on * period, lambda t: math.sin(quick * t), lambda t: quick * math.cos(quick * t)),
                (begin + on * period, begin + period, lambda t: 0.0, lambda t: 0.0),
            ]
        return found
    if kind == "chirp":
        return _chirps(wave, n, period, end)
    if kind == "samples" and wave["interpolation"] == "pchip":
        return _curves(wave, period, end)
    return _lines(_corners(wave, n), wave.get("repeat", True), period, end)


def _half_waves(n: dict[str, float], period: float, end: float) -> list[Piece]:
    """max(0, v0 + v sin), over the amplitude and less the bias, between the zeros of v0 + v sin."""
    amplitude, bias, omega = n["voltage"], n["voltage_bias"], n["drive_frequency"]
    on = (lambda t: math.sin(omega * t), lambda t: omega * math.cos(omega * t))
    off = (lambda t: -bias / amplitude, lambda t: 0.0)
    if abs(bias) >= amplitude:
        return [(0.0, end, *(on if bias > 0.0 else off))]
    rising = math.asin(-bias / amplitude) / omega
    falling, found = 0.5 * period - rising, []
    for k in range(-1, int(end / period) + 2):
        found += [(k * period + rising, k * period + falling, *on)]
        found += [(k * period + falling, (k + 1) * period + rising, *off)]
    return found


def _chirps(wave: dict[str, Any], n: dict[str, float], period: float, end: float) -> list[Piece]:
    first, last = n["start_frequency"], n["end_frequency"]
    growth = math.log(last / first) / period

    def angle(t: float) -> float:
        if wave["sweep"] == "linear":
            return first * t + 0.5 * (last - first) * t * t / period
        return first * (math.exp(growth * t) - 1.0) / growth

    def speed(t: float) -> float:
        if wave["sweep"] == "linear":
            return first + (last - first) * t / period
        return first * math.exp(growth * t)

    found: list[Piece] = []
    for k in range(int(end / period) + 1 if wave["repeat"] else 1):
        at = k * period
        found.append(
            (
                at,
                at + period,
                lambda t, at=at: math.sin(angle(t - at)),
                lambda t, at=at: speed(t - at) * math.cos(angle(t - at)),
            )
        )
    if not wave["repeat"]:
        held = math.sin(angle(period))
        found.append((period, max(end, period), lambda t: held, lambda t: 0.0))
    return found


def _corners(wave: dict[str, Any], n: dict[str, float]) -> list[tuple[float, float]]:
    """Shares of a repeat and values of a shape of straight lines, over one repeat."""
    kind = wave["component"]
    if kind == "samples":
        return list(zip(wave["shares"], wave["values"], strict=True))
    if kind == "staircase":
        levels, rise = wave["levels"], wave["rise"]
        before = levels[-1] if wave["repeat"] else levels[0]
        found = [(0.0, before)]
        for k, level in enumerate(levels):
            found += [((k + rise) / len(levels), level), ((k + 1.0) / len(levels), level)]
        return found
    rise, high, fall = {
        "triangle": lambda: (0.5, 0.0, 0.5),
        "trapezoid": lambda: (n["rise"], n["high"], n["fall"]),
        "square": lambda: (n["rise"], n["duty"] - n["rise"], n["rise"]),
        "ramp": lambda: (1.0 - n["fall"], 0.0, n["fall"]),
    }[kind]()
    begin = -0.5 * rise
    return [
        (begin, -1.0),
        (begin + rise, 1.0),
        (begin + rise + high, 1.0),
        (begin + rise + high + fall, -1.0),
        (begin + 1.0, -1.0),
    ]


def _lines(corners: list[tuple[float, float]], repeat: bool, period: float, end: float) -> list[Piece]:
    found: list[Piece] = []
    for k in range(-1, int(end / period) + 2) if repeat else (0,):
        for (share, low), (following, high) in pairwise(corners):
            begin, stop = (k + share) * period, (k + following) * period
            if stop > begin:
                slope = (high - low) / (stop - begin)
                found.append((begin, stop, lambda t, b=begin, v=low, s=slope: v + s * (t - b), lambda t, s=slope: s))
    if not repeat:
        held = corners[-1][1]
        found.append((period, max(end, period), lambda t: held, lambda t: 0.0))
    return found


def _curves(wave: dict[str, Any], period: float, end: float) -> list[Piece]:
    times = period * np.asarray(wave["shares"])
    terms = PchipInterpolator(times, wave["values"]).c
    found: list[Piece] = []
    for k in range(int(end / period) + 1 if wave["repeat"] else 1):
        for (begin, stop), (c3, c2, c1, c0) in zip(
            zip(times.tolist(), times[1:].tolist(), strict=False), terms.T.tolist(), strict=True
        ):
            at = k * period + begin
            found.append(
                (
                    at,
                    k * period + stop,
                    lambda t, at=at, c=(c0, c1, c2, c3): c[0] + (t - at) * (c[1] + (t - at) * (c[2] + (t - at) * c[3])),
                    lambda t, at=at, c=(c1, 2.0 * c2, 3.0 * c3): c[0] + (t - at) * (c[1] + (t - at) * c[2]),
                )
            )
    if not wave["repeat"]:
        held = float(wave["values"][-1])
        found.append((period, max(end, period), lambda t: held, lambda t: 0.0))
    return found


# --- the film ---------------------------------------------------------------------------------------------------------


class Lost(ArithmeticError):
    """The film has no minimum, or is beyond a stretch limit."""


@dataclass
class Sums:
    """Stresses of the springs at some lengths, their derivatives by ln m and ln n, and R d1, R d2 of each branch."""

    s1: float
    s2: float
    h11: float
    h12: float
    h22: float
    flows: list[tuple[float, float, float, float, float]]


@dataclass
class Lengths:
    """The lengths of the film and the stresses s1 and s2 at them, with the field; what is left of the minimum, or of
    the resistance to localisation, is ``margin``."""

    m: float
    n: float
    s1: float
    s2: float
    margin: float
    sums: Sums


@dataclass
class Film:
    """A film by its numbers; ``branches`` are (g, tau, 1/J)."""

    law: str
    wrinkles: bool
    localises: bool
    A: float
    B: float
    constants: tuple[float, float]
    branches: list[tuple[float, float, float]]
    linear: bool
    exponent: int
    flow_stress: float
    last: tuple[float, float] = field(default=(1.0, 1.0))

    @property
    def modulus(self) -> float:
        return 1.0 + sum(g for g, _, _ in self.branches)

    def response(self, strain: float) -> tuple[float, float]:
        """R and dR/dI1 of the law."""
        if self.law == "yeoh":
            c2, c3 = self.constants
            return 1.0 + 2.0 * c2 * strain + 3.0 * c3 * strain * strain, 2.0 * c2 + 6.0 * c3 * strain
        return _gent(strain, self.constants[0])

    def sums(self, m: float, n: float, y: Sequence[float]) -> Sums:
        """The springs at the lengths m and n; ``y`` are the states of the branches."""
        e1, e2 = self.A * m, self.B * n
        e3 = 1.0 / (e1 * e2)
        r, slope = self.response(e1 + e2 + e3 - 3.0)
        d1, d2 = e1 - e3, e2 - e3
        s1, s2 = r * d1, r * d2
        h11 = r * (e1 + e3) + slope * d1 * d1
        h12 = r * e3 + slope * d1 * d2
        h22 = r * (e2 + e3) + slope * d2 * d2
        flows = []
        size = 3 if self.linear else 2
        for k, (g, _, stiff) in enumerate(self.branches):
            if self.linear:
                a1, a2, a3 = y[size * k : size * k + 3]
                e1, e2, e3, r, slope = a1 * m, a2 * n, a3 / (m * n), 1.0, 0.0
            else:
                e1, e2 = math.exp(y[size * k]) * m, math.exp(y[size * k + 1]) * n
                e3 = 1.0 / (e1 * e2)
                r, slope = _gent(e1 + e2 + e3 - 3.0, stiff)
            d1, d2 = e1 - e3, e2 - e3
            s1 += g * r * d1
            s2 += g * r * d2
            h11 += g * (r * (e1 + e3) + slope * d1 * d1)
            h12 += g * (r * e3 + slope * d1 * d2)
            h22 += g * (r * (e2 + e3) + slope * d2 * d2)
            flows.append((r * d1, r * d2, e1, e2, e3))
        return Sums(s1, s2, h11, h12, h22, flows)

    def flow(self, lengths: Lengths, y: Sequence[float]) -> tuple[list[float], float]:
        """Rates of the states of the branches, and what they dissipate."""
        rates: list[float] = []
        lost = 0.0
        for k, (g, tau, _) in enumerate(self.branches):
            t1, t2, e1, e2, e3 = lengths.sums.flows[k]
            if self.linear:
                a1, a2, a3 = y[3 * k : 3 * k + 3]
                m, n = lengths.m, lengths.n
                rates += [(1.0 / m - a1) / tau, (1.0 / n - a2) / tau, (m * n - a3) / tau]
                lost += g / (2.0 * tau) * sum((e - 1.0) ** 2 / e for e in (e1, e2, e3))
                continue
            t1, t2 = g * t1, g * t2
            squared = t1 * t1 - t1 * t2 + t2 * t2
            quick = (squared / self.flow_stress**2) ** ((self.exponent - 1) // 2) / (3.0 * g * tau)
            rates += [-2.0 * (t1 - 0.5 * t2) * quick, -2.0 * (t2 - 0.5 * t1) * quick]
            lost += squared * quick
        return rates, lost

    def lengths(self, q: float, y: Sequence[float], squared: float | None, charge: float | None) -> Lengths:
        """The film spanning a squared length q, at a squared voltage or at a charge."""
        sums = self.sums(q, 1.0, y)
        pressed = squared * q if squared is not None else charge * charge / q  # type: ignore[operator]
        s1, s2 = sums.s1 - pressed, sums.s2 - pressed
        if not self.wrinkles or (s1 >= 0.0 and s2 >= 0.0):
            if self.wrinkles:
                self.last = (q, 1.0)
            return Lengths(q, 1.0, s1, s2, 1.0, sums)
        return self._slack(q, y, squared, charge)

    def _slack(self, q: float, y: Sequence[float], squared: float | None, charge: float | None) -> Lengths:
        try:
            return self._minimum(q, y, squared, charge)
        except Lost:  # Newton's method from lengths beyond this minimum loses it
            self.last = (q, 1.0)
            for k in range(1, LEVELS):
                less = None if squared is None else squared * k / LEVELS
                self._minimum(q, y, less, None if charge is None else charge * k / LEVELS)
            return self._minimum(q, y, squared, charge)

    def _minimum(self, q: float, y: Sequence[float], squared: float | None, charge: float | None) -> Lengths:
        m, n = max(self.last[0], q), max(self.last[1], 1.0)
        low = math.log(q)
        a, b = math.log(m), math.log(n)
        good: tuple[float, float] | None = None
        for _ in range(120):
            sums = self.sums(m, n, y)
            if squared is not None:
                pressed, sign = squared * m * n, -1.0
            else:
                pressed, sign = charge * charge / (m * n), 1.0  # type: ignore[operator]
            s1, s2, more = sums.s1 - pressed, sums.s2 - pressed, sign * pressed
            h11, h12, h22 = sums.h11 + more, sums.h12 + more, sums.h22 + more
            free1, free2 = a > low or s1 < 0.0, b > 0.0 or s2 < 0.0
            step1 = step2 = 0.0
            det = h11 * h22 - h12 * h12
            if free1 and not (h11 > 0.0 and (det > 0.0 or not free2)):
                if good is None:
                    raise Lost
                a, b = 0.5 * (a + good[0]), 0.5 * (b + good[1])  # stepped beyond the end of the minimum
                m, n = math.exp(a), math.exp(b)
                continue
            good = a, b
            if free1 and free2:
                step1, step2 = (h12 * s2 - h22 * s1) / det, (h12 * s1 - h11 * s2) / det
            elif free1:
                step1 = -s1 / h11
            elif free2:
                step2 = -s2 / h22
            longest = max(abs(step1), abs(step2), 1e-300)
            shorter = min(1.0, 0.3 / longest)
            before = a, b
            a, b = max(a + shorter * step1, low), max(b + shorter * step2, 0.0)
            m, n = q if a == low else math.exp(a), 1.0 if b == 0.0 else math.exp(b)
            if max(abs(a - before[0]), abs(b - before[1])) < 1e-9:
                break
        else:
            raise Lost
        self.last = (m, n)
        sums = self.sums(m, n, y)
        pressed = squared * m * n if squared is not None else charge * charge / (m * n)  # type: ignore[operator]
        return Lengths(
            m,
            n,
            sums.s1 - pressed,
            sums.s2 - pressed,
            self._margin(sums, pressed, q, m, n, squared is None),
            sums,
        )

    @cached_property
    def valley(self) -> float:
        """The m of a film in which nothing creeps at the minimum of Vb(t) = R (1 - t^-3)/t behind its hump, infinite
        without: what is longer has pulled in unless the disc stretches it so far."""

        def slope(t: float) -> float:
            r, change = self.response(2.0 * t + t**-2 - 3.0)
            return 2.0 * change * (1.0 - t**-3) ** 2 / t + r * (4.0 * t**-5 - t**-2)

        before = 1.0
        for t in (1.0 + 1e-3 * k for k in range(1, 30_000)):
            try:
                value = slope(t)
            except Lost:
                break
            if before < 0.0 < value:
                return float(brentq(slope, t - 1e-3, t, xtol=1e-15)) / self.A
            before = value
        return math.inf

    def _margin(self, sums: Sums, pressed: float, q: float, m: float, n: float, charged: bool) -> float:
        """At a held voltage: of a film with slack hoops what is left before it localises, else of the minimum, which a
        film that has a charge passes smoothly."""
        slack1, slack2 = m > q, n > 1.0
        ended = 0.0 if charged else ENDED
        h11, h12, h22 = sums.h11 - pressed, sums.h12 - pressed, sums.h22 - pressed
        if slack1 and slack2 and not self.branches:
            return min((h11 * h22 - h12 * h12) - ended, q / self.valley - 1.0 if m > self.valley else 1.0)
        if slack1 and slack2:
            return (h11 * h22 - h12 * h12) / self.modulus**2 - ended
        if slack1:
            return h11 / self.modulus - ended
        if slack2 and self.localises:
            return 2.0 * (h11 - h12 * h12 / h22) - (sums.s1 - pressed)
        return 1.0


def _gent(strain: float, inverse_limit: float) -> tuple[float, float]:
    left = 1.0 - inverse_limit * strain
    if left <= 0.0:
        raise Lost
    return 1.0 / left, inverse_limit / (left * left)


# --- the device -------------------------------------------------------------------------------------------------------


@dataclass
class Moment:
    """Everything at one time: lengths, voltages, charge, rates of the circuit's states, and powers."""

    lengths: Lengths
    voltage: float
    charge: float
    rates: list[float]
    powers: dict[str, float]


CAUSES = ("motion", "damper", "source", "film", "resistor", "leak", "dielectric")


class Device:
    """A device by the numbers of a model: plain data, no formula of gelcone's."""

    def __init__(self, structure: dict[str, Any], n: dict[str, float]) -> None:
        self.n, self.structure = n, structure
        count, self.linear = structure["branches"], structure["flow"] == "linear"
        branches = [
            (
                n[f"viscous_modulus_{k}"],
                n[f"relaxation_time_{k}"],
                0.0 if self.linear else 1.0 / n[f"viscous_limit_{k}"],
            )
            for k in range(1, count + 1)
        ]
        constants = (n.get("yeoh_c2", 1.0 / n.get("stretch_limit", math.inf)), n.get("yeoh_c3", 0.0))
        self.film = Film(
            structure["law"],
            structure["film"] == "wrinkling",
            structure.get("pull_in") != "minimum",
            n["lm"] ** 2,
            n["lh"] ** 2,
            constants,
            branches,
            self.linear,
            structure["flow_exponent"],
            n.get("flow_stress", 1.0),
        )
        self.viscous = (3 if self.linear else 2) * count
        self.takes = set(structure["takes"])
        self.charged = structure["circuit"] == "charge"
        self.filtered, self.delayed = "filter_time" in self.takes, "dielectric_time" in self.takes
        self.resisted = "series_resistance" in self.takes
        self.electric = self.filtered + self.delayed + self.resisted
        self.parts = set(structure["bias"].split("+"))

    def push(self, x: float) -> float:
        """The force of spring, beam, weight and a constant push."""
        n, found = self.n, 0.0
        if "spring" in self.parts:
            found += n["spring_stiffness"] * (x - n["rest_height"])
        if "beam" in self.parts:
            d = x - n["beam_height"]
            found += n["beam_stiffness"] * d + n["beam_cubic"] * d**3
        if "weight" in self.parts:
            found += n["weight"]
        return found - (n["push"] if "force" in self.parts else 0.0)

    def start(self, disc: Sequence[float]) -> list[float]:
        """All states at the start, and integrals of the powers."""
        m = n = 1.0
        if self.structure["rested"] == "raised":
            bare = Film(**{**vars(self.film), "branches": []})
            q = 1.0 + disc[0] ** 2
            bare.last = (q, 1.0)
            at = bare.lengths(q, [], 0.0, None)
            m, n = at.m, at.n
        own = [1.0 / m, 1.0 / n, m * n] if self.linear else [-math.log(m), -math.log(n)]
        return [*disc, *own * len(self.film.branches), *[0.0] * (self.electric + len(CAUSES))]

    def moment(self, command: float, command_rate: float, z: Sequence[float]) -> Moment:
        """What follows from a command and the states."""
        n, q = self.n, 1.0 + z[0] ** 2
        y = z[2 : 2 + self.viscous]
        own = iter(z[2 + self.viscous : 2 + self.viscous + self.electric])
        source, source_rate, rates = command, command_rate, []
        if self.filtered:
            source = next(own)
            source_rate = (command - source) / n["filter_time"]
            if "slew_rate" in self.takes:
                source_rate = min(max(source_rate, -n["slew_rate"]), n["slew_rate"])
            rates.append(source_rate)
        slow = next(own) if self.delayed else 0.0
        share = n["dielectric_share"] if self.delayed else 0.0
        powers = dict.fromkeys(CAUSES, 0.0)
        if self.resisted:
            charge = next(own)
            if self.film.wrinkles:
                lengths = self.film.lengths(q, y, None, charge)
                capacity = lengths.m * lengths.n
                voltage = charge / capacity
            else:
                capacity = q
                voltage = (charge - share * slow) / ((1.0 - share) * capacity)
                lengths = self.film.lengths(q, y, self._pull(voltage, slow, capacity, share), None)
        elif self.charged:
            charge, capacity = command, q
            voltage = charge / q
            lengths = self.film.lengths(q, y, voltage * voltage, None)
            powers["source"] = voltage * command_rate
        else:
            voltage = source
            lengths = self.film.lengths(q, y, self._pull(voltage, slow, q, share) if self.delayed else voltage**2, None)
            capacity = lengths.m * lengths.n
            charge = (1.0 - share) * capacity * voltage + share * slow
            powers["source"] = -charge * source_rate  # and the change of Q v
        leak = self._leak(voltage, capacity)
        powers["leak"] = voltage * leak
        if self.delayed:
            following = (capacity * voltage - slow) / n["dielectric_time"]
            rates.append(following)
            powers["dielectric"] = share * capacity * (voltage - slow / capacity) ** 2 / n["dielectric_time"]
        if self.resisted:
            current = (source - voltage) / n["series_resistance"]
            if "current_limit" in self.takes:
                current = min(max(current, -n["current_limit"]), n["current_limit"])
            rates.append(current - leak)
            powers["source"], powers["resistor"] = source * current, (source - voltage) * current
        else:
            powers["source"] += voltage * leak
        return Moment(lengths, voltage, charge, rates, powers)

    def _pull(self, voltage: float, slow: float, capacity: float, share: float) -> float:
        late = slow / capacity
        return (1.0 - share) * voltage * voltage + share * late * late

    def _leak(self, voltage: float, capacity: float) -> float:
        if "leakage_time" not in self.takes:
            return 0.0
        if "leakage_field" not in self.takes:
            return capacity * voltage / self.n["leakage_time"]
        root, scale = math.sqrt(capacity), self.n["leakage_field"]
        return capacity * scale * math.sinh(voltage * root / scale) / root / self.n["leakage_time"]

    def rates(self, moment: Moment, z: Sequence[float]) -> list[float]:
        """Rates of change of the states and of the works."""
        x, u = z[0], z[1]
        force = x * moment.lengths.s1 / (1.0 + x * x) if moment.lengths.m == 1.0 + x * x else 0.0
        flows, lost = self.film.flow(moment.lengths, z[2:])
        zeta, powers = self.n["damping_ratio"], moment.powers
        powers["motion"], powers["damper"], powers["film"] = -force * u, 2.0 * zeta * u * u, lost
        acceleration = -2.0 * zeta * u - force - self.push(x)
        return [u, acceleration, *flows, *moment.rates, *(powers[cause] for cause in CAUSES)]


# --- the motion -------------------------------------------------------------------------------------------------------


@dataclass
class Motion:
    """The end of a motion and its time; at the sample times states, the film's charge and voltage, and the works, rows
    of `Device.observed`; the number of evaluations."""

    end: str
    time: float
    rows: list[list[float]]
    evaluations: int


class Run:
    """One motion of a device from a start."""

    def __init__(
        self, device: Device, start: Sequence[float], relative: float = RELATIVE, longest: float = math.inf
    ) -> None:
        self.device, self.z, self.relative, self.longest = device, device.start(start), relative, longest
        self.evaluations = 0
        self.source = len(self.z) - len(CAUSES) + CAUSES.index("source")

    def follow(self, samples: Sequence[float]) -> Motion:
        """The motion up to the last sample."""
        rows: list[list[float]] = []
        wave = pieces(self.device.structure["waveform"], self.device.n, samples[-1])
        for begin, stop, value, rate in wave:
            times = [begin, *(t for t in samples if begin < t < stop), stop]
            try:
                margin = self._anew(value(begin), rate(begin))
            except Lost:
                return Motion(PULLED_IN, begin, rows, self.evaluations)
            if margin < 0.0:
                return Motion(PULLED_IN, begin, rows, self.evaluations)
            for now, then in pairwise(times):
                end, at = self._between(now, then, value, rate)
                if end != ARRIVED:
                    return Motion(end, at, rows, self.evaluations)
                if then in samples:
                    rows.append(self._observed(value(then), rate(then)))
        return Motion(ARRIVED, samples[-1], rows, self.evaluations)

    def _anew(self, command: float, rate: float) -> float:
        """Follow the film's minimum from V = 0 to that of a command; the margin there."""
        film, q, device = self.device.film, 1.0 + self.z[0] ** 2, self.device
        if not film.wrinkles:
            return 1.0
        y = self.z[2 : 2 + device.viscous]
        film.last = (q, 1.0)
        film.lengths(q, y, 0.0, None)
        if device.resisted:
            charge = self.z[2 + device.viscous + device.electric - 1]
            for k in range(1, LEVELS + 1):
                film.lengths(q, y, None, charge * k / LEVELS)
        else:
            voltage = self.z[2 + device.viscous] if device.filtered else command
            for k in range(1, LEVELS + 1):
                film.lengths(q, y, voltage * voltage * k / LEVELS, None)
        return device.moment(command, rate, self.z).lengths.margin

    def _between(
        self, begin: float, stop: float, value: Callable[[float], float], rate: Callable[[float], float]
    ) -> tuple[str, float]:
        device = self.device

        def right(t: float, z: np.ndarray) -> Any:
            self.evaluations += 1
            own = z.tolist()
            try:
                return np.array(device.rates(device.moment(value(t), rate(t), own), own))
            except (ArithmeticError, ValueError):
                return np.full(len(own), np.nan)

        def margin(t: float, z: np.ndarray) -> float:
            try:
                return device.moment(value(t), rate(t), z.tolist()).lengths.margin
            except (ArithmeticError, ValueError):
                return -1.0

        inner = not (device.resisted or device.charged)
        first = self._stored(value(begin)) if inner else 0.0
        solver = DOP853(
            right, begin, np.array(self.z), stop, rtol=self.relative, atol=0.1 * self.relative, max_step=self.longest
        )
        steps, left, here = 0, margin(begin, solver.y), device.film.last
        while solver.status == "running":
            solver.step()
            steps += 1
            if solver.status == "failed" or steps > MOST_STEPS or not np.isfinite(solver.y).all():
                runaway = left != 1.0  # of a slack film, towards which steps vanish
                return (PULLED_IN if runaway else FAILED), float(solver.t)
            if not device.film.wrinkles:
                continue
            before, left = left, margin(solver.t, solver.y)
            there, here = here, device.film.last
            if min(before, left) < NEAR and (ended := self._ended(solver, margin)) is not None:
                return PULLED_IN, ended
            if not device.resisted and (ended := self._jumped(solver, margin, there, here)) is not None:
                return PULLED_IN, ended
        self.z = solver.y.tolist()
        if inner:
            self.z[self.source] += self._stored(value(stop)) - first
        return ARRIVED, stop

    def _ended(self, solver: Any, margin: Callable[[float, np.ndarray], float]) -> float | None:
        """The time in the last step at which the margin fell through zero; None if it did not."""
        dense, low = solver.dense_output(), float(solver.t_old)
        levels = [low + share * (float(solver.t) - low) for share in (0.25, 0.5, 0.75, 1.0)]
        high = next((at for at in levels if margin(at, dense(at)) < 0.0), None)
        if high is None:
            return None
        for _ in range(50):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if margin(middle, dense(middle)) >= 0.0 else (low, middle)
        return high

    def _jumped(
        self,
        solver: Any,
        margin: Callable[[float, np.ndarray], float],
        lengths: tuple[float, float],
        end: tuple[float, float],
    ) -> float | None:
        """The time in the last step at which the film's length jumped to another minimum that is not far; None if it
        moved continuously. ``lengths`` and ``end`` are those at the step's beginning and end."""
        if abs(math.log(end[0] / lengths[0])) < JUMP:
            return None
        film, dense, low, high, last = self.device.film, solver.dense_output(), float(solver.t_old), solver.t, end
        for _ in range(40):
            middle, film.last = 0.5 * (low + high), lengths
            margin(middle, dense(middle))
            if abs(math.log(film.last[0] / lengths[0])) < abs(math.log(end[0] / film.last[0])):
                low, lengths = middle, film.last
            else:
                high, end = middle, film.last
        film.last = last
        return float(high) if abs(math.log(end[0] / lengths[0])) > 0.5 * JUMP else None

    def _stored(self, command: float) -> float:
        """Charge times voltage of a source without resistance."""
        moment = self.device.moment(command, 0.0, self.z)
        return moment.charge * moment.voltage

    def _observed(self, command: float, rate: float) -> list[float]:
        """Displacement, velocity, states of branches and circuit as gelcone has them, charge, voltage and works."""
        device, z = self.device, self.z
        moment = device.moment(command, rate, z)
        branches = z[2 : 2 + device.viscous]
        if not device.linear:
            branches = [math.exp(one) for one in branches]
        elif not device.film.wrinkles:
            branches = [one for k, one in enumerate(branches) if k % 3 != 1]
        electric = z[2 + device.viscous : 2 + device.viscous + device.electric]
        if device.resisted:
            electric = [*electric[:-1], moment.voltage]
        return [*z[:2], *branches, *electric, moment.charge, moment.voltage, *z[-len(CAUSES) :]]
