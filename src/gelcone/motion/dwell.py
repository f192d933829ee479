"""Times for which functions of the state are positive along sampled motions.

Between samples the displacement is the quintic through displacement, velocity and acceleration at both, and every other
state the cubic through its values and rates. Zeros of the functions are found on these, so that their error is that of
the polynomials, not the spacing of the samples.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.bracket import rise
from gelcone.motion.turning import quintic
from gelcone.physics.members import Members
from gelcone.quantity import Array

NODES = np.linspace(0.0, 1.0, 5)
"""Shares of an interval at which a function is evaluated for the polynomial on which it passes zero."""
INVERSE = np.linalg.inv(np.vander(NODES))
FINE = np.vander(np.linspace(0.0, 1.0, 65), NODES.size)
"""Powers of the shares of an interval at which the extremum of a polynomial is searched."""
Rows = npt.NDArray[np.intp]
Places = tuple[Rows, ...]
"""Indices of functions, members and intervals, (points,) each."""


@dataclass(frozen=True)
class Path:
    """Motions of ``members``: ``times`` (members, samples), the first and the last included, and ``states`` (members,
    samples, N), NaN where one has ended."""

    members: Members
    times: Array
    states: Array

    @cached_property
    def rates(self) -> Array:
        """Rates of change of the states, (members, samples, N)."""
        with np.errstate(all="ignore"):
            return np.stack(self.members.along(self.members.system.rates, self.times, self.states), axis=-1)

    def at(self, rows: Rows, interval: Rows, share: Array, *, cubic: bool = False) -> tuple[Array, Array]:
        """Times (points,) and states (points, N) at a ``share`` of the intervals of members ``rows``; with ``cubic``,
        also the displacement is a cubic."""
        first, last = (rows, interval), (rows, interval + 1)
        step, s = (self.times[last] - self.times[first])[:, None], share[:, None]
        z, ahead, rate, later = self.states[first], self.states[last], self.rates[first], self.rates[last]
        shift = ahead - z
        states = z + s * (step * rate + s * (3.0 * shift - step * (2.0 * rate + later)))
        states = states + s**3 * (step * (rate + later) - 2.0 * shift)
        if not cubic:
            h, s = step[:, 0], share
            bend, change = h * h * rate[:, 1], h * h * (later[:, 1] - rate[:, 1])
            rest, slope = shift[:, 0] - h * rate[:, 0] - 0.5 * bend, h * (later[:, 0] - rate[:, 0]) - bend
            third, fourth, fifth = quintic(rest, slope, change)
            smooth = h * rate[:, 0] + s * (0.5 * bend + s * (third + s * (fourth + s * fifth)))
            states[:, 0] = z[:, 0] + s * smooth
        return self.times[first] + share * step[:, 0], states


Values = Callable[[Members, Array, Array], Array]
"""Functions of members (points,), times (points, 1) and states (points, 1, N): an array (functions, points, 1)."""


def dwell_times(path: Path, functions: Values, values: Array) -> tuple[Array, Array]:
    """Times for which each of the ``functions`` is positive between samples, (functions, members, samples - 1), 0 where
    a motion has ended; and the error of their sum, (functions, members). ``values`` (functions, members, samples) are
    those at the samples."""
    spans = np.diff(path.times, axis=1)
    positive, finite = values > 0.0, np.isfinite(values)
    durations = np.where(positive[..., :-1] & positive[..., 1:], spans, 0.0)
    error = np.zeros(values.shape[:2])

    def at(place: Places, share: Array, *, cubic: bool = False) -> Array:
        times, states = path.at(place[1], place[2], share, cubic=cubic)
        every = functions(path.members.take(place[1]), times[:, None], states[:, None])
        return np.asarray(every[place[0], np.arange(share.size), 0])

    def polynomial(place: Places) -> Array:
        """Coefficients (points, nodes), highest first, in the share of the interval; of a straight line where the
        motion has no rate at an end, as where a film has pulled in."""
        every = tuple(np.tile(indices, NODES.size) for indices in place)
        sampled = at(every, np.repeat(NODES, place[0].size)).reshape(NODES.size, -1)
        begin = values[place]
        line = np.zeros((begin.size, NODES.size))
        line[:, -2:] = np.stack([values[place[0], place[1], place[2] + 1] - begin, begin], axis=1)
        known = np.isfinite(sampled).all(axis=0)
        line[known] = (INVERSE @ sampled[:, known]).T
        return line

    def cross(place: Places, terms: Array, low: Array, high: Array, upwards: npt.NDArray[np.bool_]) -> Array:
        """The shares of intervals at which the functions pass zero between shares ``low`` and ``high``."""
        function, rows, interval = place
        sign = np.where(upwards, 1.0, -1.0)
        share = np.asarray(rise(lambda s: sign * reduce(lambda value, term: value * s + term, terms.T), low, high))
        exact, rough = (at(place, share, cubic=c) for c in (False, True))
        steep = np.abs(values[function, rows, interval + 1] - values[place])
        with np.errstate(all="ignore"):
            off = np.fmin((np.abs(rough - exact) + np.abs(exact)) / steep, high - low)
        np.add.at(error, (function, rows), np.nan_to_num(off) * spans[rows, interval])
        return share

    crossings = np.nonzero((positive[..., :-1] != positive[..., 1:]) & finite[..., :-1] & finite[..., 1:])
    if crossings[0].size:
        upwards = positive[crossings[0], crossings[1], crossings[2] + 1]
        share = cross(crossings, polynomial(crossings), np.zeros(upwards.size), np.ones(upwards.size), upwards)
        durations[crossings] = np.where(upwards, 1.0 - share, share) * spans[crossings[1:]]
    _add_passings(values, spans, durations, polynomial, cross)
    return durations, error


def _add_passings(values: Array, spans: Array, found: Array, polynomial: Any, cross: Any) -> None:
    """Adds the times between two zeros within one interval. They are searched next to samples at which the distance to
    zero has a minimum so small that the parabola through the neighbours comes close to zero."""
    sign, size = np.where(values > 0.0, 1.0, -1.0), np.abs(values)
    before, here, after = size[..., :-2], size[..., 1:-1], size[..., 2:]
    with np.errstate(all="ignore"):  # infinite for an assumption that a film does not make
        bend = before + after - 2.0 * here
        nearest = here - (after - before) ** 2 / (8.0 * bend)
        close = (here < before) & (here <= after) & (nearest < 0.1 * bend)  # of two equal minima one alone
    close &= np.isfinite(before) & np.isfinite(after)
    same = (sign[..., :-2] == sign[..., 1:-1]) & (sign[..., 1:-1] == sign[..., 2:])
    function, rows, sample = np.nonzero(same & close)
    signs = sign[function, rows, sample + 1]
    for side in (0, 1) if rows.size else ():  # in the interval before the sample, and in the one after it
        interval = (function, rows, sample + side)
        terms = polynomial(interval)
        distances = signs * (FINE @ terms.T)
        past, turn = distances.min(axis=0) < 0.0, distances.argmin(axis=0) / (len(FINE) - 1.0)
        if past.any():
            passings, upper, terms = tuple(indices[past] for indices in interval), signs[past] > 0.0, terms[past]
            start = cross(passings, terms, np.zeros(upper.size), turn[past], ~upper)
            end = cross(passings, terms, turn[past], np.ones(upper.size), upper)
            found[passings] += np.where(upper, -1.0, 1.0) * (end - start) * spans[passings[1:]]
