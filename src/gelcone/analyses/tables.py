"""The answer that follows from the labels of a result: every variable by its name, every number by its long name."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gelcone.analyses.answer import heading, member_lines, outcome_lines, state_lines
from gelcone.codes import Outcome
from gelcone.words import event_label, measured, validity_in_words

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject


def table_words(shown: xr.Dataset, subject: Subject) -> str:
    """A line for each number, or for each member of an ensemble."""
    lines = [*heading(subject), *state_lines(shown, subject), *outcome_lines(shown)]
    if shown["outcome"].dims:
        return "\n".join(
            [*lines, *member_lines(shown, lambda member: "; ".join(_rows(member))), *validity_in_words(shown)]
        )
    return "\n".join([*lines, *_rows(shown), *validity_in_words(shown)])


def _rows(member: xr.Dataset) -> list[str]:
    """A line for each number of one member."""
    if int(member["outcome"]) != Outcome.OK:
        return ["failed"]
    return [
        f"{variable.attrs['long_name']}: {_value(variable)}"
        for name, variable in member.data_vars.items()
        if not variable.dims and name != "outcome" and not str(name).startswith("validity_")
    ]


def _value(variable: xr.DataArray) -> str:
    """A number with its unit; the meaning of a code."""
    return event_label(variable) if "flag_meanings" in variable.attrs else measured(variable, 5)
