"""Reference steps of an exported device by the compiled integrator, which the C must reproduce bit for bit."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gelcone.codes import CALL_SPAN, STEPS_PER_CALL
from gelcone.devices.fields import DRIVE_NUMBERS
from gelcone.export.sources import Exported, filled
from gelcone.motion.flow import smallest_step
from gelcone.physics.driven import DRIVE_PIECE, INPUTS, PHASE

TURN = 6.283185307179586
CLOSE = 1e-11 * TURN
"""Phase before a corner of the drive within which the next piece has begun."""
ARRIVED = 0
STEPS = 20
"""Steps of the test program, over a period of the device's drive."""


@dataclass
class Reference:
    """A motion of an exported device with its parameters: time in seconds, states and switches."""

    exported: Exported

    def __post_init__(self) -> None:
        self.time = 0.0
        self.z, self.switches = self.exported.start()
        self.numbers = self.exported.numbers()
        members = self.exported.model.members()
        self._smallest, self._fastest = float(smallest_step(members)[0]), float(np.ravel(members.fastest)[0])

    def step(self, seconds: float, given: Sequence[float]) -> int:
        """Integrate over some seconds under inputs in SI units, voltage and force each with its rate; return the status
        of the integrator."""
        s = self.exported.scale_values
        voltage, voltage_rate, force, force_rate = given
        now, done, status = self.time, 0.0, ARRIVED
        while done < seconds and status == ARRIVED:
            electric_inputs = voltage / s["voltage"], voltage_rate * s["time"] / s["voltage"]
            pushed = force / s["force"], force_rate * s["time"] / s["force"]
            drive, remaining = self._drive()
            duration = min(remaining, seconds - done)
            length = duration / s["time"]
            most = STEPS_PER_CALL * max(1.0, np.ceil(length * self._fastest / CALL_SPAN))
            n = self.numbers | dict(zip(INPUTS, (*electric_inputs, *pushed), strict=True)) | drive | self.switches
            run_end = self.exported.program.run(n, self.z, length, self._smallest, most)
            self.z, self.switches, status = run_end.states, dict(run_end.switches), run_end.status
            reached = run_end.time * s["time"]
            done = done + reached if status != ARRIVED else seconds if duration < remaining else done + duration
            self.time = now + done
            voltage, force = voltage + voltage_rate * reached, force + force_rate * reached
        return status

    def _drive(self) -> tuple[dict[str, float], float]:
        """The numbers of the included drive at the current time, and the seconds to its next corner."""
        if not self.exported.inside:
            return {}, np.inf
        frequency = self.exported.parameters.values["frequency"]
        turns = frequency * self.time
        numbers = {PHASE: TURN * (turns - np.floor(turns))}
        pieces = self.exported.pieces
        if pieces is None:
            return numbers, np.inf
        repeats, offsets = self.exported.model.system.waveform.repeat, pieces.begins - pieces.begins[0]
        along = TURN * (turns - np.floor(turns) if repeats else turns) - float(pieces.begins[0])
        if repeats and along >= TURN - CLOSE:
            along -= TURN
        if repeats and along < -CLOSE:
            along += TURN
        k = max(int((offsets - CLOSE <= along).sum()) - 1, 0)
        end = float(offsets[k + 1]) if k + 1 < offsets.size else TURN if repeats else np.inf
        terms = [along - float(offsets[k]), *map(float, pieces.terms[k])]
        return numbers | dict(zip(DRIVE_PIECE, terms, strict=True)), (end - along) / (TURN * frequency)


def test_program(exported: Exported) -> str:
    """Write a program that compares steps of the C with those of the integrator, under the device's drive."""
    device, motion = exported.device, Reference(exported)
    amplitude, offset, frequency = (float(device.get(field)) for field in DRIVE_NUMBERS)
    times = np.arange(STEPS + 1) / (STEPS * frequency)
    volts = 0.0 * times if exported.inside else offset + amplitude * np.sin(2.0 * np.pi * frequency * times)
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
