"""The response to a step of the voltage: rise time, overshoot, settling time and drift."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import PPoly
from scipy.optimize import brentq

from gelcone import dataset
from gelcone.codes import Outcome
from gelcone.devices.analysis import analysis, check_one
from gelcone.errors import InputError
from gelcone.motion.constant_voltage import at_constant_voltages, biased_like
from gelcone.motion.flow import DEFAULT_TOLERANCE, integrate
from gelcone.motion.ramp import stroke_and_blocked_force
from gelcone.motion.rest import rest_under
from gelcone.motion.settle import check_budgets, check_default_duration, times_of_run
from gelcone.motion.state_space import equilibrium_under_bias
from gelcone.motion.static_results import constant_voltages, own_levels
from gelcone.motion.turning import acceleration_at, quintic, turning_share
from gelcone.motion.validity import validity_of_run, validity_variables
from gelcone.physics.model import ConeModel
from gelcone.progress import Progress, advance, weighted
from gelcone.quantity import Array, Time, Voltage, Voltages
from gelcone.register.analysis import CONSTANT_VOLTAGE

if TYPE_CHECKING:
    import xarray as xr

DECAYS = 8.0
"""Default length of a run, in decay times of the damping or of the slowest state of a component."""
RISE = (0.1, 0.9)
"""Shares of the way between which the rise time is taken."""
SETTLED = 0.02
"""Share of the way within which the disc has settled."""
STILL = 1e-9
"""Way, in b - a, below which the disc does not move."""
LATE = 0.1
"""Last share of the run, over which the end and the drift are taken."""
SAMPLES = 2001
"""Number of even times at which the last share of the run is evaluated for the end and the drift."""


@analysis(
    axes={"voltages": CONSTANT_VOLTAGE},
    answers="trajectories",
    single=True,
    file_only=("time", "displacement"),
    examples=(
        'biased-pump --over "constant_voltage=0.5 kV,1 kV" --out results',
        'biased-pump --film wrinkling --set "series_resistance=5 MOhm" --before "0.7 kV" --json',
    ),
)
def step(
    model: ConeModel,
    voltages: Voltages | None = None,
    *,
    before: Voltage | None = None,
    duration: Time | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Compute the disc's response to a step of the commanded voltage from one constant value to another.

    Parameters
    ----------
    model : a single actuator; its drive plays no part, but for the defaults of ``voltages`` and ``before``, and for
        its bias v0 where a second film in opposite phase has 2 v0 - v.
    voltages : constant commanded voltages after the step. Default: the peak of the drive and, where it has one, its
        offset, without the voltage ``before``.
    before : constant commanded voltage before the step, at which disc, film and circuit rest. Default 0; for films in
        opposite phase v0, which both then have.
    duration : time after the step. Default eight decay times of the damping, or of the slowest state of a component.
    tolerance : relative error of one integration step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset with the ``before_voltage``, over ``constant_voltage`` ``initial_displacement`` and ``final_displacement``,
    the displacement before the step and its mean over the last tenth of the run; ``rise_time``, from 10 to 90 % of the
    way between them, first passed; ``overshoot``, the furthest beyond the end over the way; ``settling_time``, after
    which the disc stays within 2 % of the way (NaN where it does not); ``drift``, by how much it still moves in the
    last tenth, over the way; ``equilibrium_displacement``, where a slow ramp to the voltage ends; and over ``time`` the
    ``displacement``. All but ``initial_displacement`` are NaN where the film pulls in, which the ``outcome`` says.
    ``validity_*`` are those of `simulate`, of the run after the step.

    Raises
    ------
    InputError : for an ensemble, voltages out of bounds, a ``before`` without an equilibrium, a duration that is not
        positive or too long, and a model without damping unless a duration is given.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(rest_height=0.8, hoop_prestretch=1.4, damping_ratio=0.2)
    >>> answer = gelcone.step(model, [0.6])
    >>> f"overshoot {answer.overshoot.item():.3f} of the way, settled after {answer.settling_time.item():.1f}"
    'overshoot 0.647 of the way, settled after 19.5'
    """
    check_one(model, "step")
    given = "voltage_bias =" if before is None else "before ="
    if before is None:
        before = abs(float(model.voltage_bias)) if model.system.in_opposite_phase else 0.0
    start = equilibrium_under_bias(model, before, given)
    levels = _levels(model, before) if voltages is None else constant_voltages(voltages)
    members = at_constant_voltages(model, levels).members()
    lasts = _duration(float(members.values["damping_ratio"][0]), float(members.time_constant[0]), duration)
    times = times_of_run(members, lasts)
    states = np.tile(rest_under(biased_like(model, before), start, before), (members.size, 1))
    run = integrate(members, states, times, tolerance=tolerance, threads=threads, progress=weighted(progress, 0.5))
    x, ran = run.states[..., 0], run.outcome == Outcome.OK
    pulls = acceleration_at(members, np.broadcast_to(times, x.shape), run.states)
    motion = np.stack([x, run.states[..., 1], pulls], axis=-1)
    numbers = {name: np.where(ran, values, np.nan) for name, values in _measured(times, motion, start).items()}
    numbers["initial_displacement"] = np.full(levels.size, start)
    numbers["equilibrium_displacement"] = stroke_and_blocked_force(model, levels)["displacement"].values
    advance(progress, 0.5)
    along = ("constant_voltage",)
    variables: dict[str, dataset.Variable] = {name: (along, numbers[name], *about) for name, about in _MEANINGS.items()}
    variables["displacement"] = ((*along, "time"), x, "displacement after the step", "length")
    valid = validity_variables(validity_of_run(members, run), run.outcome, members.system, along, "time")
    result = dataset.label(
        model,
        variables | valid,
        coords={
            "before_voltage": ((), before, "constant voltage before the step", "voltage"),
            "constant_voltage": (along, levels, "constant voltage after the step", "voltage"),
            "time": (("time",), times, "time after the step", "time"),
        },
        options={"before": before, "duration": duration, "tolerance": tolerance},
        title="step",
    )
    return result.assign(outcome=dataset.outcome_array(run.outcome, along))


_MEANINGS: dict[str, tuple[str, dataset.Of]] = {
    "initial_displacement": ("displacement before the step", "length"),
    "final_displacement": ("displacement in the last tenth of the run", "length"),
    "rise_time": ("time from 10 to 90 % of the way", "time"),
    "overshoot": ("furthest beyond the end, over the way", "share"),
    "settling_time": ("time after which it stays within 2 % of the way", "time"),
    "drift": ("change over the last tenth of the run, over the way", "share"),
    "equilibrium_displacement": ("displacement at which a slow ramp ends", "length"),
}


def _levels(model: ConeModel, before: float) -> Array:
    """The default voltages after a step from the voltage ``before``: that one alone if there is no other."""
    levels = own_levels(model)
    others = levels[levels != before]
    return others if others.size else levels


def _duration(damping_ratio: float, time_constant: float, given: float | None) -> float:
    """The length of the run. Raises `InputError` for one that is not positive, too long, or undefined."""
    if given is None and not damping_ratio > 0.0:
        raise InputError("damping_ratio = 0: without damping the disc never settles; give it some, or a duration")
    if given is not None:
        check_budgets(duration=given)
        return given
    damped, relaxed = DECAYS / damping_ratio, DECAYS * time_constant
    remedy = "give it more damping, or a duration"
    check_default_duration(damped, f"damping_ratio = {damping_ratio:g}: {DECAYS:g} decay times", remedy)
    check_default_duration(relaxed, f"duration: {DECAYS:g} time constants of the slowest state")
    return max(damped, relaxed)


def _measured(times: Array, motion: Array, start: float) -> dict[str, Array]:
    """Numbers of steps (members,) from displacement, velocity and acceleration (members, samples, 3); NaN where the
    disc does not move, and of a motion that has ended."""
    rows = [_of_path(times, path, start) if np.isfinite(path).all() else np.full(5, np.nan) for path in motion]
    names = ("final_displacement", "rise_time", "overshoot", "settling_time", "drift")
    return dict(zip(names, np.array(rows).T, strict=True))


def _of_path(times: Array, motion: Array, start: float) -> list[float]:
    """The numbers of one step, on the quintics through its samples; between the places, samples and turning points, the
    disc moves one way."""
    path, places = _path(times, motion)
    late = np.linspace(1.0 - LATE, 1.0, SAMPLES) * times[-1]
    end = float(path(late).mean())
    way = end - start
    if not abs(way) > STILL:
        return [end, *[np.nan] * 4]
    share = (path(places) - start) / way

    def passes(level: float, k: int) -> float:
        """The time at which the share of the way is ``level``, between two places."""
        return float(brentq(lambda time: (path(time) - start) / way - level, places[k], places[k + 1]))

    first = [passes(level, int(np.argmax(share >= level)) - 1) for level in RISE]
    last = int(np.flatnonzero(np.abs(share - 1.0) > SETTLED)[-1])
    settling = passes(1.0 + np.copysign(SETTLED, share[last] - 1.0), last) if last < places.size - 1 else np.nan
    drift = _slope(late, path(late)) * LATE * times[-1] / way
    return [end, first[1] - first[0], max(float(share.max()) - 1.0, 0.0), settling, drift]


def _path(times: Array, motion: Array) -> tuple[PPoly, Array]:
    """The quintics through displacements, velocities and accelerations (samples, 3), and the times of the samples and
    turning points."""
    gap, sides = np.diff(times), np.stack([motion[:-1], motion[1:]], axis=1)
    x, u, a = sides[..., 0], sides[..., 1] * gap[:, None], sides[..., 2] * (gap * gap)[:, None]
    below = [x[:, 0], u[:, 0], 0.5 * a[:, 0]]
    above = quintic(x[:, 1] - sum(below), u[:, 1] - u[:, 0] - a[:, 0], a[:, 1] - a[:, 0])
    terms = [term / gap**k for k, term in enumerate([*below, *above])]
    turns = np.flatnonzero(sides[:, 0, 1] * sides[:, 1, 1] < 0.0)
    shares = turning_share(gap[turns], *(np.moveaxis(sides[turns], -1, 0)))
    return PPoly(np.array(terms[::-1]), times), np.sort(np.append(times, times[turns] + shares * gap[turns]))


def _slope(times: Array, x: Array) -> float:
    """The slope of the straight line fitted to samples."""
    away = times - times.mean()
    return float((x * away).sum() / (away * away).sum())
