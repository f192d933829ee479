"""Settled motion at full drive: lowest and highest displacement, period, harmonics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Outcome
from gelcone.dataset import Findings
from gelcone.devices.analysis import analysis
from gelcone.errors import InputError
from gelcone.motion.averages import AVERAGES
from gelcone.motion.electrical import MEANINGS, known_of
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.linear import linear_response, quantity_of_stroke
from gelcone.motion.settle import check_budgets
from gelcone.motion.start import start_states
from gelcone.motion.swing import Swing, settled_swing
from gelcone.motion.validity import validity_variables
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.progress import Counted, Progress, weighted
from gelcone.quantity import Array, Time

if TYPE_CHECKING:
    import xarray as xr

AT_REST = 1e-12
"""Dimensionless current, power or field of a disc at rest below which it is rounding."""


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
    """Compute the motion once its transient has decayed, and the linear response to the same drive.

    Over drive frequencies this is a frequency response whose points all start from ``initial``; `gelcone.frequency`
    sweeps up and down instead.

    Parameters
    ----------
    model : one actuator or an ensemble, with damping.
    initial : displacement and velocity at time 0, shape (2,) or ensemble shape + (2,). Default (1, 0).
    transient : as in `regime`.
    patience : as in `regime`. Default that of `regime`, but for chaos at most 32 transients.
    tolerance : relative error of one integration step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over the ensemble's dims with ``lowest``, ``highest``, ``mean`` and ``stroke`` (between the first two) of
    the displacement; ``period`` in forcing periods as in `regime`: 1 for a motion that follows the forcing, more for
    subharmonics, 0 if the disc is ``resting`` or if no period up to 64 was found (chaos, or not settled); over
    ``harmonic``, multiples of the drive frequency, ``harmonic_amplitude`` and ``harmonic_phase`` in degrees ahead of
    sin(harmonic omega t), for the voltage sin(omega t), NaN for a harmonic that vanishes; ``linear_stroke`` by linear
    theory with all harmonics of the drive (NaN without an equilibrium, and for more than some 700,000 harmonics); the
    largest ``current`` of a source (infinite if the voltage jumps); the mean ``power`` of the source, and if there are
    losses besides those of the damper its parts ``damper_power``, ``film_power``, ``resistor_power`` (with the loss at
    jumps of an ideal source's voltage), ``leak_power`` and ``dielectric_power``; the ``apparent_power`` (rms voltage
    times rms current) and the largest true ``field``; for films that creep or leak the mean ``heat`` in them over their
    volume and ``heating``, the rate at which their temperature rises while they give no heat away; the
    ``..._standard_error`` of each average, 0 for a motion that repeats: averages of one that does not are over 512
    forcing periods, and those of another run differ by their errors, its extremes by more; ``validity_*`` as in
    `regime`; and ``outcome``, an error for a member without damping.

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
    findings = settled_cells(members, states, **options, threads=threads, progress=progress)
    return dataset.label(model, findings.variables, outcome=findings.outcome, options=options, title="settled motion")


def _meaning(name: str) -> tuple[str, dataset.Of]:
    """The meaning and quantity of an average."""
    return ("mean displacement", "length") if name == "mean" else MEANINGS[name]


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
    budgets: dict[str, Any] = {"transient": transient, "patience": patience}
    check_budgets(**budgets)
    counted = Counted(progress)
    flow: dict[str, Any] = {"tolerance": tolerance, "threads": threads, "progress": weighted(counted, 0.5)}
    losing = members.damped
    swings, linear = Swing.blank(members.size, states=states.shape[1]), np.full(members.size, np.nan)
    swings.outcome[~losing] = Outcome.ERROR
    if losing.any():
        group = members.take(losing)
        swings.put(losing, settled_swing(group, states[losing], source=True, **budgets, **flow))
    rounding = swings.resting.astype(bool)[:, None] & (np.abs(swings.source) < AT_REST)
    swings.source[rounding] = 0.0
    if (ran := swings.outcome == Outcome.OK).any():
        group = members.take(ran)
        linear[ran] = linear_response(group, group.number("drive_frequency")[:, None]).stroke[:, 0]
    counted.finish()
    return Findings(
        {
            "stroke": ((), 2.0 * swings.amplitude, "stroke of the settled motion, peak to peak", "length"),
            "lowest": ((), swings.lowest, "lowest displacement", "length"),
            "highest": ((), swings.highest, "highest displacement", "length"),
            "mean": ((), swings.mean, *_meaning("mean")),
            "period": ((), swings.forcing_periods, "period in forcing periods, 0 if none", "count"),
            "resting": ((), swings.resting.astype(np.int8), "1 if the disc is at rest", "code"),
            "harmonic_amplitude": (("harmonic",), np.abs(swings.harmonics), "amplitudes of harmonics 1 to 4", "length"),
            "harmonic_phase": (("harmonic",), swings.phases, "phases of harmonics ahead of the voltage", "angle"),
            "linear_stroke": ((), linear, "stroke by linear theory", quantity_of_stroke(members, linear)),
            **{
                name: ((), swings.source[:, list(MEANINGS).index(name)], *MEANINGS[name])
                for name in known_of(members.system)
            },
            **{
                f"{name}_standard_error": ((), swings.errors[:, k], f"standard error: {_meaning(name)[0]}", quantity)
                for k, (name, quantity) in enumerate((name, _meaning(name)[1]) for name in AVERAGES)
                if name in {"mean", *known_of(members.system)}
            },
            **validity_variables(swings.validity, swings.outcome, members.system),
        },
        swings.outcome,
    )
