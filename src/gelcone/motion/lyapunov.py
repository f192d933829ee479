"""All Lyapunov exponents of the flow, per unit of dimensionless time, with their standard errors.

They are averages of the growth of deviations (`gelcone.motion.tangents`). The error is that of the mean over at least
100 blocks, each a whole number of forcing periods: the longer the blocks, the less of what the motion remembers from
one to the next is missed, and the averaging continues until longer blocks give no larger errors (Flyvbjerg and
Petersen, J. Chem. Phys. 91 (1989) 461). A motion that has arrived at an attracting
cycle has the exponents of that cycle, which its multipliers give without averaging. The exponents add up to the mean
trace of the Jacobian along the motion (-2 zeta for two states), which every result checks on itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Outcome
from gelcone.dataset import Findings
from gelcone.devices.analysis import analysis
from gelcone.errors import InputError
from gelcone.motion.attractor.search import cycles_reached, transient_of
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.settle import (
    STRETCH,
    Clock,
    check_budgets,
    clocks,
    repeats_lasting,
    settle,
    start_states,
)
from gelcone.motion.tangents import CERTAIN, FLOOR, TangentRun, advance
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.progress import Counted, Progress, weighted
from gelcone.quantity import Array, Time

if TYPE_CHECKING:
    import xarray as xr

FEWEST_BLOCKS = 100
"""Fewest blocks that give an error; fewer give a sign at best."""
GROWING = 1.15
"""Errors grow still when those of the longest blocks exceed those of half the length by this factor, twice what chance
makes of 100 blocks."""
LAST_BLOCKS = 16
"""Where they grow still and the budget is spent, the largest error of any blocks counts, as long as there is this
number.
"""
BUDGET, PRECISE_BUDGET = 20_000.0, 1e7
"""Longest averaging time by default, without and with a precision that is asked for."""
SHEAR = 5.0
"""Without damping the deviations of a regular motion grow like time, and its exponent looks like log(t)/t: only one
that is this many times larger is positive."""
STEADY = 0.05
"""Halves of the averaging time whose exponents differ by less than this share agree, however small their errors are."""
RUNNING_POINTS = 200
PIECE = 8192
"""Most stretches of a window that are held at once."""


@dataclass(frozen=True)
class Exponents:
    """The exponents of all members after averaging: ``values`` and ``standard_error`` (members, N), ``time`` averaged
    over, ``divergence`` (members,), the mean trace of the Jacobian over that time, ``sign`` of the largest (-1 or 1
    when certain, 0 when the budget did not suffice), ``outcome``; ``running`` (members, points, 2): averaged time and
    largest exponent so far; ``states`` (members, N) at the end."""

    values: Array
    standard_error: Array
    time: Array
    divergence: Array
    sign: npt.NDArray[np.int8]
    outcome: npt.NDArray[np.int8]
    running: Array
    states: Array


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
    goal = _Goal(budget, np.inf if precision is None else precision)
    count, size = states.shape
    result = Exponents(
        values=np.full((count, size), np.nan),
        standard_error=np.full((count, size), np.nan),
        time=np.zeros(count),
        divergence=np.full(count, np.nan),
        sign=np.zeros(count, dtype=np.int8),
        outcome=np.zeros(count, dtype=np.int8),
        running=np.full((count, RUNNING_POINTS, 2), np.nan),
        states=np.full((count, size), np.nan),
    )
    runs = np.asarray(np.isfinite(states).all(axis=1))
    for group, clock in clocks(members, stretch):
        rows = group[runs[group]]
        if rows.size:
            own = clock.take(runs[group])
            _average_group(members.take(rows), states[rows], own, rows, goal, result, flow_options)
    return result


@dataclass(frozen=True)
class _Goal:
    """When an average ends: at the latest after the time ``budget``, not before the error is down to ``precision``."""

    budget: float
    precision: float


def _average_group(
    members: Members,
    states: Array,
    clock: Clock,
    rows: npt.NDArray[np.intp],
    goal: _Goal,
    result: Exponents,
    flow_options: dict[str, Any],
) -> None:
    run, growth = TangentRun.at(states), np.empty((len(states), 0, states.shape[1] + 1))
    # One block lets the frame turn into its own directions before the average begins.
    advance(members, run, clock, clock.block, **flow_options)
    while True:
        blocks = FEWEST_BLOCKS if growth.shape[1] == 0 else growth.shape[1] // clock.block
        more, trace = advance(members, run, clock, blocks * clock.block, **flow_options)
        # the trace is averaged as the exponents are, over the same blocks
        growth = np.concatenate([growth, np.concatenate([more, trace[:, :, None]], axis=2)], axis=1)
        means, errors, steady, grown = steady_statistics(growth, clock)
        time = growth.shape[1] * clock.spacing
        floor = np.where(members.damped, FLOOR, shear_level(time))
        certain = np.abs(means[:, 0]) > np.maximum(CERTAIN * errors[:, 0], floor)
        enough = certain & steady & grown & (errors[:, 0] <= goal.precision)
        finished = enough | (run.outcome != Outcome.OK) | (2.0 * time > goal.budget)
        ended = rows[finished]
        result.values[ended], result.standard_error[ended] = means[finished, :-1], errors[finished, :-1]
        result.divergence[ended] = means[finished, -1]
        result.time[ended] = time[finished]
        result.sign[ended] = np.where(certain, np.sign(means[:, 0]), 0)[finished]
        result.outcome[ended] = run.outcome[finished]
        result.running[ended] = running_estimate(growth[finished], clock.take(finished))
        result.states[ended] = run.states[finished]
        if finished.all():
            return
        left = np.flatnonzero(~finished)
        members, rows, growth, clock = members.take(left), rows[left], growth[left], clock.take(left)
        run = run.take(left)


def shear_level(time: Array) -> Array:
    """The exponent that regular motion without damping may seem to have after so long an average."""
    return SHEAR * np.log(np.maximum(time, math.e)) / np.maximum(time, math.e)


def steady_statistics(growth: Array, clock: Clock) -> tuple[Array, Array, npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Exponents and standard errors, whether both halves of the time agree on the largest exponent, and whether longer
    blocks give no larger errors.

    Where the halves do not agree, the motion had not settled yet, and only the later one counts; half of what they
    differ by is an error too.
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
    """Exponents (members, N), the standard errors of the longest blocks of which there are `FEWEST_BLOCKS`, and whether
    these have stopped growing; where they have not, the largest errors that still longer blocks give."""
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


@analysis(
    swept=True,
    answers="motions",
    bulky=("running_time", "running_exponent", "finite_time", "finite_exponent"),
    examples=(
        "--set voltage=1.7 --set drive_frequency=0.1 --out results",
        "--set voltage=0.5,1,1.5 --budget 5000 --json",
    ),
)
def lyapunov(
    model: ConeModel,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    window: Time = 500.0,
    transient: Time | None = None,
    budget: Time | None = None,
    precision: float | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """All Lyapunov exponents of every member: in the long run, and over a finite window from the start.

    Parameters
    ----------
    model : one actuator or an ensemble.
    initial : displacement and velocity at time 0, shape (2,) or ensemble shape + (2,). Default (1, 0).
    window : length of the finite window from the start, dimensionless time. Default 500.
    transient : time discarded before the long average; default by damping and drive.
    budget : longest averaging time. Averaging stops earlier once the largest exponent is 3 standard errors off zero and
        longer blocks give no larger errors; at least 100 blocks of at least a forcing period and 64 time units are
        averaged. Default 20,000, or 10,000,000 for a ``precision``.
        A damped motion that is on an attracting cycle or at rest by then has the exponents of that, from its Floquet
        multipliers; what was averaged shows in ``running_exponent`` alone.
    precision : standard error of the largest exponent at which averaging may stop. Default any.
    tolerance : relative error of one integration step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset with ``lyapunov`` (in the long run) and ``finite`` (..., exponent), ``standard_error`` of the former,
    ``averaged_time``, ``cycle`` (period in forcing periods of the attracting cycle, or 1 for rest, whose exponents they
    are; 0 where they are averages), ``sign`` of the largest (0: uncertain within the budget), ``sum_residual`` (their
    sum less the mean trace of the Jacobian along the motion, -2 zeta for two states; zero in exact arithmetic),
    ``running_time`` and
    ``running_exponent`` of the average and ``finite_time`` and ``finite_exponent`` of the window, against window
    length, and ``outcome``.
    Exponents are per unit of dimensionless time; ``per_repeat`` is the largest per forcing period.

    Raises
    ------
    InputError : for a window, transient or budget that is not positive, or when no member can start.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(voltage=0.6, drive_frequency=0.5)
    >>> found = gelcone.lyapunov(model)
    >>> f"{float(found.lyapunov[0]):.4f} +- {float(found.standard_error[0]):.0e}", int(found.cycle)
    ('-0.0500 +- 1e-08', 1)
    """
    options: dict[str, Any] = {
        "window": window,
        "transient": transient,
        "budget": budget,
        "precision": precision,
        "tolerance": tolerance,
    }
    states = start_states(model, initial)
    found = lyapunov_cells(model.members(), states, **options, threads=threads, progress=progress)
    return dataset.label(model, found.variables, outcome=found.outcome, options=options, title="Lyapunov exponents")


def lyapunov_cells(
    members: Members,
    states: Array,
    *,
    window: float = 500.0,
    transient: float | None = None,
    budget: float | None = None,
    precision: float | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> Findings:
    """Compute `lyapunov` for every member of a flattened ensemble from its state (members, N); options as there."""
    check_budgets(window=window, transient=transient, budget=budget)
    if precision is not None and not (np.isfinite(precision) and precision > 0.0):
        raise InputError(f"precision = {precision:g}: must be positive, a standard error per unit time")
    flow: dict[str, Any] = {"tolerance": tolerance, "threads": threads}
    counted = Counted(progress)
    finite, finite_running = finite_exponents(members, states, window, flow | {"progress": weighted(counted, 0.2)})
    repeats = repeats_lasting(members, transient_of(members, transient))
    settled, outcome = settle(members, states, repeats, progress=weighted(counted, 0.3), **flow)
    result = average(members, settled, budget=budget, precision=precision, **flow)
    counted(0.4)
    outcome = np.where(outcome == Outcome.OK, result.outcome, outcome)
    cycle = take_cycles(members, result, flow)
    trace = -2.0 * members.values["damping_ratio"] if members.system.planar else result.divergence
    residual = result.values.sum(axis=1) - trace
    bound_shear(members, result)
    counted.finish()
    values, running = result.values, result.running
    time = np.where(outcome == Outcome.OK, result.time, np.nan)
    return Findings(
        {
            "lyapunov": (("exponent",), values, "Lyapunov exponents per unit time after the transient", "rate"),
            "standard_error": (("exponent",), result.standard_error, "standard error of the exponents", "rate"),
            "finite": (("exponent",), finite, "Lyapunov exponents per unit time over the window", "rate"),
            "per_repeat": ((), values[:, 0] * members.forcing_period, "largest exponent per forcing period", "share"),
            "averaged_time": ((), time, "averaging time behind the exponents", "time"),
            "cycle": ((), cycle, "period of the cycle behind the exponents, 0 if averaged", "count"),
            "sign": ((), result.sign, "sign of the largest exponent, 0 if uncertain", "share"),
            "sum_residual": (
                (),
                residual,
                "sum of the exponents less the mean trace of the Jacobian",
                "rate",
            ),
            "running_time": (("window",), running[..., 0], "averaging time so far, after the transient", "time"),
            "running_exponent": (("window",), running[..., 1], "largest exponent so far, after the transient", "rate"),
            "finite_time": (("window",), finite_running[..., 0], "window length, from the start", "time"),
            "finite_exponent": (("window",), finite_running[..., 1], "largest exponent over that window", "rate"),
        },
        outcome,
    )


def take_cycles(members: Members, result: Exponents, options: dict[str, Any]) -> npt.NDArray[np.int64]:
    """Puts the exponents of a cycle in the place of averages where the motion has arrived at it; the periods, or 0.

    An average over chaos that has ended in a cycle meanwhile would mix both.
    """
    period = np.zeros(members.size, dtype=np.int64)
    rows = np.flatnonzero(members.damped & np.isfinite(result.states).all(axis=1))
    if rows.size:
        found = cycles_reached(members.take(rows), result.states[rows], **options)
        there = rows[found.attracting]
        period[there] = found.period[found.attracting]
        result.values[there] = found.exponents[found.attracting]
        result.standard_error[there] = found.error[found.attracting]
        result.divergence[there] = found.divergence[found.attracting]
        result.sign[there] = -1
    return period


def bound_shear(members: Members, result: Exponents) -> None:
    """Regular motion without damping has the exponents 0: what was averaged is shear, and bounds what may be there.

    Its deviations grow like time, so that an average over T is off by log(T)/T, however small its scatter is.
    """
    regular = ~members.damped & (result.sign == 0) & (result.values[:, 0] <= shear_level(result.time))
    bound = np.abs(result.values[regular]).max(axis=1, initial=0.0)
    result.standard_error[regular] = np.maximum(result.standard_error[regular], bound[:, None])
    result.values[regular] = 0.0


def finite_exponents(members: Members, states: Array, window: float, options: dict[str, Any]) -> tuple[Array, Array]:
    """Exponents over the window from the start (members, N), and the running estimate of the largest.

    ``options`` go to `integrate`; a ``progress`` among them is that of the whole ensemble.
    """
    values = np.full(states.shape, np.nan)
    running = np.full((members.size, RUNNING_POINTS, 2), np.nan)
    for group, clock in clocks(members):
        steps = np.maximum(np.rint(window / clock.spacing), 1).astype(int)
        for count in np.unique(steps):
            rows, own = group[steps == count], clock.take(steps == count)
            share = weighted(options.get("progress"), rows.size / members.size)
            part = options | {"progress": share}
            total, running[rows] = _piece_by_piece(members.take(rows), states[rows], own, int(count), part)
            values[rows] = total / (count * own.spacing)[:, None]
    return values, running


def _piece_by_piece(
    members: Members, states: Array, clock: Clock, stretches: int, options: dict[str, Any]
) -> tuple[Array, Array]:
    """Growth over some stretches (members, N), and the running estimate; no more than `PIECE` stretches are held."""
    run, total = TangentRun.at(states), np.zeros(states.shape)
    picks = np.unique(np.linspace(1, stretches, min(RUNNING_POINTS, stretches)).astype(int))
    running = np.full((len(states), RUNNING_POINTS, 2), np.nan)
    for first in range(0, stretches, PIECE):
        count = min(PIECE, stretches - first)
        part = options | {"progress": weighted(options.get("progress"), count / stretches)}
        growth, _ = advance(members, run, clock, count, **part)
        here = np.flatnonzero((picks > first) & (picks <= first + count))
        time = clock.spacing[:, None] * picks[here]
        so_far = total[:, :1] + np.cumsum(growth[:, :, 0], axis=1)
        running[:, here, 0], running[:, here, 1] = time, so_far[:, picks[here] - first - 1] / time
        total = total + growth.sum(axis=1)
        if not np.isfinite(run.states).all(axis=1).any():
            break
    return np.where((run.outcome == Outcome.OK)[:, None], total, np.nan), running
