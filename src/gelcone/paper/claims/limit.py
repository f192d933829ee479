"""What the paper claims about the stretch limit."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from gelcone.motion.tangents import CERTAIN
from gelcone.paper.claims.claim import Studies, claim
from gelcone.paper.numbers import Number
from gelcone.paper.reading import chaotic, finite_positive, first_chaos, fixed_branch, regular, slack_of
from gelcone.paper.studies.diagrams import PANELS
from gelcone.paper.truths import every, share, truth
from gelcone.paper.verdicts import NEARLY_ALL, Finding
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

LIMIT_THRESHOLD = 1.5
"""From the paper's text."""
ABOUT = 1.2
"""What "about" leaves to either side, as a factor."""
TINY = 0.5
"""Stretch limits up to here count as going to zero."""
SAME = 0.05
"""Motions are indistinguishable when they differ by less than this share of their size: what a plot shows."""


@claim(
    "limit-threshold",
    "Chaos for stretch limits below about 1.5, stable motion above.",
    13,
    "diagram-fast-stretch-limit",
    "limit-map",
    "limit",
)
def limit_threshold(studies: Studies) -> Finding:
    diagram, plane = studies["diagram-fast-stretch-limit"], studies["limit-map"]
    branch = fixed_branch(diagram)
    limits = branch["stretch_limit"].values
    below, above = limits < LIMIT_THRESHOLD / ABOUT, limits > LIMIT_THRESHOLD * ABOUT
    threshold = first_chaos(diagram, "stretch_limit", falling=True)
    voltages = plane["voltage"].values
    own = int(np.argmin(np.abs(voltages - PANELS["fast", "stretch_limit"])))
    rows = {float(v): plane.sel(voltage=v) for v in voltages}
    largest = {v: _largest(row) for v, row in rows.items()}
    lowest = float(plane["stretch_limit"].values.min())
    chaos, calm = share(chaotic(branch)[below]), share(regular(branch)[above])
    finite = finite_positive(branch)
    return Finding(
        holds=every(chaos.exceeds(NEARLY_ALL), calm.exceeds(NEARLY_ALL)),
        holds_finite=every(share(finite[below]).exceeds(NEARLY_ALL), share(1.0 - finite[above]).exceeds(NEARLY_ALL)),
        share=share([_parted(row) for k, row in enumerate(rows.values()) if k != own]),
        neighbourhood="other drive voltages from 0.7 to 1.6, chaos at most of the lower stretch limits and at none of "
        "the higher",
        numbers=(
            *(() if threshold is None else (threshold,)),
            chaos.number(f"share of stretch limits below {LIMIT_THRESHOLD / ABOUT:g} with chaos"),
            calm.number(f"share of stretch limits above {LIMIT_THRESHOLD * ABOUT:g} without chaos"),
        ),
        why="A low stretch limit stiffens the film within reach of the motion; how low it must be follows the voltage. "
        f"Needed: chaos at {NEARLY_ALL:.0%} of the stretch limits below about 1.5 (a fifth less), and none at "
        f"{NEARLY_ALL:.0%} of those above it (a fifth more).",
        slack=slack_of(studies["limit"], "stretch_limit"),
        unseen="The largest chaotic stretch limit over voltage: "
        + ", ".join(f"{j:.3g} at v = {v:.3g}" if j == j else f"none at v = {v:.3g}" for v, j in largest.items())
        + ".",
        details={
            f"largest chaotic stretch limit at v = {v:.3g}": f"{j:.3g}" if j == j else f"none from {lowest:.3g} on"
            for v, j in largest.items()
        },
    )


def _parted(row: xr.Dataset) -> float:
    """Whether one voltage's stretch limits are mostly chaotic below about 1.5, and not at all above: 1, 0 or NaN."""
    limits, chaos = row["stretch_limit"].values, chaotic(row)
    lower = share(chaos[limits < LIMIT_THRESHOLD / ABOUT], sample=False)
    upper = share(chaos[limits > LIMIT_THRESHOLD * ABOUT], sample=False)
    met = every(lower.exceeds(0.5), None if upper.failing and not upper.found and upper.open else not upper.holding)
    return float("nan") if met is None else float(met)


def _largest(row: xr.Dataset) -> float:
    limits = row["stretch_limit"].values[chaotic(row) == 1.0]
    return float(limits.max()) if limits.size else float("nan")


@claim("limit-large-same", "Large stretch limits are indistinguishable from one another.", 5, "large-limits")
def limit_large_same(studies: Studies) -> Finding:
    study = studies["large-limits"]
    x = study["displacement"].values
    window = np.abs(x - x[:, -1:]).max(axis=-1) / np.abs(x).max(axis=-1)
    # Mirror images count as the same motion: which of the two a motion ends on is a matter of its start.
    extent = np.fmax(np.abs(study["highest"].values), np.abs(study["lowest"].values))
    least, most = _differences(extent)
    voltages = study["voltage"].values[:, 0]
    own = int(np.argmin(np.abs(voltages - PANELS["fast", "stretch_limit"])))
    same_window = (window < SAME).all(axis=1)
    same_long = np.where(most < SAME, 1.0, np.where(least < SAME, np.nan, 0.0))
    others = share(np.delete(same_long, own))
    return Finding(
        holds=truth(same_long[own]),
        holds_finite=bool(same_window[own]),
        share=others,
        neighbourhood=f"{len(voltages) - 1} other drive voltages from {voltages.min():g} to {voltages.max():g}",
        numbers=(
            Number(
                "largest difference of the extents in the long run, J = 100 and 300 against 1000",
                float(most[own]),
                low=float(least[own]),
                high=float(most[own]),
            ),
            others.number("share of other voltages from 0.5 to 1.7 with the same extent in the long run"),
            share(same_window).number("share of all voltages with the same time series over the window"),
            Number("difference of the time series over the window, v = 1.005", float(window[own, 0])),
        ),
        why="While I1 - 3 stays far below J, Gent's film is neo-Hookean to the order (I1 - 3)/J. The extents count as "
        f"the same when they agree within {SAME:.0%} for all of {extent.shape[-1]} starts within 1e-9 of one another, "
        "and as different when for none; else the start decides, and nothing is said.",
        unseen="In chaos no two stretch limits give the same time series, however large they are. The verdict is that "
        f"of v = {voltages[own]:g}.",
    )


def _differences(extent: Array) -> tuple[Array, Array]:
    """Smallest and largest relative difference of the extents from those at the largest limit, over nearby starts.

    ``extent`` is (voltages, limits, starts); both results are (voltages,): for each limit the pair of starts that
    agrees best, or worst, and of these the limit that differs most.
    """
    last = extent[:, -1, None, None, :]
    off = np.abs(extent[:, :-1, :, None] - last) / np.maximum(last, 0.01)
    return off.min(axis=(2, 3)).max(axis=1), off.max(axis=(2, 3)).max(axis=1)


@claim(
    "limit-tiny-negative",
    "As the stretch limit goes to zero the largest exponent is locally negative.",
    13,
    "beyond",
)
def limit_tiny_negative(studies: Studies) -> Finding:
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
        holds_fixed_step=bool((fixed[tiny & ~allowed] < 0.0).any()),
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
