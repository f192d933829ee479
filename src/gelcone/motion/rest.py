"""Films and circuits at rest under a constant command, with the disc held at a displacement."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np

from gelcone.motion.regular import solved_where_regular
from gelcone.physics.commanded import voltage_under
from gelcone.physics.differentiate import Gradients
from gelcone.physics.model import ConeModel
from gelcone.physics.structure import DISC
from gelcone.physics.system import ConeSystem
from gelcone.quantity import Array

NEWTON_STEPS, SAME = 20, 1e-13
"""Most steps of Newton's method, and the change of a state that ends them."""
MOST_SIDES = 5
"""Most searches for the rest of circuits, until they are on the sides of their borders that it assumed: an amplifier
whose limit the leak exceeds is at its limit at rest."""
COMMAND, SQUARE = "constant command", "squared voltage on film"
"""Names of the command and of the squared voltages among the numbers of a search for rest."""

Rates = Callable[[list[Any], Mapping[str, Any], Any], list[Any]]


def rest_under(model: ConeModel, place: float, command: float) -> Array:
    """All states (N,) of a single actuator at rest under a constant command, with the disc held at a ``place``; the
    bias has the sign of the command (`gelcone.motion.constant_voltage.biased_like`)."""
    system, n = model.system, model.numbers()
    z = list(model.members().start_states((place, 0.0))[0])
    if system.mechanical[len(DISC) :]:
        commands = ((line, system.command_of(line, command, n)) for line in system.film_lines)
        volts = [voltage_under(system, line, z[0], commanded, n) for line, commanded in commands]
        z = films_at_rest(system, [v * v for v in volts], z, n)
    return np.array(circuits_under(system, command, z, n), dtype=float)


def circuits_under(system: ConeSystem, command: Any, z: Sequence[Any], n: Mapping[str, Any]) -> list[Any]:
    """The states ``z`` of one actuator or, as arrays, of several, with those of circuits at rest under constant
    ``command``s, on the sides of their borders on which they rest; films are unchanged."""
    z = uncurrented(system, command, z, n)
    switches: dict[str, Any] | None = None
    for _ in range(MOST_SIDES if len(system.mechanical) < len(z) else 0):
        before, switches = switches, system.under(command, z, n).switches()
        if before is not None and all(np.array_equal(before[name], side) for name, side in switches.items()):
            break
        z = circuits_at_rest(system, command, z, {**n, **switches})
    return z


def films_at_rest(system: ConeSystem, squares: Sequence[Any], z: Sequence[Any], n: Mapping[str, Any]) -> list[Any]:
    """The states ``z`` with those of films and bias at rest at constant squared voltages on the films."""
    mechanical = system.mechanical[len(DISC) :]
    relaxed = dict(zip(mechanical, system.relaxed(z[0], squares, n), strict=True))
    z = [
        value if relaxed.get(i) is None else np.broadcast_to(relaxed[i], np.shape(z[0]))[()]
        for i, value in enumerate(z)
    ]
    places = [i for i in mechanical if relaxed[i] is None]
    if not places:
        return z
    with np.errstate(all="ignore"):
        for k, film in enumerate(system.films):
            n = {**n, **film.switches(z[0], squares[k], system.states_of(z, "film", k), n)}

        def rates(z: list[Any], n: Mapping[str, Any], xp: Any) -> list[Any]:
            every = system.rates_held([n[f"{SQUARE} {k}"] for k in range(len(squares))], z, n, xp)
            return [every[system.mechanical.index(i)] for i in places]

        n = {**n, **{f"{SQUARE} {k}": squared for k, squared in enumerate(squares)}}
        return at_rest(z, places, rates, Gradients(rates, len(z), tuple(n)), n)


def uncurrented(system: ConeSystem, command: Any, z: Sequence[Any], n: Mapping[str, Any]) -> list[Any]:
    """The states ``z`` with those of circuits at which no current flows under a constant ``command`` but the leak. The
    search for rest starts there: with a film without voltage an amplifier may be at its limit."""
    z = list(z)
    for line in system.lines:
        line_command = system.command_of(line, command, n)
        for i in system.places_of(line):
            z[i] = np.broadcast_to(line_command, np.shape(z[0]))[()]
        if line.circuit.carries_voltage and not line.circuit.rests_at_command(line.own(n)):
            z[system.places_of(line)[-1]] = np.sign(line_command) * voltage_under(system, line, z[0], line_command, n)
    return z


def circuits_at_rest(system: ConeSystem, command: Any, z: list[Any], n: Mapping[str, Any]) -> list[Any]:
    """The states ``z`` with those of circuits at rest under a constant ``command``; films are unchanged."""
    places = [i for line in system.lines for i in system.places_of(line)]
    if not places:
        return z
    with np.errstate(all="ignore"):
        n = {**n, COMMAND: command}
        return at_rest(z, places, partial(_circuit_rates, system), _circuit_slopes(system, tuple(n)), n)


def _circuit_rates(system: ConeSystem, z: list[Any], n: Mapping[str, Any], xp: Any) -> list[Any]:
    """Rates of change of the states of all circuits at a constant command."""
    return [rate for line in system.lines for rate in system.electric(line, n[COMMAND], 0.0, z, n, xp)[1:]]


@lru_cache(maxsize=64)
def _circuit_slopes(system: ConeSystem, names: tuple[str, ...]) -> Gradients:
    """The derivatives of the rates of all circuits by all states."""
    return Gradients(partial(_circuit_rates, system), len(system.states), names)


def at_rest(z: list[Any], places: list[int], rates: Rates, slopes: Gradients, n: Mapping[str, Any]) -> list[Any]:
    """The states with those at ``places`` changed so that their ``rates`` vanish, by Newton's method."""
    z = list(z)
    for _ in range(NEWTON_STEPS):
        by, now = stacked(slopes(z, n), z[0].shape)[..., places], stacked([rates(z, n, np)], z[0].shape)
        change = solved_where_regular(by, now[..., 0, :])
        for k, i in enumerate(places):
            z[i] = z[i] - change[..., k]
        if not np.nanmax(np.abs(change), initial=0.0) > SAME:
            break
    return z


def stacked(rows: Sequence[Sequence[Any]], shape: tuple[int, ...]) -> Array:
    """Rows and columns of arrays as matrices, ``shape`` + (rows, columns)."""
    return np.stack([np.stack([np.broadcast_to(value, shape) for value in row], axis=-1) for row in rows], axis=-2)
