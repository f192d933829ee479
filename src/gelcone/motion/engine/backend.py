"""Back end of `gelcone.integrate`: runs jobs by compiled programs, and names the ends of their members."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from gelcone.codes import CALL_SPAN, STEPS_PER_CALL, FilmPullIn, Outcome
from gelcone.motion.engine.charges import voltage_turns
from gelcone.motion.engine.interruptions import border_events, corner_numbers, corner_times, switches_at
from gelcone.motion.engine.plan import ARRIVED, NOT_FINITE, STEP_TOO_SMALL, TERMINAL_EVENT, TOO_MANY_STEPS
from gelcone.motion.engine.program import Program, Raw
from gelcone.motion.job import Job, Keep, Trajectories
from gelcone.physics.members import Members
from gelcone.physics.system import ConeSystem
from gelcone.progress import Progress, Stopped, Watch, weighted
from gelcone.quantity import Array

SMALLEST_STEP = 2e-8
"""Least length of a step: in shorter ones the film is so close to its stretch limit that rounding takes the distance,
and with it the force (measured by ``benchmarks/robustness.py``). It shrinks with the time scale of stiff members."""
RUNAWAY = 1e-3
"""Factor of the least step for films with states and borders, whose steps shrink towards a runaway."""
AWAY = 0.9
"""Largest share of its stretch limit at which a film counts as away from it."""
MOST_CORNERS = 2**22
"""Most corners of the drive held at once, some 50 bytes each."""
MOST_PROGRAMS = 64
"""Most programs held in memory; others are on disk."""

_compiling = threading.Lock()


class EngineBackend:
    """Integrates jobs with the engine; see `gelcone.motion.job.Backend`."""

    def run(self, job: Job, *, threads: int, progress: Progress, watch: Watch | None) -> None:
        """Fill the result of the job; raises `Stopped` once ``watch`` is stopped."""
        run = np.flatnonzero(job.runs)
        if not run.size:
            return
        lengths = (job.times[run, -1] - job.start[run]) * job.members.rate[run]
        run = run[np.argsort(-lengths, kind="stable")]  # the longest first, so that lanes finish at about the same time
        for part in _held_at_once(job, run):
            self._run(job, part, threads, weighted(progress, part.size / run.size), watch)

    def _run(self, job: Job, run: npt.NDArray[np.intp], threads: int, progress: Progress, watch: Watch | None) -> None:
        """Fill the result of the members ``run`` of the job."""
        members = job.members.take(run)
        smallest = smallest_step(members)
        with _compiling:
            program = _program(members.system, job.keep, job.tolerance)
        system, states, start, times = members.system, job.states0[run], job.start[run], job.times[run]
        numbers = members.own_numbers
        switches = switches_at(system, start, states, numbers)
        if _pulled_in(job, run, switches):
            if (run := run[job.runs[run]]).size:
                self._run(job, run, threads, progress, watch)
            return
        raw = program.run(
            numbers | switches,
            states,
            start,
            times,
            smallest_step=smallest,
            most_steps=STEPS_PER_CALL
            * np.ceil(np.maximum(job.gaps[run].sum(axis=1) * members.fastest / CALL_SPAN, 1.0)),
            threads=threads,
            report=progress,
            **corner_times(system, start, times[:, -1], numbers),
            stopped=None if watch is None else watch.stop.is_set,
        )
        if watch is not None and watch.stop.is_set():
            raise Stopped
        _store(job, run, members, raw, smallest)


def _held_at_once(job: Job, run: npt.NDArray[np.intp]) -> list[npt.NDArray[np.intp]]:
    """Parts of the members ``run`` with at most `MOST_CORNERS` corners of the drive; members with more end at once."""
    if not job.members.system.waveform.pieced:
        return [run]
    members = job.members.take(run)
    corners = members.system.waveform.corner_count(job.start[run], job.times[run, -1], members.own_numbers)
    _end(job, run[corners > MOST_CORNERS], Outcome.STEP_LIMIT)
    run, corners = run[corners <= MOST_CORNERS], corners[corners <= MOST_CORNERS]
    size = max(1, int(MOST_CORNERS / corners.max(initial=1.0)))
    return [run[first : first + size] for first in range(0, run.size, size)]


def _end(job: Job, members: npt.NDArray[np.intp], outcome: Outcome) -> None:
    """Ends some members at their start."""
    job.runs[members], job.result.outcome[members] = False, outcome
    job.result.end_times[members], job.result.end_states[members] = job.start[members], job.states0[members]


def _pulled_in(job: Job, run: npt.NDArray[np.intp], switches: Mapping[str, Array]) -> bool:
    """Ends the members of ``run`` whose film has pulled in at the start; true if there are any."""
    before = job.runs.copy()
    for film, border in job.members.system.borders:
        ended = run[np.isnan(switches.get(border.switch or "", np.zeros(run.size)))]
        _end(job, ended, Outcome.PULLED_IN)
        if film is not None:
            job.result.pull_in[ended, film] = FilmPullIn.MINIMUM
    return bool((job.runs != before).any())


@lru_cache(maxsize=MOST_PROGRAMS)
def _program(system: ConeSystem, keep: Keep, tolerance: float) -> Program:
    return Program(system, keep, tolerance, border_events(system), **corner_numbers(system))


def smallest_step(members: Members) -> Array:
    """The least step of each member, (members,), see `SMALLEST_STEP`; 0 without a stretch limit."""
    smallest = SMALLEST_STEP * np.minimum(1.0, 10.0 / members.rate)
    if any(film.states and film.film.borders for film in members.system.films):
        smallest = RUNAWAY * smallest
    return np.where(np.isinf(members.strain_limit()), 0.0, smallest)


def _store(job: Job, run: npt.NDArray[np.intp], members: Members, raw: Raw, smallest_step: Array) -> None:
    """Stores the samples inside the members' limits, and the ends of their runs."""
    with np.errstate(all="ignore"):
        beyond = members.strain(raw.states[..., 0]) >= members.strain_limit(trailing=1)
    inside = ~(np.logical_or.accumulate(beyond, axis=1) if beyond.any() else beyond)
    result = job.result
    if members.system.charged and raw.tangents is not None:
        _of_voltages(job, run, members, raw)
    for name in ("states", "tangents", "divergence", "work"):
        if (kept := getattr(result, name)) is not None:
            values = getattr(raw, name)
            there = inside.reshape(inside.shape + (1,) * (values.ndim - 2))
            kept[run] = values if inside.all() else np.where(there, values, np.nan)
    result.steps[run] = raw.steps
    result.end_times[run], result.end_states[run] = raw.end_time, raw.end_state
    ended = _ended_by(members, raw)
    result.outcome[run] = _outcomes(job, members, raw, ended[0], smallest_step, ~inside[:, -1])
    _store_films(result, run, members.system, raw, ended)


def _of_voltages(job: Job, run: npt.NDArray[np.intp], members: Members, raw: Raw) -> None:
    """Transforms the tangent maps of charges, which programs carry, into those of voltages, which are the states."""
    assert raw.tangents is not None
    assert raw.divergence is not None
    states = np.concatenate([job.states0[run][:, None], raw.states], axis=1)
    times = np.concatenate([job.start[run][:, None], job.times[run]], axis=1)
    with np.errstate(all="ignore"):
        turns, scale = voltage_turns(members.system, times, states, members.numbers(trailing=1))
        raw.tangents[:] = np.linalg.solve(turns[:, 1:], raw.tangents @ turns[:, :-1])
        raw.divergence[:] += scale[:, :-1] - scale[:, 1:]


def _store_films(
    result: Trajectories, run: npt.NDArray[np.intp], system: ConeSystem, raw: Raw, ended: tuple[Array, Array]
) -> None:
    """Stores the time that each film spent in each of its states, and the kind of its pull-in."""
    by, how = ended
    for k, film in enumerate(system.films):
        if film.borders:
            result.film_times[run, k, : len(film.kinds)] = film.times_of_kinds(list(raw.switches), raw.dwell)
            result.pull_in[run, k] = np.where(by == k, how, FilmPullIn.NONE)


def _ended_by(members: Members, raw: Raw) -> tuple[Array, Array]:
    """The film whose pull-in ended each member, -1 for none, and its kind.

    A film has no minimum any more if it finds no state of tension, so that switches flip without end, or if it runs
    away so fast that the steps become too short before the end is met.
    """
    system = members.system
    by, how = np.full(raw.status.shape, -1), np.full(raw.status.shape, FilmPullIn.MINIMUM)
    lost = raw.status == STEP_TOO_SMALL
    some, z = bool(lost.any()), list(raw.end_state.T)
    n = members.numbers() if some else {}
    voltages = system.voltages(raw.end_time, z, n) if some else ()
    for k, film in enumerate(system.films):
        if not film.borders:
            continue
        kind = np.broadcast_to(film.pull_in_kind(raw.switches), by.shape)
        for place, (owner, border) in enumerate(system.borders):
            here = (raw.status == TERMINAL_EVENT + place) & (owner == k)
            by[here] = k
            how[here] = FilmPullIn.MINIMUM if border.switch else kind[here]
        if some and film.states and film.film.folds:
            share = film.limit_share(z[0], voltages[k], system.states_of(z, "film", k), n)
            by[lost & (kind == FilmPullIn.MINIMUM) & ~(share > AWAY)] = k
    return by, how


def _outcomes(
    job: Job, members: Members, raw: Raw, by: Array, smallest_step: Array, beyond: npt.NDArray[np.bool_]
) -> npt.NDArray[np.int8]:
    """The `Outcome` of each member."""
    ending = members.system.film.ending
    outcome = np.where((raw.status == ARRIVED) & ~beyond, Outcome.OK, ending)
    if ending == Outcome.STRETCH_LIMIT:
        # without a stretch limit nearby the motion is infinite; away from it only its deviations can overflow
        far = (job.keep == "tangents") & (raw.smallest_step >= smallest_step)
        outcome[(raw.status == NOT_FINITE) & (far | (smallest_step == 0.0)) & ~beyond] = Outcome.NOT_FINITE
    outcome[raw.status == TOO_MANY_STEPS] = Outcome.STEP_LIMIT
    switching = [TERMINAL_EVENT + k for k, (_, border) in enumerate(members.system.borders) if border.switch]
    outcome[raw.status >= TERMINAL_EVENT] = Outcome.PULLED_IN
    if switching:
        outcome[np.isin(raw.status, switching)] = Outcome.STEP_LIMIT  # for circuits; films are set in the next line
    outcome[by >= 0] = Outcome.PULLED_IN
    return outcome.astype(np.int8)
