"""Answers about a data sheet: a table over the voltages, the drive, and the limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gelcone.analyses.answer import heading, outcome_lines
from gelcone.words import sheet_limits, sheet_rows, sheet_single

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject

NAME_WIDTH, COLUMN_WIDTH = 30, 16


def datasheet_words(shown: xr.Dataset, subject: Subject) -> str:
    """The sheet as text."""
    lines = heading(subject) + outcome_lines(shown)
    for name, values in sheet_rows(shown):
        lines.append(f"{name:{NAME_WIDTH}s}" + "".join(f"{value:>{COLUMN_WIDTH}s}" for value in values))
    lines += [f"{name:{NAME_WIDTH}s}{value:>{COLUMN_WIDTH}s}" for name, value in sheet_single(shown)]
    return "\n".join([*lines, *sheet_limits(shown)])
