"""Processes of this machine, each a Python of its own that answers tasks over its standard input and output.

They are started by a command and not by `multiprocessing`, which would run the caller's script once more in each of
them: a script without ``if __name__ == "__main__"`` works. They end when the other end of their input does, also when
this process is killed. Interrupts reach this process alone, which then ends them.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import queue
import subprocess
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from typing import IO, Any

from gelcone.atlas.workers import Answer, Task, Team, Workers, as_they_come, threads, watched
from gelcone.errors import InputError
from gelcone.motion.flow import available_threads
from gelcone.progress import Stopped

LARGE = 1024
"""Cells from which on processes are worth their start, about a second of work each."""
DEATHS = 2
"""A task that has ended so many processes is given up."""

_serving = False


class ProcessesEnded(InputError):
    """A task has ended the processes that were to do it."""


def usual_workers(cells: int, count: int | None = None) -> Workers:
    """Who computes so many cells when nobody says: one process a core where that is worth it, else threads.

    ``count`` asks for so many threads.
    """
    alone = _serving or multiprocessing.parent_process() is not None
    able = bool(sys.executable) and not getattr(sys, "frozen", False)
    if count is None and cells >= LARGE and available_threads() > 1 and able and not alone:
        return processes()
    return threads(count)


def processes(count: int | None = None) -> Workers:
    """Processes of this machine; by default one a core. Leaving the context ends them at once.

    What a component of the running script itself needs they do not find; threads of this process do those tasks.

    Raises
    ------
    InputError : for fewer than 1.
    """
    if count is not None and not (isinstance(count, int) and count >= 1):
        raise InputError(f"workers = {count!r}: must be at least 1")

    @contextmanager
    def start() -> Iterator[Team]:
        size, stop = count or available_threads(), threading.Event()
        pool, helpers = ThreadPoolExecutor(size), [Process() for _ in range(size)]
        idle: queue.SimpleQueue[Process] = queue.SimpleQueue()
        for helper in helpers:
            idle.put(helper)

        def run(function: Callable[[Task], Answer], tasks: Iterable[Task]) -> Iterator[tuple[Answer, int]]:
            content = _portable(function)

            def work(task: Task) -> tuple[Answer, int]:
                if content is None:
                    return watched(function, task, stop)
                helper = idle.get()
                try:
                    answer: tuple[Answer, int] = helper.do(content, task)
                    return answer
                finally:
                    idle.put(helper)

            return as_they_come(pool, size, work, tasks)

        try:
            yield Team(size, run)
        finally:
            stop.set()
            for helper in helpers:
                helper.end()
            pool.shutdown(cancel_futures=True)

    return start


def _portable(function: Callable[[Any], Any]) -> bytes | None:
    """The function as another process can read it; None for one that needs what the running script defines."""
    try:
        content = pickle.dumps(function)
    except (pickle.PicklingError, AttributeError, TypeError):
        return None
    return None if b"__main__" in content else content


class Process:
    """A process that does one task at a time, and another in its place where it ends by itself."""

    def __init__(self) -> None:
        self._lock, self._ended = threading.Lock(), False
        self._process = _start()

    def do(self, function: bytes, task: Any) -> Any:
        """The answer to a task; raises what it raised."""
        for _ in range(DEATHS):
            try:
                pickle.dump(pickle.dumps((function, task)), _pipe(self._process.stdin))
                _pipe(self._process.stdin).flush()
                error, answer = pickle.load(_pipe(self._process.stdout))
            except (EOFError, OSError, pickle.UnpicklingError):
                self._restart()
                continue
            if error is not None:
                raise error
            return answer
        raise ProcessesEnded(
            f"a task ended {DEATHS} processes, one after the other: they may run out of memory; start fewer with "
            "--workers. What the store holds is safe: continue with --resume"
        )

    def _restart(self) -> None:
        with self._lock:
            if self._ended:
                raise Stopped
            _kill(self._process)
            self._process = _start()

    def end(self) -> None:
        with self._lock:
            self._ended = True
            _kill(self._process)


def _start() -> subprocess.Popen[bytes]:
    path = [str(entry) for entry in sys.path]
    code = f"import sys; sys.path[:] = {path!r}; from gelcone.atlas.processes import serve; serve()"
    command, pipe = [sys.executable, "-c", code], subprocess.PIPE
    if sys.platform == "win32":
        group = subprocess.CREATE_NEW_PROCESS_GROUP
        return subprocess.Popen(command, stdin=pipe, stdout=pipe, creationflags=group)
    return subprocess.Popen(command, stdin=pipe, stdout=pipe, process_group=0)


def _kill(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.wait()
    for stream in (process.stdin, process.stdout):
        with suppress(OSError):  # what was not yet written has no reader any more
            _pipe(stream).close()


def _pipe(stream: IO[bytes] | None) -> IO[bytes]:
    assert stream is not None
    return stream


# --- in a process of its own ------------------------------------------------------------------------------------------


def serve() -> None:
    """Answers tasks until the standard input ends. What else is printed goes to the standard error."""
    global _serving
    _serving = True
    given, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)
    tasks: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(given, tasks), daemon=True).start()
    while True:
        answers.write(_answer(tasks.get()))
        answers.flush()


def _listen(given: IO[bytes], tasks: queue.SimpleQueue[bytes]) -> None:
    try:
        while True:
            tasks.put(pickle.load(given))
    except (EOFError, pickle.UnpicklingError):
        os._exit(0)  # nobody waits for an answer, also in the middle of a task


def _answer(content: bytes) -> bytes:
    """The pickled error, or None, and answer of a pickled task."""
    try:
        function, task = pickle.loads(content)
        return pickle.dumps((None, watched(pickle.loads(function), task)))
    except Exception as error:
        try:
            pickle.loads(told := pickle.dumps((error, None)))
        except Exception:
            told = pickle.dumps((RuntimeError(repr(error)), None))
        return told
