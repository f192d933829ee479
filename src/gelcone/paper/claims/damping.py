"""What the paper claims about damping."""

from __future__ import annotations

import numpy as np

from gelcone.paper.claims.claim import Studies, claim
from gelcone.paper.numbers import Number
from gelcone.paper.reading import finite_positive, fixed_branch, regular
from gelcone.paper.studies.diagrams import PANELS
from gelcone.paper.studies.triples import TRIPLES
from gelcone.paper.truths import every, share
from gelcone.paper.verdicts import NEARLY_ALL, Finding
from gelcone.presets import find_preset

SMALLEST_ERROR = 1e-6
"""Below this an error of the exponents says no more than their rounding."""


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
    calm = share(regular(base)[damped])
    rows = wide["voltage"].values
    own = int(np.argmin(np.abs(rows - PANELS["base", "damping_ratio"])))
    by_voltage = {float(v): share(regular(wide.sel(voltage=v))) for k, v in enumerate(rows) if k != own}
    never = {v: None if calm.failing == 0 and calm.open else calm.failing == 0 for v, calm in by_voltage.items()}
    undamped = base.isel(damping_ratio=0)
    return Finding(
        holds=every(calm.failing == 0, calm.exceeds(NEARLY_ALL) if calm.open else True),
        holds_finite=bool(not finite_positive(base)[damped].any()),
        share=share(list(never.values())),
        neighbourhood="other drive voltages from 0.5 to 2, each over damping ratios from 0.02 to 2",
        numbers=(
            calm.number("share of damping ratios in (0, 2] without chaos"),
            Number(
                "largest exponent without damping",
                float(undamped["lyapunov"].values[0]),
                error=float(undamped["standard_error"].values[0]),
            ),
            Number(
                "largest drive voltage without chaos at any damping ratio",
                max([v for v, ok in never.items() if ok], default=float("nan")),
                error=float(np.diff(rows)[0]),
            ),
        ),
        why="At this voltage rest is stable and attracts every motion; at a higher one little damping leaves chaos.",
        unseen="That the statement concerns the chosen voltage: it lies below the loss of stability of rest. "
        "Without damping the exponent over a window T falls like log(T)/T, which looks slightly positive in any "
        "window.",
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
    error = np.maximum(base["standard_error"].values[:, 0], SMALLEST_ERROR)
    # Overdamped motion has two real decay rates; oscillating motion has -zeta twice.
    overdamped = exponents[:, 0] - exponents[:, 1] > np.maximum(6.0 * error, 0.02 * zeta)
    stiffness = float(find_preset("base").model.stiffness(0.0))
    # Slow: in one free oscillation the swing loses less than half.
    slow = np.exp(exponents[:, 0] * 2.0 * np.pi / np.sqrt(stiffness)) > 0.5
    small, _, large = TRIPLES["damping"][2]
    at = int(np.argmin(np.abs(zeta - large)))
    nearest = int(np.argmin(np.abs(zeta - small)))
    others = (zeta >= large) & (np.arange(zeta.size) != at)
    order = bool(slow[nearest] and overdamped[at])
    return Finding(
        holds=order,
        share=share(overdamped[others] & slow[nearest]),
        neighbourhood=f"larger damping ratios than the largest drawn, {large:g}, up to 2",
        numbers=(
            Number(
                "smallest overdamped damping ratio on the grid",
                float(zeta[overdamped].min()) if overdamped.any() else float("nan"),
                error=float(np.diff(zeta)[0]),
            ),
            Number("square root of the small-signal stiffness: critical damping without voltage", stiffness**0.5),
        ),
        why=f"The order is right where the larger damping is large enough; the largest drawn ({large:g}) "
        + ("is." if overdamped[at] else "still oscillates about the flat state."),
        consequence="Any damped oscillator is overdamped beyond critical damping; the number is where that lies.",
        unseen="Where overdamping begins: at the root of the small-signal stiffness, reduced by the voltage.",
    )
