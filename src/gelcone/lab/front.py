"""Search of designs along the objectives of a wish, on closed forms.

Every requirement and every limit has a signed margin, positive if it is missed. A design is feasible if the largest
margin is negative in the wished share of draws of the tolerances, which are the same for all designs.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from gelcone.devices.device import Device
from gelcone.devices.units import format_si
from gelcone.errors import InputError
from gelcone.lab.candidates import LIMITS, Found, draws_of, examine
from gelcone.lab.wish import Objective, Wish
from gelcone.progress import Progress, weighted
from gelcone.quantity import Array

POPULATION, GENERATIONS, AGAIN = 64, 60, 40
"""Designs of a search, generations of the first search, and of searches that start from the last population."""
DRAWS, NEW_DRAWS = 128, 4096
"""Draws of the tolerances in a search, and new ones for the probability of a design."""
EXTRA = 0.02
"""Confidence added to the wished one in a search, since a search overfits its draws."""
ROWS = 6
SHORT = 15
"""Generations of a search with a weaker requirement."""
HOPELESS = 0.3
"""Nominal margin above which a design is not evaluated under its tolerances."""
MISSED, WORSE = 1e6, 1e9
"""Fitness of designs that miss a requirement under tolerances, and without, over one plus their margin."""
RELAXED = 0.1
DIGITS = 4
"""Significant digits of the fields of a design."""
LOG_RATIO = 3.0
"""Ratio of the bounds of a field above which it is searched by its logarithm."""


@dataclass(frozen=True)
class Problem:
    """A wish to be searched with ``draws`` of its tolerances; 1 stands for no uncertainty. ``pull_in`` is the share of
    the cone's lowest limit that the film of the wish withstands, ``ratios`` the numbers of that film over those of the
    closed forms, ``extra`` the confidence beyond the wished one, ``levels`` upper bounds of objectives, and ``relaxed``
    the name of a requirement that is 10 % weaker."""

    wish: Wish
    draws: int = DRAWS
    seed: int = 0
    pull_in: float = 1.0
    ratios: Mapping[str, float] = field(default_factory=dict)
    extra: float = EXTRA
    levels: tuple[tuple[Objective, float], ...] = ()
    relaxed: str = ""

    @cached_property
    def names(self) -> list[str]:
        """The free fields."""
        return list(self.wish.free)

    @cached_property
    def device(self) -> Device:
        """The device with a film that bears compression, which equals the wrinkling one as long as it is taut."""
        return self.wish.device.replace_quietly(film="taut")

    @cached_property
    def normal(self) -> Array:
        """Draws of the uncertain fields in units of their standard deviations, (draws, uncertain fields)."""
        count = self.wish.uncertain
        return draws_of(count, self.draws, self.seed) if self.draws > 1 else np.zeros((1, count))

    def designs(self, unit: Array) -> Array:
        """Map points of the unit cube to designs (designs, fields) in SI."""
        low, high = np.array(list(self.wish.free.values())).T
        logs = (low > 0.0) & (high > LOG_RATIO * np.maximum(low, 1e-300))
        with np.errstate(divide="ignore", invalid="ignore"):
            curved = low * (high / low) ** unit
        return np.where(logs, curved, low + unit * (high - low))

    def found(self, designs: Array, normal: Array) -> Found:
        """Evaluate designs under draws, (designs, draws)."""
        shape = (len(designs), len(normal))
        fields = {name: np.broadcast_to(designs[:, k, None], shape) for k, name in enumerate(self.names)}
        for k, (name, deviation, relative) in enumerate(self.wish.tolerances):
            value = fields.get(name, np.broadcast_to(float(self.device.get(name)), shape))
            share = deviation if relative else deviation / np.maximum(np.abs(value), 1e-300)
            fields[name] = value * np.exp(share * normal[:, k])
        logs = normal[:, len(self.wish.tolerances) :] @ self.wish.samples.root.T
        for name, log in zip(self.wish.samples.names, logs.T, strict=True):
            fields[name] = fields.get(name, np.broadcast_to(float(self.device.get(name)), shape)) * np.exp(log)
        examined = examine(self.device, fields, 1.0 / (1.0 - self.wish.margin))
        return examined._replace(
            values={name: self.ratios.get(name, 1.0) * column for name, column in examined.values.items()}
        )

    def nominal(self, designs: Array) -> Found:
        """Evaluate designs without uncertainty, (designs, 1)."""
        return self.found(designs, np.zeros((1, self.wish.uncertain)))

    def margins(self, found: Found) -> dict[str, Array]:
        """The signed margin of each requirement and limit, at most 1, positive where it is missed."""
        margins = {}
        for name, least, bound in self.wish.requirements:
            relaxed_bound = bound * (1.0 + (-RELAXED if least else RELAXED) * (name == self.relaxed))
            value = found.values[name]
            margins[name] = 1.0 - value / relaxed_bound if least else value / relaxed_bound - 1.0
        highest = (1.0 - self.wish.margin) * (1.0 + RELAXED * (self.relaxed == "limits")) * self.pull_in
        for name, limit in zip(LIMITS, found.limits, strict=True):
            margins[name] = found.values["peak_voltage"] / (highest * limit) - 1.0
        if self.draws > 1:
            margins["swing beyond the film's limits"] = found.failing
        return {name: np.where(np.isnan(margin), 1.0, np.minimum(margin, 1.0)) for name, margin in margins.items()}

    def objective(self, designs: Array, found: Found, worst: Array, which: Objective) -> Array:
        """An objective of designs, the smaller the better; ``worst``, the margin under draws, replaces a
        probability."""
        if which.name == "probability":
            return worst
        if which.name in found.values:
            value = found.values[which.name][:, 0]
        elif which.name in self.names:
            value = designs[:, self.names.index(which.name)]
        else:
            value = np.full(len(designs), float(self.device.get(which.name)))
        return -value if which.largest else value

    def robust(self, margins: Mapping[str, Array]) -> Array:
        """The quantile of the largest margin at the wished confidence, (designs,)."""
        worst = np.max(list(margins.values()), axis=0)
        share = min(self.wish.confidence + self.extra, 1.0 - 0.5 / self.draws)
        return np.quantile(worst, share, axis=1) if worst.shape[1] > 1 else worst[:, 0]

    def fitness(self, unit: Array, which: Objective) -> Array:
        """The number that a search minimises: the objective of feasible designs; for all others a larger number that
        grows with their margin."""
        designs = self.designs(unit)
        nominal = self.nominal(designs)
        worst = self.robust(self.margins(nominal))
        fitness = WORSE * (1.0 + worst)
        near = np.flatnonzero(worst <= HOPELESS)
        if not near.size:
            return fitness
        margins = worst[near] if self.draws == 1 else self.robust(self.margins(self.found(designs[near], self.normal)))
        few = Found({k: v[near] for k, v in nominal.values.items()}, nominal.limits[:, near], nominal.failing[near])
        for objective, level in self.levels:
            value = self.objective(designs[near], few, margins, objective)
            margins = np.maximum(margins, np.minimum((value - level) / abs(level), 1.0) if level else value)
        value = self.objective(designs[near], few, margins, which)
        fitness[near] = np.where((margins <= 0.0) | (which.name == "probability"), value, MISSED * (1.0 + margins))
        return fitness

    def search(
        self,
        which: Objective,
        start: Array | None = None,
        generations: int = GENERATIONS,
        progress: Progress = None,
    ) -> tuple[Array, Array, float]:
        """Search by differential evolution: the best design in the unit cube, the last population, and the fitness."""
        from scipy.optimize import differential_evolution

        population, report = self._population(start), weighted(progress, 1.0 / generations)
        optimum = differential_evolution(
            lambda unit: self.fitness(unit.T, which), [(0.0, 1.0)] * len(self.names), init=population,
            maxiter=generations, tol=0.0, atol=0.0, polish=False, vectorized=True, updating="deferred",
            recombination=0.9, seed=self.seed, callback=None if report is None else lambda *_: report(1.0),
        )  # fmt: skip
        return np.asarray(optimum.x), np.asarray(optimum.population), float(optimum.fun)

    def _population(self, start: Array | None) -> Array:
        """The first population: Sobol points, or three quarters of ``start`` and Sobol points."""
        from scipy.stats import qmc

        points = np.asarray(qmc.Sobol(len(self.names), seed=self.seed).random(POPULATION))
        if start is not None:
            points[: 3 * POPULATION // 4] = start[: 3 * POPULATION // 4]
        return points


def feasible(fitness: float) -> bool:
    """Whether the best fitness of a search is that of a feasible design."""
    return fitness < MISSED


def front(wish: Wish, seed: int, nominal: bool, progress: Progress) -> list[tuple[Problem, Array, Array]]:
    """Search designs along the objectives, with the problem and the last population of each; `InputError` if none is
    feasible."""
    problem = Problem(wish, 1 if nominal or not wish.uncertain else DRAWS, seed)
    first, *others = wish.objectives
    best, population, fitness = problem.search(first, progress=weighted(progress, 0.3))
    if not feasible(fitness) and first.name != "probability":
        best, population, fitness = problem.search(first, with_best(population, best), AGAIN)
    if not feasible(fitness):
        raise InputError(closest(problem, best))
    designs = [(problem, best, population)]
    if not others:
        return designs
    second = others[-1]
    ends = [objective_of(problem, best, objective) for objective in others]
    last, population, _ = problem.search(second, with_best(population, best), progress=weighted(progress, 0.1))
    lowest = objective_of(problem, last, second)
    for level in levels_between(ends[-1], lowest):
        bounded = replace(problem, levels=((second, level),))
        if len(others) > 1:
            bounded = replace(bounded, levels=(*bounded.levels, (others[0], ends[0])))
        part = weighted(progress, 0.6 / (ROWS - 1))
        best, population, fitness = bounded.search(first, with_best(population, last), AGAIN, part)
        if feasible(fitness):
            designs.append((bounded, best, population))
    return designs


def with_best(population: Array, best: Array) -> Array:
    """Put a design in front of a population."""
    return np.concatenate([best[None], population])[:POPULATION]


def levels_between(high: float, low: float) -> Array:
    """Levels of the second objective, between its value at the best design of the first and its own best."""
    low = low + 0.02 * abs(low)
    if not low < high:
        return np.array([])
    spaced = np.geomspace(high, low, ROWS) if low > 0.0 else np.linspace(high, low, ROWS)
    return np.asarray(spaced[1:])


def objective_of(problem: Problem, unit: Array, which: Objective) -> float:
    """An objective of one design, the smaller the better."""
    designs = problem.designs(unit[None])
    worst = problem.robust(problem.margins(problem.found(designs, problem.normal)))
    return float(problem.objective(designs, problem.nominal(designs), worst, which)[0])


def fields_of(problem: Problem, unit: Array) -> dict[str, float]:
    """The free fields of a design, in SI."""
    return {n: float(f"{v:.{DIGITS}g}") for n, v in zip(problem.names, problem.designs(unit[None])[0], strict=True)}


def probability_of(problem: Problem, unit: Array, seed: int) -> tuple[float, float, float]:
    """The share of new draws that meet all requirements, with its 95 % interval (`gelcone.statistics.wilson`)."""
    from gelcone.statistics import wilson

    fresh = replace(problem, draws=NEW_DRAWS, seed=seed, levels=(), relaxed="")
    examined = fresh.found(fresh.designs(unit[None]), fresh.normal)
    met = np.max(list(fresh.margins(examined).values()), axis=0)[0] <= 0.0
    low, high = wilson(met.mean(), met.size)
    return float(met.mean()), float(low), float(high)


def binding_of(problem: Problem, unit: Array) -> str:
    """The requirement or limit with the largest margin at the confidence of the search."""
    designs = problem.designs(unit[None])
    margins = problem.margins(problem.found(designs, problem.normal))
    share = min(problem.wish.confidence + problem.extra, 1.0)
    return max(margins, key=lambda name: float(np.quantile(margins[name][0], share)))


def relaxation(problem: Problem, unit: Array, population: Array, binding: str) -> float:
    """The share by which the first objective falls if the binding requirement is 10 % weaker; 0 if it does not."""
    which = problem.wish.objectives[0]
    if which.name == "probability":
        return np.nan
    name = binding if any(one.name == binding for one in problem.wish.requirements) else "limits"
    weaker = replace(problem, relaxed=name)
    _, _, fitness = weaker.search(which, with_best(population, unit), SHORT)
    before = objective_of(problem, unit, which)
    return max((before - fitness) / abs(before), 0.0) if feasible(fitness) else 0.0


def closest(problem: Problem, unit: Array) -> str:
    """The message that no design is feasible, with the closest one, its binding requirement and the bounds it
    touches."""
    wish = problem.wish
    nominal = problem.nominal(problem.designs(unit[None]))
    limit = float(np.nanmin(nominal.limits[:, 0, 0], initial=np.inf))
    peak = float(nominal.values["peak_voltage"][0, 0])
    margin = "no limit met" if not np.isfinite(limit) else f"margin {100.0 * (1.0 - peak / limit):.0f} %"
    at_ends = [
        f"raise {name} above {_shown(problem, name, high)}"
        if share > 0.5
        else f"lower {name} below {_shown(problem, name, low)}"
        for (name, (low, high)), share in zip(wish.free.items(), unit, strict=True)
        if min(share, 1.0 - share) < 0.02
    ]
    binding = binding_of(problem, unit)
    remedy = " or ".join(at_ends[:2]) or "widen the bounds"
    stroke = 1e3 * float(nominal.values["stroke"][0, 0])
    return (
        f"design: no design within the bounds meets all with a margin of {100.0 * wish.margin:.0f} % at a confidence "
        f"of {100.0 * wish.confidence:.0f} %; the closest: {margin}, stroke {stroke:.2g} mm; it is bound by {binding}; "
        f"{remedy}, or weaken a requirement"
    )


def _shown(problem: Problem, name: str, value: float) -> str:
    """A value of a field with its unit."""
    return format_si(value, problem.device.swept_fields()[name].unit)


def dominated(values: Array) -> Any:
    """Mask of the rows of (rows, objectives), the smaller the better, that another row dominates."""
    better = (values[:, None] <= values[None]).all(axis=2) & (values[:, None] < values[None]).any(axis=2)
    return better.any(axis=0)
