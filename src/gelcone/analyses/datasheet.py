"""Answers about a data sheet: a table over the voltages, the drive, and the limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gelcone.analyses.answer import heading, outcome_lines
from gelcone.words import sheet_limits, sheet_rows, sheet_single

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject

NAME_WIDTH, COLUMN_WIDTH, INTERVAL_WIDTH = 30, 16, 28


def datasheet_words(shown: xr.Dataset, subject: Subject) -> str:
    """The sheet as text."""
    lines = heading(subject) + outcome_lines(shown)
    count = int((shown["constant_voltage"] > 0.0).sum())
    rows = sheet_rows(shown)
    longest = [2 + max(map(len, column)) for column in zip(*(values for _, values in rows), strict=True)]
    widths = list(map(max, [COLUMN_WIDTH] * count + [INTERVAL_WIDTH], longest))
    for name, values in rows:
        lines.append(f"{name:{NAME_WIDTH}s}" + "".join(f"{v:>{w}s}" for v, w in zip(values, widths, strict=True)))
    single = sheet_single(shown)
    width = max(COLUMN_WIDTH, *(len(value) for _, value in single))
    lines += [f"{name:{NAME_WIDTH}s}{value:>{width}s}" for name, value in single]
    return "\n".join([*lines, *sheet_limits(shown)])
