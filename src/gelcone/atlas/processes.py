"""Processes of this machine, each a Python of its own that answers tasks over its standard input and output.

They are started by a command and not by `multiprocessing`, which would run the caller's script again in each of them,
so that a script without ``if __name__ == "__main__"`` works. They end when their input is closed, also when this
process is killed. Interrupts reach this process alone, which then ends the others.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
import time
import traceback
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from typing import IO, Any

from gelcone import disk_cache
from gelcone.atlas.workers import Answer, Task, Team, Workers, as_they_come, threads, watched
from gelcone.errors import InputError, LostWorker
from gelcone.motion.flow import available_threads
from gelcone.progress import Stopped
from gelcone.quantity import ALL_CORES, check_count

LARGE = 1024
"""Number of cells from which processes are worth the time of their start, about a second each."""
DEATHS = 2
"""Number of processes that a task may end before it is given up."""
PATIENCE = 5.0
"""Seconds that a process has to end after the request."""
REPORT_EVERY = 0.1
"""Seconds between two reports of progress."""

_serving = False
_answers: IO[bytes]
_reporting = threading.Lock()
_pending, _reported = 0.0, 0.0


class ProcessesEnded(InputError):
    """Raised for a task that ended each process that worked on it."""


def usual_workers(cells: int, count: int | None = None) -> Workers:
    """The default workers for a number of cells: one process per core for `LARGE` ones, else threads.

    With ``count`` they are that number of threads.
    """
    alone = _serving or multiprocessing.parent_process() is not None
    able = bool(sys.executable) and not getattr(sys, "frozen", False)
    if count is None and cells >= LARGE and available_threads() > 1 and able and not alone:
        return processes()
    return threads(count)


def processes(count: int | None = None) -> Workers:
    """Processes of this machine; by default one per core. Leaving the context ends them.

    Components that the running script itself defines are unknown to them; threads of this process do those tasks.

    Raises
    ------
    InputError : for fewer than 1.
    """
    if count is not None:
        check_count("workers", count, 1, ALL_CORES)

    @contextmanager
    def start() -> Iterator[Team]:
        pool, stop = Pool(count or available_threads()), threading.Event()

        def run(function: Callable[[Task], Answer], tasks: Iterable[Task]) -> Iterator[tuple[Answer, int]]:
            content = portable(function)

            def work(task: Task) -> tuple[Answer, int]:
                if content is None:
                    return watched(function, task, stop)
                answer: tuple[Answer, int] = pool.do(content, task)
                return answer

            return as_they_come(pool.threads, pool.size, work, tasks, stop)

        try:
            yield Team(pool.size, run)
        finally:
            stop.set()
            pool.close()

    return start


class Pool:
    """Processes of this machine, and as many ``threads`` of this process, which send them tasks and wait."""

    def __init__(self, size: int) -> None:
        self.size, self.threads = size, ThreadPoolExecutor(size)
        self._processes = [Process() for _ in range(size)]
        self._idle: queue.SimpleQueue[Process] = queue.SimpleQueue()
        for process in self._processes:
            self._idle.put(process)

    def do(self, function: bytes, task: Any, report: Callable[[float], None] = lambda share: None) -> Any:
        """The answer of a pickled function to a task, from the next process that is idle; see `Process.do`."""
        process = self._idle.get()
        try:
            return process.do(function, task, report)
        finally:
            self._idle.put(process)

    def close(self, patience: float = PATIENCE) -> None:
        """Ends the processes, in the middle of their work too, and kills those that take longer than ``patience``."""
        self.threads.shutdown(wait=False, cancel_futures=True)
        for process in self._processes:
            process.stop()
        until = time.monotonic() + patience
        for process in self._processes:
            process.end(until - time.monotonic())
        self.threads.shutdown()


def portable(function: Callable[[Any], Any]) -> bytes | None:
    """The function pickled for another process; None for one that needs definitions of the running script."""
    try:
        content = pickle.dumps(function)
    except (pickle.PicklingError, AttributeError, TypeError):
        return None
    return None if b"__main__" in content else content


class Process:
    """A process that does one task at a time. If it ends by itself, another one replaces it."""

    def __init__(self) -> None:
        self._lock, self._ended = threading.Lock(), False
        self._process = _start()

    def do(self, function: bytes, task: Any, report: Callable[[float], None]) -> Any:
        """The answer to a task; raises the error that the task raised.

        The shares of the work that the process reports are passed to ``report``, and content that it makes to the
        listeners of this process, see `gelcone.disk_cache.heard`.
        """
        for _ in range(DEATHS):
            try:
                pickle.dump(pickle.dumps((function, task)), _pipe(self._process.stdin))
                _pipe(self._process.stdin).flush()
                message = self._heard(report)
            except (EOFError, OSError, ValueError, pickle.UnpicklingError):  # it has ended, or its pipes are closed
                self._restart()
                continue
            error, answer = message
            if error is not None:
                raise error
            return answer
        raise ProcessesEnded(
            f"a task ended {DEATHS} processes, one after the other: they may run out of memory; start fewer with "
            "--workers. What the store holds is safe: continue with --resume"
        )

    def _heard(self, report: Callable[[float], None]) -> Any:
        """The answer of the process. Messages before it are shares of the work (numbers), the kind of a content that it
        begins to make (a text), and the end of the last one begun (an empty text)."""
        begun: list[ExitStack] = []
        with ExitStack() as making:
            while not isinstance(message := pickle.load(_pipe(self._process.stdout)), tuple):
                if isinstance(message, float):
                    report(message)
                elif message:
                    begun.append(making.enter_context(ExitStack()))
                    begun[-1].enter_context(disk_cache.making(message))
                else:
                    begun.pop().close()
        return message

    def _restart(self) -> None:
        with self._lock:
            if self._ended:
                raise Stopped
            with suppress(subprocess.TimeoutExpired):  # its pipes close a moment before it is gone
                self._process.wait(0.2)
            number, code = self._process.pid, self._process.poll()
            self._process.kill()
            _close(self._process)
            self._process = _start()
        how = "" if code is None else f" by signal {-code}" if code < 0 else f" with code {code}"
        warnings.warn(f"process {number} ended{how}; another takes over its task", LostWorker, stacklevel=2)

    def stop(self) -> None:
        """Asks the process to end."""
        with self._lock:
            self._ended = True
            self._process.terminate()

    def end(self, patience: float) -> None:
        """Waits ``patience`` seconds for the process to end, then kills it."""
        try:
            self._process.wait(max(patience, 0.0))
        except subprocess.TimeoutExpired:
            self._process.kill()
        _close(self._process)


def _start() -> subprocess.Popen[bytes]:
    path = [str(entry) for entry in sys.path]
    code = f"import sys; sys.path[:] = {path!r}; from gelcone.atlas.processes import serve; serve()"
    command, pipe = [sys.executable, "-c", code], subprocess.PIPE
    environment = {"OPENBLAS_NUM_THREADS": "1"} | os.environ  # threads of several processes would wait for one another
    if sys.platform == "win32":
        group = subprocess.CREATE_NEW_PROCESS_GROUP
        return subprocess.Popen(command, stdin=pipe, stdout=pipe, env=environment, creationflags=group)
    return subprocess.Popen(command, stdin=pipe, stdout=pipe, env=environment, process_group=0)


def _close(process: subprocess.Popen[bytes]) -> None:
    process.wait()
    for stream in (process.stdin, process.stdout):
        with suppress(OSError):  # buffered bytes have no reader any more
            _pipe(stream).close()


def _pipe(stream: IO[bytes] | None) -> IO[bytes]:
    assert stream is not None
    return stream


# --- in a process of its own ------------------------------------------------------------------------------------------


def serve() -> None:
    """Answers tasks until the standard input ends. Anything that is printed goes to the standard error."""
    global _serving, _answers
    _serving = True
    given, _answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)
    tasks: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(given, tasks), daemon=True).start()
    with suppress(KeyboardInterrupt), disk_cache.heard(_passed_on):
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        while True:
            answer = _answer(tasks.get())
            report(0.0, last=True)
            _send(answer)


def report(share: float, *, last: bool = False) -> None:
    """Sends the share of the task's work that is done, from any thread: at most once in `REPORT_EVERY` seconds, and
    the ``last`` one in any case."""
    global _pending, _reported
    with _reporting:
        _pending += share
        if _pending and (last or time.monotonic() - _reported >= REPORT_EVERY):
            _send(pickle.dumps(_pending))
            _pending, _reported = 0.0, time.monotonic()


@contextmanager
def _passed_on(kind: str) -> Iterator[None]:
    """Sends a message when content of a kind begins to be made, and another when it is complete."""
    with _reporting:
        _send(pickle.dumps(kind))
    try:
        yield
    finally:
        with _reporting:
            _send(pickle.dumps(""))


def _send(message: bytes) -> None:
    _answers.write(message)
    _answers.flush()


def _listen(given: IO[bytes], tasks: queue.SimpleQueue[bytes]) -> None:
    try:
        while True:
            tasks.put(pickle.load(given))
    except (EOFError, pickle.UnpicklingError):
        os._exit(0)  # nobody waits for an answer, also in the middle of a task


def _answer(content: bytes) -> bytes:
    """The error, or None, and the answer of a pickled task, pickled."""
    try:
        function, task = pickle.loads(content)
        return pickle.dumps((None, watched(pickle.loads(function), task)))
    except Exception as error:
        error.add_note(traceback.format_exc())
        try:
            pickle.loads(named := pickle.dumps((error, None)))
        except Exception:
            named = pickle.dumps((RuntimeError(repr(error)), None))
        return named
