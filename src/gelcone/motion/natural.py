"""The natural frequency of small motions about an equilibrium under a constant voltage."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.motion.ramp import stroke_and_blocked_force
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

ROUNDING = 1e-9
"""Amount by which a stiffness that counts as zero, as in a fold, may be negative."""


def natural_frequency(model: ConeModel, voltage: npt.ArrayLike, displacement: npt.ArrayLike | None = None) -> Any:
    """Angular frequency of small undamped motions about an equilibrium; NaN where there is no stable one.

    Parameters
    ----------
    model : a single model.
    voltage : constant voltage, dimensionless: a number, or shape (voltages,).
    displacement : the equilibrium there, of the same shape. Default: the one that a slow ramp from 0 to the voltage
        ends at.
    """
    if displacement is None:
        ramp = stroke_and_blocked_force(model, np.abs(voltage))
        displacement = ramp["displacement"].values.reshape(np.shape(voltage))
    return frequency_of(model.stiffness(displacement, voltage))


def frequency_of(stiffness: Array | float) -> Any:
    """Angular frequency of small undamped motions at a slope of the static force; NaN where that is negative."""
    with np.errstate(invalid="ignore"):
        return np.sqrt(np.where(np.asarray(stiffness) >= -ROUNDING, np.maximum(stiffness, 0.0), np.nan))[()]
