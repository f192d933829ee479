"""Validity of the model: the shares of a motion during which the film is slack, breaks down or is near its limit.

Shares are of the time, with the times at which an assumption begins and ceases to hold (`gelcone.motion.dwell`). Slack
is outside the validity only of a film that bears compression; a film that wrinkles has states for it. A cone
approximates a membrane: where its radius ratio is known, as for a device, the share of the time at voltages at which
the membrane has pulled in counts, too.
"""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from functools import reduce
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.dataset import Variable
from gelcone.motion.dwell import Path, dwell_times
from gelcone.motion.job import Trajectories, to_the_end
from gelcone.physics.film.film import Film, FilmState
from gelcone.physics.film.pull_in import over_pull_in
from gelcone.physics.film.wrinkling import FAILED
from gelcone.physics.members import Members
from gelcone.physics.placed import PlacedFilm
from gelcone.physics.system import ConeSystem
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

ASSUMPTIONS = {
    "hoop_slack": "slack hoops",
    "meridional_slack": "slack meridians",
    "breakdown": "a true field above the dielectric strength",
    "near_limit": "a strain within 1 % of the stretch limit",
    "beyond_membrane": "a voltage at which the membrane that the cone stands for has pulled in",
    "pulled_in": "a film that has pulled in",
}
"""Assumptions of the model -> words for a motion in which they fail."""
SLACK_IN = {
    "hoop_slack": ("hoop_slack", "crumpled", "partly_wrinkled", "wrinkled", "slack"),
    "meridional_slack": ("meridional_slack", "crumpled", "slack"),
}
"""States of a film that wrinkles in which each direction is slack."""
MOST_KINDS = 5
"""Most states of each of two films (`gelcone.physics.film.film.Film.kinds`)."""
SHARES = tuple(name for name in ASSUMPTIONS if name != "pulled_in")
"""Assumptions with reported shares of the time."""
NEAR_LIMIT = 0.99
"""Share of the stretch limit above which a strain is near it."""
BLOCKS = 8
"""Parts of a motion whose shares are compared for the error of its share."""
Fails = Mapping[str, npt.NDArray[np.bool_]]
"""Name of an assumption -> mask of its failures."""


def broken(
    members: Members, motion: Array, voltages: Sequence[Array], states: Sequence[FilmState | None] = (None, None)
) -> Fails:
    """Masks (members, samples) of each assumption's failures, by name, along a ``motion`` (members, samples, N).

    With two films, true where either fails. In a motion of the displacement alone, (members, samples, 1), films have
    settled. ``voltages`` are those of each film, (members, samples), and ``states`` the film states if they are known
    already. Unknown assumptions are left out: breakdown without a dielectric strength, slack of a film without
    stresses.
    """
    return _of_either(broken_by_film(members, motion, voltages, states), motion[..., 0])


def outside(
    members: Members, motion: Array, voltages: Sequence[Array], states: Sequence[FilmState | None] = (None, None)
) -> Fails:
    """Masks of `broken`, but slack only of a film that bears compression: the model is untrue there."""
    each = broken_by_film(members, motion, voltages, states)
    for film, fails in zip(members.system.films, each, strict=True):
        if film.kinds:
            fails |= {name: np.zeros_like(fails[name]) for name in SLACK_IN.keys() & fails.keys()}
    return _of_either(each, motion[..., 0])


def _of_either(films: Sequence[Fails], x: Array) -> Fails:
    either_fails: dict[str, npt.NDArray[np.bool_]] = {}
    for fails in films:
        for name, where in fails.items():
            either_fails[name] = np.broadcast_to(either_fails.get(name, False) | where, x.shape)
    return either_fails


def broken_by_film(
    members: Members, motion: Array, voltages: Sequence[Array], states: Sequence[FilmState | None] = (None, None)
) -> list[dict[str, npt.NDArray[np.bool_]]]:
    """`broken` of each film alone; slack of a film that wrinkles follows from its state."""
    by_film = []
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # at a stretch limit
        film_states = list(states)
        if any(state is None and film.kinds for film, state in zip(members.system.films, states, strict=False)):
            film_states = list(members.film_states(motion, voltages))
        every = violations(members, motion, voltages, film_states)
        for film, state, excess in zip(members.system.films, film_states, every, strict=False):
            fails = {name: np.broadcast_to(values > 0.0, motion.shape[:-1]) for name, values in excess.items()}
            if film.kinds and state is not None:
                fails |= {name: np.isin(state.kind, places) for name, places in slack_places(film).items()}
            by_film.append(fails)
    return by_film


def slack_places(film: PlacedFilm | Film) -> dict[str, list[int]]:
    """Indices among the ``kinds`` of a film of those in which its hoops and its meridians are slack."""
    return {name: [k for k, kind in enumerate(film.kinds) if kind in kinds] for name, kinds in SLACK_IN.items()}


def violations(
    members: Members, motion: Array, voltages: Sequence[Array], states: Sequence[FilmState | None] = (None, None)
) -> list[dict[str, Array]]:
    """Functions (members, samples), by name, for each film that are positive where an assumption fails and continuous
    along a motion. Unknown assumptions are left out; a film that wrinkles is never compressed."""
    n, strength = members.numbers(trailing=1), members.values.get("dielectric_strength")
    z, by_film = list(np.moveaxis(motion, -1, 0)), []
    for k, (film, voltage, state) in enumerate(zip(members.system.films, voltages, states, strict=False)):
        x, y = z[0], members.system.states_of(z, "film", k)
        if state is None and (strength is not None or not film.kinds):
            state = film.state(x, voltage, y, n)
        excesses = {"near_limit": film.limit_share(x, voltage, y, n, state) - NEAR_LIMIT}
        excesses |= dict.fromkeys(SLACK_IN if film.kinds else (), -1.0)
        if state is not None and not film.kinds:
            stresses = {"hoop_slack": state.hoop_stress, "meridional_slack": state.meridional_stress}
            excesses |= {name: -stress for name, stress in stresses.items() if not np.isnan(stress).all()}
        if state is not None and strength is not None:
            excesses["breakdown"] = state.true_field - np.asarray(strength)[:, None]
        if (over := over_pull_in(film, members.values, np.asarray(x), np.broadcast_to(voltage, x.shape))) is not None:
            excesses["beyond_membrane"] = over
        by_film.append({name: np.broadcast_to(values, x.shape) for name, values in excesses.items()})
    return by_film


def untrue_by(name: str) -> str:
    """The reason why the model is untrue, in words."""
    return ASSUMPTIONS[name] + (" under compression" if name in SLACK_IN else "")


def lasting(members: Members, times: Array, states: Array) -> tuple[dict[str, Array], Array, Array]:
    """Times (members, intervals) for which each assumption fails in either film (`outside`), by name, along motions
    sampled at ``times`` (members, samples) from their start to their end; the time for which the motion ran in each
    interval; and the largest error (members,) of the sums of the times."""

    def excess(some: Members, at: Array, z: Array) -> dict[str, Array]:
        """`violations`, of two films the larger."""
        excesses: dict[str, Array] = {}
        with np.errstate(all="ignore"):
            for film_excesses in violations(some, z, some.voltages(at, z)):
                excesses |= {
                    name: np.fmax(excesses.get(name, -np.inf), values) for name, values in film_excesses.items()
                }
        return excesses

    ran = ~np.isnan(states[..., 0])
    spans = np.where(ran[:, :-1] & ran[:, 1:], np.diff(times, axis=1), 0.0)
    known = {name: np.where(ran, values, np.nan) for name, values in excess(members, times, states).items()}

    def functions(some: Members, at: Array, z: Array) -> Array:
        excesses = excess(some, at, z)
        return np.stack([excesses.get(name, np.full(at.shape, -np.inf)) for name in known])

    lasted, error = dwell_times(Path(members, times, states), functions, np.stack([*known.values()]))
    return dict(zip(known, np.where(spans > 0.0, lasted, 0.0), strict=True)), spans, error.max(axis=0)


def shares_of(lasted: Mapping[str, Array], spans: Array, error: Array) -> tuple[list[Array], Array]:
    """Shares (members,) of the time for which `SHARES` fail, NaN where one is unknown, and their error, NaN where
    nothing ran; from those of `lasting`."""
    whole, unknown_share = spans.sum(axis=1), np.full(len(spans), np.nan)
    with np.errstate(invalid="ignore", divide="ignore"):
        shares = {name: times.sum(axis=1) / whole for name, times in lasted.items()}
        return [shares.get(name, unknown_share) for name in SHARES], np.asarray(error / whole)


def validity(
    members: Members, times: Array, states: Array, *, whole: bool = False, film_times: Array | None = None
) -> Array:
    """Shares of the time of motions sampled from their start to their end, (members, `VALIDITY`): of each of `SHARES`;
    the largest error of all shares; and of each state of the first film and of the second, from the ``film_times``
    (members, films, kinds) of the run.

    The error is that of the times at which assumptions begin and cease to hold. Unless the motion is
    ``whole``, as a turn of a cycle is, it is at least the standard error of the shares of `BLOCKS` parts.
    """
    lasted, spans, error = lasting(members, times, states)
    shares, error = shares_of(lasted, spans, error)
    ran = spans.sum(axis=1) > 0.0
    if not whole:
        error = np.maximum(error, _spread_of_parts(members, times, states, list(lasted.values()), spans))
    kinds = np.full((len(times), 2, MOST_KINDS), np.nan)
    for place, film in enumerate(members.system.films):
        if film_times is None:
            break
        with np.errstate(invalid="ignore", divide="ignore"):
            spent = film_times[:, place] / film_times[:, place].sum(axis=1, keepdims=True)
        kinds[:, place, : len(film.kinds)] = np.where(ran[:, None], spent[:, : len(film.kinds)], np.nan)
    return np.hstack([np.stack([*shares, error], axis=1), kinds.reshape(len(times), -1)])


def validity_of_run(members: Members, run: Trajectories, samples: npt.NDArray[np.intp] | slice = slice(None)) -> Array:
    """`validity` of whole runs from start to end, by some of their samples."""
    return validity(members, *to_the_end(run, samples), whole=True, film_times=run.film_times)


def _spread_of_parts(members: Members, times: Array, states: Array, lasted: list[Array], spans: Array) -> Array:
    """The largest standard error of the shares, (members,), by those of `BLOCKS` parts of the motion."""
    length = spans.shape[1] // BLOCKS
    if any(film.kinds for film in members.system.films):
        with np.errstate(all="ignore"):
            film_states = members.film_states(states, members.voltages(times, states))
        for film, state in zip(members.system.films, film_states, strict=True):
            lasted += [np.where(state.kind[:, 1:] == k, spans, 0.0) for k in range(len(film.kinds))]
    error = np.zeros(len(times))
    for durations in lasted if length else ():
        parts, part_spans = (
            a[:, : length * BLOCKS].reshape(len(a), BLOCKS, length).sum(axis=2) for a in (durations, spans)
        )
        share = np.divide(parts, part_spans, out=np.zeros_like(part_spans), where=part_spans > 0.0)
        error = np.maximum(error, share.std(axis=1, ddof=1) / np.sqrt(BLOCKS))
    return error


VALIDITY = len(SHARES) + 1 + 2 * MOST_KINDS
"""The number of shares in the `validity` of a motion."""


def unknown(*shape: int) -> Array:
    """A `validity` filled with NaN."""
    return np.full((*shape, VALIDITY), np.nan)


def validity_variables(
    found: Array,
    outcome: npt.NDArray[np.int8],
    system: ConeSystem,
    dims: tuple[str, ...] = (),
    of: str = "settled motion",
) -> dict[str, Variable]:
    """The columns of `validity` as variables ``validity_NAME`` with these dims after those of the members; for films
    with states also ``film_state_NAME``, and ``second_film_state_NAME`` for the second film.

    ``pulled_in`` is 1 for a run that ended because the film pulled in; for one that continued it is the share of the
    time for which the film had.
    """
    every = np.moveaxis(found, -1, 0)
    columns = dict(zip((*SHARES, "error"), every, strict=False))
    ran_on = np.where(np.isnan(columns["error"]), np.nan, 0.0)
    kind_shares = every[len(SHARES) + 1 :].reshape(2, MOST_KINDS, *found.shape[:-1])
    for film, rows in zip(system.films, kind_shares, strict=False):
        if FAILED in film.kinds:
            ran_on = np.fmax(ran_on, rows[film.kinds.index(FAILED)])
    columns["pulled_in"] = np.where(np.asarray(outcome) == Outcome.PULLED_IN, 1.0, ran_on)
    names = {name: f"share of the {of} with {untrue_by(name)}" for name in ASSUMPTIONS}
    names["error"] = "largest error of these shares"
    labelled: dict[str, Variable] = {
        f"validity_{name}": (dims, columns[name], meaning, "share") for name, meaning in names.items()
    }
    for film, rows in zip(system.films, kind_shares, strict=False):
        for kind, row in zip(film.kinds, rows, strict=False):
            meaning = f"share of the {of} with {film.words} {kind.replace('_', ' ')}"
            labelled[f"{film.prefix}film_state_{kind}"] = (dims, row, meaning, "share")
    return labelled


def invalid(result: xr.Dataset) -> xr.DataArray | None:
    """Mask of the members of a result in which any assumption fails at some time; None without validity."""
    names = [f"validity_{name}" for name in ASSUMPTIONS]
    fails = [result[name] > 0.0 for name in names if name in result]
    return reduce(operator.or_, fails) if fails else None
