"""Actuators whose commanded voltage is constant."""

from __future__ import annotations

from typing import Any

import numpy as np

from gelcone.physics.component import Numbers
from gelcone.physics.drive import VOLTAGE, Waveform
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array, Quantity


class _Level(Waveform):
    """A constant level, over the amplitude, of either sign."""

    name = "level"
    parameters = VOLTAGE | {"level": Quantity("l", "constant voltage less the bias, over the amplitude", 0.0)}

    def shape(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        return n["level"] + 0.0 * phase

    def shape_rate(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        return 0.0 * phase


def at_constant_voltages(model: ConeModel, levels: Array) -> ConeModel:
    """A single model under constant commands v, at least 0: a film in opposite phase has 2 v0 - v, with the model's own
    v0."""
    if model.system.in_opposite_phase:
        model = biased_like(model, 1.0)
        return model.replace(waveform=_Level(), voltage=1.0, level=levels - model.voltage_bias)
    return model.replace(voltage=0.0, voltage_bias=levels)


def biased_like(model: ConeModel, voltage: float) -> ConeModel:
    """The single model with a bias of the sign of a constant ``voltage``: the mirror image of all voltages is the same
    actuator, so that the sign of its bias says nothing where voltages have none. Its waveform plays no part."""
    return model.replace(waveform="sine", voltage_bias=np.copysign(model.voltage_bias, voltage))
