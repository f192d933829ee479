"""Jobs in parallel processes: first those without needs, and of these the long ones.

Threads would not do, as drawing and reading evidence hold Python's lock. Progress, errors and interrupts are passed to
the caller.
"""

from __future__ import annotations

import queue
from collections.abc import Callable, Collection, Generator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import Any

from gelcone.atlas.processes import REPORT_EVERY, Pool, ProcessesEnded, portable
from gelcone.atlas.processes import report as report_share
from gelcone.errors import InputError

Progress = Callable[[str, float], None]
"""Called with the current job and the share of the whole work just done."""

WORTH_A_PROCESS = 4.0
"""Work that justifies one more process, in the unit of `Job.work`: about a second."""
Call = Callable[[Mapping[str, Any], Callable[[float], None]], Any]


@dataclass(frozen=True)
class Job:
    """A job: ``call`` takes the results of the jobs in ``needs``, by name, and a callback for shares done.

    Job and result can be pickled. ``work`` is its relative cost.
    """

    name: str
    label: str
    work: float
    needs: frozenset[str]
    call: Call


def do(jobs: Sequence[Job], workers: int, progress: Progress) -> Generator[tuple[str, Any]]:
    """Runs all jobs in up to ``workers`` processes, or in this one if more are not worth it; yields the name and the
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
    """Removes and returns the first job on the list whose needs are all done; None without one."""
    ready = next((job for job in open_ if job.needs <= set(done)), None)
    if ready is not None:
        open_.remove(ready)
    return ready


def _given(job: Job, done: Mapping[str, Any]) -> dict[str, Any]:
    return {name: done[name] for name in job.needs}


def _in_processes(open_: list[Job], workers: int, report: Report) -> Generator[tuple[str, Any]]:
    done: dict[str, Any] = {}
    busy: dict[Future[Any], Job] = {}
    shares: queue.SimpleQueue[tuple[Job, float]] = queue.SimpleQueue()
    with closing(Pool(workers)) as pool:
        while open_ or busy:
            while len(busy) < workers and (job := _next(open_, done)):
                busy[pool.threads.submit(_do, pool, job, _given(job, done), shares)] = job
                report(job, 0.0)
            finished, _ = wait(busy, REPORT_EVERY, FIRST_COMPLETED)
            while not shares.empty():
                report(*shares.get())
            for future in finished:
                job = busy.pop(future)
                done[job.name] = future.result()
                yield job.name, done[job.name]


def _do(pool: Pool, job: Job, given: dict[str, Any], shares: queue.SimpleQueue[tuple[Job, float]]) -> Any:
    """The result of a job, run in a worker process, or in this one if it needs definitions of the running script."""

    def tell(share: float) -> None:
        shares.put((job, share))

    content = portable(partial(_called, job.call))
    if content is None:
        return job.call(given, tell)
    try:
        return pool.do(content, given, tell)[0]
    except ProcessesEnded:
        raise InputError(
            f"{job.label}: ended its processes, one after the other: they may run out of memory; end other programs or "
            "give `run` fewer workers; the next run continues from there"
        ) from None


def _called(call: Call, given: dict[str, Any]) -> Any:
    return call(given, report_share)
