"""What an integrator is given and what it gives back: the contract of a back end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol, get_args

import numpy as np
import numpy.typing as npt

from gelcone.physics.members import Members
from gelcone.progress import Progress, Watch
from gelcone.quantity import Array

Keep = Literal["states", "tangents", "work"]
KEEPS: tuple[Keep, ...] = get_args(Keep)


@dataclass(frozen=True)
class Trajectories:
    """Samples of every member; NaN from where a member failed.

    ``times`` (members, samples); ``states`` (members, samples, N) with displacement, velocity and what components add;
    ``tangents`` (members, samples, N, N), each the linear map of a small deviation from the previous sample (the first
    from the start) to this one; ``work`` (members, samples, 2) with the work of the electric force and the energy
    dissipated since the start; ``outcome`` and ``steps`` (members,).
    """

    times: Array
    states: Array
    tangents: Array | None
    work: Array | None
    outcome: npt.NDArray[np.int8]
    steps: npt.NDArray[np.int64]

    @classmethod
    def blank(cls, times: Array, states: int, keep: Keep, outcome: npt.NDArray[np.int8]) -> Trajectories:
        """Nothing known yet of members with so many ``states``, sampled at ``times`` (members, samples)."""
        return cls(
            times=times,
            states=np.full((*times.shape, states), np.nan),
            tangents=np.full((*times.shape, states, states), np.nan) if keep == "tangents" else None,
            work=np.full((*times.shape, 2), np.nan) if keep == "work" else None,
            outcome=outcome,
            steps=np.zeros(len(times), dtype=np.int64),
        )


@dataclass(frozen=True)
class Job:
    """One call of `gelcone.integrate`: which ``members`` run (``runs``), from where, sampled when, and what is kept.

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


class Backend(Protocol):
    """Integrates a job. A member's numbers depend on nothing but the member: not on its neighbours, their order or the
    number of threads. `gelcone.progress.Stopped` is raised once ``watch`` says so."""

    def run(self, job: Job, *, threads: int, progress: Progress, watch: Watch | None) -> None: ...
