"""Plan and fit of a device with its tests, as Datasets."""

from __future__ import annotations

import itertools
import json
import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone import dataset
from gelcone._version import __version__
from gelcone.devices.device import Device
from gelcone.devices.units import parse, parse_deviation
from gelcone.errors import DoubtfulInput, InputError, check_kind, check_name, check_names, unknown_name
from gelcone.lab.bench import KINDS, DeviceTest, field_value, rows_read
from gelcone.lab.device_fit import (
    REFUSED,
    WIDE,
    FittedDevice,
    NoStateError,
    Plan,
    Problem,
    fit_problem,
    left_out,
    plan_of,
    profiled,
)
from gelcone.lab.device_tests import DeviceTests
from gelcone.lab.measured import notes_of
from gelcone.lab.predictions import predictions_of, read_predictions
from gelcone.physics.records import FILMS
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

LOSSES = ("damper", "branch", "both")
"""Structures of the loss: a linear damper, a Maxwell branch of the film, or both."""
BRANCH = ("material.viscous_modulus_1", "material.relaxation_time_1")
BRANCH_SHARE, ANY = 0.1, 1.0
"""Initial modulus of an added branch over the shear modulus, and the prior of added fields, a factor of e."""
UPWARD, OPPOSITE = ("force", "stroke"), -0.8
"""Readings with a direction, and the cosine between measured and predicted ones below which their sign is wrong."""
CERTAIN = 5.0
"""Root mean square over the noise, of measured and predicted readings, above which their sign is checked."""
READ_TESTS = "give tests on a device, such as gelcone.read_device_tests('tests.toml')"
"""Remedy for anything but tests on a device."""
UNDECIDED = 4.0
"""Difference of the objectives of two films below which they cannot be distinguished."""


def read_free(texts: Sequence[str], device: Device) -> dict[str, float]:
    """Read free fields with the relative standard deviations of their priors, from ``FIELD~3%``, ``FIELD~5 um``, or
    ``FIELD`` without a prior."""
    deviations: dict[str, float] = {}
    for text in texts:
        name, tilde, spread = (part.strip() for part in text.partition("~"))
        value = field_value(device, name)
        if name in deviations:
            raise InputError(f"free {name}: is given twice; give it once")
        if not tilde:
            warnings.warn(f"free {name}: has no prior; give one where it was measured, {name}~3%", DoubtfulInput, 2)
            deviations[name] = WIDE
        else:
            deviations[name] = _read_prior(name, spread, device, value)
    return deviations


def _read_prior(name: str, given: Any, device: Device, value: float) -> float:
    """Read the relative standard deviation of the prior of a field with a ``value``: a number, or a text such as 3% or
    5 um."""
    if isinstance(given, str):
        return parse_deviation(f"free {name}", given, device.swept_fields()[name].unit, value) / value
    return parse(f"deviation of free {name}", given, "1", above=0.0)


def plan_device(
    device: Device,
    tests: DeviceTests,
    free: Mapping[str, float | str],
    *,
    predict: Sequence[str] = (),
    film: str | None = None,
    loss: str | None = None,
) -> xr.Dataset:
    """Compute how well tests would determine the fields of a device, before any of them is made.

    Parameters
    ----------
    device : with the nominal values of its fields.
    tests : result of `gelcone.read_device_tests`; readings are not used and may be missing.
    free : field, also a dotted one -> standard deviation of its prior, relative, such as 0.03 or ``"3%"``, or in a unit
        of the field, such as ``"5 um"``.
    predict : predictions such as ``"stroke@1.5 kV"``, ``"natural frequency@1 kV"`` and ``"pull-in"``.
    film : ``"taut"``, ``"wrinkling"`` or ``"membrane"``. Default the device's.
    loss : ``"damper"``, ``"branch"`` or ``"both"``, as in `fit_device`. Default the device's.

    Returns
    -------
    Dataset over ``unknown`` - the fields, then the gains of instruments - with the standard deviation ``posterior`` by
    the tests and the ``prior``; the ``singular_value`` of each direction of fields in units of their priors;
    ``invariant`` directions, changes of fields that change no reading; the predictions with their standard deviations,
    and the shares of these that further experiments would leave.

    Raises
    ------
    InputError : for fields that cannot be fitted, and if the device has no state in the tests.

    Examples
    --------
    >>> import gelcone, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp(), "tests.toml")
    >>> _ = path.write_text('[[test]]\\nkind = "ring-down"\\nnoise = {frequency = "0.02 Hz", decay = "0.05 1/s"}\\n')
    >>> device = gelcone.find_device("biased-pump").replace(film="taut")
    >>> plan = gelcone.plan_device(device, gelcone.read_device_tests(path), {"moving_mass": 0.1})
    >>> f"the mass will be known to {plan.posterior.item():.2%}, before to {plan.prior.item():.0%}"
    'the mass will be known to 0.35%, before to 10%'
    """
    check_kind("plan_device", tests, DeviceTests, READ_TESTS)
    problem = _problem(device, tests, free, film, loss)
    plan = plan_of(problem)
    asked = read_predictions(predict)
    nominal = np.zeros(problem.priors.size)
    predicted = predictions_of(problem, nominal, plan.covariance, asked)
    result = _planned(problem, plan, nominal, plan.left).merge(predicted)
    about = {
        "title": f"device plan: {device.name}",
        "film": str(problem.device.film),
        **_about(problem, problem.device),
    }
    return result.assign_attrs(predicted.attrs | about | {"planned": device.to_toml()})


def fit_device(
    device: Device,
    tests: DeviceTests,
    free: Mapping[str, float | str],
    *,
    predict: Sequence[str] = (),
    films: Sequence[str] | None = None,
    losses: Sequence[str] | None = None,
    profile: Sequence[str] = (),
) -> xr.Dataset:
    """Fit the fields of a device to its measurements.

    Parameters
    ----------
    device, tests, free, predict : as in `plan_device`, with all readings measured.
    films : films to compare, of ``"taut"``, ``"wrinkling"`` and ``"membrane"``. Default the device's.
    losses : structures of the loss to compare: ``"damper"``, a linear damper and a film that does not creep;
        ``"branch"``, a Maxwell branch of the film and no damper; ``"both"``. An added branch starts with a tenth of the
        shear modulus and the period of the drive over 2 pi; fields of damper and branch that are not among ``free`` are
        free within a factor of e. Default the device's.
    profile : unknowns for which the 95 % interval of the profile likelihood is computed, too, ``profile_low`` and
        ``profile_high`` as logarithms; it is right also where the objective is not a parabola. Default none.

    Returns
    -------
    Dataset of `plan_device` about the best film at the fitted fields, with the ``deviation`` of each unknown from its
    nominal value, as a logarithm; all readings with ``predicted`` ones; each test predicted from the others; and the
    objective of each ``structure``. Its attributes hold chi2, its p-value and the fitted device. Where chi2 refuses the
    structure, ``refused`` is 1, and standard deviations are multiplied by the root of chi2 over the number of readings.

    Raises
    ------
    InputError : as `plan_device`; for missing readings; for fields without priors that cannot be distinguished; and for
        measured voltages beyond pull-in.

    Examples
    --------
    >>> import gelcone, pathlib, tempfile
    >>> device = gelcone.find_device("biased-pump").replace(film="taut")
    >>> path = pathlib.Path(tempfile.mkdtemp(), "tests.toml")
    >>> reading = 'frequency = "9 Hz"\\ndecay = "1 1/s"\\nnoise = {frequency = "0.02 Hz", decay = "0.05 1/s"}\\n'
    >>> _ = path.write_text('[[test]]\\nkind = "ring-down"\\n' + reading)
    >>> free = {"moving_mass": 0.5, "damping_coefficient": 1.0}
    >>> fit = gelcone.fit_device(device, gelcone.read_device_tests(path), free)
    >>> f"{1e3 * gelcone.fitted_device(fit).moving_mass:.2f} g"
    '8.16 g'
    """
    check_kind("fit_device", tests, DeviceTests, READ_TESTS)
    if not tests.measured:
        raise InputError("a test has no readings; measure them, or ask for the plan, which needs none")
    chosen = itertools.product(
        [None] if films is None else dict.fromkeys(films), [None] if losses is None else dict.fromkeys(losses)
    )
    problems = {_structure(device, *pair): _checked(_problem(device, tests, free, *pair)) for pair in chosen}
    _check_signs(next(iter(problems.values())))
    fitted, impossible = _fitted(problems)
    structure, best = min(fitted.items(), key=lambda one: one[1].objective)
    refused = best.p_value < REFUSED
    wider = float(np.sqrt(best.chi2 / best.problem.values.size)) if refused else 1.0
    covariance = best.covariance * wider**2
    plan = plan_of(best.problem, best.logs)
    result = _planned(best.problem, plan, best.logs, np.sqrt(np.diag(covariance)))
    spread = {"covariance": (covariance, "covariance of the logarithms of the factors", "share")}
    result = result.assign(dataset.columns(("unknown", "other_unknown"), spread))
    if profile:
        result = result.assign(_profiles(best, profile))
    predicted = predictions_of(best.problem, best.logs, covariance, read_predictions(predict))
    commanded = [values for test in tests.tests for name, values in test.set.items() if name.startswith("voltage")]
    result = result.merge(predicted).merge(_readings(best)).merge(_others(best, fitted))
    return result.assign_attrs(predicted.attrs).assign_attrs(
        title=f"device fit: {device.name}",
        film=str(best.problem.device.film),
        chosen=structure,
        chi2=best.chi2,
        p_value=best.p_value,
        refused=int(refused),
        device=device.name,
        highest_voltage=max(float(np.abs(v).max()) for v in commanded) if commanded else 0.0,
        fitted=best.device.to_toml(),
        impossible=json.dumps(impossible),
        **_about(best.problem, best.device),
    )


def _fitted(problems: Mapping[str, Problem]) -> tuple[dict[str, FittedDevice], dict[str, str]]:
    """The fit of each structure, and the reason for each without a state at a measured value; `InputError` if all have
    none."""
    fits, impossible = {}, {}
    for structure, problem in problems.items():
        try:
            fits[structure] = fit_problem(problem)
        except NoStateError as error:
            impossible[structure] = str(error)
        except InputError as error:
            raise InputError(
                f"the fit runs into {str(error).partition(';')[0]}: are the units and signs of the readings right? "
                "else give that field a narrower prior"
            ) from None
    if not fits:
        raise InputError(next(iter(impossible.values())))
    return fits, impossible


def _check_signs(problem: Problem) -> None:
    """Raise `InputError` for forces and strokes that have the opposite sign of the device's throughout a test, if both
    exceed the noise by far."""
    (predicted,) = problem.predict(np.zeros((1, problem.priors.size)))
    first = 0
    for test in problem.tests:
        for name, values in test.read.items():
            expected, noise = predicted[first : first + len(values)], test.noise[name]
            first += len(values)
            is_known = np.isfinite(expected) & np.isfinite(values)
            both = np.array([expected[is_known], values[is_known]]) / noise[is_known]
            sizes = np.linalg.norm(both, axis=1)
            certain = (sizes > CERTAIN * np.sqrt(is_known.sum())).all()
            if name in UPWARD and certain and both[0] @ both[1] < OPPOSITE * sizes.prod():
                raise InputError(
                    f"{test.name}: {name} has the opposite sign of the device's; upward is positive, of a force that "
                    f'holds the disc, too: write a minus before its column, {name} = "-{name.title()}, ..."'
                )


def _profiles(best: FittedDevice, wanted: Sequence[str]) -> dict[str, Any]:
    """The profile intervals of the ``wanted`` unknowns; NaN for all others."""
    names = best.problem.names
    check_names("free field or gain of this fit", wanted, names, where="profile: ")
    ends = np.array([profiled(best, name) if name in wanted else (np.nan, np.nan) for name in names])
    return dataset.columns("unknown", {
        "profile_low": (ends[:, 0], "lower end of the profile interval, as a logarithm", "share"),
        "profile_high": (ends[:, 1], "upper end of the profile interval, as a logarithm", "share"),
    })  # fmt: skip


# --- problems ---------------------------------------------------------------------------------------------------------


def _structure(device: Device, film: str | None, loss: str | None) -> str:
    """The name of a structure."""
    return f"{film or device.film} film" + (f", loss {loss}" if loss else "")


def _problem(
    device: Device, tests: DeviceTests, free: Mapping[str, float | str], film: str | None, loss: str | None = None
) -> Problem:
    priors = {name: _read_prior(name, given, device, field_value(device, name)) for name, given in free.items()}
    if film is not None and film not in FILMS:
        raise unknown_name("film that can be fitted", str(film), FILMS)
    variant = device if film is None or film == device.film else device.replace_quietly(film=film)
    variant, priors = (variant, priors) if loss is None else _with_loss(variant, priors, loss)
    return Problem(variant, priors, tests.tests, dict(tests.gains))


def _with_loss(device: Device, free: Mapping[str, float], loss: str) -> tuple[Device, dict[str, float]]:
    """A device with another structure of its loss, and its free fields."""
    check_name("structure of the loss", loss, LOSSES)
    if device.damping_coefficient is None:
        raise InputError("loss: needs damping_coefficient in place of a damping that changes with other fields")
    branches = {
        name: None for name in device.swept_fields() if name.startswith(("material.viscous_", "material.relax"))
    }
    changes: dict[str, Any] = {}
    if loss == "damper":
        changes = branches
    elif not device.material.branches:
        modulus = BRANCH_SHARE * float(device.material.shear_modulus)
        changes = dict(zip(BRANCH, (modulus, 1.0 / (2.0 * np.pi * float(device.frequency))), strict=True))
    if loss == "branch":
        changes |= {"damping_coefficient": 0.0}
    variant = device.replace_quietly(changes)
    fields = ["damping_coefficient", *branches]
    added = {name: ANY for name in fields if variant.get(name) and name not in free}
    return variant, {
        name: prior for name, prior in {**free, **added}.items() if name not in fields or variant.get(name)
    }


def _checked(problem: Problem) -> Problem:
    """Return the problem; `InputError` for fields without priors that can change together without changing a
    reading."""
    names = list(problem.free)
    open_ = {name for name, prior in problem.free.items() if prior >= WIDE}
    for direction in plan_of(problem).directions if open_ else ():
        moved = {name for name, share in zip(names, direction, strict=True) if share}
        if moved and moved <= open_:
            raise InputError(_one_too_many(moved))
    return problem


GEL = {"material.shear_modulus", "material.relative_permittivity"}


def _one_too_many(moved: set[str]) -> str:
    if moved == {*GEL, "film_thickness"}:
        return (
            "free film_thickness: with material.shear_modulus and material.relative_permittivity free and no prior, "
            "these three are one number too many: mu H and eps/H are all that any test here determines; give one of "
            "them a prior, such as 3 % of film_thickness"
        )
    first, *others = sorted(moved)
    together = f"with {', '.join(others)} free and no prior, these change together" if others else "it changes"
    return f"free {first}: {together} without changing any reading; give it a prior, such as 3 %"


# --- the result -------------------------------------------------------------------------------------------------------


def _about(problem: Problem, device: Device) -> dict[str, Any]:
    return {
        "tests": json.dumps([test.name for test in problem.tests]),
        "readings": int(problem.values.size),
        "reading": json.dumps(notes_of((test.name, test.name, test.notes) for test in problem.tests)),
        "gelcone_version": __version__,
        **dataset.film_errors(device.to_model()),
    }


def _planned(problem: Problem, plan: Plan, logs: Array, spread: Array) -> xr.Dataset:
    """Label the unknowns ``logs`` with their standard deviations ``spread``, and the information of the tests about
    them: singular values, directions, nominal and fitted values of the fields."""
    import xarray as xr

    import gelcone.accessor  # noqa: F401  (gives Datasets their methods)

    fields = list(problem.free)
    nominal = np.array([field_value(problem.device, name) for name in fields])
    unknown = dataset.columns("unknown", {
        "prior": (problem.priors, "relative standard deviation of the prior", "share"),
        "posterior": (spread, "relative standard deviation that the tests leave", "share"),
        "deviation": (logs, "logarithm of the factor on the nominal value", "share"),
    })  # fmt: skip
    field = dataset.columns("field", {
        "nominal": (nominal, "nominal value in SI", "share"),
        "value": (nominal * np.exp(logs[: len(fields)]), "value in SI", "share"),
    })  # fmt: skip
    along = {"singular_value": (plan.singular, "what is learnt along it, over the priors", "share")}
    still = {"exponent": (plan.directions, "change that leaves every reading", "share")}
    directions = dataset.columns("direction", along) | dataset.columns(("invariant", "field"), still)
    coords = {"unknown": problem.names, "field": fields}
    return xr.Dataset({**unknown, **field, **directions}, coords, {"learnt": plan.learnt})


def _readings(best: FittedDevice) -> xr.Dataset:
    """Label all readings of the tests, measured and predicted."""
    import xarray as xr

    tests = best.problem.tests
    names = [name for test in tests for name, values in test.read.items() for _ in values]
    along = [value for test in tests for _ in test.read for value in _along(test)[0]]
    axes = [_along(test)[1] for test in tests for _ in test.values]
    units = [reading.unit for test in tests for reading in test.readings]
    test_numbers = np.repeat(np.arange(len(tests)), [test.values.size for test in tests])
    return xr.Dataset(dataset.columns("reading", {
        "reading_test": (test_numbers, "number of its test", "count"),
        "reading_name": (names, "what is read", "code"),
        "reading_axis": (axes, "what it is drawn over", "code"),
        "reading_unit": (units, "unit of the reading", "code"),
        "reading_along": (along, "voltage, height or frequency of the reading, in SI", "share"),
        "measured": (best.problem.values, "measured value in SI", "share"),
        "noise": (best.problem.noise, "standard deviation of its noise", "share"),
        "predicted": (best.predicted, "value of the fitted device", "share"),
    }))  # fmt: skip


def _along(test: DeviceTest) -> tuple[Array, str]:
    """The abscissa of a test in figures, with its name: the first set number that varies, else the row."""
    rows = len(next(iter(test.read.values())))
    if test.kind == "series":
        return test.set["time"][rows_read(len(test.set["time"]))], "time (s)"
    for name in ("frequency", "height", "load", "voltage"):
        if name in test.set and np.ptp(test.set[name]):
            return test.set[name], f"{name} ({KINDS[test.kind].set[name]})"
    return np.arange(rows, dtype=float), "row"


def _others(best: FittedDevice, fitted: Mapping[str, FittedDevice]) -> xr.Dataset:
    """Label the predictions of each test from the others, and the objectives of the structures."""
    import xarray as xr

    out = left_out(best)
    tests = dataset.columns("test", {
        "left_out_chi2": ([one.chi2 for one in out], "chi2 of a test predicted from the others", "share"),
        "left_out_points": ([one.points for one in out], "number of its readings", "count"),
        "left_out_p_value": ([one.p_value for one in out], "probability of a larger one", "share"),
    }) if out else {}  # fmt: skip
    structures = dataset.columns("structure", {
        "structure_objective": ([one.objective for one in fitted.values()], "chi2 with priors and gains", "share"),
        "structure_p_value": ([one.p_value for one in fitted.values()], "probability of a larger chi2", "share"),
    })  # fmt: skip
    coords: dict[str, Any] = {"structure": list(fitted)} | ({"test": [one.name for one in out]} if out else {})
    return xr.Dataset({**tests, **structures}, coords=coords)
