"""Steps of an exported device by the compiled integrator, as C takes them: what the C must give, bit for bit."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gelcone.codes import CALL_SPAN, STEPS_PER_CALL
from gelcone.export.sources import Exported, filled
from gelcone.motion.flow import smallest_step
from gelcone.physics.driven import INPUTS, PHASE

STEPS = 20
"""Steps of the test program, over a period of the device's own drive."""


@dataclass
class Reference:
    """A motion of an exported device with its own parameters: time in seconds, states and switches."""

    exported: Exported

    def __post_init__(self) -> None:
        self.time = 0.0
        self.z, self.switches = self.exported.start()
        self.numbers = self.exported.numbers()
        members = self.exported.model.members()
        self._smallest, self._fastest = float(smallest_step(members)[0]), float(np.ravel(members.fastest)[0])

    def step(self, seconds: float, given: Sequence[float]) -> int:
        """Moves on under inputs in SI units, voltage and force each with its rate; the status of the integrator."""
        s = self.exported.scale_values
        voltage, voltage_rate, force, force_rate = given
        own = voltage / s["voltage"], voltage_rate * s["time"] / s["voltage"]
        pushed = force / s["force"], force_rate * s["time"] / s["force"]
        n = self.numbers | dict(zip(INPUTS, (*own, *pushed), strict=True)) | self.switches
        if self.exported.sine:
            turns = self.exported.parameters.values["frequency"] * self.time
            n[PHASE] = 6.283185307179586 * (turns - np.floor(turns))
        length = seconds / s["time"]
        most = STEPS_PER_CALL * max(1.0, np.ceil(length * self._fastest / CALL_SPAN))
        found = self.exported.program.run(n, self.z, length, self._smallest, most)
        self.z, self.switches = found.states, dict(found.switches)
        self.time += seconds if found.status == 0 else found.time * s["time"]
        return found.status


def test_program(exported: Exported) -> str:
    """A program that compares steps of the C with those of the integrator, under the device's own drive."""
    device, motion = exported.device, Reference(exported)
    amplitude, offset, frequency = (float(device.get(f)) for f in ("voltage_amplitude", "voltage_offset", "frequency"))
    times = np.arange(STEPS + 1) / (STEPS * frequency)
    volts = 0.0 * times if exported.sine else offset + amplitude * np.sin(2.0 * np.pi * frequency * times)
    steps, right = [], []
    for k in range(STEPS):
        size = float(times[k + 1] - times[k])
        step = size, float(volts[k]), float((volts[k + 1] - volts[k]) / size)
        ended = motion.step(size, (*step[1:], 0.0, 0.0))
        steps.append(step)
        right.append([f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016x}" for value in motion.z])
        if ended:
            break
    return filled(
        "test.c",
        exported.name,
        {"STEPS_TABLE": _rows(steps), "RIGHT_TABLE": _rows(right), "TEST_STATES": str(len(motion.z))},
    )


def _rows(rows: Sequence[Sequence[Any]]) -> str:
    return ",\n".join(
        "  {" + ", ".join(one if isinstance(one, str) else repr(one) for one in row) + "}" for row in rows
    )
