"""Recorded drives: a table of times and voltages becomes the waveform of a device or a model."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from gelcone.devices.device import Device
from gelcone.devices.reading import TIME, VOLTAGE, Table, plain_unit, read_table
from gelcone.errors import InputError, check_path
from gelcone.physics.model import ConeModel
from gelcone.physics.waveforms import MOST_PIECES, Samples
from gelcone.quantity import Array

REMEDY = 'give a table whose header is "time (s), voltage (V)"'
COLUMNS = {"time": (TIME, "s"), "voltage": (VOLTAGE, "V")}
"""Columns of a recording: names by which they are recognised, and SI unit."""
WITHIN = 1e-4
"""Largest distance, over the peak, of left-out samples from the straight lines between the others."""
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
    """Return a device, or a model, that is driven by the voltages of a measured table.

    The amplitude of the returned drive is the file's largest voltage, and its frequency one over the file's duration,
    so that other values stretch the drive.

    Parameters
    ----------
    model : a device, or a model; the file of a model holds dimensionless times and voltages without units.
    path : a table (CSV, MATLAB, HDF5): the columns ``time`` and ``voltage`` with their units, as in
        ``time (ms), voltage (kV)``. What is interpreted, such as decimal commas, is stated in a warning.
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
    """Read times, which start at 0, and voltages of a table, in s and V with ``units``, else dimensionless.

    Raises `InputError` with the file and the line.
    """
    table = read_table(Path(path))
    times, voltages = (_column(table, role, units) for role in COLUMNS)
    if times.size < 2:
        raise InputError(f"{table.file}: has {times.size} samples; a drive needs at least 2")
    if (wrong := np.flatnonzero(~(np.diff(times) > 0.0))).size:
        at = int(wrong[0]) + 1
        before, after = times[at - 1 : at + 1]
        word = "repeats" if after == before else "goes back from"
        in_s = " s" if units else ""
        raise InputError(
            f"{table.file}, line {table.lines[at]}: the time {after:g}{in_s} {word} {before:g}{in_s}; times must "
            "increase"
        )
    table.warn()
    return times - times[0], voltages


def _column(table: Table, role: str, units: bool) -> Array:
    """The times or the voltages of a recording."""
    names, unit = COLUMNS[role]
    name = table.find(names)
    if name is None:
        raise InputError(f"{table.header}: has no column {role!r}; {REMEDY}")
    given = table.columns[name].unit
    if units and given is None:
        raise InputError(table.without_unit(name, unit))
    if not units and plain_unit(given or ""):
        raise InputError(f"{table.header}: column {name!r} is in {given}, and a model has no units; give a device")
    size = table.size_of(name, given or "", unit) if units else 1.0
    return table.numbers(name, role, whole=True) * size


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
