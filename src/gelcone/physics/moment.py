"""A system at one time: the voltages of its circuits, and the rates, charges and powers that follow from them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce
from operator import add
from typing import Any

import numpy as np

from gelcone.physics.circuit import Port
from gelcone.physics.component import Numbers
from gelcone.physics.differentiate import derivatives, directional
from gelcone.physics.structure import Line, Structure
from gelcone.physics.trace import Node


class Moment:
    """A system at one time, given by its command, states and numbers, or with the squared voltages ``squares``."""

    def __init__(
        self,
        system: Structure,
        command: Any,
        command_rate: Callable[[], Any],
        z: Sequence[Any],
        n: Numbers,
        xp: Any,
        squares: Sequence[Any] | None = None,
    ) -> None:
        self.system, self.command, self.command_rate = system, command, command_rate
        self.z, self.n, self.xp, self._squares = z, n, xp, squares
        self._voltages: dict[str, Any] = {}
        if xp is np and squares is None and (switches := self._circuit_switches()):
            self.n = {**n, **switches}

    def port(self, line: Line) -> Port:
        """The connections of a line's circuit."""
        system = self.system
        return Port(
            command=system.command_of(line, self.command, self.n),
            displacement=self.z[0],
            velocity=self.z[1],
            rate_of_command=lambda: system.command_slope(line) * self.command_rate(),
            films=tuple((system.films[k], system.states_of(self.z, "film", k)) for k in line.films),
            n=self.n,
            xp=self.xp,
        )

    def _own(self, line: Line) -> tuple[list[Any], Numbers]:
        """The states and numbers of a line's circuit."""
        return self.system.states_of(self.z, "line", line.prefix), line.own(self.n)

    def voltage(self, line: Line) -> Any:
        """Voltage that a line puts on its films."""
        if line.prefix not in self._voltages:
            self._voltages[line.prefix] = line.circuit.voltage(self.port(line), *self._own(line), self.xp)
        return self._voltages[line.prefix]

    def source_voltage(self, line: Line) -> Any:
        """Voltage of a line's source."""
        return line.circuit.source_voltage(self.port(line), *self._own(line), self.xp)

    def leaks(self) -> list[Any]:
        """Current that leaks through each film."""
        leaks: dict[int, Any] = {}
        for line in self.system.lines:
            leaks |= dict(zip(line.films, line.circuit.leaks(self.port(line), *self._own(line), self.xp), strict=True))
        return [leaks[k] for k in range(len(self.system.films))]

    def squared(self, film: int) -> Any:
        """Squared voltage on a film."""
        if self._squares is not None:
            return self._squares[film]
        line = self.system.film_lines[film]
        return line.circuit.squared(self.port(line), self.voltage(line), *self._own(line))

    def squares(self) -> list[Any]:
        """Squared voltage on each film."""
        return [self.squared(k) for k in range(len(self.system.films))]

    def stored(self, line: Line) -> Any:
        """Charge on a line's films."""
        return line.circuit.stored(self.port(line), self.voltage(line), *self._own(line))

    def circuit_rates(self, line: Line) -> list[Any]:
        """Rates of change of the states of a line's circuit."""
        return line.circuit.rates(self.port(line), *self._own(line), self.xp)

    def charging(self, line: Line) -> Any:
        """Rate of the charge on a line's films, for a circuit whose last state is their voltage."""
        return line.circuit.charging(self.port(line), *self._own(line), self.xp)

    def rates(self, circuits: bool = True) -> list[Any]:
        """Rates of change of all states, or without those of ``circuits``."""
        return self.rates_and_slope(circuits)[0]

    def rates_and_slope(self, circuits: bool = True) -> tuple[list[Any], Any]:
        """Rates of change of all states, or without those of ``circuits``, and the derivative of the acceleration by
        the displacement."""
        system, (x, u), n, xp = self.system, self.z[:2], self.n, self.xp
        force, slope = self._force(0)
        bias_y = system.states_of(self.z, "bias")
        bias, bias_slope = system.bias.force(x, bias_y, n, xp)
        acceleration, slope = -2.0 * n["damping_ratio"] * u - force - bias, -slope - bias_slope
        state_rates: list[Any] = []
        for k, film in enumerate(system.films):
            if k:
                force, steeper = self._force(k)
                acceleration, slope = acceleration - force, slope - steeper
            acceleration = acceleration - film.drag(x, n) * u if film.drags else acceleration
            state_rates += film.rates(x, u, self.squared(k), system.states_of(self.z, "film", k), n, xp)
            state_rates += system.bias.rates(x, u, bias_y, n, xp) if k == 0 else []
            for line in system.lines if circuits else ():
                if line.films[0] == k:
                    state_rates += self.circuit_rates(line)
        return [u, acceleration, *state_rates], slope

    def _force(self, film: int) -> tuple[Any, Any]:
        y = self.system.states_of(self.z, "film", film)
        return self.system.films[film].force(self.z[0], self.squared(film), y, self.n, self.xp)

    def switches(self) -> dict[str, Any]:
        """The switches of films and circuits."""
        switches: dict[str, Any] = {}
        for k, film in enumerate(self.system.films):
            if film.borders:
                switches |= film.switches(self.z[0], self.squared(k), self.system.states_of(self.z, "film", k), self.n)
        return switches | self._circuit_switches()

    def _circuit_switches(self) -> dict[str, Any]:
        switches: dict[str, Any] = {}
        for line in self.system.lines:
            line_switches = line.circuit.switches(self.port(line), *self._own(line)) if line.circuit.borders else {}
            switches |= {line.prefix + name: value for name, value in line_switches.items()}
        return switches

    def mechanical_powers(self) -> tuple[Any, Any]:
        """The power of films and field on the disc, and the power of its damper."""
        force = reduce(add, (self._force(k)[0] for k in range(len(self.system.films))))
        for film in self.system.films:
            force = force + film.drag(self.z[0], self.n) * self.z[1] if film.drags else force
        return -force * self.z[1], 2.0 * self.n["damping_ratio"] * self.z[1] * self.z[1]

    def electric_powers(self, time: Node, z: Sequence[Node], causes: Sequence[str]) -> list[Any]:
        """The power by each of the ``causes``, in a graph: sources, losses of films and of circuits."""
        rates = self.rates()
        by_cause: dict[str, Any] = dict.fromkeys(causes, 0.0)
        for line in self.system.lines if "source" in by_cause else ():
            port, (y, n) = self.port(line), self._own(line)
            charge = self.xp.node(self.stored(line))
            powers = line.circuit.powers(port, total_rate(self.system, charge, time, z, rates), y, n, self.xp)
            by_cause |= {name: by_cause[name] + power for name, power in powers.items()}
        if "film" in by_cause:
            for k, film in enumerate(self.system.films):
                y = self.system.states_of(self.z, "film", k)
                by_cause["film"] += film.dissipation(self.z[0], self.z[1], self.squared(k), y, self.n, self.xp)
        return [self.xp.node(by_cause[cause]) for cause in causes]


def total_rate(system: Structure, value: Node, time: Node, z: Sequence[Node], rates: Sequence[Any]) -> Node:
    """Rate of change of a formula along the motion."""
    if any(film.states for film in system.films):  # far fewer nodes where lengths are roots that depend on states
        along = {time: time.graph.constant(1.0)}
        return directional([value], along | {leaf: time.graph.node(rate) for leaf, rate in zip(z, rates, strict=True)})[
            0
        ]
    (total,) = derivatives([value], time)
    for leaf, rate in zip(z, rates, strict=True):
        total = total + derivatives([value], leaf)[0] * rate
    return total
