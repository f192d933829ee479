"""A membrane that creeps, in a reduced form: branches that are stretched by one mean length of the film.

In a membrane each ring has branches of its own. Here all are stretched by the mean length M of the film without voltage
(`gelcone.membrane.mean_length`), with their hoop held, so that the film has the energy

    E(x, V) + psi(M(x^2); states),

whose first term is that of the relaxed membrane, and the force x K, K = k + M' t1/M with the stress t1 of the branches.
A relaxed film is the membrane itself. Before it has relaxed, its force differs from that of a membrane with branches in
every ring by some per cent of the force without voltage, in half of the films tried by less than 0.5 %
(``benchmarks/creeping_membrane.py``). It pulls in where the relaxed membrane does, which is on the safe side: a branch
in the ring that localises would withstand more for a while.

A film never pushes. Where K would be negative, because its branches have crept at a greater height, it hangs loose at
its natural height, at which K = 0, with the branches, hoops and charge of that height.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from gelcone.bracket import rise
from gelcone.membrane.force import Pull
from gelcone.membrane.mean_length import height_of, mean_length
from gelcone.physics.component import Numbers
from gelcone.physics.film.branches import Branches
from gelcone.physics.film.film import Border
from gelcone.physics.implicit import known, root, traced

FLAT = 1e-4
"""Squared height that is added to the natural one in its equation: in the flat state, where both the natural height and
K are 0, the equation would have a double root."""

ABOVE = 1.5
"""Multiple of the rise to the height at which the last branch is free, found to some per cent, that bounds the natural
height from above: the relaxed film of much greater heights may have pulled in."""


class Membrane(Protocol):
    """The relaxed membrane, as its branches use it."""

    @property
    def viscous(self) -> Branches:
        """The branches of the film."""

    @property
    def switch_names(self) -> tuple[str, ...]:
        """The names of the switches of its borders."""

    def relaxed_pull(self, s: Any, squared: Any, n: Numbers, xp: Any = np) -> tuple[Pull, Any]:
        """The pull of the relaxed film at the squared height ``s``, and 1 where it is in tension, else 0."""

    def balancing(self, x: Any, pull: Any, n: Numbers) -> Any:
        """The V at which the relaxed film has a ``pull``."""

    def highest_squared(self, x: Any, n: Numbers) -> Any:
        """The V at which the relaxed film pulls in."""


class CreepingMembrane:
    """The formulas of a ``film`` whose branches have states ``y``."""

    def __init__(self, film: Membrane) -> None:
        self.film = film

    def pull(self, s: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """K of a film that hangs at the squared height s, and its derivative by s."""
        length, slope, bend = mean_length(s, n)
        over, steeper = self.film.viscous.pull(length, y, n)
        relaxed, pulls = self.film.relaxed_pull(s, squared, n, xp)
        steeper = bend * over + slope * slope * steeper
        return pulls * relaxed.k + slope * over, pulls * relaxed.by_s + steeper

    def place(self, s: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """The squared height at which the film hangs where its disc is at ``s``, and 1 where it pulls, else 0."""
        if not traced(xp):
            return self._places(s, squared, y, n)
        pulls = 0.5 + 0.5 * n["in_tension"]
        if known(pulls) == 1.0:
            return s, pulls

        def residual(natural: Any, s: Any, squared: Any, *others: Any) -> Any:
            *y, xp = others
            # K alone bends down: from above, too far a step
            push = (natural + FLAT) * self.pull(natural, squared, y, n, xp)[0]
            return push if known(pulls) == 0.0 else pulls * (natural - s) + (1.0 - pulls) * push

        law = [n[name] for name in self.film.switch_names]
        name = f"natural height at {[xp.node(value).index for value in (s, squared, *law, *y)]}"
        near = 0.5 + 0.5 * n["near"]
        least = near * n["mean_begin"] + (1.0 - near) * xp.maximum(n["cut_squared"], n["mean_begin"])

        most = near * n["cut_squared"] + (1.0 - near) * n["reach_squared"]

        def first(s: Any, squared: Any, *others: Any) -> Any:
            """The height at which the last branch is free, within the piece of the force: the natural height lies below
            it, and far below that the formulas of the relaxed film do not hold."""
            *y, xp = others
            above = xp.maximum(xp.maximum(s, least), height_of(self.film.viscous.free_length(y, xp), n))
            return -xp.maximum(-above, -most)

        return root(xp, name, residual, (s, squared, *y), first), pulls

    def _places(self, s: Any, squared: Any, y: list[Any], n: Numbers) -> tuple[Any, Any]:
        s, squared, *y = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in (s, squared, *y)))
        with np.errstate(all="ignore"):
            least = np.maximum(s, n["mean_begin"])
            loose = (self.pull(least, squared, y, n)[0] < 0.0) | (s < least)
            if not loose.any():
                return s, np.ones(s.shape)
            free = height_of(self.film.viscous.free_length(y, np), n)
            most = np.clip(n["mean_begin"] + ABOVE * (free - n["mean_begin"]), least, np.maximum(n["reach_squared"], s))
            natural = rise(lambda at: np.nan_to_num(self.pull(at, squared, y, n)[0]), least, most)
        return np.where(loose, natural, s), np.where(loose, 0.0, 1.0)

    def lengths(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """The squared lengths to which the branches are stretched."""
        return mean_length(self.place(x * x, squared, y, n, xp)[0], n)[0], 1.0

    def force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> tuple[Any, Any]:
        """x K and its slope where the film pulls, else 0."""
        s = x * x
        if traced(xp):
            pulls = 0.5 + 0.5 * n["in_tension"]
            if known(pulls) == 0.0:
                return 0.0 * x, 0.0 * x
        else:
            pulls = self._places(s, squared, y, n)[1]
        pull, by_s = self.pull(s, squared, y, n, xp)
        return x * (pulls * pull), pulls * (pull + 2.0 * s * by_s)

    # --- held at its states ------------------------------------------------------------------------------------------

    def balancing(self, x: Any, pull: Any, y: list[Any], n: Numbers) -> Any:
        """The V at which K is ``pull``."""
        length, slope, _ = mean_length(np.maximum(np.square(x), n["mean_begin"]), n)
        return self.film.balancing(x, pull - slope * self.film.viscous.pull(length, y, n)[0], n)

    def highest_squared(self, x: Any, y: list[Any], n: Numbers) -> Any:
        """The V at which the relaxed film pulls in at x."""
        return self.film.highest_squared(x, n)

    # --- border ------------------------------------------------------------------------------------------------------

    @property
    def border(self) -> Border:
        """``in_tension`` is positive where the film pulls, and negative where it hangs loose."""
        return Border(self._loose_border, "in_tension", divides=True)

    def _loose_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        s, side = x * x, n["in_tension"]
        natural, pulls = self.place(s, squared, y, n, xp)
        if known(pulls) == 0.0:
            return -side * (natural - s)
        tight = side * pulls * self.pull(s, squared, y, n, xp)[0]
        return tight if known(pulls) == 1.0 else tight - side * (1.0 - pulls) * (natural - s)
