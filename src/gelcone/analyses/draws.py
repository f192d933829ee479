"""Draws of uncertain parameters from the command line: distributions, or a table as it comes from a fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gelcone import dataset
from gelcone.analyses.ask import read_options
from gelcone.analyses.request import Subject
from gelcone.analyses.uncertain import read_drawn, read_uncertain
from gelcone.atlas.uncertain import Method, draw
from gelcone.devices.reading import MOST_COLUMNS, read_table
from gelcone.errors import InputError
from gelcone.quantity import Array
from gelcone.register.analysis import Analysis

if TYPE_CHECKING:
    import xarray as xr

TABLES = (".csv", ".nc")
MOST_DRAWS = 100_000
FORM = "a header of names, such as film_thickness [mm],shear_modulus [kPa], and a row of numbers a draw"


def read_draws(
    texts: Sequence[str], subject: Subject, *, count: int, method: Method, seed: int, indices: bool
) -> dict[str, Array]:
    """The draws that ``--uncertain`` asks for; ``indices``: with those that Sobol indices need, where they can be.

    Raises `InputError` for a text that is neither a distribution nor a table, or a table among others.
    """
    table = table_among(texts)
    if table is None:
        spread = read_uncertain(texts, subject)
        wanted = indices and len(spread) > 1 and count >= 4 and not count & (count - 1)
        return draw(spread, count, method=method, seed=seed, indices=wanted) if spread else {}
    if len(texts) > 1:
        raise InputError(f"--uncertain {table}: a table holds all uncertain parameters; give it alone")
    return _of_table(Path(table), subject)


def table_among(texts: Sequence[str]) -> str | None:
    """The first text of ``--uncertain`` that names a table of draws."""
    return next((text for text in texts if text.endswith(TABLES) and "=" not in text), None)


def read_samples(path: Path, uncertain: Sequence[str], subject: Subject) -> dict[str, Array]:
    """The draws of a file with their correlations; `InputError` where ``--uncertain`` is given, too."""
    draws = _of_table(path, subject)
    for text in uncertain:
        name = text.partition("=")[0].strip()
        held = "hold it already, with its correlations" if name in draws else "hold all that is uncertain"
        raise InputError(f"--samples {path} and --uncertain {name}: the samples {held}; leave one out")
    return draws


def drawn_options(analysis: Analysis, subject: Subject, given: Mapping[str, Any]) -> dict[str, Any]:
    """The options of `gelcone.over_draws` for what was typed, with a device in SI units; the axes of the analysis among
    them."""
    options = dict(given)
    over = options.pop("over", ())
    options |= read_options(analysis, subject, options, in_si=True)
    return options | (subject.axes(over, analysis, in_si=True) if analysis.axes else {})


def _of_table(path: Path, subject: Subject) -> dict[str, Array]:
    """The draws of a table."""
    if path.suffix not in TABLES:
        raise InputError(f"{path}: is not a table of draws; give a file that ends with {' or '.join(TABLES)}")
    columns = _of_csv(path) if path.suffix == ".csv" else _of_netcdf(path)
    return {name: read_drawn(f"{path}: {name}", name, *column, subject) for name, column in columns.items()}


Columns = dict[str, tuple[Array, str]]
"""Numbers and unit by name."""


def _of_csv(path: Path) -> Columns:
    """The columns of a CSV file."""
    table = read_table(path)
    if not 2 <= len(table.lines) <= MOST_DRAWS:
        raise InputError(f"{path}: has {len(table.lines)} draws; give 2 to {MOST_DRAWS}: {FORM}")
    table_columns = table.columns.items()
    columns = {name: (table.numbers(name, "a draw", whole=True), column.unit or "") for name, column in table_columns}
    table.warn()
    return columns


def _of_netcdf(path: Path) -> Columns:
    """The variables of a netCDF-4 file over one dimension, with their units."""
    table: xr.Dataset = dataset.load(path)
    if len(table.sizes) != 1 or not 2 <= next(iter(table.sizes.values())) <= MOST_DRAWS:
        sizes = ", ".join(f"{dim} {size}" for dim, size in table.sizes.items()) or "no dimension"
        raise InputError(f"{path}: has {sizes}; give variables over one dimension of 2 to {MOST_DRAWS} draws")
    columns = {str(name): values for name, values in table.data_vars.items() if values.dtype.kind in "fiu"}
    if not columns or len(columns) > MOST_COLUMNS:
        raise InputError(f"{path}: has {len(columns)} variables of numbers; give 1 to {MOST_COLUMNS}")
    units = {name: str(values.attrs.get("units", "")) for name, values in columns.items()}
    return {name: (values.values.astype(float), units[name]) for name, values in columns.items()}
