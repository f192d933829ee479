"""Cost of Lyapunov exponents compared with other tools, at equal error, in one run.

    python benchmarks/exponents.py [MEMBERS [PERIODS]]      (default 1,024 and 300)

All follow the same ensemble from (1, 0) and measure by how much a deviation grows. The peers (the extra ``bench``; one
that is absent is left out) follow a single deviation, which is cheaper; gelcone and the hand-written loop over heyoka's
general variational system give both exponents. There are two rounds: with gelcone's default tolerance, where the peers
run as close to its error as they can get, and with all errors near 1e-9. The error is that of the logarithm of the
growth over the first `SPAN` periods, over members that are not chaotic, against extended precision. Peers that are slow
run fewer members and periods. What is compiled is compiled before; all run on one thread, and the time is that of the
processor, the shorter of two turns.
"""

from __future__ import annotations

import importlib.util
import os
import sys
import time
from collections.abc import Callable
from contextlib import chdir
from dataclasses import dataclass
from functools import cache
from math import pi, sin
from tempfile import TemporaryDirectory
from typing import Any

os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")

import numpy as np
from heyoka_backend import LANES, equations, import_heyoka
from scipy.integrate import odeint

from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.settle import clocks
from gelcone.motion.tangents import TangentRun, advance, qr_growth
from gelcone.physics.model import ConeModel

PERIOD = 2.0 * pi
SPAN = 10
"""Periods after which the peers renew their deviation, and over which the error is measured."""
HIGHEST = 1.5
JUDGED = np.linspace(0.0, 0.7, 8)
"""Voltages of the members whose error is measured."""
SEED = 13
DIRECTION = 2.0 * np.random.RandomState(SEED).rand(2) - 1.0
DIRECTION /= np.linalg.norm(DIRECTION)

Growth = Callable[[np.ndarray, int, float], np.ndarray]
"""(voltages, periods, tolerance) -> logarithm of the growth of the deviation, one a voltage."""


def ensemble(voltages: np.ndarray) -> ConeModel:
    """Stiffness 0.9, damping 0.01, frequency 1, stretch limit 50: from rest to chaos at voltages up to 1.5."""
    return ConeModel(damping_ratio=0.01, spring_stiffness=0.9, drive_frequency=1.0, voltage=voltages)


def rate(x: Any, u: Any, a: Any, b: Any, force: Any) -> tuple[Any, Any, Any, Any]:
    """Rates of displacement, velocity and a deviation, written out by hand; ``force`` is the voltage's square."""
    q = 1.0 + x * x
    m = 1.04 * q - 0.02 * (q * q + 1.0)
    film = (q * q - 1.0) / (q * m)
    slope = (2.0 * q - film * (m + q * (1.04 - 0.04 * q))) / (q * m)
    k = force - 0.9 - film
    return u, k * x - 0.02 * u, b, (k - 2.0 * x * x * slope) * a - 0.02 * b


# --- the contestants --------------------------------------------------------------------------------------------------


def gelcone(voltages: np.ndarray, periods: int, tolerance: float) -> np.ndarray:
    members = ensemble(voltages).members()
    ((_, clock),) = clocks(members)
    run = TangentRun.at(np.tile([1.0, 0.0], (members.size, 1)))
    run.frames[:] = frame()
    stretches = round(periods * PERIOD / float(clock.spacing[0]))
    return advance(members, run, clock, stretches, threads=1, tolerance=tolerance)[:, :, 0].sum(axis=1)


def frame() -> np.ndarray:
    return np.array([[DIRECTION[0], -DIRECTION[1]], [DIRECTION[1], DIRECTION[0]]])


def heyoka_loop(voltages: np.ndarray, periods: int, tolerance: float) -> np.ndarray:
    """A plain loop: heyoka's var_ode_sys, batches of 8, the tangents started anew every period."""
    members, integrator = ensemble(voltages).members(), heyoka_program(tolerance)
    table = np.stack([members.number(name) for name in members.system.numbers])
    identity = np.array([[1.0], [0.0], [0.0], [1.0]])
    maps = np.empty((voltages.size, periods, 2, 2))
    for first in range(0, voltages.size, LANES):
        lanes = slice(first, first + LANES)
        integrator.set_time(0.0)
        integrator.pars[:] = table[:, lanes]
        integrator.state[:2] = np.array([[1.0], [0.0]])
        for k in range(periods):
            integrator.state[2:] = identity
            integrator.propagate_until((k + 1) * PERIOD)
            maps[lanes, k] = integrator.state[2:].T.reshape(-1, 2, 2)
    return qr_growth(maps, np.tile(frame(), (voltages.size, 1, 1)))[0][:, :, 0].sum(axis=1)


@cache
def heyoka_program(tolerance: float) -> Any:
    hk = import_heyoka()
    system = hk.var_ode_sys(equations(ConeModel().system, "states"), hk.var_args.vars, order=1)
    return hk.taylor_adaptive_batch(system, np.zeros((2, LANES)), tol=tolerance)


def lsoda(voltages: np.ndarray, periods: int, tolerance: float) -> np.ndarray:
    """SciPy's odeint, which has less overhead than solve_ivp."""

    def right_side(y: np.ndarray, t: float, voltage: float) -> tuple[float, ...]:
        return rate(*y.tolist(), (voltage * sin(t)) ** 2)

    out = []
    for voltage in voltages.tolist():
        y, total = np.array([1.0, 0.0, *DIRECTION]), 0.0
        for begin in range(0, periods, SPAN):
            times = [begin * PERIOD, (begin + SPAN) * PERIOD]
            y = odeint(right_side, y, times, (voltage,), rtol=tolerance, atol=0.01 * tolerance, mxstep=10**6)[-1]
            length = np.hypot(y[2], y[3])
            y[2:] /= length
            total += np.log(length)
        out.append(total)
    return np.array(out)


def pynamicalsys(voltages: np.ndarray, periods: int, tolerance: float) -> np.ndarray:
    system = pynamicalsys_program(tolerance)
    options = {"num_exponents": 1, "seed": SEED, "endpoint": False}
    end = periods * PERIOD
    return np.array([end * system.lyapunov([1.0, 0.0], end, parameters=[v], **options) for v in voltages.tolist()])


@cache
def pynamicalsys_program(tolerance: float) -> Any:
    from numba import njit
    from pynamicalsys import ContinuousDynamicalSystem

    compiled = njit(rate)

    @njit
    def motion(t, y, p):  # type: ignore[no-untyped-def]
        x, u, _, _ = compiled(y[0], y[1], 0.0, 0.0, (p[0] * np.sin(t)) ** 2)
        return np.array([x, u])

    @njit
    def jacobian(t, y, p):  # type: ignore[no-untyped-def]
        _, _, _, slope = compiled(y[0], y[1], 1.0, 0.0, (p[0] * np.sin(t)) ** 2)
        return np.array([[0.0, 1.0], [slope, -0.02]])

    system = ContinuousDynamicalSystem(
        equations_of_motion=motion, jacobian=jacobian, system_dimension=2, number_of_parameters=1
    )
    system.integrator("rk45", atol=0.01 * tolerance, rtol=tolerance)
    return system


def jitcode(voltages: np.ndarray, periods: int, tolerance: float) -> np.ndarray:
    """Dormand and Prince's eighth order, the fastest of its integrators here."""
    from jitcode import jitcode as base

    program = jitcode_program(tolerance)
    out = []
    for voltage in voltages.tolist():
        program.set_parameters(voltage)
        base.set_initial_value(program, np.array([1.0, 0.0, *DIRECTION]), 0.0)
        spans = [program.integrate((k + SPAN) * PERIOD)[1][0] for k in range(0, periods, SPAN)]
        out.append(sum(spans) * SPAN * PERIOD)
    return np.array(out)


@cache
def jitcode_program(tolerance: float) -> Any:
    import symengine
    from jitcode import jitcode_lyap, t, y

    voltage = symengine.Symbol("voltage")
    motion = rate(y(0), y(1), 0, 0, (voltage * symengine.sin(t)) ** 2)[:2]
    program = jitcode_lyap(motion, n_lyap=1, control_pars=[voltage], verbose=False)
    program.generate_f_C(do_cse=True)
    # Its build reads a pyproject.toml where it is started, which is none of its own.
    with TemporaryDirectory() as folder, chdir(folder):
        program.compile_C()
    program.set_integrator("dop853", rtol=tolerance, atol=0.01 * tolerance)
    return program


def diffrax(voltages: np.ndarray, periods: int, tolerance: float) -> np.ndarray:
    return np.asarray(diffrax_program(tolerance)(voltages, periods // SPAN))


@cache
def diffrax_program(tolerance: float) -> Any:
    """vmap over the members, 64 bits, Dormand and Prince's eighth order."""
    import diffrax as dx
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    term = dx.ODETerm(lambda t, y, voltage: rate(*y, (voltage * jnp.sin(t)) ** 2))
    control = dx.PIDController(rtol=tolerance, atol=0.01 * tolerance)

    def one(voltage: Any, spans: Any) -> Any:
        def span(k: Any, carried: Any) -> Any:
            y, total = carried
            begin = k * (SPAN * PERIOD)
            solution = dx.diffeqsolve(
                term,
                dx.Dopri8(),
                begin,
                begin + SPAN * PERIOD,
                0.05,
                y,
                voltage,
                stepsize_controller=control,
                max_steps=None,
                throw=False,
            )
            x, u, a, b = (column[0] for column in solution.ys)
            length = jnp.hypot(a, b)
            return (x, u, a / length, b / length), total + jnp.log(length)

        start = tuple(jnp.asarray(v) for v in (1.0, 0.0, *DIRECTION.tolist()))
        return jax.lax.fori_loop(0, spans, span, (start, jnp.asarray(0.0)))[1]

    return jax.jit(jax.vmap(one, in_axes=(0, None)))


# --- the comparison ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Contestant:
    """Name, tolerances in both rounds, members and periods that it is timed over (0: all), and the least allowed ratio
    of its time to gelcone's."""

    name: str
    module: str
    grow: Growth
    tolerances: tuple[float, float]
    members: int
    periods: int
    target: float

    def present(self) -> bool:
        return importlib.util.find_spec(self.module) is not None

    def error(self, tolerance: float) -> float:
        return float(np.abs(self.grow(JUDGED, SPAN, tolerance) - reference()).max())

    def cost(self, tolerance: float, members: int, periods: int) -> float:
        """Processor time per member and period."""
        members, periods = self.members or members, self.periods or periods
        voltages = np.linspace(0.0, HIGHEST, members)
        self.grow(voltages, SPAN, tolerance)
        begin = time.process_time()
        self.grow(voltages, periods, tolerance)
        return (time.process_time() - begin) / (members * periods)


CONTESTANTS = (
    Contestant("gelcone", "gelcone", gelcone, (DEFAULT_TOLERANCE, 1e-8), 0, 0, 1.0),
    Contestant("hand-written heyoka loop", "heyoka", heyoka_loop, (1e-15, 1e-8), 0, 0, 2.7),
    Contestant("diffrax, vmap", "diffrax", diffrax, (1e-14, 1e-10), 0, 2 * SPAN, 60.0),
    Contestant("JiTCODE", "jitcode", jitcode, (1e-15, 1e-11), 8, 5 * SPAN, 150.0),
    Contestant("SciPy LSODA", "scipy", lsoda, (1e-13, 1e-12), 8, 2 * SPAN, 1200.0),
    Contestant("pynamicalsys", "pynamicalsys", pynamicalsys, (1e-13, 3e-11), 8, 2 * SPAN, 1000.0),
)


@cache
def reference() -> np.ndarray:
    """The growth over `SPAN` periods at the voltages `JUDGED`, with 64 bits of mantissa."""
    hk = import_heyoka()
    x, u, a, b = hk.make_vars("x", "u", "a", "b")
    system = zip((x, u, a, b), rate(x, u, a, b, (hk.par[0] * hk.sin(hk.time)) ** 2), strict=True)
    start = np.array([1.0, 0.0, *DIRECTION], dtype=np.longdouble)
    program = hk.taylor_adaptive(list(system), start, tol=np.longdouble(1e-19), fp_type=np.longdouble)
    out = []
    for voltage in JUDGED:
        program.pars[:], program.state[:], program.time = voltage, start, np.longdouble(0.0)
        program.propagate_until(np.longdouble(SPAN * PERIOD))
        out.append(float(np.log(np.hypot(*program.state[2:]))))
    return np.array(out)


def main(members: int = 1024, periods: int = 300) -> None:
    present = [c for c in CONTESTANTS if c.present()]
    for absent in (c for c in CONTESTANTS if c not in present):
        print(f"{absent.name} is not installed and left out (pip install 'gelcone[bench]')")
    for level, title in enumerate(("gelcone's default tolerance", "errors near 1e-9")):
        print(f"{title}: {members} members over {periods} drive periods, one thread")
        print(f"{'':26s}{'tolerance':>10s}{'error':>10s}{'us/period':>11s}{'over gelcone':>14s}{'target':>9s}")
        turns = [[c.cost(c.tolerances[level], members, periods) for c in present] for _ in range(2)]
        for contestant, cost in zip(present, np.min(turns, axis=0), strict=True):
            tolerance, ratio = contestant.tolerances[level], cost / np.min(turns, axis=0)[0]
            line = f"{contestant.name:26s}{tolerance:10.0e}{contestant.error(tolerance):10.0e}{1e6 * cost:11.1f}"
            target = f">= {contestant.target:.3g}" if contestant.grow is not gelcone else ""
            print(f"{line}{ratio:14.1f}{target:>9s}", flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
