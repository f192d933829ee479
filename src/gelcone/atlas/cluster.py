"""The workers of a running dask cluster, or processes of this machine under the same name."""

from __future__ import annotations

import json
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

from gelcone._version import __version__
from gelcone.atlas.processes import processes
from gelcone.atlas.workers import AHEAD, Answer, Task, Team, Workers, watched
from gelcone.errors import InputError, LostWorker, MissingDependency
from gelcone.files import read_text

CONNECT_SECONDS = 10
FEWEST_AHEAD = 64
"""Tasks given to a cluster at least, whose workers may come later."""


def cluster(workers: int | None = None, scheduler: str | None = None) -> Workers:
    """Processes of this machine, or the workers of the dask scheduler at an address; one integrator in each.

    Parameters
    ----------
    workers : number of processes of this machine.
    scheduler : address of a dask scheduler, such as ``"tcp://10.0.0.1:8786"``, or the scheduler file that it writes
        with ``--scheduler-file``; in place of ``workers``. A worker that is lost, and whose tasks others take over, is
        said in a `LostWorker` warning, as is a scheduler without workers, for which the run waits.

    Returns
    -------
    The ``workers`` of `gelcone.sweep`. They start with the sweep.

    Raises
    ------
    InputError : for fewer than 1 worker, both given or none; on entering, for an address where no scheduler answers or
        whose workers have another version of gelcone.
    MissingDependency : on entering a scheduler's, without dask.distributed (extra ``cluster``).

    Examples
    --------
    >>> import gelcone
    >>> plan = gelcone.Plan(gelcone.ConeModel(), {"voltage": [0.4, 0.8]})
    >>> cells = gelcone.sweep(plan, "limits", workers=gelcone.cluster(2))
    >>> cells.pitchfork_voltage.values.round(4).tolist()
    [1.2247, 1.2247]
    """
    if (workers is None) == (scheduler is None):
        raise InputError("workers and scheduler: give one of them")
    return processes(workers) if scheduler is None else _of_scheduler(scheduler)


def _of_scheduler(scheduler: str) -> Workers:
    @contextmanager
    def start() -> Iterator[Team]:
        distributed = _import_distributed()
        with _client(distributed, address := _address(scheduler)) as client:
            threads = client.nthreads()
            size = max(sum(threads.values()), 1)
            client.subscribe_topic("all", _Watched(threads, address))
            if not threads:
                warnings.warn(f"scheduler {address}: has no workers; {_waits(address)}", LostWorker, stacklevel=2)

            def run(function: Callable[[Task], Answer], tasks: Iterable[Task]) -> Iterator[tuple[Answer, int]]:
                futures = (client.submit(watched, function, task, pure=False) for task in tasks)
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


def _address(scheduler: str) -> str:
    """The address of a scheduler, read from its scheduler file where a file is named; waits until that is written."""
    path = Path(scheduler)
    if "://" in scheduler or not (path.suffix == ".json" or path.is_file()):
        return scheduler
    begun, remedy = time.monotonic(), f"start one with `dask scheduler --scheduler-file {scheduler}`"
    # a file that is being written is empty at first
    while not (path.is_file() and path.stat().st_size) and time.monotonic() - begun < CONNECT_SECONDS:
        time.sleep(0.1)
    try:
        address = json.loads(read_text(path, remedy))["address"]
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        address = None
    if not isinstance(address, str):
        raise InputError(f"scheduler {scheduler}: is not a scheduler file of dask; {remedy}")
    return address


def _waits(address: str) -> str:
    """Words for a run whose scheduler has no workers."""
    return f"the run waits for one: start it with `dask worker {address}`"


class _Watched:
    """Receives events of the workers of a scheduler at an address, and warns of lost workers."""

    def __init__(self, workers: Iterable[str], address: str) -> None:
        self._workers, self._address = set(workers), address

    def __call__(self, event: tuple[float, Any]) -> None:
        message = event[1] if isinstance(event[1], dict) else {}
        worker, action = str(message.get("worker")), message.get("action")
        if action == "add-worker":
            self._workers.add(worker)
        elif action == "remove-worker" and worker in self._workers:
            self._workers.discard(worker)
            if not message.get("expected", False):
                others = len(self._workers)
                taken = f"{others} left take over its tasks" if others else f"none is left; {_waits(self._address)}"
                warnings.warn(f"worker {worker} is lost; {taken}", LostWorker, stacklevel=2)


def _import_distributed() -> Any:
    try:
        import distributed
    except ImportError:
        raise MissingDependency("a scheduler needs dask.distributed: pip install 'gelcone[cluster]'") from None
    return distributed


@contextmanager
def _client(distributed: Any, scheduler: str) -> Iterator[Any]:
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
