"""`gelcone devices` and `gelcone materials`: what ships."""

from __future__ import annotations

import tomllib
from pathlib import Path

import click

from gelcone.analyses.answer import bare_answer
from gelcone.cli.options import json_parameter
from gelcone.cli.output import print_json


def devices_command() -> click.Command:
    """`gelcone devices`."""
    text = "List the device files that ship, or print one, by its NAME; `gelcone simulate NAME` runs it."
    name = click.Argument(["name"], required=False, metavar="[NAME]")
    return click.Command("devices", params=[name, json_parameter()], callback=list_devices, help=text)


def list_devices(*, name: str | None, as_json: bool) -> None:
    """Prints name, title and file of each device, or one device."""
    from gelcone.devices.files import shipped_devices

    if name is not None:
        print_device("devices", name, as_json)
        return
    devices = {
        stem: (path, str(tomllib.loads(path.read_text(encoding="utf-8"))["name"]))
        for stem, path in shipped_devices().items()
    }
    if as_json:
        listed = {stem: {"name": title, "file": str(path)} for stem, (path, title) in devices.items()}
        print_json(bare_answer("devices", listed))
        return
    for stem, (path, title) in devices.items():
        click.echo(f"{stem}\n  {title}\n  {path}")


def print_device(command: str, name: str, as_json: bool) -> None:
    """Prints a device: its file, or its fields as JSON."""
    from gelcone.devices.device import find_device

    device = find_device(name)
    if as_json:
        print_json(bare_answer(command, device.parameters()))
    else:
        click.echo(device_source(name) or device.to_toml(), nl=False)


def materials_command() -> click.Command:
    """`gelcone materials`."""
    text = """List the measured gels that ship, with their sources, or print all numbers of one, by its NAME.

    It is printed as the table [material] of a device file; a device file takes a gel as it is by `material = "NAME"`.

    \b
    gelcone materials
    gelcone materials "VHB 4910"
    """
    name = click.Argument(["name"], required=False, metavar="[NAME]")
    return click.Command("materials", params=[name, json_parameter()], callback=list_materials, help=text)


def list_materials(*, name: str | None, as_json: bool) -> None:
    """Prints the gels and the sources of their numbers, or all numbers of one."""
    from gelcone.devices.materials import find_material, load_materials
    from gelcone.devices.template import material_text

    materials = load_materials() if name is None else {name: find_material(name)}
    if as_json:
        print_json(bare_answer("materials", {name: gel.parameters() for name, gel in materials.items()}))
        return
    if name is not None:
        click.echo(material_text(materials[name]))
        return
    for name, material in materials.items():
        span, creeps = material.shear_modulus_range, material.branches
        click.echo(
            f"{name}: shear modulus {material.shear_modulus / 1e3:.4g} kPa"
            + ("" if span is None else f" ({span[0] / 1e3:.4g} to {span[1] / 1e3:.4g})")
            + f", relative permittivity {material.relative_permittivity:.3g}"
            + (f", creeps: {creeps} Maxwell branches" if creeps else "")
        )
        for field, source in material.sources.items():
            click.echo(f"  {field}: {source}")


def device_source(name: str) -> str:
    """The file of a device that ships, with its comments; empty for another."""
    from gelcone.devices.files import shipped_devices

    path = shipped_devices().get(name)
    return "" if path is None or Path(name).is_file() else path.read_text(encoding="utf-8")
