"""Progress of long work, and the signal that stops it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

Progress = Callable[[float], None] | None
"""Called with the share of the work just done; the shares add up to 1."""


class Stopped(Exception):
    """The `Watch` over an integration stopped it."""


@dataclass
class Watch:
    """A watch over all integrations of one thread: ``steps`` counts their steps, ``stop`` ends them soon when set."""

    stop: threading.Event = field(default_factory=threading.Event)
    steps: int = 0


_watched = threading.local()


@contextmanager
def watching(watch: Watch) -> Iterator[None]:
    """Put ``watch`` over all integrations of this thread; once its ``stop`` is set, `integrate` raises `Stopped`."""
    before = getattr(_watched, "watch", None)
    _watched.watch = watch
    try:
        yield
    finally:
        _watched.watch = before


def current_watch() -> Watch | None:
    """The watch over what this thread integrates, if any."""
    return getattr(_watched, "watch", None)


def weighted(progress: Progress, weight: float) -> Progress:
    """A progress whose whole is the share ``weight`` of the given one's."""
    if progress is None:
        return None
    report = progress
    return lambda share: report(weight * share)


def split_progress(progress: Progress, first: float, second: float, share: float = 1.0) -> tuple[Progress, Progress]:
    """Two progresses that add up to ``share`` of the given one, in the ratio of two amounts of work."""
    whole = first + second
    return weighted(progress, share * first / whole), weighted(progress, share * second / whole)


class Counted:
    """A progress that keeps count, so that `finish` can report what is left: for work that may end early."""

    def __init__(self, progress: Progress):
        self._report, self._done = progress, 0.0

    def __call__(self, share: float) -> None:
        self._done += share
        if self._report is not None:
            self._report(share)

    def finish(self) -> None:
        """Reports the share that has not been reported yet."""
        if self._done < 1.0:
            self(1.0 - self._done)
