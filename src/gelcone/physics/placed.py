"""Films placed at the disc: one film, or two on either side of it, the antagonistic double cone.

The first is flat where the disc is at x = 0, the second where it is at x = d, its flat height: its own displacement is
d - x, and its force pulls the disc towards d. With d = 0 the two are flat together; with d > 0 a rod between their
centres keeps both cones raised, against each other. The second film is of the same material and thickness as the first;
pre-stretch, kind and voltage are its own. Its names begin with ``second_``.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gelcone.errors import unknown_name
from gelcone.physics.component import Component, Numbers, State
from gelcone.physics.film.film import Border, Film, FilmState, TracedState
from gelcone.physics.film.gel import PRESTRETCHES
from gelcone.quantity import Array, Quantity

PREFIX = "second_"
DRIVES = ("same", "opposite", "constant")
"""The second film's voltage: the first's; in opposite phase about the same bias, 2 v0 - v; or a constant one."""
FLAT_HEIGHT = Quantity("d", "height of the disc at which the second film is flat, over b-a", 0.0, scale="length")
CONSTANT_VOLTAGE = Quantity("v2", "constant voltage on the second film", 0.0, scale="voltage")


class _Unprefixed(Mapping[str, Any]):
    """The numbers of the second film by their names without prefix, each read on demand: of the thousand numbers of a
    membrane a formula takes few."""

    def __init__(self, numbers: Numbers) -> None:
        self._numbers = numbers

    def __getitem__(self, name: str) -> Any:
        return self._numbers[PREFIX + name]

    def __contains__(self, name: object) -> bool:
        return PREFIX + str(name) in self._numbers

    def __iter__(self) -> Iterator[str]:
        return (name.removeprefix(PREFIX) for name in self._numbers if name.startswith(PREFIX))

    def __len__(self) -> int:
        return sum(name.startswith(PREFIX) for name in self._numbers)


@dataclass(frozen=True)
class PlacedFilm(Component):
    """A film in the displacement, velocity and numbers of the system.

    Parameters
    ----------
    film : the film.
    drive : None for the first film, which has the commanded voltage; one of `DRIVES` for the second. Default None.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(second_film="taut", second_flat_height=0.8, rest_height=0.4)
    >>> [placed.drive for placed in model.system.films], model.second_flat_height
    ([None, 'same'], 0.8)
    """

    film: Film
    drive: str | None = None

    name = "placed film"

    def __post_init__(self) -> None:
        if self.drive is not None and self.drive not in DRIVES:
            raise unknown_name("second_drive", str(self.drive), DRIVES)

    @property
    def prefix(self) -> str:
        """The prefix of its names."""
        return "" if self.drive is None else PREFIX

    @property
    def has_other_voltage(self) -> bool:
        """Whether its voltage differs from that of the first film."""
        return self.drive in ("opposite", "constant")

    @property
    def words(self) -> str:
        """The name of the film in texts."""
        return "the film" if self.drive is None else "the second film"

    @cached_property
    def parameters(self) -> Mapping[str, Quantity]:
        if self.drive is None:
            return self.film.parameters
        film_parameters = {
            PREFIX + name: dataclasses.replace(q, meaning=f"second film: {q.meaning}")
            for name, q in self.film.parameters.items()
        }
        constant = {"second_voltage": CONSTANT_VOLTAGE} if self.drive == "constant" else {}
        return {"second_flat_height": FLAT_HEIGHT} | constant | film_parameters

    @cached_property
    def states(self) -> tuple[State, ...]:  # type: ignore[override]
        """The states of the film, with the prefix of its parameters."""
        return tuple(renamed(state, self.prefix) for state in self.film.states)

    @property
    def kinds(self) -> tuple[str, ...]:
        """Names of the film's states of tension; empty for a film without borders."""
        return self.film.kinds

    # --- numbers -----------------------------------------------------------------------------------------------------

    def complete_with(self, given: Mapping[str, Any], known: Mapping[str, Any]) -> dict[str, Any]:
        """Check the ``given`` parameters and fill in the others: of a second film from the ``known`` ones of the first,
        else from defaults."""
        film_given = {name.removeprefix(self.prefix): given[name] for name in self.parameters if name in given}
        if self.drive is None:
            return self.film.complete(film_given)
        shared = dict(known)
        if any(film_given.get(name) is not None for name in PRESTRETCHES):
            shared = {name: value for name, value in shared.items() if name not in PRESTRETCHES}
        film = {n: v for n, v in (shared | film_given).items() if n in self.film.parameters and v is not None}
        rest = {name: self.parameters[name] for name in self._placing}
        return {name: q.check(name, given.get(name, q.default)) for name, q in rest.items()} | {
            PREFIX + name: value for name, value in self.film.complete(film).items()
        }

    @property
    def _placing(self) -> list[str]:
        """Names of the parameters that are not the film's."""
        return [name for name in self.parameters if name.removeprefix(self.prefix) not in self.film.parameters]

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        film_numbers = self.film.numbers(self.own(parameters))
        rest = {name: parameters[name] for name in self._placing}
        return rest | {self.prefix + name: value for name, value in film_numbers.items()}

    @property
    def number_names(self) -> tuple[str, ...]:
        """The names of `numbers`, in their order."""
        return (*self._placing, *(self.prefix + name for name in self.film.number_names))

    def own(self, n: Numbers) -> Numbers:
        """The numbers by their names in the film's formulas, without prefix."""
        if self.drive is None:
            return n
        return _Unprefixed(n)

    def starts(self, x: Any, n: Numbers) -> list[Any]:
        return self.film.starts(self.place(x, n), self.own(n))

    def relaxed(self, x: Any, squared: Any, n: Numbers) -> list[Any] | None:
        """The film's states at rest; None where they are unknown."""
        return self.film.relaxed(self.place(x, n), squared, self.own(n))

    def time_constant(self, n: Numbers) -> Any:
        return self.film.time_constant(self.own(n))

    def place(self, x: Any, n: Numbers) -> Any:
        """The film's displacement: x, or d - x."""
        return x if self.drive is None else n["second_flat_height"] - x

    def _turned(self, value: Any) -> Any:
        """Turn a component along the film's displacement into one along the disc's, and the reverse."""
        return value if self.drive is None else -value

    # --- the film in the coordinates of the disc ----------------------------------------------------------------------

    def force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """The force that pulls the disc down, and its derivative by x."""
        force, slope = self.film.force(self.place(x, n), squared, y, self.own(n), xp)
        return self._turned(force), slope

    def voltage_force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """The reduction of the force that pulls the disc down by the voltage."""
        return self._turned(self.film.voltage_force(self.place(x, n), squared, y, self.own(n), xp))

    @cached_property
    def borders(self) -> tuple[Border, ...]:
        """The borders of the film, in the displacement and numbers of the system, with prefixed switches."""
        return tuple(self._border(border) for border in self.film.borders)

    def _border(self, border: Border) -> Border:
        def value(x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
            return border.value(self.place(x, n), squared, y, self.own(n), xp)

        # only the first film's switches divide laws: those of both would take many laws, each compiled on its own
        divides = border.divides and self.drive is None
        return dataclasses.replace(
            border, value=value, switch=border.switch and self.prefix + border.switch, divides=divides
        )

    def switches(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> dict[str, Any]:
        """The switches of its borders."""
        if not self.borders:
            return {}
        switches = self.film.switches(self.place(x, n), squared, y, self.own(n))
        return {self.prefix + name: value for name, value in switches.items()}

    def times_of_kinds(self, switches: Sequence[str], dwell: Array) -> Array:
        """Sum the time in each of its states of tension."""
        border_switches = [border.switch for border in self.borders]
        names = [
            name.removeprefix(self.prefix) if name in border_switches else f"another's {name}" for name in switches
        ]
        return self.film.times_of_kinds(names, dwell)

    def pull_in_kind(self, switches: Numbers) -> Any:
        """The way in which it has pulled in."""
        return self.film.pull_in_kind(self.own(switches))

    def rates(self, x: Any, velocity: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of its states."""
        return self.film.rates(self.place(x, n), self._turned(velocity), squared, y, self.own(n), xp)

    def dissipation(self, x: Any, velocity: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """The power that the film dissipates."""
        return self.film.dissipation(self.place(x, n), self._turned(velocity), squared, y, self.own(n), xp)

    @property
    def drags(self) -> bool:
        """True if the film damps the disc."""
        return self.film.drags

    def drag(self, x: Any, n: Numbers) -> Any:
        """The damping coefficient of the disc by the film, independent of its direction."""
        return self.film.drag(self.place(x, n), self.own(n))

    def overstretched(self, x: Any, y: list[Any], n: Numbers) -> Any:
        """Whether the film's states exceed their limit."""
        return self.film.overstretched(self.place(x, n), y, self.own(n))

    def strain(self, x: Any, n: Numbers) -> Any:
        """The measure of strain of the film."""
        return self.film.strain(self.place(x, n), self.own(n))

    def strain_limit(self, n: Numbers) -> Any:
        """The limit of `strain`."""
        return self.film.strain_limit(self.own(n))

    def highest_squared(self, x: Any, n: Numbers) -> Any:
        """The squared voltage above which it has no state."""
        return self.film.highest_squared(self.place(x, n), self.own(n))

    def highest_squared_held(self, x: Any, y: list[Any], n: Numbers) -> Any:
        """The squared voltage above which the film has no state while its states are ``y``."""
        return self.film.highest_squared_held(self.place(x, n), y, self.own(n))

    def voltage_gain(self, x: Any, squared: Any, n: Numbers) -> Any:
        """Minus the derivative of the force by the squared voltage."""
        return self._turned(self.film.voltage_gain(self.place(x, n), squared, self.own(n)))

    def work(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> Any:
        """Work against film and field from the flat film."""
        return self.film.work(self.place(x, n), squared, y, self.own(n))

    def capacitance(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """The charge of the film over its voltage."""
        return self.film.capacitance(self.place(x, n), squared, y, self.own(n), xp)

    def fitted_capacitance(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> Any:
        """The capacitance that programs have, of arrays."""
        return self.film.fitted_capacitance(self.place(x, n), squared, y, self.own(n))

    def current(self, x: Any, velocity: Any, voltage: Any, rate: Any, n: Numbers) -> Any:
        """Rate of its charge."""
        return self.film.current(self.place(x, n), self._turned(velocity), voltage, rate, self.own(n))

    def state(self, x: Any, voltage: Any, y: list[Any], n: Numbers) -> FilmState:
        """The stretches, stresses and field of the film."""
        return self.film.state(self.place(x, n), voltage, y, self.own(n))

    def traced_state(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> TracedState | None:
        """The formulas of `state` for a program; None where none are known."""
        return self.film.traced_state(self.place(x, n), squared, y, self.own(n), xp)

    def limit_share(self, x: Any, voltage: Any, y: list[Any], n: Numbers, state: FilmState | None = None) -> Any:
        """The share of the stretch limit that the film takes."""
        return self.film.limit_share(self.place(x, n), voltage, y, self.own(n), state)

    def stiffness_scale(self, n: Numbers) -> Any:
        """A typical stiffness of the film, which bounds the rate of the motion."""
        return self.film.stiffness_scale(self.own(n))

    def odd(self, n: Numbers) -> Any:
        """Whether the force is odd in the displacement of the disc."""
        centred = self.drive is None or np.asarray(n["second_flat_height"]) == 0.0
        return np.logical_and(self.film.odd(self.own(n)), centred)

    def reach(self, n: Numbers) -> tuple[float, float, float]:
        """The lowest and highest displacement of the disc with a state of the film, and the least distance from where
        it is flat; for a single actuator."""
        begin, end = self.film.reach(self.own(n))
        flat = float(self.place(0.0, n))
        return flat - end, flat + end, begin

    def outside(self, x: float, n: Numbers) -> str:
        """The message for a start at which a single film has no state, with the remedy."""
        return ("" if self.drive is None else "second film, ") + self.film.outside(float(self.place(x, n)), self.own(n))

    def unreachable(self, n: Numbers) -> str:
        """The message for a single film without a state at any displacement, with the remedy."""
        return ("" if self.drive is None else "second film: ") + self.film.unreachable(self.own(n))


def renamed(state: State, prefix: str = PREFIX) -> State:
    """A state of a film or of its circuit with a prefixed name."""
    if not prefix:
        return state
    return dataclasses.replace(state, name=prefix + state.name, meaning=f"second film: {state.meaning}")
