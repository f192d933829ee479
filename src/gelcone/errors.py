"""Errors that a user can act on: each names the value, the bound and the remedy."""

from __future__ import annotations

import difflib
import os
import reprlib
from collections.abc import Collection, Hashable, Iterable
from numbers import Number
from types import UnionType
from typing import Any


class InputError(ValueError):
    """An unusable value. The command line prints it as one line and exits with 2.

    Examples
    --------
    >>> import gelcone
    >>> gelcone.ConeModel(damping_ratio=-0.05)
    Traceback (most recent call last):
        ...
    gelcone.errors.InputError: damping_ratio = -0.05: must be at least 0; its default is 0.05
    """


def unknown_name(kind: str, name: str, known: Iterable[str], otherwise: str = "") -> InputError:
    """Make the error for an unknown name, which suggests the nearest known one, ``otherwise`` a remedy or all."""
    known = list(known)
    remedy = nearest(name, known) or otherwise or f"known: {', '.join(known)}"
    article = "an" if kind[0] in "aeiou" else "a"
    return InputError(f"{name!r} is not {article} {kind}; {remedy}")


def nearest(name: str, known: Iterable[str]) -> str:
    """Ask whether the nearest known name was meant; empty if none is near."""
    near = difflib.get_close_matches(name, list(known), n=1, cutoff=0.6)
    return f"did you mean {near[0]!r}?" if near else ""


def check_name(kind: str, name: Any, known: Collection[str], where: str = "") -> None:
    """`InputError`, which begins with ``where``, unless ``name`` is one of the ``known``."""
    if not isinstance(name, Hashable) or name not in known:
        raise InputError(f"{where}{unknown_name(kind, str(name)[:60], known)}")


def check_names(kind: str, names: Iterable[Any], known: Collection[str], where: str = "") -> None:
    """`InputError` as by `check_name` unless all are known."""
    for name in names:
        check_name(kind, name, known, where)


def described(value: object) -> str:
    """Words for an object that was given in place of another: ``the number 3``, ``the text 'x'``, ``an array``."""
    if isinstance(value, str):
        return f"the text {reprlib.repr(value)}"
    if isinstance(value, Number) and not isinstance(value, bool):
        return f"the number {value}"
    name = {"ndarray": "array", "NoneType": "None"}.get(type(value).__name__, type(value).__name__)
    return name if value is None else f"{'an' if name[0].lower() in 'aeiou' else 'a'} {name}"


def check_kind(name: str, value: object, kind: type | UnionType, remedy: str) -> None:
    """`InputError`, which ends in ``remedy``, unless ``value`` is of this kind."""
    if not isinstance(value, kind):
        raise InputError(f"{name}: was given {described(value)}; {remedy}")


def check_result(name: str, result: object) -> None:
    """`InputError` unless ``result`` is a Dataset."""
    if not hasattr(result, "data_vars"):
        raise InputError(f"{name}: was given {described(result)}; give a Dataset that an analysis returned")


def check_path(name: str, path: object) -> None:
    """`InputError` unless ``path`` is one."""
    check_kind(name, path, str | os.PathLike, "give the path of a file or folder")


class DoubtfulInput(UserWarning):
    """A usable value that is probably not meant, or a table that had to be interpreted.

    The command line prints it as one line and continues.
    """


class LostWorker(RuntimeWarning):
    """A worker of a cluster that ended in the middle of a run, whose tasks others take over; or a cluster that has no
    worker."""


class MissingDependency(ImportError):
    """A library that a result needs is not installed; the message states how to install it.

    Examples
    --------
    >>> import gelcone
    >>> try:
    ...     sheet = gelcone.validate(gelcone.ConeModel(hoop_prestretch=1.4), [0.4])
    ... except gelcone.MissingDependency as error:
    ...     print(error)  # without scikit-fem: pip install 'gelcone[fem]'
    ... else:
    ...     print(sheet.sizes["displacement"], "height compared")
    1 height compared
    """
