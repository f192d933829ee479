"""Files that are read within a size limit, and files that are written whole or not at all."""

from __future__ import annotations

import errno
import os
import stat
import tempfile
import tomllib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from gelcone.errors import InputError

LARGEST_TEXT = 2**24
"""Largest text file in bytes, such as a device or a film."""
PROBE = 2**16
"""Bytes written to find out why a file could not be."""


def read_text(path: Path, remedy: str) -> str:
    """Reads a text file in UTF-8, with or without a byte-order mark, as `read_data` does.

    Raises `InputError` as there, and for a file that is not UTF-8.
    """
    data = read_data(path, remedy)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{_shown(path)}: is not UTF-8 text (byte {error.start}); save it as UTF-8") from None


def read_data(path: Path, remedy: str) -> bytes:
    """Reads a regular file of at most `LARGEST_TEXT` bytes.

    Raises `InputError`, which ends in ``remedy``, for a file that cannot be read or is larger, and for a folder, a
    device or a pipe, which are not opened.
    """
    shown = _shown(path)
    try:
        mode = path.stat().st_mode
        if stat.S_ISDIR(mode):
            raise InputError(f"{shown}: is a folder; {remedy}")
        if not stat.S_ISREG(mode):
            raise InputError(f"{shown}: is not a regular file; {remedy}")
        with open(path, "rb", opener=_open_regular) as file:
            data = file.read(LARGEST_TEXT + 1)
    except FileNotFoundError:
        raise InputError(f"{shown}: there is no such file; {remedy}") from None
    except InputError:
        raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{shown}: cannot be read ({reason}); {remedy}") from None
    if len(data) > LARGEST_TEXT:
        raise InputError(f"{shown}: is larger than {LARGEST_TEXT // 2**20} MB; {remedy}")
    return data


def read_toml(origin: str | Path, text: str) -> dict[str, Any]:
    """Reads the text of a TOML file; `InputError` names its ``origin``."""
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{origin}: broken TOML: {error}; correct it there") from None


def _shown(path: Path) -> str:
    return str(path) if str(path).isprintable() else repr(str(path))


def _open_regular(path: str, flags: int) -> int:
    """Opens a file without blocking: it may have become a pipe, which would never answer."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def writer_of(content: str | bytes) -> Callable[[Path], object]:
    """A function for `write_whole` that writes bytes, or a text as UTF-8."""
    if isinstance(content, bytes):
        return lambda path: path.write_bytes(content)
    return lambda path: path.write_text(content, encoding="utf-8")


def write_whole(path: Path, write: Callable[[Path], object], *, force: bool = False) -> None:
    """Writes a file that appears whole or not at all; replaces an existing one only with ``force``.

    Raises `InputError` for an existing file or a folder that cannot be written.
    """
    write_together({path: write}, force=force)


def write_together(writers: Mapping[Path, Callable[[Path], object]], *, force: bool = False) -> None:
    """Writes several files that appear only once all of them are written; see `write_whole`."""
    check_writable(writers, force=force)
    temporaries: dict[Path, Path] = {}
    try:
        for path, write in writers.items():
            temporaries[path] = temporary = _temporary(path)
            try:
                write(temporary)
                temporary.chmod(0o666 & ~_umask())
            except OSError as error:
                remedy = "free some space or choose another folder"
                raise InputError(f"{path}: cannot be written ({_reason(temporary, error)}); {remedy}") from None
        for path, temporary in temporaries.items():
            temporary.replace(path)
    finally:
        for temporary in temporaries.values():
            temporary.unlink(missing_ok=True)


def _reason(path: Path, error: OSError) -> str:
    """The reason why a file could not be written; if a library hides it, a second attempt to write shows it."""
    if error.strerror is None:
        try:
            with path.open("ab") as file:
                file.write(bytes(PROBE))
        except OSError as probe_error:
            return probe_error.strerror or str(probe_error)
    return error.strerror or str(error)


def check_writable(paths: Iterable[Path], *, force: bool = False) -> None:
    """Raises `InputError` for files that exist (unless ``force``) or could not be written, without touching
    anything."""
    for path in paths:
        try:
            there = _is_there(path)
            nearest = next(parent for parent in path.absolute().parents if _is_there(parent))
        except (OSError, ValueError) as error:
            raise _unwritable(path, error) from None
        if path.is_dir():
            raise InputError(f"{path}: is a folder; choose another one to write to")
        if there and not force:
            raise InputError(
                f"{path}: exists already; choose another name, or overwrite it with force (force=True, --force)"
            )
        if not nearest.is_dir():
            raise _unwritable(path, NotADirectoryError(errno.ENOTDIR, f"{nearest} is a file"))
        if not os.access(nearest, os.W_OK | os.X_OK):
            raise _unwritable(path, PermissionError(errno.EACCES, "no permission"))


def _is_there(path: Path) -> bool:
    try:
        path.stat()
    except (FileNotFoundError, NotADirectoryError):
        return False
    return True


def _unwritable(path: Path, error: Exception) -> InputError:
    reason = getattr(error, "strerror", None) or error
    return InputError(f"{path.parent}: cannot be written ({reason}); choose another folder")


def _temporary(path: Path) -> Path:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-", suffix=path.suffix)
    except OSError as error:
        raise _unwritable(path, error) from None
    os.close(handle)
    return Path(name)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
