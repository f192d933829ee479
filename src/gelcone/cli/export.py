"""`gelcone export`: a device as C, FMU or WebAssembly, or a result as tables or for MATLAB."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from gelcone.analyses.request import read_subject
from gelcone.atlas.record import show
from gelcone.cli.options import PLACE
from gelcone.dataset import load
from gelcone.devices.files import shipped_devices
from gelcone.errors import InputError
from gelcone.export.fmu import HOST, PLATFORMS
from gelcone.export.public import FMU, OF_DEVICE, TOLERANCE, WASM, export


def export_command() -> click.Command:
    """`gelcone export`."""
    params: list[click.Parameter] = [
        click.Argument(["what"], metavar="DEVICE|FILE.nc|STORE"),
        click.Argument(["place"], type=PLACE, required=False),
        click.Option(["--fmi"], type=int, help="Version of the FMU's standard, 2 or 3.  [default: 2]"),
        click.Option(
            ["--platforms"], metavar="LIST", help=f"Machines of an FMU's libraries: {', '.join([HOST, *PLATFORMS])}."
        ),
        click.Option(["--drive"], metavar="own|sine", help="Put the device's drive inside; the input adds to it."),
        click.Option(
            ["--tolerance"],
            type=float,
            help=f"Relative error of a step.  [default: {TOLERANCE:g}, which leaves about 1e-9 of the stroke]",
        ),
        click.Option(["--set", "settings"], multiple=True, metavar="NAME=VALUE", help="Set a field of the device."),
        click.Option(["--film"], metavar="membrane|wrinkling|taut", help="The film of the device."),
        click.Option(["--force"], is_flag=True, help="Overwrite files that exist."),
    ]
    text = """A device for other programs, or a result as tables (CSV, Parquet) or for MATLAB.

    The ending of PLACE is the form. A device goes to NAME.fmu, to NAME.wasm for web pages, or as C99 to a folder: the
    integrator's compiled loop, line by line, with the same bits. A result goes to NAME.csv, NAME.mat or NAME.parquet,
    by default to a CSV file next to it; variables over the same dims make a table, whose name has these dims, as in
    simulate.time.csv.

    An FMU holds a compiled library. To compile it takes about 10 s, and up to a minute for two films or for a film
    that creeps behind a resistance. Such long sources are not optimised; with CC="gcc -O1" they are, which takes
    minutes and makes steps a third shorter.

    \b
    gelcone export biased-pump pump.fmu
    gelcone export biased-pump pump
    gelcone export results/simulate.nc
    gelcone export map.zarr tables/map.mat
    """
    return click.Command("export", params=params, callback=run_export, help=text)


def run_export(*, what: str, place: Path | None, force: bool, **typed: Any) -> None:
    """Reads a device, a result or a store, and writes it in another form."""
    given = {name: value for name, value in typed.items() if value not in (None, ())}
    if "platforms" in given:
        given["platforms"] = [name.strip() for name in given["platforms"].split(",")]
    source = Path(what)
    device = not _is_result(source)
    paths = _of_device(what, place, force, given) if device else _of_result(source, place, force, given)
    for path in paths:
        click.echo(f"wrote {path}")
    if device and place is not None and not place.suffix:
        click.echo("example.c and test.c are a program each: compile one with the device, as its first lines say")


def _is_result(source: Path) -> bool:
    """Decide whether a result or a store is meant; a shipped device has priority over a folder that holds no store."""
    if not source.is_dir():
        return source.suffix == ".nc"
    return (source / "zarr.json").is_file() or str(source) not in shipped_devices()


def _of_device(what: str, place: Path | None, force: bool, given: dict[str, Any]) -> list[Path]:
    subject = read_subject(what, film=given.pop("film", None), settings=given.pop("settings", ()))
    if place is None:
        raise InputError(f"{what}: is a device; say where it goes, to NAME{FMU}, NAME{WASM} or a folder for C")
    assert subject.device is not None
    return export(subject.device, place, force=force, **given)


def _of_result(source: Path, place: Path | None, force: bool, given: dict[str, Any]) -> list[Path]:
    for name, typed in (("film", given.get("film")), ("set", " ".join(given.get("settings", ())))):
        if typed:
            raise InputError(f"--{name} {typed}: {OF_DEVICE}")
    result = show(source) if source.is_dir() else load(source)
    return export(result, source.with_suffix(".csv") if place is None else place, force=force, **given)
