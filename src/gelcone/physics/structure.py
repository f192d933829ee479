"""The structure of a system: its films, bias, waveform and circuits, with their parameters, numbers and states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from gelcone.errors import InputError
from gelcone.physics.bias import Bias
from gelcone.physics.circuit import Circuit, IdealSource
from gelcone.physics.component import Component, Numbers, State, uncached
from gelcone.physics.drive import Pieced, Waveform
from gelcone.physics.film.film import Film
from gelcone.physics.placed import PREFIX, PlacedFilm, renamed
from gelcone.quantity import Array, Quantity

DAMPING = {"damping_ratio": Quantity("zeta", "damping ratio c/(2 m Omega0)", 0.05, lower=0.0)}
STRENGTH = {
    "dielectric_strength": Quantity(
        "Eb", "dielectric strength of the film over sqrt(mu/eps)", np.inf, positive=True, infinite=True
    )
}
"""The true field beyond which a result does not hold, not part of the equation of motion; left out if unknown."""
DISC = (
    State("displacement", "displacement x = h/(b-a)", "length", mirrored=True),
    State("velocity", "velocity of the disc", "velocity", mirrored=True),
)


class Line(NamedTuple):
    """A ``circuit`` and the indices of the ``films`` that it drives; ``drive`` is that of the second film if the
    circuit drives the second alone, and ``prefix`` that of the names of its states and switches."""

    circuit: Circuit
    films: tuple[int, ...]
    drive: str | None
    prefix: str

    def own(self, n: Numbers) -> Numbers:
        """The numbers, with the circuit's switches by their names in its formulas."""
        if not (self.prefix and self.circuit.borders):
            return n
        return {**n, **{str(b.switch): n[self.prefix + str(b.switch)] for b in self.circuit.borders}}

    @property
    def states(self) -> tuple[State, ...]:
        """The states of the circuit, with the prefix of their names."""
        return tuple(renamed(state, self.prefix) for state in self.circuit.states)

    def starts(self, x: Any, n: Numbers) -> list[Any]:
        """Initial values of the circuit's states in a run from the displacement x."""
        return self.circuit.starts(x, self.own(n))


@dataclass(frozen=True)
class Structure:
    """The components of a system: one film or two, a bias, a waveform and a circuit."""

    films: tuple[PlacedFilm, ...]
    bias: Bias
    waveform: Waveform
    circuit: Circuit

    def __post_init__(self) -> None:
        self.circuit.check()
        if self.circuit.delays and (len(self.films) > 1 or not self.film.linear_charge):
            raise InputError("dielectric_share: only a single taut film takes one; take it, or leave it out")
        if getattr(self.circuit, "reduced", False):
            self._check_reduced()
        names = [name for part in self.parts for name in part.parameters] + [*DAMPING, *STRENGTH]
        names += [state.name for state in self.states]
        if doubled := sorted({name for name in names if names.count(name) > 1}):
            raise InputError(f"{doubled[0]}: two components use this name; give one of them another")

    def _check_reduced(self) -> None:
        """Raise `InputError` where a resistance without a state would not be right to second order."""
        unlike = [film for film in self.films if not film.film.linear_charge or film.film.borders]
        if unlike:
            raise InputError(
                f"reduced: the capacitance of the film {unlike[0].film.name!r} depends on the voltage, so that its "
                "resistance takes a state; take the taut film, or leave series_resistance out of reduced"
            )
        if self.waveform.pieced and self.circuit.jumps:
            raise InputError(
                f"reduced: the voltage of the waveform {self.waveform.name!r} has corners, at which the film's would "
                "jump; give the amplifier a filter_time too (a device: filter_frequency), or leave series_resistance "
                "out of reduced"
            )

    def _check_jumps(self, values: Numbers) -> None:
        """Raise `InputError` where the command of a filter jumps, and with it the current through a resistance without
        a state."""
        if isinstance(self.waveform, Pieced) and self.waveform.jumps(self.waveform.numbers(values)):
            raise InputError(
                f"reduced: the voltage of the waveform {self.waveform.name!r} jumps, and behind a filter the film's "
                "would, too; take one that rises and falls in some share of the repeat, or leave series_resistance out "
                "of reduced"
            )

    def _check_offset(self, values: Numbers) -> None:
        """Raise `InputError` for a bias v0 of a sign that the command v never has: films with v and 2 v0 - v would then
        rise together."""
        if (np.asarray(self.waveform.offset(values)) != np.asarray(values["voltage_bias"])).any():
            raise InputError(
                f"second_drive = 'opposite': the waveform {self.waveform.name!r} stays at or above 0, so that both "
                "films, in opposite phase about a bias below 0, would rise together; make voltage_bias (a device: "
                "voltage_offset) at least 0"
            )

    def __getstate__(self) -> dict[str, Any]:
        return uncached(self)

    @property
    def film(self) -> Film:
        """The first film."""
        return self.films[0].film

    @property
    def parts(self) -> tuple[Component, ...]:
        """The components: first film, bias, waveform, circuit, and further films."""
        return (self.films[0], self.bias, self.waveform, self.circuit, *self.films[1:])

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """The circuits and the films that they drive; films of the same voltage share one."""
        shared = tuple(k for k, film in enumerate(self.films) if film.drive in (None, "same"))
        separate = [(k, film.drive) for k, film in enumerate(self.films) if film.drive not in (None, "same")]
        circuits = {"opposite": self.circuit, "constant": self.circuit.held}
        other_lines = (Line(circuits[str(drive)], (k,), drive, PREFIX) for k, drive in separate)
        return (Line(self.circuit, shared, None, ""), *other_lines)

    @cached_property
    def film_lines(self) -> tuple[Line, ...]:
        """The line of each film."""
        return tuple(next(line for line in self.lines if k in line.films) for k in range(len(self.films)))

    @cached_property
    def ideal(self) -> bool:
        """Whether all films have the commanded voltages."""
        return all(line.circuit == IdealSource() for line in self.lines)

    # --- names -------------------------------------------------------------------------------------------------------

    @cached_property
    def parameters(self) -> dict[str, Quantity]:
        """All numeric parameters, by their flat names."""
        parts = (self.bias, self.waveform, self.circuit, *self.films)
        return DAMPING | {name: q for part in parts for name, q in part.parameters.items()} | STRENGTH

    @cached_property
    def states(self) -> tuple[State, ...]:
        """Displacement and velocity, and the states of the components."""
        return (*DISC, *(state for _, owner in self._added for state in owner.states))

    @cached_property
    def _added(self) -> tuple[tuple[Any, PlacedFilm | Bias | Line], ...]:
        """The owners of the components' states, in order, with the names of their places."""
        owners: list[tuple[Any, PlacedFilm | Bias | Line]] = []
        for k, film in enumerate(self.films):
            owners.append((("film", k), film))
            owners += [(("bias",), self.bias)] if k == 0 else []
            owners += [(("line", line.prefix), line) for line in self.lines if line.films[0] == k]
        return tuple(owners)

    @cached_property
    def _places(self) -> dict[Any, slice]:
        places, begin = {}, len(DISC)
        for place, owner in self._added:
            places[place] = slice(begin, begin + len(owner.states))
            begin += len(owner.states)
        return places

    def places_of(self, line: Line) -> range:
        """The indices of the states of a line's circuit."""
        return range(*self._places["line", line.prefix].indices(len(self.states)))

    def states_of(self, z: Sequence[Any], *owner: Any) -> list[Any]:
        """The states of ``"film", k``, of ``"bias"``, or of ``"line", prefix``."""
        return list(z[self._places[owner]])

    def starts(self, x: Any, n: Numbers) -> list[Any]:
        """Initial values of the states of the components in a run from the displacement x."""
        return [start for _, owner in self._added for start in owner.starts(x, n)]

    def relaxed(self, x: Any, squares: Sequence[Any], n: Numbers) -> list[Any]:
        """The states of films and bias at rest at x and constant squared voltages; None for those that are unknown."""
        states: list[Any] = []
        for place, owner in self._added:
            if not isinstance(owner, Line):
                rest_states = owner.relaxed(x, squares[place[1]], n) if isinstance(owner, PlacedFilm) else None
                states += [None] * len(owner.states) if rest_states is None else rest_states
        return states

    @cached_property
    def numbers(self) -> tuple[str, ...]:
        """Names of the numbers of the formulas, in the order of `numbers_of`."""
        parts = (self.bias, self.films[0], self.waveform, self.circuit, *self.films[1:])
        names = [name for part in parts for name in part.number_names]
        of_lines = [line.prefix + str(b.switch) for line in self.lines[1:] for b in line.circuit.borders]
        return ("damping_ratio", *names, *of_lines)

    @property
    def mirror(self) -> Array:
        """The sign that the mirror image x -> -x gives each state: -1 or 1."""
        return np.array([-1.0 if state.mirrored else 1.0 for state in self.states])

    # --- numbers -----------------------------------------------------------------------------------------------------

    def complete(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Check the ``given`` parameters and fill in the defaults of the others."""
        damping = DAMPING["damping_ratio"]
        values = {"damping_ratio": damping.check("damping_ratio", given.get("damping_ratio", damping.default))}
        for part in (self.bias, self.waveform, self.circuit):
            values |= part.complete({name: given[name] for name in part.parameters if name in given})
        if getattr(self.circuit, "reduced", False):
            self._check_jumps(values)
        if self.in_opposite_phase:
            self._check_offset(values)
        for film in self.films:
            values |= film.complete_with(given, values)
        known = {name: q.check(name, given[name]) for name, q in STRENGTH.items() if name in given}
        return values | known

    def numbers_of(self, values: Numbers) -> dict[str, Any]:
        """Compute the numbers of the formulas from the parameters."""
        numbers = {"damping_ratio": values["damping_ratio"]}
        of_lines = [
            {line.prefix + str(b.switch): numbers_of_circuit[str(b.switch)] for b in line.circuit.borders}
            for numbers_of_circuit in [self.circuit.numbers(values)]
            for line in self.lines[1:]
        ]
        parts = [part.numbers(values) for part in (self.bias, self.films[0], self.waveform, self.circuit)]
        for part_numbers in [*parts, *(film.numbers(values) for film in self.films[1:]), *of_lines]:
            if doubled := numbers.keys() & part_numbers.keys():
                raise InputError(f"{min(doubled)}: two components give a number of this name; give one of them another")
            numbers |= part_numbers
        return numbers

    @property
    def in_opposite_phase(self) -> bool:
        """Whether the last film has a voltage in opposite phase to the first about one bias."""
        return self.films[-1].drive == "opposite"

    def command_of(self, line: Line, commanded: Any, n: Numbers) -> Any:
        """The command of a line while that of the first line is ``commanded``."""
        if line.drive == "opposite":
            return 2.0 * n["voltage_bias"] - commanded
        return commanded if line.drive is None else n["second_voltage"] + 0.0 * commanded

    @staticmethod
    def command_slope(line: Line) -> float:
        """The slope of `command_of` by the command of the first line."""
        return {"opposite": -1.0, "constant": 0.0}.get(str(line.drive), 1.0)
