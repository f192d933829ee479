"""Branches: errors against certified bifurcations, times, and agreement with brute force.

    python benchmarks/branches.py [--runs N]      (default 976, over both sets of the source paper; 0: none)

* Every certified bifurcation of ``tests/reference/continuation.json`` that lies on the branches of the base set.
* Compilation without and with object code in the cache; processor time a point, of the period-1 branch with its events
  and of a curve in two parameters, the shortest of five.
* N settled motions over voltage, half from each set, each looked for on the branches, and stable orbits run beside:
  the contradictions, and how many of them nothing explains.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import gelcone
from gelcone.atlas.branches.branch import EventKind, Walk
from gelcone.atlas.branches.curve import Window, follow_curve
from gelcone.atlas.branches.follow import follow
from gelcone.atlas.branches.point import Metric, at_value
from gelcone.atlas.branches.switching import first_points
from gelcone.atlas.branches.varied import vary
from gelcone.presets import find_preset

REFERENCES = Path(__file__).parents[1] / "tests" / "reference" / "continuation.json"
REPETITIONS = 5
COMPILE = """
import time
from gelcone.presets import find_preset
from gelcone.atlas.branches.varied import vary
import gelcone.motion.engine.phase
model = find_preset("base").model
begin = time.perf_counter()
vary(model, {"voltage": (0.9, 2.0)}).shooting()
print(time.perf_counter() - begin)
"""


def main() -> None:
    """Runs the requested parts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=976, help="settled motions to look for, at least 8, or 0 for none")
    runs = parser.parse_args().runs
    errors()
    compilation()
    times()
    for preset, low, high in (("base", 0.5, 2.0), ("fast", 0.4, 2.0)) if runs else ():
        agreement(preset, low, high, runs // 2)


def errors() -> None:
    """The largest differences from certified values on the period-1 branch and the cascade of the base set."""
    base = find_preset("base").model
    found = [
        gelcone.continue_branch(base, "voltage", 0.935, 1.38, switch=1, checks=2),
        gelcone.continue_branch(base, "voltage", 0.9995, 1.029, start="settled", switch=5, checks=2),
    ]
    values = np.concatenate([r["event_value"].values for r in found])
    references = json.loads(REFERENCES.read_text(encoding="utf-8"))["references"]
    wanted = [r for r in references if r["key"].startswith("base/") and r["type"] not in ("orbit", "estimate")]
    worst = max(float(np.abs(values - reference["value"]).min()) for reference in wanted)
    print(f"{len(wanted)} certified bifurcations of the base set: largest error {worst:.1e}")


def compilation() -> None:
    """Seconds to the first pass once everything is imported, in new processes with an empty cache and a filled one."""
    with tempfile.TemporaryDirectory() as cache:
        took = [
            float(
                subprocess.run(
                    [sys.executable, "-c", COMPILE],
                    env=os.environ | {"GELCONE_CACHE": cache},
                    capture_output=True,
                    text=True,
                    check=True,
                ).stdout
            )
            for _ in range(2)
        ]
    print(f"compilation: {took[0]:.2f} s without cache, {took[1]:.2f} s with it")


def shortest(work: Callable[[], Any]) -> tuple[float, Any]:
    """Least processor time of several repetitions, and the result."""
    best, result = np.inf, None
    for _ in range(REPETITIONS):
        begin = time.process_time()
        result = work()
        best = min(best, time.process_time() - begin)
    return best, result


def times() -> None:
    """Processor time per point."""
    base = find_preset("base").model
    walk = Walk(0.9, 2.0)
    shooting = vary(base, {"voltage": (walk.low, walk.high)}).shooting()
    nodes = np.zeros((shooting.count, 2))
    rest = at_value(shooting, nodes, 0.93, Metric.of(nodes, walk.scale)).point
    assert rest is not None
    onset = follow(shooting, rest, Walk(0.929, 0.95), both_ways=False, resting=True).events[0]
    started = first_points(shooting, onset, walk)
    assert started is not None
    child, _, point = started
    took, branch = shortest(lambda: follow(child, point, walk, both_ways=False))
    count = len(branch.points)
    print(
        f"period-1 branch of the base set to v = 2: {count} points, {len(branch.events)} events, {took:.3f} s, "
        f"{1e3 * took / count:.2f} ms a point"
    )
    fold = next(event for event in branch.events if event.kind == EventKind.FOLD)
    over = {"voltage": (1.2, 1.5), "drive_frequency": (0.095, 0.125)}
    plane = vary(base, over).shooting().of_kind(fold.map)
    guess = fold.orbit.nodes[:: max(len(fold.orbit.nodes) // plane.count, 1)]
    if len(guess) == plane.count:
        window = Window(np.array([1.2, 0.095]), np.array([1.5, 0.125]), 1000)
        values = np.array([fold.value, 0.1])
        took, curve = shortest(lambda: follow_curve(plane, fold.kind, guess, values, fold.orbit.at, window))
        count = len(curve.points)
        print(f"curve of folds over frequency: {count} points, {took:.3f} s, {1e3 * took / count:.2f} ms a point")


def agreement(preset: str, low: float, high: float, runs: int) -> None:
    """Settled motions of one set over voltage, searched on its branches."""
    begin = time.process_time()
    model = find_preset(preset).model
    result = gelcone.continue_branch(model, "voltage", low, high, checks=-(-runs // 2))
    unexplained = [k for k in range(result.sizes["flag"]) if not str(result["flag_explanation"][k].values)]
    run, cycles, orbits = result.sizes["run"], int(result["checked_cycles"]), int(result["checked_orbits"])
    print(
        f"set {preset}, voltage {low:g} to {high:g}, {time.process_time() - begin:.0f} s: {run} runs, {cycles} cycles"
    )
    print(
        f"  on {result.sizes['branch']} branches, {int(result['seeded'])} of them from cycles; {orbits} stable orbits"
    )
    print(f"  run beside; {result.sizes['flag']} contradictions, {len(unexplained)} unexplained")
    for k in unexplained:
        print(f"  branch {int(result['flag_branch'][k])}, voltage {float(result['flag_value'][k]):.6g}")


if __name__ == "__main__":
    main()
