"""Permission to follow names in texts, such as the class of a component or the file of a device.

A file that a user names may contain ``module:Class``, and reading it imports that module. Text from elsewhere, such as
a page of the studio or a link that opens it, is read under `only`: then only shipped names and those of a list are
followed, nothing else is imported or opened, and user-defined classes receive only the data that was given with them.
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
    """Restricts this thread, within the block, to names that ship and those among ``names``."""
    before = _allowed.set(names)
    try:
        yield
    finally:
        _allowed.reset(before)


def limit(names: frozenset[str]) -> None:
    """Restricts this thread, from now on, to names that ship and those among ``names``."""
    _allowed.set(names)


def check(kind: str, name: str) -> None:
    """Raises `InputError` for a name of this ``kind`` that must not be followed; nothing is imported."""
    allowed = _allowed.get()
    if allowed is not None and name not in allowed:
        shown = name if len(name) <= LONGEST_SHOWN else f"{name[:LONGEST_SHOWN]}..."
        raise InputError(f"{kind} = {shown!r}: does not ship; other components must be given when gelcone is started")


def check_data(kind: str, name: str, data: Mapping[str, Any]) -> None:
    """Raises `InputError` for data that must not be passed to the class ``name``, which might do anything with it.

    The fields of a record among the names are allowed, see `record`.
    """
    allowed = _allowed.get()
    if allowed is None or not data:
        return
    asked_record = json.loads(record(name, data))
    for allowed_record in (json.loads(text) for text in allowed if text.startswith("{")):
        if all(key in allowed_record and allowed_record[key] == value for key, value in asked_record.items()):
            return
    raise InputError(f"{kind} {name!r}: its data are not those with which gelcone was started; leave them out")


def record(name: str, data: Mapping[str, Any]) -> str:
    """A class and the data that it may receive, as one of the names of `only`."""
    return json.dumps({"component": name, **data}, default=repr)
