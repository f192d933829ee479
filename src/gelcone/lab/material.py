"""Fit of a material with Maxwell branches to tests on coupons, as a Dataset, and its table for device files."""

from __future__ import annotations

import dataclasses
import datetime
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone import dataset
from gelcone._version import __version__
from gelcone.devices.materials import Material
from gelcone.devices.record import Record
from gelcone.devices.template import material_text
from gelcone.devices.units import FieldError, format_range
from gelcone.errors import InputError, check_kind, check_name, check_names, check_result
from gelcone.lab.coupons import Coupon, Spectrum, same_temperature
from gelcone.lab.material_fit import (
    Band,
    Candidate,
    Compared,
    Tabulated,
    band_of,
    bootstrap,
    choose,
    compare,
    errors_of,
    largest,
)
from gelcone.lab.measured import Measured, notes_of
from gelcone.lab.stress import stress_of
from gelcone.physics.film.branches import FLOWS, MOST_BRANCHES
from gelcone.physics.laws import LAWS
from gelcone.progress import Counted, Progress
from gelcone.quantity import Array, check_count
from gelcone.statistics import Z

if TYPE_CHECKING:
    import xarray as xr

TITLE = "material fit"
DRAWS = 60
AT_FREQUENCY = 10.0
"""Frequency, Hz, at which the permittivity of a spectrum is taken."""
CENTRAL = (0.1587, 0.8413)
"""Quantiles two standard deviations apart in a normal distribution, which do not depend on few odd draws."""
FEWEST_TESTS = 3
"""Fewest tests of which one can be left out."""


def fit_material(
    tests: Measured,
    material: Mapping[str, Any] | Material | None = None,
    *,
    laws: Sequence[str] | None = None,
    branches: Sequence[int] | None = None,
    flow: str = "log",
    draws: int = DRAWS,
    seed: int = 0,
    progress: Progress = None,
) -> xr.Dataset:
    """Fit a material with Maxwell branches to tests on coupons.

    Parameters
    ----------
    tests : result of `gelcone.read_tests`. Those at another temperature than most are left out.
    material : fields that are known without the tests: name, ``relative_permittivity``, ``dielectric_strength``,
        sources; its modulus, law and branches are replaced. Default: the permittivity of a measured spectrum at 10 Hz.
    laws : names of strain-energy laws to compare. Default all that ship.
    branches : numbers of branches to compare, 0 to 4; more than 3 are compared and not chosen. Default all.
    flow : flow rule of the branches, ``"log"`` or ``"linear"``.
    draws : sets of tests drawn with replacement, for intervals of the parameters. Default 60; 0: none.
    seed : of the draws. Default 0.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset with the errors of all candidates over ``law`` and ``branch_count``, also of tests predicted from the
    others; the ``value`` of each ``parameter`` with a 95 % interval and its ``draws``; all samples with the stress that
    is ``predicted`` by the material; and, in its attributes, the band of a prediction and the material itself, which
    `fitted_material` reads.

    Raises
    ------
    InputError : for tests that cannot be fitted, and for unknown options.

    Examples
    --------
    >>> import gelcone, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp(), "tension.csv")
    >>> rows = [f"{l},{8 * (l - l**-2):.4f}" for l in (1.0, 1.1, 1.2, 1.4, 1.6, 1.8, 2.0)]  # neo-Hookean, 8 kPa
    >>> _ = path.write_text("stretch,stress (kPa)\\n" + "\\n".join(rows))
    >>> tests = gelcone.read_tests(path)
    >>> fit = gelcone.fit_material(tests, {"relative_permittivity": 5}, laws=["neo-hookean"], branches=[0], draws=0)
    >>> f"{gelcone.fitted_material(fit).shear_modulus:.0f} Pa"
    '8000 Pa'
    """
    check_kind("fit_material", tests, Measured, "give tests on coupons, such as gelcone.read_tests('tension.csv')")
    chosen_laws = _checked_laws(laws)
    counts = _checked_counts(branches)
    check_name("flow", flow, FLOWS)
    check_count("draws", draws, 0)
    known = _known_fields(material)
    temperature, coupons = same_temperature(tests.coupons)
    permittivity = _permittivity(known, tests.spectra, temperature)
    fitted = [test for test in coupons if test.use == "fit"]
    if not fitted:
        raise InputError('no test is to be fitted; give use = "fit" to some in tests.toml')
    counted = Counted(progress)
    data = Tabulated(fitted, flow, float(known.get("relative_permittivity", permittivity[0])), counted)
    compared_counts = counts if data.grid.size else [0]
    alone = len(fitted) < FEWEST_TESTS
    if alone and len(chosen_laws) * len(compared_counts) > 1:
        raise InputError(
            f"laws: of {len(fitted)} tests, fewer than {FEWEST_TESTS}, none can be left out to choose a law; give one "
            "law and one number of branches"
        )
    compared = compare(data, chosen_laws, compared_counts, counted)
    key = next(iter(compared)) if alone else choose(compared, MOST_BRANCHES)
    best = compared[key]
    spread = bootstrap(best.fitted, draws if not alone else 0, seed, counted)
    band = Band(np.nan, np.nan, np.nan) if alone else band_of(data, best.predicted)
    gel = _material(known, permittivity, best, fitted, flow, band)
    coupons = [test if test.use == "leave out" or _predictable(test) else _unpredictable(test) for test in coupons]
    predicted = [stress_of(test, gel) if _predictable(test) else np.full(len(test.stress), np.nan) for test in coupons]
    result = _result(coupons, np.concatenate(predicted), data, compared, key, spread, band)
    counted.finish()
    read = [(one.file, one.name, one.notes) for one in coupons]
    read += [(one.file, one.name, one.notes) for one in tests.spectra]
    options = {"laws": chosen_laws, "branches": counts, "flow": flow, "draws": draws, "seed": seed}
    return result.assign_attrs(
        title=f"{TITLE}: {gel.name}",
        material=json.dumps(gel.parameters()),
        files=json.dumps(list(tests.files)),
        temperature=temperature,
        permittivity_note=permittivity[1],
        reading=json.dumps(notes_of(read)),
        options=json.dumps(options),
        gelcone_version=__version__,
    )


def fitted_material(result: xr.Dataset) -> Material:
    """Return the material of a fit, which devices take.

    Parameters
    ----------
    result : of `fit_material`, also one that `gelcone.load` has read.

    Returns
    -------
    The `Material`, with its Maxwell branches and sources.

    Raises
    ------
    InputError : for a Dataset that is not a material fit.

    Examples
    --------
    >>> import gelcone, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp(), "tension.csv")
    >>> rows = [f"{l},{8 * (l - l**-2):.4f}" for l in (1.0, 1.1, 1.2, 1.4, 1.6, 1.8, 2.0)]  # neo-Hookean, 8 kPa
    >>> _ = path.write_text("stretch,stress (kPa)\\n" + "\\n".join(rows))
    >>> tests = gelcone.read_tests(path)
    >>> fit = gelcone.fit_material(tests, {"relative_permittivity": 5}, laws=["neo-hookean"], branches=[0], draws=0)
    >>> gel = gelcone.fitted_material(fit)
    >>> f"{gel.shear_modulus:.0f} Pa", gel.relative_permittivity
    ('8000 Pa', 5.0)
    """
    check_result("fitted_material", result)
    if "material" not in result.attrs:
        raise InputError("fitted_material: was given no material fit; give a result of gelcone.fit_material")
    return Material(**json.loads(result.attrs["material"]))


def fitted_text(result: xr.Dataset) -> str:
    """Write the table ``[material]`` of a fit for device files.

    Parameters
    ----------
    result : of `fit_material`, also one that `gelcone.load` has read.

    Returns
    -------
    TOML, with the 95 % intervals of its numbers as comments.

    Raises
    ------
    InputError : for a Dataset that is not a material fit.

    Examples
    --------
    >>> import gelcone, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp(), "tension.csv")
    >>> rows = [f"{l},{8 * (l - l**-2):.4f}" for l in (1.0, 1.1, 1.2, 1.4, 1.6, 1.8, 2.0)]  # neo-Hookean, 8 kPa
    >>> _ = path.write_text("stretch,stress (kPa)\\n" + "\\n".join(rows))
    >>> tests = gelcone.read_tests(path)
    >>> fit = gelcone.fit_material(tests, {"relative_permittivity": 5}, laws=["neo-hookean"], branches=[0], draws=0)
    >>> [line for line in gelcone.fitted_text(fit).splitlines() if line.startswith("shear_modulus")][0]
    'shear_modulus = "8 kPa"                  # small-strain shear modulus'
    """
    material, comments = fitted_material(result), {}
    for k, name in enumerate(result["parameter"].values):
        low, high = float(result["low"][k]), float(result["high"][k])
        if np.isfinite(low):
            comments[str(name)] = f"95 %: {format_range(low, high, unit_of(str(name)), 3)}"
    head = f"# {result.attrs['title']}, made by gelcone {result.attrs['gelcone_version']}. Paste it into a device file."
    return f"{head}\n{material_text(material, comments)}\n"


# --- options ----------------------------------------------------------------------------------------------------------


def _checked_laws(laws: Sequence[str] | None) -> list[str]:
    chosen = list(LAWS) if laws is None else [laws] if isinstance(laws, str) else list(laws)
    check_names("law", chosen, LAWS)
    return list(dict.fromkeys(chosen))


def _checked_counts(branches: Sequence[int] | None) -> list[int]:
    counts = list(range(MOST_BRANCHES + 2)) if branches is None else sorted({*branches})
    for count in counts:
        check_count("branches", count, 0)
        if count > MOST_BRANCHES + 1:
            raise InputError(f"branches = {count}: must be at most {MOST_BRANCHES + 1}")
    if not counts or min(counts) > MOST_BRANCHES:
        raise InputError(
            f"branches = {counts}: a material takes at most {MOST_BRANCHES}; give one of 0 to {MOST_BRANCHES}"
        )
    return counts


_REPLACED = ("shear_modulus", "young_modulus", "law", "flow")


def _known_fields(material: Mapping[str, Any] | Material | None) -> dict[str, Any]:
    """The fields of a material that a fit takes over; `InputError` for unknown fields."""
    given = dict(material.parameters() if isinstance(material, Material) else material or {})
    law_fields = {name for law in LAWS.values() for name in law.parameters}
    replaced = {n for n in given if n in _REPLACED or n in law_fields or n.startswith(("viscous_", "relaxation_time_"))}
    sources = {name: text for name, text in dict(given.pop("sources", {})).items() if name not in replaced}
    kept_fields = {name: value for name, value in given.items() if name not in replaced}
    try:
        whole = Material(**{"relative_permittivity": 1.0, **kept_fields, "shear_modulus": 1.0, "sources": sources})
    except FieldError as error:
        raise error.within("material") from None
    kept = {name: getattr(whole, name) for name in kept_fields if getattr(whole, name) is not None}
    return kept | {"sources": sources}


def _permittivity(known: Mapping[str, Any], spectra: Sequence[Spectrum], temperature: float) -> tuple[float, str]:
    """The permittivity of the spectrum nearest to a temperature, and its source."""
    if "relative_permittivity" in known:
        return float(known["relative_permittivity"]), ""
    usable = [one for one in spectra if one.frequency.size and np.isfinite(one.frequency).all()]
    if not usable:
        raise InputError(
            "relative_permittivity: is missing; give it in the material's file, or a measured spectrum (columns freq "
            "and dielec) among the tests"
        )
    near = min(usable, key=lambda one: abs(one.temperature - temperature) if np.isfinite(temperature) else 0.0)
    logs = np.log(np.maximum(near.frequency, 1e-12))
    value = float(np.interp(np.log(AT_FREQUENCY), logs, near.permittivity))
    at = f", {near.temperature - 273.15:.3g} degC" if np.isfinite(near.temperature) else ""
    return value, (
        f"{near.name} at {AT_FREQUENCY:g} Hz{at} ({near.permittivity.min():.3g} to {near.permittivity.max():.3g} over "
        f"{near.frequency.min():.2g} to {near.frequency.max():.2g} Hz)"
    )


# --- the material -----------------------------------------------------------------------------------------------------


def _numbers(candidate: Candidate, theta: Array) -> dict[str, float]:
    """The fields of a material by name."""
    moduli, times = candidate.branches(theta)
    numbers = {"shear_modulus": float(np.exp(theta[0])), **candidate.numbers(theta)}
    for k, (modulus, time) in enumerate(zip(moduli, times, strict=True), start=1):
        numbers |= {f"viscous_modulus_{k}": float(modulus), f"relaxation_time_{k}": float(time)}
    return numbers


def _material(
    known: Mapping[str, Any],
    permittivity: tuple[float, str],
    best: Compared,
    fitted: Sequence[Coupon],
    flow: str,
    band: Band,
) -> Material:
    candidate = best.fitted.candidate
    numbers = {name: float(f"{value:.5g}") for name, value in _numbers(candidate, best.fitted.theta).items()}
    files = ", ".join(dict.fromkeys(test.file for test in fitted))
    modes = ", ".join(dict.fromkeys(test.mode for test in fitted))
    rule = (
        f"{candidate.law.name} with {candidate.count} branches, {flow} flow" if candidate.count else candidate.law.name
    )
    quality = f"{best.error(False):.2%} of the largest stress"
    if np.isfinite(band.width):
        quality += f", tests left out {best.error(True):.2%}, band +-{band.width:.1%}"
    source = (
        f"fit of {len(fitted)} {modes} tests ({files}): {rule}; mean error {quality}; gelcone {__version__}, "
        f"{datetime.date.today().isoformat()}"
    )
    sources = dict(known.get("sources", {}))
    given: dict[str, Any] = {name: value for name, value in known.items() if name != "sources"}
    if permittivity[1]:
        given["relative_permittivity"] = float(f"{permittivity[0]:.4g}")
        sources["relative_permittivity"] = permittivity[1]
    given.setdefault("name", "fitted material")
    branches = {"flow": flow} if candidate.count else {}
    sources |= {name: source if name == "shear_modulus" else "same fit" for name in numbers}
    return Material(**given | branches | numbers, law=candidate.law.name, sources=sources)


def unit_of(name: str) -> str:
    """The SI unit of a material's field, or of a law's parameter."""
    field = Material.fields.get(name)
    return "1" if field is None or not field.unit else field.unit


def _predictable(test: Coupon) -> bool:
    return test.use != "leave out" and (test.voltage == 0.0 or test.thickness > 0.0)


def _unpredictable(test: Coupon) -> Coupon:
    why = 'has a voltage and no thickness: not predicted; add thickness = "0.5 mm" for its file in tests.toml'
    return dataclasses.replace(test, notes=(*test.notes, why))


# --- the result -------------------------------------------------------------------------------------------------------


def _result(
    coupons: Sequence[Coupon],
    predicted: Array,
    data: Tabulated,
    compared: Mapping[tuple[str, int], Compared],
    key: tuple[str, int],
    spread: Array,
    band: Band,
) -> xr.Dataset:
    import xarray as xr

    import gelcone.accessor  # noqa: F401  (gives Datasets their methods)

    laws, counts = list(dict.fromkeys(law for law, _ in compared)), sorted({count for _, count in compared})
    errors = np.array([[[compared[law, n].error(out) for n in counts] for law in laws] for out in (False, True)])
    best = compared[key]
    candidate = best.fitted.candidate
    values = _numbers(candidate, best.fitted.theta)
    drawn = np.array([list(_numbers(candidate, theta).values()) for theta in spread]).reshape(-1, len(values))
    low, high = _intervals(np.array(list(values.values())), drawn)
    left_out = dict(
        zip(map(id, data.tests), np.split(best.predicted, np.cumsum(_lengths(data.tests))[:-1]), strict=True)
    )
    without = np.concatenate([left_out.get(id(test), np.full(len(test.stress), np.nan)) for test in coupons])
    sample = dataset.columns("sample", {
        "sample_test": (np.repeat(np.arange(len(coupons)), _lengths(coupons)), "number of its test", "count"),
        "time": (np.concatenate([t.time for t in coupons]), "time since the film began to be stretched", _SECONDS),
        "stretch": (np.concatenate([t.stretch for t in coupons]), "stretch along the coupon", "share"),
        "stress": (np.concatenate([t.stress for t in coupons]) / 1e3, "measured nominal stress", _KILOPASCALS),
        "predicted": (predicted / 1e3, "nominal stress of the material", _KILOPASCALS),
        "left_out": (without / 1e3, "nominal stress predicted from the other tests", _KILOPASCALS),
    })  # fmt: skip
    test = dataset.columns("test", {
        **{f"test_{key}": ([getattr(t, key) for t in coupons], words, "code") for key, words in _WORDS.items()},
        "largest_stress": ([largest(t) / 1e3 for t in coupons], "largest measured stress of a test", _KILOPASCALS),
        "error": (errors_of(coupons, predicted), _ERROR, "share"),
        "left_out_error": (errors_of(coupons, without), _ERROR_OUT, "share"),
        "voltage": ([t.voltage for t in coupons], "voltage on the coupon", {"units": "V", "quantity": "voltage"}),
    })  # fmt: skip
    table = dataset.columns(("law", "branch_count"), {
        "fit_error": (errors[0], f"mean {_ERROR}", "share"),
        "prediction_error": (errors[1], f"mean {_ERROR} of tests left out", "share"),
    })  # fmt: skip
    parameter = dataset.columns("parameter", {
        "value": (list(values.values()), "fitted value in SI", "share"),
        "low": (low, "lower end of the 95 % interval of the fitted value", "share"),
        "high": (high, "upper end of the 95 % interval of the fitted value", "share"),
    })  # fmt: skip
    words = "fits to tests drawn with replacement, in SI"
    draws = dataset.columns(("draw", "parameter"), {"draws": (drawn, words, "share")})
    coords = dataset.columns("law", {"law": (laws, "strain-energy law", "code")})
    coords |= dataset.columns("branch_count", {"branch_count": (counts, "number of Maxwell branches", "count")})
    coords |= dataset.columns("parameter", {"parameter": (list(values), "parameter of the material", "code")})
    return xr.Dataset(
        {**table, **parameter, **draws, **test, **sample},
        coords=coords,
        attrs={
            "chosen_law": key[0],
            "chosen_branches": key[1],
            "band": band.width,
            "band_mean": band.mean,
            "band_least": band.least,
        },
    )


_ERROR = "root mean square of the residuals over the largest stress"
_ERROR_OUT = f"{_ERROR}, predicted from the other tests"


_KILOPASCALS = {"units": "kPa", "quantity": "stress"}
_SECONDS = {"units": "s", "quantity": "time"}
_WORDS = {
    "name": "name of the test",
    "file": "file of the test",
    "mode": "mode of loading",
    "kind": "kind of test",
    "use": "use of the test",
}
"""Texts about each test -> long names."""


def _lengths(tests: Sequence[Coupon]) -> list[int]:
    return [len(test.stress) for test in tests]


def _intervals(values: Array, drawn: Array) -> tuple[Array, Array]:
    """95 % intervals from the central two thirds of the draws, in the logarithm of parameters that are always
    positive."""
    if len(drawn) < 2:
        return np.full(values.size, np.nan), np.full(values.size, np.nan)
    positive = (drawn > 0.0).all(axis=0) & (values > 0.0)
    with np.errstate(all="ignore"):
        scaled_draws = np.where(positive, np.log(drawn), drawn)
    half = 0.5 * Z * np.ptp(np.quantile(scaled_draws, CENTRAL, axis=0), axis=0)
    low, high = (np.where(positive, values * np.exp(end), values + end) for end in (-half, half))
    return low, high


def known_fields_of(path: Path, content: Mapping[str, Any]) -> dict[str, Any]:
    """The fields in a material's file, in its table ``[material]`` or on their own; `InputError` for other fields."""
    if isinstance(content.get("material"), Mapping):
        content = content["material"]
    unknown = [name for name in content if name not in Material.fields]
    if unknown:
        raise InputError(f"{path}: {Record.unknown(Material.__new__(Material), unknown[0])}")
    return dict(content)
