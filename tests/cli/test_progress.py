"""How far long work is, on a stream that is no terminal."""

import io
import re
import time
from pathlib import Path

import numpy as np
import pytest

import gelcone
from gelcone import disk_cache
from gelcone.atlas.record import Tally
from gelcone.cli import output


def test_a_pipe_gets_a_line_now_and_then_also_without_news(monkeypatch, capsys):
    monkeypatch.setattr(output, "LOG_SECONDS", 0.05)
    with output.progress_lines("static") as report:
        time.sleep(0.12)
        report(0.25)
        time.sleep(0.12)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "static: 0 % after 0 s"
    assert re.fullmatch(r"static: 25 % after 0 s, \d s left", lines[-1])
    assert len(lines) >= 3
    time.sleep(0.12)
    assert capsys.readouterr().err == ""


def test_a_sweep_is_reported_before_its_first_cell(monkeypatch, capsys):
    monkeypatch.setattr(output, "LOG_SECONDS", 0.05)
    with output.tally_shown("sweep") as show:
        time.sleep(0.12)
        show(Tally(8, asked=8, computed=2, seconds=1.0))
        time.sleep(0.12)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "sweep: no cell yet after 0 s"
    assert lines[-1].startswith("sweep: 2 of 8 cells, 2 a second, 3 s left")


@pytest.mark.parametrize("shown", ["progress_bar", "tally_shown"])
def test_a_bar_on_a_terminal_moves_without_news(shown, monkeypatch):
    monkeypatch.setattr(output, "BAR_SECONDS", 0.05)
    screen = io.StringIO()
    screen.isatty = lambda: True
    monkeypatch.setattr(output.sys, "stderr", screen)
    with getattr(output, shown)("static"):
        time.sleep(0.3)
    assert screen.getvalue().count("static:") >= 3


@pytest.mark.parametrize("shown", ["progress_lines", "tally_shown"])
def test_a_line_says_that_membranes_are_made_and_programs_compiled(shown, monkeypatch, capsys, tmp_path):
    monkeypatch.setenv(disk_cache.VARIABLE, str(tmp_path))
    monkeypatch.setattr(output, "LOG_SECONDS", 0.05)

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
    films = [f"map, making membrane {k}" for k in (1, 2)]
    assert list(dict.fromkeys(names)) == ["map, compiling", *films, "map"]


@pytest.mark.parametrize("work", ["static", "bifurcation", "simulate"])
def test_work_of_many_steps_reports_on_its_way(work):
    told = []
    model = gelcone.ConeModel(damping_ratio=0.3)
    if work == "static":
        many = model.replace(spring_stiffness=np.linspace(0.5, 2.0, 10))
        gelcone.static(many, np.linspace(0.0, 2.0, 50), progress=told.append)
    elif work == "simulate":
        gelcone.simulate(model, periods=300.0, progress=told.append)
    else:
        short = {"budget": 100.0, "transient": 60.0, "sweeps": []}
        gelcone.bifurcation(model, "voltage", [0.5, 1.5, 2.0], progress=told.append, **short)
    assert sum(told) == pytest.approx(1.0)
    assert len(told) > (1 if work == "simulate" else 5)
    assert max(told) < 1.0
