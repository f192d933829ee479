"""Long work in processes of its own, so that sliders stay fast, and its end: cancelled work stops within moments.

A lane is a number under which a page's work of one kind runs; each new run of a lane ends the one before. Workers read
the lanes' counters in shared memory. They end when they are told to, and when the process that started them is gone.
"""

from __future__ import annotations

import asyncio
import multiprocessing
import os
import signal
import threading
import warnings
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from multiprocessing.connection import wait
from typing import Any

from gelcone.motion.flow import available_threads
from gelcone.progress import Stopped, Watch, watching

LANES = 256
NICENESS = 10
LOOK_SECONDS = 0.02
"""A worker looks this often whether its task is out of date."""

_counters: Any = None
_progress: Any = None


class Busy(RuntimeError):
    """All lanes are taken."""


class Pool:
    """Worker processes, started when they are first needed."""

    def __init__(self, size: int | None = None) -> None:
        self.size = size or available_threads()
        self._context = multiprocessing.get_context("spawn")
        self._counters = self._context.Array("Q", LANES, lock=False)
        self.progress = self._context.Array("d", LANES, lock=False)
        self._free = list(range(LANES))
        self._end, self._listen = self._context.Pipe()
        self._executor: ProcessPoolExecutor | None = None

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
        self._counters[lane] += 1
        self.progress[lane] = 0.0
        return int(self._counters[lane])

    def is_current(self, lane: int, run: int) -> bool:
        return bool(self._counters[lane] == run)

    async def do(self, lane: int, run: int, function: Callable[..., Any], *arguments: Any) -> Any:
        """``function(*arguments)`` in a worker; None if the run is out of date. Raises what it raises."""
        try:
            task = asyncio.wrap_future(self._submit(_work, lane, run, function, arguments))
            task.add_done_callback(lambda done: done.cancelled() or done.exception())
            return await asyncio.shield(task)  # who waits may be cancelled; the task finds out by its lane
        except BrokenProcessPool:
            self._executor = None
            raise

    def warm(self, function: Callable[[], None]) -> None:
        """Starts the workers, unless they run, and lets them load the module of a function."""
        if self._executor is None:
            for _ in range(self.size):
                self._submit(function)

    def _submit(self, function: Callable[..., Any], *arguments: Any) -> Any:
        if self._executor is None:
            self._executor = ProcessPoolExecutor(
                self.size,
                mp_context=self._context,
                initializer=_start,
                initargs=(self._counters, self.progress, self._listen),
            )
        return self._executor.submit(function, *arguments)

    def close(self) -> None:
        """Ends the workers, in the middle of their work too."""
        for lane in range(LANES):
            self._counters[lane] += 1
        with suppress(OSError):
            self._end.close()
            self._listen.close()
        if self._executor is not None:
            self._executor.shutdown(wait=False)
            self._executor = None


def _start(counters: Any, progress: Any, listen: Any) -> None:
    global _counters, _progress
    _counters, _progress = counters, progress
    warnings.simplefilter("ignore")  # what is doubtful is told by the studio itself
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the studio itself hears Ctrl-C and ends its workers
    with suppress(OSError, AttributeError):
        os.nice(NICENESS)
    threading.Thread(target=_end_with, args=(listen,), daemon=True).start()


def _end_with(listen: Any) -> None:
    """Ends this process once the studio has closed its end, or is gone."""
    parent = multiprocessing.parent_process()
    wait([listen, *([] if parent is None else [parent.sentinel])])
    os._exit(0)


def reporter(lane: int) -> Callable[[float], None]:
    """A progress that a lane's ``progress`` shows; for the functions that workers run."""

    def report(share: float) -> None:
        _progress[lane] += share

    return report


def _work(lane: int, run: int, function: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
    """A task under a watch that stops it once its run is out of date."""
    if _counters[lane] != run:
        return None
    watch, done = Watch(), threading.Event()

    def look() -> None:
        while not done.wait(LOOK_SECONDS):
            if _counters[lane] != run:
                watch.stop.set()
                return

    threading.Thread(target=look, daemon=True).start()
    try:
        with watching(watch):
            return function(*arguments)
    except Stopped:
        return None
    finally:
        done.set()
