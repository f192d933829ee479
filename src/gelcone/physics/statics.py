"""The static balance of each member of an ensemble, of single and double cones."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator, MutableMapping, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from gelcone.errors import InputError
from gelcone.physics.at_rest import BIAS_SHARE
from gelcone.physics.balance import StaticBalance, rest_of, single_balance
from gelcone.physics.commanded import commanded_balance
from gelcone.physics.component import Component
from gelcone.physics.members import Ensemble, Members
from gelcone.physics.model import ConeModel
from gelcone.physics.rests import single_rests
from gelcone.physics.system import ConeSystem
from gelcone.quantity import Array

E = TypeVar("E", ConeModel, Members)
T = TypeVar("T")


def every_balance(model: Ensemble, bias_share: float | None = None) -> list[StaticBalance]:
    """The static balances of all members under constant commands, also of those without any state; single cones with
    equal film, bias and circuit share one.

    ``bias_share``: the bias of films in opposite phase over the command of the first, negative if they have different
    signs. Default: the bias of the model, with the sign of the command.
    """
    members = model.members()
    if len(members.system.films) > 1:
        bias_numbers = {} if bias_share is None else {BIAS_SHARE: bias_share}
        return [
            commanded_balance(members.system, members.numbers_at(member) | bias_numbers)
            for member in range(members.size)
        ]
    _, firsts, which = _alike(members, members.system.circuit)
    balances = [commanded_balance(members.system, members.numbers_at(member)) for member in firsts]
    return [balances[index] for index in which]


def balances_of_films(members: Members) -> list[StaticBalance]:
    """The static balances of all members with one film, under constant voltages on the film."""
    _, firsts, which = _alike(members)
    balances = [single_balance(members.system, members.numbers_at(member)) for member in firsts]
    return [balances[index] for index in which]


def _alike(members: Members, *more: Component) -> tuple[Array, npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """The different sets of numbers of films, bias and ``more`` components, (sets, numbers); the first member with each
    set; and the index of the set of each member."""
    system = members.system
    parts = (system.bias, *system.films, *more)
    values = {name: value for part in parts for name, value in part.numbers(members.values).items()}
    table = np.column_stack([np.broadcast_to(value, members.shape) for value in values.values()])
    if members.size == 1:
        return table, np.zeros(1, dtype=np.intp), np.zeros(1, dtype=np.intp)
    sets, firsts, which = np.unique(table, axis=0, return_index=True, return_inverse=True)
    return sets, firsts, which.ravel()


def each(function: Callable[..., T], balances: Sequence[StaticBalance], *more: Sequence[Any]) -> list[T]:
    """Evaluate ``function(balance, ...)`` for each balance with its arguments, once for equal ones."""
    known: dict[tuple[Any, ...], T] = {}
    rows = list(zip(balances, *more, strict=True))
    keys = [(id(balance), *values) for balance, *values in rows]
    for key, row in zip(keys, rows, strict=True):
        if key not in known:
            known[key] = function(*row)
    return [known[key] for key in keys]


def balances_of(model: Ensemble) -> list[StaticBalance]:
    """The static balances of all members; `InputError` if none has a displacement inside its stretch limit."""
    balances = every_balance(model)
    if not any(balance.reachable for balance in balances):
        raise InputError(model.system.unreachable(balances[0].n))
    return balances


def rest_displacement(model: Ensemble) -> float:
    """The stable equilibrium of a single actuator, without voltage on any film, that is nearest to where its bias is
    free; of two equally near ones the higher, NaN if there is none."""
    members = switched_off(model.members())
    balances_of(members)  # refuses an actuator that no displacement keeps inside its stretch limit
    return _searched(members, np.zeros(1, dtype=np.intp))[0]


def rest_displacements(model: Ensemble) -> Any:
    """`rest_displacement` of every member, in the shape of the model; NaN where there is none.

    Members with equal films and bias are searched once, whatever their drive. Rests are stored, since a membrane takes
    some milliseconds.
    """
    members = switched_off(model.members())
    sets, firsts, which = _alike(members)
    keys = [(members.system, row.tobytes()) for row in sets]
    key_rests = [_rests.get(key) for key in keys]
    places, guessed = getattr(_thread, "trail", NO_TRAIL)
    if places is not None:
        for index in _unknown(key_rests):
            guess = _continued(members, firsts[index], places.get(members.system))
            if guess is not None:
                key_rests[index] = guessed[keys[index]] = guess
    unknown = _unknown(key_rests)
    for index, rest in zip(unknown, _searched(members, firsts[unknown]), strict=True):
        key_rests[index] = rest
    store_rests(
        {key: rest for key, rest in zip(keys, key_rests, strict=True) if rest is not None and key not in guessed}
    )
    if places is not None:
        places[members.system] = key_rests[-1]
    rests = np.array(key_rests)[which]
    return rests.reshape(model.shape) if model.shape else float(rests[0])


def _unknown(found: Sequence[float | None]) -> list[int]:
    return [place for place, rest in enumerate(found) if rest is None]


def _searched(members: Members, chosen: npt.NDArray[np.intp]) -> list[float]:
    """The rests of the ``chosen`` members."""
    if len(members.system.films) == 1:
        return single_rests(members, chosen)
    balances = [commanded_balance(members.system, members.numbers_at(member)) for member in chosen]
    return [rest_of(balance, None) if balance.reachable else math.nan for balance in balances]


RestKey = tuple[ConeSystem, bytes]
"""A system and the numbers of its films and bias."""
MOST_RESTS = 1024
"""Most rests that are stored."""
_rests: dict[RestKey, float] = {}


def store_rests(found: dict[RestKey, float]) -> None:
    """Store rests, such as those that another process has found."""
    if len(_rests) > MOST_RESTS:
        _rests.clear()
    _rests.update(found)


def stored_rests(keys: Sequence[RestKey]) -> dict[RestKey, float]:
    """The stored rests of some keys."""
    return {key: _rests[key] for key in keys if key in _rests}


# --- rests of a parameter that changes live ---------------------------------------------------------------------------

FARTHEST_REST = 0.1
"""Largest distance of a rest from the one that it continues, in units of b - a."""
_thread = threading.local()
NO_TRAIL: tuple[Any, Any] = (None, {})
"""Last rests of systems, and rests that were found from them, in a thread in which none are continued."""


@contextmanager
def continuing(places: MutableMapping[ConeSystem, float]) -> Iterator[dict[RestKey, float]]:
    """Let `rest_displacements` continue the last rest in ``places`` by Newton's method, in this thread, if no rest is
    stored; ``places`` is updated.

    Yields the rests found so. They are not stored: another stable rest may lie nearer to where the bias is free, so
    that they should be searched later.
    """
    before, guessed = getattr(_thread, "trail", NO_TRAIL), dict[RestKey, float]()
    _thread.trail = places, guessed
    try:
        yield guessed
    finally:
        _thread.trail = before


def _continued(members: Members, member: int, near: float | None) -> float | None:
    """The stable rest of a member that Newton's method reaches from ``near``; None if it is not close."""
    if near is None or math.isnan(near):
        return None
    n = members.numbers_at(member)
    x = float(stable_near(np.float64(near), lambda x: members.system.static_force(x, 0.0 * x, n))[0])
    return x if abs(x - near) < FARTHEST_REST else None


def stable_near(x: Any, balance: Callable[[Any], tuple[Any, Any]], longest: float = math.inf) -> tuple[Array, Array]:
    """The stable equilibria that Newton's method reaches from displacements x in steps of at most ``longest``, and
    their stiffness; NaN where it reaches none or passes where none is stable. ``balance`` returns force and stiffness
    at displacements."""
    with np.errstate(all="ignore"):
        for _ in range(NEWTON_STEPS):
            force, stiffness = balance(x)
            step = np.clip(force / np.where(stiffness > 0.0, stiffness, np.nan), -longest, longest)
            x = x - step
            change = np.abs(step) / (1.0 + np.abs(x))
            if not (change > NEWTON_ROUNDING).any():
                break
        near = change < CONVERGED
    return np.where(near, x, np.nan), np.where(near, stiffness, np.nan)


NEWTON_STEPS, NEWTON_ROUNDING, CONVERGED = 40, 1e-13, 1e-9
"""Most steps of Newton's method, the relative size of a step that counts as rounding and ends it, and that of the last
step above which no equilibrium is found."""


def switched_off(model: E) -> E:
    """The ensemble; a double cone without the bias or constant voltage that acts on its second film at rest."""
    if len(model.system.films) == 1:
        return model
    off = model.values.keys() & {"voltage_bias", "second_voltage"}
    return model.replace(**dict.fromkeys(off, 0.0))
