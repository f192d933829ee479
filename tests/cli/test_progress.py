"""How far long work is, on a stream that is no terminal."""

import numpy as np
import pytest

import gelcone
from gelcone.cli import output


def test_a_pipe_gets_a_line_now_and_then(monkeypatch, capsys):
    clock = iter([0.0, 1.0, 25.0, 30.0, 50.0])
    monkeypatch.setattr(output.time, "monotonic", lambda: next(clock))
    say = output.progress_lines("static")
    for _ in range(4):
        say(0.25)
    assert capsys.readouterr().err.splitlines() == [
        "static: 50 % after 25 s, 25 s left",
        "static: 100 % after 50 s, 0 s left",
    ]


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
