"""Names of two questions about double cones in opposite phase, whose second film has 2 v0 - v about the bias v0.

A constant voltage v is held at the actuator's bias. A drive that is held at its peak is scaled as a whole, its bias
and amplitude in proportion, so that v0 rises with v. For all other actuators both are one question.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.physics.system import ConeSystem

IN_PROPORTION = ", bias and amplitude in proportion"
PROPORTIONAL = "proportional_"
"""Beginning of the names of voltages in proportion that constant voltages have, too."""
OWN_BIAS = ", at the actuator's bias"


def at_own_bias(system: ConeSystem) -> str:
    """The addition to the meaning of a constant voltage: empty where the bias plays no part."""
    return OWN_BIAS if system.in_opposite_phase else ""


def in_proportion(system: ConeSystem) -> str:
    """The addition to the meaning of a peak voltage: empty where the bias plays no part of its own."""
    return IN_PROPORTION if system.in_opposite_phase else ""


def proportional(name: str, system: ConeSystem) -> str:
    """The name of the variable for a peak at which a drive is held, given that for a constant voltage."""
    return f"{PROPORTIONAL}{name}" if system.in_opposite_phase else name


def held_at_peak(limits: xr.Dataset) -> bool:
    """Whether quasi-static limits are of a drive that is held at its peak, and not of a constant voltage at the
    device's bias: of films in opposite phase."""
    return "recommended_second_voltage" in limits or f"{PROPORTIONAL}pull_in_voltage" in limits
