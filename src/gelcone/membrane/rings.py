"""The rings of an axisymmetric membrane from the disc to the rim, many states at once.

A ring at the mounted radius R = R0 e^s has the meridional and hoop length l1 and l2 = r/R over the mounted ones and the
slope u: cos = tanh u, sin = sech u. With T1, T2, T11, T12 of `gelcone.membrane.gel`

    dl2/ds = l1 tanh u - l2,    du/ds = T2/T1,    dl1/ds = (T2 tanh u - T1 - T12 dl2/ds)/T11,    dz/ds = R l1 sech u,

and the charge is v q with dq/ds = m n R^2. C = R T1 sech u, the axial force, is the same in all rings. The independent
variable sig, ds/dsig = 1/(1 + T1/(l1 T11) + |T2/T1|), makes nothing stiff: neither a ring about to localise (T11 -> 0)
nor a fold (T1 -> 0), where u turns within a width of the order of C.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import DOP853

from gelcone.membrane.gel import Array, Gel

STAGES, WEIGHTS = [np.array(row[:stage]) for stage, row in enumerate(DOP853.A)], np.array(DOP853.B)
"""An explicit Runge-Kutta method of order 8 (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I)."""
S, LOG, HOOP, SLOPE, HEIGHT, CHARGE = range(6)
"""What a ring is: s, ln l1, l2, u, z, q."""
LANDING = 8
"""Trial steps that land on the ring where the hoop falls slack."""


class Rings(NamedTuple):
    """Rings of many states: ``y`` (6, states), whether the hoop is slack, and the squared width."""

    y: Array
    slack: Array
    width: Array

    def part(self, which: Any) -> Rings:
        """Those of some states."""
        return Rings(self.y[:, which], self.slack[which], self.width[which])


def begin(gel: Gel, l1: Array, l2: Array, u: Array, V: Array) -> Rings:
    """Rings at s = 0."""
    zero = np.zeros(np.broadcast_shapes(l1.shape, l2.shape, u.shape, V.shape))
    l1, l2, u, V = l1 + zero, l2 + zero, u + zero, V + zero
    slack = gel.hoop(l1, l2, V) < 0.0
    return Rings(np.array([zero, np.log(l1), l2, u, zero, zero]), slack, gel.width(l1, l2, V))


def rates(gel: Gel, at: Rings, V: Array, radius: float, settled: bool = True) -> tuple[Array, Array]:
    """Derivatives of a ring's numbers by sig, and its width. Unless the law is ``settled``, each ring takes its own."""
    s, log, l2, u, _, _ = at.y
    l1, slack, guess = np.exp(log), at.slack, at.width
    if not settled:
        slack = gel.hoop(l1, l2, V) < 0.0
        guess = np.where(slack, np.maximum(guess, l2 * l2), guess)
    T1, T2, T11, T12, _, n = gel.ring(l1, l2, V, slack, guess)
    cosine, firm, turn = np.tanh(u), T11 * l1, T2 / T1
    whole = 1.0 / (firm + T1 + np.abs(turn) * firm)
    rate, stretch = firm * whole, l1 * cosine - l2
    R = radius * np.exp(s)
    return np.array(
        [
            rate,
            (T2 * cosine - T1 - T12 * stretch) * whole,
            stretch * rate,
            turn * rate,
            l1 / np.cosh(u) * R * rate,
            l1 * l1 * n * R * R * rate,
        ]
    ), n


def step(gel: Gel, at: Rings, V: Array, radius: float, h: Array, settled: bool = True) -> Rings:
    """Rings a step of sig further on, of the law that they begin with."""
    k = np.empty((len(STAGES), *at.y.shape))
    k[0], width = rates(gel, at, V, radius, settled)
    for stage in range(1, len(STAGES)):
        y = at.y + h * np.tensordot(STAGES[stage], k[:stage], 1)
        k[stage], width = rates(gel, Rings(y, at.slack, width), V, radius, settled)
    y = at.y + h * np.tensordot(WEIGHTS, k, 1)
    return Rings(y, at.slack, width)


def march(
    gel: Gel, start: Rings, V: Array, radius: float, end: Array, steps: int, *, grading: float = 1.0, land: bool = True
) -> list[Rings]:
    """Rings from ``start`` to sig = ``end``, each state its own, in equal steps; with a ``grading`` above 1 the first
    ones are shorter, for a start next to localisation.

    Where the hoop stress changes its sign a state lands on that ring and continues with the other law. Without ``land``
    each stage takes its own law, which costs the order there: for scans.
    """
    path, end = [start], np.broadcast_to(end, V.shape)
    with np.errstate(all="ignore"):
        for share in np.diff(np.linspace(0.0, 1.0, steps + 1) ** grading):
            now, h = path[-1], share * end
            after = step(gel, now, V, radius, h, settled=land)
            if land:
                stress = _hoop(gel, after, V)
                crossed = np.flatnonzero(((stress < 0.0) != now.slack) & np.isfinite(stress))
                if crossed.size:
                    after = _landed(gel, now, after, V, radius, h, crossed, stress)
            path.append(after)
    return path


def _hoop(gel: Gel, at: Rings, V: Array) -> Array:
    return gel.hoop(np.exp(at.y[LOG]), at.y[HOOP], V)


def _landed(
    gel: Gel, before: Rings, after: Rings, V: Array, radius: float, h: Array, crossed: Array, stress: Array
) -> Rings:
    """``after`` with the states that ``crossed`` done again in two parts, by the Illinois method."""
    own, V, h = before.part(crossed), V[crossed], h[crossed]
    low, high = np.zeros(crossed.size), np.ones(crossed.size)
    at_low, at_high = _hoop(gel, own, V), stress[crossed]
    at_low = np.where((at_low < 0.0) == own.slack, at_low, 0.0)  # it began on the border
    for trial in range(LANDING):
        share = np.clip(low - at_low * (high - low) / (at_high - at_low), low, high)
        landed = step(gel, own, V, radius, h * share)
        found = _hoop(gel, landed, V)
        same = (found < 0.0) == own.slack
        halved = 0.5 if trial else 1.0
        at_low, at_high = np.where(same, found, at_low * halved), np.where(same, at_high * halved, found)
        low, high = np.where(same, share, low), np.where(same, high, share)
        if np.nanmax(np.abs(found)) < 1e-13:
            break
    other = Rings(landed.y, ~own.slack, landed.y[HOOP] ** 2)
    further = step(gel, other, V, radius, h * (1.0 - share))
    y, slack, width = after.y.copy(), after.slack.copy(), np.array(after.width)
    y[:, crossed], slack[crossed], width[crossed] = further.y, further.slack, further.width
    return Rings(y, slack, width)
