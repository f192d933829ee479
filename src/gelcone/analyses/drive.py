"""Answers about the best drive."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import sized, sized_range
from gelcone.analyses.answer import WIDTH, heading

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject

MOST_FIELDS = 6
"""Sensitivities that are printed."""


def drive_words(shown: xr.Dataset, subject: Subject) -> str:
    """The best drive: first a line with all that is needed to use it, then margins and sensitivities."""
    peak, limit = float(shown["peak_voltage"]), float(shown["limit_voltage"])
    largest = shown.attrs["largest"]
    of = "power on the load" if largest == "power" else largest
    parts = f"offset {sized(shown['voltage_bias'])}, amplitude {sized(shown['voltage'])}"
    lines = [
        *heading(subject, ["voltage_amplitude", "voltage_offset", "frequency", "voltage", "voltage_bias"]),
        f"largest {of}: {sized(shown[largest])} at {sized(shown['drive_frequency'])} and "
        f"{sized(shown['peak_voltage'])} peak ({parts})",
        f"  {', '.join(_yields(shown, largest))}",
    ]
    if np.isfinite(limit):
        named = f"limited by {shown.attrs['limit']} at {sized(shown['limit_voltage'])}: {1.0 - peak / limit:.0%} below"
        ends = sized_range(shown["frequency_low"], shown["frequency_high"])
        lines.append(f"  {named} it; this voltage stays below all limits from {ends}")
    else:
        lines.append("  no limit was met at this frequency, up to the highest voltage examined")
    if "detuned_stroke" in shown:  # not in files of 0.2
        lower, higher = (sized(stroke) for stroke in shown["detuned_stroke"])
        share = abs(float(shown["detuning"][0]))
        lines.append(f"  stroke at a frequency {share:.0%} lower {lower}, as much higher {higher}")
    undecided = int(shown.get("undecided_motions", 0))  # not in files of 0.2
    if undecided:
        lines.append(f"  {undecided} examined motions neither settled nor showed chaos, and are not taken: --patience")
    kick = float(shown["kick"])
    if np.isfinite(kick):
        lines.append(f"  a kick of {sized(shown['kick'])} leads to another motion")
    elif np.isinf(kick):
        lines.append("  no kick that was tried leads to another motion")
    return "\n".join([*lines, *_sensitivities(shown)])


def _yields(shown: xr.Dataset, largest: str) -> list[str]:
    names = {"stroke": "stroke", "work": "work a period", "speed": "rms speed"}
    named = [f"{words} {sized(shown[name])}" for name, words in names.items() if name != largest]
    supplied = sized(shown["supplied_power"])
    power = f"mean power on the load {sized(shown['power'])} of {supplied} supplied"
    power = f"mean power supplied {supplied}" if largest == "power" else power
    return [*named, power, f"apparent power {sized(shown['apparent_power'])}"]


def _sensitivities(shown: xr.Dataset) -> list[str]:
    change = shown["sensitivity"].values
    order = [int(k) for k in np.argsort(-np.abs(np.nan_to_num(change)))][:MOST_FIELDS]
    changes = [f"{shown['field'].values[k]} {change[k]:+.3g}" for k in order if np.isfinite(change[k])]
    lost = [str(name) for name, sensitivity in zip(shown["field"].values, change, strict=True) if np.isnan(sensitivity)]
    named = f"stroke changes by, % per %: {', '.join(changes)}"
    lines = textwrap.wrap(named, WIDTH, initial_indent="  ", subsequent_indent="    ") if changes else []
    return [*lines, *([f"  a change of 1 % leads to another motion or ends it: {', '.join(lost)}"] if lost else [])]
