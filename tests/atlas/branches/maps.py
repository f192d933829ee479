"""Maps in place of shooting whose orbits, bifurcations and born branches are known by formulas.

A map with one pair of multipliers of product `SHRINKS`, like that of an actuator: (x, y) -> ((1 + b) rule(x) - b y, x).
Its fixed points are those of the one-dimensional ``rule``, whose slope is 1 where a multiplier is 1 and -1 where one is
-1; its cycles of two are those of the rule, too.
"""

from types import SimpleNamespace

import numpy as np

from gelcone.atlas.branches.point import Metric, at_value
from gelcone.motion.orbit import Kind, Pass, Shooting

SHRINKS = 0.3
HALFWAY = np.array([0.5, 0.25])
"""Each repeat has two segments: a shrinking of both states, and all the rest."""
MIRROR = -np.ones(2)
ONCE = Kind(1)


class Maps:
    """Passes over the orbits of a ``rule(x, *values)``; ``reach``, how far x may lie from 0."""

    size, segments, pulled_in, phase = 2, 2, False, np.pi
    system = SimpleNamespace(planar=True, mirror=MIRROR)
    gaps, multipliers = Shooting.gaps, Shooting.multipliers

    def __init__(self, rule, kind=ONCE, *, symmetric=False, reach=np.inf):
        self.rule, self.kind, self.symmetric, self.reach = rule, kind, symmetric, reach
        self.count = 2 * kind.repeats
        self.signs = MIRROR if kind.reflected else np.ones(2)

    def of_kind(self, kind):
        return self if kind == self.kind else Maps(self.rule, kind, symmetric=self.symmetric, reach=self.reach)

    def inside(self, nodes, values):
        return bool(np.abs(nodes[:, 0]).max() < self.reach)

    def log_determinant(self, values):
        return self.kind.repeats * np.log(SHRINKS)

    def run(self, nodes, values):
        ends, tangents = np.empty_like(nodes), np.zeros((len(nodes), 2, 2))
        slopes = np.zeros((len(nodes), 2, len(values)))
        ends[::2], tangents[::2] = nodes[::2] * HALFWAY, np.diag(HALFWAY)
        x, y = (nodes[1::2] / HALFWAY).T
        ends[1::2] = np.stack([(1.0 + SHRINKS) * self.rule(x, *values) - SHRINKS * y, x], axis=1)
        slope = self._slope(0, x, values)
        tangents[1::2] = np.stack(
            [np.stack([slope, 0.0 * x - SHRINKS], axis=1), np.stack([0.0 * x + 1.0, 0.0 * x], axis=1)], axis=1
        )
        tangents[1::2] /= HALFWAY
        for k in range(len(values)):
            slopes[1::2, 0, k] = self._slope(k + 1, x, values)
        return Pass(ends, tangents, slopes, True)

    def _slope(self, of, x, values):
        """(1 + b) times the derivative of the rule, along the imaginary axis, where nothing cancels."""
        arguments = [np.asarray(a, dtype=complex) for a in (x, *values)]
        arguments[of] = arguments[of] + 1e-30j
        return (1.0 + SHRINKS) * np.imag(self.rule(*arguments)) / 1e-30


def nodes_of(*x):
    """The nodes of the orbit through x[0], x[1], ...; y is the x before."""
    states = np.stack([x, np.roll(x, 1)], axis=1)
    return np.stack([states, states * HALFWAY], axis=1).reshape(-1, 2)


def orbit_at(maps, value, *x):
    """The orbit near those displacements; its tangent goes up in the value."""
    nodes = nodes_of(*x)
    found = at_value(maps, nodes, value, Metric.of(nodes, 1.0)).point
    assert found is not None
    return found


AWAY = 3.0
"""Displacement about which the rules below are symmetric, so that no orbit is near rest."""


def s_curve(x, p):
    """Fixed points p = g(x - AWAY), g(s) = s^3 - 3 s: folds at s = -1 and 1, where p = 2 and -2. A multiplier is -1 at
    s^2 = 5/3; the cycles of two born there are m -+ h with 3 m^2 + h^2 = 5, at p = m^3 + 3 m h^2 - 3 m."""
    s = x - AWAY
    return x + p - (s**3 - 3.0 * s)


def value_of(s):
    return s**3 - 3.0 * s


DOUBLES_AT = np.sqrt(5.0 / 3.0)


def isola(x, p):
    """Fixed points on the circle (x - AWAY)^2 + p^2 = 1, with folds at p = -1 and 1."""
    return x + 0.3 * (1.0 - (x - AWAY) ** 2 - p * p)


def pitchfork(x, p):
    """Rest x = 0 loses its stability at p = 0, where x^2 = p is born."""
    return x + 0.5 * x * (p - x * x)


def mirrored_pitchfork(x, p):
    """The same of orbits that are their own mirror image; they lose this symmetry at p = 2: cycles of the rule of two
    displacements whose ratio is r, at p = 2 (r + 1/r - 1)."""
    return -pitchfork(x, p)


def cusp(x, p, q):
    """Fixed points p = s^3 - q s: folds at 3 s^2 = q, where p = -2 s^3; both end at the cusp, p = q = 0."""
    s = x - AWAY
    return x + p - (s**3 - q * s)


def cycle_of(h):
    """Displacements and value of the cycle of two of the `s_curve` whose halves are 2 h apart."""
    m = np.sqrt((5.0 - h * h) / 3.0)
    return (AWAY + m + h, AWAY + m - h), m**3 + 3.0 * m * h * h - 3.0 * m


def doubling_line(x, p, q):
    """The fixed point x = AWAY has the multiplier -1 at p = 0; there cycles of two are born, p = q h^2, on the side of
    q: super- and subcritical meet at q = 0."""
    s = x - AWAY
    return AWAY - (1.0 + p) * s + q * s**3


def sphere(x, p, q):
    """Fixed points on a sphere, with folds on the circle p^2 + q^2 = 1."""
    return x + 0.3 * (1.0 - (x - AWAY) ** 2 - p * p - q * q)


def multipliers_at(slope):
    """The two multipliers where the rule has that slope, the larger one first."""
    return sorted(np.roots([1.0, -(1.0 + SHRINKS) * slope, SHRINKS]), key=abs, reverse=True)


def bubble(x, p):
    """The fixed point x = AWAY has the multiplier -1 at p = 0 and at p = 1; a branch of cycles of two, h^2 = p (1 - p),
    leads from the one to the other."""
    s = x - AWAY
    return AWAY - (1.0 + p * (1.0 - p)) * s + s**3
