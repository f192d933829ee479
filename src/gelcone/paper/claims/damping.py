"""What the paper claims about damping."""

from __future__ import annotations

import numpy as np

from gelcone.paper.claims.claim import Studies, claim
from gelcone.paper.reading import chaotic, finite_positive, fixed_branch, share, share_number
from gelcone.paper.verdicts import Finding, Number
from gelcone.presets import find_preset


@claim(
    "damping-never-chaotic",
    "Over damping ratios from 0 to 2 no motion is chaotic; the exponent is slightly positive only towards zero.",
    13,
    "diagram-base-damping-ratio",
    "diagram-fast-damping-ratio",
    "damping-map",
)
def damping_never_chaotic(studies: Studies) -> Finding:
    base = fixed_branch(studies["diagram-base-damping-ratio"])
    wide = studies["damping-map"]
    damped = base["damping_ratio"].values > 0.0
    regular = ~chaotic(base)
    by_voltage = {float(v): ~chaotic(wide.sel(voltage=v)).any() for v in wide["voltage"].values}
    undamped = base.isel(damping_ratio=0)
    return Finding(
        holds=bool(regular[damped].all()),
        holds_finite=bool(not finite_positive(base)[damped].any()),
        share=share(list(by_voltage.values())),
        neighbourhood="drive voltages from 0.5 to 2, each over damping ratios from 0.02 to 2",
        numbers=(
            share_number("share of damping ratios in (0, 2] without chaos", regular[damped]),
            Number(
                "largest exponent without damping",
                float(undamped["lyapunov"].values[0]),
                error=float(undamped["standard_error"].values[0]),
            ),
            Number(
                "largest drive voltage without chaos at any damping ratio",
                max([v for v, ok in by_voltage.items() if ok], default=float("nan")),
                error=float(np.diff(wide["voltage"].values)[0]),
            ),
        ),
        why="At this voltage rest is stable and attracts every motion; at a higher one little damping leaves chaos.",
        unseen="That the statement concerns the chosen voltage: it lies below the loss of stability of rest. "
        "Without "
        "damping the exponent over a window T falls like log(T)/T, which looks slightly positive in any window.",
    )


@claim(
    "damping-order",
    "Small damping gives slow decay, large damping an overdamped return.",
    4,
    "diagram-base-damping-ratio",
)
def damping_order(studies: Studies) -> Finding:
    base = fixed_branch(studies["diagram-base-damping-ratio"])
    base = base.sel(damping_ratio=base["damping_ratio"] > 0.0)
    zeta, exponents = base["damping_ratio"].values, base["lyapunov"].values
    error = np.maximum(base["standard_error"].values[:, 0], 1e-6)
    # Overdamped motion has two real decay rates; oscillating motion has -zeta twice.
    overdamped = exponents[:, 0] - exponents[:, 1] > np.maximum(6.0 * error, 0.02 * zeta)
    stiffness = float(find_preset("base").model.stiffness(0.0))
    first = zeta[overdamped].min() if overdamped.any() else float("nan")
    slow = bool((exponents[zeta < 0.3, 0] < 0.0).all())
    at_largest_drawn = bool(np.interp(0.5, zeta, overdamped.astype(float)) > 0.5)
    return Finding(
        holds=slow and at_largest_drawn,
        holds_finite=slow and at_largest_drawn,
        share=share(overdamped),
        neighbourhood="damping ratios up to 2",
        numbers=(
            Number("smallest overdamped damping ratio on the grid", float(first), error=float(np.diff(zeta)[0])),
            Number(
                "square root of the small-signal stiffness: critical damping without voltage", stiffness**0.5, error=0.0
            ),
        ),
        why="The order is right, but the largest damping ratio drawn (0.5) still oscillates about the flat state.",
        unseen="Where overdamping begins: at the root of the small-signal stiffness, reduced by the voltage.",
    )
