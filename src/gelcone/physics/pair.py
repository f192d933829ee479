"""Equilibria of a double cone under constant voltages, and their stability on a slow voltage ramp.

The voltages of the two films pull the disc in opposite directions, so that at one displacement the force may vanish at
several voltages, unlike in `gelcone.physics.balance`. Equilibria at one voltage are found between the extrema of the
force, and these between the points of a fine grid. Over the voltage equilibria form curves F(x, v) = 0, which are
followed along their tangent. Where the slope of the force changes its sign, the curve has a fold if the voltage turns
back there, else a pitchfork. Allgower and Georg, Introduction to Numerical Continuation Methods (2003), chapter 2.

A slow ramp of films in opposite phase raises both together to the bias v0; from there the first goes to v, and the
second to 2 v0 - v.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone.bracket import sign_change, sign_changes
from gelcone.physics.at_rest import BIAS_SHARE
from gelcone.physics.balance import (
    NO_LOSS,
    NO_RAMP,
    ROUNDING,
    SEARCH_RANGE,
    STAYS,
    WALL_DISTANCE,
    Equilibrium,
    Loss,
    PullIn,
    StaticBalance,
    far_end,
    rest_of,
    same_squared,
)
from gelcone.quantity import Array

GRID = 1601
"""Number of displacements between which equilibria are searched."""
HIGHEST_VOLTAGE = 20.0
"""A ramp without a loss of stability up to this voltage counts as stable."""
LONGEST_STEP = 0.04
"""Longest step along a curve, over 1 + v + |x|."""
LEAST_COSINE = 0.995
"""Least cosine of the angle between the tangents at neighbouring points of a curve."""
KINK = 1e-6
"""A turn within a shorter step is a kink of the curve: where a film begins to wrinkle the stiffness jumps."""
SHORTEST_STEP = 1e-10
MOST_POINTS = 20_000
MOST_LOSSES = 8
HIGHEST_FOLD = 6.0
"""Voltage up to which folds are searched."""
SEEDS = np.concatenate([np.linspace(0.0, 0.1, 17), np.geomspace(0.1, 1.0, 9)[1:]])
"""Shares of the highest voltage at which further curves are searched."""
BEYOND = 1e-6
"""Share of the voltage past a loss of stability at which the next equilibrium is searched."""
SMOOTH = 0.02
"""Largest distance of a branch from its pitchfork at that voltage: it grows with the square root of the share."""
ON_CURVE = 1e-6


class Curve(NamedTuple):
    """Points of a curve of equilibria, or of a stable part of a ramp, (points,) each, and the kind of its end:
    `PullIn.NEVER` at the bounds of the voltage."""

    x: Array
    voltage: Array
    end: PullIn


@dataclass(frozen=True)
class PairBalance(StaticBalance):
    """One double cone with displacements from ``lowest`` to ``highest``, which need not be symmetric about 0."""

    # --- forces ------------------------------------------------------------------------------------------------------

    @cached_property
    def flat(self) -> bool:
        odd = all(bool(film.odd(self.n)) for film in self.system.films)
        return odd and self.lowest < 0.0 < self.highest and not self.lifted

    @property
    def flat_height(self) -> float:
        return float(self.n["second_flat_height"])

    @cached_property
    def bias(self) -> float:
        """The voltage of both films from which a ramp of films in opposite phase begins; else 0."""
        fixed = self.system.in_opposite_phase and BIAS_SHARE not in self.n
        return abs(float(self.n["voltage_bias"])) if fixed else 0.0

    @cached_property
    def together(self) -> PairBalance:
        return replace(self, n={**self.n, BIAS_SHARE: 1.0}) if self.bias else self

    @property
    def film_fails(self) -> bool:
        return False

    @cached_property
    def highest_squared(self) -> float:
        return math.inf

    def inside(self, x: Array) -> npt.NDArray[np.bool_]:
        """Mask of the displacements at which both films can be held."""
        with np.errstate(all="ignore"):
            reached = self.system.strain(x, self.n) < self.system.strain_limit(self.n)
        return (x >= self.lowest) & (x <= self.highest) & reached

    def voltage_force(self, x: Any, squared: Any) -> Any:
        """The reduction of the force by the voltages, without that of a constant voltage on the second film."""
        squares = np.asarray(squared)
        with np.errstate(all="ignore"):
            return self.together.force(x, 0.0 * squares) - self.force(x, squares)

    def _slopes(self, x: float, voltage: float) -> tuple[float, float, float]:
        """F, dF/dx and dF/dv."""
        system, n, place, squared = self.system, self.n, np.float64(x), np.float64(voltage * voltage)
        squares, changes = system.squares_at_rest(squared, n), system.square_rates_at_rest(voltage, n)
        with np.errstate(all="ignore"):
            force, slope = system.force_under(place, squares, n)
            first, *others = (
                film.voltage_gain(place, square, n) * change
                for film, square, change in zip(system.films, squares, changes, strict=True)
            )
            gain = sum(others, first)
        return float(force), float(slope), -float(gain)

    def _pulled_in(self, x: Any, squared: float) -> Any:
        """Whether a film has no state at x (a number or an array), at the squared voltage on the first."""
        at = np.asarray(x, dtype=float)
        squares = self.films(at, np.float64(squared))
        fails = at != at
        for film, square in zip(self.system.films, squares, strict=True):
            fails = fails | (square >= film.highest_squared(at, self.n))
        return fails & (at == at)

    # --- equilibria at one voltage -----------------------------------------------------------------------------------

    @cached_property
    def grid(self) -> Array:
        """Displacements from ``lowest`` to ``highest``, closer between the planes of the films and at both ends, with 0
        and the middle between the planes, where a double cone may be symmetric."""
        height = self.flat_height
        middle, width = 0.5 * height, max(0.5 * abs(height), 0.5)
        low, high = (math.asinh((end - middle) / width) for end in (self.lowest, self.highest))
        even = middle + width * np.sinh(np.linspace(low, high, GRID))
        near = (self.highest - self.lowest) * np.geomspace(1e-9, 1e-2, 100)
        ends = [self.lowest + near, self.highest - near, [0.0, middle, height, self.lowest, self.highest]]
        x = np.unique(np.concatenate([even, *ends]))
        return np.asarray(x[self.inside(x)])

    def equilibria(self, squared: Array) -> list[list[Equilibrium]]:
        """All equilibria at each v^2, (levels,), in the order of x. An equilibrium of zero slope counts as unstable."""
        return [self._equilibria(float(level)) for level in squared]

    def _equilibria(self, squared: float) -> list[Equilibrium]:
        nodes, values = self._nodes(squared)
        at = np.flatnonzero(values[:-1] * values[1:] < 0.0)
        roots = sign_changes(lambda x: self.force(x, squared), nodes[at], nodes[at + 1])
        places = np.sort(np.concatenate([_isolated(nodes, values == 0.0), roots]))
        places = places[~self._pulled_in(places, squared)]
        slopes = np.broadcast_to(self.slope(places, squared), places.shape)
        return [Equilibrium(float(x), float(k), bool(k > ROUNDING)) for x, k in zip(places, slopes, strict=True)]

    def _nodes(self, squared: float) -> tuple[Array, Array]:
        """Displacements between neighbours of which the force changes its sign at most once, and the forces there."""
        x = self.grid
        force = np.broadcast_to(self.force(x, squared), x.shape)
        near = np.flatnonzero(_near_zero(force))
        # the force may change its sign twice between two points of the grid, around an extremum
        turns = near[np.prod(self.slope(np.stack([x[near], x[near + 1]]), squared), axis=0) < 0.0]
        if not turns.size:
            return x, force
        tops = sign_changes(lambda x: self.slope(x, squared), x[turns], x[turns + 1])
        order = np.argsort(nodes := np.concatenate([x, tops]))
        return nodes[order], np.concatenate([force, self.force(tops, squared)])[order]

    # --- curves of equilibria ----------------------------------------------------------------------------------------

    def curve(self, x: float, voltage: float, ahead: float, highest: float) -> Curve:
        """Follow the curve of an equilibrium, first to rising (``ahead`` 1) or falling (-1) voltage."""
        tangent = self._tangent(x, voltage, (0.0, ahead))
        xs, volts, step = [x], [voltage], 0.1 * LONGEST_STEP
        while len(xs) < MOST_POINTS:
            point = self._next(x, voltage, tangent, step)
            if point is not None:
                turned = self._tangent(*point, tangent)
                bend = turned[0] * tangent[0] + turned[1] * tangent[1]
            if (
                point is None
                or (bend < LEAST_COSINE and step > KINK)
                or (point[1] >= 0.0 and self._pulled_in(point[0], point[1] ** 2))
            ):
                step *= 0.5
                if step < SHORTEST_STEP:
                    return Curve(np.array(xs), np.array(volts), PullIn.FILM)
                continue
            bound = 0.0 if point[1] < 0.0 else highest if point[1] > highest else None
            if bound is not None:
                share = (bound - voltage) / (point[1] - voltage) if point[1] != voltage else 0.0
                (last,) = self._settle(np.array([x + share * (point[0] - x)]), np.array([bound]))
                return Curve(np.array([*xs, last]), np.array([*volts, bound]), PullIn.NEVER)
            x, voltage, tangent = *point, turned
            if not self.lowest < x < self.highest:
                halfway = volts[int(np.argmin(np.abs(np.abs(xs) - 0.5 * abs(x))))]
                return Curve(np.array(xs), np.array(volts), far_end(self.wall, halfway**2, voltage**2))
            xs.append(x)
            volts.append(voltage)
            size = LONGEST_STEP * (1.0 + voltage + abs(x))
            step = min(1.5 * step, size)
            if len(xs) > 10 and math.hypot(x - xs[0], voltage - volts[0]) < 0.5 * step:
                break
        return Curve(np.array(xs), np.array(volts), PullIn.NEVER)

    def _tangent(self, x: float, voltage: float, like: tuple[float, float]) -> tuple[float, float]:
        _, slope, gain = self._slopes(x, voltage)
        size = math.hypot(slope, gain)
        if not size > 0.0:
            return like
        along = (gain / size, -slope / size)
        sign = math.copysign(1.0, along[0] * like[0] + along[1] * like[1])
        return sign * along[0], sign * along[1]

    def _next(self, x: float, voltage: float, tangent: tuple[float, float], step: float) -> tuple[float, float] | None:
        """The point of the curve one step ahead, by Newton's method across the tangent; None if that fails."""
        ahead = (x + step * tangent[0], voltage + step * tangent[1])
        at = ahead
        for _ in range(8):
            force, slope, gain = self._slopes(at[0], max(at[1], 0.0))
            across = (at[0] - ahead[0]) * tangent[0] + (at[1] - ahead[1]) * tangent[1]
            size = slope * tangent[1] - gain * tangent[0]
            if not (math.isfinite(force) and size):
                return None
            change = (-(force * tangent[1] - gain * across) / size, -(slope * across - force * tangent[0]) / size)
            at = (at[0] + change[0], at[1] + change[1])
            if math.hypot(*change) < 1e-12 * (1.0 + abs(at[0]) + abs(at[1])):
                return at if math.hypot(at[0] - ahead[0], at[1] - ahead[1]) < 0.5 * step else None
            if at[1] < 0.0 and tangent[1] < 0.0:
                return at
        return None

    def _settle(self, x: Array, voltage: Array) -> Array:
        """Find the equilibria near displacements at voltages by Newton's method."""
        x, going = np.array(x), np.arange(x.size)
        for _ in range(30):
            if not going.size:
                break
            force, slope = self.force_and_slope(x[going], voltage[going] ** 2)
            moves = slope != 0.0
            force, slope, going = force[moves], slope[moves], going[moves]
            with np.errstate(all="ignore"):
                x[going] -= force / slope
                going = going[~(np.abs(force) < 1e-15 * np.abs(slope) * (1.0 + np.abs(x[going])))]
        return x

    def _turn(self, x: Array, voltage: Array, i: int) -> tuple[float, float]:
        """Displacement and voltage between points i and i + 1 of a curve at which the slope of the force vanishes."""

        def at(share: float) -> tuple[float, float]:
            place = float(x[i] + share * (x[i + 1] - x[i]))
            level = float(voltage[i] + share * (voltage[i + 1] - voltage[i]))
            if abs(x[i + 1] - x[i]) < abs(voltage[i + 1] - voltage[i]) * 1e-3:  # x is the same: a pitchfork
                return place, level
            for _ in range(30):
                force, _, gain = self._slopes(place, level)
                if not gain:
                    break
                level -= force / gain
                if abs(force) < 1e-16 * abs(gain) * (1.0 + level):
                    break
            return place, level

        def slope(share: float) -> float:
            place, level = at(share)
            return float(self.slope(place, level * level))

        if not slope(0.0) * slope(1.0) < 0.0:
            return float(x[i]), float(voltage[i])
        return at(sign_change(slope, 0.0, 1.0))

    def _losses(self, x: Array, voltage: Array) -> list[tuple[int, float, float, PullIn]]:
        """Sign changes of the slope along a curve: index of the point before, displacement, voltage, fold or
        pitchfork."""
        signs = np.sign(np.broadcast_to(self.slope(x, voltage * voltage), x.shape))
        losses = []
        for i in np.flatnonzero(signs[:-1] * signs[1:] < 0.0):
            place, level = self._turn(x, voltage, int(i))
            before = voltage[i] - voltage[i - 1] if i else voltage[i + 1] - voltage[i]
            after = voltage[i + 2] - voltage[i + 1] if i + 2 < len(x) else voltage[i + 1] - voltage[i]
            fold = before * after < 0.0
            losses.append((int(i), place, level, PullIn.FOLD if fold else PullIn.PITCHFORK))
        return losses

    def curves(self, highest: float) -> list[Array]:
        curves = [self._with_losses(*curve) for curve in self._followed(highest)]
        return [np.stack([x, v, np.broadcast_to(self.slope(x, v * v), x.shape)]) for x, v in curves]

    def _followed(self, highest: float) -> list[tuple[Array, Array]]:
        known: list[tuple[Array, Array]] = []
        for level in highest * SEEDS:
            if all(any(_on(x, level, *curve) for curve in known) for x in self._roughly(float(level * level))):
                continue
            for e in self._equilibria(float(level * level)):
                if not any(_on(e.displacement, level, *curve) for curve in known):
                    known.append(self._whole(e.displacement, float(level), highest))
        return known

    def _roughly(self, squared: float) -> Array:
        """The equilibria, and other zeros of the force, by straight lines between the points of the grid."""
        x, force = self._nodes(squared)
        at = np.flatnonzero(force[:-1] * force[1:] <= 0.0)
        share = force[at] / np.where(force[at] == force[at + 1], 1.0, force[at] - force[at + 1])
        return np.asarray(x[at] + share * (x[at + 1] - x[at]))

    def _whole(self, x: float, voltage: float, highest: float) -> tuple[Array, Array]:
        ahead, behind = (self.curve(x, voltage, side, highest) for side in (1.0, -1.0))
        if voltage == 0.0:
            return ahead.x, ahead.voltage
        if voltage == highest:
            return behind.x, behind.voltage
        x_of_all = np.concatenate([behind.x[:0:-1], ahead.x])
        return x_of_all, np.concatenate([behind.voltage[:0:-1], ahead.voltage])

    def _with_losses(self, x: Array, voltage: Array) -> tuple[Array, Array]:
        losses = self._losses(x, voltage)
        at = [i + 1 for i, *_ in losses]
        return np.insert(x, at, [row[1] for row in losses]), np.insert(voltage, at, [row[2] for row in losses])

    def folds(self) -> list[tuple[float, float]]:
        """(voltage, displacement) of all folds up to `HIGHEST_FOLD`, sorted by voltage."""
        rows = [row for curve in self._followed(HIGHEST_FOLD) for row in self._losses(*curve) if row[3] == PullIn.FOLD]
        return sorted((level, place) for _, place, level, _ in rows)

    def pitchfork(self) -> float:
        """The v^2 at which the flat films, or raised ones in the middle, lose stability to either side; infinite if the
        flat films never lose it, NaN if they are unstable without voltage, or raised ones do not lose it so."""
        if not self.flat:
            first = self.losses(rest_of(self, None))[0]
            return first.voltage**2 if first.kind == PullIn.PITCHFORK else math.nan
        if not float(self.slope(0.0, self.bias**2)) > 0.0:
            return math.nan
        levels = np.concatenate([np.linspace(0.0, 4.0, 401), np.geomspace(4.0, HIGHEST_VOLTAGE, 101)[1:]]) + self.bias
        slopes = self.slope(np.zeros(levels.size), levels * levels)
        lost = np.flatnonzero(slopes < 0.0)
        if not lost.size:
            return math.inf
        return sign_change(lambda v: self.slope(0.0, v * v), levels[lost[0] - 1], levels[lost[0]]) ** 2

    # --- a slow voltage ramp -----------------------------------------------------------------------------------------

    def begin(self, rest: float) -> float:
        """The displacement at the `bias`, reached from ``rest``."""
        return float(self.together.along_ramp(rest, np.array([self.bias**2]))[0][0]) if self.bias else rest

    @cached_property
    def _legs(self) -> dict[tuple[float, float, float], list[Curve]]:
        return {}

    def legs(self, rest: float, highest: float = HIGHEST_VOLTAGE, ahead: float = 1.0) -> list[Curve]:
        """The stable parts of a ramp from ``rest``, from the `bias` up to ``highest`` or (``ahead`` -1) down to 0."""
        if (rest, highest, ahead) not in self._legs:
            self._legs[rest, highest, ahead] = self._ramp(rest, highest, ahead)
        return self._legs[rest, highest, ahead]

    def _ramp(self, rest: float, highest: float, ahead: float) -> list[Curve]:
        legs: list[Curve] = []
        x, voltage = self.begin(rest), self.bias
        while not math.isnan(x) and len(legs) < MOST_LOSSES and (voltage < highest if ahead > 0.0 else voltage > 0.0):
            path = self.curve(x, voltage, ahead, highest)
            losses = self._losses(path.x, path.voltage)
            if not losses:
                legs.append(path)
                break
            i, place, level, kind = losses[0]
            legs.append(Curve(np.append(path.x[: i + 1], place), np.append(path.voltage[: i + 1], level), kind))
            x, voltage = self._beyond(place, level, ahead)
        return legs

    def _beyond(self, x: float, voltage: float, ahead: float) -> tuple[float, float]:
        """The stable equilibrium, with its voltage, to which the force leads after a loss of stability; of two equally
        near ones the higher."""
        level = voltage + ahead * BEYOND * (1.0 + voltage)
        stable = [e.displacement for e in self._equilibria(level * level) if e.stable]
        push = -float(self.force(x, level * level))
        if abs(push) > ROUNDING:
            stable = [place for place in stable if (place - x) * push > 0.0]
        return min(stable, key=lambda place: (round(abs(place - x), 9), -place), default=math.nan), level

    def losses(self, rest: float) -> list[Loss]:
        legs = self.legs(rest)
        return [self._loss(legs, k) for k in range(len(legs))] or [NO_RAMP]

    def _loss(self, legs: Sequence[Curve], k: int) -> Loss:
        """The loss of stability at the end of the k-th leg."""
        leg = legs[k]
        if leg.end in STAYS:
            return NO_LOSS._replace(kind=leg.end)
        voltage, before = float(leg.voltage[-1]), float(leg.x[-1])
        if k + 1 == len(legs):
            after = math.copysign(math.inf, -float(self.force(before, (voltage * (1.0 + BEYOND)) ** 2)))
        else:
            after = float(legs[k + 1].x[0])
        smooth = leg.end == PullIn.PITCHFORK and abs(after - before) < SMOOTH
        return Loss(voltage, leg.end, before, before if smooth else after)

    def along_ramp(self, rest: float, squared: Array) -> tuple[Array, npt.NDArray[np.int64]]:
        levels, begin = np.sqrt(squared), self.begin(rest)
        place, losses = np.full(squared.shape, begin), np.zeros(squared.shape, dtype=np.int64)
        highest = max(float(levels.max()), self.bias) + 1e-9
        for ahead, way in ((1.0, levels > self.bias), (-1.0, levels < self.bias)):
            if way.any():
                known = highest < HIGHEST_VOLTAGE and (rest, HIGHEST_VOLTAGE, ahead) in self._legs
                legs = self.legs(rest, HIGHEST_VOLTAGE if known else highest, ahead)
                place[way], losses[way] = self._along(legs, ahead, squared[way])
        return place, losses

    def _along(self, legs: Sequence[Curve], ahead: float, squared: Array) -> tuple[Array, npt.NDArray[np.int64]]:
        """The displacements on a ramp at squared voltages, NaN past its end, and the losses of stability before."""
        levels, place = np.sqrt(squared), np.full(squared.shape, np.nan)
        ends = np.array([leg.voltage[-1] for leg in legs]).reshape(-1, 1)
        losses = ((ahead * (levels - ends) > 0.0) & ~same_squared(ends**2, squared)).sum(axis=0)
        for k, leg in enumerate(legs):
            on = losses == k
            guess = np.interp(ahead * levels[on], ahead * leg.voltage, leg.x)
            place[on] = self._settle(guess, levels[on])
        return place, losses


def _near_zero(force: Array) -> npt.NDArray[np.bool_]:
    """Whether forces without a sign change between neighbours, (points - 1,), are as small as they change nearby, so
    that they may vanish at an extremum between."""
    changes = np.abs(np.diff(force))
    largest = np.fmax(changes, np.fmax(np.append(changes[1:], 0.0), np.append(0.0, changes[:-1])))
    nearest = np.minimum(np.abs(force[:-1]), np.abs(force[1:]))
    return (force[:-1] * force[1:] >= 0.0) & (nearest <= largest)


def _isolated(x: Array, holds: npt.NDArray[np.bool_]) -> list[float]:
    """The places in a mask, only the middle one of each run of neighbours, as where no force acts on a slack film."""
    at = np.flatnonzero(holds)
    bands = np.split(at, np.flatnonzero(np.diff(at) > 1) + 1) if at.size else []
    return [float(x[band[len(band) // 2]]) for band in bands]


def _on(x: float, voltage: float, xs: Array, volts: Array) -> bool:
    """Whether a point lies on a curve, within the error of the straight lines between its points."""
    if not xs.size > 1:
        return False
    dx, dv = np.diff(xs), np.diff(volts)
    size = np.maximum(dx * dx + dv * dv, 1e-300)
    share = np.clip(((x - xs[:-1]) * dx + (voltage - volts[:-1]) * dv) / size, 0.0, 1.0)
    away = np.hypot(x - xs[:-1] - share * dx, voltage - volts[:-1] - share * dv)
    return bool((away < ON_CURVE + 0.02 * np.sqrt(size)).any())


def pair_balance(system: Any, n: Any) -> PairBalance:
    """Make the balance of a double cone, searched up to its stretch limits or `SEARCH_RANGE`."""
    lows, highs, nearest = zip(*(film.reach(n) for film in system.films), strict=True)
    lowest, highest = max(lows), min(highs)
    if any(map(math.isnan, (*lows, *highs, *nearest))) or not lowest < highest:
        return PairBalance(system, n, math.nan, math.nan, False)
    margin = WALL_DISTANCE * (1.0 + min(abs(lowest), abs(highest), SEARCH_RANGE))
    wall = highest <= SEARCH_RANGE and lowest >= -SEARCH_RANGE
    return PairBalance(system, n, max(lowest + margin, -SEARCH_RANGE), min(highest - margin, SEARCH_RANGE), wall)
