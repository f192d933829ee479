"""Processes of this machine: the same bits, errors that come back, nobody left behind, no guard around the script."""

import copyreg
import io
import json
import math
import os
import pickle
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from gelcone import disk_cache
from gelcone.atlas import processes as module
from gelcone.atlas import sweep as sweeping
from gelcone.atlas.plan import Plan
from gelcone.atlas.processes import LARGE, processes, usual_workers
from gelcone.atlas.sweep import sweep
from gelcone.errors import InputError, LostWorker
from gelcone.physics.model import ConeModel
from gelcone.progress import Stopped

MODEL = ConeModel(damping_ratio=0.1, spring_stiffness=0.5, drive_frequency=0.3)
BLAS = "OPENBLAS_NUM_THREADS"
QUICK = {"transient": 100.0, "budget": 200.0, "patience": 1.0}
PLAN = Plan(MODEL, {"voltage": np.linspace(0.0, 1.2, 6), "prestretch": np.linspace(0.8, 1.6, 5)}, options=QUICK)


def started(monkeypatch):
    """The processes that are started from now on, as they come."""
    found, start = [], module._start
    monkeypatch.setattr(module, "_start", lambda: found.append(start()) or found[-1])
    return found


@pytest.mark.slow
def test_processes_give_the_same_bits_also_when_one_dies_and_none_is_left(monkeypatch):
    monkeypatch.setattr(sweeping, "TASK_CELLS", 5)
    team = started(monkeypatch)

    def kill(tally):
        if len(team) == 2:
            team[0].kill()

    with pytest.warns(LostWorker, match=r"process \d+ ended( by signal 9)?; another takes over its task"):
        result = sweep(PLAN, workers=processes(2), watch=kill)
    assert len(team) == 3
    assert all(process.poll() is not None for process in team)
    alone = sweep(PLAN, threads=1)
    xr.testing.assert_identical(result.drop_attrs(deep=False), alone.drop_attrs(deep=False))
    steps = [json.loads(found.attrs["totals"])["integrator_steps"] for found in (result, alone)]
    assert steps[0] == steps[1] > 0


@pytest.mark.parametrize(("given", "expected"), [(None, "1"), ("3", "3")])
def test_a_process_has_one_thread_of_blas_unless_others_are_asked_for(given, expected, monkeypatch):
    monkeypatch.delenv(BLAS, raising=False)
    if given:
        monkeypatch.setenv(BLAS, given)
    with processes(1)() as one:
        assert next(one.run(os.getenv, [BLAS])) == (expected, 0)


@pytest.mark.parametrize(("code", "words"), [(-9, " by signal 9"), (3, " with code 3"), (None, "")])
def test_how_a_process_ended_is_said(code, words, monkeypatch):
    ended = SimpleNamespace(pid=7, poll=lambda: code, wait=lambda seconds: code, kill=lambda: None)
    monkeypatch.setattr(module, "_start", lambda: ended)
    monkeypatch.setattr(module, "_close", lambda process: None)
    with pytest.warns(LostWorker, match=f"^process 7 ended{words}; another takes over its task$"):
        module.Process()._restart()


def test_errors_come_back_and_a_task_that_ends_its_processes_is_given_up(monkeypatch):
    team = started(monkeypatch)
    with processes(1)() as one:
        with pytest.raises(ValueError, match="domain"):
            next(one.run(math.sqrt, [-1.0]))
        assert next(one.run(math.sqrt, [4.0])) == (2.0, 0)
        assert next(one.run(partial(os.write, 1), [b"printed\n"])) == (8, 0)  # between the answers nothing else is sent
        assert next(one.run(eval, ["__import__('sys').path"]))[0] == [str(entry) for entry in sys.path]
        ended = pytest.raises(InputError, match=r"a task ended 2 processes, one after the other.*--resume")
        with pytest.warns(LostWorker, match=r"process \d+ ended"), ended:
            next(one.run(os._exit, [3]))
    assert len(team) == 3


def test_a_process_that_is_still_going_is_ended_before_another_takes_its_place(monkeypatch):
    """None does once the processes were asked to end."""
    told = []

    def wait(seconds):
        raise subprocess.TimeoutExpired("python", seconds)

    going = SimpleNamespace(pid=7, poll=lambda: None, wait=wait)
    going.kill, going.terminate = (partial(told.append, name) for name in ("killed", "asked to end"))
    monkeypatch.setattr(module, "_start", lambda: told.append("started") or going)
    monkeypatch.setattr(module, "_close", lambda process: told.append("closed"))
    own = module.Process()
    with pytest.warns(LostWorker, match="^process 7 ended; another takes over its task$"):
        own._restart()
    assert told == ["started", "killed", "closed", "started"]
    own.stop()
    with pytest.raises(Stopped):
        own._restart()
    assert told[4:] == ["asked to end"]


@pytest.mark.parametrize(("left", "waits"), [(0.25, 0.25), (-1.0, 0.0)])
def test_a_process_has_the_time_that_is_left_to_clean_up_and_is_then_killed(left, waits):
    told = []

    def wait(timeout=None):
        told.append(timeout)
        if timeout is not None:
            raise subprocess.TimeoutExpired("python", timeout)

    own = module.Process.__new__(module.Process)
    pipes = {name: io.BytesIO() for name in ("stdin", "stdout")}
    own._process = SimpleNamespace(wait=wait, kill=lambda: told.append("killed"), **pipes)
    own.end(left)
    assert told == [waits, "killed", None]
    assert all(pipe.closed for pipe in pipes.values())


class Unreadable(Exception):
    """An error that another process cannot make."""

    def __init__(self, one, other):
        super().__init__(f"{one} and {other}")


def unreadable(task):
    raise Unreadable(task, "more")


def test_an_error_comes_back_with_its_traceback_and_in_words_where_it_cannot_be_read(monkeypatch):
    # dask, where a test has loaded it, pickles the errors that it knows in its own way
    monkeypatch.delitem(copyreg.dispatch_table, Unreadable, raising=False)

    def answered(function, task):
        return pickle.loads(module._answer(pickle.dumps((pickle.dumps(function), task))))

    error, answer = answered(math.sqrt, -1.0)
    assert (type(error), answer) == (ValueError, None)
    assert "Traceback" in error.__notes__[0]
    assert "math domain error" in error.__notes__[0]
    error, answer = answered(unreadable, 3)
    assert (type(error), str(error), answer) == (RuntimeError, "Unreadable('3 and more')", None)
    assert answered(math.sqrt, 4.0) == (None, (2.0, 0))


def test_shares_of_work_are_summed_up_between_two_reports(monkeypatch):
    """Not more often than a bar can show; the last one always, unless nothing is left to say."""
    sent, now = io.BytesIO(), [100.0]
    monkeypatch.setattr(module, "_answers", sent, raising=False)
    monkeypatch.setattr(module.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(module, "_pending", 0.0)
    monkeypatch.setattr(module, "_reported", 0.0)
    for passed, share in ((0.0, 0.25), (0.05, 0.125), (0.04, 0.0625), (0.02, 0.25), (0.01, 0.03125)):
        now[0] += passed
        module.report(share)
    module.report(0.0, last=True)
    module.report(0.0, last=True)
    sent.seek(0)
    found = []
    while sent.tell() < len(sent.getvalue()):
        found.append(pickle.load(sent))
    assert found == [0.25, 0.125 + 0.0625 + 0.25, 0.03125]


def inside():
    return disk_cache.made("inner", 1, bytes, ())


def twice():
    return inside() + inside()


def refused():
    raise InputError("refused")


def after_an_error(_):
    try:
        disk_cache.made("refused", 1, refused, ())
    except InputError:
        return inside()


def reporting(shares):
    for share in shares:
        module.report(share)


def kind_of_workers(cells):
    module.available_threads = lambda: 2
    return kind(usual_workers(cells))


def test_what_a_process_makes_and_how_far_it_is_is_heard_here(monkeypatch):
    """The last share too, which comes sooner after the one before than a bar can show."""
    monkeypatch.setenv(disk_cache.VARIABLE, "")
    pool, heard, shares = module.Pool(1), [], []
    monkeypatch.setattr(module, "Pool", lambda size: pool)

    @contextmanager
    def hear(kind):
        heard.append(f"{kind} begins")
        try:
            yield
        finally:
            heard.append(f"{kind} ends")

    make = partial(disk_cache.made, make=bytes, sources=())
    with disk_cache.heard(hear), processes(1)() as one:
        assert next(one.run(partial(make, "code"), [7])) == (b"", 0)
        assert heard == ["code begins", "code ends"]
        heard.clear()
        next(one.run(partial(disk_cache.made, "outer", make=twice, sources=()), [7]))
        assert heard == ["outer begins", *["inner begins", "inner ends"] * 2, "outer ends"]
        heard.clear()
        pool.do(module.portable(reporting), [0.25, 0.5, 0.125, 0.0625, 0.0625], shares.append)
        assert (sum(shares), heard) == (1.0, [])
        next(one.run(after_an_error, [7]))
        assert next(one.run(kind_of_workers, [LARGE]))[0] == "threads"  # a process starts no others
        assert heard == ["refused begins", "refused ends", "inner begins", "inner ends"]
        heard.clear()
        with pytest.warns(LostWorker), pytest.raises(InputError):
            next(one.run(partial(disk_cache.made, "code", make=os.abort, sources=()), [7]))
        assert heard == ["code begins", "code ends"] * 2


def test_what_the_script_defines_is_done_by_threads(monkeypatch):
    def own(_):
        return os.getpid()

    command, pipe = [sys.executable, "-S", "-c", "pass"], subprocess.PIPE
    monkeypatch.setattr(module, "_start", lambda: subprocess.Popen(command, stdin=pipe, stdout=pipe))
    with processes(2)() as team:
        assert list(team.run(own, range(3))) == [(os.getpid(), 0)] * 3
    own.__module__, own.__qualname__ = "__main__", "own"
    monkeypatch.setattr(sys.modules["__main__"], "own", own, raising=False)
    assert module.portable(own) is None
    assert module.portable(math.sqrt) is not None


def kind(workers):
    return workers.__qualname__.split(".")[0]


def test_large_work_is_done_by_processes_unless_somebody_says_otherwise(monkeypatch):
    monkeypatch.setattr(module, "available_threads", lambda: 2)
    assert [kind(usual_workers(cells)) for cells in (LARGE - 1, LARGE)] == ["threads", "processes"]
    assert kind(usual_workers(LARGE, 2)) == "threads"
    with usual_workers(LARGE, 3)() as team:
        assert team.size == 3
    monkeypatch.setattr(module, "_serving", True)
    assert kind(usual_workers(LARGE)) == "threads"
    monkeypatch.setattr(module, "_serving", False)
    monkeypatch.setattr(module, "available_threads", lambda: 1)
    assert kind(usual_workers(LARGE)) == "threads"


SCRIPT = """
import os, sys, time
from gelcone.atlas.processes import processes
print("begun", flush=True)
with processes(2)() as team:
    asked = "(__import__('time').sleep(0.5), __import__('os').getpid())[1]"
    print(*{pid for pid, _ in team.run(eval, [asked] * 2)})
    print("ready", flush=True)
    list(team.run(time.sleep, [60.0] * 2))
"""


def gone(pid):
    """Whether a process has ended; one that nobody has asked for yet counts."""
    try:
        with open(f"/proc/{pid}/stat") as stat:
            return stat.read().rsplit(")", 1)[1].split()[0] == "Z"
    except FileNotFoundError:
        return True


@pytest.mark.skipif(not os.path.isdir("/proc"), reason="asks the kernel which processes there are")
@pytest.mark.parametrize("sign", [signal.SIGKILL, signal.SIGINT])
def test_a_script_runs_once_and_leaves_no_process_behind(tmp_path, sign):
    """Without ``if __name__ == "__main__"``; killed, or interrupted, in the middle of tasks."""
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    command, pipe = [sys.executable, script], subprocess.PIPE
    found = os.environ | {"PYTHONPATH": str(Path(module.__file__).parents[2])}
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, env=found) as parent:
        assert parent.stdout.readline() == "begun\n"
        pids = [int(pid) for pid in parent.stdout.readline().split()]
        assert parent.stdout.readline() == "ready\n"
        assert len(pids) == 2
        assert not any(gone(pid) for pid in pids)
        parent.send_signal(sign)
        parent.communicate(timeout=20.0)
    until = time.monotonic() + 20.0
    while not all(gone(pid) for pid in pids) and time.monotonic() < until:
        time.sleep(0.02)
    assert all(gone(pid) for pid in pids)


def test_a_worker_starts_without_what_its_tasks_may_not_need():
    heavy = {"llvmlite", "matplotlib", "netCDF4", "scipy", "xarray", "zarr"}
    code = f"import sys, gelcone.atlas.processes; print(sorted({heavy!r} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
