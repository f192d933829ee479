"""The highest peak of each sweep of a frequency response, narrowed down between the frequencies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.motion.attractor.search import integration
from gelcone.motion.stepping import Falls, Trail, carried
from gelcone.motion.swing import swing
from gelcone.physics.members import Members
from gelcone.progress import Progress, advance
from gelcone.quantity import Array

RESOLVED = 1e-5
"""Relative difference within which heights are equal: ten times the error of settled motions."""
NARROWINGS = 3
NARROWED_AT = 7
"""Frequencies inside a peak's bracket that each narrowing tries; the bracket shrinks to a quarter."""


@dataclass(frozen=True)
class Peaks:
    """Highest peak of each sweep, arrays (members,)."""

    frequency: Array
    low: Array
    high: Array
    amplitude: Array
    error: Array


def highest_peaks(model: Members, trail: Trail, falls: Falls, progress: Progress, search: dict[str, Any]) -> Peaks:
    """Narrows down the highest point of each sweep between its neighbours, starting from the motion there.

    A peak may lie at a jump. A motion that stays on one branch does not show it, so that the bracket includes the jump.
    NaN for a sweep that finds no motion at any frequency.
    """
    met, amplitudes, periods, finals = trail.sorted()
    members, amplitude = np.arange(model.size), np.where(np.isnan(amplitudes), -1.0, amplitudes)
    best = amplitude.argmax(axis=1)
    at, height = met[members, best], amplitude[members, best]
    best_members = model.replace(drive_frequency=at)
    peak = swing(best_members, finals[members, best], periods[members, best], only_extent=True, **integration(search))
    low, high = _bracket(met, _certain(amplitude, periods), at, height)
    ends = np.stack([falls.start, falls.end])
    touching = (ends.max(axis=0) >= low[:, None]) & (ends.min(axis=0) <= high[:, None])
    low_fall = np.where(touching, ends.min(axis=0), np.inf).min(axis=1)
    high_fall = np.where(touching, ends.max(axis=0), -np.inf).max(axis=1)
    error = np.full(model.size, np.inf)
    shares = np.arange(1, NARROWED_AT + 1) / (NARROWED_AT + 1)
    for _ in range(NARROWINGS):
        tried = low[:, None] + (high - low)[:, None] * shares
        rows = np.repeat(members, NARROWED_AT)
        ensemble = model.take(rows).replace(drive_frequency=tried.ravel())
        now = carried(ensemble, peak.take(rows), height[rows], search)
        # What was highest before is compared too, or a narrow peak could be lost between the new frequencies.
        heights = np.column_stack([np.nan_to_num(now.amplitude.reshape(tried.shape), nan=-1.0), height])
        places, period = np.column_stack([tried, at]), np.column_stack([now.period.reshape(tried.shape), peak.period])
        first, _, _, fourth = np.argsort(-heights, axis=1, kind="stable")[:, :4].T
        higher = np.flatnonzero(first < NARROWED_AT)
        peak.put(higher, now.take(higher * NARROWED_AT + first[higher]))
        at, height = places[members, first], heights[members, first]
        # Between equal frequencies a parabola rises by at most an eighth of its second difference. The highest four are
        # the peak, what was highest before, often at the same frequency, and the neighbours on both sides.
        error = 0.5 * (height - heights[members, fourth]) + RESOLVED * np.abs(height)
        lowest = np.full((model.size, 1), -1.0)
        edges, known = np.column_stack([low, places, high]), np.hstack([lowest, _certain(heights, period), lowest])
        low, high = _bracket(edges, known, at, height)
        advance(progress, 1.0 / NARROWINGS)
    peak_columns = at, np.minimum(low, low_fall), np.maximum(high, high_fall), height, error
    return Peaks(*(np.where(height < 0.0, np.nan, values) for values in peak_columns))


def _certain(heights: Array, period: npt.NDArray[np.int64]) -> Array:
    """The heights, NaN where the motion is not periodic and may not have reached its extremes yet."""
    return np.where((period > 0) | (heights < 0.0), heights, np.nan)


def _bracket(places: Array, heights: Array, at: Array, height: Array) -> tuple[Array, Array]:
    """The nearest of the places (members, steps) on either side of the peak that are lower, or the ends.

    A height that differs from that of the peak by less than `RESOLVED` is not lower.
    """
    lower = heights < (height * (1.0 - RESOLVED))[:, None]
    first, last = np.nanmin(places, axis=1), np.nanmax(places, axis=1)
    below = np.where(lower & (places < at[:, None]), places, -np.inf).max(axis=1)
    above = np.where(lower & (places > at[:, None]), places, np.inf).min(axis=1)
    return np.maximum(below, first), np.minimum(above, last)
