"""Device files: the text of one, where a line of it is wrong, and those that ship."""

from __future__ import annotations

import re
from pathlib import Path

from gelcone.devices.units import FieldError
from gelcone.errors import InputError


def read_text(path: Path) -> str:
    told = str(path) if str(path).isprintable() else repr(str(path))
    try:
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise InputError(f"{told}: there is no such file; {_what_ships()}") from None
    except IsADirectoryError:
        raise InputError(f"{told}: is a folder; give a TOML file or a name; {_what_ships()}") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{told}: is not UTF-8 text (byte {error.start}); save it as UTF-8") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{told}: cannot be read ({reason}); give a TOML file that can") from None


def _line_of(field: str, source: str) -> int | None:
    """Line on which a field is set, by its last name."""
    leaf = re.split(r"\W", field.removeprefix("material."))[0]
    for number, line in enumerate(source.splitlines(), start=1):
        if re.search(rf"(?:^|[\s\[{{,.\"']){re.escape(leaf)}[\"']?\s*[=\]]", line.split("#")[0]):
            return number
    return None


def located(path: Path, source: str, error: FieldError) -> str:
    """An error with the file, and the line where it can be told."""
    line = _line_of(error.field, source)
    return f"{path}{f', line {line}' if line else ''}: {error}"


def shipped_devices() -> dict[str, Path]:
    """Name -> TOML file of the worked devices that come with gelcone."""
    here = Path(__file__).resolve().parent
    # an installed wheel holds them beside this file, a checkout among its examples
    for folder in (here / "shipped", here.parents[2] / "examples" / "devices"):
        if folder.is_dir():
            return {path.stem: path for path in sorted(folder.glob("*.toml"))}
    return {}


def _what_ships() -> str:
    return f"devices that ship: {', '.join(shipped_devices()) or 'none'}"
