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
from gelcone.physics.balance import StaticBalance, rest_of, single_balance
from gelcone.physics.members import Ensemble, Members
from gelcone.physics.model import ConeModel
from gelcone.physics.pair import pair_balance
from gelcone.physics.system import BIAS_SHARE, ConeSystem
from gelcone.quantity import Array

E = TypeVar("E", ConeModel, Members)
T = TypeVar("T")


def every_balance(model: Ensemble, bias_share: float | None = None) -> list[StaticBalance]:
    """All members of the ensemble, also those that reach nothing; of one film, one for equal films and bias.

    ``bias_share``: share of the voltage that the bias of films in opposite phase takes; default: theirs is the model's.
    """
    members = model.members()
    if len(members.system.films) > 1:
        more = {} if bias_share is None else {BIAS_SHARE: bias_share}
        return [pair_balance(members.system, members.numbers_at(member) | more) for member in range(members.size)]
    _, firsts, which = _alike(members)
    found = [single_balance(members.system, members.numbers_at(member)) for member in firsts]
    return [found[place] for place in which]


def _alike(members: Members) -> tuple[Array, npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """The numbers of films and bias that occur, (sets, numbers), whatever the drive; the first members with each set;
    and which set each member has."""
    system = members.system
    parts = (system.bias, *system.films)
    values = {name: value for part in parts for name, value in part.numbers(members.values).items()}
    table = np.column_stack([np.broadcast_to(value, members.shape) for value in values.values()])
    if members.size == 1:
        return table, np.zeros(1, dtype=np.intp), np.zeros(1, dtype=np.intp)
    sets, firsts, which = np.unique(table, axis=0, return_index=True, return_inverse=True)
    return sets, firsts, which.ravel()


def each(function: Callable[..., T], balances: Sequence[StaticBalance], *more: Sequence[Any]) -> list[T]:
    """``function(balance, ...)`` of each balance and what belongs to it; what is the same is computed once."""
    known: dict[tuple[Any, ...], T] = {}
    rows = list(zip(balances, *more, strict=True))
    keys = [(id(balance), *values) for balance, *values in rows]
    for key, row in zip(keys, rows, strict=True):
        if key not in known:
            known[key] = function(*row)
    return [known[key] for key in keys]


def balances_of(model: Ensemble) -> list[StaticBalance]:
    """All members of the ensemble; `InputError` when none has a displacement inside its stretch limit."""
    found = every_balance(model)
    if not any(balance.reachable for balance in found):
        raise InputError(model.system.unreachable(found[0].n))
    return found


def rest_displacement(model: Ensemble) -> float:
    """The stable equilibrium of a single actuator without voltage that is nearest to where its bias is free, of two
    equally near ones the higher; NaN when there is none. A double cone has no voltage on either film."""
    (balance,) = balances_of(switched_off(model.members()))
    return rest_of(balance, None)


def rest_displacements(model: Ensemble) -> Any:
    """`rest_displacement` of every member: a number, or an array (members,); NaN where there is none.

    Members of equal films and bias, whatever their drive, are searched once; what was found is stored, for a film that
    wrinkles takes a quarter of a second.
    """
    members = switched_off(model.members())
    sets, firsts, which = _alike(members)
    keys = [(members.system, own.tobytes()) for own in sets]
    found = [_rests.get(key) for key in keys]
    trail = getattr(_thread, "trail", None)
    guessed = {} if trail is None else trail.guessed
    for place in (place for place, rest in enumerate(found) if rest is None):
        one = members if members.size == 1 else members.take(firsts[place : place + 1])
        if trail is not None and (guess := _continued(one, trail.places.get(members.system))) is not None:
            found[place] = guessed[keys[place]] = guess
        else:
            found[place] = _rest(*every_balance(one))
    keep_rests({key: rest for key, rest in zip(keys, found, strict=True) if rest is not None and key not in guessed})
    if trail is not None:
        trail.places[members.system] = found[-1]
    rests = np.array(found)[which]
    return rests.reshape(model.shape) if model.shape else float(rests[0])


RestKey = tuple[ConeSystem, bytes]
"""A system and the numbers of its films and bias."""
MOST_RESTS = 1024
"""Most rests that are held."""
_rests: dict[RestKey, float] = {}


def keep_rests(found: dict[RestKey, float]) -> None:
    """Keeps rests, also those that were searched for in another process."""
    if len(_rests) > MOST_RESTS:
        _rests.clear()
    _rests.update(found)


def kept_rests(keys: Sequence[RestKey]) -> dict[RestKey, float]:
    """The rests among these keys that are held."""
    return {key: _rests[key] for key in keys if key in _rests}


# --- rests of a parameter under the hand ------------------------------------------------------------------------------

FARTHEST = 0.1
"""How far a rest may lie from the one that it continues, in units of b - a."""
MOST_STEPS = 12
_thread = threading.local()


class _Trail:
    def __init__(self, places: MutableMapping[ConeSystem, float]) -> None:
        self.places, self.guessed = places, dict[RestKey, float]()


@contextmanager
def continuing(places: MutableMapping[ConeSystem, float]) -> Iterator[dict[RestKey, float]]:
    """In this thread `rest_displacements` starts from the last rest in ``places``, which it keeps up to date, where
    none is known: some Newton steps in place of a search. A rest found so is not stored, for another stable rest may
    lie nearer to where the bias is free; it is in the mapping that this gives, so that one may search for it later.
    """
    before, _thread.trail = getattr(_thread, "trail", None), _Trail(places)
    try:
        yield _thread.trail.guessed
    finally:
        _thread.trail = before


def _continued(member: Members, near: float | None) -> float | None:
    """The stable rest of a single member that Newton's method reaches from ``near``; None where none is close by."""
    if near is None or math.isnan(near):
        return None
    n, x = member.numbers_at(0), near
    for _ in range(MOST_STEPS):
        with np.errstate(all="ignore"):
            force, slope = (float(value) for value in member.system.static_force(np.asarray(x), np.asarray(0.0), n))
        if not (slope > 0.0 and math.isfinite(force)):
            return None
        step = force / slope
        x -= step
        if not abs(x - near) < FARTHEST:
            return None
        if abs(step) <= NEWTON_ROUNDING * (1.0 + abs(x)):
            return x
    return None


NEWTON_ROUNDING = 1e-13
"""A Newton step of less than this share is rounding."""


def _rest(balance: StaticBalance) -> float:
    return rest_of(balance, None) if balance.reachable else math.nan


def switched_off(model: E) -> E:
    """The ensemble; a double cone without what puts a voltage on its second film at rest."""
    if len(model.system.films) == 1:
        return model
    off = model.values.keys() & {"voltage_bias", "second_voltage"}
    return model.replace(**dict.fromkeys(off, 0.0))
