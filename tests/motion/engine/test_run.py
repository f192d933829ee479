"""Runs: progress adds up, and one that is to stop, or is interrupted, does so soon."""

import threading
import time
from dataclasses import dataclass

import numpy as np
import pytest
from engine_systems import Cone, cone_numbers

from gelcone.motion.engine import run as runs
from gelcone.motion.engine.events import Event
from gelcone.motion.engine.plan import ARRIVED
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


def started(count, start, end):
    """A run of one thread on members that it has not finished, and its work."""
    program = Program(Cone(), "states", 1e-10, width=2)
    compiled = program._compile(2)
    numbers = cone_numbers(voltage=np.linspace(0.5, 1.0, count))
    arrays = compiled.job(numbers, np.tile([0.7, 0.0], (count, 1)), start, np.full((count, 1), end), 0.0, 1e9, None)
    run = runs.Run(compiled, arrays, 1, None, None)
    run._works[0].start()
    return run, run._works[0], arrays


def test_the_share_that_is_done_is_the_mean_of_the_members_shares_of_their_time():
    run, work, arrays = started(5, 1000.0, 1040.0)
    assert run._share_done() == pytest.approx(0.0, abs=1e-12)
    seen = []
    while work.going:
        work.advance(5)
        shares = np.where(arrays.status >= 0, 1.0, 0.0)
        for member, moment in work.under_way():
            assert arrays.status[member] < 0
            shares[member] = (moment - 1000.0) / 40.0
        assert run._share_done() == pytest.approx(shares.mean(), abs=1e-12)
        seen.append(shares.mean())
    assert seen == sorted(seen)
    assert 0.0 < seen[0] < 0.5
    assert seen[-1] == 1.0


@dataclass(frozen=True)
class Sided:
    """x' = 1 on either side of a border that is far away."""

    states = ("x",)
    numbers = ("s",)

    def rates(self, time, state, n, xp):
        return [1.5 - 0.5 * n["s"] + 0.0 * state[0] + 1e-6 * xp.sin(50.0 * time)]


def test_those_under_way_are_those_in_lanes_and_those_that_wait_for_one():
    event = Event(lambda t, z, n, xp: n["s"] * (1e6 - z[0]), -1, "s", divides=True)
    program = Program(Sided(), "states", 1e-6, [event], width=2)
    compiled, ends = program._compile(2), np.array([[9.0], [1.0], [2.0], [3.0], [9.0], [9.0]])
    arrays = compiled.job({"s": np.ones(6)}, np.zeros((6, 1)), 0.0, ends, 0.0, 1e9, None)
    compiled.compile_step(0)
    work = runs.Work(compiled, arrays.fields(6))
    work.start()
    while work.going:
        under = sorted(member for member, _ in work.under_way())
        np.testing.assert_array_equal(under, np.flatnonzero(arrays.status < 0))
        work.advance(3)
    assert (arrays.status == ARRIVED).all()


def test_a_run_that_was_stopped_does_not_report_the_rest():
    told = []
    program = Program(Cone(), "states", 1e-10)
    program.run(
        cone_numbers(),
        np.tile([1.0, 0.0], (20, 1)),
        0.0,
        np.full((20, 1), 1e9),
        report=told.append,
        stopped=lambda: True,
    )
    assert sum(told) < 0.5


def test_a_thread_takes_over_code_that_was_made_meanwhile_and_counts_its_time(monkeypatch):
    """Of calls that ran; not of those in which a step was missing."""
    event = Event(lambda t, z, n, xp: n["s"] * (1e6 - z[0]), -1, "s", divides=True)
    compiled = Program(Sided(), "states", 1e-6, [event], width=2)._compile(2)
    arrays = compiled.job({"s": np.ones(2)}, np.zeros((2, 1)), 0.0, np.full((2, 1), 9.0), 0.0, 1e9, None)
    work, counted = runs.Work(compiled, arrays.fields(2)), []
    monkeypatch.setattr(compiled, "has_run", counted.append)
    own = slice(work._compiled.layout.code, work._compiled.layout.missing)
    assert not work._words[own][:-1].any()
    work.start()
    work.advance(3)
    assert counted == []
    assert work._words[own].tolist() == compiled.addresses
    assert work._words[own][:-1].any()
    before = time.perf_counter()
    work.advance(3)
    assert 0.0 < counted[0] <= time.perf_counter() - before
    monkeypatch.setattr(compiled, "has_run", lambda seconds: setattr(compiled, "addresses", compiled.addresses[::-1]))
    work.advance(0)
    assert work._words[own].tolist() == compiled.addresses
