"""Rests of many actuators with one film at once.

Without voltage the disc rests where the force rises through zero, which it does at most once between neighbouring
points of a fine grid, unless it has an extremum close to zero there.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from gelcone.bracket import sign_changes
from gelcone.physics.balance import GRID, rest_of, single_balance
from gelcone.physics.members import Members, Rows
from gelcone.physics.system import ConeSystem
from gelcone.quantity import Array

AT_ONCE = 16
"""Members that are searched at once: a membrane takes a kilobyte for the force at each point of the grid."""
SIDES = np.array([[-1.0], [1.0]])
NODES = np.concatenate([[0.0], GRID, [1.0]])
"""Points of the grid on each side of x = 0, as shares of the |x| from the lowest to the highest."""


def single_rests(members: Members, chosen: npt.NDArray[np.intp]) -> list[float]:
    """The stable equilibria of the ``chosen`` members with one film, without voltage, that are nearest to where their
    bias is free; NaN where there is none.

    They are those of `gelcone.physics.balance.rest_of` to the rounding of the force. That function searches members
    whose force vanishes at a point of the grid, as that of a flat film in balance, is not finite there, or nearly
    vanishes at an extremum.
    """
    groups = [chosen[begin : begin + AT_ONCE] for begin in range(0, chosen.size, AT_ONCE)]
    return [rest for group in groups for rest in _rests(members, group)]


def _rests(members: Members, group: npt.NDArray[np.intp]) -> list[float]:
    system, numbers = members.system, members.own_numbers.take(group)
    balances = [single_balance(system, members.numbers_at(member)) for member in group]
    low, high = np.array([[balance.lowest, balance.highest] for balance in balances]).T[:, :, None]
    places = np.stack([low + (high - low) * NODES] * len(SIDES), axis=1)
    with np.errstate(all="ignore"):
        force_and_slope = system.static_force(SIDES * places, np.asarray(0.0), numbers.trailing(2))
        force, slope = (np.broadcast_to(values, places.shape) for values in force_and_slope)
        alone = np.any(_irregular(places, SIDES * force, slope), axis=(1, 2), keepdims=True)
        rests = _nearest(system, numbers, places, np.where(alone, np.nan, SIDES * force)).tolist()
    for k in np.flatnonzero(alone):
        rests[k] = rest_of(balances[k], None) if balances[k].reachable else math.nan
    return rests


def _irregular(places: Array, outward: Array, slope: Array) -> npt.NDArray[np.bool_]:
    """Mask of the intervals between points in which a force ``outward`` may vanish more than once, and of those with an
    end at which it vanishes or is not finite."""
    begin, end = outward[..., :-1], outward[..., 1:]
    turns = (begin * slope[..., :-1] < 0.0) & (end * slope[..., 1:] > 0.0)
    steepest = np.maximum(np.abs(slope[..., :-1]), np.abs(slope[..., 1:]))
    close = np.minimum(np.abs(begin), np.abs(end)) <= np.diff(places) * steepest
    return (turns & close & (begin * end > 0.0)) | ~(np.isfinite(begin * end) & (begin * end != 0.0))


def _nearest(system: ConeSystem, numbers: Rows, places: Array, outward: Array) -> Array:
    """The place of each member nearest to where its bias is free, of those at which the force rises through zero; NaN
    where there is none."""
    member, side, cell = np.nonzero((outward[..., :-1] < 0.0) & (outward[..., 1:] > 0.0))
    rests = np.full(len(outward), np.nan)
    if not member.size:
        return rests
    n, sign = numbers.take(member), SIDES[side, 0]

    def force(x: Array) -> Array:
        return np.asarray(system.static_force(sign * x, np.asarray(0.0), n)[0])

    x = sign * sign_changes(force, places[member, side, cell], places[member, side, cell + 1])
    away = np.where(system.film.highest_squared(x, n) > 0.0, np.abs(x - system.bias.free_height(n)), np.inf)
    for k in np.lexsort((-x, away))[::-1]:
        if away[k] < np.inf:
            rests[member[k]] = x[k]
    return rests
