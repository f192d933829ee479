"""The contract of a voltage waveform: the commanded voltage v(tau) = bias + amplitude shape(omega tau).

The force goes with the square of the voltage. If the shape changes its sign after half a period, as a sine does, and
there is no bias, the force has half the period of the voltage: the *forcing period* is pi/omega, otherwise 2 pi/omega.
"""

from __future__ import annotations

import reprlib
from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from gelcone.errors import InputError
from gelcone.physics.component import Component, Numbers
from gelcone.physics.contract import (
    DEFAULTS,
    NUMBERS,
    ONE_EACH,
    PLACES,
    Trial,
    called,
    check_formulas,
    numbers_of,
    same_formula,
    wrong,
)
from gelcone.physics.differentiate import derivative
from gelcone.physics.implicit import traced
from gelcone.quantity import Array, Quantity

PHASES = 720
"""Number of phases of a period at which a shape is sampled, as for its peak."""

VOLTAGE = {
    "voltage": Quantity("v", "voltage amplitude Phi sqrt(eps/mu)/H", 0.5, lower=0.0, scale="voltage"),
    "voltage_bias": Quantity("v0", "constant part of the voltage, in the same scale", 0.0, scale="voltage"),
    "drive_frequency": Quantity("omega", "drive frequency 2 pi f/Omega0", 1.0, positive=True, scale="frequency"),
}
"""Parameters of every waveform; one with more adds them: ``parameters = Waveform.parameters | {...}``."""


PIECE = ("piece_begin", "piece_0", "piece_1", "piece_2", "piece_3", "gate")
"""Numbers of a waveform with pieces: the time of the last corner, the terms of the cubic of the phase since then, and
the gate, the share of the carrier that passes."""


PHASE_SPEED = "phase_speed"
"""Name of the drive frequency where the phase replaces the time and ``drive_frequency`` is 1."""


@dataclass(frozen=True)
class Pieces:
    """A table of the pieces of a waveform.

    Parameters
    ----------
    begins : phases at which the pieces begin, (..., pieces), increasing from the first within one repeat.
    terms : the four terms of the cubic of each piece and its gate, (..., pieces, 5).

    Examples
    --------
    >>> import gelcone
    >>> table = gelcone.ConeModel(waveform="triangle").system.waveform.table({})
    >>> table.begins.round(4).tolist(), table.terms.shape
    ([-1.5708, 1.5708], (2, 5))
    """

    begins: Array
    terms: Array


JUMP = 1e-9
"""The smallest relative step between two pieces that is not rounding."""


@dataclass(frozen=True)
class Corners:
    """The corners of members between two times.

    ``passed`` (members, 6) holds the numbers of the piece at the first time, in the order of `PIECE`; ``later``
    (members, corners) the times of all later corners, padded with infinity; ``terms`` (members, pieces, 5) the table;
    ``first`` (members,) the index of the piece that begins at the first later corner.
    """

    passed: Array
    later: Array
    terms: Array
    first: npt.NDArray[np.int64]


class Waveform(Component):
    """A periodic voltage. A new waveform supplies `shape` and `shape_rate`, and sets ``antiperiodic`` if
    shape(phase + pi) = -shape(phase).

    ``parameters`` must contain ``Waveform.parameters``. A waveform that is not smooth derives from `Pieced`. One that
    does not ``repeat`` lasts for one repeat, and analyses of periodic drives refuse it.

    Examples
    --------
    >>> import gelcone
    >>> class Soft(gelcone.Waveform):
    ...     name = "soft"
    ...
    ...     def shape(self, phase, n, xp=None):
    ...         return xp.sin(phase) + 0.1 * xp.sin(3.0 * phase)
    ...
    ...     def shape_rate(self, phase, n, xp=None):
    ...         return xp.cos(phase) + 0.3 * xp.cos(3.0 * phase)
    >>> import numpy as np
    >>> round(float(Soft().shape(1.0, {}, np)), 4), gelcone.ConeModel(waveform=Soft()).voltage
    (0.8556, 0.5)
    """

    parameters = VOLTAGE
    antiperiodic: bool = False
    pieced: ClassVar[bool] = False
    repeat: bool = True

    @abstractmethod
    def shape(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        """Voltage over amplitude at a phase, with the period 2 pi."""

    @abstractmethod
    def shape_rate(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        """Derivative of `shape` with respect to the phase."""

    def prove(self, given: Numbers = DEFAULTS) -> None:
        """Compare the stated rate of the shape with its derivative, and its symmetry with the shape, too."""
        super().prove(given)
        if lacking := [name for name in VOLTAGE if name not in self.parameters]:
            raise wrong(self, "parameters", f"lacks {lacking[0]}", "write parameters = Waveform.parameters | {...}")
        n, many = numbers_of(self, given)
        check_formulas(self, self._trials(many))
        same_formula(self, *self._rates(n))
        if self.antiperiodic:
            what = "antiperiodic = True, a change of sign of the shape after half a period, at a phase"
            here, phases = self.samples({**n, "voltage_bias": 0.0}), 2.0 * np.pi * np.arange(PHASES) / PHASES
            remedy = "leave it out, or correct the shape"
            same_formula(self, what, phases, here, lambda: -np.roll(here, PHASES // 2), remedy)

    def _trials(self, n: Numbers) -> list[Trial]:
        """The calls of its formulas that `prove` makes."""
        shape_trials = [Trial(name, (PLACES, n, np), NUMBERS) for name in ("shape", "shape_rate") if not self.pieced]
        return [
            *shape_trials,
            *(Trial(name, (PLACES, n), NUMBERS) for name in ("voltage", "voltage_rate")),
            *(Trial(name, (n,), ONE_EACH) for name in ("detail", "period", "peak", "offset")),
        ]

    def _rates(self, n: Numbers) -> tuple[Any, ...]:
        """The rate that `prove` compares with a derivative: words, phases, values, and the derivative."""
        what, rate = "shape_rate, the derivative of the shape, at a phase", called(self, "shape_rate", PLACES, n, np)
        return what, PLACES, rate, lambda: derivative(lambda at, xp: self.shape(at, n, xp), PLACES)

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
        """The numbers, with those of the current piece; unchanged for a smooth waveform."""
        return n

    def switches(self, tau: Any, n: Numbers) -> dict[str, Any]:
        """The numbers that change at corners, at a time; none for a smooth waveform."""
        return {}

    @property
    def piece_count(self) -> int:
        """The number of pieces of a repeat; 0 for a smooth waveform."""
        return 0

    def corner_count(self, start: Array, end: Array, n: Numbers) -> Array:
        """An upper bound of the number of corners of each member in `corners_between`, (members,)."""
        turns = np.asarray(n["drive_frequency"]) * (end - start) / (2.0 * np.pi) + 4.0 if self.repeat else 1.0
        return np.broadcast_to(self.piece_count * np.asarray(turns), np.shape(start))

    def corners_between(self, start: Array, end: Array, n: Numbers) -> Corners:
        """The corners of members from the times ``start`` to ``end``, (members,), of a waveform with pieces."""
        raise NotImplementedError

    def detail(self, n: Numbers) -> Any:
        """Largest number of swings of the voltage in a repeat, for sampling. Default 1."""
        return 1.0

    def period(self, n: Numbers) -> Array:
        """Period of the voltage, in dimensionless time."""
        return 2.0 * np.pi / np.asarray(n["drive_frequency"])

    def forcing_period(self, n: Numbers) -> Array:
        """Smallest period of the squared voltage, in dimensionless time; `InputError` for a waveform that does not
        repeat."""
        self.check_repeats()
        halves = np.where(np.asarray(n["voltage_bias"]) == 0.0, 1.0, 2.0) if self.antiperiodic else 2.0
        return halves * np.pi / np.asarray(n["drive_frequency"])

    def check_repeats(self) -> None:
        """Raise `InputError` for a voltage that does not repeat."""
        if not self.repeat:
            raise InputError(
                f"waveform = {self.name}: does not repeat, and this needs a drive that does; let it repeat (repeat = "
                "true in its table, or of its recording), or simulate it"
            )

    def samples(self, n: Numbers, count: int = PHASES) -> Array:
        """The voltage at ``count`` even phases of a period, as a last axis."""
        phase = 2.0 * np.pi * np.arange(count) / count
        numbers = {name: np.asarray(value)[..., None] for name, value in n.items()}
        return np.asarray(
            numbers["voltage_bias"] + numbers["voltage"] * self.shape(phase, self._at(0.0, phase, numbers, np), np)
        )

    def peak(self, n: Numbers) -> Any:
        """Largest absolute value of the voltage."""
        return np.abs(self.samples(n)).max(axis=-1)[()]

    def offset(self, n: Numbers) -> Any:
        """The voltage without amplitude. Default the bias."""
        return np.asarray(n["voltage_bias"])[()]

    def amplitude_at(self, n: Numbers, peak: Any) -> Array:
        """The amplitude from which on the largest absolute voltage exceeds ``peak``; negative where the bias does."""
        one = {**n, "voltage": np.ones_like(n["voltage"]), "voltage_bias": np.zeros_like(n["voltage_bias"])}
        samples, bias = self.samples(one), np.asarray(n["voltage_bias"])
        high, low = _reached(samples)
        size = self.peak(one) / np.maximum(high, low)
        with np.errstate(all="ignore"):
            ends = [np.where(s > 0.0, v / (s * size), np.inf) for s, v in ((high, peak - bias), (low, peak + bias))]
        return np.minimum(*ends)

    def along_bias(self, n: Numbers) -> tuple[Array, Array]:
        """Largest voltages with the sign of the bias, and with the other sign; at most samples of them, 0 for none."""
        samples = self.samples(n) * np.where(np.asarray(n["voltage_bias"]) < 0.0, -1.0, 1.0)[..., None]
        return _reached(samples)


def _reached(samples: Array) -> tuple[Array, Array]:
    """The largest of samples along their last axis, and the largest of their negatives; 0 for none above 0."""
    return np.maximum(samples.max(axis=-1), 0.0), np.maximum(-samples.min(axis=-1), 0.0)


class Pieced(Waveform):
    """A waveform of pieces: each is a cubic of the phase since its corner, and a gate times a carrier.

    A new one supplies `table`, the pieces of one repeat, and may replace the carrier, a sine. Programs load the numbers
    of a piece at its corner, where a step ends; NumPy formulas find the piece of each phase.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(waveform="triangle", voltage=0.5, voltage_bias=0.2)
    >>> isinstance(model.system.waveform, gelcone.Pieced), float(model.system.waveform.peak(model.values))
    (True, 0.7)
    """

    pieced = True

    @abstractmethod
    def table(self, n: Numbers) -> Pieces:
        """The pieces of a repeat, always of the same number; they begin at phase 0 if the waveform does not repeat."""

    def _trials(self, n: Numbers) -> list[Trial]:
        table = called(self, "table", n)
        if not isinstance(table, Pieces) or np.shape(table.terms)[-2:] != (np.shape(table.begins)[-1], 5):
            raise wrong(self, "table", f"returns {reprlib.repr(table)}", "return Pieces(begins, terms)")
        carrier_trials = [
            Trial(name, (PLACES, {**n, "since": PLACES}, np), NUMBERS) for name in ("carrier", "carrier_rate")
        ]
        return [*carrier_trials, *super()._trials(n)]

    def _rates(self, n: Numbers) -> tuple[Any, ...]:
        what = "carrier_rate, the derivative of the carrier"
        rate = self.carrier_rate(PLACES, {**n, "since": PLACES}, np)
        true = lambda: derivative(lambda at, xp: self.carrier(at, {**n, "since": at}, xp), PLACES)  # noqa: E731
        return f"{what}, at a phase", PLACES, rate, true

    def carrier(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        """The smooth part that is multiplied by the gate."""
        return xp.sin(phase)

    def carrier_rate(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        """Derivative of the carrier with respect to the phase."""
        return xp.cos(phase)

    @property
    def gated(self) -> bool:
        """True if the waveform has a carrier. Default False."""
        return False

    def jumps(self, n: Numbers) -> bool:
        """Whether the voltage of any member jumps between two pieces."""
        table = self.table(n)
        begins, terms = np.asarray(table.begins), np.moveaxis(np.asarray(table.terms), -1, 0)
        ends = np.concatenate([begins[..., 1:], begins[..., :1] + 2.0 * np.pi], axis=-1)
        s = ends - begins
        after, before = terms[0], terms[0] + s * (terms[1] + s * (terms[2] + s * terms[3]))
        if self.gated:
            trailing = {name: np.asarray(value)[..., None] for name, value in n.items()}
            after, before = (
                value + terms[4] * self.carrier(begins + since, {**trailing, "since": since})
                for value, since in ((after, 0.0 * s), (before, s))
            )
        steps = np.abs(before - np.roll(after, -1, axis=-1))[..., : None if self.repeat else -1]
        return bool(np.max(steps) > JUMP * np.max(np.abs(terms[[0, 4]])))

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        numbers = super().numbers(parameters)
        return numbers | dict.fromkeys(PIECE, np.zeros(np.shape(numbers["drive_frequency"])))

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
        """The numbers, with those of the current piece: programs have loaded them, NumPy formulas find them."""
        if traced(xp):
            return {**n, "since": n["drive_frequency"] * (tau - n[PIECE[0]])}
        return {**n, **self._place(np.asarray(phase, dtype=float), n)}

    def _place(self, phase: Array, n: Numbers) -> dict[str, Any]:
        """The terms of the pieces at phases, and ``since``, the phase since each began."""
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
            along = np.broadcast_to(along, np.broadcast_shapes(along.shape, np.shape(table.terms)[:-2]))
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
        """Largest absolute value of the voltage: of cubics from their ends and turning points, else from samples."""
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


def of_points(begins: Any, values: Any) -> Array:
    """The terms (..., pieces, 5) of straight lines between ``values`` (..., pieces + 1) at phases (..., pieces + 1)."""
    length, change = np.diff(begins, axis=-1), np.diff(values, axis=-1)
    slope = np.divide(change, length, out=np.zeros(np.broadcast_shapes(change.shape, length.shape)), where=length > 0.0)
    first = np.broadcast_to(np.asarray(values)[..., :-1], slope.shape)
    return np.stack([first, slope, 0.0 * slope, 0.0 * slope, 0.0 * slope], axis=-1)
