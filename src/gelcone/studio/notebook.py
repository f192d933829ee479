"""The studio in a notebook: the page in a frame, served by a thread of the notebook's process."""

from __future__ import annotations

import asyncio
import html
import os
import threading
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlencode

from gelcone.errors import InputError, MissingDependency

if TYPE_CHECKING:
    from gelcone.devices.device import Device

HEIGHT = 720


def check_installed() -> None:
    """Raise `MissingDependency` unless the packages of the extra ``studio`` can be imported."""
    try:
        import starlette  # noqa: F401
        import uvicorn  # noqa: F401
        import websockets  # noqa: F401
    except ImportError:
        raise MissingDependency("the studio needs starlette and uvicorn: pip install 'gelcone[studio]'") from None


class _Running:
    """A studio server in a thread."""

    def __init__(self, names: frozenset[str]) -> None:
        check_installed()
        from gelcone.studio.server import Studio
        from gelcone.studio.setting import Shelf

        self.studio = Studio(Shelf(names=names))
        listening = self.studio.listen()
        self.loop = asyncio.new_event_loop()
        self.thread = threading.Thread(target=self._run, args=(listening,), name="gelcone studio", daemon=True)
        self.thread.start()

    def _run(self, listening: object) -> None:
        self.loop.run_until_complete(self.studio.serve(listening))  # type: ignore[arg-type]
        self.loop.close()


_running: dict[frozenset[str], _Running] = {}
"""The running server for each set of names that pages may follow (see `gelcone.permission`); usually one."""


class StudioFrame:
    """A running studio, shown by a notebook as a frame; `gelcone.studio` makes it.

    ``address`` opens it in a browser of this machine. `close` ends the server, and with it all frames of the notebook,
    which share one server. The output stored in a notebook file holds an address that works once: the file gives nobody
    access.

    Parameters
    ----------
    state : settings with which the page opens.
    height : height of the frame in pixels.
    names : names of the user's own code that pages may follow.

    Examples
    --------
    >>> import gelcone
    >>> frame = gelcone.studio("biased-pump", height=600)
    >>> frame.height, frame.address.startswith("http://127.0.0.1")
    (600, True)
    >>> frame.close()
    """

    def __init__(self, state: dict[str, str], height: int, names: frozenset[str] = frozenset()) -> None:
        running = _running.get(names)
        if running is None or not running.thread.is_alive():
            running = _running[names] = _Running(names)
        self._own, self._studio = running, running.studio
        self._state = urlencode(state)
        self.height: int = height

    def close(self) -> None:
        """Ends the server and its work."""
        if self._own.thread.is_alive():
            self._own.loop.call_soon_threadsafe(self._studio.stop)
            self._own.thread.join()

    @property
    def address(self) -> str:
        """The page's address with its access token."""
        return self._studio.address(self._state)

    def _repr_html_(self) -> str:
        if place := elsewhere():
            return f"<p>{html.escape(_FAR.format(place=place, port=self._studio.port))}</p>"
        source = html.escape(self._studio.ticket(self._state), quote=True)
        return (
            f'<iframe src="{source}" title="gelcone studio" width="100%" height="{self.height}" '
            'style="border:0" allow="clipboard-write"></iframe>'
        )

    def __repr__(self) -> str:
        return f"gelcone studio at port {self._studio.port}; .address opens it in a browser, .close() ends it"


_FAR = (
    "The studio runs on the machine of this notebook's kernel, behind {place}, and answers that machine alone: your "
    "browser cannot reach it. Install gelcone on your own machine and run gelcone studio there, or forward the port "
    "(ssh -L {port}:127.0.0.1:{port} to the kernel's machine) and open .address."
)
"""Text in place of the frame where the browser runs on another machine."""


def elsewhere() -> str:
    """The service between the browser and this process, such as JupyterHub; empty if both run on one machine as far as
    is known."""
    known = {"JUPYTERHUB_SERVICE_PREFIX": "JupyterHub", "BINDER_SERVICE_HOST": "Binder"}
    known |= {"CODESPACES": "GitHub Codespaces", "COLAB_RELEASE_TAG": "Colab"}
    return next((name for variable, name in known.items() if os.environ.get(variable)), "")


def studio(device: Device | str | None = None, *, preset: str | None = None, height: int = HEIGHT) -> StudioFrame:
    """Start the studio and return its frame, for the last line of a notebook cell.

    Parameters
    ----------
    device : a `Device` of single numbers, or the name or file of one. Default ``"biased-pump"``.
    preset : in place of a device a parameter set of the source paper.
    height : height of the frame in pixels. Default 720.

    Returns
    -------
    A frame for the notebook. Its ``address`` opens the page in any browser of this machine; ``close()`` ends it.

    Raises
    ------
    InputError : for a device together with a preset, unknown names, and an ensemble.
    MissingDependency : without starlette and uvicorn (extra ``studio``).

    Examples
    --------
    >>> import gelcone
    >>> frame = gelcone.studio("biased-pump", height=600)
    >>> frame.height
    600
    >>> frame.close()
    """
    from gelcone.devices.analysis import check_one
    from gelcone.devices.device import find_device
    from gelcone.devices.files import shipped_devices
    from gelcone.presets import find_preset

    if preset is not None:
        if device is not None:
            raise InputError(f"preset {preset} and a device are both given; give one or the other")
        find_preset(preset)
        return StudioFrame({"preset": preset}, height)
    if device is None:
        device = "biased-pump"
    if isinstance(device, str):
        if device in shipped_devices() and not Path(device).is_file():
            return StudioFrame({"device": device}, height)
        device = find_device(device)
    check_one(device, "studio")
    from gelcone.studio.setting import names_in

    return StudioFrame({"file": device.to_toml()}, height, names_in(device))
