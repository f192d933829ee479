"""States of a film at held heights and voltages, by one-dimensional finite elements of the relaxed membrane.

Lengths in b - a, forces over mu Vol/(b - a). The film's meridian is a chain of straight elements between the disc and
the rim; each is a ring of `gelcone.membrane.gel` at its middle, wrinkled where its hoop would be compressed. A state
minimises

    E = 2/(b^2 - a^2) sum R dR phi(l1, l2; V),    l1 = |d(r, z)|/dR,    l2 = r/R,

at a held height of the disc, by Newton's method, many states at once. The force is dE/dx, the mean square of the
deformed over the mounted area -2 dE/dV. Elements are shortest next to the disc, where the stretches vary most.

An element resists turning by its tension alone, and where that is small, the value at the present iterate is a poor
estimate. Tensions are therefore unknowns of their own in this term once they are known, and follow the linearised ones
from iteration to iteration (a mixed method; Magisano, Leonetti, Garcea, Int. J. Numer. Meth. Engng 109, 2017).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from gelcone.membrane.gel import ENOUGH, Array, Gel

GRADING = 1.6
"""Exponent of the grading of the nodes over ln R."""
ROUNDS = 60
"""Most Newton iterations for a state."""
ACCURATE = 1e-9
"""Largest relative change of an element in the last iteration of a state that was found."""
LARGEST_STEP = 0.35
"""Largest relative change of an element in one iteration."""
LEAST_TENSION = 1e-9
"""Tension with which a slack element resists turning, so that a state without tension is unique."""
LOST = 1e14
"""Entry of the stiffness matrix at which a state is given up."""
LONGEST_STEP, SHORTEST_STEP = 0.7, 0.01
"""Longest and shortest step of ln x by which a state is raised or lowered."""
LEAST_KEPT = 0.1
"""Least share of its tension that an element retains from one iteration to the next."""
BETWEEN = 6
"""Parts of the distance between the middles of two elements, at whose ends tangent stiffness is computed."""
WARM = 4
"""Newton iterations for a natural width from that of the iteration before."""
BAND = 3
"""Unknowns r and z of neighbouring nodes are at most three places apart."""


class Chains(NamedTuple):
    """States: squared voltage, radius and height of the nodes (states, nodes), tension T1 of the elements (states,
    elements; NaN where unknown), and the mask of those that were found."""

    V: Array
    r: Array
    z: Array
    tension: Array
    found: Array

    def where(self, which: Array | int) -> Chains:
        """The states of an index or mask."""
        return Chains(*(values[which] for values in self))


class Measures(NamedTuple):
    """Height, force and area (charge over voltage) of each state, the squared meridional length at the disc and the
    larger one of disc and rim, the largest true field over v, the least tangent stiffness of its rings, and the least
    and the largest tension of its hoops (see `Gel.hoop`)."""

    x: Array
    force: Array
    area: Array
    disc: Array
    edge: Array
    field: Array
    tangent_stiffness: Array
    least_hoop: Array
    largest_hoop: Array


@dataclass(frozen=True)
class Elements:
    """A film of a gel in ``count`` elements; ``ratio`` is the disc's radius over the ring's, a/b."""

    gel: Gel
    ratio: float
    count: int = 100

    @property
    def disc(self) -> float:
        """a, the radius of the disc."""
        return self.ratio / (1.0 - self.ratio)

    @property
    def mounted(self) -> float:
        """b^2 - a^2, the mounted area over pi."""
        return 1.0 + 2.0 * self.disc

    @cached_property
    def nodes(self) -> Array:
        """Mounted radii."""
        share = np.linspace(0.0, 1.0, self.count + 1) ** GRADING
        return self.disc * np.exp(-np.log(self.ratio) * share)

    @cached_property
    def lengths(self) -> Array:
        """Mounted lengths of the elements."""
        return np.diff(self.nodes)

    @cached_property
    def middles(self) -> Array:
        """Mounted radii of the middles of the elements."""
        return 0.5 * (self.nodes[1:] + self.nodes[:-1])

    @cached_property
    def weights(self) -> Array:
        """Shares of the film's volume."""
        return 2.0 * self.middles * self.lengths / self.mounted

    def cones(self, x: Array, V: Array) -> Chains:
        """Straight cones to start from; the disc is at the height x, the rim at 0."""
        share = (self.nodes - self.nodes[0]) / (self.nodes[-1] - self.nodes[0])
        unknown = np.full((x.size, self.count), np.nan)
        return Chains(V, np.tile(self.nodes, (x.size, 1)), x[:, None] * (1.0 - share), unknown, np.zeros(x.shape, bool))

    def unloaded(self, x: Array, until_lost: bool = False) -> Chains:
        """The states without voltage at heights x > 0, each computed once.

        With ``until_lost``, heights after the first at which stepping from a neighbour fails are not stepped to.
        """
        if not x.size:
            return self.cones(x, x)
        new = np.array([height for height in x.tolist() if height not in self._unloaded])
        at = self._without_voltage(new, until_lost)
        rows = {height: at.where(k) for k, height in enumerate(new.tolist())}
        self._unloaded.update((height, row) for height, row in rows.items() if row.found)
        return Chains(*map(np.array, zip(*((rows | self._unloaded)[height] for height in x.tolist()), strict=True)))

    @cached_property
    def _unloaded(self) -> dict[float, Chains]:
        """Height -> state without voltage, as far as they are known."""
        return {}

    def _without_voltage(self, x: Array, until_lost: bool) -> Chains:
        """Finds states without voltage from straight cones, or else by steps from the state of the nearest height."""
        at = self.found(self.cones(x, np.zeros(x.size)))
        solved = np.flatnonzero(at.found)
        for k in np.flatnonzero(~at.found) if solved.size else []:
            nearest = solved[np.argmin(np.abs(np.log(x[solved] / x[k])))]
            moved = self._moved(at.where(np.array([nearest])), float(x[k]))
            for values, moved_values in zip(at, moved, strict=True):
                values[k] = moved_values[0]
            if until_lost and not at.found[k]:
                break
        return at

    def _moved(self, at: Chains, x: float) -> Chains:
        """The state of ``at`` raised or lowered in steps to the height x."""
        now, step = float(at.z[0, 0]), LONGEST_STEP
        while now != x and step > SHORTEST_STEP:
            way = np.log(x / now)
            target = x if abs(way) <= step else now * np.exp(np.copysign(step, way))
            moved = self.found(at._replace(z=at.z * (target / now), tension=at.tension * (target / now)))
            if moved.found[0]:
                at, now, step = moved, target, min(2.0 * step, LONGEST_STEP)
            else:
                step *= 0.5
        return at._replace(found=at.found & (now == x))

    def stretches(self, at: Chains) -> tuple[Array, Array, Array, Array]:
        """l1, l2, and the cosine and sine of the direction of each element, (states, elements)."""
        along, down = np.diff(at.r, axis=1), np.diff(at.z, axis=1)
        length = np.hypot(along, down)
        l2 = 0.5 * (at.r[:, 1:] + at.r[:, :-1]) / self.middles
        return length / self.lengths, l2, along / length, down / length

    def found(self, start: Chains, rounds: int = ROUNDS) -> Chains:
        """The states near ``start``, with the ends held, by Newton's method."""
        r, z, tension, done = start.r.copy(), start.z.copy(), start.tension.copy(), np.zeros(start.V.shape, bool)
        live = np.arange(start.V.size)
        width = np.full((start.V.size, self.count), np.nan)
        for _ in range(rounds):
            if not live.size:
                break
            at = Chains(start.V[live], r[live], z[live], tension[live], done[live])
            step, linear, width[live] = self._step(at, width[live])
            length = np.hypot(np.diff(at.r, axis=1), np.diff(at.z, axis=1))
            largest = np.max(np.abs(np.diff(step, axis=1)).max(axis=2) / length, axis=1)
            share = np.minimum(1.0, LARGEST_STEP / np.maximum(largest, 1e-300))[:, None]
            r[live] += share * step[:, :, 0]
            z[live] += share * step[:, :, 1]
            converged = largest < ACCURATE
            moved = np.maximum(at.tension + share * (linear - at.tension), LEAST_KEPT * at.tension)
            tension[live] = np.where(converged[:, None], linear, moved)
            done[live[converged]] = True
            lost = ~np.isfinite(largest)
            live = live[~converged & ~lost]
        return Chains(start.V, r, z, tension, done)

    def _step(self, at: Chains, width: Array) -> tuple[Array, Array, Array]:
        """Newton's step of the nodes, (states, nodes, 2), the linearised tensions after it, and the widths of the
        rings."""
        l1, l2, cosine, sine = self.stretches(at)
        V = np.broadcast_to(at.V[:, None], l1.shape)
        with np.errstate(all="ignore"):
            slack = self.gel.hoop(l1, l2, V) < 0.0
            least = np.sqrt(self.gel.G / (self.gel.B * l1 * l1))
            guess = np.where(np.isnan(width), np.maximum(l2 * l2, least), np.maximum(width, l2 * l2))
            n = self.gel.width_of(l1, l2, V, slack, guess, ENOUGH if np.isnan(width).any() else WARM)
            ring = self.gel.ring(l1, l2, V, slack, n)
        w, dR, R2 = self.weights, self.lengths, 2.0 * self.middles
        tension = np.where(np.isnan(at.tension), ring.meridional, at.tension)
        turn = np.maximum(tension, LEAST_TENSION) / (l1 * dR * dR)
        firm = np.maximum(ring.tangent_stiffness, 1e-6) / (dR * dR)
        # gradients of l1 by (r, z) of the outer node, of l2 by r of either
        gr, gz = w * ring.meridional * cosine / dR, w * ring.meridional * sine / dR
        hoop = w * ring.hoop / R2
        rr = w * (firm * cosine * cosine + turn * sine * sine)
        zz = w * (firm * sine * sine + turn * cosine * cosine)
        rz = w * (firm - turn) * cosine * sine
        mixed_r, mixed_z = w * ring.coupling * cosine / (dR * R2), w * ring.coupling * sine / (dR * R2)
        across = w * ring.hoop_tangent_stiffness / (R2 * R2)
        states, inner = at.V.size, self.count - 1
        band = np.zeros((2 * BAND + 1, states, 2 * inner))
        right = np.zeros((states, inner, 2))
        left, after = slice(0, -1), slice(1, None)  # the element inside of an inner node and the one outside
        right[:, :, 0] = gr[:, left] - gr[:, after] + hoop[:, left] + hoop[:, after]
        right[:, :, 1] = gz[:, left] - gz[:, after]
        # diagonal: an element's outer node sees + mixed, its inner one - mixed
        diagonal_r = rr + across
        band[BAND, :, 0::2] = (diagonal_r + 2.0 * mixed_r)[:, left] + (diagonal_r - 2.0 * mixed_r)[:, after]
        band[BAND, :, 1::2] = zz[:, left] + zz[:, after]
        cross = (rz + mixed_z)[:, left] + (rz - mixed_z)[:, after]
        band[BAND - 1, :, 1::2] = cross
        band[BAND + 1, :, 0::2] = cross
        # neighbouring nodes of the elements in between: inner node i, outer node o
        between = slice(1, -1)
        ro = (-rr + across)[:, between]
        zo = -zz[:, between]
        ri_zo, zi_ro = (-rz + mixed_z)[:, between], (-rz - mixed_z)[:, between]
        band[BAND - 2, :, 2::2], band[BAND + 2, :, 0:-2:2] = ro, ro
        band[BAND - 2, :, 3::2], band[BAND + 2, :, 1:-2:2] = zo, zo
        band[BAND - 3, :, 3::2], band[BAND + 3, :, 0:-2:2] = ri_zo, ri_zo
        band[BAND - 1, :, 2::2], band[BAND + 1, :, 1:-2:2] = zi_ro, zi_ro
        with np.errstate(invalid="ignore"):
            ok = (np.abs(band).max(axis=(0, 2)) < LOST) & np.isfinite(right).all(axis=(1, 2))
        moves = np.zeros((states, inner + 2, 2))
        moves[:, 1:-1] = -_solved(band, right.reshape(states, -1), ok).reshape(states, inner, 2)
        along = (cosine * np.diff(moves[:, :, 0], axis=1) + sine * np.diff(moves[:, :, 1], axis=1)) / dR
        around = (moves[:, 1:, 0] + moves[:, :-1, 0]) / R2
        return moves, ring.meridional + ring.tangent_stiffness * along + ring.coupling * around, ring.width

    def least_tangent_stiffness(self, at: Chains) -> Array:
        """The least tangent stiffness of the rings of each state, (states,), also between the middles of elements."""
        l1, l2, _, _ = self.stretches(at)
        share = np.linspace(0.0, 1.0, BETWEEN + 1)[:-1]
        fine = [values[:, :-1, None] + np.diff(values, axis=1)[:, :, None] * share for values in (l1, l2)]
        V = np.broadcast_to(at.V[:, None, None], fine[0].shape)
        with np.errstate(all="ignore"):
            stiffness: Array = np.min(self.gel.at(fine[0], fine[1], V).tangent_stiffness, axis=(1, 2))
        return stiffness

    def measures(self, at: Chains) -> Measures:
        """The measures of states; NaN for those that were not found."""
        l1, l2, _, sine = self.stretches(at)
        V = np.broadcast_to(at.V[:, None], l1.shape)
        with np.errstate(all="ignore"):
            ring, stress = self.gel.at(l1, l2, V), self.gel.hoop(l1, l2, V)
        force = -(self.weights * ring.meridional * sine / self.lengths)[:, 0]
        area = np.sum(self.weights * l1 * l1 * ring.width, axis=1)
        # at the disc and at the rim from the two elements next to them
        middles, nodes = self.middles, self.nodes
        inwards = (middles[0] - nodes[0]) / (middles[1] - middles[0])
        outwards = (nodes[-1] - middles[-1]) / (middles[-1] - middles[-2])
        disc = (l1[:, 0] + inwards * (l1[:, 0] - l1[:, 1])) ** 2
        rim = (l1[:, -1] + outwards * (l1[:, -1] - l1[:, -2])) ** 2
        with np.errstate(all="ignore"):
            edges = [m * self.gel.width(np.sqrt(m), np.ones_like(m), at.V) for m in (disc, rim)]
        measures = (
            at.z[:, 0],
            force,
            area,
            disc,
            np.maximum(disc, rim),
            np.sqrt(np.max([np.max(l1 * l1 * ring.width, axis=1), *edges], axis=0)),
            np.min(ring.tangent_stiffness, axis=1),
            np.min(stress, axis=1),
            np.max(stress, axis=1),
        )
        return Measures(*(np.where(at.found, values, np.nan) for values in measures))


def _solved(band: Array, right: Array, known: Array) -> Array:
    """Solutions of one banded system per state, (states, unknowns); NaN where it is not ``known`` or singular.

    ``band`` is (diagonals, states, unknowns). All systems are solved as one; where one is singular, it is taken out and
    the others are solved again.
    """
    from scipy.linalg.lapack import dgbsv  # importing it takes as long as starting gelcone

    diagonals, states, unknowns = band.shape
    known = known.copy()
    while True:
        band[:, ~known], right[~known] = 0.0, 0.0
        band[BAND, ~known] = 1.0
        stored = np.zeros((diagonals + BAND, states * unknowns))
        stored[BAND:] = band.reshape(diagonals, -1)
        _, _, solution, singular = dgbsv(BAND, BAND, stored, right.ravel(), overwrite_ab=True)
        if singular == 0:
            break
        known[(singular - 1) // unknowns] = False
    solved: Array = solution.reshape(states, unknowns)
    solved[~known] = np.nan
    return solved
