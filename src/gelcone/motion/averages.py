"""Averages of a motion that does not repeat, with their standard errors.

Another run of such a motion, from a start as near as you like, has other averages. Their errors are those of means over
blocks of forcing periods (`gelcone.motion.exponents.block_statistics`).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gelcone.motion.attractor.cycle import sampled
from gelcone.motion.electrical import MEANINGS, mean_deliveries
from gelcone.motion.exponents import LAST_BLOCKS, block_statistics
from gelcone.motion.settle import STILL, Clock
from gelcone.physics.members import Members
from gelcone.quantity import Array

BATCHES, BATCH = 64, 8
"""Number of blocks of an average, and forcing periods in each: a whole number of drive periods."""
AVERAGES = ("mean", *(name for name in MEANINGS if name not in {"current", "field"}))
"""Names of the averages of a settled motion: of its displacement, and of what its source delivers."""
WINDOWED = 35.0 / 18.0
"""Mean square over squared mean of the window sin^4, times which the variance of an average grows by the window."""
MOST_LAG = 64
RETURN = 1e-3
"""Distance, over the extent of the motion, within which points of a motion that repeats return."""


def averages(members: Members, states: Array, samples: int, **flow: Any) -> tuple[Array, Array]:
    """`AVERAGES` of motions from ``states`` (members, N) at phase 0 over `BATCHES` blocks, ``samples`` in a forcing
    period, and their standard errors, (members, averages) each; NaN for motions that end or whose average has no
    bound."""
    blocks, start = np.full((BATCHES, len(states), len(AVERAGES)), np.nan), states
    for block in blocks:
        run = sampled(members, start, BATCH, samples, **flow)
        spacing = (run.times.shape[1] - 1) // run.path.shape[1]
        deliveries, _ = mean_deliveries(members, run.times[:, spacing::spacing], run.path, start, **flow)
        block[:] = np.stack([run.path[..., 0].mean(axis=1), *(deliveries[name] for name in AVERAGES[1:])], axis=1)
        start = run.path[:, -1]
    rms = AVERAGES.index("apparent_power")  # the rms current is averaged as its square
    blocks[..., rms] **= 2
    with np.errstate(invalid="ignore", divide="ignore"):
        means, errors = batch_means(blocks)
        means[:, rms] = np.sqrt(means[:, rms])
        errors[:, rms] /= 2.0 * means[:, rms]
    finite = np.isfinite(means)
    return np.where(finite, means, np.nan), np.where(finite, errors, np.nan)


def batch_means(blocks: Array) -> tuple[Array, Array]:
    """Means of (blocks, ...) and their standard errors: the largest of those by blocks joined to longer ones, of which
    there are at least `LAST_BLOCKS`, since a slow part of a motion hides in short ones behind a fast one."""
    rows = np.moveaxis(blocks.reshape(len(blocks), -1), 0, 1)[..., None]
    one = np.ones(len(rows))
    clock, length = Clock(1, 1, one, one), 2
    means, errors = block_statistics(rows, clock, 1)
    while len(blocks) // length >= LAST_BLOCKS:
        errors = np.fmax(errors, block_statistics(rows, clock, length)[1])
        length *= 2
    return means.reshape(blocks.shape[1:]), errors.reshape(blocks.shape[1:])


def of_record(record: Array, periods: int) -> tuple[float, float]:
    """The standard errors of mean and rms of an even record over whole drive ``periods`` under the window sin^4; 0 of
    one that repeats."""
    rows = record.reshape(periods, -1)
    if repeats(rows[:, :: max(1, rows.shape[1] // 4)]):
        return 0.0, 0.0
    square = (record - record.mean()) ** 2
    means, errors = batch_means(np.stack([rows.mean(axis=1), square.reshape(periods, -1).mean(axis=1)], axis=1))
    mean, rms = np.sqrt(WINDOWED) * errors
    return float(mean), float(rms / (2.0 * np.sqrt(means[1])))


def repeats(points: Array) -> bool:
    """Whether the later half of points (steps, features) of a motion returns, after up to `MOST_LAG` steps, to within
    a share of its extent, or is at rest.

    This is asked of a record and not of its attractor, which `gelcone.regime` names: a record may end before its
    motion has settled, and chaos before the record does.
    """
    late = points[len(points) // 2 :]
    extent = float(np.ptp(points, axis=0).max(initial=0.0))
    if extent < STILL or len(late) < 2:
        return True
    size = max(extent, float(np.abs(points).max()) * RETURN)
    lags = range(1, min(MOST_LAG, len(late) - 1) + 1)
    return any(bool((np.abs(late[lag:] - late[:-lag]) <= RETURN * size).all()) for lag in lags)
