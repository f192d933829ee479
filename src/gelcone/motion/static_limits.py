"""The quasi-static half of an operating envelope: limits on a slow voltage ramp, and while a voltage is held."""

from __future__ import annotations

import math

import numpy as np

from gelcone.errors import InputError
from gelcone.motion.creep import Holding, holding
from gelcone.motion.equilibrium import stroke_and_blocked_force
from gelcone.motion.natural import frequency_of
from gelcone.motion.plane import Plane, is_flat
from gelcone.motion.validity import NEAR_LIMIT, excesses
from gelcone.physics.bracket import first_passing
from gelcone.physics.film.pull_in import PullInCurve
from gelcone.physics.model import ConeModel
from gelcone.progress import Progress
from gelcone.quantity import Array

STATIC_LIMITS = ("dielectric breakdown", "hoop slack", "meridional slack", "stretch limit", "pitchfork", "pull-in")
PEAKS = (1.0 / 12.0, 2.0, 24)
"""Peak voltages over the model's own that are examined: from, to, how many."""
STATIC_POINTS = 400
LATER = 2.0
"""Constant voltages up to which a membrane's pull-in is searched for, over the largest of its own."""
HELD_LEVELS = 32
"""Constant voltages that are held for a duration."""


# --- quasi-static ---------------------------------------------------------------------------------------------------


def static_limits_of(plane: Plane, peaks: Array) -> tuple[dict[str, Array], Array]:
    """`_static` up to the largest of the driven peaks, and at least to twice the model's own."""
    return _static(plane, max(float(peaks[-1]), PEAKS[1] * float(plane.model.peak_voltage)))


def _static(plane: Plane, highest: float) -> tuple[dict[str, Array], Array]:
    """Curves over the constant peak voltage of a drive in proportion, and the voltage of each of `STATIC_LIMITS`, of
    either film."""
    model, levels = plane.model, np.linspace(0.0, highest, STATIC_POINTS + 1)
    ramp = plane.ramp(levels)
    x, n = ramp.displacement, model.own_numbers
    states = [film.state(x, v, [], n) for film, v in zip(model.system.films, ramp.voltages, strict=True)]
    curves = {
        "peak_voltage": levels,
        "static_displacement": x,
        "stroke": ramp.stroke,
        "blocked_force": ramp.blocked_force,
        "natural_frequency": frequency_of(ramp.stiffness),
        "static_field": states[0].true_field,
        "static_hoop_stress": states[0].hoop_stress,
        "static_meridional_stress": states[0].meridional_stress,
    }
    leaks = model.system.leaking_at_rest(x, ramp.voltages, n)
    if any(np.any(leak) for leak in leaks):
        curves["static_heating"] = sum(leaks) / len(leaks) + 0.0 * x
    strength = np.nan if model.dielectric_strength is None else model.dielectric_strength
    excess = [
        (s.true_field - strength, -s.hoop_stress, -s.meridional_stress, s.limit_share - NEAR_LIMIT) for s in states
    ]
    limits = np.array([[first_passing(levels, of_limit) for of_limit in film] for film in excess]).min(axis=0)
    limits[0] = np.nan if np.isnan(strength) else limits[0]
    pull_in = ramp.pull_in
    if plane.membrane is not None:
        pull_in = min(pull_in, _membrane_pull_in(model, plane.membrane, pull_in))
    return curves, np.array([*limits, ramp.pitchfork if is_flat(model) else np.nan, pull_in])


def _membrane_pull_in(model: ConeModel, membrane: PullInCurve, highest: float) -> float:
    """Constant voltage up to ``highest`` at which the membrane pulls in where the ramp has led; infinity if none."""
    known = membrane.voltage(np.linspace(0.0, membrane.reach, STATIC_POINTS))
    if not np.isfinite(known).any():
        return math.inf
    # where it pulls in at all, it has at the largest of these; the ramp may come there later
    levels = np.linspace(0.0, min(highest, LATER * known[np.isfinite(known)].max()), STATIC_POINTS + 1)
    return first_passing(
        levels, levels - membrane.voltage(stroke_and_blocked_force(model, levels)["displacement"].values)
    )


# --- held for a while -----------------------------------------------------------------------------------------------


def hold(plane: Plane, duration: float, up_to: float, progress: Progress) -> Holding:
    """Constant voltages up to ``up_to`` held for a ``duration``; `InputError` for a film that does not creep."""
    if plane.model.system.films[-1].drive == "opposite":
        raise InputError("duration: films in opposite phase hold no constant voltage; leave it out")
    return holding(plane.model, duration, up_to, count=HELD_LEVELS, threads=plane.threads, progress=progress)


def held_limits(plane: Plane, held: Holding, relaxed: Array) -> Array:
    """The voltages of `STATIC_LIMITS` that are met while a voltage is held; the pitchfork, at which branches at flat
    rest do not pull, is that of the ``relaxed`` film, and so are all where no voltage is held."""
    if not held.highest > 0.0:
        return relaxed
    names = ("breakdown", "hoop_slack", "meridional_slack", "near_limit")
    voltages, found = held.members.voltages(held.run.times, held.run.states), np.full(relaxed.shape, np.inf)
    with np.errstate(all="ignore"):
        for own in excesses(held.members, held.run.states, voltages):
            most = [own[name].max(axis=1) if name in own else np.full(held.levels.shape, np.nan) for name in names]
            found[: len(names)] = np.fmin(found[: len(names)], [first_passing(held.levels, values) for values in most])
        beyond = np.inf
        if plane.membrane is not None:
            over = voltages[0] - plane.membrane.voltage(held.run.states[..., 0])
            beyond = first_passing(held.levels, over.max(axis=1))
    found[0] = np.nan if plane.model.dielectric_strength is None else found[0]
    return np.array([*found[:-2], relaxed[-2], min(held.highest, beyond)])
