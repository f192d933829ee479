"""Recorders in the place of parts of a module: what each was asked for, and made-up answers."""

import inspect

import numpy as np


def record(monkeypatch, module, **answers):
    """Replaces parts of a module by recorders: name -> calls, each the arguments by name, the defaults among them.

    An answer that can be called gets what the part was given.
    """
    asked = {name: [] for name in answers}
    for name, answer in answers.items():
        monkeypatch.setattr(module, name, _recorder(getattr(module, name), answer, asked[name]))
    return asked


def _recorder(part, answer, calls):
    form = inspect.signature(part)
    (others,) = [n for n, p in form.parameters.items() if p.kind is p.VAR_KEYWORD] or [None]

    def recorder(*values, **options):
        given = form.bind(*values, **options)
        given.apply_defaults()
        arguments = dict(given.arguments)
        calls.append(arguments | arguments.pop(others, {}))
        return answer(*values, **options) if callable(answer) else answer

    return recorder


def numbers(*shape, at=0.0):
    """Numbers that are all different, and that those ``at`` other whole numbers do not share."""
    return at + (np.arange(np.prod(shape, dtype=int)).reshape(shape) + 1.0) / 1024.0
