"""Answers about the response over drive frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import measured, missing, unit_of, with_error
from gelcone.analyses.answer import heading, outcome_lines
from gelcone.analyses.branches import followed_lines
from gelcone.analyses.tables import side_by_side
from gelcone.codes import Outcome
from gelcone.words import event_label, kinds_of_motion, shortened, validity_in_words

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject

FEW = 12
"""Most frequencies of which each stroke is printed."""
_JUMP = ("jump_low", "jump_high", "jump_from", "jump_to")


def frequency_words(shown: xr.Dataset, subject: Subject) -> str:
    """A frequency response as text: the peak and what is not periodic on each sweep, linear theory, the jumps."""
    hertz, length = unit_of(shown["drive_frequency"]), unit_of(shown["stroke"])
    frequency = shown["drive_frequency"].values
    lines = [
        *heading(subject, ["drive_frequency", "frequency"]),
        f"drive frequency {frequency[0]:.6g} to {frequency[-1]:.6g}{hertz}, {frequency.size} values",
        *outcome_lines(shown),
    ]
    for branch in shown["branch"].values:
        sweep = shown.sel(branch=branch)
        lines += _branch_lines(str(branch), sweep, hertz, length)
        lines += [f"            {line}" for line in validity_in_words(sweep)]
    linear = shown["linear_stroke"].values
    why = missing(np.nan, shown["linear_stroke"])
    if np.isfinite(linear).any():
        is_missing, (largest, at) = np.isnan(linear), _linear_peak(shown)
        missing_text = f", none at {is_missing.sum()} of {linear.size} frequencies: {why}" if is_missing.any() else ""
        where = f" at {at:.5g}{hertz}" if largest else ""  # without stroke no frequency has the largest
        whether = "" if (shown["outcome"] == Outcome.OK).any() else "; it holds for small motions, and none was found"
        lines.append(f"linear theory: largest stroke {largest:.4g}{length}{where}{missing_text}{whether}")
    else:
        lines.append(f"no linear theory: {why}")
    alone = (shown["outcome"] == Outcome.OK).sum("branch").values == 1
    if alone.any():
        lines.append(f"only one of the sweeps finds a motion at {alone.sum()} of {frequency.size} frequencies")
    if frequency.size <= FEW:
        lines += _stroke_lines(shown)
    named = [*lines, *shortened(_jump_lines(shown, hertz, length)), *followed_lines(shown, "drive frequency")]
    return "\n".join(named)


def _linear_peak(shown: xr.Dataset) -> tuple[float, float]:
    """The largest linear stroke and its frequency; in files of 0.2 among those of the sweeps."""
    if "linear_peak_stroke" in shown:
        return float(shown["linear_peak_stroke"]), float(shown["linear_peak_frequency"])
    strokes = shown["linear_stroke"].values
    k = int(np.nanargmax(strokes))
    return strokes[k], shown["drive_frequency"].values[k]


def _stroke_lines(shown: xr.Dataset) -> list[str]:
    """The stroke at each frequency, on each of the sweeps and by linear theory."""
    columns = {f"swept {branch}": _strokes(shown.sel(branch=branch)) for branch in shown["branch"].values}
    if shown["linear_stroke"].notnull().any():
        columns["linear"] = list(map(measured, shown["linear_stroke"]))
    rows = zip(shown["drive_frequency"], *columns.values(), strict=True)
    return side_by_side([["  stroke at", *columns], *([f"  {measured(at, 5)}", *strokes] for at, *strokes in rows)])


def _strokes(own: xr.Dataset) -> list[str]:
    """The strokes of one sweep, in words where the disc rests."""
    rests = own.get("resting", 0 * own["period"]).values
    return ["at rest" if rest else measured(stroke) for stroke, rest in zip(own["stroke"], rests, strict=True)]


def _branch_lines(branch: str, own: xr.Dataset, hertz: str, length: str) -> list[str]:
    """The peak of one sweep, and at how many frequencies the motion does not follow the drive."""
    frequency = own["drive_frequency"].values
    stroke, error = 2.0 * float(own["peak_amplitude"]), 2.0 * float(own["peak_amplitude_error"])
    at = f"{float(own['peak_frequency']):.5g} [{float(own['peak_low']):.5g}, {float(own['peak_high']):.5g}]{hertz}"
    ends = float(own["peak_frequency"]) in (frequency[0], frequency[-1])
    rising = ", an end of the frequencies: it may rise beyond" if ends else ""
    largest = with_error(stroke, error).removeprefix("+")
    if own["stroke"].isnull().all():
        return [f"swept {branch:5s} no motion is found at any frequency"]
    if "resting" in own and own["resting"].values[own["stroke"].notnull()].all():
        return [f"swept {branch:5s} at rest at every frequency"]
    lines = [f"swept {branch:5s} largest stroke {largest}{length} at {at}{rising}"]
    counts = {kind: int(which.sum()) for kind, which in kinds_of_motion(own).items()}
    kinds = ", ".join(f"{kind} at {n}" for kind, n in counts.items() if n)
    return [*lines, f"            {kinds} of {frequency.size} frequencies"] if kinds else lines


def _jump_lines(shown: xr.Dataset, hertz: str, length: str) -> list[str]:
    """List the jumps of each sweep, with the strokes before and after."""
    if not shown.sizes["jump"]:
        both = (shown["outcome"] == Outcome.OK).all("branch").any()
        return ["no jump: where both sweeps find a motion, it is the same"] if both else []
    lines = ["jumps (the sweeps differ between):"]
    for i in range(shown.sizes["jump"]):
        jump = shown.isel(jump=i)
        low, high, before, after = (float(jump[name]) for name in _JUMP)
        between = " to ".join(dict.fromkeys(f"{end:.5g}" for end in (low, high)))
        lines.append(
            f"  swept {jump['jump_branch'].values!s:5s} at {between}{hertz}: "
            f"stroke {before:.4g} -> {after:.4g}{length}" + _behind(jump, hertz)
        )
    return lines


def _behind(jump: xr.Dataset, hertz: str) -> str:
    """The bifurcation at which a sweep jumps."""
    if "jump_event" not in jump:
        return ""
    if int(jump["jump_event_kind"]) < 0:
        return ", no bifurcation found there"
    return f", {event_label(jump['jump_event_kind'])} at {float(jump['jump_event']):.10g}{hertz}"
