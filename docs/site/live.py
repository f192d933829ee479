"""The live cone of the first page: a device as WebAssembly, in one page that needs no server."""

from __future__ import annotations

import base64
import re
import tempfile
from pathlib import Path

import gelcone

NONE = "<p>This build had no compiler for WebAssembly; <code>gelcone studio</code> shows the cone in motion.</p>"


def live() -> str:
    """The page that `gelcone.export` writes, with its module and script inside; a sentence without a compiler."""
    device = gelcone.find_device("biased-pump").replace(film="wrinkling")
    with tempfile.TemporaryDirectory() as folder:
        try:
            paths = {path.suffix: path for path in gelcone.export(device, Path(folder, "pump.wasm"))}
        except gelcone.MissingDependency:
            return NONE
        page, script = (paths[end].read_text(encoding="utf-8") for end in (".html", ".js"))
        module = base64.b64encode(paths[".wasm"].read_bytes()).decode()
    page = re.sub(r"^ *import \{ device \} from .*$", lambda _: script.replace("export ", ""), page, flags=re.MULTILINE)
    whole = f'Uint8Array.from(atob("{module}"), (c) => c.charCodeAt(0)).buffer'
    found = page.replace('await (await fetch("pump.wasm")).arrayBuffer()', whole)
    assert found != page, "the exported page loads its module in another way"
    return re.sub(r"<h1>.*?</h1>", "", found)
