"""Tests on coupons of a film material, from measured tables: the history of stretch, and the measured stress."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gelcone.devices.reading import TIME, Column, Table, plain_unit, spelt_plainly
from gelcone.devices.units import format_si
from gelcone.errors import InputError
from gelcone.quantity import Array

MODES = ("uniaxial", "equi-biaxial", "pure shear")
KINDS = ("quasi-static", "loading", "cyclic", "relaxation", "creep")
WIDTHS = ("free", "held")
USES = ("fit", "check", "leave out")
LOADING_RATE = 0.005
"""Assumed strain rate, 1/s, of a loading that was not recorded: slow, since measured holds do not begin with the stress
of a step."""
FEWEST_ROWS, MOST_SAMPLES = 4, 400
"""Fewest samples of a test, and most, to which longer tests are thinned."""
HELD = 1e-3
"""Relative variation of the stretch below which it counts as constant."""
NEAR_ONE = 0.03
"""Distance from stretch 1 within which a test begins or ends unstretched."""
SAME_TEMPERATURE = 5.0
"""Largest difference of temperature, K, of tests that are fitted together."""
SOFTEST, STIFFEST = 2e3, 1e9
"""Moduli between which stresses without a unit are taken as pascals."""
KILO = 20.0
"""Voltages without a unit that all lie below this are probably kilovolts."""

ROLES: Mapping[str, tuple[str, ...]] = {
    "id": ("id", "test", "test id", "specimen", "sample", "run", "number", "nr", "no"),
    "label": ("description", "label", "name", "title"),
    "temperature": ("temp", "temperature"),
    "voltage": ("voltage", "volt", "u", "hv"),
    "rate": ("vel", "rate", "strain rate", "stretch rate", "velocity"),
    "stretch": ("stretch", "lambda", "lam", "stretch ratio", "\N{GREEK SMALL LETTER LAMDA}"),
    "strain": ("strain", "engineering strain", "nominal strain"),
    "stress": ("stress", "nominal stress", "engineering stress"),
    "force": ("force", "f", "load"),
    "extension": ("extension", "elongation"),
    "time": TIME,
    "frequency": ("freq", "frequency"),
    "permittivity": ("dielec", "permittivity", "relative permittivity", "dielectric constant", "eps r", "epsilon r"),
}
"""Role of a column -> names by which it is recognised."""
_SI = {
    "voltage": "V", "stress": "Pa", "force": "N", "extension": "m", "time": "s", "frequency": "Hz", "rate": "1/s",
}  # fmt: skip
"""Role -> SI unit."""
_OWN: Mapping[str, tuple[Mapping[str, float], str]] = {
    "rate": (
        {"1/s": 1.0, "s-1": 1.0, "s^-1": 1.0, "/s": 1.0, "%/s": 1e-2, "1/min": 1 / 60.0},
        "{!r} is not a strain rate; write it in 1/s",
    ),
    "strain": ({"": 1.0, "%": 1e-2}, "{!r} is not a unit of a strain; write it in %"),
    "stretch": ({"": 1.0}, "stretch has no unit; {!r} is one"),
    "permittivity": ({"": 1.0}, "permittivity has no unit; {!r} is one"),
}
"""Role with units of its own -> unit -> its size in SI, and the message for another unit."""


@dataclass(frozen=True)
class Coupon:
    """A test on a coupon.

    Attributes
    ----------
    name : the file, and the id of the test in it.
    file : the file alone.
    mode, kind : one of `MODES` and of `KINDS`.
    time, stretch, stress : samples, (n,) each: time in s, stretch along the coupon and nominal stress in Pa. The time
        starts when the stretching of the rested film begins; NaN in a quasi-static test.
    history : times and stretches, (k,) each, between which the stretch is linear, samples among them; empty in a
        quasi-static test.
    voltage : across the thickness, V. ``thickness`` : of the unstretched film, m; NaN if not stated.
    width : ``free`` to contract, or ``held``.
    temperature : K; NaN if not stated.
    use : ``fit``; ``check``: predicted and not fitted; or ``leave out``.
    notes : notes about interpreted data, and the reason why a test is not fitted.
    """

    name: str
    file: str
    mode: str
    kind: str
    time: Array
    stretch: Array
    stress: Array
    history: tuple[Array, Array]
    voltage: float = 0.0
    thickness: float = np.nan
    width: str = "free"
    temperature: float = np.nan
    use: str = "fit"
    notes: tuple[str, ...] = ()

    def with_use(self, use: str, why: str) -> Coupon:
        """The test with another use, and the reason among its notes."""
        return dataclasses.replace(self, use=use, notes=(*self.notes, why))


@dataclass(frozen=True)
class Spectrum:
    """A measured relative ``permittivity`` over ``frequency`` in Hz, (n,) each, at a ``temperature`` in K."""

    name: str
    file: str
    frequency: Array
    permittivity: Array
    temperature: float
    notes: tuple[str, ...] = ()


# --- columns and their units ------------------------------------------------------------------------------------------


def roles_of(table: Table, named: Mapping[str, str]) -> dict[str, tuple[Column, str | None]]:
    """Find the column of each role, and its unit, by the names of columns or as ``named``: role -> ``"NAME, UNIT"``.

    Raises `InputError` for a name that is not a column, and for two columns with one role.
    """
    roles: dict[str, tuple[Column, str | None]] = {}
    for role, text in named.items():
        column_name, stated = table.named(text, f"{table.file}: {role} = {text!r}: ")
        roles[role] = table.columns[column_name], table.unit_of(column_name, stated)
    taken = {column.name for column, _ in roles.values()}
    for name, column in table.columns.items():
        guess = next((role for role, names in ROLES.items() if spelt_plainly(name) in names), None)
        if name not in taken and guess is not None:
            if guess in roles and guess not in named:
                raise InputError(
                    f"{table.file}: columns {roles[guess][0].name!r} and {name!r} both look like {guess}; name one in "
                    f'tests.toml: {guess} = "{name}"'
                )
            roles.setdefault(guess, (column, column.unit))
    return roles


def in_si(table: Table, role: str, column: Column, unit: str | None, notes: list[str]) -> Array:
    """Convert a column to SI units; `InputError` for words, and for a unit that is missing or of another quantity."""
    values = table.numbers(column.name, role)
    if role == "temperature":
        return _kelvin(table, column.name, values, unit, notes)
    if unit is None:
        unit = _assumed_unit(table, role, column.name, values, notes)
    if role not in _OWN:
        return values * table.size_of(column.name, unit, _SI[role])
    factors, refusal = _OWN[role]
    if plain_unit(unit) not in factors:
        raise InputError(f"{table.file}: column {column.name!r}: {refusal.format(unit)}")
    return values * factors[plain_unit(unit)]


def _kelvin(table: Table, name: str, values: Array, unit: str | None, notes: list[str]) -> Array:
    if unit is None:
        unit = "K" if np.nanmedian(values) > 150.0 else "degC"
        notes.append(f"column {name!r} has no unit: taken as {unit}")
    if unit not in ("K", "degC", "\N{DEGREE SIGN}C", "C", "celsius"):
        raise InputError(f"{table.file}: column {name!r}: {unit!r} is not K or degC; write one of them")
    return values if unit == "K" else values + 273.15


def refuse_kilovolts(table: Table, volts: Array) -> None:
    """Raise `InputError` for voltages without a unit that are implausibly small in V."""
    sizes = np.abs(volts[volts != 0.0])
    if sizes.size and sizes.max() < KILO:
        raise InputError(
            f"{table.file}: {sizes.size} of {sizes.size} voltages are below {KILO:g} V: kilovolts? write the unit"
        )


SHORT = {"N": "mN", "m": "mm"}
"""SI unit -> a usual unit of measured columns, for messages."""


def without_unit(table: Table, role: str, name: str, unit: str) -> InputError:
    """Make the error for a column without a unit."""
    named = f'{role} = "{name}, {SHORT.get(unit, unit)}"'
    return InputError(f"{table.without_unit(name, unit)}, or name it in tests.toml: {named}")


def _assumed_unit(table: Table, role: str, name: str, values: Array, notes: list[str]) -> str:
    """The unit of a column that states none: SI, of plausible voltages alone; forces and extensions are refused."""
    unit = _SI.get(role, "")
    if role in ("force", "extension"):
        raise without_unit(table, role, name, unit)
    if role == "voltage":
        refuse_kilovolts(table, values[np.isfinite(values)])
    if unit:
        notes.append(f"column {name!r} has no unit: taken as {unit}")
    return unit


# --- tests of a table -------------------------------------------------------------------------------------------------


def spectra_of(table: Table, named: Mapping[str, str]) -> list[Spectrum]:
    """Read the permittivity spectra of a table; none without columns of frequency and permittivity."""
    roles = roles_of(table, named)
    if not {"frequency", "permittivity"} <= roles.keys():
        return []
    notes: list[str] = []
    role_names = ("frequency", "permittivity", "temperature")
    numbers = {role: in_si(table, role, *roles[role], notes) for role in role_names if role in roles}
    spectra = []
    for name, rows in _groups(table, roles):
        keep = rows[np.isfinite(numbers["frequency"][rows]) & np.isfinite(numbers["permittivity"][rows])]
        order = keep[np.argsort(numbers["frequency"][keep])]
        eps = numbers["permittivity"][order]
        if order.size and (eps < 1.0).any():
            raise InputError(
                f"{table.file}: a relative permittivity of {eps.min():.3g} is below 1; give it over that of vacuum"
            )
        spectra.append(
            Spectrum(
                name,
                table.file,
                numbers["frequency"][order],
                eps,
                _one(numbers.get("temperature"), rows, np.nan),
                (*table.notes, *notes),
            )
        )
    return spectra


def coupons_of(table: Table, settings: Mapping[str, Any]) -> list[Coupon]:
    """Read the coupon tests of a table, split by its ids, with their notes.

    ``settings`` are those of tests.toml (`gelcone.lab.measured.KEYS`): mode, width, thickness, rate, loading_rate,
    temperature, voltage, use, gauge_length, specimen_width, hold_from, creep, columns.
    """
    roles = roles_of(table, settings.get("columns", {}))
    notes = list(table.notes)
    used = {column.name for column, _ in roles.values()}
    notes += [f"column {name!r} is not used" for name in table.columns if name not in used]
    numbers = {role: in_si(table, role, *roles[role], notes) for role in roles if role not in ("id", "label")}
    numbers |= _derived(table, numbers, settings)
    for role in ("stretch", "stress"):
        if role not in numbers:
            known = ", ".join(table.columns)
            raise InputError(
                f"{table.file}: no column is a {role} (columns: {known}); name it in tests.toml: "
                f'{role} = "COLUMN{", kPa" if role == "stress" else ""}"'
            )
    if roles.get("stress") and roles["stress"][1] is None:
        _check_pascals(table, numbers)
    return _without_repeats([
        _coupon(table, name, rows, numbers, settings, notes) for name, rows in _groups(table, roles)
    ])  # fmt: skip


def _derived(table: Table, numbers: Mapping[str, Array], settings: Mapping[str, Any]) -> dict[str, Array]:
    """Compute the stretch from strain or extension, and the stress from force, if they are not given."""
    derived = {}
    if "stretch" not in numbers and "strain" in numbers:
        derived["stretch"] = 1.0 + numbers["strain"]
    elif "stretch" not in numbers and "extension" in numbers:
        derived["stretch"] = 1.0 + numbers["extension"] / _needed(table, settings, "gauge_length", "extension")
    if "stress" not in numbers and "force" in numbers:
        width = _needed(table, settings, "specimen_width", "force")
        derived["stress"] = numbers["force"] / (width * _needed(table, settings, "thickness", "force"))
    return derived


def _needed(table: Table, settings: Mapping[str, Any], name: str, column: str) -> float:
    if settings.get(name) is None:
        raise InputError(f'{table.file}: its {column} needs {name}; add {name} = "20 mm" in tests.toml')
    return float(settings[name])


def _check_pascals(table: Table, numbers: Mapping[str, Array]) -> None:
    """Raise `InputError` for stresses without a unit that are implausible for an elastomer in pascals."""
    strain = np.abs(numbers["stretch"] - 1.0)
    far = strain > 0.1
    if not far.any():
        return
    modulus = float(np.nanmax(np.abs(numbers["stress"][far]) / np.minimum(strain[far], 2.0)))
    if not SOFTEST < modulus < STIFFEST:
        most = float(np.nanmax(np.abs(numbers["stress"])))
        raise InputError(f"{table.file}: the largest stress is {most:.4g}: is it in kPa or MPa? write the unit")


def _groups(table: Table, roles: Mapping[str, tuple[Column, str | None]]) -> Iterator[tuple[str, Any]]:
    """The name of each test of a table, and the indices of its rows."""
    label_role = roles.get("id") or roles.get("label")
    stem = table.file.rsplit(".", 1)[0]
    if label_role is None:
        yield stem, np.arange(len(table.lines))
        return
    words = label_role[0].words
    for word in dict.fromkeys(words):
        yield f"{stem} {word[:40]}", np.flatnonzero(np.array([label == word for label in words]))


def _one(values: Array | None, rows: Any, default: float) -> float:
    if values is None:
        return default
    row_values = values[rows]
    return float(np.nanmedian(row_values)) if np.isfinite(row_values).any() else default


def _coupon(
    table: Table, name: str, rows: Any, numbers: Mapping[str, Array], settings: Mapping[str, Any], notes: list[str]
) -> Coupon:
    """Read one test of a table."""
    test_notes = list(notes)
    whole = np.isfinite(numbers["stretch"][rows]) & np.isfinite(numbers["stress"][rows])
    if not whole.all():
        test_notes.append(f"{int((~whole).sum())} rows without stretch or stress left out")
    rows = rows[whole]
    line = table.lines[int(rows[0])] if rows.size else 1
    if rows.size < FEWEST_ROWS:
        raise InputError(f"{table.file}, line {line}: test {name!r} has {rows.size} rows; give at least {FEWEST_ROWS}")
    if rows.size > MOST_SAMPLES:
        test_notes.append(f"thinned from {rows.size} to {MOST_SAMPLES} samples")
        rows = rows[np.linspace(0, rows.size - 1, MOST_SAMPLES).round().astype(int)]
    stretch, stress = numbers["stretch"][rows], numbers["stress"][rows]
    if (stretch <= 0.0).any() or (stretch > 50.0).any():
        odd = int(rows[np.argmax((stretch <= 0.0) | (stretch > 50.0))])
        raise InputError(
            f"{table.file}, line {table.lines[odd]}: stretch {numbers['stretch'][odd]:.4g}: must be over 0 and at most "
            "50; is it a strain, or a strain in %? name the column strain (%)"
        )
    voltage = abs(_one(numbers.get("voltage"), rows, float(settings.get("voltage") or 0.0)))
    rate = _one(numbers.get("rate"), rows, float(settings.get("rate") or np.nan))
    coupon = Coupon(
        name=name,
        file=table.file,
        mode=settings.get("mode", MODES[0]),
        kind="quasi-static",
        time=np.full(rows.size, np.nan),
        stretch=stretch,
        stress=stress,
        history=(np.empty(0), np.empty(0)),
        voltage=voltage,
        thickness=float(settings.get("thickness") or np.nan),
        width=settings.get("width", WIDTHS[0]),
        temperature=_one(numbers.get("temperature"), rows, float(settings.get("temperature") or np.nan)),
        use=settings.get("use") or ("check" if voltage > 0.0 else "fit"),
    )
    if "time" in numbers:
        coupon = _timed(table, coupon, numbers["time"][rows], rows, settings, test_notes)
    elif np.isfinite(rate):
        if not rate > 0.0:
            raise InputError(f"{table.file}, line {line}: strain rate {rate:g}: must be greater than 0")
        coupon = _at_rate(coupon, rate)
    elif settings.get("kind", "quasi-static") != "quasi-static":
        raise InputError(f'{table.file}: has neither time nor rate; add rate = "0.1 1/s" in tests.toml')
    else:
        test_notes.append("has neither time nor rate: taken as quasi-static, with all branches relaxed")
    return dataclasses.replace(coupon, notes=(*test_notes, *_oddities(coupon)))


def _at_rate(coupon: Coupon, rate: float) -> Coupon:
    """Complete a test at a constant rate, whose time follows from the stretch."""
    path = np.concatenate([[1.0], coupon.stretch])
    times = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(path))) / rate])
    return dataclasses.replace(coupon, kind=_moving(coupon.stretch), time=times[1:], history=(times, path))


def _moving(stretch: Array) -> str:
    """The kind of a test whose stretch moves."""
    turns = np.diff(stretch)
    return "cyclic" if (turns < -HELD).any() and (turns > HELD).any() else "loading"


def _timed(
    table: Table, coupon: Coupon, time: Array, rows: Any, settings: Mapping[str, Any], notes: list[str]
) -> Coupon:
    """Complete a test with recorded times; the loading before its first sample is added to its history."""
    if not np.isfinite(time).all() or (np.diff(time) <= 0.0).any():
        odd = int(rows[np.argmax(~np.isfinite(time) | np.concatenate([[False], np.diff(time) <= 0.0]))])
        raise InputError(
            f"{table.file}, line {table.lines[odd]}: the time does not increase; one test a file, or give ids"
        )
    rate = float(settings.get("loading_rate") or settings.get("rate") or LOADING_RATE)
    first = float(coupon.stretch[0])
    is_held = np.ptp(coupon.stretch) < HELD * first
    start_time = float(time[0])
    if is_held:
        start_time = _start_of_hold(table, time, settings, notes)
        if not settings.get("loading_rate"):
            notes.append(f"its loading is not recorded: taken as {rate:g} 1/s (loading_rate in tests.toml)")
    lead = abs(first - 1.0) / rate
    ramp = [(0.0, 1.0), (lead, first)] if lead > 0.0 else [(0.0, 1.0)]
    elapsed = time - start_time + lead
    inside = elapsed > lead if is_held else np.arange(elapsed.size) >= (1 if lead > 0.0 or first == 1.0 else 0)
    times = np.concatenate([[t for t, _ in ramp], elapsed[inside]])
    path = np.concatenate([[s for _, s in ramp], coupon.stretch[inside]])
    kind = "creep" if settings.get("kind") == "creep" else "relaxation" if is_held else _moving(coupon.stretch)
    return dataclasses.replace(coupon, kind=kind, time=np.maximum(elapsed, 0.0), history=(times, path))


def _start_of_hold(table: Table, time: Array, settings: Mapping[str, Any], notes: list[str]) -> float:
    """The time of the file at which a hold begins."""
    if settings.get("hold_from") is not None:
        start = float(settings["hold_from"])
        if start > time[0]:
            raise InputError(
                f"{table.file}: hold_from = {start:g} s: is after the first sample, at {time[0]:g} s; lower it"
            )
        return start
    steps = np.diff(time)
    if time[0] > 0.0 and steps.size and np.ptp(steps) < 1e-3 * steps[0] and abs(time[0] - steps[0]) < 1e-3 * steps[0]:
        notes.append(
            f"its clock starts at {time[0]:g} s, one step: the hold is taken to begin with the first sample (hold_from "
            "in tests.toml)"
        )
        return float(time[0])
    return min(0.0, float(time[0]))


def _oddities(coupon: Coupon) -> Iterator[str]:
    """Notes about odd first and last samples of a test."""
    first, last = float(coupon.stretch[0]), float(coupon.stretch[-1])
    if first < 1.0 - 1e-6:
        yield f"starts at stretch {first:.4g}, below 1: taken as it is"
    if coupon.stress[0] < 0.0:
        yield f"starts with a stress of {format_si(float(coupon.stress[0]), 'Pa', 3)}, below 0: taken as it is"
    most = float(np.max(coupon.stress))
    if coupon.voltage > 0.0 and abs(coupon.stress[0]) < 1e-3 * most:
        yield "has no stress at its first stretch under voltage: a slack film, of which no compression is predicted"
    if coupon.kind == "cyclic" and last > 1.0 + NEAR_ONE and coupon.stress[-1] < 0.15 * most:
        yield f"its unloading is cut at stretch {last:.4g}, where the stress has come to 0"


def _without_repeats(tests: list[Coupon]) -> list[Coupon]:
    """The tests; one that repeats the first rows of another is marked to be left out."""
    marked_tests: list[Coupon] = []
    for test in tests:
        longer = next((other for other in tests if other is not test and _repeats(test, other)), None)
        if longer is not None and (len(longer.stress) > len(test.stress) or longer in marked_tests):
            why = f"repeats the first {len(test.stress)} rows of {longer.name}: left out"
            test = test.with_use("leave out", why)
        marked_tests.append(test)
    return marked_tests


def _repeats(test: Coupon, other: Coupon) -> bool:
    n = len(test.stress)
    same = (test.mode, test.kind, test.voltage) == (other.mode, other.kind, other.voltage)
    return (
        same
        and n <= len(other.stress)
        and np.array_equal(test.stretch, other.stretch[:n])
        and np.array_equal(test.stress, other.stress[:n])
    )


def same_temperature(tests: Sequence[Coupon]) -> tuple[float, list[Coupon]]:
    """The temperature near which most tests to be fitted were measured, NaN if none is known; and the tests, those at
    other temperatures marked to be left out."""
    fit_tests = [test for test in tests if test.use == "fit" and np.isfinite(test.temperature)]
    if not fit_tests:
        return np.nan, list(tests)
    near = {
        test.temperature: sum(abs(other.temperature - test.temperature) <= SAME_TEMPERATURE for other in fit_tests)
        for test in fit_tests
    }
    chosen = max(near, key=lambda t: (near[t], -abs(t - 293.15)))
    marked_tests = []
    for test in tests:
        if test.use == "fit" and abs(test.temperature - chosen) > SAME_TEMPERATURE:
            why = f"at {test.temperature - 273.15:.3g} degC, not at {chosen - 273.15:.3g} degC as most: left out"
            test = test.with_use("leave out", why)
        marked_tests.append(test)
    return chosen, marked_tests
