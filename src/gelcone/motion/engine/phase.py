"""Equations of motion over the phase of the drive, with the derivatives that shooting needs.

With the phase omega tau in place of time, periods of the drive begin at fixed phases, and the frequency is a parameter
like any other. Behind the states follow the columns of the tangent map and the derivatives with respect to the free
parameters, by the same Taylor series (variational equations).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from gelcone.motion.engine.charges import voltage_turns
from gelcone.motion.engine.interruptions import border_events, corner_numbers, corner_times, switches_at
from gelcone.motion.engine.program import Program, Rerun
from gelcone.physics.differentiate import derivatives
from gelcone.physics.drive import PHASE_SPEED
from gelcone.physics.system import ConeSystem
from gelcone.physics.trace import Graph, Node
from gelcone.quantity import Array

MOST_STEPS = 50_000.0
"""Most steps of the integrator in a segment."""
MOST_PROGRAMS = 64
"""Most programs held in memory; others are on disk."""


def by_phase(n: Mapping[str, Any]) -> dict[str, Any]:
    """The numbers with which formulas take the phase in place of the time."""
    return {**n, "drive_frequency": 1.0, PHASE_SPEED: n["drive_frequency"]}


@dataclass(frozen=True)
class PhaseSystem:
    """A system whose time is the phase of the drive, and whose numbers depend on free parameters.

    ``moved``: the numbers that depend on each free parameter. The number ``share k`` (0 in every run) times ``NAME by
    k`` is added to the number NAME, so that a derivative with respect to the share is one along the parameter. The
    numbers ``at NAME`` stand for the initial states: only the start of a run depends on them.
    """

    system: ConeSystem
    moved: tuple[tuple[str, ...], ...] = ()

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return tuple(state.name for state in self.system.states)

    @property
    def initial(self) -> tuple[str, ...]:
        """Names of the numbers that stand for the initial states."""
        return tuple(f"at {name}" for name in self.states)

    @property
    def shares(self) -> tuple[str, ...]:
        """Names of the shares of the moved parameters."""
        return tuple(f"share {k}" for k in range(len(self.moved)))

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the numbers: those of the system, the initial states, the shares, and slopes by these."""
        by = tuple(f"{name} by {k}" for k, names in enumerate(self.moved) for name in names)
        return (*self.system.numbers, *self.initial, *self.shares, *by)

    def own(self, n: Mapping[str, Any]) -> dict[str, Any]:
        """The system's numbers at the given shares."""
        numbers = {name: n[name] for name in self.system.numbers}
        for k, names in enumerate(self.moved):
            for name in names:
                numbers[name] = numbers[name] + n[f"share {k}"] * n[f"{name} by {k}"]
        return numbers

    def flow(
        self, phase: Any, state: Sequence[Any], n: Mapping[str, Any], xp: Any
    ) -> tuple[list[Any], list[list[Any]]]:
        """Rates of change with the phase, and their Jacobian."""
        numbers = self.own(n)
        slowness = 1.0 / numbers["drive_frequency"]
        rates, slopes = self.system.flow(phase, state, by_phase(numbers), xp)
        return [rate * slowness for rate in rates], [[slope * slowness for slope in row] for row in slopes]

    def forced(self, phase: Node, state: Sequence[Node], n: Mapping[str, Node], xp: Graph, name: str) -> list[Node]:
        """Derivatives of the rates with respect to a number, at fixed charges in place of their voltages."""
        numbers = self.own(n)
        slowness = 1.0 / numbers["drive_frequency"]
        rates, charges = self.system.deviating(phase, state, by_phase(numbers), xp)
        rates = [xp.node(rate * slowness) for rate in rates]
        forcing = derivatives(rates, n[name])
        for index, charge in charges.items():
            (by,), (of_number,) = derivatives([charge], state[index]), derivatives([charge], n[name])
            slopes = derivatives(rates, state[index])
            forcing = [rate - slope * (of_number / by) for rate, slope in zip(forcing, slopes, strict=True)]
        return forcing


@dataclass(frozen=True)
class Sensitivities:
    """A system whose states are those of ``system`` and their derivatives with respect to the numbers ``by``.

    The derivative s = d state / d number obeys s' = J s + d rates / d number, with J the Jacobian, and starts from the
    derivative of the initial state. Behind a resistance it is that of the film's charge in place of its voltage. It
    only runs on a graph, with ``keep="states"``.

    Parameters
    ----------
    system : the system, with ``states``, ``numbers``, ``flow`` and ``forced``.
    by : names among its numbers, none of which an event switches.
    """

    system: Any
    by: tuple[str, ...]

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states: "displacement", ..., "d displacement / d voltage", ..."""
        base = tuple(self.system.states)
        first = tuple(f"d {state} / d {name}" for name in self.by for state in base)
        return base + first

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the system's numbers."""
        return tuple(self.system.numbers)

    def rates(self, time: Node, state: Sequence[Node], n: Mapping[str, Node], xp: Graph) -> list[Node]:
        """Rates of change of the states and of their derivatives."""
        size = len(self.system.states)
        flow, slopes = self.system.flow(time, list(state[:size]), n, xp)
        rates = [xp.node(rate) for rate in flow]
        for k, name in enumerate(self.by, 1):
            block = state[size * k : size * (k + 1)]
            forcing = self.system.forced(time, state[:size], n, xp, name)
            rates += [
                sum((slope * s for slope, s in zip(row, block, strict=True)), forced_rate)
                for row, forced_rate in zip(slopes, forcing, strict=True)
            ]
        return rates


class PhaseProgram:
    """A compiled program for states, tangent maps and derivatives by free parameters, over the drive's phase.

    Behind the N states of a member follow the columns of the tangent map, N each, which begin as those of the unit
    matrix, and the derivatives with respect to the shares, which begin at 0. ``numbers`` are the names of the numbers
    of a run.
    """

    def __init__(self, system: ConeSystem, moved: tuple[tuple[str, ...], ...], tolerance: float) -> None:
        phase = PhaseSystem(system, moved)
        carried: Any = Sensitivities(phase, (*phase.initial, *phase.shares))
        events = border_events(system, lambda numbers: by_phase(phase.own(numbers)))
        corners = corner_numbers(system)
        self._program = Program(carried, "states", tolerance, events, **corners)
        self._system, self._moved = system, moved
        self.numbers = phase.numbers
        switches = [event.switch for event in events if event.switch is not None]
        self.switches = tuple(dict.fromkeys([*switches, *corners.get("pieces", ())]))

    def switches_at(self, phases: Array, states: Array, numbers: Mapping[str, Any]) -> Array:
        """Switches (1 or -1) of films, and terms of a waveform with corners, at ``phases`` (members,) and ``states``
        (members, N), (members, switches) as `Rerun.run` takes them, if there are any."""
        switches = switches_at(self._system, phases, states, by_phase(numbers))
        return np.stack([switches[name] for name in self.switches], axis=1)

    def of_states(
        self, phases: Sequence[Array], states: Sequence[Array], tangents: Array, slopes: Array, n: Mapping[str, float]
    ) -> tuple[Array, Array]:
        """Tangent maps (members, N, N) and derivatives by the shares (members, N, P) of states.

        They follow from those of the deviations that the program carries (`ConeSystem.charged`) between two ``phases``,
        (members,) each.
        """
        numbers = by_phase({name: n[name] for name in self._system.numbers})
        start, end = (voltage_turns(self._system, at, z, numbers)[0] for at, z in zip(phases, states, strict=True))
        moved = []
        for at, z in zip(phases, states, strict=True):
            jump = np.zeros(slopes.shape)
            for k, names in enumerate(self._moved):
                for index, by in self._system.charges_by(at, list(z.T), numbers, names).items():
                    jump[:, index, k] = sum(n[f"{name} by {k}"] * slope for name, slope in zip(names, by, strict=True))
            moved.append(jump)
        slopes = slopes + tangents @ moved[0] - moved[1]
        return np.asarray(np.linalg.solve(end, tangents @ start)), np.asarray(np.linalg.solve(end, slopes))

    def corners(self, start: Array, end: Array, numbers: Mapping[str, Any]) -> tuple[Array, Array, Array] | None:
        """The corners between phases (members,), as `Rerun.run` takes them; None for a smooth drive."""
        options = corner_times(self._system, start, end, by_phase(numbers))
        return (options["corners"], *options["terms"]) if options else None

    def again(self, start: Array, end: Array) -> Rerun:
        """A run from phases ``start`` to ``end`` (members,) that can be repeated with other numbers and states."""
        pieces = self._system.waveform.piece_count
        turns = int(np.ceil((end - start).max() / (2.0 * np.pi))) + 1
        return Rerun(self._program, start, end, MOST_STEPS, turns * pieces + 1, pieces)


phase_program = lru_cache(maxsize=MOST_PROGRAMS)(PhaseProgram)
"""The program of a system and its free parameters, from the memory if it was compiled before."""
