"""The equation of motion, put together from its components: what is compiled, apart from the numbers.

The disc obeys x'' = -2 zeta x' - sum of F_film(x, V) - F_bias(x), with V the square of each film's voltage, which a
circuit makes of the waveform's. Components may add states of their own behind displacement and velocity.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial, reduce
from typing import Any

import numpy as np

from gelcone.errors import InputError
from gelcone.physics.circuit import IdealSource, Port
from gelcone.physics.component import Numbers
from gelcone.physics.differentiate import derivatives, evaluated, jacobian
from gelcone.physics.film.film import Border
from gelcone.physics.implicit import traced
from gelcone.physics.moment import Moment, total_rate
from gelcone.physics.structure import DISC, Line, Structure
from gelcone.physics.trace import Graph, Node, ordered
from gelcone.quantity import Array

BIAS_SHARE = "bias share"
"""Among the numbers of statics: the share of the first film's voltage that the bias of a drive takes, where it rises
with it; else the bias is the model's own."""
FOLDED = 1e-7
"""The flat film's capacitance over dQ/dv at which a minimum counts as ended: some 1e-6 before, when steps still lead
there."""
_IDEAL = IdealSource()


@dataclass(frozen=True)
class ConeSystem(Structure):
    """A disc on one film, or between two (a double cone), with a bias, under a waveform through a circuit."""

    @cached_property
    def planar(self) -> bool:
        """Whether displacement and velocity are all there is, and no voltage follows them, as it does where the charge
        is commanded. Areas then shrink by exp(-2 zeta tau)."""
        drags = any(film.drags for film in self.films)
        return len(self.states) == len(DISC) and not drags and not self._voltages_follow_the_disc

    @property
    def _voltages_follow_the_disc(self) -> bool:
        """Whether a voltage is a formula of the states."""
        if all(line.circuit == _IDEAL for line in self.lines):
            return False
        graph, _, time, z, n = _leaves(self)
        try:
            voltages = [graph.node(voltage) for voltage in self.voltages(time, z, n, graph)]
        except InputError:  # of a film whose charge no program knows: it has statics alone
            return False
        return any(node.operation == "state" for node in ordered(voltages))

    # --- voltages ----------------------------------------------------------------------------------------------------

    def voltages(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Voltage on each film."""
        moment = self._moment(tau, z, n, xp)
        return [moment.voltage(self.line_of(k)) for k in range(len(self.films))]

    def squares(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """The squared voltages with which the fields pull on the films."""
        moment = self._moment(tau, z, n, xp)
        return [moment.squared(k) for k in range(len(self.films))]

    def squared_at(self, voltage: Any, z: Sequence[Any], n: Numbers) -> Any:
        """The first of them where that film has a voltage."""
        moment, line = Moment(self, voltage, lambda: 0.0, z, n, np), self.lines[0]
        return line.circuit.squared(moment.port(line), voltage, self.states_of(z, "line", line.prefix), line.own(n))

    def stored(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> Any:
        """Charge on the films of the first line."""
        return self._moment(tau, z, n, xp).stored(self.lines[0])

    def voltage_rates(self, tau: Any, z: Sequence[Any], n: Numbers) -> list[Any]:
        """Their rates of change along a motion, of numbers or arrays."""
        if all(line.circuit == _IDEAL for line in self.lines):
            change = self.waveform.voltage_rate(tau, n)
            signs = {"opposite": -1.0, "constant": 0.0}
            return [signs[str(f.drive)] * change if str(f.drive) in signs else change for f in self.films]
        leaves, nodes = _voltage_rates_of(self, False)
        return self._values(leaves, nodes, tau, z, n)

    def currents(self, tau: Any, z: Sequence[Any], n: Numbers) -> list[Any]:
        """Currents into the films along a motion, of numbers or arrays: the rates of their charges, and their leaks."""
        leaks = self._moment(tau, z, n, np).leaks()
        return [
            rate + leak if np.any(leak) else rate for rate, leak in zip(self._chargings(tau, z, n), leaks, strict=True)
        ]

    def source_voltages(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Voltage of the source that drives each film."""
        moment = self._moment(tau, z, n, xp)
        return [moment.source_voltage(self.line_of(k)) for k in range(len(self.films))]

    def source_charges(self, tau: Any, z: Sequence[Any], n: Numbers) -> list[Any]:
        """Charge on the films of each line, which its source has to deliver."""
        moment = self._moment(tau, z, n, np)
        return [moment.stored(line) for line in self.lines]

    def source_rates(self, tau: Any, z: Sequence[Any], n: Numbers) -> list[Any]:
        """Rates of change of these voltages."""
        if all(line.circuit == _IDEAL for line in self.lines):
            return self.voltage_rates(tau, z, n)
        leaves, nodes = _voltage_rates_of(self, True)
        return self._values(leaves, nodes, tau, z, n)

    def saturations(self, line: Line, tau: Any, z: Sequence[Any], n: Numbers) -> Mapping[str, Any]:
        """By the limits of a line's circuit the excess over each that it does not allow."""
        moment = self._moment(tau, z, n, np)
        return line.circuit.saturations(moment.port(line), self.states_of(z, "line", line.prefix), line.own(moment.n))

    def _chargings(self, tau: Any, z: Sequence[Any], n: Numbers) -> list[Any]:
        """Rates of change of the films' charges."""
        leaves, nodes = _currents_of(self)
        found = iter(self._values(leaves, nodes, tau, z, n))
        moving = zip(self.films, self.voltages(tau, z, n), self.voltage_rates(tau, z, n), strict=True)
        return [
            next(found) if film.film.traced_charge else film.current(z[0], z[1], voltage, rate, n)
            for film, voltage, rate in moving
        ]

    def _moment(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any) -> Moment:
        return Moment(self, self.waveform.voltage(tau, n, xp), lambda: self.waveform.voltage_rate(tau, n, xp), z, n, xp)

    # --- the equation of motion --------------------------------------------------------------------------------------

    def rates(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of the states."""
        return self._moment(tau, z, n, xp).rates_and_slope()[0]

    def rates_under(self, commanded: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of the states under a constant commanded voltage."""
        return Moment(self, commanded, lambda: 0.0, z, n, xp).rates_and_slope()[0]

    @cached_property
    def mechanical(self) -> list[int]:
        """The places of the states that are not those of a circuit."""
        own = [place for owner, place in self._places.items() if owner[0] != "line"]
        return [*range(len(DISC)), *(i for place in own for i in range(place.start, place.stop))]

    def rates_held(self, squares: Sequence[Any], z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of the `mechanical` states while the films have these squared voltages."""
        return Moment(self, 0.0, lambda: 0.0, z, n, xp, squares).rates_and_slope(circuits=False)[0]

    def electric(
        self, line: Line, command: Any, command_rate: Any, z: Sequence[Any], n: Numbers, xp: Any = np
    ) -> list[Any]:
        """The voltage of a line, and the rates of change of its circuit's states, at a command of the first line."""
        moment = Moment(self, command, lambda: command_rate, z, n, xp)
        return [moment.voltage(line), *moment.circuit_rates(line)]

    def stored_under(self, commanded: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> Any:
        """Charge on the films of the first line under a constant commanded voltage."""
        return Moment(self, commanded, lambda: 0.0, z, n, xp).stored(self.lines[0])

    def leaks_under(self, commanded: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Current that leaks through each film under a constant commanded voltage."""
        return Moment(self, commanded, lambda: 0.0, z, n, xp).leaks()

    def flow(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> tuple[list[Any], list[list[Any]]]:
        """Rates of change, and their Jacobian [i][j]: the rate of state i by state j.

        Of a planar system the Jacobian shares the film's division with the rates; else the rates are differentiated.
        In a graph it is that of deviations which have the film's charge in place of a voltage (see `charged`).
        """
        rates, slope = self._moment(tau, z, n, xp).rates_and_slope()
        if self.planar:
            return rates, [[0.0, 1.0], [slope, -2.0 * n["damping_ratio"]]]
        if not traced(xp):
            return rates, [row[1:] for row in self.rates_and_slopes(tau, z, n)[1]]
        own, charges = self.deviating(tau, z, n, xp)
        slopes = jacobian(own, z)
        for place, charge in charges.items():
            by = [derivatives([charge], leaf)[0] for leaf in z]
            for row in slopes:
                share = row[place] / by[place]
                row[:] = [share if j == place else slope - share * by[j] for j, slope in enumerate(row)]
        return rates, slopes

    @cached_property
    def charged(self) -> dict[int, Line]:
        """The circuits of which a state is the voltage on their films, by its place.

        Where a film's law changes, so does the rate of its voltage, but not that of its charge: deviations jump in the
        one and are continuous in the other, which programs carry in its place.
        """
        return {self.places_of(line)[-1]: line for line in self.lines if line.circuit.carries_voltage}

    def deviating(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Graph) -> tuple[list[Node], dict[int, Node]]:
        """Rates of change in a graph, of charges in place of `charged` voltages; and these charges, by their places."""
        moment = self._moment(tau, z, n, xp)
        rates, charges = [xp.node(rate) for rate in moment.rates_and_slope()[0]], {}
        for place, line in self.charged.items():
            rates[place] = xp.node(moment.charging(line))
            charges[place] = xp.node(moment.port(line).charge(z[place]))
        return rates, charges

    def charges_by(self, tau: Any, z: Sequence[Any], n: Numbers, names: Sequence[str] = ()) -> dict[int, list[Any]]:
        """Derivatives of the charges of `charged` circuits by all states, or by numbers of some ``names``."""
        found = {}
        for place in self.charged:
            leaves, slopes = _charge_slopes_of(self, place, tuple(names))
            found[place] = self._values(leaves, slopes, tau, z, n)
        return found

    def rates_and_slopes(self, tau: Any, z: Sequence[Any], n: Numbers) -> tuple[list[Any], list[list[Any]]]:
        """Rates of change, and derivatives [i][j] of that of state i, by time (j = 0) or by state j - 1, of numbers or
        arrays."""
        leaves, rows = _rates_and_slopes_of(self)
        flat, size = self._values(leaves, [node for row in rows for node in row], tau, z, n), len(rows[0])
        found = [flat[i * size : (i + 1) * size] for i in range(len(rows))]
        return [row[0] for row in found], [row[1:] for row in found]

    def _values(
        self, leaves: Mapping[str, Node], nodes: Sequence[Node], tau: Any, z: Sequence[Any], n: Numbers
    ) -> list[Any]:
        """Values of traced formulas along motions; ``leaves`` as `_leaves` gives them."""
        values = {**n, **self.switches(tau, z, n)}
        known = {leaves[name].index: values[name] for name in self.numbers}
        known |= {leaf.index: at for leaf, at in zip(leaves.values(), (tau, *z), strict=False)}
        with np.errstate(all="ignore"):
            return evaluated(nodes, known)

    # --- borders -----------------------------------------------------------------------------------------------------

    @cached_property
    def borders(self) -> tuple[tuple[int | None, Border], ...]:
        """All borders: those of the films by their places, then those of the circuits (None). The value of each is
        ``value(tau, z, n, xp)``."""
        found: list[tuple[int | None, Border]] = []
        for k, film in enumerate(self.films):
            carried = self.line_of(k).circuit.carries_voltage
            own = [border for border in film.borders if not (border.folds and carried)]
            found += [(k, replace(border, value=partial(self._film_value, k, border))) for border in own]
        for line in self.lines:
            for border in line.circuit.borders:
                value = partial(self._line_value, line, border)
                found.append((None, replace(border, value=value, switch=line.prefix + str(border.switch))))
            for place, k in enumerate(line.films):
                if line.circuit.carries_voltage and self.films[k].film.folds:
                    found.append((k, Border(partial(self._fold_value, line, place), seldom=True)))
        return tuple(found)

    def _film_value(self, k: int, border: Border, tau: Any, z: Sequence[Any], n: Numbers, xp: Any) -> Any:
        squared = self._moment(tau, z, n, xp).squared(k)
        return border.value(z[0], squared, self.states_of(z, "film", k), n, xp)

    def _line_value(self, line: Line, border: Border, tau: Any, z: Sequence[Any], n: Numbers, xp: Any) -> Any:
        port = self._moment(tau, z, n, xp).port(line)
        return border.value(port, self.states_of(z, "line", line.prefix), line.own(n), xp)

    def _fold_value(self, line: Line, place: int, tau: Any, z: Sequence[Any], n: Numbers, xp: Any) -> Any:
        """Where the minimum of the energy of a film, by its place in the line, ends at its voltage. Behind a resistance
        its charge passes that end, while the voltage turns there and crosses nothing."""
        moment = self._moment(tau, z, n, xp)
        port = moment.port(line)
        return 1.0 / replace(port, films=(port.films[place],)).slope(moment.voltage(line)) - FOLDED

    def switches(self, tau: Any, z: Sequence[Any], n: Numbers) -> dict[str, Any]:
        """The numbers that borders and corners switch, as time and states give them."""
        return self._moment(tau, z, n, np).switches() | self.waveform.switches(tau, n)

    def switches_under(self, commanded: Any, z: Sequence[Any], n: Numbers) -> dict[str, Any]:
        """Those of the borders, under a constant commanded voltage."""
        return Moment(self, commanded, lambda: 0.0, z, n, np).switches()

    # --- powers ------------------------------------------------------------------------------------------------------

    @cached_property
    def causes(self) -> tuple[str, ...]:
        """The powers of `powers`, in this order: ``"motion"``, what film and field give the disc; ``"damper"``, what
        the disc's damping takes; ``"film"``, what films lose that do; where the charge of all films is known in a
        program, the ``"source"``; and with it what the circuit loses, ``"resistor"``, ``"leak"`` and ``"dielectric"``.

        The source is left out where the circuit loses nothing and a charge is known by a fit alone, or not proportional
        to the voltage while all that the source gives moves the disc or is stored: the current of a crumpled film grows
        beyond all bounds as it pulls in, and the first law does not.
        """
        lossy = any(film.film.dissipates for film in self.films)
        losses = self.circuit.losses
        simple = all(film.film.linear_charge for film in self.films)
        own = ["film"] if lossy else []
        fitted = any(film.film.fitted_charge for film in self.films)
        exact = not fitted and (simple or lossy)
        if not all(film.film.traced_charge for film in self.films) or not (exact or losses):
            return ("motion", "damper", *own)
        return ("motion", "damper", *own, "source", *losses)

    @property
    def bounding_powers(self) -> int:
        """Number of the first of them that bear on the length of steps: what a film loses may have poles that motions
        do not have, as with linear flow where an elastic stretch is 0."""
        return 3 if "film" in self.causes else 2

    def powers(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> tuple[Any, ...]:
        """The power by each of its `causes`; of functions of neither arrays nor a graph, the first two."""
        found = self._moment(tau, z, n, xp).mechanical_powers()
        if len(self.causes) == len(found) or not (traced(xp) or xp is np):
            return found
        if traced(xp):
            return (*found, *self._moment(tau, z, n, xp).electric_powers(xp.time, z, self.causes[2:]))
        leaves, nodes = _powers_of(self)
        return (*found, *self._values(leaves, nodes, tau, z, n))

    # --- at rest -----------------------------------------------------------------------------------------------------

    def forcing_period(self, n: Numbers) -> Array:
        """Smallest period of what drives the motion; that of the voltage where a circuit has states or borders;
        `InputError` for a drive that does not repeat."""
        self.waveform.check_repeats()
        whole = self.circuit.states or self.circuit.borders
        return self.waveform.period(n) if whole else self.waveform.forcing_period(n)

    def static_force(self, x: Any, squared: Any, n: Numbers) -> tuple[Any, Any]:
        """Force of films and bias at a constant squared voltage on the first film, and its slope."""
        return self.force_under(x, self.squares_at_rest(squared, n), n)

    def force_under(self, x: Any, squares: Sequence[Any], n: Numbers) -> tuple[Any, Any]:
        """The static force, and its slope, at constant squared voltages on the films."""
        first, *others = ((film, squared) for film, squared in zip(self.films, squares, strict=True))
        force, slope = first[0].force(x, first[1], [], n)
        bias, bias_slope = self.bias.force(x, [], n)
        force, slope = force + bias, slope + bias_slope
        for film, squared in others:
            more, steeper = film.force(x, squared, [], n)
            force, slope = force + more, slope + steeper
        return force, slope

    def squares_at_rest(self, squared: Any, n: Numbers) -> list[Any]:
        """Squared voltage on each film while a constant command puts a squared voltage on the first."""

        def on(drive: str | None) -> Any:
            if drive == "constant":
                return n["second_voltage"] * n["second_voltage"] + 0.0 * squared
            if drive == "opposite":
                first = np.sqrt(squared)
                voltage = self._twice_bias(first, n) - first
                return voltage * voltage
            return squared

        return [on(film.drive) for film in self.films]

    def square_rates_at_rest(self, voltage: float, n: Numbers) -> list[float]:
        """Derivatives of `squares_at_rest` by the voltage on the first film."""
        opposite = 2.0 * (self._twice_bias(voltage, n) - voltage) * (2.0 * n.get(BIAS_SHARE, 0.0) - 1.0)
        slopes = {"constant": 0.0, "opposite": float(opposite)}
        return [slopes.get(str(film.drive), 2.0 * voltage) for film in self.films]

    def leaking_at_rest(self, x: Any, voltages: Sequence[Any], n: Numbers) -> list[Any]:
        """Power that leaks through each film at displacements at rest and constant voltages on the films."""
        found: dict[int, Any] = {}
        for line in self.lines:
            voltage = voltages[line.films[0]]
            port = Port(voltage, x, 0.0, lambda: 0.0, tuple((self.films[k], []) for k in line.films), n, np)
            leaks = line.circuit.held.leaks(port, [], n)
            found |= {k: voltage * leak for k, leak in zip(line.films, leaks, strict=True)}
        return [found[k] for k in range(len(self.films))]

    def _twice_bias(self, first: Any, n: Numbers) -> Any:
        """The sum of both films' voltages at rest in opposite phase, where the ``first``'s is not negative."""
        if BIAS_SHARE in n:
            return 2.0 * n[BIAS_SHARE] * first
        return 2.0 * np.abs(n["voltage_bias"] * np.real(self.circuit.gain(0.0, n)))

    # --- where the films have a state --------------------------------------------------------------------------------

    def pulled_in(self, x: Any, squared: Any, n: Numbers) -> Any:
        """Whether a film has pulled in where the disc is held at x, at a constant squared voltage on the first."""
        found = False
        for film, own in zip(self.films, self.squares_at_rest(squared, n), strict=True):
            found = found | (own > film.highest_squared(x, n))
        return found

    def strain(self, x: Any, n: Numbers) -> Any:
        """The film's measure of strain; of several films the largest share of their limits, or the largest measure
        where none has one."""
        strains = [film.strain(x, n) for film in self.films]
        if len(strains) == 1:
            return strains[0]
        limits = [film.strain_limit(n) for film in self.films]
        shares = [strain / limit for strain, limit in zip(strains, limits, strict=True)]
        endless = reduce(np.logical_and, map(np.isinf, limits))
        return np.where(endless, reduce(np.maximum, strains), reduce(np.maximum, shares))[()]

    def overstretched(self, z: Sequence[Any], n: Numbers) -> Any:
        """Whether the own states of a film are beyond a limit of theirs."""
        found = [film.overstretched(z[0], self.states_of(z, "film", k), n) for k, film in enumerate(self.films)]
        return reduce(np.logical_or, found)

    def strain_limit(self, n: Numbers) -> Any:
        """The limit that `strain` cannot reach."""
        limits = [film.strain_limit(n) for film in self.films]
        if len(limits) == 1:
            return limits[0]
        return np.where(reduce(np.logical_and, map(np.isinf, limits)), np.inf, 1.0)[()]

    def outside(self, x: float, n: Numbers) -> str:
        """Why there is no state at a start, in words, with the remedy; of one actuator."""
        lost = [film for film in self.films if not film.strain(x, n) < film.strain_limit(n)]
        return (lost or self.films)[0].outside(x, n)

    def unreachable(self, n: Numbers) -> str:
        """Why there is no state at any displacement, in words, with the remedy; of one actuator."""
        lost = [film for film in self.films if np.isnan(film.reach(n)[2])]
        if lost or len(self.films) == 1:
            return (lost or self.films)[0].unreachable(n)
        return (
            f"second_flat_height = {float(n['second_flat_height']):g}: so far from 0 that no displacement lies inside "
            "the stretch limits of both films; bring it closer to 0 or raise the limits"
        )


def _leaves(system: ConeSystem) -> tuple[Graph, dict[str, Node], Node, list[Node], dict[str, Node]]:
    """A graph; its leaves by name, time and states first; time, states and numbers."""
    graph = Graph()
    z = [graph.state(i) for i in range(len(system.states))]
    n = {name: graph.switch(name) for name in system.numbers}
    return graph, {"time": graph.time} | {f"state {i}": leaf for i, leaf in enumerate(z)} | n, graph.time, z, n


@lru_cache(maxsize=64)
def _rates_and_slopes_of(system: ConeSystem) -> tuple[dict[str, Node], list[list[Node]]]:
    """The leaves of a graph, and in it each rate in front of its slopes."""
    graph, leaves, time, z, n = _leaves(system)
    rates = [graph.node(rate) for rate in system.rates(time, z, n, graph)]
    return leaves, [[rate, *row] for rate, row in zip(rates, jacobian(rates, [time, *z]), strict=True)]


@lru_cache(maxsize=64)
def _charge_slopes_of(system: ConeSystem, place: int, names: tuple[str, ...]) -> tuple[dict[str, Node], list[Node]]:
    """The leaves of a graph, and in it the derivatives of a charge that `ConeSystem.charges_by` gives."""
    graph, leaves, time, z, n = _leaves(system)
    charge = system.deviating(time, z, n, graph)[1][place]
    return leaves, [derivatives([charge], leaf)[0] for leaf in ([n[name] for name in names] or z)]


@lru_cache(maxsize=64)
def _powers_of(system: ConeSystem) -> tuple[dict[str, Node], list[Node]]:
    """The leaves of a graph, and in it the powers that only a graph gives."""
    graph, leaves, time, z, n = _leaves(system)
    return leaves, [graph.node(power) for power in system.powers(time, z, n, graph)[2:]]


@lru_cache(maxsize=64)
def _voltage_rates_of(system: ConeSystem, of_sources: bool) -> tuple[dict[str, Node], list[Node]]:
    """The leaves of a graph, and in it the rates of the voltages of films, or of sources."""
    graph, leaves, time, z, n = _leaves(system)
    rates = system.rates(time, z, n, graph)
    voltages = (system.source_voltages if of_sources else system.voltages)(time, z, n, graph)
    return leaves, [total_rate(system, graph.node(v), time, z, rates) for v in voltages]


@lru_cache(maxsize=64)
def _currents_of(system: ConeSystem) -> tuple[dict[str, Node], list[Node]]:
    """The leaves of a graph, and in it the currents of the films whose charge it knows."""
    graph, leaves, time, z, n = _leaves(system)
    rates, voltages = system.rates(time, z, n, graph), system.voltages(time, z, n, graph)
    charges = [
        system.stored(time, z, n, graph)
        if system.circuit.delays
        else voltage * film.capacitance(z[0], voltage * voltage, system.states_of(z, "film", k), n, graph)
        for k, (film, voltage) in enumerate(zip(system.films, voltages, strict=True))
        if film.film.traced_charge
    ]
    return leaves, [total_rate(system, graph.node(charge), time, z, rates) for charge in charges]
