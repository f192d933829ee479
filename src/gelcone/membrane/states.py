"""States of a film at held heights and voltages, by shooting from the disc to the rim.

Lengths in b - a, forces over mu Vol/(b - a). A state is found from what its innermost ring is: its stretch l1 and slope
u; sig tells where the rim lies. `Film.table` finds all states in tension without a start to guess: at a given V and l1
the slope alone is unknown. `Film.held` refines states at given heights.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from gelcone.membrane.gel import Array, Gel, bisected
from gelcone.membrane.rings import CHARGE, HEIGHT, HOOP, LOG, Rings, S, begin, march, rates

NUDGE = 1e-6
"""Step of the differences that make Newton's matrices."""
ACCURATE = 1e-11
GOOD = 1e-8
"""Largest miss of the rim of a state that was found."""
STEPS = 12
SLOPES = np.concatenate([np.linspace(-2.0, 3.2, 22), [4.0, 5.0, 6.5, 9.0]])
"""Slopes u beside the disc of a scan."""
SCAN_END, SCAN_STEPS = 14.0, 28
ROW = np.concatenate([[1e-6, 1e-5, 1e-4, 1e-3], np.linspace(0.08, 1.0, 24) ** 2 * 0.9999])
"""Shares of the way from the innermost ring's first stretch to its last, at which states are found from a scan."""
NEARBY = 0.3
"""Share of the lowest height found from which Newton's method still converges."""
NEAR_LOCALISATION = 3.0
"""Grading of the steps from a ring that is about to localise: T11 grows there like the root of s."""
JUST_BEFORE = 1e-11
"""Of the stretch at which the hoop of a ring falls slack, where both laws meet."""
FARTHEST = 30.0
"""Largest meridional stretch that is looked at."""
LIMIT_SHARE = 0.9
"""Share of the stretch limit beside the disc up to which states are looked for."""


class States(NamedTuple):
    """Held states: the stretch ``l1``, slope ``u`` beside the disc and ``end`` of sig; height, force, ``area`` (the
    charge over the voltage, mean square of the deformed over the mounted area) and the rim's ``miss``."""

    V: Array
    l1: Array
    u: Array
    end: Array
    x: Array
    force: Array
    area: Array
    miss: Array

    def where(self, which: Any) -> States:
        """Those of an index or mask."""
        return States(*(values[which] for values in self))


class Ends(NamedTuple):
    """The innermost ring's stretch where it comes under tension, and where it localises or reaches its limit."""

    low: Array
    high: Array
    localises: Array


class Profile(NamedTuple):
    """A state along the film, from the disc to the rim: mounted and deformed radius, depth below the disc, squared
    lengths over the mounted ones, true field over sqrt(mu/eps), firmness, and whether the hoop is slack."""

    mounted: Array
    radius: Array
    depth: Array
    m: Array
    n: Array
    field: Array
    firmness: Array
    slack: Array


@dataclass(frozen=True)
class Film:
    """A gel on a ring: ``ratio`` is the disc's radius over the ring's, a/b."""

    gel: Gel
    ratio: float

    @property
    def disc(self) -> float:
        """a."""
        return self.ratio / (1.0 - self.ratio)

    @property
    def span(self) -> float:
        """ln(b/a)."""
        return float(-np.log(self.ratio))

    @property
    def mounted(self) -> float:
        """b^2 - a^2."""
        return 1.0 + 2.0 * self.disc

    # --- one ring -----------------------------------------------------------------------------------------------------

    def ends(self, V: Array) -> Ends:
        """Of the innermost ring, whose hoop is held."""
        gel, column = self.gel, np.arange(V.size)
        grid = np.geomspace(0.2, FARTHEST, 1200)[:, None] * np.ones(V.size)
        one = np.ones_like(V)
        with np.errstate(all="ignore"):
            ring = gel.at(grid, np.ones_like(grid), np.broadcast_to(V, grid.shape))
            share = gel.strain(grid * grid, ring.width) / gel.strain_limit
            known = (share < 1.0) & np.isfinite(ring.meridional)
            rises = known[:-1] & known[1:] & (ring.meridional[:-1] <= 0.0) & (ring.meridional[1:] > 0.0)
            first = np.argmax(rises, axis=0)
            low = bisected(lambda l1: gel.at(l1, one, V).meridional, grid[first, column], grid[first + 1, column])
            beyond = np.arange(len(grid))[:, None] > first + 1
            stops = beyond & ((ring.firmness <= 0.0) | (share >= LIMIT_SHARE) | ~known)
            last = np.where(stops.any(axis=0), np.argmax(stops, axis=0), 1)
            localises = stops.any(axis=0) & (ring.firmness[last, column] <= 0.0) & (share[last, column] < LIMIT_SHARE)

            def beyond_end(l1: Array) -> Array:
                own = gel.at(l1, one, V)
                limit = gel.strain(l1 * l1, own.width) / gel.strain_limit - LIMIT_SHARE
                return np.where(localises, -own.firmness, limit)

            high = bisected(beyond_end, grid[last - 1, column], grid[last, column])
        high = np.where(stops.any(axis=0), high, FARTHEST)
        exists = rises.any(axis=0)
        return Ends(np.where(exists, low, np.nan), np.where(exists, high, np.nan), localises & exists)

    # --- shooting -----------------------------------------------------------------------------------------------------

    def shoot(self, l1: Array, u: Array, V: Array, end: Array, steps: int = STEPS, grading: float = 1.0) -> list[Rings]:
        """Rings from the disc to sig = ``end``."""
        start = begin(self.gel, l1, np.ones_like(l1), u, V)
        return march(self.gel, start, V, self.disc, end, steps, grading=grading)

    def force(self, l1: Array, u: Array, V: Array) -> Array:
        """Of a state: 2 a T1 sech u/(b^2 - a^2)."""
        found: Array = 2.0 * self.disc / self.mounted * self.gel.at(l1, np.ones_like(l1), V).meridional / np.cosh(u)
        return found

    def held(
        self, x: Array, V: Array, start: tuple[Array, Array, Array], steps: int = STEPS, rounds: int = 12
    ) -> States:
        """States at heights and voltages, from near values of (l1, u, end), by Newton's method."""

        def residual(last: Rings, which: Array) -> Array:
            return np.array([last.y[HOOP] - 1.0, last.y[S] - self.span, last.y[HEIGHT] - x[which]])

        log, u, end = np.log(start[0]), start[1], start[2]
        found, miss = self._newton(np.array([log, u, end]), V, residual, (HOOP, S, HEIGHT), steps, rounds)
        return self._states(found, V, miss, steps)

    def stretched(
        self, l1: Array, V: Array, u: Array, end: Array, steps: int = STEPS, rounds: int = 8, grading: float = 1.0
    ) -> States:
        """States of a given stretch of the innermost ring, from near values of (u, end)."""

        def residual(last: Rings, which: Array) -> Array:
            return np.array([last.y[HOOP] - 1.0, last.y[S] - self.span])

        start = np.array([np.log(l1), u, end])
        found, miss = self._newton(start, V, residual, (HOOP, S), steps, rounds, grading)
        return self._states(found, V, miss, steps, grading)

    def _newton(
        self,
        start: Array,
        V: Array,
        residual: Callable[[Rings, Array], Array],
        places: tuple[int, ...],
        steps: int,
        rounds: int,
        grading: float = 1.0,
    ) -> tuple[Array, Array]:
        """The unknowns (ln l1, u, end), of which those that ``residual`` needs vary; and the largest residual."""
        p, found, miss = start.copy(), start.copy(), np.full(V.size, np.inf)
        varied = [0, 1] if len(places) == 3 else [1]
        live = np.flatnonzero(np.isfinite(p).all(axis=0))
        for _ in range(rounds):
            if not live.size:
                break
            now, count = p[:, live], live.size
            trial = np.tile(now, 1 + len(varied))
            for k, which in enumerate(varied, 1):
                trial[which, k * count : (k + 1) * count] += NUDGE
            tiled = np.tile(V[live], 1 + len(varied))
            last = self.shoot(np.exp(trial[0]), trial[1], tiled, trial[2], steps, grading)[-1]
            parts = [last.part(slice(k * count, (k + 1) * count)) for k in range(1 + len(varied))]
            with np.errstate(all="ignore"):
                value = residual(parts[0], live)
                rate = rates(self.gel, parts[0], V[live], self.disc)[0][list(places)]
                columns = [(residual(part, live) - value) / NUDGE for part in parts[1:]]
                matrix = np.stack([*columns, rate], axis=-1).transpose(1, 0, 2)
                error = np.abs(value).max(axis=0)
            bad = ~np.isfinite(matrix).all(axis=(1, 2)) | ~np.isfinite(error)
            bad |= np.abs(np.linalg.det(np.where(bad[:, None, None], np.eye(len(places)), matrix))) < 1e-300
            matrix[bad], value[:, bad], error[bad] = np.eye(len(places)), 0.0, np.inf
            better = error < miss[live]
            found[:, live[better]], miss[live[better]] = now[:, better], error[better]
            change = np.zeros_like(now)
            change[[*varied, 2]] = -np.linalg.solve(matrix, value.T[..., None])[..., 0].T
            with np.errstate(all="ignore"):
                share = np.minimum(1.0, 0.7 / np.abs(change[:2]).max(axis=0))
                share = np.minimum(share, 0.3 * now[2] / np.abs(change[2]))
            after = now + np.where(np.isfinite(share), share, 1.0) * change
            after[:, bad] = 0.5 * (after[:, bad] + found[:, live[bad]])
            p[:, live] = after
            live = live[error > ACCURATE]
        return found, miss

    def _states(self, found: Array, V: Array, miss: Array, steps: int, grading: float = 1.0) -> States:
        l1, u, end = np.exp(found[0]), found[1], found[2]
        with np.errstate(all="ignore"):
            last = self.shoot(l1, u, V, end, steps, grading)[-1]
            good = miss < GOOD
            x, charge = (np.where(good, last.y[which], np.nan) for which in (HEIGHT, CHARGE))
            force = np.where(good, self.force(l1, u, V), np.nan)
        return States(V, l1, u, end, x, force, 2.0 * charge / self.mounted, miss)

    # --- all states ---------------------------------------------------------------------------------------------------

    def scan(self, l1: Array, V: Array) -> tuple[Array, Array]:
        """Near values of (u, end) at given stretches of the innermost ring, by a scan over the slope; NaN where the
        scan misses."""
        count, width = l1.size, SLOPES.size
        u, many, squared = np.tile(SLOPES, count), np.repeat(l1, width), np.repeat(V, width)
        start = begin(self.gel, many, np.ones_like(many), u, squared)
        path = march(self.gel, start, squared, self.disc, np.full(many.shape, SCAN_END), SCAN_STEPS, land=False)
        with np.errstate(all="ignore"):
            hoop, sig = _at_rim(path, self.span)
        below, sig = hoop.reshape(count, width) - 1.0, (sig * SCAN_END / SCAN_STEPS).reshape(count, width)
        rises = (below[:, :-1] < 0.0) & (below[:, 1:] >= 0.0)
        last = width - 2 - np.argmax(rises[:, ::-1], axis=1)
        row = np.arange(count)
        with np.errstate(all="ignore"):
            share = -below[row, last] / (below[row, last + 1] - below[row, last])
            u0 = SLOPES[last] + share * (SLOPES[last + 1] - SLOPES[last])
            end = sig[row, last] + share * (sig[row, last + 1] - sig[row, last])
        hit = rises.any(axis=1)
        return np.where(hit, u0, np.nan), np.where(hit, end, np.nan)

    def table(self, V: Array, l1: Array, steps: int = STEPS) -> States:
        """States (voltages, stretches) at every V and its own row of stretches l1 beside the disc."""
        shape, squared = l1.shape, np.repeat(V, l1.shape[1])
        u, end = (values.reshape(shape) for values in self.scan(l1.ravel(), squared))
        found = None
        for _ in range(3):
            _fill(u, end, l1)
            missing = np.arange(l1.size) if found is None else np.flatnonzero(~(found.miss < GOOD))
            own = self.stretched(l1.ravel()[missing], squared[missing], u.ravel()[missing], end.ravel()[missing], steps)
            if found is None:
                found = own
            else:
                for whole, part in zip(found, own, strict=True):
                    whole[missing] = part
            good = (found.miss < GOOD).reshape(shape)
            if good.all():
                break
            u, end = (np.where(good, v.reshape(shape), np.nan) for v in (found.u, found.end))
        assert found is not None
        return States(*(values.reshape(shape) for values in found))

    def at(self, x: Array, V: Array, steps: int = 24) -> States:
        """States at heights x > 0 and squared voltages V, arrays of one length; NaN where the film has none in
        tension."""
        squared, place = np.unique(V, return_inverse=True)
        ends = self.ends(squared)
        with np.errstate(all="ignore"):
            low = np.where(self._flat_is_tight(squared) & (self.gel.A == self.gel.B), 1.0, ends.low)
            row = low[:, None] + (ends.high - low)[:, None] * ROW
            known = self.table(squared, np.where(np.isfinite(row), row, 1.0))
            known = known._replace(x=np.where(np.isfinite(row), known.x, np.nan))
        start = np.full((3, x.size), np.nan)
        for k in range(x.size):
            found = np.flatnonzero(np.isfinite(known.x[place[k]]))
            if found.size > 1:
                own = known.where((place[k], found[np.argsort(known.x[place[k], found])]))
                if own.x[0] * NEARBY <= x[k] <= own.x[-1]:
                    start[:, k] = [np.interp(np.log(x[k]), np.log(own.x), v) for v in (own.l1, own.u, own.end)]
        return self.held(x, V, (start[0], start[1], start[2]), steps, 25)

    def _flat_is_tight(self, V: Array) -> Array:
        """Whether the flat film of an equibiaxial pre-stretch is in tension."""
        found: Array = self.gel.crumpling(self.gel.A) > V * self.gel.G
        return found

    def pull_in(self, V: Array, steps: int = 60) -> States:
        """The states in which a film held higher would localise beside the disc, where it does; NaN elsewhere."""
        ends = self.ends(V)
        l1 = np.where(ends.localises, ends.high * (1.0 - JUST_BEFORE), 1.0)
        u, end = self.scan(l1, V)
        found = self.stretched(l1, V, np.where(ends.localises, u, np.nan), end, steps, 12, NEAR_LOCALISATION)
        return States(*(np.where(ends.localises, values, np.nan) for values in found))

    # --- a state in full ----------------------------------------------------------------------------------------------

    def profile(self, V: float, l1: float, u: float, end: float, steps: int = 48) -> Profile:
        """Along the film, of one state."""
        squared = np.array([V])
        path = self.shoot(np.array([l1]), np.array([u]), squared, np.array([end]), steps)
        y = np.array([at.y[:, 0] for at in path]).T
        slack = np.array([at.slack[0] for at in path])
        stretch, hoop, R = np.exp(y[LOG]), y[HOOP], self.disc * np.exp(y[S])
        many = np.broadcast_to(squared, stretch.shape)
        ring = self.gel.at(stretch, hoop, many)
        m, n = stretch * stretch, np.where(slack, ring.width, hoop * hoop)
        return Profile(R, R * hoop, y[HEIGHT], m, n, np.sqrt(np.maximum(V, 0.0) * m * n), ring.firmness, slack)


def _fill(u: Array, end: Array, l1: Array) -> None:
    """Fills gaps of rows from their neighbours."""
    for k in range(len(u)):
        known = np.isfinite(u[k])
        if known.any():
            u[k], end[k] = (np.interp(l1[k], l1[k, known], values[k, known]) for values in (u, end))


def _at_rim(path: list[Rings], span: float) -> tuple[Array, Array]:
    """l2 where s reaches the rim, linearly between steps, and the number of steps to there; NaN where it does not."""
    s, hoop = (np.array([at.y[which] for at in path]) for which in (S, HOOP))
    after = np.argmax(s >= span, axis=0)
    reached = (s >= span).any(axis=0) & (after > 0)
    after, column = np.maximum(after, 1), np.arange(s.shape[1])
    share = (span - s[after - 1, column]) / (s[after, column] - s[after - 1, column])
    value = hoop[after - 1, column] + share * (hoop[after, column] - hoop[after - 1, column])
    return np.where(reached, value, np.nan), after - 1 + share
