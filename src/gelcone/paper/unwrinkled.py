"""The film that bears compression, of the source paper, as a smooth function of displacement and voltage squared.

In the equation of motion the homogeneous cone pulls the disc back with x (h(q) - v^2). An `UnwrinkledFilm` stands in
for h - v^2, as `gelcone.paper.unwrinkled_fit.fit_unwrinkled` fits it to the membrane, as a function of s = x^2 and
V = v^2:

    k(s, V) = P(t) + w/(1 - s/wall) - V (1 - Q(t)) + V^2 R(t) + (1 - y - V C(t)/2) S(t),
    t = t0 + t1/(1 + s),    y = sqrt(1 - V C(t)).

P, Q, R, S and C are polynomials. The term with ``wall`` is the stretch limit of the film as a whole; 1/C(t) is the
highest V at which the film has a state (it pulls in at a fold, near which its force varies like the square root y).
Beyond either, k is NaN, and a trajectory that arrives there ends.

The film has no inertia, so any such force has an energy: the integral of x k over x.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gelcone.bracket import halved
from gelcone.codes import Outcome
from gelcone.physics.balance import NEAR_PULL_IN
from gelcone.physics.component import Numbers
from gelcone.physics.film.film import Film

Polynomial = tuple[float, ...]
"""Coefficients, constant first."""
BISECTIONS = 60


@dataclass(frozen=True, kw_only=True)
class UnwrinkledFilm(Film):
    """The fitted force of one film that does not wrinkle, of one geometry, law and pre-stretch.

    Parameters
    ----------
    radius_ratio : a/b.
    scale : a typical stiffness.
    largest : largest |x| that the fit covers.
    wall : s at which the film as a whole reaches its stretch limit, more than reach^2.
    variable : t0 and t1.
    rest, wall_strength, field, field_squared, fold, ceiling : P, w, Q, R, S and C.
    errors : what -> largest error of k over |k| + 0.3 V + 0.02, at the states that were fitted.
    """

    radius_ratio: float
    scale: float
    largest: float
    wall: float
    variable: tuple[float, float]
    rest: Polynomial
    wall_strength: float
    field: Polynomial
    field_squared: Polynomial
    fold: Polynomial
    ceiling: Polynomial
    errors: tuple[tuple[str, float], ...] = ()

    name = "unwrinkled"
    ending = Outcome.PULLED_IN

    def strain_limit(self, n: Numbers) -> Any:
        """The largest x^2 of the fit."""
        return np.asarray(self.largest * self.largest)

    def reach(self, n: Numbers) -> tuple[float, float]:
        """The displacements of the fit."""
        return 0.0, self.largest

    def stiffness_scale(self, n: Numbers) -> Any:
        """A typical stiffness of the film, for time scales."""
        return self.scale

    # --- terms of the equation of motion -----------------------------------------------------------------------

    def force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """x (k + V - V) and its slope, with the fitted k(s, V)."""
        s = x * x
        k, k_slope = self.stiffness(s, squared)
        k = k - squared
        return x * k, k + 2.0 * s * k_slope

    def stiffness(self, s: Any, squared: Any) -> tuple[Any, Any]:
        """k + V, which takes the place of the law's h, and its derivative by s.

        Works on floats, arrays and the expressions of compiled programs.
        """
        r = 1.0 / (1.0 + s)
        t = self.variable[0] + self.variable[1] * r
        powers = self._powers(t)
        t_slope = -self.variable[1] * r * r
        p, p_slope = _value(self.rest, powers), _slope(self.rest, powers)
        f, f_slope = _value(self.field, powers), _slope(self.field, powers)
        g, g_slope = _value(self.field_squared, powers), _slope(self.field_squared, powers)
        fold, fold_slope = _value(self.fold, powers), _slope(self.fold, powers)
        share = squared * _value(self.ceiling, powers)
        y = (1.0 - share) ** 0.5
        bend = 1.0 - y - 0.5 * share
        bend_slope = 0.5 * squared * _slope(self.ceiling, powers) * (1.0 / y - 1.0)
        value = p + squared * (f + squared * g) + bend * fold
        slope = (p_slope + squared * (f_slope + squared * g_slope) + bend * fold_slope + bend_slope * fold) * t_slope
        near = 1.0 / (1.0 - s * (1.0 / self.wall))
        value = value + self.wall_strength * near
        return value, slope + (self.wall_strength / self.wall) * near * near

    def gain(self, s: Any, squared: Any) -> Any:
        """-dk/dV: how fast the voltage weakens the film; 1 for the homogeneous cone."""
        powers = self._powers(self._t(s))
        ceiling = _value(self.ceiling, powers)
        y = (1.0 - squared * ceiling) ** 0.5
        bend_rate = 0.5 * ceiling * (1.0 / y - 1.0) * _value(self.fold, powers)
        linear = _value(self.field, powers) + 2.0 * squared * _value(self.field_squared, powers)
        return 1.0 - linear - bend_rate

    def _t(self, s: Any) -> Any:
        return self.variable[0] + self.variable[1] / (1.0 + s)

    def _powers(self, t: Any) -> list[Any]:
        most = max(len(p) for p in (self.rest, self.field, self.field_squared, self.fold, self.ceiling))
        powers = [1.0, t]
        while len(powers) < most:
            powers.append(powers[len(powers) // 2] * powers[(len(powers) + 1) // 2])
        return powers

    def voltage_gain(self, x: Any, squared: Any, n: Numbers) -> Any:
        """Derivative of the force by V, with the opposite sign."""
        return x * self.gain(np.square(x), squared)

    def balancing(self, x: Any, pull: Any, n: Numbers) -> Any:
        """V at which the film balances the pull k, by bisection: k falls with V. Beyond the V of pull-in, and below 0,
        it continues as in the cone."""
        x = np.asarray(x, dtype=float)
        s, highest = x * x, self.highest_squared(x, n)
        with np.errstate(all="ignore"):
            wanted = pull + 0.0 * x
            low, high = np.zeros_like(s), NEAR_PULL_IN * highest
            pulls = [self.stiffness(s, squared)[0] - squared for squared in (low, high)]
            low, high = halved(lambda v: self.stiffness(s, v)[0] - v > wanted, low, high, BISECTIONS)
            beyond = np.where(wanted < pulls[1], highest + pulls[1] - wanted, 0.5 * (low + high))
            return np.where(wanted > pulls[0], pulls[0] - wanted, beyond)[()]

    def highest_squared(self, x: Any, n: Numbers) -> Any:
        """The highest V at which the film has a state."""
        return 1.0 / np.polynomial.polynomial.polyval(self._t(np.square(np.asarray(x, dtype=float))), self.ceiling)


# --- polynomials ---------------------------------------------------------------------------------------------------


def _value(coefficients: Polynomial, powers: list[Any]) -> Any:
    total = coefficients[0] * powers[0]
    for factor, power in zip(coefficients[1:], powers[1:], strict=False):
        total = total + factor * power
    return total


def _slope(coefficients: Polynomial, powers: list[Any]) -> Any:
    total: Any = 0.0
    for k, factor in enumerate(coefficients[1:]):
        total = total + ((k + 1) * factor) * powers[k]
    return total
