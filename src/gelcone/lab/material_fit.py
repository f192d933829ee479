"""Fits of laws and Maxwell branches to tests on coupons, and the choice among them by predicting tests left out.

All tests have equal weight; residuals are in units of 3 % of the largest stress of a test. Positive parameters are
fitted by their logarithms. The stress is linear in the moduli; relaxation times enter through a spline over a grid.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from gelcone.errors import InputError
from gelcone.lab.coupons import Coupon
from gelcone.lab.stress import (
    branch_stresses,
    field_stress,
    known_width,
    law_stress,
    relaxation_grid,
    squared_lengths,
)
from gelcone.physics.laws import LAWS, StrainEnergyLaw
from gelcone.progress import Counted, Progress
from gelcone.quantity import Array
from gelcone.statistics import CONFIDENCE

NOISE = 0.03
"""Standard deviation of a residual over the largest stress of its test."""
GAIN = 0.03
"""Standard deviation of the gain of the load cell from test to test, for intervals of the parameters."""
BEYOND = 1.2
"""Multiple of the largest measured strain I1 - 3 up to which the law must stay stiff."""
LEAST_RESPONSE, STIFF_POINTS, STIFF_WEIGHT = 0.02, 24, 100.0
STARTS = 3
"""Number of relaxation times from which a fit with one more branch starts."""
COARSE = 4
"""Step between the relaxation times of the grid that are tried for a start."""


class Curves(NamedTuple):
    """Samples of several tests in a row: squared stretches ``m`` and ``width``, measured ``stress``, stress of the
    ``field``, ``scale`` of the residual, and index of the ``test``."""

    m: Array
    width: Array
    stress: Array
    field: Array
    scale: Array
    test: Any


class Tabulated:
    """Tests with the stresses of branches over a grid of relaxation times, as a spline in the logarithm of the time."""

    def __init__(self, tests: Sequence[Coupon], flow: str, permittivity: float, progress: Progress = None) -> None:
        from scipy.interpolate import CubicSpline

        for test in tests:
            if not known_width(test):
                raise InputError(
                    f"{test.name}: its width is free under a voltage: it can be predicted, not fitted; set use = "
                    '"check" for its file in tests.toml'
                )
        self.tests: list[Coupon] = list(tests)
        parts = [_curves(k, test, permittivity) for k, test in enumerate(tests)]
        self.curves: Curves = Curves(*(np.concatenate(column) for column in zip(*parts, strict=True)))
        self.grid: Array = relaxation_grid(self.tests)
        counted, rows = Counted(progress), []
        for test in tests:
            rows.append(branch_stresses(test, self.grid, flow))
            counted(0.4 / len(tests))
        self.spline: Any = CubicSpline(np.log(self.grid), np.concatenate(rows, axis=1)) if self.grid.size else None
        self.slopes: Any = None if self.spline is None else self.spline.derivative()

    @property
    def farthest(self) -> float:
        """The largest I1 - 3 of the samples."""
        m, width = self.curves.m, self.curves.width
        return float(np.max(m + width + 1.0 / (m * width) - 3.0))


def _curves(k: int, test: Coupon, permittivity: float) -> Curves:
    m, width = squared_lengths(test, test.stretch)
    scale = np.full(m.size, NOISE * largest(test) * np.sqrt(m.size))
    return Curves(m, width, test.stress, field_stress(test, permittivity, m, width), scale, np.full(m.size, k))


def largest(test: Coupon) -> float:
    """The largest absolute stress of a test, Pa; `InputError` for a test without stress."""
    most = float(np.abs(test.stress).max())
    if not most > 0.0:
        raise InputError(f"{test.name}: all stresses are 0; leave it out")
    return most


@dataclass(frozen=True)
class Fitted:
    """A fitted ``candidate`` with its parameters ``theta``, and the ``cost`` of the fit."""

    candidate: Candidate
    theta: Array
    cost: float


class Candidate:
    """A law with ``count`` branches, to be fitted to tabulated tests.

    Its parameters theta are the logarithm of the shear modulus, those of the law (logarithms where they must be
    positive), and the logarithms of all branch moduli and of all relaxation times.
    """

    def __init__(self, law: str, count: int, data: Tabulated) -> None:
        self.law: StrainEnergyLaw = LAWS[law]
        self.count: int = count
        self.data: Tabulated = data
        self.names: list[str] = list(self.law.parameters)
        self.logarithmic: list[bool] = [self.law.parameters[name].positive for name in self.names]
        strain = data.farthest
        self.strains: Array = np.linspace(0.0, BEYOND * strain, STIFF_POINTS)
        sizes = [1.0 if log else 1.0 / strain ** (k + 1) for k, log in enumerate(self.logarithmic)]
        self.sizes: Array = np.array(sizes)

    def numbers(self, theta: Array) -> dict[str, float]:
        """The parameters of the law by name."""
        law_theta = theta[1 : 1 + len(self.names)]
        return {
            name: float(np.exp(v)) if log else float(v * size)
            for name, v, log, size in zip(self.names, law_theta, self.logarithmic, self.sizes, strict=True)
        }

    def branches(self, theta: Array) -> tuple[Array, Array]:
        """Moduli in Pa and relaxation times in s, sorted by the times."""
        moduli, times = self._split(theta)
        order = np.argsort(times)
        return np.exp(moduli[order]), np.exp(times[order])

    def _split(self, theta: Array) -> tuple[Array, Array]:
        branch_logs = theta[1 + len(self.names) :]
        return branch_logs[: self.count], branch_logs[self.count :]

    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest theta."""
        strain = self.data.farthest
        least = [np.log(1.02 * BEYOND * strain) if log else -np.inf for log in self.logarithmic]
        most = [np.log(1e4 * strain) if log else np.inf for log in self.logarithmic]
        grid = np.log(self.data.grid[[0, -1]]) if self.count else np.zeros(2)
        low = [-np.inf, *least, *[-20.0] * self.count, *[grid[0]] * self.count]
        high = [np.inf, *most, *[40.0] * self.count, *[grid[1]] * self.count]
        return np.array(low), np.array(high)

    def shape(self, own: Array) -> Array:
        """Stress of the law over its modulus at all samples, at its own part of theta."""
        n = self.law.numbers(self.law.complete(self.numbers(np.concatenate([[0.0], own]))))
        return law_stress(self.law, n, self.data.curves.m, self.data.curves.width)

    def stress(self, theta: Array) -> Array:
        """The stress at all samples."""
        moduli, times = self._split(theta)
        stress = np.exp(theta[0]) * self.shape(theta[1 : 1 + len(self.names)]) + self.data.curves.field
        return stress + np.exp(moduli) @ self.data.spline(times) if self.count else stress

    def slopes(self, theta: Array) -> Array:
        """Derivatives of the stress by theta, (samples, parameters)."""
        law_theta, mu = theta[1 : 1 + len(self.names)], np.exp(theta[0])
        columns = [mu * self.shape(law_theta)]
        for k in range(law_theta.size):
            step = np.zeros(law_theta.size)
            step[k] = 1e-5 * max(1.0, abs(law_theta[k]))
            columns.append(mu * (self.shape(law_theta + step) - self.shape(law_theta - step)) / (2.0 * step[k]))
        if self.count:
            moduli, times = self._split(theta)
            columns += list(np.exp(moduli)[:, None] * self.data.spline(times))
            columns += list(np.exp(moduli)[:, None] * self.data.slopes(times))
        return np.stack(columns, axis=1)

    def softness(self, theta: Array) -> Array:
        """Penalty of a soft law: the weighted shortfall of its response below the least allowed one, at each strain."""
        n = self.law.numbers(self.law.complete(self.numbers(theta)))
        response = np.broadcast_to(self.law.response(self.strains, n), self.strains.shape)
        return STIFF_WEIGHT * np.maximum(LEAST_RESPONSE - response, 0.0)

    def refine(self, theta: Array, weight: Array, gain: Array | None = None) -> Fitted:
        """Fit from ``theta`` with weights of the tests, (tests,); stresses are multiplied by the ``gain`` of their
        test."""
        from scipy.optimize import least_squares

        low, high = self.bounds()
        curves = self.data.curves
        scale = np.sqrt(weight)[curves.test] / curves.scale
        measured = curves.stress if gain is None else curves.stress * gain[curves.test]

        def residuals(t: Array) -> Array:
            return np.concatenate([scale * (self.stress(t) - measured), self.softness(t)])

        def jacobian(t: Array) -> Array:
            h, softness_slopes = 1e-6, np.zeros((STIFF_POINTS, t.size))
            if self.softness(t).any():
                for k in range(1, 1 + len(self.names)):
                    step = np.zeros(t.size)
                    step[k] = h
                    softness_slopes[:, k] = (self.softness(t + step) - self.softness(t - step)) / (2.0 * h)
            return np.concatenate([scale[:, None] * self.slopes(t), softness_slopes])

        start = np.clip(theta, low + 1e-9, high - 1e-9)
        optimum = least_squares(residuals, start, jacobian, (low, high), x_scale="jac", ftol=1e-9, xtol=1e-9, gtol=1e-9)
        return Fitted(self, optimum.x, float(2.0 * optimum.cost))

    def first(self, weight: Array) -> Fitted:
        """Fit without branches."""
        theta = np.zeros(1 + len(self.names))
        for k, log in enumerate(self.logarithmic):
            theta[1 + k] = np.log(5.0 * BEYOND * self.data.farthest) if log else 0.0
        moduli, _ = _moduli(self, theta, np.empty(0), weight)
        theta[0] = np.log(max(moduli[0], 1e-3))
        return self.refine(theta, weight)

    def after(self, before: Fitted, weight: Array) -> Fitted:
        """Fit one branch more than another fit of the same law has, from the relaxation times that fit best."""
        law = before.theta[: 1 + len(self.names)]
        times = before.candidate._split(before.theta)[1]
        tried = []
        for time in np.log(self.data.grid[::COARSE]):
            moduli, residual = _moduli(self, law, np.append(times, time), weight)
            tried.append((residual, time, moduli))
        tried.sort(key=lambda entry: entry[0])
        fits = []
        for _, time, moduli in tried[:STARTS]:
            moduli = np.log(np.maximum(moduli, 1e-3 * moduli.max()))
            start = np.concatenate([[moduli[0]], law[1:], moduli[1:], times, [time]])
            fits.append(self.refine(start, weight))
        return min(fits, key=lambda entry: entry.cost)


def _moduli(candidate: Candidate, law: Array, times: Array, weight: Array) -> tuple[Array, float]:
    """The non-negative moduli that fit best at given relaxation times and shape of the law, and the norm of the
    residuals."""
    from scipy.optimize import nnls

    data, curves = candidate.data, candidate.data.curves
    scale = np.sqrt(weight)[curves.test] / curves.scale
    columns = [candidate.shape(law[1:]), *(data.spline(times) if times.size else ())]
    moduli, residual = nnls(scale[:, None] * np.stack(columns, axis=1), scale * (curves.stress - curves.field))
    return moduli, float(residual)


# --- all candidates ---------------------------------------------------------------------------------------------------


class Compared(NamedTuple):
    """A candidate ``fitted`` to all tests, and the stresses ``predicted`` at all samples, of each test by a fit to the
    others."""

    fitted: Fitted
    predicted: Array

    def error(self, left_out: bool) -> float:
        """The mean over the tests of the root mean square of the residuals, over the largest stress."""
        return float(np.mean(errors_of(self.fitted.candidate.data.tests, self.predicted if left_out else self.stress)))

    @property
    def stress(self) -> Array:
        """The fitted stress at all samples."""
        return self.fitted.candidate.stress(self.fitted.theta)


def errors_of(tests: Sequence[Coupon], stress: Array) -> Array:
    """Root mean square of each test's residuals over its largest stress, (tests,), of stresses at the samples of all in
    a row."""
    stresses = np.split(stress, np.cumsum([len(test.stress) for test in tests])[:-1])
    return np.array([np.sqrt(np.mean((s - t.stress) ** 2)) / largest(t) for t, s in zip(tests, stresses, strict=True)])


def compare(
    data: Tabulated, laws: Sequence[str], counts: Sequence[int], progress: Progress = None
) -> dict[tuple[str, int], Compared]:
    """Fit laws with several ``counts`` of branches, and predict each test from the others."""
    tests, compared = len(data.tests), {}
    counted = Counted(progress)
    all_tests = np.ones(tests)
    for law in laws:
        fitted: Fitted | None = None
        for count in range(max(counts) + 1 if data.grid.size else 1):
            candidate = Candidate(law, count, data)
            fitted = candidate.first(all_tests) if fitted is None else candidate.after(fitted, all_tests)
            if count in counts:
                compared[law, count] = Compared(fitted, _left_out(fitted))
            counted(0.5 / len(laws) / (max(counts) + 1))
    return compared


def _left_out(fitted: Fitted) -> Array:
    """The stress at the samples of each test by a fit to all others; NaN with fewer than three tests."""
    candidate, data = fitted.candidate, fitted.candidate.data
    stress = np.full(data.curves.stress.size, np.nan)
    if len(data.tests) < 3:
        return stress
    for k in range(len(data.tests)):
        weight = np.ones(len(data.tests))
        weight[k] = 0.0
        rows = data.curves.test == k
        stress[rows] = candidate.stress(candidate.refine(fitted.theta, weight).theta)[rows]
    return stress


CLOSE = 1.03
"""Factor on the error of the best candidate within which others count as equal."""


def choose(compared: Mapping[tuple[str, int], Compared], most: int) -> tuple[str, int]:
    """Choose the candidate with the fewest branches, at most ``most``, within 3 % of the best prediction error."""
    errors = {key: one.error(True) for key, one in compared.items() if key[1] <= most}
    best = min(errors.values())
    good = [key for key, error in errors.items() if error <= CLOSE * best]
    return min(good, key=lambda key: (key[1], errors[key]))


def bootstrap(fitted: Fitted, draws: int, seed: int, progress: Progress = None) -> Array:
    """Fit theta to tests drawn with replacement, each times a gain drawn from its prior, (draws, parameters)."""
    tests = len(fitted.candidate.data.tests)
    rng, counted = np.random.default_rng(seed), Counted(progress)
    thetas = []
    for _ in range(draws):
        weight = np.bincount(rng.integers(tests, size=tests), minlength=tests).astype(float)
        gain = np.exp(GAIN * rng.standard_normal(tests))
        thetas.append(fitted.candidate.refine(fitted.theta, weight, gain).theta)
        counted(0.1 / draws)
    return np.array(thetas).reshape(draws, fitted.theta.size)


class Band(NamedTuple):
    """Half the ``width`` of the band that covers 95 % of the residuals of tests left out, over the largest stress of a
    test; and the ``mean`` and ``least`` share of a test that the band of the others covers."""

    width: float
    mean: float
    least: float


def band_of(data: Tabulated, predicted: Array) -> Band:
    """Compute the band of predictions from the residuals of tests left out, with equal weights of the tests."""
    test = data.curves.test
    sizes = np.abs(predicted - data.curves.stress) / np.array([largest(t) for t in data.tests])[test]
    covered = []
    for k in range(len(data.tests)):
        others = test != k
        covered.append(float(np.mean(sizes[~others] <= _quantile(sizes[others], test[others]))))
    return Band(_quantile(sizes, test), float(np.mean(covered)), float(np.min(covered)))


def _quantile(sizes: Array, test: Any) -> float:
    """The size that a share `CONFIDENCE` of the residuals does not exceed, with equal weights of the tests."""
    order = np.argsort(sizes)
    counts = np.bincount(test)
    weights = np.cumsum(1.0 / counts[test[order]])
    return float(sizes[order][np.searchsorted(weights, CONFIDENCE * weights[-1])])
