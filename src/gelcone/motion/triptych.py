"""Several motions for comparison: from the start, settled, in the phase plane and as a section, with their regimes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Outcome, Regime
from gelcone.devices.analysis import analysis
from gelcone.errors import InputError
from gelcone.motion.flow import DEFAULT_TOLERANCE, integrate
from gelcone.motion.regime import regime_cells
from gelcone.motion.section import section_cells
from gelcone.motion.settle import check_forcing_periods
from gelcone.motion.start import start_states
from gelcone.physics.model import ConeModel
from gelcone.progress import Progress, advance, weighted
from gelcone.quantity import Array, Time

if TYPE_CHECKING:
    import xarray as xr

MOST = 4
"""Most motions in one figure."""
PER_PERIOD, PER_OSCILLATION, MOST_SAMPLES = 60, 26, 20_000
"""Fewest samples of a drive period and of an oscillation, and most samples of a curve."""
SECTION_POINTS = 600
"""Points of the section of a motion that does not repeat."""

_CURVES = ("time", "displacement", "velocity")
_LONG = (*_CURVES, *(f"late_{name}" for name in _CURVES), "section_displacement", "section_velocity")


@analysis(
    answers="motions",
    file_only=_LONG,
    examples=("--preset base --set voltage=0.5,1.04,1.7 --out results", 'biased-pump --set "frequency=8 Hz,10 Hz"'),
)
def triptych(
    model: ConeModel,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    periods: int = 20,
    late_periods: int = 8,
    transient: Time | None = None,
    patience: Time | None = None,
    budget: Time = 20_000.0,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Up to four motions side by side, as in figure 7 of the paper, for any parameter: a column for each.

    Parameters
    ----------
    model : one actuator, or an ensemble of at most four.
    initial : displacement and velocity at time 0, shape (2,) or ensemble shape + (2,). Default (1, 0).
    periods : drive periods that are shown from the start. Default 20.
    late_periods : drive periods that are shown of the settled motion. Default 8.
    transient, patience, budget : as in `regime`.
    tolerance : relative error of one integration step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over the ensemble's dims with the variables of `regime`; from the start ``time``, ``displacement`` and
    ``velocity`` over ``sample``; of the motion that followed the search for its regime ``late_time`` from a multiple of
    the forcing period on, ``late_displacement`` and ``late_velocity`` over ``late_sample``; and
    ``section_displacement`` and ``section_velocity`` over ``repeat``, once every forcing period. NaN from where a
    member failed.

    Raises
    ------
    InputError : for more than four members, no periods, and as `regime`.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(spring_stiffness=0.5, drive_frequency=0.3, voltage=[0.4, 0.9])
    >>> found = gelcone.triptych(model, periods=4, late_periods=2)
    >>> [gelcone.Regime(code).label for code in found.regime.values], round(float(found.late_displacement[1].max()), 4)
    (['rest', 'periodic'], 0.6743)
    """
    check_forcing_periods(model.members(), 1, periods=periods, late_periods=late_periods)
    if model.size > MOST:
        raise InputError(f"triptych: was given {model.size} motions; give at most {MOST}, as --set voltage=0.5,1,2")
    states, members = start_states(model, initial), model.members()
    flow: dict[str, Any] = {"tolerance": tolerance, "threads": threads}
    budgets: dict[str, Any] = {"transient": transient, "patience": patience, "budget": budget}
    findings = regime_cells(members, states, **budgets, **flow, progress=weighted(progress, 0.7))
    section = findings.variables["section"][1]
    late = np.where(np.isfinite(section[:, -1]), section[:, -1], states)
    kinds = findings.variables["regime"][1]
    points = section_cells(members, late, repeats=SECTION_POINTS, discard=0, **flow, progress=weighted(progress, 0.2))
    open_ended = ~np.isin(kinds, (Regime.REST, Regime.PERIODIC))[:, None]
    ran = (findings.outcome == Outcome.OK)[:, None]
    repeats = np.arange(SECTION_POINTS) < np.where(open_ended, SECTION_POINTS, section.shape[1])
    first, after = (_sampled(count, members.drive_period, members.rate) for count in (periods, late_periods))
    runs = integrate(members, states, first, **flow), integrate(members, late, after, **flow)
    advance(progress, 0.1)
    variables: dict[str, dataset.Variable] = {
        name: variable for name, variable in findings.variables.items() if name != "section"
    }
    for prefix, run, dim, shown in (("", runs[0], "sample", True), ("late_", runs[1], "late_sample", ran)):
        for name, values, quantity in (
            ("time", run.times, "time"),
            ("displacement", run.states[..., 0], "length"),
            ("velocity", run.states[..., 1], "velocity"),
        ):
            variables[prefix + name] = ((dim,), np.where(shown, values, np.nan), _WORDS[prefix + name], quantity)
    for name, quantity in (("displacement", "length"), ("velocity", "velocity")):
        values = np.where(ran & repeats, points.variables[name][1], np.nan)
        variables[f"section_{name}"] = (("repeat",), values, f"{name} once every forcing period", quantity)
    options = budgets | {"periods": periods, "late_periods": late_periods, "tolerance": tolerance}
    result = dataset.label(model, variables, outcome=findings.outcome, options=options, title="triptych")
    return dataset.with_initial(result, model, states)


_WORDS = {
    "time": "time from the start",
    "displacement": "displacement from the start",
    "velocity": "velocity from the start",
    "late_time": "time after the search for the regime, from a whole forcing period on",
    "late_displacement": "displacement of the settled motion",
    "late_velocity": "velocity of the settled motion",
}


def _sampled(periods: int, period: Array, rate: Array) -> Array:
    """Even times over some drive periods, (members, samples), equally many for all members."""
    span = np.broadcast_to(periods * period, rate.shape)
    wanted = max(PER_PERIOD * periods, int((PER_OSCILLATION * rate * span / (2.0 * np.pi)).max()))
    return span[:, None] * np.linspace(0.0, 1.0, min(wanted, MOST_SAMPLES) + 1)
