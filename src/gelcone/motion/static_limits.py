"""The quasi-static part of an operating envelope: limits on a slow voltage ramp, and while a voltage is held."""

from __future__ import annotations

import math

import numpy as np

from gelcone.errors import InputError
from gelcone.motion.creep import Holding, holding
from gelcone.motion.driven import WITHIN
from gelcone.motion.natural import frequencies_under
from gelcone.motion.plane import Plane, is_flat
from gelcone.motion.ramp import Ramp
from gelcone.motion.validity import NEAR_LIMIT, excesses
from gelcone.physics.bracket import first_passing
from gelcone.physics.film.film import FilmState
from gelcone.physics.film.pull_in import PullInCurve
from gelcone.physics.model import ConeModel
from gelcone.progress import Progress
from gelcone.quantity import Array

STATIC_LIMITS = ("dielectric breakdown", "hoop slack", "meridional slack", "stretch limit", "pitchfork", "pull-in")
PEAKS = 20
"""Default number of peak voltages."""
STATIC_POINTS, CLOSER = 400, 65
"""Number of constant voltages at which limits are searched, and of those that are added around each limit."""
LATER = 2.0
"""Ratio of the highest constant voltage at which a membrane's pull-in is searched to the largest of its pull-in
voltages, and of the highest default peak voltage to the lowest quasi-static limit."""
FARTHEST = 1024.0
"""Highest constant voltage, dimensionless, at which limits are searched for a film without pull-in and stretch
limit."""
BEFORE = 1.0 - 1e-9
"""Share of the pull-in voltage at which the disc has not jumped yet."""
HELD_LEVELS = 32
"""Number of constant voltages that are held for a duration."""


# --- quasi-static ---------------------------------------------------------------------------------------------------


def static_limits_of(plane: Plane) -> Array:
    """The constant peak voltage at which either film meets each of `STATIC_LIMITS`, on the way to pull-in or, without
    pull-in, to the stretch limit; infinite where it does not."""
    model, ramp = plane.model, plane.ramp(np.zeros(1))
    pull_in = ramp.pull_in
    if plane.membrane is not None:
        pull_in = min(pull_in, _membrane_pull_in(plane, plane.membrane, pull_in))
    end = BEFORE * pull_in if np.isfinite(pull_in) else 1.0
    met = _met(plane, end)
    while not np.isfinite(pull_in) and not np.isfinite(met[-1]) and end < FARTHEST:
        end *= 2.0
        met = _met(plane, end)
    return np.array([*met, ramp.pitchfork if is_flat(model) else np.nan, pull_in])


def _met(plane: Plane, highest: float) -> Array:
    """The constant peak voltages up to ``highest`` at which breakdown, slack and the stretch limit are met."""
    levels = np.linspace(0.0, highest, STATIC_POINTS + 1)
    met = _first_met(plane, levels)
    around = met[np.isfinite(met)][:, None] + levels[1] * np.linspace(-1.0, 1.0, CLOSER)
    return _first_met(plane, np.union1d(levels, np.clip(around, 0.0, highest))) if around.size else met


def _first_met(plane: Plane, levels: Array) -> Array:
    """`_met` at given levels, by linear interpolation between them."""
    states, strength = _states(plane, plane.ramp(levels)), plane.model.dielectric_strength
    least = np.nan if strength is None else strength
    excess = [(s.true_field - least, -s.hoop_stress, -s.meridional_stress, s.limit_share - NEAR_LIMIT) for s in states]
    met = np.array([[first_passing(levels, of_limit) for of_limit in film] for film in excess]).min(axis=0)
    met[0] = np.nan if strength is None else met[0]
    return met


def _states(plane: Plane, ramp: Ramp) -> list[FilmState]:
    """The state of each film on a ramp."""
    films, n = plane.model.system.films, plane.model.own_numbers
    return [film.state(ramp.displacement, v, [], n) for film, v in zip(films, ramp.voltages, strict=True)]


def peaks_of(static: Array) -> Array:
    """The default peak voltages at which the driven motion is examined: up to a little above pull-in, or to twice the
    lowest of the ``static`` limits."""
    positive = static[np.isfinite(static) & (static > 0.0)]
    top = np.fmin(LATER * positive.min(initial=FARTHEST), (1.0 + WITHIN) * static[-1])
    return np.asarray(top * np.arange(1, PEAKS + 1) / PEAKS)


def static_curves(plane: Plane, highest: float) -> dict[str, Array]:
    """Static quantities over the constant peak voltage, up to the ``highest``."""
    model, levels = plane.model, np.linspace(0.0, highest, STATIC_POINTS + 1)
    ramp = plane.ramp(levels)
    state = _states(plane, ramp)[0]
    curves = {
        "peak_voltage": levels,
        "static_displacement": ramp.displacement,
        "stroke": ramp.stroke,
        "blocked_force": ramp.blocked_force,
        "natural_frequency": _natural(model, ramp),
        "static_field": state.true_field,
        "static_hoop_stress": state.hoop_stress,
        "static_meridional_stress": state.meridional_stress,
    }
    leaks = model.system.leaking_at_rest(ramp.displacement, ramp.voltages, model.own_numbers)
    if any(np.any(leak) for leak in leaks):
        curves["static_heating"] = sum(leaks) / len(leaks) + 0.0 * ramp.displacement
    return curves


def _natural(model: ConeModel, ramp: Ramp) -> Array:
    """The natural frequency at each constant voltage of a ramp."""
    rows = (ramp.stiffness, ramp.displacement, *ramp.voltages)
    stiffness, place, *voltages = (np.reshape(row, (1, -1)) for row in rows)
    return frequencies_under(model.members(), stiffness, place, voltages)[0]


def _membrane_pull_in(plane: Plane, membrane: PullInCurve, highest: float) -> float:
    """The constant voltage up to ``highest`` at which the membrane pulls in on the ramp; infinity if none."""
    known = membrane.voltage(np.linspace(0.0, membrane.reach, STATIC_POINTS))
    if not np.isfinite(known).any():
        return math.inf
    # it pulls in at these voltages at the latest, but the ramp may reach the displacement at a higher one
    levels = np.linspace(0.0, min(highest, LATER * known[np.isfinite(known)].max()), STATIC_POINTS + 1)
    return first_passing(levels, levels - membrane.voltage(plane.ramp(levels).displacement))


# --- held for a while -----------------------------------------------------------------------------------------------


def hold(plane: Plane, duration: float, up_to: float, progress: Progress) -> Holding:
    """Constant voltages up to ``up_to`` held for a ``duration``. Raises `InputError` for a film that does not creep."""
    if plane.model.system.films[-1].drive == "opposite":
        raise InputError("duration: films in opposite phase hold no constant voltage; leave it out")
    return holding(plane.model, duration, up_to, count=HELD_LEVELS, threads=plane.threads, progress=progress)


def held_limits(plane: Plane, held: Holding, relaxed: Array) -> Array:
    """The voltages of `STATIC_LIMITS` that are met while a voltage is held. The pitchfork is that of the ``relaxed``
    film, since branches do not pull on the flat film; without a voltage that is held, all limits are."""
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
