"""Jobs in parallel processes: first those that need no others, and of these the long ones.

Processes and not threads, because drawing and the reading of evidence hold Python's lock. Progress, errors and
interrupts are passed back to the caller.
"""

from __future__ import annotations

import multiprocessing
import pickle
import signal
import threading
import time
import traceback
from collections.abc import Callable, Collection, Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Any, cast

Progress = Callable[[str, float], None]
"""Takes what is being worked on, and the share of the whole work that was just done."""

WORTH_A_PROCESS = 4.0
"""Work that justifies starting one more process, in the unit of `Job.work`: about a second."""
REPORT_EVERY = 0.1
PATIENCE = 5.0
"""Seconds that a process has to clean up when it is asked to stop."""


@dataclass(frozen=True)
class Job:
    """A job: ``call`` takes the results of the jobs in ``needs``, by name, and a callback for shares done.

    It can be pickled, and so can its result. ``work`` is its cost relative to others.
    """

    name: str
    label: str
    work: float
    needs: frozenset[str]
    call: Callable[[Mapping[str, Any], Callable[[float], None]], Any]


def do(jobs: Sequence[Job], workers: int, progress: Progress) -> Generator[tuple[str, Any]]:
    """Does all jobs in up to ``workers`` processes, or in this one where more are not worth it; yields the name and the
    result of each job as it finishes."""
    whole = sum(job.work for job in jobs)
    workers = min(workers, len(jobs), int(whole / WORTH_A_PROCESS))

    def report(job: Job, share: float) -> None:
        progress(job.label, share * job.work / whole)

    open_ = sorted(jobs, key=lambda job: (bool(job.needs), -job.work))
    return _in_processes(open_, workers, report) if workers > 1 else _here(open_, report)


Report = Callable[[Job, float], None]


def _here(open_: list[Job], report: Report) -> Generator[tuple[str, Any]]:
    done: dict[str, Any] = {}
    while (job := _next(open_, done)) is not None:
        report(job, 0.0)
        done[job.name] = job.call(_given(job, done), lambda share, job=job: report(job, share))  # type: ignore[misc]
        yield job.name, done[job.name]


def _next(open_: list[Job], done: Collection[str]) -> Job | None:
    """Removes and returns the first job on the list whose needs are all done; None if there is none."""
    ready = next((job for job in open_ if job.needs <= set(done)), None)
    if ready is not None:
        open_.remove(ready)
    return ready


def _given(job: Job, done: Mapping[str, Any]) -> dict[str, Any]:
    return {name: done[name] for name in job.needs}


def _in_processes(open_: list[Job], workers: int, report: Report) -> Generator[tuple[str, Any]]:
    done: dict[str, Any] = {}
    busy: dict[Any, Job] = {}
    with _processes(workers) as idle:
        while open_ or busy:
            while idle and (job := _next(open_, done)):
                connection = idle.pop()
                connection.send((job.call, _given(job, done)))
                busy[connection] = job
                report(job, 0.0)
            for ready in wait(list(busy)):
                job = busy[ready]
                message = _receive(ready, job)
                report(job, message.share)
                if message.error is not None:
                    raise message.error
                if message.is_done:
                    idle.append(cast(Connection, ready))
                    del busy[ready]
                    done[job.name] = message.result
                    yield job.name, message.result


@dataclass(frozen=True)
class _Message:
    """The ``share`` of a job that was just done; and when that is all of it, its result or the error that ended it."""

    share: float
    is_done: bool = False
    result: Any = None
    error: Exception | None = None


def _receive(connection: Any, job: Job) -> _Message:
    try:
        message: _Message = connection.recv()
    except EOFError:
        raise RuntimeError(f"{job.label}: its process has ended; was there enough memory?") from None
    return message


@contextmanager
def _processes(count: int) -> Iterator[list[Connection]]:
    """Connections to ``count`` processes that take jobs; in any case the processes have ended afterwards."""
    context = multiprocessing.get_context("spawn")
    pairs = [context.Pipe() for _ in range(count)]
    processes = [context.Process(target=_serve, args=(theirs,), daemon=True) for _, theirs in pairs]
    with _interrupts_ignored():  # also by the processes that start now: the caller handles interrupts
        for process in processes:
            process.start()
    for _, theirs in pairs:
        theirs.close()
    try:
        yield [ours for ours, _ in pairs]
    except BaseException:
        for process in processes:
            process.terminate()
        raise
    finally:
        for ours, _ in pairs:
            ours.close()
        for process in processes:
            process.join(PATIENCE)
            process.kill()


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():  # where signals cannot be set
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


# --- in a process of its own ------------------------------------------------------------------------------------------


def _serve(connection: Connection) -> None:
    """Does one job after the other until the other end closes or asks it to stop."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _stop)
    try:
        while True:
            call, given = connection.recv()
            reports = _Reports(connection)
            try:
                reports.close(result=call(given, reports))
            except Exception as error:
                reports.close(error=_portable(error))
    except (EOFError, OSError, KeyboardInterrupt):  # the other end is closed, or this process is asked to stop
        pass


def _stop(*_: Any) -> None:
    raise KeyboardInterrupt


def _portable(error: Exception) -> Exception:
    """The error as it can travel, with a note of where it was raised."""
    error.add_note(traceback.format_exc())
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(traceback.format_exc())
    return error


class _Reports:
    """Passes on the shares that a job reports, from any thread, but not more often than a progress bar can show."""

    def __init__(self, connection: Connection):
        self._connection, self._lock = connection, threading.Lock()
        self._pending, self._last = 0.0, 0.0

    def __call__(self, share: float) -> None:
        with self._lock:
            self._pending += share
            if time.monotonic() - self._last >= REPORT_EVERY:
                self._send()

    def close(self, result: Any = None, error: Exception | None = None) -> None:
        with self._lock:
            self._send(is_done=True, result=result, error=error)

    def _send(self, **more: Any) -> None:
        self._connection.send(_Message(self._pending, **more))
        self._pending, self._last = 0.0, time.monotonic()
