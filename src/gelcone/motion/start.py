"""Initial states of all members, and a check that they lie in the members' domains."""

from __future__ import annotations

import reprlib

import numpy as np
import numpy.typing as npt

from gelcone.errors import InputError
from gelcone.physics.members import Ensemble, Members
from gelcone.quantity import Array


def inside(members: Members, displacement: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """Mask (members,) of members whose stretch limit allows a displacement, one for all or (members,)."""
    x = np.broadcast_to(np.asarray(displacement, dtype=float), (members.size,))
    with np.errstate(over="ignore"):
        return np.asarray(members.strain(x) < members.strain_limit())


def start_states(model: Ensemble, initial: npt.ArrayLike) -> Array:
    """Initial states of all members, (members, N).

    Parameters
    ----------
    model : one actuator or an ensemble.
    initial : displacement and velocity, or all N states; shape (2,) or (N,), or the ensemble's shape followed by
        either. States that are not given start from those of `Members.start_states`.

    Raises
    ------
    InputError : for another shape, numbers that are not finite, or when no member can start.
    """
    members = model.members()
    names = [state.name for state in members.system.states]
    count = len(names)
    try:
        given = np.asarray(initial, dtype=float)
        if given.shape[-1:] not in ((2,), (count,)):
            raise ValueError
        states = np.broadcast_to(given, (*model.shape, given.shape[-1])).reshape(model.size, given.shape[-1])
    except (TypeError, ValueError):
        shapes = [f"shape {(*ensemble, n)}" for ensemble in ((), model.shape) for n in (2, count)]
        wanted = " or ".join(dict.fromkeys(shapes))
        meaning = "a displacement and a velocity" + (f", or {', '.join(names)}" if count > 2 else "")
        shown = " ".join(reprlib.repr(initial).split())
        raise InputError(f"initial = {shown}: must be {meaning}, {wanted}") from None
    if not np.isfinite(states).all():
        raise InputError(f"initial = {states[~np.isfinite(states).all(axis=1)][0].tolist()}: must be finite")
    states = complete(members, states)
    if not (within := inside(members, states[:, 0])).any():
        raise InputError(members.system.outside(float(states[0, 0]), members.numbers_at(0)))
    if not (within & ~members.system.overstretched(list(states.T), members.numbers())).any():
        raise InputError(
            f"initial displacement {states[0, 0]:g}: stretches a Maxwell branch beyond its viscous_limit; start lower, "
            "raise the limit, or give the states of the branch"
        )
    return states


def complete(members: Members, states: Array) -> Array:
    """All N states (members, N), from these or from displacement and velocity (members, 2)."""
    given = states.shape[1]
    if given == len(members.system.states):
        return states
    return np.concatenate([states, members.start_states(states[:, :2])[:, given:]], axis=1)


def nudge(states: Array, by: float) -> Array:
    """States (..., N) with the displacement moved, for motions that would stay at an unstable equilibrium."""
    offset = np.zeros(states.shape[-1])
    offset[0] = by
    return states + offset
