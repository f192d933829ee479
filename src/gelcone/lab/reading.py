"""Measured tables as laboratories export them: texts with several separators, decimal marks, encodings and headings.

Interpretations are named in the notes of the table. Data that cannot be interpreted with certainty are refused in one
line that names the file, the line and the remedy.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path

import numpy as np

from gelcone.errors import InputError, check_name
from gelcone.files import read_data
from gelcone.lab.binary import read_vectors
from gelcone.quantity import Array

MOST_COLUMNS = 64
MOST_ROWS = 200_000
LONGEST_WORD = 60
"""Most letters of a foreign text in a message."""
REMEDY = "give a CSV file with a header such as stretch,stress (kPa)"
NOT_READ = {
    ".tdms": "TDMS is not read; export CSV (TDMS has a viewer that does) with units in the header",
    **dict.fromkeys((".uff", ".unv"), "UFF is not read; export CSV with units in the header"),
    ".xls": "Excel files are not read; save the sheet as CSV (UTF-8) with units in the header",
    ".xlsx": "Excel files are not read; save the sheet as CSV (UTF-8) with units in the header",
    ".nc": "netCDF is not read here; export CSV with units in the header",
    ".ods": "spreadsheets are not read; save the sheet as CSV (UTF-8) with units in the header",
}
"""Suffixes of files that are not read -> message with the remedy."""
BINARY = {".mat": "MATLAB", ".h5": "HDF5", ".hdf5": "HDF5"}
"""Suffixes of files whose vectors are columns -> name of the format."""
_PLAIN = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)
_COMMA = re.compile(r"[+-]?(\d+,\d*|,\d+)([eE][+-]?\d{1,3})?", re.ASCII)
_MISSING = ("", "nan", "na", "n/a", "-", "--", "null", "none")


@dataclass(frozen=True)
class Column:
    """A column: its ``name`` and ``unit`` in the header (None if not stated), its ``values`` (NaN for an empty cell,
    None for a column of words), and its ``words``."""

    name: str
    unit: str | None
    values: Array | None
    words: tuple[str, ...]


@dataclass(frozen=True)
class Table:
    """A measured table: its file, its ``columns`` by name, the ``lines`` of the file for its rows, and ``notes`` about
    interpretations."""

    file: str
    columns: Mapping[str, Column]
    lines: Sequence[int]
    notes: tuple[str, ...] = field(default=())

    def unit_of(self, name: str, stated: str | None) -> str | None:
        """The unit of a column, of its heading or ``stated`` in a list; `InputError` where these are two."""
        own = self.columns[name].unit
        if stated and own and _ascii(stated) != _ascii(own):
            raise InputError(
                f"{self.file}: column {name!r} is in {own} by its heading and in {stated} by the list; leave the unit "
                "out of the list, or correct the heading"
            )
        return stated or own

    def named(self, text: str, where: str) -> tuple[str, str | None]:
        """The column that a list names, as in ``"F, mN"``, and the unit stated there, None for none; `InputError`,
        which begins with ``where``, unless there is such a column."""
        before, comma, after = text.rpartition(",")
        own, stated = (before.strip(), after.strip()) if comma else (text.strip(), None)
        check_name("column", own, self.columns, where=where)
        return own, stated


def spelt_plainly(name: str) -> str:
    """The name of a column in small letters, with single spaces between its words."""
    return re.sub(r"[\s_\-]+", " ", name.strip().lower())


def _ascii(unit: str) -> str:
    """A unit with u for both letters that look like mu."""
    return unit.replace("\N{MICRO SIGN}", "u").replace("\N{GREEK SMALL LETTER MU}", "u")


def read_table(path: Path) -> Table:
    """Read a measured table from a text file, or the vectors of a MATLAB or HDF5 file.

    Semicolons, tabs, commas and spaces separate; decimals have points or commas; a unit stands in the heading, as in
    ``stress (kPa)``, ``stress [kPa]`` or ``stress / kPa``, or in a second row; lines that begin with # or % are left
    out. UTF-8, UTF-16 and Latin-1 are read.

    Raises
    ------
    InputError : for a file that cannot be read or whose numbers are not certain, in one line with the remedy.
    """
    if reason := NOT_READ.get(path.suffix.lower()):
        raise InputError(f"{path.name}: {reason}")
    if path.suffix.lower() in BINARY:
        return _table_of(path)
    text, notes = _decoded(path)
    rows, lines = _rows(path.name, text, notes)
    heading, *body = rows
    names, units = _heading(path.name, lines[0], heading)
    if body and any(body[0]) and not any(map(_number_like, body[0])) and len(body) > 1:
        units = _second_row(body[0], units)
        notes.append("units stand in the second row")
        body, lines = body[1:], [lines[0], *lines[2:]]
    if not body:
        raise InputError(f"{path.name}: has a header and no numbers; {REMEDY}")
    body = _even(path.name, lines[1:], body, len(names), notes)
    lines = lines[1 : 1 + len(body)]
    columns = {
        name: _column(path.name, name, unit, [row[k] for row in body], lines, notes)
        for k, (name, unit) in enumerate(zip(names, units, strict=True))
    }
    return Table(path.name, columns, lines, tuple(dict.fromkeys(notes)))


def _table_of(path: Path) -> Table:
    """The table of the vectors of a MATLAB or HDF5 file."""
    vectors = read_vectors(path, REMEDY)
    columns = {name: Column(name, unit, values, ()) for name, (values, unit) in vectors.items()}
    rows = len(next(iter(columns.values())).values)  # type: ignore[arg-type]
    if rows > MOST_ROWS:
        raise InputError(f"{path.name}: has {rows} rows; give at most {MOST_ROWS}")
    return Table(path.name, columns, range(1, rows + 1), (f"read as {BINARY[path.suffix.lower()]}",))


def _decoded(path: Path) -> tuple[str, list[str]]:
    """The text of a file, and notes about its encoding."""
    data, notes = read_data(path, REMEDY), []
    encoding = "utf-16" if data.startswith((b"\xff\xfe", b"\xfe\xff")) else "utf-8-sig"
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError as error:
        if encoding == "utf-16":
            raise InputError(f"{path.name}: is not UTF-16 text (byte {error.start}); save it as UTF-8") from None
        text = data.decode("latin-1")
        notes.append("is not UTF-8: read as Latin-1")
    if "\x00" in text or sum(not (c.isprintable() or c.isspace()) for c in text[:4096]) > 8:
        raise InputError(f"{path.name}: is not text; {REMEDY}")
    if "\N{REPLACEMENT CHARACTER}" in text:
        notes.append("letters were lost when it was exported (they read \N{REPLACEMENT CHARACTER}), numbers were not")
    return text, notes


def _rows(file: str, text: str, notes: list[str]) -> tuple[list[list[str]], list[int]]:
    """The cells of all lines that are neither empty nor comments, the header first, and the numbers of the lines."""
    lines = [(k, line) for k, line in enumerate(text.splitlines(), start=1) if line.strip(" \t;,")]
    comments = [k for k, line in lines if line.lstrip().startswith(("#", "%"))]
    if comments:
        notes.append(f"{len(comments)} comment lines left out")
        lines = [(k, line) for k, line in lines if k not in set(comments)]
    if not lines:
        raise InputError(f"{file}: is empty; {REMEDY}")
    if len(lines) > MOST_ROWS:
        raise InputError(f"{file}: has {len(lines)} lines; give at most {MOST_ROWS}, thinned out")
    separator = _separator(lines[0][1])
    if separator == " ":
        cells = [line.split() for _, line in lines]
    else:
        try:
            cells = list(csv.reader(StringIO("\n".join(line for _, line in lines)), delimiter=separator, strict=True))
        except csv.Error as error:
            raise InputError(f"{file}: {error}; close every quote, one row a line") from None
        if len(cells) != len(lines):
            raise InputError(f"{file}: a quote runs over several lines; close it on its line")
    if separator != ",":
        known = {";": "semicolons", "\t": "tabs", " ": "spaces"}[separator]
        notes.append(f"cells are separated by {known}")
    return [[cell.strip() for cell in row] for row in cells], [k for k, _ in lines]


def _separator(header: str) -> str:
    """The separator of a header line: a semicolon or a tab where there is one, else a comma, else spaces."""
    return next((mark for mark in ";\t," if mark in header), " ")


def _heading(file: str, line: int, cells: list[str]) -> tuple[list[str], list[str | None]]:
    """Names and units of the columns; `InputError` for a header that cannot be used."""
    while cells and not cells[-1]:
        cells = cells[:-1]
    if all(map(_number_like, cells)):
        raise InputError(f"{file}, line {line}: is a row of numbers, not a header; {REMEDY}")
    if len(cells) > MOST_COLUMNS:
        raise InputError(f"{file}, line {line}: has {len(cells)} columns; give at most {MOST_COLUMNS}")
    named = [_name_and_unit(cell) for cell in cells]
    names = [name for name, _ in named]
    if "" in names:
        raise InputError(f"{file}, line {line}: column {names.index('') + 1} has no name; {REMEDY}")
    odd = next((k for k, cell in enumerate(cells) if len(cell) > LONGEST_WORD or not cell.isprintable()), None)
    if odd is not None:
        raise InputError(
            f"{file}, line {line}: column {odd + 1} is named {_short(cells[odd])!r}; give it at most "
            f"{LONGEST_WORD} letters"
        )
    twice = next((name for k, name in enumerate(names) if name in names[:k]), None)
    if twice is not None:
        raise InputError(f"{file}, line {line}: has two columns {_short(twice)!r}; leave one out or rename it")
    return names, [unit for _, unit in named]


def _name_and_unit(cell: str) -> tuple[str, str | None]:
    """Split ``stress (kPa)``, ``stress [kPa]`` or ``stress / kPa`` into name and unit."""
    found = re.fullmatch(r"(.*?)\s*[\(\[]([^\(\)\[\]]*)[\)\]]", cell) or re.fullmatch(r"(.+?)\s+/\s*(\S+)", cell)
    return (found[1].strip(), found[2].strip()) if found else (cell, None)


def _second_row(row: list[str], units: list[str | None]) -> list[str | None]:
    """The units of the header, completed by a row below it."""
    padded = [*row, *[""] * len(units)]
    own = [cell.strip("()[] ") for cell in padded]
    return [unit if unit is not None or not cell else cell for unit, cell in zip(units, own, strict=False)]


def _number_like(cell: str) -> bool:
    return bool(_PLAIN.fullmatch(cell) or _COMMA.fullmatch(cell))


def _even(file: str, lines: list[int], rows: list[list[str]], count: int, notes: list[str]) -> list[list[str]]:
    """Check that rows have ``count`` cells each; `InputError` for one with more or fewer."""
    found = []
    for line, row in zip(lines, rows, strict=True):
        while len(row) > count and not row[-1]:
            row = row[:-1]
        if len(row) == 2 * count and all(re.fullmatch(r"[+-]?\d+([eE][+-]?\d+)?", cell) for cell in row):
            raise InputError(
                f"{file}: decimal comma and comma separator cannot be distinguished in line {line}; export with "
                "semicolons"
            )
        if len(row) > count:
            raise InputError(
                f"{file}, line {line}: has {len(row)} cells for {count} columns; decimal commas need semicolons "
                "between cells, and words that hold a separator need quotes"
            )
        if len(row) < count:
            if line != lines[-1]:
                raise InputError(f"{file}, line {line}: has {len(row)} cells for {count} columns; complete it")
            notes.append(f"line {line}, the last, is cut off ({len(row)} cells of {count}) and left out")
            continue
        found.append(row)
    if not found:
        raise InputError(f"{file}: has no whole row; {REMEDY}")
    return found


def _column(file: str, name: str, unit: str | None, cells: list[str], lines: Sequence[int], notes: list[str]) -> Column:
    """Read a column of numbers or of words; `InputError` for a number that is not certain."""
    filled = [cell for cell in cells if cell.lower() not in _MISSING]
    numeric = sum(map(_number_like, filled))
    if numeric * 2 < len(filled) or not filled:
        return Column(name, unit, None, tuple(cells))
    commas = any(_COMMA.fullmatch(cell) for cell in filled)
    points = next((cell for cell in filled if "." in cell), None)
    if commas and points is not None:
        line = lines[cells.index(points)]
        raise InputError(
            f"{file}, line {line}: column {_short(name)!r} has decimal points and decimal commas ({_short(points)}); "
            "export it with one of them and no marks between thousands"
        )
    if commas:
        notes.append("decimals are written with commas")
    values = np.array([_number(file, name, cell, line) for cell, line in zip(cells, lines, strict=True)])
    if gaps := int(np.isnan(values).sum()):
        notes.append(f"column {_short(name)!r} has {gaps} empty cells")
    return Column(name, unit, values, tuple(cells))


def _number(file: str, name: str, cell: str, line: int) -> float:
    if cell.lower() in _MISSING:
        return np.nan
    if not _number_like(cell):
        raise InputError(
            f"{file}, line {line}: column {_short(name)!r} holds {_short(cell)!r}; give one number a cell, without "
            "unit and without marks between thousands"
        )
    value = float(cell.replace(",", "."))
    if not np.isfinite(value):
        raise InputError(f"{file}, line {line}: column {_short(name)!r} holds {_short(cell)!r}; give a finite number")
    return value


def _short(text: str) -> str:
    """A foreign text for a message: printable, and not longer than `LONGEST_WORD`."""
    clean = "".join(c if c.isprintable() else "?" for c in text)
    return clean if len(clean) <= LONGEST_WORD else f"{clean[: LONGEST_WORD - 3]}..."
