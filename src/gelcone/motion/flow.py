"""Trajectories of an ensemble: arguments are checked here, and a back end integrates."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.devices.analysis import check_model
from gelcone.errors import InputError, check_name
from gelcone.motion.job import KEEPS, Backend, Job, Keep, Portable, Trajectories
from gelcone.motion.jumps import end_films
from gelcone.physics.driven import DrivenSystem
from gelcone.physics.members import Ensemble, Members
from gelcone.physics.system import ConeSystem
from gelcone.physics.trace import Node
from gelcone.progress import current_watch
from gelcone.quantity import ALL_CORES, Array, check_count, spread

if TYPE_CHECKING:
    from gelcone.motion.engine.phase import PhaseProgram
    from gelcone.motion.engine.portable import Outputs
    from gelcone.motion.engine.steps import Steps

DEFAULT_TOLERANCE = 1e-15


@cache
def backend() -> Backend:
    """The integrator, loaded when it is first needed."""
    from gelcone.motion.engine.backend import EngineBackend

    return EngineBackend()


def phase_program(system: ConeSystem, moved: tuple[tuple[str, ...], ...], tolerance: float) -> PhaseProgram:
    """The integrator over the drive's phase, with the derivatives that shooting needs; see `PhaseProgram`."""
    from gelcone.motion.engine import phase

    return phase.phase_program(system, moved, tolerance)


def smallest_step(members: Members) -> Array:
    """The step below which a member has lost its digits to its stretch limit, (members,); 0 where it has none."""
    from gelcone.motion.engine.backend import smallest_step as of_members

    return of_members(members)


def integrate(
    model: Ensemble,
    initial: npt.ArrayLike,
    times: npt.ArrayLike,
    *,
    start: npt.ArrayLike = 0.0,
    keep: Keep = "states",
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Trajectories:
    """Integrate all members of a flattened ensemble, sampled at given times.

    Parameters
    ----------
    model : the ensemble, flattened in C order to its members.
    initial : the states at ``start``, shape (N,) or (members, N): displacement, velocity and the states that components
        add. With displacement and velocity alone the others begin at their components' defaults.
    times : increasing sample times from ``start`` on, shape (samples,) or (members, samples).
    start : time at the initial state (sets the phase of the drive), scalar or (members,). Default 0.
    keep : ``"states"``; ``"tangents"`` adds the tangent maps, ``"work"`` the integrals of the powers.
    tolerance : relative error of one step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    `Trajectories`: ``states`` (members, samples, states), NaN from where a member failed, its ``outcome``, and the
    ``tangents`` or ``work`` asked for.

    Raises
    ------
    InputError : for times that do not increase, shapes that do not fit, or options that cannot be used.
    MissingDependency : when the integrator is not installed.

    Examples
    --------
    >>> import gelcone
    >>> run = gelcone.integrate(gelcone.ConeModel(), (1.0, 0.0), [0.0, 5.0, 10.0])
    >>> run.states.shape, run.states[0, -1].round(6).tolist()
    ((1, 3, 2), [0.199411, -0.80577])
    """
    check_model(model, "integrate")
    members = model.members()
    check_name("thing to keep", keep, KEEPS)
    check_flow(tolerance, threads)
    states0 = _states("initial", initial, members)
    t0 = _fit("start", start, (members.size,))
    samples = np.size(times) if np.ndim(times) < 2 else np.shape(times)[-1]
    sample_times = _fit("times", times, (members.size, samples))
    if not (sample_times.size and np.isfinite(sample_times).all() and np.isfinite(t0).all()):
        raise InputError("times: must be at least one and, like the start, finite")
    gaps = np.diff(sample_times, axis=1, prepend=t0[:, None])
    if not ((gaps[:, :1] >= 0.0).all() and (gaps[:, 1:] > 0.0).all()):
        raise InputError("times: must increase and not be before the start; sort them and leave out doubles")
    with np.errstate(over="ignore", invalid="ignore"):
        outside = ~(members.strain(states0[:, 0]) < members.strain_limit())
        if not members.system.planar:
            outside |= members.system.overstretched(list(states0.T), members.numbers())
    outcome = np.where(outside, Outcome.OUTSIDE, Outcome.OK).astype(np.int8)
    outcome[np.isnan(states0).any(axis=1) | np.isinf(states0[:, 1:]).any(axis=1)] = Outcome.NOT_FINITE
    result = Trajectories.blank(sample_times, members.system, keep, outcome)
    runs = outcome == Outcome.OK
    _store_start(result, states0, runs & (gaps[:, 0] == 0.0))
    job = Job(members, runs, states0, t0, sample_times, gaps, keep, tolerance, result)
    watch, count = current_watch(), threads or available_threads()
    backend().run(job, threads=count, progress=progress, watch=watch)
    end_films(job, lambda more: backend().run(more, threads=count, progress=None, watch=watch))
    if watch is not None:
        watch.steps += int(result.steps.sum())
    return result


def check_flow(tolerance: float, threads: int | None) -> None:
    """Raises `InputError` for a tolerance or a number of threads that the integrator cannot use."""
    if not (isinstance(tolerance, float | int) and 0.0 < tolerance < 1.0):
        raise InputError(
            f"tolerance = {tolerance!r}: must be a number above 0 and below 1, for example {DEFAULT_TOLERANCE:g}"
        )
    if threads is not None:
        check_count("threads", threads, 1, ALL_CORES)


def _states(name: str, value: npt.ArrayLike, members: Members) -> Array:
    """States (members, N), which may be given as displacement and velocity alone."""
    count = len(members.system.states)
    if count > 2 and np.shape(value)[-1:] == (2,):
        return members.start_states(_fit(name, value, (members.size, 2)))
    return _fit(name, value, (members.size, count))


def _fit(name: str, value: npt.ArrayLike, shape: tuple[int, ...]) -> Array:
    """``value`` broadcast to ``shape`` except for the last axis of several; raises `InputError` where it does not
    fit."""
    try:
        array = np.asarray(value, dtype=float)
        if len(shape) > 1 and np.atleast_1d(array).shape[-1] != shape[-1]:
            raise ValueError
        return spread(array, shape)
    except (TypeError, ValueError):
        wanted = " or ".join(dict.fromkeys(str(s) for s in (shape[1:], shape)))
        raise InputError(f"{name}: must be numbers of shape {wanted}, not {np.shape(value)}") from None


def _store_start(result: Trajectories, states0: Array, members: npt.NDArray[np.bool_]) -> None:
    """The first sample of members that are sampled at their start."""
    result.states[members, 0] = states0[members]
    unit = np.eye(states0.shape[1])
    for kept, value in ((result.tangents, unit), (result.divergence, 0.0), (result.work, 0.0)):
        if kept is not None:
            kept[members, 0] = value


def available_threads() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def portable(system: ConeSystem, outputs: Outputs, tolerance: float) -> Portable:
    """The program of a system as text for another language; see `Portable`."""
    from gelcone.motion.engine import portable as engine

    return engine.portable(system, outputs, tolerance)


def steps(system: DrivenSystem, tolerance: float, members: int, most_steps: float) -> Steps:
    """Many motions under inputs that are set between steps; see `Steps`."""
    from gelcone.motion.engine import steps as engine

    return engine.Steps(system, tolerance, members, most_steps)


def formulas_text(name: str, leaves: Sequence[str], nodes: Mapping[int, Node]) -> str:
    """Formulas of numbers as text for another language."""
    from gelcone.motion.engine import portable as engine

    return engine.formulas_text(name, leaves, nodes)
