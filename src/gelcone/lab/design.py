"""Designs that meet a wish in spite of tolerances: searched on closed forms, checked by the analyses.

Every requirement and every limit has a signed margin, positive where it is missed. A design is feasible where the
largest of them is met by the wished share of draws of the tolerances, the same draws for all designs.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gelcone._version import __version__
from gelcone.devices.device import Device
from gelcone.devices.scales import MEASURES
from gelcone.devices.units import format_si
from gelcone.errors import DoubtfulInput, InputError
from gelcone.lab.candidates import LIMITS, Found, draws_of, examine
from gelcone.lab.wish import Objective, Wish, with_samples
from gelcone.motion.envelope import envelope
from gelcone.motion.settled import settled
from gelcone.progress import Counted, Progress, weighted
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

POPULATION, GENERATIONS, AGAIN = 64, 60, 40
"""Designs of a search, generations of the first one, and of those that start from the last one's."""
DRAWS, NEW_DRAWS = 128, 4096
"""Draws of the tolerances in a search, and new ones that give the probability of a design."""
EXTRA = 0.02
"""Confidence beyond the wished one in a search, which fits its draws."""
ROWS = 6
ATTEMPTS = 3
"""Searches of a row, each with the pull-in that the last one's check found."""
SHORT, TRAP = 15, 200
"""Generations of a search with a requirement that is weaker, and of one where nothing is uncertain."""
HOPELESS = 0.3
"""Nominal margin beyond which a design is not examined under its tolerances."""
MISSED, WORSE = 1e6, 1e9
"""What is added to the margin of designs that miss a requirement under tolerances, and already without."""
RELAXED = 0.1
DIGITS = 4
"""Digits of the fields of a design."""
LOG_RATIO = 3.0
"""Bounds with a larger ratio are searched by logarithm."""


@dataclass(frozen=True)
class Problem:
    """A wish with draws of its tolerances, one: none; ``pull_in`` is the membrane's share of the cone's lowest limit,
    ``extra`` the confidence beyond the wished one, ``levels`` upper bounds of objectives, and ``relaxed`` the name of a
    requirement that is 10 % weaker."""

    wish: Wish
    draws: int = DRAWS
    seed: int = 0
    pull_in: float = 1.0
    extra: float = EXTRA
    levels: tuple[tuple[Objective, float], ...] = ()
    relaxed: str = ""

    @cached_property
    def names(self) -> list[str]:
        """The free fields."""
        return list(self.wish.free)

    @cached_property
    def device(self) -> Device:
        """The device with a film that bears compression, as which a film without slack counts."""
        return self.wish.device.replace_quietly(film="taut")

    @cached_property
    def normal(self) -> Array:
        """Draws of what is uncertain in units of its deviations, (draws, uncertain fields)."""
        own = self.wish.uncertain
        return draws_of([1.0] * own, self.draws, self.seed) if self.draws > 1 else np.zeros((1, own))

    def designs(self, unit: Array) -> Array:
        """Designs (designs, fields) in SI, from a cube of unit length."""
        low, high = np.array(list(self.wish.free.values())).T
        logs = (low > 0.0) & (high > LOG_RATIO * np.maximum(low, 1e-300))
        with np.errstate(divide="ignore", invalid="ignore"):
            curved = low * (high / low) ** unit
        return np.where(logs, curved, low + unit * (high - low))

    def found(self, designs: Array, normal: Array) -> Found:
        """What designs do under draws, (designs, draws)."""
        shape = (len(designs), len(normal))
        fields = {name: np.broadcast_to(designs[:, k, None], shape) for k, name in enumerate(self.names)}
        for k, (name, deviation, relative) in enumerate(self.wish.tolerances):
            value = fields.get(name, np.broadcast_to(float(self.device.get(name)), shape))
            share = deviation if relative else deviation / np.maximum(np.abs(value), 1e-300)
            fields[name] = value * np.exp(share * normal[:, k])
        logs = normal[:, len(self.wish.tolerances) :] @ self.wish.samples.root.T
        for name, log in zip(self.wish.samples.names, logs.T, strict=True):
            fields[name] = fields.get(name, np.broadcast_to(float(self.device.get(name)), shape)) * np.exp(log)
        return examine(self.device, fields, 1.0 / (1.0 - self.wish.margin))

    def margins(self, found: Found) -> dict[str, Array]:
        """The signed margin of each requirement and limit, at most 1: positive where it is missed."""
        margins = {}
        for name, least, bound in self.wish.requirements:
            own = bound * (1.0 + (-RELAXED if least else RELAXED) * (name == self.relaxed))
            value = found.values[name]
            margins[name] = 1.0 - value / own if least else value / own - 1.0
        highest = (1.0 - self.wish.margin) * (1.0 + RELAXED * (self.relaxed == "limits")) * self.pull_in
        for name, limit in zip(LIMITS, found.limits, strict=True):
            margins[name] = found.values["peak_voltage"] / (highest * limit) - 1.0
        if self.draws > 1:
            margins["swing beyond the film's limits"] = found.failing
        return {name: np.where(np.isnan(margin), 1.0, np.minimum(margin, 1.0)) for name, margin in margins.items()}

    def objective(self, designs: Array, found: Found, worst: Array, which: Objective) -> Array:
        """An objective of designs, the smaller the better; ``worst``: margin under draws, in place of a probability."""
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
        """The quantile of the largest margin, (designs,)."""
        worst = np.max(list(margins.values()), axis=0)
        share = min(self.wish.confidence + self.extra, 1.0 - 0.5 / self.draws)
        return np.quantile(worst, share, axis=1) if worst.shape[1] > 1 else worst[:, 0]

    def fitness(self, unit: Array, which: Objective) -> Array:
        """What is made smallest: the objective of feasible designs, above it the margin of all others."""
        designs = self.designs(unit)
        nominal = self.found(designs, np.zeros((1, self.wish.uncertain)))
        worst = self.robust(self.margins(nominal))
        fitness = WORSE * (1.0 + worst)
        near = np.flatnonzero(worst <= HOPELESS)
        if not near.size:
            return fitness
        own = worst[near] if self.draws == 1 else self.robust(self.margins(self.found(designs[near], self.normal)))
        few = Found({k: v[near] for k, v in nominal.values.items()}, nominal.limits[:, near], nominal.failing[near])
        for objective, level in self.levels:
            value = self.objective(designs[near], few, own, objective)
            own = np.maximum(own, np.minimum((value - level) / abs(level), 1.0) if level else value)
        value = self.objective(designs[near], few, own, which)
        fitness[near] = np.where((own <= 0.0) | (which.name == "probability"), value, MISSED * (1.0 + own))
        return fitness

    def search(
        self, which: Objective, start: Array | None = None, generations: int = GENERATIONS
    ) -> tuple[Array, Array, float]:
        """The best design in the unit cube, the last population, and its fitness, by differential evolution."""
        from scipy.optimize import differential_evolution

        population = self._population(start)
        found = differential_evolution(
            lambda unit: self.fitness(unit.T, which), [(0.0, 1.0)] * len(self.names), init=population,
            maxiter=generations, tol=0.0, atol=0.0, polish=False, vectorized=True, updating="deferred",
            recombination=0.9, seed=self.seed,
        )  # fmt: skip
        return np.asarray(found.x), np.asarray(found.population), float(found.fun)

    def _population(self, start: Array | None) -> Array:
        """The last population, a quarter of it anew; or Sobol points."""
        from scipy.stats import qmc

        points = np.asarray(qmc.Sobol(len(self.names), seed=self.seed).random(POPULATION))
        if start is not None:
            points[: 3 * POPULATION // 4] = start[: 3 * POPULATION // 4]
        return points


def feasible(fitness: float) -> bool:
    """Whether a search ended with a design that meets all."""
    return fitness < MISSED


def front(wish: Wish, seed: int, nominal: bool, progress: Progress) -> list[tuple[Problem, Array, Array]]:
    """Designs along the objectives, with the problem and the last population of each; `InputError` where none meets
    all."""
    problem = Problem(wish, 1 if nominal or not wish.uncertain else DRAWS, seed)
    progress = progress or (lambda share: None)
    first, *others = wish.objectives
    best, population, fitness = problem.search(first)
    progress(0.3)
    if not feasible(fitness) and first.name != "probability":
        best, population, fitness = problem.search(first, with_best(population, best), AGAIN)
    if not feasible(fitness):
        raise InputError(closest(problem, best))
    found = [(problem, best, population)]
    if not others:
        return found
    second = others[-1]
    ends = [objective_of(problem, best, one) for one in others]
    last, population, _ = problem.search(second, with_best(population, best))
    progress(0.1)
    lowest = objective_of(problem, last, second)
    for level in levels_between(ends[-1], lowest):
        bounded = replace(problem, levels=((second, level),))
        if len(others) > 1:
            bounded = replace(bounded, levels=(*bounded.levels, (others[0], ends[0])))
        best, population, fitness = bounded.search(first, with_best(population, last), AGAIN)
        progress(0.6 / (ROWS - 1))
        if feasible(fitness):
            found.append((bounded, best, population))
    return found


def with_best(population: Array, best: Array) -> Array:
    """A population with a further design in front."""
    return np.concatenate([best[None], population])[:POPULATION]


def levels_between(high: float, low: float) -> Array:
    """Levels of the second objective, from below its value at the best of the first to just above its best."""
    low = low + 0.02 * abs(low)
    if not low < high:
        return np.array([])
    spaced = np.geomspace(high, low, ROWS) if low > 0.0 else np.linspace(high, low, ROWS)
    return np.asarray(spaced[1:])


def objective_of(problem: Problem, unit: Array, which: Objective) -> float:
    """An objective of one design, the smaller the better."""
    designs = problem.designs(unit[None])
    found = problem.found(designs, np.zeros((1, problem.wish.uncertain)))
    worst = problem.robust(problem.margins(problem.found(designs, problem.normal)))
    return float(problem.objective(designs, found, worst, which)[0])


def fields_of(problem: Problem, unit: Array) -> dict[str, float]:
    """The free fields of a design, in SI."""
    return {n: float(f"{v:.{DIGITS}g}") for n, v in zip(problem.names, problem.designs(unit[None])[0], strict=True)}


def probability_of(problem: Problem, unit: Array, seed: int) -> tuple[float, float, float]:
    """The share of new draws that meet all, with its 95 % interval by Wilson."""
    from gelcone.statistics import wilson

    fresh = replace(problem, draws=NEW_DRAWS, seed=seed, levels=(), relaxed="")
    found = fresh.found(fresh.designs(unit[None]), fresh.normal)
    met = np.max(list(fresh.margins(found).values()), axis=0)[0] <= 0.0
    low, high = wilson(met.mean(), met.size)
    return float(met.mean()), float(low), float(high)


def binding_of(problem: Problem, unit: Array) -> str:
    """The requirement or limit whose margin is the first to be missed."""
    designs = problem.designs(unit[None])
    margins = problem.margins(problem.found(designs, problem.normal))
    share = min(problem.wish.confidence + problem.extra, 1.0)
    return max(margins, key=lambda name: float(np.quantile(margins[name][0], share)))


def relaxation(problem: Problem, unit: Array, population: Array, binding: str) -> float:
    """By what share the first objective falls where the binding requirement is 10 % weaker; 0 where it does not."""
    which = problem.wish.objectives[0]
    if which.name == "probability":
        return np.nan
    name = binding if any(one.name == binding for one in problem.wish.requirements) else "limits"
    weaker = replace(problem, relaxed=name)
    _, _, fitness = weaker.search(which, with_best(population, unit), SHORT)
    before = objective_of(problem, unit, which)
    return max((before - fitness) / abs(before), 0.0) if feasible(fitness) else 0.0


def closest(problem: Problem, unit: Array) -> str:
    """Why no design is feasible: the closest one, what binds it, and which bounds it lies at."""
    wish = problem.wish
    designs = problem.designs(unit[None])
    found = problem.found(designs, np.zeros((1, wish.uncertain)))
    limit = float(np.nanmin(found.limits[:, 0, 0], initial=np.inf))
    peak = float(found.values["peak_voltage"][0, 0])
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
    stroke = 1e3 * float(found.values["stroke"][0, 0])
    return (
        f"design: no design within the bounds meets all with a margin of {100.0 * wish.margin:.0f} % at a confidence "
        f"of {100.0 * wish.confidence:.0f} %; the closest: {margin}, stroke {stroke:.2g} mm; it is bound by {binding}; "
        f"{remedy}, or weaken a requirement"
    )


def _shown(problem: Problem, name: str, value: float) -> str:
    """A value of a field with its unit."""
    return format_si(value, problem.device.swept_fields()[name].unit)


# --- the check --------------------------------------------------------------------------------------------------------


class Checked(NamedTuple):
    """What the analyses say of a design: its settled ``stroke`` and ``apparent_power``, the ``recommended`` highest
    peak voltage at its frequency, the ``first_limit`` there, the stroke as a ``membrane``, and why it ``failed``, empty
    if it holds."""

    stroke: float
    membrane: float
    apparent_power: float
    recommended: float
    first_limit: str
    failed: str


BESIDE = 0.03
"""Share of the drive frequency to either side at which limits are examined, too."""


def check(wish: Wish, device: Device) -> Checked:
    """Examine a design by its settled motion and by its operating envelope around its own frequency."""
    motion, membrane = settled(device), settled(device.replace_quietly(film="membrane"))
    stroke, power = 1e-3 * float(motion["stroke"]), 1e-3 * float(motion["apparent_power"])
    own = float(device.frequency)
    found = envelope(device, frequencies=own * np.array([1.0 - BESIDE, 1.0, 1.0 + BESIDE]), margin=wish.margin)
    recommended = float(found["recommended_peak"][1])
    peak, first = float(found["own_peak"]), int(found["first_limit"][1])
    static = found["static_limit_voltage"]
    name = f"{static['static_limit'].values[int(np.nanargmin(static.values))]} on a ramp"
    if first >= 0 and float(found["limit_low"][first, 1]) <= float(static.min()):
        name = f"{found['driven_limit'].values[first]} under the drive"
    failed = ""
    missed = [one for one in wish.requirements if one.name == "stroke" and (stroke < one.bound) == one.least]
    if not np.isfinite(stroke) or missed:
        failed = f"its settled stroke is {1e3 * stroke:.3g} mm"
    elif peak > recommended:
        failed = f"{name} leaves {recommended:.4g} V at its frequency, and it takes {peak:.4g} V"
    return Checked(stroke, 1e-3 * float(membrane["stroke"]), power, recommended, name, failed)


class Row(NamedTuple):
    """A design: its ``problem``, place in the unit ``cube`` and ``checked`` numbers."""

    problem: Problem
    unit: Array
    population: Array
    device: Device
    checked: Checked


def checked_row(problem: Problem, unit: Array, population: Array) -> Row:
    """A design as found or, where a check fails for its limits or new draws for its confidence, one that keeps more."""
    wished, uncertain = problem.wish.confidence, problem.draws > 1
    for attempt in range(ATTEMPTS):
        device = problem.wish.device.replace_quietly(fields_of(problem, unit))
        row = Row(problem, unit, population, device, check(problem.wish, device))
        lacking = wished - probability_of(problem, unit, problem.seed + 2)[0] if uncertain else 0.0
        if attempt == ATTEMPTS - 1 or ("leaves" not in row.checked.failed and lacking <= 0.0):
            return row
        if row.checked.failed:
            found = problem.found(problem.designs(unit[None]), np.zeros((1, problem.wish.uncertain)))
            share = row.checked.recommended / (1.0 - problem.wish.margin) / float(np.nanmin(found.limits[:, 0, 0]))
            problem = replace(problem, pull_in=min(share, 0.98 * problem.pull_in))
        problem = replace(problem, extra=min(problem.extra + max(lacking, 0.0), 1.0 - wished))
        unit, population, fitness = problem.search(problem.wish.objectives[0], with_best(population, unit), AGAIN)
        if not feasible(fitness):
            return row
    return row


def dominated(values: Array) -> Any:
    """Which rows of (rows, objectives), the smaller the better, another row beats in all."""
    better = (values[:, None] <= values[None]).all(axis=2) & (values[:, None] < values[None]).any(axis=2)
    return better.any(axis=0)


# --- the result -------------------------------------------------------------------------------------------------------


def design(
    wish: Wish, *, samples: Any = None, nominal: bool = False, seed: int = 0, progress: Progress = None
) -> xr.Dataset:
    """Find designs that meet a wish in spite of the tolerances of their fields.

    Parameters
    ----------
    wish : of `gelcone.read_wish`.
    samples : draws of fields that are uncertain together, as a fit leaves them: name -> values in SI, or a Dataset of
        `gelcone.fitted_draws`. A fixed field is at their median, a free one spreads as they do. Default none.
    nominal : search as if nothing were uncertain, to compare. Default no.
    seed : of the search and its draws. Default 0.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over ``design``, along the front of the first two objectives: the free fields, stroke, voltage and power,
    the ``probability`` that a device within the tolerances meets all, of 4,096 new draws, with its 95 % interval; the
    ``first_limit`` and the ``recommended`` highest peak voltage; the ``distance`` of the natural frequency from that of
    the drive in half widths of the resonance; what ``binds``, and by what share the first objective falls where that
    is 10 % weaker (``relaxed``). The attribute ``nominal_probability`` is the smallest probability of the designs that
    are best in an objective where nothing is uncertain, ``nominal_probabilities`` those by objective. Designs that the
    settled motion or the envelope refuse are left out; the attribute
    ``left_out`` says why; ``samples`` holds names, medians and the covariance of the logarithms of fields that are
    uncertain together. `gelcone.designed_devices` gives the devices.

    Raises
    ------
    InputError : where no design within the bounds meets all, and where nothing is uncertain.

    Examples
    --------
    A search takes a minute, so that its result is not shown here.

    >>> import gelcone, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp(), "wish.toml")
    >>> text = '''
    ... stroke = ">= 2 mm"
    ... smallest = ["apparent_power"]
    ... frequency = "10 Hz"
    ... footprint = "60 mm"
    ... film = "taut"
    ... disc_radius = "8 mm"
    ... film_thickness = "0.2 mm"
    ... hoop_prestretch = 1.4
    ... moving_mass = "5 g"
    ... damping_coefficient = "10 mN s/m"
    ... material = "PVC-DBA 6:1"
    ... voltage_offset = "0.8 kV"
    ... voltage_amplitude = "0.7 kV"
    ... [free]
    ... spring_rate = "1 N/m:100 N/m"
    ... initial_height = "5 mm:40 mm"
    ... [tolerances]
    ... film_thickness = "5 %"
    ... '''
    >>> _ = path.write_text(text)
    >>> wish = gelcone.read_wish(path)
    >>> len(wish.free), wish.confidence
    (2, 0.95)
    >>> found = gelcone.design(wish)  # doctest: +SKIP
    >>> devices = gelcone.designed_devices(found)  # doctest: +SKIP
    """
    if samples is not None:
        named = samples.data_vars.items() if hasattr(samples, "data_vars") else samples.items()
        wish = with_samples(wish, {str(name): np.asarray(values) for name, values in named})
    if not wish.uncertain and not nominal:
        raise InputError(
            "design: nothing is uncertain: tolerances are needed to tell a design from a coincidence; give "
            "[tolerances], --samples of a fit, or --nominal to see the trap"
        )
    counted = Counted(progress)
    with quiet_input():
        found = front(wish, seed, nominal, weighted(counted, 0.5))
        kept = ~dominated(np.array([[objective_of(p, unit, one) for one in wish.objectives] for p, unit, _ in found]))
        rows = []
        for (problem, unit, population), keep in zip(found, kept, strict=True):
            if keep:
                rows.append(checked_row(problem, unit, population))
            counted(0.4 / len(found))
        scores = np.array([[objective_of(r.problem, r.unit, one) for one in wish.objectives] for r in rows])
        rows = [rows[k] for k in np.argsort(scores[:, -1])[::-1] if not dominated(scores)[k]]
        result = _labelled(wish, rows, seed, traps(wish, seed) if wish.uncertain else {})
    counted.finish()
    return result


def designed_devices(result: xr.Dataset) -> list[Device]:
    """The devices of a design.

    Parameters
    ----------
    result : of `gelcone.design`, also one that `gelcone.load` has read.

    Returns
    -------
    A `Device` for each row, in the order of the rows.

    Raises
    ------
    InputError : for another Dataset.

    Examples
    --------
    >>> import gelcone
    >>> response = gelcone.simulate(gelcone.ConeModel(), periods=1)
    >>> try:
    ...     gelcone.designed_devices(response)
    ... except gelcone.InputError as error:
    ...     print("error 2:", error)
    error 2: designed_devices: was given no designs; give a result of gelcone.design
    """
    if "devices" not in result.attrs:
        raise InputError("designed_devices: was given no designs; give a result of gelcone.design")
    return [Device.from_text(text) for text in json.loads(result.attrs["devices"])]


@contextmanager
def quiet_input() -> Iterator[None]:
    """No warnings about unusual values, and none about missing numbers, of designs that a search only tries."""
    with warnings.catch_warnings(), np.errstate(invalid="ignore", divide="ignore"):
        warnings.simplefilter("ignore", DoubtfulInput)
        yield


def traps(wish: Wish, seed: int) -> dict[str, float]:
    """The probability of the design that is best where nothing is uncertain, by objective; without those that no free
    field moves."""
    alone, found = Problem(wish, 1, seed), {}
    for objective in wish.objectives:
        unit, _, fitness = alone.search(objective, generations=TRAP)
        start = objective_of(alone, np.full(len(alone.names), 0.5), objective)
        if feasible(fitness) and fitness != start:
            found[objective.name] = probability_of(alone, unit, seed + 1)[0]
    return found


def _stored(wish: Wish) -> dict[str, Any]:
    """What was drawn together, so that the result says it: names, medians, and the covariance of the logarithms."""
    names, medians, root = wish.samples
    return {"names": names, "medians": medians.tolist(), "covariance": (root @ root.T).tolist()} if names else {}


_NUMBERS = {
    "stroke": ("settled stroke, peak to peak", "length"),
    "membrane_stroke": ("settled stroke of the film as a membrane", "length"),
    "peak_voltage": ("peak voltage of the drive", "voltage"),
    "apparent_power": ("apparent power of the settled motion", "apparent power"),
    "recommended": ("highest peak voltage recommended at its frequency", "voltage"),
    "probability": ("share of devices, as uncertain as they are, that meet all", "share"),
    "probability_low": ("lower end of its 95 % interval", "share"),
    "probability_high": ("upper end of its 95 % interval", "share"),
    "distance": ("natural frequency less that of the drive, in half widths of the resonance", "share"),
    "relaxed": ("share by which the first objective falls where what binds is 10 % weaker", "share"),
}


def _labelled(wish: Wish, rows: Sequence[Row], seed: int, trap: Mapping[str, float]) -> xr.Dataset:
    """The designs that hold as a Dataset."""
    import xarray as xr

    import gelcone.accessor  # noqa: F401  (gives Datasets their methods)

    good = [row for row in rows if not row.checked.failed]
    left = [row.checked.failed for row in rows if row.checked.failed]
    if not good:
        rest = "widen the bounds, or weaken a requirement"
        raise InputError(f"design: every design found fails its check, the first since {left[0]}; {rest}")
    columns: dict[str, list[float]] = {name: [] for name in _NUMBERS}
    binds = []
    for row in good:
        share, low, high = probability_of(row.problem, row.unit, seed + 1)
        binds.append(binding_of(row.problem, row.unit))
        found = row.problem.found(row.problem.designs(row.unit[None]), np.zeros((1, wish.uncertain)))
        width = float(row.device.to_model().damping_ratio) * float(row.device.scales.frequency)
        distance = (float(found.values["natural_frequency"][0, 0]) - float(row.device.frequency)) / width
        values = (
            row.checked.stroke, row.checked.membrane, float(found.values["peak_voltage"][0, 0]),
            row.checked.apparent_power, row.checked.recommended, share, low, high, distance,
            relaxation(row.problem, row.unit, row.population, binds[-1]),
        )  # fmt: skip
        for own, value in zip(columns.values(), values, strict=True):
            own.append(value)
    known = good[0].device.swept_fields()
    fields = {
        name: (
            "design",
            [float(row.device.get(name)) for row in good],
            {"units": known[name].unit, "long_name": known[name].meaning},
        )
        for name in wish.free
    }
    labelled = {
        name: ("design", np.array(columns[name]) * MEASURES[of].per_unit if of in MEASURES else np.array(columns[name]),
               {"units": MEASURES[of].shown if of in MEASURES else "1", "long_name": words})
        for name, (words, of) in _NUMBERS.items()
    }  # fmt: skip
    texts = {"first_limit": ("design", [row.checked.first_limit for row in good]), "binds": ("design", binds)}
    return xr.Dataset(
        {**labelled, **fields, **texts},
        {"design": np.arange(1, len(good) + 1)},
        {
            "title": f"designs: {wish.name}",
            "wish": wish.text,
            "objectives": json.dumps([one.name for one in wish.objectives]),
            "free": json.dumps(list(wish.free)),
            "margin": wish.margin,
            "confidence": wish.confidence,
            "frequency": float(wish.device.frequency),
            "nominal_probability": min(trap.values(), default=np.nan),
            "nominal_probabilities": json.dumps(trap),
            "left_out": json.dumps(left),
            "devices": json.dumps(
                [row.device.replace_quietly(name=f"{wish.name} {k}").to_toml() for k, row in enumerate(good, 1)]
            ),
            "samples": json.dumps(_stored(wish)),
            "seed": seed,
            "gelcone_version": __version__,
        },
    )
