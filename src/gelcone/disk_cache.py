"""The disk cache of compiled code and membranes, under keys that name all their inputs."""

from __future__ import annotations

import hashlib
import inspect
import os
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import cache
from pathlib import Path

VARIABLE = "GELCONE_CACHE"
"""Environment variable with another cache folder; empty for no cache."""
MEMBRANES = "membranes"
"""Kind of the tables of membranes, which take seconds to compute."""
CHARGES = "membrane charges"
"""Kind of the membranes' capacitances, computed after them."""
LIBRARY = "library"
"""Kind of the compiled sources of an exported device, which are not stored."""
MOST_BYTES = 64 * 2**20
"""Size limit of each kind; the least recently used entries are removed first."""
_MAGIC = b"gelcone cache 2\n"


def folder(kind: str) -> Path | None:
    """Folder of the entries of a kind; None without a home folder, or if the cache is disabled."""
    chosen = os.environ.get(VARIABLE)
    if chosen is not None:
        return Path(chosen) / kind if chosen else None
    try:
        if sys.platform == "win32":
            base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
        elif sys.platform == "darwin":
            base = Path.home() / "Library" / "Caches"
        else:
            base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    except RuntimeError:
        return None
    return base / "gelcone" / kind if base.is_absolute() else None


Sources = tuple[Path | type, ...]
"""Files, folders of Python files, and classes (for the files that define them)."""


class Unmade(Exception):
    """Content that is missing in the cache and takes seconds to make."""


_thread = threading.local()


@contextmanager
def unmade_refused() -> Iterator[None]:
    """Makes `made` raise `Unmade`, in this thread, for content that the cache could hold but does not."""
    before, _thread.refuses = getattr(_thread, "refuses", False), True
    try:
        yield
    finally:
        _thread.refuses = before


def refuses() -> bool:
    """Whether this thread is within `unmade_refused`."""
    return getattr(_thread, "refuses", False)


Listener = Callable[[str], AbstractContextManager[object]]
"""Called with the kind of content that is missing in the cache; the content is made within the context that it
returns."""
_listeners: list[Listener] = []


@contextmanager
def heard(listener: Listener) -> Iterator[None]:
    """Calls ``listener``, within the block and in all threads, for content that is made; of nested listeners only the
    innermost."""
    _listeners.append(listener)
    try:
        yield
    finally:
        _listeners.remove(listener)


def making(kind: str) -> AbstractContextManager[object]:
    """The context in which content of a kind is made, here or in a worker; also for other work that takes as long."""
    for listener in _listeners[-1:]:
        return listener(kind)
    return nullcontext()


def made(kind: str, parts: object, make: Callable[[], bytes], sources: Sources) -> bytes:
    """The content that ``make`` returns, or returned before for equal ``parts`` and unchanged sources.

    ``parts`` are compared by ``repr``. Raises `Unmade` within `unmade_refused`.
    """
    key = _key(parts, sources)
    content = read(kind, key)
    if content is None:
        if key and folder(kind) is not None and refuses():
            raise Unmade(kind)
        with making(kind):
            content = make()
        write(kind, key, content)
    return content


def holds(kind: str, parts: object, sources: Sources) -> bool:
    """Whether `made` finds the content without making it."""
    return read(kind, _key(parts, sources)) is not None


def _key(parts: object, sources: Sources) -> str:
    """The key of an entry; empty if it cannot be stored."""
    digest = digest_of(sources)
    return hashlib.sha256(repr((parts, digest)).encode()).hexdigest() if digest else ""


@cache
def digest_of(sources: Sources) -> str:
    """A digest of the sources; empty if a class has no source file, as a class of a session may change."""
    paths: set[Path] = set()
    for source in sources:
        if isinstance(source, Path):
            paths |= set(source.glob("*.py")) if source.is_dir() else {source}
            continue
        try:
            paths.add(Path(inspect.getfile(source)).resolve(strict=True))
        except (TypeError, OSError):
            return ""
    return hashlib.sha256(b"\0".join(path.read_bytes() for path in sorted(paths))).hexdigest()


def read(kind: str, key: str) -> bytes | None:
    """The content under a key; None if it is missing or damaged, and for an empty key."""
    home = folder(kind)
    if home is None or not key:
        return None
    path = home / key
    try:
        with path.open("rb") as file:
            owner = os.fstat(file.fileno()).st_uid
            stored = file.read()
        if hasattr(os, "getuid") and owner != os.getuid():  # may be compiled code: do not trust it
            return None
        content = stored[len(_MAGIC) + 32 :]
        if stored != _MAGIC + _digest(key, content) + content:
            return None
        os.utime(path)
    except OSError:
        return None
    return content


def write(kind: str, key: str, content: bytes) -> None:
    """Stores content under a key, whole or not at all; does nothing if the folder cannot be written."""
    home = folder(kind)
    if home is None or not key:
        return
    try:
        home.mkdir(parents=True, exist_ok=True, mode=0o700)
        handle, name = tempfile.mkstemp(dir=home, prefix=key[:16], suffix=".part")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(_MAGIC + _digest(key, content) + content)
            os.replace(name, home / key)
        except BaseException:
            Path(name).unlink(missing_ok=True)
            raise
        _trim(home)
    except OSError:
        return


def _digest(key: str, content: bytes) -> bytes:
    """A digest of content and key together, so that an entry copied to another key is invalid."""
    return hashlib.sha256(key.encode() + content).digest()


def _trim(home: Path) -> None:
    """Removes the least recently used entries, down to nine tenths of `MOST_BYTES`."""
    entries = []
    for path in home.iterdir():
        try:
            status = path.stat()
        except OSError:  # removed by another process
            continue
        entries.append((status.st_mtime, status.st_size, path))
    total = sum(size for _, size, _ in entries)
    if total <= MOST_BYTES:
        return
    for _, size, path in sorted(entries):
        if total <= 0.9 * MOST_BYTES:
            break
        path.unlink(missing_ok=True)
        total -= size
