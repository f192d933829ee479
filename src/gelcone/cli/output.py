"""What commands print and write: JSON, netCDF, figures, progress."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def check_folder(out: Path | None, name: str, force: bool) -> None:
    """Refuses a result that exists or a folder that cannot be written, before any work is done."""
    if out is not None:
        from gelcone.dataset import check_writable

        check_writable(result_paths(out, name), force=force)


def result_paths(out: Path, name: str) -> tuple[Path, Path]:
    """The files NAME.nc and NAME.png in the folder ``out``."""
    return out / f"{name}.nc", out / f"{name}.png"


def write_results(out: Path, name: str, result: xr.Dataset, figure: Figure, force: bool) -> tuple[Path, Path]:
    """Writes NAME.nc and NAME.png; both appear whole or none does."""
    from gelcone.dataset import write_netcdf, write_together
    from gelcone.plots.style import draw_file

    data, picture = result_paths(out, name)
    write_together(
        {data: lambda to: write_netcdf(result, to), picture: lambda to: draw_file(figure, to)},
        force=force,
    )
    return data, picture


def print_json(content: dict[str, Any]) -> None:
    """One JSON object; what is not a finite number becomes null, an infinite parameter the string "inf"."""
    click.echo(json.dumps(plain(content), allow_nan=False))


def plain(value: Any) -> Any:
    """``value`` in the types of JSON."""
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if hasattr(value, "dims"):
        value = value.values
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def parameters_json(model: Any) -> dict[str, Any]:
    """The model's parameters; an infinite stretch limit is the string "inf"."""

    def write(value: Any) -> Any:
        array = np.asarray(value, dtype=object)
        return (
            ["inf" if v == np.inf else v for v in array.ravel()] if array.ndim else "inf" if value == np.inf else value
        )

    return {name: write(value) for name, value in model.parameters().items()}


def outcome_names(result: xr.Dataset) -> Any:
    """The outcome of a single run as a name, of an ensemble as (nested) lists of names."""
    from gelcone.motion.flow import Outcome

    names = np.vectorize(lambda code: Outcome(code).name.lower())(result["outcome"].values)
    return names.tolist()


@contextmanager
def progress_bar(label: str, hidden: bool) -> Iterator[Callable[[float], None]]:
    """A bar on a terminal that takes shares of the work; nothing when piped."""
    import sys

    from tqdm import tqdm

    disable = True if hidden or not sys.stderr.isatty() else None
    form = "{l_bar}{bar}| {elapsed}<{remaining}"
    with tqdm(total=1.0, desc=label, disable=disable, leave=False, bar_format=form, delay=0.5) as bar:
        yield lambda share: bar.update(share)
