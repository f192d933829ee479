"""Speed ratios measured in one run, each from the fastest of several interleaved repetitions.

    python benchmarks/speed.py [REPETITIONS] [--against SOURCE]      (default 5)

* An ensemble through `gelcone.integrate` against the same work in a bare loop over a hand-written heyoka integrator.
* Two threads against one, beside what two threads of bare loops gain on this machine.
* SciPy's LSODA (compiled Fortran, called with `scipy.integrate.odeint`) member by member against `integrate` at a
  tolerance at which its error is no larger.
* The time from the shell to the prompt: ``gelcone --help``, ``import gelcone``, a first ``gelcone simulate``.

``--against SOURCE`` compares with another version instead, whose ``src`` folder that is: a process each, which take
turns, one thread, processor time. The ratio of the shortest is printed for states, tangents, exponents, and the regimes
of 9 x 9 cells of the base set.
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from heyoka_backend import LANES, import_heyoka
from scipy.integrate import odeint

from gelcone.codes import Outcome
from gelcone.motion.flow import integrate
from gelcone.physics.model import ConeModel

MEMBERS = 512
PERIODS = 200


def ensemble(count: int) -> ConeModel:
    """Members with different stiffness, voltage, frequency and pre-stretch."""
    rng = np.random.default_rng(512)
    return ConeModel(
        damping_ratio=rng.uniform(0.01, 0.1, count),
        spring_stiffness=rng.uniform(0.5, 2.0, count),
        voltage=rng.uniform(0.2, 1.2, count),
        drive_frequency=rng.uniform(0.5, 1.5, count),
        stretch_limit=rng.uniform(5.0, 50.0, count),
        hoop_prestretch=rng.uniform(1.0, 1.3, count),
        rest_height=rng.uniform(0.0, 0.2, count),
    )


def sample_times(model: ConeModel, periods: int) -> np.ndarray:
    return model.drive_period[:, None] * np.arange(periods + 1)


def numbers(model: ConeModel) -> np.ndarray:
    """Inputs of the equations below, (numbers, members): zeta, kappa, x0, A, B, G, J, v, omega."""
    members = model.members()
    kept = [members.number(name) for name in ("damping_ratio", "spring_stiffness", "rest_height", "A", "B", "G")]
    driven = [members.number(name) for name in ("voltage", "drive_frequency")]
    return np.stack([*kept, np.broadcast_to(model.stretch_limit, model.shape), *driven])


# --- the bare loop ----------------------------------------------------------------------------------------------------


def hand_written() -> object:
    """One batch integrator of the equation of motion as one would write it down for this ensemble."""
    hk = import_heyoka()
    x, u = hk.make_vars("x", "u")
    zeta, kappa, rest, A, B, G, J, v, omega = (hk.par[i] for i in range(9))
    q = 1.0 + x * x
    qq = q * q
    film = J * (A * qq - G) / (q * (q * (J + 3.0 - B) - A * qq - G))
    drive = 0.5 * v * v * (1.0 - hk.cos(2.0 * omega * hk.time))
    rate = kappa * rest - 2.0 * zeta * u + x * (drive - kappa - film)
    return hk.taylor_adaptive_batch([(x, u), (u, rate)], np.zeros((2, LANES)), tol=1e-15)


def bare_loop(integrator: object, model: ConeModel, initial: tuple[float, float], times: np.ndarray) -> np.ndarray:
    """All members, a batch at a time."""
    table = numbers(model)
    states = np.empty((*times.shape, 2))
    for first in range(0, model.size, LANES):
        members = slice(first, first + LANES)
        integrator.set_time(0.0)
        integrator.pars[:] = table[:, members]
        integrator.state[:] = np.array(initial)[:, None]
        grid = np.ascontiguousarray(times[members].T)
        states[members] = integrator.propagate_grid(grid)[-1].transpose(2, 0, 1)
    return states


# --- LSODA ------------------------------------------------------------------------------------------------------------


def lsoda(model: ConeModel, initial: tuple[float, float], times: np.ndarray, tolerance: float) -> np.ndarray:
    """All members, one at a time."""
    table = numbers(model).T.tolist()

    def rate(state, t, zeta, kappa, rest, A, B, G, J, v, omega):
        x, u = state
        q = 1.0 + x * x
        qq = q * q
        film = J * (A * qq - G) / (q * (q * (J + 3.0 - B) - A * qq - G))
        sine = v * math.sin(omega * t)
        return u, kappa * rest - 2.0 * zeta * u + x * (sine * sine - kappa - film)

    return np.stack(
        [
            odeint(rate, initial, times[i], args=tuple(table[i]), rtol=tolerance, atol=tolerance, mxstep=100_000)
            for i in range(model.size)
        ]
    )


# --- the clock --------------------------------------------------------------------------------------------------------


def fastest(repetitions: int, *works: Callable[[], object]) -> list[float]:
    """Smallest wall time of each of the works, run in turn."""
    seconds = [math.inf] * len(works)
    for _ in range(repetitions):
        for k, work in enumerate(works):
            begin = time.perf_counter()
            work()
            seconds[k] = min(seconds[k], time.perf_counter() - begin)
    return seconds


def report(what: str, ratio: float, target: str) -> None:
    print(f"{what:68s} {ratio:8.2f}   target {target}", flush=True)


def ensemble_against_bare_loop(repetitions: int) -> None:
    model, initial = ensemble(MEMBERS), (0.5, 0.0)
    times = sample_times(model, PERIODS)
    integrator = hand_written()
    run = integrate(model, initial, times, threads=1)
    np.testing.assert_allclose(run.states, bare_loop(integrator, model, initial, times), atol=1e-6)
    assert (run.outcome == Outcome.OK).all()
    mine, bare = fastest(
        repetitions,
        lambda: integrate(model, initial, times, threads=1),
        lambda: bare_loop(integrator, model, initial, times),
    )
    print(f"{MEMBERS} members over {PERIODS} drive periods: {mine:.3f} s, {mine / MEMBERS / PERIODS * 1e6:.2f} us each")
    report("integrate over the bare loop, one thread", mine / bare, "<= 1.15")


def one_thread_against_two(repetitions: int) -> None:
    """A short run, often: on a machine that others use, too, both cores are free at the same time only now and then."""
    model, initial = ensemble(MEMBERS // 2), (0.5, 0.0)
    times = sample_times(model, PERIODS // 2)
    halves = [np.arange(model.size // 2), np.arange(model.size // 2, model.size)]
    bare = [(hand_written(), model.take(half), initial, times[half]) for half in halves]

    def side_by_side() -> None:
        threads = [threading.Thread(target=bare_loop, args=arguments) for arguments in bare]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    one, two, bare_one, bare_two = fastest(
        8 * repetitions,
        lambda: integrate(model, initial, times, threads=1),
        lambda: integrate(model, initial, times, threads=2),
        lambda: [bare_loop(*arguments) for arguments in bare],
        side_by_side,
    )
    report("integrate, one thread over two", one / two, ">= 1.8")
    report("bare loops, one thread over two: what the machine gives", bare_one / bare_two, "(none)")


def lsoda_against_ensemble(repetitions: int, tolerance: float = 1e-10) -> None:
    model, initial, count = ensemble(MEMBERS), (0.5, 0.0), 16
    times = sample_times(model, 20)
    few = model.take(np.arange(count))
    exact = integrate(few, initial, times[:count]).states
    theirs = np.abs(lsoda(few, initial, times[:count], tolerance) - exact).max()
    for mine in 10.0 ** -np.arange(5.0, 16.0):
        error = np.abs(integrate(few, initial, times[:count], tolerance=mine).states - exact).max()
        if error <= theirs:
            break
    print(f"LSODA at {tolerance:.0e} has the error {theirs:.1e}; integrate at {mine:.0e} has {error:.1e}")
    one, all_ = fastest(
        repetitions,
        lambda: lsoda(few, initial, times[:count], tolerance),
        lambda: integrate(model, initial, times, tolerance=mine, threads=1),
    )
    report("LSODA over integrate, per member, one thread", (one / count) / (all_ / MEMBERS), ">= 50")


def shell(*arguments: str, **environment: str) -> Callable[[], object]:
    command = [sys.executable, *arguments]
    return lambda: subprocess.run(command, check=True, capture_output=True, env={**os.environ, **environment})


def from_the_shell(repetitions: int) -> None:
    simulate = ("-m", "gelcone", "simulate", "paper-table1", "--json")
    with tempfile.TemporaryDirectory() as folder:
        fresh = (str(number) for number in range(10**6))
        nothing, importing, help_, warm, cold, drawn = fastest(
            repetitions,
            shell("-c", "pass"),
            shell("-c", "import gelcone"),
            shell("-m", "gelcone", "--help"),
            shell(*simulate),
            lambda: shell(*simulate, GELCONE_CACHE=f"{folder}/{next(fresh)}")(),
            lambda: shell(*simulate, "--out", f"{folder}/{next(fresh)}")(),
        )
    print(f"seconds from the shell; of these {nothing:.3f} are Python's own start")
    report("import gelcone", importing, "(none)")
    report("gelcone --help", help_, "<= 0.4")
    report("gelcone simulate, compiled programs in the cache", warm, "<= 1.5")
    report("gelcone simulate, cache empty", cold, "<= 1.5")
    report("gelcone simulate --out, with netCDF and figure", drawn, "<= 3")


# --- another version --------------------------------------------------------------------------------------------------

PROGRAM = """
import sys, time
import numpy as np
from gelcone import ConeModel, integrate, lyapunov, regime

rng = np.random.default_rng(512)
names = {"spring_stiffness": (0.5, 2.0), "voltage": (0.2, 1.2), "drive_frequency": (0.5, 1.5), "prestretch": (1.0, 1.3)}
model = ConeModel(**{name: rng.uniform(*bounds, 128) for name, bounds in names.items()})
grid = {"voltage": np.linspace(0.0, 2.0, 9)[:, None], "prestretch": np.linspace(0.4, 2.0, 9)}
base = ConeModel(damping_ratio=0.01, spring_stiffness=0.9, drive_frequency=0.1, **grid)
times = model.drive_period[:, None] * np.arange(101)
for line in sys.stdin:
    what, tolerance = line.split()
    options = {"tolerance": float(tolerance), "threads": 1}
    begin = time.process_time()
    if what == "exponents":
        lyapunov(model, **options)
    elif what == "regimes":
        regime(base, **options)
    else:
        integrate(model, (0.5, 0.0), times, keep=what, **options)
    print(time.process_time() - begin, flush=True)
"""
WORKS = ("states 1e-15", "states 1e-10", "tangents 1e-15", "tangents 1e-10", "exponents 1e-15", "regimes 1e-15")


def against(source: Path, repetitions: int) -> None:
    """Prints the time of each of `WORKS` here and with another version; the first turn also compiles."""

    def start(path: Path) -> subprocess.Popen[str]:
        environment = {**os.environ, "PYTHONPATH": str(path.resolve(strict=True))}
        command, pipe = [sys.executable, "-c", PROGRAM], subprocess.PIPE
        return subprocess.Popen(command, env=environment, stdin=pipe, stdout=pipe, text=True)

    def seconds(process: subprocess.Popen[str], work: str) -> float:
        print(work, file=process.stdin, flush=True)
        return float(process.stdout.readline())

    with start(Path(__file__).parents[1] / "src") as mine, start(source) as other:
        for work in WORKS:
            turns = [[seconds(process, work) for process in (mine, other)] for _ in range(repetitions + 1)]
            here, there = np.min(turns, axis=0)
            report(f"{work}: {here:.3f} s over {there:.3f} s of the other version", here / there, "<= 1.05")


def main(repetitions: int) -> None:
    ensemble_against_bare_loop(repetitions)
    one_thread_against_two(repetitions)
    lsoda_against_ensemble(repetitions)
    from_the_shell(repetitions)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("repetitions", nargs="?", type=int, default=5)
    parser.add_argument("--against", type=Path, metavar="SOURCE")
    given = parser.parse_args()
    if given.against:
        against(given.against, given.repetitions)
    else:
        main(given.repetitions)
