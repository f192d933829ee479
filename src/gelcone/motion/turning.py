"""Turning points of the disc between two samples: on the quintic through both, and by Newton's method on the flow."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gelcone.bracket import halved
from gelcone.motion.flow import integrate
from gelcone.physics.members import Members
from gelcone.quantity import Array

VELOCITY_LEFT = 1e-11
"""Largest velocity at a turning point."""
SMALL_STEP = 1e-3
"""Share of the samples' spacing up to which the last step is taken by the Taylor expansion of the flow."""
MOST_POLISHINGS = 60


def acceleration_at(members: Members, times: Array, states: Array) -> Array:
    """The disc's acceleration at ``times`` (members, samples) and ``states`` (members, samples, N)."""
    return np.asarray(members.flow(times, states)[0][1])


def quintic(rest: Array, slope: Array, change: Array) -> tuple[Array, Array, Array]:
    """The coefficients of s^3, s^4 and s^5 in x0 + u0 s + a0 s^2/2 + ..., with the share s of an interval.

    They add ``rest`` to the value at its end, ``slope`` to the slope there and ``change`` to the second derivative.
    """
    third = 10.0 * rest - 4.0 * slope + 0.5 * change
    return third, 7.0 * slope - 15.0 * rest - change, 6.0 * rest - 3.0 * slope + 0.5 * change


def turning_share(gap: Array, x: Array, u: Array, a: Array) -> Array:
    """The share of each interval (points,) of length ``gap`` at which the velocity of the quintic through displacement,
    velocity and acceleration at both its ends (points, 2) changes its sign."""
    (u0, u1), (slope0, slope1), mean = u.T, gap * a.T, (x[:, 1] - x[:, 0]) / gap
    low, high = np.zeros_like(u0), np.ones_like(u0)
    # A value of exactly 0 at the left end has the sign with which it is left.
    sign = np.sign(np.where(u0 == 0.0, slope0, u0))
    # The cubic of the values and slopes has the mean (u0 + u1)/2 + (slope0 - slope1)/12; s^2 (1 - s)^2 has 1/30.
    bump = 30.0 * (mean - 0.5 * (u0 + u1) - (slope0 - slope1) / 12.0)

    def before(s: Array) -> Any:
        r = 1.0 - s
        value = r * r * ((1.0 + 2.0 * s) * u0 + s * slope0) + s * s * ((1.0 + 2.0 * r) * u1 - r * slope1 + r * r * bump)
        return value * sign > 0.0

    low, high = halved(before, low, high, 40)
    return 0.5 * (low + high)


def turning_points(
    turning: Members, starts: Array, sides: Sequence[Array], kind: Array, **flow: Any
) -> tuple[Array, Array]:
    """Times (points,) at which the velocity vanishes, and displacement and velocity (points, 2), by Newton's method.

    ``sides`` are time, displacement, velocity and acceleration at the samples around each turning point, (points, 2),
    ``starts`` the states at the first of them, ``kind`` the sign of the velocity before the turning point. The last
    step, once it is small, is taken by the Taylor expansion of the flow. The bracket is halved where Newton's step
    leaves it, as near the stretch limit, where the film reverses the motion like a wall.
    """
    begin, end = sides[0].T
    times = begin + (end - begin) * turning_share(end - begin, *sides[1:])
    low, high, states, left = begin.copy(), end.copy(), np.empty((times.size, 2)), np.arange(times.size)
    for _ in range(MOST_POLISHINGS):
        part, at = turning.take(left), times[left]
        reached = integrate(part, starts[left], at[:, None], start=begin[left], **flow).states
        states[left] = reached[:, 0, :2]
        x, u = reached[..., 0], reached[..., 1]
        a = acceleration_at(part, at[:, None], reached)
        step = -u / np.where(a == 0.0, 1.0, a)
        remains = u + a * step + 0.5 * _jerk_at(part, at[:, None], reached) * step * step
        final = np.column_stack([x + (u + 0.5 * a * step) * step, remains])
        before = u[:, 0] * kind[left] > 0.0
        low[left], high[left] = np.where(before, at, low[left]), np.where(before, high[left], at)
        newton = at + step[:, 0]
        inside = (low[left] <= newton) & (newton <= high[left])
        small = np.abs(step[:, 0]) <= SMALL_STEP * (end - begin)[left]
        done = inside & small & (np.abs(remains[:, 0]) <= VELOCITY_LEFT)
        states[left[done]], times[left[done]] = final[done], newton[done]
        better = np.where(inside & (newton != at), newton, 0.5 * (low[left] + high[left]))
        unfinished = ~done & (low[left] < better) & (better < high[left])
        left = left[unfinished]
        if not left.size:
            break
        times[left] = better[unfinished]
    return times, states


def _jerk_at(members: Members, times: Array, states: Array) -> Array:
    """The rate of change of the acceleration along the motion, by the chain rule."""
    n, z = members.numbers(trailing=1), list(np.moveaxis(states, -1, 0))
    rates, (_, (by_time, *by_state), *_) = members.system.rates_and_slopes(times, z, n)
    return np.asarray(sum((slope * rate for slope, rate in zip(by_state, rates, strict=True)), by_time))
