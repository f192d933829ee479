"""The data sheet on one page: a table of numbers, and curves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.amounts import sized
from gelcone.motion.proportion import IN_PROPORTION, PROPORTIONAL, held_at_peak
from gelcone.plots.style import (
    BLACK,
    BLUE,
    CYCLE,
    GREY,
    SKY,
    VERMILION,
    axis_label,
    log_ticks,
    name_axes,
    say,
    second_axes,
    styled,
)
from gelcone.plots.values import end_of_bars
from gelcone.words import is_toleranced, sheet_limits, sheet_rows, sheet_single

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 7.6, 10.2
MOST_COLUMNS = 4
LINE = 0.0365
"""Height of a row of the table, as a share of its panel."""
END = 1.15
"""End of the bar of an unbounded interval, over the longest bar."""
HALF_POWER = np.sqrt(0.5)


def datasheet_figure(result: xr.Dataset) -> Figure:
    """One page: the table on top; below force over displacement, stroke and force over voltage, response over
    frequency, and limits."""

    def draw(figure: Figure) -> None:
        parts: Any = figure.subfigures(2, 1, height_ratios=[0.93, 1.0])
        write_table(result, parts[0].subplots())
        grid = parts[1].subplots(2, 2)
        over_displacement(result, grid[0, 0])
        over_voltage(result, grid[0, 1])
        over_frequency(result, grid[1, 0])
        limit_bars(result, grid[1, 1])

    return styled(WIDTH, HEIGHT, draw)


def write_table(result: xr.Dataset, axes: Axes) -> None:
    """Name, numbers and first limit."""
    axes.set_axis_off()
    axes.set_xlim(-0.04, 1.04)
    axes.set_ylim(0.0, 1.0)
    name = result.attrs.get("device", "cone model, dimensionless")
    axes.text(0.0, 1.0, name, fontsize=14.0, fontweight="bold", va="top")
    axes.text(1.0, 0.99, "data sheet, computed", fontsize=9.0, color=GREY, va="top", ha="right")
    axes.axhline(0.935, xmin=0.037, xmax=0.963, color=BLACK, lw=1.0)
    rows = sheet_rows(result)
    chosen, places = _columns(len(rows[0][1]), is_toleranced(result))
    height = 0.905
    for k, (words, values) in enumerate(rows):
        weight = "bold" if k == 0 else "normal"
        axes.text(0.0, height, words, va="center", fontweight=weight)
        for place, i in zip(places, chosen, strict=True):
            axes.text(place, height, values[i], va="center", ha="right", fontweight=weight)
        height -= LINE
        axes.axhline(height + 0.5 * LINE, xmin=0.037, xmax=0.963, color=GREY, lw=0.6 if k == 0 else 0.15)
    height -= 0.4 * LINE
    single = sheet_single(result)
    for k, (words, value) in enumerate(single):
        x = 0.0 if k % 2 == 0 else 0.53
        axes.text(x, height, words, va="center", fontsize=8.5 if is_toleranced(result) else None)
        axes.text(x + 0.47, height, value, va="center", ha="right", fontsize=7.5 if is_toleranced(result) else None)
        height -= LINE * (k % 2 == 1 or k == len(single) - 1)
    height -= 0.3 * LINE
    for line in sheet_limits(result):
        axes.text(0.02 * line.startswith(" "), height, line.strip(), va="center", fontsize=8.5)
        height -= LINE


def _columns(count: int, toleranced: bool) -> tuple[np.ndarray, np.ndarray]:
    """The voltages that are shown, and the right ends of their columns; the last column holds tolerance intervals, if
    any."""
    voltages, right = (count - 1, 0.7) if toleranced else (count, 1.0)
    few = min(voltages, MOST_COLUMNS - toleranced)
    chosen = np.unique(np.linspace(0, voltages - 1, few).round().astype(int))
    places = 0.42 + (right - 0.42) * (np.arange(few) + 1) / (few if toleranced else max(few, 2))
    return (np.append(chosen, count - 1), np.append(places, 1.0)) if toleranced else (chosen, places)


def over_displacement(result: xr.Dataset, axes: Axes) -> None:
    """Force on a load at each voltage, with blocked force, free stroke, and the work of the last voltage's stroke."""
    heights, rest = result["displacement"].values, float(result["rest_displacement"])
    for colour, k in zip(CYCLE, range(result.sizes["constant_voltage"]), strict=False):
        curve = result.isel(constant_voltage=k)
        axes.plot(heights, -curve["force"].values, color=colour, label=sized(curve["constant_voltage"]))
        axes.plot(rest, curve["blocked_force"], "o", color=colour, ms=4.0, zorder=3)
        axes.plot(rest + curve["stroke"], 0.0, "D", color=colour, ms=4.0, mfc="white", zorder=3)
    end = rest + float(curve["stroke"])
    inside = (heights >= rest) & (heights <= end)
    axes.fill_between(heights, 0.0, -curve["force"].values, where=inside, color=SKY, alpha=0.3, lw=0)
    axes.axhline(0.0, color=GREY, lw=0.6)
    name_axes(axes, result["displacement"], result["force"], "height", "force on a load")
    axes.legend(fontsize=7.0, loc="lower left")
    axes.set_title("dot: blocked force, diamond: free stroke", loc="left", fontsize=7.0)
    axes.margins(x=0)


def over_voltage(result: xr.Dataset, axes: Axes) -> None:
    """Stroke and blocked force on a slow ramp."""
    volts = result["ramp_voltage"]
    axes.plot(volts, result["ramp_stroke"], color=BLUE)
    axes.set_xlabel(axis_label(volts, "constant voltage"))
    other = second_axes(axes, result["ramp_stroke"], "free stroke", result["ramp_blocked_force"], "blocked force")
    other.plot(volts, result["ramp_blocked_force"], color=VERMILION, ls="--")
    axes.margins(x=0)


def over_frequency(result: xr.Dataset, axes: Axes) -> None:
    """The small-signal response about each voltage."""
    frequency = result["drive_frequency"]
    shown = [k for k in range(result.sizes["constant_voltage"]) if result["gain"][k].notnull().any()]
    for colour, k in zip(CYCLE, shown, strict=False):
        label = sized(result["constant_voltage"][k])
        axes.plot(frequency, result["gain"][k], color=colour, label=f"about {label}")
    axes.axhline(HALF_POWER, color=GREY, lw=0.8, ls=":", label="half power")
    axes.set_yscale("log")
    log_ticks(axes)
    axes.set_xlabel(axis_label(frequency, "frequency"))
    axes.set_ylabel("small stroke over static one")
    axes.legend(fontsize=6.0)


def limit_bars(result: xr.Dataset, axes: Axes) -> None:
    """Peak voltages of the limits that the drive meets, as bars."""
    met = {name: float(result[name]) for name in _limits(result) if np.isfinite(result[name])}
    more = IN_PROPORTION if held_at_peak(result) else ""
    axes.set_title(f"limits met: peak of the drive{more}", loc="left", fontsize=7.0 if more else 8.0)
    if not met:
        say(axes, str(result.attrs["first_limit"]))
        axes.set_axis_off()
        return
    names = sorted(met, key=lambda name: -met[name])
    colours = [VERMILION if met[name] == min(met.values()) else BLUE for name in names]
    end = end_of_bars(list(met.values()))
    axes.barh(range(len(names)), [min(met[name], end) for name in names], color=colours, height=0.4)
    for k, name in enumerate(names):
        if met[name] > end:
            axes.text(end, k, f"{met[name]:.3g} ", fontsize=6.0, color="white", ha="right", va="center")
        if is_toleranced(result):
            span = np.clip([float(result[f"{name}_{end}"]) for end in ("low", "high")], 0.0, END * end)
            axes.plot(span, [k, k], color=BLACK, lw=1.5)
    axes.set_ylim(-0.6, max(len(names), 4) - 0.4)
    axes.set_yticks(range(len(names)), [_limit_label(name, result) for name in names], fontsize=7.0)
    axes.set_xlabel(axis_label(result["first_limit_voltage"], "peak voltage"))


def _limits(result: xr.Dataset) -> list[str]:
    """The names of the variables with the limits of the drive; of films in opposite phase without the pull-in at the
    bias of the device, which the drive scales; none without a drive."""
    if "first_limit_voltage" not in result:
        return []
    every = [str(name) for name, value in result.data_vars.items() if value.dims == ()]
    every = [name for name in every if name.endswith("_voltage") and name.removeprefix(PROPORTIONAL) not in NOT_LIMITS]
    return [name for name in every if not held_at_peak(result) or name.startswith((PROPORTIONAL, "driven_"))]


def _limit_label(name: str, result: xr.Dataset) -> str:
    """The label of a limit by the name of its variable; that of pull-in says whether it is a cone's or its membrane's,
    where the result has both."""
    words = name.removeprefix(PROPORTIONAL).removesuffix("_voltage").replace("pull_in", "pull-in").replace("_", " ")
    if "membrane_pull_in_voltage" in result:
        whose = {"pull-in": "cone pull-in", "driven pull-in": f"driven {result.attrs['pull_in_of']} pull-in"}
        words = whose.get(words, words)
    return words.replace("driven ", "drive: ")


NOT_LIMITS = (
    "first_limit_voltage", "safe_peak_voltage", "examined_voltage", "examined_step_voltage", "driven_error_voltage",
    "pitchfork_voltage",
)  # fmt: skip
