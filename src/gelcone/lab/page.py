"""Measured devices of the literature: stated numbers, predictions from them, and their agreement with measurements.

Every number of a page has a value, a unit, the sentence that states it, and a kind. A prediction with more than half of
its variance from assumed numbers is refused.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from gelcone.devices.device import Device
from gelcone.devices.fields import DEVICE_FIELDS
from gelcone.devices.materials import find_material
from gelcone.devices.units import FieldError, format_si, parse, parse_share
from gelcone.errors import InputError, check_name, check_names, check_path, unknown_name
from gelcone.files import read_text, read_toml
from gelcone.lab.device_fit import STEP, Problem
from gelcone.lab.material import fit_material
from gelcone.lab.measured import place_of, read_tests
from gelcone.lab.predictions import PREDICTIONS, Asked, predicted_values, read_predictions
from gelcone.physics.records import FILMS
from gelcone.progress import Progress
from gelcone.quantity import Array
from gelcone.statistics import QUANTILES, Z

KINDS: Mapping[str, float] = {"stated": 0.01, "derived": 0.03, "digitised": 0.02, "assumed": 0.0}
"""Kinds of numbers -> default relative standard deviation; an assumed number must state its own."""
KEYS = ("title", "source", "missing", "device", "measured", "coupons")
DRAWS = 256
HALF = 0.5
"""Share of assumed numbers in a prediction's variance above which it is refused."""
INSIDE = 0.9
"""Share of the samples of a coupon within the band above which the test counts as inside."""
REMEDY = "give a TOML file as docs/measured holds them"
MOST = 200
"""Most numbers and most comparisons of a page."""


class Number(NamedTuple):
    """A number of a page in SI, its standard deviation and its kind."""

    value: float
    deviation: float
    kind: str


class Comparison(NamedTuple):
    """A quantity as predicted, with the ends of its 95 % interval, and as measured, in the ``unit``; ``verdict`` is
    inside, outside, or the reason why it is not compared."""

    quantity: str
    predicted: float
    low: float
    high: float
    measured: float
    unit: str
    verdict: str


class Page(NamedTuple):
    """A measured device: its title and source, the list of missing data, and its comparisons."""

    title: str
    source: str
    missing: tuple[str, ...]
    compared: tuple[Comparison, ...]


def compare_measured(path: str | Path, *, seed: int = 0, progress: Progress = None) -> Page:
    """Compare the predictions of a measured device, or of a material's tests, with what was measured.

    Parameters
    ----------
    path : a TOML file: ``title``, ``source`` and a list of ``missing`` data; a table ``[device]`` of fields, each a
        table with ``value``, ``unit``, ``sentence``, ``kind`` (stated, derived, digitised, assumed) and, if known,
        ``deviation``; tables ``[[measured]]`` with the same keys and a ``quantity`` such as ``"stroke@1.5 kV"``; or
        ``[coupons]`` with a list of ``tests`` on a film, each of which is predicted from the others.
    seed : of the draws. Default 0.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    The page: ``title``, ``source``, ``missing`` data, and the comparisons ``compared``.

    Raises
    ------
    InputError : in one line, for a file that cannot be read or used.

    Examples
    --------
    >>> import gelcone, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp(), "cone.toml")
    >>> _ = path.write_text('title = "A cone"\\nsource = "an abstract"\\nmissing = ["all sizes", "the voltage"]\\n')
    >>> page = gelcone.compare_measured(path)
    >>> len(page.missing), len(page.compared)
    (2, 0)
    """
    check_path("compare_measured", path)
    path = Path(path)
    content = read_toml(path, read_text(path, REMEDY))
    check_names("key of a measured device", content, KEYS, where=f"{path}: ")
    texts = [content.get(key, "") for key in ("title", "source")]
    missing = content.get("missing", [])
    if not all(isinstance(text, str) and text for text in texts):
        raise InputError(f"{path}: title or source is missing; {REMEDY}")
    if not isinstance(missing, list) or not all(isinstance(text, str) for text in missing):
        raise InputError(f"{path}: missing must be a list of texts")
    compared: list[Comparison] = []
    if "coupons" in content:
        compared = _coupons(path, content["coupons"], progress)
    elif "device" in content:
        compared = _device(path, content, seed)
    elif not missing:
        raise InputError(f"{path}: has no [device] and no [coupons], and does not say what is missing; {REMEDY}")
    return Page(texts[0], texts[1], tuple(missing), tuple(compared))


# --- a device ---------------------------------------------------------------------------------------------------------


def _device(path: Path, content: Mapping[str, Any], seed: int) -> list[Comparison]:
    numbers, texts = _fields(path, content["device"])
    listed = content.get("measured", [])
    if not isinstance(listed, list) or not all(isinstance(one, dict) for one in listed) or len(listed) > MOST:
        raise InputError(f"{path}: measured must be tables [[measured]], at most {MOST}")
    try:
        values: dict[str, Any] = {name: number.value for name, number in numbers.items()}
        device = Device(**{"name": path.stem, "film": "wrinkling", **texts, **values})
    except FieldError as error:
        raise InputError(f"{path}: {str(error).splitlines()[0]}") from None
    free = {name: one.deviation / abs(one.value) for name, one in numbers.items() if one.deviation and one.value > 0.0}
    problem = Problem(device, free, (), {})
    rng = np.random.default_rng(seed)
    spreads = np.array(list(free.values()))
    logs = spreads * rng.standard_normal((DRAWS, spreads.size))
    return [_compared(path, problem, numbers, logs, k, entry) for k, entry in enumerate(listed, start=1)]


def _fields(path: Path, given: Any) -> tuple[dict[str, Number], dict[str, str]]:
    """Numbers and names of a table ``[device]``."""
    if not isinstance(given, dict) or not given or len(given) > MOST:
        raise InputError(f"{path}: [device] must be a table of at most {MOST} fields")
    numbers, texts = {}, {}
    for name, entry in given.items():
        where = f"{path}: device.{name}"
        if name not in DEVICE_FIELDS and name not in ("material", "film"):
            raise InputError(f"{path}: [device] {unknown_name('device field', name[:60], DEVICE_FIELDS)}")
        if isinstance(entry, dict) and isinstance(entry.get("value"), str):
            texts[name] = _name(where, name, entry)
        else:
            numbers[name] = _number(where, entry, DEVICE_FIELDS[name].unit)
    return numbers, texts


def _name(where: str, name: str, entry: Mapping[str, Any]) -> str:
    """Read the name of a film or material that ships."""
    value = str(entry["value"])
    if name == "material":
        return str(find_material(value).name)
    choices = tuple(FILMS) if name == "film" else ()
    if value not in choices:
        raise InputError(f"{where}: {unknown_name(name, value[:60], choices or ('a number',))}")
    return value


def _number(where: str, entry: Any, unit: str) -> Number:
    keys = ("value", "unit", "sentence", "kind", "deviation", "quantity")
    if not isinstance(entry, dict):
        raise InputError(f"{where}: must be a table {{value = ..., unit = ..., sentence = ..., kind = ...}}")
    check_names("key of a number", entry, keys, where=f"{where}: ")
    kind, sentence = str(entry.get("kind")), entry.get("sentence")
    check_name("kind of number", kind, KINDS, where=f"{where}: ")
    if not isinstance(sentence, str) or not sentence.strip():
        raise InputError(f"{where}: the sentence that states it is missing")
    value = _si(where, entry.get("value"), str(entry.get("unit", "")), unit)
    if kind == "assumed" and "deviation" not in entry:
        raise InputError(f'{where}: is assumed; say how far off it may be, deviation = "20 %"')
    share = parse_share(f"{where}.deviation", entry["deviation"]) if "deviation" in entry else KINDS[kind]
    return Number(value, share * abs(value), kind)


def _si(where: str, value: Any, written: str, unit: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{where}: value = {str(value)[:60]!r}: must be a number, with its unit in unit")
    try:
        return parse("value", f"{value!r} {written}" if written not in ("", "1") else float(value), unit)
    except FieldError as error:
        raise InputError(f"{where}: {error}") from None


def _compared(
    path: Path, problem: Problem, numbers: Mapping[str, Number], logs: Array, k: int, entry: Mapping[str, Any]
) -> Comparison:
    """Compare a quantity as predicted and as measured."""
    where = f"{path}: measured {k}"
    if not isinstance(entry.get("quantity"), str):
        raise InputError(f'{where}: quantity is missing; give one of {", ".join(PREDICTIONS)}, such as "stroke@1 kV"')
    (asked,) = read_predictions([entry["quantity"]])
    unit = PREDICTIONS[asked.kind]
    measured = _number(where, entry, unit)
    predicted = predicted_values(problem, logs, asked)
    low, middle, high = np.nanquantile(predicted, QUANTILES) if np.isfinite(predicted).any() else [np.nan] * 3
    blamed = _assumed(problem, numbers, asked)
    if blamed:
        verdict = f"not compared: it rests on assumed numbers ({', '.join(blamed)})"
    elif not np.isfinite(predicted).all():
        verdict = f"not compared: {np.isnan(predicted).mean():.0%} of the draws have no such state"
    else:
        apart = abs(middle - measured.value)
        deviation = np.hypot((high - middle if measured.value > middle else middle - low) / Z, measured.deviation)
        verdict = "inside" if apart <= Z * deviation else "outside"
    return Comparison(asked.text, float(middle), float(low), float(high), measured.value, unit, verdict)


def _assumed(problem: Problem, numbers: Mapping[str, Number], asked: Asked) -> list[str]:
    """The assumed numbers that cause more than half of the variance of a prediction, the strongest first; else
    empty."""
    spreads = np.array(list(problem.free.values()))
    if not spreads.size:
        return []
    steps = STEP * np.eye(spreads.size)
    slopes = (predicted_values(problem, steps, asked) - predicted_values(problem, -steps, asked)) / (2.0 * STEP)
    shares = (np.nan_to_num(slopes) * spreads) ** 2
    assumed_shares = {
        name: share for name, share in zip(problem.free, shares, strict=True) if numbers[name].kind == "assumed"
    }
    if sum(assumed_shares.values()) <= HALF * shares.sum():
        return []
    largest = sorted(assumed_shares.items(), key=lambda item: -item[1])[:3]
    return [f"{name} {share / shares.sum():.0%}" for name, share in largest if share > 0.01 * shares.sum()]


# --- tests on coupons -------------------------------------------------------------------------------------------------


def _coupons(path: Path, given: Any, progress: Progress) -> list[Comparison]:
    """Compare each test on a film with its prediction from the others, by the share of samples within the band."""
    keys = ("tests", "material", "law", "branches", "relative_permittivity")
    if not isinstance(given, dict):
        raise InputError(f"{path}: [coupons] must be a table; {REMEDY}")
    check_names("setting", given, keys, where=f"{path}: coupons: ")
    tests = read_tests(place_of(path, f"{path}: coupons", given.get("tests")))
    laws = [str(given["law"])] if "law" in given else None
    counts = [given["branches"]] if "branches" in given else None
    if counts is not None and (isinstance(counts[0], bool) or not isinstance(counts[0], int)):
        raise InputError(f"{path}: coupons.branches = {str(counts[0])[:60]!r}: must be a whole number")
    material = {"name": str(given.get("material", path.stem))[:60]}
    fitted = fit_material(tests, material, laws=laws, branches=counts, draws=0, progress=progress)
    band, compared = float(fitted.attrs["band"]), []
    for k in range(fitted.sizes["test"]):
        rows = np.flatnonzero(fitted["sample_test"].values == k)
        stress, out = (1e3 * fitted[name].values[rows] for name in ("stress", "left_out"))
        if not np.isfinite(out).all():
            continue
        most = 1e3 * float(fitted["largest_stress"][k])
        share = float((np.abs(out - stress) <= band * most).mean())
        at = int(np.argmax(np.abs(stress)))
        verdict = f"{'inside' if share >= INSIDE else 'outside'} ({share:.0%} of {rows.size} samples)"
        name = f"{fitted['test_name'].values[k]}: largest stress"
        low, high = out[at] - band * most, out[at] + band * most
        compared.append(Comparison(name, out[at], low, high, stress[at], "Pa", verdict))
    return compared


def page_words(page: Page) -> str:
    """The text of a page."""
    lines = [f"{page.title} ({page.source})"]
    width = max((len(one.quantity) for one in page.compared), default=0) + 2
    for one in page.compared:
        predicted, low, high, measured = (
            format_si(float(f"{value:.4g}"), one.unit) if np.isfinite(value) else "none"
            for value in (one.predicted, one.low, one.high, one.measured)
        )
        interval = f"{predicted} ({low} to {high})"
        lines.append(f"  {one.quantity:{width}s}{interval:36s}  measured {measured:10s}  {one.verdict}")
    if not page.compared:
        lines.append("  nothing is compared")
    counted = [one.verdict.partition(" ")[0] for one in page.compared if not one.verdict.startswith("not")]
    if counted:
        lines.append(f"{counted.count('inside')} of {len(counted)} inside the interval of their prediction")
    if page.missing:
        lines.append(f"missing: {'; '.join(page.missing)}")
    return "\n".join(lines)
