"""Device files: the lines of their errors, and the files that ship."""

from __future__ import annotations

import difflib
import re
from pathlib import Path

from gelcone.devices.units import FieldError


def _line_of(field: str, source: str) -> int | None:
    """Number of the line on which a field is set, found by the last part of its name; None if there is none."""
    leaf = re.split(r"\W", field.removeprefix("material."))[0]
    for number, line in enumerate(source.splitlines(), start=1):
        if re.search(rf"(?:^|[\s\[{{,.\"']){re.escape(leaf)}[\"']?\s*[=\]]", line.split("#")[0]):
            return number
    return None


def located(path: str | Path, source: str, error: FieldError) -> str:
    """The text of an error with the file, and with the line if it is known."""
    line = _line_of(error.field, source)
    return f"{path}{f', line {line}' if line else ''}: {error}"


def shipped_devices() -> dict[str, Path]:
    """Name -> TOML file of the worked devices that come with gelcone."""
    here = Path(__file__).resolve().parent
    # an installed wheel holds them next to this file, a checkout among its examples
    for folder in (here / "shipped", here.parents[2] / "examples" / "devices"):
        if folder.is_dir():
            return {path.stem: path for path in sorted(folder.glob("*.toml"))}
    return {}


def what_ships(name: str = "") -> str:
    """The remedy for a device file that cannot be read: shipped devices of similar names, or all of them."""
    shipped = list(shipped_devices())
    containing = [shipped_name for shipped_name in shipped if name and name in shipped_name]
    near = containing or difflib.get_close_matches(name, shipped, n=1, cutoff=0.7)
    if near:
        return f"did you mean {' or '.join(map(repr, near))}, which ships?"
    return f"give a TOML file or a name; devices that ship: {', '.join(shipped) or 'none'}"
