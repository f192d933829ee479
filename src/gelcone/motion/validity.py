"""Where the model stops being true: for which share of a motion the film is slack, breaks down or nears its limit.

Shares are those of samples spread evenly over the motion. Over forcing periods they are spread so that their phases
are spread evenly too, also over the periods of a subharmonic (`spread_over`). A film that wrinkles may be slack: what
it does then is told by the shares of its states, and only a film that bears compression is outside its validity there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.dataset import Variable
from gelcone.physics.film.film import FilmState
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
    "pulled_in": "a film that has pulled in",
}
"""How the model stops being true. A film that wrinkles may be slack."""
SLACK_IN = {"hoop_slack": ("hoop_slack", "crumpled"), "meridional_slack": ("meridional_slack", "crumpled")}
"""States of a film that wrinkles in which each direction is slack."""
MOST_KINDS = 5
"""States that each of two films may have (`gelcone.physics.film.film.Film.kinds`)."""
SHARES = tuple(name for name in ASSUMPTIONS if name != "pulled_in")
"""Those of which a motion has a share."""
NEAR_LIMIT = 0.99
SAMPLES = 511
"""Samples of a settled motion: not a multiple of any number of phases, so that over 64 forcing periods each lies at a
phase of its own."""
BLOCKS = 8
"""Parts of a motion whose shares are compared for the error of the whole's."""


Fails = Mapping[str, npt.NDArray[np.bool_]]
"""Name of an assumption -> where it fails."""


def spread_over(periods: int) -> Array:
    """Times of the samples in forcing periods, (samples,), within a motion of so many periods.

    The third of a spacing keeps them off the phases at which other samples are taken.
    """
    return periods * (np.arange(SAMPLES) + 1.0 / 3.0) / SAMPLES


def broken(
    members: Members, x: Array, voltages: Sequence[Array], states: Sequence[FilmState | None] = (None, None)
) -> Fails:
    """Which assumptions fail at displacements (members, samples), by name; of two films, of either.

    ``voltages`` holds that of each film, (members, samples), and ``states`` theirs where they are known already. What
    nothing is known of is left out: the breakdown without a dielectric strength, slack of a film that does not know its
    stresses.
    """
    return _of_either(broken_by_film(members, x, voltages, states), x)


def outside(
    members: Members, x: Array, voltages: Sequence[Array], states: Sequence[FilmState | None] = (None, None)
) -> Fails:
    """Where the model is untrue: what `broken` tells, but slack only of a film that bears it as compression."""
    each = broken_by_film(members, x, voltages, states)
    for film, fails in zip(members.system.films, each, strict=True):
        if film.kinds:
            fails |= {name: np.zeros_like(fails[name]) for name in SLACK_IN.keys() & fails.keys()}
    return _of_either(each, x)


def _of_either(films: Sequence[Fails], x: Array) -> Fails:
    found: dict[str, npt.NDArray[np.bool_]] = {}
    for fails in films:
        for name, where in fails.items():
            found[name] = np.broadcast_to(found.get(name, False) | where, x.shape)
    return found


def broken_by_film(
    members: Members, x: Array, voltages: Sequence[Array], states: Sequence[FilmState | None] = (None, None)
) -> list[dict[str, npt.NDArray[np.bool_]]]:
    """What `broken` tells of each film alone."""
    n, found = members.numbers(trailing=1), list[dict[str, npt.NDArray[np.bool_]]]()
    for film, voltage, state in zip(members.system.films, voltages, states, strict=False):
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # at a stretch limit
            state = film.state(x, voltage, n) if state is None else state
            fails = {"near_limit": film.near_limit(x, voltage, n, NEAR_LIMIT)}
            fails |= _slack(film, state)
            if "dielectric_strength" in members.values:
                fails["breakdown"] = np.asarray(state.true_field > members.values["dielectric_strength"][:, None])
        found.append({name: np.broadcast_to(where, x.shape) for name, where in fails.items()})
    return found


def _slack(film: PlacedFilm, state: FilmState) -> Fails:
    """Where hoops and meridians are slack: under compression, or wrinkled instead where the film wrinkles."""
    stresses = {"hoop_slack": state.hoop_stress, "meridional_slack": state.meridional_stress}
    known = {name: stress for name, stress in stresses.items() if not np.isnan(stress).all()}
    if not film.kinds:
        return {name: np.asarray(stress < 0.0) for name, stress in known.items()}
    # The stresses of a slack direction are zero up to rounding, so that the state of the film tells.
    return {
        name: np.isin(state.kind, [k for k, kind in enumerate(film.kinds) if kind in SLACK_IN[name]]) for name in known
    }


def untrue_by(name: str) -> str:
    """What makes the model untrue, in words."""
    return ASSUMPTIONS[name] + (" under compression" if name in SLACK_IN else "")


def shares(fails: Fails, ran: npt.NDArray[np.bool_]) -> dict[str, Array]:
    """Share (members,) of the samples (members, samples) that ``ran`` at which each of `SHARES` fails, NaN unknown."""
    with np.errstate(invalid="ignore", divide="ignore"):
        found = {name: (where & ran).sum(axis=1) / ran.sum(axis=1) for name, where in fails.items()}
    return {name: found.get(name, np.full(len(ran), np.nan)) for name in SHARES}


def validity(members: Members, times: Array, states: Array, *, turn: bool = False) -> Array:
    """Shares over samples of motions, (members, 5 + 2 `MOST_KINDS`): of each of `SHARES`; the largest standard error of
    all shares; and of each state of the first film and of the second.

    The error is the standard error of the shares of `BLOCKS` parts of the motion, and at least one sample. Of one whole
    ``turn`` of a cycle it is half a sample for each time that an assumption begins or ceases to hold.
    """
    x, n = states[..., 0], members.numbers(trailing=1)
    ran, voltages = ~np.isnan(x), members.voltages(times, states)
    films = members.system.films
    with np.errstate(over="ignore", invalid="ignore"):
        of_films = [film.state(x, voltage, n) for film, voltage in zip(films, voltages, strict=True)]
    fails = outside(members, x, voltages, of_films)
    kinds = np.full((len(x), 2, MOST_KINDS), np.nan)
    spent = {}
    for place, (film, state) in enumerate(zip(films, of_films, strict=True)):
        for k in range(len(film.kinds)):
            spent[place, k] = np.broadcast_to(state.kind == k, x.shape)
            with np.errstate(invalid="ignore", divide="ignore"):
                kinds[:, place, k] = (spent[place, k] & ran).sum(axis=1) / ran.sum(axis=1)
    error = np.where(ran.any(axis=1), 1.0 / states.shape[1], np.nan)
    length = states.shape[1] // BLOCKS
    for where in (*fails.values(), *spent.values()):
        if turn:
            changes = (where[:, 1:] != where[:, :-1]).sum(axis=1) + (where[:, 0] != where[:, -1])
            error = np.maximum(error, 0.5 * (changes / where.shape[1]))
            continue
        parts = where[:, : length * BLOCKS].reshape(len(where), BLOCKS, length).mean(axis=2)
        error = np.maximum(error, parts.std(axis=1, ddof=1) / np.sqrt(BLOCKS))
    return np.hstack([np.stack([*shares(fails, ran).values(), error], axis=1), kinds.reshape(len(x), -1)])


def unknown(*shape: int) -> Array:
    """What `validity` is of motions of which nothing is known yet."""
    return np.full((*shape, len(SHARES) + 1 + 2 * MOST_KINDS), np.nan)


def validity_variables(
    found: Array,
    outcome: npt.NDArray[np.int8],
    system: ConeSystem,
    dims: tuple[str, ...] = (),
    of: str = "settled motion",
) -> dict[str, Variable]:
    """The columns of `validity` as variables ``validity_NAME`` with these dims behind the members'; and of films that
    have states ``film_state_NAME``, of a second one ``second_film_state_NAME``.

    A run that ended because the film pulled in counts as one that has pulled in all the time; one that went on, with
    the share of the time for which it has.
    """
    every = np.moveaxis(found, -1, 0)
    columns = dict(zip((*SHARES, "error"), every, strict=False))
    ran_on = np.where(np.isnan(columns["error"]), np.nan, 0.0)
    own = every[len(SHARES) + 1 :].reshape(2, MOST_KINDS, *found.shape[:-1])
    for film, rows in zip(system.films, own, strict=False):
        if FAILED in film.kinds:
            ran_on = np.fmax(ran_on, rows[film.kinds.index(FAILED)])
    columns["pulled_in"] = np.where(np.asarray(outcome) == Outcome.PULLED_IN, 1.0, ran_on)
    names = {name: f"share of the {of} with {untrue_by(name)}" for name in ASSUMPTIONS}
    names["error"] = "largest standard error of these shares"
    told: dict[str, Variable] = {
        f"validity_{name}": (dims, columns[name], meaning, "share") for name, meaning in names.items()
    }
    for film, rows in zip(system.films, own, strict=False):
        for kind, row in zip(film.kinds, rows, strict=False):
            meaning = f"share of the {of} with {film.words} {kind.replace('_', ' ')}"
            told[f"{film.prefix}film_state_{kind}"] = (dims, row, meaning, "share")
    return told


def invalid(result: xr.Dataset, prefix: str = "") -> xr.DataArray | None:
    """Where in a result any assumption fails for more than a sample; None for a result without validity."""
    names = [f"{prefix}validity_{name}" for name in ASSUMPTIONS]
    known = [result[name] for name in names if name in result]
    if not known:
        return None
    fails = known[0] > 0.0
    for share in known[1:]:
        fails = fails | (share > 0.0)
    return fails
