"""Fit of a device to its measurements, and the information in the tests about its fields.

The unknowns are the logarithms of factors on the fields, each with a prior, and of the gain of each instrument.
Intervals are those of the Gauss-Newton approximation with priors and gains.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from gelcone.devices.device import Device
from gelcone.errors import InputError
from gelcone.lab.bench import AMPLIFIER, INSTRUMENTS, DeviceTest, Variants, field_value
from gelcone.motion.static_bifurcations import pull_in_voltage
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.quantity import Array
from gelcone.statistics import Z

STEP = 1e-6
"""Change of a logarithm over which derivatives are taken."""
WIDE = 10.0
"""Standard deviation of the logarithm of a field without a prior, wide enough for any size."""
CLIFF = 100.0
"""Residual, over the noise, where a variant has no equilibrium at a measured voltage."""
RESPONSES_FIRST = 50.0
SWINGING = ("frequency response", "series")
"""Kinds of tests with `RESPONSES_FIRST` times their noise in the first stage of a fit, since a sharp peak or a phase
would trap it."""
STARTS, SPREAD = 3, 0.7
"""Starts of a fit if the film can turn slack, and their spread in units of the priors."""
ROUGH, FINE = 1e-3, 1e-9
"""Relative tolerances of a fit from each start, and of the final fit from the best of these."""
REFUSED = 0.01
"""p-value of chi2 below which the structure is refused."""
MOST_FREE = 24
LEARNT = 1.0
"""Singular value, in units of the priors, above which the tests determine a direction better than the priors."""
EXACT = 1e-5
"""Singular value, over the largest, below which a direction changes no reading."""


SHAPING = {
    "disc_radius", "film_radius", "prestretch", "meridional_prestretch", "hoop_prestretch", "material.stretch_limit",
    "material.yeoh_c2", "material.yeoh_c3",
}  # fmt: skip
"""Fields on which the membrane's numbers depend; all others are scales."""


@dataclass(frozen=True)
class Problem:
    """Tests of a ``device``, whose ``free`` fields, name -> relative standard deviation of the prior, are fitted with
    the ``gains`` of instruments, name -> standard deviation."""

    device: Device
    free: Mapping[str, float]
    tests: tuple[DeviceTest, ...]
    gains: Mapping[str, float]

    def __post_init__(self) -> None:
        if not self.free:
            raise InputError("free: names no field; give some with priors, such as film_thickness with 3 %")
        if len(self.free) > MOST_FREE:
            raise InputError(f"{len(self.free)} fields are free: give at most {MOST_FREE}")
        for name in self.free:
            field_value(self.device, name)
        shaping = sorted(SHAPING & set(self.free))
        if self.device.film == "membrane" and shaping:
            raise InputError(
                f"free {shaping[0]}: the film 'membrane' is computed anew for each value, which takes seconds; leave "
                "it out, or fit with the film wrinkling or taut"
            )

    @cached_property
    def used(self) -> list[str]:
        """The instruments of the tests: those of readings, and the amplifier if there is a voltage."""
        instruments = {reading.instrument for test in self.tests for reading in test.readings}
        volts = any(np.any(values) for test in self.tests for name, values in test.set.items() if "voltage" in name)
        return [name for name in INSTRUMENTS if name in instruments or (name == AMPLIFIER and volts)]

    @property
    def names(self) -> list[str]:
        """Free fields, then gains."""
        return [*self.free, *(f"gain of the {name}" for name in self.used)]

    @cached_property
    def priors(self) -> Array:
        """Standard deviations of all unknowns."""
        return np.array([*self.free.values(), *(self.gains[name] for name in self.used)])

    def variants(self, logs: Array, near: Variants | None = None) -> Variants:
        """Make variants of the device at logarithms of factors, (variants, unknowns), searched from the states of
        ``near``."""
        factors, count = np.exp(logs), len(self.free)
        gains = {name: factors[:, count + k] for k, name in enumerate(self.used)}
        return Variants(self.device, list(self.free), factors[:, :count], gains, near)

    def predict(self, logs: Array) -> Array:
        """Predict all readings, (variants, readings); NaN where a variant has no state."""
        return self._readings(self.variants(logs), None)

    def _readings(self, variants: Variants, tests: Sequence[DeviceTest] | None) -> Array:
        return np.concatenate([variants.predict(test) for test in (self.tests if tests is None else tests)], axis=1)

    def slopes(
        self, logs: Array, tests: Sequence[DeviceTest] | None = None, central: bool = False
    ) -> tuple[Array, Array]:
        """Readings at one set of unknowns, and their derivatives, (readings, unknowns): one-sided differences, on the
        side that has a state, or ``central`` ones."""
        near = self.variants(logs[None])
        (here,) = self._readings(near, tests)
        rise = (self._readings(self.variants(logs + STEP * np.eye(logs.size), near), tests) - here) / STEP
        if central or not np.isfinite(rise[:, np.isfinite(here)]).all():
            fall = (here - self._readings(self.variants(logs - STEP * np.eye(logs.size), near), tests)) / STEP
            both = np.isfinite(rise) & np.isfinite(fall)
            rise = np.where(both, 0.5 * (rise + fall), np.where(np.isfinite(rise), rise, fall))
        return here, np.where(np.isfinite(rise), rise, 0.0).T

    @cached_property
    def values(self) -> Array:
        """All readings."""
        return np.concatenate([test.values for test in self.tests])

    @cached_property
    def noise(self) -> Array:
        """The noise of all readings."""
        return np.concatenate([test.deviations for test in self.tests])


# --- the plan ---------------------------------------------------------------------------------------------------------


class Plan(NamedTuple):
    """The information in tests: standard deviations ``left`` of all unknowns, ``singular`` values of the fields in
    units of their priors, and the ``directions`` of fields that change no reading, one in a row."""

    left: Array
    covariance: Array
    singular: Array
    directions: Array

    @property
    def learnt(self) -> int:
        """The number of directions that the tests determine better than the priors."""
        return int((self.singular > LEARNT).sum())


def plan_of(problem: Problem, logs: Array | None = None) -> Plan:
    """Compute the information of tests about the free fields, which needs no readings."""
    logs = np.zeros(problem.priors.size) if logs is None else logs
    here, slopes = problem.slopes(logs, central=True)
    if not np.isfinite(here).any():
        raise InputError("the device has no state in any of these tests; check voltages and heights")
    scaled = slopes / problem.noise[:, None] * problem.priors
    covariance = np.linalg.inv(scaled.T @ scaled + np.eye(problem.priors.size))
    count = len(problem.free)
    plain = slopes[:, :count] / problem.noise[:, None]
    singular_values = np.linalg.svd(scaled[:, :count], compute_uv=False)
    return Plan(
        problem.priors * np.sqrt(np.diag(covariance)),
        covariance * np.outer(problem.priors, problem.priors),
        np.concatenate([singular_values, np.zeros(count - singular_values.size)]),
        _invariant(plain, list(problem.free)),
    )


SYMMETRIES: tuple[Mapping[str, float], ...] = (
    {"material.shear_modulus": 1.0, "film_thickness": -1.0, "material.relative_permittivity": -1.0},
    {"material.shear_modulus": 1.0, "spring_rate": 1.0, "moving_mass": 1.0, "damping_coefficient": 1.0,
     "material.relative_permittivity": 1.0},
)  # fmt: skip
"""Changes of fields, as exponents, that change no reading: only mu H and eps/H act; and without a force or a known mass
all stiffnesses, mass, damping and eps/H change together."""


def _invariant(slopes: Array, names: Sequence[str]) -> Array:
    """Directions of fields that change no reading: the known symmetries, then all others."""
    _, sizes, rows = np.linalg.svd(slopes)
    sizes = np.concatenate([sizes, np.zeros(len(names) - sizes.size)])
    still = EXACT * sizes.max(initial=1e-300)
    symmetries = [
        np.array([symmetry.get(name, 0.0) for name in names])
        for symmetry in SYMMETRIES
        if symmetry.keys() <= set(names)
    ]
    symmetries = [vector for vector in symmetries if np.linalg.norm(slopes @ vector) < still * np.linalg.norm(vector)]
    unexplained = rows[sizes < still]
    if symmetries:
        basis, _ = np.linalg.qr(np.array(symmetries).T)
        _, kept, others = np.linalg.svd(unexplained - unexplained @ basis @ basis.T)
        unexplained = others[: len(kept)][kept > 0.5]
    return np.concatenate([np.array(symmetries).reshape(-1, len(names)), _simple(unexplained)])


def _simple(directions: Array) -> Array:
    """Combine directions so that they have as many zeros as possible, the largest entry of each being 1."""
    rows = np.array(directions)
    done: list[int] = []
    for k in range(len(rows)):
        free = [j for j in range(rows.shape[1]) if j not in done]
        pivot = max(free, key=lambda j: abs(rows[k, j]))
        done.append(pivot)
        rows[k] /= rows[k, pivot]
        for other in range(len(rows)):
            if other != k:
                rows[other] -= rows[other, pivot] * rows[k]
    largest = [row[np.argmax(np.abs(row))] for row in rows]  # clearing the others' pivots may have made it another
    rows /= np.reshape(largest, (-1, 1))
    rows[np.abs(rows) < 1e-3] = 0.0
    return rows


class Gain(NamedTuple):
    """A further measurement in ``words``, and the ``ratio`` of a prediction's standard deviation with it to that
    without."""

    words: str
    ratio: float


def next_experiments(problem: Problem, readings: Array, logs: Array | None = None) -> list[Gain]:
    """Rank further measurements for a prediction, the best first: four times the rows of each test, each gain
    calibrated to a fifth, each prior halved.

    ``readings`` is the derivative of the prediction by all unknowns.
    """
    logs = np.zeros(problem.priors.size) if logs is None else logs
    _, slopes = problem.slopes(logs)
    rows = np.cumsum([test.values.size for test in problem.tests])[:-1]
    parts = [
        (part / noise[:, None])
        for part, noise in zip(np.split(slopes, rows), np.split(problem.noise, rows), strict=True)
    ]
    weights = 1.0 / problem.priors**2

    def left(information: Array) -> float:
        return float(np.sqrt(readings @ np.linalg.solve(information, readings)))

    base = sum(part.T @ part for part in parts) + np.diag(weights)
    now = left(base)
    gains = [
        Gain(f"four times the rows of: {test.name}", left(base + 3.0 * part.T @ part) / now)
        for test, part in zip(problem.tests, parts, strict=True)
    ]
    for k, name in enumerate(problem.names):
        is_gain = k >= len(problem.free)
        improved = base + np.diag(np.where(np.arange(weights.size) == k, (24.0 if is_gain else 3.0) * weights, 0.0))
        to = "calibrated to" if is_gain else "known to"
        words = f"{name} {to} {(20.0 if is_gain else 50.0) * problem.priors[k]:.2g} %"
        gains.append(Gain(words, left(improved) / now))
    return sorted(gains, key=lambda entry: entry.ratio)


# --- the fit ----------------------------------------------------------------------------------------------------------


class NoStateError(InputError):
    """A structure without a state at a measured value for any fields within the priors."""


class FittedDevice(NamedTuple):
    """A fit: the unknowns ``logs`` with their ``covariance``, the ``predicted`` readings, ``chi2`` over the readings,
    and the ``objective``, chi2 with priors and gains."""

    problem: Problem
    logs: Array
    covariance: Array
    predicted: Array
    chi2: float
    objective: float

    @property
    def p_value(self) -> float:
        """The probability of a larger chi2 if the structure is right."""
        from scipy.stats import chi2

        return float(chi2.sf(self.chi2, self.problem.values.size))

    @property
    def device(self) -> Device:
        """Make the device with the fitted fields."""
        problem = self.problem
        factors = np.exp(self.logs)
        return problem.device.replace(
            {n: field_value(problem.device, n) * float(f) for n, f in zip(problem.free, factors, strict=False)}
        )


def fit_problem(problem: Problem, start: Array | None = None) -> FittedDevice:
    """Fit the free fields, responses at first with wide noise; from several starts if the film can turn slack, or
    roughly from a ``start`` that is near.

    Raises `NoStateError` if no device within the priors has a state at measured values.
    """
    starts = _starts(problem) if start is None else [start]
    kinds = [RESPONSES_FIRST if test.kind in SWINGING else 1.0 for test in problem.tests]
    wide = problem.noise * np.repeat(kinds, [test.values.size for test in problem.tests])
    if start is None:
        starts = _rough(problem, starts, wide)
    best = min(starts, key=lambda candidate: _objective(problem, candidate))
    logs = _least(problem, best, problem.noise, FINE if start is None else ROUGH)
    predicted, slopes = problem.slopes(logs)
    lost = ~np.isfinite(predicted)
    if lost.any():
        raise NoStateError(_without_state(problem, lost))
    scaled = np.concatenate([slopes / problem.noise[:, None], np.diag(1.0 / problem.priors)])
    return FittedDevice(
        problem,
        logs,
        np.linalg.inv(scaled.T @ scaled),
        predicted,
        float(np.sum(((predicted - problem.values) / problem.noise) ** 2)),
        _objective(problem, logs),
    )


def _rough(problem: Problem, starts: Sequence[Array], wide: Array) -> list[Array]:
    """Fit roughly from starts; where films or circuits have states, which is slow, only until chi2 is not refused."""
    from scipy.stats import chi2

    fits, patient = [], problem.device.to_model().system.planar
    enough = float(chi2.isf(REFUSED, problem.values.size))
    for start in starts:
        fits.append(_least(problem, _least(problem, start, wide, ROUGH), problem.noise, ROUGH))
        if not patient and _objective(problem, fits[-1]) < enough:
            break
    return fits


def _without_state(problem: Problem, lost: Any) -> str:
    """The reason why readings cannot be fitted: voltages above every pull-in within the priors, or values without a
    state."""
    steps = 2.0 * np.diag(_narrow(problem))
    factors = np.exp(np.concatenate([steps, -steps])[:, : len(problem.free)])
    with np.errstate(all="ignore"):
        highest = float(np.nanmax(pull_in_voltage(Variants(problem.device, list(problem.free), factors, {}).device)[
            "pull_in_voltage"
        ]))  # fmt: skip
    peaks = np.concatenate([np.tile(_peaks(test), len(test.read)) for test in problem.tests])
    above = lost & (peaks > highest)
    rest = "is the film or the voltage scale right? nothing was fitted"
    if np.isfinite(highest) and above.any():
        return (
            f"{int(above.sum())} of {lost.size} measured voltages lie above the pull-in of every device within the "
            f"priors (highest {highest:,.0f} V): {rest}"
        )
    return f"{int(lost.sum())} of {lost.size} measured values lie where no device within the priors has a state: {rest}"


def _peaks(test: DeviceTest) -> Array:
    """The largest voltage of each row of a test."""
    volts = [np.abs(values) for name, values in test.set.items() if "voltage" in name]
    rows = len(next(iter(test.read.values())))
    peaks = np.sum(volts, axis=0) if volts else 0.0
    return np.broadcast_to(np.max(peaks) if test.kind == "series" else peaks, rows)


def _starts(problem: Problem) -> list[Array]:
    """The starts of a fit: the nominal device, and others within the priors if its film can turn slack."""
    slack = isinstance(problem.device.to_model().system.film, WrinklingCone)
    rng, count = np.random.default_rng(0), problem.priors.size
    draws = [np.clip(rng.standard_normal(count), -1.5, 1.5) for _ in range((STARTS - 1) * slack)]
    return [np.zeros(count), *(SPREAD * draw * _narrow(problem) for draw in draws)]


def _narrow(problem: Problem) -> Array:
    """The priors, no wider than a factor of e."""
    return np.minimum(problem.priors, 1.0)


def _residuals(problem: Problem, logs: Array, noise: Array) -> Array:
    left = (problem.predict(logs[None])[0] - problem.values) / noise
    return np.concatenate([np.where(np.isfinite(left), left, CLIFF), logs / problem.priors])


def _objective(problem: Problem, logs: Array) -> float:
    """The sum of squares that a fit minimises."""
    return float(np.sum(_residuals(problem, logs, problem.noise) ** 2))


def _least(problem: Problem, start: Array, noise: Array, tolerance: float, held: int | None = None) -> Array:
    """Minimise the sum of squares from a start, to a relative tolerance; the unknown ``held`` stays fixed."""
    from scipy.optimize import least_squares

    unit, free = _narrow(problem), np.arange(start.size) != (-1 if held is None else held)

    def whole(z: Array) -> Array:
        logs = start.copy()
        logs[free] = z * unit[free]
        return logs

    def residuals(z: Array) -> Array:
        try:
            return _residuals(problem, whole(z), noise)
        except InputError:  # a trial step to fields that no device may have
            return np.full(noise.size + unit.size, CLIFF)

    def jacobian(z: Array) -> Array:
        slopes = problem.slopes(whole(z))[1] / noise[:, None]
        return (np.concatenate([slopes, np.diag(1.0 / problem.priors)]) * unit)[:, free]

    solution = least_squares(
        residuals, (start / unit)[free], jacobian, xtol=tolerance, ftol=tolerance, gtol=tolerance, max_nfev=100
    )
    return whole(solution.x)


PROFILED, PROFILE_STEPS = Z, 8
"""Root of the rise of the objective at the ends of a 95 % interval, and most refits for each end."""


def profiled(fitted: FittedDevice, name: str) -> tuple[float, float]:
    """Ends of the 95 % interval of an unknown, as deviations of its logarithm: there the objective, minimised over all
    others, has risen by `PROFILED`^2. NaN for an end that is not found."""
    problem, k = fitted.problem, fitted.problem.names.index(name)
    spread = float(np.sqrt(fitted.covariance[k, k]))
    ends = []
    for side in (-1.0, 1.0):
        step, low, high, logs = PROFILED * spread, 0.0, np.inf, fitted.logs
        for _ in range(PROFILE_STEPS):
            begin = logs.copy()
            begin[k] = fitted.logs[k] + side * step
            logs = _least(problem, begin, problem.noise, ROUGH, held=k)
            root = float(np.sqrt(max(_objective(problem, logs) - fitted.objective, 0.0)))
            if abs(root / PROFILED - 1.0) < PROFILE_WITHIN:
                break
            low, high = (step, high) if root < PROFILED else (low, step)
            guess = step * PROFILED / max(root, 0.1 * PROFILED)
            step = guess if low < guess < high else 0.5 * (low + high) if np.isfinite(high) else 2.0 * step
        else:
            step = np.nan
        ends.append(fitted.logs[k] + side * step)
    return ends[0], ends[1]


PROFILE_WITHIN = 0.01
"""Relative error allowed of the root of the rise."""


class LeftOut(NamedTuple):
    """A test predicted from the others: chi2 of its readings, with the uncertainty of the fit, and its p-value."""

    name: str
    chi2: float
    points: int
    p_value: float


def left_out(fitted: FittedDevice) -> list[LeftOut]:
    """Predict each test from a fit to the others, which starts from the fit to all; empty for a single test."""
    from scipy.stats import chi2

    problem, predictions = fitted.problem, []
    for k, test in enumerate(problem.tests if len(problem.tests) > 1 else ()):
        others = Problem(problem.device, problem.free, (*problem.tests[:k], *problem.tests[k + 1 :]), problem.gains)
        start = fitted.logs[[problem.names.index(name) for name in others.names]]
        logs, covariance = _with_all_gains(problem, others, fit_problem(others, start))
        predicted, slopes = problem.slopes(logs, [test])
        spread = np.diag(test.deviations**2) + slopes @ covariance @ slopes.T
        gap = np.where(np.isfinite(predicted), predicted - test.values, CLIFF * test.deviations)
        size = float(gap @ np.linalg.solve(spread, gap))
        predictions.append(LeftOut(test.name, size, gap.size, float(chi2.sf(size, gap.size))))
    return predictions


def _with_all_gains(problem: Problem, others: Problem, fitted: FittedDevice) -> tuple[Array, Array]:
    """Extend the unknowns of a fit to fewer tests to those of all; unused gains have their priors."""
    places = [problem.names.index(name) for name in others.names]
    logs, covariance = np.zeros(problem.priors.size), np.diag(problem.priors**2)
    logs[places] = fitted.logs
    covariance[np.ix_(places, places)] = fitted.covariance
    return logs, covariance
