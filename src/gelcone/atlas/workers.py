"""Who does the tasks of a sweep: threads of this process, processes of this machine, or a running dask cluster.

Each is a context manager that gives a `Team`. The numbers do not depend on who computes them.
"""

from __future__ import annotations

import logging
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from itertools import islice
from typing import Any, Protocol, TypeVar

from gelcone._version import __version__
from gelcone.errors import InputError, MissingDependency
from gelcone.motion.flow import available_threads
from gelcone.progress import Watch, watching

Task = TypeVar("Task")
Answer = TypeVar("Answer")
CONNECT_SECONDS = 10
AHEAD = 4
"""Tasks that each worker is given ahead of time: it never waits, and what is in memory does not grow with the sweep."""
END_NOW = getattr(signal, "SIGKILL", signal.SIGTERM)
"""The signal that ends a process at once; on Windows, which has no SIGKILL, SIGTERM does."""
FEWEST_AHEAD = 64
"""Tasks given to a cluster at least, whose workers may come later."""


class Run(Protocol):
    """Does tasks side by side; gives each answer with the integrator's steps behind it, in any order."""

    def __call__(self, function: Callable[[Task], Answer], tasks: Iterable[Task]) -> Iterator[tuple[Answer, int]]: ...


@dataclass(frozen=True)
class Team:
    """``size``, how many work side by side, and ``run(function, tasks)``, an iterator over the results as they come."""

    size: int
    run: Run


Workers = Callable[[], AbstractContextManager[Team]]


def threads(count: int | None = None) -> Workers:
    """Threads of this process; by default one a core. Leaving the context stops them within moments."""
    if count is not None and not (isinstance(count, int) and count >= 1):
        raise InputError(f"threads = {count!r}: must be at least 1; leave it out to use all cores")

    @contextmanager
    def start() -> Iterator[Team]:
        stop, size = threading.Event(), count or available_threads()
        pool = ThreadPoolExecutor(size)

        def run(function: Callable[[Task], Answer], tasks: Iterable[Task]) -> Iterator[tuple[Answer, int]]:
            futures = (pool.submit(_watched, function, task, stop) for task in tasks)
            given = set(islice(futures, AHEAD * size))
            while given:
                done, given = wait(given, return_when=FIRST_COMPLETED)
                given.update(islice(futures, len(done)))
                while done:
                    yield done.pop().result()

        try:
            yield Team(size, run)
        finally:
            stop.set()
            pool.shutdown(cancel_futures=True)

    return start


def cluster(workers: int | None = None, scheduler: str | None = None) -> Workers:
    """Processes of this machine, or the workers of the dask scheduler at an address; one integrator in each.

    Raises
    ------
    InputError : for fewer than 1 worker, both given or none; on entering, for an address where no scheduler answers or
        whose workers have another version of gelcone.
    MissingDependency : on entering, without dask.distributed (extra ``cluster``).
    """
    if (workers is None) == (scheduler is None):
        raise InputError("workers and scheduler: give one of them")
    if workers is not None and workers < 1:
        raise InputError(f"workers = {workers}: must be at least 1")

    @contextmanager
    def start() -> Iterator[Team]:
        distributed = _import_distributed()
        with _client(distributed, workers, scheduler) as client:
            size = max(sum(client.nthreads().values()), 1)

            def run(function: Callable[[Task], Answer], tasks: Iterable[Task]) -> Iterator[tuple[Answer, int]]:
                futures = (client.submit(_watched, function, task, pure=False) for task in tasks)
                given = set(islice(futures, max(AHEAD * size, FEWEST_AHEAD)))
                try:
                    done = distributed.as_completed(given)
                    for future in done:
                        yield _result(distributed, future)
                        given.remove(future)
                        for further in islice(futures, 1):
                            given.add(further)
                            done.add(further)
                finally:
                    client.cancel(list(given))

            yield Team(size, run)

    return start


def _watched(function: Callable[[Task], Answer], task: Task, stop: threading.Event | None = None) -> tuple[Answer, int]:
    watch = Watch(stop) if stop is not None else Watch()
    with watching(watch):
        return function(task), watch.steps


def _import_distributed() -> Any:
    try:
        import distributed
    except ImportError:
        raise MissingDependency(
            "workers and schedulers need dask.distributed: pip install 'gelcone[cluster]'"
        ) from None
    return distributed


@contextmanager
def _client(distributed: Any, workers: int | None, scheduler: str | None) -> Iterator[Any]:
    if scheduler is None:
        options = {"threads_per_worker": 1, "dashboard_address": "127.0.0.1:0", "silence_logs": "CRITICAL"}
        with (
            distributed.LocalCluster(n_workers=workers, processes=True, **options) as local,
            distributed.Client(local) as client,
        ):
            try:
                yield client
            except BaseException:
                _end_now(local)
                raise
        return
    try:
        client = distributed.Client(scheduler, timeout=CONNECT_SECONDS)
    except (OSError, ValueError, TimeoutError):
        raise InputError(
            f"scheduler {scheduler}: does not answer; start one with `dask scheduler` and give its address, "
            "for example tcp://localhost:8786"
        ) from None
    with client:
        _check_versions(client, scheduler)
        yield client


def _end_now(local: Any) -> None:
    """Ends the processes of a local cluster without waiting for their tasks or for what their connections say."""
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    for nanny in list(local.workers.values()):
        nanny.auto_restart = False
        if nanny.pid is not None:
            with suppress(ProcessLookupError):
                os.kill(nanny.pid, END_NOW)


def _check_versions(client: Any, scheduler: str) -> None:
    try:
        versions = set(client.run(_version).values())
    except ModuleNotFoundError:
        versions = {"no gelcone"}
    if versions - {__version__}:
        theirs = ", ".join(sorted(versions))
        raise InputError(f"scheduler {scheduler}: its workers have {theirs}, here is {__version__}; install the same")


def _version() -> str:
    return __version__


def _result(distributed: Any, future: Any) -> Any:
    try:
        return future.result()
    except distributed.KilledWorker:
        raise InputError(
            "a task ended several workers, one after the other: they may run out of memory; start fewer on a machine. "
            "What the store holds is safe: continue with --resume"
        ) from None
