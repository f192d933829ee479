"""Voltage waveforms: the voltage that is commanded, v(tau) = bias + amplitude shape(omega tau).

The force goes with the square of the voltage. Where the shape changes its sign half a period on, as a sine does, and
there is no bias, the force has half the period of the voltage: the *forcing period* is pi/omega, otherwise 2 pi/omega.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar

import numpy as np

from gelcone.physics.component import Component, Numbers
from gelcone.quantity import Array, Quantity

PHASES = 720
"""Phases of a period at which a shape is evaluated for its peak and its mean square."""

VOLTAGE = {
    "voltage": Quantity("v", "voltage amplitude Phi sqrt(eps/mu)/H", 0.5, lower=0.0),
    "voltage_bias": Quantity("v0", "constant part of the voltage, in the same scale", 0.0),
    "drive_frequency": Quantity("omega", "drive frequency 2 pi f/Omega0", 1.0, positive=True),
}
"""What every waveform takes; one with more numbers adds them: ``parameters = VOLTAGE | {...}``."""


class Waveform(Component):
    """A periodic voltage. A new one supplies `shape` and `shape_rate`, and says whether it is ``antiperiodic``:
    shape(phase + pi) = -shape(phase).

    ``parameters`` must hold those of `VOLTAGE`. `corners` are the phases (0 to 2 pi) at which it is not smooth.
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

    def voltage(self, tau: Any, n: Numbers, xp: Any = np) -> Any:
        """Voltage at the time tau."""
        return n["voltage_bias"] + n["voltage"] * self.shape(n["drive_frequency"] * tau, n, xp)

    def voltage_rate(self, tau: Any, n: Numbers, xp: Any = np) -> Any:
        """Time derivative of `voltage`."""
        return n["voltage"] * n["drive_frequency"] * self.shape_rate(n["drive_frequency"] * tau, n, xp)

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
        return np.asarray(own["voltage_bias"] + own["voltage"] * self.shape(phase, own))

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


WAVEFORMS: dict[str, Waveform] = {waveform.name: waveform for waveform in (Sine(),)}
