"""Above which voltage a membrane has pulled in, over the displacement, of all pre-stretches.

Higher up than a height at which it localises, it has pulled in on the way there at no more than that voltage; where it
falls slack first, it pulls in as a film without tension does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gelcone.errors import InputError
from gelcone.membrane.columns import Columns, columns, longest
from gelcone.membrane.elements import Elements
from gelcone.membrane.gel import Array, Gel

HEIGHTS = np.concatenate([np.linspace(0.05, 0.8, 16), np.geomspace(0.86, 3.0, 12)])
FINEST = 1e-3
"""Share of the V of a column within which its end is known."""
LONG = 0.99
"""Share of the length at which the innermost ring localises that it has at least at the end of a column that does."""
NEXT = 0.01
"""Of a voltage: at the lowest at which a ring localises, the end of a column may lie below by so much."""
SLACK = 0.98
"""Share of the voltage that takes the tension of a film at which it is slack."""
MESH_ERROR = 1e-3
"""Of the voltage by the elements, from their halving."""


@dataclass(frozen=True)
class PullInCurve:
    """Voltages above which a film has pulled in, at displacements from the lowest up; infinite where it does not.

    ``error`` is the largest of the voltages between, over them: of the elements, the steps and the interpolation.
    """

    displacements: tuple[float, ...]
    voltages: tuple[float, ...]
    error: float

    def voltage(self, x: npt.ArrayLike) -> Array:
        """At displacements of either sign: linear between those of the curve, level beyond, infinite up to the first at
        which it pulls in."""
        return np.interp(np.abs(x), self.displacements, self.voltages)


def pull_in_curve(gel: Gel, ratio: float) -> PullInCurve:
    """The curve of the film of a gel; ``ratio`` is a/b.

    Raises `InputError` for a film that is in tension at no displacement, and for a ratio outside 0 to 1.
    """
    if not 0.0 < ratio < 1.0:
        raise InputError(f"radius_ratio = {ratio:g}: must lie between 0 and 1; the disc is smaller than its ring")
    hump = gel.hump()
    free = max(float(gel.crumpling(max(t, 1.0))) / gel.G for t in (hump, gel.A, gel.B) if np.isfinite(t))
    free_limit = free if np.isfinite(hump) else np.inf
    top = np.full(HEIGHTS.size, free if np.isfinite(hump) else 4.0 * max(free, 1.0))
    first = np.minimum(0.5 * top, _evenly_slack(gel, HEIGHTS)) if gel.A >= gel.B else 0.5 * top
    found = columns(Elements(gel, ratio), HEIGHTS, np.maximum(first, 1e-6), top, finest=FINEST)
    if not np.isfinite(found.first).any():
        raise InputError("the film is in tension at no displacement; raise the pre-stretch or the stretch limit")
    localises, slackens = _endings(gel, found)
    x, squared, lowest, unknown = [0.0], [free_limit], free_limit, 0.0
    for k in range(HEIGHTS.size):
        # where it is not known to localise or to be slack, it is in tension up to the end of columns higher up
        known, highest = localises[k] or slackens[k], float(np.max(found.end[k:]))
        if localises[k]:
            lowest = min(lowest, float(found.end[k]))
        elif not known and lowest == free_limit and 0.0 < highest < free_limit < np.inf:
            unknown = max(unknown, 1.0 - (highest / free_limit) ** 0.5)
        elif not known:
            continue
        x.append(float(HEIGHTS[k]))
        squared.append(lowest if known else highest)
    voltages = np.sqrt(squared)
    # where slackness gives way to pull-in the curve is steep: its place, not its voltage, is uncertain there
    smooth = voltages[voltages < voltages[0]]
    bent = np.abs(np.diff(smooth, 2)) / 8.0 / smooth[1:-1]
    error = MESH_ERROR + FINEST + float(np.max(bent, initial=0.0))
    return PullInCurve(tuple(x), tuple(voltages.tolist()), max(error, unknown))


def _evenly_slack(gel: Gel, heights: Array) -> Array:
    """The V at which all rings of a film fall slack at once, as they do where the hoop is not the stronger."""
    found: Array = np.maximum(gel.crumpling(gel.A * (1.0 + heights**2)) / gel.G, 0.0)
    return found


def _endings(gel: Gel, found: Columns) -> tuple[Array, Array]:
    """Which columns end because a ring localises, and which because the film is slack. Of others, those of strong hoops
    that are all but slack, the next state was not found: they say nothing."""
    own = np.zeros((2, found.heights.size))
    for k in map(int, np.flatnonzero(np.isfinite(found.first))):
        V, disc = found.along(k, found.measures.disc)
        own[:, k] = V[-1], disc[-1]
    V, disc = own
    ended = (V > 0.0) & (found.end < found.top * (1.0 - FINEST))
    if gel.A >= gel.B:
        slackens = ended & (found.end > SLACK * _evenly_slack(gel, found.heights))
        return ended & ~slackens, slackens
    localises = ended & (np.sqrt(disc) > LONG * longest(gel, V * (1.0 + NEXT)))
    return localises, np.zeros(V.size, bool)
