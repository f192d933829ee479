"""Names in texts, such as the class of a component or the file of a device: all of them may be followed or, while
`only` holds, those that ship and those of a list alone.

A file that a user names may say ``module:Class``, and reading it imports that module. Text from elsewhere, such as a
page of the studio or a link that opens it, is read under `only`: there nothing is imported and no file is opened whose
name was not given beforehand, and no class of one's own is handed other data than was given with it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from gelcone.errors import InputError

_allowed: ContextVar[frozenset[str] | None] = ContextVar("allowed", default=None)
LONGEST_SHOWN = 60


@contextmanager
def only(names: frozenset[str]) -> Iterator[None]:
    """Follow, in this thread and until the end of the block, only names that ship and those among ``names``."""
    before = _allowed.set(names)
    try:
        yield
    finally:
        _allowed.reset(before)


def limit(names: frozenset[str]) -> None:
    """Follow, for the rest of this thread, only names that ship and those among ``names``."""
    _allowed.set(names)


def check(kind: str, name: str) -> None:
    """`InputError` for a name of a ``kind`` of thing that must not be followed; nothing is imported."""
    allowed = _allowed.get()
    if allowed is not None and name not in allowed:
        shown = name if len(name) <= LONGEST_SHOWN else f"{name[:LONGEST_SHOWN]}..."
        raise InputError(f"{kind} = {shown!r}: does not ship; other components must be given when gelcone is started")


def check_data(kind: str, name: str, data: Mapping[str, Any]) -> None:
    """`InputError` for data that must not be handed to the class ``name``, which might do anything with a text.

    Allowed are fields of a record among the names, see `record`."""
    allowed = _allowed.get()
    if allowed is None or not data:
        return
    own = json.loads(record(name, data))
    for known in (json.loads(text) for text in allowed if text.startswith("{")):
        if all(key in known and known[key] == value for key, value in own.items()):
            return
    raise InputError(f"{kind} {name!r}: its data are not those with which gelcone was started; leave them out")


def record(name: str, data: Mapping[str, Any]) -> str:
    """A class and the data that it may be handed, as one of the names of `only`."""
    return json.dumps({"component": name, **data}, default=repr)
