"""The film as a continuum: the force of the wrinkling membrane, fitted over displacement and voltage squared.

The membrane bears no compression (see `gelcone.continuum.density`), so that it never pushes the disc. It pulls the
disc back with x k(s, V) at s = x^2 and the squared voltage V, where

    k = (H - V)/M [S (P0 + P1 T1 + P2 T2 + ...) + w s/(wall - s)],    M = ((H - V)^2 + (H/50)^2)^(1/2),

    S = V + (H - V + M)/2,    t = r/(r + c),

with Chebyshev polynomials Tj of 2 V/S - 1, sums Pj of those of 2 t/t_reach - 1, H = (b + t) times another such sum, and
r = s. S is H below V = H, all but near it, and V above, so that both arguments lie between -1 and 1. For b = 0, a film
without tension while it is flat, this keeps the law of small heights k = s f(V/s). Where the hoop is stretched more
than the meridian, rings move inwards and the film hangs loose beside the disc; its k then grows like |x|, and
r = sqrt(s + e^2) - e with a small e. The term with ``wall`` is the stretch limit of the film as a whole.

The film is slack and has no force where the bracket is negative, and above V = H, which lies a little higher: there the
factor before it, all but 1 below, ends what the polynomials do beyond. The switch ``pulls`` tells.

It has pulled in above V = E(t), another such sum, where the tension of its most stretched ring no longer grows with the
ring's length; below the height sqrt(``slack_first``) it falls slack before, and a slack film pulls in above
``slack_limit``, where it would thin without end.
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

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
"""Of t, so that a flat film without voltage has a force."""
FADE = 0.02
"""Width, over H, in which (H - V)/M falls from 1 to 0."""
DOUBTFUL = 0.05
"""Error of the force above which every analysis warns."""
BISECTIONS = 50
STATES = ("in_tension", "slack")


@dataclass(frozen=True, kw_only=True)
class ContinuumFilm(FittedFilm):
    """The fitted force of one film; `gelcone.fit_film` makes one, `gelcone.read_film` reads one from a file.

    Parameters
    ----------
    variable : c.
    rounding : e; 0 for r = s.
    flat_tension : b, the V that takes the tension of the flat film.
    stiffness : the coefficients of P0, P1, ...
    slack_above : those of H.
    wall, wall_strength : the s at which the film as a whole reaches its stretch limit, more than reach^2; and w.
    disc_stretch : as ``stiffness``, for (deformed over mounted length along the meridian)^2 - 1 beside the disc.
    pull_in : E.
    slack_first : s up to which the film falls slack before it pulls in; negative if it does so nowhere.
    slack_limit : V above which a slack film has pulled in.
    errors : of k over k + 2 % of k without voltage, and of pull-in voltages; at states fitted and between them, there
        on a finer mesh, and more by three tenths, or by seven where it hangs loose.
    """

    variable: float
    rounding: float
    flat_tension: float
    stiffness: tuple[Polynomial, ...]
    slack_above: Polynomial
    wall: float
    wall_strength: float
    disc_stretch: tuple[Polynomial, ...]
    pull_in: Polynomial
    slack_first: float
    slack_limit: float

    name = "continuum"
    form = 3
    kinds = STATES

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        """Beside those of the gel, the switch ``pulls``."""
        own = super().numbers(parameters)
        return own | {"pulls": np.ones(np.shape(own["A"]))}

    # --- force -------------------------------------------------------------------------------------------------------

    def rate(self, s: Any, squared: Any) -> tuple[Any, Any, Any]:
        """k and its derivatives by s and V, without regard to where the film is slack."""
        k, by_s, by_v, _ = self._laws(s, squared)
        return k, by_s, by_v

    def pull(self, s: Any, squared: Any) -> Any:
        """k of numbers, and 0 where the film is slack."""
        s, squared = np.broadcast_arrays(np.asarray(s, dtype=float), np.asarray(squared, dtype=float))
        t = self._place(s)[0]
        argument = self._argument(t)
        highest = (t + (self.flat_tension + TINY)) * np.polynomial.chebyshev.chebval(argument, self.slack_above)
        rest = highest - squared
        root = np.hypot(rest, FADE * highest)
        S = squared + 0.5 * (rest + root)
        bracket = S * np.polynomial.chebyshev.chebval2d(argument, 2.0 * squared / S - 1.0, self._table)
        bracket = bracket + self.wall_strength * s / (self.wall - s)
        return np.where((bracket > 0.0) & (rest > 0.0), bracket * rest / root, 0.0)[()]

    @cached_property
    def _table(self) -> Array:
        """The coefficients of the products of Chebyshev polynomials, those of one j in a column."""
        most = max(map(len, self.stiffness))
        return np.array([[*p, *[0.0] * (most - len(p))] for p in self.stiffness]).T

    def _laws(self, s: Any, squared: Any) -> tuple[Any, Any, Any, Any]:
        """k, its derivatives by s and V, and what is positive where the film is in tension: where both the bracket and
        H - V are."""
        t, t_slope = self._place(s)
        values = _chebyshev(self._argument(t), max(map(len, (*self.stiffness, self.slack_above))))
        scale = _Scale.of(*self._highest(t, values), squared)
        bracket, by_t, by_v = _surface(self.stiffness, self._slopes, values, scale, squared)
        near = 1.0 / (self.wall - s)
        bracket = bracket + self.wall_strength * s * near
        by_s = by_t * t_slope + (self.wall_strength * self.wall) * near * near
        part, by_part = scale.part, bracket * t_slope
        tightness = bracket + scale.rest - (bracket * bracket + scale.rest * scale.rest) ** 0.5
        return part * bracket, part * by_s + by_part * scale.rise, part * by_v - bracket * scale.steep, tightness

    def _highest(self, t: Any, values: list[Any]) -> tuple[Any, Any]:
        """H and its derivative by t."""
        share, slope = _value(self.slack_above, values), _value(self._derived(self.slack_above), values)
        scale = t + (self.flat_tension + TINY)
        return scale * share, share + scale * slope

    @cached_property
    def _slopes(self) -> tuple[Polynomial, ...]:
        """The coefficients of the derivatives of P0, P1, ... by t."""
        return tuple(self._derived(p) for p in self.stiffness)

    def _derived(self, p: Polynomial) -> Polynomial:
        return tuple((np.polynomial.chebyshev.chebder(p) * (2.0 / self._largest_place)).tolist())

    @cached_property
    def _largest_place(self) -> float:
        return float(self._place(self.reach_squared)[0])

    def _argument(self, t: Any) -> Any:
        return t * (2.0 / self._largest_place) - 1.0

    def _place(self, s: Any) -> tuple[Any, Any]:
        """t and its derivative by s."""
        r, slope = s, 1.0
        if self.rounding > 0.0:
            root = (s + self.rounding * self.rounding) ** 0.5
            r, slope = s / (root + self.rounding), 0.5 / root
        inverse = 1.0 / (r + self.variable)
        return r * inverse, (self.variable * slope) * inverse * inverse

    def force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """x k and its slope; nothing where the film is slack, NaN where it has pulled in."""
        s = x * x
        k, slope, _, tightness = self._laws(s, squared)
        if traced(xp):
            pulls = 0.5 + 0.5 * n["pulls"]
        else:
            with np.errstate(invalid="ignore"):
                gone = (squared > self.highest_squared_at(s)) | (s >= self.wall)
                pulls = np.where(gone, np.nan, np.where(tightness > 0.0, 1.0, 0.0))[()]
        return x * (pulls * k), pulls * (k + 2.0 * s * slope)

    def highest_squared_at(self, s: Any) -> Any:
        """The V above which the film has pulled in."""
        s = np.asarray(s, dtype=float)
        return np.where(s < self.slack_first, self.slack_limit, self._pull_in(s))[()]

    def _pull_in(self, s: Any) -> Any:
        return _value(self.pull_in, _chebyshev(self._argument(self._place(s)[0]), len(self.pull_in)))

    # --- borders -----------------------------------------------------------------------------------------------------

    @cached_property
    def borders(self) -> tuple[Border, ...]:  # type: ignore[override]
        """``pulls`` tells a film in tension from a slack one; the other border ends the film."""
        return Border(self._slack_border, "pulls"), Border(self._end_border)

    def _slack_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        return n["pulls"] * self._laws(x * x, squared)[3]

    def _end_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        """Positive while V < E, or s < slack_first: the sum of both and the root of the sum of squares is positive
        where one of them is."""
        s, pulls = x * x, 0.5 + 0.5 * n["pulls"]
        below = self._pull_in(s) - squared
        if self.slack_first > 0.0:
            first = self.slack_first - s
            below = below + first + (below * below + first * first) ** 0.5
        return pulls * below + (1.0 - pulls) * (self.slack_limit - squared)

    def switches(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> dict[str, Any]:
        return {"pulls": np.where(self.pull(np.square(x), squared) > 0.0, 1.0, -1.0)}

    def times_of_kinds(self, switches: Sequence[str], dwell: Array) -> Array:
        slack = (np.arange(dwell.shape[1]) >> list(switches).index("pulls")) & 1 == 1
        return np.stack([dwell[:, ~slack].sum(axis=1), dwell[:, slack].sum(axis=1)], axis=1)

    def pull_in_kind(self, switches: Numbers) -> Any:
        return np.where(switches["pulls"] > 0.0, FilmPullIn.LOCALISATION, FilmPullIn.MINIMUM)

    # --- statics -----------------------------------------------------------------------------------------------------

    def voltage_gain(self, x: Any, squared: Any, n: Numbers) -> Any:
        _, _, by_v, tightness = self._laws(np.square(x), squared)
        return x * np.where(tightness > 0.0, -by_v, 0.0)

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
            weakest, strongest = self.pull(s, high), self.pull(s, low)
            for _ in range(BISECTIONS):
                middle = 0.5 * (low + high)
                above = self.pull(s, middle) > wanted
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

    def work(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> Any:
        """Work against film and field from the flat film to x at constant V: the integral of x k over x."""

        def inner(s: Any) -> Any:
            return self.rate(s, squared)[0]

        s, begin = np.square(np.asarray(x, dtype=float)), self._tightens(x, squared)
        with np.errstate(all="ignore"):
            return 0.5 * _between(inner, begin, s)

    def capacitance(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """Mean square of the deformed over the mounted area, -2 dE/dV of the energy E: that of the flat film, and the
        integral of -dk/dV over s."""
        if traced(xp):
            return Film.capacitance(self, x, squared, y, n, xp)
        s, begin = np.square(np.asarray(x, dtype=float)), self._tightens(x, squared)
        flat = self._ring.capacitance(np.zeros_like(s), squared, [], self._ring_numbers(n))
        with np.errstate(all="ignore"):
            return flat + _between(lambda at: -self.rate(at, squared)[2], begin, s)

    def _tightens(self, x: Any, squared: Any) -> Any:
        """The s up to x^2 at which the film begins to pull."""
        s, squared = np.broadcast_arrays(np.square(np.asarray(x, dtype=float)), np.asarray(squared, dtype=float))
        low, high = np.zeros_like(s), np.array(s)
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            slack = self.pull(middle, squared) <= 0.0
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

    def state(self, x: Any, voltage: Any, y: list[Any], n: Numbers) -> FilmState:
        """Beside the disc, where the meridian is stretched most; NaN where the film has pulled in."""
        s, squared = np.broadcast_arrays(np.square(np.asarray(x, dtype=float)), np.square(voltage))
        with np.errstate(all="ignore"):
            k, gone = self.pull(s, squared), squared > self.highest_squared_at(s)
            t = self._place(s)[0]
            values = _chebyshev(self._argument(t), max(map(len, (*self.disc_stretch, self.slack_above))))
            S = _Scale.of(*self._highest(t, values), squared).S
            factors = [_value(p, values) for p in self.disc_stretch]
            extra = S * _value(factors, _chebyshev(2.0 * squared / S - 1.0, len(factors)))
        along = np.sqrt(np.where(k > 0.0, np.maximum(extra, 0.0), s))
        state = self._ring.state(along, np.broadcast_to(voltage, s.shape), [], self._ring_numbers(n))
        own = FilmState(*(np.where(gone, np.nan, values)[()] for values in state))
        return own._replace(kind=np.where(gone, -1, np.where(k > 0.0, 0, 1)))

    def describe(self) -> str:
        """How far the fit reaches, and how good it is."""
        known = ", ".join(f"{name} {error:.1%}" for name, error in self.errors) or "not known"
        reach = f"a/b = {self.radius_ratio:.4g}, up to |x| = {self.largest:.4g}"
        return f"film as a continuum that wrinkles, {reach}; largest error of the fit: {known}"

    def doubt(self) -> str:
        """Where the fit is poor."""
        error = dict(self.errors).get("force", 0.0)
        if error <= DOUBTFUL:
            return ""
        return (
            f"the force of the continuum film is wrong by up to {error:.0%}: it could not be fitted better; take the "
            "wrinkling cone (--film wrinkling), or look at the membrane itself (gelcone validate --wrinkles relax)"
        )

    def sound(self) -> bool:
        """Whether its numbers are."""
        rows = [*self.stiffness, *self.disc_stretch, self.pull_in, self.slack_above]
        rest = (self.flat_tension, self.wall_strength, self.slack_first, self.slack_limit)
        finite = np.isfinite([v for row in (*rows, rest) for v in row]).all()
        return bool(all(rows) and finite and 0.0 < self.variable < np.inf and 0.0 <= self.rounding < np.inf)


class _Scale(NamedTuple):
    """What H and V alone tell: ``rest`` H - V, ``part`` (H - V)/M, ``steep`` its fall with V, ``rise`` its rise with t;
    S and its derivatives by t and V."""

    rest: Any
    part: Any
    steep: Any
    rise: Any
    S: Any
    by_t: Any
    by_v: Any

    @classmethod
    def of(cls, highest: Any, rise: Any, squared: Any) -> _Scale:
        """``rise``: the derivative of H by t."""
        rest, width = highest - squared, FADE * highest
        root = (rest * rest + width * width) ** 0.5
        inverse = 1.0 / root
        part, narrow = rest * inverse, width * inverse
        return cls(
            rest=rest,
            part=part,
            steep=narrow * narrow * inverse,
            rise=FADE * narrow * (squared * inverse * inverse) * rise,
            S=0.5 * (highest + squared + root),
            by_t=0.5 * (1.0 + part + FADE * narrow) * rise,
            by_v=0.5 * (1.0 - part),
        )


def _surface(
    polynomials: Sequence[Polynomial], slopes: Sequence[Polynomial], values: list[Any], scale: _Scale, squared: Any
) -> tuple[Any, Any, Any]:
    """S times the sum over the Tj of 2 V/S - 1, and its derivatives by t and V."""
    share = squared / scale.S
    places = _chebyshev(2.0 * share - 1.0, len(polynomials))
    factors = [_value(p, values) for p in polynomials]
    total = _value(factors, places)
    by_share = 2.0 * _value(_derivative(factors), places)
    by_t = _value([_value(p, values) for p in slopes], places)
    # the share V/S falls as S grows
    along = total - share * by_share
    return scale.S * total, scale.S * by_t + scale.by_t * along, scale.by_v * along + by_share


def _chebyshev(argument: Any, count: int) -> list[Any]:
    """T0, T1, T2, ...: shared by all sums, which then have no other product."""
    found = [1.0 + 0.0 * argument, argument]
    while len(found) < count:
        half, rest = len(found) // 2, (len(found) + 1) // 2
        found.append(2.0 * (found[half] * found[rest]) - found[rest - half])
    return found[:count]


def _value(coefficients: Sequence[Any], values: Sequence[Any]) -> Any:
    return _sum(factor * value for factor, value in zip(coefficients, values, strict=False))


def _derivative(coefficients: Sequence[Any]) -> list[Any]:
    """The coefficients of the derivative of a sum of Chebyshev polynomials by their argument."""
    found: list[Any] = [0.0] * (len(coefficients) + 1)
    for j in range(len(coefficients) - 1, 0, -1):
        found[j - 1] = found[j + 1] + (2.0 * j) * coefficients[j]
    found[0] = 0.5 * found[0]
    return found[: max(1, len(coefficients) - 1)]


def _sum(terms: Iterable[Any]) -> Any:
    return functools.reduce(operator.add, terms, 0.0)


def _between(function: Any, low: Any, high: Any) -> Any:
    """The integral from ``low`` to ``high`` over log(1 + s), denser towards ``low``, where S is small."""
    begin, length = np.log1p(low), np.log1p(high) - np.log1p(low)

    def dense(u: Any) -> Any:
        s = np.expm1(begin + length * u * u)
        return function(s) * (1.0 + s) * (2.0 * length * u)

    return integral(dense, np.ones_like(length))
