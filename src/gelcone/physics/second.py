"""A second film on the other side of the disc: the antagonistic double cone.

Both films hold the same disc. The first is flat where the disc is at x = 0, the second where it is at x = d, its flat
height: its own displacement is d - x, and its force pulls the disc towards d. With d = 0 the two are flat together;
with d > 0 a rod between their centres keeps both cones raised, against each other. The second film is of the same
material and thickness as the first; pre-stretch, kind and voltage are its own. Its names begin with ``second_``.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gelcone.errors import unknown_name
from gelcone.physics.component import Component, Numbers, State
from gelcone.physics.film.film import Border, Film, FilmState
from gelcone.physics.film.fitted import FittedFilm
from gelcone.physics.film.taut import PRESTRETCHES
from gelcone.quantity import Array, Quantity

PREFIX = "second_"
DRIVES = ("same", "opposite", "constant")
"""The second film's voltage: the first's; in opposite phase about the same bias, 2 v0 - v; or one that is constant."""
FLAT_HEIGHT = Quantity("d", "height of the disc at which the second film is flat, over b-a", 0.0, scale="length")
CONSTANT_VOLTAGE = Quantity("v2", "constant voltage on the second film", 0.0, scale="voltage")


@dataclass(frozen=True)
class SecondFilm(Component):
    """A ``film`` on the other side of the disc; ``drive`` is one of `DRIVES`."""

    film: Film
    drive: str = "same"

    name = "second film"

    def __post_init__(self) -> None:
        if self.drive not in DRIVES:
            raise unknown_name("second_drive", str(self.drive), DRIVES)

    @cached_property
    def parameters(self) -> Mapping[str, Quantity]:
        own = {
            PREFIX + name: dataclasses.replace(q, meaning=f"second film: {q.meaning}")
            for name, q in self.film.parameters.items()
        }
        constant = {"second_voltage": CONSTANT_VOLTAGE} if self.drive == "constant" else {}
        return {"second_flat_height": FLAT_HEIGHT} | constant | own

    @cached_property
    def states(self) -> tuple[State, ...]:  # type: ignore[override]
        return tuple(renamed(state) for state in self.film.states)

    # --- numbers -----------------------------------------------------------------------------------------------------

    def complete_beside(self, given: Mapping[str, Any], first: Mapping[str, Any]) -> dict[str, Any]:
        """The values of all parameters, checked; of those not ``given``, the second film's are the ``first``'s."""
        own = {name.removeprefix(PREFIX): value for name, value in given.items()}
        shared = {} if isinstance(self.film, FittedFilm) else dict(first)
        if any(own.get(name) is not None for name in PRESTRETCHES):
            shared = {name: value for name, value in shared.items() if name not in PRESTRETCHES}
        known = {n: v for n, v in (shared | own).items() if n in self.film.parameters and v is not None}
        rest = {name: q for name, q in self.parameters.items() if name.removeprefix(PREFIX) not in self.film.parameters}
        return {name: q.check(name, given.get(name, q.default)) for name, q in rest.items()} | {
            PREFIX + name: value for name, value in self.film.complete(known).items()
        }

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        own = self.film.numbers(self.own(parameters))
        rest = {name: parameters[name] for name in ("second_flat_height", "second_voltage") if name in self.parameters}
        return rest | {PREFIX + name: value for name, value in own.items()}

    def own(self, n: Numbers) -> dict[str, Any]:
        """What the film's own formulas take: the numbers without their prefix."""
        return {name.removeprefix(PREFIX): value for name, value in n.items() if name.startswith(PREFIX)}

    def time_constant(self, n: Numbers) -> Any:
        return self.film.time_constant(self.own(n))

    def place(self, x: Any, n: Numbers) -> Any:
        """The film's own displacement d - x."""
        return n["second_flat_height"] - x

    # --- the film as the disc feels it -------------------------------------------------------------------------------

    def force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """What it adds to the force that pulls the disc down, and the derivative by x."""
        force, slope = self.film.force(self.place(x, n), squared, y, self.own(n), xp)
        return -force, slope

    def voltage_force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """What its voltage takes from the force that pulls the disc down."""
        return -self.film.voltage_force(self.place(x, n), squared, y, self.own(n), xp)

    @cached_property
    def borders(self) -> tuple[Border, ...]:
        """The film's own, with its place, numbers and the names of its switches."""
        return tuple(self._border(border) for border in self.film.borders)

    def _border(self, border: Border) -> Border:
        def value(x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
            return border.value(self.place(x, n), squared, y, self.own(n), xp)

        return Border(value, border.switch and PREFIX + border.switch, border.seldom, border.jumps, border.tells)

    def switches(self, x: Any, squared: Any, n: Numbers) -> dict[str, Any]:
        own = self.film.switches(self.place(x, n), squared, self.own(n))
        return {PREFIX + name: value for name, value in own.items()}

    def times_of_kinds(self, switches: Sequence[str], dwell: Array) -> Array:
        names = [name.removeprefix(PREFIX) if name.startswith(PREFIX) else f"first {name}" for name in switches]
        return self.film.times_of_kinds(names, dwell)

    def pull_in_kind(self, switches: Numbers) -> Any:
        return self.film.pull_in_kind(self.own(switches))

    def rates(self, x: Any, velocity: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> list[Any]:
        return self.film.rates(self.place(x, n), -velocity, squared, y, self.own(n), xp)

    def strain(self, x: Any, n: Numbers) -> Any:
        return self.film.strain(self.place(x, n), self.own(n))

    def strain_limit(self, n: Numbers) -> Any:
        return self.film.strain_limit(self.own(n))

    def voltage_gain(self, x: Any, squared: Any, n: Numbers) -> Any:
        return -self.film.voltage_gain(self.place(x, n), squared, self.own(n))

    def work(self, x: Any, squared: Any, n: Numbers) -> Any:
        """Work against film and field from where the film is flat."""
        return self.film.work(self.place(x, n), squared, self.own(n))

    def area(self, x: Any, squared: Any, n: Numbers) -> Any:
        return self.film.area(self.place(x, n), squared, self.own(n))

    def current(self, times: Array, x: Array, velocity: Array, voltage: Array, rate: Array, n: Numbers) -> Array:
        """Rate of its charge."""
        return self.film.current(times, self.place(x, n), -velocity, voltage, rate, self.own(n))

    def state(self, x: Any, voltage: Any, n: Numbers) -> FilmState:
        return self.film.state(self.place(x, n), voltage, self.own(n))

    def near_limit(self, x: Any, voltage: Any, n: Numbers, share: float) -> Any:
        return self.film.near_limit(self.place(x, n), voltage, self.own(n), share)

    def stiffness_scale(self, n: Numbers) -> Any:
        return self.film.stiffness_scale(self.own(n))

    def odd(self, n: Numbers) -> Any:
        """Whether its force at -x is the opposite of that at x."""
        return np.logical_and(self.film.odd, np.asarray(n["second_flat_height"]) == 0.0)

    def reach(self, n: Numbers) -> tuple[float, float, float]:
        """The displacements of the disc at which it has a state, of one actuator: from lowest to highest, and the
        least distance from where it is flat."""
        begin, end = self.film.reach(self.own(n))
        flat = float(n["second_flat_height"])
        return flat - end, flat + end, begin


def renamed(state: State) -> State:
    """A state of the second film or of its circuit."""
    return dataclasses.replace(state, name=PREFIX + state.name, meaning=f"second film: {state.meaning}")
