"""Voltage waveforms: the voltage that is commanded, v(tau) = bias + amplitude shape(omega tau).

The force goes with the square of the voltage. Where the shape changes its sign half a period on, as a sine does, and
there is no bias, the force has half the period of the voltage: the *forcing period* is pi/omega, otherwise 2 pi/omega.
"""

from __future__ import annotations

import random
import reprlib
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from gelcone.errors import InputError, unknown_name
from gelcone.physics.component import Component, Numbers
from gelcone.physics.implicit import traced
from gelcone.quantity import Array, Quantity

PHASES = 720
"""Phases of a period at which a shape is evaluated for its peak and its mean square."""

VOLTAGE = {
    "voltage": Quantity("v", "voltage amplitude Phi sqrt(eps/mu)/H", 0.5, lower=0.0, scale="voltage"),
    "voltage_bias": Quantity("v0", "constant part of the voltage, in the same scale", 0.0, scale="voltage"),
    "drive_frequency": Quantity("omega", "drive frequency 2 pi f/Omega0", 1.0, positive=True, scale="frequency"),
}
"""What every waveform takes; one with more numbers adds them: ``parameters = VOLTAGE | {...}``."""


PIECE = ("piece_begin", "piece_0", "piece_1", "piece_2", "piece_3", "gate")
"""Numbers of a waveform with pieces: the time of the corner that was passed last, the terms of the cubic of the phase
since then, and the share of the waveform's carrier that passes."""


PHASE_SPEED = "phase_speed"
"""The drive frequency, where the phase stands in place of the time and ``drive_frequency`` is 1."""


@dataclass(frozen=True)
class Pieces:
    """A table: the phases at which pieces begin, ``begins`` (..., pieces), increasing from the first within one repeat,
    and their ``terms`` (..., pieces, 5): those of the cubic, and the gate."""

    begins: Array
    terms: Array


@dataclass(frozen=True)
class Corners:
    """The corners of members between two times: the numbers of the piece at the first time, ``passed`` (members, 6) in
    the order of `PIECE`; all later corners up to the second time, ``later`` (members, corners), padded with infinity;
    the ``terms`` (members, pieces, 5) of the table, and the piece that begins at the ``first`` later corner."""

    passed: Array
    later: Array
    terms: Array
    first: npt.NDArray[np.int64]


class Waveform(Component):
    """A periodic voltage. A new one supplies `shape` and `shape_rate`, and says whether it is ``antiperiodic``:
    shape(phase + pi) = -shape(phase).

    ``parameters`` must hold those of `VOLTAGE`. One that is not smooth derives from `Pieced`. One that does not
    ``repeat`` lasts for one repeat and is refused by analyses of periodic drives.
    """

    parameters = VOLTAGE
    antiperiodic: bool = False
    pieced: ClassVar[bool] = False
    repeat: bool = True

    @abstractmethod
    def shape(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        """Voltage over amplitude at a phase, of period 2 pi."""

    @abstractmethod
    def shape_rate(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        """Derivative of `shape` with respect to the phase."""

    def voltage(self, tau: Any, n: Numbers, xp: Any = np) -> Any:
        """Voltage at the time tau."""
        phase = n["drive_frequency"] * tau
        return n["voltage_bias"] + n["voltage"] * self.shape(phase, self._at(tau, phase, n, xp), xp)

    def voltage_rate(self, tau: Any, n: Numbers, xp: Any = np) -> Any:
        """Time derivative of `voltage`."""
        phase = n["drive_frequency"] * tau
        speed = n.get(PHASE_SPEED, n["drive_frequency"])
        return n["voltage"] * speed * self.shape_rate(phase, self._at(tau, phase, n, xp), xp)

    def _at(self, tau: Any, phase: Any, n: Numbers, xp: Any) -> Numbers:
        """The numbers with the place between corners; none where it is smooth."""
        return n

    def switches(self, tau: Any, n: Numbers) -> dict[str, Any]:
        """The numbers that its corners switch, as the time gives them; none where it is smooth."""
        return {}

    @property
    def piece_count(self) -> int:
        """The number of pieces of a repeat; 0 where it is smooth."""
        return 0

    def corners_between(self, start: Array, end: Array, n: Numbers) -> Corners:
        """The corners of members from the times ``start`` to ``end``, (members,), of a waveform with pieces."""
        raise NotImplementedError

    def detail(self, n: Numbers) -> Any:
        """Most swings of the voltage in a repeat, for sampling. Default 1."""
        return 1.0

    def period(self, n: Numbers) -> Array:
        """Period of the voltage, in dimensionless time."""
        return 2.0 * np.pi / np.asarray(n["drive_frequency"])

    def forcing_period(self, n: Numbers) -> Array:
        """Smallest period of the square of the voltage, in dimensionless time; `InputError` for one that does not
        repeat."""
        self.check_repeats()
        halves = np.where(np.asarray(n["voltage_bias"]) == 0.0, 1.0, 2.0) if self.antiperiodic else 2.0
        return halves * np.pi / np.asarray(n["drive_frequency"])

    def check_repeats(self) -> None:
        """`InputError` for a voltage that does not repeat."""
        if not self.repeat:
            raise InputError(
                f"waveform = {self.name}: does not repeat, and this needs a drive that does; give repeat = true to its "
                "table (--drive-repeat), or simulate it"
            )

    def samples(self, n: Numbers) -> Array:
        """The voltage at `PHASES` even phases of a period, as a last axis."""
        phase = 2.0 * np.pi * np.arange(PHASES) / PHASES
        own = {name: np.asarray(value)[..., None] for name, value in n.items()}
        return np.asarray(own["voltage_bias"] + own["voltage"] * self.shape(phase, self._at(0.0, phase, own, np)))

    def peak(self, n: Numbers) -> Any:
        """Largest absolute value of the voltage."""
        return np.abs(self.samples(n)).max(axis=-1)[()]

    def mean_square(self, n: Numbers) -> Any:
        """Mean of the squared voltage over a period."""
        return np.square(self.samples(n)).mean(axis=-1)[()]


class Sine(Waveform):
    """v0 + v sin(omega tau)."""

    name = "sine"
    antiperiodic = True

    def shape(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        return xp.sin(phase)

    def shape_rate(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        return xp.cos(phase)

    def peak(self, n: Numbers) -> Any:
        return np.asarray(n["voltage"]) + np.abs(n["voltage_bias"])

    def mean_square(self, n: Numbers) -> Any:
        return np.square(n["voltage_bias"]) + 0.5 * np.square(n["voltage"])


class Pieced(Waveform):
    """A waveform of pieces: each is a cubic of the phase since its corner, and a gate times a carrier.

    A new one supplies `table`, the pieces of one repeat from a phase on, and may replace the carrier, a sine. Programs
    load the numbers of a piece at its corner, where a step ends; NumPy formulas look it up.
    """

    pieced = True

    @abstractmethod
    def table(self, n: Numbers) -> Pieces:
        """The pieces of a repeat; their number is always the same. Of one that does not repeat they begin at 0."""

    def carrier(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        """The smooth part that the gate lets pass."""
        return xp.sin(phase)

    def carrier_rate(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        """Derivative of the carrier with respect to the phase."""
        return xp.cos(phase)

    @property
    def gated(self) -> bool:
        """Whether it has a carrier. Default no."""
        return False

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        own = super().numbers(parameters)
        return own | dict.fromkeys(PIECE, np.zeros(np.shape(own["drive_frequency"])))

    @cached_property
    def piece_count(self) -> int:
        """The number of pieces of a repeat."""
        return int(self.table(self.complete({})).begins.shape[-1])

    def shape(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        s = n["since"]
        cubic = n["piece_0"] + s * (n["piece_1"] + s * (n["piece_2"] + s * n["piece_3"]))
        return cubic + n["gate"] * self.carrier(phase, n, xp) if self.gated else cubic

    def shape_rate(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        s = n["since"]
        cubic = n["piece_1"] + s * (2.0 * n["piece_2"] + s * (3.0 * n["piece_3"]))
        return cubic + n["gate"] * self.carrier_rate(phase, n, xp) if self.gated else cubic

    def _at(self, tau: Any, phase: Any, n: Numbers, xp: Any) -> Numbers:
        """Programs have the numbers of the piece; NumPy formulas look them up."""
        if traced(xp):
            return {**n, "since": n["drive_frequency"] * (tau - n[PIECE[0]])}
        return {**n, **self._place(np.asarray(phase, dtype=float), n)}

    def _place(self, phase: Array, n: Numbers) -> dict[str, Any]:
        """The terms of the piece, and ``since``, at phases."""
        table = self.table(n)
        begins, count = np.asarray(table.begins), self.piece_count
        along = phase - begins[..., 0]
        if self.repeat:
            along = np.mod(along, 2.0 * np.pi)
        offsets = begins - begins[..., :1]
        if offsets.ndim == 1 and np.ndim(table.terms) == 2:
            last = np.clip(np.searchsorted(offsets, along, side="right") - 1, 0, count - 1)
            terms = np.moveaxis(table.terms[last], -1, 0)
            begun = offsets[last]
        else:
            last = np.clip((offsets <= along[..., None]).sum(axis=-1) - 1, 0, count - 1)[..., None]
            shape = (*last.shape[:-1], count)
            begun = np.take_along_axis(np.broadcast_to(offsets, shape), last, axis=-1)[..., 0]
            rows = np.broadcast_to(table.terms, (*shape, table.terms.shape[-1]))
            terms = np.moveaxis(np.take_along_axis(rows, last[..., None], axis=-2)[..., 0, :], -1, 0)
        return {"since": along - begun, **dict(zip(PIECE[1:], terms, strict=True))}

    def switches(self, tau: Any, n: Numbers) -> dict[str, Any]:
        place = self._place(np.asarray(n["drive_frequency"] * tau, dtype=float), n)
        return {PIECE[0]: tau - place.pop("since") / n["drive_frequency"], **place}

    def corners_between(self, start: Array, end: Array, n: Numbers) -> Corners:
        """The corners of members from the times ``start`` to ``end``, (members,)."""
        omega, count, table = np.asarray(n["drive_frequency"], dtype=float), self.piece_count, self.table(n)
        begins = np.broadcast_to(table.begins, (start.size, count))
        turn, turns = np.zeros(start.size), 1
        if self.repeat:
            turn = np.floor((omega * start - begins[:, 0]) / (2.0 * np.pi)) - 1.0
            turns = int(np.ceil((omega * (end - start)).max(initial=0.0) / (2.0 * np.pi))) + 3
        phases = 2.0 * np.pi * (turn[:, None, None] + np.arange(turns)[:, None]) + begins[:, None, :]
        times = phases.reshape(start.size, -1) / np.broadcast_to(omega, start.shape)[:, None]
        last = np.maximum((times <= start[:, None]).sum(axis=1) - 1, 0)
        within = (times > start[:, None]) & (times <= end[:, None])
        most = int(within.sum(axis=1).max(initial=0))
        places = last[:, None] + 1 + np.arange(most)
        known = np.minimum(places, times.shape[1] - 1)
        later = np.where(
            (places < times.shape[1]) & np.take_along_axis(within, known, axis=1),
            np.take_along_axis(times, known, axis=1),
            np.inf,
        )
        terms = np.broadcast_to(table.terms, (start.size, count, table.terms.shape[-1]))
        rows = np.arange(start.size)
        passed = np.concatenate([times[rows, last][:, None], terms[rows, last % count]], axis=1)
        return Corners(passed, later, terms, (last + 1) % count)

    def detail(self, n: Numbers) -> Any:
        return max(self.piece_count / 4.0, 1.0)

    def peak(self, n: Numbers) -> Any:
        """Largest absolute value of the voltage: of cubics at their ends and turning points, else of samples."""
        if self.gated:
            return super().peak(n)
        table = self.table(n)
        lengths = np.diff(table.begins, axis=-1, append=table.begins[..., :1] + 2.0 * np.pi)
        c = np.moveaxis(table.terms, -1, 0)
        with np.errstate(all="ignore"):
            root = np.sqrt(c[2] * c[2] - 3.0 * c[1] * c[3])
            turns = [(-c[2] + sign * root) / (3.0 * c[3]) for sign in (1.0, -1.0)] + [-c[1] / (2.0 * c[2])]
        places = [0.0 * lengths, lengths, *(np.where((t > 0.0) & (t < lengths), t, 0.0) for t in turns)]
        values = [c[0] + s * (c[1] + s * (c[2] + s * c[3])) for s in places]
        high, low = np.max(values, axis=(0, -1)), np.min(values, axis=(0, -1))
        at = [np.asarray(n["voltage_bias"]) + np.asarray(n["voltage"]) * level for level in (high, low)]
        return np.maximum(np.abs(at[0]), np.abs(at[1]))[()]

    def mean_square(self, n: Numbers) -> Any:
        """Mean of the squared voltage over a repeat, by quadrature of each piece, which is exact for cubics."""
        table = self.table(n)
        lengths = np.diff(table.begins, axis=-1, append=table.begins[..., :1] + 2.0 * np.pi)
        places, weights = np.polynomial.legendre.leggauss(NODES)
        total: Any = 0.0
        own = {name: np.asarray(value)[..., None] for name, value in n.items()}
        for place, weight in zip(0.5 * (places + 1.0), 0.5 * weights, strict=True):
            s = place * lengths
            terms = dict(zip(PIECE[1:], np.moveaxis(table.terms, -1, 0), strict=True))
            shape = self.shape(table.begins + s, {**own, **terms, "since": s})
            voltage = self._voltage(shape, {**own, **terms})
            total = total + (weight * lengths * voltage * voltage).sum(axis=-1)
        return (total / (2.0 * np.pi))[()]

    def _voltage(self, shape: Any, n: Numbers) -> Any:
        """The voltage of a shape, with the numbers of its piece."""
        return n["voltage_bias"] + n["voltage"] * shape


def of_points(begins: Any, values: Any) -> Array:
    """The terms (..., pieces, 5) of straight lines between ``values`` (..., pieces + 1) at phases (..., pieces + 1)."""
    length, change = np.diff(begins, axis=-1), np.diff(values, axis=-1)
    slope = np.divide(change, length, out=np.zeros(np.broadcast_shapes(change.shape, length.shape)), where=length > 0.0)
    first = np.broadcast_to(np.asarray(values)[..., :-1], slope.shape)
    return np.stack([first, slope, 0.0 * slope, 0.0 * slope, 0.0 * slope], axis=-1)


def _check_flags(name: str, **flags: Any) -> None:
    """`InputError` for what is neither true nor false."""
    for flag, value in flags.items():
        if not isinstance(value, bool):
            raise InputError(f"{name}: {flag} = {value!r} must be true or false")


def edges(rise: Any, high: Any, fall: Any) -> Pieces:
    """Up, high, down and low at -1 and 1, by their shares of a repeat; phase 0 is the middle of the rise."""
    rise, high, fall = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in (rise, high, fall)))
    zero = 0.0 * rise
    begins = (
        2.0
        * np.pi
        * (np.stack([zero, rise, rise + high, rise + high + fall, zero + 1.0], axis=-1) - 0.5 * rise[..., None])
    )
    values = np.stack([zero - 1.0, zero + 1.0, zero + 1.0, zero - 1.0, zero - 1.0], axis=-1)
    return Pieces(begins[..., :-1], of_points(begins, values))


class Triangle(Pieced):
    """Up and down at a constant rate, as a generator ramps: zero and rising at phase 0, 1 at pi/2, -1 at 3 pi/2."""

    name = "triangle"
    antiperiodic = True

    def table(self, n: Numbers) -> Pieces:
        begins = np.array([-0.5, 0.5, 1.5]) * np.pi
        return Pieces(begins[:-1], of_points(begins, np.array([-1.0, 1.0, -1.0])))


class Trapezoid(Pieced):
    """Up, high, down and low at -1 and 1."""

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
    """1 and -1; with ``rise`` 0 it jumps. The ``duty`` is counted between the middles of rise and fall."""

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
    """From -1 to 1 at a constant rate, and back in the share ``fall`` of the repeat; with 0 it jumps."""

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
    """max(0, v0 + v sin): a diode behind the generator. The corners move with bias and amplitude."""

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

    def voltage_rate(self, tau: Any, n: Numbers, xp: Any = np) -> Any:
        return super().voltage_rate(tau, n, xp)

    def _voltage(self, shape: Any, n: Numbers) -> Any:
        return n["gate"] * n["voltage_bias"] + n["voltage"] * shape

    def samples(self, n: Numbers) -> Array:
        own = {name: np.asarray(value)[..., None] for name, value in n.items()}
        phase = 2.0 * np.pi * np.arange(PHASES) / PHASES
        return np.maximum(own["voltage_bias"] + own["voltage"] * np.sin(phase), 0.0)

    def peak(self, n: Numbers) -> Any:
        return np.maximum(np.asarray(n["voltage_bias"]) + n["voltage"], 0.0)[()]


@dataclass(frozen=True)
class Burst(Pieced):
    """Some ``cycles`` of a sine, then a rest, in a repeat of ``period`` cycles; the drive frequency is that of the
    repeat."""

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

    def peak(self, n: Numbers) -> Any:
        return np.asarray(n["voltage"]) + np.abs(n["voltage_bias"])

    def mean_square(self, n: Numbers) -> Any:
        share = self.cycles / self.period_in_cycles
        return np.square(n["voltage_bias"]) + 0.5 * share * np.square(n["voltage"])


@dataclass(frozen=True)
class Chirp(Pieced):
    """A sine whose frequency goes from ``start_frequency`` to ``end_frequency`` in one repeat, ``sweep`` linear or
    logarithmic; one that does not ``repeat`` then holds its last voltage."""

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
        if self.sweep not in SWEEPS:
            raise unknown_name("sweep of a chirp", str(self.sweep), SWEEPS)

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
        return np.max(np.maximum(n["start_frequency"], n["end_frequency"]) / np.asarray(n["drive_frequency"]))

    def peak(self, n: Numbers) -> Any:
        return np.asarray(n["voltage"]) + np.abs(n["voltage_bias"])


@dataclass(frozen=True)
class Harmonics(Waveform):
    """The sum of a_k sin(k phase + phi_k) over ``terms`` (k, a_k, phi_k)."""

    terms: tuple[tuple[float, ...], ...] = ((1, 1.0, 0.0), (3, 0.2, 0.0))

    name = "harmonics"

    def __post_init__(self) -> None:
        good = all(len(term) == 3 and np.isfinite(term).all() and 1 <= term[0] == int(term[0]) for term in self.terms)
        if not (good and 1 <= len(self.terms) <= MOST_HARMONICS):
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

    def mean_square(self, n: Numbers) -> Any:
        total = {int(k): 0.0j for k, _, _ in self.terms}
        for k, a, phi in self.terms:
            total[int(k)] += a * np.exp(1j * phi)
        power = 0.5 * sum(abs(one) ** 2 for one in total.values())
        return np.square(n["voltage_bias"]) + power * np.square(n["voltage"])


def multisine(lowest: int, highest: int, seed: int = 0) -> Harmonics:
    """Equal harmonics from ``lowest`` to ``highest`` with random phases, scaled to a peak of 1."""
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
    """``levels`` one after the other, held equally long, each reached in the share ``rise`` of its time: the first from
    the last; one that does not ``repeat`` starts at the first and holds the last."""

    levels: tuple[float, ...] = (0.0, 0.5, 1.0, 0.5)
    rise: float = 0.1
    repeat: bool = True

    name = "staircase"

    def __post_init__(self) -> None:
        _check_flags(self.name, repeat=self.repeat)
        if not (1 <= len(self.levels) <= MOST_PIECES and np.isfinite(self.levels).all() and 0.0 <= self.rise <= 1.0):
            raise InputError(
                f"staircase: takes 1 to {MOST_PIECES} finite levels, and a rise from 0 to 1, a share of a level's time"
            )

    def table(self, n: Numbers) -> Pieces:
        count, before = len(self.levels), self.levels[-1] if self.repeat else self.levels[0]
        begins = np.append(np.repeat(np.arange(count, dtype=float), 2), count)
        begins[1:-1:2] += self.rise
        begins *= 2.0 * np.pi / count
        values = np.append(before, np.repeat(self.levels, 2))
        return Pieces(begins[:-1], of_points(begins, values))


def random_levels(count: int, seed: int = 0, rise: float = 0.1) -> Staircase:
    """A staircase of ``count`` random levels, -1 or 1."""
    if not 2 <= count <= MOST_PIECES:
        raise InputError(f"random levels: {count} must be 2 to {MOST_PIECES}")
    draw = random.Random(seed)
    return Staircase(tuple(draw.choice((-1.0, 1.0)) for _ in range(count)), rise)


@dataclass(frozen=True)
class Samples(Pieced):
    """Values at increasing ``shares`` of a repeat from 0 to 1, ``interpolation`` linear or pchip; one that does not
    ``repeat`` holds the last."""

    shares: tuple[float, ...] = (0.0, 0.5, 1.0)
    values: tuple[float, ...] = (0.0, 1.0, 0.0)
    interpolation: str = "linear"
    repeat: bool = False
    jump: bool = False

    name = "samples"

    def __post_init__(self) -> None:
        _check_flags(self.name, repeat=self.repeat, jump=self.jump)
        if self.interpolation not in INTERPOLATIONS:
            raise unknown_name("interpolation", str(self.interpolation), INTERPOLATIONS)
        shares, values = np.asarray(self.shares, dtype=float), np.asarray(self.values, dtype=float)
        if not (2 <= shares.size == values.size <= MOST_PIECES and np.isfinite(values).all()):
            raise InputError(f"samples: takes 2 to {MOST_PIECES} finite values, as many as shares")
        if not (shares[0] == 0.0 and shares[-1] == 1.0 and (np.diff(shares) > 0.0).all()):
            raise InputError("samples: their shares of the repeat must increase from 0 to 1")
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


SWEEPS = ("linear", "logarithmic")
INTERPOLATIONS = ("linear", "pchip")
MOST_CYCLES, MOST_HARMONICS, MOST_PIECES = 1000, 256, 20_000
NODES = 24
"""Of Gauss's quadrature in each piece."""
_SHIPPED: tuple[Waveform, ...] = (
    Sine(), Triangle(), Square(), Trapezoid(), Ramp(), HalfWave(), Burst(), Chirp(), Harmonics(), Staircase(),
    Samples(),
)  # fmt: skip
WAVEFORMS: dict[str, Waveform] = {waveform.name: waveform for waveform in _SHIPPED}
