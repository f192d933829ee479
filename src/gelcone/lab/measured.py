"""The list of measured files, tests.toml: the tests in each file, and settings that its columns do not state."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from gelcone.devices.reading import read_table
from gelcone.devices.units import FieldError, parse
from gelcone.errors import InputError, check_name, check_names
from gelcone.files import read_text, read_toml
from gelcone.lab.coupons import KINDS, MODES, ROLES, USES, WIDTHS, Coupon, Spectrum, coupons_of, spectra_of

MOST_FILES = 200
REMEDY = 'give a list of tests: a table [[test]] for each file, with file = "tension.csv"'
_CHOICES = {"mode": MODES, "kind": KINDS, "width": WIDTHS, "use": USES}
_NUMBERS = {
    "thickness": "m",
    "gauge_length": "m",
    "specimen_width": "m",
    "voltage": "V",
    "hold_from": "s",
}
_RATES = ("rate", "loading_rate")
KEYS = ("file", "only", "temperature", *_CHOICES, *_NUMBERS, *_RATES, *ROLES)
"""Keys of a table [[test]]; a role (`gelcone.lab.coupons.ROLES`) names its column: ``stress = "F/A, kPa"``."""


@dataclass(frozen=True)
class Measured:
    """Measured tests on coupons, the result of `gelcone.read_tests`.

    Parameters
    ----------
    coupons : the mechanical tests.
    spectra : measured permittivities over frequency.
    files : the names of their files.

    Examples
    --------
    >>> import gelcone, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp(), "tension.csv")
    >>> _ = path.write_text("stretch,stress (kPa)\\n1,0\\n1.1,5\\n1.2,9\\n1.3,12\\n")
    >>> tests = gelcone.read_tests(path)
    >>> len(tests.coupons), len(tests.spectra), [pathlib.Path(file).name for file in tests.files]
    (1, 0, ['tension.csv'])
    """

    coupons: tuple[Coupon, ...]
    spectra: tuple[Spectrum, ...]
    files: tuple[str, ...]


def read_tests(*paths: str | Path) -> Measured:
    """Read measured tests on coupons.

    Parameters
    ----------
    paths : lists of tests (tests.toml), or measured tables (CSV) whose headers say enough. A list has a table
        ``[[test]]`` for each file; ``file`` lies in the folder of the list.

    Returns
    -------
    `Measured`: every test with notes about interpreted data.

    Raises
    ------
    InputError : for data that cannot be read with certainty, in one line that names file, line and remedy.

    Examples
    --------
    >>> import gelcone, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp(), "tension.csv")
    >>> _ = path.write_text("stretch,stress (kPa)\\n1,0\\n1.1,5\\n1.2,9\\n1.3,12\\n")
    >>> tests = gelcone.read_tests(path)
    >>> f"{len(tests.coupons)} test, largest stress {tests.coupons[0].stress.max():.0f} Pa"
    '1 test, largest stress 12000 Pa'
    """
    coupons: list[Coupon] = []
    spectra: list[Spectrum] = []
    files: list[str] = []
    for path in map(Path, paths):
        for table_path, settings in _listed(path):
            table = read_table(table_path)
            file_spectra = spectra_of(table, settings["columns"])
            file_coupons = [] if file_spectra else coupons_of(table, settings)
            coupons += _only(table.file, file_coupons, settings.get("only"))
            spectra += file_spectra
            files.append(table.file)
    if len(set(files)) < len(files):
        twice = next(name for k, name in enumerate(files) if name in files[:k])
        raise InputError(f"{twice}: is listed twice; list it once, with only = [...] for some of its tests")
    if not files:
        raise InputError(f"no measured file is given; {REMEDY}")
    return Measured(tuple(coupons), tuple(spectra), tuple(files))


def _listed(path: Path) -> Iterable[tuple[Path, dict[str, Any]]]:
    """The files of a list and their settings; a measured table is a list of one file without settings."""
    if path.suffix.lower() != ".toml":
        return [(path, {"columns": {}})]
    entries, _ = listed_tables(path)
    return [_read_entry(path, k, entry) for k, entry in enumerate(entries, start=1)]


def listed_tables(path: Path, others: Sequence[str] = ()) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Read the tables ``[[test]]`` of a list, and the tables named ``others`` if it has them; `InputError` for any
    other file."""
    content = read_toml(path, read_text(path, REMEDY))
    listed = content.pop("test", None)
    known = {name: content.pop(name) for name in others if isinstance(content.get(name), dict)}
    if content or not isinstance(listed, list) or not listed or not all(isinstance(one, dict) for one in listed):
        raise InputError(f"{path}: {f'{next(iter(content))!r} is not known; ' if content else ''}{REMEDY}")
    if len(listed) > MOST_FILES:
        raise InputError(f"{path}: lists {len(listed)} files; give at most {MOST_FILES}")
    return listed, known


def place_of(path: Path, where: str, name: Any) -> Path:
    """The path of a file that a list names, in the folder of the list; `InputError` for another folder."""
    if not isinstance(name, str) or not name.strip() or "\x00" in name:
        raise InputError(f"{where}: file is missing; {REMEDY}")
    if PurePosixPath(name).is_absolute() or ".." in PurePosixPath(name).parts or "\\" in name or ":" in name:
        raise InputError(f"{where}: file = {name!r}: must lie in the folder of the list; put it there")
    return path.parent / name


def _read_entry(path: Path, number: int, entry: Mapping[str, Any]) -> tuple[Path, dict[str, Any]]:
    """Read a table [[test]]: its file, and its settings in SI."""
    where = f"{path}, test {number}"
    check_names("setting of a test", entry, KEYS, where=f"{where}: ")
    place = place_of(path, where, entry.get("file"))
    columns = {key: value for key, value in entry.items() if key in ROLES and not _begins_a_number(value)}
    for key, value in columns.items():
        if not isinstance(value, str) or not value.strip():
            raise InputError(f'{where}: {key} = {value!r}: must name a column, {key} = "COLUMN, UNIT"')
    others = {key: value for key, value in entry.items() if key != "file" and key not in columns}
    return place, {key: _setting(where, key, value) for key, value in others.items()} | {"columns": columns}


def _begins_a_number(value: Any) -> bool:
    return value[:1] in "+-.0123456789" if isinstance(value, str) and value else isinstance(value, int | float)


def _setting(where: str, key: str, value: Any) -> Any:
    """Read a setting; numbers are in SI."""
    try:
        if key in _CHOICES:
            check_name(key, value, _CHOICES[key])
            return value
        if key in _NUMBERS:
            bounds: dict[str, Any] = {"least": 0.0} if key in ("voltage", "hold_from") else {"above": 0.0}
            return parse(key, value, _NUMBERS[key], **bounds)
        if key in _RATES:
            text = value.removesuffix("1/s").removesuffix("/s").strip() if isinstance(value, str) else value
            return parse(key, text, "1", above=0.0)
        if key == "temperature" and (text := str(value).strip()).endswith(("degC", "K")):
            number = parse(key, text.removesuffix("degC").removesuffix("K").strip(), "1")
            return number + (273.15 if text.endswith("degC") else 0.0)
    except (FieldError, InputError) as error:
        raise InputError(f"{where}: {error}") from None
    if key == "only":
        if isinstance(value, list) and value and all(isinstance(one, int | str) for one in value):
            return [str(one) for one in value]
        raise InputError(f"{where}: only = {value!r}: must be a list of ids, such as [101, 102]")
    if key == "temperature":
        raise InputError(f"{where}: temperature = {value!r}: has no unit; write '20 degC' or '293 K'")
    raise InputError(f'{where}: {key} = {value!r}: must name a column, {key} = "COLUMN, UNIT"')


def _only(file: str, tests: list[Coupon], ids: list[str] | None) -> list[Coupon]:
    """The tests with some ids; all if ``ids`` is None."""
    if ids is None:
        return tests
    by_id = {test.name.removeprefix(f"{file.rsplit('.', 1)[0]} "): test for test in tests}
    check_names("test of the file", ids, by_id, where=f"{file}: ")
    return [by_id[test_id] for test_id in ids]


def notes_of(read: Iterable[tuple[str, str, Sequence[str]]]) -> list[tuple[str, list[str]]]:
    """Each note once, with the files that it applies to, or the tests if it does not apply to all of a file.

    ``read`` holds the file, the name and the notes of each test.
    """
    files: dict[str, list[str]] = {}
    about: dict[str, dict[str, list[str]]] = {}
    for file, name, notes in read:
        files.setdefault(file, []).append(name)
        for note in notes:
            about.setdefault(note, {}).setdefault(file, []).append(name)
    return [
        (note, [name for file, tests in where.items() for name in ([file] if tests == files[file] else tests)])
        for note, where in about.items()
    ]
