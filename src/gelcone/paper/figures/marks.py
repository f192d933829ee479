"""Marks shared by the paper's figures: slack film, symbols of parameters."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.codes import Regime
from gelcone.plots.regime import REGIME_COLOURS
from gelcone.plots.style import BLACK, GREY

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SYMBOLS = {
    "damping_ratio": r"$\zeta$",
    "stretch_limit": "$J$",
    "voltage": "$v$",
    "prestretch": r"$\lambda_p$",
    "spring_stiffness": r"$\kappa$",
    "drive_frequency": r"$\omega$",
    "rest_height": "$x_0$",
}


def fixed_parameters(study: xr.Dataset, *names: str) -> str:
    """The parameter set of a study, and the named parameters (default all) that are constant in it."""
    model = json.loads(study.attrs["model"])
    wanted = [name for name in names or SYMBOLS if name in model]
    shared = ", ".join(f"{SYMBOLS[name]} = {float(model[name]):g}" for name in wanted)
    return f"set {study.attrs['preset']}: {shared}"


def listed(values: Sequence[float]) -> str:
    """Numbers as an enumeration: ``1, 2 and 3``."""
    *first, last = (f"{value:g}" for value in values)
    return f"{', '.join(first)} and {last}"


def mark_slack(axes: Axes, x: Any, y: Any, slack: Any, colour: str) -> None:
    """A line that is faint where the film is slack."""
    x, y, slack = np.asarray(x), np.asarray(y), np.asarray(slack) != 0
    # both lines reach the next sample of the other kind, so that no gaps are left
    taut = ~slack
    taut[1:] |= taut[:-1]
    axes.plot(x, y, color=colour, lw=0.7, alpha=0.45)
    axes.plot(x, np.where(taut, y, np.nan), color=colour, lw=1.0)


def film_legend(figure: Figure, kinds: Sequence[Regime]) -> None:
    """One legend below all panels."""
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], color=BLACK, lw=1.2, label="film taut"),
        Line2D([], [], color=BLACK, lw=0.7, alpha=0.45, label="film slack: the model does not hold"),
        Line2D([], [], color=GREY, lw=0.8, marker="x", ms=4.0, label="window from the start"),
    ]
    handles += [
        Line2D([], [], color=REGIME_COLOURS[kind], lw=1.2, marker="o", ms=4.0, label=f"long run: {kind.label}")
        for kind in dict.fromkeys(kinds)
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
