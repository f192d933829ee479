"""Coverage of the intervals of device fits, with simulated devices, instruments and noise.

    python benchmarks/fit_coverage.py [taut|wrinkling|wrong] [REPEATS] [SEED]      (default taut 200 0)

taut: film taut in all tests. wrinkling: its hoops turn slack within the tests. wrong: a taut film fitted to data of one
that wrinkles. Printed are the shares of fields and gains, and of predictions, within their 95 % intervals, the share of
fits that chi2 refuses, and the time of a fit.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from gelcone.errors import InputError
from gelcone.lab.bench import DeviceTest
from gelcone.lab.device_fit import REFUSED, STEP, FittedDevice, Problem, fit_problem
from gelcone.lab.predictions import predicted_values, read_predictions
from gelcone.statistics import wilson
from tests.lab.certified import TAUT, WRINKLING, problem

CASES = {"taut": (TAUT, "taut", "taut"), "wrinkling": (WRINKLING, "wrinkling", "wrinkling"),
         "wrong": (WRINKLING, "wrinkling", "taut")}  # fmt: skip
PREDICTED = ("stroke@1.5 kV", "natural frequency@1 kV", "blocked force@1.5 kV")
MOST_TRIES = 20


def measured(own: Problem, rng: np.random.Generator) -> tuple[np.ndarray, tuple[DeviceTest, ...]]:
    """True deviations that have a state in all tests, and tests with their readings and noise."""
    for _ in range(MOST_TRIES):
        truth = own.priors * np.clip(rng.standard_normal(own.priors.size), -2.5, 2.5)
        readings = own.predict(truth[None])[0]
        if np.isfinite(readings).all():
            break
    noisy, at, tests = readings + own.noise * rng.standard_normal(own.noise.size), 0, []
    for test in own.tests:
        read = {}
        for name, old in test.read.items():
            read[name], at = noisy[at : at + old.size], at + old.size
        tests.append(replace(test, read=read))
    return truth, tuple(tests)


def predictions(fitted: FittedDevice, truth: np.ndarray, true: Problem) -> list[bool]:
    """Whether each prediction's interval holds the value of the true device."""
    count, found = len(fitted.problem.free), []
    steps = np.concatenate([np.zeros((1, count)), STEP * np.eye(count)]) + fitted.logs[:count]
    for asked in read_predictions(PREDICTED):
        values = predicted_values(fitted.problem, steps, asked)
        slopes = (values[1:] - values[0]) / STEP
        spread = float(np.sqrt(slopes @ fitted.covariance[:count, :count] @ slopes))
        known = float(predicted_values(true, truth[None, :count], asked)[0])
        found.append(bool(abs(values[0] - known) <= 1.96 * spread))
    return found


def main(case: str = "taut", repeats: int = 200, seed: int = 0) -> None:
    data, film, fitted_film = CASES[case]
    own, other = problem(data, film), problem(data, fitted_film)
    inside, predicted, refused, lost = [], [], 0, 0
    begun = time.process_time()
    for k in range(repeats):
        truth, tests = measured(own, np.random.default_rng([seed, k]))
        try:
            fitted = fit_problem(Problem(other.device, other.free, tests, other.gains))
        except InputError:  # no state at a measured value: refused, too
            lost += 1
            continue
        refused += fitted.p_value < REFUSED
        inside.append(np.abs(fitted.logs - truth) <= 1.96 * np.sqrt(np.diag(fitted.covariance)))
        predicted.append(predictions(fitted, truth, own))
    took = (time.process_time() - begun) / repeats
    print(f"{case}: {len(inside)} fits, {took:.2f} s of processor each; {lost} without a state")
    print(f"refused by chi2 at {REFUSED:.0%}: {refused / max(len(inside), 1):.1%}")
    shares = np.mean(inside, axis=0)
    low, high = (float(end) for end in wilson(np.mean(inside), np.size(inside)))
    each = f"{shares.min():.1%} to {shares.max():.1%}"
    print(f"fields and gains: {np.mean(inside):.1%} ({low:.1%} to {high:.1%}), each {each}")
    for name, share in zip(PREDICTED, np.mean(predicted, axis=0), strict=True):
        print(f"{name}: {share:.1%}")


if __name__ == "__main__":
    kind, *numbers = sys.argv[1:] or ["taut"]
    main(kind, *map(int, numbers))
