"""Changes of a system's equations of motion: borders of films and circuits, and corners of the drive."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from gelcone.motion.engine.events import Event
from gelcone.physics.drive import PIECE
from gelcone.physics.film.film import Border
from gelcone.physics.system import ConeSystem
from gelcone.quantity import Array, spread

OwnNumbers = Callable[[Mapping[str, Any]], Mapping[str, Any]]
"""Function from a program's numbers to those of its system."""


def border_events(system: ConeSystem, own: OwnNumbers = lambda numbers: numbers) -> list[Event]:
    """The borders of a system's films and circuits as events of a program, in their order."""
    smooth = not system.charged
    return [_event(border, own, smooth) for _, border in system.borders]


def corner_numbers(system: ConeSystem) -> dict[str, Any]:
    """Options of a program whose drive has corners; none for a smooth drive."""
    return {"pieces": PIECE} if system.waveform.pieced else {}


def corner_times(system: ConeSystem, start: Array, end: Array, numbers: Mapping[str, Any]) -> dict[str, Any]:
    """Options of a run of a program: the corners of the drive between two times; none for a smooth drive."""
    if not system.waveform.pieced:
        return {}
    corners = system.waveform.corners_between(start, end, numbers)
    return {"corners": corners.later, "terms": (corners.terms, corners.first)}


def switches_at(system: ConeSystem, times: Array, states: Array, numbers: Mapping[str, Any]) -> dict[str, Array]:
    """Switches of films, circuits and drive by name at ``times`` (members,) and ``states`` (members, N)."""
    switches = system.switches(times, list(states.T), numbers)
    if system.waveform.pieced:
        corners = system.waveform.corners_between(times, times, numbers)
        switches |= dict(zip(PIECE, corners.passed.T, strict=True))
    return {name: spread(value, times.shape) for name, value in switches.items()}


def _event(border: Border, own: OwnNumbers, smooth: bool) -> Event:
    """A border as an event.

    The rates, and so tangent maps, are continuous there, except for the voltage behind a resistance, with which they
    are not ``smooth``: deviations are then those of its charge.
    """

    def value(time: Any, state: Sequence[Any], n: Mapping[str, Any], xp: Any) -> Any:
        return border.value(time, state, own(n), xp)

    return Event(
        value,
        direction=-1,
        switch=border.switch,
        inside=True,
        smooth=smooth and not border.jumps,
        seldom=border.seldom,
        divides=border.divides,
        gentle=border.gentle,
    )
