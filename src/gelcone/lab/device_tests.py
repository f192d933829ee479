"""Tests on a device from a list, tests.toml: rows of measured files, or numbers in the list itself."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from gelcone.devices.reading import TIME, VOLTAGE, Table, read_table
from gelcone.devices.units import FieldError, parse, parse_share
from gelcone.errors import InputError, check_name, check_names, check_path
from gelcone.lab.bench import INSTRUMENTS, KINDS, DeviceTest, rows_read
from gelcone.lab.coupons import SHORT, refuse_kilovolts, without_unit
from gelcone.lab.measured import listed_tables, place_of
from gelcone.physics.waveforms import MOST_PIECES
from gelcone.quantity import Array

GAINS: Mapping[str, float] = dict.fromkeys(INSTRUMENTS, 0.01) | {"load cell": 0.02}
"""Default standard deviation of the gain of each instrument."""
_NEAR = {
    "height": ("height", "h", "position", "z"),
    "voltage": VOLTAGE,
    "force": ("force", "f", "load"),
    "stroke": ("stroke", "displacement", "d"),
    "load": ("load", "weight", "force"),
    "capacitance": ("capacitance", "c"),
    "frequency": ("frequency", "freq", "f"),
    "in_phase": ("in phase", "real", "x"),
    "quadrature": ("quadrature", "imaginary", "y"),
    "amplitude": ("amplitude", "amp", "magnitude"),
    "phase": ("phase",),
    "decay": ("decay",),
    "time": TIME,
    "current": ("current", "i"),
    "voltage_offset": ("offset", "voltage offset"),
    "voltage_amplitude": ("voltage amplitude",),
}
"""Number that is set or read -> names by which its column is recognised."""
_NUMBER = re.compile(r"\s*[+-]?\.?\d")
"""Beginning of a number; any other text names a column, after a minus with the opposite sign."""
_EXAMPLES = {"m": "10 mm", "V": "1 kV", "N": "20 mN", "Hz": "10 Hz", "s": "1 s"}
"""Unit -> example of a value that is set."""
_OWN_UNITS = ("1/s", "deg")
"""Units that fields of a device do not have."""
_PARTS = ("in_phase", "quadrature")
_EXTRA = {"amplitude": "m", "phase": "deg"}
"""Readings that replace in_phase and quadrature."""


class DeviceTests(NamedTuple):
    """Tests on a device, and the standard deviations of the gains of instruments."""

    tests: tuple[DeviceTest, ...]
    gains: Mapping[str, float]

    @property
    def measured(self) -> bool:
        """Whether all tests have readings, as a fit needs."""
        return all(np.isfinite(test.values).all() for test in self.tests)


def read_device_tests(path: str | Path) -> DeviceTests:
    """Read tests on a device from a list.

    Parameters
    ----------
    path : a TOML file with a table ``[[test]]`` for each test: its ``kind``, a key of `gelcone.lab.bench.KINDS`; its
        ``noise``, one text such as ``"1 mN"`` or a table by reading; and for what is set and read a column of its
        ``file``, ``"F, mN"``, or the number itself, or a list of numbers. Readings that are left out are planned. A
        table ``[instruments]`` states the standard deviation of the gain of ``load_cell``, ``laser``,
        ``capacitance_meter``, ``ammeter`` and ``amplifier``.

    Returns
    -------
    The tests with what is set, what is read and its noise, in SI, and the gains of the instruments.

    Raises
    ------
    InputError : for data that cannot be read with certainty, in one line that names test and remedy.

    Examples
    --------
    >>> import gelcone, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp(), "tests.toml")
    >>> _ = path.write_text('[[test]]\\nkind = "stroke over voltage"\\nvoltage = ["1 kV"]\\nnoise = "10 um"\\n')
    >>> planned = gelcone.read_device_tests(path).tests[0]
    >>> planned.kind, planned.set["voltage"].tolist()
    ('stroke over voltage', [1000.0])
    """
    check_path("read_device_tests", path)
    path = Path(path)
    if path.suffix.lower() != ".toml":
        raise InputError(f'{path}: is not a list of tests on a device; give tests.toml, with kind = "blocked force"')
    entries, others = listed_tables(path, ("instruments",))
    gains = dict(GAINS)
    for name, value in others.get("instruments", {}).items():
        instrument = name.replace("_", " ")
        check_name("instrument", instrument, INSTRUMENTS, where=f"{path}: ")
        gains[instrument] = parse_share(f"{path}: instruments.{name}", value)
    return DeviceTests(tuple(_test(path, k, entry) for k, entry in enumerate(entries, start=1)), gains)


def _test(path: Path, number: int, entry: Mapping[str, Any]) -> DeviceTest:
    """Read a test of the list."""
    where = f"{path}, test {number}"
    kind = str(entry.get("kind"))
    check_name("kind of test on a device", kind, KINDS, where=f"{where}: ")
    units = _units(kind)
    settings = ("file", "kind", "noise", *units)
    check_names(f"setting of a {kind} test", entry, settings, where=f"{where}: ")
    table = read_table(place_of(path, where, entry["file"])) if "file" in entry else None
    numbers = {}
    for name, unit in units.items():
        values = _numbers(where, name, unit, entry.get(name), table)
        if values is not None:
            numbers[name] = values
    if table is not None:
        _check_columns(where, kind, entry, numbers, table)
    return _assembled(where, kind, numbers, entry.get("noise"), table)


def _check_columns(where: str, kind: str, entry: Mapping[str, Any], numbers: Mapping[str, Array], table: Table) -> None:
    """Raise `InputError` for a file with unused columns of numbers if a number that is set, all readings, or one of
    amplitude and phase are missing."""
    used = {column_name for name in _units(kind) if (column_name := _named(where, name, entry.get(name), table)[0])}
    unused = [name for name, column in table.columns.items() if name not in used and column.values is not None]
    halves = ("amplitude", "phase")
    readings = halves if any(name in numbers for name in halves) else tuple(KINDS[kind].read)
    readings = () if set(readings) == set(KINDS[kind].read) and any(name in numbers for name in readings) else readings
    lacking = [name for name in (*KINDS[kind].set, *readings) if name not in numbers]
    if unused and lacking:
        unit = _units(kind)[lacking[0]]
        raise InputError(
            f"{where}: which column of {table.file} is {lacking[0]}? not used yet: {', '.join(unused)[:80]}; "
            f'name it, {lacking[0]} = "{unused[0][:40]}, {SHORT.get(unit, unit)}"'
        )


def _units(kind: str) -> dict[str, str]:
    """The numbers that a kind of test may state, name -> SI unit."""
    units = dict(KINDS[kind].set) | {name: reading.unit for name, reading in KINDS[kind].read.items()}
    return units | (_EXTRA if kind == "frequency response" else {})


def _assembled(where: str, kind: str, numbers: dict[str, Array], noise: Any, table: Table | None) -> DeviceTest:
    """Make a test of its numbers, with all columns of one length."""
    if "amplitude" in numbers and "phase" in numbers:
        size, angle = numbers.pop("amplitude"), np.radians(numbers.pop("phase"))
        numbers |= dict(zip(_PARTS, (size * np.cos(angle), size * np.sin(angle)), strict=True))
    test_kind = KINDS[kind]
    rows = max((len(values) for values in numbers.values()), default=1)
    for name, unit in test_kind.set.items():
        if name not in numbers:
            raise InputError(
                f'{where}: a {kind} test needs {name}; name a column, or give {name} = "{_EXAMPLES[unit]}"'
            )
    for name, values in numbers.items():
        if len(values) not in (1, rows):
            raise InputError(f"{where}: {name} has {len(values)} values and others {rows}; give one for each row")
        numbers[name] = np.broadcast_to(values, rows)
    missing, read_names = np.full(rows, np.nan), list(test_kind.read)
    name = where.rpartition(", ")[2] if table is None else table.file
    if kind == "series":
        _check_times(where, numbers["time"])
        read_names = [quantity for quantity in read_names if quantity in numbers] or read_names[:1]
        kept = rows_read(rows)
        numbers |= {quantity: numbers.get(quantity, missing)[kept] for quantity in read_names}
        missing = missing[kept]
        name += f", {missing.size} of {rows} rows" * (missing.size < rows)
    read = {quantity: numbers.get(quantity, missing) for quantity in read_names}
    deviation = {
        quantity: np.full(missing.size, _noise(where, quantity, test_kind.read[quantity].unit, noise))
        for quantity in read_names
    }
    notes = table.notes if table else ()
    return DeviceTest(
        f"{kind}, {name}", kind, {quantity: numbers[quantity] for quantity in test_kind.set}, read, deviation, notes
    )


def _check_times(where: str, times: Array) -> None:
    """Raise `InputError` for times that do not rise, and for more than a run may have."""
    if not 2 <= times.size <= MOST_PIECES:
        raise InputError(f"{where}: has {times.size} times; a series takes 2 to {MOST_PIECES}")
    if (wrong := np.flatnonzero(np.diff(times) <= 0.0)).size:
        before, after = times[wrong[0] : wrong[0] + 2]
        raise InputError(f"{where}: the time {after:g} s follows {before:g} s; times must rise")


def _noise(where: str, name: str, unit: str, given: Any) -> float:
    """The standard deviation of a reading."""
    value = given.get(name) if isinstance(given, Mapping) else given
    if value is None and name in _PARTS:
        raise InputError(
            f'{where}: the noise is missing; give that of the displacement at the frequency of the drive, noise = "10 '
            'um": it counts for in_phase and quadrature alike, into which amplitude and phase are turned'
        )
    example = {"N": "1 mN", "m": "10 um", "Hz": "0.02 Hz", "1/s": "0.05 1/s", "F": "1 pF", "A": "1 uA"}[unit]
    if value is None:
        raise InputError(f'{where}: the noise of {name} is missing; give noise = "{example}", or a table by reading')
    return _parsed(where, f"noise of {name}", value, unit, above=0.0)


def _parsed(where: str, name: str, value: Any, unit: str, **bounds: Any) -> float:
    """Read a number with its unit; `InputError` with the test otherwise."""
    text = str(value).strip()
    try:
        if unit in _OWN_UNITS:
            return parse(name, text.removesuffix(unit).strip(), "1", **bounds)
        return parse(name, value, unit, **bounds)
    except FieldError as error:
        raise InputError(f"{where}: {error}") from None


def _numbers(where: str, name: str, unit: str, given: Any, table: Table | None) -> Array | None:
    """Read a number that is set or read, from the list or from a column; None if it is missing."""
    if isinstance(given, list):
        return np.array([_parsed(where, f"{name}[{k}]", one, unit) for k, one in enumerate(given)])
    if isinstance(given, int | float) or (isinstance(given, str) and _NUMBER.match(given)):
        return np.array([_parsed(where, name, given, unit)])
    if given is not None and (not isinstance(given, str) or not given.strip()):
        raise InputError(f'{where}: {name} = {given!r}: must be a number with its unit, or a column, "COLUMN, {unit}"')
    if table is None:
        if given is not None:
            raise InputError(f"{where}: {name} = {given!r}: names a column, but no file is given")
        return None
    return _column(where, name, unit, given, table)


def _column(where: str, name: str, unit: str, given: str | None, table: Table) -> Array | None:
    """Read a column in SI; `InputError` for one without a unit, with a unit of another quantity, or with another in the
    list than in the file."""
    column, stated = _named(where, name, given, table)
    if column is None:
        return None
    values = table.numbers(column, name, whole=True)
    written = table.unit_of(column, stated)
    if written is None:
        if unit == "V":
            refuse_kilovolts(table, values)
        raise without_unit(table, name, column, unit)
    if unit in _OWN_UNITS and written != unit:
        raise InputError(f"{table.header}: column {column!r}: {written!r} is not a unit of {name}; write it in {unit}")
    size = 1.0 if unit in _OWN_UNITS else table.size_of(column, written, unit)
    sign = -1.0 if given is not None and given.startswith("-") else 1.0
    return np.asarray(sign * values * size)


def _named(where: str, name: str, given: Any, table: Table) -> tuple[str | None, str | None]:
    """The name of a column, and the unit that the list states; None if the list holds numbers, or no column is
    found."""
    if given is None:
        return table.find(_NEAR[name]), None
    if not isinstance(given, str) or _NUMBER.match(given):
        return None, None
    given = given.removeprefix("-")
    return table.named(given, f"{where}: {name} = {given!r}: ")


FIRST_TESTS = """\
# Tests on a device, a table for each. `gelcone fit DEVICE --data {file} --free FIELD~SD --plan` states what they
# determine, also before they are made; with the readings, `gelcone fit` fits the fields that are --free.
#
# What is set and read is a column of the test's file, found by its name or named here, voltage = "U, V" ("-F, mN": with
# the opposite sign); or a number for all rows, voltage = "1 kV"; or a list. A reading that is missing is planned. noise
# is the standard deviation of a reading. Heights, strokes and forces that hold the disc are positive upward, away from
# the plane of the rim; loads pull down. CSV, MATLAB and HDF5 files are read.

[instruments]                          # standard deviation of each gain; also capacitance_meter and ammeter
load_cell = "2 %"
laser = "1 %"
amplifier = "1 %"

[[test]]
kind = "blocked force"                 # height and voltage are set, the force that holds the disc is read
# file = "force.csv"                   # in place of the lists
# force = "F, mN"
height = ["10 mm", "12 mm", "14 mm", "10 mm", "12 mm", "14 mm"]
voltage = ["0 V", "0 V", "0 V", "1.4 kV", "1.4 kV", "1.4 kV"]
noise = "1 mN"

[[test]]
kind = "stroke over voltage"           # the stroke from where it rests without voltage
# file = "stroke.csv"
voltage = ["400 V", "800 V", "1.2 kV", "1.6 kV"]
noise = "10 um"

[[test]]
kind = "frequency response"            # in_phase and quadrature, or amplitude and phase, of the displacement
# file = "response.csv"
voltage_offset = "1 kV"
voltage_amplitude = "60 V"
frequency = ["6 Hz", "9 Hz", "10 Hz", "11 Hz", "12 Hz", "15 Hz"]
noise = "10 um"

[[test]]
kind = "ring-down"                     # without voltage
# frequency = "11.5 Hz"
# decay = "1.2 1/s"                    # of the amplitude, exp(-decay t)
noise = {{frequency = "0.02 Hz", decay = "0.05 1/s"}}

# [[test]]
# kind = "stroke over load"            # the stroke from where the load hangs without voltage
# load = ["0 mN", "20 mN", "40 mN"]
# voltage = "1.5 kV"
# noise = "10 um"

# [[test]]
# kind = "capacitance"
# height = ["10 mm", "14 mm"]
# voltage = "100 V"
# noise = "1 pF"

# [[test]]
# kind = "series"                      # time and voltage are set; stroke, current or both are read, from rest
# file = "step.csv"
# noise = {{stroke = "10 um", current = "10 nA"}}
"""
"""The text of a first list of tests, with the name of its ``file``."""
