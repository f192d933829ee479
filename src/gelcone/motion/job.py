"""The contract of an integrator: its input and its result."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, Protocol, get_args

import numpy as np
import numpy.typing as npt

from gelcone.physics.members import Members
from gelcone.physics.system import ConeSystem
from gelcone.progress import Progress, Watch
from gelcone.quantity import Array

Keep = Literal["states", "tangents", "work"]
KEEPS: tuple[Keep, ...] = get_args(Keep)


@dataclass(frozen=True)
class Trajectories:
    """Samples of every member; NaN after a member failed.

    ``times`` (members, samples); ``states`` (members, samples, N) with displacement, velocity and what components add;
    ``tangents`` (members, samples, N, N), each the linear map of a small deviation from the previous sample (the first
    from the start) to this one, and ``divergence`` (members, samples), the integral of the Jacobian's trace between
    them, unless the system is planar; ``work`` (members, samples, causes), the integrals of the powers since the start
    (`gelcone.physics.system.ConeSystem.causes`); ``outcome`` and ``steps`` (members,). ``end_times`` (members,) and
    ``end_states`` (members, N) are the last known of each. ``pull_in`` (members, films) is the way in which each film
    pulled in (`FilmPullIn`), ``film_times`` (members, films, kinds) the time that it spent in each of its states.
    """

    times: Array
    states: Array
    tangents: Array | None
    divergence: Array | None
    work: Array | None
    outcome: npt.NDArray[np.int8]
    steps: npt.NDArray[np.int64]
    end_times: Array
    end_states: Array
    pull_in: npt.NDArray[np.int8]
    film_times: Array

    @classmethod
    def blank(cls, times: Array, system: ConeSystem, keep: Keep, outcome: npt.NDArray[np.int8]) -> Trajectories:
        """Trajectories of members of ``system`` sampled at ``times`` (members, samples), filled with NaN and zeros."""
        states = len(system.states)
        return cls(
            times=times,
            states=np.full((*times.shape, states), np.nan),
            tangents=np.full((*times.shape, states, states), np.nan) if keep == "tangents" else None,
            divergence=np.full(times.shape, np.nan) if keep == "tangents" and not system.planar else None,
            work=np.full((*times.shape, len(system.causes)), np.nan) if keep == "work" else None,
            outcome=outcome,
            steps=np.zeros(len(times), dtype=np.int64),
            end_times=np.full(len(times), np.nan),
            end_states=np.full((len(times), states), np.nan),
            pull_in=np.zeros((len(times), len(system.films)), dtype=np.int8),
            film_times=np.zeros((len(times), len(system.films), max(len(film.kinds) for film in system.films))),
        )


def to_the_end(run: Trajectories, samples: npt.NDArray[np.intp] | slice = slice(None)) -> tuple[Array, Array]:
    """Times and states of some samples of a run, default all; the first sample behind an early end is that end."""
    times, states = run.times[:, samples].copy(), run.states[:, samples].copy()
    ended = np.isnan(states[..., 0])
    rows, first = np.flatnonzero(ended.any(axis=1)), ended.argmax(axis=1)
    later = rows[run.end_times[rows] > times[rows, first[rows] - 1]]
    times[later, first[later]], states[later, first[later]] = run.end_times[later], run.end_states[later]
    return times, states


@dataclass(frozen=True)
class Job:
    """One call of `gelcone.integrate`: ``members``, the mask ``runs`` of those to integrate, and what to record.

    ``states0`` (members, N) at ``start`` (members,), ``times`` (members, samples), ``gaps`` between the samples, the
    first from the start. ``result`` takes the samples, steps and outcomes; the back end fills it for those that run.
    """

    members: Members
    runs: npt.NDArray[np.bool_]
    states0: Array
    start: Array
    times: Array
    gaps: Array
    keep: Keep
    tolerance: float
    result: Trajectories


@dataclass
class Portable:
    """The program of one member as text in LLVM's language, and the layout of its arrays.

    ``modules`` hold ``prepare``, ``start``, ``advance``, ``serve`` and ``step`` - one ``step`` in the first module, or
    with several laws one in each of the others. ``points`` hold the functions ``point_K(z, time, numbers, switches,
    roots, out)`` of each law K, which write the ``outputs``: rates of the states, further outputs, and borders.
    ``sizes`` names the lengths of arrays and indices in them. ``used`` are the ``numbers`` on which anything depends.
    ``telling`` are the indices among ``switches`` of those whose signs make the number of a law. ``border_switches``
    has the index of the switch of each border, -1 where the member ends.
    """

    modules: tuple[str, ...]
    points: tuple[str, ...]
    outputs: tuple[str, ...]
    sizes: Mapping[str, int]
    numbers: tuple[str, ...]
    used: frozenset[str]
    switches: tuple[str, ...]
    telling: tuple[int, ...]
    border_switches: tuple[int, ...]

    def run(
        self, numbers: Mapping[str, Any], states: Array, length: float, smallest_step: float, most_steps: float
    ) -> Ended:
        """Run one member, compiled, from the time 0 over a length."""
        raise NotImplementedError


@dataclass(frozen=True)
class Ended:
    """The end of a run of one member: the ``status`` of the integrator, 0 where it arrived, ``time``, ``states`` and
    ``switches``."""

    status: int
    time: float
    states: Array
    switches: Mapping[str, float]


class Backend(Protocol):
    """An integrator of jobs. A member's numbers depend on that member alone, not on its neighbours, their order or the
    number of threads. Raises `gelcone.progress.Stopped` once the stop of ``watch`` is set."""

    def run(self, job: Job, *, threads: int, progress: Progress, watch: Watch | None) -> None:
        """Run the job and fill its result."""
