"""Voltage waveforms: the voltage that is commanded, v(tau) = bias + amplitude shape(omega tau).

The force goes with the square of the voltage. Where the shape changes its sign half a period on, as a sine does, and
there is no bias, the force has half the period of the voltage: the *forcing period* is pi/omega, otherwise 2 pi/omega.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

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


SIDE, CORNER = "side", "corner"
"""Numbers of a waveform with corners: 1 behind the first corner of a period and -1 behind the next, in turn; and the
time of the corner that was passed last."""


PHASE_SPEED = "phase_speed"
"""The drive frequency, where the phase stands in place of the time and ``drive_frequency`` is 1."""


@dataclass(frozen=True)
class Corners:
    """The corners of members between two times: the last one at or before the first time, ``passed`` (members,), its
    ``side``, and all later ones up to the second time, ``later`` (members, corners), padded with infinity."""

    passed: Array
    side: Array
    later: Array


class Waveform(Component):
    """A periodic voltage. A new one supplies `shape` and `shape_rate`, and says whether it is ``antiperiodic``:
    shape(phase + pi) = -shape(phase).

    ``parameters`` must hold those of `VOLTAGE`. `corners` are the phases (from 0, below 2 pi, increasing, an even
    number of them) at which it is continuous but not smooth. Its numbers then hold, for `shape` and `shape_rate`,
    ``side``: 1 behind the first corner, -1 behind the next, in turn; and ``since``, the phase since the last corner.
    The integrator ends a step at each corner.
    """

    parameters = VOLTAGE
    antiperiodic: ClassVar[bool] = False
    corners: ClassVar[tuple[float, ...]] = ()

    @abstractmethod
    def shape(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        """Voltage over amplitude at a phase, of period 2 pi."""

    @abstractmethod
    def shape_rate(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        """Derivative of `shape` with respect to the phase."""

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        own = super().numbers(parameters)
        if not self.corners:
            return own
        one = np.ones(np.shape(own["drive_frequency"]))
        return own | {SIDE: one, CORNER: 0.0 * one}

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
        """The numbers with the place between corners; programs receive the last corner, NumPy formulas compute it."""
        if not self.corners:
            return n
        if traced(xp):
            return {**n, "since": n["drive_frequency"] * (tau - n[CORNER])}
        return {**n, **self._place(np.asarray(phase, dtype=float))}

    def _place(self, phase: Array) -> dict[str, Any]:
        """``side`` and ``since`` at phases."""
        offsets = np.asarray(self.corners) - self.corners[0]
        along = np.mod(phase - self.corners[0], 2.0 * np.pi)
        last = np.searchsorted(offsets, along, side="right") - 1
        return {SIDE: 1.0 - 2.0 * (last % 2), "since": along - offsets[last]}

    def switches(self, tau: Any, n: Numbers) -> dict[str, Any]:
        """The numbers that its corners switch, as the time gives them; none where it is smooth."""
        if not self.corners:
            return {}
        place = self._place(np.asarray(n["drive_frequency"] * tau, dtype=float))
        return {SIDE: place[SIDE], CORNER: tau - place["since"] / n["drive_frequency"]}

    def corners_between(self, start: Array, end: Array, n: Numbers) -> Corners:
        """The corners of members from the times ``start`` to ``end``, (members,)."""
        omega, count = np.asarray(n["drive_frequency"], dtype=float), len(self.corners)
        turn = np.floor((omega * start - self.corners[0]) / (2.0 * np.pi)) - 1.0
        turns = int(np.ceil((omega * (end - start)).max(initial=0.0) / (2.0 * np.pi))) + 3
        phases = 2.0 * np.pi * (turn[:, None, None] + np.arange(turns)[:, None]) + np.asarray(self.corners)
        times = phases.reshape(len(turn), -1) / np.broadcast_to(omega, start.shape)[:, None]
        passed = (times <= start[:, None]).sum(axis=1) - 1
        later = np.where((times > start[:, None]) & (times <= end[:, None]), times, np.inf)
        most = int(np.isfinite(later).sum(axis=1).max(initial=0))
        return Corners(
            passed=times[np.arange(len(turn)), passed],
            side=1.0 - 2.0 * (passed % count % 2),
            later=np.sort(later, axis=1)[:, :most],
        )

    def period(self, n: Numbers) -> Array:
        """Period of the voltage, in dimensionless time."""
        return 2.0 * np.pi / np.asarray(n["drive_frequency"])

    def forcing_period(self, n: Numbers) -> Array:
        """Smallest period of the square of the voltage, in dimensionless time."""
        halves = np.where(np.asarray(n["voltage_bias"]) == 0.0, 1.0, 2.0) if self.antiperiodic else 2.0
        return halves * np.pi / np.asarray(n["drive_frequency"])

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


class Triangle(Waveform):
    """Up and down at a constant rate, as a generator ramps: zero and rising at phase 0, 1 at pi/2, -1 at 3 pi/2."""

    name = "triangle"
    antiperiodic = True
    corners = (0.5 * np.pi, 1.5 * np.pi)

    def shape(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        return n[SIDE] * (1.0 - (2.0 / np.pi) * n["since"])

    def shape_rate(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        return (-2.0 / np.pi) * n[SIDE] + 0.0 * n["since"]

    def peak(self, n: Numbers) -> Any:
        return np.asarray(n["voltage"]) + np.abs(n["voltage_bias"])

    def mean_square(self, n: Numbers) -> Any:
        return np.square(n["voltage_bias"]) + np.square(n["voltage"]) / 3.0


WAVEFORMS: dict[str, Waveform] = {waveform.name: waveform for waveform in (Sine(), Triangle())}
