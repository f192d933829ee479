"""Files that are read within bounds, and files that appear whole or not at all."""

from __future__ import annotations

import errno
import os
import stat
import tempfile
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from gelcone.errors import InputError

LARGEST_TEXT = 2**24
"""Bytes of a text file, such as a device or a film, that are read at most."""
PROBE = 2**16
"""Bytes that are written to learn why a file could not be."""


def read_text(path: Path, remedy: str) -> str:
    """Read the text of a file as `read_data` does, of UTF-8, with or without a byte-order mark.

    Raises `InputError` as there, and for a file that is not UTF-8.
    """
    data = read_data(path, remedy)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{_shown(path)}: is not UTF-8 text (byte {error.start}); save it as UTF-8") from None


def read_data(path: Path, remedy: str) -> bytes:
    """Read a regular file of at most `LARGEST_TEXT` bytes.

    Raises `InputError`, which ends in ``remedy``, for what cannot be read, for a folder, a device or a pipe, which are
    not opened, and for a file that is larger.
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


def _shown(path: Path) -> str:
    return str(path) if str(path).isprintable() else repr(str(path))


def _open_regular(path: str, flags: int) -> int:
    """Open a file without waiting: one that has become a pipe meanwhile would never answer."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def write_whole(path: Path, write: Callable[[Path], None], *, force: bool = False) -> None:
    """Write a file that appears whole or not at all; an existing one stays unless ``force``.

    Raises `InputError` for an existing file or a folder that cannot be written.
    """
    write_together({path: write}, force=force)


def write_together(writers: Mapping[Path, Callable[[Path], None]], *, force: bool = False) -> None:
    """Write several files that appear whole and only when all are written; see `write_whole`."""
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
    """Why a file could not be written; where a library does not say so, a write that fails again does."""
    if error.strerror is None:
        try:
            with path.open("ab") as file:
                file.write(bytes(PROBE))
        except OSError as own:
            return own.strerror or str(own)
    return error.strerror or str(error)


def check_writable(paths: Iterable[Path], *, force: bool = False) -> None:
    """Refuse, without touching anything, files that exist (unless ``force``) or that could not be written."""
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
