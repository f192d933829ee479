"""Tangent maps along motions, and the growth of small deviations, from which exponents and multipliers follow.

The maps over stretches of at most `gelcone.motion.settle.STRETCH` fastest time scales come from the variational
equations; QR decomposition of their products (Benettin et al., Meccanica 15 (1980) 9) gives the logarithmic growth of
each stretch. Formulas hold for any number of states N; for two states there are faster and more accurate ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.motion.flow import DEFAULT_TOLERANCE, integrate
from gelcone.motion.job import Trajectories
from gelcone.motion.regular import solved_where_regular
from gelcone.motion.settle import STRETCH, Clock
from gelcone.physics.members import Members
from gelcone.quantity import Array

CERTAIN = 3.0
"""Standard errors from zero at which the sign of an exponent counts as certain."""
FLOOR = 1e-7
"""Exponents closer to zero than this are zero within double precision."""
RESOLVED = 1e-3
"""Largest error, by errors in a tangent map, of a logarithmic growth under the map that is not lost to it."""


@dataclass
class TangentRun:
    """The state of a run with deviations: ``states`` (members, N), orthonormal ``frames`` (members, N, N) of deviations
    in columns, number of stretches ``done``, the ``outcome`` (members,), and the largest ``error`` (members, N) of the
    growth of a stretch by errors in its tangent map: 0 for two states, NaN for a growth that is lost to it."""

    states: Array
    frames: Array
    done: int
    outcome: npt.NDArray[np.int8]
    error: Array

    @classmethod
    def at(cls, states: Array) -> TangentRun:
        """A run that starts from ``states`` (members, N) at a whole forcing period."""
        return cls(states.copy(), first_frames(states), 0, np.zeros(len(states), dtype=np.int8), np.zeros(states.shape))

    def take(self, index: Any) -> TangentRun:
        """The run of some members."""
        return TangentRun(self.states[index], self.frames[index], self.done, self.outcome[index], self.error[index])


def first_frames(states: Array) -> Array:
    """Initial orthonormal deviations, for each of the ``states`` (members, N): the unit matrix for two states.

    For more states it is a reflection that mixes all, so that the first deviation grows by the largest exponent also
    where some states do not depend on others, as a filter not on the disc.
    """
    count = states.shape[-1]
    across = np.sqrt(np.arange(1.0, count + 1.0)) if count > 2 else np.zeros(count)
    mirror = np.eye(count) - np.outer(across, across) * (4.0 / (count * (count + 1)))
    return np.tile(mirror, (len(states), 1, 1))


def advance(
    members: Members, run: TangentRun, clock: Clock, stretches: int, **flow_options: Any
) -> tuple[Array, Array]:
    """Continue ``run`` by some stretches.

    Returns the logarithmic growth of each stretch, (members, stretches, N), and the `contraction` there (members,
    stretches); NaN from the failure of a member on. With two states, over stretches longer than `STRETCH`, the second
    growth is the contraction less the first (Liouville's theorem): an exponent, but no check of the first. With more
    states a growth that is lost to errors of the tangent map is `resolved`.
    """
    phase = (run.done % clock.per_repeat) / clock.per_repeat * clock.repeat
    times = phase[:, None] + clock.spacing[:, None] * np.arange(1, stretches + 1)
    flow = integrate(members, run.states, times, start=phase, keep="tangents", **flow_options)
    assert flow.tangents is not None
    growth, run.frames = qr_growth(flow.tangents, run.frames)
    whole = contraction(members, flow, np.broadcast_to(clock.spacing[:, None], times.shape))
    if _two_states(flow.tangents):
        long = clock.spacing * members.fastest > STRETCH * (1.0 + 1e-9)
        growth[long, :, -1] = whole[long] - growth[long, :, :-1].sum(axis=2)
    else:
        error = rounding(flow.tangents, growth, flow_options.get("tolerance", DEFAULT_TOLERANCE))
        growth, error = resolved(growth, error, whole)
        run.error = np.maximum(run.error, error.max(axis=1))
    run.states = flow.states[:, -1]
    run.done += stretches
    run.outcome = np.where(run.outcome == Outcome.OK, flow.outcome, run.outcome)
    return growth, whole


def contraction(members: Members, run: Trajectories, spans: Array) -> Array:
    """Integrate the Jacobian's trace between samples ``spans`` (members, samples) of time apart.

    By Liouville's theorem this is the logarithm of the change of a volume of states: -2 zeta times the span for a
    planar system, else the integral that the ``run`` computed along the motion.
    """
    return -2.0 * members.values["damping_ratio"][:, None] * spans if run.divergence is None else run.divergence


def qr_growth(tangents: Array, frames: Array) -> tuple[Array, Array]:
    """Logarithmic growth along orthonormal frames under tangent maps (members, stretches, N, N).

    Returns the growth (members, stretches, N) and the final frames (members, N, N), columns orthonormal.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return (_growth_in_the_plane if _two_states(tangents) else _growth)(tangents, frames)


def rounding(tangents: Array, growth: Array, tolerance: float) -> Array:
    """Errors (..., N) of a logarithmic ``growth`` (..., N) along frames by errors of the tangent maps (..., N, N),
    which are ``tolerance`` over their largest entries."""
    return np.asarray(tolerance * np.abs(tangents).max(axis=(-2, -1))[..., None] * np.exp(-growth))


def resolved(growth: Array, error: Array, whole: Array, maps: int = 1) -> tuple[Array, Array]:
    """Growths (..., N) over a number of ``maps``, NaN for one that is lost to its ``error`` (..., N), and the errors.

    If it is the last one alone, it is the logarithmic change of a volume, ``whole`` (...,), less the other growths
    (Liouville's theorem).
    """
    lost = error > maps * RESOLVED
    growth, error = np.where(lost, np.nan, growth), np.where(lost, np.nan, error)
    growth[..., -1] = np.where(lost[..., -1], whole - growth[..., :-1].sum(axis=-1), growth[..., -1])
    error[..., -1] = np.where(lost[..., -1], error[..., :-1].sum(axis=-1), error[..., -1])
    return growth, error


def solved(matrices: Array, right: Array) -> Array:
    """Solutions (members, N) of linear equations with ``matrices`` (members, N, N) and right-hand sides (members, N).

    NaN or infinite where there is no solution.
    """
    return (_solved_in_the_plane if _two_states(matrices) else solved_where_regular)(matrices, right)


def _two_states(matrices: Array) -> bool:
    return matrices.shape[-1] == 2


# --- two states -------------------------------------------------------------------------------------------------------


def _growth_in_the_plane(tangents: Array, frames: Array) -> tuple[Array, Array]:
    """`qr_growth` of two states, from the first vector of a frame; the second one is normal to it, on its left."""
    (a, b), (c, d) = np.ascontiguousarray(tangents.transpose(2, 3, 1, 0))
    leads = np.empty((a.shape[0] + 1, 2, a.shape[1]))
    lengths = np.empty_like(a)
    leads[0] = frames[:, :, 0].T
    for k, (x, y) in enumerate(leads[:-1]):
        image = leads[k + 1]
        image[0], image[1] = a[k] * x + b[k] * y, c[k] * x + d[k] * y
        np.hypot(image[0], image[1], out=lengths[k])
        image /= lengths[k]
    x, y = leads[:-1, 0], leads[:-1, 1]
    # The normal part of the second vector is the area over the length of the first, without the cancellation of
    # subtracting its projection.
    height = leads[1:, 0] * (d * x - c * y) - leads[1:, 1] * (b * x - a * y)
    growth = np.empty(tangents.shape[:3])  # contiguous by member, so that sums have the same order anywhere
    growth[:, :, 0], growth[:, :, 1] = np.log(lengths.T), np.log(np.abs(height.T))
    x, y = leads[-1]
    return growth, np.stack([np.stack([x, y], axis=1), np.stack([-y, x], axis=1)], axis=2)


def _solved_in_the_plane(matrices: Array, right: Array) -> Array:
    (a, b), (c, d) = np.moveaxis(matrices, 0, 2)
    step = np.stack([d * right[:, 0] - b * right[:, 1], a * right[:, 1] - c * right[:, 0]], axis=1)
    return np.asarray(step / (a * d - b * c)[:, None])


# --- any number of states ---------------------------------------------------------------------------------------------


def _growth(tangents: Array, frames: Array) -> tuple[Array, Array]:
    growth = np.empty(tangents.shape[:3])
    for k in range(tangents.shape[1]):
        frames = _turned(tangents[:, k] @ frames, growth[:, k])
    return growth, frames


def _turned(image: Array, growth: Array) -> Array:
    """Orthonormal frames of the images (members, N, N) of frames; writes their growth to ``growth`` (members, N)."""
    frames = np.full(image.shape, np.nan)
    growth[:] = np.nan
    finite = np.isfinite(image).all(axis=(1, 2))
    if finite.any():
        q, r = np.linalg.qr(image[finite])
        heights = np.diagonal(r, axis1=1, axis2=2)
        frames[finite] = q * np.where(heights < 0.0, -1.0, 1.0)[:, None, :]
        growth[finite] = np.log(np.abs(heights))
    return frames
