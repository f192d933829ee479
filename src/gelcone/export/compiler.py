"""The C compiler of this machine, if there is one, and the compiler of the package ziglang for other machines."""

from __future__ import annotations

import importlib.util
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from gelcone import disk_cache
from gelcone.errors import InputError, MissingDependency

FLAGS = ("-std=c99", "-ffp-contract=off", "-fPIC", "-fvisibility=hidden", "-shared")
LONG = 4_000_000
"""Characters of the sources above which a library is not optimised. Compilers allocate registers in a time that grows
faster than the length of a function."""


def find_compiler() -> list[str] | None:
    """Find the command of the compiler: that of ``CC``, else ``cc``, ``gcc`` or ``clang``; None without one."""
    named = shlex.split(os.environ.get("CC", ""))
    for command in [named] if named else [["cc"], ["gcc"], ["clang"]]:
        if shutil.which(command[0]):
            return command
    return None


def cross_compiler(target: str) -> list[str]:
    """Make the command of the compiler for another machine; `MissingDependency` without ziglang."""
    if importlib.util.find_spec("ziglang") is None:
        raise MissingDependency("libraries for other machines need a compiler: pip install 'gelcone[platforms]'")
    return [sys.executable, "-m", "ziglang", "cc", "-target", target, "-s"]


def compile_library(compiler: list[str], texts: Mapping[str, str], source: str) -> bytes:
    """Compile one of some sources, name -> text, to a shared library; `InputError` as `compiled`.

    The level of optimisation is that of the command, such as ``gcc -O1``, else it follows from the length of the
    sources. It does not change a bit of the results.
    """
    flags = [flag for flag in FLAGS if not (flag == "-fPIC" and any("windows" in word for word in compiler))]
    if not any(word.startswith("-O") for word in compiler):
        flags.insert(1, "-O1" if sum(map(len, texts.values())) <= LONG else "-O0")
    command = [*compiler, *flags, "-o", "library", source, "-lm"]
    return compiled(
        command, texts, "library", "does not compile the source ({}); give another one by CC, or CC= for none"
    )


def compiled(command: list[str], texts: Mapping[str, str], made: str, refusal: str) -> bytes:
    """Compile sources, name -> text, in a folder of their own by a ``command`` that makes the file ``made``.

    `InputError` with the ``refusal``, which holds the first line of the compiler, if that fails.
    """
    with tempfile.TemporaryDirectory(prefix="gelcone-") as folder:
        for name, text in texts.items():
            Path(folder, name).write_text(text, encoding="utf-8")
        with disk_cache.making(disk_cache.LIBRARY):
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode:
            first = (done.stderr.strip().splitlines() or ["no message"])[0]
            raise InputError(f"{command[0]}: {refusal.format(first)}")
        return Path(folder, made).read_bytes()
