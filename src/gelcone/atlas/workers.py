"""Workers that do the tasks of a sweep, and threads of this process as such.

Workers are context managers that give a `Team`: `threads`, `gelcone.atlas.processes`, `gelcone.atlas.cluster`. The
numbers do not depend on the kind of workers.
"""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from itertools import islice
from typing import Protocol, TypeVar

from gelcone.motion.flow import available_threads
from gelcone.progress import Stopped, Watch, watching
from gelcone.quantity import ALL_CORES, check_count

Task = TypeVar("Task")
Answer = TypeVar("Answer")
AHEAD = 4
"""Tasks that each worker is given ahead of time: it never waits, and the memory does not grow with the sweep."""
WAKE_EVERY = 0.25
"""Seconds after which a wait for answers lets an interrupt through."""


class Run(Protocol):
    """Does tasks in parallel, and gives each answer with its number of integration steps, in any order."""

    def __call__(self, function: Callable[[Task], Answer], tasks: Iterable[Task]) -> Iterator[tuple[Answer, int]]: ...


@dataclass(frozen=True)
class Team:
    """The number of workers, ``size``, and ``run(function, tasks)``, an iterator over the answers as they come."""

    size: int
    run: Run


Workers = Callable[[], AbstractContextManager[Team]]


def threads(count: int | None = None) -> Workers:
    """Threads of this process, by default one a core. Leaving the context stops them within moments."""
    if count is not None:
        check_count("threads", count, 1, ALL_CORES)

    @contextmanager
    def start() -> Iterator[Team]:
        stop, size = threading.Event(), count or available_threads()
        pool = ThreadPoolExecutor(size)

        def run(function: Callable[[Task], Answer], tasks: Iterable[Task]) -> Iterator[tuple[Answer, int]]:
            return as_they_come(pool, size, lambda task: watched(function, task, stop), tasks, stop)

        try:
            yield Team(size, run)
        finally:
            stop.set()
            pool.shutdown(cancel_futures=True)

    return start


def as_they_come(
    pool: ThreadPoolExecutor,
    size: int,
    function: Callable[[Task], Answer],
    tasks: Iterable[Task],
    left: threading.Event,
) -> Iterator[Answer]:
    """Answers of ``size`` threads as they come; tasks are taken a little ahead.

    Raises `Stopped` once ``left`` is set, which happens before the pool shuts down.
    """
    ended: queue.SimpleQueue[Future[Answer]] = queue.SimpleQueue()
    ahead = iter(tasks)

    def give(most: int) -> int:
        futures = [_given(pool, function, task, left) for task in islice(ahead, most)]
        for future in futures:
            future.add_done_callback(ended.put)
        return len(futures)

    waiting = give(AHEAD * size)
    while waiting:
        future = _next(ended)  # `concurrent.futures.wait` would never return for futures that the pool has cancelled
        waiting += give(1) - 1
        try:
            answer = future.result()
        except CancelledError:
            raise Stopped from None
        yield answer


def _next(ended: queue.SimpleQueue[Future[Answer]]) -> Future[Answer]:
    """The next future. It wakes up for interrupts: one just before a wait does not end it."""
    while True:
        with suppress(queue.Empty):
            return ended.get(timeout=WAKE_EVERY)


def _given(
    pool: ThreadPoolExecutor, function: Callable[[Task], Answer], task: Task, left: threading.Event
) -> Future[Answer]:
    try:
        return pool.submit(function, task)
    except RuntimeError:
        if left.is_set():
            raise Stopped from None
        raise


def watched(function: Callable[[Task], Answer], task: Task, stop: threading.Event | None = None) -> tuple[Answer, int]:
    """The answer to a task and its number of integration steps; raises `Stopped` once ``stop`` is set."""
    watch = Watch(stop) if stop is not None else Watch()
    with watching(watch):
        return function(task), watch.steps
