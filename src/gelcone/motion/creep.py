"""Creep of a film while a voltage is held, and the time for which it bears a voltage between its two thresholds.

A film whose branches carry a part of the load bears more at once than in the long run. Between its two pull-in
voltages, that at once and that of the relaxed film, it pulls in late.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gelcone import dataset
from gelcone.codes import Outcome
from gelcone.devices.analysis import analysis, check_one
from gelcone.errors import InputError
from gelcone.motion.constant_voltage import at_constant_voltages
from gelcone.motion.electrical import heating
from gelcone.motion.flow import DEFAULT_TOLERANCE, integrate
from gelcone.motion.job import Trajectories
from gelcone.motion.proportion import at_own_bias, in_proportion, proportional
from gelcone.motion.rest import circuits_under
from gelcone.motion.settle import check_budgets, check_default_duration, times_of_run
from gelcone.motion.static_results import constant_voltages, own_levels
from gelcone.motion.validity import validity_of_run, validity_variables
from gelcone.physics.balance import Loss, PullIn, StaticBalance, rest_of
from gelcone.physics.film.at_once import films_at_once
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.physics.statics import every_balance, stable_near
from gelcone.progress import Progress, advance, weighted
from gelcone.quantity import Array, Time, Voltages
from gelcone.register.analysis import CONSTANT_VOLTAGE

if TYPE_CHECKING:
    import xarray as xr

DECAYS = 8.0
"""Time constants of the slowest state that a voltage is held by default."""
SAMPLES, DECADES = 120, 4.0
"""Samples of the holding time, and the decades over which they are spread."""
CURVE, FINER, FINE = 12, 2, 6
"""Number of voltages between the thresholds at which the time to pull-in is computed; how often the interval in which
that time begins to exceed the holding time is divided again, and by how many voltages."""
START_SHARE = 0.7
"""Share of the starts in the time of a part of the curve; equilibria of membranes behind a resistance take longest."""
ZOOMS, ZOOMED = 3, 65
"""How often the interval in which the disc jumps is sampled more finely, and the number of samples."""
RISE, HIGHEST, HALVINGS = 0.04, 30.0, 32
"""Relative step of the voltage in the search for pull-in, the largest relative rise searched, and the halvings of the
step in which pull-in lies."""


@analysis(
    axes={"voltages": CONSTANT_VOLTAGE},
    answers="trajectories",
    single=True,
    file_only=("time", "displacement", "current", "second_current", "heating", "margin"),
    examples=(
        'biased-pump --film wrinkling --set "material.viscous_modulus_1=4 kPa" --set "material.relaxation_time_1=2 s" '
        '--over "constant_voltage=1 kV,2 kV" --out results',
        'biased-pump --film taut --set "material.viscous_modulus_1=4 kPa" --set "material.relaxation_time_1=2 s" '
        '--duration "600 s" --json',
    ),
)
def creep(
    model: ConeModel,
    voltages: Voltages | None = None,
    *,
    duration: Time | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Compute how a film that creeps moves while constant voltages are held, and when it pulls in.

    The voltage is applied slowly enough that the disc does not overshoot, but faster than the film relaxes. The disc
    begins at its equilibrium with the unrelaxed film, circuits charged. (`gelcone.step` applies the voltage at once.)

    Parameters
    ----------
    model : a single actuator whose film has branches; its drive gives the default of ``voltages`` alone.
    voltages : constant commanded voltages that are held. Default: the peak of the drive and, where it has one, its
        offset.
    duration : the holding time. Default eight time constants of the slowest state of film and circuit; that of a
        branch is (1 + g) tau, since under load it creeps more slowly than it relaxes.
    tolerance : relative error of one integration step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over ``constant_voltage`` with the ``initial_displacement``, the ``final_displacement``, the
    ``equilibrium_displacement`` that the relaxed film has, and ``pull_in_time``, infinite where the voltage is held;
    over ``time``, 0 and then evenly over four decades, the ``displacement``, the ``current`` into the film, the
    ``second_current`` into a second one, ``heating``, at which rate the temperature of the film, or the mean of two,
    rises as long as it gives no heat away, and the ``margin``, the share by which the voltage on the film is below the
    one at which, raised at once, the film would pull in or the disc jump: 1 where none does, 0 where it does already.
    ``long_term_pull_in_voltage`` and ``instantaneous_pull_in_voltage`` are the thresholds of the relaxed film and at
    once, and ``long_term_pull_in_kind``, a `PullIn`, the way of the first. All voltages are commanded ones. Over
    ``held_voltage``, from the one threshold to the other, ``time_to_pull_in`` is infinite where it exceeds the
    duration; ``holding_voltage`` is the highest that is held for it, from below to 1/400 of the window. ``validity_*``
    are those of `simulate`, for the time over which the voltage is held; also a disc that jumps counts as pulled in.

    A run of a wrinkling cone ends where its film localises at once. Above a long-term threshold of the kind ``FILM``
    one ring of the relaxed film lengthens slowly before that, which a homogeneous cone does not show: the film pulls
    in no later than after these times, and ``holding_voltage`` is an upper bound.

    Raises
    ------
    InputError : for an ensemble, a film without branches, a commanded charge, voltages out of bounds and a duration
        that is not positive or too long.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(rest_height=0.8, viscous_modulus_1=0.5, relaxation_time_1=10.0, damping_ratio=0.2)
    >>> held = gelcone.creep(model, [0.6])
    >>> f"from {held.initial_displacement.item():.4f} to {held.final_displacement.item():.4f}"
    'from 0.6374 to 0.7070'
    >>> held.long_term_pull_in_voltage.item()
    inf
    """
    check_one(model, "creep")
    _check_creeps(model, "creep", "or use step")
    levels = constant_voltages(own_levels(model) if voltages is None else voltages)
    lasts = _duration(model, duration)
    films = _Held.of(model, tolerance, threads)
    times = _times(lasts)
    sampled = np.union1d(times_of_run(films.members(levels), lasts), times)
    advance(progress, 0.15)
    starts = films.starts(levels, weighted(progress, 0.1))
    whole, ends = films.run(levels, starts, sampled, weighted(progress, 0.1))
    shown = np.searchsorted(sampled, times)
    run = replace(whole, times=whole.times[:, shown], states=whole.states[:, shown])
    along = ("constant_voltage",)
    x = np.where(times <= ends[:, None], run.states[..., 0], np.nan)
    members, outcome = films.members(levels), np.where(np.isfinite(ends), Outcome.PULLED_IN, run.outcome)
    *currents, heat = (np.where(np.isnan(x), np.nan, series) for series in _electric(members, run))
    held_voltage, to_pull_in, highest = films.curve(lasts, weighted(progress, 0.5))
    variables: dict[str, dataset.Variable] = {
        "initial_displacement": (along, starts[:, 0], "displacement at once", _AT_ONCE),
        "final_displacement": (along, x[:, -1], "displacement after the holding time", _LOST),
        "equilibrium_displacement": (along, films.relaxed.place(levels), "displacement of the relaxed film", _BEYOND),
        "pull_in_time": (along, ends, "time to pull-in", _HELD),
        "displacement": ((*along, "time"), x, "displacement while the voltage is held", "length"),
        **{
            f"{film.prefix}current": ((*along, "time"), current, f"current into {film.words}", "current")
            for film, current in zip(model.system.films, currents, strict=True)
        },
        "heating": ((*along, "time"), heat, "rate of the temperature of films that lose no heat", "heating"),
        "margin": ((*along, "time"), films.margins(levels, run, x), *_MARGIN),
        **_both(films.relaxed, films.at_once, at_own_bias(model.system)),
        "long_term_pull_in_kind": ((), films.relaxed.lost.kind, "how the relaxed film pulls in", PullIn),
        "holding_voltage": ((), highest, *_HIGHEST),
        "time_to_pull_in": (("held_voltage",), to_pull_in, "time to pull-in", _HELD),
        **validity_variables(validity_of_run(members, whole), outcome, model.system, along, "time"),
    }
    result = dataset.label(
        model,
        variables,
        coords={
            "constant_voltage": (along, levels, "constant voltage", "voltage"),
            "time": (("time",), times, "holding time", "time"),
            "held_voltage": (("held_voltage",), held_voltage, "constant voltage", "voltage"),
        },
        options={"duration": duration, "tolerance": tolerance},
        title="creep",
    )
    advance(progress, 0.15)
    return result.assign(outcome=dataset.outcome_array(outcome, along))


def _duration(model: ConeModel, given: float | None) -> float:
    """The holding time. Raises `InputError` for one that is not positive or too long."""
    if given is not None:
        check_budgets(duration=given)
        return float(given)
    lasts = DECAYS * float(model.members().time_constant[0])
    check_default_duration(lasts, f"duration: {DECAYS:g} time constants of the slowest state")
    return lasts


def _check_creeps(model: ConeModel, name: str, remedy: str) -> None:
    """Raises `InputError` for a film without branches, and for a commanded charge."""
    if not any(film.states for film in model.system.films):
        raise InputError(
            f"{name}: the film has no branch that relaxes; give viscous_modulus_1 and relaxation_time_1 (of a device: "
            f"of its material), {remedy}"
        )
    if model.system.circuit.name == "charge":
        raise InputError(
            f"circuit = charge: {name} holds a voltage, not a charge; take the ideal source or an amplifier"
        )


_AT_ONCE, _LOST = (dataset.absent("length", nan=words) for words in ("pulls in at once", "pulls in"))
_BEYOND = dataset.absent("length", nan="none: pulls in in the long run")
_HELD = dataset.absent("time", nan="unknown", infinite="held for the duration")
_NEVER = dataset.absent("voltage", nan="nothing is stable without voltage", infinite="never")
_HIGHEST = "highest voltage that is held for the duration", _NEVER
_MARGIN = (
    "share by which the film's voltage is below that of pull-in at once",
    dataset.absent("share", nan="pulled in"),
)


class _Ramp:
    """A slow voltage ramp: the displacement at ``rest``, and the first loss of stability, ``lost``, that is not a
    smooth pitchfork. ``bias_share`` is that of `every_balance`."""

    def __init__(self, model: ConeModel | Members, bias_share: float | None = None) -> None:
        self.balance: StaticBalance
        (self.balance,) = every_balance(model, bias_share)
        self.rest = rest_of(self.balance, None)
        self.lost: Loss = self.balance.jump(self.rest)

    def place(self, levels: Array) -> Array:
        """Displacement at commanded voltages; NaN at and above that at which the film is lost."""
        displacements, _ = self.balance.along_ramp(self.rest, levels**2)
        return np.where(levels < self.lost.voltage, displacements, np.nan)


def thresholds(model: ConeModel, bias_share: float) -> dict[str, dataset.Variable]:
    """The pull-in voltages of a film that creeps, in the long run and at once, with the bias of films in opposite phase
    in proportion, the share ``bias_share``; empty for a film that does not creep."""
    if not any(film.states for film in model.system.films):
        return {}
    variables = _both(_Ramp(model, bias_share), _Ramp(films_at_once(model), bias_share), in_proportion(model.system))
    return {proportional(name, model.system): variable for name, variable in variables.items()}


class Holding(NamedTuple):
    """Constant commanded voltages that a film bears for a duration: the ``highest`` of them and the ``levels`` up to
    it; the members there and their ``runs``, and `at` for those of other levels; and the ``variables`` of the same
    names as in `creep`."""

    highest: float
    levels: Array
    runs: tuple[Members, Trajectories]
    at: Callable[[Array], tuple[Members, Trajectories]]
    variables: dict[str, dataset.Variable]


def check_holds(model: ConeModel, duration: float) -> None:
    """Raises `InputError` where `holding` has no answer: for a duration that is not positive or too long, a film
    without branches, a commanded charge and films in opposite phase."""
    if model.system.in_opposite_phase:
        raise InputError("duration: films in opposite phase hold no constant voltage; leave it out")
    _check_creeps(model, "duration", "or leave it out")
    check_budgets(duration=duration)


def holding(
    model: ConeModel, duration: float, up_to: float, *, count: int, threads: int | None, progress: Progress = None
) -> Holding:
    """The highest voltage that a film bears for a ``duration``, and its runs at ``count`` levels up to that, or up to
    ``up_to`` for a film that never pulls in."""
    films, lasts = _Held.of(model, DEFAULT_TOLERANCE, threads), float(duration)
    _, _, highest = films.curve(lasts, weighted(progress, 0.5))
    end = highest if np.isfinite(highest) else up_to
    levels = end * (1.0 - np.linspace(1.0, 0.0, count) ** 2)  # closer to the end

    def at(levels: Array, progress: Progress = None) -> tuple[Members, Trajectories]:
        return films.members(levels), films.run(levels, films.starts(levels), _times(lasts), progress)[0]

    variables = _both(films.relaxed, films.at_once, "") | {"holding_voltage": ((), highest, *_HIGHEST)}
    return Holding(highest, levels, at(levels, weighted(progress, 0.5)), at, variables)


def _both(relaxed: _Ramp, at_once: _Ramp, more: str) -> dict[str, dataset.Variable]:
    """The two thresholds as variables, with ``more`` at the end of their meanings."""
    return {
        "long_term_pull_in_voltage": ((), relaxed.lost.voltage, f"pull-in voltage of the relaxed film{more}", _NEVER),
        "instantaneous_pull_in_voltage": (
            (),
            at_once.lost.voltage,
            f"pull-in voltage of the film at once{more}",
            _NEVER,
        ),
    }


@dataclass(frozen=True)
class _Held:
    """Runs of a ``model`` at constant voltages, on ramps of the film ``at_once`` and ``relaxed``."""

    model: ConeModel
    at_once: _Ramp
    relaxed: _Ramp
    tolerance: float
    threads: int | None

    @classmethod
    def of(cls, model: ConeModel, tolerance: float, threads: int | None) -> _Held:
        """Makes both ramps of a model."""
        return cls(model, _Ramp(films_at_once(model)), _Ramp(model), tolerance, threads)

    def members(self, levels: Array) -> Members:
        """The actuator at the levels."""
        return at_constant_voltages(self.model, levels).members()

    def starts(self, levels: Array, progress: Progress = None) -> Array:
        """Equilibria (levels, N) of the film at once, behind charged circuits; the displacement is NaN where it pulls
        in at once."""
        members = self.members(levels)
        starts = members.start_states((self.relaxed.rest, 0.0)).copy()
        starts[:, 0] = self.at_once.place(levels)
        advance(progress, 0.5)
        holds = np.flatnonzero(np.isfinite(starts[:, 0]))
        if holds.size:
            system, n = members.system, members.take(holds).numbers()
            command = np.broadcast_to(system.waveform.voltage(0.0, n), holds.shape)
            starts[holds] = np.stack(circuits_under(system, command, list(starts[holds].T), n), axis=-1)
        advance(progress, 0.5)
        return starts

    def run(self, levels: Array, states: Array, times: Array, progress: Progress) -> tuple[Trajectories, Array]:
        """The runs from the ``states`` of `starts`, and the time at which each film pulls in or its disc jumps: 0 at
        once, infinite if it does not, NaN if unknown."""
        members = self.members(levels)
        options: dict[str, Any] = {"tolerance": self.tolerance, "threads": self.threads}
        run = integrate(members, states, times, **options, progress=progress)
        lost = np.isin(run.outcome, (Outcome.PULLED_IN, Outcome.STRETCH_LIMIT))
        ends = np.where(run.outcome == Outcome.OK, np.inf, np.where(lost, run.end_times, np.nan))
        before, after = self.relaxed.lost.before, self.relaxed.lost.after
        if self.relaxed.lost.kind == PullIn.FOLD and np.isfinite(after):
            middle = 0.5 * (before + after)
            for k in np.flatnonzero(((run.states[..., 0] - middle) * (after - before) > 0.0).any(axis=1)):
                part = members.take(slice(k, k + 1))
                ends[k] = _passes(part, times, run.states[k], middle, after - before, options)
        return run, np.where(np.isnan(states[:, 0]), 0.0, ends)

    def curve(self, lasts: float, progress: Progress) -> tuple[Array, Array, float]:
        """Voltages between the thresholds, the times to pull-in there, and the highest that is held."""
        low, high = self.relaxed.lost.voltage, self.at_once.lost.voltage
        if not np.isfinite(low):
            advance(progress, 1.0)
            peak = float(np.max(own_levels(self.model)))
            return np.linspace(0.0, peak, CURVE), np.full(CURVE, np.nan if np.isnan(low) else np.inf), low
        high = max(high, low * (1.0 + 1e-6)) if np.isfinite(high) else 2.0 * low
        times = _times(lasts)
        voltages, ends = np.empty(0), np.empty(0)
        held, fails = low, high
        shares = (np.arange(1, CURVE + 1) / (CURVE + 1)) ** 1.5
        for refinement in range(1 + FINER):
            levels = held + (fails - held) * shares
            share = weighted(progress, 1.0 / (1 + FINER))
            begun = self.starts(levels, weighted(share, START_SHARE))
            _, new_ends = self.run(levels, begun, times, weighted(share, 1.0 - START_SHARE))
            voltages, ends = np.append(voltages, levels), np.append(ends, new_ends)
            held = max([held, *levels[np.isinf(new_ends)]])
            fails = min([high, *voltages[np.isfinite(ends) & (voltages > held)]])
            shares = np.arange(1, FINE + 1) / (FINE + 1) if refinement < FINER else shares
        order = np.argsort(voltages)
        return voltages[order], ends[order], held

    def margins(self, levels: Array, run: Trajectories, x: Array) -> Array:
        """The margin of each voltage to pull-in at once along the runs, (levels, samples)."""
        rows, samples = np.nonzero(np.isfinite(x))
        members = self.members(levels)
        margins = np.full(x.shape, np.nan)
        if rows.size:
            volts = members.voltages(run.times, run.states)[0]
            at_once = films_at_once(members.take(rows), run.states[rows, samples])
            margins[rows, samples] = _margin(at_once, x[rows, samples], np.abs(volts[rows, samples]))
        return margins


def _times(lasts: float) -> Array:
    """0, and the samples of a holding time."""
    return np.concatenate([[0.0], lasts * np.geomspace(10.0**-DECADES, 1.0, SAMPLES)])


def _passes(member: Members, times: Array, states: Array, middle: float, way: float, options: dict[str, Any]) -> float:
    """The time at which the displacement of a run passes ``middle`` in the direction of ``way``, by sampling the
    interval more finely `ZOOMS` times."""
    for _ in range(ZOOMS):
        k = int(np.argmax((states[:, 0] - middle) * way > 0.0))
        if k == 0:
            return float(times[0])
        times = np.linspace(times[k - 1], times[k], ZOOMED)
        run = integrate(member, states[k - 1], times, start=float(times[0]), **options)
        states = run.states[0]
    return float(times[np.argmax((states[:, 0] - middle) * way > 0.0)])


def _electric(members: Members, run: Trajectories) -> list[Array]:
    """The current into each film, and the power that heats them over the volume of all, (members, samples)."""
    system = members.system
    with np.errstate(all="ignore"):
        currents = members.along(system.currents, run.times, run.states)
        powers = dict(zip(system.causes, members.along(system.powers, run.times, run.states), strict=True))
        heat = heating(powers, run.times.shape) / len(system.films)
    return [*currents, heat]


def _margin(held: Members, x: Array, volts: Array) -> Array:
    """The share by which voltages are below pull-in or a jump of films at once, with equilibria near ``x``."""
    n, system = dict(held.numbers()), held.system

    def follow(x: Array, volts: Array) -> tuple[Array, Any]:
        squared = volts * volts
        x, _ = stable_near(x, partial(system.static_force, squared=squared, n=n))
        return x, np.isfinite(x) & ~np.asarray(system.pulled_in(x, squared, n), dtype=bool)

    with np.errstate(all="ignore"):
        low, high = np.ones(x.shape), np.full(x.shape, np.inf)
        x, rests = follow(x, volts)
        rising = rests & (volts > 0.0)
        while rising.any():
            next_x, stays = follow(x, low * (1.0 + RISE) * volts)
            high = np.where(rising & ~stays, low * (1.0 + RISE), high)
            rising = rising & stays
            low, x = np.where(rising, low * (1.0 + RISE), low), np.where(rising, next_x, x)
            rising = rising & (low < 1.0 + HIGHEST)
        ended = np.isfinite(high)
        for _ in range(HALVINGS if ended.any() else 0):
            middle = 0.5 * (low + high)
            next_x, stays = follow(x, middle * volts)
            low, x = np.where(ended & stays, middle, low), np.where(ended & stays, next_x, x)
            high = np.where(ended & ~stays, middle, high)
    return np.where(rests, np.where(ended, 1.0 - 1.0 / low, 1.0), 0.0)
