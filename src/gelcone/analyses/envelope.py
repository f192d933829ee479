"""Answers about where a device is safe to drive."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone.amounts import lasting, sized, unit_of
from gelcone.analyses.answer import heading, pulled_in
from gelcone.codes import Outcome, Regime
from gelcone.motion.proportion import IN_PROPORTION, PROPORTIONAL, held_at_peak
from gelcone.words import FAILINGS, motion_in_words, shortened

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject

_HELD = "holding_time"
_STATIC = ("constant_voltage", "stroke", "blocked_force", "natural_frequency")
_WINDOW = ("drive_frequency", "recommended_peak", "window_stroke", "window_power", "window_apparent_power")
_WARM = "window_heating"
"""And of films that get warm."""
_HEADS = ("frequency", "up to", "stroke", "power", "apparent", "warms by")
_WIDTHS = (18, 12, 14, 14, 16, 16)
Values = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]
_SAME_FREQUENCY = 1e-9
"""Relative difference of a drive frequency and the same one after conversions of units, at most."""
_FEW_ROWS, _ON_LINE = 12, 0.04
"""Rows that are always printed, and the share of the largest value to which those left out are on a line."""


def _names(shown: xr.Dataset, dim: str) -> list[str]:
    """The names along a dim of limits."""
    return [str(name) for name in shown[dim].values]


def _first_name(shown: xr.Dataset, index: int) -> str | None:
    """Name of the driven limit that comes first, None where none does."""
    return None if index < 0 else _names(shown, "driven_limit")[int(index)]


def _missing(name: str) -> str:
    """Words for a limit that is not known."""
    return "unknown" if name == "dielectric breakdown" else "not applicable"


def envelope_words(shown: xr.Dataset, subject: Subject) -> str:
    """An envelope as text: all limits, the window over frequency with what it yields, and the device's drive."""
    tables = (_static_lines, _window_table, _coexisting_lines)
    lines = [*_limits_table(shown, pulled_in(subject)), *(line for table in tables for line in table(shown))]
    return "\n".join([*heading(subject), *lines])


def _limits_table(shown: xr.Dataset, whose: str) -> Iterator[str]:
    """Each limit at a constant voltage, and the lowest peak voltage at which a driven motion meets it."""
    static = dict(zip(_names(shown, "static_limit"), shown["static_limit_voltage"].values, strict=True))
    driven_names = _names(shown, "driven_limit")
    constant = "held at its peak" if held_at_peak(shown) else "constant voltage"
    yield f"{'limit':22s}  {_held_words(shown) or constant:16s}  driven, lowest peak voltage"
    for name in dict.fromkeys([*static, *driven_names]):
        reading = _static_reading(shown, name, static[name]) if name in static else "-"
        row = _lowest_driven(shown, driven_names.index(name)) if name in driven_names else "-"
        yield f"  {name:20s}  {reading:16s}  {row}"
    if held_at_peak(shown):
        yield f"held at its peak: the drive raised slowly as a whole{IN_PROPORTION}"
    yield _pull_in_words(shown)
    low = dict(zip(driven_names, shown["limit_low"].values, strict=True))
    if (np.isfinite(low["pull-in"]) & (low.get("chaos", np.inf) < low["pull-in"])).any():
        yield "a driven pull-in above the limit of chaos is that of one run: others pull in lower or higher"
    if (start := _creeps(shown)) is not None:
        yield from _creep_words(shown, whose, start)
    if np.isnan(static["dielectric breakdown"]):
        yield "the dielectric strength is not given: the window takes no account of breakdown"


def _creeps(shown: xr.Dataset) -> str | None:
    """The start of the names of the pull-in voltages of a film that creeps; None for another."""
    return next((start for start in (PROPORTIONAL, "") if f"{start}instantaneous_pull_in_voltage" in shown), None)


def _creep_words(shown: xr.Dataset, whose: str, start: str) -> Iterator[str]:
    """The two pull-in voltages of a film that creeps, whose names begin with ``start``, and what the limits at constant
    voltage, or of a drive that is held at its peak, hold for."""
    at_once, late = (shown[f"{start}{name}_pull_in_voltage"] for name in ("instantaneous", "long_term"))
    if not np.isfinite(late):
        none = "held at no peak the drive" if start else "no constant voltage"
        yield f"the film creeps: {none} pulls {whose} in, at once or in the long run"
        return
    if start:
        yield (
            f"the film creeps: held at its peak the drive pulls {whose} in above {sized(at_once)} at once, above "
            f"{sized(late)} after a while; limits of the drive held at its peak are those in the long run"
        )
        return
    yield (
        f"the film creeps: at constant voltage {whose} pulls in above {sized(at_once)} at once, above {sized(late)} "
        "after a while (gelcone creep says when)"
    )
    yield (
        f"up to {sized(shown['holding_voltage'])} is {_held_words(shown)}: limits at constant voltage are those of "
        "that time"
        if "holding_voltage" in shown
        else "limits at constant voltage are those in the long run, with --duration those of a time"
    )


def _held_words(shown: xr.Dataset) -> str:
    """State for how long a constant voltage is held; empty where that is without end."""
    return f"held for {lasting(float(shown['holding_time']), shown['holding_time'], 3)}" if _HELD in shown else ""


def _pull_in_words(shown: xr.Dataset) -> str:
    if shown.attrs["pull_in_of"] == "cone":
        return "pull-in is that of the model's film; a membrane, which a wrinkling cone stands for, pulls in earlier"
    gel = "" if _creeps(shown) is None else " of the relaxed gel"
    return f"pull-in is that of the film as a membrane{gel}, its force known to {shown.attrs['pull_in_error']:.1%}"


def _static_reading(shown: xr.Dataset, name: str, voltage: float) -> str:
    if np.isinf(voltage) and name not in ("pitchfork", "pull-in"):
        pull_in = float(shown["static_limit_voltage"][_names(shown, "static_limit").index("pull-in")])
        if pull_in <= float(shown["constant_voltage"].max()):
            return "none to pull-in"
        return f"above {_plain(shown['constant_voltage'].max())}{unit_of(shown['constant_voltage'])}"
    if np.isnan(voltage):
        return _missing(name)
    return "none" if np.isinf(voltage) else f"{_plain(voltage)}{unit_of(shown['constant_voltage'])}"


def _lowest_driven(shown: xr.Dataset, row: int) -> str:
    low = shown["limit_low"].values[row]
    if np.isnan(low).all():
        return _missing(_names(shown, "driven_limit")[row])
    k = int(np.argmin(low))
    frequency = shown["drive_frequency"]
    if np.isinf(low[k]):
        pull_in = shown["limit_low"].values[_names(shown, "driven_limit").index("pull-in")]
        held = shown["static_limit_voltage"].values[_names(shown, "static_limit").index("pull-in")]
        if np.isfinite(pull_in).all() or held < float(shown["peak_voltage"][-1]):
            return "none to pull-in"
        return f"above {_plain(shown['peak_voltage'].max())}{unit_of(shown['peak_voltage'])}"
    return f"{_interval(shown, row, k)} at {_plain(frequency[k])}{unit_of(frequency)}"


def _interval(shown: xr.Dataset, row: int, k: int) -> str:
    low, high = (_plain(shown[name].values[row, k]) for name in ("limit_low", "limit_high"))
    return f"{low if low == high else f'{low} to {high}'}{unit_of(shown['peak_voltage'])}"


def _static_lines(shown: xr.Dataset) -> Iterator[str]:
    """The recommended constant voltage, with stroke, blocked force and natural frequency there."""
    highest, margin = float(shown["recommended_constant"]), _margin_of(shown)
    if highest <= 0.0:
        what = "peak at which the drive is held" if held_at_peak(shown) else "constant voltage"
        yield f"no {what} is recommended: the film is slack from 0 on; pre-stretch it"
        return
    there = {name: np.interp(highest, shown["constant_voltage"], shown[name]) for name in _STATIC}
    at = {name: f"{_plain(value)}{unit_of(shown[name])}" for name, value in there.items()}
    at |= {name: sized(shown[name][0].copy(data=there[name])) for name in ("stroke", "blocked_force")}
    said = [f"stroke {at['stroke']}"]
    if _HELD in shown:
        place = np.interp(highest, shown["held_voltage"], shown["held_displacement"]) - float(
            shown["rest_displacement"]
        )
        said = [f"stroke {_plain(place)}{unit_of(shown['stroke'])} after that time"]
    if "nan" not in at["natural_frequency"]:
        still = _plain(shown["natural_frequency"][0])
        said += [
            f"blocked force {at['blocked_force']}",
            f"natural frequency {at['natural_frequency']} ({still} at 0)",
        ]
    if "static_heating" in shown:
        warm = np.interp(highest, shown["constant_voltage"], shown["static_heating"])
        said.append(f"warms by {float(warm):.3g}{unit_of(shown['static_heating'])}")
    while_held = f", {_held_words(shown)}" if _HELD in shown else ""
    what, volts = f"constant voltage{while_held}", at["constant_voltage"]
    if held_at_peak(shown):
        second = shown["recommended_second_voltage"]
        what = "peak at which the drive is held"
        volts += f" on the first film and {_plain(second)}{unit_of(second)} on the second{IN_PROPORTION}"
    yield f"recommended {what}, {margin:.0%} below {_bound(shown)}: {volts}; {', '.join(said)}"


def _margin_of(shown: xr.Dataset) -> float:
    """The margin that the envelope was made with."""
    return float(json.loads(shown.attrs["options"])["margin"])


def _window_table(shown: xr.Dataset) -> Iterator[str]:
    """The recommended window over drive frequency; neighbouring frequencies of equal rows in one."""
    recommended = shown["recommended_peak"].values
    if (recommended <= 0.0).all():
        first = dict.fromkeys(_first_name(shown, i) for i in shown["first_limit"].values)
        yield f"no driven window is recommended: {', '.join(map(str, first))} from 0 on at every frequency"
    else:
        columns = [*_WINDOW, *([_WARM] if _WARM in shown else [])]
        units = [shown[name].attrs["units"].replace("1", "") for name in columns]
        reading = [f"{text} ({u})" if u else text for text, u in zip(_HEADS, units, strict=False)]
        yield f"recommended drive, {_margin_of(shown):.0%} below its limits{_from_words(shown)}:"
        yield "  " + "".join(f"{head:{width}s}" for head, width in zip(reading, _WIDTHS, strict=False)) + "first limit"
        frequency = shown["drive_frequency"].values
        rows = {
            k: _window_row(shown, k) for k in _kept_rows(np.log(frequency), recommended, shown["window_stroke"].values)
        }
        for row, group in itertools.groupby(rows, key=lambda k: rows[k]):
            ks = list(group)
            span = _plain(frequency[ks[0]]) + (f" to {_plain(frequency[ks[-1]])}" if len(ks) > 1 else "")
            yield f"  {span:{_WIDTHS[0]}s}{row}"
        if left := frequency.size - len(rows):
            yield f"  {left} frequencies between these, on the lines from one to the next: all with --out"
        if (shown["window_regime"].values == 0.0).all():
            yield "within the window the film stays at rest: only a bias and a spring that lifts the disc move it there"
    yield _own_line(shown)


def _kept_rows(x: Values, *curves: Values) -> list[int]:
    """Rows of the table: all of few, else those at which one of the curves bends."""
    if x.size <= _FEW_ROWS:
        return list(range(x.size))
    return sorted(set().union(*(_bends(x, np.nan_to_num(curve)) for curve in curves)))


def _bends(x: Values, y: Values) -> list[int]:
    """Places of points between which all others are on straight lines, to `_ON_LINE` of the largest y."""
    kept, ranges = {0, x.size - 1}, [(0, x.size - 1)]
    while ranges:
        first, last = ranges.pop()
        line = np.interp(x[first : last + 1], x[[first, last]], y[[first, last]])
        off = np.abs(y[first : last + 1] - line)
        at = first + int(off.argmax())
        if off.max() > _ON_LINE * y.max():
            kept.add(at)
            ranges += [(first, at), (at, last)]
    return sorted(map(int, kept))


def _from_words(shown: xr.Dataset) -> str:
    """State the start from which the limits hold; results of gelcone 0.2 do not store it."""
    return _FROM.get(json.loads(shown.attrs["options"]).get("limits_from", ""), "")


_FROM = {
    "rest": " when it is switched on from rest",
    "settled": " when its voltage rises slowly",
    "both": " when it is switched on from rest or its voltage rises slowly",
}


def _coexisting_lines(shown: xr.Dataset) -> Iterator[str]:
    """List the motions that coexist with the window's, and the size of the kick that leads to them."""
    tried = shown["kick_tried"].values
    if np.isnan(tried).all():
        return
    largest, unit = f"{_plain(np.nanmax(tried))}", unit_of(shown["kick_low"])
    kick = "kick, a sudden change of the disc's velocity"
    if not (shown["coexisting_motions"].values > 0).any():
        yield f"no other motion was found within the window: no {kick}, up to {largest}{unit} leads away"
        return
    yield f"where a {kick}, can lead from the recommended drive (tried up to {largest}{unit}):"
    shown = shown.isel(drive_frequency=np.flatnonzero(np.isfinite(tried)))
    lines: list[str] = []
    for goals, group in itertools.groupby(
        range(shown.sizes["drive_frequency"]), key=lambda k: _goals(shown.isel(drive_frequency=k))
    ):
        lines += _kick_lines(shown.isel(drive_frequency=list(group)), goals) if goals else []
    yield from shortened(lines)


def _goals(one: xr.Dataset) -> tuple[str, ...]:
    """The motions that coexist with the window's at one drive frequency, by rising kick."""
    return tuple(_goal(one.isel(motion=n)) for n in range(int(np.nan_to_num(one["coexisting_motions"]))))


def _goal(motion: xr.Dataset) -> str:
    regime, outcome = int(motion["motion_regime"]), int(motion["motion_outcome"])
    if outcome == Outcome.PULLED_IN:
        return "pull-in"
    if regime == Regime.LEFT_THE_DOMAIN:
        return f"{Regime(regime).label}, {Outcome(outcome).words}"
    return motion_in_words(regime, int(np.nan_to_num(motion["motion_period"])))


def _kick_lines(part: xr.Dataset, goals: tuple[str, ...]) -> Iterator[str]:
    """State the size of the kick at neighbouring drive frequencies from which the same motions can be reached."""
    frequency, high = part["drive_frequency"], part["kick_high"].values
    least = int(np.argmin(high))
    span = _range(frequency)
    if np.isfinite(high[least]):
        at = f", at {_plain(frequency[least])}{unit_of(frequency)}" if high.size > 1 else ""
        between = f"{_plain(part['kick_low'][least])} and {_plain(high[least])}{unit_of(part['kick_low'])}"
        yield f"  {span}: the smallest that leads away lies between {between}{at}"
    else:
        yield f"  {span}: no kick leads away, but another motion exists"
    for n, goal in enumerate(goals):
        motion = part.isel(motion=n)
        moves = f", stroke {_range(motion['motion_stroke'])}" if motion["motion_stroke"].notnull().any() else ""
        known = {name: motion.get(f"motion_validity_{name}") for name in FAILINGS}  # files of 0.2 do not have all
        shares = {FAILINGS[name]: float(share.max()) for name, share in known.items() if share is not None}
        up_to = "up to " if high.size > 1 else ""
        fails = [f"{words} {up_to}{100.0 * share:.3g} %" for words, share in shares.items() if share > 0.0]
        named = f"; the model does not hold: {', '.join(fails)}" if fails and goal != "pull-in" else ""
        yield f"    to: {goal}{moves}{named}"


def _range(values: xr.DataArray) -> str:
    """The least and the largest of some values, with their unit."""
    low, high = _plain(values.min()), _plain(values.max())
    return f"{low if low == high else f'{low} to {high}'}{unit_of(values)}"


def _bound(shown: xr.Dataset) -> str:
    """Name the bound of the constant voltage: its limits, or the highest voltage that was computed."""
    highest = shown["constant_voltage"][-1]
    met = float(np.nanmin(shown["static_limit_voltage"].values, initial=np.inf)) <= float(highest)
    return "its limits" if met else f"{_plain(highest)}{unit_of(highest)}, up to which no limit was met"


def _window_row(shown: xr.Dataset, k: int) -> str:
    """Recommended peak, what it yields, and the limit that comes first, at one drive frequency."""
    recommended = float(shown["recommended_peak"][k])
    if recommended <= 0.0:
        cells = ["none", "-", "-", "-"]
    else:
        rest = shown["window_regime"].values[k] == 0.0
        moved = ["at rest", "0"] if rest else [_plain(shown[name][k]) for name in _WINDOW[2:4]]
        cells = [_plain(recommended), *moved, _plain(shown[_WINDOW[4]][k])]
    if _WARM in shown:
        cells.append(f"{float(shown[_WARM][k]):.3g}" if recommended > 0.0 else "-")
    first = int(shown["first_limit"].values[k])
    lowest_static = float(np.nanmin(shown["static_limit_voltage"].values, initial=np.inf))
    low = np.inf if first < 0 else float(shown["limit_low"].values[first, k])
    highest = float(shown["peak_voltage"][-1])
    if min(low, lowest_static) > highest:
        reading = f"none met up to {_plain(highest)}{unit_of(shown['peak_voltage'])}"
    elif lowest_static < low:
        at = int(np.nanargmin(shown["static_limit_voltage"].values))
        name = _names(shown, "static_limit")[at]
        volts = f"{_plain(lowest_static)}{unit_of(shown['peak_voltage'])}"
        reading = f"{name} at {volts} {_held_words(shown)}" if _HELD in shown else f"{name} {way_of(shown)} {volts}"
    else:
        reading = f"{_first_name(shown, first)} {_interval(shown, first, k)}"
    return "".join(f"{cell:{width}s}" for cell, width in zip(cells, _WIDTHS[1:], strict=False)) + reading


def _own_line(shown: xr.Dataset) -> str:
    """Compare the device's drive with the window."""
    peak, frequency = float(shown["operating_peak_voltage"]), float(shown["operating_frequency"])
    volt, hertz = unit_of(shown["operating_peak_voltage"]), unit_of(shown["operating_frequency"])
    drive = f"its drive, {_plain(peak)}{volt} at {_plain(frequency)}{hertz}:"
    frequencies = shown["drive_frequency"].values
    if not frequencies[0] <= frequency <= frequencies[-1]:
        return f"{drive} outside the frequencies examined"
    highest = float(np.interp(frequency, frequencies, shown["recommended_peak"].values))
    limit, there = highest / (1.0 - _margin_of(shown)), f"{_plain(highest)}{volt} there{interpolated(shown, frequency)}"
    if peak <= highest:
        return f"{drive} inside the window, {there}"
    searched = float(shown["peak_voltage"][-1])
    if peak > searched and limit >= searched * (1.0 - 1e-9):
        return f"{drive} above the voltages examined, up to {_plain(searched)}{volt}, at which no limit was met"
    side = "below" if peak <= limit else "beyond"
    return _other_motion(shown, peak, frequency, drive) or f"{drive} above the window, {there}, and {side} a limit"


def _examined_at(shown: xr.Dataset, frequency: float) -> Rows:
    """Index of a drive frequency among those examined, (1,); (0,) for one between them."""
    return np.flatnonzero(np.isclose(shown["drive_frequency"].values, frequency, rtol=_SAME_FREQUENCY, atol=0.0))


def interpolated(shown: xr.Dataset, frequency: float) -> str:
    """Name the two frequencies between which a value is interpolated; empty at one that was examined."""
    if _examined_at(shown, frequency).size:
        return ""
    looked = shown["drive_frequency"]
    k = int(np.searchsorted(looked.values, frequency))
    return f" (interpolated between {_plain(looked[k - 1])} and {_plain(looked[k])}{unit_of(looked)})"


def way_of(shown: xr.Dataset) -> str:
    """The addition to the name of a quasi-static limit among driven ones."""
    return "of the drive held at its peak" if held_at_peak(shown) else "at constant"


_OTHER_MOTION = ("onset of rest", "chaos", "pitchfork at constant", "pitchfork of the drive held at its peak")
"""Limits beyond which the motion is of another kind, while the film holds."""


def _other_motion(shown: xr.Dataset, peak: float, frequency: float, own: str) -> str:
    """Name the limit that a drive exceeds while it is below all limits of the film; empty if there is none, or at a
    frequency that was not examined."""
    at = _examined_at(shown, frequency)
    if not at.size:
        return ""
    names = [*_names(shown, "driven_limit"), *(f"{name} {way_of(shown)}" for name in _names(shown, "static_limit"))]
    voltages = [*shown["limit_low"].values[:, at[0]], *shown["static_limit_voltage"].values]
    met = {name: v for name, v in zip(names, voltages, strict=True) if np.isfinite(v)}
    exceeded = {name: v for name, v in met.items() if v < peak}
    if not exceeded or not exceeded.keys() <= {*_OTHER_MOTION}:
        return ""
    volt = unit_of(shown["operating_peak_voltage"])
    above = " and ".join(f"{name}, {_plain(v)}{volt}" for name, v in exceeded.items())
    held = {name: v for name, v in met.items() if v >= peak}
    if not held:
        return f"{own} above {above}; no other limit is met"
    first = min(held, key=held.__getitem__)
    left = f"{1.0 - peak / held[first]:.0%} below the first other limit"
    return f"{own} above {above}; {left}, {first} {_plain(held[first])}{volt}"


def _plain(value: Any) -> str:
    """A number to four digits, a large one without an exponent."""
    return f"{float(f'{float(value):.4g}'):.10g}"
