"""The equation of motion, put together from its components: what is compiled, apart from the numbers.

The disc obeys x'' = -2 zeta x' - F_film(x, V) - F_bias(x), with V the square of the film's voltage, which the circuit
makes of the waveform's. A second film on the other side of the disc adds its force. Components may add states of their
own behind displacement and velocity.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from gelcone.errors import InputError
from gelcone.physics.bias import Bias
from gelcone.physics.circuit import CIRCUITS, Circuit
from gelcone.physics.component import Component, Numbers, State
from gelcone.physics.differentiate import evaluated, gradients, jacobian
from gelcone.physics.drive import Waveform
from gelcone.physics.film.film import Film
from gelcone.physics.implicit import traced
from gelcone.physics.second import SecondFilm, renamed
from gelcone.physics.trace import Graph, Node
from gelcone.quantity import Array, Quantity

DAMPING = {"damping_ratio": Quantity("zeta", "damping ratio c/(2 m Omega0)", 0.05, lower=0.0)}
STRENGTH = {
    "dielectric_strength": Quantity(
        "Eb", "dielectric strength of the film over sqrt(mu/eps)", np.inf, positive=True, infinite=True
    )
}
"""Not part of the equation of motion: beyond this true field a result does not hold. Left out where it is unknown."""
DISC = (
    State("displacement", "displacement x = h/(b-a)", "length", mirrored=True),
    State("velocity", "velocity of the disc", "velocity", mirrored=True),
)


@dataclass(frozen=True)
class ConeSystem:
    """A disc on a film, with a bias, under a waveform through a circuit; with a second film, a double cone."""

    film: Film
    bias: Bias
    waveform: Waveform
    circuit: Circuit
    second: SecondFilm | None = None

    def __post_init__(self) -> None:
        names = [name for part in self.parts for name in part.parameters] + [*DAMPING, *STRENGTH]
        names += [state.name for state in self.states]
        if doubled := sorted({name for name in names if names.count(name) > 1}):
            raise InputError(f"{doubled[0]}: two components use this name; give one of them another")

    @property
    def parts(self) -> tuple[Component, ...]:
        return (self.film, self.bias, self.waveform, self.circuit, *([] if self.second is None else [self.second]))

    # --- names -------------------------------------------------------------------------------------------------------

    @cached_property
    def parameters(self) -> dict[str, Quantity]:
        """All numeric parameters, by their flat names."""
        parts = (self.bias, self.waveform, self.circuit, self.film, *self.parts[4:])
        return DAMPING | {name: q for part in parts for name, q in part.parameters.items()} | STRENGTH

    @cached_property
    def states(self) -> tuple[State, ...]:
        """Displacement and velocity, and what the components add."""
        first = (*DISC, *self.film.states, *self.bias.states, *self.circuit.states)
        if self.second is None:
            return first
        return (*first, *self.second.states, *(renamed(state) for state in self._second_circuit.states))

    @property
    def _second_circuit(self) -> Circuit:
        """The circuit between the second film's commanded voltage and the film; it has states only in opposite phase,
        since films of the same voltage share the first's."""
        opposite = self.second is not None and self.second.drive == "opposite"
        return self.circuit if opposite else _NO_CIRCUIT

    @cached_property
    def numbers(self) -> tuple[str, ...]:
        """Names of what the formulas take."""
        return tuple(self.numbers_of(self.complete({})))

    @property
    def planar(self) -> bool:
        """Whether displacement and velocity are all there is. Areas then shrink by exp(-2 zeta tau)."""
        return len(self.states) == len(DISC)

    @property
    def mirror(self) -> Array:
        """What the mirror image x -> -x does to each state: -1 or 1."""
        return np.array([-1.0 if state.mirrored else 1.0 for state in self.states])

    # --- numbers -----------------------------------------------------------------------------------------------------

    def complete(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """The values of all parameters, checked; what is not ``given`` takes its default."""
        damping = DAMPING["damping_ratio"]
        values = {"damping_ratio": damping.check("damping_ratio", given.get("damping_ratio", damping.default))}
        for part in (self.bias, self.waveform, self.circuit, self.film):
            values |= part.complete({name: given[name] for name in part.parameters if name in given})
        if self.second is not None:
            own = {name: given[name] for name in self.second.parameters if name in given}
            values |= self.second.complete_beside(own, values)
        known = {name: q.check(name, given[name]) for name, q in STRENGTH.items() if name in given}
        return values | known

    def numbers_of(self, values: Numbers) -> dict[str, Any]:
        """From the parameters, the numbers that the formulas take."""
        numbers = {"damping_ratio": values["damping_ratio"]}
        for part in (self.bias, self.film, self.waveform, self.circuit, *self.parts[4:]):
            own = part.numbers(values)
            if doubled := numbers.keys() & own.keys():
                raise InputError(f"{min(doubled)}: two components give a number of this name; give one of them another")
            numbers |= own
        return numbers

    # --- the equation of motion --------------------------------------------------------------------------------------

    def split(self, z: Sequence[Any]) -> tuple[list[Any], list[Any], list[Any]]:
        """The states of film, bias and circuit."""
        first = len(DISC)
        second = first + len(self.film.states)
        third = second + len(self.bias.states)
        return list(z[first:second]), list(z[second:third]), list(z[third : third + len(self.circuit.states)])

    def split_second(self, z: Sequence[Any]) -> tuple[list[Any], list[Any]]:
        """The states of the second film and of its circuit."""
        first = len(DISC) + len(self.film.states) + len(self.bias.states) + len(self.circuit.states)
        second = first + (0 if self.second is None else len(self.second.states))
        return list(z[first:second]), list(z[second:])

    def film_voltage(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> Any:
        """Voltage on the film."""
        return self.circuit.voltage(self.waveform.voltage(tau, n, xp), self.split(z)[2], n, xp)

    def film_voltage_rate(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> Any:
        """Its rate of change along a motion."""
        commanded, change = self.waveform.voltage(tau, n, xp), self.waveform.voltage_rate(tau, n, xp)
        return _rate(self.circuit, commanded, change, self.split(z)[2], n, xp)

    def second_command(self, commanded: Any, n: Numbers) -> Any:
        """Commanded voltage of the second film while that of the first is ``commanded``; constant where it is."""
        assert self.second is not None
        if self.second.drive == "opposite":
            return 2.0 * n["voltage_bias"] - commanded
        return commanded if self.second.drive == "same" else n["second_voltage"] + 0.0 * commanded

    def second_voltage(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> Any:
        """Voltage on the second film."""
        return self._second_voltage(self.waveform.voltage(tau, n, xp), z, n, xp)

    def _second_voltage(self, commanded: Any, z: Sequence[Any], n: Numbers, xp: Any) -> Any:
        assert self.second is not None
        if self.second.drive == "same":
            return self.circuit.voltage(commanded, self.split(z)[2], n, xp)
        return self._second_circuit.voltage(self.second_command(commanded, n), self.split_second(z)[1], n, xp)

    def second_voltage_rate(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> Any:
        """Its rate of change along a motion."""
        assert self.second is not None
        if self.second.drive == "same":
            return self.film_voltage_rate(tau, z, n, xp)
        change = self.waveform.voltage_rate(tau, n, xp)
        if self.second.drive == "constant":
            return 0.0 * change
        own = self.split_second(z)[1]
        return _rate(self.circuit, self.second_command(self.waveform.voltage(tau, n, xp), n), -change, own, n, xp)

    def rates(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of the states."""
        return self.rates_under(self.waveform.voltage(tau, n, xp), z, n, xp)

    def rates_under(self, commanded: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of the states under a commanded voltage."""
        return self._rates_and_slope(commanded, z, n, xp)[0]

    def flow(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> tuple[list[Any], list[list[Any]]]:
        """Rates of change, and their Jacobian [i][j]: the rate of state i by state j.

        With two states the Jacobian shares the film's division with the rates; with more the rates are differentiated.
        """
        commanded = self.waveform.voltage(tau, n, xp)
        rates, slope = self._rates_and_slope(commanded, z, n, xp)
        if self.planar:
            return rates, [[0.0, 1.0], [slope, -2.0 * n["damping_ratio"]]]
        if traced(xp):
            return rates, jacobian([xp.node(rate) for rate in rates], z)
        return rates, [row[1:] for row in self.slopes(tau, z, n)]

    def slopes(self, tau: Any, z: Sequence[Any], n: Numbers) -> list[list[Any]]:
        """Derivatives [i][j] of the rate of state i, by time (j = 0) or by state j - 1, of numbers or arrays."""
        values = {**n, **self.switches(tau, z, n)}
        leaves, rows = _slopes_of(self)
        known = {leaves[name].index: values[name] for name in self.numbers}
        known |= {leaf.index: at for leaf, at in zip(leaves.values(), (tau, *z), strict=False)}
        with np.errstate(all="ignore"):
            flat = evaluated([slope for row in rows for slope in row], known)
        return [flat[i * len(rows[0]) : (i + 1) * len(rows[0])] for i in range(len(rows))]

    def switches(self, tau: Any, z: Sequence[Any], n: Numbers) -> dict[str, Any]:
        """The numbers that borders and corners switch, as time and states give them."""
        return self.switches_under(self.waveform.voltage(tau, n), z, n) | self.waveform.switches(tau, n)

    def switches_under(self, commanded: Any, z: Sequence[Any], n: Numbers) -> dict[str, Any]:
        """Those of the borders, under a commanded voltage."""
        found: dict[str, Any] = {}
        if self.film.borders:
            voltage = self.circuit.voltage(commanded, self.split(z)[2], n)
            found |= self.film.switches(z[0], np.square(voltage), n)
        if self.second is not None and self.second.borders:
            found |= self.second.switches(z[0], np.square(self._second_voltage(commanded, z, n, np)), n)
        return found

    def _rates_and_slope(self, commanded: Any, z: Sequence[Any], n: Numbers, xp: Any) -> tuple[list[Any], Any]:
        x, u = z[0], z[1]
        film_y, bias_y, circuit_y = self.split(z)
        voltage = self.circuit.voltage(commanded, circuit_y, n, xp)
        squared = voltage * voltage
        film, film_slope = self.film.force(x, squared, film_y, n, xp)
        bias, bias_slope = self.bias.force(x, bias_y, n, xp)
        acceleration = -2.0 * n["damping_ratio"] * u - film - bias
        own = [
            *self.film.rates(x, u, squared, film_y, n, xp),
            *self.bias.rates(x, u, bias_y, n, xp),
            *self.circuit.rates(commanded, circuit_y, n, xp),
        ]
        if self.second is None:
            return [u, acceleration, *own], -film_slope - bias_slope
        second_y, second_circuit_y = self.split_second(z)
        voltage = self._second_voltage(commanded, z, n, xp)
        squared = voltage * voltage
        second, second_slope = self.second.force(x, squared, second_y, n, xp)
        own += self.second.rates(x, u, squared, second_y, n, xp)
        own += self._second_circuit.rates(self.second_command(commanded, n), second_circuit_y, n, xp)
        return [u, acceleration - second, *own], -film_slope - bias_slope - second_slope

    def powers(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """Power that film and field put into the motion, and power that the disc's damping takes out of it."""
        voltage = self.film_voltage(tau, z, n, xp)
        force = self.film.force(z[0], voltage * voltage, self.split(z)[0], n, xp)[0]
        if self.second is not None:
            voltage = self.second_voltage(tau, z, n, xp)
            force = force + self.second.force(z[0], voltage * voltage, self.split_second(z)[0], n, xp)[0]
        return -force * z[1], 2.0 * n["damping_ratio"] * z[1] * z[1]

    def forcing_period(self, n: Numbers) -> Array:
        """Smallest period of what drives the motion; that of the voltage where a circuit has states."""
        return self.waveform.period(n) if self.circuit.states else self.waveform.forcing_period(n)

    def static_force(self, x: Any, squared: Any, n: Numbers, second_squared: Any = None) -> tuple[Any, Any]:
        """Force of films and bias at a constant squared voltage, and its slope.

        ``second_squared`` is that on the second film; default what it is at rest under the same constant command.
        """
        film, film_slope = self.film.force(x, squared, [], n)
        bias, bias_slope = self.bias.force(x, [], n)
        if self.second is None:
            return film + bias, film_slope + bias_slope
        if second_squared is None:
            second_squared = self.second_squared(squared, n)
        second, second_slope = self.second.force(x, second_squared, [], n)
        return film + bias + second, film_slope + bias_slope + second_slope

    def second_squared(self, squared: Any, n: Numbers) -> Any:
        """Squared voltage on the second film while a constant command puts a squared voltage on the first."""
        assert self.second is not None
        if self.second.drive == "same":
            return squared
        if self.second.drive == "constant":
            return n["second_voltage"] * n["second_voltage"] + 0.0 * squared
        voltage = self._twice_bias(n) - np.sqrt(squared)
        return voltage * voltage

    def _twice_bias(self, n: Numbers) -> Any:
        """The sum of both films' voltages at rest in opposite phase, where the first's is not negative."""
        return 2.0 * np.abs(n["voltage_bias"] * np.real(self.circuit.gain(0.0, n)))

    def second_squared_rate(self, voltage: float, n: Numbers) -> float:
        """Derivative of `second_squared` by the voltage on the first film."""
        assert self.second is not None
        if self.second.drive == "same":
            return 2.0 * voltage
        if self.second.drive == "constant":
            return 0.0
        return float(2.0 * (voltage - self._twice_bias(n)))

    # --- where the films have a state --------------------------------------------------------------------------------

    def strain(self, x: Any, n: Numbers) -> Any:
        """The film's measure of strain; with two films the larger share of their limits, or the larger measure where
        neither has one."""
        strain = self.film.strain(x, n)
        if self.second is None:
            return strain
        other, limits = self.second.strain(x, n), (self.film.strain_limit(n), self.second.strain_limit(n))
        endless = np.isinf(limits[0]) & np.isinf(limits[1])
        return np.where(endless, np.maximum(strain, other), np.maximum(strain / limits[0], other / limits[1]))[()]

    def strain_limit(self, n: Numbers) -> Any:
        """What `strain` cannot reach."""
        limit = self.film.strain_limit(n)
        if self.second is None:
            return limit
        return np.where(np.isinf(limit) & np.isinf(self.second.strain_limit(n)), np.inf, 1.0)[()]

    def outside(self, x: float, n: Numbers) -> str:
        """Why there is no state at a start, in words, with the remedy; of one actuator."""
        if self.second is None or not self.film.strain(x, n) < self.film.strain_limit(n):
            return self.film.outside(x, n)
        own = self.second.own(n)
        return f"second film, {self.second.film.outside(float(self.second.place(x, n)), own)}"

    def unreachable(self, n: Numbers) -> str:
        """Why there is no state at any displacement, in words, with the remedy; of one actuator."""
        if self.second is None or np.isnan(self.film.reach(n)[0]):
            return self.film.unreachable(n)
        if np.isnan(self.second.reach(n)[2]):
            return f"second film: {self.second.film.unreachable(self.second.own(n))}"
        return (
            f"second_flat_height = {float(n['second_flat_height']):g}: so far from 0 that no displacement lies inside "
            "the stretch limits of both films; bring it closer to 0 or raise the limits"
        )


@lru_cache(maxsize=64)
def _slopes_of(system: ConeSystem) -> tuple[dict[str, Node], list[list[Node]]]:
    """The leaves of a graph, time and states first, and the graph of `ConeSystem.slopes`."""
    graph = Graph()
    at = {"time": graph.time} | {f"state {i}": graph.state(i) for i in range(len(system.states))}
    n = {name: graph.switch(name) for name in system.numbers}
    z = list(at.values())
    return at | n, jacobian([graph.node(rate) for rate in system.rates(z[0], z[1:], n, graph)], z)


_NO_CIRCUIT = CIRCUITS["ideal"]


def _rate(circuit: Circuit, commanded: Any, change: Any, own: list[Any], n: Numbers, xp: Any) -> Any:
    """Rate of the voltage behind a circuit, from that of the commanded one and of its own states."""
    if not own:
        return change
    by = gradients(lambda v, f: [circuit.voltage(v[0], v[1:], n, f)], [commanded, *own])[0]
    rates = [change, *circuit.rates(commanded, own, n, xp)]
    return sum(slope * rate for slope, rate in zip(by, rates, strict=True))
