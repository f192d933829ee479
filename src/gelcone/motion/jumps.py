"""Jumps of the voltage of an ideal source: their times, and the films that they end.

A film that creeps follows the minimum of its energy in time. When its voltage jumps, it passes the minima at the
voltages in between. It pulls in where this minimum ends, even if a second one, of a far longer film near its stretch
limit, exists at the voltage after the jump.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone.codes import FilmPullIn, Outcome
from gelcone.motion.job import Job, Trajectories
from gelcone.physics.members import Members
from gelcone.physics.placed import PlacedFilm
from gelcone.physics.structure import Line
from gelcone.physics.system import ConeSystem
from gelcone.quantity import Array

NEARBY = 1e-12
"""Share of a drive period before and after a corner at which its voltages are taken."""
JUMP = 1e-9
"""Share of the peak voltage above which a change of the voltage at a corner is a jump."""


class Jumps(NamedTuple):
    """Jumps of the commanded voltage: the ``times`` (members, jumps), padded with infinity, the voltages ``before`` and
    ``after``, and the mask ``there`` of the jumps."""

    times: Array
    before: Array
    after: Array
    there: npt.NDArray[np.bool_]


def jumping(system: ConeSystem) -> list[Line]:
    """The lines whose voltage jumps where that of a waveform with pieces does."""
    lines = system.lines if system.waveform.pieced else ()
    return [line for line in lines if line.circuit.jumps and line.drive != "constant"]


def jumps_between(members: Members, start: Array, end: Array) -> Jumps:
    """The jumps after ``start`` and until ``end`` (members,) of a waveform with pieces."""
    system, wide = members.system, members.numbers(trailing=1)
    corners = system.waveform.corners_between(start, end, members.own_numbers).later
    finite, apart = np.isfinite(corners), NEARBY * members.drive_period[:, None]
    at = np.where(finite, corners, end[:, None])
    before, after = (system.waveform.voltage(at + sign * apart, wide) for sign in (-1.0, 1.0))
    with np.errstate(invalid="ignore"):  # between infinite times of padding
        lasts = np.diff(np.where(finite, corners, np.inf), axis=1, append=np.inf)
    last = lasts > 2.0 * apart  # pieces may have length 0
    is_jump = finite & last & (np.abs(after - before) > JUMP * np.reshape(members.peak_voltage, (-1, 1)))
    first = np.argsort(~is_jump, axis=1, kind="stable")[:, : int(is_jump.sum(axis=1).max(initial=0))]
    jump_fields = [
        np.take_along_axis(array, first, axis=1)
        for array in (np.where(is_jump, corners, np.inf), before, after, is_jump)
    ]
    return Jumps(*jump_fields)


def increasing(times: Array, end: Array) -> Array:
    """Times (members, columns) to integrate to: infinite ones are replaced by increasing times after the ``end``."""
    behind = end[:, None] + (1.0 + np.abs(end[:, None])) * 1e-3 * (1.0 + np.arange(times.shape[1]))
    return np.where(np.isfinite(times), times, behind)


def end_films(job: Job, run: Callable[[Job], None]) -> None:
    """Ends members at the first jump at which a film pulls in; ``run`` integrates a job."""
    system = job.members.system
    films = [(line, k) for line in jumping(system) for k in line.films if _follows_minimum(system.films[k])]
    rows = np.flatnonzero(_slack(job.result, system, [k for _, k in films]) & job.runs) if films else np.empty(0, int)
    if not rows.size:
        return
    members, last = job.members.take(rows), job.times[rows, -1]
    jumps = jumps_between(members, job.start[rows], last)
    if not jumps.there.any():
        return
    to_jumps = _job(job, rows, increasing(jumps.times, last))
    run(to_jumps)
    z, n = list(np.moveaxis(to_jumps.result.states, -1, 0)), members.numbers(trailing=1)
    ends, by = np.full(rows.size, np.inf), np.full(rows.size, -1)
    for line, k in films:
        squares = [np.square(system.command_of(line, v, n)) for v in (jumps.before, jumps.after)]
        with np.errstate(invalid="ignore"):
            most = system.films[k].highest_squared_held(z[0], system.states_of(z, "film", k), n)
            lost = jumps.there & (squares[1] > most) & (squares[1] > squares[0])
        first = np.where(lost, jumps.times, np.inf).min(axis=1)
        ends, by = np.minimum(ends, first), np.where(first < ends, k, by)
    met = by >= 0
    if met.any():
        _cut(job, rows[met], ends[met], by[met], run)


def _follows_minimum(film: PlacedFilm) -> bool:
    return bool(film.film.folds and film.states)


def _slack(result: Trajectories, system: ConeSystem, films: list[int]) -> npt.NDArray[np.bool_]:
    """Mask (members,): some of the ``films`` were without force for a time, or have pulled in.

    Only then may a jump have ended a film.
    """
    times = result.film_times[:, films, :]
    slack = [[name in ("meridional_slack", "crumpled") for name in system.films[k].kinds] for k in films]
    slack_kinds = np.array([row + [False] * (times.shape[2] - len(row)) for row in slack], dtype=bool)
    return np.asarray(((times > 0.0) & slack_kinds).any(axis=(1, 2)) | (result.outcome == Outcome.PULLED_IN))


def _job(job: Job, rows: npt.NDArray[np.intp], times: Array) -> Job:
    """A job of some members to other times that records the states."""
    members, outcome = job.members.take(rows), np.zeros(rows.size, dtype=np.int8)
    gaps = np.diff(times, axis=1, prepend=job.start[rows, None])
    result = Trajectories.blank(times, members.system, "states", outcome)
    runs = np.ones(rows.size, dtype=bool)
    return replace(
        job, members=members, runs=runs, states0=job.states0[rows], start=job.start[rows], times=times, gaps=gaps,
        keep="states", result=result,
    )  # fmt: skip


def _cut(job: Job, rows: npt.NDArray[np.intp], ends: Array, by: Array, run: Callable[[Job], None]) -> None:
    """Sets results of members after the jump in which a film pulls in to NaN, and records the pull-in."""
    until = _job(job, rows, ends[:, None])
    run(until)
    result, beyond = job.result, job.times[rows] > ends[:, None]
    for kept in (result.states, result.tangents, result.divergence, result.work):
        if kept is not None:
            values = kept[rows]
            values[beyond] = np.nan
            kept[rows] = values
    result.outcome[rows], result.steps[rows] = Outcome.PULLED_IN, until.result.steps
    result.end_times[rows], result.end_states[rows] = ends, until.result.states[:, 0]
    result.film_times[rows] = until.result.film_times
    result.pull_in[rows] = FilmPullIn.NONE
    result.pull_in[rows, by] = FilmPullIn.MINIMUM
