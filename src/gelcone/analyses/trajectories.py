"""Answers about single runs: time responses, sections, turning points and spectra."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import lasting, lasting_alike, measured, sized, sized_alike, sized_range, sized_with_error, unit_of
from gelcone.analyses.answer import ending_lines, heading, pulled_in
from gelcone.analyses.tables import side_by_side
from gelcone.codes import FilmPullIn, Outcome
from gelcone.motion.averages import repeats
from gelcone.motion.response import LOSSES
from gelcone.physics.balance import PullIn
from gelcone.physics.film.pull_in import is_cone
from gelcone.physics.placed import PREFIX
from gelcone.words import (
    MOST_LINES,
    evenly,
    film_state_in_words,
    members_of,
    shortened,
    unrepeated_lines,
    validity_in_words,
    varied_names,
)

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject

PRINTED_LINES = 8
"""Lines of a spectrum in its text."""
COOL = 1e-6
"""Share of the largest heating below which a film that is held no longer warms."""


def _span(variable: xr.DataArray, digits: int = 5) -> str:
    """Smallest and largest value of a variable with its unit."""
    return f"{float(variable.min()):.{digits}g} to {float(variable.max()):.{digits}g}{unit_of(variable)}"


# --- time responses ---------------------------------------------------------------------------------------------------


def simulate_words(shown: xr.Dataset, subject: Subject) -> str:
    """A time response as text, of an ensemble with a column for each of the first members."""
    several = f", {shown['outcome'].size} members" if shown["outcome"].dims else ""
    lines = [*heading(subject), f"run of {_lengths(shown['time'])}{several}", *ending_lines(shown)]
    ended = bool((shown["outcome"].values == Outcome.OK).any())
    if several:
        lines += _member_lines(shown)
    elif ended:
        whole, late = _reach(shown)
        lines.append(f"displacement {whole}; in the second half {late}")
    if ended:
        lines += _source_lines(shown, subject)
        if "heating" in shown and not several:
            warms = f"which alone warms it by {sized(shown['heating'])}"
            lines.append(f"heat in the film {sized(shown['heat'])}, {warms}")
    lines += _pull_in_lines(shown)
    return "\n".join([*lines, *(validity_in_words(shown) if ended else film_state_in_words(shown))])


def _lengths(time: xr.DataArray) -> str:
    """The length of a run, of members that differ in it the shortest and the longest."""
    ends = time.isel({time.dims[-1]: -1})
    return sized_range(ends.min(keep_attrs=True), ends.max(keep_attrs=True), 5)


def _reach(member: xr.Dataset) -> list[str]:
    """The range of the displacement of one run, of all of it and of its second half."""
    half = member["displacement"].size // 2
    return [_span(_with_turns(part), 4) for part in (member, member.isel({member["time"].dims[-1]: slice(half, None)}))]


def _with_turns(member: xr.Dataset) -> xr.DataArray:
    """The displacements of a run at its samples, and where it turns between two: on the cubic through displacement and
    velocity at both."""
    import xarray as xr

    x = member["displacement"]
    place, time, speed = (member[name].values for name in ("displacement", "time", "velocity"))
    (first,) = np.nonzero(speed[:-1] * speed[1:] < 0.0)
    gap = np.diff(time)[first]  # a velocity times a time is a length in the units of results
    start, end = gap * speed[first], gap * speed[first + 1]
    rise = place[first + 1] - place[first]
    third, second = start + end - 2.0 * rise, 3.0 * rise - 2.0 * start - end
    # of the two roots of the slope the one between the samples, without cancellation
    share = start / (-second + np.sign(start) * np.sqrt(second**2 - 3.0 * third * start))
    turns = place[first] + share * (start + share * (second + share * third))
    return xr.DataArray(np.append(place, turns), attrs=x.attrs)


def _member_lines(shown: xr.Dataset) -> list[str]:
    """The first members of an ensemble side by side: what they differ in, and the ranges of their displacements."""
    members = [member for _, member in members_of(shown, range(shown["outcome"].size)[:MOST_LINES])]
    head = [[name, *(measured(member[name]) for member in members)] for name in varied_names(shown)]
    reached = [[Outcome(int(one["outcome"])).words, ""] if int(one["outcome"]) else _reach(one) for one in members]
    labels = ("displacement", "in the second half")
    rows = [[label, *texts] for label, texts in zip(labels, zip(*reached, strict=True), strict=True)]
    return [
        *side_by_side([*(head or [["member", *map(str, range(len(members)))]]), *rows]),
        *shortened([], shown["outcome"].size),
    ]


_JUMPS = (
    "the voltage jumps: the charge moves at once, so that peak and rms current of the ideal source are infinite; a "
    "rise of the waveform or a series resistance gives finite ones"
)


def _source_lines(shown: xr.Dataset, subject: Subject) -> list[str]:
    """The output of a single amplifier, and the part of it that is lost; of the ideal source, whether it jumps."""
    if "peak_current" not in shown:  # as in files of 0.2
        return []
    if shown["outcome"].ndim or subject.model.system.circuit.name == "ideal":
        jumps = not shown["outcome"].ndim and np.isinf(shown["peak_current"])
        return [_JUMPS] if jumps else []
    lost = [name for name in LOSSES if f"{name}_dissipation" in shown]
    split = ", ".join(f"{name} {sized(shown[f'{name}_dissipation'].isel(time=-1), 4)}" for name in lost)
    lines, both = [], PREFIX + "peak_current" in shown
    for prefix, name_of in (("", "first film's amplifier"), (PREFIX, "second film's amplifier"))[: 1 + both]:
        peaks, rms = (
            ", ".join(sized(shown[prefix + name], 4) for name in names)
            for names in (("peak_current", "peak_charge", "peak_slew_rate"), ("rms_voltage", "rms_current"))
        )
        lines.append(f"{name_of if both else 'amplifier'}: up to {peaks}; rms in the second half {rms}")
    lines[-1] += f", {sized(shown['apparent_power'], 4)}" + (" of both" if both else "")
    limits = [str(name) for name in shown.data_vars if str(name).endswith("_limited")]
    lines += [f"  {name.replace('_', ' ')} for {100.0 * float(shown[name]):.3g} % of the time" for name in limits]
    return [*lines, f"  supplied {sized(shown['supplied_energy'].isel(time=-1), 4)}, lost: {split}"] if lost else lines


def _pull_in_lines(shown: xr.Dataset) -> list[str]:
    """State where a film of a single run pulls in, if it may wrinkle."""
    lines = []
    for film, prefix in (("film", ""), ("second film", PREFIX)):
        kind = shown.get(f"{prefix}pull_in_kind")
        if kind is None or kind.ndim or int(kind) <= 0:
            continue
        time, displacement, voltage = (
            sized(shown[f"{prefix}pull_in_{name}"], digits)
            for name, digits in (("time", 6), ("displacement", 5), ("film_voltage", 5))
        )
        reason = FilmPullIn(int(kind)).label
        lines.append(f"{film} pulls in at {time}, displacement {displacement}, voltage on it {voltage} ({reason})")
    return lines


# --- steps ------------------------------------------------------------------------------------------------------------


def step_words(shown: xr.Dataset, subject: Subject) -> str:
    """Steps of the voltage as text, a line for each voltage, each column in one unit."""
    before, after = shown["initial_displacement"], shown["final_displacement"]
    lines = [*heading(subject), f"before the step{_before(shown, subject)}: {sized(before[0])}"]
    way = abs(after - before).assign_attrs(after.attrs)
    columns = zip(
        *(sized_alike(column) for column in (shown["constant_voltage"], way, after, shown["equilibrium_displacement"])),
        lasting_alike(shown["rise_time"], 3),
        lasting_alike(shown["settling_time"], 4),
        strict=True,
    )
    for k, (voltage, moves, end, equilibrium, rise, settling) in enumerate(columns):
        step = shown.isel(constant_voltage=k)
        name = f"  {voltage}:"
        if int(step["outcome"]) != Outcome.OK:
            lines.append(f"{name} {Outcome(int(step['outcome'])).meaning}")
            continue
        if np.isnan(step["overshoot"]):
            lines.append(f"{name} does not move the disc from {end}")
            continue
        settles = f"settled after {settling}" if np.isfinite(step["settling_time"]) else "not settled within the run"
        lines.append(
            f"{name} moves by {moves} to {end} (a slow ramp ends at {equilibrium}); rise {rise}, overshoot "
            f"{100.0 * float(step['overshoot']):.1f} %, {settles}, drift at the end "
            f"{100.0 * round(float(step['drift']), 7) + 0.0:.2g} %"
        )
    return "\n".join([*lines, *validity_in_words(shown)])


def _before(shown: xr.Dataset, subject: Subject) -> str:
    """The voltage before the step, of two films with different voltages that of the first."""
    of = " on the first film" if subject.model.system.films[-1].has_other_voltage else ""
    return f", at {sized(shown['before_voltage'])}{of}"


# --- creep ------------------------------------------------------------------------------------------------------------


def creep_words(shown: xr.Dataset, subject: Subject) -> str:
    """Creep under held voltages as text: the thresholds, a line for each voltage, and the times to pull-in."""
    longest, whose = lasting(float(shown["time"][-1]), shown["time"], 3), pulled_in(subject)
    late = shown.isel(held_voltage=np.isfinite(shown["time_to_pull_in"].values))
    ends = {name: shown[f"{name}_voltage"] for name in ("instantaneous_pull_in", "long_term_pull_in", "holding")}
    digits = telling_digits([*late["held_voltage"].values, *(float(v) for v in ends.values() if np.isfinite(v))])
    thresholds = {name: sized(voltage, digits) for name, voltage in ends.items()}
    lines = [
        *heading(subject),
        *(
            [f"no constant voltage pulls {whose} in, at once or in the long run"]
            if not np.isfinite(ends["long_term_pull_in"])
            else [
                f"pull-in voltage of {whose}: {thresholds['instantaneous_pull_in']} at once, "
                f"{thresholds['long_term_pull_in']} in the long run",
                f"highest voltage without pull-in for {longest}: {thresholds['holding']}",
            ]
        ),
    ]
    if int(shown["long_term_pull_in_kind"]) == PullIn.FILM and any(map(is_cone, subject.model.system.films)):
        lines.append(
            f"above {thresholds['long_term_pull_in']} one ring of the film slowly lengthens. The uniform cone does not "
            "show that: the film may pull in earlier and at lower voltages than printed"
        )
    for k in range(shown.sizes["constant_voltage"]):
        one = shown.isel(constant_voltage=k)
        name = f"  {sized(one['constant_voltage'])}:"
        time = float(one["pull_in_time"])
        if not np.isfinite(one["initial_displacement"]):
            lines.append(f"{name} pulls in at once")
        elif np.isfinite(time):
            after = lasting(time, shown["time"], 4)
            lines.append(f"{name} from {sized(one['initial_displacement'])}, pulls in after {after}")
        elif np.isnan(time):
            lines.append(f"{name} {Outcome(int(one['outcome'])).meaning}")
        else:
            margin = float(one["margin"].isel(time=-1))
            heating = one["heating"].values
            warm = "no longer warms"
            if not abs(heating[-1]) <= COOL * np.nanmax(np.abs(heating)):
                warm = f"warms by {sized(one['heating'].isel(time=-1), 3)}"
            lines.append(
                f"{name} creeps from {sized(one['initial_displacement'])} to {sized(one['final_displacement'])} in "
                f"{longest}, to {sized(one['equilibrium_displacement'])} in the long run; {warm}; "
                f"margin to pull-in of {whose} at the end: {margin:.1%}"
            )
    if late.sizes["held_voltage"]:
        lines.append("time to pull-in at other voltages:")
        later = late.isel(held_voltage=late["time_to_pull_in"].values > 0.0)
        for k in evenly(later.sizes["held_voltage"], PRINTED_LINES):
            one = later.isel(held_voltage=int(k))
            late_by = lasting(float(one["time_to_pull_in"]), shown["time"], 4)
            lines.append(f"  {sized(one['held_voltage'], digits)}: {late_by}")
        if later.sizes["held_voltage"] < late.sizes["held_voltage"]:
            first = late["held_voltage"][late["time_to_pull_in"].values == 0.0].min()
            lines.append(f"  from {sized(first, digits)} on: at once")
    return "\n".join([*lines, *validity_in_words(shown)])


def telling_digits(values: Iterable[float]) -> int:
    """The digits from 4 on at which different values are written differently; at most 12."""
    different = set(values)
    return next((k for k in range(4, 12) if len({f"{value:.{k}g}" for value in different}) == len(different)), 12)


# --- transfer functions -----------------------------------------------------------------------------------------------


def transfer_words(shown: xr.Dataset, subject: Subject) -> str:
    """Transfer functions as text: where they are largest, and a table of gains, linear and measured."""
    lines = [
        *heading(subject),
        f"about {sized(shown['bias_voltage'])}: displacement {sized(shown['equilibrium_displacement'])}, "
        f"natural frequency {sized(shown['natural_frequency'])}",
        f"largest gain {sized(shown['largest_gain'])} at {sized(shown['resonance'])}",
    ]
    frequencies = shown["measured_frequency"].values
    if not shown["measured_gain"].size:
        return "\n".join(lines)
    names = "".join(f"{sized(amplitude):>16s}" for amplitude in shown["amplitude"])
    lines.append(f"  gain at{'':9s}{'linear':>16s}{names}")
    for k in evenly(frequencies.size, PRINTED_LINES):
        one = shown.isel(measured_frequency=int(k))
        linear = np.interp(frequencies[k], shown["drive_frequency"].values, shown["gain"].values)
        gains = "".join(f"{sized(gain):>16s}" for gain in one["measured_gain"])
        lines.append(f"  {sized(one['measured_frequency']):15s} {linear:>10.4g}{unit_of(shown['gain']):6s}{gains}")
    if shown["measured_gain"].isnull().any():
        lines.append("  unknown: the motion ends, does not repeat with the drive, or is as small as rounding")
    return "\n".join(lines)


# --- sections ---------------------------------------------------------------------------------------------------------


def section_words(shown: xr.Dataset, subject: Subject) -> str:
    """A Poincare section as text."""
    lines = _section_heading(shown, subject)
    if shown["velocity"].notnull().any():
        lines.append(f"velocity {_span(shown['velocity'])}")
    return "\n".join(lines)


def extrema_words(shown: xr.Dataset, subject: Subject) -> str:
    """Turning points as text."""
    lines = _section_heading(shown, subject)
    for kind, word in ((1, "maxima"), (-1, "minima")):
        of_kind = shown["displacement"].where(shown["maximum"] == kind)
        if of_kind.notnull().any():
            lines.append(f"  {int(of_kind.notnull().sum())} {word}: {_span(of_kind)}")
    if not shown["count"].any():
        lines.append("no turning points: the disc is at rest by then")
    return "\n".join(lines)


def _section_heading(shown: xr.Dataset, subject: Subject) -> list[str]:
    several = f", {shown['outcome'].size} members" if shown["outcome"].dims else ""
    lines = [*heading(subject), f"{shown.attrs['title']}{several}", *ending_lines(shown)]
    x = shown["displacement"]
    if not x.notnull().any():
        return lines
    return [*lines, f"displacement {_span(x)}", *unrepeated_lines(_repeat(shown))]


def _repeat(shown: xr.Dataset) -> list[bool]:
    """Whether the points of each member, of those that the motion runs through in order, repeat."""
    members = [member for _, member in members_of(shown)] if shown["outcome"].dims else [shown]
    repeat_flags = []
    for member in members:
        points = np.stack([member[name].values.ravel() for name in ("displacement", "velocity") if name in member], 1)
        repeat_flags.append(repeats(points[np.isfinite(points).all(axis=1)]))
    return repeat_flags


# --- spectra ----------------------------------------------------------------------------------------------------------


def spectrum_words(shown: xr.Dataset, subject: Subject) -> str:
    """A spectrum as text: the strongest lines of a single run, how far the members of an ensemble differ."""
    lines = [*heading(subject), *ending_lines(shown)]
    if shown["outcome"].size > 1:
        lines += [
            f"{name.replace('_', ' ')} {_span(shown[name], 4)}"
            for name in ("rms", "power_in_lines", "flatness")
            if shown[name].notnull().any()
        ]
    elif int(shown["outcome"].values.ravel()[0]) == Outcome.OK:
        lines += _line_table(shown)
    if "rms_standard_error" in shown:
        lines += unrepeated_lines(~(shown["rms_standard_error"].values > 0.0))
    return "\n".join(lines)


def _run_lines(shown: xr.Dataset) -> list[str]:
    """State the range of the spectrum of a run whose drive does not repeat."""
    amplitude, frequency = (shown[name].values.ravel()[1:] for name in ("amplitude", "frequency"))
    unit, highest = unit_of(shown["frequency"]), int(np.argmax(amplitude))
    power = np.cumsum(amplitude**2) / np.sum(amplitude**2)
    low, high = (frequency[np.searchsorted(power, share)] for share in (0.05, 0.95))
    return [
        "of the run of a drive that does not repeat, from its start on; it has no lines",
        f"largest at {frequency[highest]:.6g}{unit}: {amplitude[highest]:.4g}{unit_of(shown['amplitude'])}",
        f"90 % of the power from {low:.6g} to {high:.6g}{unit}; spectral flatness {float(shown['flatness']):.3g}",
    ]


def _line_table(shown: xr.Dataset) -> list[str]:
    """The strongest lines of a single run."""
    if np.isnan(shown["flatness"]):
        return ["the actuator stands still: it has no spectrum"]
    rms, mean = (
        sized_with_error(shown[name], shown.get(f"{name}_standard_error"), 5) for name in ("rms", "mean_displacement")
    )
    swing = f"rms {rms} about {mean}"
    if np.isnan(shown["power_in_lines"]):
        return [swing, *_run_lines(shown)]
    count = int(shown["line_ratio"].notnull().sum())
    if not count:
        return [swing, f"no lines; spectral flatness {float(shown['flatness']):.3g}"]
    lines = [
        swing,
        f"{100.0 * float(shown['power_in_lines']):.4g} % of the variance in lines, "
        f"spectral flatness {float(shown['flatness']):.3g}",
        "  frequency/drive    frequency    amplitude    prominence",
    ]
    for i in range(min(PRINTED_LINES, count)):
        line = shown.isel(line=i)
        lines.append(
            f"  {float(line['line_ratio']):15.6g} "
            f"{float(line['line_frequency']):12.6g}{unit_of(line['line_frequency'])} "
            f"{float(line['line_amplitude']):12.4g}{unit_of(line['line_amplitude'])} "
            f"{float(line['line_prominence']):10.1f} dB"
        )
    if count > PRINTED_LINES:
        lines.append(f"  and {count - PRINTED_LINES} more")
    return lines
