"""The engine in the place of an integrator: jobs of gelcone run by compiled programs."""

from __future__ import annotations

import threading
from functools import lru_cache

import numpy as np

from gelcone.codes import CALL_SPAN, STEPS_PER_CALL, Outcome
from gelcone.motion.engine.program import ARRIVED, NOT_FINITE, TOO_MANY_STEPS, Program, Raw
from gelcone.motion.job import Job, Keep
from gelcone.physics.system import ConeSystem
from gelcone.progress import Progress, Stopped, Watch

SMALLEST_STEP = 2e-8
"""A shorter step means that the film came so close to its stretch limit that the distance, and with it the force, is
lost to rounding (measured by ``benchmarks/robustness.py``). It shrinks with the time scale of very stiff members."""
MOST_PROGRAMS = 64

_lock = threading.Lock()


class EngineBackend:
    """Integrates jobs with compiled Taylor programs; see `gelcone.motion.job.Backend`."""

    def run(self, job: Job, *, threads: int, progress: Progress, watch: Watch | None) -> None:
        run = np.flatnonzero(job.runs)
        if not run.size:
            return
        members = job.members.take(run)
        limit = np.broadcast_to(members.strain_limit(), members.shape)
        smallest = np.where(np.isinf(limit), 0.0, SMALLEST_STEP * np.minimum(1.0, 10.0 / members.rate))
        calls = np.maximum(np.ceil(job.gaps[run].sum(axis=1) * members.rate / CALL_SPAN), 1.0)
        with _lock:
            program = _program(members.system, job.keep, job.tolerance)
        raw = program.run(
            {name: members.number(name) for name in members.system.numbers},
            job.states0[run],
            job.start[run],
            job.times[run],
            smallest_step=smallest,
            most_steps=int(STEPS_PER_CALL * calls.max()),
            threads=threads,
            report=progress,
            stopped=None if watch is None else watch.stop.is_set,
        )
        if watch is not None and watch.stop.is_set():
            raise Stopped
        _store(job, run, raw, limit)


@lru_cache(maxsize=MOST_PROGRAMS)
def _program(system: ConeSystem, keep: Keep, tolerance: float) -> Program:
    return Program(system, keep, tolerance)


def _store(job: Job, run: np.ndarray, raw: Raw, limit: np.ndarray) -> None:
    """Takes over what the members reached, and says how those ended that did not arrive."""
    result, film = job.result, job.members.system.film
    members = job.members.take(run)
    with np.errstate(all="ignore"):
        beyond = members.strain(raw.states[..., 0]) >= limit[:, None]
    crossed = beyond.any(axis=1)
    wall = film.ending
    far = raw.smallest_step >= np.where(np.isinf(limit), 0.0, 0.0)
    outcome = np.where(raw.status == ARRIVED, Outcome.OK, wall)
    unbounded = np.isinf(limit) & (film.ending == Outcome.STRETCH_LIMIT)
    outcome[(raw.status == NOT_FINITE) & unbounded] = Outcome.NOT_FINITE
    outcome[raw.status == TOO_MANY_STEPS] = Outcome.STEP_LIMIT
    outcome[crossed] = wall
    result.outcome[run] = outcome
    result.steps[run] = raw.steps
    kept = ~np.logical_or.accumulate(beyond, axis=1)
    for into, values in ((result.states, raw.states), (result.tangents, raw.tangents), (result.work, raw.work)):
        if into is not None and values is not None:
            shape = kept.shape + (1,) * (values.ndim - 2)
            into[run] = np.where(kept.reshape(shape), values, np.nan)
