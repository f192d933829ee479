"""What the paper claims about the stretch limit."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from gelcone.paper.claims.claim import Studies, claim
from gelcone.paper.reading import chaotic, finite_positive, first_chaos, fixed_branch, share, share_number
from gelcone.paper.verdicts import Finding, Number

if TYPE_CHECKING:
    import xarray as xr

LIMIT_THRESHOLD = 1.5
"""From the paper's text."""
SAME = 0.05
"""Motions are indistinguishable when they differ by less than this share of their size: what a plot shows."""
NEARLY_ALL = 0.95


@claim(
    "limit-threshold",
    "Chaos for stretch limits below about 1.5, stable motion above.",
    13,
    "diagram-fast-stretch-limit",
    "limit-map",
)
def limit_threshold(studies: Studies) -> Finding:
    diagram, plane = studies["diagram-fast-stretch-limit"], studies["limit-map"]
    branch = fixed_branch(diagram)
    limits, chaos = branch["stretch_limit"].values, chaotic(branch)
    threshold = first_chaos(diagram, "stretch_limit", falling=True)
    below = limits < LIMIT_THRESHOLD
    largest = {float(v): _largest(plane, float(v)) for v in plane["voltage"].values}
    lowest = float(plane["stretch_limit"].values.min())
    near = [bool(LIMIT_THRESHOLD / 1.5 <= j <= LIMIT_THRESHOLD * 1.5) for j in largest.values()]
    holds = threshold is not None and abs(threshold.value / LIMIT_THRESHOLD - 1.0) <= 0.2
    finite = finite_positive(branch)
    extra = () if threshold is None else (threshold,)
    return Finding(
        holds=bool(holds),
        holds_finite=bool(share(finite[below]) >= NEARLY_ALL and not finite[~below].any()),
        share=share(near),
        neighbourhood="drive voltages from 0.7 to 1.6 (threshold between 1 and 2.25)",
        numbers=(
            *extra,
            share_number("share of stretch limits below 1.5 with chaos", chaos[below]),
            share_number("share of stretch limits above 1.5 with chaos", chaos[~below]),
        ),
        why="A low stretch limit stiffens the film within reach of the motion; how low it must be follows the voltage.",
        unseen="The largest chaotic stretch limit over voltage: "
        + ", ".join(f"{j:.3g} at v = {v:.3g}" if j == j else f"none at v = {v:.3g}" for v, j in largest.items())
        + ".",
        details={
            f"largest chaotic stretch limit at v = {v:.3g}": f"{j:.3g}" if j == j else f"none from {lowest:.3g} on"
            for v, j in largest.items()
        },
    )


def _largest(plane: xr.Dataset, voltage: float) -> float:
    row = plane.sel(voltage=voltage)
    limits = row["stretch_limit"].values[chaotic(row)]
    return float(limits.max()) if limits.size else float("nan")


@claim("limit-large-same", "Large stretch limits are indistinguishable from one another.", 5, "large-limits")
def limit_large_same(studies: Studies) -> Finding:
    study = studies["large-limits"]
    x = study["displacement"].values
    window = np.abs(x - x[:, -1:]).max(axis=-1) / np.abs(x).max(axis=-1)
    # Mirror images count as the same motion: which of the two a motion ends on is a matter of its start.
    highest = np.fmax(np.abs(study["highest"].values), np.abs(study["lowest"].values))
    extent = np.abs(highest - highest[:, -1:]) / np.maximum(highest[:, -1:], 0.01)
    voltages = study["voltage"].values[:, 0]
    own = int(np.argmin(np.abs(voltages - 1.005)))
    same_long, same_window = (extent < SAME).all(axis=1), (window < SAME).all(axis=1)
    error = 1e-4 / highest[own, -1]
    return Finding(
        holds=bool(same_long[own]),
        holds_finite=bool(same_window[own]),
        share=share(same_long),
        neighbourhood=f"{len(voltages)} drive voltages from {voltages.min():g} to {voltages.max():g}",
        numbers=(
            Number(
                "difference of the extents in the long run, J = 100 against 1000", float(extent[own, 0]), error=error
            ),
            share_number("share of voltages from 0.5 to 1.7 with the same extent in the long run", same_long),
            share_number("share of these voltages with the same time series over the window", same_window),
            Number("difference of the time series over the window, v = 1.005", float(window[own, 0]), error=1e-9),
        ),
        why="While I1 - 3 stays far below J, Gent's film is neo-Hookean to the order (I1 - 3)/J.",
        unseen="In chaos no two stretch limits give the same time series, however large they are. The verdict is that "
        f"of v = {voltages[own]:g}; of all voltages checked the claim holds for {int(same_long.sum())} of "
        f"{same_long.size}.",
    )


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
    outside = limits <= needed
    fixed = study["fixed_step_exponent"].values
    inside = study["lyapunov"].values[:, 0]
    error = study["standard_error"].values[:, 0]
    smallest = int(np.argmin(limits))
    negative = inside[outside] < -3.0 * error[outside]
    found = f"{int(negative.sum())} of {negative.size}"
    return Finding(
        holds=False,
        holds_finite=False,
        holds_fixed_step=bool((fixed[outside] < 0.0).any()),
        share=share(negative),
        neighbourhood="stretch limits from 0.02 to 0.5, each with a motion from half the displacement that it allows",
        numbers=(
            Number("smallest stretch limit that the paper's initial state allows", needed, error=0.0),
            share_number("share of smaller ones with a negative exponent, from inside the limit", negative),
            Number("exponent at the smallest limit from inside", float(inside[smallest]), error=float(error[smallest])),
            Number("exponent of the fixed-step run there, beyond the limit", float(fixed[smallest]), error=0.0),
        ),
        why=f"The initial displacement 1 strains the film to I1 - 3 = {needed:g}: for any smaller stretch limit "
        "there is no such motion. A fixed-step integrator starts on the unphysical side all the same and runs off to "
        f"infinity. From inside, {found} stretch limits have a negative exponent: periodic windows, which a finer "
        "search would find more of, so that this verdict says that there are such windows and not how many.",
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
            share_number("share of neighbouring stretch limits of which the smaller is steeper everywhere", steeper),
            Number("displacement at which the film with J = 1 ends", reach, error=1e-9),
            Number("slope for J = 1 over that for J = 100, at 95 % of that displacement", sharp, error=1e-6),
        ),
        why="The film's force is x (A - G/q^2) over 1 - (I1 - 3)/J, which grows as J falls at every displacement.",
        unseen="The energy grows only like a logarithm at the limit: an integrator without a guard can step across.",
    )
