"""Measured tables as laboratories export them: texts with several separators, decimal marks, encodings and headings.

Interpretations are named in the notes of the table. Data that cannot be interpreted with certainty are refused in one
line that names the file, the line and the remedy.
"""

from __future__ import annotations

import csv
import re
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path

import numpy as np

from gelcone.devices.binary import UNITS, read_vectors
from gelcone.devices.units import DIMENSIONS
from gelcone.errors import DoubtfulInput, InputError, check_name
from gelcone.files import read_data
from gelcone.quantity import Array

MOST_COLUMNS = 64
MOST_ROWS = 1_000_000
LONGEST_HEADER = 8000
"""Most letters of the line of headings."""
LARGEST = 1e20
"""Largest size of a number."""
SMALLER = f"give numbers of at most {LARGEST:g}"
LONGEST_WORD = 60
"""Most letters of a foreign text in a message."""
REMEDY = "give a CSV file with a header of names and units, such as time (s),force (mN)"
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
PAIRS = (("(", ")"), ("[", "]"))
"""Brackets around units."""
_DIGITS = frozenset("0123456789+-.,eE")
"""Letters of numbers."""
_MISSING = ("", "nan", "na", "n/a", "-", "--", "null", "none")
_SPELT = {"sec": "s", "mm/mm": "", "-": "", "1": "", "none": ""}
"""Units as they are also written -> as gelcone writes them."""
_SLASHED = {*UNITS, *_SPELT, "min", "h", "%", "1/s", "K", "degC", "\N{DEGREE SIGN}C", "deg"}
"""Units that follow a slash without a space before it."""
_NAMES = ("F/A", *UNITS)
"""Headings with a slash that are names: a force over an area is not in amperes."""
TIME = ("time", "t")
VOLTAGE = ("voltage", "volt", "u", "v", "hv")
"""Names by which columns of time and voltage are recognised."""


@dataclass(frozen=True)
class Column:
    """A column: its ``name`` and ``unit`` in the header (None if not stated), its ``values`` (NaN for an empty cell,
    None for a column of words), its ``words``, and the ``fault`` for which cells among numbers are words."""

    name: str
    unit: str | None
    values: Array | None
    words: tuple[str, ...]
    fault: str = ""


@dataclass(frozen=True)
class Table:
    """A measured table: its file, its ``columns`` by name, the ``lines`` of the file for its rows, ``notes`` about
    interpretations, and where its ``header`` is, for messages."""

    file: str
    columns: Mapping[str, Column]
    lines: Sequence[int]
    notes: tuple[str, ...] = field(default=())
    header: str = ""

    def find(self, names: Sequence[str]) -> str | None:
        """The column that has the first of the ``names`` that one has, None without; `InputError` where two have it."""
        spelt: dict[str, list[str]] = {}
        for name in self.columns:
            spelt.setdefault(spelt_plainly(name), []).append(name)
        alike = next((spelt[name] for name in names if name in spelt), [None])
        if len(alike) > 1:
            raise InputError(f"{self.header}: columns {alike[0]!r} and {alike[1]!r} are spelt alike; rename one")
        return alike[0]

    def without_unit(self, name: str, unit: str) -> str:
        """The beginning of the message about a column without a unit."""
        return f'{self.header}: column "{name}" has no unit; write "{name} ({unit})"'

    def numbers(self, name: str, role: str, *, whole: bool = False) -> Array:
        """The values of a column; `InputError` for words, and where they are to be ``whole`` for an empty cell."""
        column = self.columns[name]
        if column.values is None:
            words = f"column {name!r} holds words, and {role} is a number; rename the column"
            raise InputError(column.fault or f"{self.file}: {words}")
        if whole and np.isnan(column.values).any():
            line = self.lines[int(np.argmax(np.isnan(column.values)))]
            raise InputError(
                f"{self.file}, line {line}: column {name!r} has an empty cell; complete it, or leave the row out"
            )
        return column.values

    def size_of(self, name: str, unit: str, si: str) -> float:
        """The size of the ``unit`` of a column in the SI unit ``si``; `InputError` for a unit of another quantity."""
        dimension = DIMENSIONS[si]
        sizes = {**{unit_name: 10.0**power for unit_name, power in dimension.powers.items()}, **dimension.factors}
        unit_name = plain_unit(unit)
        if unit_name not in sizes:
            listed = ", ".join(symbol for symbol in sizes if symbol.isascii())
            remedy = f"write one of {listed}" if listed else "leave it out"
            raise InputError(f"{self.header}: column {name!r}: {unit!r} is not a unit of {dimension.name}; {remedy}")
        return sizes[unit_name]

    def unit_of(self, name: str, stated: str | None) -> str | None:
        """The unit of a column, of its heading or ``stated`` in a list; `InputError` where these are two."""
        unit = self.columns[name].unit
        if stated and unit and _ascii(stated) != _ascii(unit):
            raise InputError(
                f"{self.file}: column {name!r} is in {unit} by its heading and in {stated} by the list; leave the unit "
                "out of the list, or correct the heading"
            )
        return stated or unit

    def named(self, text: str, where: str) -> tuple[str, str | None]:
        """The column that a list names, as in ``"F, mN"``, and the unit stated there, None for none; `InputError`,
        which begins with ``where``, unless there is such a column."""
        before, comma, after = text.rpartition(",")
        column, stated = (before.strip(), after.strip()) if comma else (text.strip(), None)
        check_name("column", column, self.columns, where=where)
        return column, stated

    def warn(self) -> None:
        """State the notes in a warning, for what has no place for them in its answer."""
        if self.notes:
            warnings.warn(f"{self.file}: {'; '.join(self.notes)}", DoubtfulInput, stacklevel=3)


def spelt_plainly(name: str) -> str:
    """The name of a column in small letters, with single spaces between its words."""
    return re.sub(r"[\s_\-]+", " ", name.strip().lower())


def plain_unit(unit: str) -> str:
    """A unit as gelcone writes it."""
    return _SPELT.get(unit.strip().lower(), unit.strip())


def _ascii(unit: str) -> str:
    """A unit with u for both letters that look like mu."""
    return unit.replace("\N{MICRO SIGN}", "u").replace("\N{GREEK SMALL LETTER MU}", "u")


def read_table(path: Path) -> Table:
    """Read a measured table from a text file, or the vectors of a MATLAB or HDF5 file.

    Semicolons, tabs, commas and spaces separate; decimals have points or commas; a unit stands in the heading, as in
    ``stress (kPa)``, ``stress [kPa]``, ``stress / kPa`` or ``stress/kPa``, or in a second row; lines that begin with #
    or % are left out, and so is a first line ``sep=;``, which names the separator. UTF-8, UTF-16 and Latin-1 are read.

    Raises
    ------
    InputError : for a file that cannot be read or whose numbers are not certain, in one line with the remedy.
    """
    file = _short(path.name)
    if reason := NOT_READ.get(path.suffix.lower()):
        raise InputError(f"{file}: {reason}")
    if path.suffix.lower() in BINARY:
        return _table_of(path, file)
    text, notes = _decoded(path, file)
    rows, lines, separator = _rows(file, text, notes)
    heading, *body = rows
    header = f"{file}, line {lines[0]}"
    names, units = _heading(header, heading)
    if body and any(body[0]) and not any(map(_number_like, body[0])) and len(body) > 1:
        units = _second_row(body[0], units)
        notes.append("units stand in the second row")
        body, lines = body[1:], [lines[0], *lines[2:]]
    if len(body) > MOST_ROWS:
        raise InputError(f"{file}: has {len(body)} rows; give at most {MOST_ROWS}, thinned out")
    if not body:
        raise InputError(f"{file}: has a header and no numbers; {REMEDY}")
    body = _even(file, lines[1:], body, len(names), notes)
    lines = lines[1 : 1 + len(body)]
    columns = {}
    for name, unit, cells in zip(names, units, zip(*body, strict=True), strict=True):
        try:
            columns[name] = _column(file, name, unit, cells, lines, separator, notes)
        except InputError as error:
            columns[name] = Column(name, unit, None, cells, str(error))
    return Table(file, columns, lines, tuple(dict.fromkeys(notes)), header)


def _table_of(path: Path, file: str) -> Table:
    """The table of the vectors of a MATLAB or HDF5 file."""
    vectors = read_vectors(path, file, REMEDY)
    _check_names(file, list(vectors))
    columns = {}
    for name, (values, unit) in vectors.items():
        large = np.flatnonzero(np.abs(values) > LARGEST)
        fault = f"{file}: column {name!r} holds {values[large[0]]:g}; {SMALLER}" if large.size else ""
        columns[name] = Column(name, unit and _short(unit), None if fault else values, (), fault)
    rows = len(next(iter(vectors.values()))[0])
    if rows > MOST_ROWS:
        raise InputError(f"{file}: has {rows} rows; give at most {MOST_ROWS}, thinned out")
    return Table(file, columns, range(1, rows + 1), (f"read as {BINARY[path.suffix.lower()]}",), file)


def _decoded(path: Path, file: str) -> tuple[str, list[str]]:
    """The text of a file, and notes about its encoding."""
    data, notes = read_data(path, REMEDY), []
    encoding = "utf-16" if data.startswith((b"\xff\xfe", b"\xfe\xff")) else "utf-8-sig"
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError as error:
        if encoding == "utf-16":
            raise InputError(f"{file}: is not UTF-16 text (byte {error.start}); save it as UTF-8") from None
        text = data.decode("latin-1")
        notes.append("is not UTF-8: read as Latin-1")
    if "\x00" in text or sum(not (c.isprintable() or c.isspace()) for c in text[:4096]) > 8:
        raise InputError(f"{file}: is not text; {REMEDY}")
    if "\N{REPLACEMENT CHARACTER}" in text:
        notes.append("letters were lost when it was exported (they read \N{REPLACEMENT CHARACTER}), numbers were not")
    return text, notes


def _rows(file: str, text: str, notes: list[str]) -> tuple[list[list[str]], list[int], str]:
    """The cells of all lines that are neither empty nor comments, the header first, the numbers of the lines, and what
    separates the cells."""
    lines, numbers = [], []
    for number, line in enumerate(StringIO(text, newline=None), start=1):
        if line.strip(" \t;,\n") and not line.lstrip().startswith(("#", "%")):
            lines.append(line)
            numbers.append(number)
        if len(lines) > MOST_ROWS + 2:
            raise InputError(f"{file}: has more than {MOST_ROWS} rows; give at most that, thinned out")
    declared = re.fullmatch(r"sep=([;\t,])\s*", lines[0]) if lines else None  # as Excel reads and writes it
    lines, numbers = (lines[1:], numbers[1:]) if declared else (lines, numbers)
    if not lines:
        raise InputError(f"{file}: is empty; {REMEDY}")
    if len(lines[0]) > LONGEST_HEADER:
        raise InputError(
            f"{file}, line {numbers[0]}: is a header of {len(lines[0])} letters; give at most {LONGEST_HEADER}"
        )
    # a semicolon or a tab where there is one, else a comma, else spaces
    separator = declared[1] if declared else next((mark for mark in ";\t," if mark in lines[0]), " ")
    if separator == " ":
        # spaces before and within brackets belong to the unit of a heading, those around a slash to neither
        first = re.sub(r"\s+(?=[\[(/])|(?<=/)\s+", "", lines[0])
        cells = [re.findall(r"(?:[(\[][^)\]]*[)\]]|\S)+", first), *(line.split() for line in lines[1:])]
    else:
        try:
            cells = [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=separator, strict=True)]
        except csv.Error as error:
            raise InputError(f"{file}: {error}; close every quote, one row a line") from None
        if len(cells) != len(lines):
            raise InputError(f"{file}: a quote runs over several lines; close it on its line")
    if separator != "," and len(cells[0]) > 1:
        known = {";": "semicolons", "\t": "tabs", " ": "spaces"}[separator]
        notes.append(f"cells are separated by {known}")
    return cells, numbers, separator


def _heading(header: str, cells: list[str]) -> tuple[list[str], list[str | None]]:
    """Names and units of the columns; `InputError` for a header that cannot be used."""
    while cells and not cells[-1]:
        cells = cells[:-1]
    if len(cells) > MOST_COLUMNS:
        raise InputError(f"{header}: has {len(cells)} columns; give at most {MOST_COLUMNS}")
    if all(map(_number_like, cells)):
        raise InputError(f"{header}: is a row of numbers, not a header; {REMEDY}")
    _check_names(header, cells)
    unclosed = [cell for cell in cells if any(cell.count(one) != cell.count(other) for one, other in PAIRS)]
    if unclosed:
        raise InputError(f"{header}: column {unclosed[0]!r} has a bracket that is not closed; close it")
    named = [_name_and_unit(cell) for cell in cells]
    names = [name for name, _ in named]
    if "" in names:
        raise InputError(f"{header}: column {names.index('') + 1} has no name; {REMEDY}")
    twice = next((name for k, name in enumerate(names) if name in names[:k]), None)
    if twice is not None:
        raise InputError(f"{header}: has two columns {twice!r}; leave one out or rename it")
    return names, [unit for _, unit in named]


def _check_names(header: str, cells: Sequence[str]) -> None:
    """`InputError` for the name of a column that is too long or has no letters."""
    odd = next((k for k, cell in enumerate(cells) if len(cell) > LONGEST_WORD or not cell.isprintable()), None)
    if odd is not None:
        raise InputError(
            f"{header}: column {odd + 1} is named {_short(cells[odd])!r}; give it at most {LONGEST_WORD} letters"
        )


def _name_and_unit(cell: str) -> tuple[str, str | None]:
    """Split ``stress (kPa)``, ``stress [kPa]``, ``stress / kPa`` or ``stress/kPa`` into name and unit."""
    match = re.fullmatch(r"(.*?)\s*/?\s*[\(\[]([^\(\)\[\]]*)[\)\]]", cell) or re.fullmatch(r"(.+?)\s+/\s*(\S+)", cell)
    if match:
        return match[1].strip(), match[2].strip()
    slashes = [] if cell in _NAMES else [k for k, letter in enumerate(cell) if letter == "/"]
    unit = next((k for k in slashes if cell[k + 1 :] in _SLASHED), None)
    return (cell, None) if unit is None else (cell[:unit], cell[unit + 1 :])


def _second_row(row: list[str], units: list[str | None]) -> list[str | None]:
    """The units of the header, completed by a row below it."""
    padded = [*row, *[""] * len(units)]
    row_units = [_short(cell.strip("()[] ")) for cell in padded]
    return [unit if unit is not None or not cell else cell for unit, cell in zip(units, row_units, strict=False)]


def _number_like(cell: str) -> bool:
    return not np.isnan(_value(cell))


def _even(file: str, lines: list[int], rows: list[list[str]], count: int, notes: list[str]) -> list[list[str]]:
    """Check that rows have ``count`` cells each; `InputError` for one with more or fewer."""
    whole_rows = []
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
                "between cells, words that hold a separator quotes, and lines above the header a # before them"
            )
        if len(row) < count:
            if line != lines[-1]:
                raise InputError(f"{file}, line {line}: has {len(row)} cells for {count} columns; complete it")
            notes.append(f"line {line}, the last, is cut off ({len(row)} cells of {count}) and left out")
            continue
        whole_rows.append(row)
    if not whole_rows:
        raise InputError(f"{file}: has no whole row; {REMEDY}")
    return whole_rows


def _column(
    file: str,
    name: str,
    unit: str | None,
    cells: tuple[str, ...],
    lines: Sequence[int],
    separator: str,
    notes: list[str],
) -> Column:
    """Read a column of numbers or of words; `InputError` for a number that is not certain."""
    values = np.array(list(map(_value, cells)))
    odd = np.flatnonzero(np.isnan(values))
    wrong = [k for k in odd.tolist() if cells[k].lower() not in _MISSING]
    numeric = len(cells) - len(odd)
    if numeric < max(len(wrong), 1):
        return Column(name, unit, None, cells)
    commas = [k for k, cell in enumerate(cells) if "," in cell and values[k] == values[k]]
    points = next((k for k, cell in enumerate(cells) if "." in cell), None) if commas else None
    if points is not None:
        raise InputError(
            f"{file}, line {lines[points]}: column {name!r} has decimal points and decimal commas "
            f"({_short(cells[points])}); export it with one of them and no marks between thousands"
        )
    at = f"{file}, line {{}}: column {name!r} holds {{!r}}"
    first = cells[commas[0]] if commas else ""
    if commas and separator == "," and all(re.fullmatch(r"[+-]?\d{1,3},\d{3}", cells[k]) for k in commas):
        raise InputError(
            f"{at.format(lines[commas[0]], first)}: a decimal comma, or a mark between thousands? separate cells by "
            "semicolons, or write decimals with points"
        )
    if wrong:
        words = "give one number a cell, without unit and without marks between thousands"
        raise InputError(f"{at.format(lines[wrong[0]], _short(cells[wrong[0]]))}; {words}")
    if (large := np.flatnonzero(np.abs(values) > LARGEST)).size:
        raise InputError(f"{at.format(lines[int(large[0])], _short(cells[int(large[0])]))}; {SMALLER}")
    if commas and not any(note.startswith("decimals") for note in notes):
        notes.append(f"decimals are written with commas: {_short(first)} is {_short(first.replace(',', '.'))}")
    if odd.size:
        notes.append(f"column {name!r} has {odd.size} empty cells")
    return Column(name, unit, values, cells)


def _value(cell: str) -> float:
    """The number in a cell, NaN for anything else."""
    try:
        return float(cell.replace(",", ".")) if _DIGITS.issuperset(cell) else np.nan
    except ValueError:
        return np.nan


def _short(text: str) -> str:
    """A foreign text for a message: printable, and not longer than `LONGEST_WORD`."""
    clean = "".join(c if c.isprintable() else "?" for c in text)
    return clean if len(clean) <= LONGEST_WORD else f"{clean[: LONGEST_WORD - 3]}..."
