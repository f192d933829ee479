"""The voltages and heights at which a film is slack: without tension in a part that spans its height, so that it does
not pull.

While no hoop is stretched more than its meridian, all rings fall slack at once, each stretched evenly by t^(1/2), at
the voltage that cancels the stress of such a film. A film whose hoop is stretched more hangs, as it falls slack,
between two flat rims whose hoop is still taut, the one at the disc turned over; each rim ends where its hoop falls
slack, too.

A slack film pulls in at the maximum over t of the voltage that cancels the stress, or where the edge of a rim
localises.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gelcone.membrane.columns import longest
from gelcone.membrane.gel import Array, Gel

STEP, LONGEST_RIM = 0.02, 6.0
"""Step of ln R across a rim, and length in ln R up to which a rim is followed."""
VOLTAGES = 240
"""Number of voltages at which the heights of a film with rims are computed; between them they are interpolated."""


def slack_voltages(gel: Gel, ratio: float) -> Callable[[Array], Array]:
    """The function of x >= 0 that gives the V above which a film held there is slack; infinite where no voltage cancels
    its tension. ``ratio`` is a/b."""

    def evenly(x: Array) -> Array:
        return np.asarray(np.maximum(gel.crumpling(gel.A * (1.0 + x * x)) / gel.G, 0.0))

    if not gel.has_rims:
        return evenly
    hump = gel.hump()
    V = np.linspace(0.0, 1.0, VOLTAGES) * float(gel.crumpling(min(hump, gel.B))) / gel.G
    heights = _between_rims(gel, ratio, V)
    last = int(np.argmin(np.isfinite(heights))) or V.size  # beyond, no rim is found: such a film has pulled in
    heights, V = heights[:last], V[:last]

    def between_rims(x: Array) -> Array:
        higher = np.maximum(evenly(x), V[-1]) if hump > gel.B else V[-1]
        return np.where(x > heights[-1], higher, np.interp(x, heights, V, left=0.0))

    return between_rims


def slack_height(gel: Gel, ratio: float, V: float) -> float:
    """The x up to which the film is slack, 0 where it is in tension at all heights; V is at most `slack_limit`."""
    squared = np.array([V])
    t = gel.natural_stretch(squared)
    if not gel.has_rims or t[0] >= gel.B:
        return float(np.sqrt(max(t[0] / gel.A - 1.0, 0.0)))
    return float(max(_between_rims(gel, ratio, squared)[0], 0.0))


def slack_limit(gel: Gel) -> float:
    """The V above which a slack film has pulled in; infinite where it does not."""
    hump = gel.hump()
    if not np.isfinite(hump):
        return np.inf
    limit = float(gel.crumpling(hump)) / gel.G
    if hump >= gel.B or not gel.has_rims:
        return limit
    V = np.linspace(0.0, limit, VOLTAGES)
    t = gel.natural_stretch(V)
    edge = np.fmax(*(_edge(gel, V, t, outer)[1] for outer in (True, False)))
    with np.errstate(invalid="ignore"):
        left = longest(gel, V) - edge
    lost = np.flatnonzero(left <= 0.0)
    if not lost.size:
        return limit
    first = int(lost[0])
    if not first or np.isnan(left[first - 1]):
        return float(V[first])
    return float(np.interp(0.0, -left[first - 1 : first + 1], V[first - 1 : first + 1]))


def _between_rims(gel: Gel, ratio: float, V: Array) -> Array:
    """The heights at which films with rims fall slack; negative where they are in tension at all heights."""
    disc, length = ratio / (1.0 - ratio), gel.natural_stretch(V)
    ends = (_edge(gel, V, length, outer)[0] for outer in (True, False))
    outside, inside = (np.exp(-s) for s in ends)
    heights: Array = np.sqrt(length * (1.0 / gel.A - 1.0 / gel.B)) * ((disc + 1.0) * outside - disc * inside)
    return heights


def _edge(gel: Gel, V: Array, t: Array, outer: bool) -> tuple[Array, Array]:
    """ln R of the edge of a rim over that of its end without tension, where l1 = (t/A)^(1/2) and l2 = (t/B)^(1/2); and
    l1 at the edge. Infinity and NaN for a rim of more than `LONGEST_RIM`, longer than any film.

    In the plane the hoop length changes as dl2/ds = +-l1 - l2, s = ln R, with the sign of the meridian's direction, and
    the tensions are in balance: dT1/ds = +-T2 - T1. The edge is held, l2 = 1. Where the pre-stretches are nearly equal
    l2 hardly changes at first, so that s is integrated over, and l2 in the last step alone.
    """
    direction = 1.0 if outer else -1.0
    held = np.zeros(V.shape, bool)

    def rates(place: Array) -> Array:
        """Rates of s, l1 and l2 over the distance from the end without tension to the edge."""
        _, l1, l2 = place
        ring = gel.ring(l1, l2, V, held, l2 * l2)
        turn = direction * l1 - l2
        along = (direction * ring.hoop - ring.meridional - ring.coupling * turn) / ring.tangent_stiffness
        return direction * np.array([np.ones_like(l1), along, turn])

    def by_hoop(place: Array) -> Array:
        """Rates over l2."""
        derivatives = rates(place)
        return np.asarray(derivatives / derivatives[2])

    place = np.array([np.zeros(V.shape), np.sqrt(t / gel.A), np.sqrt(t / gel.B)])
    edge = np.full((2, *V.shape), [[direction * np.inf], [np.nan]])
    with np.errstate(all="ignore"):
        for _ in range(int(LONGEST_RIM / STEP)):
            after = _stepped(rates, place, np.full(V.shape, STEP))
            arrives = np.isnan(edge[1]) & (after[2] >= 1.0)
            if arrives.any():
                edge[:, arrives] = _stepped(by_hoop, place, 1.0 - place[2])[:2, arrives]
            if not np.isnan(edge[1]).any():
                break
            place = after
    return edge[0], edge[1]


def _stepped(rates: Callable[[Array], Array], place: Array, h: Array) -> Array:
    """The place after a step of the fourth-order Runge-Kutta method."""
    first = rates(place)
    second = rates(place + 0.5 * h * first)
    third = rates(place + 0.5 * h * second)
    fourth = rates(place + h * third)
    return np.asarray(place + h / 6.0 * (first + 2.0 * second + 2.0 * third + fourth))
