"""What the tests of commands share."""

import pickle
import warnings

import pytest

from gelcone.cli import command

COMPUTED: dict[bytes, tuple] = {}
"""Pickled question -> its result and the warnings that came with it."""


@pytest.fixture
def computed_once(monkeypatch):
    """Commands that ask the same question share one computation, in whatever tests: each makes its own text, object and
    files of it. Not for tests of progress, interrupts or stores."""
    plain = command.plain

    def remembering(call):
        def ask(*given, progress=None, **options):
            key = pickle.dumps((call.__module__, call.__name__, given, sorted(options.items())))
            if key not in COMPUTED:
                with warnings.catch_warnings(record=True) as said:
                    warnings.simplefilter("always")
                    COMPUTED[key] = plain(call)(*given, **options), said
            result, said = COMPUTED[key]
            for one in said:
                warnings.warn_explicit(one.message, one.category, one.filename, one.lineno)
            return result.copy(deep=True)

        return ask

    monkeypatch.setattr(command, "plain", remembering)
