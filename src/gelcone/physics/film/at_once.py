"""A film whose branches have no time to relax, for the statics of a fast step.

The states of its branches are parameters, held where the branches have rested before. The film is elastic, and stiffer
than the relaxed film of the same gel, which all other statics describe.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gelcone.bracket import rise
from gelcone.physics.component import Numbers
from gelcone.physics.film.elastic import STEEP
from gelcone.physics.film.film import Film, FilmState
from gelcone.physics.film.membrane import MembraneFilm
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.members import Ensemble, Members
from gelcone.physics.statics import rest_displacements
from gelcone.physics.structure import DISC
from gelcone.quantity import Array, Quantity

HELD = "held_"
"""Prefix of the name of a state that is a parameter."""
FARTHEST_SEARCHED = 1e6
"""The |x| up to which the limit of a branch is searched."""


@dataclass(frozen=True)
class FilmAtOnce(Film):
    """A ``film`` in which the states of its branches are parameters."""

    film: Film

    name = "film at once"

    @cached_property
    def parameters(self) -> Mapping[str, Quantity]:
        held = {HELD + state.name: Quantity(state.name, state.meaning, state.start) for state in self.film.states}
        return {**self.film.parameters, **held}

    def complete(self, given: Mapping[str, Any]) -> dict[str, Any]:
        held_values = {name: given.get(name, q.default) for name, q in self.parameters.items() if name.startswith(HELD)}
        return self.film.complete({name: given[name] for name in given if name not in held_values}) | held_values

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        held = {name: parameters[name] for name in self.parameters if name.startswith(HELD)}
        return self.film.numbers(parameters) | held

    def held(self, n: Numbers) -> list[Any]:
        """The states at which the branches are held."""
        return [n[HELD + state.name] for state in self.film.states]

    @property
    def linear_charge(self) -> bool:  # type: ignore[override]
        """Whether the charge is proportional to the voltage at every displacement."""
        return self.film.linear_charge

    @property
    def kinds(self) -> tuple[str, ...]:  # type: ignore[override]
        """The states of the film whose shares of time results carry."""
        return self.film.kinds

    def force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        return self.film.force(x, squared, self.held(n), n, xp)

    def odd(self, n: Numbers) -> Any:
        return self.film.odd(n)

    def switches(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> dict[str, Any]:
        return self.film.switches(x, squared, self.held(n), n)

    def strain(self, x: Any, n: Numbers) -> Any:
        return self.film.strain(x, n)

    def strain_limit(self, n: Numbers) -> Any:
        return self.film.strain_limit(n)

    def reach(self, n: Numbers) -> tuple[float, float]:
        """The displacements at which neither the law nor a branch is at its limit."""
        begin, end = self.film.reach(n)
        far = min(end, FARTHEST_SEARCHED)
        if not np.any(self.film.overstretched(far, self.held(n), n)):
            return begin, end
        limit = rise(lambda x: np.where(self.film.overstretched(x, self.held(n), n), 1.0, -1.0), 0.0 * far, far)
        return begin, float(limit)

    def outside(self, x: float, n: Numbers) -> str:
        return self.film.outside(x, n)

    def unreachable(self, n: Numbers) -> str:
        return self.film.unreachable(n)

    def highest_squared(self, x: Any, n: Numbers) -> Any:
        if not isinstance(self.film, WrinklingCone | MembraneFilm):
            return super().highest_squared(x, n)
        return self.film.creeping.highest_squared(x, self.held(n), n)

    def balancing(self, x: Any, pull: Any, n: Numbers) -> Any:
        """Solve force = ``pull`` x for V. A film that wrinkles cannot push: for a negative ``pull`` V rises too steeply
        to be reached."""
        if not isinstance(self.film, WrinklingCone | MembraneFilm):
            return super().balancing(x, pull, n)
        squared = self.film.creeping.balancing(x, np.maximum(pull, 0.0), self.held(n), n)
        return squared - STEEP * np.minimum(pull, 0.0)

    def turning(self, x: Any, squared: Any, n: Numbers) -> Any:
        return np.nan_to_num(super().turning(x, squared, n))  # 0 beyond the valley, where the film does not pull

    def stiffness_scale(self, n: Numbers) -> Any:
        return self.film.stiffness_scale(n)

    def work(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> Any:
        return self.film.work(x, squared, self.held(n), n)

    def capacitance(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        return self.film.capacitance(x, squared, self.held(n), n, xp)

    def fitted_capacitance(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> Any:
        return self.film.fitted_capacitance(x, squared, self.held(n), n)

    def state(self, x: Any, voltage: Any, y: list[Any], n: Numbers) -> FilmState:
        return self.film.state(x, voltage, self.held(n), n)

    def limit_share(self, x: Any, voltage: Any, y: list[Any], n: Numbers, state: FilmState | None = None) -> Any:
        return self.film.limit_share(x, voltage, self.held(n), n, state)


def films_at_once(model: Ensemble, states: Array | None = None) -> Members:
    """Return the members with films whose branches do not relax; the same members where no film has states.

    The branches are held at ``states`` (members, N). Default: those of a run from rest without voltage.
    """
    members = model.members()
    system = members.system
    if not any(film.states for film in system.films):
        return members
    if states is None:
        rest = np.reshape(rest_displacements(members), -1)
        disc = np.stack([np.nan_to_num(rest), np.zeros(members.size)], axis=1)
        states = members.start_states(disc)
    films = tuple(
        dataclasses.replace(film, film=FilmAtOnce(film.film)) if film.states else film for film in system.films
    )
    names = [state.name for state in system.states]
    held = {
        film.prefix + HELD + state.name.removeprefix(film.prefix): states[:, names.index(state.name, len(DISC))]
        for film in system.films
        for state in film.states
    }
    return Members(dataclasses.replace(system, films=films), {**members.values, **held}, members.size)
