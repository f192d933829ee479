"""Which compiler is taken, how it is called, and what is said where there is none or it fails."""

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from gelcone import disk_cache
from gelcone.errors import InputError, MissingDependency
from gelcone.export import compiler


@pytest.mark.parametrize(
    ("named", "there", "found"),
    [
        ("", ("cc", "gcc", "clang"), ["cc"]),
        ("", ("gcc", "clang"), ["gcc"]),
        ("", ("clang",), ["clang"]),
        ("", (), None),
        ("ccache gcc -m64", ("ccache", "cc"), ["ccache", "gcc", "-m64"]),
        ("tcc", ("cc",), None),  # what is named is taken, or none
        ("'my cc' -O0", ("my cc",), ["my cc", "-O0"]),
    ],
)
def test_the_compiler_is_the_one_that_is_named_else_the_first_there_is(named, there, found, monkeypatch):
    monkeypatch.setenv("CC", named)
    monkeypatch.setattr(compiler.shutil, "which", lambda command: f"/bin/{command}" if command in there else None)
    assert compiler.find_compiler() == found


def test_the_compiler_of_other_machines_takes_their_target(monkeypatch):
    monkeypatch.setattr(compiler.importlib.util, "find_spec", lambda name: object() if name == "ziglang" else None)
    assert compiler.cross_compiler("x86_64-macos") == [
        sys.executable, "-m", "ziglang", "cc", "-target", "x86_64-macos", "-s",
    ]  # fmt: skip
    monkeypatch.setattr(compiler.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(MissingDependency) as error:
        compiler.cross_compiler("x86_64-macos")
    assert str(error.value) == "libraries for other machines need a compiler: pip install 'gelcone[platforms]'"


@pytest.mark.parametrize(("command", "position"), [(["cc"], True), (["zig", "x86_64-windows-gnu"], False)])
def test_a_library_is_compiled_without_contraction(command, position, monkeypatch):
    asked, heard = [], []

    def run(given, cwd, **how):
        asked.append((given, Path(cwd, "a.c").read_text()))
        Path(cwd, "library").write_bytes(b"made")
        return SimpleNamespace(returncode=0, stderr="")

    monkeypatch.setattr(compiler.subprocess, "run", run)

    class Making:
        def __init__(self, kind):
            heard.append(kind)

        __enter__ = __exit__ = lambda self, *_: None

    monkeypatch.setattr(disk_cache, "making", Making)
    assert compiler.compile_library(command, {"a.c": "int a;", "a.h": ""}, "a.c") == b"made"
    (((*own, to, library, source, mathematics), text),) = asked
    assert (to, library, source, mathematics, text) == ("-o", "library", "a.c", "-lm", "int a;")
    assert own[: len(command)] == command
    flags = set(own[len(command) :])
    assert {"-std=c99", "-ffp-contract=off", "-shared", "-fvisibility=hidden"} <= flags
    assert ("-fPIC" in flags) == position
    assert not flags & {"-ffast-math", "-Ofast"}
    assert heard == ["library"]


@pytest.mark.parametrize(
    ("command", "length", "level"),
    [(["cc"], 0, "-O1"), (["cc"], 1, "-O0"), (["cc", "-O2"], 0, "-O2"), (["cc", "-O2"], 1, "-O2")],
)
def test_long_sources_are_not_optimised_unless_the_command_says_so(command, length, level, monkeypatch):
    asked = []
    monkeypatch.setattr(compiler, "compiled", lambda given, *_: asked.append(given) or b"")
    compiler.compile_library(command, {"a.c": "a" * (compiler.LONG - 2), "a.h": "b" * (2 + length)}, "a.c")
    assert [word for word in asked[0] if word.startswith("-O")] == [level]


@pytest.mark.parametrize(
    ("said", "first"), [("a.c:1: lost\nmore", "a.c:1: lost"), ("\n  \n", "no message"), ("", "no message")]
)
def test_a_compiler_that_fails_is_named_with_its_first_line(said, first, monkeypatch):
    failed = subprocess.CompletedProcess([], 1, stdout="", stderr=said)
    monkeypatch.setattr(compiler.subprocess, "run", lambda *given, **how: failed)
    with pytest.raises(InputError) as error:
        compiler.compile_library(["my-cc", "-x"], {"a.c": ""}, "a.c")
    assert str(error.value) == (
        f"my-cc: does not compile the source ({first}); give another one by CC, or CC= for none"
    )
