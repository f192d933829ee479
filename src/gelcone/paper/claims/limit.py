"""Claims about the stretch limit."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from gelcone.motion.tangents import CERTAIN
from gelcone.paper.claims.claim import Studies, claim
from gelcone.paper.numbers import Number
from gelcone.paper.reading import (
    LIMIT_THRESHOLD,
    SAME,
    chaotic,
    differences,
    finite_not_positive,
    finite_positive,
    first_chaos,
    parted,
    regular,
    same_extents,
    slack_of,
)
from gelcone.paper.sampling import part, share_of
from gelcone.paper.studies.limits import OWN_VOLTAGE
from gelcone.paper.studies.samples import ABOUT, rows_same
from gelcone.paper.truths import every, share, truth
from gelcone.paper.verdicts import NEARLY_ALL, WIDE, Finding

if TYPE_CHECKING:
    import xarray as xr

TINY = 0.5
"""Stretch limits up to this count as approaching zero."""


@claim(
    "limit-threshold",
    "Chaos for stretch limits below about 1.5, stable motion above.",
    13,
    "diagram-fast-stretch-limit",
    "share-limit",
    "other-voltages-limit",
    "limit-map",
    "limit",
)
def limit_threshold(studies: Studies) -> Finding:
    """Judges samples of stretch limits on both sides of the threshold."""
    plane, others = studies["limit-map"], studies["other-voltages-limit"]
    below, above = (part(studies["share-limit"], name) for name in ("below", "above"))
    threshold = first_chaos(studies["diagram-fast-stretch-limit"], "stretch_limit", falling=True)
    largest = {float(v): _largest(plane.sel(voltage=v)) for v in plane["voltage"].values}
    lowest = float(plane["stretch_limit"].values.min())
    chaos, calm = share_of(below, chaotic(below)), share_of(above, regular(above))
    finite, finite_calm = share_of(below, finite_positive(below)), share_of(above, finite_not_positive(above))
    return Finding(
        holds=every(chaos.exceeds(NEARLY_ALL), calm.exceeds(NEARLY_ALL)),
        holds_finite=every(finite.exceeds(NEARLY_ALL), finite_calm.exceeds(NEARLY_ALL)),
        share=share_of(others, parted(others)),
        neighbourhood="other drive voltages from 0.7 to 1.6, chaos at most of the lower stretch limits and at none of "
        "the higher",
        numbers=(
            *(() if threshold is None else (threshold,)),
            chaos.number(f"share of stretch limits below {LIMIT_THRESHOLD / ABOUT:g} with chaos"),
            calm.number(f"share of stretch limits above {LIMIT_THRESHOLD * ABOUT:g} with regular motion"),
        ),
        why="A low stretch limit stiffens the film within reach of the motion; how low it must be follows the voltage. "
        f"Needed: chaos at {NEARLY_ALL:.0%} of the stretch limits below {LIMIT_THRESHOLD / ABOUT:g}, and regular "
        f"motion at {NEARLY_ALL:.0%} of those above {LIMIT_THRESHOLD * ABOUT:g}; about {LIMIT_THRESHOLD:g} is any "
        "limit between them.",
        slack=slack_of(studies["limit"], "stretch_limit"),
        unseen="The largest stretch limit at which chaos was seen, over the voltage.",
        details={
            f"largest stretch limit at which chaos was seen, v = {v:.3g}": f"{j:.3g}"
            if j == j
            else f"none from {lowest:.3g} on"
            for v, j in largest.items()
        },
    )


def _largest(row: xr.Dataset) -> float:
    limits = row["stretch_limit"].values[chaotic(row) == 1.0]
    return float(limits.max()) if limits.size else float("nan")


@claim("limit-large-same", "Large stretch limits are indistinguishable from one another.", 5, "large-limits")
def limit_large_same(studies: Studies) -> Finding:
    """Judges extents at three large stretch limits from nearby starts."""
    study = studies["large-limits"]
    x = study["displacement"].values
    window = float((np.abs(x - x[-1:]).max(axis=-1) / np.abs(x).max(axis=-1)).max())
    spans = study["own_extent"].values[None]
    least, most, _ = differences(spans)
    others = share_of(study, rows_same(study))
    return Finding(
        holds=truth(same_extents(spans, study["own_regime"].values[None])[0]),
        holds_finite=None if np.isnan(window) else window < SAME,
        share=others,
        neighbourhood="other drive voltages from 0.5 to 1.7",
        numbers=(
            Number(
                "largest difference of the extents in the long run, J = 100 and 300 against 1000",
                float(most[0]),
                low=float(least[0]),
                high=float(most[0]),
            ),
            others.number("share of other voltages from 0.5 to 1.7 with the same extent in the long run"),
            Number("largest difference of the time series over the window, v = 1.005", window),
        ),
        why="While I1 - 3 stays far below J, Gent's film is neo-Hookean to the order (I1 - 3)/J. The extents count as "
        f"the same when each of {spans.shape[-1]} starts within 1e-9 of one another has one at the other limit within "
        f"{SAME:.0%} (in chaos, when two agree), and as different when no two agree; else the start decides, and "
        "nothing is said.",
        unseen="In chaos no two stretch limits give the same time series, however large they are. The verdict is that "
        f"of v = {OWN_VOLTAGE:g}.",
    )


@claim(
    "limit-tiny-negative",
    "As the stretch limit goes to zero the largest exponent is locally negative.",
    13,
    "beyond",
)
def limit_tiny_negative(studies: Studies) -> Finding:
    """Judges exponents at small stretch limits: of the true motion within the limit and of the fixed-step run beyond
    it."""
    study = studies["beyond"]
    limits = study["stretch_limit"].values
    needed = float(study["initial_strain"].values[0])
    tiny, allowed = limits <= TINY, limits > needed
    fixed = study["fixed_step_exponent"].values
    inside = study["lyapunov"].values[:, 0]
    error = study["standard_error"].values[:, 0]
    smallest = int(np.argmin(limits))
    negative = inside < -CERTAIN * error
    other = share(negative[tiny & ~allowed])
    return Finding(
        holds=bool((negative & tiny & allowed).any()),
        holds_fixed_step=share(fixed[tiny & ~allowed] < 0.0).exceeds(WIDE) is True,
        share=other,
        neighbourhood="starts at half the displacement that the stretch limit allows, for limits from 0.02 to 0.5 that "
        "do not allow the paper's start",
        numbers=(
            Number("smallest stretch limit that the paper's initial state allows", needed),
            other.number("share of smaller ones with a negative exponent, from inside the limit"),
            Number("exponent at the smallest limit from inside", float(inside[smallest]), error=float(error[smallest])),
            Number("exponent of the fixed-step run there, beyond the limit", float(fixed[smallest])),
        ),
        why=f"The initial displacement 1 strains the film to I1 - 3 = {needed:g}: for any smaller stretch limit "
        "there is no such motion, so that the limit of zero cannot be reached from there. A fixed-step integrator "
        "starts on the unphysical side all the same. From inside, some stretch limits have a negative exponent: "
        "periodic windows, of which a finer search would find more.",
        unseen="That the initial state lies beyond the stretch limit, where the energy is not defined.",
    )


@claim(
    "energy-steepening",
    "The energy curves steepen as the stretch limit falls; for J = 1 the energy rises sharply near the limit.",
    6,
    "energy",
)
def energy_steepening(studies: Studies) -> Finding:
    """Judges the slopes of the energy curves pair by pair."""
    study = studies["energy"]
    limits, x = study["stretch_limit"].values, study["displacement"].values
    force = study["film_force"].values[:, x > 0.0]
    steeper = [bool((a[np.isfinite(a)] > b[np.isfinite(a)]).all()) for a, b in pairwise(force)]
    one = int(np.flatnonzero(limits == 1.0)[0])
    reach = float(study["reach"].values[one])
    near = int(np.argmin(np.abs(x[x > 0.0] - 0.95 * reach)))
    sharp = float(force[one, near] / force[-1, near])
    return Finding(
        holds=all(steeper) and sharp > 2.0,
        numbers=(
            share(steeper, sample=False).number(
                "share of neighbouring stretch limits of which the smaller is steeper everywhere"
            ),
            Number("displacement at which the film with J = 1 ends", reach),
            Number("slope for J = 1 over that for J = 100, at 95 % of that displacement", sharp),
        ),
        why="The film's force is x (A - G/q^2) over 1 - (I1 - 3)/J, which grows as J falls at every displacement.",
        consequence="It follows from Gent's energy alone, for any parameters and any motion.",
        unseen="The energy grows only like a logarithm at the limit: an integrator without a guard can step across.",
    )
