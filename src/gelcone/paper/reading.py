"""Truths and numbers read off studies: chaotic motions, positive exponents, thresholds. Arrays of truths hold 1, 0 and
NaN (open)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from gelcone.codes import Regime
from gelcone.motion.attractor.search import PATIENCE
from gelcone.motion.tangents import CERTAIN
from gelcone.paper.numbers import Number
from gelcone.paper.verdicts import NEARLY_ALL
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

LIMIT_THRESHOLD = 1.5
"""Stretch limit below which the paper sees chaos (text)."""
STARTS = 4
"""Number of nearby starts of a motion, for the errors of numbers read from it."""
SAME = 0.05
"""Motions that differ by less than this share of their size look the same in a plot."""
SIX = (5.5, 6.5)
"""Interval that rounds to 6, the paper's number (text)."""


def ended(study: xr.Dataset) -> Array:
    """Mask of the runs that ended before the long run, for example by pull-in."""
    return np.asarray(study["regime"].values == Regime.LEFT_THE_DOMAIN)


def chaotic(study: xr.Dataset) -> Array:
    """Truths: the long run is chaotic by exponent and 0-1 test; false for a run that ended.

    Open for motions that have not settled, for chaos that ends so late that observing the end is chance, and where only
    some of the nearby starts have left chaos.
    """
    kinds = study["regime"].values
    undecided = kinds == Regime.TRANSIENT
    if "lifetime_high" in study:
        undecided = undecided | ((kinds == Regime.TRANSIENT_CHAOS) & (study["lifetime_high"].values > PATIENCE))
    if "share_chaotic" in study:
        undecided = undecided | ((kinds == Regime.CHAOTIC) & (study["share_chaotic"].values < 1.0))
    return np.where(undecided, np.nan, kinds == Regime.CHAOTIC)


def regular(study: xr.Dataset) -> Array:
    """Truths: the long run is certainly not chaotic; false for a run that ended."""
    return np.where(ended(study), 0.0, 1.0 - chaotic(study))


def without_chaos(study: xr.Dataset) -> Array:
    """Truths: no chaos in the long run; open for a run that ended."""
    return np.where(ended(study), np.nan, 1.0 - chaotic(study))


def positive(study: xr.Dataset) -> Array:
    """Truths: the largest exponent of the long run is positive by more than three standard errors. Open within three
    errors of zero, unless the motion is known to be regular; false for a run that ended."""
    exponent, error = study["lyapunov"].values[..., 0], study["standard_error"].values[..., 0]
    kinds = study["regime"].values
    certain = exponent > CERTAIN * error
    undecided = ~certain & ~(exponent < -CERTAIN * error) & np.isin(kinds, (Regime.TRANSIENT, Regime.CHAOTIC))
    return np.where(undecided, np.nan, certain)


def not_positive(study: xr.Dataset) -> Array:
    """Truths: the largest exponent of the long run is at most zero; open for a run that ended."""
    return np.where(ended(study), np.nan, 1.0 - positive(study))


def resolution(study: xr.Dataset) -> float:
    """Largest exponent over a finite window that counts as zero: log(T)/T, which regular motions reach."""
    window = study.attrs.get("window")
    return math.log(window) / window if window else 0.0


def finite_positive(study: xr.Dataset) -> Array:
    """Truths: the largest exponent over the finite window from the start is above zero, as the paper would read it;
    false for a run that ended in it."""
    return np.where(study["finite"].values[..., 0] > resolution(study), 1.0, 0.0)


def finite_not_positive(study: xr.Dataset) -> Array:
    """Truths: the largest exponent over the finite window is at most zero; open for a run that ended in it."""
    return np.where(np.isnan(study["finite"].values[..., 0]), np.nan, 1.0 - finite_positive(study))


def any_of(rows: Array) -> Array:
    """Truths: a statement holds at any place of each row."""
    return np.where((rows == 1.0).any(axis=-1), 1.0, np.where(np.isnan(rows).any(axis=-1), np.nan, 0.0))


def all_of(rows: Array) -> Array:
    """Truths: a statement holds at all places of each row."""
    return 1.0 - any_of(1.0 - rows)


def nearly_all_of(rows: Array) -> Array:
    """Truths: a statement holds at nine of ten places of each row, or more."""
    most_failing = math.floor((1.0 - NEARLY_ALL) * rows.shape[-1] + 1e-9)
    failing, open_ = (rows == 0.0).sum(axis=-1), np.isnan(rows).sum(axis=-1)
    return np.where(failing > most_failing, 0.0, np.where(failing + open_ <= most_failing, 1.0, np.nan))


def parted(study: xr.Dataset) -> Array:
    """Truths: at every point, most stretch limits below about 1.5 are chaotic and all above are regular."""
    below = study["stretch_limit"].values < LIMIT_THRESHOLD
    chaos, calm = chaotic(study), regular(study)
    held = np.where(below, chaos, 0.0)
    failing = np.where(below, 1.0 - chaos, 0.0)
    half = 0.5 * below.sum(axis=-1)
    low = np.where((held == 1.0).sum(axis=-1) > half, 1.0, np.where((failing == 1.0).sum(axis=-1) >= half, 0.0, np.nan))
    high = all_of(np.where(below, 1.0, calm))
    return all_of(np.stack([low, high], axis=-1))


def about_six(largest: Array, chaos: Array) -> Array:
    """Truths: the largest displacement in chaos rounds to 6; false without any chaos."""
    none = np.where(np.isnan(chaos).any(axis=-1), np.nan, 0.0)
    return np.where(np.isnan(largest), none, (largest >= SIX[0]) & (largest < SIX[1]))


def largest_in(chaos: Array, extent: Array) -> Array:
    """Largest extent in chaos of each row; NaN without chaos."""
    size = np.where(chaos == 1.0, extent, -np.inf).max(axis=-1)
    return np.where(np.isfinite(size), size, np.nan)


def ordered(kinds: Array) -> Array:
    """Truths: the three motions of each row are chaotic, periodic and at rest; open if an unsettled one decides."""
    decided = kinds != Regime.TRANSIENT
    fits = kinds == np.array([Regime.CHAOTIC, Regime.PERIODIC, Regime.REST])
    return all_of(np.where(decided, fits, np.nan))


def same_extents(extent: Array, kinds: Array) -> Array:
    """Truths: the extents (points, limits, starts) at every limit equal those at the largest one.

    True where each start has a counterpart at the other limit within `SAME` of its extent, false where no two agree,
    and open in between. Wandering motions such as chaos cover their extent only slowly: where some start wanders at
    every limit, one pair that agrees is enough.
    """
    least, _, apart = differences(extent)
    wandering = (~np.isin(kinds, (Regime.REST, Regime.PERIODIC))).any(axis=-1).all(axis=-1)
    return np.where((apart < SAME) | (wandering & (least < SAME)), 1.0, np.where(least >= SAME, 0.0, np.nan))


def differences(extent: Array) -> tuple[Array, Array, Array]:
    """Relative differences of the extents from those at the largest limit, for the limit that differs most, (points,).

    Three numbers: of the two starts that agree best, of the two that agree worst, and the largest difference between a
    start and its nearest counterpart.
    """
    last = extent[:, -1:, None, :]
    off = np.abs(extent[:, :-1, :, None] - last) / np.maximum(last, 0.01)
    nearest = np.maximum(off.min(axis=-1).max(axis=-1), off.min(axis=-2).max(axis=-1))
    return off.min(axis=(2, 3)).max(axis=1), off.max(axis=(2, 3)).max(axis=1), nearest.max(axis=1)


def fixed_branch(diagram: xr.Dataset) -> xr.Dataset:
    """The branch of a bifurcation diagram that starts from the fixed initial state."""
    name = next(b for b in diagram["branch"].values if str(b).startswith("from"))
    return diagram.sel(branch=name)


def first_chaos(diagram: xr.Dataset, parameter: str, *, falling: bool = False) -> Number | None:
    """Lowest parameter value with chaos (highest if ``falling``), and the range of its threshold.

    The range extends over undecided values to the next value that is certainly not chaotic.
    """
    branch = fixed_branch(diagram)
    values, truths = branch[parameter].values, chaotic(branch)
    if not (truths == 1.0).any():
        return None
    edge = int(np.flatnonzero(truths == 1.0)[-1 if falling else 0])
    step = 1 if falling else -1
    neighbour = edge + step
    while 0 <= neighbour < len(values) and np.isnan(truths[neighbour]):
        neighbour += step
    if not 0 <= neighbour < len(values):
        return Number(f"chaos at the end of the range, {parameter}", float(values[edge]))
    low, high = sorted((float(values[edge]), float(values[neighbour])))
    if abs(neighbour - edge) == 1:
        columns = (diagram[f"threshold_{name}"].values for name in ("branch", "low", "high"))
        branch_name = str(branch["branch"].values)
        bisected = ((float(a), float(b)) for name, a, b in zip(*columns, strict=True) if name == branch_name)
        low, high = next(((a, b) for a, b in bisected if a < high and low < b), (low, high))
    which = "largest" if falling else "smallest"
    seen = low if falling else high
    return Number(f"{which} {parameter.replace('_', ' ')} at which chaos was seen", seen, low=low, high=high)


def largest_exponent(meaning: str, motion: xr.Dataset) -> Number:
    """The largest exponent of the long run of one motion."""
    return Number(meaning, float(motion["lyapunov"][0]), error=float(motion["standard_error"][0]))


def slack_of(study: xr.Dataset, parameter: str) -> tuple[Number, ...]:
    """Share of the long run with slack film, for each chaotic motion of a study."""
    rows = zip(study[parameter].values, chaotic(study), study["late_validity_slack"].values, strict=True)
    name = parameter.replace("_", " ")
    return tuple(
        Number(f"share of the time that the film is slack in the chaos at {name} {value:g}", float(slack))
        for value, chaos, slack in rows
        if chaos == 1.0
    )
