"""The film as a continuum: the force of the wrinkling membrane, fitted over displacement and voltage squared.

The membrane bears no compression (see `gelcone.continuum.density`), so that it never pushes the disc. It pulls the
disc back with x k(s, V) at s = x^2 and the squared voltage V, where

    k = S (P0 + P1 z + P2 z^2 + ...) + w s/(wall - s),    S = V + b + t,    z = V/S,    t = s/(s + c),

with polynomials Pj of t. For b = 0, a film without tension while it is flat, S P(z) keeps the law of small heights
k = s f(V/s). The term with ``wall`` is the stretch limit of the film as a whole. Where k would be negative the film is
slack and has no force; the switch ``pulls`` tells.

It has pulled in above V = E(t), a polynomial, where the tension of its most stretched ring no longer grows with the
ring's length; below the height sqrt(``slack_first``) it falls slack before, and a slack film pulls in above
``slack_limit``, where it would thin without end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gelcone.codes import FilmPullIn
from gelcone.physics.component import Numbers
from gelcone.physics.film.film import Border, Film, FilmState
from gelcone.physics.film.fitted import FittedFilm, Polynomial
from gelcone.physics.film.wrinkling import STEEP, WrinklingCone
from gelcone.physics.implicit import traced
from gelcone.physics.quadrature import integral
from gelcone.quantity import Array

TINY = 1e-12
"""Of S, so that a flat film without voltage has a force."""
BISECTIONS = 50
STATES = ("in_tension", "slack")


@dataclass(frozen=True, kw_only=True)
class ContinuumFilm(FittedFilm):
    """The fitted force of one film; `gelcone.fit_film` makes one, `gelcone.read_film` reads one from a file.

    Parameters
    ----------
    variable : c.
    flat_tension : b, the V that takes the tension of the flat film.
    stiffness : the polynomials P0, P1, ...
    wall, wall_strength : the s at which the film as a whole reaches its stretch limit, more than reach^2; and w.
    disc_stretch : as ``stiffness``, for (deformed over mounted length along the meridian)^2 - 1 beside the disc.
    pull_in : E.
    slack_first : s up to which the film falls slack before it pulls in; negative if it does so nowhere.
    slack_limit : V above which a slack film has pulled in.
    errors : of k over k + 2 % of k without voltage, and of pull-in voltages; at states fitted and between them.
    """

    variable: float
    flat_tension: float
    stiffness: tuple[Polynomial, ...]
    wall: float
    wall_strength: float
    disc_stretch: tuple[Polynomial, ...]
    pull_in: Polynomial
    slack_first: float
    slack_limit: float

    name = "continuum"
    form = 2
    kinds = STATES

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        """Beside those of the gel, the switch ``pulls``."""
        own = super().numbers(parameters)
        return own | {"pulls": np.ones(np.shape(own["A"]))}

    # --- force -------------------------------------------------------------------------------------------------------

    def rate(self, s: Any, squared: Any) -> tuple[Any, Any, Any]:
        """k and its derivatives by s and V, without regard to its sign."""
        r = 1.0 / (s + self.variable)
        t, t_slope = s * r, self.variable * r * r
        k, by_t, by_v = self._surface(self.stiffness, t, squared)
        near = 1.0 / (self.wall - s)
        k = k + self.wall_strength * s * near
        return k, by_t * t_slope + (self.wall_strength * self.wall) * near * near, by_v

    def _surface(self, polynomials: tuple[Polynomial, ...], t: Any, squared: Any) -> tuple[Any, Any, Any]:
        """S times the polynomial in z, and its derivatives by t and V."""
        S = squared + (t + (self.flat_tension + TINY))
        z = squared / S
        value, by_t, by_v, power, before = 0.0, 0.0, 0.0, 1.0, 0.0
        for j, polynomial in enumerate(polynomials):
            p, p_slope = _with_slope(polynomial, t)
            value = value + p * power
            by_t = by_t + (S * p_slope + (1.0 - j) * p) * power
            by_v = by_v + p * (power + (float(j) * (1.0 - z)) * before)
            before, power = power, power * z
        return S * value, by_t, by_v

    def force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """x k and its slope; nothing where the film is slack, NaN where it has pulled in."""
        s = x * x
        k, slope, _ = self.rate(s, squared)
        if traced(xp):
            pulls = 0.5 + 0.5 * n["pulls"]
        else:
            with np.errstate(invalid="ignore"):
                gone = (squared > self.highest_squared_at(s)) | (s >= self.wall)
                pulls = np.where(gone, np.nan, np.where(k > 0.0, 1.0, 0.0))[()]
        return x * (pulls * k), pulls * (k + 2.0 * s * slope)

    def highest_squared_at(self, s: Any) -> Any:
        """The V above which the film has pulled in."""
        s = np.asarray(s, dtype=float)
        return np.where(s < self.slack_first, self.slack_limit, self._pull_in(s))[()]

    def _pull_in(self, s: Any) -> Any:
        return _with_slope(self.pull_in, s / (s + self.variable))[0]

    # --- borders -----------------------------------------------------------------------------------------------------

    @cached_property
    def borders(self) -> tuple[Border, ...]:  # type: ignore[override]
        """``pulls`` tells a film in tension from a slack one; the other border ends the film."""
        return Border(self._slack_border, "pulls"), Border(self._end_border)

    def _slack_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        return n["pulls"] * self.rate(x * x, squared)[0]

    def _end_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        """Positive while V < E, or s < slack_first: the sum of both and the root of the sum of squares is positive
        where one of them is."""
        s, pulls = x * x, 0.5 + 0.5 * n["pulls"]
        below = self._pull_in(s) - squared
        if self.slack_first > 0.0:
            first = self.slack_first - s
            below = below + first + (below * below + first * first) ** 0.5
        return pulls * below + (1.0 - pulls) * (self.slack_limit - squared)

    def switches(self, x: Any, squared: Any, n: Numbers) -> dict[str, Any]:
        return {"pulls": np.where(self.rate(np.square(x), squared)[0] > 0.0, 1.0, -1.0)}

    def times_of_kinds(self, switches: Sequence[str], dwell: Array) -> Array:
        slack = (np.arange(dwell.shape[1]) >> list(switches).index("pulls")) & 1 == 1
        return np.stack([dwell[:, ~slack].sum(axis=1), dwell[:, slack].sum(axis=1)], axis=1)

    def pull_in_kind(self, switches: Numbers) -> Any:
        return np.where(switches["pulls"] > 0.0, FilmPullIn.LOCALISATION, FilmPullIn.MINIMUM)

    # --- statics -----------------------------------------------------------------------------------------------------

    def voltage_gain(self, x: Any, squared: Any, n: Numbers) -> Any:
        k, _, by_v = self.rate(np.square(x), squared)
        return x * np.where(k > 0.0, -by_v, 0.0)

    def turning(self, x: Any, squared: Any, n: Numbers) -> Any:
        return Film.turning(self, x, squared, n)

    def balancing(self, x: Any, pull: Any, n: Numbers) -> Any:
        """By bisection, as the pull k falls while the voltage rises. No voltage makes the film push: a negative
        ``pull`` takes a V that rises too steeply to be reached; so does one that is less than the pull at which the
        film pulls in."""
        s, pull = np.broadcast_arrays(np.square(np.asarray(x, dtype=float)), np.asarray(pull, dtype=float))
        wanted, highest = np.maximum(pull, 0.0), np.minimum(self.highest_squared_at(s), self.end_of_fit)
        with np.errstate(all="ignore"):
            low, high = np.zeros_like(s), np.array(highest, dtype=float)
            weakest, strongest = self.rate(s, high)[0], self.rate(s, low)[0]
            for _ in range(BISECTIONS):
                middle = 0.5 * (low + high)
                above = self.rate(s, middle)[0] > wanted
                low, high = np.where(above, middle, low), np.where(above, high, middle)
            found = np.where(weakest > wanted, highest + STEEP * (weakest - wanted), 0.5 * (low + high))
            found = np.where(wanted > strongest, strongest - wanted, found)
        return (found - STEEP * np.minimum(pull, 0.0))[()]

    @property
    def end_of_fit(self) -> float:
        """The V above which no film in tension was found at any height."""
        return max(self.slack_limit, float(np.max(self._pull_in(np.linspace(0.0, self.reach_squared, 101)))))

    def highest_squared(self, x: Any, n: Numbers) -> Any:
        return self.highest_squared_at(np.square(x))

    # --- energies ------------------------------------------------------------------------------------------------

    def work(self, x: Any, squared: Any, n: Numbers) -> Any:
        """Work against film and field from the flat film to x at constant V: the integral of x k over x."""

        def smooth(s: Any) -> Any:
            return self.rate(s, squared)[0] - self.wall_strength * s / (self.wall - s)

        def of_wall(s: Any) -> Any:
            return -self.wall_strength * (s + self.wall * np.log1p(-s / self.wall))

        s, begin = np.square(np.asarray(x, dtype=float)), self._tightens(x, squared)
        with np.errstate(all="ignore"):
            return 0.5 * (_between(smooth, begin, s) + of_wall(s) - of_wall(begin))

    def area(self, x: Any, squared: Any, n: Numbers) -> Any:
        """Mean square of the deformed over the mounted area, -2 dE/dV of the energy E: that of the flat film, and the
        integral of -dk/dV over s."""
        s, begin = np.square(np.asarray(x, dtype=float)), self._tightens(x, squared)
        flat = self._ring.area(np.zeros_like(s), squared, self._ring_numbers(n))
        with np.errstate(all="ignore"):
            return flat + _between(lambda at: -self.rate(at, squared)[2], begin, s)

    def _tightens(self, x: Any, squared: Any) -> Any:
        """The s up to x^2 at which the film begins to pull."""
        s, squared = np.broadcast_arrays(np.square(np.asarray(x, dtype=float)), np.asarray(squared, dtype=float))
        low, high = np.zeros_like(s), np.array(s)
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            slack = self.rate(middle, squared)[0] <= 0.0
            low, high = np.where(slack, middle, low), np.where(slack, high, middle)
        return np.where(high < 1e-12 * s, 0.0, high)

    # --- what else is asked of a film ----------------------------------------------------------------------------

    @cached_property
    def _ring(self) -> WrinklingCone:
        """A ring beside the disc, whose hoop is held: it obeys the wrinkling cone's law at its own meridian."""
        return WrinklingCone(law=self.law, pull_in="minimum")

    def _ring_numbers(self, n: Numbers) -> dict[str, Any]:
        lm, lh = self.prestretches
        given = dict(self.law_parameters) | {"meridional_prestretch": lm, "hoop_prestretch": lh}
        return self._ring.numbers(self._ring.complete(given))

    def state(self, x: Any, voltage: Any, n: Numbers) -> FilmState:
        """Beside the disc, where the meridian is stretched most; NaN where the film has pulled in."""
        s, squared = np.broadcast_arrays(np.square(np.asarray(x, dtype=float)), np.square(voltage))
        with np.errstate(all="ignore"):
            k, gone = self.rate(s, squared)[0], squared > self.highest_squared_at(s)
            extra = self._surface(self.disc_stretch, s / (s + self.variable), squared)[0]
        along = np.sqrt(np.where(k > 0.0, np.maximum(extra, 0.0), s))
        state = self._ring.state(along, np.broadcast_to(voltage, s.shape), self._ring_numbers(n))
        own = FilmState(*(np.where(gone, np.nan, values)[()] for values in state))
        return own._replace(kind=np.where(gone, -1, np.where(k > 0.0, 0, 1)))

    def describe(self) -> str:
        """How far the fit reaches, and how good it is."""
        known = ", ".join(f"{name} {error:.1%}" for name, error in self.errors) or "not known"
        reach = f"a/b = {self.radius_ratio:.4g}, up to |x| = {self.largest:.4g}"
        return f"film as a continuum that wrinkles, {reach}; largest error of the fit: {known}"

    def sound(self) -> bool:
        """Whether its numbers are."""
        rows = [*self.stiffness, *self.disc_stretch, self.pull_in]
        rest = (self.variable, self.flat_tension, self.wall_strength, self.slack_first, self.slack_limit)
        return bool(all(rows) and self.variable > 0.0 and np.isfinite([v for row in (*rows, rest) for v in row]).all())


def _with_slope(coefficients: Polynomial, t: Any) -> tuple[Any, Any]:
    """A polynomial and its derivative, by Horner's rule."""
    value, slope = coefficients[-1] + 0.0 * t, 0.0 * t
    for factor in reversed(coefficients[:-1]):
        slope = slope * t + value
        value = value * t + factor
    return value, slope


def _between(function: Any, low: Any, high: Any) -> Any:
    """The integral from ``low`` to ``high`` over log(1 + s), denser towards ``low``, where S is small."""
    begin, length = np.log1p(low), np.log1p(high) - np.log1p(low)

    def dense(u: Any) -> Any:
        s = np.expm1(begin + length * u * u)
        return function(s) * (1.0 + s) * (2.0 * length * u)

    return integral(dense, np.ones_like(length))
