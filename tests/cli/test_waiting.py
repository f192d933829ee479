"""What is said while one waits: what is made, and for how long, on a terminal and in a pipe."""

import io
import sys
import threading
import time
from contextlib import nullcontext
from pathlib import Path

import pytest

from gelcone import disk_cache
from gelcone.atlas.record import Tally
from gelcone.cli import output, waiting
from gelcone.export.compiler import compile_library


@pytest.mark.parametrize("shown", ["progress_lines", "tally_shown"])
def test_a_line_says_that_membranes_are_made_and_programs_compiled(shown, monkeypatch, capsys, tmp_path):
    monkeypatch.setenv(disk_cache.VARIABLE, str(tmp_path))
    monkeypatch.setattr(waiting, "FIRST_SECONDS", 0.05)
    monkeypatch.setattr(waiting, "LOG_SECONDS", 0.05)

    def slowly():
        time.sleep(0.12)
        return b"made"

    with getattr(output, shown)("map") as report:
        for kind, parts in (("code", 2), (disk_cache.MEMBRANES, 1), (disk_cache.MEMBRANES, 2), ("code", 1)):
            disk_cache.made(kind, parts, slowly, (Path(__file__),))
        report(Tally(8, asked=8, computed=2, seconds=1.0) if shown == "tally_shown" else 0.5)
        time.sleep(0.12)
        disk_cache.made(disk_cache.MEMBRANES, 1, slowly, (Path(__file__),))
    names = [line.split(":")[0] for line in capsys.readouterr().err.splitlines()]
    membranes = [f"map, making membrane {k}" for k in (1, 2)]
    assert list(dict.fromkeys(names)) == ["map, compiling", *membranes, "map"]


def test_what_two_threads_make_is_named_until_both_have_it():
    names = []
    with waiting.preparing("map", names.append), disk_cache.making("code"):
        with disk_cache.making("code"):
            pass
        assert names == ["map, compiling"] * 2
    assert names[2:] == ["map"]


def test_a_membrane_of_the_cache_whose_charge_is_new_is_the_first():
    names = []
    with waiting.preparing("map", names.append), disk_cache.making(disk_cache.CHARGES):
        pass
    assert names == ["map, making membrane 1", "map"]


def test_an_export_says_that_it_compiles():
    names, compiler = [], [sys.executable, "-c", "open('library', 'w').close()"]
    with waiting.preparing("export", names.append):
        assert compile_library(compiler, {"pump.c": ""}, "pump.c") == b""
    assert names == ["export, compiling", "export"]
    kinds = []
    with disk_cache.heard(lambda kind: kinds.append(kind) or nullcontext()):
        compile_library(compiler, {"pump.c": ""}, "pump.c")
    assert kinds == [disk_cache.LIBRARY]


def test_while_something_is_made_no_time_is_foretold(monkeypatch, capsys):
    monkeypatch.setattr(waiting, "FIRST_SECONDS", 0.05)
    with output.progress_lines("map") as report:
        report(0.5)
        with disk_cache.making("code"):
            time.sleep(0.08)
    assert capsys.readouterr().err.splitlines() == ["map, compiling: stored for later runs; 50 % after 0 s"]


def test_a_command_and_its_progress_say_it_once(monkeypatch, capsys):
    monkeypatch.setattr(waiting, "FIRST_SECONDS", 0.05)
    with waiting.said_before("map"), output.progress_lines("map"), disk_cache.making("code"):
        time.sleep(0.08)
    assert capsys.readouterr().err.splitlines() == ["map, compiling: stored for later runs; 0 % after 0 s"]


@pytest.mark.parametrize(("kind", "stored"), [("code", ": stored for later runs"), (disk_cache.LIBRARY, "")])
def test_of_a_library_that_is_not_stored_nothing_else_is_said(kind, stored, monkeypatch, capsys):
    monkeypatch.setattr(waiting, "FIRST_SECONDS", 0.05)
    with waiting.said_before("export"), disk_cache.making(kind):
        time.sleep(0.08)
    assert capsys.readouterr().err.splitlines() == [f"export, compiling{stored}; after 0 s"]


# --- for how long -----------------------------------------------------------------------------------------------------


def heard(said, count, wait=5.0):
    """Waits until something was said so often, or for some seconds."""
    end = time.monotonic() + wait
    while len(said) < count and time.monotonic() < end:
        time.sleep(0.01)
    return len(said)


def test_the_first_word_comes_after_its_own_time_and_the_others_after_theirs():
    said = []
    with waiting.ticking(lambda: said.append(1), 0.02):
        assert heard(said, 3) >= 3
    ended = len(said)
    with waiting.ticking(lambda: said.append(1), 60.0, 0.02):
        assert heard(said, ended + 1) == ended + 1
        assert heard(said, ended + 2, 0.15) == ended + 1
    with waiting.ticking(lambda: said.append(1), 0.02, 60.0):
        assert heard(said, ended + 2, 0.15) == ended + 1
    assert heard(said, ended + 2, 0.1) == ended + 1


def test_the_first_line_of_a_log_comes_sooner_than_the_others(monkeypatch):
    """A short run says nothing, and a long one has few lines."""
    assert (waiting.FIRST_SECONDS, waiting.LOG_SECONDS) == (5.0, 20.0)
    said = []
    monkeypatch.setattr(waiting, "FIRST_SECONDS", 0.05)
    with waiting.logging(lambda: said.append(1)):
        assert heard(said, 1) == 1
        assert heard(said, 2, 0.15) == 1


def test_membranes_are_counted_and_programs_not(monkeypatch, capsys):
    monkeypatch.setattr(waiting, "FIRST_SECONDS", 0.02)
    with waiting.said_before("limits"):
        for kind in ("code", disk_cache.MEMBRANES, "code", disk_cache.MEMBRANES):
            with disk_cache.making(kind):
                time.sleep(0.06)
    lines = capsys.readouterr().err.splitlines()
    wanted = ["compiling", "making membrane 1", "compiling", "making membrane 2"]
    assert [line.split(":")[0] for line in lines] == [f"limits, {made}" for made in wanted]
    assert all(int(line.removesuffix(" s").split("after ")[1]) < 60 for line in lines)  # seconds since each began


def test_on_a_terminal_the_seconds_pass_without_news(monkeypatch):
    monkeypatch.setattr(waiting, "BAR_SECONDS", 0.05)
    monkeypatch.setattr(waiting, "FIRST_SECONDS", 0.02)
    screen = io.StringIO()
    screen.isatty = lambda: True
    monkeypatch.setattr(waiting.sys, "stderr", screen)
    with waiting.said_before("limits"), disk_cache.making(disk_cache.MEMBRANES):
        time.sleep(0.3)
    assert screen.getvalue().count("limits, making membrane 1 [00:0") >= 3


def test_what_waits_ends_with_the_work_also_where_that_fails():
    before = threading.active_count()
    with pytest.raises(KeyError), waiting.ticking(lambda: None, 0.01):
        raise KeyError
    assert threading.active_count() == before
