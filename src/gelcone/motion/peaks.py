"""Largest values along a motion, such as that of the field in its film, also between samples and at corners.

Around each sample that may be next to the largest value the motion is sampled again, more closely in each round.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from gelcone.motion.corners import Weighted
from gelcone.motion.flow import integrate
from gelcone.physics.members import Members
from gelcone.quantity import Array

PARTS = 32
"""Samples between the neighbours of a sample that may be next to the largest value."""
ROUNDS = 4
"""Rounds, each with 1/16 of the spacing: the error is rounding at a smooth peak, 1e-6 of the slope at a corner."""

Value = Callable[[Members, Array, Array], Array]
"""Members, times (members, samples) and states (members, samples, N) -> a number of each (members, samples), or
several (numbers, members, samples)."""


def largest(members: Members, path: Weighted, value: Value, known: Array | None = None, **flow: Any) -> Array:
    """The largest ``value``, (members,) or (numbers, members), along a ``path``, also between its samples; NaN for a
    motion that has ended.

    A peak is assumed to rise above its highest sample by less than that sample above the lower one of its neighbours.
    ``known`` are the values at the start of the path and at its samples, if they are known; ``flow`` are options of
    `integrate`.
    """
    times = np.concatenate([path.start[:, None], path.times], axis=1)
    states = np.concatenate([path.begin[:, None], path.states], axis=1)
    behind = np.pad(times[:, 1:], ((0, 0), (0, 1)), constant_values=np.inf)
    lasts = np.minimum(behind, path.end[:, None])
    inside = np.pad(path.weights > 0.0, ((0, 0), (1, 0)), constant_values=True)
    with np.errstate(all="ignore"):  # of a motion that has ended
        known = value(members, times, states) if known is None else known
        values = np.where(inside, known, -np.inf)
        shape, values = values.shape[:-1], values.reshape(-1, *times.shape)
        highest, rises = values.max(axis=-1), np.diff(values, axis=-1)
        before = np.pad(rises, ((0, 0), (0, 0), (1, 0)))
        after = np.pad(np.where(inside[:, 1:], -rises, 0.0), ((0, 0), (0, 0), (0, 1)))
        above = np.where((before >= 0.0) & (after >= 0.0), np.maximum(before, after), 0.0)
        may_peak = inside & (above > 0.0) & (values + above >= highest[..., None])
    firsts = np.pad(times[:, :-1], ((0, 0), (1, 0)), mode="edge")
    which, rows, at = np.nonzero(may_peak & (firsts < lasts))
    if rows.size:

        def chosen_values(some: Members, times: Array, states: Array) -> Array:
            return value(some, times, states).reshape(-1, *times.shape)[which, np.arange(rows.size)]

        some, states = members.take(rows), states[rows, np.maximum(at - 1, 0)]
        closer = _closer(some, states, firsts[rows, at], lasts[rows, at], chosen_values, **flow)
        np.fmax.at(highest, (which, rows), closer)
    return highest.reshape(shape)


def _closer(some: Members, states: Array, begin: Array, end: Array, value: Value, **flow: Any) -> Array:
    """The largest ``value`` (peaks,) of motions from ``states`` (peaks, N) at ``begin`` until ``end``."""
    highest, every = np.full(begin.size, -np.inf), np.arange(begin.size)
    for _ in range(ROUNDS):
        times = begin[:, None] + (end - begin)[:, None] * (np.arange(1, PARTS + 1) / PARTS)
        run = integrate(some, states, times, start=begin, **flow).states
        times = np.concatenate([begin[:, None], times], axis=1)
        run = np.concatenate([states[:, None], run], axis=1)
        with np.errstate(all="ignore"):
            values = value(some, times, run)
        at = np.where(np.isnan(values), -np.inf, values).argmax(axis=1)
        highest = np.fmax(highest, values[every, at])
        low, high = np.maximum(at - 1, 0), np.minimum(at + 1, PARTS)
        states, begin, end = run[every, low], times[every, low], times[every, high]
    return highest
