"""Statics: force over displacement under a constant voltage, equilibria, pitchfork, folds and pull-in.

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
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.errors import InputError
from gelcone.film import ContinuumFilm
from gelcone.model import PARAMETERS, Body, Coefficients, ConeModel, electric_force, film_stiffness
from gelcone.motion.flow import Outcome
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

SEARCH_RANGE = 1000.0
"""Largest |x| that is searched where the stretch limit, if there is one, leaves room for more."""
WALL_DISTANCE = 1e-12
"""Share of the reachable displacements left out before the stretch limit, where the force is lost to rounding."""
NEAR_PULL_IN = 1.0 - 1e-9
"""Share of the v^2 at which a continuum film pulls in up to which its slope, infinite there, is taken."""
ROUNDING = 1e-14
"""Voltages squared that differ by less are one: an equilibrium then lies on its fold or pitchfork."""
BISECTIONS = 60
FORCE_SAMPLES = 401


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


def static(model: ConeModel, voltages: npt.ArrayLike, displacements: npt.ArrayLike | None = None) -> xr.Dataset:
    """Force over displacement, equilibria, their branches, pitchfork, folds and pull-in under constant voltages.

    Parameters
    ----------
    model : one actuator or an ensemble; its own drive plays no part.
    voltages : constant voltages v, at least 0, one number or shape (voltages,).
    displacements : increasing x at which the force is given; default 401 even ones around all equilibria.

    Returns
    -------
    Dataset over the ensemble's dims, ``constant_voltage``, ``displacement`` and ``equilibrium`` (padded with NaN;
    ``equilibria`` counts them). ``force`` holds the disc at x and ``stiffness`` is its slope, both NaN beyond the
    stretch limit. ``slope`` is that of the force at ``equilibrium_displacement``, which is ``stable`` where the energy
    has a minimum. ``branch_*`` trace the equilibria over the voltage, pieces parted by NaN, with the folds among the
    points. Pitchfork, folds and pull-in are those of `pitchfork_voltage`, `fold_voltages` and `pull_in_voltage`. The
    ``outcome`` of a member is ``outside`` where its pre-stretch exceeds the stretch limit at every displacement.

    Raises
    ------
    InputError : for voltages out of bounds, displacements that do not increase or of which none can be reached, or
        when no member can be reached at all.
    """
    levels = _voltages(voltages)
    cones = _cones(model)
    found = [[_equilibria(cone, v * v) for v in levels] for cone in cones]
    x = _force_range(cones, found) if displacements is None else _wanted(displacements, cones)
    squared = levels[:, None] ** 2
    force = np.stack([np.where(cone.inside(x), cone.force(x, squared), np.nan) for cone in cones])
    stiffness = np.stack([np.where(cone.inside(x), cone.slope(x, squared), np.nan) for cone in cones])
    count = np.array([[len(at) for at in row] for row in found])
    each = [np.array(at, dtype=float).reshape(-1, 3) for row in found for at in row]
    place, slope, stable = (_padded([at[:, k] for at in each]).reshape(*count.shape, -1) for k in range(3))
    dims = ("constant_voltage", "equilibrium")
    result = _label(
        model,
        cones,
        {
            "force": (("constant_voltage", "displacement"), force, "static force that holds the disc", "force"),
            "stiffness": (("constant_voltage", "displacement"), stiffness, "slope of the static force", "stiffness"),
            "equilibria": (("constant_voltage",), count, "number of equilibria", "count"),
            "equilibrium_displacement": (dims, place, "displacement of the equilibrium", "length"),
            "slope": (dims, slope, "slope of the static force at the equilibrium", "stiffness"),
            "stable": (dims, stable == 1.0, "whether the equilibrium is stable", "flag"),
        }
        | _branches(cones, _branch_limit(cones, levels))
        | _pitchfork_variable(model)
        | _fold_variables(cones)
        | _pull_in_variables(cones, [None] * len(cones)),
        coords={
            "constant_voltage": (("constant_voltage",), levels, "constant voltage", "voltage"),
            "displacement": (("displacement",), x, "displacement x = h/(b-a)", "length"),
        },
        title="statics",
    )
    return _with_flags(result)


def pitchfork_voltage(model: ConeModel) -> Array:
    """Constant voltage at which the flat film loses its stability, of the ensemble's shape.

    It is the root of the small-signal stiffness kappa + (A - G)/(1 - (A+B+G-3)/J), or that of a continuum film. NaN
    where x = 0 is no equilibrium (``rest_height`` with a spring), cannot be reached or is unstable without voltage
    already, or where a continuum film pulls in before.
    """
    flat = np.zeros(model.shape)
    with np.errstate(all="ignore"):
        stiffness = np.asarray(model.stiffness(flat), dtype=float)
        rests = np.asarray(model.spring_stiffness) * np.asarray(model.rest_height) == 0.0
        exists = (stiffness >= -ROUNDING) & rests & (model.strain(flat) < model.strain_limit())
        squared = np.maximum(stiffness, 0.0)
        if model.film is not None:
            cones = _cones(model)
            squared = np.reshape([float(cone.squared(0.0)) for cone in cones], model.shape)
            exists &= squared < cones[0].highest_squared
        return np.where(exists, np.sqrt(squared), np.nan)


def fold_voltages(model: ConeModel) -> xr.Dataset:
    """All constant voltages at which two equilibria meet and vanish, and where: the limit points.

    Returns ``fold_voltage`` and ``fold_displacement`` over the ensemble's dims and ``fold``, in the order of the
    voltage, NaN-padded. Displacements up to the stretch limit are searched, at most 1000.
    """
    cones = _cones(model)
    return _label(model, cones, _fold_variables(cones), title="folds of the equilibria")


def pull_in_voltage(model: ConeModel, start: npt.ArrayLike | None = None) -> xr.Dataset:
    """Where the stable equilibrium loses its stability on a slow (quasi-static) voltage ramp from 0.

    Parameters
    ----------
    model : one actuator or an ensemble; its own drive plays no part.
    start : the ramp starts from the stable equilibrium at v = 0 nearest to this displacement; default the model's
        ``rest_height`` (of two equally near ones the higher).

    Returns
    -------
    Dataset over the ensemble's dims: ``pull_in_voltage`` (infinity if never, NaN where nothing is stable at v = 0);
    ``pull_in_kind``, a `PullIn`; ``pull_in_from``, the displacement there; ``pull_in_to``, where the disc goes: to the
    next stable equilibrium that the force leads to, infinity when there is none, the same displacement where
    a pitchfork continues smoothly, NaN if never. ``rest_displacement`` is where the ramp starts.
    """
    cones = _cones(model)
    variables = _pull_in_variables(cones, _starts(model, start))
    return _with_flags(_label(model, cones, variables, start=start, title="pull-in"))


def stroke_and_blocked_force(
    model: ConeModel, voltages: npt.ArrayLike, start: npt.ArrayLike | None = None
) -> xr.Dataset:
    """What the actuator delivers at constant voltages reached on a slow ramp from 0: stroke and blocked force.

    Parameters
    ----------
    model : one actuator or an ensemble; its own drive plays no part.
    voltages : constant voltages v, at least 0, one number or shape (voltages,).
    start : as in `pull_in_voltage`.

    Returns
    -------
    Dataset over the ensemble's dims and ``constant_voltage``: ``displacement`` of the disc and its ``stroke`` from
    ``rest_displacement``, on the branch that the ramp follows and past its end on the one it goes to (after a pitchfork
    the positive one), NaN where it goes to infinity; ``losses``, how many losses of stability the ramp has passed;
    ``blocked_force``, what the voltage adds to the force (v^2 x in the cone), with which the disc pushes (away from the
    flat film) on a stop that holds it where it rests without voltage.
    """
    levels = _voltages(voltages)
    cones = _cones(model)
    rests = [_rest(cone, near) for cone, near in zip(cones, _starts(model, start), strict=True)]
    reached = [_on_ramp(cone, rest, levels**2) for cone, rest in zip(cones, rests, strict=True)]
    place, losses = (np.stack([row[k] for row in reached]) for k in range(2))
    rest = np.array(rests)
    with np.errstate(all="ignore"):
        blocked = np.stack([electric_force(x, levels, cone.c, cone.body) for x, cone in zip(rests, cones, strict=True)])
    dims = ("constant_voltage",)
    return _label(
        model,
        cones,
        {
            "displacement": (dims, place, "displacement on a slow voltage ramp", "length"),
            "stroke": (dims, place - rest[:, None], "displacement from the rest without voltage", "length"),
            "blocked_force": (dims, blocked + 0.0, "force on a stop at the rest position", "force"),
            "losses": (dims, losses, "losses of stability passed on the ramp", "count"),
            "rest_displacement": ((), rest, "stable equilibrium without voltage", "length"),
        },
        coords={"constant_voltage": (dims, levels, "constant voltage", "voltage")},
        start=start,
        title="stroke and blocked force",
    )


# --- one actuator -------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Cone:
    """One actuator as its statics see it; it reaches ``lowest`` <= |x| <= ``highest``, NaN if nothing.

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


def _cones(model: ConeModel) -> list[_Cone]:
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


def _cone(body: Body, c: Coefficients, limit: float) -> _Cone:
    """I1 - 3 = A q + B + G/q - 3 < limit holds between the two roots of a quadratic in q, as far as q >= 1."""
    if isinstance(body, ContinuumFilm):
        return _Cone(body, c, 0.0, body.reach * (1.0 - WALL_DISTANCE), wall=True)
    half = 0.5 * (limit + 3.0 - c.B)
    middle = math.sqrt(c.A * c.G)
    if math.isinf(limit):
        return _Cone(body, c, 0.0, SEARCH_RANGE, wall=False)
    if half <= middle:
        return _Cone(body, c, math.nan, math.nan, wall=True)
    above = (half + math.sqrt(half - middle) * math.sqrt(half + middle)) / c.A
    below = c.G / (c.A * above)
    if above <= 1.0:
        return _Cone(body, c, math.nan, math.nan, wall=True)
    end = math.sqrt(above - 1.0) * (1.0 - WALL_DISTANCE)
    begin = math.sqrt(below - 1.0) * (1.0 + WALL_DISTANCE) if below > 1.0 else 0.0
    return _Cone(body, c, begin, min(end, SEARCH_RANGE), wall=end <= SEARCH_RANGE)


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


def _grid(cone: _Cone) -> Array:
    """Displacements |x| over all that can be reached, finer towards both ends."""
    shares = np.geomspace(1e-9, 0.5, 300)
    even = np.linspace(0.0, 1.0, 400)[1:]
    return cone.lowest + (cone.highest - cone.lowest) * np.unique(np.concatenate([shares, 1.0 - shares, even]))


def _folds(cone: _Cone, side: int) -> list[float]:
    """Folds on one side of x = 0, from the inside out, whatever the sign of their v^2."""
    x = side * _grid(cone)
    signs = np.sign(cone.turning(x))
    x, signs = x[signs != 0.0], signs[signs != 0.0]
    return [_root(cone.turning, x[i], x[i + 1]) for i in np.flatnonzero(signs[:-1] != signs[1:])]


def _rises(cone: _Cone, segment: tuple[float, float]) -> bool:
    """Whether w grows with |x| on the segment: whether its equilibria are stable."""
    middle = 0.5 * (segment[0] + segment[1])
    return bool(middle * cone.turning(middle) > 0.0)


def _on_segment(cone: _Cone, squared: float, segment: tuple[float, float]) -> float | None:
    """The x of a segment with w(x) = v^2, None if there is none inside it."""

    def balance(x: float) -> Any:
        return cone.squared(x) - squared if cone.offset == 0.0 else cone.force(x, squared)

    inner, outer = (float(balance(x)) for x in segment)
    if not inner * outer < 0.0 or any(_equal(float(cone.squared(x)), squared) for x in segment):
        return None
    return _root(balance, *segment)


def _equal(a: float, b: float) -> bool:
    return abs(a - b) <= ROUNDING * (1.0 + abs(b))


class _Equilibrium(NamedTuple):
    displacement: float
    slope: float
    stable: bool


def _equilibria(cone: _Cone, squared: float) -> list[_Equilibrium]:
    """All equilibria at v^2, in the order of x. One that lies on a fold counts once, and as unstable."""
    found: dict[float, bool] = {}
    for side in (-1, 1):
        segments = cone.segments[side]
        for segment in segments:
            x = _on_segment(cone, squared, segment)
            if x is not None and cone.excess(x) < 0.0:
                found[x] = _rises(cone, segment)
        found |= {fold: False for _, fold in segments[:-1] if _equal(float(cone.squared(fold)), squared)}
    if cone.flat and squared < cone.highest_squared:
        at_pitchfork = _equal(float(cone.squared(0.0)), squared)
        found[0.0] = _rises(cone, cone.segments[1][0]) if at_pitchfork else bool(cone.squared(0.0) > squared)
    return [_Equilibrium(x, float(cone.slope(x, squared)), found[x]) for x in sorted(found)]


# --- a slow voltage ramp ------------------------------------------------------------------------------------------


class _Leg(NamedTuple):
    """A stable branch on the ramp: v^2 grows from ``low`` to ``high`` while |x| grows over (part of) ``segment``."""

    low: float
    high: float
    begin: float
    segment: tuple[float, float]
    end: PullIn


def _rest(cone: _Cone, near: float | None) -> float:
    """The stable equilibrium at v = 0 nearest to ``near``; NaN if there is none."""
    stable = [e.displacement for e in _equilibria(cone, 0.0) if e.stable]
    target = float(cone.c.rest) if near is None else near
    return min(stable, key=lambda x: (abs(x - target), -x), default=math.nan)


def _ramp(cone: _Cone, rest: float) -> list[_Leg]:
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
        begin = _on_segment(cone, low, segment)
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


def _film_lost(cone: _Cone, segment: tuple[float, float], begin: float | None) -> float | None:
    """Where on a rising segment a continuum film pulls in, or its fit ends; None if it does not."""
    if not isinstance(cone.body, ContinuumFilm):
        return None
    x = np.linspace(segment[0] if begin is None else begin, segment[1], FORCE_SAMPLES)
    over = np.flatnonzero(cone.excess(x) >= 0.0)
    if not over.size:
        return float(x[-1]) if segment is cone.segments[-1 if x[-1] < 0.0 else 1][-1] else None
    k = int(over[0])
    return float(x[0]) if k == 0 else _root(cone.excess, x[k - 1], x[k])


def _pull_in(cone: _Cone, rest: float) -> tuple[float, PullIn, float, float]:
    """Voltage, kind, displacement before and after the first loss of stability."""
    legs = _ramp(cone, rest)
    if not legs:
        return math.nan, PullIn.NEVER, math.nan, math.nan
    first = legs[0]
    if first.end == PullIn.NEVER:
        return math.inf, first.end, math.nan, math.nan
    beyond = legs[1].begin if len(legs) > 1 else math.copysign(math.inf, rest)
    return math.sqrt(first.high), first.end, first.segment[1], beyond


def _on_ramp(cone: _Cone, rest: float, squared: Array) -> tuple[Array, npt.NDArray[np.int64]]:
    """Displacement and losses of stability passed at each v^2."""
    legs = _ramp(cone, rest)
    passed = [[leg.high < value and not _equal(leg.high, float(value)) for leg in legs] for value in squared]
    losses = np.array([sum(row) for row in passed], dtype=np.int64)
    place = np.full(squared.shape, np.nan)
    for i, (value, lost) in enumerate(zip(squared, losses, strict=True)):
        if lost < len(legs):
            leg = legs[lost]
            x = 0.0 if leg.segment == (0.0, 0.0) else _on_segment(cone, float(value), leg.segment)
            nearest = leg.segment[1] if _equal(leg.high, float(value)) else leg.begin
            place[i] = nearest if x is None else x
    return place, losses


# --- what the Datasets hold ---------------------------------------------------------------------------------------


def _label(
    model: ConeModel,
    cones: list[_Cone],
    variables: dict[str, dataset.Variable],
    *,
    coords: dict[str, dataset.Variable] | None = None,
    start: npt.ArrayLike | None = None,
    title: str,
) -> xr.Dataset:
    options = {"search_range": SEARCH_RANGE, "start": None if start is None else np.asarray(start).tolist()}
    outcome = [Outcome.OK if cone.reachable else Outcome.OUTSIDE for cone in cones]
    return dataset.label(model, variables, coords=coords, outcome=outcome, options=options, title=title)


def _voltages(voltages: npt.ArrayLike) -> Array:
    levels = np.atleast_1d(np.asarray(PARAMETERS["voltage"].check("voltages", voltages), dtype=float))
    if levels.ndim > 1:
        raise InputError(f"voltages has the shape {levels.shape}: must be a number or one-dimensional; ravel it")
    return levels


def _wanted(displacements: npt.ArrayLike, cones: list[_Cone]) -> Array:
    x = np.atleast_1d(np.asarray(displacements, dtype=float))
    if x.ndim > 1 or x.size == 0 or not np.isfinite(x).all() or (np.diff(x) <= 0.0).any():
        raise InputError(f"displacements = {np.asarray(displacements).tolist()}: must be finite and increasing")
    if not any(cone.inside(x).any() for cone in cones):
        highest = max(cone.highest for cone in cones if cone.reachable)
        raise InputError(f"displacements from {x[0]:g} to {x[-1]:g}: none is reached; give |x| below {highest:.6g}")
    return x


def _starts(model: ConeModel, start: npt.ArrayLike | None) -> list[float | None]:
    if start is None:
        return [None] * model.size
    try:
        values = np.broadcast_to(np.asarray(start, dtype=float), model.shape).ravel()
    except (TypeError, ValueError):
        raise InputError(f"start = {start!r}: must be a displacement, or one a member (shape {model.shape})") from None
    if not np.isfinite(values).all():
        raise InputError(f"start = {values[~np.isfinite(values)][0]:g}: must be finite")
    return [float(value) for value in values]


def _force_range(cones: list[_Cone], found: list[list[list[_Equilibrium]]]) -> Array:
    """Even displacements around all equilibria and rest heights, or up to 1, as far as any member reaches."""
    farthest = max((abs(e.displacement) for row in found for at in row for e in at), default=0.0)
    rests = max(abs(float(cone.c.rest)) for cone in cones)
    wanted = 1.4 * max(farthest, rests, 1.0 if farthest == 0.0 else 0.0)
    reached = max(0.995 * cone.highest for cone in cones if cone.reachable)
    return np.linspace(-1.0, 1.0, FORCE_SAMPLES) * min(wanted, reached)


def _padded(rows: Sequence[Array]) -> Array:
    """Rows of different lengths as one array with at least one column, NaN behind each."""
    longest = max(1, *(len(row) for row in rows))
    return np.stack([np.concatenate([row, np.full(longest - len(row), np.nan)]) for row in rows])


def _real_folds(cone: _Cone) -> list[tuple[float, float]]:
    """(voltage, displacement) of the folds at a real voltage, in that order."""
    folds = [x for side in (-1, 1) for _, x in cone.segments[side][:-1] if cone.excess(x) < 0.0]
    return sorted((math.sqrt(w), x) for x in folds if (w := float(cone.squared(x))) >= 0.0)


def _fold_variables(cones: list[_Cone]) -> dict[str, dataset.Variable]:
    folds = [np.array(_real_folds(cone)).reshape(-1, 2) for cone in cones]
    voltage, place = (_padded([f[:, k] for f in folds]) for k in range(2))
    return {
        "fold_voltage": (("fold",), voltage, "voltage at which two equilibria meet in a fold", "voltage"),
        "fold_displacement": (("fold",), place, "displacement of the fold", "length"),
    }


def _pitchfork_variable(model: ConeModel) -> dict[str, dataset.Variable]:
    voltage = pitchfork_voltage(model).reshape(model.size)
    return {"pitchfork_voltage": ((), voltage, "voltage at which the flat film loses stability", "voltage")}


def _pull_in_variables(cones: list[_Cone], starts: list[float | None]) -> dict[str, dataset.Variable]:
    rests = [_rest(cone, near) for cone, near in zip(cones, starts, strict=True)]
    lost = [_pull_in(cone, rest) for cone, rest in zip(cones, rests, strict=True)]
    voltage, kind, before, after = (np.array([row[k] for row in lost]) for k in range(4))
    return {
        "rest_displacement": ((), np.array(rests), "stable equilibrium without voltage", "length"),
        "pull_in_voltage": ((), voltage, "voltage at which a slow ramp loses stability", "voltage"),
        "pull_in_kind": ((), kind.astype(np.int8), "how the ramp loses stability", "flag"),
        "pull_in_from": ((), before, "displacement at which the ramp loses stability", "length"),
        "pull_in_to": ((), after, "displacement that it goes to", "length"),
    }


def _with_flags(result: xr.Dataset) -> xr.Dataset:
    result["pull_in_kind"].attrs |= {
        "flag_values": np.array([kind.value for kind in PullIn], dtype=np.int8),
        "flag_meanings": " ".join(kind.name.lower() for kind in PullIn),
    }
    return result


def _branch_limit(cones: list[_Cone], levels: Array) -> float:
    """Highest voltage to which the branches are traced: past all that happens and all that was asked for."""
    events = [v for cone in cones for v, _ in _real_folds(cone)]
    events += [math.sqrt(w) for cone in cones if cone.flat and (w := float(cone.squared(0.0))) > 0.0]
    return max(1.2 * float(levels.max()), 1.5 * max(events, default=0.0), 1e-3)


def _branches(cones: list[_Cone], highest: float) -> dict[str, dataset.Variable]:
    traced = [_trace(cone, highest) for cone in cones]
    place, voltage, slope = (_padded([t[k] for t in traced]) for k in range(3))
    dims = ("branch_point",)
    return {
        "branch_displacement": (dims, place, "displacement along the equilibria", "length"),
        "branch_voltage": (dims, voltage, "constant voltage along the equilibria", "voltage"),
        "branch_slope": (dims, slope, "slope of the static force along the equilibria", "stiffness"),
    }


def _trace(cone: _Cone, highest: float) -> tuple[Array, Array, Array]:
    """Displacement, voltage and slope along all equilibria up to a voltage, one piece after the other."""
    gap = np.full((3, 1), np.nan)
    pieces = [gap]
    for segment in cone.segments[-1] + cone.segments[1]:
        begin, end = (_traced_end(cone, segment, k, highest) for k in (0, 1))
        if begin is not None and end is not None:
            pieces += [_piece(cone, segment, _closer_to_ends(begin, end)), gap]
    if cone.flat:
        pitchfork = float(cone.squared(0.0))
        lost = math.sqrt(min(max(pitchfork, 0.0), cone.highest_squared))
        voltage = np.unique([0.0, lost, min(highest, math.sqrt(cone.highest_squared))])
        slope = np.where((voltage == lost) & (pitchfork >= 0.0), 0.0, pitchfork - voltage**2)
        pieces += [np.stack([0.0 * voltage, voltage, slope]), gap]
    place, voltage, slope = np.concatenate(pieces, axis=1)
    return place, voltage, slope


def _traced_end(cone: _Cone, segment: tuple[float, float], k: int, highest: float) -> float | None:
    """One end of a segment drawn in to where 0 <= w <= highest^2; None if that leaves nothing of it."""
    w = float(cone.squared(segment[k]))
    bound = min(max(w, 0.0), highest * highest)
    return segment[k] if _equal(w, bound) else _on_segment(cone, bound, segment)


def _piece(cone: _Cone, segment: tuple[float, float], x: Array) -> Array:
    """Rows displacement, voltage and slope x dw/dx; the slope is exactly 0 in a fold or pitchfork."""
    events = [end for end in segment if abs(end) < cone.highest]
    slope = np.where(np.isin(x, events), 0.0, cone.turning(x) / np.where(x == 0.0, 1.0, x))
    squared = cone.squared(x)
    rows = np.stack([x, np.sqrt(np.maximum(squared, 0.0)), slope])
    return np.where(cone.excess(x) < 0.0, rows, np.nan)


def _closer_to_ends(begin: float, end: float) -> Array:
    """Displacements from end to end, closer together where the voltage may change fast."""
    fine = np.geomspace(1e-4, 0.02, 20)
    shares = np.concatenate([[0.0], fine, np.linspace(0.02, 0.98, 120)[1:-1], 1.0 - fine[::-1], [1.0]])
    return begin * (1.0 - shares) + end * shares
