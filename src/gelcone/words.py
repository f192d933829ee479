"""Results in words, the same in figures and on the command line."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from gelcone.codes import Outcome, Regime

if TYPE_CHECKING:
    import xarray as xr


def with_error(value: float, error: float) -> str:
    """A signed value to the digits that its standard error leaves it, and the error: ``+0.0310 ± 0.0061``."""
    if not math.isfinite(value):
        return "unknown"
    if not (math.isfinite(error) and error > 0.0):
        return f"{value:+.4g}"
    # Two digits of the error, and never more than six of the value.
    own = 1 - math.floor(math.log10(error))
    decimals = min(own, 5 - math.floor(math.log10(max(abs(value), error))))
    if not 0 <= decimals <= 8:
        return f"{value:+.3e} ± {error:.1e}"
    return (
        f"{value:+.{decimals}f} ± {error:.{decimals}f}" if decimals == own else f"{value:+.{decimals}f} ± {error:.1g}"
    )


def motion_in_words(regime: int, period: int = 0, symmetric: bool = False) -> str:
    """A kind of motion, with its period in drive repeats and its symmetry where it has them."""
    if regime != Regime.PERIODIC:
        return Regime(regime).label
    return f"periodic, period {period}{', symmetric' if symmetric else ''}"


def outcome_in_words(code: int) -> str:
    """How a run ended, in two or three words."""
    return Outcome(code).name.lower().replace("_", " ")


def unit_of(variable: xr.DataArray) -> str:
    """The unit of a variable behind a space, nothing for a dimensionless one."""
    units = variable.attrs.get("units", "1")
    return "" if units == "1" else f" {units}"


def rate_unit(variable: xr.DataArray) -> str:
    """What an exponent is counted per."""
    return "per unit time" if variable.attrs.get("units", "1") == "1" else "per second"
