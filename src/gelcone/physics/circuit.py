"""Circuits between the commanded voltage and the film: what a circuit is, the ideal source, and charge control."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from gelcone.errors import InputError
from gelcone.physics.component import Component, Numbers
from gelcone.physics.contract import (
    DEFAULTS,
    NAMED,
    NUMBERS,
    PLACES,
    TEXT,
    Trial,
    check_formulas,
    check_rates,
    listed,
    numbers_of,
)
from gelcone.physics.differentiate import derivatives, gradients
from gelcone.physics.film.film import Border
from gelcone.physics.implicit import root, traced
from gelcone.physics.placed import PlacedFilm

LOSSES = ("resistor", "leak", "dielectric")
"""Losses of a circuit: behind the source, through the film, and in a permittivity that follows with a delay."""


@dataclass(frozen=True)
class Port:
    """The connections of a circuit: its command, and the films that it drives in parallel.

    All values are dimensionless; the unit of capacitance is that of the flat film, C0 = eps pi (b^2 - a^2)/H, that of
    current C0 Phi0 Omega0.

    Parameters
    ----------
    command : the commanded voltage.
    displacement, velocity : those of the disc.
    rate_of_command : function that returns the rate of the commanded voltage, see `command_rate`.
    films : each film with its states.
    n : the numbers of the system, by name.
    xp : the namespace of functions for formulas.

    Examples
    --------
    >>> import gelcone
    >>> port = gelcone.Port(0.5, 0.2, 0.0, lambda: 0.1, (), {}, None)  # made by gelcone for each evaluation
    >>> port.command, port.command_rate
    (0.5, 0.1)
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

    def capacitances(self, voltage: Any) -> list[Any]:
        """The capacitance of each film at a voltage, of arrays as of programs, so that a run stays where films rest."""
        x, squared = self.displacement, voltage * voltage
        if traced(self.xp):
            return [film.capacitance(x, squared, y, self.n, self.xp) for film, y in self.films]
        return [film.fitted_capacitance(x, squared, y, self.n) for film, y in self.films]

    def capacitance(self, voltage: Any) -> Any:
        """The capacitance of all films at a voltage."""
        parts = self.capacitances(voltage)
        return sum(parts[1:], parts[0])

    def charge(self, voltage: Any) -> Any:
        """The charge of all films at a voltage."""
        return voltage * self.capacitance(voltage)

    def voltage(self, charge: Any) -> Any:
        """The voltage at which the films hold a charge."""
        unlike = [film.film for film, _ in self.films if not film.film.linear_charge]
        if traced(self.xp) and any(film.borders for film in unlike):  # the width of a wrinkled film is a root itself
            raise InputError(
                f"film {unlike[0].name!r}: its voltage does not follow from its charge while a motion is computed; "
                "take the taut film, or a circuit whose state is the film's voltage, as behind a series_resistance"
            )
        flat = charge / self.capacitance(0.0 * charge)
        if not unlike:
            return flat

        def residual(v: Any, charge: Any, xp: Any) -> Any:
            return replace(self, xp=xp).charge(v) - charge

        name = f"voltage of a charge on {', '.join(film.words for film, _ in self.films)}"
        return root(self.xp, name, residual, (charge,), lambda charge, xp: flat)

    def voltage_rate(self, voltage: Any, current: Any) -> Any:
        """Rate of the voltage while a ``current`` charges the films and the disc moves; the voltage must be a state."""
        by_voltage, *by_others = self._slopes(voltage)
        for slope, rate in zip(by_others, self._moving(voltage), strict=True):
            current = current - slope * rate
        return current / by_voltage

    def _moving(self, voltage: Any) -> list[Any]:
        """Rates of displacement and films' states at a voltage."""
        rates = [self.velocity]
        for film, y in self.films:
            rates += film.rates(self.displacement, self.velocity, voltage * voltage, y, self.n, self.xp)
        return rates

    def charge_rate(self, voltage: Any, rate: Any) -> Any:
        """Rate of the charge at a voltage with a ``rate`` while the disc moves. The capacitance must not depend on the
        voltage, nor the voltage on the disc or the films' states."""
        charge_rate = self.capacitance(voltage) * rate
        for slope, change in zip(self._slopes(voltage, False), self._moving(voltage), strict=True):
            charge_rate = charge_rate + slope * change
        return charge_rate

    def slope(self, voltage: Any) -> Any:
        """Derivative of the films' charge by the voltage, which must be a state; it has a pole where the minimum of a
        film's energy ends."""
        return self._slopes(voltage)[0]

    def _slopes(self, voltage: Any, by_voltage: bool = True) -> list[Any]:
        """Derivatives of the charge by the voltage (if ``by_voltage``), the displacement and the films' states."""
        at = [voltage, self.displacement, *(value for _, y in self.films for value in y)]

        def charge(at: list[Any], xp: Any) -> list[Any]:
            states, films = iter(at[2:]), []
            for film, y in self.films:
                films.append((film, [next(states) for _ in y]))
            port = replace(self, displacement=at[1], films=tuple(films), xp=xp)
            return [port.charge(at[0])]

        if not traced(self.xp):
            return gradients(charge, at)[0][0 if by_voltage else 1 :]
        (total_charge,) = charge(at, self.xp)
        return [derivatives([self.xp.node(total_charge)], leaf)[0] for leaf in at[0 if by_voltage else 1 :]]


class Circuit(Component):
    """A circuit turns the commanded voltage into the voltage on the film.

    A new circuit supplies `voltage`, and `rates` for the ``states`` that it adds; `gain` where it is linear and its
    gain is not 1. A state may be the film's charge, whose rate is the current (`Port.voltage` returns the voltage), or
    its voltage, whose rate is `Port.voltage_rate` of `charging`; then it is the last one, and ``carries_voltage`` is
    True. Where its law changes, as at a limit, it lists ``borders``: the value of each is ``value(port, y, n, xp)``,
    and its switch, one of the circuit's `numbers`, has the sign of the side (see `Border`). A circuit with states or
    borders has the period of the voltage itself, since these follow the voltage's sign.

    Examples
    --------
    >>> import gelcone
    >>> class Filter(gelcone.Circuit):
    ...     name = "filter"
    ...     states = (gelcone.State("film_voltage", "voltage on the film", "voltage"),)
    ...     parameters = {"filter_constant": gelcone.Quantity("t", "time constant", 0.3, positive=True, scale="time")}
    ...
    ...     def voltage(self, port, y, n, xp=None):
    ...         return y[0]
    ...
    ...     def rates(self, port, y, n, xp=None):
    ...         return [(port.command - y[0]) / n["filter_constant"]]
    ...
    ...     def time_constant(self, n):
    ...         return n["filter_constant"]
    >>> model = gelcone.ConeModel(circuit=Filter(), voltage=0.5)
    >>> gelcone.settled(model.replace(rest_height=0.8)).stroke.round(5).item()
    0.09453
    """

    borders: tuple[Border, ...] = ()
    carries_voltage: bool = False

    @abstractmethod
    def voltage(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """Voltage on the film, given the circuit's states ``y``."""

    def prove(self, given: Numbers = DEFAULTS) -> None:
        """Call the formulas with a taut film at the port, too."""
        from gelcone.physics.film.taut import TautCone

        super().prove(given)
        self.check()
        film = PlacedFilm(TautCone())
        (of_film, many_of_film), (n, many) = numbers_of(film, DEFAULTS), numbers_of(self, given)
        one, many = {**of_film, **n}, {**many_of_film, **many}
        port = Port(0.3, PLACES, PLACES, lambda: 0.1, ((film, []),), many, np)
        y = [np.broadcast_to(value, PLACES.shape) for value in self.starts(PLACES, n)]
        check_formulas(self, [Trial("switches", (port, y, many), NAMED)])
        here = {**many, **self.switches(port, y, many)}
        port = replace(port, n=here)
        of_states = ("voltage", "source_voltage", *(("charging",) if self.carries_voltage else ()))
        check_formulas(
            self,
            [
                *(Trial(name, (port, y, here), NUMBERS) for name in of_states),
                *(Trial(name, (port, PLACES, y, here), NUMBERS) for name in ("squared", "stored")),
                Trial("rates", (port, y, here), listed(len(self.states))),
                Trial("powers", (port, PLACES, y, here), NAMED),
                Trial("leaks", (port, y, here), listed(1, "films")),
                Trial("saturations", (port, y, here), NAMED),
                Trial("gain", (PLACES, many), NUMBERS),
                Trial("commanded", (port, PLACES, many), NUMBERS),
                Trial("describe", (), TEXT),
            ],
        )
        fixed = {**one, **dict.fromkeys(self.switches(port, y, many), 1.0)}

        def rates(z: list[Any], xp: Any) -> list[Any]:
            traced_port = replace(port, displacement=z[0], velocity=z[1], n=fixed, xp=xp)
            return [self.voltage(traced_port, z[2:], fixed, xp), *self.rates(traced_port, z[2:], fixed, xp)]

        check_rates(self, len(self.states), rates)

    def rates(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of the circuit's states."""
        return []

    def charging(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """Rate of the films' charge, for a circuit whose last state is their voltage."""
        raise NotImplementedError

    def switches(self, port: Port, y: list[Any], n: Numbers) -> dict[str, Any]:
        """The switches of its borders at the start of a motion, 1 or -1. Default: the sign of each border's value."""
        switches: dict[str, Any] = {}
        for border in self.borders:
            numbers = {**n, str(border.switch): 1.0}
            switches[str(border.switch)] = np.where(np.asarray(border.value(port, y, numbers, np)) < 0.0, -1.0, 1.0)
        return switches

    def gain(self, frequency: Any, n: Numbers) -> Any:
        """Complex ratio of the film's voltage to the commanded one at an angular frequency (0: a constant voltage)."""
        return 1.0 + 0.0j

    def rests_at_command(self, n: Numbers) -> bool:
        """Whether films rest at the commanded voltage. Default: where the `gain` of a constant voltage is 1."""
        return bool(np.all(np.asarray(self.gain(0.0, n)) == 1.0))

    def commanded(self, port: Port, voltage: Any, n: Numbers) -> Any:
        """The constant command, not negative, under which the films rest at a ``voltage``, with the disc held at the
        port's displacement. Default: by the `gain` of a constant voltage."""
        return voltage / np.abs(self.gain(0.0, n))

    @property
    def losses(self) -> tuple[str, ...]:
        """Names of its losses, among `LOSSES`. Default: the first two if it has `powers`."""
        return () if type(self).powers is Circuit.powers else LOSSES[:2]

    @property
    def held(self) -> Circuit:
        """The circuit of a film with a constant voltage of its own. Default: the ideal source."""
        return IdealSource()

    def powers(self, port: Port, current: Any, y: list[Any], n: Numbers, xp: Any = np) -> Mapping[str, Any]:
        """Power of the ``source``, and the power of each loss (`LOSSES`), while ``current`` charges the films. Default:
        a source at the film's voltage, without losses."""
        return {"source": self.voltage(port, y, n, xp) * current}

    def source_voltage(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """Voltage at the output of the source. Default: the film's."""
        return self.voltage(port, y, n, xp)

    def leaks(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Current that leaks through each film. Default: none."""
        return [0.0] * len(port.films)

    def squared(self, port: Port, voltage: Any, y: list[Any], n: Numbers) -> Any:
        """The effective squared voltage of the field's force on the films. Default: that of the ``voltage``."""
        return voltage * voltage

    def stored(self, port: Port, voltage: Any, y: list[Any], n: Numbers) -> Any:
        """The charge on the films at a ``voltage`` on them."""
        return port.charge(voltage)

    @property
    def delays(self) -> bool:
        """Whether a share of the permittivity follows the field with a delay."""
        return False

    @property
    def jumps(self) -> bool:
        """Whether the voltage on the films jumps where the command does. Default: where it has no states."""
        return not self.states

    def saturations(self, port: Port, y: list[Any], n: Numbers) -> Mapping[str, Any]:
        """Name of each limit -> demand less limit, positive while the circuit is limited. Results report the share of
        the time at it as ``NAME_limited``. Default: no limits."""
        return {}

    def describe(self) -> str:
        """A note about the circuit for readers of a result. Default: empty."""
        return ""

    def check(self) -> None:
        """Raise `InputError` for borders without a switch."""
        if any(border.switch is None for border in self.borders):
            raise InputError(f"circuit {self.name!r}: a border has no switch; name the number whose sign changes there")


class IdealSource(Circuit):
    """A source that puts the commanded voltage on the film.

    Examples
    --------
    >>> import gelcone
    >>> gelcone.ConeModel().system.circuit == gelcone.IdealSource(), gelcone.IdealSource().time_constant({})
    (True, 0.0)
    """

    name = "ideal"

    def voltage(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        return port.command


class ChargeControl(Circuit):
    """A source that commands the charge, stated as the voltage that it gives one flat film; two films share it."""

    name = "charge"

    def voltage(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        return port.voltage(port.command)

    def rests_at_command(self, n: Numbers) -> bool:
        return False

    def commanded(self, port: Port, voltage: Any, n: Numbers) -> Any:
        return port.charge(voltage)
