"""Where motions go: followed for long, are they settled at the end, on which period, and since when?

A motion has settled when its last points return, period after period. How near it then was to the cycle at earlier
times tells when it arrived there, and from neighbours that were followed beside it when they came apart.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.motion.cycle import Cycles, find_cycles
from gelcone.motion.flow import integrate
from gelcone.motion.settle import alike
from gelcone.physics.members import Members
from gelcone.progress import Progress, weighted
from gelcone.quantity import Array

SEPARATED = 1e-3
"""Starts have come apart when they differ by this share of the motion's size."""
LONGEST_PERIOD = 64
"""Motions with up to so many forcing periods as their own period are recognised."""
HISTORY, WINDOW = 64, 144
"""Forcing periods of a course that are looked at: so many spread over it, and so many in a row at its end."""
PHASES = (0.5, 1.0)
"""Where in a forcing period: a slow drive can push all motions to the same point once a period."""
LAGS = 24
"""Points, at least, that have to return for a motion to have settled."""
RETURN = 1e-4
"""Share of the motion's size within which they do; a thousand times what the loosest run leaves."""
AWAY = 1e-2
"""A motion was last away from the cycle that it ends on when it was further from it than this share of its size."""
SMALLEST_SIZE = 1e-3
BLOCK_SAMPLES = 2**19
"""Most samples of a block of members, which bounds the memory."""


@dataclass(frozen=True)
class Course:
    """Where some motions went; arrays (members, ...).

    ``final`` states (members, N); the ``outcome``; the ``period`` on which they have settled, in forcing periods (0:
    none); when they were last ``away`` from it, since the beginning; ``lowest`` and ``highest`` (members, 2 N) of the
    states at the two `PHASES` over that period; and ``gap``, the least distance of a return over the size.
    """

    final: Array
    outcome: npt.NDArray[np.int8]
    period: npt.NDArray[np.int64]
    away: Array
    lowest: Array
    highest: Array
    gap: Array

    @classmethod
    def blank(cls, count: int, states: int) -> Course:
        """Nothing known yet."""
        return cls(
            np.full((count, states), np.nan),
            np.zeros(count, dtype=np.int8),
            np.zeros(count, dtype=np.int64),
            np.full(count, np.inf),
            np.full((count, 2 * states), np.nan),
            np.full((count, 2 * states), np.nan),
            np.full(count, np.nan),
        )


def course(
    members: Members,
    states: Array,
    repeats: npt.NDArray[np.int64],
    *,
    abreast: int = 1,
    progress: Progress = None,
    **flow_options: Any,
) -> tuple[Course, Array]:
    """Follows members from ``states`` (members, N) at phase 0 over ``repeats`` (members,) forcing periods each.

    Also the times (members,) at which each was first apart from the first of the ``abreast`` neighbours that it is one
    of, infinite where it was not.
    """
    found, apart = Course.blank(*states.shape), np.full(members.size, np.inf)
    for rows, numbers in _groups(repeats, abreast):
        part = members.take(rows)
        ticks = (numbers[:, :, None] + np.asarray(PHASES) - 1.0).reshape(len(rows), -1)
        share = weighted(progress, rows.size / members.size)
        run = integrate(part, states[rows], ticks * part.forcing_period[:, None], progress=share, **flow_options)
        points = run.states.reshape(*numbers.shape, -1)
        times = numbers * part.forcing_period[:, None]
        found.final[rows], found.outcome[rows] = run.states[:, -1], run.outcome
        dense = points[:, -min(WINDOW, points.shape[1]) :]
        found.period[rows], found.gap[rows] = period_of(dense)
        _describe(found, rows, points, times)
        apart[rows] = _separation(points, times, abreast)
    return found, apart


def _groups(
    repeats: npt.NDArray[np.int64], abreast: int
) -> Iterator[tuple[npt.NDArray[np.intp], npt.NDArray[np.int64]]]:
    """Members that are sampled equally often, in blocks of bounded memory, and the periods (members, samples) at whose
    ends they are."""
    window = np.minimum(repeats, WINDOW)
    before = np.minimum(repeats - window, HISTORY)
    for (last, first), group in alike(window, before):
        size = max(1, BLOCK_SAMPLES // (last + first) // abreast) * abreast
        for begin in range(0, group.size, size):
            rows = group[begin : begin + size]
            spread = (repeats[rows, None] - last) * np.arange(1, first + 1) // max(first, 1)
            ends = repeats[rows, None] - last + np.arange(1, last + 1)
            yield rows, np.concatenate([spread, ends], axis=1)


def period_of(points: Array) -> tuple[npt.NDArray[np.int64], Array]:
    """Smallest number of periods (members,) after which the last points return, 0 if none; and the least distance.

    ``points`` (members, periods, coordinates) in a row. At least `LAGS` points, and all of a period, have to return.
    """
    count, length = points.shape[:2]
    with np.errstate(invalid="ignore"):
        scale = np.maximum(np.abs(points).max(axis=(1, 2)), SMALLEST_SIZE)
        longest = min(LONGEST_PERIOD, length // 2)
        last = np.abs(points[:, -1:] - points[:, -1 - longest : -1][:, ::-1]).max(axis=2) / scale[:, None]
    period, gap = np.zeros(count, dtype=np.int64), np.full(count, np.inf)
    candidates = last < RETURN
    for lag in np.flatnonzero(candidates.any(axis=0)) + 1:
        rows = np.flatnonzero(candidates[:, lag - 1] & (period == 0))
        if not rows.size:
            continue
        compared = min(max(LAGS, lag), length - lag)
        later = points[rows, -compared:]
        earlier = points[rows, -compared - lag : -lag]
        distance = np.abs(later - earlier).max(axis=(1, 2)) / scale[rows]
        gap[rows] = np.minimum(gap[rows], distance)
        period[rows[distance < RETURN]] = lag
    nearest = last.min(axis=1, initial=np.inf)
    return period, np.where(np.isfinite(gap), gap, nearest)


def _describe(found: Course, rows: npt.NDArray[np.intp], points: Array, times: Array) -> None:
    """When the settled ones of the ``rows`` were last away from their cycles, and how far these reach."""
    period = found.period[rows]
    for repeats in np.unique(period[period > 0]):
        same = np.flatnonzero(period == repeats)
        path = points[same]
        cycle = path[:, -repeats:]
        scale = np.maximum(np.abs(cycle).max(axis=(1, 2)), SMALLEST_SIZE)
        distance = np.full(path.shape[:2], np.inf)
        for k in range(repeats):
            distance = np.minimum(distance, np.abs(path - cycle[:, k : k + 1]).max(axis=2))
        away = np.where(distance > AWAY * scale[:, None], times[same], 0.0)
        found.away[rows[same]] = away.max(axis=1)
        found.lowest[rows[same]], found.highest[rows[same]] = cycle.min(axis=1), cycle.max(axis=1)


def _separation(points: Array, times: Array, abreast: int) -> Array:
    """When each of the members was first apart from the first of its neighbours, infinite where it was not."""
    if abreast == 1:
        return np.full(len(points), np.inf)
    together = points.reshape(-1, abreast, *points.shape[1:])
    with np.errstate(invalid="ignore"):
        scale = np.maximum(np.abs(together[:, :1]).max(axis=(2, 3)), SMALLEST_SIZE)
        apart = np.abs(together - together[:, :1]).max(axis=3) > SEPARATED * scale[..., None]
    each = times.reshape(-1, abreast, times.shape[1])
    return np.asarray(np.where(apart, each, np.inf).min(axis=2).ravel())


def cycles_reached(members: Members, states: Array, **flow_options: Any) -> Cycles:
    """The cycles near motions that are at ``states``, at phase 0, and return from there."""
    found, _ = course(members, states, np.full(members.size, WINDOW), **flow_options)
    return find_cycles(members, found.final, found.period, **flow_options)
