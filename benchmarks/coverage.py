"""Do the intervals hold what they say? Exponents and lifetimes of chaos, against far longer runs.

    python benchmarks/coverage.py [MODELS [SEED]]      (default 60 and 7)

Exponents: points from a hard random set, half of them around the paper's two sets, at which 8 starts are still chaotic
after 20,000 time units. At each, the exponents of `RUNS` starts are averaged as `gelcone lyapunov` averages them, and
compared with the mean over many more and longer runs, whose own error is added. Targets: 65 to 71 % within one standard
error, 93 to 97 % within 1.96, at least 99 % within three.

Lifetimes: points at which chaos ends. The interval that `gelcone regime` states for several starts is held against the
mean lifetime of 256 other starts, whose own error is added. Target: at least 95 %.
"""

from __future__ import annotations

import sys

import numpy as np
from classification import unlabelled

from gelcone.codes import Outcome, Regime
from gelcone.motion.course import course
from gelcone.motion.lyapunov import average
from gelcone.motion.regime import MEASURE_TOLERANCE, classify
from gelcone.motion.settle import repeats_lasting, settle
from gelcone.physics.members import Members

RUNS = 9
"""Test runs of each point."""
REFERENCES, REFERENCE_BUDGET = 24, 40_000.0
STARTS = 256
LIFETIME_RUNS = 8
FORGET = 2_000.0
SPREAD = 1e-3
TOLERANCE = 1e-6
TARGETS = ((1.0, 0.65, 0.71), (1.96, 0.93, 0.97), (3.0, 0.99, 1.0))


def near(rng: np.random.Generator, state: np.ndarray, count: int) -> np.ndarray:
    """So many states near one."""
    return state + SPREAD * rng.normal(size=(count, state.size))


def exponents(members: Members, initial: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """How many standard errors the test runs of each point are off its reference, (points * RUNS,)."""
    off = []
    for row in range(members.size):
        many = members.take(np.full(RUNS + REFERENCES, row))
        states, _ = settle(
            many, near(rng, initial[row], RUNS + REFERENCES), repeats_lasting(many, FORGET), tolerance=TOLERANCE
        )
        tests = average(many.take(np.arange(RUNS)), states[:RUNS], tolerance=MEASURE_TOLERANCE)
        rest = np.arange(RUNS, RUNS + REFERENCES)
        long = average(
            many.take(rest), states[rest], budget=REFERENCE_BUDGET, precision=1e-9, tolerance=MEASURE_TOLERANCE
        )
        mean, error = long.values[:, 0].mean(), long.values[:, 0].std(ddof=1) / np.sqrt(REFERENCES)
        off.append(np.abs(tests.values[:, 0] - mean) / np.hypot(tests.standard_error[:, 0], error))
    return np.concatenate(off)


def lasting_points(members: Members, initial: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Members that are chaotic, and of which eight nearby starts are chaotic still after 20,000 time units."""
    found = classify(members, initial, patience=20_000.0)
    rows = np.flatnonzero((found.regime == Regime.CHAOTIC) & (found.outcome == Outcome.OK) & members.damped)
    several = members.take(np.repeat(rows, 8))
    states = np.concatenate([near(rng, initial[row], 8) for row in rows])
    run, _ = course(several, states, repeats_lasting(several, 20_000.0), tolerance=TOLERANCE)
    lasts = ((run.period == 0) & (run.outcome == Outcome.OK)).reshape(-1, 8).all(axis=1)
    return rows[lasts]


def lifetimes(members: Members, initial: np.ndarray, rng: np.random.Generator) -> tuple[int, int]:
    """Of how many stated intervals so many hold the mean lifetime of the other starts."""
    held = tried = 0
    for row in range(members.size):
        runs = members.take(np.full(LIFETIME_RUNS, row))
        stated = classify(runs, near(rng, initial[row], LIFETIME_RUNS))
        known = np.isfinite(stated.lifetime)
        if not known.any():
            continue
        horizon = 4.0 * float(np.median(stated.lifetime[known]))
        many = members.take(np.full(STARTS, row))
        run, _ = course(
            many, near(rng, initial[row], STARTS), repeats_lasting(many, min(horizon, 40_000.0)), tolerance=TOLERANCE
        )
        ended = run.period > 0
        times = np.where(ended, run.away, horizon if horizon < 40_000.0 else 40_000.0)
        mean, share = times.sum() / max(ended.sum(), 1), 2.0 / np.sqrt(max(ended.sum(), 1))
        low, high = stated.lifetime_low[known], stated.lifetime_high[known]
        held += int(((low <= mean * (1.0 + share)) & (high >= mean * (1.0 - share))).sum())
        tried += int(known.sum())
    return held, tried


def main(models: int = 60, seed: int = 7) -> int:
    rng = np.random.default_rng(seed)
    cases = unlabelled(rng, 16 * models)
    members, initial = cases.model.members(), cases.initial
    rows = lasting_points(members, initial, rng)[:models]
    off = exponents(members.take(rows), initial[rows], rng)
    print(f"exponents: {off.size} runs at {rows.size} points")
    right = True
    for sigma, least, most in TARGETS:
        share = float((off <= sigma).mean())
        right &= least <= share <= most
        print(f"  within {sigma:g} standard errors: {share:.3f} (target {least:g} to {most:g})")
    print(f"  the worst: {off.max():.1f} standard errors")
    short = classify(members, initial, patience=20_000.0)
    ends = np.flatnonzero(short.regime == Regime.TRANSIENT_CHAOS)[: models // 4]
    held, tried = lifetimes(members.take(ends), initial[ends], rng)
    right &= held >= 0.93 * tried
    print(f"lifetimes: {held} of {tried} intervals hold the mean of {STARTS} other starts ({held / max(tried, 1):.3f})")
    return 0 if right else 1


if __name__ == "__main__":
    sys.exit(main(*(int(argument) for argument in sys.argv[1:])))
