"""The engine against heyoka at equal error: states and tangents of the cone, one thread, interleaved minima.

    python benchmarks/engine.py [TURNS]

For each tolerance, both errors are those of the sampled states (and tangents) against heyoka in extended precision; the
times are the shortest of TURNS (default 8) rounds, in which both take turns. A ratio of times is stated at equal error:
a difference of the errors is accounted for by how heyoka's time changes with its error.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import heyoka as hk
import numpy as np

from gelcone.motion.engine.program import Program

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "motion" / "engine"))
from engine_systems import Cone, cone_numbers

TOLERANCES = (1e-6, 1e-10, 1e-14)
LANES = 8
MEMBERS = 256
FEW = 64
"""Members over which the errors are averaged (geometric mean of each one's largest)."""


def equations(keep: str) -> list[tuple[Any, Any]]:
    """The cone as heyoka takes it, with tangents that share the film's division."""
    cone = Cone()
    n = {name: hk.par[i] for i, name in enumerate(cone.numbers)}
    x, u = hk.make_vars("x", "u")
    rates, slopes = cone.flow(hk.time, (x, u), n, hk)
    system = [(x, rates[0]), (u, rates[1])]
    if keep == "tangents":
        for column in "12":
            dx, du = hk.make_vars("x" + column, "u" + column)
            system += [(dx, du), (du, slopes[1][0] * dx + slopes[1][1] * du)]
    return system


class Peer:
    """heyoka's batch integrator, eight members at a time."""

    def __init__(self, keep: str, tolerance: float) -> None:
        self.keep = keep
        system = equations(keep)
        self.size = len(system)
        self.integrator = hk.taylor_adaptive_batch(system, np.zeros((self.size, LANES)), tol=tolerance)

    def run(self, values: np.ndarray, times: np.ndarray) -> np.ndarray:
        """States at ``times`` (samples,) for parameters (numbers, members); shape (members, samples, variables)."""
        integrator, members = self.integrator, values.shape[1]
        result = np.empty((members, times.size, self.size))
        grid = np.repeat(np.concatenate([[0.0], times])[:, None], LANES, axis=1)
        for first in range(0, members, LANES):
            part = slice(first, first + LANES)
            integrator.set_time(0.0)
            integrator.pars[:] = values[:, part]
            integrator.state[:] = 0.0
            integrator.state[0] = 1.0
            if self.keep == "states":
                result[part] = np.moveaxis(integrator.propagate_grid(grid)[-1][1:], 2, 0)
                continue
            for k, moment in enumerate(times):
                integrator.state[2:] = np.array([[1.0], [0.0], [0.0], [1.0]])
                integrator.propagate_until(moment)
                result[part, k] = integrator.state.T
        return result


def reference(keep: str, values: np.ndarray, times: np.ndarray) -> np.ndarray:
    """The same in extended precision."""
    system = equations(keep)
    long = np.longdouble
    integrator = hk.taylor_adaptive(system, np.zeros(len(system), long), tol=long(1e-19), fp_type=long)
    result = np.empty((values.shape[1], times.size, len(system)))
    for i in range(values.shape[1]):
        integrator.time = long(0)
        integrator.state[:] = 0
        integrator.state[0] = 1
        integrator.pars[:] = values[:, i].astype(long)
        for k, moment in enumerate(times):
            integrator.state[2:] = [1, 0, 0, 1][: len(system) - 2]
            integrator.propagate_until(long(moment))
            result[i, k] = integrator.state
    return result


def own(program: Program, numbers: dict[str, Any], members: int, times: np.ndarray, threads: int = 1) -> np.ndarray:
    """The engine's result in the same shape."""
    raw = program.run(numbers, np.tile([1.0, 0.0], (members, 1)), 0.0, np.tile(times, (members, 1)), threads=threads)
    if raw.tangents is None:
        return raw.states
    columns = raw.tangents.swapaxes(-1, -2).reshape(members, times.size, 4)
    return np.concatenate([raw.states, columns], axis=-1)


def timed(call: Any, *arguments: Any) -> float:
    """Seconds that a call takes."""
    before = time.perf_counter()
    call(*arguments)
    return time.perf_counter() - before


def main(turns: int) -> None:
    """Prints a line for each stored quantity and tolerance."""
    period = np.pi / 0.1
    for keep, step in (("states", 1.0), ("tangents", 0.125)):
        few = {"voltage": np.linspace(1.1, 2.0, FEW)}
        many = {"voltage": np.linspace(1.1, 2.0, MEMBERS)}
        small, large = (cone_numbers(**each) for each in (few, many))
        matrices = [
            np.array([np.broadcast_to(numbers[name], size) for name in Cone.numbers])
            for numbers, size in ((small, FEW), (large, MEMBERS))
        ]
        short, long = period * step * np.arange(1, 2 / step + 1), period * step * np.arange(1, 10 / step + 1)
        exact = reference(keep, matrices[0], short)

        def error(result: np.ndarray, exact: np.ndarray = exact) -> float:
            relative = np.abs(result - exact) / np.maximum(1.0, np.abs(exact))
            return float(np.exp(np.log(relative.max(axis=(1, 2))).mean()))

        peers = [Peer(keep, tolerance) for tolerance in TOLERANCES]
        programs = [Program(Cone(), keep, tolerance) for tolerance in TOLERANCES]
        seconds = np.full((len(TOLERANCES), 3), np.inf)
        for _ in range(turns):
            for k, (peer, program) in enumerate(zip(peers, programs, strict=True)):
                turn = [
                    timed(peer.run, matrices[1], long),
                    timed(own, program, large, MEMBERS, long),
                    timed(own, program, large, MEMBERS, long, 2),
                ]
                seconds[k] = np.minimum(seconds[k], turn)
        errors = np.array(
            [
                [error(peer.run(matrices[0], short)), error(own(program, small, FEW, short))]
                for peer, program in zip(peers, programs, strict=True)
            ]
        )
        slopes = np.gradient(np.log(seconds[:, 0]), np.log(errors[:, 0]))
        span = long[-1] * MEMBERS * 1e-9
        for k, tolerance in enumerate(TOLERANCES):
            at_equal = seconds[k, 0] * (errors[k, 1] / errors[k, 0]) ** slopes[k]
            print(
                f"{keep:8s} {tolerance:.0e}: heyoka {errors[k, 0]:.1e} {seconds[k, 0] / span:5.0f} ns/unit, "
                f"engine {errors[k, 1]:.1e} {seconds[k, 1] / span:5.0f} ns/unit, "
                f"ratio {seconds[k, 0] / seconds[k, 1]:.2f}, at equal error {at_equal / seconds[k, 1]:.2f}; "
                f"two threads {seconds[k, 1] / seconds[k, 2]:.2f}",
                flush=True,
            )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 8)
