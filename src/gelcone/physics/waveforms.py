"""The waveforms that ship, by name."""

from __future__ import annotations

import random
import reprlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gelcone.errors import InputError, check_name
from gelcone.physics.component import Numbers
from gelcone.physics.drive import PHASE_SPEED, PHASES, VOLTAGE, Pieced, Pieces, Waveform, of_points
from gelcone.quantity import LARGEST, Array, Quantity

SWEEPS = ("linear", "logarithmic")
INTERPOLATIONS = ("linear", "pchip")
MOST_CYCLES, MOST_HARMONICS, MOST_PIECES = 1000, 256, 20_000
CLOSEST = 1e-12
"""Least share of a repeat between two samples, from which slopes and curvatures are computed."""


def _peak_of_sine(waveform: Waveform, n: Numbers) -> Any:
    """Largest absolute value of a voltage whose shape reaches 1 and -1."""
    return np.asarray(n["voltage"]) + np.abs(n["voltage_bias"])


class Sine(Waveform):
    """v0 + v sin(omega tau).

    Examples
    --------
    >>> import gelcone
    >>> float(gelcone.Sine().peak({"voltage": 0.5, "voltage_bias": 0.2}))
    0.7
    """

    name = "sine"
    antiperiodic = True

    def shape(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        return xp.sin(phase)

    def shape_rate(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        return xp.cos(phase)

    peak = _peak_of_sine


def _check_flags(name: str, **flags: Any) -> None:
    """Raise `InputError` for a flag that is neither true nor false."""
    for flag, value in flags.items():
        if not isinstance(value, bool):
            raise InputError(f"{name}: {flag} = {value!r} must be true or false")


def _list_of_numbers(name: str, given: Any) -> Array:
    """A list as an array; `InputError` for anything but a flat list of numbers of at most `LARGEST`."""
    try:
        array = np.asarray(given)
    except ValueError:  # lists of different lengths
        array = np.asarray(given, dtype=object)
    if array.ndim != 1 or array.dtype.kind not in "iuf" or not (np.abs(array) <= LARGEST).all():
        raise InputError(f"{name} = {reprlib.repr(given)}: must be a list of numbers of at most {LARGEST:g}")
    return array.astype(float)


def edges(rise: Any, high: Any, fall: Any) -> Pieces:
    """The pieces of a trapezoid between -1 and 1 with shares of the repeat for rise, high and fall; phase 0 is the
    middle of the rise."""
    rise, high, fall = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in (rise, high, fall)))
    zero = 0.0 * rise
    ends = np.stack([zero, rise, rise + high, rise + high + fall, zero + 1.0], axis=-1)
    begins = 2.0 * np.pi * (ends - 0.5 * rise[..., None])
    values = np.stack([zero - 1.0, zero + 1.0, zero + 1.0, zero - 1.0, zero - 1.0], axis=-1)
    return Pieces(begins[..., :-1], of_points(begins, values))


class Triangle(Pieced):
    """A triangle wave: zero and rising at phase 0, 1 at pi/2, -1 at 3 pi/2."""

    name = "triangle"
    antiperiodic = True

    def table(self, n: Numbers) -> Pieces:
        begins = np.array([-0.5, 0.5, 1.5]) * np.pi
        return Pieces(begins[:-1], of_points(begins, np.array([-1.0, 1.0, -1.0])))


class Trapezoid(Pieced):
    """A trapezoid wave between -1 and 1."""

    name = "trapezoid"
    parameters = VOLTAGE | {
        "rise": Quantity("r", "share of the repeat in which the voltage rises", 0.1, lower=0.0),
        "high": Quantity("h", "share of the repeat in which it is high", 0.4, lower=0.0),
        "fall": Quantity("f", "share of the repeat in which it falls", 0.1, lower=0.0),
    }

    def complete(self, given: Mapping[str, Any]) -> dict[str, Any]:
        values = super().complete(given)
        total = np.max(sum(np.asarray(values[name]) for name in ("rise", "high", "fall")))
        if total > 1.0:
            raise InputError(f"rise + high + fall = {total:g}: are shares of one repeat, at most 1; make one smaller")
        return values

    def table(self, n: Numbers) -> Pieces:
        return edges(n["rise"], n["high"], n["fall"])


class Square(Pieced):
    """A square wave between -1 and 1; with ``rise`` 0 it jumps. ``duty`` is measured between the middles of rise and
    fall."""

    name = "square"
    parameters = VOLTAGE | {
        "duty": Quantity("d", "share of the repeat in which the voltage is high", 0.5, lower=0.0),
        "rise": Quantity("r", "share of the repeat in which it rises, and falls; 0: it jumps", 0.02, lower=0.0),
    }

    def complete(self, given: Mapping[str, Any]) -> dict[str, Any]:
        values = super().complete(given)
        duty, rise = np.broadcast_arrays(values["duty"], values["rise"])
        if (wrong := (rise > duty) | (rise > 1.0 - duty)).any():
            at = int(np.argmax(wrong.ravel()))
            raise InputError(
                f"duty = {duty.flat[at]:g}: must be from rise = {rise.flat[at]:g} to 1 - rise; change one of the two"
            )
        return values

    def table(self, n: Numbers) -> Pieces:
        rise = np.asarray(n["rise"])
        return edges(rise, n["duty"] - rise, rise)


class Ramp(Pieced):
    """A ramp from -1 to 1 at a constant rate, and back in the share ``fall`` of the repeat; with 0 it jumps."""

    name = "ramp"
    parameters = VOLTAGE | {
        "fall": Quantity("f", "share of the repeat in which the voltage falls; 0: it jumps", 0.05, lower=0.0)
    }

    def complete(self, given: Mapping[str, Any]) -> dict[str, Any]:
        values = super().complete(given)
        if np.max(values["fall"]) > 1.0:
            raise InputError(f"fall = {np.max(values['fall']):g}: is a share of the repeat; must be at most 1")
        return values

    def table(self, n: Numbers) -> Pieces:
        fall = np.asarray(n["fall"])
        return edges(1.0 - fall, 0.0 * fall, fall)


class HalfWave(Pieced):
    """A rectified sine, max(0, v0 + v sin), as of a diode behind the generator. The corners depend on bias and
    amplitude."""

    name = "half_wave"
    gated = True

    def table(self, n: Numbers) -> Pieces:
        amplitude, bias = np.broadcast_arrays(
            np.asarray(n["voltage"], dtype=float), np.asarray(n["voltage_bias"], dtype=float)
        )
        with np.errstate(all="ignore"):
            share = np.where(amplitude > 0.0, -bias / amplitude, np.where(bias < 0.0, 1.0, -1.0))
        begin = np.arcsin(np.clip(share, -1.0, 1.0))  # the voltage rises through 0 there, and falls at pi - begin
        begins = np.stack([begin, np.pi - begin], axis=-1)
        zero = 0.0 * begins
        gate = np.stack([zero[..., 0] + (share < 1.0), zero[..., 0] + (share <= -1.0)], axis=-1)
        return Pieces(begins, np.stack([zero, zero, zero, zero, gate], axis=-1))

    def voltage(self, tau: Any, n: Numbers, xp: Any = np) -> Any:
        phase = n["drive_frequency"] * tau
        gate = self._at(tau, phase, n, xp)["gate"]
        return gate * (n["voltage_bias"] + n["voltage"] * xp.sin(phase))

    def samples(self, n: Numbers, count: int = PHASES) -> Array:
        numbers = {name: np.asarray(value)[..., None] for name, value in n.items()}
        phase = 2.0 * np.pi * np.arange(count) / count
        return np.maximum(numbers["voltage_bias"] + numbers["voltage"] * np.sin(phase), 0.0)

    def peak(self, n: Numbers) -> Any:
        return np.maximum(np.asarray(n["voltage_bias"]) + n["voltage"], 0.0)[()]

    def offset(self, n: Numbers) -> Any:
        return np.maximum(n["voltage_bias"], 0.0)[()]


@dataclass(frozen=True)
class Burst(Pieced):
    """A burst of ``cycles`` of a sine, followed by a rest, in a repeat of ``period_in_cycles``; the drive frequency is
    that of the repeat."""

    cycles: int = 3
    period_in_cycles: int = 5

    name = "burst"
    gated = True

    def __post_init__(self) -> None:
        whole = isinstance(self.cycles, int) and isinstance(self.period_in_cycles, int)
        if not (whole and 1 <= self.cycles < self.period_in_cycles <= MOST_CYCLES):
            raise InputError(
                f"burst of {self.cycles} cycles in {self.period_in_cycles}: must be whole numbers, from 1, fewer than "
                f"the period of at most {MOST_CYCLES}"
            )

    def table(self, n: Numbers) -> Pieces:
        terms = np.zeros((2, 5))
        terms[0, 4] = 1.0
        return Pieces(np.array([0.0, 2.0 * np.pi * self.cycles / self.period_in_cycles]), terms)

    def carrier(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        return xp.sin(self.period_in_cycles * phase)

    def carrier_rate(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        return self.period_in_cycles * xp.cos(self.period_in_cycles * phase)

    def detail(self, n: Numbers) -> Any:
        return self.period_in_cycles

    peak = _peak_of_sine


@dataclass(frozen=True)
class Chirp(Pieced):
    """A sine whose frequency changes from ``start_frequency`` to ``end_frequency`` in one repeat, with a linear or
    logarithmic ``sweep``; without ``repeat`` it then holds its last voltage."""

    sweep: str = "linear"
    repeat: bool = False

    name = "chirp"
    gated = True
    parameters = VOLTAGE | {
        "start_frequency": Quantity(
            "w0", "frequency at the start, 2 pi f/Omega0", 0.5, positive=True, scale="frequency"
        ),
        "end_frequency": Quantity("w1", "frequency at the end", 3.0, positive=True, scale="frequency"),
    }

    def __post_init__(self) -> None:
        _check_flags(self.name, repeat=self.repeat)
        check_name("sweep of a chirp", self.sweep, SWEEPS)

    def complete(self, given: Mapping[str, Any]) -> dict[str, Any]:
        values = super().complete(given)
        if self.sweep == "logarithmic" and np.any(np.equal(values["start_frequency"], values["end_frequency"])):
            raise InputError("start_frequency = end_frequency: a logarithmic chirp needs two; take sweep = linear")
        return values

    def table(self, n: Numbers) -> Pieces:
        if self.repeat:
            return Pieces(np.zeros(1), np.array([[0.0, 0.0, 0.0, 0.0, 1.0]]))
        last = np.sin(self._angle(2.0 * np.pi, n, np)[0])
        zero, one = 0.0 * last, 0.0 * last + 1.0
        terms = [
            np.stack([zero, last], axis=-1),
            *[np.stack([zero, zero], axis=-1)] * 3,
            np.stack([one, zero], axis=-1),
        ]
        return Pieces(np.array([0.0, 2.0 * np.pi]), np.stack(terms, axis=-1))

    def carrier(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        return xp.sin(self._angle(n["since"], n, xp)[0])

    def carrier_rate(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        angle, rate = self._angle(n["since"], n, xp)
        return rate * xp.cos(angle)

    def _angle(self, phase: Any, n: Numbers, xp: Any) -> tuple[Any, Any]:
        """The angle of the sine, and its derivative by the phase of the repeat."""
        speed = n.get(PHASE_SPEED, n["drive_frequency"])
        first, last = n["start_frequency"] / speed, n["end_frequency"] / speed
        if self.sweep == "linear":
            growth = (last - first) / (2.0 * np.pi)
            return phase * (first + 0.5 * growth * phase), first + growth * phase
        growth = xp.log(last / first) / (2.0 * np.pi)
        rise = xp.exp(growth * phase)
        return (first / growth) * (rise - 1.0), first * rise

    def detail(self, n: Numbers) -> Any:
        return np.maximum(n["start_frequency"], n["end_frequency"]) / np.asarray(n["drive_frequency"])

    peak = _peak_of_sine


@dataclass(frozen=True)
class Harmonics(Waveform):
    """The sum of a_k sin(k phase + phi_k) over ``terms`` (k, a_k, phi_k)."""

    terms: tuple[tuple[float, ...], ...] = ((1, 1.0, 0.0), (3, 0.2, 0.0))

    name = "harmonics"

    def __post_init__(self) -> None:
        terms = self.terms if isinstance(self.terms, tuple | list) else ((),)
        flat = [_list_of_numbers("harmonics: a term", term) for term in terms]
        good = all(term.size == 3 and 1 <= term[0] == np.floor(term[0]) for term in flat)
        if not (good and 1 <= len(flat) <= MOST_HARMONICS):
            raise InputError(
                f"harmonics: {reprlib.repr(self.terms)} must be 1 to {MOST_HARMONICS} triples [k, amplitude, phase], "
                "with k = 1, 2, ..."
            )

    @property
    def antiperiodic(self) -> bool:  # type: ignore[override]
        """Whether all its harmonics are odd."""
        return all(int(k) % 2 == 1 for k, _, _ in self.terms)

    def shape(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        parts = [a * xp.sin(int(k) * phase + float(phi)) for k, a, phi in self.terms]
        return sum(parts[1:], parts[0])

    def shape_rate(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        parts = [int(k) * a * xp.cos(int(k) * phase + float(phi)) for k, a, phi in self.terms]
        return sum(parts[1:], parts[0])

    def detail(self, n: Numbers) -> Any:
        return max(int(k) for k, _, _ in self.terms)


def multisine(lowest: int, highest: int, seed: int = 0) -> Harmonics:
    """Make a sum of equal harmonics from ``lowest`` to ``highest`` with random phases, scaled to a peak of 1."""
    if not 1 <= lowest <= highest < lowest + MOST_HARMONICS:
        raise InputError(f"multisine from {lowest} to {highest}: must be 1 to {MOST_HARMONICS} harmonics from 1 on")
    draw = random.Random(seed)
    phases = [2.0 * np.pi * draw.random() for _ in range(lowest, highest + 1)]
    plain = Harmonics(tuple((k, 1.0, phi) for k, phi in zip(range(lowest, highest + 1), phases, strict=True)))
    angle = 2.0 * np.pi * np.arange(64 * highest) / (64 * highest)
    peak = float(np.abs(plain.shape(angle, {})).max())
    return Harmonics(tuple((k, 1.0 / peak, phi) for k, _, phi in plain.terms))


@dataclass(frozen=True)
class Staircase(Pieced):
    """A sequence of ``levels`` of equal duration, each reached in the share ``rise`` of it, the first from the last.
    Without ``repeat`` it starts at the first and holds the last."""

    levels: tuple[float, ...] = (0.0, 0.5, 1.0, 0.5)
    rise: float = 0.1
    repeat: bool = True

    name = "staircase"

    def __post_init__(self) -> None:
        _check_flags(self.name, repeat=self.repeat)
        levels = _list_of_numbers("staircase: levels", self.levels)
        if not (1 <= levels.size <= MOST_PIECES and 0.0 <= self.rise <= 1.0):
            raise InputError(
                f"staircase: takes 1 to {MOST_PIECES} levels, and a rise from 0 to 1, a share of a level's time"
            )

    def table(self, n: Numbers) -> Pieces:
        count, before = len(self.levels), self.levels[-1] if self.repeat else self.levels[0]
        begins = np.append(np.repeat(np.arange(count, dtype=float), 2), count)
        begins[1:-1:2] += self.rise
        begins *= 2.0 * np.pi / count
        values = np.append(before, np.repeat(self.levels, 2))
        return Pieces(begins[:-1], of_points(begins, values))


def random_levels(count: int, seed: int = 0, rise: float = 0.1) -> Staircase:
    """Make a staircase of ``count`` random levels, -1 or 1."""
    if not 2 <= count <= MOST_PIECES:
        raise InputError(f"random levels: {count} must be 2 to {MOST_PIECES}")
    draw = random.Random(seed)
    return Staircase(tuple(draw.choice((-1.0, 1.0)) for _ in range(count)), rise)


@dataclass(frozen=True)
class Samples(Pieced):
    """A waveform through ``values`` at increasing ``shares`` of a repeat from 0 to 1, with linear or pchip
    ``interpolation``; without ``repeat`` it holds the last value."""

    shares: tuple[float, ...] = (0.0, 0.5, 1.0)
    values: tuple[float, ...] = (0.0, 1.0, 0.0)
    interpolation: str = "linear"
    repeat: bool = False
    jump: bool = False

    name = "samples"

    def __post_init__(self) -> None:
        _check_flags(self.name, repeat=self.repeat, jump=self.jump)
        check_name("interpolation", self.interpolation, INTERPOLATIONS)
        shares, values = (_list_of_numbers(f"samples: {name}", getattr(self, name)) for name in ("shares", "values"))
        if not 2 <= shares.size == values.size <= MOST_PIECES:
            raise InputError(f"samples: takes 2 to {MOST_PIECES} values, as many as shares")
        if not (shares[0] == 0.0 and shares[-1] == 1.0 and (np.diff(shares) >= CLOSEST).all()):
            raise InputError(f"samples: shares {_misplaced(shares)}")
        if self.repeat and not self.jump and values[0] != values[-1]:
            raise InputError(
                f"samples: {values[-1]:g} at the end, {values[0]:g} at the start: repeated they would jump; add a last "
                "sample, or jump = true"
            )

    @cached_property
    def _pieces(self) -> Pieces:
        begins, values = 2.0 * np.pi * np.asarray(self.shares), np.asarray(self.values, dtype=float)
        terms = of_points(begins, values)
        if self.interpolation == "pchip":
            from scipy.interpolate import PchipInterpolator

            terms[:, :4] = PchipInterpolator(begins, values).c[::-1].T
        if self.repeat:
            return Pieces(begins[:-1], terms)
        return Pieces(begins, np.concatenate([terms, [[values[-1], 0.0, 0.0, 0.0, 0.0]]]))

    def table(self, n: Numbers) -> Pieces:
        return self._pieces


def _misplaced(shares: Array) -> str:
    """State what is wrong with shares that do not increase from 0 to 1, and the remedy."""
    for at, word, end, inside in ((0, "begin", 0, shares[0] > 0.0), (-1, "end", 1, shares[-1] < 1.0)):
        if shares[at] != end:
            remedy = f"add {end}.0 with its value" if inside else "scale them from 0 to 1"
            return f"{word} at {shares[at]:g} of the repeat, and must {word} at {end}; {remedy}"
    k = int(np.argmax(np.diff(shares) < CLOSEST))
    return f"{shares[k]:g}, {shares[k + 1]:g}: must increase, by {CLOSEST:g} at least; sort them with their values"


_SHIPPED: tuple[Waveform, ...] = (
    Sine(), Triangle(), Square(), Trapezoid(), Ramp(), HalfWave(), Burst(), Chirp(), Harmonics(), Staircase(),
    Samples(),
)  # fmt: skip
WAVEFORMS: dict[str, Waveform] = {waveform.name: waveform for waveform in _SHIPPED}
