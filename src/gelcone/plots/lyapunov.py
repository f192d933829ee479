"""Figure of the largest Lyapunov exponent: convergence of the estimate, and the long-run value."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import rate_unit, time_unit, with_error
from gelcone.plots.response import members
from gelcone.plots.section import failure
from gelcone.plots.style import CYCLE, GREY, styled
from gelcone.words import SIGNS

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TIMES = ("finite_time", "running_time")
SETTLED = 0.05
"""Estimates over windows longer than this share of the longest one set the limits; earlier ones may leave them."""


def lyapunov_figure(result: xr.Dataset) -> Figure:
    """Running estimates over the window's length, with the long-run values; up to six members of an ensemble."""

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        running_exponents(result, axes)
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))

    return styled(7.2, max(3.2, 1.1 + 0.52 * len(members(result))), draw, result)


def running_exponents(result: xr.Dataset, axes: Axes) -> None:
    """Largest exponent over window length: from the start (dashed, a dot at the end of the finite window) and after the
    transient (solid), with a band of one standard error about the long-run value."""
    axes.set_xscale("log")
    size, unit = _window_unit(result)
    result = result.assign({name: result[name] / size for name in TIMES})
    axes.axhline(0.0, color=GREY, lw=0.8)
    for colour, (name, member) in zip(CYCLE, members(result), strict=False):
        draw_member(member, name, colour, axes)
    set_limits(result, axes)
    axes.plot([], [], color=GREY, ls="--", marker="o", ms=4.0, label="from the start, to the\nend of the finite window")
    axes.plot([], [], color=GREY, label="after the transient, with\nlong-run value ± s.e.")
    axes.set_xlabel(f"window length ({unit})")
    axes.set_ylabel(f"largest Lyapunov exponent\n({rate_unit(result['lyapunov'])})")


def _window_unit(result: xr.Dataset) -> tuple[float, str]:
    """The unit in which the finite window reads well, as in the text, and how many of the result's it is."""
    times = result["finite_time"].values
    size, unit = time_unit(float(np.max(times, initial=0.0, where=np.isfinite(times))), result["running_time"])
    return size, "dimensionless time" if unit == " time units" else unit.strip()


def draw_member(member: xr.Dataset, name: str, colour: str, axes: Axes) -> None:
    """Both running estimates of a member and its long-run value."""
    time, exponent = member["finite_time"].values, member["finite_exponent"].values
    axes.plot(time, exponent, color=colour, ls="--", lw=0.8)
    if np.isfinite(exponent).any():
        end = np.flatnonzero(np.isfinite(exponent))[-1]
        axes.plot(time[end], exponent[end], "o", ms=4.0, color=colour)
    time = member["running_time"].values
    axes.plot(time, member["running_exponent"], color=colour, label=f"{name}\n{verdict(member)}".strip())
    value, error = float(member["lyapunov"][0]), float(member["standard_error"][0])
    if np.isfinite(time).any() and np.isfinite(value):
        ends = [np.nanmin(time), np.nanmax(time)]
        axes.fill_between(ends, value - error, value + error, color=colour, alpha=0.2, lw=0.0)
        axes.plot(ends, [value, value], color=colour, lw=0.6)


def verdict(member: xr.Dataset) -> str:
    """The long-run value with its error, and whether its sign is certain; or the failure."""
    if words := failure(member):
        return words
    value = with_error(float(member["lyapunov"][0]), float(member["standard_error"][0]))
    return f"{value}\n{SIGNS[int(member['sign'])]}"


def set_limits(result: xr.Dataset, axes: Axes) -> None:
    """Limits that contain zero and all estimates except those over the shortest windows."""
    seen = [np.zeros(1)]
    for time, exponent in (("finite_time", "finite_exponent"), ("running_time", "running_exponent")):
        longest = result[time].max("window")
        seen.append(result[exponent].where(result[time] > SETTLED * longest).values.ravel())
    value, error = result["lyapunov"].isel(exponent=0), result["standard_error"].isel(exponent=0)
    seen += [(value - error).values.ravel(), (value + error).values.ravel()]
    values = np.concatenate(seen)
    low, high = np.nanmin(values), np.nanmax(values)
    room = 0.08 * (high - low) or 1.0
    axes.set_ylim(low - room, high + room)
