"""Sampling of motions between the corners of their voltage, for means of quantities with kinks there, like currents.

Pieces between corners and even times are sampled at Gauss-Legendre nodes. Behind a corner pieces are the shorter the
nearer they are, as a current decays within the time constant of its circuit.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gelcone.motion.flow import integrate
from gelcone.motion.jumps import increasing
from gelcone.physics.members import Members
from gelcone.quantity import Array

PER_PERIOD = 16
"""Even pieces of a drive period."""
CLOSER, LEVELS = 4.0, 5
"""Ratio of the lengths of neighbouring pieces behind a corner, and the number of such pieces."""
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)
SHORTEST = 1e-9
"""Least length of a piece, over that of an even piece; shorter ones come from rounding."""


class Weighted(NamedTuple):
    """Sampled motions and weights of means over time.

    ``times`` and ``weights`` (members, nodes), 0 for nodes behind the end, and ``states`` (members, nodes, N); from the
    states ``begin`` (members, N) at the times ``start`` until ``end`` (members,).
    """

    times: Array
    states: Array
    weights: Array
    begin: Array
    start: Array
    end: Array

    def mean(self, values: Array) -> Array:
        """The mean over time (members,) of values (members, nodes)."""
        return np.asarray((self.weights * np.where(self.weights > 0.0, values, 0.0)).sum(axis=1))


def sampled_evenly(times: Array, states: Array, begin: Array, start: Array, end: Array) -> Weighted:
    """Motions with equal weights at even ``times`` (members, samples), in ``states`` (members, samples, N)."""
    return Weighted(times, states, np.full(times.shape, 1.0 / times.shape[1]), begin, start, end)


def between_corners(members: Members, begin: Array, start: Array, spans: Array, **flow: Any) -> Weighted:
    """Sample motions under a waveform with corners from ``begin`` (members, N), at the times ``start`` (members,), over
    the times ``spans`` (members,). ``flow``: options of `integrate`."""
    end, even = start + spans, members.drive_period / PER_PERIOD
    count = int(np.ceil((spans / even).max() - SHORTEST))
    corners = members.system.waveform.corners_between(start, end, members.own_numbers).later
    behind = even[:, None, None] * CLOSER ** -np.arange(1.0, LEVELS + 1.0)
    parts = (
        start[:, None] + even[:, None] * np.arange(count + 1.0),
        corners,
        (corners[:, :, None] + behind).reshape(members.size, -1),
    )
    breaks = np.sort(np.minimum(np.concatenate(parts, axis=1), end[:, None]), axis=1)
    low, length = breaks[:, :-1, None], np.diff(breaks, axis=1)[:, :, None]
    real = length > SHORTEST * even[:, None, None]
    times = np.where(real, low + 0.5 * length * (1.0 + NODES), np.inf).reshape(members.size, -1)
    weights = np.where(real, 0.5 * length * WEIGHTS, 0.0).reshape(members.size, -1) / spans[:, None]
    order = np.argsort(times, axis=1, kind="stable")
    times, weights = (np.take_along_axis(one, order, axis=1) for one in (times, weights))
    known = np.isfinite(times).any(axis=0)
    times, weights = increasing(times[:, known], end), weights[:, known]
    states = integrate(members, begin, times, start=start, **flow).states
    return Weighted(times, states, weights, begin, start, end)


def root_mean_squares(members: Members, path: Weighted) -> list[tuple[Array, Array]]:
    """Root mean squares of the voltage and the current of each line's source, (members,) each."""
    voltages = members.along(members.system.source_voltages, path.times, path.states)
    currents = members.along(members.system.source_currents, path.times, path.states)
    rms_pairs = []
    for line, current in zip(members.system.lines, currents, strict=True):
        voltage = voltages[line.films[0]]
        rms_pairs.append((np.sqrt(path.mean(voltage * voltage)), np.sqrt(path.mean(current * current))))
    return rms_pairs
