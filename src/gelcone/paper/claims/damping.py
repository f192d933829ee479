"""Claims about damping."""

from __future__ import annotations

import numpy as np

from gelcone.paper.claims.claim import Studies, claim
from gelcone.paper.films import CREEPING
from gelcone.paper.numbers import Number
from gelcone.paper.reading import finite_not_positive, fixed_branch, largest_exponent, without_chaos
from gelcone.paper.sampling import share_of
from gelcone.paper.studies.samples import holds_throughout, rows_without_chaos
from gelcone.paper.studies.triples import TRIPLES
from gelcone.paper.truths import lengths
from gelcone.paper.verdicts import NEARLY_ALL, Finding
from gelcone.presets import find_preset
from gelcone.quantity import Array

SMALLEST_ERROR = 1e-6
"""Errors of exponents below this are rounding."""


@claim(
    "damping-never-chaotic",
    "Over damping ratios from 0 to 2 no motion is chaotic; the exponent is slightly positive only towards zero.",
    13,
    "diagram-base-damping-ratio",
    "share-damping",
    "other-voltages-damping",
)
def damping_never_chaotic(studies: Studies) -> Finding:
    """Judges damping ratios on samples, also at other voltages."""
    sample, others = studies["share-damping"], studies["other-voltages-damping"]
    calm = share_of(sample, without_chaos(sample))
    never = rows_without_chaos(others)
    voltages = others["voltage"].values[:, 0]
    chaos = voltages[never == 0.0]
    first = float(chaos.min()) if chaos.size else float("nan")
    below = voltages[(never == 1.0) & ~(voltages > first)]
    undamped = fixed_branch(studies["diagram-base-damping-ratio"]).isel(damping_ratio=0)
    return Finding(
        holds=holds_throughout(calm),
        holds_finite=holds_throughout(share_of(sample, finite_not_positive(sample))),
        share=share_of(others, never),
        neighbourhood="other drive voltages from 0.5 to 2, each at damping ratios from 0.02 to 2",
        numbers=(
            calm.number("share of damping ratios in (0, 2] without chaos"),
            largest_exponent("largest exponent without damping", undamped),
            Number(
                "largest drive voltage up to which no chaos was seen at any damping ratio",
                float(below.max()) if below.size else float("nan"),
                low=float(below.max()) if below.size else None,
                high=first if chaos.size else None,
            ),
        ),
        why="At this voltage rest is stable and attracts every motion; at a higher one little damping leaves chaos. "
        f"Needed: no chaos at any damping ratio of a sample that bounds its share by {1.0 - NEARLY_ALL:.0%}.",
        unseen="That the statement concerns the chosen voltage: it lies below the loss of stability of rest. "
        "Without damping the exponent over a window T falls like log(T)/T, which looks slightly positive in any "
        "window.",
    )


@claim(
    "damping-order",
    "Small damping gives slow decay, large damping an overdamped return.",
    4,
    "diagram-base-damping-ratio",
    without=(CREEPING,),  # the second exponent is one of the branch
)
def damping_order(studies: Studies) -> Finding:
    """Judges decay and return from the two exponents at the damping ratios of the diagram."""
    base = fixed_branch(studies["diagram-base-damping-ratio"])
    base = base.sel(damping_ratio=base["damping_ratio"] > 0.0)
    zeta, exponents = base["damping_ratio"].values, base["lyapunov"].values
    error = np.maximum(base["standard_error"].values[:, 0], SMALLEST_ERROR)
    # Overdamped motion has two real decay rates; oscillating motion has -zeta twice.
    overdamped = exponents[:, 0] - exponents[:, 1] > np.maximum(6.0 * error, 0.02 * zeta)
    stiffness = float(find_preset("base").model.stiffness(0.0))
    # slow decay: the swing loses less than half in one free oscillation
    slow = np.exp(exponents[:, 0] * 2.0 * np.pi / np.sqrt(stiffness)) > 0.5
    small, _, large = TRIPLES["damping"][2]
    at = int(np.argmin(np.abs(zeta - large)))
    nearest = int(np.argmin(np.abs(zeta - small)))
    order = bool(slow[nearest] and overdamped[at])
    return Finding(
        holds=order,
        share=lengths(zeta[at:], overdamped[at:] & slow[nearest]),
        neighbourhood=f"larger damping ratios than the largest drawn, {large:g}, up to 2",
        numbers=(
            _first(zeta, overdamped),
            Number("square root of the small-signal stiffness: critical damping without voltage", stiffness**0.5),
        ),
        why=f"The order is right where the larger damping is large enough; the largest drawn ({large:g}) "
        + ("is." if overdamped[at] else "still oscillates about the flat state."),
        consequence="Any damped oscillator is overdamped beyond critical damping; the number is where that lies.",
        unseen="Where overdamping begins: at the root of the small-signal stiffness, reduced by the voltage.",
    )


def _first(zeta: Array, overdamped: Array) -> Number:
    """The smallest overdamped damping ratio, and the ratio below it."""
    meaning = "smallest overdamped damping ratio that was seen"
    if not overdamped.any():
        return Number(meaning, float("nan"))
    k = int(np.argmax(overdamped))
    return Number(meaning, float(zeta[k]), low=float(zeta[max(k - 1, 0)]), high=float(zeta[k]))
