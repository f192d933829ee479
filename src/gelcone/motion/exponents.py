"""Averages of the growth of deviations: Lyapunov exponents with their standard errors.

The error is that of the mean over at least 100 blocks, each a whole number of forcing periods. Correlations between
blocks vanish as blocks get longer, and the averaging continues until longer blocks give no larger errors (Flyvbjerg and
Petersen, J. Chem. Phys. 91 (1989) 461).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.motion.columns import Columns, column
from gelcone.motion.settle import STRETCH, Clock, clocks
from gelcone.motion.tangents import CERTAIN, FLOOR, TangentRun, advance
from gelcone.physics.members import Members
from gelcone.quantity import Array

FEWEST_BLOCKS = 100
"""Fewest blocks that give an error; fewer give a sign at best."""
GROWING = 1.15
"""Ratio of the errors of the longest blocks to those of blocks half as long above which errors still grow: twice the
scatter of errors from 100 blocks."""
LAST_BLOCKS = 16
"""Least number of blocks for an error if errors still grow at the end of the budget."""
BUDGET, PRECISE_BUDGET = 20_000.0, 1e7
"""Default longest averaging time, without and with a given precision."""
SHEAR = 5.0
"""Multiple of log(t)/t above which an exponent without damping is positive: deviations of a regular motion grow in
proportion to time, so that its exponent seems to be log(t)/t."""
STEADY = 0.05
"""Relative difference below which the exponents of both halves of the averaging time agree, whatever their errors."""
RUNNING_POINTS = 200


@dataclass(frozen=True)
class Exponents(Columns):
    """The exponents of all members after averaging: ``values`` and ``standard_error`` (members, N); the averaging
    ``time``; ``divergence`` (members,), the mean trace of the Jacobian over that time; ``sign`` of the largest, 0 where
    the budget did not suffice; ``outcome``; ``running`` (members, points, 2), averaged time and largest exponent so
    far; ``states`` (members, N) at the end."""

    values: Array = column(np.nan, "N")
    standard_error: Array = column(np.nan, "N")
    time: Array = column(0.0)
    divergence: Array = column()
    sign: npt.NDArray[np.int8] = column(0, kind=np.int8)
    outcome: npt.NDArray[np.int8] = column(0, kind=np.int8)
    running: Array = column(np.nan, RUNNING_POINTS, 2)
    states: Array = column(np.nan, "N")


def average(
    members: Members,
    states: Array,
    *,
    budget: float | None = None,
    precision: float | None = None,
    stretch: float = STRETCH,
    **flow_options: Any,
) -> Exponents:
    """Averages from ``states`` (members, N) at phase 0 until the sign of the largest exponent is certain, and its
    standard error at most ``precision`` where that is given.

    Members with NaN states are left out. ``budget`` is the longest averaging time, at least `FEWEST_BLOCKS` blocks;
    ``stretch`` as in `clocks`.
    """
    if budget is None:
        budget = BUDGET if precision is None else PRECISE_BUDGET
    goal = np.inf if precision is None else precision
    result = Exponents.blank(len(states), states=states.shape[1])
    runs = np.asarray(np.isfinite(states).all(axis=1))
    for group, clock in clocks(members, stretch):
        rows = group[runs[group]]
        if rows.size:
            row_inputs = members.take(rows), states[rows], clock.take(runs[group])
            for ended, exponents in _averages(*row_inputs, budget, goal, flow_options):
                result.put(rows[ended], exponents)
    return result


def _averages(
    members: Members, states: Array, clock: Clock, budget: float, precision: float, flow_options: dict[str, Any]
) -> Iterator[tuple[npt.NDArray[np.intp], Exponents]]:
    """Yields the indices and exponents of members whose average has ended: after the time ``budget`` at the latest, or
    when the error is down to ``precision``."""
    rows = np.arange(len(states))
    run, growth = TangentRun.at(states), np.empty((len(states), 0, states.shape[1] + 1))
    # During the first block the frame aligns with the directions of growth; the average begins after it.
    advance(members, run, clock, clock.block, **flow_options)
    while True:
        blocks = FEWEST_BLOCKS if growth.shape[1] == 0 else growth.shape[1] // clock.block
        new_growth, trace = advance(members, run, clock, blocks * clock.block, **flow_options)
        # the trace is averaged as the exponents are, over the same blocks
        growth = np.concatenate([growth, np.concatenate([new_growth, trace[:, :, None]], axis=2)], axis=1)
        means, errors, steady, grown = steady_statistics(growth, clock)
        errors[:, :-1] = np.maximum(errors[:, :-1], run.error / clock.spacing[:, None])
        time = growth.shape[1] * clock.spacing
        floor = np.where(members.damped, FLOOR, shear_level(time))
        certain = np.abs(means[:, 0]) > np.maximum(CERTAIN * errors[:, 0], floor)
        enough = certain & steady & grown & (errors[:, 0] <= precision)
        finished = enough | (run.outcome != Outcome.OK) | (2.0 * time > budget)
        sign, running = np.where(certain, np.sign(means[:, 0]), 0), running_estimate(growth, clock)
        exponents = Exponents(means[:, :-1], errors[:, :-1], time, means[:, -1], sign, run.outcome, running, run.states)
        yield rows[finished], exponents.take(finished)
        if finished.all():
            return
        unfinished = np.flatnonzero(~finished)
        members, rows, growth, clock = (
            members.take(unfinished),
            rows[unfinished],
            growth[unfinished],
            clock.take(unfinished),
        )
        run = run.take(unfinished)


def shear_level(time: Array) -> Array:
    """The exponent that regular motion without damping may seem to have after an averaging time."""
    return SHEAR * np.log(np.maximum(time, math.e)) / np.maximum(time, math.e)


def steady_statistics(growth: Array, clock: Clock) -> tuple[Array, Array, npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Exponents and standard errors, and the masks of members whose largest exponent agrees in both halves of the time,
    and whose errors do not grow with longer blocks.

    Where the halves do not agree, the motion had not settled yet, and only the later half counts; half of the
    difference is an error, too.
    """
    half = growth.shape[1] // clock.block // 2 * clock.block
    means, errors, grown = grown_statistics(growth, clock)
    late, late_errors, _ = grown_statistics(growth[:, half:], clock)
    early = block_statistics(growth[:, :half], clock)[0]
    apart = np.abs(late[:, 0] - early[:, 0])
    agree = ~(apart > np.maximum(CERTAIN * 2.0 * errors[:, 0], STEADY * np.abs(late[:, 0])))
    late_errors = np.fmax(late_errors, 0.5 * apart[:, None])
    return np.where(agree[:, None], means, late), np.where(agree[:, None], errors, late_errors), agree, grown


def grown_statistics(growth: Array, clock: Clock) -> tuple[Array, Array, npt.NDArray[np.bool_]]:
    """Exponents (members, N), standard errors, and the mask of members whose errors have stopped growing.

    The errors are those of the longest blocks with a number of at least `FEWEST_BLOCKS`; if they still grow, the
    largest errors of longer blocks.
    """
    units = growth.shape[1] // clock.per_repeat
    longest = max(units // FEWEST_BLOCKS, 1)
    means, errors = block_statistics(growth, clock, longest)
    _, shorter = block_statistics(growth, clock, max(longest // 2, 1))
    grown = ~(errors[:, 0] > GROWING * shorter[:, 0])
    largest, length = errors, 2 * longest
    while not grown.all() and units // length >= LAST_BLOCKS:
        _, more = block_statistics(growth, clock, length)
        largest = np.where(grown[:, None], largest, np.fmax(largest, more))
        length *= 2
    return means, largest, grown


def block_statistics(growth: Array, clock: Clock, units: int | None = None) -> tuple[Array, Array]:
    """Exponents (members, N) as means over blocks, and the standard errors of these means.

    A block is that of the clock, or a number of ``units`` of its shortest whole number of forcing periods.
    """
    block = clock.block if units is None else units * clock.per_repeat
    blocks = growth.shape[1] // block
    per_block = growth[:, : blocks * block].reshape(len(growth), blocks, block, -1).sum(axis=2)
    rates = per_block / (block * clock.spacing)[:, None, None]
    return rates.mean(axis=1), rates.std(axis=1, ddof=1) / np.sqrt(blocks)


def running_estimate(growth: Array, clock: Clock) -> Array:
    """Averaged time and largest exponent so far at up to `RUNNING_POINTS` even points, (members, points, 2)."""
    steps = growth.shape[1]
    picks = np.unique(np.linspace(1, steps, min(RUNNING_POINTS, steps)).astype(int)) - 1
    time = clock.spacing[:, None] * (picks + 1)
    out = np.full((len(growth), RUNNING_POINTS, 2), np.nan)
    out[:, : len(picks), 0] = time
    out[:, : len(picks), 1] = np.cumsum(growth[:, :, 0], axis=1)[:, picks] / time
    return out


def bound_shear(members: Members, result: Exponents) -> None:
    """Sets exponents near 0 of regular motions without damping to 0, with the averages as errors.

    Deviations of such a motion grow in proportion to time by shear, so that an average over T is off by log(T)/T,
    whatever its scatter.
    """
    level = shear_level(result.time)[:, None]
    regular = ~members.damped & (result.sign == 0) & (result.values[:, 0] <= level[:, 0])
    near = regular[:, None] & (np.abs(result.values) <= np.maximum(level, CERTAIN * result.standard_error))
    bound = np.where(near, np.abs(result.values), 0.0).max(axis=1, keepdims=True, initial=0.0)
    result.standard_error[near] = np.maximum(result.standard_error, bound)[near]
    result.values[near] = 0.0
