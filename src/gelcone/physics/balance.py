"""Equilibria of one actuator under a constant voltage, and their stability on a slow voltage ramp.

The force that holds the disc at x against film, bias and a constant voltage v is F(x, V) = F_film(x, V) + F_bias(x),
with V = v^2. It falls as the voltage rises, so that away from x = 0 it vanishes at one V = w(x). There dF/dx has the
sign of x dw/dx: an equilibrium is stable where w grows with |x|, and two of them meet in a fold where x dF/dx - F = 0.
Between neighbouring folds w is monotone and has at most one equilibrium, so that none is missed, however close two are.
Where the flat film is an equilibrium at every voltage, it is stable up to the pitchfork at w(0).

In the homogeneous cone with a spring, F = x (kappa + h(q) - V) - kappa x0 and w = kappa (1 - x0/x) + h(q), q = 1 + x^2.

A film may have no state above some V: there is no equilibrium beyond, and a ramp that reaches this V ends.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone.bracket import rise, sign_change, sign_changes
from gelcone.codes import Code
from gelcone.errors import InputError
from gelcone.physics.system import ConeSystem
from gelcone.quantity import Array

SEARCH_RANGE = 1000.0
"""Largest |x| that is searched if the stretch limit lies beyond it, or if there is none."""
LEVELLED = 1.05
"""Ratio of w at the end of the search to that at half of it below which w tends to a limit, above which nothing holds
the disc."""
WALL_DISTANCE = 1e-12
"""Share of the displacements left out before the stretch limit, where the force is lost to rounding."""
NEAR_PULL_IN = 1.0 - 1e-9
"""Share of the pull-in V up to which slopes, infinite there, are evaluated."""
ROUNDING = 1e-14
"""Squared voltages that differ by less count as equal: an equilibrium then lies on its fold or pitchfork."""
FLAT_SAMPLES = 161
"""Points along the flat equilibria."""
FILM_SAMPLES = 401
_CLOSE = np.geomspace(1e-9, 0.5, 300)
GRID = np.unique(np.concatenate([_CLOSE, 1.0 - _CLOSE, np.linspace(0.0, 1.0, 400)[1:]]))
"""Points between which equilibria are searched, as shares of the |x| from the lowest to the highest, finer towards both
ends."""


class PullIn(Code):
    """Ways in which the equilibrium on a slow voltage ramp is lost.

    Examples
    --------
    >>> import gelcone
    >>> [(kind.value, kind.name) for kind in gelcone.PullIn]
    [(0, 'NEVER'), (1, 'PITCHFORK'), (2, 'FOLD'), (3, 'SEARCH_RANGE'), (4, 'FILM'), (5, 'RUNAWAY')]
    """

    NEVER = 0, "stable at every voltage"
    PITCHFORK = 1, "loses stability in a pitchfork: the flat film buckles to either side"
    FOLD = 2, "meets an unstable equilibrium in a fold and vanishes"
    SEARCH_RANGE = 3, f"stable up to {SEARCH_RANGE:g} times the width of the film, where the search ends"
    FILM = 4, "reaches a displacement at which the film pulls in"
    RUNAWAY = 5, "runs away: beyond, no displacement holds it"


STAYS = (PullIn.NEVER, PullIn.SEARCH_RANGE)
"""The kinds that lose no stability: their voltage is infinite."""


class Loss(NamedTuple):
    """A loss of stability on a slow voltage ramp: its voltage and kind, and the displacements before and after it,
    which are equal at a pitchfork from which the displacement changes continuously."""

    voltage: float
    kind: PullIn
    before: float
    after: float


NO_LOSS = Loss(math.inf, PullIn.NEVER, math.nan, math.nan)
NO_RAMP = Loss(math.nan, PullIn.NEVER, math.nan, math.nan)


@dataclass(frozen=True)
class StaticBalance:
    """One actuator of a ``system`` with the numbers ``n`` under a constant voltage.

    Displacements are ``lowest`` <= |x| <= ``highest``, NaN if there are none; ``wall`` is True where ``highest`` is the
    stretch limit, False where it is the end of the search.
    """

    system: ConeSystem
    n: Mapping[str, Any]
    lowest: float
    highest: float
    wall: bool

    @property
    def implicit(self) -> bool:
        """Whether the force at a squared voltage takes a search of its own, while `squared` takes none."""
        return False

    @property
    def reachable(self) -> bool:
        """Whether any displacement can be reached."""
        return self.lowest < self.highest

    @cached_property
    def lifted(self) -> bool:
        """Whether bias or film exert a force at x = 0."""
        return bool(abs(self.force(0.0, 0.0)) > 0.0)

    @property
    def flat(self) -> bool:
        """Whether x = 0 is an equilibrium at every voltage."""
        return not self.lifted and self.lowest == 0.0 and bool(self.system.film.odd(self.n))

    @property
    def flat_height(self) -> float:
        """The displacement at which a second film is flat; 0 without one."""
        return 0.0

    @property
    def together(self) -> StaticBalance:
        """The balance whose films in opposite phase have one voltage, as while their bias rises."""
        return self

    @cached_property
    def free_height(self) -> float:
        """The displacement at which the bias exerts no force."""
        return float(self.system.bias.free_height(self.n))

    @cached_property
    def highest_squared(self) -> float:
        """The V at which the flat film pulls in; infinite if it never does."""
        return float(self.highest_at(0.0))

    @cached_property
    def film_fails(self) -> bool:
        """Whether the film can pull in, whatever command leads to its voltage."""
        return float(self.system.film.highest_squared(0.0, self.n)) != math.inf

    @cached_property
    def segments(self) -> dict[int, list[tuple[float, float]]]:
        """Side of x = 0, -1 or 1 -> intervals on which w is monotone, from the inside out."""
        if not self.reachable:
            return {-1: [], 1: []}
        ends = {side: [side * self.lowest, *_folds(self, side), side * self.highest] for side in (-1, 1)}
        return {side: list(itertools.pairwise(x)) for side, x in ends.items()}

    @cached_property
    def _ramps(self) -> dict[float, list[_Leg]]:
        return {}

    def ramp_from(self, rest: float) -> list[_Leg]:
        """The stable branches of a ramp from ``rest``."""
        if rest not in self._ramps:
            self._ramps[rest] = _ramp(self, rest)
        return self._ramps[rest]

    def films(self, x: Any, squared: Any) -> list[Any]:
        """The squared voltage on each film at rest at x, under a squared constant command."""
        return self.system.squares_at_rest(squared, self.n)

    def highest_at(self, x: Any) -> Any:
        """The V at which the film pulls in at x; infinite if it never does."""
        return self.system.film.highest_squared(x, self.n)

    def inside(self, x: Array) -> npt.NDArray[np.bool_]:
        """Mask of the displacements at which the film can be held."""
        return (np.abs(x) >= self.lowest) & (np.abs(x) <= self.highest)

    def force_and_slope(self, x: Any, squared: Any) -> tuple[Any, Any]:
        """F(x, V) and dF/dx."""
        with np.errstate(all="ignore"):
            # also a single number as an array: the root of a negative float would be complex
            return self.system.static_force(np.asarray(x, dtype=float), np.asarray(squared, dtype=float), self.n)

    def force(self, x: Any, squared: Any) -> Any:
        """F(x, V)."""
        return self.force_and_slope(x, squared)[0]

    def slope(self, x: Any, squared: Any) -> Any:
        """dF/dx."""
        return self.force_and_slope(x, squared)[1]

    def whole(self, x: Array, squared: Array) -> npt.NDArray[np.bool_]:
        """Mask of the x inside the stretch limits at which no film has pulled in."""
        with np.errstate(all="ignore"):
            return self.inside(x) & ~np.asarray(self.system.pulled_in(x, squared, self.n))

    def stiffness(self, x: Array, squared: Array) -> Array:
        """dF/dx where the film can be held, NaN elsewhere."""
        return np.where(self.whole(x, squared), self.slope(x, squared), np.nan)

    def voltage_force(self, x: Any, squared: Any) -> Any:
        """The reduction of the force by the voltage."""
        with np.errstate(all="ignore"):
            return self.system.film.voltage_force(np.float64(x), np.asarray(self.films(x, squared)[0]), [], self.n)

    def squared(self, x: Any) -> Any:
        """w(x), the V at which x is an equilibrium; at x = 0 its limit, infinite where a force acts on the flat film.

        Above the pull-in V of the film it continues as in the cone.
        """
        return self.balancing(x)

    def balancing(self, x: Any) -> Any:
        """The squared voltage on the film at which x is an equilibrium."""
        with np.errstate(all="ignore"):
            return self.system.film.balancing(x, -self.system.bias.secant(x, self.n), self.n)

    def turning(self, x: Any) -> Any:
        """x dF/dx - F at the V of equilibrium, which has the sign of x^2 dw/dx and is smooth at x = 0."""
        squared: Any = 0.0
        with np.errstate(all="ignore"):
            if self.film_fails:
                highest = self.system.film.highest_squared(x, self.n)
                balancing = self.balancing(x)
                # infinite where the film holds the disc at any voltage: evaluated without voltage
                squared = np.where(np.isinf(balancing), 0.0, np.clip(balancing, 0.0, NEAR_PULL_IN * highest))
            return self.system.film.turning(x, squared, self.n) + self.system.bias.turning(x, self.n)

    def equilibria(self, squared: Array) -> list[list[Equilibrium]]:
        """All equilibria at each v^2, (levels,), in the order of x. An equilibrium on a fold counts once, as
        unstable."""
        equilibria: list[dict[float, bool]] = [{} for _ in squared]
        for side in (-1, 1):
            segments = self.segments[side]
            for segment in segments:
                x = roots_on_segment(self, squared, segment)
                at = np.flatnonzero(~np.isnan(x))
                stable = at.size > 0 and _rises(self, segment)
                whole = squared[at] < self.highest_at(x[at])
                for i in at[whole]:
                    equilibria[i][float(x[i])] = stable
            for _, fold in segments[:-1]:
                for i in np.flatnonzero(same_squared(float(self.squared(fold)), squared)):
                    equilibria[i][fold] = False
        if self.flat:
            pitchfork, beside = float(self.squared(0.0)), 0.5 * float(sum(self.segments[1][0]))
            # the force, and not the slope of w, which is 0 where the film is slack at w
            pull = self.force(np.full(squared.shape, beside), squared)
            held = np.where(same_squared(pitchfork, squared), pull, pitchfork - squared) > 0.0
            for i in np.flatnonzero(squared < self.highest_squared):
                equilibria[i][0.0] = bool(held[i])
        return [_with_slopes(self, level, at) for level, at in zip(squared, equilibria, strict=True)]

    def losses(self, rest: float) -> list[Loss]:
        """The losses of stability on a ramp from ``rest``, in their order. The last has an infinite voltage and one of
        the kinds `STAYS` if the ramp stays stable from there on; its voltage is NaN if nothing is stable without
        voltage."""
        legs = self.ramp_from(rest)
        begins = [*(leg.begin for leg in legs[1:]), math.copysign(math.inf, rest)]
        return [
            NO_LOSS._replace(kind=leg.end)
            if leg.end in STAYS
            else Loss(math.sqrt(leg.high), leg.end, leg.segment[1], begin)
            for leg, begin in zip(legs, begins, strict=False)
        ] or [NO_RAMP]

    def jump(self, rest: float) -> Loss:
        """The first loss of stability at which the displacement jumps or the film ends."""
        losses = self.losses(rest)
        return next(loss for loss in losses if loss.kind != PullIn.PITCHFORK or loss.after != loss.before)

    def along_ramp(self, rest: float, squared: Array) -> tuple[Array, npt.NDArray[np.int64]]:
        """The displacement, and the number of losses of stability passed, at each v^2, (levels,) each."""
        legs = self.ramp_from(rest)
        highs = np.array([leg.high for leg in legs])
        level = np.asarray(squared)[:, None]
        losses = ((highs < level) & ~same_squared(highs, level)).sum(axis=1)
        place = np.full(squared.shape, np.nan)
        for k, leg in enumerate(legs):
            here = losses == k
            flat = leg.segment == (0.0, 0.0)
            x = np.zeros(here.sum()) if flat else roots_on_segment(self, squared[here], leg.segment)
            nearest = np.where(same_squared(leg.high, squared[here]), leg.segment[1], leg.begin)
            place[here] = np.where(np.isnan(x), nearest, x)
        return place, losses

    def pitchfork(self) -> float:
        """The v^2 at which the flat film loses stability; NaN where it is not an equilibrium."""
        return float(self.squared(0.0)) if self.flat else math.nan

    def folds(self) -> list[tuple[float, float]]:
        """(voltage, displacement) of the folds at real voltages, sorted by voltage."""
        folds = [x for side in (-1, 1) for _, x in self.segments[side][:-1] if self.excess(x) < 0.0]
        return sorted((math.sqrt(w), x) for x in folds if (w := float(self.squared(x))) >= 0.0)

    def curves(self, highest: float) -> list[Array]:
        """Displacement, voltage and slope, (3, points), along each curve of equilibria up to a voltage; folds and
        pitchforks are points of the curves."""
        curves = []
        for segment in self.segments[-1] + self.segments[1]:
            start, end = (_traced_end(self, segment, k, highest) for k in (0, 1))
            if start is not None and end is not None:
                curves.append(_piece(self, segment, _closer_to_ends(start, end)))
        if self.flat:
            pitchfork = float(self.squared(0.0))
            lost = math.sqrt(min(max(pitchfork, 0.0), self.highest_squared))
            end = min(highest, math.sqrt(self.highest_squared))
            voltage = np.unique([*np.linspace(0.0, end, FLAT_SAMPLES), min(lost, end)])
            away = self.balancing(0.0) - self.films(0.0, voltage**2)[0]
            slope = np.where((voltage == lost) & (pitchfork >= 0.0), 0.0, away)
            curves.append(np.stack([0.0 * voltage, voltage, slope]))
        return curves

    def excess(self, x: Any) -> Any:
        """w(x) over the pull-in V, less 1: positive where there is no equilibrium."""
        if not self.film_fails:
            return np.full(np.shape(x), -1.0)[()]
        return self.squared(x) / self.highest_at(x) - 1.0


def single_balance(system: ConeSystem, n: Mapping[str, Any]) -> StaticBalance:
    """Make the balance of an actuator with one film, searched up to its stretch limit or `SEARCH_RANGE`."""
    begin, end = system.film.reach(n)
    highest = end * (1.0 - WALL_DISTANCE)
    wall = not highest > SEARCH_RANGE
    return StaticBalance(system, n, begin * (1.0 + WALL_DISTANCE), highest if wall else SEARCH_RANGE, wall)


def _folds(balance: StaticBalance, side: int) -> list[float]:
    """Folds on one side of x = 0, from the inside out, also those with a negative v^2."""
    x = side * (balance.lowest + (balance.highest - balance.lowest) * GRID)
    signs = np.sign(balance.turning(x))
    x, signs = x[np.abs(signs) > 0.0], signs[np.abs(signs) > 0.0]  # a film may have no state next to the flat one
    turns = np.flatnonzero(signs[:-1] != signs[1:])
    # where the film has no state a fold only separates intervals: its exact place does not matter
    with np.errstate(all="ignore"):
        exists = (balance.excess(x[turns]) < 0.0) | (balance.excess(x[turns + 1]) < 0.0)
    try:
        return [
            sign_change(balance.turning, x[i], x[i + 1]) if held else 0.5 * float(x[i] + x[i + 1])
            for i, held in zip(turns, exists, strict=True)
        ]
    except ArithmeticError as lost:
        law = getattr(balance.system.film, "law", None)
        if balance.wall or law is None:
            raise
        raise InputError(
            f"law = {law.name}: its response overflows within {balance.highest:g} times the width of the film, "
            "the end of the search; give the law a strain_limit, the I1 - 3 at which the film is as stiff as a wall"
        ) from lost


def _rises(balance: StaticBalance, segment: tuple[float, float]) -> bool:
    """Whether w grows with |x| on the segment, so that its equilibria are stable."""
    middle = 0.5 * (segment[0] + segment[1])
    turning = middle * float(balance.turning(middle))
    if turning == 0.0:  # without bias a film that wrinkles has no tension at w: rounding decides whether it pulls
        return bool(balance.squared(segment[1]) > balance.squared(segment[0]))
    return turning > 0.0


def roots_on_segment(balance: StaticBalance, squared: Array, segment: tuple[float, float]) -> Array:
    """The root x of w(x) = v^2 inside a segment for each v^2, (levels,); NaN if there is none."""

    def excess(x: Array) -> Array:
        if balance.implicit or not balance.lifted:
            return np.asarray(balance.squared(x) - squared)
        force = np.asarray(balance.force(x, squared))
        if not np.isnan(force).any():
            return force
        above = np.asarray(balance.squared(x) - squared)
        # a film that has pulled in has no force: take its sign from w, so that no root before pull-in is missed
        return np.where(np.isnan(force), math.copysign(1.0, segment[1]) * np.sign(above), force)

    ends = [np.full(squared.shape, x) for x in segment]
    at_end = [same_squared(float(balance.squared(x)), squared) for x in segment]
    return np.where(at_end[0] | at_end[1], np.nan, sign_changes(excess, *ends))


def root_on_segment(balance: StaticBalance, squared: float, segment: tuple[float, float]) -> float | None:
    """The root on a segment for one v^2; None if there is none."""
    x = float(roots_on_segment(balance, np.array([squared]), segment)[0])
    return None if math.isnan(x) else x


def same_squared(a: Any, b: Any) -> Any:
    """Whether two squared voltages agree to rounding."""
    return np.abs(a - b) <= ROUNDING * (1.0 + np.abs(b))


class Equilibrium(NamedTuple):
    """A displacement at which the forces balance, the slope of the force there, and whether it is stable."""

    displacement: float
    slope: float
    stable: bool


def _with_slopes(balance: StaticBalance, squared: float, found: Mapping[float, bool]) -> list[Equilibrium]:
    places = sorted(found)
    slopes = balance.slope(np.array(places), squared) if places else ()
    return [Equilibrium(x, float(slope), found[x]) for x, slope in zip(places, slopes, strict=True)]


# --- a slow voltage ramp ------------------------------------------------------------------------------------------


class _Leg(NamedTuple):
    """A stable branch of the ramp: v^2 grows from ``low`` to ``high``, |x| from ``begin`` within ``segment``."""

    low: float
    high: float
    begin: float
    segment: tuple[float, float]
    end: PullIn


def rest_of(balance: StaticBalance, near: float | None) -> float:
    """The stable equilibrium without voltage nearest to ``near``; NaN if there is none."""
    stable = [e.displacement for e in balance.together.equilibria(np.zeros(1))[0] if e.stable]
    target = balance.free_height if near is None else near
    return min(stable, key=lambda x: (abs(x - target), -x), default=math.nan)


def _ramp(balance: StaticBalance, rest: float) -> list[_Leg]:
    """The stable branches of a ramp from ``rest``; after each, the force leads outwards to the next."""
    if math.isnan(rest):
        return []
    legs = []
    low, side = 0.0, -1 if rest < 0.0 else 1
    if rest == 0.0:
        low = max(float(balance.squared(0.0)), 0.0)
        if low >= balance.highest_squared:
            return [_Leg(0.0, balance.highest_squared, 0.0, (0.0, 0.0), PullIn.FILM)]
        legs.append(_Leg(0.0, low, 0.0, (0.0, 0.0), PullIn.PITCHFORK))
    segments = [s for s in balance.segments[side] if abs(s[1]) > abs(rest)]
    for segment in segments:
        outermost = segment is segments[-1]
        top = float(balance.squared(segment[1]))
        if not _rises(balance, segment) or top <= low:
            continue
        root = root_on_segment(balance, low, segment)
        start = segment[0] if root is None else root
        end = PullIn.FOLD if not outermost else far_end(balance.wall, float(balance.squared(0.5 * segment[1])), top)
        high = math.inf if end == PullIn.NEVER else top
        lost = _film_lost(balance, segment, start)
        if lost is not None:
            # w may be infinitely steep where the film pulls in, so that the voltage is that of the film
            squared = balance.squared if lost in (start, segment[1]) else balance.highest_at
            legs.append(_Leg(low, float(squared(lost)), start, (segment[0], lost), PullIn.FILM))
            break
        legs.append(_Leg(low, high, start, segment, end))
        low = top
    return legs


def far_end(wall: bool, halfway: float, end: float) -> PullIn:
    """The end of a ramp at the last displacement searched, a stretch limit or not, from w there and halfway to it."""
    if wall:
        return PullIn.NEVER
    return PullIn.RUNAWAY if end < LEVELLED * halfway else PullIn.SEARCH_RANGE


def _film_lost(balance: StaticBalance, segment: tuple[float, float], begin: float) -> float | None:
    """The displacement on a rising segment at which the film pulls in, or its range ends; None if it does not."""
    if not balance.film_fails:
        return None
    x = np.linspace(begin, segment[1], FILM_SAMPLES)
    over = np.flatnonzero(balance.excess(x) >= 0.0)
    if not over.size:
        return float(x[-1]) if segment is balance.segments[-1 if x[-1] < 0.0 else 1][-1] else None
    k = int(over[0])
    return float(x[0]) if k == 0 else float(rise(balance.excess, x[k - 1], x[k]))


# --- curves of equilibria -----------------------------------------------------------------------------------------


def _traced_end(balance: StaticBalance, segment: tuple[float, float], k: int, highest: float) -> float | None:
    """The k-th end of a segment, moved to where 0 <= w <= highest^2; None if nothing of the segment is left."""
    w = float(balance.squared(segment[k]))
    bound = min(max(w, 0.0), highest * highest)
    return segment[k] if same_squared(w, bound) else root_on_segment(balance, bound, segment)


def _piece(balance: StaticBalance, segment: tuple[float, float], x: Array) -> Array:
    """Rows displacement, voltage and slope x dw/dx; the slope is exactly 0 in a fold or pitchfork."""
    events = [end for end in segment if abs(end) < balance.highest]
    slope = np.where(np.isin(x, events), 0.0, balance.turning(x) / np.where(x == 0.0, 1.0, x))
    squared = balance.squared(x)
    rows = np.stack([x, np.sqrt(np.maximum(squared, 0.0)), slope])
    return np.where(balance.excess(x) < 0.0, rows, np.nan)


def _closer_to_ends(begin: float, end: float) -> Array:
    """Displacements from ``begin`` to ``end``, closer together at both, where the voltage may change fast."""
    fine = np.geomspace(1e-4, 0.02, 20)
    shares = np.concatenate([[0.0], fine, np.linspace(0.02, 0.98, 120)[1:-1], 1.0 - fine[::-1], [1.0]])
    return begin * (1.0 - shares) + end * shares
