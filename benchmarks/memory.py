"""Memory of a map: flat from 64 x 64 to 512 x 512 cells, apart from the result itself.

    python benchmarks/memory.py [SIZE ...]      (default 64 128 256 512)

Maps of a heavily damped set that comes to rest, refined, kept in a store, each by `sweep` in a process of its own; and
the same with every cell computed by an analysis that costs nothing, so that as many tasks come as in a uniform map.
Printed is the highest resident memory, the result's own, and what remains over what remains at the first size (target
1.2). Last the command `gelcone map --store --out`, which draws and writes the result too.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

MIB = 2**20
SIZES = (64, 128, 256, 512)
PROGRAM = """
import json, resource, sys
import numpy as np
from gelcone.register.analyses import find_analysis
from gelcone.atlas import sweep as module
from gelcone.atlas.plan import Plan
from gelcone.physics.model import ConeModel

size, store, uniform = int(sys.argv[1]), sys.argv[2], sys.argv[3] == "uniform"
over = {"voltage": np.linspace(0.0, 0.2, size), "prestretch": np.linspace(1.0, 1.2, size)}
model = ConeModel(damping_ratio=1.0, spring_stiffness=0.5, drive_frequency=0.3)
plan = Plan(model, over, options={"transient": 20.0, "patience": 20.0, "budget": 60.0})
if uniform:
    regime = find_analysis("regime")
    one = module.compute(Plan(model, over, options=regime.settings(plan.options)), regime, np.arange(64))
    module.compute = lambda plan, analysis, cells, keep: one.isel(member=np.arange(cells.size))
result = module.sweep(plan, store=store, coarsest=None if uniform else 33)
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(json.dumps({"peak": 1024 * peak, "result": result.nbytes, **json.loads(result.attrs["totals"])}))
"""
MAP = ["--set", "damping_ratio=1", "--set", "spring_stiffness=0.5", "--set", "drive_frequency=0.3", "--coarsest", "33"]


def measure(size: int, kind: str, folder: Path) -> dict[str, int]:
    """The sizes that a sweep of that size reports of itself."""
    command = [sys.executable, "-c", PROGRAM, str(size), str(folder / f"{kind}-{size}.zarr"), kind]
    told: dict[str, int] = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return told


def peak_of_command(size: int, folder: Path) -> int:
    """Highest resident memory of `gelcone map`, in bytes."""
    over = ["--over", f"voltage=0:0.2:{size}", "--over", f"prestretch=1:1.2:{size}"]
    rest = ["--transient", "20", "--budget", "60", "--store", str(folder / f"{size}.zarr"), "--out", str(folder / "o")]
    program = [sys.executable, "-c", "from gelcone.cli import main; main()", "map", *MAP, *over, *rest, "--force"]
    process = subprocess.Popen(program, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit("gelcone map failed")
    return 1024 * usage.ru_maxrss


def main(sizes: list[int], folder: Path) -> int:
    flat = True
    for kind in ("refined", "uniform"):
        print(f"{kind}: cells a side, cells computed, peak (MiB), result (MiB), the rest over that at {sizes[0]}")
        rests = []
        for size in sizes:
            told = measure(size, kind, folder)
            rests.append(told["peak"] - told["result"])
            share = rests[-1] / rests[0]
            flat &= share <= 1.2
            peak, result = told["peak"] / MIB, told["result"] / MIB
            print(f"  {size:4d} {told['computed']:7d} {peak:7.1f} {result:6.1f} {share:6.3f}", flush=True)
    print("gelcone map --store --out: cells a side, peak (MiB)")
    for size in (sizes[0], sizes[-1]):
        print(f"  {size:4d} {peak_of_command(size, folder) / MIB:7.1f}", flush=True)
    return int(not flat)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        sys.exit(main([int(size) for size in sys.argv[1:]] or list(SIZES), Path(place)))
