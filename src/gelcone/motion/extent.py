"""The lowest and highest displacement of sampled motions, also where the disc turns between two samples.

There the displacement is the quintic through displacement, velocity and acceleration at both samples.
"""

from __future__ import annotations

import numpy as np

from gelcone.physics.bracket import rise
from gelcone.physics.members import Members
from gelcone.quantity import Array


def acceleration_at(members: Members, times: Array, states: Array) -> Array:
    """The disc's acceleration at ``times`` (members, samples) and ``states`` (members, samples, N)."""
    return np.asarray(members.flow(times, states)[0][1])


def extent(members: Members, times: Array, states: Array) -> tuple[Array, Array]:
    """The lowest and highest displacement, (members,) each, of motions at ``times`` (members, samples) and ``states``
    (members, samples, N); NaN of one that is not known throughout."""
    x, u = states[..., 0], states[..., 1]
    lowest, highest = x.min(axis=1), x.max(axis=1)
    rows, first = np.nonzero(u[:, :-1] * u[:, 1:] < 0.0)
    if rows.size:
        both = rows[:, None], first[:, None] + np.arange(2)
        a = acceleration_at(members.take(rows), times[both], states[both])
        turns = _turning(times[both], x[both], u[both], np.broadcast_to(a, x[both].shape))
        np.fmin.at(lowest, rows, np.where(np.isnan(lowest[rows]), np.nan, turns))
        np.fmax.at(highest, rows, np.where(np.isnan(highest[rows]), np.nan, turns))
    return lowest, highest


def quintic(rest: Array, slope: Array, change: Array) -> tuple[Array, Array, Array]:
    """The coefficients of s^3, s^4 and s^5 in x0 + u0 s + a0 s^2/2 + ..., with the share s of an interval.

    They add ``rest`` to the value at its end, ``slope`` to the slope there and ``change`` to the second derivative.
    """
    third = 10.0 * rest - 4.0 * slope + 0.5 * change
    return third, 7.0 * slope - 15.0 * rest - change, 6.0 * rest - 3.0 * slope + 0.5 * change


def _turning(times: Array, x: Array, u: Array, a: Array) -> Array:
    """The displacement (points,) where the velocity passes zero between two samples, (points, 2) each."""
    h = times[:, 1] - times[:, 0]
    (u0, u1), (a0, a1) = (h * u.T), (h * h * a.T)
    rest = x[:, 1] - x[:, 0] - u0 - 0.5 * a0
    slope, change = u1 - u0 - a0, a1 - a0
    third, fourth, fifth = quintic(rest, slope, change)
    upward = np.where(u0 > 0.0, -1.0, 1.0)

    def velocity(s: Array) -> Array:
        return upward * (u0 + s * (a0 + s * (3.0 * third + s * (4.0 * fourth + s * 5.0 * fifth))))

    s = rise(velocity, np.zeros(h.size), np.ones(h.size))
    return np.asarray(x[:, 0] + s * (u0 + s * (0.5 * a0 + s * (third + s * (fourth + s * fifth)))))
