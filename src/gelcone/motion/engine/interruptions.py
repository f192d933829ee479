"""Where the equations of motion of a system change: at the borders of its films and at the corners of its drive."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from gelcone.motion.engine.events import Event
from gelcone.physics.drive import CORNER, SIDE
from gelcone.physics.film.film import Border
from gelcone.physics.system import ConeSystem
from gelcone.quantity import Array, spread

OwnNumbers = Callable[[Mapping[str, Any]], Mapping[str, Any]]
"""A system's numbers from those of the program that holds it."""


def border_events(system: ConeSystem, own: OwnNumbers = lambda numbers: numbers) -> list[Event]:
    """The borders of the films as events of a program: those of the film, then those of the second one."""
    events = [_event(border, own, system.film_voltage, system.split) for border in system.film.borders]
    if system.second is not None:
        second = system.second_voltage, system.split_second
        events += [_event(border, own, *second) for border in system.second.borders]
    return events


def corner_numbers(system: ConeSystem) -> dict[str, Any]:
    """The options of a program whose drive has corners; none where it is smooth."""
    return {"corner_switch": SIDE, "corner_time": CORNER} if system.waveform.corners else {}


def corner_times(system: ConeSystem, start: Array, end: Array, numbers: Mapping[str, Any]) -> Array | None:
    """The times between at which the drive is not smooth, (members, corners); None where it is smooth throughout."""
    return system.waveform.corners_between(start, end, numbers).later if system.waveform.corners else None


def switches_at(system: ConeSystem, times: Array, states: Array, numbers: Mapping[str, Any]) -> dict[str, Array]:
    """The switches of the films and of the drive by name, as ``times`` (members,) and ``states`` (members, N) give
    them."""
    z = list(states.T)
    found = system.switches_under(system.waveform.voltage(times, numbers), z, numbers)
    if system.waveform.corners:
        there = system.waveform.corners_between(times, times, numbers)
        found |= {SIDE: there.side, CORNER: there.passed}
    return {name: spread(value, times.shape) for name, value in found.items()}


def _event(border: Border, own: OwnNumbers, voltage_of: Callable[..., Any], split: Callable[..., Any]) -> Event:
    """A border of a film as an event. The rates are continuous there, so that tangent maps go on."""

    def value(time: Any, state: Sequence[Any], n: Mapping[str, Any], xp: Any) -> Any:
        numbers = own(n)
        voltage = voltage_of(time, state, numbers, xp)
        return border.value(state[0], voltage * voltage, split(state)[0], numbers, xp)

    return Event(
        value,
        direction=-1,
        switch=border.switch,
        inside=True,
        smooth=not border.jumps,
        seldom=border.seldom,
        tells=border.tells,
    )
