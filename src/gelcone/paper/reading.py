"""What claims read off studies: where the motion is chaotic, where exponents are positive, intervals of thresholds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone.codes import Regime
from gelcone.motion.tangents import CERTAIN
from gelcone.paper.verdicts import Number

if TYPE_CHECKING:
    import xarray as xr

Mask = npt.NDArray[np.bool_]


def chaotic(study: xr.Dataset) -> Mask:
    """Where the long run is chaotic by exponent and 0-1 test."""
    return study["regime"].values == Regime.CHAOTIC


def positive(study: xr.Dataset) -> Mask:
    """Where the largest exponent of the long run is positive by more than three standard errors."""
    return study["lyapunov"].values[..., 0] > CERTAIN * study["standard_error"].values[..., 0]


def finite_positive(study: xr.Dataset) -> Mask:
    """Where the largest exponent over the finite window from the start is above zero, as the paper would read it."""
    return study["finite"].values[..., 0] > 0.0


def fixed_branch(diagram: xr.Dataset) -> xr.Dataset:
    """The branch of a bifurcation diagram that starts from the fixed initial state."""
    name = next(b for b in diagram["branch"].values if str(b).startswith("from"))
    branch: xr.Dataset = diagram.sel(branch=name)
    return branch


def share(mask: Any) -> float:
    """Share of true values; NaN for none at all."""
    mask = np.asarray(mask)
    return float(mask.mean()) if mask.size else float("nan")


def share_number(meaning: str, mask: Any) -> Number:
    """A share of grid points with its 95 % Wilson interval, the grid taken as a sample of the range."""
    mask = np.asarray(mask)
    n, p, z = max(mask.size, 1), share(mask), 1.96
    centre = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return Number(meaning, p, low=float(max(0.0, centre - half)), high=float(min(1.0, centre + half)))


def first_chaos(diagram: xr.Dataset, parameter: str, *, falling: bool = False) -> Number | None:
    """Lowest value of the parameter with chaos (highest if ``falling``), with the interval of its threshold."""
    branch = fixed_branch(diagram)
    values, mask = branch[parameter].values, chaotic(branch)
    if not mask.any():
        return None
    edge = int(np.flatnonzero(mask)[-1 if falling else 0])
    neighbour = edge + 1 if falling else edge - 1
    if not 0 <= neighbour < len(values):
        return Number(f"chaos at the end of the range, {parameter}", float(values[edge]), error=0.0)
    low, high = sorted((float(values[edge]), float(values[neighbour])))
    refined = [
        (float(a), float(b))
        for name, a, b in zip(
            diagram["threshold_branch"].values,
            diagram["threshold_low"].values,
            diagram["threshold_high"].values,
            strict=True,
        )
        if name == str(branch["branch"].values) and low <= a and b <= high
    ]
    low, high = refined[0] if refined else (low, high)
    which = "largest" if falling else "smallest"
    return Number(f"{which} {parameter.replace('_', ' ')} with chaos", 0.5 * (low + high), low=low, high=high)
