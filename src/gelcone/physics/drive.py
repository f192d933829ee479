"""The voltage waveform across the film: v(tau) = bias + amplitude sin(omega tau).

The force goes with the square of the voltage, so a pure sine drives the film with the period pi/omega
(its *repeat*), half the period of the voltage; a bias brings the repeat back to 2 pi/omega.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gelcone.quantity import Array


def voltage(tau: Any, amplitude: Any, bias: Any, frequency: Any, xp: Any = np) -> Any:
    """Voltage at the time tau; ``xp`` supplies ``sin`` (NumPy, SymPy or heyoka)."""
    return bias + amplitude * xp.sin(frequency * tau)


def voltage_rate(tau: Any, amplitude: Any, frequency: Any, xp: Any = np) -> Any:
    """Time derivative of `voltage`."""
    return amplitude * frequency * xp.cos(frequency * tau)


def repeat(frequency: Any, bias: Any) -> Array:
    """Smallest period of the force, in dimensionless time."""
    return np.where(np.asarray(bias) == 0.0, 1.0, 2.0) * np.pi / np.asarray(frequency)
