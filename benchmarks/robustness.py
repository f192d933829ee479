"""No member is silently wrong: random parameter sets against the same motion in 80-bit arithmetic.

    python benchmarks/robustness.py [MEMBERS]      (default 100,000)

Half of the members start within 1e-6 to 1 of the stretch limit, a third has one near 1, voltages go up to 3.
The reference is heyoka's scalar integrator in long double, compiled from the Lagrangian rather than from the closed
form. A member is right when it agrees with it to 1e-9 of its size, times the factor by which its own tangent map says
that rounding errors grow; every other one must carry an outcome that says why not.
"""

from __future__ import annotations

import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from cone_energy import dissipation, lagrangian
from heyoka_backend import functions, import_heyoka

from gelcone.codes import Outcome
from gelcone.motion.engine import backend
from gelcone.motion.flow import available_threads, integrate
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel

SAMPLES = 6
LONGEST = 20.0


def random_ensemble(count: int, seed: int = 2026) -> tuple[ConeModel, np.ndarray]:
    """Models and initial states, all inside their stretch limits unless the pre-stretch alone exceeds it."""
    rng = np.random.default_rng(seed)
    limit = np.where(rng.random(count) < 1 / 3, rng.uniform(0.8, 1.3, count), 10 ** rng.uniform(-0.3, 2.5, count))
    limit[rng.random(count) < 0.05] = np.inf
    hoop = rng.uniform(0.6, 1.6, count)
    model = ConeModel(
        damping_ratio=np.where(rng.random(count) < 0.3, 0.0, 10 ** rng.uniform(-3, 0.3, count)),
        spring_stiffness=10 ** rng.uniform(-1, 1.3, count),
        voltage=rng.uniform(0, 3, count),
        voltage_bias=np.where(rng.random(count) < 0.5, 0.0, rng.uniform(-1, 1, count)),
        drive_frequency=10 ** rng.uniform(-1.3, 0.7, count),
        stretch_limit=limit,
        meridional_prestretch=np.where(rng.random(count) < 0.5, 1.0, hoop),
        hoop_prestretch=hoop,
        rest_height=rng.uniform(-0.5, 0.5, count),
    )
    low, high = np.zeros(count), np.full(count, 100.0)
    for _ in range(60):
        middle = 0.5 * (low + high)
        inside = model.strain(middle) < limit
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    share = np.where(rng.random(count) < 0.5, 1 - 10 ** rng.uniform(-6, 0, count), rng.random(count))
    displacement = np.where(np.isfinite(limit), low * share, 2 * rng.random(count)) * rng.choice([-1, 1], count)
    return model, np.stack([displacement, rng.uniform(-1, 1, count)], axis=1)


def reference(model: ConeModel, initial: np.ndarray, times: np.ndarray) -> np.ndarray:
    """The same motion in long double, from the Lagrangian; NaN where that does not arrive."""
    out = np.full((*times.shape, 2), np.nan)
    finite = np.isfinite(model.stretch_limit)
    for law, members in (("gent", np.flatnonzero(finite)), ("neo-hookean", np.flatnonzero(~finite))):
        part = model.take(members).replace(law=law).members()
        out[members] = _reference(part, initial[members], times[members])
    return out


def _reference(members: Members, initial: np.ndarray, times: np.ndarray) -> np.ndarray:
    hk, system = import_heyoka(), members.system
    x, u = hk.make_vars("x", "u")
    n = {name: hk.par[i] for i, name in enumerate(system.numbers)}
    voltage = n["voltage_bias"] + n["voltage"] * hk.sin(n["drive_frequency"] * hk.time)
    energy = lagrangian(x, u, voltage, n, system.film, system.bias, functions())
    motion = hk.lagrangian(energy, [x], [u], dissipation(u, n))
    table = np.stack([members.number(name) for name in system.numbers]).astype(np.longdouble)
    out = np.full((*times.shape, 2), np.nan)

    def work(rows: np.ndarray) -> None:
        integrator = hk.taylor_adaptive(motion, np.zeros(2, dtype=np.longdouble), fp_type=np.longdouble)
        for i in rows:
            integrator.time = np.longdouble(0)
            integrator.pars[:] = table[: len(integrator.pars), i]
            integrator.state[:] = initial[i]
            samples = integrator.propagate_grid(times[i].astype(np.longdouble), max_steps=400_000)[-1]
            out[i, : len(samples)] = samples

    threads = available_threads()
    with ThreadPoolExecutor(threads) as executor:
        list(executor.map(work, np.array_split(np.arange(members.size), 8 * threads)))
    return out


def main(count: int) -> int:
    model, initial = random_ensemble(count)
    horizon = np.minimum(LONGEST, 4 * model.drive_period)
    times = horizon[:, None] * np.arange(SAMPLES + 1) / SAMPLES
    begin = time.perf_counter()
    run = integrate(model, initial, times)
    seconds = time.perf_counter() - begin
    backend.SMALLEST_STEP = 0.0  # the growth is wanted of every member that the run above kept
    tangents = integrate(model, initial, times, keep="tangents").tangents
    begin = time.perf_counter()
    exact = reference(model, initial, times)
    growth = np.broadcast_to(np.eye(2), (count, 2, 2))
    size = np.ones(count)
    worst = np.zeros(count)
    for k in range(times.shape[1]):
        growth = tangents[:, k] @ growth
        size = np.fmax(size, np.linalg.norm(growth, axis=(1, 2)))
        scale = (1 + np.abs(exact[:, k]).max(axis=1)) * size
        worst = np.fmax(worst, np.abs(run.states[:, k] - exact[:, k]).max(axis=1) / scale)
    ok = run.outcome == Outcome.OK
    arrived = np.isfinite(exact).all(axis=(1, 2))
    beyond = ok & (model.strain(run.states[:, -1, 0]) >= model.strain_limit())
    wrong = ok & arrived & ~(worst <= 1e-9)
    print(f"{count} members in {seconds:.1f} s (the reference took {time.perf_counter() - begin:.1f} s)")
    for outcome in Outcome:
        print(f"  {outcome.name.lower():14s} {(run.outcome == outcome).sum()}")
    print(f"ok members beyond the stretch limit: {beyond.sum()}")
    print(f"ok members without a reference: {(ok & ~arrived).sum()}")
    print(f"ok members that are wrong (error over 1e-9 of size and growth): {wrong.sum()}; worst {worst[ok].max():.1e}")
    return int(beyond.any() or wrong.any() or (ok & ~arrived).any())


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 100_000))
