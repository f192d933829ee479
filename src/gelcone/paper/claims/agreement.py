"""Claim about the cone and the continuum: their agreement in figure 3, and the thresholds that survive the
correction."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from gelcone.continuum.path import Ending
from gelcone.paper.numbers import Number
from gelcone.paper.studies.continuum import MISSING
from gelcone.paper.truths import share
from gelcone.paper.verdicts import Finding
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

CLOSE = 0.05
"""Forces agree closely if they differ by at most this share of the continuum's largest force: the resolution of a
plot."""
NEARLY_ALL = 0.95
"""A voltage is compared if at this share of the displacements or more the continuum has a physical state: in tension,
or slack if it wrinkles."""
SURVIVES = 0.2
"""A threshold survives if the corrected one lies within this share of the cone's, in states that exist."""


def agreement(studies: Mapping[str, xr.Dataset]) -> Finding:
    """Judges whether model (cone or membrane) and continuum agree closely at all voltages of figure 3, at the paper's
    radius ratio."""
    study, thresholds = studies["continuum"], studies["corrected"]
    missing = study.attrs.get(MISSING) or thresholds.attrs.get(MISSING)
    if missing:
        return Finding(
            holds=False,
            decidable=False,
            numbers=(),
            why=f"Nothing was computed: {missing}. After that, gelcone paper --force fem-agreement computes it.",
        )
    reached, off = shares_in_tension(study), deviations(study)
    agrees = (reached >= NEARLY_ALL) & (off <= CLOSE)
    ratios, voltages = study["radius_ratio"].values, study["constant_voltage"].values
    limit, cone_limit = (study[name].values[0] for name in ("limit_displacement", "cone_limit_displacement"))
    model = model_of(study)
    apart = study["membrane_deviation" if model == "membrane" else "deviation"].values[:, 0]
    largest = np.nanmax(np.abs(apart), axis=1)
    held = "in tension or slack" if '"relax"' in study.attrs.get("options", "") else "in tension"

    numbers = [
        Number(f"largest deviation of the {model}'s force at v = 0, a/b = {r:g}", float(off), error=1e-3)
        for r, off in zip(ratios, largest, strict=True)
    ]
    numbers += [
        Number(f"share of the displacements with a film {held}, v = {v:g}, a/b = {r:g}", float(reached[i, k]))
        for i, r in enumerate(ratios)
        for k, v in enumerate(voltages)
    ]
    numbers += [
        Number(f"displacement at {part:.0%} of the stretch limit next to the disc (cone {far:.4g})", float(near))
        for part, near, far in zip(study["share"].values, limit, cone_limit, strict=True)
    ]
    return Finding(
        holds=bool(agrees[0].all()),
        share=share(agrees[1:].all(axis=1), sample=False),
        neighbourhood="radius ratio a/b = " + " and ".join(f"{r:g}" for r in ratios[1:]),
        numbers=tuple(numbers),
        why=_why(agrees[0], voltages, float(largest[0]), float(ratios[0])),
        unseen=f"{_over_or_under(study['deviation'].values[0, 0])} The continuum's meridian is not straight, but steep "
        f"next to the disc: there the film reaches half of its stretch limit at a displacement of {limit[1]:.3g}, the "
        f"cone only at {cone_limit[1]:.3g}. "
        "Below: the paper's threshold voltages when the continuum replaces the cone.",
        details=threshold_table(thresholds),
    )


def _over_or_under(deviation: Array) -> str:
    """The displacements at which the cone's force is too large and too small, without voltage, in words."""
    high, low = float(np.nanmax(deviation)), float(np.nanmin(deviation))
    if low >= 0.0:
        return f"Without voltage the cone overestimates the force everywhere, by up to {high:.0%}."
    if high <= 0.0:
        return f"Without voltage the cone underestimates the force everywhere, by up to {-low:.0%}."
    return f"Without voltage the cone overestimates the force by up to {high:.0%} and underestimates it by {-low:.0%}."


def shares_in_tension(study: xr.Dataset) -> Array:
    """Share of the displacements with a physical continuum state: in tension, or slack if it wrinkles, and not pulled
    in, (ratios, voltages)."""
    return np.asarray(_held(study).mean("displacement").values)


def model_of(study: xr.Dataset) -> str:
    """The model compared with the continuum, in words: the homogeneous cone or the membrane."""
    return "membrane" if study.attrs.get("film") == "membrane" else "cone"


def deviations(study: xr.Dataset) -> Array:
    """Largest difference of the forces over the continuum's largest force, (ratios, voltages); infinite if nothing can
    be compared."""
    force = study["continuum_force"].where(_held(study))
    off = abs(study[f"{model_of(study)}_force"] - force).max("displacement") / abs(force).max("displacement")
    return np.asarray(off.fillna(np.inf).values)


def _held(study: xr.Dataset) -> xr.DataArray:
    return study["ending"].isin([Ending.CONVERGED, Ending.SLACK]) & (study["folds"] == 0)


def _why(agrees: Array, voltages: Array, largest: float, ratio: float) -> str:
    if agrees.all():
        return f"Both forces lie within {CLOSE:.0%} of each other at all voltages."
    failing = ", ".join(f"{v:g}" for v, fine in zip(voltages, agrees, strict=True) if not fine)
    return (
        f"They do not agree within {CLOSE:.0%} at v = {failing}. Without voltage the two differ by up to {largest:.0%} "
        f"for a/b = {ratio:g}; at the higher voltages a film without pre-stretch has lost its tension or pulled in, so "
        "that there is hardly any force to compare."
    )


def threshold_table(study: xr.Dataset) -> dict[str, str]:
    """The paper's thresholds in words: in the cone, corrected, and whether they survive."""
    rows = {}
    for k, name in enumerate(json.loads(study.attrs["threshold_names"])):
        cone, corrected, lost = (study[n].values[k] for n in ("cone", "corrected", "lost"))
        rows[str(name)] = f"cone {_interval(cone)}; " + _outcome(cone, corrected, float(lost))
    return rows


def survives(cone: Array, corrected: Array) -> bool:
    """Whether a corrected threshold exists and lies within `SURVIVES` of the cone's, middle to middle."""
    return bool(abs(np.mean(corrected) / np.mean(cone) - 1.0) <= SURVIVES)


def _outcome(cone: Array, corrected: Array, lost: float) -> str:
    if np.isfinite(corrected).all():
        change = float(np.mean(corrected) / np.mean(cone) - 1.0)
        survival = "survives" if survives(cone, corrected) else "does not survive"
        return f"corrected {_interval(corrected)} ({change:+.0%}): {survival}"
    if np.isfinite(lost):
        return f"corrected none: the film has no state above {lost:.3g}, it pulls in before: does not survive"
    return "corrected none in the searched range: does not survive"


def _interval(ends: Array) -> str:
    low, high = map(float, ends)
    if not np.isfinite(low + high):
        return "none in the searched range"
    return f"{low:.4g}" if high - low < 1e-4 * high else f"{0.5 * (low + high):.4g} [{low:.4g}, {high:.4g}]"
