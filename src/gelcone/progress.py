"""Progress of long work, and the signal that stops it."""

from __future__ import annotations

import functools
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

Progress = Callable[[float], None] | None
"""Called with the share of the work just done; the shares add up to 1."""


class Stopped(Exception):
    """Raised once the `Watch` over an integration has stopped it."""


@dataclass
class Watch:
    """A watch over all integrations of a thread: ``steps`` counts their steps, and setting ``stop`` ends them soon."""

    stop: threading.Event = field(default_factory=threading.Event)
    steps: int = 0


_watched = threading.local()


@contextmanager
def watching(watch: Watch) -> Iterator[None]:
    """Puts ``watch`` over all integrations of this thread; once its ``stop`` is set, `integrate` raises `Stopped`."""
    before = getattr(_watched, "watch", None)
    _watched.watch = watch
    try:
        yield
    finally:
        _watched.watch = before


def current_watch() -> Watch | None:
    """The watch over this thread's integrations, if any."""
    return getattr(_watched, "watch", None)


def advance(progress: Progress, share: float) -> None:
    """Reports a share of the work to a progress, if there is one."""
    if progress is not None:
        progress(share)


def weighted(progress: Progress, weight: float) -> Progress:
    """A progress that stands for the share ``weight`` of the given one."""
    if progress is None:
        return None
    report = progress
    return lambda share: report(weight * share)


def split_progress(progress: Progress, first: float, second: float, share: float = 1.0) -> tuple[Progress, Progress]:
    """Two progresses that make up ``share`` of the given one, in the ratio of two amounts of work."""
    whole = first + second
    return weighted(progress, share * first / whole), weighted(progress, share * second / whole)


class Counted:
    """A progress that counts, so that `finish` can report the rest: for work that may end early."""

    def __init__(self, progress: Progress):
        self._report, self._done = progress, 0.0

    def __call__(self, share: float) -> None:
        self._done += share
        advance(self._report, share)

    def finish(self) -> None:
        """Reports the share that has not been reported yet."""
        if self._done < 1.0:
            self(1.0 - self._done)


@contextmanager
def bar(label: str) -> Iterator[Callable[[Any], None]]:
    """A tqdm bar (widgets in a notebook) that takes shares of the work, or counts of cells."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a notebook without widgets gets a line of text
        from tqdm.auto import tqdm

        shown = tqdm(total=1.0, desc=label, leave=False, bar_format="{l_bar}{bar}| {elapsed}<{remaining}")

    def report(done: Any) -> None:
        share = done.computed / max(done.asked, 1) - shown.n if hasattr(done, "computed") else done
        shown.update(share)

    with shown:
        yield report


def barred(run: Callable[..., Any]) -> Callable[..., Any]:
    """A function whose option ``progress=True`` shows a `bar`."""

    @functools.wraps(run)
    def call(*arguments: Any, **options: Any) -> Any:
        if options.get("progress") is not True:
            return run(*arguments, **options)
        with bar(run.__name__) as report:
            return run(*arguments, **options | {"progress": report})

    return call
