"""Cycles: the periodic orbit that a damped motion settles on, how far it still is from it, and its exponents.

A motion that nearly returns after n drive repeats is near a fixed point of the map over n repeats. Two Newton steps
from it give the cycle itself and tell it from a slow drift, which has no fixed point nearby. The eigenvalues of the
tangent map over the cycle, its Floquet multipliers, give both Lyapunov exponents without any averaging. Nayfeh and
Balachandran, Applied Nonlinear Dynamics (1995), chapters 3 and 7.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.motion.flow import integrate
from gelcone.motion.tangents import CERTAIN, FLOOR, LONG_STRETCH, Clock, chained, clocks, log_multipliers, qr_growth
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

RETURNS = 64
"""Repeats that are looked at; motions with up to a quarter of this as period are recognised."""
LONGEST_PERIOD = RETURNS // 4
PHASES = 8
"""Samples within each repeat, for the amplitude and for returns: a slow drive can push all motions to the same point
once a repeat, and they still differ between."""
RETURN_TOLERANCE = 1e-6
NEAR_RETURN = 1e-4
"""A damped motion that returns this closely is asked for the cycle that it returns to, and one that is no further from
it has arrived."""
NEAR = 1e-2
"""A cycle further away than this share of the motion's size is not the one that the motion is on."""
CONVERGENCE = 0.1
"""The second Newton step has to be this much smaller than the first, or negligible, for a cycle to be there."""
NEGLIGIBLE = 1e-8
SAME_POINT = 1e-6
"""Points of a cycle that are closer than this share of its size are one."""
SMALLEST_SIZE = 1e-3
STEPS_BESIDE = 8
CLOSE_BESIDE = 1e-4
"""Newton's method from chaos stops after so many steps, or when the next is this small beside the motion's size."""
FARTHEST_BESIDE = 1.2
"""It is given up where it leads further out than this many times the extent of the chaos."""
TOLERANCE_BESIDE = 1e-7
"""Errors of its integration: far below that closeness, as only whether a cycle is there and attracts is asked."""
MAPS_BESIDE = ((1, 1.0), (1, -1.0), (2, 1.0), (3, 1.0))
"""Repeats and sign of the maps whose fixed points are looked for beside chaos. Minus the map over one repeat has the
cycles of two repeats that are their own mirror image; most cycles that chaos falls into are of these kinds."""


def follow(model: ConeModel, states: Array, **flow_options: Any) -> tuple[Array, npt.NDArray[np.int8]]:
    """Paths over `RETURNS` repeats from ``states`` at a whole repeat, (members, repeats, phases, 2), and the outcomes.

    The last phase of each repeat is its end.
    """
    repeat = np.broadcast_to(model.forcing_period, model.shape)
    times = repeat[:, None] * (np.arange(1, RETURNS * PHASES + 1) / PHASES)
    flow = integrate(model, states, times, **flow_options)
    return flow.states.reshape(len(states), RETURNS, PHASES, 2), flow.outcome


def periods_of(points: Array, tolerance: npt.ArrayLike = RETURN_TOLERANCE) -> tuple[npt.NDArray[np.int64], Array]:
    """Smallest number of repeats after which all points return, (members,), 0 if none; and the smallest distance.

    ``points`` (members, repeats, coordinates). A return is closer than ``tolerance`` times the size of the motion (at
    least 1e-3 of a length), for every point.
    """
    scale = np.maximum(np.abs(points).max(axis=(1, 2)), SMALLEST_SIZE)
    period = np.zeros(len(points), dtype=np.int64)
    nearest = np.full(len(points), np.inf)
    for candidate in range(LONGEST_PERIOD, 0, -1):
        distance = np.abs(points[:, candidate:] - points[:, :-candidate]).max(axis=(1, 2)) / scale
        returns = distance < tolerance
        period[returns] = candidate
        nearest = np.where(returns, distance, np.where(period > 0, nearest, np.fmin(nearest, distance)))
    return period, nearest


@dataclass(frozen=True)
class Cycles:
    """The cycles near some motions; arrays (members, ...).

    ``found``; ``period`` in drive repeats; ``extent`` (the larger one of its displacement and velocity); ``symmetric``
    under x -> -x; ``exponents`` (members, 2) per unit time and their ``error``; ``distance`` of the motion from the
    cycle over its size; ``time`` of the repeats behind the exponents.
    """

    found: npt.NDArray[np.bool_]
    period: npt.NDArray[np.int64]
    extent: Array
    symmetric: npt.NDArray[np.bool_]
    exponents: Array
    error: Array
    distance: Array
    time: Array

    @property
    def attracting(self) -> npt.NDArray[np.bool_]:
        """Where the motion has arrived at a cycle that certainly attracts."""
        certain = self.exponents[:, 0] < -np.maximum(CERTAIN * self.error[:, 0], FLOOR)
        return self.found & certain & (self.distance < NEAR_RETURN)


def cycles_reached(model: ConeModel, states: Array, **flow_options: Any) -> Cycles:
    """The cycles near motions that are at ``states``, a whole repeat, and return from there."""
    path, _ = follow(model, states, **flow_options)
    period, _ = periods_of(path.reshape(len(path), RETURNS, -1), NEAR_RETURN)
    return find_cycles(model, path[:, -1, -1], period, **flow_options)


def find_cycles(model: ConeModel, states: Array, period: npt.NDArray[np.int64], **flow_options: Any) -> Cycles:
    """The cycles of ``period`` (members,) drive repeats, or of a divisor of it, near ``states`` at a whole repeat.

    A member of period 0 has none.
    """
    count = len(states)
    cycles = Cycles(
        found=np.zeros(count, dtype=bool),
        period=np.zeros(count, dtype=np.int64),
        extent=np.full(count, np.nan),
        symmetric=np.zeros(count, dtype=bool),
        exponents=np.full((count, 2), np.nan),
        error=np.full((count, 2), np.nan),
        distance=np.full(count, np.nan),
        time=np.zeros(count),
    )
    for group, clock in clocks(model):
        for repeats in np.unique(period[group][period[group] > 0]):
            same = period[group] == repeats
            members = group[same]
            _find(model.take(members), states[members], clock.take(same), int(repeats), members, cycles, flow_options)
    return cycles


def _find(
    model: ConeModel,
    states: Array,
    clock: Clock,
    repeats: int,
    members: npt.NDArray[np.intp],
    cycles: Cycles,
    flow_options: dict[str, Any],
) -> None:
    with np.errstate(all="ignore"):  # a motion that is on no cycle gives steps of any size, or none
        step, first, _ = _newton_step(model, states, clock, repeats, flow_options)
        rest, exponents, path = _newton_step(model, states + step, clock, repeats, flow_options)
        size = np.maximum(np.abs(path).max(axis=(1, 2)), SMALLEST_SIZE)
        distance, left = np.abs(step).max(axis=1) / size, np.abs(rest).max(axis=1) / size
        found = (distance < NEAR) & ((left < CONVERGENCE * distance) | (left < NEGLIGIBLE))
    period = _smallest_period(path, size)
    moved = path.reshape(len(path), -1, 2)
    cycles.found[members], cycles.period[members], cycles.distance[members] = found, period, distance
    cycles.extent[members] = np.maximum(np.ptp(moved[..., 0], axis=1), np.abs(moved[..., 1]).max(axis=1))
    cycles.symmetric[members] = _is_symmetric(path, period, size)
    # The exponents of the cycle against those found before the last step, which was far larger than what is left.
    cycles.exponents[members], cycles.error[members] = exponents, np.maximum(np.abs(exponents - first), FLOOR / 10)
    cycles.time[members] = repeats * clock.repeat


def _newton_step(
    model: ConeModel, states: Array, clock: Clock, repeats: int, flow_options: dict[str, Any], sign: float = 1.0
) -> tuple[Array, Array, Array]:
    """The step (members, 2) to the fixed point of the map over some repeats, or of minus that map; both exponents
    (members, 2); and the path (members, repeats, ...)."""
    stretches = repeats * clock.per_repeat
    times = clock.repeat[:, None] * (np.arange(1, stretches + 1) / clock.per_repeat)
    flow = integrate(model, states, times, keep="tangents", **flow_options)
    assert flow.tangents is not None
    product, log_scale = chained(flow.tangents)
    growth, _ = qr_growth(flow.tangents, np.tile(np.eye(2), (len(states), 1, 1)))
    log_moduli = log_multipliers(product, log_scale, growth.sum(axis=(1, 2)))
    away = sign * flow.states[:, -1] - states
    (a, b), (c, d) = np.moveaxis(np.eye(2) - sign * product * np.exp(log_scale)[:, None, None], 0, 2)
    step = np.stack([d * away[:, 0] - b * away[:, 1], a * away[:, 1] - c * away[:, 0]], axis=1)
    step = np.where((flow.outcome == Outcome.OK)[:, None], step / (a * d - b * c)[:, None], np.nan)
    path = flow.states.reshape(len(states), repeats, -1)
    return step, log_moduli / times[:, -1:], path


def attractors_beside(model: ConeModel, section: Array, starts: int, **flow_options: Any) -> npt.NDArray[np.bool_]:
    """Whether Newton's method finds an attracting cycle or rest from chaos, given its ``section`` (members, points, 2).

    It makes so many ``starts``, from the points that return the closest. Chaos with an attractor beside it often ends
    there, however long it has lasted. An attractor that is found is there; one that is not found may be there all the
    same.
    """
    members = np.repeat(np.arange(len(section)), starts)
    several = model.take(members)
    farthest = FARTHEST_BESIDE * np.abs(section).max(axis=1)[members]
    mirrored = np.broadcast_to(several.rest_height, several.shape) == 0.0
    found = np.zeros(members.size, dtype=bool)
    options = flow_options | {"tolerance": max(flow_options.get("tolerance", 0.0), TOLERANCE_BESIDE)}
    for repeats, sign in MAPS_BESIDE:
        begin = _closest_returns(section, repeats, sign, starts)
        done = np.repeat(found.reshape(-1, starts).any(axis=1), starts)
        for group, clock in clocks(several, LONG_STRETCH):
            tried = (mirrored[group] | (sign > 0.0)) & ~done[group]
            part = group[tried]
            if part.size:
                found[part] |= _attracted(
                    several.take(part), begin[part], farthest[part], clock.take(tried), repeats, sign, options
                )
    return np.asarray(found.reshape(-1, starts).any(axis=1))


def _closest_returns(section: Array, repeats: int, sign: float, starts: int) -> Array:
    """So many points of each section whose images are the nearest to them, (members * starts, 2)."""
    gap = np.abs(sign * section[:, repeats:] - section[:, :-repeats]).max(axis=2)
    nearest = np.argsort(gap, axis=1, kind="stable")[:, :starts, None]
    return np.take_along_axis(section, nearest, axis=1).reshape(-1, 2)


def _attracted(
    model: ConeModel,
    states: Array,
    farthest: Array,
    clock: Clock,
    repeats: int,
    sign: float,
    flow_options: dict[str, Any],
) -> npt.NDArray[np.bool_]:
    """Which of the ``states`` Newton's method takes to an attracting cycle without leaving the bounds ``farthest``."""
    found = np.zeros(len(states), dtype=bool)
    members = np.arange(len(states))
    for _ in range(STEPS_BESIDE):
        with np.errstate(all="ignore"):
            step, exponents, _ = _newton_step(model, states, clock, repeats, flow_options, sign)
            there = np.abs(step).max(axis=1) < CLOSE_BESIDE * farthest.max(axis=1)
            on = ~there & (np.abs(states + step) < farthest).all(axis=1)  # not for NaN, from outside the stretch limit
        found[members[there]] = exponents[there, 0] < -FLOOR
        if not on.any():
            break
        model, clock = model.take(on), clock.take(on)
        members, states, farthest = members[on], states[on] + step[on], farthest[on]
    return found


def _smallest_period(path: Array, size: Array) -> npt.NDArray[np.int64]:
    """Smallest number of repeats after which the path (members, repeats, ...) goes over itself."""
    repeats = path.shape[1]
    period = np.full(len(path), repeats)
    for divisor in range(repeats - 1, 0, -1):
        if repeats % divisor == 0:
            gap = np.abs(path - np.roll(path, divisor, axis=1)).max(axis=(1, 2))
            period[gap < SAME_POINT * size] = divisor
    return period


def _is_symmetric(path: Array, period: npt.NDArray[np.int64], size: Array) -> npt.NDArray[np.bool_]:
    """Whether the path is its own mirror image, half a period on (or, at rest, at once)."""
    shift = np.where(period % 2 == 0, period // 2, 0)
    later = (np.arange(path.shape[1]) + shift[:, None]) % path.shape[1]
    mirrored = np.take_along_axis(path, later[:, :, None], axis=1)
    return np.abs(path + mirrored).max(axis=(1, 2)) < 10.0 * SAME_POINT * size
