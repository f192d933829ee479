"""Cost of a map's cell: the share of Python, the gain from threads and processes, and the time of another version.

    python benchmarks/cells.py [VOLTAGES] [PRESTRETCHES] [--turns N] [--against SOURCE]

The uniform map of the base set over voltage (0 to 2) and pre-stretch (0.4 to 2); default 101 by 81 cells. Times of one
thread are processor time, so that a busy machine tells the same; those of several are wall time and need free cores.
Works that are compared run in turn, and the shortest of each counts. ``--against`` takes another version's sources, 0.1
included, for the same map on one thread.

Last, `gelcone simulate` from the shell, its modules compiled before as after an installation: without and with compiled
programs in the cache. Targets: Python at most 20 %; three times 0.1; two threads 1.85 times one, two processes 1.9;
cold start 1.5 s.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from gelcone import integrate
from gelcone.atlas.plan import Plan
from gelcone.atlas.processes import processes
from gelcone.atlas.sweep import sweep
from gelcone.atlas.workers import Workers, threads
from gelcone.motion.engine.machine_code import Compiled
from gelcone.physics.model import ConeModel
from gelcone.presets import find_preset

SOURCE = Path(__file__).parents[1] / "src"
ONE_MAP = """
import sys, time
import numpy as np
import gelcone
made = getattr(gelcone, "map", None) or gelcone.parameter_map
base = gelcone.ConeModel(damping_ratio=0.01, spring_stiffness=0.9, drive_frequency=0.1)
def run(voltages, prestretches):
    over = {"voltage": np.linspace(0.0, 2.0, voltages), "prestretch": np.linspace(0.4, 2.0, prestretches)}
    made(base, over, (1.0, 0.0), threads=1)
run(3, 3)
for line in sys.stdin:
    begin = time.process_time()
    run(*map(int, line.split()))
    print(time.process_time() - begin, flush=True)
"""


def plan_of(voltages: int, prestretches: int) -> Plan:
    """The base set's uniform map."""
    preset = find_preset("base")
    over = {"voltage": np.linspace(0.0, 2.0, voltages), "prestretch": np.linspace(0.4, 2.0, prestretches)}
    return Plan(preset.model, over, preset.initial)


def share_of_python(plan: Plan) -> None:
    """Processor time of a map on one thread, and of the compiled loop in it."""
    inside = 0.0
    calls = Compiled.__init__

    def counted(self: Compiled, *given: object) -> None:
        calls(self, *given)
        advance = self.advance

        def timed(*arguments: object) -> int:
            nonlocal inside
            begin = time.thread_time()
            steps: int = advance(*arguments)
            inside += time.thread_time() - begin
            return steps

        self.advance = timed

    Compiled.__init__ = counted  # before any program is compiled
    sweep(plan_of(9, 7), workers=threads(1))
    inside, begin = 0.0, time.process_time()
    sweep(plan, workers=threads(1))
    took = time.process_time() - begin
    Compiled.__init__ = calls
    print(f"map of {plan.size} cells: {1e3 * took / plan.size:.2f} ms a cell, {100 * (1 - inside / took):.1f} % Python")


def shortest(turns: int, *works: Callable[[], object]) -> list[float]:
    """Shortest wall time of each of the works, run in turn."""
    taken = np.full((turns, len(works)), np.inf)
    for turn in taken:
        for k, work in enumerate(works):
            begin = time.perf_counter()
            work()
            turn[k] = time.perf_counter() - begin
    return taken.min(axis=0).tolist()


def two_over_one(plan: Plan, turns: int) -> None:
    """Two threads and two processes, each from when its workers are there; and two threads of the integrator alone."""

    def mapped(workers: Workers) -> Callable[[], object]:
        return lambda: sweep(plan, workers=workers)

    rng = np.random.default_rng(512)
    bounds = {"spring_stiffness": (0.5, 2.0), "voltage": (0.2, 1.2), "drive_frequency": (0.5, 1.5)}
    model = ConeModel(**{name: rng.uniform(*ends, 1024) for name, ends in bounds.items()})
    times = model.drive_period[:, None] * np.arange(1, 51)

    def integrated(keep: str, count: int) -> Callable[[], object]:
        return lambda: integrate(model, (0.5, 0.0), times, keep=keep, threads=count)

    for name, one, two in (
        ("map, two threads over one", mapped(threads(1)), mapped(threads(2))),
        ("map, two processes over one", mapped(processes(1)), mapped(processes(2))),
        ("states, two threads over one", integrated("states", 1), integrated("states", 2)),
        ("tangents, two threads over one", integrated("tangents", 1), integrated("tangents", 2)),
    ):
        slow, fast = shortest(turns, one, two)
        print(f"{name}: {slow / fast:.2f} ({fast:.2f} s, not {slow:.2f} s)", flush=True)


def against(source: Path, plan: Plan, turns: int) -> None:
    """The same map with this version and another one."""

    def start(path: Path) -> subprocess.Popen[str]:
        pipe, found = subprocess.PIPE, os.environ | {"PYTHONPATH": str(path.resolve(strict=True))}
        return subprocess.Popen([sys.executable, "-c", ONE_MAP], env=found, stdin=pipe, stdout=pipe, text=True)

    def seconds(process: subprocess.Popen[str]) -> float:
        print(*plan.shape, file=process.stdin, flush=True)
        return float(process.stdout.readline())

    with start(SOURCE) as mine, start(source) as other:
        here, there = np.min([[seconds(process) for process in (mine, other)] for _ in range(turns)], axis=0)
    print(f"map of {plan.size} cells: {here:.2f} s, {there / here:.2f} times faster than {there:.2f} s of {source}")


def from_the_shell(turns: int) -> None:
    """Wall and processor seconds of `gelcone simulate`, with an empty cache and with a filled one."""
    with tempfile.TemporaryDirectory() as folder:
        modules = {"PYTHONPYCACHEPREFIX": f"{folder}/modules", "PYTHONDONTWRITEBYTECODE": "", "PYTHONPATH": str(SOURCE)}

        def simulated(cache: str) -> list[float]:
            begin, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
            command = [sys.executable, "-m", "gelcone", "simulate", "paper-table1", "--json"]
            environment = os.environ | modules | {"GELCONE_CACHE": f"{folder}/{cache}"}
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=environment)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            return [time.perf_counter() - begin, spent]

        simulated("warm")
        for name, caches in (("empty", [f"cold{turn}" for turn in range(turns)]), ("filled", ["warm"] * turns)):
            wall, processor = np.min([simulated(cache) for cache in caches], axis=0)
            print(f"gelcone simulate, cache {name}: {wall:.2f} s, of the processor {processor:.2f} s", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("voltages", nargs="?", type=int, default=101)
    parser.add_argument("prestretches", nargs="?", type=int, default=81)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--against", type=Path, metavar="SOURCE")
    given = parser.parse_args()
    wanted = plan_of(given.voltages, given.prestretches)
    share_of_python(wanted)
    two_over_one(wanted, given.turns)
    if given.against:
        against(given.against, wanted, given.turns)
    from_the_shell(given.turns)
