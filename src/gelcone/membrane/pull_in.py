"""Above which voltage a membrane has pulled in, over the displacement, of all pre-stretches.

Higher up than a height at which it localises, it has pulled in on the way there at no more than that voltage; where it
falls slack first, it pulls in as a film without tension does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gelcone.errors import InputError
from gelcone.membrane.columns import Columns, columns, localised
from gelcone.membrane.elements import Elements
from gelcone.membrane.gel import Array, Gel
from gelcone.membrane.slack import slack_limit, slack_voltage

HEIGHTS = np.concatenate([np.linspace(0.05, 0.8, 16), np.geomspace(0.86, 3.0, 12)])
FINEST = 1e-3
"""Share of the V of a column within which its end is known."""
SLACK = 0.98
"""Share of the voltage that takes the tension of a film at which it is slack."""
MESH_ERROR = 1e-3
"""Of the voltage, by the elements: certified ones are up to 8e-4 away."""


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
    free_limit = slack_limit(gel)
    free = max(float(gel.crumpling(max(t, 1.0))) / gel.G for t in (gel.A, gel.B))
    top = np.full(HEIGHTS.size, max(free, free_limit) if np.isfinite(free_limit) else 4.0 * max(free, 1.0))
    slack = slack_voltage(gel, ratio, HEIGHTS)
    first = np.minimum(0.5 * top, slack)
    found = columns(Elements(gel, ratio), HEIGHTS, np.maximum(first, 1e-6), top, finest=FINEST)
    if not np.isfinite(found.first).any():
        raise InputError("the film is in tension at no displacement; raise the pre-stretch or the stretch limit")
    slackens = (found.end > SLACK * slack) & (found.end < top * (1.0 - FINEST))
    localises = ~slackens & (_ends(found) if gel.A >= gel.B else localised(gel, found))
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


def _ends(found: Columns) -> Array:
    """Which columns end below their top."""
    ended: Array = np.isfinite(found.first) & (found.end > 0.0) & (found.end < found.top * (1.0 - FINEST))
    return ended
