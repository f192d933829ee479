"""All states of a film: columns of rising voltage at held heights, and the limits at which they end.

A column starts from the straight cone without voltage and rises until the film falls slack, or until the ring at the
disc localises, or with a strong hoop the one at the rim. There the tangent stiffness T11 of that ring, whose hoop is
held, has fallen to zero, smoothly or by a jump where its hoop falls slack: an equation of one ring, `longest`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gelcone.bracket import sign_changes
from gelcone.membrane.elements import Chains, Elements, Measures
from gelcone.membrane.gel import Array, Gel

LONGEST, SHORTEST, GRID = 30.0, 0.5, 500
"""Longest and shortest meridional length over the mounted one at which the innermost ring is searched to localise, and
the number of trials between them."""
LIMIT_SHARE = 0.9
"""Share of the stretch limit, at the disc, up to which states are computed."""
WEAKEST = 1e-6
"""Share of the force without voltage below which a film is slack."""
LARGEST_CHANGE = 0.12
"""Largest relative change of an element's length between states of a column; a film that localises changes more."""
LOWEST_ROUNDS, LOWEST_GRID = 5, 3000
STEPS, MOST_STEPS = 14, 150
"""Equal steps that a column takes to the V it is expected to reach, and the most that it takes altogether."""
STEP_ROUNDS = 14
"""Newton iterations for a state of a column, which begin near it."""
GOLDEN = 0.6180339887498949


def longest(gel: Gel, V: Array, grid: int = GRID) -> Array:
    """The meridional length of the innermost ring at which it localises, (voltages,); NaN where it does not localise
    below the stretch limit."""
    lengths = np.geomspace(SHORTEST, LONGEST, grid)[:, None] * np.ones(V.size)
    unit_hoop = np.ones_like(lengths)
    with np.errstate(all="ignore"):
        ring = gel.at(lengths, unit_hoop, np.broadcast_to(V, lengths.shape))
        share = gel.strain(lengths * lengths, ring.width) / gel.strain_limit
        lost = (ring.meridional > 0.0) & (share < 1.0) & (ring.tangent_stiffness <= 0.0)
        first, ring_lengths = np.argmax(lost, axis=0), np.full(V.size, np.nan)
        crossed = np.flatnonzero(lost.any(axis=0) & (first > 0))
        ends = lengths[first[crossed] - 1, 0], lengths[first[crossed], 0]
        ring_lengths[crossed] = sign_changes(
            lambda l1: gel.at(l1, np.ones_like(l1), V[crossed]).tangent_stiffness, *ends
        )
    return ring_lengths


def lowest_localisation(gel: Gel, highest: float) -> float:
    """V*, the lowest V at which any ring whose hoop is held localises; infinity if that is above ``highest``."""
    low, high = 0.0, np.inf
    trial = np.geomspace(1e-4 * highest, highest, 60)
    for _ in range(LOWEST_ROUNDS):
        localises = np.isfinite(longest(gel, trial, LOWEST_GRID))
        if not localises.any():
            return high
        first = int(np.argmax(localises))
        low, high = (float(trial[first - 1]) if first else low), float(trial[first])
        trial = np.linspace(low, high, 13)[1:]
    return high


LONG = 0.99
"""Least share of the length of localisation that the ring at an edge has where a column ends by localisation."""
FINEST = 1e-3
"""Share of the V up to which a column may go: a column that ends this close to it did not end by itself."""
NEXT = 0.01
"""Share of V by which the end of a column may lie below the lowest voltage at which a ring localises."""


@dataclass(frozen=True)
class Columns:
    """States in columns.

    Of each state the index of its ``column``, its V and `Measures`. Of each column its height, whether it ended
    ``slack``, the V of its ``end``, the ``top``, where it stops in any case, and its ``last`` state.
    """

    column: Array
    V: Array
    measures: Measures
    heights: Array
    slack: Array
    end: Array
    top: Array
    last: Chains

    @cached_property
    def first(self) -> Array:
        """Force without voltage of each column."""
        forces = np.full(self.heights.size, np.nan)
        start = self.V == 0.0
        forces[self.column[start]] = self.measures.force[start]
        return forces

    def falls(self, values: Array) -> Array:
        """The V of each column at which ``values`` of its states fall through zero; NaN where they do not."""
        crossings = np.full(self.heights.size, np.nan)
        for k in range(self.heights.size):
            V, column_values = self.along(k, values)
            after = np.flatnonzero((column_values[:-1] > 0.0) & (column_values[1:] <= 0.0))
            if after.size:
                j = after[0]
                crossings[k] = V[j] + (V[j + 1] - V[j]) * column_values[j] / (column_values[j] - column_values[j + 1])
        return crossings

    def along(self, k: int, values: Array) -> tuple[Array, Array]:
        """V and ``values`` of the states of a column, in the order of V."""
        indices = np.flatnonzero(self.column == k)
        indices = indices[np.argsort(self.V[indices])]
        return self.V[indices], values[indices]


def localised(gel: Gel, found: Columns) -> Array:
    """Mask of the columns that end because the ring at the disc or the one at the rim localises."""
    V, edge = np.zeros((2, found.heights.size))
    for k in map(int, np.flatnonzero(np.isfinite(found.first))):
        voltages, edges = found.along(k, found.measures.edge)
        V[k], edge[k] = voltages[-1], edges[-1]
    with np.errstate(invalid="ignore"):
        near: Array = np.sqrt(edge) > LONG * longest(gel, V * (1.0 + NEXT))
    return (V > 0.0) & (found.end < found.top * (1.0 - FINEST)) & near


def columns(
    film: Elements, heights: Array, first: Array, top: Array, steps: int = STEPS, finest: float = 0.0003
) -> Columns:
    """Columns at ``heights`` > 0, up to V = ``top``; ``first`` is the V that a column is expected to reach.

    A column rises by steps of ``first`` / ``steps`` after a shorter first one. A step is halved where no state is found
    nearby; the column ends where steps fall below ``finest`` of ``first``. Columns without a state at V = 0 are empty.
    """
    count = heights.size
    now = film.unloaded(heights)
    measured = film.measures(now)
    force, live = measured.force, np.flatnonzero(now.found & (measured.force > 0.0))
    column, V, kept = [live], [np.zeros(live.size)], [Measures(*(v[live] for v in measured))]
    r, z, tension, reached = now.r.copy(), now.z.copy(), now.tension.copy(), np.zeros(count)
    started = np.isin(np.arange(count), live)
    rate_r, rate_z = np.zeros_like(r), np.zeros_like(z)
    # the first steps of the columns differ, so that their states are scattered over the voltage
    regular = np.minimum(first / steps, top)
    step, least = regular * (1.0 - GOLDEN * np.arange(count) % 1.0 * 0.8), finest * first
    failed, slack = np.full(count, np.inf), np.zeros(count, bool)
    live = live[top[live] > 0.0]
    for _ in range(MOST_STEPS):
        if not live.size:
            break
        h = step[live]
        r_next, z_next = (place[live] + h[:, None] * rate[live] for place, rate in ((r, rate_r), (z, rate_z)))
        start = Chains(reached[live] + h, r_next, z_next, tension[live], np.zeros(live.size, bool))
        after = film.found(start, STEP_ROUNDS)
        measured = film.measures(after)
        with np.errstate(all="ignore"):
            change = np.max(np.abs(_lengths(after.r, after.z) / _lengths(r[live], z[live]) - 1.0), axis=1)
            near = after.found & (film.least_tangent_stiffness(after) > 0.0) & (change < LARGEST_CHANGE)
            weak = near & (measured.force < WEAKEST * force[live])
        good = near & ~weak
        on, off = live[good], live[~good]
        rate_r[on] = (after.r[good] - r[on]) / h[good, None]
        rate_z[on] = (after.z[good] - z[on]) / h[good, None]
        r[on], z[on], tension[on], reached[on] = (values[good] for values in (after.r, after.z, after.tension, after.V))
        column.append(on)
        V.append(after.V[good])
        kept.append(Measures(*(values[good] for values in measured)))
        slack[off] = weak[~good]
        # extrapolation from a folded state may lead to one under compression: try again from the last state itself
        folded = rate_z[off].any(axis=1) & film.gel.has_rims
        failed[off[~folded]] = after.V[~good][~folded]
        rate_r[off[folded]], rate_z[off[folded]] = 0.0, 0.0
        beyond = reached + step >= failed * (1.0 - 1e-9)
        step = np.where(beyond, 0.5 * (failed - reached), step)
        step[on] = np.where(np.isfinite(failed[on]), step[on], regular[on])
        step = np.minimum(step, top - reached)
        live = live[step[live] >= 0.999 * least[live]]
    parts = zip(*kept, strict=True)
    all_columns = Columns(
        np.concatenate(column), np.concatenate(V), Measures(*(np.concatenate(part) for part in parts)), heights, slack,
        np.minimum(0.5 * (reached + np.where(np.isfinite(failed), failed, reached)), top),
        top,
        Chains(reached, r, z, tension, started),
    )  # fmt: skip
    return all_columns


def _lengths(r: Array, z: Array) -> Array:
    """Lengths of the elements, (states, elements)."""
    return np.hypot(np.diff(r, axis=1), np.diff(z, axis=1))
