"""Figure of a spectrum: amplitude over frequency, with its lines marked."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.plots.response import members
from gelcone.plots.section import failure
from gelcone.plots.style import BLUE, GREY, VERMILION, axis_label, styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_LABELS = 8
"""Most lines of a panel labelled with their frequency, strongest first."""
LABEL_WIDTH = 0.045
"""Width of a label, as a share of the panel."""
DEEPEST = 1e-9
"""Amplitudes below this share of the largest one are not shown."""


def spectrum_figure(spectrum: xr.Dataset) -> Figure:
    """Amplitude over frequency, one panel per member; up to six members of an ensemble."""
    shown = members(spectrum)

    def draw(figure: Figure) -> None:
        panels = figure.subplots(len(shown), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
        for axes, (name, member) in zip(panels, shown, strict=True):
            amplitude_spectrum(member, axes, room_for=spectrum)
            axes.set_title(name, loc="left", fontsize=8.0)
            axes.label_outer()

    return styled(7.2, 2.8 if len(shown) == 1 else 0.4 + 1.7 * len(shown), draw, spectrum)


def amplitude_spectrum(member: xr.Dataset, axes: Axes, room_for: xr.Dataset | None = None) -> None:
    """Amplitude of one member over frequency: in hertz for results in SI units, otherwise relative to the drive's.

    The run of a drive that does not repeat is drawn over the frequency itself. ``room_for`` is the ensemble whose
    members share the axis limits; by default the member alone.
    """
    frequency = _frequency(member)
    axes.plot(frequency, _of_motion(member), color=BLUE, lw=0.7)
    set_limits(member if room_for is None else room_for, axes)
    of_drive = frequency.name == "frequency_ratio"
    at, height = member["line_ratio" if of_drive else "line_frequency"].values, member["line_amplitude"].values
    axes.plot(at, height, "o", ms=3.5, mfc="none", mec=VERMILION, mew=0.8)
    label_lines(axes, at, height)
    axes.set_title(verdict(member), loc="right", fontsize=8.0, color=GREY)
    axes.set_xlabel("frequency / drive frequency" if of_drive else axis_label(frequency, "frequency"))
    axes.set_ylabel(axis_label(member["amplitude"], "amplitude"))


def set_limits(spectrum: xr.Dataset, axes: Axes) -> None:
    """Log limits over the amplitudes above `DEEPEST` of the largest, with room for labels."""
    frequency, moving = _frequency(spectrum), _of_motion(spectrum)
    largest = float(moving.max())
    axes.set_yscale("log")
    if largest > 0.0:
        seen = moving > DEEPEST * largest
        axes.set_xlim(0.0, 1.02 * float(frequency.where(seen).max()))
        axes.set_ylim(max(0.5 * float(moving.where(seen).min()), DEEPEST * largest), 20.0 * largest)


def _frequency(spectrum: xr.Dataset) -> xr.DataArray:
    """The frequency axis: relative to the drive's for dimensionless results of drives that repeat."""
    in_si = spectrum["frequency"].attrs["units"] != "1"
    without_lines = (spectrum["flatness"].notnull() & spectrum["power_in_lines"].isnull()).any()  # it does not repeat
    return spectrum["frequency" if in_si or without_lines else "frequency_ratio"]


def _of_motion(spectrum: xr.Dataset) -> xr.DataArray:
    """The amplitude without the mean in the first bin, and without motions that are only rounding."""
    amplitude, moves = spectrum["amplitude"], spectrum["flatness"].notnull()
    return amplitude.where((spectrum["frequency_ratio"] > 0.0) & (amplitude > 0.0) & moves)


def label_lines(axes: Axes, at: np.ndarray, height: np.ndarray) -> None:
    """Writes the frequencies of the strongest lines above them, unless they would overlap."""
    left, right = axes.get_xlim()
    taken: list[float] = []
    for x, y in zip(at, height, strict=True):
        apart = all(abs(x - other) > LABEL_WIDTH * (right - left) for other in taken)
        if np.isfinite(x) and left <= x <= right and apart and len(taken) < MOST_LABELS:
            taken.append(float(x))
            axes.annotate(
                f"{x:.4g}", (x, y), (0.0, 3.0), textcoords="offset points", ha="center", va="bottom", fontsize=7.0
            )


def verdict(member: xr.Dataset) -> str:
    """The result of a member in a few words."""
    share, flatness = float(member["power_in_lines"]), float(member["flatness"])
    if failure(member):
        return failure(member)
    if np.isnan(flatness):
        return "stands still"
    if np.isnan(share):
        return f"of the run, flatness {flatness:.1e}"
    return f"{100.0 * share:.4g} % of the variance in lines, flatness {flatness:.1e}"
