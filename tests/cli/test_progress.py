"""How far long work is, on a stream that is no terminal."""

import io
import re
import time

import numpy as np
import pytest

import gelcone
from gelcone import disk_cache
from gelcone.atlas.record import Tally
from gelcone.cli import output, waiting
from gelcone.membrane import made as films
from gelcone.physics.film import membrane_charge


def test_a_pipe_gets_a_line_now_and_then_also_without_news(monkeypatch, capsys):
    monkeypatch.setattr(waiting, "FIRST_SECONDS", 0.05)
    monkeypatch.setattr(waiting, "LOG_SECONDS", 0.05)
    with output.progress_lines("static") as report:
        time.sleep(0.12)
        report(0.09)
        time.sleep(0.12)
        report(0.16)
        time.sleep(0.12)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "static: 0 % after 0 s"
    assert "static: 9 % after 0 s" in lines  # too early to say how long
    assert re.fullmatch(r"static: 25 % after 0 s, \d s left", lines[-1])
    assert len(lines) >= 3
    time.sleep(0.12)
    assert capsys.readouterr().err == ""


def test_the_time_that_is_left_is_that_of_the_work_that_is_left(monkeypatch, capsys):
    """A quarter of the work is done: three times as long again. The clock runs a hundred times as fast."""
    real = time.monotonic
    monkeypatch.setattr(waiting, "FIRST_SECONDS", 0.05)
    monkeypatch.setattr(waiting, "LOG_SECONDS", 0.05)
    monkeypatch.setattr(output.time, "monotonic", lambda: 100.0 * real())
    with output.progress_lines("static") as report:
        report(0.25)
        time.sleep(0.12)
    said = [re.search(r"25 % after (\d+) s, (\d+) s left", line) for line in capsys.readouterr().err.splitlines()]
    spent, left = max((int(one[1]), int(one[2])) for one in said if one)
    assert spent >= 5
    assert left == pytest.approx(3 * spent, abs=2)


def test_a_sweep_is_reported_before_its_first_cell(monkeypatch, capsys):
    monkeypatch.setattr(waiting, "FIRST_SECONDS", 0.05)
    monkeypatch.setattr(waiting, "LOG_SECONDS", 0.05)
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


ASKED = {
    "map": ("--over", "voltage_amplitude=100 V:200 V:2", "--over", "frequency=5 Hz:6 Hz:2"),
    "sweep": ("--over", "voltage_amplitude=100 V,200 V", "--analysis", "limits"),
    "bifurcation": ("--over", "voltage_amplitude=100 V:200 V:2", "--sweeps", "none"),
    "continue": (),
    "simulate": ("--periods", "1"),
}


@pytest.mark.parametrize("command", ASKED)
def test_a_command_says_what_it_makes_from_its_start(command, command_line, monkeypatch):
    monkeypatch.setattr(waiting, "FIRST_SECONDS", 0.05)
    made = disk_cache.made

    def slowly(kind, *given):
        with disk_cache.making(kind):
            time.sleep(0.2)
        return made(kind, *given)

    monkeypatch.setattr(disk_cache, "made", slowly)
    films._made.cache_clear()
    membrane_charge._made.cache_clear()
    words = ("voltage_amplitude", "100 V", "120 V", "--checks", "2") if command == "continue" else ()
    code, _, said = command_line(command, "biased-pump", *words, *ASKED[command])
    assert code == 0
    assert said.splitlines()[0] == f"{command}, making membrane 1: stored for later runs; after 0 s"


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
