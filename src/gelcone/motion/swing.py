"""What a settled motion covers: its lowest and highest displacement, its period, its harmonics."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.motion.cycle import periods_of
from gelcone.motion.flow import integrate
from gelcone.motion.regime import REST_TOLERANCE
from gelcone.motion.section import repeat_of
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

REPEATS = 24
"""Drive repeats that are looked at: whole periods of every motion of 1, 2, 3, 4, 6, 8 or 12 repeats."""
SAMPLES = 128
"""Samples of a repeat; turning points between them are found by parabolas."""
HARMONICS = (1, 2, 3, 4)
"""Multiples of the drive frequency of which amplitude and phase are told."""
DECAYS = 20.0
SHORTEST = 200.0
ROUNDS = 6


@dataclass(frozen=True)
class Swing:
    """Settled motions, arrays over the same dims: ``lowest`` and ``highest`` displacement, the ``period`` in drive
    repeats (0: none found), the ``outcome``, (..., harmonics) the complex ``harmonics`` - displacement is the sum of
    the imaginary parts of harmonic times exp(i k omega t) -, and (..., 2) the ``final`` states at a whole repeat.
    """

    lowest: Array
    highest: Array
    period: npt.NDArray[np.int64]
    outcome: npt.NDArray[np.int8]
    harmonics: npt.NDArray[np.complex128]
    final: Array

    @classmethod
    def blank(cls, *shape: int) -> Swing:
        return cls(
            lowest=np.full(shape, np.nan),
            highest=np.full(shape, np.nan),
            period=np.zeros(shape, dtype=np.int64),
            outcome=np.zeros(shape, dtype=np.int8),
            harmonics=np.full((*shape, len(HARMONICS)), np.nan + 0j),
            final=np.full((*shape, 2), np.nan),
        )

    def put(self, where: Any, other: Swing) -> None:
        """Takes over the motions of another one at some places."""
        for field in fields(self):
            getattr(self, field.name)[where] = getattr(other, field.name)

    @property
    def amplitude(self) -> Array:
        return 0.5 * (self.highest - self.lowest)

    @property
    def middle(self) -> Array:
        return 0.5 * (self.highest + self.lowest)


def swing(model: ConeModel, states: Array, **flow_options: Any) -> Swing:
    """Follows a flattened ensemble from ``states`` (members, 2) at phase 0 of the drive over `REPEATS` repeats."""
    ticks = np.arange(1, REPEATS * SAMPLES + 1) / SAMPLES
    times = repeat_of(model)[:, None] * ticks
    run = integrate(model, states, times, **flow_options)
    x, points = run.states[..., 0], run.states[:, SAMPLES - 1 :: SAMPLES]
    period, _ = periods_of(points)
    omega = np.broadcast_to(model.drive_frequency, model.shape)[:, None]
    waves = [2j * (x * np.exp(-1j * k * omega * times)).mean(axis=1) for k in HARMONICS]
    return Swing(-highest(-x), highest(x), period, run.outcome, np.stack(waves, axis=1), points[:, -1])


def highest(x: Array) -> Array:
    """Largest value of each row (members, samples), by the parabola through the largest sample and its neighbours."""
    at = np.clip(np.argmax(x, axis=1), 1, x.shape[1] - 2)
    before, here, after = (np.take_along_axis(x, at[:, None] + k, axis=1)[:, 0] for k in (-1, 0, 1))
    curvature = before - 2.0 * here + after
    rise = (before - after) ** 2 / np.where(curvature < 0.0, -8.0 * curvature, np.inf)
    return np.maximum(here + rise, x.max(axis=1))


def settled_swing(model: ConeModel, states: Array, **flow_options: Any) -> Swing:
    """The swing after a transient, a rest with period 1; a motion whose points do not return yet is given more time.

    At first `DECAYS` decay times (at least `SHORTEST`), and then up to `ROUNDS` - 1 times as long as all before.
    """
    settled = Swing.blank(model.size)
    settled.final[:] = states
    open_ = np.arange(model.size)
    for trial in range(ROUNDS):
        part = model.take(open_)
        repeat = repeat_of(part)
        span = np.maximum(DECAYS / np.asarray(part.damping_ratio), SHORTEST) * 2 ** max(trial - 1, 0)
        run = integrate(part, settled.final[open_], (np.ceil(span / repeat) * repeat)[:, None], **flow_options)
        ran = run.outcome == Outcome.OK
        settled.outcome[open_] = run.outcome
        part, open_ = part.take(ran), open_[ran]
        if open_.size:
            settled.put(open_, swing(part, run.states[ran, 0], **flow_options))
            open_ = open_[(settled.period[open_] == 0) & (settled.outcome[open_] == Outcome.OK)]
        if not open_.size:
            break
    # what is left of a motion that dies out has no period of its own
    settled.period[(settled.amplitude < REST_TOLERANCE) & (settled.outcome == Outcome.OK)] = 1
    return settled
