"""The equation of motion of components, independent of their numbers; programs are compiled from it.

The disc obeys x'' = -2 zeta x' - sum of F_film(x, V) - F_bias(x), with the squared voltage V of each film, which a
circuit makes from the waveform. Components may add states after displacement and velocity.
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
"""Number of statics: the bias of the drive over the voltage of the first film, where the bias rises with it; without
this number the bias is that of the model."""
FOLDED = 1e-7
"""The flat film's capacitance over dQ/dv at which a minimum counts as ended, some 1e-6 before its end."""
_IDEAL = IdealSource()


@dataclass(frozen=True)
class ConeSystem(Structure):
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
        if all(line.circuit == _IDEAL for line in self.lines):
            return False
        graph, _, time, z, n = _leaves(self)
        try:
            voltages = [graph.node(voltage) for voltage in self.voltages(time, z, n, graph)]
        except InputError:  # programs do not know the film's charge, so that it has statics alone
            return False
        return any(node.operation == "state" for node in ordered(voltages))

    # --- voltages ----------------------------------------------------------------------------------------------------

    def voltages(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Voltage on each film."""
        moment = self._moment(tau, z, n, xp)
        return [moment.voltage(self.line_of(k)) for k in range(len(self.films))]

    def commands(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Commanded voltage of each film."""
        moment = self._moment(tau, z, n, xp)
        return [moment.port(self.line_of(k)).command for k in range(len(self.films))]

    def squares(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """The effective squared voltages of the fields' forces on the films."""
        moment = self._moment(tau, z, n, xp)
        return [moment.squared(k) for k in range(len(self.films))]

    def squares_under(self, commanded: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """The effective squared voltages on the films under a constant commanded voltage."""
        moment = Moment(self, commanded, lambda: 0.0, z, n, xp)
        return [moment.squared(k) for k in range(len(self.films))]

    def squared_at(self, voltage: Any, z: Sequence[Any], n: Numbers, film: int = 0) -> Any:
        """The effective squared voltage on a film at a ``voltage``."""
        moment, line = Moment(self, voltage, lambda: 0.0, z, n, np), self.line_of(film)
        return line.circuit.squared(moment.port(line), voltage, self.states_of(z, "line", line.prefix), line.own(n))

    def stored(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> Any:
        """Charge on the films of the first line."""
        return self._moment(tau, z, n, xp).stored(self.lines[0])

    def voltage_rates(self, tau: Any, z: Sequence[Any], n: Numbers) -> list[Any]:
        """Rates of change of the voltages on the films along a motion, of numbers or arrays."""
        if all(line.circuit == _IDEAL for line in self.lines):
            change = self.waveform.voltage_rate(tau, n)
            return [self.command_slope(self.line_of(k)) * change for k in range(len(self.films))]
        leaves, nodes = _voltage_rates_of(self, False)
        return self._values(leaves, nodes, tau, z, n)

    def currents(self, tau: Any, z: Sequence[Any], n: Numbers) -> list[Any]:
        """Currents into the films along a motion, of numbers or arrays: the rates of their charges, and their leaks."""
        leaks = self.leaks(tau, z, n)
        return [
            rate + leak if np.any(leak) else rate for rate, leak in zip(self._chargings(tau, z, n), leaks, strict=True)
        ]

    def leaks(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Current that leaks through each film."""
        return self._moment(tau, z, n, xp).leaks()

    def source_voltages(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Voltage of the source that drives each film."""
        moment = self._moment(tau, z, n, xp)
        return [moment.source_voltage(self.line_of(k)) for k in range(len(self.films))]

    def source_charges(self, tau: Any, z: Sequence[Any], n: Numbers) -> list[Any]:
        """Charge on the films of each line, delivered by its source."""
        moment = self._moment(tau, z, n, np)
        return [moment.stored(line) for line in self.lines]

    def source_rates(self, tau: Any, z: Sequence[Any], n: Numbers) -> list[Any]:
        """Rates of change of `source_voltages`."""
        if all(line.circuit == _IDEAL for line in self.lines):
            return self.voltage_rates(tau, z, n)
        leaves, nodes = _voltage_rates_of(self, True)
        return self._values(leaves, nodes, tau, z, n)

    def saturations(self, line: Line, tau: Any, z: Sequence[Any], n: Numbers) -> Mapping[str, Any]:
        """Name of each limit of a line's circuit -> demand less limit, positive while the circuit is limited."""
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
        """Rates of change of the states; by NumPy each with the switches of its place."""
        return self._moment(tau, z, self._switched(tau, z, n, xp), xp).rates_and_slope()[0]

    def _switched(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any) -> Numbers:
        own = self.switches(tau, z, n) if xp is np else {}
        return {**n, **own} if own else n

    def rates_under(self, commanded: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of the states under a constant commanded voltage."""
        return Moment(self, commanded, lambda: 0.0, z, n, xp).rates_and_slope()[0]

    @cached_property
    def mechanical(self) -> list[int]:
        """The indices of the states that do not belong to a circuit."""
        own = [place for owner, place in self._places.items() if owner[0] != "line"]
        return [*range(len(DISC)), *(i for place in own for i in range(place.start, place.stop))]

    def rates_held(self, squares: Sequence[Any], z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of the `mechanical` states at given squared voltages on the films."""
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
        """Index of a state -> the line whose films have that state as their voltage.

        Where a film's law changes, the rate of its voltage jumps, but not that of its charge. Deviations are therefore
        continuous in the charge, which programs use in place of the voltage.
        """
        return {self.places_of(line)[-1]: line for line in self.lines if line.circuit.carries_voltage}

    def deviating(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Graph) -> tuple[list[Node], dict[int, Node]]:
        """Rates of change in a graph, with charges in place of `charged` voltages; and these charges by state index."""
        moment = self._moment(tau, z, n, xp)
        rates, charges = [xp.node(rate) for rate in moment.rates_and_slope()[0]], {}
        for place, line in self.charged.items():
            rates[place] = xp.node(moment.charging(line))
            charges[place] = xp.node(moment.port(line).charge(z[place]))
        return rates, charges

    def charges_by(self, tau: Any, z: Sequence[Any], n: Numbers, names: Sequence[str] = ()) -> dict[int, list[Any]]:
        """Derivatives of the charges of `charged` lines by all states, or by the numbers ``names``; by state index."""
        found = {}
        for place in self.charged:
            leaves, slopes = _charge_slopes_of(self, place, tuple(names))
            found[place] = self._values(leaves, slopes, tau, z, n)
        return found

    def rates_and_slopes(
        self, tau: Any, z: Sequence[Any], n: Numbers, switches: Numbers | None = None
    ) -> tuple[list[Any], list[list[Any]]]:
        """Rates of change, and their derivatives [i][j] by time (j = 0) and by state j - 1, of numbers or arrays.

        ``switches`` replace those that the states have.
        """
        leaves, rows = _rates_and_slopes_of(self)
        nodes, size = [node for row in rows for node in row], len(rows[0])
        flat = self._values(leaves, nodes, tau, z, n, switches)
        found = [flat[i * size : (i + 1) * size] for i in range(len(rows))]
        return [row[0] for row in found], [row[1:] for row in found]

    def _values(
        self,
        leaves: Mapping[str, Node],
        nodes: Sequence[Node],
        tau: Any,
        z: Sequence[Any],
        n: Numbers,
        switches: Numbers | None = None,
    ) -> list[Any]:
        """Values of traced formulas along motions, with the ``leaves`` of `_leaves`."""
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
        """Border value at the end of the minimum of a film's energy, by its index in the line. Behind a resistance the
        charge passes that end, while the voltage turns back there without a crossing."""
        moment = self._moment(tau, z, n, xp)
        port = moment.port(line)
        return 1.0 / replace(port, films=(port.films[place],)).slope(moment.voltage(line)) - FOLDED

    def switches(self, tau: Any, z: Sequence[Any], n: Numbers) -> dict[str, Any]:
        """The switches of the borders, and the numbers of the waveform's piece, at time and states."""
        return self._moment(tau, z, n, np).switches() | self.waveform.switches(tau, n)

    def switches_under(self, commanded: Any, z: Sequence[Any], n: Numbers) -> dict[str, Any]:
        """The switches of the borders, under a constant commanded voltage."""
        return Moment(self, commanded, lambda: 0.0, z, n, np).switches()

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
        own = ["film"] if lossy else []
        fitted = any(film.film.fitted_charge for film in self.films)
        exact = not fitted and (simple or lossy)
        if not all(film.film.traced_charge for film in self.films) or not (exact or losses):
            return ("motion", "damper", *own)
        return ("motion", "damper", *own, "source", *losses)

    @property
    def bounding_powers(self) -> int:
        """Number of the first `causes` that bound the length of steps: the dissipation of a film may have poles that
        motions do not have, as with linear flow at an elastic stretch of 0."""
        return 3 if "film" in self.causes else 2

    def powers(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> tuple[Any, ...]:
        """The power by each of the `causes`; the first two alone where ``xp`` is neither NumPy nor a graph."""
        found = self._moment(tau, z, n, xp).mechanical_powers()
        if len(self.causes) == len(found) or not (traced(xp) or xp is np):
            return found
        if traced(xp):
            return (*found, *self._moment(tau, z, n, xp).electric_powers(xp.time, z, self.causes[2:]))
        leaves, nodes = _powers_of(self)
        return (*found, *self._values(leaves, nodes, tau, z, n))

    # --- at rest -----------------------------------------------------------------------------------------------------

    def forcing_period(self, n: Numbers) -> Array:
        """Smallest period of the forcing: that of the voltage if a circuit has states or borders, else that of its
        square. `InputError` for a drive that does not repeat."""
        self.waveform.check_repeats()
        whole = self.circuit.states or self.circuit.borders
        return self.waveform.period(n) if whole else self.waveform.forcing_period(n)

    def static_force(self, x: Any, squared: Any, n: Numbers) -> tuple[Any, Any]:
        """Force of films and bias at a constant squared voltage on the first film, and its slope by x."""
        return self.force_under(x, self.squares_at_rest(squared, n), n)

    def force_under(self, x: Any, squares: Sequence[Any], n: Numbers) -> tuple[Any, Any]:
        """The static force, and its slope by x, at constant squared voltages on the films."""
        first, *others = ((film, squared) for film, squared in zip(self.films, squares, strict=True))
        force, slope = first[0].force(x, first[1], [], n)
        bias, bias_slope = self.bias.force(x, [], n)
        force, slope = force + bias, slope + bias_slope
        for film, squared in others:
            more, steeper = film.force(x, squared, [], n)
            force, slope = force + more, slope + steeper
        return force, slope

    def squares_at_rest(self, squared: Any, n: Numbers) -> list[Any]:
        """Squared voltage on each film under a constant command, given that on the first."""

        def on(line: Line) -> Any:
            gain = self._gain_at_rest(line, n)
            return (
                squared if line.drive is None else (gain * self.command_at_rest(line, np.sqrt(squared) / gain, n)) ** 2
            )

        return [on(self.line_of(k)) for k in range(len(self.films))]

    def square_rates_at_rest(self, voltage: float, n: Numbers) -> list[float]:
        """Derivatives of `squares_at_rest` by the voltage on the first film."""

        def rate(line: Line) -> float:
            gain = self._gain_at_rest(line, n)
            return 2.0 * float(gain * self.command_at_rest(line, voltage / gain, n) * self.slope_at_rest(line, n))

        return [rate(self.line_of(k)) for k in range(len(self.films))]

    def _gain_at_rest(self, line: Line, n: Numbers) -> Any:
        """The share of the bias that comes through the circuit to films in opposite phase."""
        return np.real(self.circuit.gain(0.0, n)) if line.drive == "opposite" else 1.0

    def leaking_at_rest(self, x: Any, voltages: Sequence[Any], n: Numbers) -> list[Any]:
        """Power that leaks through each film at displacements at rest and constant voltages on the films."""
        found: dict[int, Any] = {}
        for line in self.lines:
            voltage = voltages[line.films[0]]
            port = Port(voltage, x, 0.0, lambda: 0.0, tuple((self.films[k], []) for k in line.films), n, np)
            leaks = line.circuit.held.leaks(port, [], n)
            found |= {k: voltage * leak for k, leak in zip(line.films, leaks, strict=True)}
        return [found[k] for k in range(len(self.films))]

    def command_at_rest(self, line: Line, command: Any, n: Numbers) -> Any:
        """The constant command of a line under one of the first that is not negative: it stands for both signs, as the
        mirror image of all voltages is the same actuator. The bias has its sign, unless a share of it is negative."""
        if line.drive != "opposite":
            return self.command_of(line, command, n)
        bias = n[BIAS_SHARE] * command if BIAS_SHARE in n else np.abs(n["voltage_bias"])
        return 2.0 * bias - command

    def slope_at_rest(self, line: Line, n: Numbers) -> float:
        """The slope of `command_at_rest` by the command of the first line."""
        more = 2.0 * n.get(BIAS_SHARE, 0.0) if line.drive == "opposite" else 0.0
        return self.command_slope(line) + more

    # --- where the films have a state --------------------------------------------------------------------------------

    def pulled_in(self, x: Any, squared: Any, n: Numbers) -> Any:
        """Mask of the x at which a film has pulled in, at a constant squared voltage on the first."""
        found = False
        for film, own in zip(self.films, self.squares_at_rest(squared, n), strict=True):
            found = found | (own > film.highest_squared(x, n))
        return found

    def strain(self, x: Any, n: Numbers) -> Any:
        """The film's measure of strain; of several films the largest share of their limits, or the largest measure if
        none has a limit."""
        strains = [film.strain(x, n) for film in self.films]
        if len(strains) == 1:
            return strains[0]
        limits = [film.strain_limit(n) for film in self.films]
        shares = [strain / limit for strain, limit in zip(strains, limits, strict=True)]
        endless = reduce(np.logical_and, map(np.isinf, limits))
        return np.where(endless, reduce(np.maximum, strains), reduce(np.maximum, shares))[()]

    def overstretched(self, z: Sequence[Any], n: Numbers) -> Any:
        """Whether the states of a film exceed their limit."""
        found = [film.overstretched(z[0], self.states_of(z, "film", k), n) for k, film in enumerate(self.films)]
        return reduce(np.logical_or, found)

    def strain_limit(self, n: Numbers) -> Any:
        """The limit that `strain` cannot reach."""
        limits = [film.strain_limit(n) for film in self.films]
        if len(limits) == 1:
            return limits[0]
        return np.where(reduce(np.logical_and, map(np.isinf, limits)), np.inf, 1.0)[()]

    def outside(self, x: float, n: Numbers) -> str:
        """The message for a start at which a film of a single actuator has no state, with the remedy."""
        lost = [film for film in self.films if not film.strain(x, n) < film.strain_limit(n)]
        return (lost or self.films)[0].outside(x, n)

    def unreachable(self, n: Numbers) -> str:
        """The message for a single actuator without a state at any displacement, with the remedy."""
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
    """The leaves of a graph, and rows of each rate followed by its derivatives by time and states."""
    graph, leaves, time, z, n = _leaves(system)
    rates = [graph.node(rate) for rate in system.rates(time, z, n, graph)]
    return leaves, [[rate, *row] for rate, row in zip(rates, jacobian(rates, [time, *z]), strict=True)]


@lru_cache(maxsize=64)
def _charge_slopes_of(system: ConeSystem, place: int, names: tuple[str, ...]) -> tuple[dict[str, Node], list[Node]]:
    """The leaves of a graph, and the derivatives of a charge for `ConeSystem.charges_by`."""
    graph, leaves, time, z, n = _leaves(system)
    charge = system.deviating(time, z, n, graph)[1][place]
    return leaves, [derivatives([charge], leaf)[0] for leaf in ([n[name] for name in names] or z)]


@lru_cache(maxsize=64)
def _powers_of(system: ConeSystem) -> tuple[dict[str, Node], list[Node]]:
    """The leaves of a graph, and the powers after the first two."""
    graph, leaves, time, z, n = _leaves(system)
    return leaves, [graph.node(power) for power in system.powers(time, z, n, graph)[2:]]


@lru_cache(maxsize=64)
def _voltage_rates_of(system: ConeSystem, of_sources: bool) -> tuple[dict[str, Node], list[Node]]:
    """The leaves of a graph, and the rates of the voltages of films, or of sources."""
    graph, leaves, time, z, n = _leaves(system)
    rates = system.rates(time, z, n, graph)
    voltages = (system.source_voltages if of_sources else system.voltages)(time, z, n, graph)
    return leaves, [total_rate(system, graph.node(v), time, z, rates) for v in voltages]


@lru_cache(maxsize=64)
def _currents_of(system: ConeSystem) -> tuple[dict[str, Node], list[Node]]:
    """The leaves of a graph, and the currents of the films whose charge programs know."""
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
