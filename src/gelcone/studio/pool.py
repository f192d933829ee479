"""Worker processes for long work, so that sliders stay fast; cancelled work stops within moments.

A lane is a number for a page's work of one kind; each new run in a lane cancels the run before. Workers read the lanes'
run numbers from a file that they and the studio map into memory. They end with the pool, or when the process that
started them is gone.
"""

from __future__ import annotations

import asyncio
import os
import pickle
import threading
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import cache, lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from gelcone import permission
from gelcone.atlas import processes
from gelcone.motion.flow import available_threads
from gelcone.progress import Stopped, Watch, watching

LANES = 256
NICENESS = 10
PATIENCE = 0.5
"""Seconds that workers get to end by themselves; as background processes they may have to wait for a busy machine."""
LOOK_SECONDS = 0.02
"""Interval at which a worker checks whether its task is outdated."""


class Busy(RuntimeError):
    """All lanes are in use."""


class Pool:
    """Worker processes, started when first needed. ``background`` workers run at low priority; beyond what ships,
    workers follow only ``names``, see `gelcone.permission`."""

    def __init__(
        self, size: int | None = None, *, background: bool = True, names: frozenset[str] = frozenset()
    ) -> None:
        self.size, self.background, self.names = size or available_threads(), background, names
        self._folder = TemporaryDirectory(prefix="gelcone-studio-", ignore_cleanup_errors=True)
        self._path = str(Path(self._folder.name) / "lanes")
        np.zeros(LANES).tofile(self._path)
        self._board = _board(self._path)
        self._free = list(range(LANES))
        self._processes: processes.Pool | None = None

    def lane(self) -> int:
        """A free lane; `Busy` if all are in use."""
        if not self._free:
            raise Busy("too many open pages; close a browser tab")
        return self._free.pop()

    def leave(self, lane: int) -> None:
        """Cancels the run in a lane and returns the lane."""
        self.begin(lane)
        self._free.append(lane)

    def begin(self, lane: int) -> int:
        """Cancels the run in a lane, and returns the number of its next run."""
        self._board[lane] += 1
        return int(self._board[lane])

    async def do(self, lane: int, run: int, function: Callable[..., Any], *arguments: Any) -> Any:
        """The result of ``function(*arguments)`` in a worker; None if the run is outdated. Raises the function's
        errors, and `ProcessesEnded`."""
        pool, task = self._started(), self._task(lane, run, function, arguments)
        asked = asyncio.wrap_future(pool.threads.submit(_do, pool, task))
        asked.add_done_callback(lambda done: done.cancelled() or done.exception())
        return await asyncio.shield(asked)  # a cancelled caller leaves the task running; its lane stops it

    def warm(self, function: Callable[[], None]) -> None:
        """Starts the workers, unless they run, and makes them import the module of a function."""
        if self._processes is None:
            pool = self._started()
            for _ in range(self.size):
                pool.threads.submit(_do, pool, self._task(0, int(self._board[0]), function, ()))

    def _task(self, lane: int, run: int, function: Callable[..., Any], arguments: tuple[Any, ...]) -> _Task:
        return _Task(self._path, self.background, self.names, lane, run, function, arguments)

    def _started(self) -> processes.Pool:
        if self._processes is None:
            self._processes = processes.Pool(self.size)
        return self._processes

    def close(self) -> None:
        """Ends the workers, even in the middle of a task."""
        self._board[:] += 1
        if self._processes is not None:
            self._processes.close(PATIENCE)
        self._folder.cleanup()


def _do(pool: processes.Pool, task: _Task) -> Any:
    try:
        return pool.do(pickle.dumps(work), task)[0]
    except Stopped:  # the pool is closed
        return None


@lru_cache(maxsize=4)
def _board(path: str) -> Any:
    """The memory shared by the studio and its workers: the run number of each lane."""
    return np.memmap(path, dtype=float, mode="r+", shape=(LANES,))


# --- in the workers --------------------------------------------------------------------------------------------------


class _Task(NamedTuple):
    path: str
    background: bool
    names: frozenset[str]
    lane: int
    run: int
    function: Callable[..., Any]
    arguments: tuple[Any, ...]


@cache
def _begin(background: bool) -> None:
    """Prepares a worker, once in its life."""
    warnings.simplefilter("ignore")  # the page shows these doubts itself
    with suppress(OSError, AttributeError):
        os.nice(NICENESS if background else 0)


def work(task: _Task) -> Any:
    """The result of a task, run under a watch that stops it once its run is outdated."""
    _begin(task.background)
    run = _board(task.path)
    if run[task.lane] != task.run:
        return None
    watch, done = Watch(), threading.Event()

    def look() -> None:
        while not done.wait(LOOK_SECONDS):
            if run[task.lane] != task.run:
                watch.stop.set()
                return

    threading.Thread(target=look, daemon=True).start()
    try:
        with permission.only(task.names), watching(watch):
            return task.function(*task.arguments)
    except Stopped:
        return None
    finally:
        done.set()
