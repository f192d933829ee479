"""Jobs side by side in processes: order, results, progress, errors and interrupts."""

import os
import signal
import subprocess
import sys
import textwrap
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from types import SimpleNamespace

import pytest

from gelcone.errors import InputError, LostWorker
from gelcone.paper import work as module
from gelcone.paper.work import WORTH_A_PROCESS, Job, do


def add(number, given, progress):
    """Gives its number plus what it is given, and the process in which it ran."""
    progress(0.25)
    progress(0.75)
    return number + sum(value for value, _ in given.values()), os.getpid()


def refuse(given, progress):
    raise InputError("voltage = -1: must be at least 0")


def vanish(given, progress):
    os._exit(3)


def job(name, *needs, call=None, work=10.0):
    return Job(name, f"making {name}", work, frozenset(needs), call or partial(add, len(name)))


DIAMOND = [job("end", "left", "right"), job("left", "a"), job("right", "a"), job("a")]


@pytest.mark.parametrize("workers", [1, 2])
def test_jobs_come_after_what_they_need_and_get_it(workers):
    steps = []
    found = dict(do(DIAMOND, workers, lambda *step: steps.append(step)))
    assert {name: value for name, (value, _) in found.items()} == {"a": 1, "left": 5, "right": 6, "end": 14}
    assert next(iter(found)) == "a"
    assert list(found)[-1] == "end"
    assert sum(share for _, share in steps) == pytest.approx(1.0)
    assert {label for label, _ in steps} == {f"making {name}" for name in found}


def test_processes_are_others_only_where_they_pay():
    small = [job(name, work=WORTH_A_PROCESS / 5.0) for name in ("a", "bb")]
    assert {pid for _, (_, pid) in do(small, 2, lambda *_: None)} == {os.getpid()}
    large = [job(name) for name in ("a", "bb")]
    assert os.getpid() not in {pid for _, (_, pid) in do(large, 2, lambda *_: None)}


@pytest.mark.parametrize(("work", "wanted"), [(0.9, 0), (1.9, 1), (2.1, 2), (9.0, 3)])
def test_a_process_for_each_few_seconds_of_work(work, wanted, monkeypatch):
    """As many as the work is worth, and no more than jobs or workers."""
    asked = []
    monkeypatch.setattr(module, "_in_processes", lambda jobs, workers, report: asked.append(workers))
    jobs = [job(name, work=work * WORTH_A_PROCESS / 4.0) for name in ("a", "b", "c", "d")]
    do(jobs, 3, lambda *_: None)
    assert asked == ([wanted] if wanted > 1 else [])


def test_long_jobs_come_first():
    jobs = [job("short", work=1.0), job("long", work=3.0), job("middle", work=2.0)]
    assert [name for name, _ in do(jobs, 1, lambda *_: None)] == ["long", "middle", "short"]


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_comes_home_as_it_was(workers):
    with pytest.raises(InputError, match="must be at least 0"):
        list(do([job("bad", call=refuse), job("other", "bad")], workers, lambda *_: None))


def test_a_process_that_dies_is_an_error_and_not_a_wait_for_ever():
    refused = pytest.raises(InputError, match="making bad: ended its processes")
    with pytest.warns(LostWorker, match=r"ended with code 3; another takes over its task"), refused:
        list(do([job("bad", call=vanish), job("other")], 2, lambda *_: None))


SLOW_JOB = """
    import os
    import time
    from pathlib import Path

    def sleep(given, progress):
        Path(f"{os.getpid()}.pid").touch()
        try:
            time.sleep(30.0)
        finally:
            Path(f"{os.getpid()}.pid").unlink()
"""
SLOW = """
    from slow_job import sleep
    from gelcone.paper.work import Job, do

    jobs = [Job(name, name, 10.0, frozenset(), sleep) for name in "ab"]
    try:
        list(do(jobs, 2, lambda label, share: print(label, flush=True)))
    except KeyboardInterrupt:
        print("interrupted", flush=True)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals to a group of processes")
@pytest.mark.parametrize("send", [os.killpg, os.kill])
def test_an_interrupt_ends_all_processes_at_once_and_quietly(tmp_path, send):
    (tmp_path / "slow_job.py").write_text(textwrap.dedent(SLOW_JOB))
    script = tmp_path / "slow.py"
    script.write_text(textwrap.dedent(SLOW))
    run = subprocess.Popen(
        [sys.executable, script],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        cwd=tmp_path,
    )
    assert [run.stdout.readline() for _ in range(2)] == ["a\n", "b\n"]
    while len(pids := [int(path.stem) for path in tmp_path.glob("*.pid")]) < 2:
        time.sleep(0.05)
    begin = time.monotonic()
    send(run.pid, signal.SIGINT)
    out, errors = run.communicate(timeout=20)
    assert (out, errors) == ("interrupted\n", "")
    assert time.monotonic() - begin < 10.0
    for pid in pids:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)
    assert not list(tmp_path.glob("*.pid"))  # each had time to clean up


def test_as_many_jobs_run_at_once_as_there_are_workers(monkeypatch):
    """Whatever is ready: the pool is not given more."""
    pool, given = SimpleNamespace(threads=ThreadPoolExecutor(8), close=lambda: None), []

    def work(pool, job, *_):
        given.append(job.name)
        return job.name

    def waited(busy, *_):
        seen.append(len(busy))
        done = [future for future in busy if future.result()][:1]
        return done, None

    seen = []
    monkeypatch.setattr(module, "Pool", lambda workers: pool)
    monkeypatch.setattr(module, "_do", work)
    monkeypatch.setattr(module, "wait", waited)
    names = [name for name, _ in module._in_processes([job(name) for name in "abcde"], 2, lambda *_: None)]
    assert sorted(names) == sorted(given) == list("abcde")
    assert seen == [2, 2, 2, 2, 1]
    pool.threads.shutdown()
