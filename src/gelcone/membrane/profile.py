"""A film along its meridian: shape, stretches, field and tangent stiffness of every ring at held heights and
voltages."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gelcone.membrane.columns import columns
from gelcone.membrane.elements import Chains, Elements
from gelcone.membrane.gel import Array

LOWEST = 1e-3
"""Height at which a flat film is computed, since Newton's method needs a direction out of the plane; the error is its
square."""
NEARLY = 1e-3
"""Share of its voltage by which a column may fall short, since it takes no shorter step."""


class Profile(NamedTuple):
    """States ring by ring from the disc to the rim, (states, rings); NaN for states that were not found.

    Mounted ``radius`` R in b - a, (rings,); deformed radius ``r`` and height ``z`` above the plane of the rim;
    meridional length ``l1`` over the mounted one; ``width``, the hoop length of the material over the mounted one, and
    ``span``, the circumference over the mounted one, which is less where the hoop is wrinkled; the true ``field`` over
    v; ``limit_share``, (I1 - 3) over the stretch limit; and ``tangent_stiffness``, the slope of the meridional tension
    by l1.
    """

    radius: Array
    r: Array
    z: Array
    l1: Array
    width: Array
    span: Array
    field: Array
    limit_share: Array
    tangent_stiffness: Array

    @property
    def thickness(self) -> Array:
        """Thickness of each ring over the mounted one."""
        return 1.0 / (self.l1 * self.width)

    @property
    def excess(self) -> Array:
        """Share of the hoop length that lies in wrinkles."""
        return np.maximum(1.0 - self.span / self.width, 0.0)


def held(film: Elements, x: Array, V: Array) -> Chains:
    """The states of a film at the heights x >= 0 after the voltage has risen to V; not found where the film falls slack
    or localises before, or has no tension without voltage."""
    lowest = np.maximum(x, LOWEST)
    risen = columns(film, lowest, V, V)
    there = risen.last.found & (risen.last.V >= (1.0 - NEARLY) * V)
    if there.any():
        at = film.found(risen.last.where(there)._replace(V=V[there]))
        r, z = risen.last.r.copy(), risen.last.z.copy()
        r[there], z[there], there[there] = at.r, at.z, at.found
        return Chains(V, r, z * (x / lowest)[:, None], risen.last.tension, there)
    return risen.last._replace(V=V, found=there)


def profile(film: Elements, at: Chains) -> Profile:
    """The profile of states, at the disc, at the middles of the elements and at the rim."""
    R = np.concatenate([film.nodes[:1], film.middles, film.nodes[-1:]])
    l1, span, _, _ = film.stretches(at)
    l1 = np.concatenate(
        [_before(film.nodes[0], film.middles, l1), l1, _before(film.nodes[-1], film.middles[::-1], l1[:, ::-1])], axis=1
    )
    span = np.pad(span, ((0, 0), (1, 1)), constant_values=1.0)
    r, z = (
        np.concatenate([coordinate[:, :1], 0.5 * (coordinate[:, 1:] + coordinate[:, :-1]), coordinate[:, -1:]], axis=1)
        for coordinate in (at.r, at.z)
    )
    V = np.broadcast_to(at.V[:, None], l1.shape)
    with np.errstate(all="ignore"):
        ring = film.gel.at(l1, span, V)
        share = film.gel.strain(l1 * l1, ring.width) / film.gel.strain_limit
    width = np.sqrt(ring.width)
    fields = (r, z, l1, width, span, l1 * width, share, ring.tangent_stiffness)
    return Profile(R, *(np.where(at.found[:, None], values, np.nan) for values in fields))


def _before(place: float, places: Array, values: Array) -> Array:
    """Values extrapolated to a ``place`` before the first of ``places``, on the line through the first two."""
    rate = (place - places[0]) / (places[1] - places[0])
    extrapolated: Array = values[:, :1] + rate * (values[:, 1:2] - values[:, :1])
    return extrapolated
