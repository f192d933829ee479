"""`gelcone devices` and `gelcone materials`: what ships."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gelcone.cli.options import json_parameter
from gelcone.cli.output import say

if TYPE_CHECKING:
    from gelcone.devices.materials import Material


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
    listed = {stem: {"name": title, "file": str(path)} for stem, (path, title) in devices.items()}
    say(
        "devices", as_json, listed, "\n".join(f"{stem}\n  {title}\n  {path}" for stem, (path, title) in devices.items())
    )


def print_device(command: str, name: str, as_json: bool) -> None:
    """Prints a device: its file, or its fields as JSON."""
    from gelcone.devices.device import find_device
    from gelcone.devices.files import shipped_devices

    device = find_device(name)
    path = None if Path(name).is_file() else shipped_devices().get(name)
    text = device.to_toml() if path is None else path.read_text(encoding="utf-8")  # a file that ships has comments
    say(command, as_json, device.parameters(), text.removesuffix("\n"))


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
    words = [_material_words(*gel) for gel in materials.items()] if name is None else [material_text(materials[name])]
    content = {name: gel.parameters() for name, gel in materials.items()}
    say("materials", as_json, content, "\n".join(words))


def _material_words(name: str, gel: Material) -> str:
    """A line with the numbers of a gel, and a line for each of their sources."""
    span, creeps = gel.shear_modulus_range, gel.branches
    line = (
        f"{name}: shear modulus {gel.shear_modulus / 1e3:.4g} kPa"
        + ("" if span is None else f" ({span[0] / 1e3:.4g} to {span[1] / 1e3:.4g})")
        + f", relative permittivity {gel.relative_permittivity:.3g}"
        + (f", creeps: {creeps} Maxwell branches" if creeps else "")
    )
    return "\n".join([line, *(f"  {field}: {source}" for field, source in gel.sources.items())])
