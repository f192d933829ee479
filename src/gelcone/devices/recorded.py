"""Recorded drives: a CSV file of times and voltages becomes the waveform of a device or a model."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from gelcone.devices.device import Device
from gelcone.devices.units import DIMENSIONS
from gelcone.errors import InputError, check_path
from gelcone.files import read_text
from gelcone.physics.model import ConeModel
from gelcone.physics.waveforms import MOST_PIECES, Samples
from gelcone.quantity import Array

REMEDY = 'give a CSV file whose first line is "time (s), voltage (V)"'
COLUMNS = {"time": "s", "voltage": "V"}
WITHIN = 1e-4
"""Largest distance, over the peak, of left-out samples from the straight lines between the others."""
MOST_ROWS = 1_000_000
_COLUMN = re.compile(r"(time|voltage)(?:\s*[(\[/]\s*([^)\]]*?)\s*[)\]]?)?")
Driven = TypeVar("Driven", Device, ConeModel)


def recorded(
    model: Driven,
    path: str | Path,
    *,
    scale: float = 1.0,
    repeat: bool = False,
    interpolation: str = "linear",
    jump: bool = False,
) -> Driven:
    """Return a device, or a model, that is driven by the voltages of a CSV file.

    The amplitude of the returned drive is the file's largest voltage, and its frequency one over the file's duration,
    so that other values stretch the drive.

    Parameters
    ----------
    model : a device, or a model; the file of a model holds dimensionless times and voltages without units.
    path : a CSV file: the columns ``time`` and ``voltage`` with their units, as in ``time (ms), voltage (kV)``.
    scale : factor of all voltages, such as an amplifier's gain. Default 1.
    repeat : whether the drive repeats. Default no: the last voltage is held.
    interpolation : "linear" (default; samples within 1e-4 of the peak of the straight line between others are left out)
        or "pchip", monotone cubics through all samples.
    jump : whether a drive that repeats may jump from its last voltage to its first. Default no.

    Returns
    -------
    The device, or model, with this drive.

    Raises
    ------
    InputError : in a line, for a file that cannot be read or used.

    Examples
    --------
    >>> import gelcone, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp(), "recorded.csv")
    >>> _ = path.write_text("time (ms),voltage (kV)\\n0,0\\n50,0.7\\n100,0.7\\n200,0\\n")
    >>> device = gelcone.recorded(gelcone.find_device("biased-pump"), path)
    >>> device.voltage_amplitude, device.frequency
    (700.0, 5.0)
    """
    check_path("recorded", path)
    if isinstance(scale, bool) or not isinstance(scale, float | int) or not math.isfinite(scale) or scale == 0.0:
        raise InputError(f"scale = {scale!r}: must be a finite number other than 0")
    times, voltages = read_recording(path, isinstance(model, Device))
    if interpolation == "linear":
        kept = needed(times, voltages)
        times, voltages = times[kept], voltages[kept]
    if times.size > MOST_PIECES:
        raise InputError(
            f"{path}: needs {times.size} samples, of which {MOST_PIECES} are taken; record fewer, or smooth it"
        )
    peak = float(np.abs(voltages).max())
    values, shares = voltages / (peak or 1.0), times / times[-1]
    try:
        drive = Samples(tuple(shares.tolist()), tuple(values.tolist()), interpolation, repeat, jump)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    if scale < 0.0:
        drive = replace(drive, values=tuple((-values).tolist()))
    amplitude = abs(scale) * peak
    if isinstance(model, Device):
        return model.replace(
            waveform=drive, voltage_amplitude=amplitude, voltage_offset=0.0, frequency=1.0 / float(times[-1])
        )
    return model.replace(
        waveform=drive, voltage=amplitude, voltage_bias=0.0, drive_frequency=2.0 * np.pi / float(times[-1])
    )


def read_recording(path: str | Path, units: bool) -> tuple[Array, Array]:
    """Read times, which start at 0, and voltages of a CSV file, in s and V with ``units``, else dimensionless.

    Raises `InputError` with the file and the line.
    """
    lines = read_text(Path(path), REMEDY).splitlines()
    rows = [(number, line) for number, line in enumerate(lines, 1) if line.strip() and not line.startswith("#")]
    if not rows:
        raise InputError(f"{path}: is empty; {REMEDY}")
    if len(rows) > MOST_ROWS:
        raise InputError(f"{path}: has {len(rows)} lines, of which {MOST_ROWS} are read; record fewer samples")
    places, powers = _header(path, *rows[0], units)
    found, columns = np.empty((len(rows) - 1, 2)), len(rows[0][1].split(","))
    for k, (number, line) in enumerate(rows[1:]):
        cells = line.split(",")
        if len(cells) != columns:
            raise InputError(
                f"{path}, line {number}: has {len(cells)} values, the first line {columns}; separate them by commas, "
                "and write decimals with a point"
            )
        for column, place in enumerate(places):
            found[k, column] = _number(path, number, cells[place])
    if len(found) < 2:
        raise InputError(f"{path}: has {len(found)} samples; a drive needs at least 2")
    times, voltages = found[:, 0] * 10.0 ** powers[0], found[:, 1] * 10.0 ** powers[1]
    if (wrong := np.flatnonzero(~(np.diff(times) > 0.0))).size:
        at = int(wrong[0]) + 1
        before, after = found[at - 1 : at + 1, 0]
        word = "repeats" if after == before else "goes back from"
        raise InputError(f"{path}, line {rows[at + 1][0]}: the time {after:g} {word} {before:g}; times must increase")
    return times - times[0], voltages


def _header(path: str | Path, number: int, line: str, units: bool) -> tuple[list[int], list[int]]:
    """Read the header: the indices of the columns of time and voltage, and the powers of ten of their units."""
    raw = [cell.strip().strip('"') for cell in line.split(",")]
    heads = [cell.lower() for cell in raw]
    if set(line) & set(";\t"):
        raise InputError(f"{path}, line {number}: separate the columns by commas; {REMEDY}")
    places, powers = [], []
    for name, unit in COLUMNS.items():
        at = [k for k, head in enumerate(heads) if head == name or re.match(rf"{name}\s*[(\[/]", head)]
        if len(at) != 1:
            found = "no column" if not at else f"{len(at)} columns"
            raise InputError(f"{path}, line {number}: has {found} {name!r}; {REMEDY}")
        match = _COLUMN.fullmatch(name + raw[at[0]][len(name) :])
        given = (match.group(2) or "") if match else "?"
        known = DIMENSIONS[unit].powers if units else {"": 0, "1": 0}
        if given not in known:
            takes = f"give one of {', '.join(one for one in known if one.isascii())}" if units else "give a device"
            shown = f"the unit {given!r}" if given else "no unit"
            raise InputError(f"{path}, line {number}: the column {name!r} has {shown}; {takes}")
        places.append(at[0])
        powers.append(known[given])
    return places, powers


def _number(path: str | Path, line: int, text: str) -> float:
    try:
        value = float(text) if text.isascii() and "_" not in text else math.nan
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or abs(value) > 1e20:
        shown = text.strip()[:30]
        what = f"{shown!r} is not a finite number" if shown else "a value is missing"
        raise InputError(f"{path}, line {line}: {what}; give one on each line, decimals with a point")
    return value


def needed(times: Array, values: Array) -> list[int]:
    """The indices of samples that stay, such that all others are within `WITHIN` of the peak of the lines between them.

    After each sample that stays follows the farthest one whose line passes all samples between: its slope lies in the
    intersection of the ranges of slopes to these.
    """
    allowed = WITHIN * float(np.abs(values).max())
    kept, first, low, high, last = [0], 0, -math.inf, math.inf, 1
    k, t, v = 1, times.tolist(), values.tolist()
    while k < len(t):
        span = t[k] - t[first]
        slope = (v[k] - v[first]) / span
        if low <= slope <= high:
            last = k
        low, high = max(low, slope - allowed / span), min(high, slope + allowed / span)
        if low > high or k == len(t) - 1:
            if last == len(t) - 1:
                break
            kept.append(last)
            first, low, high, k = last, -math.inf, math.inf, last + 1
            last = k
            continue
        k += 1
    return [*kept, len(t) - 1]
