"""The quasi-static part of an operating envelope: limits on a slow voltage ramp, and while a voltage is held."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from gelcone.motion.creep import Holding
from gelcone.motion.driven import WITHIN
from gelcone.motion.job import Trajectories
from gelcone.motion.natural import frequencies_under
from gelcone.motion.plane import Plane
from gelcone.motion.ramp import Ramp
from gelcone.physics.film.film import FilmState
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

STATIC_LIMITS = ("dielectric breakdown", "hoop slack", "meridional slack", "stretch limit", "pitchfork", "pull-in")
MEMBRANE_PULL_IN = "membrane pull-in"
"""Name of the pull-in of the membrane for which a cone stands; "pull-in" among `STATIC_LIMITS` is the lower of this and
the cone's own."""
PEAKS = 20
"""Default number of peak voltages."""
STATIC_POINTS = 400
"""Number of constant voltages of the static curves, and in each interval in which limits are searched."""
FIRST, CLOSER, RESOLVED = 1.0, 65, 1e-9
"""End of the first interval, dimensionless (each of the next is as long as all before); number of voltages between
which a limit is bracketed again; and the share of itself to which it is known."""
LATER = 2.0
"""Ratio of the highest default peak voltage to the lowest quasi-static limit."""
HIGHEST_SEARCHED = 1024.0
"""Highest constant voltage, dimensionless, at which limits are searched for a film without pull-in and stretch
limit."""
BEFORE = 1.0 - 1e-9
"""Share of the pull-in voltage at which the disc has not jumped yet."""
_FAILING = ("breakdown", "hoop_slack", "meridional_slack", "near_limit", "beyond_membrane")
HELD_CLOSER, HELD_RESOLVED = 10, 1e-4
"""As `CLOSER` and `RESOLVED`, of voltages that are held."""


# --- quasi-static ---------------------------------------------------------------------------------------------------


def static_limits_of(plane: Plane) -> Array:
    """The constant peak voltage at which either film meets each of `STATIC_LIMITS`, on the way to pull-in of the model
    or, without it, to the stretch limit; infinite where it does not. The pull-in of a cone is that of the membrane for
    which it stands, where that comes first.

    A limit lies where the mask of `gelcone.motion.validity` changes, to `RESOLVED`.
    """
    return with_first_pull_in(ramp_limits_of(plane))


def ramp_limits_of(plane: Plane) -> Array:
    """Find the constant peak voltages of `STATIC_LIMITS`, pull-in being that of the film as given, followed by that of
    the membrane for which a cone stands: NaN where it is unknown, infinite where it does not come before the cone's."""
    ramp = plane.ramp(np.zeros(1))
    *met, membrane = _met(plane, BEFORE * ramp.pull_in if np.isfinite(ramp.pull_in) else HIGHEST_SEARCHED)
    return np.array([*met, ramp.pitchfork, ramp.pull_in, membrane])


def with_first_pull_in(limits: Array) -> Array:
    """Return the voltages of `STATIC_LIMITS` from those of `ramp_limits_of`: pull-in is that which comes first."""
    *met, cone, membrane = limits
    return np.array([*met, np.fmin(cone, membrane)])


def membrane_pull_in_at_own_bias(plane: Plane) -> float:
    """The constant voltage of pull-in of the membrane, as in `ramp_limits_of`, of films in opposite phase at the
    model's bias, from which the voltage rises; NaN if the way to that bias is lost."""
    biased_plane = replace(plane, own_bias=True)
    lost = biased_plane.ramp(np.zeros(1)).pull_in
    if np.isnan(lost):
        return lost
    start = abs(float(plane.model.voltage_bias)) if plane.model.system.in_opposite_phase else 0.0
    return float(_met(biased_plane, BEFORE * lost if np.isfinite(lost) else HIGHEST_SEARCHED, start)[-1])


def _met(plane: Plane, highest: float, begin: float = 0.0) -> Array:
    """The constant peak voltages up to ``highest`` below which the assumptions `_FAILING` hold, searched upwards from
    ``begin``."""

    def excess(levels: Array) -> Array:
        ramp = plane.ramp(levels)
        voltages = [voltage[None] for voltage in ramp.voltages]
        return _violations(plane, plane.model.members(), ramp.displacement[None, :, None], voltages)[:, 0]

    low, high = np.zeros(len(_FAILING)), np.full(len(_FAILING), np.inf)
    known = np.zeros(len(_FAILING), dtype=bool)
    end = min(begin + FIRST, highest)
    while True:
        levels = np.linspace(begin, end, STATIC_POINTS + 1)
        excesses = excess(levels)
        known |= ~np.isnan(excesses).all(axis=1)
        low, high = np.where(np.isinf(high), _first_over(levels, excesses), [low, high])
        if end >= highest or np.isfinite(high[known]).all():
            break
        begin, end = end, min(2.0 * end, highest)
    return np.where(known, _narrowed(excess, low, high, CLOSER, RESOLVED), np.nan)


def _first_over(levels: Array, excess: Array) -> Array:
    """The ends (2, assumptions) of the first intervals of ``levels``, (levels,) or (assumptions, levels), at whose
    upper ends the ``excess`` (assumptions, levels) is positive; the upper one is infinite if it never is."""
    over = excess > 0.0
    first = over.argmax(axis=1)[:, None]
    low, high = (
        np.take_along_axis(np.broadcast_to(levels, over.shape), k, axis=1)[:, 0]
        for k in (np.maximum(first - 1, 0), first)
    )
    return np.stack([low, np.where(over.any(axis=1), high, np.inf)])


def _narrowed(excess: Callable[[Array], Array], low: Array, high: Array, closer: int, resolved: float) -> Array:
    """The lower ends (assumptions,) of intervals in which assumptions cease to hold, divided by ``closer`` voltages
    until they are as wide as the share ``resolved`` of the voltage; infinite where ``high`` is."""
    while (wide := np.flatnonzero(np.isfinite(high) & (high - low > resolved * (high + resolved)))).size:
        inner = np.linspace(low[wide], high[wide], closer, axis=1)
        excesses = excess(inner.ravel()).reshape(-1, *inner.shape)[wide, np.arange(wide.size)]
        excesses[:, -1] = np.inf
        low[wide], high[wide] = _first_over(inner, excesses)
    return np.where(np.isfinite(high), low, np.inf)


def _violations(plane: Plane, members: Members, motion: Array, voltages: Sequence[Array]) -> Array:
    """Excesses of the assumptions `_FAILING` (assumptions, members, samples), of two films the larger; NaN: unknown."""
    excesses = np.full((len(_FAILING), *motion.shape[:2]), np.nan)
    with np.errstate(all="ignore"):
        for film_excesses in plane.violations(members, motion, voltages):
            for row, name in enumerate(_FAILING):
                excesses[row] = np.fmax(excesses[row], film_excesses.get(name, np.nan))
    return excesses


def _states(plane: Plane, ramp: Ramp) -> list[FilmState]:
    """The state of each film on a ramp."""
    films, n = plane.model.system.films, plane.model.own_numbers
    return [film.state(ramp.displacement, v, [], n) for film, v in zip(films, ramp.voltages, strict=True)]


def peaks_of(plane: Plane, static: Array) -> Array:
    """The default peak voltages at which the driven motion is examined: up to a little above pull-in, or to twice the
    lowest of the ``static`` limits. If none is met, to twice the voltage from which on a leaking film gets no more."""
    positive = static[np.isfinite(static) & (static > 0.0)]
    lowest = positive.min() if positive.size else _highest_of_use(plane)
    top = np.fmin(LATER * lowest, (1.0 + WITHIN) * static[-1])
    return np.asarray(top * np.arange(1, PEAKS + 1) / PEAKS)


def _highest_of_use(plane: Plane) -> float:
    """The lowest constant peak voltage at which the first film is `WITHIN` its voltage at `HIGHEST_SEARCHED`."""
    levels = np.geomspace(1e-3, HIGHEST_SEARCHED, STATIC_POINTS)
    on_film = plane.ramp(levels).voltages[0]
    return float(levels[np.argmax(on_film >= (1.0 - WITHIN) * on_film[-1])])


def static_curves(plane: Plane, highest: float) -> dict[str, Array]:
    """Static quantities over the constant peak voltage, up to the ``highest``."""
    model, levels = plane.model, np.linspace(0.0, highest, STATIC_POINTS + 1)
    ramp = plane.ramp(levels)
    state = _states(plane, ramp)[0]
    curves = {
        "constant_voltage": levels,
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


# --- held for a while -----------------------------------------------------------------------------------------------


def held_limits(plane: Plane, held: Holding, relaxed: Array) -> Array:
    """The voltages of `STATIC_LIMITS` that are met while a voltage is held, from below to `HELD_RESOLVED`. The
    pitchfork is that of the ``relaxed`` film, since branches do not pull on the flat film; without a voltage that is
    held, all limits are."""
    if not held.highest > 0.0:
        return relaxed

    def excess(members: Members, run: Trajectories) -> Array:
        with np.errstate(all="ignore"):
            voltages = members.voltages(run.times, run.states)
        return np.asarray(np.fmax.reduce(_violations(plane, members, run.states, voltages), axis=2))

    low, high = _first_over(held.levels, excess(*held.runs))
    *met, membrane = _narrowed(lambda levels: excess(*held.at(levels)), low, high, HELD_CLOSER, HELD_RESOLVED)
    met[0] = np.nan if plane.model.dielectric_strength is None else met[0]
    return np.array([*met, relaxed[-2], min(held.highest, membrane)])
