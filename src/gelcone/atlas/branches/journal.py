"""The journal of a run along branches, stored in a folder, with which the same run continues where it was stopped.

Following branches is one chain of steps, each of which depends only on the model and the steps before. A run that
starts again therefore asks for the same entries in the same order. Entries that are complete are read, with the same
bits, and the one that was under way continues from its last state.
"""

from __future__ import annotations

import json
import time
import zipfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from gelcone.atlas.store import open_store
from gelcone.errors import InputError
from gelcone.files import write_whole

EVERY = 1.0
"""Seconds between two times at which the state of an entry under way is written."""
Entry = Mapping[str, Any]
"""Arrays and numbers by name."""


class Journal:
    """The entries of one run, in the order in which they are requested; without a folder none is stored."""

    def __init__(self, folder: Path | None = None) -> None:
        self._folder, self._number, self._written = folder, 0, time.monotonic()

    def entry(self, compute: Callable[[], Entry]) -> Entry:
        """The next entry, read from the folder or computed now."""
        entry, whole = self.begin()
        if not whole:
            entry = compute()
            self.end(lambda: entry)
        return entry

    def begin(self) -> tuple[Entry, bool]:
        """The stored part of the next entry; and True if it is complete."""
        if self._folder is None:
            return {}, False
        for name, whole in ((self._name, True), (self._partial, False)):
            if (self._folder / name).exists():
                self._number += whole
                return _read(self._folder / name), whole
        return {}, False

    def note(self, state: Callable[[], Entry]) -> None:
        """Writes the state of the entry under way, at most once in `EVERY` seconds."""
        if self._folder is not None and time.monotonic() > self._written + EVERY:
            self._write(self._partial, state())

    def end(self, entry: Callable[[], Entry]) -> None:
        """Writes the complete entry."""
        if self._folder is not None:
            self._write(self._name, entry())
            (self._folder / self._partial).unlink(missing_ok=True)
        self._number += 1

    @property
    def _name(self) -> str:
        return f"{self._number:05d}.npz"

    @property
    def _partial(self) -> str:
        return f"{self._number:05d}-under-way.npz"

    def _write(self, name: str, entry: Entry) -> None:
        assert self._folder is not None
        write_whole(self._folder / name, lambda path: np.savez(path, **entry), force=True)
        self._written = time.monotonic()


def _read(path: Path) -> Entry:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            return dict(archive)
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        reason = " ".join(str(error).split())
        raise InputError(f"{path}: is damaged ({reason}); remove it, and what follows is computed again") from None


@contextmanager
def journal_in(folder: str | Path | None, plan: Mapping[str, Any], *, resume: bool) -> Iterator[Journal]:
    """The journal of a run in a folder, locked for this run: a new one or, to ``resume``, that of the same plan.

    Raises `InputError` for what `gelcone.atlas.store.open_store` refuses.
    """
    if folder is None:
        yield Journal()
        return
    place = Path(folder)
    with open_store(place, json.loads(json.dumps(plan)), ("entry",), (1,), resume=resume):
        for unfinished in place.glob(".*.npz"):  # left by a run that was killed while it wrote
            unfinished.unlink()
        yield Journal(place)
