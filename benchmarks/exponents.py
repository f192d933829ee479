"""Cost of Lyapunov exponents, side by side in one run.

    python benchmarks/exponents.py [MEMBERS] [PERIODS]      (default 1,024 and 300)

The tangent maps of an ensemble over drive periods, with the QR decomposition that turns them into exponents, against a
hand-written batch loop over heyoka's general variational system and against SciPy's LSODA on a few members, scaled.
Prints times per member and period, and ratios; each contestant runs twice in turn and the shorter time counts.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from gelcone.laws import Gent
from gelcone.model import ConeModel
from gelcone.motion.flow import LANES, _runtime_parameters, equations, import_heyoka
from gelcone.motion.lyapunov import TangentRun, advance, clocks, qr_growth

LSODA_MEMBERS = 4
LSODA_PERIODS = 30
PERIOD = 2.0 * np.pi


def ensemble(count: int) -> ConeModel:
    """Members from rest to chaos: stiffness 0.9, damping 0.01, frequency 1, voltages up to 1.5."""
    return ConeModel(
        damping_ratio=0.01, spring_stiffness=0.9, drive_frequency=1.0, voltage=np.linspace(0.0, 1.5, count)
    )


def gelcone_exponents(model: ConeModel, periods: int) -> np.ndarray:
    (_, clock), *rest = clocks(model)
    assert not rest
    run = TangentRun.at(np.tile([1.0, 0.0], (model.size, 1)))
    stretches = round(periods * PERIOD / float(clock.spacing[0]))
    growth = advance(model, run, clock, stretches, threads=1)
    return growth.sum(axis=1) / (stretches * clock.spacing[0])


def heyoka_exponents(model: ConeModel, periods: int) -> np.ndarray:
    """A plain loop: heyoka's var_ode_sys, batches of 8, the tangents started anew every period."""
    hk = import_heyoka()
    system = hk.var_ode_sys(equations(Gent(), "states", 1), hk.var_args.vars, order=1)
    integrator = hk.taylor_adaptive_batch(system, np.zeros((2, LANES)), tol=1e-15)
    table, period = _runtime_parameters(model), PERIOD
    identity = np.array([[1.0], [0.0], [0.0], [1.0]])
    maps = np.empty((model.size, periods, 2, 2))
    for first in range(0, model.size, LANES):
        lanes = slice(first, first + LANES)
        integrator.set_time(0.0)
        integrator.pars[:] = table[:, lanes]
        integrator.state[:2] = np.array([[1.0], [0.0]])
        for k in range(periods):
            integrator.state[2:] = identity
            integrator.propagate_until((k + 1) * period)
            maps[lanes, k] = integrator.state[2:].T.reshape(-1, 2, 2)
    growth, _ = qr_growth(maps, np.tile(np.eye(2), (model.size, 1, 1)))
    return growth.sum(axis=1) / (periods * period)


def lsoda_exponents(model: ConeModel, periods: int) -> np.ndarray:
    """SciPy's LSODA with a hand-written tangent, renormalised every period."""
    out = []
    for voltage in np.asarray(model.voltage):

        def rate(t: float, y: np.ndarray, voltage: float = float(voltage)) -> list[float]:
            x, u, dx, du = y
            q, s = 1.0 + x * x, 0.02
            m = q * (1.0 + 2.0 * s) - (q * q + 1.0) * s
            h = (q * q - 1.0) / (q * m)
            slope = (2.0 * q - h * (m + q * (1.0 + 2.0 * s - 2.0 * q * s))) / (q * m)
            g = (voltage * np.sin(t)) ** 2 - 0.9 - h
            return [u, g * x - 0.02 * u, du, (g - 2.0 * x * x * slope) * dx - 0.02 * du]

        y, total, period = np.array([1.0, 0.0, 1.0, 0.0]), 0.0, PERIOD
        for k in range(periods):
            span = (k * period, (k + 1) * period)
            y = solve_ivp(rate, span, y, method="LSODA", rtol=1e-10, atol=1e-12).y[:, -1]
            length = np.hypot(y[2], y[3])
            total += np.log(length)
            y[2:] /= length
        out.append(total / (periods * period))
    return np.array(out)


def timed(work: Callable[[], np.ndarray]) -> tuple[float, np.ndarray]:
    begin = time.perf_counter()
    result = work()
    return time.perf_counter() - begin, result


def main(members: int, periods: int) -> None:
    model = ensemble(members)
    few = model.take(np.linspace(0, members // 2, LSODA_MEMBERS).astype(int))
    gelcone_exponents(model.take(np.arange(LANES)), 2)
    heyoka_exponents(model.take(np.arange(LANES)), 2)
    runs = [
        (
            timed(lambda: gelcone_exponents(model, periods)),
            timed(lambda: heyoka_exponents(model, periods)),
            timed(lambda: lsoda_exponents(few, LSODA_PERIODS)),
        )
        for _ in range(2)
    ]
    mine, loop = (min(run[k][0] for run in runs) / (members * periods) for k in (0, 1))
    lsoda = min(run[2][0] for run in runs) / (LSODA_MEMBERS * LSODA_PERIODS)
    regular = runs[0][0][1][:, 0] < 0.0
    gap = np.abs(runs[0][0][1] - runs[0][1][1])[regular].max()
    print(f"{members} members over {periods} drive periods, one thread, microseconds per member and period")
    print(f"  gelcone                      {1e6 * mine:8.2f}")
    print(f"  hand-written heyoka loop     {1e6 * loop:8.2f}   gelcone over it {mine / loop:.2f} (target <= 1.2)")
    print(f"  SciPy LSODA, {LSODA_MEMBERS} members       {1e6 * lsoda:8.2f}   over gelcone {lsoda / mine:.0f} (>= 50)")
    print(f"  largest difference of the exponents, gelcone and loop, regular members: {gap:.1e}")


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:3])) if len(sys.argv) > 2 else main(1024, 300)
