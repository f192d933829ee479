"""Results in the formats of other programs: tables (CSV, Parquet) and MATLAB files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.codes import meanings
from gelcone.errors import InputError, MissingDependency, check_result
from gelcone.files import write_together

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

FORMATS = ("csv", "mat", "parquet")


def export(result: xr.Dataset, path: str | Path, *, force: bool = False) -> list[Path]:
    """Write a result as tables or for MATLAB.

    Parameters
    ----------
    result : a Dataset that an analysis returned or `gelcone.load` read.
    path : a name that ends in ``.csv``, ``.mat`` or ``.parquet``. A table holds the variables of the same dims; the
        others go to files with the dims before the ending, as in ``run.time.csv``.
    force : whether files that exist are overwritten. Default no.

    Returns
    -------
    The files written. Columns are ``name (unit)``; codes are words. A MATLAB file holds the variables as arrays, and
    their units, dims and long names in structs.

    Raises
    ------
    InputError : for another ending, a file that exists, or a folder that cannot be written.
    MissingDependency : for Parquet without pyarrow.
    """
    path = Path(path)
    kind = path.suffix.removeprefix(".").lower()
    if kind not in FORMATS:
        raise InputError(f"{path}: a result is written to NAME.{FORMATS[0]}, NAME.{FORMATS[1]} or NAME.{FORMATS[2]}")
    check_result("export", result)
    writers: dict[Path, Callable[[Path], None]]
    if kind == "mat":
        writers = {path: partial(_write_mat, result)}
    else:
        write = _write_csv if kind == "csv" else _write_parquet
        writers = {_named(path, dims): partial(write, table) for dims, table in tables(result).items()}
    write_together(writers, force=force)
    return list(writers)


def tables(result: xr.Dataset) -> dict[tuple[str, ...], pd.DataFrame]:
    """Dims -> a table of the variables over them, one row per entry, with columns ``name (unit)``."""
    return {dims: _table(result, dims, names) for dims, names in _by_dims(result).items()}


def _by_dims(result: xr.Dataset) -> dict[tuple[str, ...], list[str]]:
    """Dims -> the names of the variables over them."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for name, variable in result.data_vars.items():
        groups.setdefault(tuple(map(str, variable.dims)), []).append(str(name))
    return groups


def table(result: xr.Dataset, over: str | Sequence[str] | None = None) -> pd.DataFrame:
    """Return the variables of a result over the same dims as a table of pandas.

    Parameters
    ----------
    result : a Dataset that an analysis returned or `gelcone.load` read.
    over : the dim, or dims, of the table. Default: the first dim of the result alone, or where no variable is over it
        alone, the dims of most variables.

    Returns
    -------
    One row for each entry, with columns ``name (unit)``; codes are words. A result without dims has one row.

    Raises
    ------
    InputError : for dims over which there are no variables.

    Examples
    --------
    >>> import gelcone
    >>> response = gelcone.simulate(gelcone.ConeModel(), times=[0.0, 1.0, 2.0])
    >>> frame = gelcone.table(response)
    >>> len(frame), float(frame["displacement"][0])
    (3, 1.0)
    """
    check_result("table", result)
    groups = _by_dims(result)
    first = tuple(map(str, result.sizes))[:1]
    most = max(groups, key=lambda dims: len(groups[dims]), default=())
    chosen = (first if first in groups else most) if over is None else (over,) if isinstance(over, str) else tuple(over)
    dims = next((dims for dims in groups if set(dims) == set(chosen)), None)
    if dims is None:
        tables = " | ".join(", ".join(table_dims) or "()" for table_dims in groups)
        raise InputError(f"over = {', '.join(chosen)}: no variable is over these dims; there are tables over {tables}")
    return _table(result, dims, groups[dims])


def _table(result: xr.Dataset, dims: tuple[str, ...], names: list[str]) -> pd.DataFrame:
    import pandas as pd
    import xarray as xr

    along = [str(name) for name, c in result.coords.items() if c.dims and set(map(str, c.dims)) <= set(dims)]
    sizes = {dim: result.sizes[dim] for dim in dims}
    numbers = {dim: xr.DataArray(np.arange(size), dims=[dim]) for dim, size in sizes.items() if dim not in along}
    shape = xr.DataArray(np.zeros(tuple(sizes.values())), dims=dims)
    columns: dict[str, Any] = {}
    for name, one in (numbers | {name: result[name] for name in (*along, *names)}).items():
        spread = one.broadcast_like(shape).transpose(*dims).values.ravel()
        columns[_heading(name, one)] = _in_words(spread, one)
    return pd.DataFrame(columns)


def _heading(name: str, variable: xr.DataArray) -> str:
    unit = variable.attrs.get("units", "1")
    return name if unit == "1" else f"{name} ({unit})"


def _in_words(values: Any, variable: xr.DataArray) -> Any:
    """The values of a variable, with words for its codes."""
    if "flag_meanings" not in variable.attrs:
        return values
    known = meanings(variable)
    return np.array([known.get(value, "") for value in values.tolist()], dtype=object)


def _named(path: Path, dims: tuple[str, ...]) -> Path:
    """The path of a table's file; the table of single numbers keeps the name as given."""
    return path.with_suffix("".join(f".{part}" for part in ("-".join(dims), path.suffix[1:]) if part))


def _write_csv(table: pd.DataFrame, path: Path) -> None:
    table.to_csv(path, index=False)


def _write_parquet(table: pd.DataFrame, path: Path) -> None:
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        raise MissingDependency("Parquet files need pyarrow: pip install 'gelcone[parquet]'") from None
    table.to_parquet(path, index=False)


def _write_mat(result: xr.Dataset, path: Path) -> None:
    from scipy.io import savemat

    arrays = {
        str(name): np.asarray(v.values.tolist() if v.dtype.kind in "OU" else v)
        for name, v in (*result.items(), *result.coords.items())
    }
    about = {
        "units": {str(name): v.attrs.get("units", "1") for name, v in result.variables.items()},
        "long_names": {str(name): v.attrs.get("long_name", "") for name, v in result.variables.items()},
        "dims": {str(name): ", ".join(map(str, v.dims)) for name, v in result.variables.items()},
        "attributes": {str(name): value for name, value in result.attrs.items()},
    }
    savemat(path, arrays | about, long_field_names=True, appendmat=False)
