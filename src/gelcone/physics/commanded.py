"""Statics under a constant command, where films do not rest at the commanded voltage.

A film that leaks rests at less than the voltage of a source behind a resistance, and one with a commanded charge at a
voltage that falls as its capacitance grows. With the disc held at x a film rests at the voltage v whose command c(x, v)
is the given one; c rises with v. The equilibria are those of `gelcone.physics.balance`: where a film's squared voltage
w(x) holds the disc the command is c(x, sqrt(w)), and the disc is stable where that command grows with |x|, so that
folds lie where it turns.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone.bracket import rise
from gelcone.physics.balance import NEAR_PULL_IN, NO_LOSS, STAYS, Loss, StaticBalance, single_balance
from gelcone.physics.circuit import Port
from gelcone.physics.component import Numbers
from gelcone.physics.pair import PairBalance, pair_balance
from gelcone.physics.structure import Line
from gelcone.physics.system import ConeSystem
from gelcone.quantity import Array

STEP = 6e-6
"""Change of displacement and voltage, relative to 1 + |x| and v, over which the slopes of a command are computed."""
LEAST, MOST = 1e-16, 1e16
"""Bounds of the squared voltages at which the ratio of command to voltage is computed."""
NEXT = 1e-9
"""Relative distance from a fold at which the command of an equilibrium is finite, unless it ends there."""
DOUBLINGS = 60
"""Most doublings in the search for a voltage above that of a command."""


def rest_at_command(system: ConeSystem, n: Numbers) -> bool:
    """Whether all films rest at the commanded voltages."""
    return all(line.circuit.rests_at_command(line.own(n)) for line in system.lines)


def command_at(system: ConeSystem, line: Line, x: Any, voltage: Any, n: Numbers) -> Any:
    """The constant command of a line under which its films rest at a ``voltage``, with the disc held at x."""
    if line.circuit.rests_at_command(line.own(n)):
        return voltage
    with np.errstate(all="ignore"):
        return _commands(system, line, n)(x, voltage)


def _commands(system: ConeSystem, line: Line, n: Numbers) -> Callable[[Any, Any], Any]:
    """The command of a line whose films do not rest at it, over displacement and voltage."""
    numbers, films = line.own(n), tuple((system.films[k], list[Any]()) for k in line.films)
    return lambda x, voltage: line.circuit.commanded(Port(voltage, x, 0.0, lambda: 0.0, films, n, np), voltage, numbers)


def voltage_under(system: ConeSystem, line: Line, x: Any, command: Any, n: Numbers) -> Any:
    """The voltage at which the films of a line rest under a constant ``command`` of either sign, with the disc held at
    x; above that of pull-in where they have no state there."""
    if line.circuit.rests_at_command(line.own(n)):
        return np.abs(command)
    x, command = np.broadcast_arrays(np.asarray(x, dtype=float), np.abs(np.asarray(command, dtype=float)))
    if not command.any():
        return np.where(np.isnan(x), np.nan, command)[()]

    command_of = _commands(system, line, n)

    def excess(v: Any) -> Any:
        commanded = command_of(x, v) if v.any() else v
        return np.where(np.isnan(commanded), np.inf, commanded) - command

    with np.errstate(all="ignore"):
        limits = [np.asarray(system.films[k].highest_squared(x, n), dtype=float) for k in line.films]
        highest = np.sqrt(NEAR_PULL_IN * np.fmin.reduce(limits)) + 0.0 * command
        high = np.minimum(highest, 1.0 + command)
        for _ in range(DOUBLINGS):
            low = excess(high) < 0.0
            if not (low & (high < highest)).any():
                break
            high = np.where(low, np.minimum(2.0 * high, highest), high)
        voltage = rise(excess, np.zeros(command.shape), high)
        if low.any():
            voltage = np.where(low, high * command / command_of(x, high), voltage)
        return np.where(np.isnan(x), np.nan, voltage)[()]


class _Slopes(NamedTuple):
    """Derivatives of a line's command by displacement and by voltage."""

    x: Any
    voltage: Any


def _slopes_of_command(system: ConeSystem, line: Line, x: Any, voltage: Any, n: Numbers) -> _Slopes:
    """The slopes at voltages above 0, next to that of pull-in at one slightly below; not finite where the limit of
    the current holds the film's voltage."""
    if line.circuit.rests_at_command(line.own(n)):
        return _Slopes(0.0 * voltage, 1.0 + 0.0 * voltage)
    x, voltage = np.broadcast_arrays(x, voltage)
    h = STEP * (1.0 + np.abs(x))
    near = np.stack([x - h, x, x + h])
    limits = [np.fmin.reduce(system.films[k].highest_squared(near, n), axis=0) for k in line.films]
    voltage = np.fmin(voltage, np.sqrt(np.fmin.reduce(limits)) * (1.0 - 2.0 * STEP))
    volts = np.stack([voltage, voltage, voltage * (1.0 + STEP), voltage * (1.0 - STEP)])
    above, below, more, less = command_at(system, line, np.stack([x + h, x - h, x, x]), volts, n)
    return _Slopes((above - below) / (2.0 * h), (more - less) / (2.0 * STEP * voltage))


class _Commanded(StaticBalance):
    """A balance whose squared voltages are those of the command of the first line."""

    def films(self, x: Any, squared: Any) -> list[Any]:
        return [film.squared for film in self._at(x, squared, slopes=False)]

    def _at(self, x: Any, squared: Any, slopes: bool = True) -> list[_Film]:
        """The films at displacements under squared commands."""
        system, n, films = self.system, self.n, dict[int, _Film]()
        command = np.sqrt(np.asarray(squared, dtype=float))
        for line in system.lines:
            line_command, share = system.command_at_rest(line, command, n), system.slope_at_rest(line, n)
            v = voltage_under(system, line, x, line_command, n)
            by_x, by_command = 0.0 * v, 0.0 * v
            if slopes:
                slope = _slopes_of_command(system, line, x, np.maximum(v, math.sqrt(LEAST)), n)
                by_x, by_command = (
                    -2.0 * v * slope.x / slope.voltage,
                    2.0 * v * share * np.sign(line_command) / slope.voltage,
                )
                if (limited := ~np.isfinite(slope.voltage)).any():
                    h = STEP * (1.0 + np.abs(x))
                    above, below = (voltage_under(system, line, x + step, line_command, n) ** 2 for step in (h, -h))
                    by_x = np.where(limited, (above - below) / (2.0 * h), by_x)
            films |= dict.fromkeys(line.films, _Film(v * v, by_x, by_command))
        return [films[k] for k in range(len(system.films))]

    def force(self, x: Any, squared: Any) -> Any:
        with np.errstate(all="ignore"):
            x = np.asarray(x, dtype=float)
            return self.system.force_under(x, self.films(x, squared), self.n)[0]

    def force_and_slope(self, x: Any, squared: Any) -> tuple[Any, Any]:
        """The force, and dF/dx at a constant command, under which the films' voltages follow the disc."""
        x = np.asarray(x, dtype=float)
        with np.errstate(all="ignore"):
            return self._changes(x, self._at(x, squared))[:2]

    def _changes(self, x: Any, at: list[_Film]) -> tuple[Any, Any, Any]:
        """F, dF/dx and minus dF/dc by the command c."""
        force, slope = self.system.force_under(x, [film.squared for film in at], self.n)
        gain: Any = 0.0
        for film, film_square in zip(self.system.films, at, strict=True):
            by_square = film.voltage_gain(x, film_square.squared, self.n)
            slope = slope - np.where(film_square.by_x == 0.0, 0.0, by_square * film_square.by_x)
            gain = gain + by_square * film_square.by_command
        return force, slope, gain

    def whole(self, x: Array, squared: Array) -> npt.NDArray[np.bool_]:
        with np.errstate(all="ignore"):
            whole = self.inside(x)
            for film, square in zip(self.system.films, self.films(x, squared), strict=True):
                whole = whole & ~np.asarray(square > film.highest_squared(x, self.n))
            return whole

    def losses(self, rest: float) -> list[Loss]:
        losses = super().losses(rest)
        return [NO_LOSS if math.isinf(loss.voltage) and loss.kind not in STAYS else loss for loss in losses]


class _Film(NamedTuple):
    """The squared voltage on a film, and its derivatives by the displacement and by the command."""

    squared: Any
    by_x: Any
    by_command: Any


@dataclass(frozen=True)
class CommandedBalance(_Commanded):
    """One actuator with one film under a constant command."""

    @property
    def implicit(self) -> bool:
        return True

    def _ratio(self, x: Any, squared: Any) -> Any:
        """The command over the voltage on the film, squared, at a squared voltage on the film."""
        voltage = np.sqrt(np.clip(squared, LEAST, MOST))
        return (command_at(self.system, self.system.lines[0], x, voltage, self.n) / voltage) ** 2

    def highest_at(self, x: Any) -> Any:
        highest = super().highest_at(x)
        return highest * self._ratio(x, NEAR_PULL_IN * highest)

    def folds(self) -> list[tuple[float, float]]:
        """The folds of the balance, but those next to which no command is high enough."""
        around = np.array([1.0 - NEXT, 1.0, 1.0 + NEXT])
        return [(v, x) for v, x in super().folds() if np.isfinite(self.squared(x * around)).all()]

    def curves(self, highest: float) -> list[Array]:
        """The curves of the balance; where the limit of the current holds the film's voltage, the disc stays at its
        place up to the highest command."""
        return [self._to_the_limit(rows, highest) for rows in super().curves(highest)]

    def _to_the_limit(self, rows: Array, highest: float) -> Array:
        """A curve with a point at the ``highest`` command at each end next to which no command is high enough."""
        around = np.array([1.0 - NEXT, 1.0 + NEXT])
        for k, at in ((0, 0), (-1, rows.shape[1])):
            x, command = rows[0, k], rows[1, k]
            if command < highest and np.isinf(self.squared(x * around)).any():
                rows = np.insert(rows, at, [x, highest, rows[2, k]], axis=1)
        return np.stack([rows[0], np.minimum(rows[1], highest), rows[2]])

    def squared(self, x: Any) -> Any:
        with np.errstate(all="ignore"):
            on_film = self.balancing(x)
            highest = NEAR_PULL_IN * np.asarray(StaticBalance.highest_at(self, x))
            return on_film * self._ratio(x, np.minimum(on_film, highest))

    def excess(self, x: Any) -> Any:
        """w(x) over the pull-in V, less 1, of the film's voltages, with which the command rises: commands may be
        infinite at both."""
        if not self.film_fails:
            return super().excess(x)
        return self.balancing(x) / super().highest_at(x) - 1.0

    def turning(self, x: Any) -> Any:
        with np.errstate(all="ignore"):
            highest = NEAR_PULL_IN * np.asarray(StaticBalance.highest_at(self, x))
            on_film = np.clip(np.nan_to_num(self.balancing(x), nan=0.0, posinf=0.0, neginf=0.0), 0.0, highest)
            voltage = np.sqrt(np.maximum(on_film, LEAST))
            slope = _slopes_of_command(self.system, self.system.lines[0], x, voltage, self.n)
            more = x * self.system.film.voltage_gain(x, on_film, self.n) * 2.0 * on_film * slope.x
            turning = super().turning(x) + more / (voltage * slope.voltage)
            return np.where(np.isfinite(turning), turning, np.copysign(1.0, x))  # no command takes the disc beyond


@dataclass(frozen=True)
class CommandedPair(_Commanded, PairBalance):
    """One double cone under a constant command."""

    def _slopes(self, x: float, voltage: float) -> tuple[float, float, float]:
        place = np.float64(x)
        with np.errstate(all="ignore"):
            force, slope, gain = self._changes(place, self._at(place, np.float64(voltage * voltage)))
        return float(force), float(slope), -float(gain)


def under_commands(system: ConeSystem, n: Mapping[str, Any]) -> StaticBalance:
    """Make a balance for forces alone, also of many actuators: the numbers may be arrays."""
    if rest_at_command(system, n):
        return StaticBalance(system, n, math.nan, math.nan, False)
    return _Commanded(system, n, math.nan, math.nan, False)


def commanded_balance(system: ConeSystem, n: Mapping[str, Any]) -> StaticBalance:
    """Make the balance of an actuator under constant commands."""
    if len(system.films) > 1:
        pair = pair_balance(system, n)
        return pair if rest_at_command(system, n) else CommandedPair(system, n, pair.lowest, pair.highest, pair.wall)
    one = single_balance(system, n)
    return one if rest_at_command(system, n) else CommandedBalance(system, n, one.lowest, one.highest, one.wall)
