"""The equation of motion of components, independent of their numbers; programs are compiled from it.

The disc obeys x'' = -2 zeta x' - sum of F_film(x, V) - F_bias(x), with the squared voltage V of each film, which a
circuit makes from the waveform. Components may add states after displacement and velocity.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from typing import Any

import numpy as np

from gelcone.errors import InputError
from gelcone.physics.at_rest import SystemAtRest
from gelcone.physics.component import Numbers
from gelcone.physics.differentiate import derivatives, evaluated, jacobian
from gelcone.physics.film.film import Border
from gelcone.physics.implicit import traced
from gelcone.physics.moment import Moment, total_rate
from gelcone.physics.structure import DISC, Line
from gelcone.physics.trace import Graph, Node, ordered
from gelcone.quantity import Array

FOLDED = 1e-7
"""The flat film's capacitance over dQ/dv at which a minimum counts as ended, some 1e-6 before its end."""


@dataclass(frozen=True)
class ConeSystem(SystemAtRest):
    """A disc on one film, or between two (a double cone), with a bias, under a waveform through a circuit."""

    @cached_property
    def planar(self) -> bool:
        """Whether displacement and velocity are the only states, and no voltage depends on them, as with a commanded
        charge. Areas then shrink by exp(-2 zeta tau)."""
        drags = any(film.drags for film in self.films)
        return len(self.states) == len(DISC) and not drags and not self._voltages_follow_the_disc

    @property
    def _voltages_follow_the_disc(self) -> bool:
        """Whether a voltage depends on the states."""
        if self.ideal:
            return False
        try:
            voltages = _traced(self, ConeSystem.voltages)[1]
        except InputError:  # programs do not know the film's charge, so that it has statics alone
            return False
        return any(node.operation == "state" for node in ordered(voltages))

    # --- voltages ----------------------------------------------------------------------------------------------------

    def voltages(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Voltage on each film."""
        moment = self._moment(tau, z, n, xp)
        return [moment.voltage(line) for line in self.film_lines]

    def commands(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Commanded voltage of each film."""
        moment = self._moment(tau, z, n, xp)
        return [moment.port(line).command for line in self.film_lines]

    def squares(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """The effective squared voltages of the fields' forces on the films."""
        return self._moment(tau, z, n, xp).squares()

    def squared_at(self, voltage: Any, z: Sequence[Any], n: Numbers, film: int = 0) -> Any:
        """The effective squared voltage on a film at a ``voltage``."""
        moment, line = self.under(voltage, z, n), self.film_lines[film]
        return line.circuit.squared(moment.port(line), voltage, self.states_of(z, "line", line.prefix), line.own(n))

    def stored(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> Any:
        """Charge on the films of the first line."""
        return self._moment(tau, z, n, xp).stored(self.lines[0])

    def voltage_rates(self, tau: Any, z: Sequence[Any], n: Numbers) -> list[Any]:
        """Rates of change of the voltages on the films along a motion, of numbers or arrays."""
        if self.ideal:
            change = self.waveform.voltage_rate(tau, n)
            return [self.command_slope(line) * change for line in self.film_lines]
        return self._values(_total_rates, tau, z, n, ConeSystem.voltages)

    def currents(self, tau: Any, z: Sequence[Any], n: Numbers) -> list[Any]:
        """Currents into the films along a motion, of numbers or arrays: the rates of their charges, and their leaks."""
        charge_rates = iter(self._values(_total_rates, tau, z, n, _charges))
        moving = zip(self.films, self.voltages(tau, z, n), self.voltage_rates(tau, z, n), strict=True)
        rates = [
            next(charge_rates) if film.film.traced_charge else film.current(z[0], z[1], voltage, rate, n)
            for film, voltage, rate in moving
        ]
        leaks = zip(rates, self.leaks(tau, z, n), strict=True)
        return [rate + leak if np.any(leak) else rate for rate, leak in leaks]

    def source_currents(self, tau: Any, z: Sequence[Any], n: Numbers) -> list[Any]:
        """Current from the source of each line into its films."""
        currents = self.currents(tau, z, n)
        return [sum((currents[k] for k in line.films[1:]), currents[line.films[0]]) for line in self.lines]

    def leaks(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Current that leaks through each film."""
        return self._moment(tau, z, n, xp).leaks()

    def source_voltages(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Voltage of the source that drives each film."""
        moment = self._moment(tau, z, n, xp)
        return [moment.source_voltage(line) for line in self.film_lines]

    def source_charges(self, tau: Any, z: Sequence[Any], n: Numbers) -> list[Any]:
        """Charge on the films of each line, delivered by its source."""
        moment = self._moment(tau, z, n, np)
        return [moment.stored(line) for line in self.lines]

    def source_rates(self, tau: Any, z: Sequence[Any], n: Numbers) -> list[Any]:
        """Rates of change of `source_voltages`."""
        if self.ideal:
            return self.voltage_rates(tau, z, n)
        return self._values(_total_rates, tau, z, n, ConeSystem.source_voltages)

    def saturations(self, line: Line, tau: Any, z: Sequence[Any], n: Numbers) -> Mapping[str, Any]:
        """Name of each limit of a line's circuit -> demand less limit, positive while the circuit is limited."""
        moment = self._moment(tau, z, n, np)
        return line.circuit.saturations(moment.port(line), self.states_of(z, "line", line.prefix), line.own(moment.n))

    def under(
        self, command: Any, z: Sequence[Any], n: Numbers, xp: Any = np, *, rate: Any = 0.0, squares: Any = None
    ) -> Moment:
        """The system under a command of the first line, constant unless it has a ``rate``, or at given ``squares``."""
        return Moment(self, command, lambda: rate, z, n, xp, squares)

    def _moment(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any) -> Moment:
        return Moment(self, self.waveform.voltage(tau, n, xp), lambda: self.waveform.voltage_rate(tau, n, xp), z, n, xp)

    # --- the equation of motion --------------------------------------------------------------------------------------

    def rates(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of the states; by NumPy each with the switches of its place."""
        return self._moment(tau, z, self._switched(tau, z, n, xp), xp).rates()

    def _switched(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any) -> Numbers:
        switches = self.switches(tau, z, n) if xp is np else {}
        return {**n, **switches} if switches else n

    @cached_property
    def mechanical(self) -> list[int]:
        """The indices of the states that do not belong to a circuit."""
        slices = [place for owner, place in self._places.items() if owner[0] != "line"]
        return [*range(len(DISC)), *(i for place in slices for i in range(place.start, place.stop))]

    def rates_held(self, squares: Sequence[Any], z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of the `mechanical` states at given squared voltages on the films."""
        return self.under(0.0, z, n, xp, squares=squares).rates(circuits=False)

    def electric(
        self, line: Line, command: Any, command_rate: Any, z: Sequence[Any], n: Numbers, xp: Any = np
    ) -> list[Any]:
        """The voltage of a line, and the rates of change of its circuit's states, at a command of the first line."""
        moment = self.under(command, z, n, xp, rate=command_rate)
        return [moment.voltage(line), *moment.circuit_rates(line)]

    def flow(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> tuple[list[Any], list[list[Any]]]:
        """Rates of change, and their Jacobian [i][j], the derivative of rate i by state j.

        In a planar system the Jacobian shares the film's division with the rates; else the rates are differentiated. In
        a graph it is that of deviations with the film's charge in place of its voltage (see `charged`). By NumPy each
        is taken with the switches of its place.
        """
        rates, slope = self._moment(tau, z, self._switched(tau, z, n, xp), xp).rates_and_slope()
        if self.planar:
            return rates, [[0.0, 1.0], [slope, -2.0 * n["damping_ratio"]]]
        if not traced(xp):
            return rates, [row[1:] for row in self.rates_and_slopes(tau, z, n)[1]]
        deviations, charges = self.deviating(tau, z, n, xp)
        slopes = jacobian(deviations, z)
        for index, charge in charges.items():
            by = [derivatives([charge], leaf)[0] for leaf in z]
            for row in slopes:
                share = row[index] / by[index]
                row[:] = [share if j == index else slope - share * by[j] for j, slope in enumerate(row)]
        return rates, slopes

    @cached_property
    def charged(self) -> dict[int, Line]:
        """Index of a state -> the line whose films have that state as their voltage.

        Where a film's law changes, the rate of its voltage jumps, but not that of its charge. Deviations are therefore
        continuous in the charge, which programs use in place of the voltage.
        """
        return {self.places_of(line)[-1]: line for line in self.lines if line.circuit.carries_voltage}

    def deviating(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Graph) -> tuple[list[Node], dict[int, Node]]:
        """Rates of change in a graph, with charges in place of `charged` voltages; and these charges by state index."""
        moment = self._moment(tau, z, n, xp)
        rates, charges = [xp.node(rate) for rate in moment.rates()], {}
        for place, line in self.charged.items():
            rates[place] = xp.node(moment.charging(line))
            charges[place] = xp.node(moment.port(line).charge(z[place]))
        return rates, charges

    def charges_by(self, tau: Any, z: Sequence[Any], n: Numbers, names: Sequence[str] = ()) -> dict[int, list[Any]]:
        """Derivatives of the charges of `charged` lines by all states, or by the numbers ``names``; by state index."""
        return {place: self._values(_charge_slopes, tau, z, n, place, tuple(names)) for place in self.charged}

    def rates_and_slopes(
        self, tau: Any, z: Sequence[Any], n: Numbers, switches: Numbers | None = None
    ) -> tuple[list[Any], list[list[Any]]]:
        """Rates of change, and their derivatives [i][j] by time (j = 0) and by state j - 1, of numbers or arrays.

        ``switches`` replace those that the states have.
        """
        flat, size = self._values(_rates_and_slopes, tau, z, n, switches=switches), 2 + len(self.states)
        rows = [flat[begin : begin + size] for begin in range(0, len(flat), size)]
        return [row[0] for row in rows], [row[1:] for row in rows]

    def _values(
        self, formulas: _Formulas, tau: Any, z: Sequence[Any], n: Numbers, *more: Any, switches: Numbers | None = None
    ) -> list[Any]:
        """Values of ``formulas``, as for `_traced`, along motions, of numbers or arrays."""
        leaves, nodes = _traced(self, formulas, *more)
        values = {**n, **self.switches(tau, z, n), **(switches or {})}
        known = {leaves[name].index: values[name] for name in self.numbers}
        known |= {leaf.index: at for leaf, at in zip(leaves.values(), (tau, *z), strict=False)}
        with np.errstate(all="ignore"):
            return evaluated(nodes, known)

    # --- borders -----------------------------------------------------------------------------------------------------

    @cached_property
    def borders(self) -> tuple[tuple[int | None, Border], ...]:
        """All borders with the index of their film; those of circuits follow, with None. The value of each is
        ``value(tau, z, n, xp)``."""
        borders: list[tuple[int | None, Border]] = []
        for k, film in enumerate(self.films):
            carried = self.film_lines[k].circuit.carries_voltage
            film_borders = [border for border in film.borders if not (border.folds and carried)]
            borders += [(k, replace(border, value=partial(self._film_value, k, border))) for border in film_borders]
        for line in self.lines:
            for border in line.circuit.borders:
                value = partial(self._line_value, line, border)
                borders.append((None, replace(border, value=value, switch=line.prefix + str(border.switch))))
            for index, k in enumerate(line.films):
                if line.circuit.carries_voltage and self.films[k].film.folds:
                    borders.append((k, Border(partial(self._fold_value, line, index), seldom=True)))
        return tuple(borders)

    def _film_value(self, k: int, border: Border, tau: Any, z: Sequence[Any], n: Numbers, xp: Any) -> Any:
        squared = self._moment(tau, z, n, xp).squared(k)
        return border.value(z[0], squared, self.states_of(z, "film", k), n, xp)

    def _line_value(self, line: Line, border: Border, tau: Any, z: Sequence[Any], n: Numbers, xp: Any) -> Any:
        port = self._moment(tau, z, n, xp).port(line)
        return border.value(port, self.states_of(z, "line", line.prefix), line.own(n), xp)

    def _fold_value(self, line: Line, place: int, tau: Any, z: Sequence[Any], n: Numbers, xp: Any) -> Any:
        """Border value at the end of the minimum of a film's energy, by its index in the line. Behind a resistance the
        charge passes that end, while the voltage turns back there without a crossing."""
        moment = self._moment(tau, z, n, xp)
        port = moment.port(line)
        return 1.0 / replace(port, films=(port.films[place],)).slope(moment.voltage(line)) - FOLDED

    def switches(self, tau: Any, z: Sequence[Any], n: Numbers) -> dict[str, Any]:
        """The switches of the borders, and the numbers of the waveform's piece, at time and states."""
        return self._moment(tau, z, n, np).switches() | self.waveform.switches(tau, n)

    # --- powers ------------------------------------------------------------------------------------------------------

    @cached_property
    def causes(self) -> tuple[str, ...]:
        """The causes of `powers`, in order: ``"motion"``, of film and field on the disc; ``"damper"``, of the disc's
        damping; ``"film"``, of films that dissipate; where programs know the charge of all films ``"source"``, and the
        losses of its circuit, ``"resistor"``, ``"leak"`` and ``"dielectric"``.

        The source is left out behind a circuit without losses if programs take a charge from a fit, or if no film
        dissipates and a charge is not proportional to the voltage: the current of a crumpled film is unbounded as it
        pulls in, while its energy is not.
        """
        lossy = any(film.film.dissipates for film in self.films)
        losses = self.circuit.losses
        simple = all(film.film.linear_charge for film in self.films)
        film_losses = ["film"] if lossy else []
        fitted = any(film.film.fitted_charge for film in self.films)
        exact = not fitted and (simple or lossy)
        if not all(film.film.traced_charge for film in self.films) or not (exact or losses):
            return ("motion", "damper", *film_losses)
        return ("motion", "damper", *film_losses, "source", *losses)

    @property
    def bounding_powers(self) -> int:
        """Number of the first `causes` that bound the length of steps: the dissipation of a film may have poles that
        motions do not have, as with linear flow at an elastic stretch of 0."""
        return 3 if "film" in self.causes else 2

    def powers(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> tuple[Any, ...]:
        """The power by each of the `causes`; the first two alone where ``xp`` is neither NumPy nor a graph."""
        powers = self._moment(tau, z, n, xp).mechanical_powers()
        if len(self.causes) == len(powers) or not (traced(xp) or xp is np):
            return powers
        if traced(xp):
            return (*powers, *self._moment(tau, z, n, xp).electric_powers(xp.time, z, self.causes[2:]))
        return (*powers, *self._values(_electric_powers, tau, z, n))

    # --- the forcing -------------------------------------------------------------------------------------------------

    def forcing_period(self, n: Numbers) -> Array:
        """Smallest period of the forcing: that of the voltage if a circuit has states or borders, else that of its
        square. `InputError` for a drive that does not repeat."""
        self.waveform.check_repeats()
        whole = self.circuit.states or self.circuit.borders
        return self.waveform.period(n) if whole else self.waveform.forcing_period(n)


_Formulas = Callable[..., Sequence[Any]]
"""Formulas of a system, its time, states and numbers, the graph and further arguments."""


@lru_cache(maxsize=256)
def _traced(system: ConeSystem, formulas: _Formulas, *more: Any) -> tuple[dict[str, Node], list[Node]]:
    """The leaves of a graph by name, time and states first, and the nodes of ``formulas``."""
    graph = Graph()
    z = [graph.state(i) for i in range(len(system.states))]
    n = {name: graph.switch(name) for name in system.numbers}
    leaves = {"time": graph.time} | {f"state {i}": leaf for i, leaf in enumerate(z)} | n
    return leaves, [graph.node(value) for value in formulas(system, graph.time, z, n, graph, *more)]


def _rates_and_slopes(system: ConeSystem, time: Node, z: list[Node], n: dict[str, Node], graph: Graph) -> list[Node]:
    """Each rate followed by its derivatives by time and states."""
    rates = [graph.node(rate) for rate in system.rates(time, z, n, graph)]
    return [node for rate, row in zip(rates, jacobian(rates, [time, *z]), strict=True) for node in (rate, *row)]


def _charge_slopes(
    system: ConeSystem, time: Node, z: list[Node], n: dict[str, Node], graph: Graph, place: int, names: tuple[str, ...]
) -> list[Node]:
    """The derivatives of a charge for `ConeSystem.charges_by`."""
    charge = system.deviating(time, z, n, graph)[1][place]
    return [derivatives([charge], leaf)[0] for leaf in ([n[name] for name in names] or z)]


def _electric_powers(system: ConeSystem, time: Node, z: list[Node], n: dict[str, Node], graph: Graph) -> Sequence[Any]:
    """The powers after the first two."""
    return system.powers(time, z, n, graph)[2:]


def _total_rates(
    system: ConeSystem, time: Node, z: list[Node], n: dict[str, Node], graph: Graph, values: _Formulas
) -> list[Node]:
    """The rates of change of ``values`` along the motion."""
    rates = system.rates(time, z, n, graph)
    return [total_rate(system, graph.node(value), time, z, rates) for value in values(system, time, z, n, graph)]


def _charges(system: ConeSystem, time: Node, z: list[Node], n: dict[str, Node], graph: Graph) -> list[Any]:
    """The charges of the films whose charge programs know."""
    return [
        system.stored(time, z, n, graph)
        if system.circuit.delays
        else voltage * film.capacitance(z[0], voltage * voltage, system.states_of(z, "film", k), n, graph)
        for k, (film, voltage) in enumerate(zip(system.films, system.voltages(time, z, n, graph), strict=True))
        if film.film.traced_charge
    ]
