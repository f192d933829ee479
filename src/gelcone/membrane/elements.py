"""States of a film at held heights and voltages, by one-dimensional finite elements of the relaxed membrane.

Lengths in b - a, forces over mu Vol/(b - a). The film's meridian is a chain of straight elements between the disc and
the rim; each is a ring of `gelcone.membrane.gel` at its middle, wrinkled where its hoop would be compressed. A state
minimises

    E = 2/(b^2 - a^2) sum R dR phi(l1, l2; V),    l1 = |d(r, z)|/dR,    l2 = r/R,

at a held height of the disc, by Newton's method, many states at once. The force is dE/dx, the mean square of the
deformed over the mounted area -2 dE/dV. Elements are shortest beside the disc, where the stretches vary most.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from gelcone.membrane.gel import Array, Gel

GRADING = 1.6
"""Exponent of the elements' places over ln R."""
ROUNDS = 60
ACCURATE = 1e-9
"""Largest change of an element in the last round, over its length, of a state that was found."""
LARGEST_STEP = 0.35
"""Of the change of an element in one round, over its length."""
LEAST_TENSION = 1e-9
"""Tension with which a slack element withstands turning, so that a state without tension is a single one."""
BETWEEN = 6
"""Rings between the middles of two elements at which their firmness is computed, too."""
BAND = 3
"""Unknowns r and z of neighbouring nodes are at most three places apart."""


class Chains(NamedTuple):
    """States: squared voltage, radius and height of the nodes (states, nodes), whether each was found."""

    V: Array
    r: Array
    z: Array
    found: Array

    def where(self, which: Array) -> Chains:
        """Those of an index or mask."""
        return Chains(*(values[which] for values in self))


class Measures(NamedTuple):
    """Of states: height, force, area (charge over voltage), squared meridional length beside the disc, the true field
    over v where it is largest, least firmness of any ring, and of the hoop (see `Gel.hoop`) the least tension and the
    largest."""

    x: Array
    force: Array
    area: Array
    disc: Array
    field: Array
    firmness: Array
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
        """a."""
        return self.ratio / (1.0 - self.ratio)

    @property
    def mounted(self) -> float:
        """b^2 - a^2."""
        return 1.0 + 2.0 * self.disc

    @cached_property
    def nodes(self) -> Array:
        """Mounted radii."""
        share = np.linspace(0.0, 1.0, self.count + 1) ** GRADING
        return self.disc * np.exp(-np.log(self.ratio) * share)

    @cached_property
    def lengths(self) -> Array:
        return np.diff(self.nodes)

    @cached_property
    def middles(self) -> Array:
        return 0.5 * (self.nodes[1:] + self.nodes[:-1])

    @cached_property
    def weights(self) -> Array:
        """Shares of the film's volume."""
        return 2.0 * self.middles * self.lengths / self.mounted

    def cones(self, x: Array, V: Array) -> Chains:
        """Straight cones of those heights, to start from; the disc is at the height x, the rim at 0."""
        share = (self.nodes - self.nodes[0]) / (self.nodes[-1] - self.nodes[0])
        return Chains(V, np.tile(self.nodes, (x.size, 1)), x[:, None] * (1.0 - share), np.zeros(x.shape, bool))

    def stretches(self, at: Chains) -> tuple[Array, Array, Array, Array]:
        """l1, l2, and the direction of each element (states, elements)."""
        along, down = np.diff(at.r, axis=1), np.diff(at.z, axis=1)
        length = np.hypot(along, down)
        l2 = 0.5 * (at.r[:, 1:] + at.r[:, :-1]) / self.middles
        return length / self.lengths, l2, along / length, down / length

    def found(self, start: Chains, rounds: int = ROUNDS) -> Chains:
        """The states near chains whose ends are held."""
        r, z, done = start.r.copy(), start.z.copy(), np.zeros(start.V.shape, bool)
        live = np.arange(start.V.size)
        width = np.full((start.V.size, self.count), np.nan)
        for _ in range(rounds):
            if not live.size:
                break
            at = Chains(start.V[live], r[live], z[live], done[live])
            step, width[live] = self._step(at, width[live])
            length = np.hypot(np.diff(at.r, axis=1), np.diff(at.z, axis=1))
            largest = np.max(np.abs(np.diff(step, axis=1)).max(axis=2) / length, axis=1)
            share = np.minimum(1.0, LARGEST_STEP / np.maximum(largest, 1e-300))
            r[live] += share[:, None] * step[:, :, 0]
            z[live] += share[:, None] * step[:, :, 1]
            converged = largest < ACCURATE
            done[live[converged]] = True
            lost = ~np.isfinite(largest)
            live = live[~converged & ~lost]
        return Chains(start.V, r, z, done)

    def _step(self, at: Chains, width: Array) -> tuple[Array, Array]:
        """Newton's step of the nodes, (states, nodes, 2), and the rings' widths."""
        from scipy.linalg import solve_banded  # importing it takes as long as starting gelcone

        l1, l2, cosine, sine = self.stretches(at)
        V = np.broadcast_to(at.V[:, None], l1.shape)
        with np.errstate(all="ignore"):
            slack = self.gel.hoop(l1, l2, V) < 0.0
            least = np.sqrt(self.gel.G / (self.gel.B * l1 * l1))
            guess = np.where(np.isnan(width), np.maximum(l2 * l2, least), np.maximum(width, l2 * l2))
            ring = self.gel.ring(l1, l2, V, slack, guess, steps=25 if np.isnan(width).any() else 4)
        w, dR, R2 = self.weights, self.lengths, 2.0 * self.middles
        turn = np.maximum(ring.meridional, LEAST_TENSION) / (l1 * dR * dR)
        firm = np.maximum(ring.firmness, 1e-6) / (dR * dR)
        # gradients of l1 by (r, z) of the outer node, of l2 by r of either
        gr, gz = w * ring.meridional * cosine / dR, w * ring.meridional * sine / dR
        hoop = w * ring.hoop / R2
        rr = w * (firm * cosine * cosine + turn * sine * sine)
        zz = w * (firm * sine * sine + turn * cosine * cosine)
        rz = w * (firm - turn) * cosine * sine
        mixed_r, mixed_z = w * ring.coupling * cosine / (dR * R2), w * ring.coupling * sine / (dR * R2)
        across = w * ring.hoop_firmness / (R2 * R2)
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
        ok = np.isfinite(band).all(axis=(0, 2)) & np.isfinite(right).all(axis=(1, 2))
        band[:, ~ok], right[~ok] = 0.0, 0.0
        band[BAND, ~ok] = 1.0
        step = -solve_banded((BAND, BAND), band.reshape(2 * BAND + 1, -1), right.ravel(), check_finite=False)
        step = np.pad(step.reshape(states, inner, 2), ((0, 0), (1, 1), (0, 0)))
        step[~ok] = np.nan
        return step, ring.width

    def least_firmness(self, at: Chains) -> Array:
        """Of any ring of states, (states,), also between the middles of elements."""
        l1, l2, _, _ = self.stretches(at)
        share = np.linspace(0.0, 1.0, BETWEEN + 1)[:-1]
        fine = [values[:, :-1, None] + np.diff(values, axis=1)[:, :, None] * share for values in (l1, l2)]
        V = np.broadcast_to(at.V[:, None, None], fine[0].shape)
        with np.errstate(all="ignore"):
            found: Array = np.min(self.gel.at(fine[0], fine[1], V).firmness, axis=(1, 2))
        return found

    def measures(self, at: Chains) -> Measures:
        """What states are; NaN where none was found."""
        l1, l2, _, sine = self.stretches(at)
        V = np.broadcast_to(at.V[:, None], l1.shape)
        with np.errstate(all="ignore"):
            ring, stress = self.gel.at(l1, l2, V), self.gel.hoop(l1, l2, V)
        force = -(self.weights * ring.meridional * sine / self.lengths)[:, 0]
        area = np.sum(self.weights * l1 * l1 * ring.width, axis=1)
        # beside the disc from the two innermost elements
        rate = (self.middles[0] - self.nodes[0]) / (self.middles[1] - self.middles[0])
        disc = (l1[:, 0] + rate * (l1[:, 0] - l1[:, 1])) ** 2
        found = (
            at.z[:, 0],
            force,
            area,
            disc,
            np.sqrt(np.max(l1 * l1 * ring.width, axis=1)),
            np.min(ring.firmness, axis=1),
            np.min(stress, axis=1),
            np.max(stress, axis=1),
        )
        return Measures(*(np.where(at.found, values, np.nan) for values in found))
