"""The back end that compiles with heyoka, and the only file that imports it.

The equation of motion becomes a Taylor integrator over batches of `LANES` members. A member's numbers do not depend on
its neighbours in a batch, on the number of threads or on the order of the work, so that an ensemble equals its members
one by one to the last bit.
"""

from __future__ import annotations

import copy
import queue
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt
from heyoka_batches import Batch, batches, run_batches, stretches

from gelcone.codes import STEPS_PER_CALL, Outcome
from gelcone.errors import MissingDependency
from gelcone.motion.job import Job, Keep
from gelcone.physics.system import ConeSystem
from gelcone.progress import Progress, Watch
from gelcone.quantity import Array

LANES = 8
DISK_CACHE_BYTES = 512 * 2**20
SMALLEST_STEP = 2e-8
"""A shorter step means that the film came so close to its stretch limit that the distance, and with it the force, is
lost to rounding (measured by ``benchmarks/robustness.py``). It shrinks with the time scale of very stiff members."""


class HeyokaBackend:
    """Integrates jobs with heyoka; see `gelcone.motion.job.Backend`."""

    def run(self, job: Job, *, threads: int, progress: Progress, watch: Watch | None) -> None:
        integrators = _Integrators(job.members.system, job.keep, job.tolerance)
        ensemble = _Ensemble.of(job)

        def advance(batch: Batch) -> Iterator[float]:
            integrator = integrators.borrow()
            try:
                yield from _advance(ensemble, batch, integrator)
            finally:
                integrators.give_back(integrator)

        plans = list(batches(job, LANES))
        run_batches(plans, advance, threads=threads, progress=progress, watch=watch)


def import_heyoka() -> Any:
    """The heyoka module; `MissingDependency` with the way to install it if it is missing."""
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


# --- the compiled programs ---------------------------------------------------------------------------------------


def functions() -> SimpleNamespace:
    """heyoka's functions under the names that formulas use."""
    hk = import_heyoka()
    return SimpleNamespace(
        sin=hk.sin, cos=hk.cos, exp=hk.exp, log=hk.log, log1p=lambda z: hk.log(1.0 + z), sqrt=hk.sqrt
    )


def equations(system: ConeSystem, keep: Keep) -> list[tuple[Any, Any]]:
    """The equations that are compiled, as heyoka (variable, derivative) pairs.

    ``"tangents"`` adds the columns of the tangent map, which share the film's division with the motion and so cost half
    of what a general variational system does; ``"work"`` adds the quadratures of the system's two powers.
    """
    hk, xp = import_heyoka(), functions()
    n = {name: hk.par[i] for i, name in enumerate(system.numbers)}
    names = [state.name for state in system.states]
    z = list(hk.make_vars(*names))
    rates = system.rates(hk.time, z, n, xp)
    equations = list(zip(z, rates, strict=True))
    if keep == "tangents":
        every = [hk.expression(rate) if isinstance(rate, float) else rate for rate in rates]
        jacobian = system.flow(hk.time, z, n, xp)[1] if system.planar else [[hk.diff(r, v) for v in z] for r in every]
        for column in range(len(z)):
            deviation = list(hk.make_vars(*(f"{name}_{column}" for name in names)))
            equations += [(one, _product(row, deviation)) for one, row in zip(deviation, jacobian, strict=True)]
    elif keep == "work":
        quadratures = hk.make_vars("film_work", "dissipated")
        equations += zip(quadratures, system.powers(hk.time, z, n, xp), strict=True)
    return equations


def _product(row: list[Any], deviation: list[Any]) -> Any:
    """A row of the Jacobian times a deviation, without the terms that are 0."""
    terms = [
        d if isinstance(slope, float) and slope == 1.0 else slope * d
        for slope, d in zip(row, deviation, strict=True)
        if not (isinstance(slope, float) and slope == 0.0)
    ]
    return sum(terms[1:], terms[0]) if terms else import_heyoka().expression(0.0)


@cache
def _template(system: ConeSystem, keep: Keep, tolerance: float) -> Any:
    hk = import_heyoka()
    compiled = equations(system, keep)
    return hk.taylor_adaptive_batch(compiled, np.zeros((len(compiled), LANES)), tol=tolerance)


class _Integrators:
    """Integrators of one program, each lent to one thread at a time (two threads on one give wrong numbers)."""

    _lock = threading.Lock()
    _idle: dict[Any, queue.SimpleQueue[Any]] = {}

    def __init__(self, system: ConeSystem, keep: Keep, tolerance: float):
        self._key = (system, keep, tolerance)
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


# --- one batch in the lanes of one integrator ------------------------------------------------------------------------


@dataclass(frozen=True)
class _Ensemble:
    """A job with what its lanes need of all members: their numbers (numbers, members), the limits of their strains and
    the steps below which their digits are lost, (members,)."""

    job: Job
    rows: Array
    limit: Array
    smallest_step: Array

    @classmethod
    def of(cls, job: Job) -> _Ensemble:
        members = job.members
        rows = np.stack([members.number(name) for name in members.system.numbers])
        limit = np.broadcast_to(members.strain_limit(), members.shape)
        smallest_step = SMALLEST_STEP * np.minimum(1.0, 10.0 / members.rate)
        return cls(job, rows, limit, np.where(np.isinf(limit), 0.0, smallest_step))


def _advance(ensemble: _Ensemble, batch: Batch, integrator: Any) -> Iterator[float]:
    """Runs one batch to the end, yielding the share done after each call."""
    job, lanes = ensemble.job, _Lanes(ensemble, batch.members, integrator)
    reached = job.start[lanes.padded]
    times, samples = stretches(job, lanes.padded, batch.pieces)
    for first in range(0, len(samples), batch.call):
        part = slice(first, first + batch.call)
        values = lanes.propagate(np.concatenate([reached[None], times[part]]), samples[part])
        kept = samples[part] >= 0
        lanes.store(samples[part][kept], values[kept])
        reached = times[part][-1]
        yield len(values) / len(samples)


_Advance = tuple[Array, list[tuple[float, ...]], list[tuple[int, ...]], dict[int, Outcome]]
"""States at the ends of the stretches; smallest step and number of steps of each lane in each call of the integrator;
lanes that did not arrive, and why."""


class _Lanes:
    """The members of one batch in the lanes of one integrator, with what becomes of each."""

    def __init__(self, ensemble: _Ensemble, members: npt.NDArray[np.intp], integrator: Any):
        job = ensemble.job
        self.job, self.members, self.integrator = job, members, integrator
        self.system = job.members.system
        self.count = len(self.system.states)
        self.identity = np.eye(self.count).reshape(-1, 1)
        self.padded = np.concatenate([members, np.full(LANES - members.size, members[-1])])
        self.alive = np.ones(members.size, dtype=bool)
        self.rows = ensemble.rows[:, self.padded]
        self.limit, self.smallest_step = ensemble.limit[members], ensemble.smallest_step[self.padded]
        self.outcomes = import_heyoka().taylor_outcome
        self.arrived = (self.outcomes.time_limit,) * LANES
        integrator.set_time(job.start[self.padded])
        integrator.pars[:] = self.rows
        integrator.state[:] = 0.0
        integrator.state[: self.count] = job.states0[self.padded].T
        if job.keep == "tangents":
            self._restart_tangents()

    def _restart_tangents(self) -> None:
        self.integrator.state[self.count :] = self.identity

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

    @property
    def _ends_in_a_state(self) -> bool:
        """Whether the film's end is a state, not a loss of digits: what was reached before it counts."""
        return self.system.film.ending != Outcome.STRETCH_LIMIT

    def _keep_reached(self, lane: int, samples: npt.NDArray[np.int64], values: Array) -> None:
        """Keeps the samples before the film's end."""
        if not (self._ends_in_a_state and lane < self.members.size and self.alive[lane]):
            return
        result, member = self.job.result, self.members[lane]
        own = dict(zip(self.system.numbers, self.rows[:, lane], strict=True))
        inside = self.system.film.strain(values[:, 0], own) < self.limit[lane]
        reached = (samples >= 0) & np.isfinite(values).all(axis=1) & inside
        result.states[member, samples[reached]] = values[reached, : self.count]
        if result.work is not None:
            result.work[member, samples[reached]] = values[reached, self.count :]

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
                self._restart_tangents()
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
        """The reason why a lane did not arrive, judged by the lane alone: one lane's failure is reported for all."""
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
        """Puts a member at rest into the lane of one that failed."""
        self.integrator.pars[:, lane] = _resting(self.system)
        self.integrator.state[:, lane] = 0.0
        if lane < self.members.size and self.alive[lane]:
            self.alive[lane] = False
            if self._ends_in_a_state and outcome != Outcome.STEP_LIMIT:
                outcome = self.system.film.ending
            self.job.result.outcome[self.members[lane]] = outcome

    def store(self, samples: npt.NDArray[np.int64], values: Array) -> None:
        """Keeps the samples of the members that are alive and inside; ``values`` (samples, variables, lanes)."""
        values = np.moveaxis(values, 2, 0)[: self.members.size]
        n = dict(zip(self.system.numbers, self.rows[:, : self.members.size, None], strict=True))
        beyond = np.asarray(self.system.film.strain(values[:, :, 0], n)) >= self.limit[:, None]
        for lane in np.flatnonzero(self.alive & beyond.any(axis=1)) if beyond.any() else ():
            self._retire(int(lane), Outcome.STRETCH_LIMIT)
        members = self.members
        if not self.alive.all():
            members, values = members[self.alive], values[self.alive]
        result, kept, count = self.job.result, (members[:, None], samples), self.count
        result.states[kept] = values[:, :, :count]
        if result.tangents is not None:
            result.tangents[kept] = values[:, :, count:].reshape(*values.shape[:2], count, count).swapaxes(-1, -2)
        if result.work is not None:
            result.work[kept] = values[:, :, count:]


@cache
def _resting(system: ConeSystem) -> Array:
    """The numbers of a member that rests: the defaults, without voltage."""
    n = system.numbers_of(system.complete({"voltage": 0.0}))
    return np.array([n[name] for name in system.numbers], dtype=float)
