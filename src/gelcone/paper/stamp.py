"""The stamp of a study's data: the effort and the program that they depend on."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

import gelcone
from gelcone._version import __version__
from gelcone.devices.files import shipped_devices
from gelcone.paper.effort import Effort

SHOWING = (
    "accessor.py",
    "amounts.py",
    "analyses",
    "cli",
    "plots",
    "paper/figures",
    "paper/claims",
    "paper/report.py",
    "paper/run.py",
    "paper/stamp.py",
    "paper/work.py",
    "words.py",
)
"""Sources that print, draw and judge results, but do not affect them."""


def stamp(effort: Effort) -> dict[str, str]:
    """Attributes stored with a study's data; data with other attributes are computed again."""
    sizes = {name: size for name, size in asdict(effort).items() if name != "name"}
    return {
        "effort": effort.name,
        "effort_sizes": json.dumps(sizes),
        "gelcone_version": __version__,
        "program": program(),
    }


@cache
def program() -> str:
    """Digest of everything that affects the data: sources except `SHOWING`, shipped devices, and the libraries
    below."""
    digest = sha256()
    for name in ("numpy", "scipy"):
        digest.update(f"{name} {version(name)}\n".encode())
    for name, path in sources():
        digest.update(name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def sources() -> Iterator[tuple[str, Path]]:
    """Name and path of each file that affects the data, sorted by name."""
    root = Path(gelcone.__file__).parent
    files = {path.relative_to(root).as_posix(): path for suffix in ("py", "toml") for path in root.rglob(f"*.{suffix}")}
    files |= {f"devices/{path.name}": path for path in shipped_devices().values()}
    for name in sorted(files):
        if not any(name == part or name.startswith(f"{part}/") for part in SHOWING):
            yield name, files[name]
