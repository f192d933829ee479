"""Voltages that bound the use of an actuator: onset of motion under the drive, static pitchfork, pull-in."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone import dataset
from gelcone.codes import Outcome
from gelcone.dataset import Findings
from gelcone.devices.analysis import analysis
from gelcone.motion.floquet import onset_voltage
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.proportion import at_own_bias
from gelcone.motion.start import inside, start_states
from gelcone.motion.static_bifurcations import (
    PITCHFORK,
    PITCHFORK_ABSENT,
    PULL_IN,
    PULL_IN_ABSENT,
    PULL_IN_KIND,
    jump_voltages,
    of_the_cone,
    pitchfork_voltages,
)
from gelcone.physics.balance import PullIn
from gelcone.physics.film.at_once import films_at_once
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.physics.statics import every_balance
from gelcone.progress import Progress, advance, weighted
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr


@analysis(swept=True, examples=("--preset base --set prestretch=0.8:1.2:5", "paper-table1 --json"))
def limits(
    model: ConeModel,
    *,
    at_once: bool = False,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Compute the voltages at which the film pulls in, the disc jumps, or a flat film starts to move.

    Parameters
    ----------
    model : one actuator or an ensemble; its voltage plays no part.
    at_once : pitchfork and pull-in of a film that creeps when the voltage has just been applied, before the film
        relaxes. Default those of the relaxed film.
    tolerance : relative error of one integration step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over the ensemble's dims: ``onset_voltage``, the amplitude at which the flat film under the drive loses its
    stability, and the width ``onset_error`` to which it is known (`gelcone.onset_voltage`; infinity where it stays
    stable up to the highest voltage searched, NaN where the film does not rest flat); ``pitchfork_voltage``
    (`gelcone.pitchfork_voltage`); ``pull_in_voltage``, at which the disc jumps or a film pulls in on a slow ramp
    (infinity if never; a pitchfork from which the disc rises gradually is not one; of the film as given: a cone stands
    for a membrane that pulls in earlier, see `operating_limits`), and ``pull_in_kind``, how (a `PullIn`); and
    ``outcome``.

    Raises
    ------
    InputError : when the flat film lies beyond its stretch limit in all members.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(spring_stiffness=0.5, drive_frequency=0.5)
    >>> found = gelcone.limits(model)
    >>> f"onset {found.onset_voltage.item():.5f}, pitchfork {found.pitchfork_voltage.item():.5f}"
    'onset 0.59953, pitchfork 0.70711'
    """
    states = start_states(model, (0.0, 0.0))
    options: dict[str, Any] = {"at_once": at_once, "tolerance": tolerance}
    findings = limits_cells(model.members(), states, **options, threads=threads, progress=progress)
    return dataset.label(model, findings.variables, outcome=findings.outcome, options=options, title="limits")


def limits_cells(
    members: Members,
    states: Array,
    *,
    at_once: bool = False,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> Findings:
    """Compute `limits` for every member of a flattened ensemble; the ``states`` are ignored, options as there."""
    voltages = {name: np.full(members.size, np.nan) for name in _MEANINGS}
    outcome = np.full(members.size, Outcome.OUTSIDE, dtype=np.int8)
    kind = np.full(members.size, PullIn.NEVER, dtype=np.int8)
    reachable = inside(members, 0.0)
    flat = reachable & members.symmetric
    if reachable.any():
        reached = members.take(reachable)
        outcome[reachable] = Outcome.OK
        held = films_at_once(reached) if at_once else reached
        voltages["pitchfork_voltage"][reachable] = pitchfork_voltages(every_balance(held))
        voltages["pull_in_voltage"][reachable], kind[reachable] = jump_voltages(held)
    advance(progress, 0.1 if flat.any() else 1.0)
    if flat.any():
        onset = onset_voltage(
            members.take(flat), tolerance=tolerance, threads=threads, progress=weighted(progress, 0.9)
        )
        outcome[flat] = onset["outcome"]
        for name in ("onset_voltage", "onset_error"):
            voltages[name][flat] = onset[name]
        stays = flat & (outcome == Outcome.OK) & np.isnan(voltages["onset_voltage"])
        voltages["onset_voltage"][stays] = np.inf
    endings = dict.fromkeys(("pitchfork_voltage", "pull_in_voltage"), at_own_bias(members.system))
    endings["pull_in_voltage"] += of_the_cone(members.system)
    variables: dict[str, dataset.Variable] = {
        n: ((), voltages[n], meaning + endings.get(n, ""), _ABSENT[n]) for n, meaning in _MEANINGS.items()
    }
    return Findings(variables | {"pull_in_kind": ((), kind, PULL_IN_KIND, PullIn)}, outcome)


_MEANINGS = {
    "onset_voltage": "voltage amplitude at which the flat film loses stability",
    "onset_error": "uncertainty of the onset",
    "pitchfork_voltage": PITCHFORK,
    "pull_in_voltage": PULL_IN,
}
_ABSENT = {
    "onset_voltage": dataset.absent("voltage", infinite="none found"),
    "onset_error": dataset.absent("voltage"),
    "pitchfork_voltage": PITCHFORK_ABSENT,
    "pull_in_voltage": PULL_IN_ABSENT,
}
