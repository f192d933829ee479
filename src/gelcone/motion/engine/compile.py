"""Object code: made by LLVM for one kind of processor, kept in the user's cache folder, loaded into the process."""

from __future__ import annotations

import ctypes
import hashlib
import os
import platform
import sys
import tempfile
import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm

from gelcone._version import __version__

CACHE_BYTES = 64 * 2**20
"""Bound of the cache; the entries used longest ago go first."""
CACHE_VARIABLE = "GELCONE_CACHE"
"""Environment variable that names another cache folder; empty for none."""
_MAGIC = b"gelcone object code 1\n"
_lock = threading.Lock()


@dataclass(frozen=True)
class Machine:
    """A kind of processor and system that code is made for: LLVM's target triple, processor name and features."""

    triple: str
    processor: str
    features: str

    @property
    def vector(self) -> int:
        """Doubles in one register: 8 with AVX-512, 4 on other x86, 2 elsewhere (NEON)."""
        if not self.triple.startswith(("x86", "i686", "amd64")):
            return 2
        return 8 if "+avx512f" in self.features.split(",") else 4


@cache
def host() -> Machine:
    """The machine that this process runs on."""
    _initialize()
    try:
        features = sorted(llvm.get_host_cpu_features().items())
    except RuntimeError:  # not known on every system; the processor's name then stands for them
        features = []
    told = ",".join(("+" if on else "-") + name for name, on in features)
    return Machine(llvm.get_process_triple(), llvm.get_host_cpu_name(), told)


@cache
def _initialize() -> None:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()


@cache
def _initialize_all() -> None:
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()


def _target_machine(machine: Machine, in_process: bool) -> Any:
    if machine.triple == host().triple:
        _initialize()
    else:
        _initialize_all()
    return llvm.Target.from_triple(machine.triple).create_target_machine(
        cpu=machine.processor,
        features=machine.features,
        opt=2,
        codemodel="jitdefault" if in_process else "default",
        jit=in_process,
    )


def object_code(text: str, machine: Machine) -> bytes:
    """Object code of an LLVM module for a machine, also for one of another system than this one's."""
    with _lock:
        target = _target_machine(machine, machine.triple == host().triple)
        module = llvm.parse_assembly(text)
        module.triple = target.triple
        module.data_layout = str(target.target_data)
        return bytes(target.emit_object(module))


class Library:
    """Object code in this process. Its functions run without the interpreter's lock."""

    def __init__(self, code: bytes, machine: Machine) -> None:
        with _lock:
            target = _target_machine(machine, True)
            empty = llvm.parse_assembly("")
            empty.triple = target.triple
            self._engine = llvm.create_mcjit_compiler(empty, target)
            self._engine.add_object_file(llvm.ObjectFileRef.from_data(code))
            self._engine.finalize_object()

    def function(self, name: str, result: Any, *arguments: Any) -> Callable[..., Any]:
        """A function of the library, by ctypes types."""
        made: Callable[..., Any] = ctypes.CFUNCTYPE(result, *arguments)(self.address(name))
        return made

    def address(self, name: str) -> int:
        """Where a function is."""
        return int(self._engine.get_function_address(name))


def library(content: str, text: Callable[[], str], machine: Machine | None = None) -> Library:
    """The library of a program, from the cache if it is there.

    Parameters
    ----------
    content : tells programs apart; equal content means equal text.
    text : makes the module's text, when it has to be compiled.
    machine : what to compile for. Default: this process's machine.
    """
    machine = machine or host()
    key = hashlib.sha256(repr((content, machine, llvm.llvm_version_info, __version__, _sources())).encode()).hexdigest()
    code = _read(key)
    if code is None:
        code = object_code(text(), machine)
        _write(key, code)
    return Library(code, machine)


@cache
def _sources() -> str:
    """What the engine itself looks like: other sources make other code."""
    folder = Path(__file__).parent
    return hashlib.sha256(b"".join(path.read_bytes() for path in sorted(folder.glob("*.py")))).hexdigest()


# --- the cache -----------------------------------------------------------------------------------------------------


def cache_folder() -> Path | None:
    """The folder of the cache; None where there is no home folder, or none is wanted."""
    chosen = os.environ.get(CACHE_VARIABLE)
    if chosen is not None:
        return Path(chosen) if chosen else None
    try:
        if sys.platform == "win32":
            base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
        elif sys.platform == "darwin":
            base = Path.home() / "Library" / "Caches"
        else:
            base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    except RuntimeError:
        return None
    return base / "gelcone" / f"code-{platform.machine()}" if base.is_absolute() else None


def _entry(key: str) -> Path | None:
    folder = cache_folder()
    return None if folder is None else folder / f"{key}.o"


def _read(key: str) -> bytes | None:
    """The code kept under this key; None when there is none, or it is not what was written there."""
    path = _entry(key)
    if path is None:
        return None
    try:
        with path.open("rb") as file:
            owner = os.fstat(file.fileno()).st_uid
            content = file.read()
        if hasattr(os, "getuid") and owner != os.getuid():  # what someone else left there is not run
            return None
        head, digest, code = (
            content[: len(_MAGIC)],
            content[len(_MAGIC) : len(_MAGIC) + 32],
            content[len(_MAGIC) + 32 :],
        )
        if head != _MAGIC or digest != _digest(key, code):
            return None
        os.utime(path)
    except OSError:
        return None
    return code


def _digest(key: str, code: bytes) -> bytes:
    """Of code and key together: an entry that was copied to another key is no entry."""
    return hashlib.sha256(key.encode() + code).digest()


def _write(key: str, code: bytes) -> None:
    """Keeps code, whole or not at all; without a folder that can be written to, it is not kept."""
    path = _entry(key)
    if path is None:
        return
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=key[:16], suffix=".part")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(_MAGIC + _digest(key, code) + code)
            os.replace(name, path)
        except BaseException:
            Path(name).unlink(missing_ok=True)
            raise
        _trim(path.parent)
    except OSError:
        return


def _trim(folder: Path) -> None:
    """Removes the entries used longest ago, down to nine tenths of `CACHE_BYTES`."""
    entries = []
    for path in folder.iterdir():
        try:
            status = path.stat()
        except OSError:  # another process removed it
            continue
        entries.append((status.st_mtime, status.st_size, path))
    total = sum(size for _, size, _ in entries)
    if total <= CACHE_BYTES:
        return
    for _, size, path in sorted(entries):
        if total <= 0.9 * CACHE_BYTES:
            break
        path.unlink(missing_ok=True)
        total -= size
