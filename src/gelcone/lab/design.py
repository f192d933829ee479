"""Designs that meet a wish in spite of tolerances: searched on closed forms, checked by the analyses.

The search is that of `gelcone.lab.front`.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gelcone import dataset
from gelcone._version import __version__
from gelcone.devices.device import Device
from gelcone.devices.points import field_attributes
from gelcone.devices.scales import MEASURES
from gelcone.devices.units import format_si
from gelcone.errors import DoubtfulInput, InputError, check_kind, check_result
from gelcone.lab.candidates import Found
from gelcone.lab.front import (
    AGAIN,
    Problem,
    binding_of,
    dominated,
    feasible,
    fields_of,
    front,
    objective_of,
    probability_of,
    relaxation,
    with_best,
)
from gelcone.lab.wish import MEASURES as WISHED
from gelcone.lab.wish import Requirement, Wish, with_samples
from gelcone.motion.envelope import envelope
from gelcone.motion.natural import driven_frequency
from gelcone.motion.ramp import stroke_and_blocked_force
from gelcone.motion.settled import settled
from gelcone.progress import Counted, Progress, weighted
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

ATTEMPTS = 3
"""Most searches of a design, each with the pull-in that the check of the last one found."""
TRAP = 200
"""Generations of a search without uncertainty."""


# --- the check --------------------------------------------------------------------------------------------------------


class Checked(NamedTuple):
    """The check of a design by the analyses, with its own film: its ``values`` in SI by name, the ``recommended``
    highest peak voltage at its frequency with the ``first_limit``, the requirements that it ``missed``, and the reason
    why it ``failed``, empty if it did not."""

    values: Mapping[str, float]
    recommended: float
    first_limit: str
    missed: tuple[Requirement, ...]
    failed: str


NEARBY = 0.03
"""Distance of two more frequencies at which limits are examined, over the drive frequency."""
TILT = 0.01
"""Share by which a search aims beyond a requirement that the check of a design found missed."""


def values_of(device: Device) -> dict[str, float]:
    """The numbers of a design that may be required, in SI, with its own film."""
    motion, scales = settled(device), device.scales
    numbers = {
        name: float(motion[name]) / MEASURES[quantity].per_unit
        for name, quantity in (("stroke", "length"), ("apparent_power", "apparent power"), ("current", "current"))
    }
    peak = abs(float(device.voltage_offset)) + float(device.voltage_amplitude)
    force = float(stroke_and_blocked_force(device, [peak])["blocked_force"][0])
    return numbers | {
        "peak_voltage": peak,
        "blocked_force": force / MEASURES["force"].per_unit,
        "natural_frequency": driven_frequency(device.to_model()) * float(scales.frequency),
        "rest_height": float(device.initial_state()[0]) * float(scales.length),
        "footprint": 2.0 * float(device.film_radius),
    }


def check(wish: Wish, device: Device) -> Checked:
    """Examine a design by its settled motion and by its operating envelope around its frequency."""
    values, frequency = values_of(device), float(device.frequency)
    window = envelope(device, frequencies=frequency * np.array([1.0 - NEARBY, 1.0, 1.0 + NEARBY]), margin=wish.margin)
    recommended = float(window["recommended_peak"][1])
    peak, first = float(window["operating_peak_voltage"]), int(window["first_limit"][1])
    static = window["static_limit_voltage"]
    name = f"{static['static_limit'].values[int(np.nanargmin(static.values))]} on a ramp"
    if first >= 0 and float(window["limit_low"][first, 1]) <= float(static.min()):
        name = f"{window['driven_limit'].values[first]} under the drive"
    failed = ""
    missed = tuple(requirement for requirement in wish.requirements if not meets(requirement, values[requirement.name]))
    if missed:
        failed = f"its {missed[0].name} is {said(missed[0].name, values[missed[0].name])}"
    elif not np.isfinite(values["stroke"]):
        failed = "its motion does not settle"
    elif peak > recommended:
        failed = f"{name} leaves {recommended:.4g} V at its frequency, and it takes {peak:.4g} V"
    return Checked(values, recommended, name, missed, failed)


def meets(requirement: Requirement, value: float) -> bool:
    """Whether a value meets a requirement; NaN does not."""
    return value >= requirement.bound if requirement.least else value <= requirement.bound


def said(name: str, value: float) -> str:
    """A number of a design with its unit."""
    return format_si(value, WISHED[name], 3) if np.isfinite(value) else "unknown"


class Row(NamedTuple):
    """A design: its ``problem``, place in the ``unit`` cube, last ``population``, ``device`` and ``checked``
    numbers."""

    problem: Problem
    unit: Array
    population: Array
    device: Device
    checked: Checked


def checked_row(problem: Problem, unit: Array, population: Array) -> Row:
    """Check a design; if it fails, or new draws for its confidence, search one with the ratios of the checked film to
    the closed forms, and with more distance. Its probability is that under these ratios and the limits that the check
    found."""
    wished, uncertain = problem.wish.confidence, problem.draws > 1
    for attempt in range(ATTEMPTS):
        device = problem.wish.device.replace_quietly(fields_of(problem, unit))
        checked = check(problem.wish, device)
        nominal = replace(problem, ratios={}).nominal(problem.designs(unit[None]))
        limit = float(np.nanmin(nominal.limits[:, 0, 0]))
        share = checked.recommended / (1.0 - problem.wish.margin) / limit if np.isfinite(limit) else 1.0
        limited = with_ratios(replace(problem, pull_in=float(np.fmin(share, 1.0))), nominal, checked)
        row = Row(limited, unit, population, device, checked)
        lacking = wished - probability_of(limited, unit, problem.seed + 2)[0] if uncertain else 0.0
        if attempt == ATTEMPTS - 1 or (not checked.failed and lacking <= 0.0):
            return row
        overfit = wished - probability_of(problem, unit, problem.seed + 2)[0] if lacking > 0.0 else 0.0
        lowered = float(np.fmin(share, (0.98 if "leaves" in checked.failed else 1.0) * problem.pull_in))
        extra = min(problem.extra + max(overfit, 0.0), 1.0 - wished)
        problem = tilted(replace(limited, pull_in=lowered, extra=extra), checked)
        unit, population, fitness = problem.search(problem.wish.objectives[0], with_best(population, unit), AGAIN)
        if not feasible(fitness):
            return row
    return row


def with_ratios(problem: Problem, found: Found, checked: Checked) -> Problem:
    """The problem with the numbers of the checked film over those of the closed forms, and its levels with them."""
    values = {name: float(value[0, 0]) for name, value in found.values.items()}
    ratios = {name: checked.values[name] / value if value else 1.0 for name, value in values.items()}
    known = {name: ratio for name, ratio in ratios.items() if np.isfinite(ratio) and ratio > 0.0}
    levels = tuple(
        (one, level * known.get(one.name, 1.0) / problem.ratios.get(one.name, 1.0)) for one, level in problem.levels
    )
    return replace(problem, ratios=known, levels=levels)


def tilted(problem: Problem, checked: Checked) -> Problem:
    """The problem with the numbers whose requirement was missed a little worse."""
    worse = {
        one.name: problem.ratios.get(one.name, 1.0) * (1.0 - TILT if one.least else 1.0 + TILT)
        for one in checked.missed
    }
    return replace(problem, ratios={**problem.ratios, **worse})


# --- the result -------------------------------------------------------------------------------------------------------


def design(
    wish: Wish, *, samples: Any = None, nominal: bool = False, seed: int = 0, progress: Progress = None
) -> xr.Dataset:
    """Find designs that meet a wish in spite of the tolerances of their fields.

    Parameters
    ----------
    wish : of `gelcone.read_wish`.
    samples : draws of correlated fields, such as those of a fit: name -> values in SI, or a Dataset of
        `gelcone.fitted_draws`. A fixed field is set to their median, and a free one has their spread. Default none.
    nominal : search without uncertainty, for comparison. Default no.
    seed : of the search and its draws. Default 0.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over ``design``, along the front of the first two objectives: the free fields; of the film of the wish, by
    default "membrane", stroke, voltage and power; unless ``nominal`` the ``probability`` that a device within the
    tolerances meets all, of 4,096 new draws, with its 95 % interval: draws of the homogeneous cone, its numbers times
    those of the film over its own at nominal values; the
    ``first_limit`` and the ``recommended`` highest peak voltage; the ``distance`` of the natural frequency from that of
    the drive in half widths of the resonance; the ``binding_requirement``, and the share by which the
    first objective falls if that is 10 % weaker (``relaxed``). The attribute ``nominal_probability`` is the smallest
    probability of the designs that are best in an objective without uncertainty, ``nominal_probabilities`` those by
    objective; neither if ``nominal``. Designs whose settled motion or envelope fails are left out, with the reasons
    in the attribute ``left_out``; ``samples`` holds names, medians and the covariance of the logarithms of correlated
    fields.
    `gelcone.designed_devices` returns the devices.

    Raises
    ------
    InputError : if no design within the bounds meets all requirements, and if nothing is uncertain.

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
    check_kind("design", wish, Wish, "give a wish, such as gelcone.read_wish('wish.toml')")
    if samples is not None:
        named = samples.data_vars.items() if hasattr(samples, "data_vars") else samples.items()
        wish = with_samples(wish, {str(name): np.asarray(values) for name, values in named})
    if not wish.uncertain and not nominal:
        raise InputError(
            "design: nothing is uncertain: tolerances are needed to distinguish a design from a coincidence; give "
            "[tolerances] or the samples of a fit; only a nominal design needs neither"
        )
    counted = Counted(progress)
    with quiet_input():
        candidates = front(wish, seed, nominal, weighted(counted, 0.5))
        kept = ~dominated(
            np.array([[objective_of(p, unit, objective) for objective in wish.objectives] for p, unit, _ in candidates])
        )
        rows = []
        for (problem, unit, population), keep in zip(candidates, kept, strict=True):
            if keep:
                rows.append(checked_row(problem, unit, population))
            counted(0.4 / len(candidates))
        scores = np.array([[objective_of(r.problem, r.unit, objective) for objective in wish.objectives] for r in rows])
        rows = [rows[k] for k in np.argsort(scores[:, -1])[::-1] if not dominated(scores)[k]]
        result = _labelled(wish, rows, seed, {} if nominal else traps(wish, seed))
    counted.finish()
    return result


def designed_devices(result: xr.Dataset) -> list[Device]:
    """Return the devices of a design.

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
    check_result("designed_devices", result)
    if "devices" not in result.attrs:
        raise InputError("designed_devices: was given no designs; give a result of gelcone.design")
    return [Device.from_text(text) for text in json.loads(result.attrs["devices"])]


@contextmanager
def quiet_input() -> Iterator[None]:
    """Suppress warnings about unusual values and missing numbers of designs that a search tries."""
    with warnings.catch_warnings(), np.errstate(invalid="ignore", divide="ignore"):
        warnings.simplefilter("ignore", DoubtfulInput)
        yield


def traps(wish: Wish, seed: int) -> dict[str, float]:
    """Objective -> probability of the design that is best in it without uncertainty and passes its check; objectives
    that depend on no free field are left out."""
    probabilities = {}
    for objective in wish.objectives:
        alone = Problem(replace(wish, objectives=(objective,)), 1, seed)
        unit, population, fitness = alone.search(objective, generations=TRAP)
        start = objective_of(alone, np.full(len(alone.names), 0.5), objective)
        if feasible(fitness) and fitness != start:
            row = checked_row(alone, unit, population)
            probabilities[objective.name] = probability_of(row.problem, row.unit, seed + 1)[0]
    return probabilities


def _stored(wish: Wish) -> dict[str, Any]:
    """Names, medians and the covariance of the logarithms of correlated fields, for the result; empty if there are
    none."""
    names, medians, root = wish.samples
    return {"names": names, "medians": medians.tolist(), "covariance": (root @ root.T).tolist()} if names else {}


_NUMBERS = {
    "stroke": ("settled stroke, peak to peak", "length"),
    "peak_voltage": ("peak voltage of the drive", "voltage"),
    "apparent_power": ("apparent power of the settled motion", "apparent power"),
    "recommended": ("highest peak voltage recommended at its frequency", "voltage"),
    "distance": ("natural frequency less that of the drive, in half widths of the resonance", "share"),
    "relaxed": ("share by which the first objective falls where what binds is 10 % weaker", "share"),
}
_PROBABILITY = {
    "probability": ("share of devices, as uncertain as they are, that meet all", "share"),
    "probability_low": ("lower end of the 95 % interval of the share of devices that meet all", "share"),
    "probability_high": ("upper end of the 95 % interval of the share of devices that meet all", "share"),
}
"""Columns that a nominal design lacks."""


def _labelled(wish: Wish, rows: Sequence[Row], seed: int, trap: Mapping[str, float]) -> xr.Dataset:
    """Label the designs that pass their checks as a Dataset."""
    import xarray as xr

    import gelcone.accessor  # noqa: F401  (gives Datasets their methods)

    good = [row for row in rows if not row.checked.failed]
    left = [row.checked.failed for row in rows if row.checked.failed]
    if not good:
        rest = "widen the bounds, or weaken a requirement"
        raise InputError(f"design: every design found fails its check, the first since {left[0]}; {rest}")
    numbers, binds, drawn = [], [], good[0].problem.draws > 1
    for row in good:
        binds.append(binding_of(row.problem, row.unit))
        width = float(row.device.to_model().damping_ratio) * float(row.device.scales.frequency)
        values = row.checked.values
        distance = (values["natural_frequency"] - float(row.device.frequency)) / width
        numbers.append((
            values["stroke"], values["peak_voltage"], values["apparent_power"], row.checked.recommended, distance,
            relaxation(row.problem, row.unit, row.population, binds[-1]),
            *(probability_of(row.problem, row.unit, seed + 1) if drawn else ()),
        ))  # fmt: skip
    table: dict[str, tuple[Any, str, dataset.Of]] = {}
    named = _NUMBERS | (_PROBABILITY if drawn else {})
    for (name, (words, of)), values in zip(named.items(), np.transpose(numbers), strict=True):
        table[name] = values, words, of
        if of in MEASURES:
            table[name] = values * MEASURES[of].per_unit, words, {"units": MEASURES[of].shown, "quantity": of}
    table |= {
        name: ([float(row.device.get(name)) for row in good], "", field_attributes(good[0].device, name))
        for name in wish.free
    }
    table |= {
        "first_limit": ([row.checked.first_limit for row in good], "limit that comes first", "code"),
        "binding_requirement": (binds, "requirement that binds", "code"),
    }
    return xr.Dataset(
        dataset.columns("design", table),
        dataset.columns("design", {"design": (np.arange(1, len(good) + 1), "number of the design", "count")}),
        {
            "title": f"designs: {wish.name}",
            "wish": wish.text,
            "objectives": json.dumps([one.name for one in wish.objectives]),
            "free": json.dumps(list(wish.free)),
            "margin": wish.margin,
            "confidence": wish.confidence,
            "frequency": float(wish.device.frequency),
            "film": str(wish.device.film),
            "nominal_probability": min(trap.values(), default=np.nan),
            "nominal_probabilities": json.dumps(trap),
            "left_out": json.dumps(left),
            "devices": json.dumps(
                [row.device.replace_quietly(name=f"{wish.name} {k}").to_toml() for k, row in enumerate(good, 1)]
            ),
            "samples": json.dumps(_stored(wish)),
            "seed": seed,
            "gelcone_version": __version__,
            **dataset.film_errors(*(row.device.to_model() for row in good)),
        },
    )
