"""The equation of motion, put together from its components: what is compiled, apart from the numbers.

The disc obeys x'' = -2 zeta x' - F_film(x, V) - F_bias(x), with V the square of the film's voltage, which the circuit
makes of the waveform's. Components may add states of their own behind displacement and velocity.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from gelcone.errors import InputError
from gelcone.physics.bias import Bias
from gelcone.physics.circuit import Circuit
from gelcone.physics.component import Component, Numbers, State
from gelcone.physics.drive import Waveform
from gelcone.physics.dual import gradients
from gelcone.physics.film.film import Film
from gelcone.quantity import Array, Quantity

DAMPING = {"damping_ratio": Quantity("zeta", "damping ratio c/(2 m Omega0)", 0.05, lower=0.0)}
DISC = (
    State("displacement", "displacement x = h/(b-a)", "length", mirrored=True),
    State("velocity", "velocity of the disc", "velocity", mirrored=True),
)


class System(Protocol):
    """What a back end compiles: ordinary differential equations whose numbers have names.

    ``states`` and ``numbers`` name the states and the numbers. `flow` gives the rates of change and their Jacobian
    together, so that both share what they have in common; `powers` those of the electric force and of the dissipation.
    Formulas take numbers by name and the functions of ``xp``. Equal systems share a program.
    """

    @property
    def states(self) -> tuple[State, ...]: ...

    @property
    def numbers(self) -> tuple[str, ...]: ...

    def flow(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> tuple[list[Any], list[list[Any]]]: ...

    def powers(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]: ...


@dataclass(frozen=True)
class ConeSystem:
    """A disc on a film, with a bias, under a waveform through a circuit."""

    film: Film
    bias: Bias
    waveform: Waveform
    circuit: Circuit

    def __post_init__(self) -> None:
        names = [name for part in self.parts for name in part.parameters] + list(DAMPING)
        names += [state.name for state in self.states]
        if doubled := sorted({name for name in names if names.count(name) > 1}):
            raise InputError(f"{doubled[0]}: two components use this name; give one of them another")

    @property
    def parts(self) -> tuple[Component, ...]:
        return self.film, self.bias, self.waveform, self.circuit

    # --- names -------------------------------------------------------------------------------------------------------

    @cached_property
    def parameters(self) -> dict[str, Quantity]:
        """All numeric parameters, by their flat names."""
        return DAMPING | {
            name: q
            for part in (self.bias, self.waveform, self.circuit, self.film)
            for name, q in part.parameters.items()
        }

    @cached_property
    def states(self) -> tuple[State, ...]:
        """Displacement and velocity, and what the components add."""
        return (*DISC, *self.film.states, *self.bias.states, *self.circuit.states)

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
        return values

    def numbers_of(self, values: Numbers) -> dict[str, Any]:
        """From the parameters, the numbers that the formulas take."""
        numbers = {"damping_ratio": values["damping_ratio"]}
        for part in (self.bias, self.film, self.waveform, self.circuit):
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
        return list(z[first:second]), list(z[second:third]), list(z[third:])

    def film_voltage(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> Any:
        """Voltage on the film."""
        return self.circuit.voltage(self.waveform.voltage(tau, n, xp), self.split(z)[2], n, xp)

    def film_voltage_rate(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> Any:
        """Its rate of change along a motion."""
        own = self.split(z)[2]
        commanded, change = self.waveform.voltage(tau, n, xp), self.waveform.voltage_rate(tau, n, xp)
        if not own:
            return change
        by = gradients(lambda v, f: [self.circuit.voltage(v[0], v[1:], n, f)], [commanded, *own], xp)[0]
        rates = [change, *self.circuit.rates(commanded, own, n, xp)]
        return sum(slope * rate for slope, rate in zip(by, rates, strict=True))

    def rates(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of the states."""
        return self.rates_under(self.waveform.voltage(tau, n, xp), z, n, xp)

    def rates_under(self, commanded: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of the states under a commanded voltage."""
        return self._rates_and_slope(commanded, z, n, xp)[0]

    def flow(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> tuple[list[Any], list[list[Any]]]:
        """Rates of change, and their Jacobian [i][j]: the rate of state i by state j.

        With two states the Jacobian shares the film's division with the rates; with more it comes from dual numbers.
        """
        commanded = self.waveform.voltage(tau, n, xp)
        rates, slope = self._rates_and_slope(commanded, z, n, xp)
        if self.planar:
            return rates, [[0.0, 1.0], [slope, -2.0 * n["damping_ratio"]]]
        return rates, gradients(lambda at, functions: self.rates_under(commanded, at, n, functions), z, xp)

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
        return [u, acceleration, *own], -film_slope - bias_slope

    def powers(self, tau: Any, z: Sequence[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """Power that the electric force puts into the motion, and power that the disc's damping takes out of it."""
        voltage = self.film_voltage(tau, z, n, xp)
        electric = self.film.voltage_force(z[0], voltage * voltage, self.split(z)[0], n, xp)
        return electric * z[1], 2.0 * n["damping_ratio"] * z[1] * z[1]

    def forcing_period(self, n: Numbers) -> Array:
        """Smallest period of what drives the motion; that of the voltage where a circuit has states."""
        return self.waveform.period(n) if self.circuit.states else self.waveform.forcing_period(n)

    def static_force(self, x: Any, squared: Any, n: Numbers) -> tuple[Any, Any]:
        """Force of film and bias at a constant squared voltage, and its slope."""
        film, film_slope = self.film.force(x, squared, [], n)
        bias, bias_slope = self.bias.force(x, [], n)
        return film + bias, film_slope + bias_slope
