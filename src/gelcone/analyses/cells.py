"""Cell functions and public functions of analyses that `gelcone.motion` does not give by these names yet."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Outcome
from gelcone.errors import InputError
from gelcone.motion.driven import DRIVEN_LIMITS
from gelcone.motion.envelope import STATIC_LIMITS, limits_at
from gelcone.motion.equilibrium import pitchfork_voltage, pull_in_voltage
from gelcone.motion.floquet import onset_voltage
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.linear import linear_response
from gelcone.motion.lyapunov import lyapunov
from gelcone.motion.regime import classify, label_evidence
from gelcone.motion.response import start_states
from gelcone.motion.swing import Swing, settled_swing
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

Progress = Callable[[float], None] | None


class Findings(NamedTuple):
    variables: Mapping[str, dataset.Variable]
    outcome: npt.NDArray[np.int8]


def _findings(result: xr.Dataset) -> Findings:
    variables = {
        str(name): (tuple(map(str, v.dims[1:])), v.values, v.attrs["long_name"], v.attrs.get("quantity", "code"))
        for name, v in result.data_vars.items()
        if name != "outcome"
    }
    return Findings(variables, result["outcome"].values)


def lyapunov_cells(
    members: ConeModel, states: Array, *, threads: int | None = None, progress: Progress = None, **options: Any
) -> Findings:
    return _findings(lyapunov(members, states, threads=threads, **options))


def regime_cells(
    members: ConeModel, states: Array, *, threads: int | None = None, progress: Progress = None, **options: Any
) -> Findings:
    return _findings(label_evidence(members, classify(members, states, threads=threads, **options), {}, "regime"))


def limits_cells(
    members: ConeModel, states: Array, *, threads: int | None = None, progress: Progress = None, **options: Any
) -> Findings:
    inside = np.flatnonzero(members.strain(np.zeros(members.size)) < members.strain_limit())
    found = np.full((4, members.size), np.nan)
    outcome = np.full(members.size, Outcome.OUTSIDE, dtype=np.int8)
    if inside.size:
        part = members.take(inside)
        onset = onset_voltage(part, tolerance=options["tolerance"], threads=threads)
        found[:, inside] = [
            onset["onset_voltage"],
            onset["onset_error"],
            np.broadcast_to(pitchfork_voltage(part), part.shape),
            pull_in_voltage(part)["pull_in_voltage"],
        ]
        outcome[inside] = onset["outcome"]
    return Findings(
        {
            "onset_voltage": ((), found[0], "voltage amplitude at which rest loses stability", "voltage"),
            "onset_error": ((), found[1], "width to which the onset is known", "voltage"),
            "pitchfork_voltage": ((), found[2], "constant voltage at which the flat film loses stability", "voltage"),
            "pull_in_voltage": ((), found[3], "constant voltage at which the equilibrium is lost", "voltage"),
        },
        outcome,
    )


def settled_cells(
    members: ConeModel, states: Array, *, threads: int | None = None, progress: Progress = None, **options: Any
) -> Findings:
    damped = np.broadcast_to(members.damping_ratio, members.shape) > 0.0
    found, linear = Swing.blank(members.size), np.full(members.size, np.nan)
    found.outcome[~damped] = Outcome.ERROR
    if damped.any():
        flow = {"tolerance": options["tolerance"], "threads": threads}
        found.put(damped, settled_swing(members.take(damped), states[damped], **flow))
    for cell in np.flatnonzero(found.outcome == Outcome.OK):
        alone = members.take(cell)
        linear[cell] = linear_response(alone, np.array([alone.drive_frequency])).stroke[0]
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
        },
        found.outcome,
    )


def operating_limits_cells(
    members: ConeModel, states: Array, *, threads: int | None = None, progress: Progress = None, **options: Any
) -> Findings:
    meanings = {"safe peak": "below every limit", "driven error": "width to which the driven limits are known"}
    meanings |= {name: f"quasi-static limit: {name}" for name in STATIC_LIMITS}
    meanings |= {f"driven {name}": f"limit at the drive frequency: {name}" for name in DRIVEN_LIMITS}
    found = {name: np.full(members.size, np.nan) for name in meanings}
    outcome = np.full(members.size, Outcome.OUTSIDE, dtype=np.int8)
    for cell in np.flatnonzero(members.strain(np.zeros(members.size)) < members.strain_limit()):
        try:
            values, outcome[cell] = limits_at(members.take(cell), options["field_limit"]), Outcome.OK
        except InputError:
            values, outcome[cell] = {}, Outcome.ERROR
        for name, value in values.items():
            found[name][cell] = value
    variables = {
        f"{name.replace(' ', '_').replace('-', '_')}_voltage": ((), values, meanings[name], "voltage")
        for name, values in found.items()
    }
    return Findings(variables, outcome)


def _public(
    cells: Callable[..., Findings],
    title: str,
    model: ConeModel,
    initial: npt.ArrayLike,
    threads: int | None,
    progress: Progress,
    **options: Any,
) -> xr.Dataset:
    flat = model.take(slice(None))
    found = cells(flat, start_states(model, initial), threads=threads, **options)
    if progress is not None:
        progress(1.0)
    return dataset.label(model, found.variables, outcome=found.outcome, options=options, title=title)


def limits(
    model: ConeModel,
    *,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Voltages that bound the use: loss of stability of rest under the drive, pitchfork, pull-in.

    Parameters
    ----------
    model : one actuator or an ensemble.
    tolerance : relative error of one integration step. Default 1e-15.
    threads : worker threads. Default one a core.
    """
    return _public(limits_cells, "limits", model, (0.0, 0.0), threads, progress, tolerance=tolerance)


def settled(
    model: ConeModel,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """The settled motion at full drive, and the linear response to it.

    Parameters
    ----------
    model : one actuator or an ensemble.
    initial : displacement and velocity at time 0, shape (2,) or ensemble shape + (2,). Default (1, 0).
    tolerance : relative error of one integration step. Default 1e-15.
    threads : worker threads. Default one a core.
    """
    return _public(settled_cells, "settled motion", model, initial, threads, progress, tolerance=tolerance)


def operating_limits(
    model: ConeModel,
    *,
    field_limit: float | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Peak voltages at which an operating envelope ends, at the model's own drive frequency.

    Parameters
    ----------
    model : one actuator or an ensemble; its drive must not be 0.
    field_limit : dielectric strength over sqrt(mu/eps). Default unknown.
    threads : worker threads. Default one a core.
    """
    return _public(
        operating_limits_cells, "operating limits", model, (0.0, 0.0), threads, progress, field_limit=field_limit
    )
