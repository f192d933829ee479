"""Requests of a page, read and checked before anything is computed."""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Mapping
from typing import Any

from gelcone.errors import InputError
from gelcone.studio import exports
from gelcone.studio.grids import Axis, Source, axis
from gelcone.studio.setting import Setting, Shelf, typed

LONGEST_ID = 2**53
MAP_CELLS, STRIP_VALUES = (65, 49), 241
"""Cells of a map along each axis, and values of a sweep."""


def read(text: str | None, kinds: Collection[str]) -> dict[str, Any]:
    """The request in a message: an object with a known ``kind`` and a number ``id``; `InputError` for anything else."""
    if text is None:
        raise InputError("the message is not text; send JSON")
    try:
        request = json.loads(text, parse_constant=_number, parse_int=_number, parse_float=_number)
    except (ValueError, RecursionError):
        raise InputError("the message is not JSON") from None
    if not isinstance(request, dict) or text_of(request, "kind") not in kinds:
        raise InputError("the message must be an object whose kind is one of: " + ", ".join(kinds))
    number = request.get("id")
    if isinstance(number, bool) or not isinstance(number, int | float) or not 0 <= number < LONGEST_ID or number % 1:
        raise InputError("id: must be a whole number")
    return request | {"id": int(number)}


def read_map(shelf: Shelf, request: Mapping[str, Any]) -> tuple[Source, Axis, Axis]:
    """The source and the two axes of a map."""
    setting = Setting.read(request.get("setting"))
    controls = shelf.controls(setting)
    x, y = (axis(controls, request.get(name), count) for name, count in (("x", MAP_CELLS[0]), ("y", MAP_CELLS[1])))
    if x.name == y.name:
        raise InputError(f"{x.name}: is on both axes; choose two parameters")
    return source(shelf, setting), x, y


def read_sweep(shelf: Shelf, request: Mapping[str, Any]) -> tuple[Source, Axis]:
    """The source and the axis of a sweep."""
    setting = Setting.read(request.get("setting"))
    return source(shelf, setting), axis(shelf.controls(setting), request.get("over"), STRIP_VALUES)


def read_envelope(shelf: Shelf, request: Mapping[str, Any]) -> tuple[Source]:
    """The source of an operating envelope; `InputError` for a preset."""
    setting = Setting.read(request.get("setting"))
    if setting.preset is not None:
        raise InputError("a preset has no envelope; choose a device")
    return (source(shelf, setting),)


def read_export(shelf: Shelf, request: Mapping[str, Any]) -> tuple[Source, exports.Wanted, str]:
    """The source, result and format of a file that the page saves."""
    setting, wanted = _wanted(shelf, request)
    form = text_of(request, "format")
    if form not in exports.FORMATS:
        raise InputError(f"format: must be one of {', '.join(exports.FORMATS)}")
    return source(shelf, setting), wanted, form


def device_file(shelf: Shelf, request: Mapping[str, Any]) -> str:
    """The text of a device file with the current values; `InputError` for a preset."""
    device = shelf.subject(Setting.read(request.get("setting"))).device
    if device is None:
        raise InputError("a preset has no device file; choose a device")
    return device.to_toml()


def code(shelf: Shelf, request: Mapping[str, Any]) -> dict[str, Any]:
    """The command and the Python lines that compute what the page shows."""
    setting, wanted = _wanted(shelf, request)
    shelf.subject(setting)
    device = shelf.called(setting)
    text = {"command": exports.command(setting, wanted, device), "python": exports.lines(setting, wanted, device)}
    return {"own_file": setting.file is not None, **text}


def _wanted(shelf: Shelf, request: Mapping[str, Any]) -> tuple[Setting, exports.Wanted]:
    setting, name = Setting.read(request.get("setting")), text_of(request, "what")
    names = exports.OVER.get(name, ())
    counts = MAP_CELLS if len(names) == 2 else (STRIP_VALUES,)
    controls = shelf.controls(setting) if names else []
    axes = tuple(axis(controls, request.get(n), count) for n, count in zip(names, counts, strict=False))
    wanted = exports.Wanted.read(name, request.get("options", {}), axes)
    return exports.fitting(setting, wanted), wanted


def source(shelf: Shelf, setting: Setting) -> Source:
    """The source of a setting's subject for a worker; `InputError` as `Shelf.check`."""
    shelf.check(setting)
    return Source(shelf.path(setting), setting.file, typed(setting))


def text_of(request: Mapping[str, Any], name: str) -> str:
    """A text of a request, empty if it is missing; `InputError` for anything but a text."""
    value = request.get(name, "")
    if not isinstance(value, str):
        raise InputError(f"{name}: must be a text")
    return value


def _number(text: str) -> float:
    """A finite number of a request; `ValueError` for others, such as 1e999 or NaN."""
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(text)
    return number
