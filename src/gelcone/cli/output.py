"""What commands print and write: JSON, netCDF, figures, progress."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from gelcone.cli.options import Subject
    from gelcone.devices.device import Device
    from gelcone.physics.film.continuum import ContinuumFilm

SCALED_PARAMETERS = {
    "voltage": "voltage",
    "voltage_bias": "voltage",
    "drive_frequency": "frequency",
    "rest_height": "length",
    "spring_stiffness": "stiffness",
}
"""Parameters of the model that a device gives SI values -> the quantity of their scale."""


def deliver(
    name: str,
    result: xr.Dataset,
    subject: Subject,
    *,
    figure: Callable[[xr.Dataset], Figure],
    report: Callable[[xr.Dataset, xr.Dataset, Subject], dict[str, Any]],
    summary: Callable[[xr.Dataset, Subject], str],
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """What every command does with its result: SI units for a device, NAME.nc and NAME.png for --out, JSON or text.

    ``figure`` and ``summary`` see the result as it is shown, in SI units for a device; ``report``, which makes the
    JSON object, the dimensionless one too.
    """
    shown = in_si(result, subject)
    paths = () if out is None else write_results(out, name, shown, figure(shown), force)
    if as_json:
        print_json(report(result, shown, subject))
        return
    click.echo(summary(shown, subject))
    for path in paths:
        click.echo(f"wrote {path}")


def in_si(result: xr.Dataset, subject: Subject) -> xr.Dataset:
    """The result in millimetres, volts and so on when there is a device.

    The dimensionless parameters stay; the SI values of those that have some stand beside them as ``NAME_si``.
    """
    if subject.device is None:
        return result
    from gelcone.devices.si import READ_AS, factor, to_si

    shown = to_si(result, subject.device)
    for name, variable in shown.data_vars.items():
        # Displacement and velocity side by side in one variable, each with its own scale.
        if variable.attrs.get("quantity") == "state" and variable.attrs["units"] == "1":
            quantities = ("length", "velocity")
            scaled = variable * [factor(subject.device, quantity) for quantity in quantities]
            scaled.attrs = variable.attrs | {"units": ", ".join(READ_AS[quantity][0] for quantity in quantities)}
            shown[name] = scaled
    for name, coord in result.coords.items():
        scale = parameter_scale(str(name), subject.device)
        if scale is not None:
            attrs = {"long_name": str(coord.attrs["long_name"]), "units": scale[1], "quantity": "si"}
            shown = shown.assign_coords({f"{name}_si": (coord.dims, coord.values * scale[0], attrs)})
    return shown


def parameter_scale(name: str, device: Device) -> tuple[float, str] | None:
    """What one dimensionless unit of a parameter is for a device, and in which unit; None for one without a scale."""
    if name not in SCALED_PARAMETERS:
        return None
    from gelcone.devices.si import READ_AS, factor

    quantity = SCALED_PARAMETERS[name]
    return factor(device, quantity), READ_AS[quantity][0]


def common_json(result: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """What every JSON object holds: how the runs ended, the parameters, the initial state, the options, the device."""
    content = {
        "outcome": outcome_names(result),
        "parameters": parameters_json(subject.model),
        "initial": list(subject.initial),
        "options": json.loads(result.attrs["options"]),
    }
    return content if subject.device is None else content | {"device": subject.device.name}


def si_json(shown: xr.Dataset, names: Iterable[str]) -> dict[str, Any]:
    """Some variables of a result in SI units, each with its unit."""
    return {name: {"units": shown[name].attrs["units"], "values": shown[name]} for name in names}


def heading(subject: Subject, swept: Iterable[Any] = ()) -> list[str]:
    """First lines of a text: what was computed on, with those parameters that are one number and not swept."""
    numbers = {k: v for k, v in subject.model.parameters().items() if isinstance(v, float) and k not in swept}
    name = subject.device.name if subject.device else "cone model, dimensionless"
    lines = [name, "  " + ", ".join(f"{k} {v:.4g}" for k, v in numbers.items())]
    about = subject.model.film.describe()
    return [*lines, f"  {about}"] if about else lines


def film_errors(film: ContinuumFilm) -> str:
    """How far a fitted film reaches, and how well its force was fitted."""
    told = ", ".join(f"{name} {error:.1%}" for name, error in film.errors) or "not known"
    return f"a/b = {film.radius_ratio:.4g}, up to |x| = {film.reach:.4g}; largest error of its force: {told}"


def outcome_lines(result: xr.Dataset) -> list[str]:
    """How many runs did not end well, and what to do about them."""
    from gelcone.codes import Outcome

    codes = result["outcome"].values.ravel()
    counts = {outcome: int((codes == outcome).sum()) for outcome in Outcome if outcome}
    return [f"{n} of {codes.size} run(s) failed: {outcome.meaning}" for outcome, n in counts.items() if n]


def check_folder(out: Path | None, name: str, force: bool) -> None:
    """Refuses a result that exists or a folder that cannot be written, before any work is done."""
    if out is not None:
        from gelcone.files import check_writable

        check_writable(result_paths(out, name), force=force)


def result_paths(out: Path, name: str) -> tuple[Path, Path]:
    """The files NAME.nc and NAME.png in the folder ``out``."""
    return out / f"{name}.nc", out / f"{name}.png"


def write_results(out: Path, name: str, result: xr.Dataset, figure: Figure, force: bool) -> tuple[Path, Path]:
    """Writes NAME.nc and NAME.png; both appear whole or none does."""
    from gelcone.dataset import write_netcdf
    from gelcone.files import write_together
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
    from gelcone.codes import Outcome

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
