"""A system at rest under a constant command: its forces, and where its films have a state."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import Any

import numpy as np

from gelcone.physics.bias import summed
from gelcone.physics.circuit import Port
from gelcone.physics.component import Numbers
from gelcone.physics.structure import Line, Structure

BIAS_SHARE = "bias share"
"""Number of statics: the bias of the drive over the voltage of the first film, where the bias rises with it; without
this number the bias is that of the model."""


class SystemAtRest(Structure):
    """The forces of films and bias on a disc at rest, and the ends of the films' states."""

    def static_force(self, x: Any, squared: Any, n: Numbers) -> tuple[Any, Any]:
        """Force of films and bias at a constant squared voltage on the first film, and its slope by x."""
        return self.force_under(x, self.squares_at_rest(squared, n), n)

    def force_under(self, x: Any, squares: Sequence[Any], n: Numbers) -> tuple[Any, Any]:
        """The static force, and its slope by x, at constant squared voltages on the films."""
        first, *others = (film.force(x, squared, [], n) for film, squared in zip(self.films, squares, strict=True))
        return summed([first, self.bias.force(x, [], n), *others])

    def squares_at_rest(self, squared: Any, n: Numbers) -> list[Any]:
        """Squared voltage on each film under a constant command, given that on the first."""
        return [
            squared if line.drive is None else self._voltage_at_rest(line, np.sqrt(squared), n) ** 2
            for line in self.film_lines
        ]

    def square_rates_at_rest(self, voltage: float, n: Numbers) -> list[float]:
        """Derivatives of `squares_at_rest` by the voltage on the first film."""
        return [
            2.0 * float(self._voltage_at_rest(line, voltage, n) * self.slope_at_rest(line, n))
            for line in self.film_lines
        ]

    def _voltage_at_rest(self, line: Line, voltage: Any, n: Numbers) -> Any:
        """The voltage of a line where that on the first film is ``voltage``; to films in opposite phase a share of the
        bias comes through the circuit."""
        gain = np.real(self.circuit.gain(0.0, n)) if line.drive == "opposite" else 1.0
        return gain * self.command_at_rest(line, voltage / gain, n)

    def leaking_at_rest(self, x: Any, voltages: Sequence[Any], n: Numbers) -> list[Any]:
        """Power that leaks through each film at displacements at rest and constant voltages on the films."""
        powers: dict[int, Any] = {}
        for line in self.lines:
            voltage = voltages[line.films[0]]
            port = Port(voltage, x, 0.0, lambda: 0.0, tuple((self.films[k], []) for k in line.films), n, np)
            leaks = line.circuit.held.leaks(port, [], n)
            powers |= {k: voltage * leak for k, leak in zip(line.films, leaks, strict=True)}
        return [powers[k] for k in range(len(self.films))]

    def command_at_rest(self, line: Line, command: Any, n: Numbers) -> Any:
        """The constant command of a line under one of the first that is not negative: it stands for both signs, as the
        mirror image of all voltages is the same actuator. The bias has its sign, unless a share of it is negative."""
        if line.drive != "opposite":
            return self.command_of(line, command, n)
        bias = n[BIAS_SHARE] * command if BIAS_SHARE in n else np.abs(n["voltage_bias"])
        return 2.0 * bias - command

    def slope_at_rest(self, line: Line, n: Numbers) -> float:
        """The slope of `command_at_rest` by the command of the first line."""
        more = 2.0 * n.get(BIAS_SHARE, 0.0) if line.drive == "opposite" else 0.0
        return self.command_slope(line) + more

    # --- where the films have a state --------------------------------------------------------------------------------

    def pulled_in(self, x: Any, squared: Any, n: Numbers) -> Any:
        """Mask of the x at which a film has pulled in, at a constant squared voltage on the first."""
        pulled_in = False
        for film, square in zip(self.films, self.squares_at_rest(squared, n), strict=True):
            pulled_in = pulled_in | (square > film.highest_squared(x, n))
        return pulled_in

    def strain(self, x: Any, n: Numbers) -> Any:
        """The film's measure of strain; of several films the largest share of their limits, or the largest measure if
        none has a limit."""
        strains = [film.strain(x, n) for film in self.films]
        if len(strains) == 1:
            return strains[0]
        limits = [film.strain_limit(n) for film in self.films]
        shares = [strain / limit for strain, limit in zip(strains, limits, strict=True)]
        endless = reduce(np.logical_and, map(np.isinf, limits))
        return np.where(endless, reduce(np.maximum, strains), reduce(np.maximum, shares))[()]

    def overstretched(self, z: Sequence[Any], n: Numbers) -> Any:
        """Whether the states of a film exceed their limit."""
        overstretched = [film.overstretched(z[0], self.states_of(z, "film", k), n) for k, film in enumerate(self.films)]
        return reduce(np.logical_or, overstretched)

    def strain_limit(self, n: Numbers) -> Any:
        """The limit that `strain` cannot reach."""
        limits = [film.strain_limit(n) for film in self.films]
        if len(limits) == 1:
            return limits[0]
        return np.where(reduce(np.logical_and, map(np.isinf, limits)), np.inf, 1.0)[()]

    def outside(self, x: float, n: Numbers) -> str:
        """The message for a start at which a film of a single actuator has no state, with the remedy."""
        lost = [film for film in self.films if not film.strain(x, n) < film.strain_limit(n)]
        return (lost or self.films)[0].outside(x, n)

    def unreachable(self, n: Numbers) -> str:
        """The message for a single actuator without a state at any displacement, with the remedy."""
        lost = [film for film in self.films if np.isnan(film.reach(n)[2])]
        if lost or len(self.films) == 1:
            return (lost or self.films)[0].unreachable(n)
        return (
            f"second_flat_height = {float(n['second_flat_height']):g}: so far from 0 that no displacement lies inside "
            "the stretch limits of both films; bring it closer to 0 or raise the limits"
        )
