"""Both Lyapunov exponents of the flow, per unit of dimensionless time, with their standard errors.

They are averages of the growth of deviations (`gelcone.motion.tangents`); the error is that of the mean over blocks,
each a whole number of drive repeats and longer than the motion remembers. A motion that has arrived at an attracting
cycle has the exponents of that cycle, which its multipliers give without averaging. The exponents add up to -2 zeta
exactly, which every result checks on itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Outcome
from gelcone.errors import InputError
from gelcone.motion.cycle import cycles_reached
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.response import start_states
from gelcone.motion.section import repeats_lasting, settle
from gelcone.motion.tangents import CERTAIN, FLOOR, STRETCH, Clock, TangentRun, advance, clocks
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

FEWEST_BLOCKS = 20
SHEAR = 5.0
"""Without damping the deviations of a regular motion grow like time, and its exponent looks like log(t)/t: only one
that is this many times larger is positive."""
STEADY = 0.05
"""Halves of the averaging time whose exponents differ by less than this share agree, however small their errors are."""
RUNNING_POINTS = 200


def default_transient(model: ConeModel) -> Array:
    """Time after which a motion counts as settled, (members,): 20 decay times (at most 5,000), 30 repeats or 200."""
    repeat = np.broadcast_to(model.forcing_period, model.shape).ravel()
    damping = np.broadcast_to(model.damping_ratio, model.shape).ravel()
    decay = np.minimum(20.0 / np.maximum(damping, 1e-12), 5000.0)
    return np.maximum(np.maximum(30.0 * repeat, decay), 200.0)


@dataclass(frozen=True)
class Exponents:
    """Both exponents of all members after averaging: ``values`` and ``standard_error`` (members, 2), ``time`` averaged
    over, ``sign`` of the largest (-1 or 1 when certain, 0 when the budget did not suffice), ``outcome``; ``running``
    (members, points, 2): averaged time and largest exponent so far; ``states`` at the end."""

    values: Array
    standard_error: Array
    time: Array
    sign: npt.NDArray[np.int8]
    outcome: npt.NDArray[np.int8]
    running: Array
    states: Array


def average(
    model: ConeModel, states: Array, *, budget: float, stretch: float = STRETCH, **flow_options: Any
) -> Exponents:
    """Averages from ``states`` on (at a whole repeat) until the sign of the largest exponent is certain.

    ``model`` is a flattened ensemble, of which members with NaN states are left out; ``budget`` the longest averaging
    time, at least `FEWEST_BLOCKS` blocks; ``stretch`` as in `clocks`.
    """
    count = len(states)
    result = Exponents(
        values=np.full((count, 2), np.nan),
        standard_error=np.full((count, 2), np.nan),
        time=np.zeros(count),
        sign=np.zeros(count, dtype=np.int8),
        outcome=np.zeros(count, dtype=np.int8),
        running=np.full((count, RUNNING_POINTS, 2), np.nan),
        states=np.full((count, 2), np.nan),
    )
    ran = np.asarray(np.isfinite(states).all(axis=1))
    for group, clock in clocks(model, stretch):
        members = group[ran[group]]
        if members.size:
            own = clock.take(ran[group])
            _average_group(model.take(members), states[members], own, members, budget, result, flow_options)
    return result


def _average_group(
    model: ConeModel,
    states: Array,
    clock: Clock,
    members: npt.NDArray[np.intp],
    budget: float,
    result: Exponents,
    flow_options: dict[str, Any],
) -> None:
    run, growth = TangentRun.at(states), np.empty((len(states), 0, 2))
    # One block lets the frame turn into its own directions before the average begins.
    advance(model, run, clock, clock.block, **flow_options)
    while True:
        blocks = FEWEST_BLOCKS if growth.shape[1] == 0 else growth.shape[1] // clock.block
        growth = np.concatenate([growth, advance(model, run, clock, blocks * clock.block, **flow_options)], axis=1)
        means, errors, steady = steady_statistics(growth, clock)
        time = growth.shape[1] * clock.spacing
        undamped = np.broadcast_to(model.damping_ratio, model.shape) == 0.0
        floor = np.where(undamped, shear_level(time), FLOOR)
        certain = steady & (np.abs(means[:, 0]) > np.maximum(CERTAIN * errors[:, 0], floor))
        finished = certain | (run.outcome != Outcome.OK) | (2.0 * time > budget)
        ended = members[finished]
        result.values[ended], result.standard_error[ended] = means[finished], errors[finished]
        result.time[ended] = time[finished]
        result.sign[ended] = np.where(certain, np.sign(means[:, 0]), 0)[finished]
        result.outcome[ended] = run.outcome[finished]
        result.running[ended] = running_estimate(growth[finished], clock.take(finished))
        result.states[ended] = run.states[finished]
        if finished.all():
            return
        on = np.flatnonzero(~finished)
        model, members, growth, clock, run = model.take(on), members[on], growth[on], clock.take(on), run.take(on)


def shear_level(time: Array) -> Array:
    """The exponent that regular motion without damping may seem to have after so long an average."""
    return SHEAR * np.log(np.maximum(time, math.e)) / np.maximum(time, math.e)


def steady_statistics(growth: Array, clock: Clock) -> tuple[Array, Array, npt.NDArray[np.bool_]]:
    """Exponents and standard errors, and whether both halves of the time agree on the largest.

    Where they do not, the motion was still on its way - chaos that ends in a cycle - and the later half alone counts.
    """
    half = growth.shape[1] // clock.block // 2 * clock.block
    means, errors = block_statistics(growth, clock)
    (early, early_error), (late, late_error) = (
        block_statistics(g, clock) for g in (growth[:, :half], growth[:, half:])
    )
    spread = np.hypot(early_error[:, 0], late_error[:, 0])
    steady = ~(np.abs(late[:, 0] - early[:, 0]) > np.maximum(CERTAIN * spread, STEADY * np.abs(late[:, 0])))
    return (
        np.where(steady[:, None], means, late),
        np.where(steady[:, None], errors, late_error),
        steady,
    )


def block_statistics(growth: Array, clock: Clock) -> tuple[Array, Array]:
    """Exponents (members, 2) as means over blocks, and the standard errors of these means."""
    blocks = growth.shape[1] // clock.block
    per_block = growth[:, : blocks * clock.block].reshape(len(growth), blocks, clock.block, 2).sum(axis=2)
    rates = per_block / (clock.block * clock.spacing)[:, None, None]
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


def lyapunov(
    model: ConeModel,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    window: float = 500.0,
    transient: float | None = None,
    budget: float = 20_000.0,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Both Lyapunov exponents of every member: over a finite window from the start, and asymptotically.

    Parameters
    ----------
    model : one actuator or an ensemble.
    initial : displacement and velocity at time 0, shape (2,) or ensemble shape + (2,). Default (1, 0).
    window : length of the finite window from the start, dimensionless time. Default 500.
    transient : time discarded before the asymptotic average; default `default_transient`.
    budget : longest asymptotic averaging time. Averaging stops earlier once the largest exponent is 3 standard errors
        off zero; at least 20 blocks of at least a drive repeat and 64 time units are averaged. Default 20,000.
        A damped motion that is on an attracting cycle or at rest by then has the exponents of that, from its Floquet
        multipliers; what was averaged shows in ``running_exponent`` alone.
    tolerance : relative error of one integration step. Default 1e-15.

    Returns
    -------
    Dataset with ``asymptotic`` and ``finite`` (..., exponent), ``standard_error`` of the asymptotic ones,
    ``averaged_time``, ``cycle`` (period in drive repeats of the attracting cycle, or 1 for rest, whose exponents they
    are; 0 where they are averages), ``sign`` of the largest (0: uncertain within the budget), ``sum_residual`` (their
    sum plus 2 zeta, zero in exact arithmetic), ``running_time`` and ``running_exponent`` of the asymptotic average and
    ``finite_time`` and ``finite_exponent`` of the window, against window length, and ``outcome``.
    Exponents are per unit of dimensionless time; ``per_repeat`` is the largest per drive repeat.

    Raises
    ------
    InputError : for a window, transient or budget that is not positive, or when no member can start.
    """
    check_budgets(window=window, transient=transient, budget=budget)
    states = start_states(model, initial)
    flat = model.members()
    options: dict[str, Any] = {"tolerance": tolerance, "threads": threads}
    report = progress or (lambda share: None)
    finite, finite_running = finite_exponents(flat, states, window, options)
    report(0.2)
    duration = default_transient(flat) if transient is None else np.full(flat.size, transient)
    settled, outcome = settle(flat, states, repeats_lasting(flat, duration), **options)
    report(0.3)
    result = average(flat, settled, budget=budget, **options)
    report(0.4)
    outcome = np.where(outcome == Outcome.OK, result.outcome, outcome)
    cycle = take_cycles(flat, result, options)
    report(0.1)
    values, running = result.values, result.running
    damping = np.broadcast_to(flat.damping_ratio, flat.shape)
    repeat = np.broadcast_to(flat.forcing_period, flat.shape)
    return dataset.label(
        model,
        {
            "asymptotic": (("exponent",), values, "Lyapunov exponents per unit time after the transient", "rate"),
            "standard_error": (("exponent",), result.standard_error, "standard error of the exponents", "rate"),
            "finite": (("exponent",), finite, "Lyapunov exponents per unit time over the window", "rate"),
            "per_repeat": ((), values[:, 0] * repeat, "largest exponent per drive repeat", "share"),
            "averaged_time": (
                (),
                np.where(outcome == Outcome.OK, result.time, np.nan),
                "averaging time behind the asymptotic exponents",
                "time",
            ),
            "cycle": ((), cycle, "period of the cycle behind the asymptotic exponents, 0 if averaged", "count"),
            "sign": ((), result.sign, "sign of the largest exponent, 0 if uncertain", "share"),
            "sum_residual": ((), values.sum(axis=1) + 2.0 * damping, "sum of the exponents plus 2 zeta", "rate"),
            "running_time": (("window",), running[..., 0], "averaging time so far, after the transient", "time"),
            "running_exponent": (("window",), running[..., 1], "largest exponent so far, after the transient", "rate"),
            "finite_time": (("window",), finite_running[..., 0], "window length, from the start", "time"),
            "finite_exponent": (("window",), finite_running[..., 1], "largest exponent over that window", "rate"),
        },
        outcome=outcome,
        options={"window": window, "transient": transient, "budget": budget, "tolerance": tolerance},
        title="Lyapunov exponents",
    )


def take_cycles(model: ConeModel, result: Exponents, options: dict[str, Any]) -> npt.NDArray[np.int64]:
    """Puts the exponents of a cycle in the place of averages where the motion has arrived at it; the periods, or 0.

    An average over chaos that has ended in a cycle meanwhile would mix both.
    """
    period = np.zeros(model.size, dtype=np.int64)
    damped = np.broadcast_to(model.damping_ratio, model.shape) > 0.0
    members = np.flatnonzero(damped & np.isfinite(result.states).all(axis=1))
    if members.size:
        found = cycles_reached(model.take(members), result.states[members], **options)
        there = members[found.attracting]
        period[there] = found.period[found.attracting]
        result.values[there] = found.exponents[found.attracting]
        result.standard_error[there] = found.error[found.attracting]
        result.sign[there] = -1
    return period


def check_budgets(**budgets: float | None) -> None:
    """`InputError` for a time that is not positive and finite."""
    for name, value in budgets.items():
        if value is not None and not (np.isfinite(value) and value > 0.0):
            raise InputError(f"{name} = {value:g}: must be a positive dimensionless time")


def finite_exponents(model: ConeModel, states: Array, window: float, options: dict[str, Any]) -> tuple[Array, Array]:
    """Exponents over the window from the start (members, 2), and the running estimate of the largest."""
    values = np.full((model.size, 2), np.nan)
    running = np.full((model.size, RUNNING_POINTS, 2), np.nan)
    for group, clock in clocks(model):
        steps = np.maximum(np.rint(window / clock.spacing), 1).astype(int)
        for count in np.unique(steps):
            members, own = group[steps == count], clock.take(steps == count)
            growth = advance(model.take(members), TangentRun.at(states[members]), own, int(count), **options)
            values[members] = growth.sum(axis=1) / (count * own.spacing)[:, None]
            running[members] = running_estimate(growth, own)
    return values, running
