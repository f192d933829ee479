"""The command that starts the studio."""

from __future__ import annotations

import os
import sys
import threading
import warnings
import webbrowser
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from urllib.parse import urlencode

import click

from gelcone.errors import DoubtfulInput
from gelcone.presets import find_preset


def studio_command() -> click.Command:
    """``gelcone studio``."""

    @click.command("studio")
    @click.argument("device", required=False, metavar="[DEVICE]")
    @click.option(
        "--preset",
        metavar="NAME",
        help="Start from a parameter set of the source paper, without units: base, fast, spring or table1.",
    )
    @click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port to listen on.  [default: a free one]")
    @click.option("--host", default="127.0.0.1", metavar="NAME", help="Address to listen on.  [default: 127.0.0.1]")
    @click.option("--no-browser", is_flag=True, help="Print the address alone.")
    def command(device: str | None, preset: str | None, port: int, host: str, no_browser: bool) -> None:
        """A page in the browser in which every control answers at once.

        DEVICE is a device file (`gelcone init mine.toml` writes one to fill in) or one of those that `gelcone devices`
        lists; left out, biased-pump. The file is not changed: Save... in the page writes the device as it is set there.
        Ctrl-C ends the studio.

        \b
        gelcone studio biased-pump
        gelcone studio my-device.toml
        gelcone studio --preset base
        """
        start(device, preset, port, host, no_browser)

    return command


def leading_page(address: str, folder: Path) -> Path:
    """A page in a folder of the user's own that leads to an address: what a browser is started with, all users of the
    machine can read, and the address holds the token."""
    page = folder / "studio.html"
    page.touch(0o600)
    page.write_text(
        f'<!doctype html><meta charset="utf-8"><meta http-equiv="refresh" content="0; url={escape(address)}">'
    )
    return page


def start(device: str | None, preset: str | None, port: int, host: str, no_browser: bool) -> None:
    """Starts the server, prints its address, opens the browser, and serves until Ctrl-C."""
    if device is not None and preset is not None:
        raise click.UsageError(f"--preset {preset} and the device {device!r} are both given; give one or the other")
    if preset is not None:
        find_preset(preset)
    from gelcone.studio.notebook import check_installed

    check_installed()
    from gelcone.devices.device import find_device
    from gelcone.devices.files import shipped_devices
    from gelcone.studio.server import LOCAL, Studio, run
    from gelcone.studio.setting import Setting, Shelf, check_single, names_in

    warnings.simplefilter("ignore", DoubtfulInput)  # the page shows them
    name = device if device is not None or preset is not None else "biased-pump"
    given, names = None, frozenset[str]()
    if name is not None and (name not in shipped_devices() or Path(name).is_file()):
        checked_device = find_device(name)
        check_single(checked_device)
        given, names = Path(name), names_in(checked_device)
    studio = Studio(Shelf(given, names), host)
    listening = studio.listen(port)
    shown = {"preset": preset} if name is None else {"device": given.stem if given else name}
    address = studio.address(urlencode(shown))
    if host not in (LOCAL, "localhost", "::1"):
        click.echo(
            f"warning: --host {host}: whoever can reach this machine and has the address can use the studio, and the "
            "connection is not encrypted",
            err=True,
        )
    click.echo(f"gelcone studio: {address}\nCtrl-C ends it.")
    sys.stdout.flush()
    with TemporaryDirectory(prefix="gelcone-studio-") as folder:
        leading = leading_page(address, Path(folder))
        browse = threading.Thread(target=webbrowser.open, args=(leading.as_uri(),), daemon=True)
        run(studio, listening, Setting(**shown), (lambda: None) if no_browser else browse.start)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)  # all is closed; a thread in the middle of a formula, which would be waited for, is not
