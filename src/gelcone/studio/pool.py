"""Long work in processes of its own, so that sliders stay fast, and its end: cancelled work stops within moments.

A lane is a number under which a page's work of one kind runs; each new run of a lane ends the one before. Workers read
the lanes' counters in a file that they and the studio map into memory. They end with the pool, and when the process
that started them is gone.
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
"""Seconds that workers have to end by themselves: they are in the background, and a busy machine lets them wait."""
LOOK_SECONDS = 0.02
"""A worker looks this often whether its task is out of date."""


class Busy(RuntimeError):
    """All lanes are taken."""


class Pool:
    """Worker processes, started when they are first needed. Those in the ``background`` leave the processor to the
    studio and the browser; what does not ship they follow by ``names`` alone, see `gelcone.permission`."""

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
        """A free lane; `Busy` when there is none."""
        if not self._free:
            raise Busy("too much at once; close a page")
        return self._free.pop()

    def leave(self, lane: int) -> None:
        """Cancels what runs in a lane and gives it back."""
        self.begin(lane)
        self._free.append(lane)

    def begin(self, lane: int) -> int:
        """Cancels what runs in a lane; the number of its next run."""
        self._board[lane] += 1
        return int(self._board[lane])

    async def do(self, lane: int, run: int, function: Callable[..., Any], *arguments: Any) -> Any:
        """``function(*arguments)`` in a worker; None if the run is out of date. Raises what it raises, and
        `ProcessesEnded`."""
        pool, task = self._started(), self._task(lane, run, function, arguments)
        asked = asyncio.wrap_future(pool.threads.submit(_do, pool, task))
        asked.add_done_callback(lambda done: done.cancelled() or done.exception())
        return await asyncio.shield(asked)  # who waits may be cancelled; the task finds out by its lane

    def warm(self, function: Callable[[], None]) -> None:
        """Starts the workers, unless they run, and lets them load the module of a function."""
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
        """Ends the workers, in the middle of their work too."""
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
    """What the studio and its workers share: the number of each lane's run."""
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
    """Once in each worker."""
    warnings.simplefilter("ignore")  # the studio itself states what is doubtful
    with suppress(OSError, AttributeError):
        os.nice(NICENESS if background else 0)


def work(task: _Task) -> Any:
    """Does a task under a watch that stops it once its run is out of date."""
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
