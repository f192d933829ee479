"""Results in words, the same in figures, on the command line and in reports."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.amounts import (
    lasting,
    measured,
    rate_unit,
    sized,
    sized_alike,
    sized_range,
    time_unit,
    unit_of,
    with_error,
)
from gelcone.codes import Outcome, Regime, meanings
from gelcone.motion.proportion import IN_PROPORTION, PROPORTIONAL, held_at_peak

if TYPE_CHECKING:
    import xarray as xr

SIGNS = {-1: "certainly negative", 0: "sign uncertain within the budget", 1: "certainly positive"}
"""What is known of the sign of the largest exponent."""
DISCORD = "the evidence disagrees"
"""What is doubtful about a kind of motion."""

# --- data sheets ------------------------------------------------------------------------------------------------------

SHEET_ROWS = {
    "blocked_force": "blocked force",
    "stroke": "free stroke",
    "stiffness_at_rest": "stiffness under voltage",
    "stroke_work": "work of a stroke (out alone)",
    "load_work": "  of it on a constant load",
    "volume_work": "  over film volume",
    "mass_work": "  over moving mass",
    "volume_power": "power over film volume",
    "mass_power": "power over moving mass",
    "coupling": "coupling factor, squared",
    "capacitance": "capacitance",
    "field_energy": "energy of the field",
    "natural_frequency": "natural frequency",
    "half_width": "  half width at half power",
    "bandwidth": "bandwidth, to half power",
    "rise_time": "rise time of a small step",
}
"""Numbers of a data sheet over constant voltages, and what they are called there."""
SHEET_DRIVE = {
    "drive_stroke": "stroke of the drive",
    "peak_current": "peak current",
    "apparent_power": "apparent power",
    "mean_power": "mean power supplied",
}


SHEET_WIDTH = 104
"""Letters of a line below a data sheet."""


def sheet_rows(sheet: xr.Dataset) -> list[tuple[str, list[str]]]:
    """The rows of a data sheet over its voltages above 0: name and values with units; of draws also the 95 % interval
    at the highest voltage."""
    shown = sheet.isel(constant_voltage=sheet["constant_voltage"].values > 0.0)
    count, last = shown.sizes["constant_voltage"], shown.isel(constant_voltage=-1)
    of_film = ", first film" if "ramp_begin_voltage" in sheet else ""
    rows = {"constant_voltage": f"constant voltage{of_film}", **SHEET_ROWS}
    resonance = float(shown["natural_frequency"].max()) if shown["natural_frequency"].notnull().any() else 0.0
    among = {"half_width": resonance}  # in the unit of the frequency above it
    table_rows = [
        (words, [sized_alike(shown[name][k : k + 1], among=among.get(name, 0.0))[0] for k in range(count)])
        for name, words in rows.items()
    ]
    if is_toleranced(sheet):
        for (_, values), name in zip(table_rows, rows, strict=True):
            at = f"95 % at {sized(last['constant_voltage'])}"
            values.append(at if name == "constant_voltage" else interval_in_words(last, name))
    return table_rows


def is_toleranced(sheet: xr.Dataset) -> bool:
    """Whether a data sheet has the intervals of draws."""
    return "drawn" in sheet.attrs


def interval_in_words(sheet: xr.Dataset, name: str) -> str:
    """The 95 % interval of a number of a data sheet over the draws."""
    return sized_range(sheet[f"{name}_low"], sheet[f"{name}_high"], 3)


def sheet_single(sheet: xr.Dataset) -> list[tuple[str, str]]:
    """The single numbers of a data sheet: the rest, and the settled motion under the drive."""
    rest = sheet["stiffness_at_rest"].isel(constant_voltage=0)
    rows = [("rest height", sized(sheet["rest_displacement"])), ("stiffness at rest", sized(rest))]
    if sheet["apparent_power"].notnull():
        rows += [(words, sized(sheet[name])) for name, words in SHEET_DRIVE.items()]
    if not is_toleranced(sheet):
        return rows
    still = sheet.isel(constant_voltage=0)
    names = ["rest_displacement", "stiffness_at_rest", *SHEET_DRIVE][: len(rows)]
    return [
        (words, f"{value} ({interval_in_words(still, name)})") for (words, value), name in zip(rows, names, strict=True)
    ]


def sheet_limits(sheet: xr.Dataset) -> list[str]:
    """Pull-in, of the membrane and of the cone that stands for it, the first limit of the drive, and the voltage below
    all limits."""
    within = {
        name: f", 95 % within {interval_in_words(sheet, name)}" if is_toleranced(sheet) else ""
        for name in ("membrane_pull_in_voltage", "pull_in_voltage", "first_limit_voltage", "safe_peak_voltage")
        if name in sheet
    }
    whose = f" of the {sheet.attrs['pull_in_of']}" if "pull_in_of" in sheet.attrs else ""
    films = {"pull_in_voltage": whose}
    if "membrane_pull_in_voltage" in sheet:
        films = {"membrane_pull_in_voltage": " of the membrane", "pull_in_voltage": " of the cone"}
    bias = f" at the bias of {sized(sheet['ramp_begin_voltage'])}" if "ramp_begin_voltage" in sheet else ""
    lines = [
        f"pull-in{of_film} under constant voltage{bias}: {sized(sheet[name])}{within[name]}"
        for name, of_film in films.items()
    ]
    if "first_limit_voltage" in sheet:
        lines += _first_limit(sheet, within)
    if is_toleranced(sheet):
        failed = f", of which {sheet.attrs['failed']} have no state" if sheet.attrs["failed"] else ""
        named = json.loads(sheet.attrs["drawn"]).items()
        every = ", ".join(
            f"{name} {deviation[0]:.3g} ± {deviation[1]:.2g}"
            if isinstance(deviation, list)
            else f"{name} {100.0 * deviation:.2g} %"
            for name, deviation in named
        )
        text = f"tolerances: within these intervals lie 95 % of {sheet.attrs['draws']} draws{failed}, of {every}"
        lines += textwrap.wrap(text, SHEET_WIDTH, subsequent_indent="  ")
    return lines


def _first_limit(sheet: xr.Dataset, within: dict[str, str]) -> list[str]:
    """The first limit of the drive and the voltage below all limits, each with its interval ``within``."""
    opposite = held_at_peak(sheet)
    first, proportion = str(sheet.attrs["first_limit"]), IN_PROPORTION * opposite
    slow = "of the drive held at its peak" if opposite else "on a slow ramp"
    way = "of the drive" if first.startswith("driven ") else slow
    peak = f" {way}, at a peak of {sized(sheet['first_limit_voltage'])}{within['first_limit_voltage']}{proportion}"
    safe = f"{sized(sheet['safe_peak_voltage'])}{within['safe_peak_voltage']}{proportion}"
    named = {"driven pull-in": f"{sheet.attrs.get('pull_in_of')} pull-in", "pull-in": "cone pull-in"}
    limit_name = (named if "membrane_pull_in_voltage" in sheet else {}).get(first, first.removeprefix("driven "))
    lines = [
        f"first limit: {limit_name}{'' if np.isinf(sheet['first_limit_voltage']) else peak}",
        f"below every limit: peaks up to {safe}",
    ]
    if sheet[f"{PROPORTIONAL * opposite}dielectric_breakdown_voltage"].isnull():
        lines.append("dielectric strength: unknown, breakdown is not accounted for")
    return lines


# --- motions ----------------------------------------------------------------------------------------------------------


def motion_in_words(regime: int, period: int = 0, symmetric: bool = False) -> str:
    """A kind of motion, with its period in forcing periods and its symmetry where it has them, and what chaos ends
    in."""
    if regime == Regime.TRANSIENT_CHAOS:
        end = motion_in_words(Regime.PERIODIC, period, symmetric) if period else Regime.REST.label
        return f"{Regime(regime).label}, ends {'' if period else 'at '}{end}"
    if regime != Regime.PERIODIC:
        return Regime(regime).label
    return f"periodic, period {period}{', symmetric' if symmetric else ''}"


UNREPEATED = "not repeat: numbers are of one run, those of another differ"


def unrepeated_lines(repeats: Any) -> list[str]:
    """A line for motions, ``repeats`` saying of each whether it does, that do not repeat, as chaotic ones: each run of
    them has other numbers."""
    known = np.ravel(repeats)
    count = int((~known.astype(bool)).sum())
    which = "the motion does" if known.size == 1 else f"{count} of {known.size} motions do"
    return [f"{which} {UNREPEATED}"] if count else []


def failed_in_words(outcomes: Any) -> str:
    """The ending of runs that did not reach their end, in two or three words, where all have one that is not a failure:
    pulled in, or impossible."""
    failed = set(np.unique(outcomes)) - {Outcome.OK}
    return next((one.words for one in (Outcome.PULLED_IN, Outcome.IMPOSSIBLE) if failed == {one}), "run failed")


def exponent_in_words(member: xr.Dataset) -> str:
    """The largest exponent of one run with its error and unit; ``lyapunov`` holds all of them."""
    exponent = with_error(float(member["lyapunov"][0]), float(member["standard_error"][0]))
    return f"{exponent} {rate_unit(member['lyapunov'])}"


def evidence_in_words(member: xr.Dataset) -> list[str]:
    """The kind of one motion and the evidence for it, line by line."""
    if int(member["outcome"]):
        return [f"failed: {Outcome(int(member['outcome'])).words}"]
    period, mirror = int(member["period"]), bool(member["symmetric"])
    lines = [
        motion_in_words(int(member["regime"]), period, mirror),
        f"largest exponent {exponent_in_words(member)}",
    ]
    lines += lasting_in_words(member)
    if np.isfinite(member["zero_one"]):
        lines.append(f"0-1 test {float(member['zero_one']):.2f}")
    if np.isfinite(member["cycle_distance"]):
        lines.append(f"settled (within {float(member['cycle_distance']):.0e} of its size)")
    elif period:
        lines.append(f"points return to within {float(member['return_distance']):.0e} of its size")
    if int(member["doubtful"]):
        lines.append(f"! {DISCORD}")
    return lines


def lasting_in_words(member: xr.Dataset) -> list[str]:
    """The lifetime of the chaos of one motion, and where nearby starts end."""
    if "lifetime" not in member or np.isnan(member["lifetime"]):
        return _fates_in_words(member) if "fate_regime" in member else []
    low, mean, high = (float(member[name]) for name in ("lifetime_low", "lifetime", "lifetime_high"))
    starts, of = int(member["starts"]), member["lifetime"]
    left = round(float(member["share_chaotic"]) * starts)
    if left == starts:
        seen = f"persisted for at least {lasting(float(member['chaotic_until']), of, 4)}"
        return [f"{seen}; mean lifetime above {lasting(low, of)}" if starts > 1 else seen]
    size, unit = time_unit(mean, of)
    times = f"chaos lasts {mean / size:.2g} [{low / size:.2g}, {high / size:.2g}]{unit} in the mean"
    return [f"{times}; {left} of {starts} nearby starts are still chaotic", *_fates_in_words(member)]


def _fates_in_words(member: xr.Dataset) -> list[str]:
    """List the motions in which nearby starts end, if they differ."""
    regimes, periods = member["fate_regime"].values, member["fate_period"].values
    shares = zip(*(member[f"fate_share{end}"].values for end in ("", "_low", "_high")), strict=True)
    names, fates = set[str](), list[str]()
    for regime, period, (share, low, high) in zip(regimes, periods, shares, strict=True):
        if regime >= 0:
            name = motion_in_words(int(regime), int(period))
            fates.append(f"{'another ' * (name in names)}{name} {share:.0%} [{low:.0%}, {high:.0%}]")
            names.add(name)
    return ["starts within 1e-9 end as: " + "; ".join(fates)] if len(fates) > 1 else []


def attractor_in_words(attractor: xr.Dataset) -> str:
    """Regime, period, share and extent of one attractor."""
    regime, period = int(attractor["attractor_regime"]), int(attractor["attractor_period"])
    # What lies below 1e-6 is rounding; adding 0 turns -0 into 0.
    low, high = (round(float(attractor[f"attractor_{end}"]), 6) + 0.0 for end in ("lowest", "highest"))
    unit = unit_of(attractor["attractor_lowest"])
    returns = regime in (Regime.REST, Regime.PERIODIC)
    unstable = ", unstable" if returns and float(attractor["attractor_lyapunov"]) > 0.0 else ""
    where = f"at {high:.3g}{unit}" if regime == Regime.REST else f"from {low:.3g} to {high:.3g}{unit}"
    name = motion_in_words(regime, period)
    return f"{name}{unstable}: {100.0 * float(attractor['attractor_share']):.3g} %\n{where}"


def kinds_of_motion(sweep: xr.Dataset) -> dict[str, xr.DataArray]:
    """Ways in which the motion of one frequency sweep departs from the drive's period -> where; not failed runs or
    rests."""
    # files of earlier versions give a rest the period 1
    moving = ~sweep["resting"].astype(bool) if "resting" in sweep else True
    return {
        "subharmonic": sweep["period"] > 1,
        "not periodic": (sweep["period"] == 0) & (sweep["outcome"] == Outcome.OK) & moving,
    }


def regime_counts(cells: xr.Dataset) -> dict[str, int]:
    """Kind of motion -> number of cells, of those that occur."""
    codes = cells["regime"].values.ravel()
    return {kind.label: int((codes == kind).sum()) for kind in Regime if (codes == kind).any()}


# --- validity ---------------------------------------------------------------------------------------------------------

FAILINGS = {
    "hoop_slack": "hoop slack",
    "meridional_slack": "meridional slack",
    "breakdown": "above breakdown",
    "near_limit": "near the stretch limit",
    "beyond_membrane": "above membrane pull-in",
    "pulled_in": "pulled in",
}
"""Names of the assumptions of `gelcone.motion.validity` -> what is wrong, in two or three words."""
UNKNOWN_STRENGTH = "breakdown unknown: the dielectric strength is not given"


def validity_in_words(result: xr.Dataset) -> list[str]:
    """State the share of the motion, or the number of motions, for which the model does not hold; empty if unknown.

    A film that wrinkles may be slack: of it the shares of its states come first.
    """
    states = film_state_in_words(result)
    shares = {
        words: result[f"validity_{name}"].values for name, words in FAILINGS.items() if f"validity_{name}" in result
    }
    known = {words: share[np.isfinite(share)] for words, share in shares.items()}
    count = max((share.size for share in known.values()), default=0)
    if not count:
        return []
    failing = {words: share[share > 0.0] for words, share in known.items() if (share > 0.0).any()}
    holds = (
        "the model holds: film away from its limits" if states else "the model holds: film taut, away from its limits"
    )
    lines = [*states, _how_often(failing, count) if failing else holds]
    return [*lines, *strength_in_words(result)]


def strength_in_words(result: xr.Dataset) -> list[str]:
    """Say that the dielectric strength is missing, where the film's states are known and not whether it breaks down."""
    held, field = (np.isfinite(result[f"validity_{name}"]).any() for name in ("near_limit", "breakdown"))
    return [UNKNOWN_STRENGTH] if held and not field else []


def film_state_in_words(result: xr.Dataset) -> list[str]:
    """State the share of the time of wrinkling films in each state, the mean of all motions; empty for others."""
    lines = []
    for prefix, film in (("", "film"), ("second_", "second film")):
        start = f"{prefix}film_state_"
        shares = {str(n).removeprefix(start): v.values for n, v in result.items() if str(n).startswith(start)}
        known = {name: share[np.isfinite(share)] for name, share in shares.items()}
        if not known or not all(share.size for share in known.values()):
            continue
        over = "share of the time" if max(share.size for share in known.values()) == 1 else "mean share of the time"
        states = ", ".join(f"{name.replace('_', ' ')} {100.0 * share.mean():.1f} %" for name, share in known.items())
        lines.append(f"{film} ({over}): {states}")
    return lines


def _how_often(failing: dict[str, Any], count: int) -> str:
    if count == 1:
        parts = [f"{words} {100.0 * share[0]:.3g} %" for words, share in failing.items()]
        return f"share of the motion in which the model does not hold: {', '.join(parts)}"
    parts = [
        f"{words} in {share.size} (up to {100.0 * share.max():.3g} % of the motion)" for words, share in failing.items()
    ]
    return f"of {count} motions the model does not hold in: {', '.join(parts)}"


# --- lists and members ------------------------------------------------------------------------------------------------

MOST_LINES = 20
"""Most lines of a list; the rest are counted."""


def shortened(lines: list[str], count: int | None = None) -> list[str]:
    """At most `MOST_LINES` lines, and how many more there are of ``count`` in all (default: of the lines)."""
    more = (len(lines) if count is None else count) - MOST_LINES
    return lines if more <= 0 else [*lines[:MOST_LINES], f"  and {more} more (all with --json or --out)"]


VARIED = ("parameter", "device field")
"""The quantities of coordinates in which members differ."""


def evenly(count: int, most: int) -> Any:
    """Places of at most ``most`` of ``count`` things, evenly picked, the first and the last among them."""
    return np.unique(np.linspace(0, count - 1, most).astype(int))


def varied_names(result: xr.Dataset) -> list[str]:
    """The fields and parameters in which the members of an ensemble differ; all that they have where none differs.

    A gel stands for its numbers.
    """
    names = [str(n) for n, c in result.coords.items() if n == "radius_ratio" or c.attrs.get("quantity") in VARIED]
    if "material" in result.coords:
        names = ["material", *(n for n in names if n != "material" and not n.startswith("material."))]
    return [n for n in names if np.unique(result[n]).size > 1] or names


def members_of(result: xr.Dataset, picks: Iterable[int] | None = None) -> list[tuple[str, xr.Dataset]]:
    """Members of an ensemble (default all), each named by what it differs in; a single run has no name."""
    dims = list(result["outcome"].dims)
    if not dims:
        return [("", result)]
    stacked, names = result.stack(flat=dims), varied_names(result)
    chosen = [with_own_axes(stacked.isel(flat=i)) for i in (range(stacked.sizes["flat"]) if picks is None else picks)]
    return [(", ".join(f"{n} {measured(m[n])}" for n in names), m) for m in chosen]


def with_own_axes(member: xr.Dataset) -> xr.Dataset:
    """A member whose axes have their own names; they are `sample` where their values in SI differ over the members."""
    dims_by_name = {name: c.dims[0] for name, c in member.coords.items() if c.ndim == 1 and name != "time"}
    return member.swap_dims({dim: name for name, dim in dims_by_name.items() if str(dim).endswith("sample")})


# --- branches of periodic orbits --------------------------------------------------------------------------------------

ENDINGS = {
    "limit": "the end of the interval",
    "rest": "rest",
    "closed": "closed",
    "wall": "the stretch limit",
    "pulled_in": "pulls in",
    "step": "the shortest step",
    "merged": "a branch of half its period or a symmetric one",
    "points": "the most points",
    "impossible": "no actuator",
}


def event_label(kind: xr.DataArray) -> str:
    """The kind of an event of a branch."""
    return meanings(kind)[int(kind)].replace("_", " ")


def branch_endings(branch: xr.Dataset) -> list[str]:
    """Why a branch ends at either end."""
    names = meanings(branch["ended"])
    return [ENDINGS[names[int(code)]] for code in branch["ended"].values]
