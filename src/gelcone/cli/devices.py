"""`gelcone devices`."""

from __future__ import annotations

import click

from gelcone.cli.output import print_json


@click.command("devices")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of text.")
def command(as_json: bool) -> None:
    """List the device files that ship; `gelcone simulate NAME` runs one."""
    from gelcone.devices.device import Device, shipped_devices

    devices = {stem: (path, Device.from_toml(path)) for stem, path in shipped_devices().items()}
    if as_json:
        print_json({stem: {"name": device.name, "file": str(path)} for stem, (path, device) in devices.items()})
        return
    for stem, (path, device) in devices.items():
        click.echo(f"{stem}\n  {device.name}\n  {path}")
