"""The paper's method, under examination: Runge-Kutta 4 with a fixed step and no guard at the stretch limit.

Beyond the limit the closed form of the film's force continues with the wrong sign, and so does this integrator. Nothing
outside this folder uses it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array


@dataclass(frozen=True)
class FixedStepRun:
    """States (members, steps + 1, 2), largest exponent over the run (members,), and share of steps beyond the stretch
    limit (members,)."""

    states: Array
    exponent: Array
    beyond: Array


def fixed_step(model: ConeModel, initial: tuple[float, float], step: float, steps: int) -> FixedStepRun:
    """Integrates every member of a flattened ensemble with a fixed step; non-finite states are returned as they are."""
    members = model.members()
    n = members.numbers()
    state = np.tile([initial[0], initial[1], 1.0, 0.0], (members.size, 1)).T
    states = np.empty((members.size, steps + 1, 2))
    states[:, 0] = state[:2].T
    grown, beyond = np.zeros(members.size), np.zeros(members.size)
    limit = members.strain_limit()
    with np.errstate(all="ignore"):
        for k in range(steps):
            state = _step(members, n, k * step, state, step)
            length = np.hypot(state[2], state[3])
            grown += np.log(length)
            state[2:] /= length
            states[:, k + 1] = state[:2].T
            beyond += ~(members.strain(state[0]) < limit)
    return FixedStepRun(states, grown / (steps * step), beyond / steps)


def _step(members: Members, n: Mapping[str, Array], time: float, state: Array, step: float) -> Array:
    def rate(at: float, y: Array) -> Array:
        rates, jacobian = members.system.flow(at, list(y[:2]), n)
        slope, damping = jacobian[1]
        return np.stack([*rates, y[3], slope * y[2] + damping * y[3]])

    k1 = rate(time, state)
    k2 = rate(time + step / 2, state + step / 2 * k1)
    k3 = rate(time + step / 2, state + step / 2 * k2)
    k4 = rate(time + step, state + step * k3)
    return state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
