"""Answers about envelopes and frequency responses of draws: what every draw shows, as median and 95 % interval."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import unit_of
from gelcone.analyses.answer import heading, outcome_lines
from gelcone.analyses.envelope import interpolated, way_of
from gelcone.analyses.grids import drawn_names, membranes_lines, spread_line
from gelcone.codes import Outcome
from gelcone.motion.proportion import IN_PROPORTION, held_at_peak
from gelcone.statistics import spread

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject

WIDTHS = (18, 12, 22)


def over_draws_words(shown: xr.Dataset, subject: Subject) -> str:
    """Envelopes or frequency responses of draws as text."""
    names = drawn_names(shown)
    lines = [*heading(subject, names), f"{shown.sizes['draw']} draws of {', '.join(names)}", *outcome_lines(shown)]
    lines += _window_lines(shown) if shown.attrs["analysis"] == "envelope" else _response_lines(shown)
    return "\n".join([*lines, *membranes_lines(shown)])


def _window_lines(shown: xr.Dataset) -> list[str]:
    """Quasi-static limits, the window over frequency, and in how many draws the device's drive lies inside."""
    margin = json.loads(shown.attrs["options"])["margin"]
    static, constant = "at constant voltage", "constant voltage"
    if held_at_peak(shown):
        static = f"of the drive held at its peak{IN_PROPORTION}"
        constant = f"peak at which the drive is held{IN_PROPORTION}"
    lines = []
    for name in map(str, shown["static_limit"].values):
        limit_voltages = shown["static_limit_voltage"].sel(static_limit=name)
        if np.isfinite(limit_voltages).any():
            lines.append(spread_line(limit_voltages.assign_attrs(long_name=f"{name} {static}")))
    if np.isfinite(shown["recommended_constant"]).any():
        named = f"recommended {constant}, {margin:.0%} below its limits"
        lines.append(spread_line(shown["recommended_constant"].assign_attrs(long_name=named)))
    if held_at_peak(shown):
        second = shown["recommended_second_voltage"]
        lines.append(spread_line(second.assign_attrs(long_name="voltage on the second film then")))
    units = [shown[name].attrs["units"] for name in ("drive_frequency", "recommended_peak")]
    heads = [f"frequency ({units[0]})", f"up to ({units[1]})", "95 % within"]
    if units[0] == "1":
        heads = [head.partition(" (")[0] for head in heads]
    head = "".join(f"{text:{width}s}" for text, width in zip(heads, WIDTHS, strict=True))
    lines += [f"recommended drive, {margin:.0%} below its limits:", f"  {head}first limit, in how many draws"]
    failed = shown["outcome"].values != Outcome.OK
    first, lost = _first_limits(shown)[~failed], [f"failed {failed.sum()}"] * bool(failed.any())
    for k, at in enumerate(shown["drive_frequency"].values):
        low, middle, high = spread(shown["recommended_peak"].values[:, k])
        cells = (f"{at:.4g}", f"{middle:.4g}", f"{low:.4g} to {high:.4g}")
        limits, counts = np.unique(first[:, k], return_counts=True)
        every = ", ".join([*(f"{limits[i]} {counts[i]}" for i in np.argsort(-counts)), *lost])
        lines.append("  " + "".join(f"{cell:{width}s}" for cell, width in zip(cells, WIDTHS, strict=True)) + every)
    return [*lines, _own_line(shown)]


def _first_limits(shown: xr.Dataset) -> np.ndarray:
    """The name of the limit that comes first, (draws, frequencies)."""
    driven, static = (list(map(str, shown[dim].values)) for dim in ("driven_limit", "static_limit"))
    low = np.nan_to_num(shown["limit_low"].values, nan=np.inf, posinf=np.inf)
    static_voltages = np.nan_to_num(shown["static_limit_voltage"].values, nan=np.inf, posinf=np.inf)
    first_limits = np.array([[driven[i] for i in row] for row in low.argmin(axis=1)], dtype=object)
    way, lowest = way_of(shown), static_voltages.min(axis=1)
    names = np.array([f"{static[i]} {way}" for i in static_voltages.argmin(axis=1)], dtype=object)
    first_limits = np.where(lowest[:, None] < low.min(axis=1), names[:, None], first_limits)
    first_limits[~np.isfinite(np.minimum(low.min(axis=1), lowest[:, None]))] = "none"
    return np.asarray(first_limits)


def _own_line(shown: xr.Dataset) -> str:
    """Count the draws in which the device's drive lies inside the window."""
    at, peak = shown["operating_frequency"].values, shown["operating_peak_voltage"].values
    frequency, window = shown["drive_frequency"].values, shown["recommended_peak"].values
    is_examined = (at >= frequency[0]) & (at <= frequency[-1])
    if not is_examined.all():
        return "its own drive: outside the frequencies examined"
    inside = sum(peak[k] <= np.interp(at[k], frequency, window[k]) for k in range(len(at)))
    volt, hertz = unit_of(shown["operating_peak_voltage"]), unit_of(shown["operating_frequency"])
    drive = f"{np.median(peak):.4g}{volt} at {np.median(at):.4g}{hertz}"
    between = interpolated(shown, float(np.median(at)))
    return f"its drive, {drive}: inside the window{between} in {inside} of {len(at)} draws"


def _response_lines(shown: xr.Dataset) -> list[str]:
    """The largest stroke of each sweep and where it is, and which draws jump."""
    frequency = shown["drive_frequency"].values
    lines = [
        f"drive frequency {frequency[0]:.6g} to {frequency[-1]:.6g}{unit_of(shown['drive_frequency'])}, "
        f"{frequency.size} values"
    ]
    for branch in map(str, shown["branch"].values):
        sweep = shown.sel(branch=branch)
        stroke = (2.0 * sweep["peak_amplitude"]).assign_attrs(sweep["peak_amplitude"].attrs)
        lines.append(spread_line(stroke.assign_attrs(long_name=f"swept {branch}, largest stroke")))
        lines.append(spread_line(sweep["peak_frequency"].assign_attrs(long_name=f"swept {branch}, its frequency")))
    jump = int((shown["jumps"] > 0).sum())
    return [*lines, f"the sweeps differ, with jumps, in {jump} of {shown.sizes['draw']} draws"]
