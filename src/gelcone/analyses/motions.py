"""Answers about kinds of motion: Lyapunov exponents and regimes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import lasting, rate_unit, sized_range, with_error
from gelcone.analyses.answer import (
    counts_text,
    doubt_lines,
    heading,
    member_lines,
    outcome_lines,
)
from gelcone.codes import Outcome, Regime
from gelcone.words import SIGNS, evidence_in_words, exponent_in_words, unrepeated_lines, validity_in_words

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject


# --- exponents --------------------------------------------------------------------------------------------------------


def lyapunov_words(shown: xr.Dataset, subject: Subject) -> str:
    """Lyapunov exponents as text."""
    lines = heading(subject) + outcome_lines(shown)
    if not shown["outcome"].dims:
        return "\n".join(lines + _exponents(shown))
    return "\n".join([*lines, "largest exponent in the long run:", *member_lines(shown, _largest)])


def _largest(member: xr.Dataset) -> str:
    """The largest exponent in one line."""
    if int(member["outcome"]):
        return f"failed, {Outcome(int(member['outcome'])).words}"
    value, error = float(member["lyapunov"][0]), float(member["standard_error"][0])
    period = float(member["per_repeat"]) / value if value else 0.0
    return (
        f"{exponent_in_words(member)} ({with_error(value * period, error * period)} per forcing period), "
        f"{SIGNS[int(member['sign'])]}"
    )


def _exponents(member: xr.Dataset) -> list[str]:
    """The exponents of one run, what they rest on, and those over the finite window."""
    if int(member["outcome"]):
        return []
    at, residual = rate_unit(member["lyapunov"]), abs(float(member["sum_residual"]))
    second = with_error(float(member["lyapunov"][1]), float(member["standard_error"][1]))
    known = f"the sum of all is off the mean trace by {residual:.1g} {at}, 0 without rounding"
    lost = "not all are known: rounding hides fast decays"
    errors = member.get("finite_standard_error", 0.0 * member["finite"])  # files of earlier versions have none
    finite = ", ".join(map(with_error, member["finite"].values, errors.values))
    window, averaged = float(member["finite_time"].max()), float(member["averaged_time"])
    time, period = member["averaged_time"], int(member["cycle"])
    source = f"averaged over {lasting(averaged, time, 4)} after the transient"
    if period:
        cycle = "rest or a cycle of 1 forcing period" if period == 1 else f"a cycle of {period} forcing periods"
        source = f"from the multipliers of what it settles on, {cycle}"
    return [
        f"largest exponent {_largest(member)}",
        f"second exponent {second} {at}; {known if np.isfinite(residual) else lost}",
        source,
        f"over the first {lasting(window, time, 4)} from the start: {finite} {at}",
    ]


# --- regimes ----------------------------------------------------------------------------------------------------------


def regime_words(shown: xr.Dataset, subject: Subject) -> str:
    """Kinds of motion as text."""
    lines = heading(subject) + outcome_lines(shown)
    if not shown["outcome"].dims:
        return "\n".join(lines + _evidence(shown) + validity_in_words(shown))
    members = member_lines(shown, lambda member: "; ".join(_evidence(member)[:2]))
    return "\n".join([*lines, counts_text(shown), *doubt_lines(shown), *validity_in_words(shown), *members])


triptych_words = regime_words


def _evidence(member: xr.Dataset) -> list[str]:
    """The kind of one motion, the evidence for it, its extent, and the times behind it."""
    lines = evidence_in_words(member)
    if int(member["outcome"]):
        return lines
    time = member["averaged_time"]
    lines.insert(2, f"displacement {sized_range(member['lowest'], member['highest'])}")
    settled, averaged = float(member["settled_time"]), float(member["averaged_time"])
    if np.isfinite(settled):
        of_cycle = np.isfinite(member["cycle_distance"])
        source = "of the cycle" if of_cycle else f"averaged over {lasting(averaged, time, 4)}"
        lines.append(f"examined after {lasting(settled, time, 4)}; exponents {source}")
    repeats = int(member["regime"]) not in {Regime.CHAOTIC, Regime.QUASI_PERIODIC}
    return [*lines, *unrepeated_lines(repeats)]
