"""The settled motion at full drive: its lowest and highest displacement, its period, its harmonics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Outcome
from gelcone.dataset import Findings
from gelcone.devices.analysis import analysis
from gelcone.errors import InputError
from gelcone.motion.attractor.cycle import Cycles, sampled
from gelcone.motion.attractor.search import search
from gelcone.motion.columns import Columns
from gelcone.motion.electrical import MEANINGS, electrical, known_of
from gelcone.motion.extent import extent
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.linear import linear_response
from gelcone.motion.settle import check_budgets
from gelcone.motion.start import start_states
from gelcone.motion.validity import unknown, validity_variables
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.progress import Progress
from gelcone.quantity import Array, Time

if TYPE_CHECKING:
    import xarray as xr

REPEATS = 24
"""Forcing periods over which a motion without a period is sampled."""
SAMPLES = 128
"""Samples of a forcing period of which harmonics and what the source gives are made."""
HARMONICS = (1, 2, 3, 4)
"""Multiples of the drive frequency of which amplitude and phase are reported."""
ROUNDING = 1e-12
"""Harmonics below this share of the largest displacement are rounding."""


@dataclass(frozen=True)
class Swing(Columns):
    """Settled motions, arrays over the same dims: ``lowest`` and ``highest`` displacement, the ``period`` of the cycle
    in forcing periods (0: none), whether that is ``resting`` (of period 1), the ``outcome``, (..., harmonics) the
    complex ``harmonics`` - displacement is the sum of the imaginary parts of harmonic times exp(i k omega t) -, (...,
    N) the ``final`` states at phase 0, the ``mean`` displacement, the ``validity``
    (`gelcone.motion.validity.validity`), and what the source gives, (..., `gelcone.motion.electrical.MEANINGS`).
    """

    lowest: Array
    highest: Array
    period: npt.NDArray[np.int64]
    resting: npt.NDArray[np.bool_]
    outcome: npt.NDArray[np.int8]
    harmonics: npt.NDArray[np.complex128]
    final: Array
    mean: Array
    validity: Array
    source: Array

    @classmethod
    def blank(cls, *shape: int, states: int = 2) -> Swing:
        """Nothing known yet of motions with this number of states."""
        return cls(
            lowest=np.full(shape, np.nan),
            highest=np.full(shape, np.nan),
            period=np.zeros(shape, dtype=np.int64),
            resting=np.zeros(shape, dtype=bool),
            outcome=np.zeros(shape, dtype=np.int8),
            harmonics=np.full((*shape, len(HARMONICS)), np.nan + 0j),
            final=np.full((*shape, states), np.nan),
            mean=np.full(shape, np.nan),
            validity=unknown(*shape),
            source=np.full((*shape, len(MEANINGS)), np.nan),
        )

    @property
    def amplitude(self) -> Array:
        """Half of what the motion covers."""
        return 0.5 * (self.highest - self.lowest)

    @property
    def forcing_periods(self) -> npt.NDArray[np.int64]:
        """The period as results report it: 0 for a rest, too, which has none."""
        return np.where(self.resting, 0, self.period)

    @property
    def phases(self) -> Array:
        """Phases of the harmonics in degrees; NaN where the disc rests or a harmonic is rounding."""
        size = ROUNDING * np.maximum(np.abs(self.lowest), np.abs(self.highest))
        moves = (np.abs(self.harmonics) > size[..., None]) & ~self.resting[..., None]
        return np.where(moves, np.degrees(np.angle(self.harmonics)), np.nan)

    @property
    def middle(self) -> Array:
        """Halfway between its turning points."""
        return 0.5 * (self.highest + self.lowest)


@analysis(swept=True, examples=("biased-pump", "--preset spring --set drive_frequency=0.3,0.4 --json"))
def settled(
    model: ConeModel,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    transient: Time | None = None,
    patience: Time | None = None,
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
    transient, patience : as in `regime`; by default chaos is followed for 32 transients alone.
    tolerance : relative error of one integration step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over the ensemble's dims with ``lowest``, ``highest``, ``mean`` and ``stroke`` (between the first two) of
    the displacement; ``period`` in forcing periods as in `regime`: 1 where the motion follows the forcing, more for
    subharmonics, 0 where the disc is ``resting``, and where none up to 64 was found (chaos, or not settled); over
    ``harmonic``, multiples of the drive frequency, ``harmonic_amplitude`` and ``harmonic_phase`` in degrees ahead of
    sin(harmonic omega t), where the voltage is sin(omega t), NaN where there is no such motion; ``linear_stroke`` by
    linear theory (NaN without an equilibrium); the largest ``current`` into a film (infinite where the voltage jumps),
    the mean ``power`` that the source gives, and where more than the damper takes it ``damper_power``, ``film_power``,
    ``resistor_power`` (with what is lost where the voltage of an ideal source jumps), ``leak_power`` and
    ``dielectric_power``, which split it; the ``apparent_power`` (rms voltage times rms current) and the largest true
    ``field``; of films that creep or leak the mean ``heat`` in them over their volume and ``heating``, at which rate
    their temperature rises as long as they give no heat away; ``validity_*`` as in `regime`; and ``outcome``, that of a
    member without damping being an error.

    Raises
    ------
    InputError : for a transient or patience that is not positive, or when no member has damping or can start.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4)
    >>> motion = gelcone.settled(model)
    >>> f"stroke {motion.stroke.item():.5f}, by linear theory {motion.linear_stroke.item():.5f}"
    'stroke 0.41049, by linear theory 0.39872'
    """
    states, members = start_states(model, initial), model.members()
    if not members.damped.any():
        raise InputError("damping_ratio = 0: without damping no motion settles; give it some")
    options: dict[str, Any] = {"transient": transient, "patience": patience, "tolerance": tolerance}
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
    transient: float | None = None,
    patience: float | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> Findings:
    """Compute `settled` for every member of a flattened ensemble from its state (members, N); options as there."""
    check_budgets(transient=transient, patience=patience)
    losing = members.damped
    found, linear = Swing.blank(members.size, states=states.shape[1]), np.full(members.size, np.nan)
    found.outcome[~losing] = Outcome.ERROR
    if losing.any():
        options: dict[str, Any] = {
            "transient": transient,
            "patience": patience,
            "tolerance": tolerance,
            "threads": threads,
        }
        part = members.take(losing)
        found.put(losing, settled_swing(part, states[losing], source=True, progress=progress, **options))
    if (ran := found.outcome == Outcome.OK).any():
        part = members.take(ran)
        linear[ran] = linear_response(part, part.number("drive_frequency")[:, None]).stroke[:, 0]
    return Findings(
        {
            "stroke": ((), 2.0 * found.amplitude, "stroke of the settled motion, peak to peak", "length"),
            "lowest": ((), found.lowest, "lowest displacement", "length"),
            "highest": ((), found.highest, "highest displacement", "length"),
            "mean": ((), found.mean, "mean displacement", "length"),
            "period": ((), found.forcing_periods, "period in forcing periods, 0 if none", "count"),
            "resting": ((), found.resting.astype(np.int8), "1 if the disc is at rest", "code"),
            "harmonic_amplitude": (("harmonic",), np.abs(found.harmonics), "amplitudes of harmonics 1 to 4", "length"),
            "harmonic_phase": (("harmonic",), found.phases, "their phases ahead of the voltage's", "angle"),
            "linear_stroke": ((), linear, "stroke by linear theory", dataset.absent("length")),
            **{
                name: ((), found.source[:, list(MEANINGS).index(name)], *MEANINGS[name])
                for name in known_of(members.system)
            },
            **validity_variables(found.validity, found.outcome, members.system),
        },
        found.outcome,
    )


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

    Those on cycles of known ``period`` (members,) over whole turns and drive periods, those of period 0 over `REPEATS`
    forcing periods. ``only_extent`` leaves out harmonics and validity, which takes the film's own lengths at each
    sample; they stay NaN. So does what the ``source`` gives, unless it is asked for.
    """
    found = Swing.blank(members.size, states=states.shape[1])
    found.period[:] = 0 if period is None else period
    for own in np.unique(found.period):
        rows = np.flatnonzero(found.period == own)
        # two forcing periods are a whole number of the drive's
        repeats = int(own * (1 + own % 2)) or REPEATS
        part = members.take(rows)
        run = sampled(part, states[rows], repeats, SAMPLES, **flow_options)
        x = run.path[..., 0]
        found.lowest[rows], found.highest[rows] = extent(part, run.times, run.states)
        found.outcome[rows], found.final[rows], found.mean[rows] = run.outcome, run.path[:, -1], x.mean(axis=1)
        if source:
            spacing = (run.times.shape[1] - 1) // x.shape[1]
            of_source = electrical(part, run.times[:, spacing::spacing], run.path, states[rows], **flow_options)
            found.source[rows] = np.stack([of_source[name] for name in MEANINGS], axis=-1)
        if not only_extent:
            found.harmonics[rows] = harmonics_of(part, x, SAMPLES)
            found.validity[rows] = run.validity(part, turn=own > 0)
    return found


def harmonics_of(members: Members, x: Array, samples: int) -> npt.NDArray[np.complex128]:
    """The complex harmonics (members, harmonics) of displacements over whole drive periods, ``samples`` of them in a
    forcing period, the first one spacing after phase 0."""
    turn = np.broadcast_to(members.drive_frequency * members.forcing_period, members.shape)
    turns, which = np.unique(turn, return_inverse=True)
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
    """The swing of damped members on the attractor that a search finds from ``states`` (members, N), a rest having
    period 1; where it finds none, after the search. Options as in `settled`; ``only_extent`` and ``source`` as in
    `swing`."""
    reached = search(members, states, transient=transient, patience=patience, progress=progress, **flow_options)
    found = Swing.blank(members.size, states=states.shape[1])
    found.outcome[:] = reached.outcome
    rows = np.flatnonzero(reached.outcome == Outcome.OK)
    if rows.size:
        part, cycles = members.take(rows), reached.cycles.take(rows)
        found.put(
            rows, swing_of(part, cycles, reached.state[rows], only_extent=only_extent, source=source, **flow_options)
        )
    return found


def swing_of(members: Members, cycles: Cycles, states: Array, **options: Any) -> Swing:
    """`swing` on ``cycles``, and from ``states`` (members, N) where there is none."""
    begin = np.where(cycles.found[:, None], cycles.point, states)
    found = swing(members, begin, np.where(cycles.found, cycles.period, 0), **options)
    found.resting[:] = cycles.resting
    return found
