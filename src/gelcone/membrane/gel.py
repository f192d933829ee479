"""One ring of a wrinkling membrane: tensions and tangent stiffness of the relaxed energy under voltage.

m and n are the squared true meridional and hoop length over the mounted ones, A = lm^2, B = lh^2 and G = 1/(A B) of the
pre-stretches, V the squared voltage. A ring has the energy phi = W(A m + B n + G/(m n) - 3) - V m n/2 per mounted
volume over mu. Its hoop is held (n = l2^2) while it is in tension, and takes the natural width n > l2^2 of zero hoop
stress where it would be compressed: the ring then wrinkles along its meridian (tension-field theory, see
`gelcone.physics.film.wrinkling`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from gelcone.bracket import rise
from gelcone.membrane.crumpling import MOST_STRETCHED, Law, crumpling, turnings
from gelcone.quantity import taken

Array = np.ndarray[Any, np.dtype[Any]]
ENOUGH = 25
"""Newton iterations that find a natural width from any start."""


class Ring(NamedTuple):
    """Derivatives of a ring's energy by l1 and l2: T1, T2, T11, T12 and T22; and its squared width n."""

    meridional: Array
    hoop: Array
    tangent_stiffness: Array
    coupling: Array
    hoop_tangent_stiffness: Array
    width: Array


@dataclass(frozen=True)
class Gel:
    """A strain-energy law with its numbers, and the squares of the meridional and hoop pre-stretch."""

    law: Law
    numbers: Mapping[str, float]
    A: float
    B: float

    @property
    def G(self) -> float:
        """The squared stretch through the thickness, 1/(A B), of the mounted film."""
        return 1.0 / (self.A * self.B)

    @property
    def has_rims(self) -> bool:
        """True for a film whose hoop is stretched, and more than its meridian: when raised from the plane it falls
        slack between rims whose hoop is taut."""
        return self.A < self.B and self.B > 1.0

    @property
    def strain_limit(self) -> float:
        """The largest I1 - 3 of its law."""
        return float(self.law.strain_limit(self.numbers))

    def strain(self, m: Array, n: Array) -> Array:
        """I1 - 3."""
        strain: Array = self.A * m + self.B * n + self.G / (m * n) - 3.0
        return strain

    def natural(self, m: Array, V: Array, guess: Array, steps: int = ENOUGH) -> Array:
        """The squared width n of zero hoop stress, B - r/n = V m K with r = G/(m n) and the compliance K.

        The left side less the right one rises and is concave (Gent, neo-Hookean), so that Newton's method converges
        from below. Iterations continue only for widths that neither stay nor alternate between two values.
        """
        widths, places = np.array(guess, dtype=float), np.arange(np.size(guess))
        gel, n, Am, Vm = self, widths.copy(), self.A * m, V * m
        before, least = np.full_like(n, np.nan), np.sqrt(self.G / (self.B * m))
        for remaining in reversed(range(steps)):
            r = gel.G / (m * n)
            strain, thin = Am + gel.B * n + r - 3.0, gel.B - r / n
            excess = thin - Vm * gel.law.compliance(strain, gel.numbers)
            slope = 2.0 * r / (n * n) + Vm * gel.law.stiffening(strain, gel.numbers) * thin
            after = np.minimum(np.maximum(n - excess / slope, np.maximum(least, 0.4 * n)), 3.0 * n)
            swings = after == before
            widths[places] = np.where(swings, n, after) if remaining % 2 else after
            moves = ~(swings | (after == n) | np.isnan(after))
            before, n = n, after
            if 2 * np.count_nonzero(moves) > n.size:
                continue
            if not moves.any():
                break
            gel = gel._of(moves)
            places, before, n, m, Am, Vm, least = (array[moves] for array in (places, before, n, m, Am, Vm, least))
        return widths

    def _of(self, places: Array) -> Gel:
        """The gel at the places of a mask, if its numbers are arrays over places."""
        numbers = {name: taken(value, places) for name, value in self.numbers.items()}
        return Gel(self.law, numbers, taken(self.A, places), taken(self.B, places))

    def width(self, l1: Array, l2: Array, V: Array) -> Array:
        """The squared width of rings, natural where their hoop is slack."""
        return self.width_of(l1, l2, V, self.hoop(l1, l2, V) < 0.0)

    def width_of(
        self, l1: Array, l2: Array, V: Array, slack: Array, guess: Array | None = None, steps: int = ENOUGH
    ) -> Array:
        """The squared width of rings, natural where ``slack``: near ``guess``, or by default from a width below it."""
        m, n = l1 * l1, l2 * l2
        if not slack.any():
            return n
        guess = np.maximum(n, np.sqrt(self.G / (self.B * m))) if guess is None else guess
        n, m, V, guess = np.broadcast_arrays(n, m, V, guess)
        widths = n.copy()
        widths[slack] = self._of(slack).natural(m[slack], V[slack], guess[slack], steps)
        return widths

    def hoop(self, l1: Array, l2: Array, V: Array) -> Array:
        """K times the hoop stress of an unwrinkled ring: negative where it wrinkles."""
        m, h = l1 * l1, l2 * l2
        r = self.G / (m * h)
        compliance = self.law.compliance(self.A * m + self.B * h + r - 3.0, self.numbers)
        stress: Array = self.B * h - r - V * m * h * compliance
        return stress

    def ring(self, l1: Array, l2: Array, V: Array, slack: Array, n: Array) -> Ring:
        """Tensions of rings of the squared widths n; ``slack`` is the mask of those whose hoop is slack."""
        m = l1 * l1
        r = self.G / (m * n)
        strain, along, across = self.A * m + self.B * n + r - 3.0, self.A - r / m, self.B - r / n
        response = 1.0 / self.law.compliance(strain, self.numbers)
        rise = 0.5 * self.law.stiffening(strain, self.numbers) * (response * response)
        by_m, by_n = 0.5 * (response * along - V * n), 0.5 * (response * across - V * m)
        firm = response * r
        by_mm = rise * along * along + firm / (m * m)
        by_mn = rise * along * across + 0.5 * (firm / (m * n) - V)
        by_nn = rise * across * across + firm / (n * n)
        softer = np.where(slack, by_mn * by_mn / by_nn, 0.0)
        held = ~slack
        return Ring(
            2.0 * l1 * by_m,
            held * (2.0 * l2 * by_n),
            2.0 * by_m + 4.0 * m * (by_mm - softer),
            held * (4.0 * l1 * l2 * by_mn),
            held * (2.0 * by_n + 4.0 * n * by_nn),
            n,
        )

    def at(self, l1: Array, l2: Array, V: Array) -> Ring:
        """Tensions of rings, after finding which hoops are slack and the natural widths of these."""
        l1, l2, V = np.broadcast_arrays(l1, l2, V)
        slack = self.hoop(l1, l2, V) < 0.0
        return self.ring(l1, l2, V, slack, self.width_of(l1, l2, V, slack))

    # --- an equibiaxially stretched film without stress ---------------------------------------------------------------

    def crumpling(self, t: Any) -> Any:
        """Vb(t), see `crumpling`."""
        return crumpling(self.law, t, self.numbers)

    def natural_stretch(self, V: Array) -> Array:
        """The t >= 1 with Vb(t) = V G; at voltages above the hump of Vb the t of the hump."""
        highest = np.full_like(V, min(self.hump(), MOST_STRETCHED))
        return np.asarray(rise(lambda t: self.crumpling(t) - V * self.G, np.ones_like(V), highest))

    def hump(self) -> float:
        """The t of the first maximum of Vb; infinite without one."""
        return float(turnings(self.law, self.numbers)[0])
