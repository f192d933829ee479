"""`gelcone export`: a device as C sources, or a result as tables or for MATLAB."""

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
from gelcone.export.public import FMU, TOLERANCE, WASM, export

OF_DEVICES = ("film", "settings", "drive", "tolerance", "fmi", "platforms")


def export_command() -> click.Command:
    """`gelcone export`."""
    params: list[click.Parameter] = [
        click.Argument(["what"], metavar="DEVICE|FILE.nc|STORE"),
        click.Option(["--c", "c"], type=PLACE, metavar="FOLDER", help="Write the device as C99 there."),
        click.Option(["--fmu"], type=PLACE, metavar="FILE.fmu", help="Write the device as an FMU."),
        click.Option(["--wasm"], type=PLACE, metavar="FILE.wasm", help="Write the device for web pages."),
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
        click.Option(["--to", "kind"], metavar="csv|mat|parquet", help="The format of a result.  [default: csv]"),
        click.Option(
            ["--out"], type=PLACE, metavar="DIR", help="Folder for these files.  [default: that of the result]"
        ),
        click.Option(["--force"], is_flag=True, help="Overwrite files that exist."),
    ]
    text = """A device for other programs, or a result as tables (CSV, Parquet) or for MATLAB.

    A device becomes C99, alone or in an FMU: the integrator's compiled loop, line by line, with the same bits. Of a
    result, variables over the same dims make a table; a table over dims has them in its name, as in simulate.time.csv.

    \b
    gelcone export biased-pump --fmu pump.fmu
    gelcone export biased-pump --c pump
    gelcone export results/simulate.nc --to csv
    gelcone export map.zarr --to mat --out tables
    """
    return click.Command("export", params=params, callback=run_export, help=text)


def run_export(*, what: str, c: Path | None, fmu: Path | None, wasm: Path | None, force: bool, **typed: Any) -> None:
    """Reads a device, a result or a store, and writes it in another form."""
    given = {name: value for name, value in typed.items() if value not in (None, ())}
    paths: list[Path]
    place = _one_of(c, fmu, wasm)
    if place is None:
        paths = _of_result(Path(what), force, given)
    else:
        _only(given, OF_DEVICES, "results")
        subject = read_subject(what, film=given.pop("film", None), settings=given.pop("settings", ()))
        assert subject.device is not None
        if "platforms" in given:
            given["platforms"] = [name.strip() for name in given["platforms"].split(",")]
        paths = export(subject.device, place, force=force, **given)
    for path in paths:
        click.echo(f"wrote {path}")
    if c is not None:
        click.echo("example.c and test.c are a program each: compile one with the device, as its first lines say")


def _one_of(c: Path | None, fmu: Path | None, wasm: Path | None) -> Path | None:
    """The place of a device; None for a result."""
    given = [place for place in (c, fmu, wasm) if place is not None]
    if len(given) > 1:
        raise InputError("--c, --fmu and --wasm: give one of them")
    if c is not None and c.suffix:
        raise InputError(f"--c {c}: is a folder, without an ending")
    if fmu is not None and fmu.suffix != FMU:
        raise InputError(f"--fmu {fmu}: must end in {FMU}")
    if wasm is not None and wasm.suffix != WASM:
        raise InputError(f"--wasm {wasm}: must end in {WASM}")
    return given[0] if given else None


def _of_result(place: Path, force: bool, given: dict[str, Any]) -> list[Path]:
    if place.suffix == ".toml" or (str(place) in shipped_devices() and not place.exists()):
        raise InputError(f"{place}: is a device; say what it becomes: --fmu FILE.fmu, --c FOLDER or --wasm FILE.wasm")
    _only(given, ("kind", "out"), "devices")
    result, kind = show(place) if place.is_dir() else load(place), given.get("kind", "csv")
    return export(result, given.get("out", place.parent) / f"{place.stem}.{kind.lower()}", force=force)


def _only(given: dict[str, Any], known: tuple[str, ...], others: str) -> None:
    """`InputError` for options of the others."""
    for name in given.keys() - set(known):
        flag = {"kind": "to", "settings": "set"}.get(name, name)
        raise InputError(f"--{flag}: is an option of {others}; leave it out")
