"""Names in texts, such as the class of a component or the file of a film: all of them may be followed or, while `only`
holds, those that ship and those of a list alone.

A file that a user names may say ``module:Class``, and reading it imports that module. Text from elsewhere, such as a
page of the studio or a link that opens it, is read under `only`: there nothing is imported and no file is opened whose
name was not given beforehand.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from gelcone.errors import InputError

_allowed: ContextVar[frozenset[str] | None] = ContextVar("allowed", default=None)
LONGEST_SHOWN = 60


@contextmanager
def only(names: frozenset[str]) -> Iterator[None]:
    """Follows, in this thread and until the end of the block, no name that does not ship and is not among ``names``."""
    before = _allowed.set(names)
    try:
        yield
    finally:
        _allowed.reset(before)


def limit(names: frozenset[str]) -> None:
    """As `only`, for the rest of this thread."""
    _allowed.set(names)


def check(kind: str, name: str) -> None:
    """`InputError` for a name of a ``kind`` of thing that must not be followed; it is not looked at further."""
    allowed = _allowed.get()
    if allowed is not None and name not in allowed:
        shown = name if len(name) <= LONGEST_SHOWN else f"{name[:LONGEST_SHOWN]}..."
        raise InputError(f"{kind} = {shown!r}: does not ship; what else there is must be given when gelcone is started")
