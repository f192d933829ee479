"""The lowest and highest displacement of sampled motions, including turning points between samples.

At a turning point the displacement is that of the quintic through displacement, velocity and acceleration at both
samples. Where that is far from the cubic through displacement and velocity, the motion is integrated to the turning
points that may be extremes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.motion.turning import acceleration_at, quintic, turning_points, turning_share
from gelcone.physics.members import Members
from gelcone.quantity import Array

Index = npt.NDArray[np.intp]

FAR = 1e-8
"""Largest distance between quintic and cubic, over the motion's extent, at which the quintic is accurate enough. Its
error is far smaller for a sine, and about as large where the disc turns at the stretch limit as at a wall."""
UNSURE = 2.0
"""Largest error of a quintic over its distance from the cubic."""


def extent(members: Members, times: Array, states: Array, **flow: Any) -> tuple[Array, Array]:
    """The lowest and highest displacement, (members,) each, of motions at ``times`` (members, samples) and ``states``
    (members, samples, N); NaN for a motion with samples that are NaN. ``flow`` are options of `integrate`."""
    x, u = states[..., 0], states[..., 1]
    lowest, highest = x.min(axis=1), x.max(axis=1)
    rows, first = np.nonzero(u[:, :-1] * u[:, 1:] < 0.0)
    if rows.size:
        extremes, apart = _on_quintics(members, times, states, rows, first)
        doubt, low, high = UNSURE * apart, lowest.copy(), highest.copy()
        np.fmin.at(low, rows, extremes + doubt)  # the lowest displacement is below ``low``, the highest above ``high``
        np.fmax.at(high, rows, extremes - doubt)
        may = (extremes - doubt <= low[rows]) | (extremes + doubt >= high[rows])
        at = np.flatnonzero(may & (apart > FAR * (highest - lowest)[rows]))
        if at.size:
            extremes[at] = _reached(members, times, states, rows[at], first[at], flow)
        np.fmin.at(lowest, rows, np.where(np.isnan(lowest[rows]), np.nan, extremes))
        np.fmax.at(highest, rows, np.where(np.isnan(highest[rows]), np.nan, extremes))
    return lowest, highest


def _on_quintics(members: Members, times: Array, states: Array, rows: Index, first: Index) -> tuple[Array, Array]:
    """The displacement (points,) at the turning points of ``rows`` after their samples ``first``, and its distance from
    that of the cubic."""
    t, x, u, a = _both_sides(members, times, states, rows, first)
    gap = t[:, 1] - t[:, 0]
    s = turning_share(gap, x, u, a)
    (u0, u1), (a0, a1) = gap * u.T, gap * gap * a.T
    rest, slope = x[:, 1] - x[:, 0] - u0, u1 - u0
    cubic = x[:, 0] + s * (u0 + s * (3.0 * rest - slope + s * (slope - 2.0 * rest)))
    third, fourth, fifth = quintic(rest - 0.5 * a0, slope - a0, a1 - a0)
    displacement = x[:, 0] + s * (u0 + s * (0.5 * a0 + s * (third + s * (fourth + s * fifth))))
    return np.asarray(displacement), np.abs(displacement - cubic)


def _both_sides(
    members: Members, times: Array, states: Array, rows: Index, first: Index
) -> tuple[Array, Array, Array, Array]:
    """Time, displacement, velocity and acceleration at the samples around each turning point, (points, 2)."""
    both = rows[:, None], first[:, None] + np.arange(2)
    x = states[..., 0][both]
    a = acceleration_at(members.take(rows), times[both], states[both])
    return times[both], x, states[..., 1][both], np.broadcast_to(a, x.shape)


def _reached(members: Members, times: Array, states: Array, rows: Index, first: Index, flow: dict[str, Any]) -> Array:
    """The displacement (points,) at the turning points, integrated from the samples before."""
    sides, starts = _both_sides(members, times, states, rows, first), states[rows, first]
    return turning_points(members.take(rows), starts, sides, np.sign(starts[:, 1]), **flow)[1][:, 0]
