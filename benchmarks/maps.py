"""Refined maps: work saved, features missed, and growth of the work, for the base set over voltage and pre-stretch.

    python benchmarks/maps.py [POINTS] [MODE] [SAMPLE]   (default 65, that is 64 cells and one a side; radial; 4,096)

The uniform map of POINTS by POINTS cells (a power of 2 and one, so that grids nest) stands beside the refined one: all
of its cells, or where it has more than SAMPLE, so many drawn at random, which give its work and its regimes with a
standard error. Printed are the integrator steps of both and their ratio (target 10 at 512), the share of cells whose
regime differs (target at most 0.5 %), and the borders' dimension. Then the refinement is replayed on the nested grids,
and the exponent with which its work grows is fitted: 1 for smooth borders, 2 for a uniform map. The work of a cell is
there the time that was integrated for it. Last a uniform map on one thread and on two (target 1.85), and by one process
and two (target 1.8), each from when its workers are there, the shortest of three turns.
"""

from __future__ import annotations

import json
import sys
from dataclasses import replace

import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter

from gelcone.atlas.plan import Plan
from gelcone.atlas.processes import processes
from gelcone.atlas.refinement import refine
from gelcone.atlas.sweep import compute, sweep
from gelcone.atlas.workers import threads
from gelcone.presets import find_preset
from gelcone.progress import Watch, watching
from gelcone.register.analyses import find_analysis

COARSEST = 16
SMALLEST = 17
SAMPLE = 4096
BATCH = 64
TURNS = 3


def replayed(kinds: np.ndarray) -> np.ndarray:
    """The cells of a grid of known kinds that the refinement computes."""
    wanted, computed = refine(kinds.shape, COARSEST), np.zeros(kinds.shape, dtype=bool)
    cells = next(wanted)
    while True:
        computed.flat[cells] = True
        try:
            cells = wanted.send(kinds.flat[cells])
        except StopIteration:
            return computed


def sampled(plan: Plan, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Regimes of some cells, and the integrator steps that each batch of `BATCH` of them takes."""
    regimes, steps = [], []
    regime = find_analysis("regime")
    plan = replace(plan, options=regime.settings(plan.options))
    for batch in np.split(cells, np.arange(BATCH, cells.size, BATCH)):
        watch = Watch()
        with watching(watch):
            regimes.append(compute(plan, regime, batch)["regime"].values)
        steps.append(watch.steps)
    return np.concatenate(regimes), np.array(steps)


def main(points: int, mode: str, sample: int) -> None:
    preset = find_preset("base")
    over = {"voltage": np.linspace(0.0, 2.0, points), "prestretch": np.linspace(0.4, 2.0, points)}
    plan = Plan(preset.model.replace(prestretch_mode=mode), over, preset.initial)
    refined = sweep(plan, coarsest=COARSEST)
    totals = json.loads(refined.attrs["totals"])
    print(f"base, {mode} pre-stretch, {points} x {points} cells, coarsest lattice {COARSEST}")
    print(f"  refined: {totals['computed']} of {plan.size} cells computed, {totals['integrator_steps']:.3e} steps")
    if totals["border_dimension"]:
        print("  borders of dimension {:.2f} +- {:.2f}".format(*totals["border_dimension"]))
    cells = np.random.default_rng(0).permutation(plan.size)[: min(sample, plan.size) // BATCH * BATCH]
    regimes, steps = sampled(plan, cells)
    known = refined["regime"].values
    border = maximum_filter(known, 3) != minimum_filter(known, 3)
    differs = regimes != known.flat[cells]
    whole = steps.mean() / BATCH * plan.size
    error = steps.std() / np.sqrt(steps.size) / steps.mean()
    print(
        f"  uniform, {cells.size} cells: {whole:.3e} steps (+- {100 * error:.1f} %), "
        f"{whole / totals['integrator_steps']:.2f} times those of the refined map (target 10 at 512)"
    )
    print(
        f"  another regime: {100 * differs.mean():.2f} +- {100 * np.sqrt(differs.mean() / cells.size):.2f} % of them "
        f"(target 0.5), {(differs & ~border.flat[cells]).sum()} cells of {differs.sum()} off the refined map's borders"
    )
    kinds = 3 * known.astype(int) + refined["sign"].values
    work = (refined["settled_time"] + refined["averaged_time"]).values
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
    for who, start, target in (("threads", threads, 1.85), ("processes", processes, 1.8)):
        turns = [
            [json.loads(sweep(few, workers=start(count)).attrs["totals"])["wall_time_s"] for count in (1, 2)]
            for _ in range(TURNS)
        ]
        one, two = np.min(turns, axis=0)
        print(f"  two {who} {one / two:.2f} times as fast as one: {two:.1f} s, not {one:.1f} s (target {target})")


if __name__ == "__main__":
    given = dict(enumerate(sys.argv))
    main(int(given.get(1, 65)), given.get(2, "radial"), int(given.get(3, SAMPLE)))
