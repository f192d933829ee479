"""The linear map of small motions about the flat film over one forcing period, and its multipliers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.motion.cyclic import scaled_product
from gelcone.motion.flow import integrate
from gelcone.motion.multipliers import moduli_in_the_plane
from gelcone.motion.settle import next_power_of_two
from gelcone.physics.members import Members
from gelcone.progress import Progress, weighted
from gelcone.quantity import Array

PIECE = 4.0
"""Length of the pieces of a forcing period, in units of the fastest linear time scale: so short that the determinant of
a piece is accurate, and that deviations do not overflow."""
MOST_PIECES_AT_ONCE = 1_000_000
STILL_STABLE = 1e-12
"""Margin without voltage below which rest is stable within rounding."""
SETTLING, MOST_SETTLINGS = 64.0, 100
"""Forcing periods after which the states other than the disc's are compared, and the most comparisons."""


@dataclass(frozen=True)
class Monodromy:
    """The linear map over one forcing period for every member: its trace is ``trace`` exp(``log_scale``), |trace| <= 2.

    ``log_product`` is the logarithm of the product of the multipliers, -2 zeta T.
    """

    trace: Array
    log_scale: Array
    log_product: Array
    product_error: Array
    repeat: Array
    outcome: npt.NDArray[np.int8]

    def margin(self) -> Array:
        """(|trace| - 1 - p)/(|trace| + 1 + p), p the product, from logarithms."""
        with np.errstate(divide="ignore"):
            log_trace = np.log(np.abs(self.trace)) + self.log_scale
        return np.tanh(0.5 * (log_trace - np.log1p(np.exp(self.log_product))))

    def multipliers(self) -> tuple[Array, Array, Array]:
        """Real part, imaginary part and logarithm of the modulus, each (members, 2), the larger modulus first."""
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            log_modulus, half, square = moduli_in_the_plane(self.trace, self.log_scale, self.log_product)
            sign = np.where(self.trace < 0.0, -1.0, 1.0)[:, None]
            scale = np.exp(self.log_scale)
            pair = (square < 0.0)[:, None]
            real = sign * np.where(pair, (half * scale)[:, None], np.exp(log_modulus))
            imag = np.where(pair, (np.sqrt(np.abs(square)) * scale)[:, None] * np.array([1.0, -1.0]), 0.0)
        return real, np.where(np.isnan(real), np.nan, imag), log_modulus


def _resting(members: Members, options: dict[str, Any]) -> tuple[Array, npt.NDArray[np.int8]]:
    """States (members, N) at phase 0 with the disc at rest and all other states periodic with the drive, and the
    outcomes of the runs to them."""
    states, outcome = members.start_states((0.0, 0.0)), np.zeros(members.size, dtype=np.int8)
    for _ in range(0 if members.system.planar else MOST_SETTLINGS):
        run = integrate(members, states, SETTLING * members.forcing_period[:, None], **options)
        change, states = np.abs(run.states[:, -1] - states), run.states[:, -1]
        outcome = np.where(outcome == Outcome.OK, run.outcome, outcome)
        if not (change > STILL_STABLE).any():
            break
    return states, outcome


def monodromy(members: Members, options: dict[str, Any], progress: Progress = None) -> Monodromy:
    """The maps of a one-dimensional ensemble. Members with equal numbers of pieces are computed together, so that the
    numbers of a member do not depend on the others."""
    repeat = members.forcing_period
    pieces = next_power_of_two(np.maximum(repeat * members.fastest / PIECE, 1.0))
    resting, at_rest = _resting(members, options)
    result = np.full((3, members.size), np.nan)
    outcome = np.zeros(members.size, dtype=np.int8)
    for count in np.unique(pieces):
        same = np.flatnonzero(pieces == count)
        for rows in np.array_split(same, int(np.ceil(same.size * count / MOST_PIECES_AT_ONCE))):
            times = repeat[rows, None] * (np.arange(1, count + 1) / count)
            share = weighted(progress, float(rows.size * count) / float(pieces.sum()))
            part = members.take(rows)
            run = integrate(part, resting[rows], times, keep="tangents", progress=share, **options)
            assert run.tangents is not None
            # the other states are even in x, so that they do not respond to deviations of the disc to first order
            result[:, rows], outcome[rows] = _trace_and_area(run.tangents[..., :2, :2]), run.outcome
    outcome = np.where(at_rest == Outcome.OK, outcome, at_rest)
    log_product = -2.0 * members.damping_ratio * repeat
    return Monodromy(result[0], result[1], log_product, np.expm1(result[2] - log_product), repeat, outcome)


def _trace_and_area(tangents: Array) -> tuple[Array, Array, Array]:
    """The product of all pieces: trace over a scale, logarithm of the scale, and logarithm of the determinant."""
    product, log_scale = scaled_product(tangents)
    with np.errstate(invalid="ignore"):
        areas = np.log(tangents[..., 0, 0] * tangents[..., 1, 1] - tangents[..., 0, 1] * tangents[..., 1, 0])
    return np.trace(product, axis1=1, axis2=2), log_scale, areas.sum(axis=1)
