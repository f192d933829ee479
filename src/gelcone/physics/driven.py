"""A system under inputs of another program: voltage and force, constant or with constant rates over a step.

The time restarts at 0 with each step, so that no digits are lost in long runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from gelcone.errors import InputError
from gelcone.physics.component import Numbers
from gelcone.physics.drive import PIECE, VOLTAGE, Pieced, Waveform
from gelcone.physics.film.film import Border
from gelcone.physics.system import ConeSystem

INPUTS = ("input_voltage", "input_voltage_rate", "input_force", "input_force_rate")
PHASE = "input_phase"
"""The phase of the device's drive at the beginning of a step."""
DRIVE_PIECE = ("drive_since", "drive_0", "drive_1", "drive_2", "drive_3", "drive_gate")
"""Numbers of the piece of the device's drive in which a step lies: phase since it began, terms of its cubic,
gate."""
STRENGTH_SQUARED = "squared_dielectric_strength"


@dataclass(frozen=True)
class Input(Waveform):
    """An input voltage, plus the device's ``own`` waveform if it is given.

    Each step lies within one piece of that waveform, whose terms are the numbers `DRIVE_PIECE`.
    """

    own: Waveform | None = None

    name = "input"
    parameters = VOLTAGE

    def __post_init__(self) -> None:
        waveform = self.own
        if waveform is not None:
            object.__setattr__(self, "parameters", waveform.parameters)
            if type(waveform).voltage is not Waveform.voltage:
                raise InputError(
                    f"waveform = {waveform.name}: its corners move with the voltage; leave the drive outside"
                )

    @property
    def pieces(self) -> Pieced | None:
        """The device's waveform if it has pieces, else None."""
        return self.own if isinstance(self.own, Pieced) else None

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        plain = self.own is None or self.pieces is not None
        numbers = super().numbers(parameters) if plain else self.own.numbers(parameters)  # type: ignore[union-attr]
        return numbers | dict.fromkeys((*INPUTS, PHASE, *(DRIVE_PIECE if self.pieces else ())), 0.0)

    def shape(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        return 0.0 * phase if self.own is None else self.own.shape(n[PHASE] + phase, self._within(phase, n), xp)

    def shape_rate(self, phase: Any, n: Numbers, xp: Any = np) -> Any:
        return 0.0 * phase if self.own is None else self.own.shape_rate(n[PHASE] + phase, self._within(phase, n), xp)

    def _within(self, phase: Any, n: Numbers) -> Numbers:
        """The numbers, with those of the current piece under the names in the waveform's formulas."""
        if self.pieces is None:
            return n
        since, *terms = (n[name] for name in DRIVE_PIECE)
        return {**n, "since": since + phase, **dict(zip(PIECE[1:], terms, strict=True))}

    def voltage(self, tau: Any, n: Numbers, xp: Any = np) -> Any:
        given = n[INPUTS[0]] + n[INPUTS[1]] * tau
        return given if self.own is None else given + super().voltage(tau, n, xp)

    def voltage_rate(self, tau: Any, n: Numbers, xp: Any = np) -> Any:
        given = n[INPUTS[1]] + 0.0 * tau
        return given if self.own is None else given + super().voltage_rate(tau, n, xp)


@dataclass(frozen=True)
class DrivenSystem(ConeSystem):
    """A system whose waveform is an `Input`, with an input force on the disc, positive away from the film's plane.

    ``breaks_down``: a motion ends where the squared true field of a film reaches the number `STRENGTH_SQUARED`, for
    films whose field is known in a program.
    """

    breaks_down: bool = False

    def rates(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        rates = super().rates(tau, z, n, xp)
        rates[1] = rates[1] + (n[INPUTS[2]] + n[INPUTS[3]] * tau)
        return rates

    @cached_property
    def numbers(self) -> tuple[str, ...]:
        return (*super().numbers, STRENGTH_SQUARED) if self.breaks_down else super().numbers

    def numbers_of(self, values: Numbers) -> dict[str, Any]:
        numbers = super().numbers_of(values)
        return numbers | {STRENGTH_SQUARED: values["dielectric_strength"] ** 2} if self.breaks_down else numbers

    @cached_property
    def borders(self) -> tuple[tuple[int | None, Border], ...]:
        return (*super().borders, *self.field_borders)

    @property
    def field_borders(self) -> tuple[tuple[int | None, Border], ...]:
        """The borders of dielectric breakdown, one for each film; they are the last of `borders`."""
        films = range(len(self.films)) if self.breaks_down else ()
        return tuple((None, Border(partial(self._field_left, k), seldom=True)) for k in films)

    def _field_left(self, k: int, tau: Any, z: Sequence[Any], n: Numbers, xp: Any) -> Any:
        voltage = self._moment(tau, z, n, xp).voltage(self.film_lines[k])
        state = self.films[k].traced_state(z[0], voltage * voltage, self.states_of(z, "film", k), n, xp)
        return n[STRENGTH_SQUARED] - (0.0 * z[0] if state is None else state.field_squared)


def driven(system: ConeSystem, inside: bool = False, breaks_down: bool = False) -> DrivenSystem:
    """Make the system under inputs, with its drive ``inside`` or without it.

    Raises `InputError` for a drive that cannot be inside.
    """
    inputs = Input(system.waveform if inside else None)
    return DrivenSystem(system.films, system.bias, inputs, system.circuit, breaks_down)
