"""Runs: progress adds up, and one that is to stop, or is interrupted, does so soon."""

import threading
import time

import numpy as np
import pytest
from engine_systems import Cone, cone_numbers

from gelcone.motion.engine import run as runs
from gelcone.motion.engine.program import Program


def test_progress_adds_up_to_one(monkeypatch):
    monkeypatch.setattr(runs, "REPORT_EVERY", 0.001)
    monkeypatch.setattr(runs, "CALL_SECONDS", 0.002)
    told = []
    program = Program(Cone(), "states", 1e-15)
    for threads in (1, 2):
        told.clear()
        program.run(
            cone_numbers(voltage=np.linspace(0.5, 1.5, 64)),
            np.tile([1.0, 0.0], (64, 1)),
            0.0,
            np.full((64, 1), 8000.0),
            threads=threads,
            report=told.append,
        )
        assert sum(told) == pytest.approx(1.0)
        assert min(told) >= 0.0
        assert len(told) > 3


@pytest.mark.parametrize("threads", [1, 2])
def test_a_run_stops_soon_after_it_is_told(threads):
    program = Program(Cone(), "states", 1e-15)
    program.run(cone_numbers(), [[1.0, 0.0]], 0.0, [[1.0]])
    stop = threading.Event()
    threading.Timer(0.3, stop.set).start()
    before = time.perf_counter()
    raw = program.run(
        cone_numbers(), np.tile([1.0, 0.0], (20, 1)), 0.0, np.full((20, 1), 1e9), threads=threads, stopped=stop.is_set
    )
    assert time.perf_counter() - before < 0.3 + 0.25
    assert (raw.status == -1).all()


def test_a_run_with_many_samples_a_step_stops_soon():
    program, times = Program(Cone(), "states", 1e-15), np.linspace(0.0, 300.0, 400_000)[None].repeat(16, axis=0)
    program.run(cone_numbers(), [[1.0, 0.0]], 0.0, [[1.0]])
    asked = []
    program.run(
        cone_numbers(),
        np.tile([1.0, 0.0], (16, 1)),
        0.0,
        times,
        stopped=lambda: asked.append(time.thread_time()) is None,
    )
    assert len(asked) == 1
    asked.clear()
    program.run(
        cone_numbers(),
        np.tile([1.0, 0.0], (16, 1)),
        0.0,
        times,
        stopped=lambda: asked.append(time.thread_time()) or False,
    )
    assert np.diff(asked).max() < 0.2


@pytest.mark.parametrize("threads", [1, 2])
def test_an_interrupt_gets_through(threads):
    import _thread

    program = Program(Cone(), "states", 1e-15)
    program.run(cone_numbers(), [[1.0, 0.0]], 0.0, [[1.0]])
    alive = threading.active_count()
    threading.Timer(0.2, _thread.interrupt_main).start()
    before = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        program.run(cone_numbers(), np.tile([1.0, 0.0], (20, 1)), 0.0, np.full((20, 1), 1e9), threads=threads)
    assert time.perf_counter() - before < 0.2 + 0.25
    time.sleep(0.05)
    assert threading.active_count() <= alive
