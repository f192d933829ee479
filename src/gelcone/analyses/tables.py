"""The answer that follows from the labels of a result: every variable by its name, every number by its long name."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from gelcone.analyses.answer import heading, member_lines, outcome_lines, state_lines
from gelcone.codes import Outcome
from gelcone.physics.balance import PullIn
from gelcone.words import event_label, measured, sized, validity_in_words

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject

DIGITS = 5
SMALL = 1e-2
"""A number below this in its usual unit has one in which it reads better."""
YES = "1 if "
"""With this a label begins whose number is 1 for yes and 0 for no."""
FILM_STATES = r"validity_|(second_)?film_state_"
"""Names of numbers which a line of their own says of a single device, for an ensemble their mean."""


def table_words(shown: xr.Dataset, subject: Subject) -> str:
    """A line for each number, or for each member of an ensemble."""
    lines = [*heading(subject), *state_lines(shown, subject), *outcome_lines(shown)]
    if shown["outcome"].dims:
        return "\n".join(
            [*lines, *member_lines(shown, lambda member: "; ".join(_rows(member))), *validity_in_words(shown)]
        )
    return "\n".join([*lines, *_rows(shown, FILM_STATES), *validity_in_words(shown)])


def _rows(member: xr.Dataset, apart: str = r"validity_") -> list[str]:
    """A line for each number of one member but those whose names match ``apart``."""
    if int(member["outcome"]) != Outcome.OK:
        return ["failed"]
    return [
        f"{variable.attrs['long_name'].removeprefix(YES)}: {_value(variable)}"
        for name, variable in member.data_vars.items()
        if not variable.dims and name != "outcome" and not re.match(apart, str(name))
    ]


def _value(variable: xr.DataArray) -> str:
    """A number with its unit; the meaning of a code; yes or no."""
    if variable.name == "pull_in_kind":
        return PullIn(int(variable)).meaning
    if "flag_meanings" in variable.attrs and float(variable) in variable.attrs["flag_values"]:
        return event_label(variable)
    if variable.attrs["long_name"].startswith(YES):
        return "yes" if variable else "no"
    return sized(variable, DIGITS) if 0.0 < abs(float(variable)) < SMALL else measured(variable, DIGITS)
