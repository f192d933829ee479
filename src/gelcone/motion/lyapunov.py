"""All Lyapunov exponents of the flow, per unit of dimensionless time, with their standard errors.

They are averages (`gelcone.motion.exponents`) of the growth of deviations. A motion that has arrived at an attracting
cycle has the exponents of that cycle, which follow from its multipliers without averaging. Over a finite window the
numbers of a motion on which starts next to each other part have an error, too. The sum of the exponents is the mean
trace of the Jacobian along the motion (-2 zeta for two states); every result states the difference. The trace is
integrated along the motion. Where a source saturates it jumps; the rates of the states do not, so that deviations pass
without a saltation matrix, and the difference is that of rounding there, too.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Outcome
from gelcone.dataset import Findings
from gelcone.devices.analysis import analysis
from gelcone.errors import InputError
from gelcone.motion.attractor.search import cycles_reached, transient_of
from gelcone.motion.averages import batch_means
from gelcone.motion.exponents import LAST_BLOCKS, RUNNING_POINTS, Exponents, average, bound_shear
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.settle import Clock, check_budgets, clocks, repeats_lasting, settle
from gelcone.motion.start import start_states
from gelcone.motion.tangents import TangentRun, advance
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.progress import Counted, Progress, weighted
from gelcone.quantity import Array, Time

if TYPE_CHECKING:
    import xarray as xr

PIECE = 8192
"""Most stretches of a window in memory at a time."""
MOST_BLOCKS = 1024
"""Most blocks of a window whose growth is compared."""
PARTING = math.log(1e9)
"""Logarithmic growth of a deviation below which starts 1e-12 apart remain within 1e-3 of each other."""

FINITE_ERROR = "standard error of the exponents over the window, 0 where starts 1e-12 apart have the same"


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
    """Compute all Lyapunov exponents of every member: in the long run, and over a finite window from the start.

    Parameters
    ----------
    model : one actuator or an ensemble.
    initial : displacement and velocity at time 0, shape (2,) or ensemble shape + (2,). Default (1, 0).
    window : length of the finite window from the start, dimensionless time. Default 500.
    transient : time discarded before the long average; default by damping, drive and slow states.
    budget : longest averaging time. Averaging stops earlier once the largest exponent is 3 standard errors off zero and
        longer blocks give no larger errors; at least 100 blocks of at least a forcing period and 64 time units are
        averaged. Default 20,000, or 10,000,000 for a ``precision``.
        A damped motion that has then reached an attracting cycle or rest has its exponents, from the Floquet
        multipliers; averages are then only in ``running_exponent``.
    precision : standard error of the largest exponent at which averaging may stop. Default any.
    tolerance : relative error of one integration step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset with ``lyapunov`` (in the long run) and ``finite`` (..., exponent), ``standard_error`` of the former and
    ``finite_standard_error`` of the latter (0 where starts 1e-12 apart have the same, as on the way to a cycle),
    ``averaged_time``, ``cycle`` (period in forcing periods of the attracting cycle, or 1 for rest, whose exponents they
    are; 0 where they are averages), ``sign`` of the largest (0: uncertain within the budget), ``sum_residual`` (their
    sum less the mean trace of the Jacobian along the motion, -2 zeta for two states; zero in exact arithmetic, whether
    or not a source saturates), ``running_time`` and ``running_exponent`` of the average and ``finite_time`` and
    ``finite_exponent`` of the window, against window length, and ``outcome``.
    Exponents are per unit of dimensionless time; ``per_repeat`` is the largest per forcing period. An exponent is NaN
    where deviations decay so fast that rounding hides them.

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
    findings = lyapunov_cells(model.members(), states, **options, threads=threads, progress=progress)
    return dataset.label(
        model, findings.variables, outcome=findings.outcome, options=options, title="Lyapunov exponents"
    )


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
    first_share = {"progress": weighted(counted, 0.2)}
    finite, finite_running, finite_errors = finite_exponents(members, states, window, flow | first_share)
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
            "finite_standard_error": (("exponent",), finite_errors, FINITE_ERROR, "rate"),
            "per_repeat": ((), values[:, 0] * members.forcing_period, "largest exponent per forcing period", "share"),
            "averaged_time": ((), time, "averaging time behind the exponents", "time"),
            "cycle": ((), cycle, "period of the cycle behind the exponents, 0 if averaged", "count"),
            "sign": ((), result.sign, "sign of the largest exponent, 0 if uncertain", "code"),
            "sum_residual": ((), residual, "sum of the exponents less the mean trace of the Jacobian", "rate"),
            "running_time": (("window",), running[..., 0], "averaging time so far, after the transient", "time"),
            "running_exponent": (("window",), running[..., 1], "largest exponent so far, after the transient", "rate"),
            "finite_time": (("window",), finite_running[..., 0], "window length, from the start", "time"),
            "finite_exponent": (("window",), finite_running[..., 1], "largest exponent over that window", "rate"),
        },
        outcome,
    )


def take_cycles(members: Members, result: Exponents, options: dict[str, Any]) -> npt.NDArray[np.int64]:
    """Replaces averages by the exponents of a cycle where the motion has arrived at one; returns the periods, or 0.

    An average over chaos that ends in a cycle would mix both.
    """
    period = np.zeros(members.size, dtype=np.int64)
    rows = np.flatnonzero(members.damped & np.isfinite(result.states).all(axis=1))
    if rows.size:
        cycles = cycles_reached(members.take(rows), result.states[rows], **options)
        attracted = rows[cycles.attracting]
        period[attracted] = cycles.period[cycles.attracting]
        result.values[attracted] = cycles.exponents[cycles.attracting]
        result.standard_error[attracted] = cycles.error[cycles.attracting]
        result.divergence[attracted] = cycles.divergence[cycles.attracting]
        result.sign[attracted] = -1
    return period


def finite_exponents(
    members: Members, states: Array, window: float, options: dict[str, Any]
) -> tuple[Array, Array, Array]:
    """Exponents over the window from the start (members, N), the running estimate of the largest, and the standard
    errors (members, N): 0 of motions on which starts 1e-12 apart do not part within the window.

    ``options`` go to `integrate`; a ``progress`` among them is that of the whole ensemble.
    """
    values, errors = np.full((2, *states.shape), np.nan)
    running = np.full((members.size, RUNNING_POINTS, 2), np.nan)
    for group, clock in clocks(members):
        steps = np.maximum(np.rint(window / clock.spacing), 1).astype(int)
        for count in np.unique(steps):
            rows, row_clock = group[steps == count], clock.take(steps == count)
            share = weighted(options.get("progress"), rows.size / members.size)
            row_options = options | {"progress": share}
            here = members.take(rows), states[rows], row_clock
            total, running[rows], errors[rows] = _piece_by_piece(*here, int(count), row_options)
            values[rows] = total / (count * row_clock.spacing)[:, None]
    return values, running, errors


def _parts(running: Array) -> npt.NDArray[np.bool_]:
    """Whether a deviation grows by more than `PARTING` between two points of running estimates (members, points, 2)."""
    grown = running[..., 0] * running[..., 1]
    lowest = np.minimum.accumulate(np.minimum(grown, 0.0), axis=1)
    return np.asarray(np.fmax.reduce(grown - lowest, axis=1) > PARTING)


def _piece_by_piece(
    members: Members, states: Array, clock: Clock, stretches: int, options: dict[str, Any]
) -> tuple[Array, Array, Array]:
    """Growth over some stretches (members, N), the running estimate, and the standard errors of the rates, in pieces of
    at most `PIECE` stretches."""
    run, total = TangentRun.at(states), np.zeros(states.shape)
    picks = np.unique(np.linspace(1, stretches, min(RUNNING_POINTS, stretches)).astype(int))
    running = np.full((len(states), RUNNING_POINTS, 2), np.nan)
    block = _block_of(clock, stretches)
    blocks = np.zeros((stretches // block, *states.shape))
    for first in range(0, stretches, PIECE):
        count = min(PIECE, stretches - first)
        part = options | {"progress": weighted(options.get("progress"), count / stretches)}
        growth, _ = advance(members, run, clock, count, **part)
        here = np.flatnonzero((picks > first) & (picks <= first + count))
        time = clock.spacing[:, None] * picks[here]
        so_far = total[:, :1] + np.cumsum(growth[:, :, 0], axis=1)
        running[:, here, 0], running[:, here, 1] = time, so_far[:, picks[here] - first - 1] / time
        total = total + growth.sum(axis=1)
        of = (first + np.arange(count)) // block
        np.add.at(blocks, of[of < len(blocks)], growth.swapaxes(0, 1)[of < len(blocks)])
        if not np.isfinite(run.states).all(axis=1).any():
            break
    rates = blocks / (block * clock.spacing)[:, None]
    errors = batch_means(rates)[1] if len(rates) > 1 else np.full_like(total, np.nan)
    errors = np.where(_parts(running)[:, None], errors, 0.0)
    ran = (run.outcome == Outcome.OK)[:, None]
    return np.where(ran, total, np.nan), running, np.where(ran & np.isfinite(total), errors, np.nan)


def _block_of(clock: Clock, stretches: int) -> int:
    """The stretches in a block of a window: whole forcing periods where there are `LAST_BLOCKS` of them, over which
    growth differs less than within one."""
    periods = stretches // clock.per_repeat
    if periods < LAST_BLOCKS:
        return max(stretches // LAST_BLOCKS, 1)
    return clock.per_repeat * math.ceil(periods / MOST_BLOCKS)
