"""Answers about the stability of rest under the drive."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import measured, unit_of
from gelcone.analyses.answer import heading, outcome_lines
from gelcone.motion.floquet import Onset
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject


def tongues_words(shown: xr.Dataset, subject: Subject) -> str:
    """The tongues as text."""
    volt = unit_of(shown["voltage"])
    onset, kind = float(shown["operating_onset_voltage"]), Onset(int(shown["operating_onset_kind"]))
    searched = f"searched up to {float(shown['operating_searched'][1]):.4g}{volt}"
    onset_text = f"onset at {onset:.6g}{volt}, " if np.isfinite(onset) else ""
    lines = [*heading(subject), *outcome_lines(shown), f"at its own frequency: {onset_text}{kind.meaning} ({searched})"]
    line = shown["onset_voltage"].values
    if np.isfinite(line).any():
        i = int(np.nanargmin(line))
        at = measured(shown["drive_frequency"][i])
        lines.append(f"lowest onset on the grid {line[i]:.4g}{volt} at drive frequency {at}")
    lines.append(_unstable_line(shown["margin"].values))
    static = float(shown["pitchfork_amplitude"])
    return "\n".join(
        [*lines, f"static pitchfork, for comparison: {static:.4g}{volt}"] if np.isfinite(static) else lines
    )


def _unstable_line(margin: Array) -> str:
    """The share of the cells in which rest is unstable, of those in which that is known."""
    known = margin[np.isfinite(margin)]
    if not known.size:
        return "whether rest is stable is unknown on all of the grid"
    of = "the grid" if known.size == margin.size else f"the {known.size} of {margin.size} cells in which that is known"
    return f"rest is unstable in {100.0 * float((known > 0.0).mean()):.3g} % of {of}"
