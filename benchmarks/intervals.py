"""Coverage of stated intervals: exponents and lifetimes of chaos, against far longer runs.

    python benchmarks/intervals.py [MODELS [SEED]]      (default 60 and 7)

Exponents: points from a hard random set, half of them around the paper's two sets, at which 24 starts are still chaotic
after 40,000 time units. At each, the exponents of `RUNS` starts are averaged as `gelcone lyapunov` averages them, and
compared with the mean over many more and longer runs, whose own error is added. Targets: 65 to 71 % within one standard
error, 93 to 97 % within 1.96, at least 99 % within three.

Thresholds: two diagrams, again from starts 1e-12 to 1e-9 apart and at another tolerance. The middle of each range of a
rerun lies in the stated range of the same change, or of one that overlaps it. Target: at least 95 %.

Verdicts: `python benchmarks/intervals.py verdicts [RERUNS]` (default 9) judges the paper's claims with the effort of
`gelcone paper --quick` again from starts 1e-12 to 1e-9 apart, and prints how often each verdict came out as at first.
Each run is added to ``docs/verdicts.csv``, from which the README's table is made; a benchmark that was stopped goes on
there. Target: always.

Lifetimes: points at which chaos ends. The interval that `gelcone regime` states for several starts is held against the
mean lifetime of 256 other starts, whose own error is added. Target: at least 95 %.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from classification import unlabelled

from gelcone import __version__
from gelcone.atlas.bifurcation import bifurcation, thresholds_of
from gelcone.codes import Outcome, Regime
from gelcone.motion.attractor.classification import MEASURE_TOLERANCE, classify
from gelcone.motion.attractor.lifetime import SETTLING
from gelcone.motion.attractor.search import follow
from gelcone.motion.exponents import average
from gelcone.motion.settle import repeats_lasting, settle
from gelcone.paper.effort import QUICK
from gelcone.paper.run import source_paper
from gelcone.paper.studies.diagrams import PANELS
from gelcone.paper.verdicts import judge
from gelcone.physics.members import Members
from gelcone.presets import Preset, find_preset

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
    """Several states near one."""
    return state + SPREAD * rng.normal(size=(count, state.size))


def exponents(members: Members, initial: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Deviation of each point's test runs from its reference in standard errors, (points * RUNS,)."""
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
    """Chaotic members of which all nearby starts are still chaotic after the reference time."""
    found = classify(members, initial, patience=20_000.0)
    rows = np.flatnonzero((found.regime == Regime.CHAOTIC) & (found.outcome == Outcome.OK) & members.damped)
    several = members.take(np.repeat(rows, REFERENCES))
    states = np.concatenate([near(rng, initial[row], REFERENCES) for row in rows])
    run, _ = follow(several, states, repeats_lasting(several, REFERENCE_BUDGET), tolerance=TOLERANCE)
    lasts = ((run.period == 0) & (run.outcome == Outcome.OK)).reshape(-1, REFERENCES).all(axis=1)
    return rows[lasts]


def lifetimes(members: Members, initial: np.ndarray, rng: np.random.Generator) -> tuple[int, int]:
    """Number of stated intervals that hold the mean lifetime of the other starts, and their total."""
    held = tried = 0
    for row in range(members.size):
        runs = members.take(np.full(LIFETIME_RUNS, row))
        stated = classify(runs, near(rng, initial[row], LIFETIME_RUNS))
        known = stated.regime == Regime.TRANSIENT_CHAOS
        if not known.any():
            continue
        horizon = 4.0 * float(np.median(stated.lifetime[known]))
        many = members.take(np.full(STARTS, row))
        run, _ = follow(
            many, near(rng, initial[row], STARTS), repeats_lasting(many, min(horizon, 40_000.0)), tolerance=TOLERANCE
        )
        ended = run.period > 0
        lag = SETTLING / min(float(-stated.exponents[known][0, 0]), float(members.number("damping_ratio")[row]))
        whole = min(horizon, 40_000.0)
        times = np.maximum(np.where(ended, run.away - lag, whole - 2.0 * lag), 0.0)
        mean, share = times.sum() / max(ended.sum(), 1), 2.0 / np.sqrt(max(ended.sum(), 1))
        low, high = stated.lifetime_low[known], stated.lifetime_high[known]
        held += int(((low <= mean * (1.0 + share)) & (high >= mean * (1.0 - share))).sum())
        tried += int(known.sum())
    return held, tried


DIAGRAMS = (("fast", "stretch_limit", np.geomspace(1.2, 2.4, 15)), ("base", "voltage", np.linspace(0.9, 1.15, 15)))
STARTS_APART = (1e-12, -1e-11, 1e-10, 1e-9)


def ranges(preset: str, parameter: str, values: np.ndarray, off: float, tolerance: float) -> list[dict[str, Any]]:
    found = find_preset(preset)
    voltage = {} if parameter == "voltage" else {"voltage": PANELS[preset, parameter]}
    start = (found.initial[0] + off, found.initial[1])
    model = found.model.replace(**voltage)
    return thresholds_of(
        bifurcation(model, parameter, values, start, sweeps=(), tolerance=tolerance, patience=25_000.0)
    )


def thresholds() -> tuple[int, int]:
    """Number of rerun thresholds that lie in a stated range, and their total."""
    held = tried = 0
    for diagram in DIAGRAMS:
        stated = ranges(*diagram, 0.0, 1e-15)
        resolution = float(np.diff(diagram[2]).max()) / 256.0
        for off, tolerance in zip(STARTS_APART, (1e-15, 1e-14, 1e-15, 1e-13), strict=True):
            for row in ranges(*diagram, off, tolerance):
                middle = 0.5 * (row["low"] + row["high"])
                held += any(own["low"] - resolution <= middle <= own["high"] + resolution for own in stated)
                tried += 1
    return held, tried


VERDICTS = Path(__file__).parents[1] / "docs" / "verdicts.csv"


def verdicts(reruns: int = 9) -> int:
    """Prints how often each verdict of the quick run stays the same from other starts."""
    seen: list[dict[str, str]] = []
    if VERDICTS.exists():
        with VERDICTS.open(encoding="utf-8", newline="") as file:
            seen = list(csv.DictReader(file))
    for k in range(len(seen), reruns + 1):
        off = (-1.0) ** k * (1 + (k - 1) // 4) * 10.0 ** (-12 + (k - 1) % 4) if k else 0.0  # no start twice
        with moved_starts(off):
            seen.append({"start": f"{off:g}", "version": __version__, **judged_once()})
        with VERDICTS.open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, list(seen[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(seen)
    same = {name: sum(other[name] == seen[0][name] for other in seen[1:]) for name in source_paper().claims}
    for name, count in same.items():
        print(f"{name:22s} {seen[0][name]:28s} the same in {count} of {reruns} reruns")
    return int(any(count < reruns for count in same.values()))


def judged_once() -> dict[str, str]:
    """The verdict on each claim, with the paper's own film."""
    paper = source_paper()
    studies = {name: study.compute(QUICK, lambda share: None) for name, study in paper.studies.items()}
    found = {name: claim.check({own: studies[own] for own in claim.studies}) for name, claim in paper.claims.items()}
    return {name: judge(finding).value for name, finding in found.items()}


@contextmanager
def moved_starts(off: float) -> Iterator[None]:
    """All parameter sets of the paper start a little apart."""
    unmoved = find_preset  # this module's own name is replaced too
    changed = {module: module.find_preset for module in list(sys.modules.values()) if hasattr(module, "find_preset")}

    def moved(name: str) -> Preset:
        found = unmoved(name)
        return replace(found, initial=(found.initial[0] + off, found.initial[1]))

    for module in changed:
        module.find_preset = moved  # type: ignore[attr-defined]
    try:
        yield
    finally:
        for module, own in changed.items():
            module.find_preset = own  # type: ignore[attr-defined]


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
    held, tried = thresholds()
    right &= held >= 0.95 * tried
    print(f"thresholds: {held} of {tried} of other starts and tolerances lie in a stated range")
    return 0 if right else 1


if __name__ == "__main__":
    if sys.argv[1:2] == ["verdicts"]:
        sys.exit(verdicts(*(int(argument) for argument in sys.argv[2:])))
    sys.exit(main(*(int(argument) for argument in sys.argv[1:])))
