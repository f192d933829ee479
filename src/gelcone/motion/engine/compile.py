"""Object code: compiled by LLVM for one kind of processor, stored in the cache folder, loaded into the process."""

from __future__ import annotations

import ctypes
import functools
import platform
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm

from gelcone import disk_cache
from gelcone._version import __version__

CODE = f"code-{platform.machine()}"
"""Kind of the entries of the cache."""
HOT, COLD, QUICK = 2, 1, 0
"""LLVM's levels of optimisation. For long code without loops its schedulers take two thirds of the time at the highest
level; the lowest compiles ten times as fast as the middle one, and its code runs four times as long."""
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


@functools.cache
def host() -> Machine:
    """The machine that this process runs on."""
    _initialize()
    try:
        features = sorted(llvm.get_host_cpu_features().items())
    except RuntimeError:  # unknown on some systems; the processor's name implies them
        features = []
    named = ",".join(("+" if on else "-") + name for name, on in features)
    return Machine(llvm.get_process_triple(), llvm.get_host_cpu_name(), named)


@functools.cache
def _initialize() -> None:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()


@functools.cache
def _initialize_all() -> None:
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()


def _target_machine(machine: Machine, in_process: bool, level: int = HOT) -> Any:
    if machine.triple == host().triple:
        _initialize()
    else:
        _initialize_all()
    return llvm.Target.from_triple(machine.triple).create_target_machine(
        cpu=machine.processor,
        features=machine.features,
        opt=level,
        codemodel="jitdefault" if in_process else "default",
        jit=in_process,
    )


def object_code(text: str, machine: Machine, level: int = HOT) -> bytes:
    """Object code of an LLVM module for a machine, also for another system.

    ``level``: `HOT`, `COLD` for code that seldom runs or is long, or `QUICK`; the numbers are the same.
    """
    with _lock:
        target = _target_machine(machine, machine.triple == host().triple, level)
        module = llvm.parse_assembly(text)
        module.triple = target.triple
        module.data_layout = str(target.target_data)
        return bytes(target.emit_object(module))


class Library:
    """Object code loaded into this process. Its functions run without the interpreter's lock."""

    def __init__(self, code: bytes, machine: Machine) -> None:
        self.size = len(code)
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
        """The address of a function."""
        return int(self._engine.get_function_address(name))


def library(content: str, text: Callable[[], str], machine: Machine | None = None, level: int = HOT) -> Library:
    """The library of a program, from the cache if it is stored there.

    Parameters
    ----------
    content : identifies programs; equal content means equal text.
    text : makes the module's text, if it has to be compiled.
    machine : target of the compilation. Default: this process's machine.
    level : as in `object_code`.
    """
    made = disk_cache.made(*_entry(content, machine), lambda: object_code(text(), machine or host(), level), _SOURCES)
    return Library(made, machine or host())


def is_stored(content: str, machine: Machine | None = None) -> bool:
    """True if `library` finds the program in the cache."""
    return disk_cache.holds(*_entry(content, machine), _SOURCES)


_SOURCES = (Path(__file__).parent,)


def _entry(content: str, machine: Machine | None) -> tuple[str, object]:
    """Kind and parts of the cache entry of a program."""
    return CODE, (content, machine or host(), llvm.llvm_version_info, __version__)
