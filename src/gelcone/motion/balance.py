"""One actuator under a constant voltage: where its forces balance, and what a slow voltage ramp does to it.

The force that holds the disc at x against film, spring and a constant voltage v is

    F(x, v) = x (kappa + h(q) - v^2) - kappa x0,    q = 1 + x^2,

with the law's film stiffness h. It vanishes away from x = 0 where v^2 = w(x) = kappa (1 - x0/x) + h(q). There
dF/dx = x dw/dx: an equilibrium is stable where w grows with |x|, and two of them meet in a fold where
dw/dx = kappa x0/x^2 + 2 x dh/dq = 0. Between neighbouring folds w is monotone and holds one equilibrium at most, so
that none is missed however close two come. With x0 = 0 the disc may also rest at x = 0, stably up to the pitchfork at
v^2 = kappa + h(1).

In a continuum film h depends on v^2 as well, but the force still falls as the voltage rises, so that w(x) is the root
of F(x, v) = 0 in v^2 and dF/dx has the sign of x dw/dx as before. It has no state above the v^2 at which it pulls in:
what lies there is no equilibrium, and a ramp that comes there ends.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone.errors import InputError
from gelcone.physics.film.continuum import ContinuumFilm
from gelcone.physics.model import Body, Coefficients, ConeModel, film_stiffness
from gelcone.quantity import Array

SEARCH_RANGE = 1000.0
"""Largest |x| that is searched where the stretch limit, if there is one, leaves room for more."""
WALL_DISTANCE = 1e-12
"""Share of the reachable displacements left out before the stretch limit, where the force is lost to rounding."""
NEAR_PULL_IN = 1.0 - 1e-9
"""Share of the v^2 at which a continuum film pulls in up to which its slope, infinite there, is taken."""
ROUNDING = 1e-14
"""Voltages squared that differ by less are one: an equilibrium then lies on its fold or pitchfork."""
BISECTIONS = 60
FILM_SAMPLES = 401


class PullIn(IntEnum):
    """How the equilibrium followed on a slow voltage ramp is lost."""

    NEVER = 0
    PITCHFORK = 1
    FOLD = 2
    SEARCH_RANGE = 3
    FILM = 4

    @property
    def meaning(self) -> str:
        """One line: what happens there."""
        return _MEANINGS[self]


_MEANINGS = {
    PullIn.NEVER: "stable at every voltage, ever closer to the stretch limit",
    PullIn.PITCHFORK: "loses stability in a pitchfork: the flat film buckles to either side",
    PullIn.FOLD: "meets an unstable equilibrium in a fold and vanishes",
    PullIn.SEARCH_RANGE: f"leaves the searched displacements, |x| up to {SEARCH_RANGE:g}",
    PullIn.FILM: "comes to where the continuum film itself has no state: it pulls in, or its fit ends",
}


@dataclass(frozen=True)
class Cone:
    """One actuator under a constant voltage; it reaches ``lowest`` <= |x| <= ``highest``, NaN if nothing.

    ``wall`` tells a ``highest`` at the stretch limit from one at the end of the search.
    """

    body: Body
    c: Coefficients
    lowest: float
    highest: float
    wall: bool

    @property
    def reachable(self) -> bool:
        return self.lowest < self.highest

    @property
    def offset(self) -> float:
        """Force of the spring on the flat film, kappa x0."""
        return float(self.c.kappa * self.c.rest)

    @property
    def flat(self) -> bool:
        """Whether x = 0 is an equilibrium at every voltage."""
        return self.offset == 0.0 and self.lowest == 0.0

    @property
    def highest_squared(self) -> float:
        """The v^2 at which the flat film pulls in; infinite for a cone."""
        return float(self.body.highest_squared(0.0)) if isinstance(self.body, ContinuumFilm) else math.inf

    @cached_property
    def segments(self) -> dict[int, list[tuple[float, float]]]:
        """For either side of x = 0, from the inside out, the stretches on each of which w is monotone."""
        if not self.reachable:
            return {-1: [], 1: []}
        ends = {side: [side * self.lowest, *_folds(self, side), side * self.highest] for side in (-1, 1)}
        return {side: list(itertools.pairwise(x)) for side, x in ends.items()}

    def inside(self, x: Array) -> npt.NDArray[np.bool_]:
        return (np.abs(x) >= self.lowest) & (np.abs(x) <= self.highest)

    def film(self, x: Any, squared: Any) -> tuple[Any, Any]:
        """The film's stiffness h and its derivative by x^2."""
        with np.errstate(all="ignore"):
            # an array even of one number: the root of a negative float would be complex
            return film_stiffness(np.square(x), np.float64(1.0) * squared, self.c, self.body)

    def force(self, x: Any, squared: Any) -> Any:
        """F(x, v), with v^2 given."""
        return x * (self.c.kappa + self.film(x, squared)[0] - squared) - self.offset

    def slope(self, x: Any, squared: Any) -> Any:
        """dF/dx."""
        h, h_slope = self.film(x, squared)
        return self.c.kappa + h - squared + 2.0 * x * x * h_slope

    def squared(self, x: Any) -> Any:
        """w(x): the v^2 that makes x an equilibrium; at x = 0 its limit, with a rest height infinite.

        Where it would exceed what a continuum film withstands, it goes on as in the cone.
        """
        if isinstance(self.body, ContinuumFilm):
            return _balance(self.body, self.c, x)
        if self.offset == 0.0:
            return self.c.kappa + self.film(x, 0.0)[0]
        with np.errstate(divide="ignore"):
            return self.c.kappa + self.film(x, 0.0)[0] - self.offset / np.asarray(x, dtype=float)

    def turning(self, x: Any) -> Any:
        """x^2 dw/dx, or with a continuum film what has its sign and x^2 dF/dx; smooth also at x = 0."""
        squared = 0.0
        if isinstance(self.body, ContinuumFilm):
            squared = np.clip(self.squared(x), 0.0, NEAR_PULL_IN * self.body.highest_squared(x * x))
        return self.offset + 2.0 * x * x * x * self.film(x, squared)[1]

    def excess(self, x: Any) -> Any:
        """w(x) over the v^2 at which a continuum film pulls in, less 1: positive where there is no equilibrium."""
        if not isinstance(self.body, ContinuumFilm):
            return np.full(np.shape(x), -1.0)[()]
        return self.squared(x) / self.body.highest_squared(x * x) - 1.0


def cones_of(model: ConeModel) -> list[Cone]:
    """All members of the ensemble; `InputError` when none has a displacement inside its stretch limit."""
    members = model.take(slice(None))
    c = members.coefficients()
    limits = np.broadcast_to(members.strain_limit(), members.shape)
    rows = np.stack([np.broadcast_to(row, members.shape) for row in (*c[:-1], *c.law)])
    cones = [
        _cone(members.body, Coefficients._make([*row[:6], tuple(row[6:])]), float(limit))
        for row, limit in zip(rows.T.tolist(), limits, strict=True)
    ]
    if not any(cone.reachable for cone in cones):
        c = cones[0].c
        least = 2.0 * math.sqrt(c.A * c.G) + c.B - 3.0 if c.G > c.A else c.A + c.B + c.G - 3.0
        raise InputError(
            f"stretch_limit = {limits[0]:g}: must exceed the smallest I1 - 3 = {least:.4g} that the pre-stretch leaves "
            "at any displacement; raise the limit or bring the pre-stretch closer to 1"
        )
    return cones


def _cone(body: Body, c: Coefficients, limit: float) -> Cone:
    """I1 - 3 = A q + B + G/q - 3 < limit holds between the two roots of a quadratic in q, as far as q >= 1."""
    if isinstance(body, ContinuumFilm):
        return Cone(body, c, 0.0, body.reach * (1.0 - WALL_DISTANCE), wall=True)
    half = 0.5 * (limit + 3.0 - c.B)
    middle = math.sqrt(c.A * c.G)
    if math.isinf(limit):
        return Cone(body, c, 0.0, SEARCH_RANGE, wall=False)
    if half <= middle:
        return Cone(body, c, math.nan, math.nan, wall=True)
    above = (half + math.sqrt(half - middle) * math.sqrt(half + middle)) / c.A
    below = c.G / (c.A * above)
    if above <= 1.0:
        return Cone(body, c, math.nan, math.nan, wall=True)
    end = math.sqrt(above - 1.0) * (1.0 - WALL_DISTANCE)
    begin = math.sqrt(below - 1.0) * (1.0 + WALL_DISTANCE) if below > 1.0 else 0.0
    return Cone(body, c, begin, min(end, SEARCH_RANGE), wall=end <= SEARCH_RANGE)


def _balance(film: ContinuumFilm, c: Coefficients, x: Any) -> Any:
    """v^2 at which film and field hold the spring at x, by bisection: their pull k falls as the voltage rises."""
    x = np.asarray(x, dtype=float)
    s, highest = x * x, film.highest_squared(x * x)
    with np.errstate(all="ignore"):
        wanted = c.kappa * ((c.rest / x if c.kappa * c.rest else 0.0) - 1.0) + 0.0 * x
        ends = [np.zeros_like(s), NEAR_PULL_IN * highest]
        pulls = [film.stiffness(s, squared)[0] - squared for squared in ends]
        low, high = ends
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            above = film.stiffness(s, middle)[0] - middle > wanted
            low, high = np.where(above, middle, low), np.where(above, high, middle)
        beyond = np.where(wanted < pulls[1], highest + pulls[1] - wanted, 0.5 * (low + high))
        return np.where(wanted > pulls[0], pulls[0] - wanted, beyond)[()]


def _root(function: Callable[[float], Any], a: float, b: float) -> float:
    from scipy.optimize import brentq

    return float(brentq(lambda x: float(function(x)), a, b, xtol=1e-300, rtol=8.9e-16, maxiter=500))


def _grid(cone: Cone) -> Array:
    """Displacements |x| over all that can be reached, finer towards both ends."""
    shares = np.geomspace(1e-9, 0.5, 300)
    even = np.linspace(0.0, 1.0, 400)[1:]
    return cone.lowest + (cone.highest - cone.lowest) * np.unique(np.concatenate([shares, 1.0 - shares, even]))


def _folds(cone: Cone, side: int) -> list[float]:
    """Folds on one side of x = 0, from the inside out, whatever the sign of their v^2."""
    x = side * _grid(cone)
    signs = np.sign(cone.turning(x))
    x, signs = x[signs != 0.0], signs[signs != 0.0]
    return [_root(cone.turning, x[i], x[i + 1]) for i in np.flatnonzero(signs[:-1] != signs[1:])]


def _rises(cone: Cone, segment: tuple[float, float]) -> bool:
    """Whether w grows with |x| on the segment: whether its equilibria are stable."""
    middle = 0.5 * (segment[0] + segment[1])
    return bool(middle * cone.turning(middle) > 0.0)


def root_on_segment(cone: Cone, squared: float, segment: tuple[float, float]) -> float | None:
    """The x of a segment with w(x) = v^2, None if there is none inside it."""

    def balance(x: float) -> Any:
        return cone.squared(x) - squared if cone.offset == 0.0 else cone.force(x, squared)

    inner, outer = (float(balance(x)) for x in segment)
    if not inner * outer < 0.0 or any(same_squared(float(cone.squared(x)), squared) for x in segment):
        return None
    return _root(balance, *segment)


def same_squared(a: float, b: float) -> bool:
    return abs(a - b) <= ROUNDING * (1.0 + abs(b))


class Equilibrium(NamedTuple):
    displacement: float
    slope: float
    stable: bool


def equilibria_of(cone: Cone, squared: float) -> list[Equilibrium]:
    """All equilibria at v^2, in the order of x. One that lies on a fold counts once, and as unstable."""
    found: dict[float, bool] = {}
    for side in (-1, 1):
        segments = cone.segments[side]
        for segment in segments:
            x = root_on_segment(cone, squared, segment)
            if x is not None and cone.excess(x) < 0.0:
                found[x] = _rises(cone, segment)
        found |= {fold: False for _, fold in segments[:-1] if same_squared(float(cone.squared(fold)), squared)}
    if cone.flat and squared < cone.highest_squared:
        at_pitchfork = same_squared(float(cone.squared(0.0)), squared)
        found[0.0] = _rises(cone, cone.segments[1][0]) if at_pitchfork else bool(cone.squared(0.0) > squared)
    return [Equilibrium(x, float(cone.slope(x, squared)), found[x]) for x in sorted(found)]


# --- a slow voltage ramp ------------------------------------------------------------------------------------------


class _Leg(NamedTuple):
    """A stable branch on the ramp: v^2 grows from ``low`` to ``high`` while |x| grows over (part of) ``segment``."""

    low: float
    high: float
    begin: float
    segment: tuple[float, float]
    end: PullIn


def rest_of(cone: Cone, near: float | None) -> float:
    """The stable equilibrium at v = 0 nearest to ``near``; NaN if there is none."""
    stable = [e.displacement for e in equilibria_of(cone, 0.0) if e.stable]
    target = float(cone.c.rest) if near is None else near
    return min(stable, key=lambda x: (abs(x - target), -x), default=math.nan)


def _ramp(cone: Cone, rest: float) -> list[_Leg]:
    """The stable branches that a ramp from ``rest`` runs through; after each, the force leads outwards to the next."""
    if math.isnan(rest):
        return []
    legs = []
    low, side = 0.0, -1 if rest < 0.0 else 1
    if rest == 0.0:
        low = max(float(cone.squared(0.0)), 0.0)
        if low >= cone.highest_squared:
            return [_Leg(0.0, cone.highest_squared, 0.0, (0.0, 0.0), PullIn.FILM)]
        legs.append(_Leg(0.0, low, 0.0, (0.0, 0.0), PullIn.PITCHFORK))
    segments = [s for s in cone.segments[side] if abs(s[1]) > abs(rest)]
    for segment in segments:
        outermost = segment is segments[-1]
        top = float(cone.squared(segment[1]))
        if not _rises(cone, segment) or top <= low:
            continue
        begin = root_on_segment(cone, low, segment)
        end = PullIn.FOLD if not outermost else PullIn.NEVER if cone.wall else PullIn.SEARCH_RANGE
        high = math.inf if end == PullIn.NEVER else top
        lost = _film_lost(cone, segment, begin)
        if lost is not None:
            legs.append(
                _Leg(
                    low,
                    float(cone.squared(lost)),
                    segment[0] if begin is None else begin,
                    (segment[0], lost),
                    PullIn.FILM,
                )
            )
            break
        legs.append(_Leg(low, high, segment[0] if begin is None else begin, segment, end))
        low = top
    return legs


def _film_lost(cone: Cone, segment: tuple[float, float], begin: float | None) -> float | None:
    """Where on a rising segment a continuum film pulls in, or its fit ends; None if it does not."""
    if not isinstance(cone.body, ContinuumFilm):
        return None
    x = np.linspace(segment[0] if begin is None else begin, segment[1], FILM_SAMPLES)
    over = np.flatnonzero(cone.excess(x) >= 0.0)
    if not over.size:
        return float(x[-1]) if segment is cone.segments[-1 if x[-1] < 0.0 else 1][-1] else None
    k = int(over[0])
    return float(x[0]) if k == 0 else _root(cone.excess, x[k - 1], x[k])


def first_loss(cone: Cone, rest: float) -> tuple[float, PullIn, float, float]:
    """Voltage, kind, displacement before and after the first loss of stability."""
    legs = _ramp(cone, rest)
    if not legs:
        return math.nan, PullIn.NEVER, math.nan, math.nan
    first = legs[0]
    if first.end == PullIn.NEVER:
        return math.inf, first.end, math.nan, math.nan
    beyond = legs[1].begin if len(legs) > 1 else math.copysign(math.inf, rest)
    return math.sqrt(first.high), first.end, first.segment[1], beyond


def along_ramp(cone: Cone, rest: float, squared: Array) -> tuple[Array, npt.NDArray[np.int64]]:
    """Displacement and losses of stability passed at each v^2."""
    legs = _ramp(cone, rest)
    passed = [[leg.high < value and not same_squared(leg.high, float(value)) for leg in legs] for value in squared]
    losses = np.array([sum(row) for row in passed], dtype=np.int64)
    place = np.full(squared.shape, np.nan)
    for i, (value, lost) in enumerate(zip(squared, losses, strict=True)):
        if lost < len(legs):
            leg = legs[lost]
            x = 0.0 if leg.segment == (0.0, 0.0) else root_on_segment(cone, float(value), leg.segment)
            nearest = leg.segment[1] if same_squared(leg.high, float(value)) else leg.begin
            place[i] = nearest if x is None else x
    return place, losses
