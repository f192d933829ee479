"""Poincare section: the states once every forcing period."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.dataset import Findings, with_initial
from gelcone.devices.analysis import analysis
from gelcone.errors import InputError
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.settle import check_forcing_periods, pieces, settle
from gelcone.motion.start import start_states
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.progress import Progress, split_progress
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr


@analysis(
    answers="trajectories", examples=("--set voltage=1.7 --set drive_frequency=0.1 --repeats 2000 --out results",)
)
def section(
    model: ConeModel,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    repeats: int = 500,
    discard: int = 200,
    phase: float = 0.0,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Compute the stroboscopic Poincare section: the states once every forcing period.

    Parameters
    ----------
    model : one actuator or an ensemble.
    initial : displacement and velocity at time 0, shape (2,) or ensemble shape + (2,). Default (1, 0).
    repeats : number of points, one a forcing period: pi/omega for a pure sine, as the force goes with the square of the
        voltage, and 2 pi/omega with a bias. Default 500.
    discard : forcing periods that pass before the first point, so that the motion settles. Default 200.
    phase : where in the forcing period the points are taken, from 0 (the voltage's sine starts) up to but not including
        1. Default 0.
    tolerance : relative error of one step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over the ensemble's dims and ``repeat`` (numbered from the start of the run) with ``displacement``,
    ``velocity`` and any further state at ``time``, NaN from where a member failed; and ``outcome``.

    Raises
    ------
    InputError : for no repeats, a negative discard, a phase outside [0, 1), or an initial state of which no member
        lies inside its stretch limit.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4)
    >>> points = gelcone.section(model, repeats=3)
    >>> points.displacement.values.round(6).tolist()
    [0.675847, 0.675847, 0.675847]
    """
    phase = _checked_phase(phase)
    states0, members = start_states(model, initial), model.members()
    options: dict[str, Any] = {"repeats": repeats, "discard": discard, "phase": phase, "tolerance": tolerance}
    findings = section_cells(members, states0, **options, threads=threads, progress=progress)
    numbers = discard + np.arange(repeats)
    times = (numbers + phase) * members.forcing_period[:, None]
    shared = bool((times == times[0]).all())
    result = dataset.label(
        model,
        findings.variables,
        coords={
            "repeat": (("repeat",), numbers, "forcing periods since the start", "count"),
            "time": (("repeat",), times[0] if shared else times, "time", "time"),
        },
        outcome=findings.outcome,
        options=options,
        title="Poincare section",
    )
    return with_initial(result, model, states0)


def section_cells(
    members: Members,
    states: Array,
    *,
    repeats: int = 500,
    discard: int = 200,
    phase: float = 0.0,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> Findings:
    """Compute `section` for every member of a flattened ensemble from its state (members, N); options as there."""
    check_forcing_periods(members, 1, repeats=repeats)
    check_forcing_periods(members, discard=discard)
    phase = _checked_phase(phase)
    flow: dict[str, Any] = {"tolerance": tolerance, "threads": threads}
    settling, sampling = split_progress(progress, discard, repeats)
    settled, outcome = settle(members, states, discard, progress=settling, **flow)
    points = np.full((members.size, repeats, len(members.system.states)), np.nan)
    for piece in pieces(members, settled, repeats, [phase], outcome=outcome, progress=sampling, **flow):
        points[:, piece.first : piece.first + piece.repeats] = piece.states[:, :-1]
        outcome = piece.outcome
    return Findings(
        {
            "displacement": (("repeat",), points[..., 0], "displacement x = h/(b-a)", "length"),
            "velocity": (("repeat",), points[..., 1], "velocity of the disc", "velocity"),
        }
        | {
            state.name: (("repeat",), points[..., k], state.meaning, state.quantity)
            for k, state in enumerate(members.system.states[2:], start=2)
        },
        outcome,
    )


def _checked_phase(phase: Any) -> float:
    try:
        value = float(phase)
    except (TypeError, ValueError):
        raise InputError(f"phase = {phase!r}: must be a number") from None
    if not 0.0 <= value < 1.0:
        raise InputError(f"phase = {value:g}: must be at least 0 and below 1, the share of the forcing period gone by")
    return value
