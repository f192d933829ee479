"""Tangent maps along motions, and how much they make deviations grow: what exponents and multipliers are made of.

The maps over stretches of at most `STRETCH` fastest time scales come from the variational equations; QR decomposition
of their products (Benettin et al., Meccanica 15 (1980) 9) gives the logarithmic growth of each stretch.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.motion.flow import integrate
from gelcone.physics.members import Ensemble
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

STRETCH = 16.0
"""Tangent maps are restarted after this many fastest linear time scales: deviations then grow by so little that neither
the step control nor the area between them suffers."""
LONG_STRETCH = 64.0
"""The same where a few digits of the larger deviation are enough; the area between both may be lost to rounding."""
BLOCK = 64.0
"""Shortest block of an average: longer than chaotic motions remember."""
CERTAIN = 3.0
"""The sign of an exponent counts as certain when it is this many standard errors from zero."""
FLOOR = 1e-7
"""Exponents closer to zero than this are zero as far as double precision tells."""


@dataclass(frozen=True)
class Clock:
    """How the time of each member is cut into stretches: ``per_repeat`` stretches to a drive repeat, or - where a
    repeat is short - ``repeats`` repeats to a stretch; ``block`` stretches, a whole number of repeats, to a block. One
    ``per_repeat`` and ``block`` for all members, the rest (members,)."""

    per_repeat: int
    block: int
    repeat: Array
    repeats: Array

    @property
    def spacing(self) -> Array:
        return self.repeat * self.repeats / self.per_repeat

    def take(self, index: Any) -> Clock:
        return Clock(self.per_repeat, self.block, self.repeat[index], self.repeats[index])


def clocks(model: ConeModel, stretch: float = STRETCH) -> list[tuple[npt.NDArray[np.intp], Clock]]:
    """Members grouped by their stretches per repeat and per block, each group with its clock.

    ``stretch`` is the longest, in fastest linear time scales.
    """
    repeat = np.broadcast_to(model.forcing_period, model.shape).ravel()
    longest = stretch / fastest_rate(model)
    per_repeat = 2 ** np.ceil(np.log2(np.maximum(repeat / longest, 1.0))).astype(int)
    repeats = np.maximum(np.floor(longest / repeat), 1.0)
    block = per_repeat * np.ceil(BLOCK / (repeat * repeats)).astype(int)
    keys, group = np.unique(np.stack([per_repeat, block], axis=1), axis=0, return_inverse=True)
    groups = [np.flatnonzero(group.ravel() == i) for i in range(len(keys))]
    return [
        (members, Clock(int(key[0]), int(key[1]), repeat[members], repeats[members]))
        for key, members in zip(keys, groups, strict=True)
    ]


def fastest_rate(model: Ensemble) -> Array:
    """A bound of how fast small deviations move, (members,)."""
    return model.members().rate


@dataclass
class TangentRun:
    """Members on their way: states, orthonormal frames of tangent vectors, stretches done, and how it went."""

    states: Array
    frames: Array
    done: int
    outcome: npt.NDArray[np.int8]

    @classmethod
    def at(cls, states: Array) -> TangentRun:
        count = len(states)
        return cls(states.copy(), np.tile(np.eye(2), (count, 1, 1)), 0, np.zeros(count, dtype=np.int8))

    def take(self, index: Any) -> TangentRun:
        return TangentRun(self.states[index], self.frames[index], self.done, self.outcome[index])


def advance(model: ConeModel, run: TangentRun, clock: Clock, stretches: int, **flow_options: Any) -> Array:
    """Moves ``run`` on by some stretches; the logarithmic growth of each, shape (members, stretches, 2).

    ``model`` is a flattened ensemble of the run's members. NaN from where a member fails. Over stretches longer than
    `STRETCH` the second growth is what Liouville's theorem leaves of -2 zeta: an exponent, but no check of the first.
    """
    phase = (run.done % clock.per_repeat) / clock.per_repeat * clock.repeat
    times = phase[:, None] + clock.spacing[:, None] * np.arange(1, stretches + 1)
    flow = integrate(model, run.states, times, start=phase, keep="tangents", **flow_options)
    assert flow.tangents is not None
    growth, run.frames = qr_growth(flow.tangents, run.frames)
    shrinking = -2.0 * np.broadcast_to(model.damping_ratio, model.shape) * clock.spacing
    long = clock.spacing * fastest_rate(model) > STRETCH * (1.0 + 1e-9)
    growth[long, :, 1] = shrinking[long, None] - growth[long, :, 0]
    run.states = flow.states[:, -1]
    run.done += stretches
    run.outcome = np.where(run.outcome == Outcome.OK, flow.outcome, run.outcome)
    return growth


def qr_growth(tangents: Array, frames: Array) -> tuple[Array, Array]:
    """Logarithmic growth along the orthonormal frames that tangent maps (members, stretches, 2, 2) carry along.

    Returns the growth (members, stretches, 2) and the final frames (members, 2, 2), columns orthonormal.
    """
    growth = np.empty((*tangents.shape[:2], 2))
    with np.errstate(divide="ignore", invalid="ignore"):
        for k in range(tangents.shape[1]):
            image = tangents[:, k] @ frames
            first, second = image[:, :, 0], image[:, :, 1]
            length = np.hypot(first[:, 0], first[:, 1])
            first = first / length[:, None]
            # In the plane what is left of the second vector is the area over the first one's length, without the
            # cancellation that subtracting its projection would suffer.
            height = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
            frames = np.stack([first, np.stack([-first[:, 1], first[:, 0]], axis=1)], axis=2)
            growth[:, k, 0] = np.log(length)
            growth[:, k, 1] = np.log(np.abs(height))
    return growth, frames


def chained(tangents: Array) -> tuple[Array, Array]:
    """Product of tangent maps (members, stretches, 2, 2), scaled to entries of at most 1, and log of the scale."""
    product, log_scale = np.broadcast_to(np.eye(2), (len(tangents), 2, 2)), np.zeros(len(tangents))
    for k in range(tangents.shape[1]):
        product = tangents[:, k] @ product
        scale = np.abs(product).max(axis=(1, 2))
        product, log_scale = product / scale[:, None, None], log_scale + np.log(scale)
    return product, log_scale


def log_multipliers(product: Array, log_scale: Array, log_determinant: Array) -> Array:
    """Logarithms of the moduli of both eigenvalues of scaled maps (members, 2, 2), the larger first.

    The smaller one comes from the determinant, which the trace would lose to rounding.
    """
    half = 0.5 * np.abs(product[:, 0, 0] + product[:, 1, 1])
    square = half * half - np.exp(log_determinant - 2.0 * log_scale)
    larger = np.where(square >= 0.0, log_scale + np.log(half + np.sqrt(np.abs(square))), 0.5 * log_determinant)
    return np.stack([larger, log_determinant - larger], axis=1)
