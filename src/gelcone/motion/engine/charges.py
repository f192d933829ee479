"""Deviations of the charges of films in place of those of their voltages.

Where a film's law changes, as when it begins to wrinkle, the rate of its voltage behind a resistance jumps, and so do
deviations of the voltage; those of its charge are continuous. Programs carry deviations of charges, results hold those
of the states; along a motion each is linear in the other.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from gelcone.physics.system import ConeSystem
from gelcone.quantity import Array


def voltage_turns(system: ConeSystem, times: Array, states: Array, n: Mapping[str, Any]) -> tuple[Array, Array]:
    """Matrices (..., N, N) that transform deviations of ``states`` (..., N) into those with charges in place of
    voltages, and logarithms (...) of their determinants."""
    turns = np.broadcast_to(np.eye(states.shape[-1]), (*states.shape, states.shape[-1])).copy()
    scale = np.zeros(states.shape[:-1])
    for place, by in system.charges_by(times, list(np.moveaxis(states, -1, 0)), n).items():
        turns[..., place, :] = np.stack(np.broadcast_arrays(*by, scale)[:-1], axis=-1)
        scale = scale + np.log(turns[..., place, place])
    lost = ~np.isfinite(turns).all(axis=(-2, -1))
    turns[lost] = np.eye(states.shape[-1]) * np.nan
    return turns, scale
