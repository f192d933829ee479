"""Messages while one waits for work that moves no progress: membranes being made, programs being compiled."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

import click

from gelcone import disk_cache

BAR_SECONDS = 1.0
"""Time after which a bar on a terminal is drawn again, whether or not there is news."""
STORED = "stored for later runs"
"""Words about what is made."""
FIRST_SECONDS, LOG_SECONDS = 5.0, 20.0
"""Time to the first line about a run that is not watched on a terminal, and between the others."""


def warned() -> list[str]:
    """The warnings of the command that runs, a line each."""
    context = click.get_current_context(silent=True)
    lines: list[str] = context.meta.setdefault("gelcone.warnings", []) if context else []
    return lines


@contextmanager
def preparing(label: str, name: Callable[[str], object]) -> Iterator[None]:
    """Calls ``name`` with the label of a progress line and what is being made, and with the label once it is there.

    What is made in another thread, or in a worker of this process, is heard too.
    """
    lock, films, making = threading.Lock(), 0, 0

    @contextmanager
    def hear(kind: str) -> Iterator[None]:
        nonlocal films, making
        with lock:
            films, making = films + (kind == disk_cache.MEMBRANES), making + 1
            name(f"{label}, {_making(kind, films)}")
        try:
            yield
        finally:
            with lock:
                making -= 1
                if not making:
                    name(label)

    with disk_cache.heard(hear):
        yield


def _making(kind: str, films: int) -> str:
    return f"making membrane {max(films, 1)}" if kind in (disk_cache.MEMBRANES, disk_cache.CHARGES) else "compiling"


@contextmanager
def said_before(command: str) -> Iterator[None]:
    """Says what is made while a command shows no progress of its own: the rest of a device needs its membrane."""
    films = 0

    @contextmanager
    def hear(kind: str) -> Iterator[None]:
        nonlocal films
        films += kind == disk_cache.MEMBRANES
        with _line(f"{command}, {_making(kind, films)}", "" if kind == disk_cache.LIBRARY else f": {STORED}"):
            yield

    with disk_cache.heard(hear):
        yield


@contextmanager
def _line(text: str, stored: str) -> Iterator[None]:
    """A line with the time since on a terminal, else one now and then, which also says what is ``stored``."""
    if not sys.stderr.isatty():
        begun = time.monotonic()
        with logging(lambda: click.echo(f"{text}{stored}; after {time.monotonic() - begun:.0f} s", err=True)):
            yield
        return
    from tqdm import tqdm

    shown = tqdm(desc=text, leave=False, bar_format="{desc} [{elapsed}]")
    with shown, ticking(shown.refresh, BAR_SECONDS):
        yield


@contextmanager
def ticking(say: Callable[[], object], seconds: float, first: float | None = None) -> Iterator[None]:
    """Calls ``say`` every so often during other work, however long that takes without a report of its own."""
    stop = threading.Event()

    def tick() -> None:
        wait = seconds if first is None else first
        while not stop.wait(wait):
            say()
            wait = seconds

    thread = threading.Thread(target=tick, daemon=True)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


def logging(say: Callable[[], object]) -> AbstractContextManager[None]:
    """`ticking` for a stream that keeps every line."""
    return ticking(say, LOG_SECONDS, FIRST_SECONDS)
