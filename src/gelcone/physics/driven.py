"""A system as another program drives it: voltage and force that are held, or change at a constant rate, over a step.

The time begins anew with each step, so that no digits are lost in long runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gelcone.physics.component import Numbers
from gelcone.physics.drive import VOLTAGE, Waveform
from gelcone.physics.system import ConeSystem

INPUTS = ("input_voltage", "input_voltage_rate", "input_force", "input_force_rate")
PHASE = "input_phase"
"""The phase of the device's own sine where a step begins."""


@dataclass(frozen=True)
class Input(Waveform):
    """A voltage from outside, with the device's own sine added to it if ``sine`` says so."""

    sine: bool = False

    name = "input"
    parameters = VOLTAGE

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        return super().numbers(parameters) | dict.fromkeys((*INPUTS, PHASE), 0.0)

    def shape(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        return xp.sin(n[PHASE] + phase) if self.sine else 0.0 * phase

    def shape_rate(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        return xp.cos(n[PHASE] + phase) if self.sine else 0.0 * phase

    def voltage(self, tau: Any, n: Numbers, xp: Any = np) -> Any:
        given = n[INPUTS[0]] + n[INPUTS[1]] * tau
        return given + super().voltage(tau, n, xp) if self.sine else given

    def voltage_rate(self, tau: Any, n: Numbers, xp: Any = np) -> Any:
        given = n[INPUTS[1]] + 0.0 * tau
        return given + super().voltage_rate(tau, n, xp) if self.sine else given


@dataclass(frozen=True)
class DrivenSystem(ConeSystem):
    """A system whose waveform is an `Input`, with a force on the disc, positive away from the film's plane."""

    def rates(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        rates = super().rates(tau, z, n, xp)
        rates[1] = rates[1] + (n[INPUTS[2]] + n[INPUTS[3]] * tau)
        return rates


def driven(system: ConeSystem, sine: bool) -> DrivenSystem:
    """The system under inputs, with the device's own sine or without."""
    return DrivenSystem(system.films, system.bias, Input(sine), system.circuit)
