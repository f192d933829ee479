"""Stroke, extremes and harmonics of a periodic motion, over its period."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.motion.attractor.cycle import Cycles, extremes, sampled
from gelcone.motion.attractor.search import search
from gelcone.motion.averages import AVERAGES, averages
from gelcone.motion.columns import Columns, column
from gelcone.motion.electrical import MEANINGS, electrical
from gelcone.motion.validity import VALIDITY
from gelcone.physics.members import Members
from gelcone.progress import Progress
from gelcone.quantity import Array

REPEATS = 24
"""Forcing periods over which a motion without a period is sampled."""
SAMPLES = 128
"""Samples of a forcing period for harmonics and the deliveries of the source."""
HARMONICS = (1, 2, 3, 4)
"""Multiples of the drive frequency with reported amplitude and phase."""
SMALLEST_HARMONIC = 1e-12
"""Harmonics below this share of the largest displacement are rounding."""


@dataclass(frozen=True)
class Swing(Columns):
    """Settled motions, arrays over the same dims.

    ``lowest`` and ``highest`` displacement; ``period`` of the cycle in forcing periods (0: none); ``resting``, true if
    the cycle (of period 1) is a rest; ``outcome``; complex ``harmonics`` (..., harmonics), the displacement being the
    sum of the imaginary parts of harmonic times exp(i k omega t); ``final`` states (..., N) at phase 0; ``mean``
    displacement; ``validity`` (`gelcone.motion.validity.validity`); deliveries of the ``source``, (...,
    `gelcone.motion.electrical.MEANINGS`); and with these the standard ``errors`` of `gelcone.motion.averages.AVERAGES`,
    0 for a cycle.
    """

    lowest: Array = column()
    highest: Array = column()
    period: npt.NDArray[np.int64] = column(0, kind=np.int64)
    resting: npt.NDArray[np.bool_] = column(False, kind=bool)
    outcome: npt.NDArray[np.int8] = column(0, kind=np.int8)
    harmonics: npt.NDArray[np.complex128] = column(np.nan + 0j, len(HARMONICS), kind=complex)
    final: Array = column(np.nan, "N")
    mean: Array = column()
    validity: Array = column(np.nan, VALIDITY)
    source: Array = column(np.nan, len(MEANINGS))
    errors: Array = column(np.nan, len(AVERAGES))

    @property
    def amplitude(self) -> Array:
        """Half of the extent of the motion."""
        return 0.5 * (self.highest - self.lowest)

    @property
    def forcing_periods(self) -> npt.NDArray[np.int64]:
        """The period as results report it: 0 also for a rest."""
        return np.where(self.resting, 0, self.period)

    @property
    def phases(self) -> Array:
        """Phases of the harmonics in degrees; NaN where the disc rests or a harmonic is rounding."""
        size = SMALLEST_HARMONIC * np.maximum(np.abs(self.lowest), np.abs(self.highest))
        moves = (np.abs(self.harmonics) > size[..., None]) & ~self.resting[..., None]
        return np.where(moves, np.degrees(np.angle(self.harmonics)), np.nan)

    @property
    def middle(self) -> Array:
        """Middle between lowest and highest displacement."""
        return 0.5 * (self.highest + self.lowest)


def swing(
    members: Members,
    states: Array,
    period: npt.NDArray[np.int64] | None = None,
    *,
    only_extent: bool = False,
    source: bool = False,
    **flow_options: Any,
) -> Swing:
    """The motions of a flattened ensemble from ``states`` (members, N) at phase 0.

    Motions on cycles of known ``period`` (members,) are sampled over whole turns and drive periods, those of period 0
    over `REPEATS` forcing periods, their averages with the ``source`` over more. With ``only_extent``, harmonics and
    validity, which is slow to compute, stay NaN; deliveries stay NaN without ``source``.
    """
    swings = Swing.blank(members.size, states=states.shape[1])
    swings.period[:] = 0 if period is None else period
    for cycle_period in np.unique(swings.period):
        rows = np.flatnonzero(swings.period == cycle_period)
        # two forcing periods are a whole number of drive periods
        repeats = int(cycle_period * (1 + cycle_period % 2)) or REPEATS
        group = members.take(rows)
        run = sampled(group, states[rows], repeats, SAMPLES, **flow_options)
        x = run.path[..., 0]
        swings.lowest[rows], swings.highest[rows] = extremes(group, states[rows], repeats, run, **flow_options)
        swings.outcome[rows], swings.final[rows], swings.mean[rows] = run.outcome, run.path[:, -1], x.mean(axis=1)
        if source:
            spacing = (run.times.shape[1] - 1) // x.shape[1]
            of_source = electrical(group, run.times[:, spacing::spacing], run.path, states[rows], **flow_options)
            swings.source[rows] = np.stack([of_source[name] for name in MEANINGS], axis=-1)
            swings.errors[rows] = 0.0
            if not cycle_period:
                _average(swings, rows, *averages(group, states[rows], SAMPLES, **flow_options))
        if not only_extent:
            swings.harmonics[rows] = harmonics_of(group, x, SAMPLES)
            swings.validity[rows] = run.validity(group, turn=cycle_period > 0)
    return swings


def _average(found: Swing, rows: npt.NDArray[np.intp], means: Array, errors: Array) -> None:
    """Set the averages of motions without a period, where they are known, and their errors."""
    for k, name in enumerate(AVERAGES):
        target = found.mean if name == "mean" else found.source[:, list(MEANINGS).index(name)]
        target[rows] = np.where(np.isfinite(means[:, k]), means[:, k], target[rows])
    found.errors[rows] = errors


def harmonics_of(members: Members, x: Array, samples: int) -> npt.NDArray[np.complex128]:
    """The complex harmonics (members, harmonics) of displacements over whole drive periods, with ``samples`` per
    forcing period, the first one spacing after phase 0."""
    turns, which = np.unique(members.drive_frequency * members.forcing_period, return_inverse=True)
    waves = np.exp(-1j * turns[:, None] * (np.arange(1, x.shape[1] + 1) / samples))
    return np.stack([2j * (x * (waves**k)[which]).mean(axis=1) for k in HARMONICS], axis=1)


def settled_swing(
    members: Members,
    states: Array,
    *,
    transient: float | None = None,
    patience: float | None = None,
    only_extent: bool = False,
    source: bool = False,
    progress: Progress = None,
    **flow_options: Any,
) -> Swing:
    """The swing of damped members on the attractor that a search finds from ``states`` (members, N), with period 1 for
    a rest, or else of the motion after the search. Options as in `settled` and `swing`."""
    reached = search(members, states, transient=transient, patience=patience, progress=progress, **flow_options)
    swings = Swing.blank(members.size, states=states.shape[1])
    swings.outcome[:] = reached.outcome
    rows = np.flatnonzero(reached.outcome == Outcome.OK)
    if rows.size:
        group, cycles = members.take(rows), reached.cycles.take(rows)
        swings.put(
            rows, swing_of(group, cycles, reached.state[rows], only_extent=only_extent, source=source, **flow_options)
        )
    return swings


def swing_of(members: Members, cycles: Cycles, states: Array, **options: Any) -> Swing:
    """`swing` on ``cycles``, or from ``states`` (members, N) where there is none."""
    starts = np.where(cycles.found[:, None], cycles.point, states)
    swings = swing(members, starts, np.where(cycles.found, cycles.period, 0), **options)
    swings.resting[:] = cycles.resting
    return swings
