"""The settled motion at full drive: its lowest and highest displacement, its period, its harmonics."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Outcome
from gelcone.dataset import Findings
from gelcone.devices.analysis import analysis
from gelcone.errors import InputError
from gelcone.motion.cycle import periods_of
from gelcone.motion.examination import REST_TOLERANCE
from gelcone.motion.flow import DEFAULT_TOLERANCE, integrate
from gelcone.motion.job import Trajectories
from gelcone.motion.linear import linear_response
from gelcone.motion.settle import default_transient, repeats_lasting, round_duration, settle, single, start_states
from gelcone.motion.validity import unknown, validity, validity_variables
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.progress import Counted, Progress, weighted
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

REPEATS = 24
"""Forcing periods that are examined: whole periods of every motion of 1, 2, 3, 4, 6, 8 or 12 of them."""
SAMPLES = 128
"""Samples of a forcing period; turning points between them are found by parabolas."""
SPREAD = 7
"""Every so many of them are looked at for the validity: over whole periods of every motion they lie at all phases."""
HARMONICS = (1, 2, 3, 4)
"""Multiples of the drive frequency of which amplitude and phase are reported."""
ROUNDS = 6


@dataclass(frozen=True)
class Swing:
    """Settled motions, arrays over the same dims: ``lowest`` and ``highest`` displacement, the ``period`` in forcing
    periods (0: none found), the ``outcome``, (..., harmonics) the complex ``harmonics`` - displacement is the sum of
    the imaginary parts of harmonic times exp(i k omega t) -, (..., N) the ``final`` states at phase 0, and the
    ``validity`` (`gelcone.motion.validity.validity`).
    """

    lowest: Array
    highest: Array
    period: npt.NDArray[np.int64]
    outcome: npt.NDArray[np.int8]
    harmonics: npt.NDArray[np.complex128]
    final: Array
    validity: Array

    @classmethod
    def blank(cls, *shape: int, states: int = 2) -> Swing:
        """Nothing known yet of motions with so many states."""
        return cls(
            lowest=np.full(shape, np.nan),
            highest=np.full(shape, np.nan),
            period=np.zeros(shape, dtype=np.int64),
            outcome=np.zeros(shape, dtype=np.int8),
            harmonics=np.full((*shape, len(HARMONICS)), np.nan + 0j),
            final=np.full((*shape, states), np.nan),
            validity=unknown(*shape),
        )

    def take(self, rows: Any) -> Swing:
        """Some of the motions."""
        return Swing(**{field.name: getattr(self, field.name)[rows].copy() for field in fields(self)})

    def put(self, where: Any, other: Swing) -> None:
        """Takes over the motions of another one at some places."""
        for field in fields(self):
            getattr(self, field.name)[where] = getattr(other, field.name)

    @property
    def amplitude(self) -> Array:
        """Half of what the motion covers."""
        return 0.5 * (self.highest - self.lowest)

    @property
    def middle(self) -> Array:
        """Halfway between its turning points."""
        return 0.5 * (self.highest + self.lowest)


@analysis(swept=True, examples=("biased-pump", "--preset spring --set drive_frequency=0.3,0.4 --json"))
def settled(
    model: ConeModel,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """The settled motion under the full drive, and the linear response to the same drive.

    Over drive frequencies it is a frequency response whose points all start from ``initial``;
    `gelcone.frequency` sweeps up and down instead.

    Parameters
    ----------
    model : one actuator or an ensemble, with damping.
    initial : displacement and velocity at time 0, shape (2,) or ensemble shape + (2,). Default (1, 0).
    tolerance : relative error of one integration step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over the ensemble's dims with ``lowest``, ``highest`` and ``stroke`` (between them) of the displacement;
    ``period`` in forcing periods: 1 where the motion follows the forcing or dies out, more for subharmonics, 0 where
    none up to 16 was found (chaos, or not settled); over ``harmonic``, multiples of the drive frequency,
    ``harmonic_amplitude`` and ``harmonic_phase`` in degrees ahead of sin(harmonic omega t), where the voltage is
    sin(omega t); ``linear_stroke`` by linear theory (NaN where there is no equilibrium); ``validity_*`` as in `regime`;
    and ``outcome``, that of a member without damping being an error.

    Raises
    ------
    InputError : when no member has damping or can start.
    """
    states, members = start_states(model, initial), model.members()
    if not members.damped.any():
        raise InputError("damping_ratio = 0: without damping no motion settles; give it some")
    options: dict[str, Any] = {"tolerance": tolerance}
    found = settled_cells(members, states, **options, threads=threads, progress=progress)
    multiples = (("harmonic",), np.array(HARMONICS), "multiple of the drive frequency", "count")
    return dataset.label(
        model,
        found.variables,
        coords={"harmonic": multiples},
        outcome=found.outcome,
        options=options,
        title="settled motion",
    )


def settled_cells(
    members: Members,
    states: Array,
    *,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> Findings:
    """What `settled` finds of every member of a flattened ensemble from its state (members, N); options as there."""
    losing = members.damped
    found, linear = Swing.blank(members.size, states=states.shape[1]), np.full(members.size, np.nan)
    found.outcome[~losing] = Outcome.ERROR
    if losing.any():
        flow: dict[str, Any] = {"tolerance": tolerance, "threads": threads}
        found.put(losing, settled_swing(members.take(losing), states[losing], progress=progress, **flow))
    for row in np.flatnonzero(found.outcome == Outcome.OK):
        alone = single(members, int(row))
        linear[row] = linear_response(alone, np.array([alone.drive_frequency])).stroke[0]
    phase = np.where(np.abs(found.harmonics) > 0.0, np.degrees(np.angle(found.harmonics)), np.nan)
    return Findings(
        {
            "stroke": ((), 2.0 * found.amplitude, "stroke of the settled motion, peak to peak", "length"),
            "lowest": ((), found.lowest, "lowest displacement", "length"),
            "highest": ((), found.highest, "highest displacement", "length"),
            "period": ((), found.period, "period in forcing periods, 0 if none", "count"),
            "harmonic_amplitude": (("harmonic",), np.abs(found.harmonics), "amplitudes of harmonics 1 to 4", "length"),
            "harmonic_phase": (("harmonic",), phase, "their phases, degrees ahead of the voltage's", "angle"),
            "linear_stroke": ((), linear, "stroke by linear theory", "length"),
            **validity_variables(found.validity, found.outcome, members.system),
        },
        found.outcome,
    )


def swing(members: Members, states: Array, *, only_periodic: bool = False, **flow_options: Any) -> Swing:
    """Follows a flattened ensemble from ``states`` (members, N) at phase 0 over `REPEATS` forcing periods.

    ``only_periodic``: the validity, which takes the film's own lengths at each sample, of motions with a period alone.
    """
    run = _followed(members, states, **flow_options)
    found, spread = _extent(run), slice(None, None, SPREAD)
    at = found.period > 0 if only_periodic else np.ones(members.size, dtype=bool)
    if at.any():
        found.validity[at] = validity(members.take(at), run.times[at, spread], run.states[at, spread])
    return replace(found, harmonics=_harmonics(members, run.states[..., 0]))


def extent(members: Members, states: Array, **flow_options: Any) -> Swing:
    """What `swing` finds but for harmonics and validity, which stay NaN."""
    return _extent(_followed(members, states, **flow_options))


def _followed(members: Members, states: Array, **flow_options: Any) -> Trajectories:
    ticks = np.arange(1, REPEATS * SAMPLES + 1) / SAMPLES
    return integrate(members, states, members.forcing_period[:, None] * ticks, **flow_options)


def _extent(run: Trajectories) -> Swing:
    found = Swing.blank(len(run.states), states=run.states.shape[-1])
    x, points = run.states[..., 0], run.states[:, SAMPLES - 1 :: SAMPLES]
    period, _ = periods_of(points)
    return replace(
        found, lowest=-highest(-x), highest=highest(x), period=period, outcome=run.outcome, final=points[:, -1]
    )


def _harmonics(members: Members, x: Array) -> npt.NDArray[np.complex128]:
    """The complex harmonics (members, harmonics) of displacements that `_followed` sampled."""
    turn = np.broadcast_to(members.drive_frequency * members.forcing_period, members.shape)
    turns, which = np.unique(turn, return_inverse=True)
    waves = np.exp(-1j * turns[:, None] * (np.arange(1, x.shape[1] + 1) / SAMPLES))
    return np.stack([2j * (x * (waves**k)[which]).mean(axis=1) for k in HARMONICS], axis=1)


def highest(x: Array) -> Array:
    """Largest value of each row (members, samples), by the parabola through the largest sample and its neighbours."""
    at = np.clip(np.argmax(x, axis=1), 1, x.shape[1] - 2)
    before, here, after = (np.take_along_axis(x, at[:, None] + k, axis=1)[:, 0] for k in (-1, 0, 1))
    curvature = before - 2.0 * here + after
    rise = (before - after) ** 2 / np.where(curvature < 0.0, -8.0 * curvature, np.inf)
    return np.maximum(here + rise, x.max(axis=1))


def settled_swing(
    members: Members,
    states: Array,
    *,
    only_extent: bool = False,
    progress: Progress = None,
    **flow_options: Any,
) -> Swing:
    """The swing after a transient, rest having period 1; a motion whose points do not return yet is given more time.

    At first 20 decay times (at least 200 and a forcing period), and then up to `ROUNDS` - 1 times as long as all
    before. ``only_extent`` leaves out harmonics and validity, see `extent`.
    """
    counted = Counted(progress)
    found = Swing.blank(members.size, states=states.shape[1])
    found.final[:] = states
    duration = default_transient(members, repeats=1, longest_decay=np.inf)
    left = np.arange(members.size)
    for trial in range(ROUNDS):
        part = members.take(left)
        repeats = repeats_lasting(part, round_duration(duration[left], trial))
        share = weighted(counted, 0.5 ** (trial + 1))
        reached, outcome = settle(part, found.final[left], repeats, progress=share, **flow_options)
        ran = outcome == Outcome.OK
        found.outcome[left] = outcome
        left = left[ran]
        if left.size:
            part, begun = part.take(ran), reached[ran]
            followed_on = trial < ROUNDS - 1
            now = (
                extent(part, begun, **flow_options)
                if only_extent
                else swing(part, begun, only_periodic=followed_on, **flow_options)
            )
            found.put(left, now)
            left = left[(found.period[left] == 0) & (found.outcome[left] == Outcome.OK)]
        if not left.size:
            break
    # what is left of a motion that dies out has no period of its own
    found.period[(found.amplitude < REST_TOLERANCE) & (found.outcome == Outcome.OK)] = 1
    counted.finish()
    return found
