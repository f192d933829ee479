"""What claims read off studies: where the motion is chaotic, where exponents are positive, intervals of thresholds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.codes import Regime
from gelcone.motion.attractor.search import PATIENCE
from gelcone.motion.tangents import CERTAIN
from gelcone.paper.numbers import Number
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr


def chaotic(study: xr.Dataset) -> Array:
    """Where the long run is chaotic by exponent and 0-1 test: truths.

    Open where the motion has not settled, where chaos ends so late that it is chance whether an end is seen, and where
    some of the nearby starts have left it and others have not.
    """
    kinds = study["regime"].values
    untold = kinds == Regime.TRANSIENT
    if "lifetime_high" in study:
        untold = untold | ((kinds == Regime.TRANSIENT_CHAOS) & (study["lifetime_high"].values > PATIENCE))
    if "share_chaotic" in study:
        untold = untold | ((kinds == Regime.CHAOTIC) & (study["share_chaotic"].values < 1.0))
    return np.where(untold, np.nan, kinds == Regime.CHAOTIC)


def regular(study: xr.Dataset) -> Array:
    """Where the long run is certain not to be chaotic: truths."""
    return 1.0 - chaotic(study)


def positive(study: xr.Dataset) -> Array:
    """Where the largest exponent of the long run is positive by more than three standard errors: truths, open where it
    is within three of zero and the motion is not known to be regular."""
    exponent, error = study["lyapunov"].values[..., 0], study["standard_error"].values[..., 0]
    kinds = study["regime"].values
    certain = exponent > CERTAIN * error
    untold = ~certain & ~(exponent < -CERTAIN * error) & np.isin(kinds, (Regime.TRANSIENT, Regime.CHAOTIC))
    return np.where(untold, np.nan, certain)


def finite_positive(study: xr.Dataset) -> Array:
    """Where the largest exponent over the finite window from the start is above zero, as the paper would read it."""
    return np.where(study["finite"].values[..., 0] > 0.0, 1.0, 0.0)


def fixed_branch(diagram: xr.Dataset) -> xr.Dataset:
    """The branch of a bifurcation diagram that starts from the fixed initial state."""
    name = next(b for b in diagram["branch"].values if str(b).startswith("from"))
    branch: xr.Dataset = diagram.sel(branch=name)
    return branch


def first_chaos(diagram: xr.Dataset, parameter: str, *, falling: bool = False) -> Number | None:
    """Lowest value of the parameter with chaos (highest if ``falling``), with the range of its threshold.

    The range reaches from there over all values of which it is not certain to the next one without chaos.
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
    refined = [
        (float(a), float(b))
        for name, a, b in zip(
            diagram["threshold_branch"].values,
            diagram["threshold_low"].values,
            diagram["threshold_high"].values,
            strict=True,
        )
        if name == str(branch["branch"].values) and abs(neighbour - edge) == 1 and a < high and low < b
    ]
    low, high = refined[0] if refined else (low, high)
    which = "largest" if falling else "smallest"
    return Number(f"{which} {parameter.replace('_', ' ')} with chaos", 0.5 * (low + high), low=low, high=high)


def slack_of(study: xr.Dataset, parameter: str) -> tuple[Number, ...]:
    """For what share of the long run the film was slack, at each motion of a study that is chaotic."""
    rows = zip(study[parameter].values, chaotic(study), study["late_validity_slack"].values, strict=True)
    name = parameter.replace("_", " ")
    return tuple(
        Number(f"share of the time that the film is slack in the chaos at {name} {value:g}", float(slack))
        for value, chaos, slack in rows
        if chaos == 1.0
    )
