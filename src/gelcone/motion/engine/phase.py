"""Equations of motion over the phase of the drive, with the derivatives that shooting needs.

With the phase omega tau in place of time the repeats of the drive lie at fixed phases, and the frequency is a parameter
like any other. Behind the states follow the columns of the tangent map and the derivatives with respect to the free
parameters, all by the same Taylor series (variational equations).
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
"""A segment that takes more steps of the integrator does not end."""
MOST_PROGRAMS = 64
"""Programs held in memory; one that is dropped comes back from the cache on disk."""


def by_phase(n: Mapping[str, Any]) -> dict[str, Any]:
    """The numbers with which formulas of the time take the phase in its place."""
    return {**n, "drive_frequency": 1.0, PHASE_SPEED: n["drive_frequency"]}


@dataclass(frozen=True)
class PhaseSystem:
    """A system whose time is the phase of the drive, and whose numbers move with free parameters.

    ``moved``: for each free parameter the numbers that depend on it. Its number ``share k`` (0 in every run) moves
    number NAME by ``NAME by k`` times itself, so that a derivative with respect to the share is one along the
    parameter. The numbers ``at NAME`` stand for the initial states: nothing depends on them but where a run begins.
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
        """Names of the numbers, those of the system and their slopes by the shares."""
        by = tuple(f"{name} by {k}" for k, names in enumerate(self.moved) for name in names)
        return (*self.system.numbers, *self.initial, *self.shares, *by)

    def own(self, n: Mapping[str, Any]) -> dict[str, Any]:
        """The system's numbers, moved by the shares."""
        own = {name: n[name] for name in self.system.numbers}
        for k, names in enumerate(self.moved):
            for name in names:
                own[name] = own[name] + n[f"share {k}"] * n[f"{name} by {k}"]
        return own

    def flow(
        self, phase: Any, state: Sequence[Any], n: Mapping[str, Any], xp: Any
    ) -> tuple[list[Any], list[list[Any]]]:
        """Rates of change with the phase, and their Jacobian."""
        own = self.own(n)
        slowness = 1.0 / own["drive_frequency"]
        rates, slopes = self.system.flow(phase, state, by_phase(own), xp)
        return [rate * slowness for rate in rates], [[slope * slowness for slope in row] for row in slopes]

    def forced(self, phase: Node, state: Sequence[Node], n: Mapping[str, Node], xp: Graph, name: str) -> list[Node]:
        """Derivatives of the rates of change of deviations by a number, at held deviations."""
        own = self.own(n)
        slowness = 1.0 / own["drive_frequency"]
        rates, charges = self.system.deviating(phase, state, by_phase(own), xp)
        rates = [xp.node(rate * slowness) for rate in rates]
        found = derivatives(rates, n[name])
        for place, charge in charges.items():
            (by,), (of_number,) = derivatives([charge], state[place]), derivatives([charge], n[name])
            slopes = derivatives(rates, state[place])
            found = [rate - slope * (of_number / by) for rate, slope in zip(found, slopes, strict=True)]
        return found


@dataclass(frozen=True)
class Sensitivities:
    """A system whose states are those of ``system``, followed by their derivatives with respect to the numbers ``by``.

    The derivative s = d state / d number obeys s' = J s + d rates / d number, with J the Jacobian, and starts from the
    derivative of the initial state (zero where that does not depend on the number). Behind a resistance it is that of
    the film's charge in place of its voltage. It runs on a graph only, as
    ``keep="states"``.

    Parameters
    ----------
    system : the system, with ``states``, ``numbers`` and ``flow``.
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
        """Names of the numbers, which are the system's."""
        return tuple(self.system.numbers)

    def rates(self, time: Node, state: Sequence[Node], n: Mapping[str, Node], xp: Graph) -> list[Node]:
        """Rates of change of the states and of their derivatives."""
        size = len(self.system.states)
        flow, slopes = self.system.flow(time, list(state[:size]), n, xp)
        rates = [xp.node(rate) for rate in flow]
        blocks = [list(state[size * (k + 1) : size * (k + 2)]) for k in range(len(self.by))]

        first: dict[str, list[Node]] = {}
        for name, block in zip(self.by, blocks, strict=True):
            own = self.system.forced(time, state[:size], n, xp, name)
            first[name] = [
                sum((slope * s for slope, s in zip(row, block, strict=True)), own_rate)
                for row, own_rate in zip(slopes, own, strict=True)
            ]
        return rates + [rate for name in self.by for rate in first[name]]


class PhaseProgram:
    """The compiled states, tangent maps and derivatives with respect to free parameters, over the drive's phase.

    Behind the N states of a member follow the columns of the tangent map, N each, which begin as those of the unit
    matrix, and the derivatives with respect to the shares, which begin at 0. ``numbers`` names what a run takes.
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

    def switches_at(self, phases: Array, states: Array, numbers: Mapping[str, Any]) -> dict[str, Array]:
        """The switches of the films at ``phases`` (members,) and ``states`` (members, N), 1 or -1, by name; and what a
        waveform with corners has there."""
        found = switches_at(self._system, phases, states, by_phase(numbers))
        return {name: found[name] for name in self.switches}

    def of_states(
        self, phases: Sequence[Array], states: Sequence[Array], tangents: Array, slopes: Array, n: Mapping[str, float]
    ) -> tuple[Array, Array]:
        """Tangent maps (members, N, N) and derivatives by the shares (members, N, P) of states, from those of the
        deviations that the program carries (`ConeSystem.charged`) between two phases, each (members,)."""
        own = by_phase({name: n[name] for name in self._system.numbers})
        begin, end = (voltage_turns(self._system, at, z, own)[0] for at, z in zip(phases, states, strict=True))
        moved = []
        for at, z in zip(phases, states, strict=True):
            jump = np.zeros(slopes.shape)
            for k, names in enumerate(self._moved):
                for place, by in self._system.charges_by(at, list(z.T), own, names).items():
                    jump[:, place, k] = sum(n[f"{name} by {k}"] * one for name, one in zip(names, by, strict=True))
            moved.append(jump)
        slopes = slopes + tangents @ moved[0] - moved[1]
        return np.asarray(np.linalg.solve(end, tangents @ begin)), np.asarray(np.linalg.solve(end, slopes))

    def corners(self, start: Array, end: Array, numbers: Mapping[str, Any]) -> tuple[Array, Array, Array] | None:
        """The corners between phases, (members,), as `Rerun.run` takes them; None where the drive is smooth."""
        found = corner_times(self._system, start, end, by_phase(numbers))
        return (found["corners"], *found["terms"]) if found else None

    def again(self, start: Array, end: Array) -> Rerun:
        """Repeat the run from phases ``start`` to ``end`` (members,), to be repeated with other numbers and states."""
        pieces = self._system.waveform.piece_count
        turns = int(np.ceil((end - start).max() / (2.0 * np.pi))) + 1
        return Rerun(self._program, start, end, MOST_STEPS, turns * pieces + 1, pieces)


@lru_cache(maxsize=MOST_PROGRAMS)
def phase_program(system: ConeSystem, moved: tuple[tuple[str, ...], ...], tolerance: float) -> PhaseProgram:
    """The program of a system and its free parameters, compiled once."""
    return PhaseProgram(system, moved, tolerance)
