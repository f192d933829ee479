"""Answers about kinds of motion: Lyapunov exponents and regimes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.analyses.answer import (
    counts_text,
    doubt_lines,
    exponent_unit,
    heading,
    member_lines,
    outcome_lines,
    periods_json,
    variable_json,
)
from gelcone.words import (
    SIGNS,
    evidence_in_words,
    exponent_in_words,
    lasting,
    outcome_in_words,
    rate_unit,
    unit_of,
    validity_in_words,
    with_error,
)

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject


def _time(variable: xr.DataArray) -> str:
    """The unit of a time."""
    return unit_of(variable) or " time units"


# --- exponents --------------------------------------------------------------------------------------------------------


def lyapunov_json(result: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object of Lyapunov exponents."""
    evidence = ("standard_error", "finite", "sign", "sum_residual", "averaged_time")
    return {
        "lyapunov": {
            "values": result["lyapunov"],
            **{name: variable_json(result, name) for name in evidence},
            "cycle": periods_json(result["cycle"]),
            "per_repeat": result["per_repeat"],
            "unit": exponent_unit(result["lyapunov"]),
        }
    }


def lyapunov_words(shown: xr.Dataset, subject: Subject) -> str:
    """Lyapunov exponents as text."""
    lines = heading(subject) + outcome_lines(shown)
    if not shown["outcome"].dims:
        return "\n".join(lines + _exponents(shown))
    return "\n".join([*lines, "largest exponent in the long run:", *member_lines(shown, _largest)])


def _largest(member: xr.Dataset) -> str:
    """The largest exponent in one line."""
    if int(member["outcome"]):
        return f"failed, {outcome_in_words(int(member['outcome']))}"
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
    finite = " and ".join(f"{float(value):+.4g}" for value in member["finite"])
    window, averaged = float(member["finite_time"].max()), float(member["averaged_time"])
    unit, period = _time(member["averaged_time"]), int(member["cycle"])
    source = f"averaged over {lasting(averaged, member['averaged_time'], 4)} after the transient"
    if period:
        cycle = "rest or a cycle of 1 forcing period" if period == 1 else f"a cycle of {period} forcing periods"
        source = f"from the multipliers of what it settles on, {cycle}"
    return [
        f"largest exponent {_largest(member)}",
        f"second exponent {second} {at}; the sum of all is off the mean trace by {residual:.1g}",
        source,
        f"over the first {window:.4g}{unit} from the start: {finite} {at}",
    ]


_KIND = ("regime", "period", "symmetric")


# --- regimes ----------------------------------------------------------------------------------------------------------


def regime_json(result: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object of kinds of motion."""
    evidence = {
        "lyapunov": {
            "values": result["lyapunov"],
            **{name: variable_json(result, name) for name in ("standard_error", "sign", "averaged_time")},
            "unit": exponent_unit(result["lyapunov"]),
        },
        **{name: result[name] for name in ("return_distance", "cycle_distance", "zero_one")},
        **{name: result[name] for name in ("lowest", "highest", "settled_time")},
        "section": {"displacement": result["section"][..., 0], "velocity": result["section"][..., 1]},
        **{name: variable_json(result, name) for name in ("coexisting", "doubtful")},
    }
    kind = {"name" if name == "regime" else name: variable_json(result, name) for name in _KIND}
    fates = {name: variable_json(result, f"fate_{name}") for name in ("regime", "period", "share")}
    ends = {"share_interval": _interval(result, "fate_share")}
    return {"regime": {**kind, "lasting": _lasting_json(result), "fates": fates | ends, "evidence": evidence}}


def _lasting_json(result: xr.Dataset) -> dict[str, Any]:
    """How long chaos lasts, null where there is none; a lifetime of which no end was seen is null too."""
    seen = {name: result[name] for name in ("seen_until", "share_chaotic", "lifetime")}
    return seen | {"lifetime_interval": _interval(result, "lifetime")}


def _interval(result: xr.Dataset, name: str) -> Any:
    """Both ends of a variable's interval side by side."""
    import xarray as xr

    ends = [result[f"{name}_{end}"] for end in ("low", "high")]
    both = np.stack([end.values for end in ends], axis=-1)
    return xr.DataArray(both, dims=(*ends[0].dims, "end"), attrs=ends[0].attrs)


def regime_words(shown: xr.Dataset, subject: Subject) -> str:
    """Kinds of motion as text."""
    lines = heading(subject) + outcome_lines(shown)
    if not shown["outcome"].dims:
        return "\n".join(lines + _evidence(shown) + validity_in_words(shown))
    members = member_lines(shown, lambda member: "; ".join(_evidence(member)[:2]))
    return "\n".join([*lines, counts_text(shown), *doubt_lines(shown), *validity_in_words(shown), *members])


def _evidence(member: xr.Dataset) -> list[str]:
    """The kind of one motion, the evidence for it, its extent, and the times behind it."""
    lines = evidence_in_words(member)
    if int(member["outcome"]):
        return lines
    unit, time = unit_of(member["lowest"]), member["averaged_time"]
    lines.insert(2, f"displacement {float(member['lowest']):.4g} to {float(member['highest']):.4g}{unit}")
    settled, averaged = float(member["settled_time"]), float(member["averaged_time"])
    if np.isfinite(settled):
        of_cycle = np.isfinite(member["cycle_distance"])
        source = "of the cycle" if of_cycle else f"averaged over {lasting(averaged, time, 4)}"
        lines.append(f"settled for {lasting(settled, time, 4)}, exponents {source}")
    return lines
