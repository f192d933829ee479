"""Operating limits: the ends of an operating envelope at the drive frequency of each member."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone import dataset
from gelcone.codes import Outcome
from gelcone.dataset import Findings
from gelcone.devices.analysis import analysis
from gelcone.errors import InputError
from gelcone.motion.driven import driven
from gelcone.motion.envelope import plane_of, pull_in_of, recommended_peaks
from gelcone.motion.plane import DRIVEN_LIMITS, Plane
from gelcone.motion.proportion import in_proportion, proportional
from gelcone.motion.start import inside, start_states
from gelcone.motion.static_bifurcations import PITCHFORK_ABSENT, PULL_IN_ABSENT
from gelcone.motion.static_limits import MEMBRANE_PULL_IN, STATIC_LIMITS, peaks_of, ramp_limits_of, with_first_pull_in
from gelcone.physics.film.pull_in import is_cone
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel, single
from gelcone.physics.system import ConeSystem
from gelcone.progress import Progress, advance
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr


@analysis(swept=True, examples=("biased-pump",))
def operating_limits(model: ConeModel, *, threads: int | None = None, progress: Progress = None) -> xr.Dataset:
    """Compute the peak voltage of each limit of operation: on a slow voltage ramp, and at the drive frequency.

    They are those of `envelope` from rest: quasi-static ones on the way to pull-in or the stretch limit, driven ones up
    to ``examined_voltage``, where the motion pulls in, or a little above the constant voltage of pull-in, or to twice
    the lowest quasi-static limit where that is less. Only the proportion of the member's voltages matters: amplitude
    and offset rise together. Of films in opposite phase quasi-static limits are those of the drive held at its peak, so
    that the offset rises with it; their names begin with ``proportional_``, since `limits` and `static` hold the
    member's offset. A wrinkling cone, and a taut one with a ``radius_ratio``, stands for a membrane, which pulls in at
    a lower voltage than the cone: ``pull_in_voltage`` is that of the cone itself, as in `limits` and `static`, and
    ``membrane_pull_in_voltage`` that of the membrane (infinity where it does not come before the cone's, NaN where it
    is unknown). The drive is limited by the first of them; the attribute ``pull_in_of`` says whose
    ``driven_pull_in_voltage`` is.

    Parameters
    ----------
    model : one actuator or an ensemble; its drive gives the proportion of amplitude to bias. Without a
        ``dielectric_strength`` breakdown is NaN and not accounted for.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over the ensemble's dims with a voltage for each of `STATIC_LIMITS` and, named ``driven_...``, of
    `DRIVEN_LIMITS` (infinity where one is not met, NaN where it does not apply): the lower, safe end of the interval in
    which the limit is first met, as in `envelope` and `drive`. ``driven_error_voltage`` is the largest width of these
    intervals (NaN where no limit is met); ``examined_step_voltage``, the distance between the peaks
    examined: a window of chaos narrower than that may be missed, and the first one met may then begin lower;
    ``safe_peak_voltage`` below all of them; and ``outcome``, that of a member without voltage being an error. Borders
    of chaos, and of pull-in out of chaos, are fractal: their intervals hold the voltages at which motions from four
    starts 1e-9 apart differ; limits of another run may lie higher or lower.

    Raises
    ------
    InputError : when every member is refused, as one without voltage is, with the reason of the first; or when the flat
        film lies beyond its stretch limit in all members.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4)
    >>> found = gelcone.operating_limits(model)
    >>> f"{found.safe_peak_voltage.item():.3f} +- {found.driven_error_voltage.item():.3f}"
    '0.901 +- 0.001'
    """
    start_states(model, (0.0, 0.0))
    findings, refused, whose = _limits_of_members(model.members(), threads, progress)
    if refused and not (findings.outcome == Outcome.OK).any():
        raise refused[0]
    result = dataset.label(model, findings.variables, outcome=findings.outcome, options={}, title="operating limits")
    return result.assign_attrs(pull_in_of=whose)


def operating_limits_cells(
    members: Members, states: Array, *, threads: int | None = None, progress: Progress = None
) -> Findings:
    """Compute `operating_limits` for every member of a flattened ensemble; the ``states`` are ignored, options as
    there."""
    return _limits_of_members(members, threads, progress)[0]


def _limits_of_members(
    members: Members, threads: int | None, progress: Progress
) -> tuple[Findings, list[InputError], str]:
    """The limits of all members, the errors of those that are refused, and whose the pull-in is: of the ``membrane``,
    of the ``cone``, or of one in some members and of the other in the rest."""
    limits = {name: np.full(members.size, np.nan) for name in _meanings(members.system, "")}
    refused = list[InputError]()
    whose = set[str]()
    outcome = np.full(members.size, Outcome.OUTSIDE, dtype=np.int8)
    for row in range(members.size):
        if inside(members, 0.0)[row]:
            try:
                plane = plane_of(single(members, row), threads)
                values, outcome[row] = _limits_of(plane), Outcome.OK
                whose.add(pull_in_of(plane))
            except InputError as error:
                values, outcome[row] = {}, Outcome.ERROR
                refused.append(error)
            for name, value in values.items():
                limits[name][row] = value
        advance(progress, 1.0 / members.size)
    owner = " or ".join(sorted(whose, reverse=True))
    late = np.isfinite(limits["driven pull-in"]) & (limits["driven chaos"] < limits["driven pull-in"])
    words = _meanings(members.system, owner)
    words["driven pull-in"] += OUT_OF_CHAOS if late.any() else ""
    lacking = " without radius_ratio" if owner == "cone" and "radius_ratio" not in members.values else ""
    variables: dict[str, dataset.Variable] = {
        limit_variable(name, members.system): ((), values, words[name], _limit(name, lacking))
        for name, values in limits.items()
    }
    return Findings(variables, outcome), refused, owner


def limit_variable(name: str, system: ConeSystem) -> str:
    """The name of the variable with the voltage of a limit."""
    variable = f"{name.replace(' ', '_').replace('-', '_')}_voltage"
    return proportional(variable, system) if name in (*STATIC_LIMITS, MEMBRANE_PULL_IN) else variable


def slow_limits(system: ConeSystem) -> tuple[str, ...]:
    """The names of the limits on a slow ramp: `STATIC_LIMITS`, with the pull-in of the membranes that cones stand
    for."""
    return (*STATIC_LIMITS, MEMBRANE_PULL_IN) if any(map(is_cone, system.films)) else STATIC_LIMITS


def _meanings(system: ConeSystem, of: str) -> dict[str, str]:
    """The meaning of each voltage by its name in `_limits_of`; that of pull-in says whose it is, ``of`` under the
    drive."""
    suffix = in_proportion(system)
    slow = f"limit of the drive held at its peak{suffix}" if suffix else "limit on a slow ramp to a constant voltage"
    fast = f"limit of the drive that is switched on from rest{suffix}"
    meanings = {
        "safe peak": f"peak voltage below every limit{suffix}",
        "examined": f"peak voltage up to which the driven motion was examined{suffix}",
        "examined step": "distance between the peaks examined, below which a window of chaos may be missed",
        "driven error": "largest width of the intervals that begin at the limits of the drive",
    }
    slow_names = slow_limits(system)
    whose = {"driven pull-in": f" of the {of}" if of else "", MEMBRANE_PULL_IN: " of the membrane"}
    whose["pull-in"] = " of the cone" if MEMBRANE_PULL_IN in slow_names else whose["driven pull-in"]
    meanings |= {name: f"{slow}: {name.removeprefix('membrane ')}" for name in slow_names}
    meanings |= {f"driven {name}": f"{fast}: {name}" for name in DRIVEN_LIMITS}
    return {name: words + whose.get(name, "") for name, words in meanings.items()}


def _limit(name: str, lacking: str) -> dict[str, str]:
    """The attributes of a variable with a limit; that of breakdown is unknown without a dielectric strength, and that
    of a membrane which cannot be computed, also as what it needs is ``lacking``."""
    if name in _ABSENT:
        return _ABSENT[name]
    infinite = "above the voltages examined" if name.startswith("driven") else "none before pull-in"
    nan = "unknown" if "breakdown" in name else "not applicable"
    return dataset.absent("voltage", f"unknown{lacking}" if name == MEMBRANE_PULL_IN else nan, infinite)


_ABSENT = {"pitchfork": PITCHFORK_ABSENT, "pull-in": PULL_IN_ABSENT}


OUT_OF_CHAOS = " out of chaos (other runs pull in lower or higher)"
"""Words for a limit of pull-in of a motion that was chaotic before."""


def _limits_of(plane: Plane) -> dict[str, float]:
    """The limits of a single model by the names in `_meanings`."""
    slow = ramp_limits_of(plane)
    static = with_first_pull_in(slow)
    volts = peaks_of(plane, static)
    intervals = driven(plane, np.array([float(plane.model.drive_frequency)]), volts, refine=False, progress=None)
    low, high = intervals["low"][0], intervals["high"][0]
    with np.errstate(invalid="ignore"):
        error = np.fmax.reduce(np.where(np.isfinite(high), high - low, np.nan))
    safe = recommended_peaks(intervals["low"], np.nanmin(static, initial=np.inf), volts, margin=0.0)[0]
    examined = np.fmin(high[DRIVEN_LIMITS.index("pull-in")], volts[-1])
    return (
        {"safe peak": float(safe), "examined": float(examined), "examined step": float(np.diff(volts).max())}
        | {"driven error": float(error)}
        | {name: float(value) for name, value in zip(slow_limits(plane.model.system), slow, strict=False)}
        | {f"driven {name}": float(value) for name, value in zip(DRIVEN_LIMITS, low, strict=True)}
    )
