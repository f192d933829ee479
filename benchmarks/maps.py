"""What a refined map saves, what it misses, and how its work grows: the base set over voltage and pre-stretch.

    python benchmarks/maps.py [POINTS] [MODE]      (default 65, that is 64 cells and one a side; radial)

The uniform map of POINTS by POINTS cells (a power of 2 and one, so that grids nest) is computed with the refined one:
integrator steps of both and their ratio (target 10 at 512), cells whose regime differs (target at most 0.5 %), and how
many of those lie away from every border of the uniform map. Then the refinement is replayed on the nested grids, and
the exponent with which its work grows is fitted: 1 for smooth borders, 2 for a uniform map. The work of a cell is there
the time that was integrated for it. Last a uniform map on one thread and on two (target 1.85), and by one process and
two (target 1.8), each from when its workers are there.
"""

from __future__ import annotations

import json
import sys

import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter

from gelcone.atlas.cells import Plan
from gelcone.atlas.refinement import refine
from gelcone.atlas.survey import survey
from gelcone.atlas.workers import cluster, threads
from gelcone.paper.presets import find_preset

COARSEST = 16
SMALLEST = 17


def replayed(kinds: np.ndarray) -> np.ndarray:
    """Which cells of a grid of known kinds the refinement computes."""
    wanted, computed = refine(kinds.shape, COARSEST), np.zeros(kinds.shape, dtype=bool)
    cells = next(wanted)
    while True:
        computed.flat[cells] = True
        try:
            cells = wanted.send(kinds.flat[cells])
        except StopIteration:
            return computed


def main(points: int, mode: str) -> None:
    preset = find_preset("base")
    over = {"voltage": np.linspace(0.0, 2.0, points), "prestretch": np.linspace(0.4, 2.0, points)}
    plan = Plan(preset.model.replace(prestretch_mode=mode), over, preset.initial)
    uniform, refined = survey(plan), survey(plan, coarsest=COARSEST)
    steps = [json.loads(result.attrs["totals"])["integrator_steps"] for result in (uniform, refined)]
    regime = uniform["regime"].values
    differs = regime != refined["regime"].values
    border = maximum_filter(regime, 3) != minimum_filter(regime, 3)
    computed = json.loads(refined.attrs["totals"])["computed"]
    print(f"base, {mode} pre-stretch, {points} x {points} cells, coarsest lattice {COARSEST}")
    print(
        f"  steps: uniform {steps[0]:.3e}, refined {steps[1]:.3e}, ratio {steps[0] / steps[1]:.2f} (target 10 at 512)"
    )
    print(f"  cells computed {computed} of {regime.size}; at a border of the uniform map {100 * border.mean():.1f} %")
    print(f"  another regime: {100 * differs.mean():.2f} % (<= 0.5), of them {(differs & ~border).sum()} off a border")
    kinds = 3 * regime.astype(int) + uniform["sign"].values
    work = (uniform["settled_time"] + uniform["averaged_time"]).values
    sizes, spent = [], []
    while (stride := 2 ** len(sizes)) <= (points - 1) // (SMALLEST - 1):
        part = np.s_[::stride, ::stride]
        sizes.append((points - 1) // stride)
        spent.append(work[part][replayed(kinds[part])].sum() / work[part].mean())
        saved = sizes[-1] ** 2 / spent[-1]
        print(f"  {sizes[-1]:4d} cells a side: work of {spent[-1]:8.0f} cells, {saved:.2f} times less")
    if len(sizes) > 1:
        print(f"  work grows with the power {np.polyfit(np.log(sizes), np.log(spent), 1)[0]:.2f} of the cells a side")
    few = Plan(
        plan.model, {name: values[:: max(1, (points - 1) // 32)] for name, values in over.items()}, preset.initial
    )
    for who, start, target in (("threads", threads, 1.85), ("processes", cluster, 1.8)):
        one, two = (json.loads(survey(few, workers=start(count)).attrs["totals"])["wall_time_s"] for count in (1, 2))
        print(f"  two {who} {one / two:.2f} times as fast as one: {two:.1f} s, not {one:.1f} s (target {target})")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 65, sys.argv[2] if len(sys.argv) > 2 else "radial")
