"""Circuits between the commanded voltage and the film: the ideal source, or one with states and borders of its own."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gelcone.errors import InputError
from gelcone.physics.component import Component, Numbers
from gelcone.physics.differentiate import derivatives, gradients
from gelcone.physics.film.film import Border
from gelcone.physics.implicit import root, traced
from gelcone.physics.placed import PlacedFilm

LOSSES = ("resistor", "leak")
"""Where a circuit may lose power: behind the source, and through the film."""


@dataclass(frozen=True)
class Port:
    """The connections of a circuit: the ``command``, and the films on which it puts a voltage, in parallel.

    ``displacement`` and ``velocity`` are those of the disc. All values are over the scales of the model; a capacitance
    over that of the flat film (C0 = eps pi (b^2 - a^2)/H), a current over C0 Phi0 Omega0.
    """

    command: Any
    displacement: Any
    velocity: Any
    rate_of_command: Callable[[], Any]
    films: tuple[tuple[PlacedFilm, list[Any]], ...]
    n: Numbers
    xp: Any

    @cached_property
    def command_rate(self) -> Any:
        """Rate of the commanded voltage."""
        return self.rate_of_command()

    def capacitance(self, voltage: Any) -> Any:
        """The films' capacitance at a voltage."""
        parts = [film.capacitance(self.displacement, voltage * voltage, y, self.n, self.xp) for film, y in self.films]
        return sum(parts[1:], parts[0])

    def charge(self, voltage: Any) -> Any:
        """The films' charge at a voltage."""
        return voltage * self.capacitance(voltage)

    def voltage(self, charge: Any) -> Any:
        """The voltage at which the films hold a charge."""
        unlike = [film.film for film, _ in self.films if not film.film.linear_charge]
        if traced(self.xp) and any(film.borders for film in unlike):  # the width of a wrinkled film is a root itself
            raise InputError(
                f"film {unlike[0].name!r}: its voltage does not follow from its charge while a motion is computed; "
                "take a circuit whose state is the film's voltage (Port.voltage_rate), or the taut film"
            )
        flat = charge / self.capacitance(0.0 * charge)
        if not unlike:
            return flat

        def residual(v: Any, charge: Any, xp: Any) -> Any:
            return Port(**{**vars(self), "xp": xp}).charge(v) - charge

        name = f"voltage of a charge on {', '.join(film.words for film, _ in self.films)}"
        return root(self.xp, name, residual, (charge,), lambda charge, xp: flat)

    def voltage_rate(self, voltage: Any, current: Any) -> Any:
        """Rate of the voltage while a current charges the films and the disc moves; the voltage must be a state."""
        at = [voltage, self.displacement, *(value for _, y in self.films for value in y)]
        by_voltage, *by_others = self._slopes(at)
        moving = [self.velocity]
        for film, y in self.films:
            moving += film.rates(self.displacement, self.velocity, voltage * voltage, y, self.n, self.xp)
        for slope, rate in zip(by_others, moving, strict=True):
            current = current - slope * rate
        return current / by_voltage

    def _slopes(self, at: list[Any]) -> list[Any]:
        """Derivatives of the charge by voltage, displacement and the films' states."""

        def charge(at: list[Any], xp: Any) -> list[Any]:
            left, films = iter(at[2:]), []
            for film, y in self.films:
                films.append((film, [next(left) for _ in y]))
            port = Port(**{**vars(self), "displacement": at[1], "films": tuple(films), "xp": xp})
            return [port.charge(at[0])]

        if not traced(self.xp):
            return gradients(charge, at)[0]
        (found,) = charge(at, self.xp)
        return [derivatives([self.xp.node(found)], leaf)[0] for leaf in at]


class Circuit(Component):
    """A circuit turns the commanded voltage into that on the film.

    A new one supplies `voltage`, and `rates` for the ``states`` that it adds; `gain` where it is linear and its gain is
    not 1. A state may be the film's charge, whose rate is the current (`Port.voltage` gives the voltage), or its
    voltage, whose rate is `Port.voltage_rate`. Where its law changes, as at a limit, it lists ``borders``: the value of
    each is ``value(port, y, n, xp)``, and its switch, one of the circuit's `numbers`, has the sign of the side (see
    `Border`). A circuit with states or borders has the period of the voltage itself, since these follow the voltage's
    sign.
    """

    borders: tuple[Border, ...] = ()

    @abstractmethod
    def voltage(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """Voltage on the film, given the circuit's own states ``y``."""

    def rates(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of the circuit's states."""
        return []

    def switches(self, port: Port, y: list[Any], n: Numbers) -> dict[str, Any]:
        """The switches of its borders at the start of a motion, 1 or -1: default the sign of each border's value."""
        found: dict[str, Any] = {}
        for border in self.borders:
            one = {**n, str(border.switch): 1.0}
            found[str(border.switch)] = np.where(np.asarray(border.value(port, y, one, np)) < 0.0, -1.0, 1.0)
        return found

    def gain(self, frequency: Any, n: Numbers) -> Any:
        """Complex ratio of the film's voltage to the commanded one at an angular frequency (0: a constant voltage)."""
        return 1.0 + 0.0j

    def powers(self, port: Port, current: Any, y: list[Any], n: Numbers, xp: Any = np) -> Mapping[str, Any]:
        """Power of the ``source``, and what of it is lost where (`LOSSES`), while ``current`` charges the films.
        Default: a source that has the film's voltage, and no losses."""
        return {"source": self.voltage(port, y, n, xp) * current}

    def check(self) -> None:
        """`InputError` for borders that cannot be followed."""
        if any(border.switch is None for border in self.borders):
            raise InputError(f"circuit {self.name!r}: a border has no switch; name the number whose sign changes there")


class IdealSource(Circuit):
    """The film has the commanded voltage."""

    name = "ideal"

    def voltage(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        return port.command


CIRCUITS: dict[str, Circuit] = {circuit.name: circuit for circuit in (IdealSource(),)}
