"""Compiled ensembles of trajectories: the only file that knows the integrator.

The equation of motion is compiled by heyoka into a Taylor integrator over batches of `LANES` members. A member's
numbers do not depend on its neighbours in a batch, on the number of threads or on the order of the work, so that an
ensemble equals its members one by one to the last bit.
"""

from __future__ import annotations

import copy
import os
import queue
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from gelcone.codes import CALL_SPAN, STEPS_PER_CALL, Outcome
from gelcone.errors import InputError, MissingDependency, unknown_name
from gelcone.physics import drive
from gelcone.physics.model import Body, Coefficients, ConeModel, acceleration, electric_force, strain
from gelcone.progress import Stopped, Watch, _watched
from gelcone.quantity import Array

LANES = 8
DEFAULT_TOLERANCE = 1e-15
DISK_CACHE_BYTES = 512 * 2**20
SMALLEST_STEP = 2e-8
"""A shorter step means that the film came so close to its stretch limit that the distance, and with it the force, is
lost to rounding (measured by ``benchmarks/robustness.py``). It shrinks with the time scale of very stiff members."""

Keep = Literal["states", "tangents", "work"]
KEEPS: tuple[Keep, ...] = get_args(Keep)


@dataclass(frozen=True)
class Trajectories:
    """Samples of every member; NaN from where a member failed.

    ``times`` (members, samples); ``states`` (members, samples, 2) with displacement and velocity; ``tangents``
    (members, samples, 2, 2), each the linear map of a small deviation from the previous sample (the first from the
    start) to this one; ``work`` (members, samples, 2) with the work of the electric force and the energy dissipated
    since the start; ``outcome`` and ``steps`` (members,).
    """

    times: Array
    states: Array
    tangents: Array | None
    work: Array | None
    outcome: npt.NDArray[np.int8]
    steps: npt.NDArray[np.int64]


def integrate(
    model: ConeModel,
    initial: npt.ArrayLike,
    times: npt.ArrayLike,
    *,
    start: npt.ArrayLike = 0.0,
    keep: Keep = "states",
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Trajectories:
    """Trajectories of all members of a flattened ensemble, sampled at given times.

    Parameters
    ----------
    model : the ensemble, flattened in C order to its members.
    initial : displacement and velocity at ``start``, shape (2,) or (members, 2).
    times : increasing sample times from ``start`` on, shape (samples,) or (members, samples).
    start : time at the initial state (sets the phase of the drive), scalar or (members,). Default 0.
    keep : ``"states"``; ``"tangents"`` adds the tangent maps, ``"work"`` electric work and dissipation.
    tolerance : relative error of one step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Raises
    ------
    InputError : for times that do not increase, shapes that do not fit, or options that cannot be used.
    MissingDependency : when heyoka is not installed.
    """
    count = model.size
    _check_options(keep, tolerance, threads)
    states0 = _fit("initial", initial, (count, 2))
    t0 = _fit("start", start, (count,))
    sample_times = _fit("times", times, (count, np.size(times) if np.ndim(times) < 2 else np.shape(times)[-1]))
    if not (sample_times.size and np.isfinite(sample_times).all() and np.isfinite(t0).all()):
        raise InputError("times: must be at least one and, like the start, finite")
    gaps = np.diff(sample_times, axis=1, prepend=t0[:, None])
    if not ((gaps[:, :1] >= 0.0).all() and (gaps[:, 1:] > 0.0).all()):
        raise InputError("times: must increase and not be before the start; sort them and leave out doubles")

    parameters = _runtime_parameters(model)
    limit = np.broadcast_to(model.strain_limit(), model.shape).ravel()
    with np.errstate(over="ignore", invalid="ignore"):
        outside = ~(model.take(slice(None)).strain(states0[:, 0]) < limit)
    outcome = np.where(outside, Outcome.OUTSIDE, Outcome.OK).astype(np.int8)
    outcome[np.isnan(states0).any(axis=1) | np.isinf(states0[:, 1])] = Outcome.NOT_FINITE
    runs = outcome == Outcome.OK
    job = _Job(
        parameters=parameters,
        states0=states0,
        start=t0,
        times=sample_times,
        keep=keep,
        fitted=model.film is not None,
        limit=limit,
        time_scale=1.0 / np.sqrt(1.0 + _stiffness(parameters)),
        integrators=_Integrators(model.body, keep, tolerance, len(parameters)),
        result=Trajectories(
            times=sample_times,
            states=np.full((count, sample_times.shape[1], 2), np.nan),
            tangents=np.full((count, sample_times.shape[1], 2, 2), np.nan) if keep == "tangents" else None,
            work=np.full((count, sample_times.shape[1], 2), np.nan) if keep == "work" else None,
            outcome=outcome,
            steps=np.zeros(count, dtype=np.int64),
        ),
    )
    _store_start(job, runs & (gaps[:, 0] == 0.0))
    batches = list(_batches(job, gaps, np.flatnonzero(runs)))
    watch = getattr(_watched, "watch", None)
    _run(job, batches, threads or available_threads(), progress, watch)
    if watch is not None:
        watch.steps += int(job.result.steps.sum())
    return job.result


def _check_options(keep: str, tolerance: float, threads: int | None) -> None:
    if keep not in KEEPS:
        raise unknown_name("thing to keep", str(keep), KEEPS)
    if not (isinstance(tolerance, float | int) and 0.0 < tolerance < 1.0):
        raise InputError(f"tolerance = {tolerance!r}: must be between 0 and 1, for example {DEFAULT_TOLERANCE:g}")
    if threads is not None and not (isinstance(threads, int) and threads >= 1):
        raise InputError(f"threads = {threads!r}: must be at least 1; leave it out to use all cores")


def _fit(name: str, value: npt.ArrayLike, shape: tuple[int, ...]) -> Array:
    """``value`` spread to ``shape``, of which the last axis is not spread; `InputError` when it does not fit."""
    try:
        array = np.asarray(value, dtype=float)
        if len(shape) > 1 and np.atleast_1d(array).shape[-1] != shape[-1]:
            raise ValueError
        return np.broadcast_to(array, shape)
    except (TypeError, ValueError):
        wanted = " or ".join(dict.fromkeys(str(s) for s in (shape[1:], shape)))
        raise InputError(f"{name}: must be numbers of shape {wanted}, not {np.shape(value)}") from None


def available_threads() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


# --- the compiled programs ---------------------------------------------------------------------------------------


def import_heyoka() -> Any:
    """The heyoka module; `MissingDependency` with the way to get it when it is absent."""
    try:
        import heyoka
    except ImportError:
        raise MissingDependency(
            "heyoka is not installed: on Linux `pip install heyoka`; on macOS and Windows its builds are on "
            "conda-forge: `conda install -c conda-forge heyoka.py`"
        ) from None
    _set_up(heyoka)
    return heyoka


@cache
def _set_up(heyoka: Any) -> None:
    try:
        heyoka.llvm_state.set_diskcache_limit(DISK_CACHE_BYTES)
    except (RuntimeError, ValueError):  # no folder for the cache, as in a container without a home: compile each time
        heyoka.llvm_state.set_diskcache_enabled(False)


def equations(body: Body, keep: Keep, law_size: int) -> list[tuple[Any, Any]]:
    """The system that is compiled, as heyoka (variable, derivative) pairs.

    ``"tangents"`` adds two deviations (the columns of the tangent map), which share the film's division with the
    motion and so cost half of what a general variational system does; ``"work"`` adds the quadratures of the power
    v^2 x x' of the electric force (in a continuum film: of what the voltage takes from the film's force) and of the
    dissipated power 2 zeta x'^2.
    """
    hk = import_heyoka()
    par = hk.par
    zeta, kappa, rest, A, B, G, amplitude, bias, frequency = (par[i] for i in range(9))
    c = Coefficients(zeta, kappa, rest, A, B, G, tuple(par[9 + i] for i in range(law_size)))
    x, u = hk.make_vars("x", "u")
    voltage = drive.voltage(hk.time, amplitude, bias, frequency, hk)
    rate, slope = acceleration(x, u, voltage, c, body)
    system = [(x, u), (u, rate)]
    if keep == "tangents":
        for column in "12":
            dx, du = hk.make_vars(f"x{column}", f"u{column}")
            system += [(dx, du), (du, slope * dx - 2.0 * c.zeta * du)]
    elif keep == "work":
        worked, dissipated = hk.make_vars("worked", "dissipated")
        system += [(worked, electric_force(x, voltage, c, body) * u), (dissipated, 2.0 * c.zeta * u * u)]
    return system


def _runtime_parameters(model: ConeModel) -> Array:
    """The numbers of all members in the order in which `equations` reads them, shape (parameters, members)."""
    c = model.coefficients()
    law = c.law if model.film is None else ()
    rows = [*c[:-1], model.voltage, model.voltage_bias, model.drive_frequency, *law]
    return np.stack([np.broadcast_to(row, model.shape).ravel() for row in rows])


_BENIGN = np.array([0.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0])
"""A member at rest that takes the lane of one that failed."""


@cache
def _template(body: Body, keep: Keep, tolerance: float, law_size: int) -> Any:
    hk = import_heyoka()
    system = equations(body, keep, law_size)
    return hk.taylor_adaptive_batch(system, np.zeros((len(system), LANES)), tol=tolerance)


class _Integrators:
    """Integrators of one program, each lent to one thread at a time (two threads on one give wrong numbers)."""

    _lock = threading.Lock()
    _idle: dict[Any, queue.SimpleQueue[Any]] = {}

    def __init__(self, body: Body, keep: Keep, tolerance: float, parameters: int):
        self._key = (body, keep, tolerance, parameters - len(_BENIGN))
        with self._lock:
            self._queue = self._idle.setdefault(self._key, queue.SimpleQueue())

    def borrow(self) -> Any:
        try:
            return self._queue.get_nowait()
        except queue.Empty:
            with self._lock:
                return copy.deepcopy(_template(*self._key))

    def give_back(self, integrator: Any) -> None:
        self._queue.put(integrator)


# --- batches over threads ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Job:
    parameters: Array
    states0: Array
    start: Array
    times: Array
    keep: Keep
    fitted: bool
    limit: Array
    time_scale: Array
    integrators: _Integrators
    result: Trajectories


@dataclass(frozen=True)
class _Batch:
    """Up to `LANES` members that are advanced alike.

    ``pieces`` (samples,) says into how many stretches each gap between samples is cut (none for a first sample at the
    start); ``call`` how many stretches go into one call.
    """

    members: npt.NDArray[np.intp]
    pieces: npt.NDArray[np.int64]
    call: int


def _store_start(job: _Job, members: npt.NDArray[np.bool_]) -> None:
    """The first sample of members that are sampled at their start."""
    job.result.states[members, 0] = job.states0[members]
    if job.result.tangents is not None:
        job.result.tangents[members, 0] = np.eye(2)
    if job.result.work is not None:
        job.result.work[members, 0] = 0.0


def _stiffness(parameters: Array) -> Array:
    """A bound of the stiffness of spring, film at rest and field: how fast the members move."""
    return parameters[1] + parameters[3] + (parameters[6] + np.abs(parameters[7])) ** 2


def _batches(job: _Job, gaps: Array, members: npt.NDArray[np.intp]) -> Iterator[_Batch]:
    """Batches of members with the same plan of calls: a plan depends on the member alone, so its numbers do too.

    Pieces and calls are powers of 2, so that there are few plans and the batches are full.
    """
    span, samples = CALL_SPAN * job.time_scale, gaps.shape[1]
    widest = np.maximum(gaps.max(axis=1), 1e-12)
    most = min(2.0 ** np.ceil(np.log2(samples)), 4096.0)
    call = 2 ** np.floor(np.log2(np.clip(span / widest, 1.0, most))).astype(int)
    pieces = np.where(gaps > 0.0, 2 ** np.ceil(np.log2(np.maximum(gaps / span[:, None], 1.0))).astype(np.int64), 0)
    plans: dict[tuple[int, bytes], list[int]] = {}
    for member in members[np.argsort((gaps.sum(axis=1) / span)[members], kind="stable")].tolist():
        plans.setdefault((int(call[member]), pieces[member].tobytes()), []).append(member)
    for (call_size, pieces_bytes), plan in plans.items():
        for first in range(0, len(plan), LANES):
            yield _Batch(np.array(plan[first : first + LANES]), np.frombuffer(pieces_bytes, dtype=np.int64), call_size)


def _run(
    job: _Job, batches: list[_Batch], threads: int, progress: Callable[[float], None] | None, watch: Watch | None
) -> None:
    stop = threading.Event()
    lock = threading.Lock()

    def report(share: float) -> None:
        if progress is not None:
            with lock:
                progress(share / len(batches))

    def work(batch: _Batch) -> None:
        if stop.is_set():
            return
        integrator = job.integrators.borrow()
        for share in _advance(job, batch, integrator):
            if stop.is_set():
                return
            if watch is not None and watch.stop.is_set():
                raise Stopped
            report(share)
        job.integrators.give_back(integrator)

    if threads == 1 or len(batches) == 1:
        for batch in batches:
            work(batch)
        return
    with ThreadPoolExecutor(threads) as executor:
        futures = [executor.submit(work, batch) for batch in batches]
        try:
            for future in as_completed(futures):
                future.result()
        except BaseException:
            stop.set()
            executor.shutdown(wait=True, cancel_futures=True)
            raise


def _advance(job: _Job, batch: _Batch, integrator: Any) -> Iterator[float]:
    """Runs one batch to the end, yielding the share done after each call."""
    lanes = _Lanes(job, batch.members, integrator)
    reached = job.start[lanes.padded]
    times, samples = _stretches(job, lanes.padded, batch.pieces)
    for first in range(0, len(samples), batch.call):
        part = slice(first, first + batch.call)
        values = lanes.propagate(np.concatenate([reached[None], times[part]]), samples[part])
        kept = samples[part] >= 0
        lanes.store(samples[part][kept], values[kept])
        reached = times[part][-1]
        yield len(values) / len(samples)


def _stretches(
    job: _Job, members: npt.NDArray[np.intp], pieces: npt.NDArray[np.int64]
) -> tuple[Array, npt.NDArray[np.int64]]:
    """Where each of a batch's stretches ends, shape (stretches, members), and the sample that it gives, or -1."""
    ends = np.concatenate([job.start[members][None], job.times[members].T])
    samples = np.repeat(np.arange(pieces.size), pieces)
    left = np.cumsum(pieces)[samples] - np.arange(1, samples.size + 1)
    share = (1.0 - left / pieces[samples])[:, None]
    between = ends[samples] + (ends[samples + 1] - ends[samples]) * share
    return np.where(share == 1.0, ends[samples + 1], between), np.where(left == 0, samples, -1)


_IDENTITY = np.array([[1.0], [0.0], [0.0], [1.0]])


_Advance = tuple[Array, list[tuple[float, ...]], list[tuple[int, ...]], dict[int, Outcome]]
"""States at the ends of the stretches; smallest step and number of steps of each lane in each call of the integrator;
lanes that did not arrive, and why."""


class _Lanes:
    """The members of one batch in the lanes of one integrator, with what becomes of each."""

    def __init__(self, job: _Job, members: npt.NDArray[np.intp], integrator: Any):
        self.job, self.members, self.integrator = job, members, integrator
        self.padded = np.concatenate([members, np.full(LANES - members.size, members[-1])])
        self.alive = np.ones(members.size, dtype=bool)
        self.smallest_step = SMALLEST_STEP * np.minimum(1.0, 10.0 * job.time_scale[self.padded])
        self.smallest_step[np.isinf(job.limit[self.padded])] = 0.0
        self.outcomes = import_heyoka().taylor_outcome
        self.arrived = (self.outcomes.time_limit,) * LANES
        integrator.set_time(job.start[self.padded])
        integrator.pars[:] = job.parameters[:, self.padded]
        integrator.state[:] = 0.0
        integrator.state[:2] = job.states0[self.padded].T
        if job.keep == "tangents":
            integrator.state[2:] = _IDENTITY

    def propagate(self, times: Array, samples: npt.NDArray[np.int64]) -> Array:
        """States at ``times[1:]``, shape (stretches, variables, lanes), starting from ``times[0]``.

        A lane that does not arrive stops its neighbours, too; it is put to rest and the call is made again.
        """
        advance = self._stop_at_each if self.job.keep == "tangents" else self._read_grid
        while True:
            state = self.integrator.state.copy()
            clock = [part.copy() for part in self.integrator.dtime]
            values, smallest, steps, failed = advance(times, samples)
            if not failed:
                self._count_steps(np.array(smallest) < self.smallest_step, np.array(steps))
                return values
            for lane, outcome in failed.items():
                self._keep_reached(lane, samples, values[:, :, lane])
                self._retire(lane, outcome)
                state[:, lane] = self.integrator.state[:, lane]
            self.integrator.state[:] = state
            self.integrator.set_dtime(*clock)

    def _keep_reached(self, lane: int, samples: npt.NDArray[np.int64], values: Array) -> None:
        """The samples that a continuum film gave before it pulled in: its end is a state, not a loss of digits."""
        if not (self.job.fitted and lane < self.members.size and self.alive[lane]):
            return
        result, member = self.job.result, self.members[lane]
        inside = values[:, 0] ** 2 < self.job.limit[member]
        reached = (samples >= 0) & np.isfinite(values).all(axis=1) & inside
        result.states[member, samples[reached]] = values[reached, :2]
        if result.work is not None:
            result.work[member, samples[reached]] = values[reached, 2:]

    def _read_grid(self, times: Array, samples: npt.NDArray[np.int64]) -> _Advance:
        values = self.integrator.propagate_grid(times, max_steps=STEPS_PER_CALL)[-1][1:]
        smallest, steps, failed = self._report()
        return values, [smallest], [steps], failed

    def _stop_at_each(self, times: Array, samples: npt.NDArray[np.int64]) -> _Advance:
        integrator, state = self.integrator, self.integrator.state
        values = np.full((len(samples), *state.shape), np.nan)
        failed: dict[int, Outcome] = {}
        smallest, steps = [], []
        for k, sample in enumerate(samples.tolist()):
            integrator.propagate_until(times[k + 1], max_steps=STEPS_PER_CALL)
            values[k] = state
            least, count, failed = self._report()
            smallest.append(least)
            steps.append(count)
            if failed:
                break
            if sample >= 0:
                state[2:] = _IDENTITY
        return values, smallest, steps, failed

    def _report(self) -> tuple[tuple[float, ...], tuple[int, ...], dict[int, Outcome]]:
        """Smallest step and number of steps of each lane in the last call; lanes that did not arrive, and why."""
        report = self.integrator.propagate_res
        ends, smallest, _, steps = zip(*report, strict=True)
        if ends == self.arrived and max(steps) < STEPS_PER_CALL:
            return smallest, steps, {}
        failed = {lane: self._failure(lane, each) for lane, each in enumerate(report)}
        return smallest, steps, {lane: outcome for lane, outcome in failed.items() if outcome}

    def _failure(self, lane: int, report: Any) -> Outcome:
        """Why a lane did not arrive; judged by the lane alone, since one lane's failure is reported for all."""
        end, smallest, _, steps = report
        if end == self.outcomes.err_nf_state:
            # only a bounded motion's deviations can overflow away from the wall
            far = self.job.keep == "tangents" and smallest >= self.smallest_step[lane]
            return Outcome.NOT_FINITE if far or self.smallest_step[lane] == 0.0 else Outcome.STRETCH_LIMIT
        return Outcome.STEP_LIMIT if steps >= STEPS_PER_CALL else Outcome.OK

    def _count_steps(self, lost: npt.NDArray[np.bool_], steps: npt.NDArray[np.int64]) -> None:
        """Adds up the ``steps`` (calls, lanes) of the members, and retires those whose digits were ``lost``."""
        some = lost.any()
        if some:  # what comes after the loss does not count
            steps = np.where(np.cumsum(lost, axis=0) - lost > 0, 0, steps)
        self.job.result.steps[self.members] += steps.sum(axis=0)[: self.members.size] * self.alive
        for lane in np.flatnonzero(lost.any(axis=0)) if some else ():
            self._retire(int(lane), Outcome.STRETCH_LIMIT)

    def _retire(self, lane: int, outcome: Outcome) -> None:
        self.integrator.pars[:, lane] = 0.0
        self.integrator.pars[: _BENIGN.size, lane] = _BENIGN
        self.integrator.state[:, lane] = 0.0
        if lane < self.members.size and self.alive[lane]:
            self.alive[lane] = False
            if self.job.fitted and outcome != Outcome.STEP_LIMIT:
                outcome = Outcome.PULLED_IN
            self.job.result.outcome[self.members[lane]] = outcome

    def _strains(self, x: Array) -> Array:
        """I1 - 3 at displacements (members, samples), or what a continuum film has in its place."""
        if self.job.fitted:
            return x * x
        zeta, kappa, rest, A, B, G = self.job.parameters[:6, self.members, None]
        return np.asarray(strain(x, Coefficients(zeta, kappa, rest, A, B, G, ())))

    def store(self, samples: npt.NDArray[np.int64], values: Array) -> None:
        """Keeps the samples of the members that are alive and inside; ``values`` (samples, variables, lanes)."""
        values = np.moveaxis(values, 2, 0)[: self.members.size]
        beyond = self._strains(values[:, :, 0]) >= self.job.limit[self.members, None]
        for lane in np.flatnonzero(self.alive & beyond.any(axis=1)) if beyond.any() else ():
            self._retire(int(lane), Outcome.STRETCH_LIMIT)
        members = self.members
        if not self.alive.all():
            members, values = members[self.alive], values[self.alive]
        result, kept = self.job.result, (members[:, None], samples)
        result.states[kept] = values[:, :, :2]
        if result.tangents is not None:
            result.tangents[kept] = values[:, :, 2:].reshape(*values.shape[:2], 2, 2).swapaxes(-1, -2)
        if result.work is not None:
            result.work[kept] = values[:, :, 2:]
