"""Both Lyapunov exponents of the flow, per unit of dimensionless time, with their standard errors.

The tangent maps over stretches of at most `STRETCH` fastest time scales come from the variational equations; QR
decomposition of their products (Benettin et al., Meccanica 15 (1980) 9) gives the logarithmic growth of each stretch.
The error is that of the mean over blocks, each a whole number of drive repeats and longer than the motion remembers.
The exponents add up to -2 zeta exactly, which every result checks on itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.errors import InputError
from gelcone.model import ConeModel
from gelcone.motion.flow import DEFAULT_TOLERANCE, Outcome, integrate
from gelcone.motion.response import start_states
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

STRETCH = 16.0
"""Tangent maps are restarted after this many fastest linear time scales: deviations then grow by so little that neither
the step control nor the area between them suffers."""
BLOCK = 64.0
"""Shortest block of an average: longer than chaotic motions remember."""
FEWEST_BLOCKS = 20
CERTAIN = 3.0
"""The sign of an exponent counts as certain when it is this many standard errors from zero."""
FLOOR = 1e-7
"""Exponents closer to zero than this are zero as far as double precision tells."""
SHEAR = 5.0
"""Without damping the deviations of a regular motion grow like time, and its exponent looks like log(t)/t: only one
that is this many times larger is positive."""
STEADY = 0.05
"""Halves of the averaging time whose exponents differ by less than this share agree, however small their errors are."""
RUNNING_POINTS = 200


@dataclass(frozen=True)
class Clock:
    """How the time of each member is cut into stretches: ``per_repeat`` stretches to a drive repeat, or - where a
    repeat is short - ``repeats`` repeats to a stretch; ``block`` stretches, a whole number of repeats, to a block. One
    ``per_repeat`` and ``block`` for all members, the rest (members,)."""

    per_repeat: int
    block: int
    repeat: Array
    repeats: Array

    @property
    def spacing(self) -> Array:
        return self.repeat * self.repeats / self.per_repeat

    def take(self, index: Any) -> Clock:
        return Clock(self.per_repeat, self.block, self.repeat[index], self.repeats[index])


def clocks(model: ConeModel) -> list[tuple[npt.NDArray[np.intp], Clock]]:
    """Members grouped by their stretches per repeat and per block, each group with its clock."""
    repeat = np.broadcast_to(model.drive_repeat, model.shape).ravel()
    longest = STRETCH / fastest_rate(model)
    per_repeat = 2 ** np.ceil(np.log2(np.maximum(repeat / longest, 1.0))).astype(int)
    repeats = np.maximum(np.floor(longest / repeat), 1.0)
    block = per_repeat * np.ceil(BLOCK / (repeat * repeats)).astype(int)
    keys, group = np.unique(np.stack([per_repeat, block], axis=1), axis=0, return_inverse=True)
    groups = [np.flatnonzero(group.ravel() == i) for i in range(len(keys))]
    return [
        (members, Clock(int(key[0]), int(key[1]), repeat[members], repeats[members]))
        for key, members in zip(keys, groups, strict=True)
    ]


def fastest_rate(model: ConeModel) -> Array:
    """A bound of how fast small deviations move: damping, and spring, film at rest and field added up, (members,)."""
    c = model.coefficients()
    field = (np.asarray(model.voltage) + np.abs(model.voltage_bias)) ** 2
    rate = 2.0 * c.zeta + np.sqrt(1.0 + c.kappa + c.A + field)
    return np.broadcast_to(rate, model.shape).ravel()


@dataclass
class TangentRun:
    """Members on their way: states, orthonormal frames of tangent vectors, stretches done, and how it went."""

    states: Array
    frames: Array
    done: int
    outcome: npt.NDArray[np.int8]

    @classmethod
    def at(cls, states: Array) -> TangentRun:
        count = len(states)
        return cls(states.copy(), np.tile(np.eye(2), (count, 1, 1)), 0, np.zeros(count, dtype=np.int8))

    def take(self, index: Any) -> TangentRun:
        return TangentRun(self.states[index], self.frames[index], self.done, self.outcome[index])


def advance(model: ConeModel, run: TangentRun, clock: Clock, stretches: int, **flow_options: Any) -> Array:
    """Moves ``run`` on by some stretches; the logarithmic growth of each, shape (members, stretches, 2).

    ``model`` is a flattened ensemble of the run's members. NaN from where a member fails.
    """
    phase = (run.done % clock.per_repeat) / clock.per_repeat * clock.repeat
    times = phase[:, None] + clock.spacing[:, None] * np.arange(1, stretches + 1)
    flow = integrate(model, run.states, times, start=phase, keep="tangents", **flow_options)
    assert flow.tangents is not None
    growth, run.frames = qr_growth(flow.tangents, run.frames)
    run.states = flow.states[:, -1]
    run.done += stretches
    run.outcome = np.where(run.outcome == Outcome.OK, flow.outcome, run.outcome)
    return growth


def qr_growth(tangents: Array, frames: Array) -> tuple[Array, Array]:
    """Logarithmic growth along the orthonormal frames that tangent maps (members, stretches, 2, 2) carry along.

    Returns the growth (members, stretches, 2) and the final frames (members, 2, 2), columns orthonormal.
    """
    growth = np.empty((*tangents.shape[:2], 2))
    with np.errstate(divide="ignore", invalid="ignore"):
        for k in range(tangents.shape[1]):
            image = tangents[:, k] @ frames
            first, second = image[:, :, 0], image[:, :, 1]
            length = np.hypot(first[:, 0], first[:, 1])
            first = first / length[:, None]
            # In the plane what is left of the second vector is the area over the first one's length, without the
            # cancellation that subtracting its projection would suffer.
            height = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
            frames = np.stack([first, np.stack([-first[:, 1], first[:, 0]], axis=1)], axis=2)
            growth[:, k, 0] = np.log(length)
            growth[:, k, 1] = np.log(np.abs(height))
    return growth, frames


def default_transient(model: ConeModel) -> Array:
    """Time after which a motion counts as settled, (members,): 20 decay times (at most 5,000), 30 repeats or 200."""
    repeat = np.broadcast_to(model.drive_repeat, model.shape).ravel()
    damping = np.broadcast_to(model.damping_ratio, model.shape).ravel()
    decay = np.minimum(20.0 / np.maximum(damping, 1e-12), 5000.0)
    return np.maximum(np.maximum(30.0 * repeat, decay), 200.0)


def settle(model: ConeModel, states: Array, duration: Array, **flow_options: Any) -> tuple[Array, npt.NDArray[np.int8]]:
    """States (members, 2) after ``duration``, rounded up to whole drive repeats, and the outcomes."""
    repeat = np.broadcast_to(model.drive_repeat, model.shape).ravel()
    flow = integrate(model, states, (np.ceil(duration / repeat) * repeat)[:, None], **flow_options)
    return flow.states[:, 0], flow.outcome


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


def average(model: ConeModel, states: Array, *, budget: float, **flow_options: Any) -> Exponents:
    """Averages from ``states`` on (at a whole repeat) until the sign of the largest exponent is certain.

    ``model`` is a flattened ensemble, of which members with NaN states are left out; ``budget`` the longest averaging
    time, at least `FEWEST_BLOCKS` blocks.
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
    for group, clock in clocks(model):
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
    return SHEAR * np.log(np.maximum(time, np.e)) / np.maximum(time, np.e)


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
    tolerance : relative error of one integration step. Default 1e-15.

    Returns
    -------
    Dataset with ``asymptotic`` and ``finite`` (..., exponent), ``standard_error`` of the asymptotic ones,
    ``averaged_time``, ``sign`` of the largest (0: uncertain within the budget), ``sum_residual`` (their sum plus
    2 zeta, zero in exact arithmetic), ``running_time`` and ``running_exponent`` of the asymptotic average and
    ``finite_time`` and ``finite_exponent`` of the window, against window length, and ``outcome``.
    Exponents are per unit of dimensionless time; ``per_repeat`` is the largest per drive repeat.

    Raises
    ------
    InputError : for a window, transient or budget that is not positive, or when no member can start.
    """
    check_budgets(window=window, transient=transient, budget=budget)
    states = start_states(model, initial)
    flat = model.take(slice(None))
    options: dict[str, Any] = {"tolerance": tolerance, "threads": threads}
    report = progress or (lambda share: None)
    finite, finite_running = finite_exponents(flat, states, window, options)
    report(0.2)
    duration = default_transient(flat) if transient is None else np.full(flat.size, transient)
    settled, outcome = settle(flat, states, duration, **options)
    report(0.3)
    result = average(flat, settled, budget=budget, **options)
    report(0.5)
    outcome = np.where(outcome == Outcome.OK, result.outcome, outcome)
    values, running = result.values, result.running
    damping = np.broadcast_to(flat.damping_ratio, flat.shape)
    repeat = np.broadcast_to(flat.drive_repeat, flat.shape)
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
