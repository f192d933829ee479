"""The answer that follows from the labels of a result: every variable by its name, every number by its long name."""

from __future__ import annotations

import re
import textwrap
from collections import Counter
from itertools import zip_longest
from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import measured, missing, sized_range, sized_with_error
from gelcone.analyses.answer import WIDTH, heading, outcome_lines, state_lines
from gelcone.codes import Outcome
from gelcone.physics.balance import PullIn
from gelcone.words import (
    MOST_LINES,
    event_label,
    members_of,
    shortened,
    unrepeated_lines,
    validity_in_words,
    varied_names,
)

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject

DIGITS = 5
YES = "1 if "
"""With this a label begins whose number is 1 for yes and 0 for no."""
FILM_STATES = r"validity_|(second_)?film_state_"
"""Names of numbers which a line of their own says of a single device, for an ensemble their mean."""
ERROR = "_standard_error"
"""Ending of the name of a standard error."""
LABEL_WIDTH = 48
"""Most letters of a line of a label in a table of members, unless there is room."""
MOST_LETTERS = 24
"""Most letters of a line of a value there."""
GAP = 2
"""Spaces between two columns."""


def table_words(shown: xr.Dataset, subject: Subject) -> str:
    """A line for each number, with a column for each of the first members of an ensemble."""
    lines = [*heading(subject), *state_lines(shown, subject), *outcome_lines(shown)]
    if shown["outcome"].dims:
        lines += [*_columns(shown), *shortened([], shown["outcome"].size)]
    else:
        rows = _rows(shown, FILM_STATES) if int(shown["outcome"]) == Outcome.OK else {}
        lines += _single_lines(rows, _reasons(shown))
    return "\n".join([*lines, *_unrepeated_lines(shown), *validity_in_words(shown)])


def _unrepeated_lines(shown: xr.Dataset) -> list[str]:
    """A line for settled motions that do not repeat, as chaotic ones: each run of them has other numbers."""
    if not {"period", "resting"} <= {*shown.data_vars}:
        return []
    moving = (shown["outcome"] == Outcome.OK) & (shown["resting"] == 0)
    return unrepeated_lines(~(moving & (shown["period"] == 0)))


def _reasons(shown: xr.Dataset) -> set[str]:
    """The words for the single numbers that have no value."""
    single = [v for v in shown.data_vars.values() if not v.dims and v.dtype.kind == "f"]
    return {missing(float(v), v) for v in single if not np.isfinite(v)}


def _single_lines(rows: dict[str, str], reasons: set[str]) -> list[str]:
    """A line for each number, below a line of what they have in common, and one line for all that have no value for the
    same reason."""
    names: dict[str, list[str]] = {}
    for label, value in rows.items():
        names.setdefault(value if value in reasons else label, []).append(label)
    lines = []
    for begin, ends in _by_begin([labels[0] for labels in names.values() if len(labels) == 1]).items():
        alike = begin != "" and len(ends) > 1
        lines += [begin.rstrip()] if alike else []
        lines += [f"  {end}: {rows[begin + end]}" if alike else f"{begin}{end}: {rows[begin + end]}" for end in ends]
    for reason, labels in names.items():
        if len(labels) > 1:
            line = f"{reason}: {'; '.join(_with_common_begin(labels))}"
            lines += textwrap.wrap(line, WIDTH, subsequent_indent="  ", break_on_hyphens=False)
    return lines


def _by_begin(labels: list[str]) -> dict[str, list[str]]:
    """The ends of labels by their words up to the last colon and its space, empty for those without one."""
    ends: dict[str, list[str]] = {}
    for label in labels:
        begin, colon, end = label.rpartition(": ")
        ends.setdefault(begin + colon, []).append(end)
    return ends


def _with_common_begin(labels: list[str]) -> list[str]:
    """Labels of which those with the same words before a colon are joined."""
    return [start + ", ".join(endings) if start else "; ".join(endings) for start, endings in _by_begin(labels).items()]


MOST_VALUES = 6
"""Most values of a series that are listed; of a longer one the smallest and the largest."""


def any_words(shown: xr.Dataset, subject: Subject) -> str:
    """The numbers of a result that no command gives: single ones as `table_words`, series by their values or ends."""
    if "outcome" in shown:
        lines = table_words(shown, subject).splitlines()
        members = members_of(shown, range(shown["outcome"].size)[:MOST_LINES])
    else:
        lines, members = heading(subject), [("", shown)]
        lines += [f"{label}: {value}" for label, value in _rows(shown).items()]
    for name, member in members:
        series = series_lines(member)
        lines += [f"{name}:", *(f"  {line}" for line in series)] if name and series else series
    return "\n".join(lines)


def series_lines(shown: xr.Dataset) -> list[str]:
    """A line for each variable and axis of several numbers or names: its values or, of many, the ends."""
    series = [v for v in shown.data_vars.values() if v.dims and v.size]
    axes = [shown[dim] for dim in dict.fromkeys(d for v in series for d in v.dims) if dim in shown.coords]
    return [f"{v.attrs.get('long_name', v.name)}: {_series(v)}" for v in (*axes, *series) if v.dtype.kind in "bfiuOU"]


def _series(variable: xr.DataArray) -> str:
    """The values of a variable one by one or, of many, how many there are and their ends."""
    flat = variable.stack(flat=variable.dims) if variable.ndim > 1 else variable
    if flat.size <= MOST_VALUES:
        return ", ".join(measured(one) if flat.dtype.kind in "OU" else _value(one) for one in flat)
    count = f"{' x '.join(map(str, variable.shape))} values"
    if flat.dtype.kind in "OU":
        return count
    if flat.dtype.kind == "b" or "flag_meanings" in variable.attrs:
        names = Counter(_value(one) for one in flat)
        return ", ".join(f"{name} in {number} of {flat.size}" for name, number in names.items())
    known = flat.values[np.isfinite(flat.values)]
    if not known.size:
        return f"{missing(np.nan, variable)} in {count}"
    low, high = (flat[0].copy(data=end) for end in (known.min(), known.max()))
    return f"{sized_range(low, high)} in {count}"


def _columns(shown: xr.Dataset) -> list[str]:
    """The first members side by side, what is the same for all of them, and which of them failed."""
    members = members_of(shown, range(shown["outcome"].size)[:MOST_LINES])
    solved = [member for _, member in members if int(member["outcome"]) == Outcome.OK]
    failed = [name for name, member in members if int(member["outcome"]) != Outcome.OK]
    lines = textwrap.wrap("failed: " + "; ".join(failed), WIDTH, subsequent_indent="  ") if failed else []
    if not solved:
        return lines
    member_rows = [_rows(member) for member in solved]
    rows = [[label, *(cells[label] for cells in member_rows)] for label in member_rows[0]]
    same = [row for row in rows if len(solved) > 1 and len(set(row[1:])) == 1]
    head = [[name, *(measured(member[name]) for member in solved)] for name in varied_names(shown)]
    table = [*head, *(row for row in rows if row not in same)]
    for_all = [f"for each of the {len(solved)}:", *(f"  {label}: {value}" for label, value, *_ in same)] if same else []
    return [*(side_by_side(table) if table else []), *for_all, *lines]


def side_by_side(rows: list[list[str]]) -> list[str]:
    """Rows of a label and values as lines, as many of the columns at a time as fit the width."""
    widths = [min(max(map(len, column)), MOST_LETTERS) for column in list(zip(*rows, strict=True))[1:]]
    room = max(LABEL_WIDTH, WIDTH - sum(widths) - GAP * len(widths))
    label_width = max(len(line) for row in rows for line in textwrap.wrap(row[0], room))
    fit = max(1, (WIDTH - label_width) // (GAP + max(widths)))
    lines: list[str] = []
    for start in range(0, len(widths), fit):
        those = slice(start, start + fit)
        lines += [""] if start else []
        for label, *values in rows:
            lines += _row_lines(label, label_width, values[those], widths[those])
    return lines


def _row_lines(label: str, label_width: int, values: list[str], widths: list[int]) -> list[str]:
    """A row of a table: a label at the left and values at the right of their columns, wrapped where they are long."""
    cells = [textwrap.wrap(label, label_width), *(textwrap.wrap(v, w) for v, w in zip(values, widths, strict=True))]
    return [
        (
            f"{parts[0]:{label_width}}"
            + "".join(f"{' ' * GAP}{v:>{w}}" for v, w in zip(parts[1:], widths, strict=True))
        ).rstrip()
        for parts in zip_longest(*cells, fillvalue="")
    ]


def _rows(member: xr.Dataset, apart: str = r"validity_") -> dict[str, str]:
    """The text of each number of one member but those whose names match ``apart``, by its label; one whose error the
    member has with it, as ``onset_voltage`` with ``onset_error``."""
    errors = {name: error for name in map(str, member) if (error := _error_name(name)) in member}
    return {
        variable.attrs["long_name"].removeprefix(YES): _value(variable, member.get(errors.get(str(name), "")))
        for name, variable in member.data_vars.items()
        if not variable.dims and name not in ("outcome", *errors.values()) and not re.match(apart, str(name))
    }


def _error_name(name: str) -> str:
    """The name under which a result has the error of a number."""
    return name.replace("_voltage", "_error") if name.endswith("_voltage") else f"{name}{ERROR}"


def _value(variable: xr.DataArray, error: xr.DataArray | None = None) -> str:
    """A number with its unit and its ``error``; the meaning of a code; yes or no."""
    if variable.dtype.kind == "b":
        return "yes" if variable else "no"
    if variable.name == "pull_in_kind":
        return PullIn(int(variable)).meaning
    if "flag_meanings" in variable.attrs and float(variable) in variable.attrs["flag_values"]:
        return event_label(variable)
    if variable.attrs.get("long_name", "").startswith(YES):
        return "yes" if variable else "no"
    return sized_with_error(variable, error, DIGITS)
