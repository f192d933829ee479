"""Is the kind of motion named right? Cases whose regime is certain, and what `gelcone.regime` says of them.

    python benchmarks/classification.py [CASES [SEED]]      (default 1,000 and 3)

The labels come from evidence that the classification does not have:

- left the domain: the start is beyond the stretch limit, or the field on a neo-Hookean film is stiffer than film and
  spring together, so that nothing bounds the motion;
- rest: the voltage is constant and the motion damped, so that the energy falls until the disc rests;
- quasi-periodic: neither damping nor an alternating voltage (an integrable oscillator seen at times that have nothing
  to do with its period); or no damping and a deviation that over 400 forcing periods and more grows no faster than time
  does;
- rest and cycles under a drive: after 10 times the transient, and at two tolerances alike, Newton's method from where
  the motion is finds an orbit that it stays on, its points well apart; SciPy's LSODA, with the equation and its
  variation written out by hand, confirms that the orbit closes and that both multipliers are inside the unit circle;
- chaos: after 40 times the transient, an average 20 times as long is 10 standard errors above zero at both tolerances,
  and a 0-1 test of 2,000 points is above 0.9.

A case whose evidence is not of this kind is left out and counted. Chaos that ends between 10 and 40 times the transient
has a table of its own: how long it lasts is chance (another tolerance, another length), so that what it is said to be
cannot be right or wrong, only flagged or not.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import odeint

from gelcone.codes import Regime
from gelcone.motion.attractor.classification import classify
from gelcone.motion.flow import integrate
from gelcone.motion.zero_one import zero_one
from gelcone.physics.model import ConeModel

TARGET = 0.99
TOLERANCES = (1e-13, 1e-12)
PATIENCE = (10, 40)
"""Transients after which cycles and rests count as certain, and chaos."""
AVERAGE = 50_000.0
FEWEST_BLOCKS = 400
OPINION = 2000
"""Time over which exponents are averaged for the labels, fewest blocks of it, and points of their 0-1 test."""
LONGEST_CYCLE = 16
MOST_REPEATS = 500
"""Forcing periods that are run at once, the clock then set back to 0."""
UNKNOWN = -1
PAPER_SETS = ({"drive_frequency": 0.1, "spring_stiffness": 0.9}, {"drive_frequency": 0.3, "spring_stiffness": 0.5})


@dataclass
class Cases:
    """Models (members,), initial states (members, 2) and their labels: codes of `Regime` or `UNKNOWN`, and periods.

    ``late`` marks motions that settle only after a long time; their labels say on what.
    """

    model: ConeModel
    initial: np.ndarray
    regime: np.ndarray
    period: np.ndarray
    late: np.ndarray

    def take(self, index: Any) -> Cases:
        index = np.asarray(index)
        return Cases(self.model.take(index), *(getattr(self, name)[index] for name in LABELS))


LABELS = ("initial", "regime", "period", "late")


def join(parts: list[Cases]) -> Cases:
    names = parts[0].model.parameters()
    values = {
        name: np.concatenate([np.broadcast_to(part.model.parameters()[name], part.model.shape) for part in parts])
        for name, value in names.items()
        if not isinstance(value, str)
    }
    return Cases(
        ConeModel.from_parameters(values), *(np.concatenate([getattr(part, name) for part in parts]) for name in LABELS)
    )


# --- the cases --------------------------------------------------------------------------------------------------------


def random_parameters(rng: np.random.Generator, count: int) -> dict[str, np.ndarray]:
    """Parameters over the whole range, half of them around the two sets of the paper."""

    def either(chance: float, one: Any, other: Any) -> np.ndarray:
        return np.where(rng.random(count) < chance, one, other)

    values = {
        "damping_ratio": 10 ** rng.uniform(np.log10(0.003), np.log10(0.5), count),
        "spring_stiffness": 10 ** rng.uniform(-1, 0.7, count),
        "voltage": rng.uniform(0.0, 2.2, count),
        "voltage_bias": either(0.7, 0.0, rng.uniform(-1.0, 1.0, count)),
        "drive_frequency": 10 ** rng.uniform(np.log10(0.05), np.log10(3.0), count),
        "stretch_limit": either(0.5, 50.0, 10 ** rng.uniform(0.2, 2.0, count)),
        "hoop_prestretch": either(0.5, 1.0, rng.uniform(0.7, 1.5, count)),
        "rest_height": either(0.7, 0.0, rng.uniform(-0.3, 0.3, count)),
    }
    values["meridional_prestretch"] = either(0.6, 1.0, values["hoop_prestretch"])
    for share, fixed in zip((0.3, 0.5), PAPER_SETS, strict=True):
        near = rng.random(count) < share / 2
        for name, value in ({"damping_ratio": 0.01, "voltage_bias": 0.0, "rest_height": 0.0} | fixed).items():
            values[name] = np.where(near, value, values[name])
    return values


def within_limit(rng: np.random.Generator, model: ConeModel) -> np.ndarray:
    """Initial states inside the stretch limit, most of them (1, 0)."""
    initial = np.stack([np.ones(model.size), np.zeros(model.size)], axis=1)
    other = rng.random(model.size) < 0.3
    initial[other] = rng.uniform(-1.0, 1.0, (int(other.sum()), 2))
    while (beyond := ~(model.strain(initial[:, 0]) < 0.9 * model.strain_limit())).any():
        initial[beyond] *= 0.7
        initial[beyond & (np.abs(initial).max(axis=1) < 1e-3)] = np.nan
    return initial


def unlabelled(rng: np.random.Generator, count: int, **fixed: Any) -> Cases:
    """Random cases that can start."""
    values = random_parameters(rng, 2 * count) | {name: np.broadcast_to(v, 2 * count) for name, v in fixed.items()}
    model = ConeModel.from_parameters(values)
    model = model.take(np.flatnonzero(model.strain(0.0) < 0.5 * model.strain_limit())[:count])
    kinds = np.full((2, model.size), UNKNOWN)
    return Cases(model, within_limit(rng, model), kinds[0], kinds[1], np.zeros(model.size, dtype=bool))


def constant_voltage(rng: np.random.Generator, count: int) -> Cases:
    """Damped, the voltage constant: rest."""
    cases = unlabelled(rng, count, voltage=0.0)
    cases.regime[:], cases.period[:] = Regime.REST, 0
    return cases


def undamped(rng: np.random.Generator, count: int) -> Cases:
    """No damping; a third of the cases without drive, which is quasi-periodic. The rest is still to be labelled."""
    cases = unlabelled(rng, count, damping_ratio=0.0)
    free = rng.random(cases.model.size) < 1 / 3
    cases.model = cases.model.replace(voltage=np.where(free, 0.0, rng.uniform(0.0, 1.0, cases.model.size)))
    cases.regime[free], cases.period[free] = Regime.QUASI_PERIODIC, 0
    return cases


def unbounded(rng: np.random.Generator, count: int) -> Cases:
    """Starts beyond the stretch limit, and films without one that a constant field tears open."""
    cases = unlabelled(rng, count)
    half = cases.model.size // 2
    limit = np.broadcast_to(cases.model.stretch_limit, cases.model.shape).copy()
    bias = np.broadcast_to(cases.model.voltage_bias, cases.model.shape).copy()
    voltage = np.broadcast_to(cases.model.voltage, cases.model.shape).copy()
    cases.initial[:half, 0] = np.sqrt(limit[:half] + 3.0) / np.asarray(cases.model.stretches[0])[:half]
    limit[half:], voltage[half:] = np.inf, 0.0
    members = cases.model.members()
    bias[half:] = np.sqrt(members.number("spring_stiffness") + members.number("A") + 0.5)[half:]
    cases.model = cases.model.replace(stretch_limit=limit, voltage_bias=bias, voltage=voltage)
    cases.regime[:], cases.period[:] = Regime.LEFT_THE_DOMAIN, 0
    return cases


def build(count: int, seed: int) -> Cases:
    """About ``count`` cases, six tenths of them under a drive with damping, labelled where that can be done."""
    rng = np.random.default_rng(seed)
    parts = [constant_voltage(rng, count // 10), unbounded(rng, count // 10)]
    parts += [label_undamped(undamped(rng, count // 5)), label_damped(unlabelled(rng, 6 * count // 10))]
    return join(parts)


# --- the evidence -----------------------------------------------------------------------------------------------------


def run(model: ConeModel, states: np.ndarray, repeats: int, tolerance: float) -> np.ndarray:
    """States after each of some forcing periods, (members, repeats, 2)."""
    repeat = np.broadcast_to(model.forcing_period, model.shape)
    parts = []
    for first in range(0, repeats, MOST_REPEATS):
        times = repeat[:, None] * np.arange(1, min(MOST_REPEATS, repeats - first) + 1)
        parts.append(integrate(model, states, times, tolerance=tolerance).states)
        states = parts[-1][:, -1]
    return np.concatenate(parts, axis=1)


def let_pass(model: ConeModel, states: np.ndarray, transients: float, tolerance: float) -> np.ndarray:
    """States after a number of transients of the classification (20 decay times or 30 forcing periods)."""
    states = states.copy()
    repeat = np.broadcast_to(model.forcing_period, model.shape)
    transient = np.maximum(np.clip(20.0 / np.maximum(model.damping_ratio, 1e-9), 200.0, 5000.0), 30.0 * repeat)
    left = np.ceil(transients * transient / repeat).astype(int)
    while (left > 0).any():
        step = np.minimum(left, MOST_REPEATS)
        for count in np.unique(step[step > 0]):
            part = np.flatnonzero(step == count)
            times = (count * repeat[part])[:, None]
            states[part] = integrate(model.take(part), states[part], times, tolerance=tolerance).states[:, -1]
        left -= step
    return states


def tangent_growth(model: ConeModel, states: np.ndarray, duration: float, tolerance: float) -> tuple[Any, Any, Any]:
    """Logarithmic growth of one deviation over 400 blocks or more of whole forcing periods, (members, blocks); the
    length of a block, (members,); and the states after it."""
    repeat = np.broadcast_to(model.forcing_period, model.shape)
    pieces = int(np.ceil(repeat.max() / 6.0))
    repeats = np.maximum(1, np.ceil(6.0 / repeat)).astype(int) if pieces == 1 else np.ones(model.size, dtype=int)
    blocks = max(FEWEST_BLOCKS, int(duration / (repeats * repeat).min()))
    times = (repeats * repeat)[:, None] * np.arange(1, 20 * pieces + 1) / pieces
    vector = np.tile([1.0, 0.3], (model.size, 1))
    growth = []
    for _ in range(-(-blocks // 20)):
        flow = integrate(model, states, times, keep="tangents", tolerance=tolerance)
        states = flow.states[:, -1]
        for k in range(20):
            total = np.zeros(model.size)
            for tangent in np.moveaxis(flow.tangents[:, k * pieces : (k + 1) * pieces], 1, 0):
                vector = np.einsum("mij,mj->mi", tangent, vector)
                length = np.linalg.norm(vector, axis=1)
                vector, total = vector / length[:, None], total + np.log(length)
            growth.append(total)
    return np.stack(growth, axis=1), repeats * repeat, states


def grouped(model: ConeModel) -> list[np.ndarray]:
    """Members of about the same forcing period, so that one call does not cut fast drives as finely as slow ones."""
    octave = np.floor(2.0 * np.log2(np.broadcast_to(model.forcing_period, model.shape)))
    return [np.flatnonzero(octave == value) for value in np.unique(octave)]


def is_chaotic(model: ConeModel, states: np.ndarray, tolerance: float) -> np.ndarray:
    """Whether the average over 50,000 time units and the 0-1 test of 2,000 points leave no doubt of chaos."""
    certain = np.zeros(model.size, dtype=bool)
    for part in grouped(model):
        growth, spacing, after = tangent_growth(model.take(part), states[part], AVERAGE, tolerance)
        batches = growth[:, : growth.shape[1] // 20 * 20].reshape(len(part), 20, -1).mean(axis=2) / spacing[:, None]
        error = batches.std(axis=1, ddof=1) / np.sqrt(20)
        points = run(model.take(part), after, OPINION, tolerance)[..., 0]
        # A short piece of the motion shows whether a drive so slow has pushed every deviation to nothing by its end.
        opinion = zero_one(np.sign(points) * np.log1p(np.abs(points) / np.abs(points).std(axis=1, keepdims=True)))
        certain[part] = (batches.mean(axis=1) > 10.0 * error) & (opinion > 0.9)
    return certain


def newton(model: ConeModel, states: np.ndarray, period: int, tolerance: float) -> np.ndarray:
    """The fixed points of ``period`` forcing periods near ``states``; NaN where Newton's method does not get there."""
    repeat = np.broadcast_to(model.forcing_period, model.shape)
    pieces = period * int(np.ceil(repeat.max() / 6.0))
    times = (period * repeat)[:, None] * np.arange(1, pieces + 1) / pieces
    states = states.copy()
    for _ in range(8):
        flow = integrate(model, states, times, keep="tangents", tolerance=tolerance)
        total = np.eye(2)
        for tangent in np.moveaxis(flow.tangents, 1, 0):
            total = tangent @ total
        bad = ~np.isfinite(total).all(axis=(1, 2))
        total[bad] = 0.0
        step = np.linalg.solve(np.eye(2) - total, (flow.states[:, -1] - states)[..., None])[..., 0]
        states = np.where(bad[:, None], np.nan, states + step)
    return np.where(np.abs(step).max(axis=1)[:, None] < 1e-9 * size_of(states)[:, None], states, np.nan)


def size_of(states: np.ndarray) -> np.ndarray:
    return np.maximum(np.abs(states).max(axis=-1), 1e-2)


def find_cycle(model: ConeModel, states: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Period (0: none) and a point of the cycle on which the settled motions (members, 2) are."""
    points = np.concatenate([states[:, None], run(model, states, 2 * LONGEST_CYCLE, tolerance)], axis=1)
    size = size_of(points).max(axis=1)
    period, orbit = np.zeros(model.size, dtype=int), np.full((model.size, 2), np.nan)
    for candidate in range(1, LONGEST_CYCLE + 1):
        gap = np.abs(points[:, candidate:] - points[:, :-candidate]).max(axis=(1, 2))
        near = np.flatnonzero((period == 0) & (gap < 1e-5 * size))
        for part in (near[g] for g in grouped(model.take(near))) if near.size else ():
            found = newton(model.take(part), states[part], candidate, tolerance)
            on_it = np.abs(found - states[part]).max(axis=1) < 1e-4 * size[part]
            period[part[on_it]], orbit[part[on_it]] = candidate, found[on_it]
    return period, orbit


def confirm(model: ConeModel, state: np.ndarray, period: int) -> tuple[bool, bool]:
    """Whether SciPy finds the orbit closed and attracting, its points apart; and whether it rests.

    The equation of motion and its variation, by hand: x'' = kappa (x0 - x) - 2 zeta x' + v^2 x - F(x) with the film's
    force F = x (A - G/q^2)/(1 - e/J), e = A q + B + G/q - 3.
    """
    p = {name: float(value[0]) for name, value in model.take([0]).parameters().items() if not isinstance(value, str)}
    A, B = p["meridional_prestretch"] ** 2, p["hoop_prestretch"] ** 2
    G, J, kappa, two_zeta = 1.0 / (A * B), p["stretch_limit"], p["spring_stiffness"], 2.0 * p["damping_ratio"]

    def right_side(y: np.ndarray, t: float) -> list[float]:
        x, u, a, b, c, d = y
        v = p["voltage_bias"] + p["voltage"] * np.sin(p["drive_frequency"] * t)
        q = 1.0 + x * x
        left = 1.0 - (A * q + B + G / q - 3.0) / J
        stress = A - G / (q * q)
        slope = (stress + 2.0 * x * x * (2.0 * G / q**3 + stress * stress / (J * left))) / left
        rate = kappa * (p["rest_height"] - x) - two_zeta * u + v * v * x - x * stress / left
        k = v * v - kappa - slope
        return [u, rate, b, k * a - two_zeta * b, d, k * c - two_zeta * d]

    repeat = float(model.forcing_period[0])
    times = repeat * np.arange(8 * period + 1) / 8
    path, total = [state], np.eye(2)
    for begin, end in pairwise(times):
        start = [*path[-1], 1.0, 0.0, 0.0, 1.0]
        y = odeint(right_side, start, [begin, end], rtol=1e-11, atol=1e-13, mxstep=100_000)[-1]
        path.append(y[:2])
        total = np.array([[y[2], y[4]], [y[3], y[5]]]) @ total
    path = np.array(path)
    size = max(float(np.abs(path).max()), 1e-2)
    closed = bool(np.abs(path[-1] - path[0]).max() < 1e-6 * size)
    attracting = bool(np.abs(np.linalg.eigvals(total)).max() < 0.99)
    by_repeat = path[:-1].reshape(period, 8, 2)
    apart = all(
        np.abs(by_repeat - np.roll(by_repeat, divisor, axis=0)).max() > 1e-3 * size
        for divisor in range(1, period)
        if period % divisor == 0
    )
    rests = bool(np.ptp(path[:, 0]) < 1e-9 and np.abs(path[:, 1]).max() < 1e-9)
    moves = bool(np.ptp(path[:, 0]) > 1e-4)
    return closed and attracting and apart and (rests or moves), rests


def label_damped(cases: Cases) -> Cases:
    """Labels driven cases with damping: rest, cycles up to `LONGEST_CYCLE`, chaos."""
    states = [cases.initial, cases.initial]
    open_cases = np.arange(cases.model.size)
    for late, transients in enumerate((PATIENCE[0], PATIENCE[1] - PATIENCE[0])):
        model = cases.model.take(open_cases)
        states = [let_pass(model, s, transients, t) for s, t in zip(states, TOLERANCES, strict=True)]
        (period, orbit), (again, _) = (find_cycle(model, s, t) for s, t in zip(states, TOLERANCES, strict=True))
        for i in np.flatnonzero((period > 0) & (again == period)):
            certain, rests = confirm(model.take([i]), orbit[i], int(period[i]))
            if certain:
                case = open_cases[i]
                cases.regime[case], cases.period[case] = (Regime.REST, 0) if rests else (Regime.PERIODIC, period[i])
                cases.late[case] = bool(late)
        on = np.isfinite(states[0]).all(axis=1) & np.isfinite(states[1]).all(axis=1)
        on &= (cases.regime[open_cases] == UNKNOWN) & ((period == 0) | (again == 0))
        open_cases, states = open_cases[on], [s[on] for s in states]
    chaotic = np.ones(open_cases.size, dtype=bool)
    for s, tolerance in zip(states, TOLERANCES, strict=True):
        if chaotic.any():
            chaotic[chaotic] = is_chaotic(cases.model.take(open_cases[chaotic]), s[chaotic], tolerance)
    cases.regime[open_cases[chaotic]], cases.period[open_cases[chaotic]] = Regime.CHAOTIC, 0
    return cases


def label_undamped(cases: Cases) -> Cases:
    """Labels driven cases without damping: quasi-periodic where deviations grow like time, or chaos."""
    for part in grouped(cases.model):
        model = cases.model.take(part)
        growth, spacing, after = tangent_growth(model, cases.initial[part], AVERAGE, TOLERANCES[0])
        grown, elapsed = np.cumsum(growth, axis=1), spacing[:, None] * np.arange(1, growth.shape[1] + 1)
        beyond_time = (grown - np.log1p(elapsed)).max(axis=1)
        opinion = zero_one(run(model, after, OPINION, TOLERANCES[0])[..., 0])
        unknown = cases.regime[part] == UNKNOWN
        regular, chaotic = unknown & (beyond_time < 4.0) & (opinion < 0.1), unknown & (beyond_time > 500.0)
        cases.regime[part[regular]] = Regime.QUASI_PERIODIC
        cases.regime[part[chaotic & (opinion > 0.9)]] = Regime.CHAOTIC
        cases.period[part[regular | chaotic]] = 0
    return cases


# --- the table --------------------------------------------------------------------------------------------------------


def judge(cases: Cases) -> tuple[Any, np.ndarray, int]:
    """The answers of the classification: how many are right, including the period, and how many found another cycle.

    Where several cycles attract, rounding can decide on which one chaos ends. Such an answer is right if SciPy confirms
    the claimed cycle at the classified motion, by the criteria of the labels. Chaos that ends is judged by its end, or,
    if it outlived the labels, counts as chaos that may live that long.
    """
    evidence = classify(cases.model.members(), cases.initial)
    ends = evidence.regime == Regime.TRANSIENT_CHAOS
    named = np.where(ends, np.where(evidence.period > 0, Regime.PERIODIC, Regime.REST), evidence.regime)
    right = (named == cases.regime) & (evidence.period == cases.period)
    right |= ends & (cases.regime == Regime.CHAOTIC) & (evidence.lifetime_high > AVERAGE)
    settled = np.isin(cases.regime, (Regime.REST, Regime.PERIODIC))
    others = np.flatnonzero(settled & ~right & np.isin(named, (Regime.REST, Regime.PERIODIC)))
    for i in others:
        period = max(int(evidence.period[i]), 1)
        orbit = newton(cases.model.take([i]), evidence.final[[i]], period, TOLERANCES[0])
        near = np.abs(orbit - evidence.final[i]).max() < 1e-3 * size_of(evidence.section[i]).max()
        certain, rests = confirm(cases.model.take([i]), orbit[0], period) if near else (False, False)
        right[i] = certain and rests == (named[i] == Regime.REST)
    return evidence, right, int(right[others].sum())


def print_table(cases: Cases, evidence: Any) -> None:
    columns = [*Regime, "flag"]
    print(f"{'certain':>18s} | said to be" + "".join(f"{getattr(c, 'label', c):>16s}" for c in columns))
    for kind in Regime:
        said = evidence.regime[cases.regime == kind]
        if said.size:
            counts = [*np.bincount(said, minlength=len(Regime)), evidence.doubtful[cases.regime == kind].sum()]
            print(f"{kind.label:>18s} |           " + "".join(f"{n:16d}" for n in counts))


def describe(cases: Cases, i: int) -> str:
    parameters = {k: v.item() for k, v in cases.model.take([i]).parameters().items() if not isinstance(v, str)}
    return f"from {cases.initial[i].tolist()}: {parameters}"


def main(count: int, seed: int = 3) -> int:
    begin = time.perf_counter()
    drawn = build(count, seed)
    late = np.flatnonzero(drawn.late)
    cases = drawn.take(np.flatnonzero((drawn.regime != UNKNOWN) & ~drawn.late))
    labelled = time.perf_counter()
    evidence, right, elsewhere = judge(cases)
    print(
        f"{cases.model.size} certain cases out of {drawn.model.size} drawn, labelled in {labelled - begin:.0f} s, "
        f"classified in {time.perf_counter() - labelled:.1f} s"
    )
    print_table(cases, evidence)
    periods = cases.period[cases.regime == Regime.PERIODIC]
    counts = {int(n): int((periods == n).sum()) for n in np.unique(periods)}
    print(f"periods among the periodic: {counts}")
    unflagged = ~right & ~evidence.doubtful
    print(f"right, period included: {right.mean():.2%}; wrong without a flag: {unflagged.sum()}")
    doubted = (right & evidence.doubtful).mean()
    print(f"right answers with a flag: {doubted:.2%}; on another cycle, confirmed: {elsewhere}")
    for i in np.flatnonzero(~right):
        print(
            f"  {Regime(cases.regime[i]).label} {cases.period[i]} said to be {Regime(evidence.regime[i]).label} "
            f"{evidence.period[i]}{', flagged,' * bool(evidence.doubtful[i])} {describe(cases, i)}"
        )
    if late.size:
        print(f"chaos that ends after {PATIENCE[0]} to {PATIENCE[1]} transients:")
        print_table(drawn.take(late), judge(drawn.take(late))[0])
    return int(right.mean() < TARGET or unflagged.any())


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:3])) if len(sys.argv) > 1 else main(1000))
