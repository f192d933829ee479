"""Numbers with their units as text, in the unit in which they read well."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from gelcone.devices.scales import MEASURES, Measure
from gelcone.devices.units import DIMENSIONS, format_range, in_one_unit

if TYPE_CHECKING:
    import xarray as xr


def with_error(value: float, error: float) -> str:
    """A signed value to the digits that its standard error leaves it, and the error: ``+0.0310 ± 0.0061``."""
    if not math.isfinite(value):
        return "unknown"
    if not (math.isfinite(error) and error > 0.0):
        return f"{value:+.4g}"
    # Two digits of the error, and never more than six of the value.
    error_decimals = 1 - math.floor(math.log10(error))
    decimals = min(error_decimals, 5 - math.floor(math.log10(max(abs(value), error))))
    if not 0 <= decimals <= 8:
        return f"{value:+.3e} ± {error:.1e}"
    return (
        f"{value:+.{decimals}f} ± {error:.{decimals}f}"
        if decimals == error_decimals
        else f"{value:+.{decimals}f} ± {error:.1g}"
    )


def unit_of(variable: xr.DataArray) -> str:
    """The unit of a variable after a space, nothing for a dimensionless one."""
    units = variable.attrs.get("units", "1")
    return "" if units == "1" else f" {units}"


def measured(variable: xr.DataArray, digits: int = 4) -> str:
    """A single number with its unit, or a text; one that is not finite in the words of its attributes."""
    if variable.dtype.kind in "UO":
        return str(variable.item())
    value = float(variable)
    return f"{value:.{digits}g}{unit_of(variable)}" if math.isfinite(value) else missing(value, variable)


def missing(value: float, variable: xr.DataArray) -> str:
    """The words for a value of a variable that is not finite."""
    if math.isnan(value):
        return str(variable.attrs.get("nan_means", "unknown"))
    return str(variable.attrs.get("infinite_means", "infinite"))


TIMES = (("ms", 1.0), ("s", 1e3), ("min", 6e4), ("h", 3.6e6), ("days", 8.64e7))
"""Units of a time and how many milliseconds each is."""
FEWEST = 2.0
"""A unit is used from this number of it on."""
FEWEST_DIGITS = 4
"""Numbers below 10,000 have no exponent, however few of their digits count."""


def time_unit(value: float, variable: xr.DataArray) -> tuple[float, str]:
    """The unit in which a time reads well, with a space before it, and how many of the variable's units it is."""
    units = variable.attrs.get("units", "1")
    if units not in dict(TIMES):
        return 1.0, " time units" if units == "1" else f" {units}"
    unit_size = dict(TIMES)[units]
    name, size = next((t for t in reversed(TIMES) if value * unit_size >= FEWEST * t[1]), TIMES[0])
    return size / unit_size, f" {name}"


def lasting(value: float, variable: xr.DataArray, digits: int = 2) -> str:
    """A time of the kind of a variable."""
    if math.isinf(value):
        return "infinite"
    size, unit = time_unit(value, variable)
    number = float(f"{value / size:.{digits}g}")
    return f"{number:.{max(digits, FEWEST_DIGITS)}g}{unit}"


def rate_unit(variable: xr.DataArray) -> str:
    """The time that an exponent refers to."""
    return "per unit time" if variable.attrs.get("units", "1") == "1" else "per second"


ATOM = 1e-10
"""In metres: a shorter length is shown as 0, such as the stroke of a disc that is at rest."""


def sized(variable: xr.DataArray, digits: int = 4) -> str:
    """A single number with the unit in which it reads well."""
    return sized_range(variable, variable, digits)


def sized_range(low: xr.DataArray, high: xr.DataArray, digits: int = 4) -> str:
    """Two ends of a range with the unit in which the larger reads well; one number where they do not differ."""
    if not (math.isfinite(low) and math.isfinite(high)):
        return " to ".join(dict.fromkeys(_alone(end, digits) for end in (low, high)))
    measure = _measure_of(low)
    if measure is None:
        ends = dict.fromkeys(f"{float(end):.{digits}g}" for end in (low, high))
        return f"{' to '.join(ends)}{unit_of(low)}"
    least, most = (_without_atoms(float(end) / measure.per_unit, measure.unit) for end in (low, high))
    if measure.unit == "m" and least == most == 0.0:
        return f"0{unit_of(low)}"
    return format_range(least, most, measure.unit, digits)


def sized_with_error(variable: xr.DataArray, error: xr.DataArray | None, digits: int) -> str:
    """A single number with its error, both in the unit in which the number reads well: ``239.600932 ± 8.4e-06 V``.
    It has the digits that the error, of two digits, leaves; without an error ``digits``."""
    value, spread = float(variable), 0.0 if error is None else float(error)
    if not (math.isfinite(value) and 0.0 < spread < math.inf):
        return sized(variable, digits)
    spread = float(f"{spread:.2g}")
    digits_left = 2 + _place(value) - _place(spread) if value else 2
    measure = _measure_of(variable)
    per_unit, unit = (1.0, "1") if measure is None else (measure.per_unit, measure.unit)
    (text, error_text), symbol = in_one_unit([value / per_unit, spread / per_unit], unit, max(digits_left, 2))
    return f"{text} ± {error_text}{unit_of(variable) if measure is None else f' {symbol}'}"


def _place(value: float) -> int:
    """The power of ten of the first digit of a number."""
    return math.floor(math.log10(abs(value)))


def sized_alike(variable: xr.DataArray, digits: int = 4, among: float = 0.0) -> list[str]:
    """The numbers of a variable of one dim, with the unit in which the largest of them, or ``among``, reads well."""
    measure, finite = _measure_of(variable), np.isfinite(variable.values)
    if measure is None or not finite.any():
        return [sized(one, digits) for one in variable]
    in_si = [_without_atoms(float(v) / measure.per_unit, measure.unit) for v in variable.values[finite]]
    if measure.unit == "m" and not any((*in_si, among)):
        return [sized(one, digits) for one in variable]
    texts, symbol = in_one_unit([*in_si, among / measure.per_unit], measure.unit, digits)
    known = iter(texts)
    return [
        f"{next(known)} {symbol}".rstrip() if k else _alone(one, digits)
        for one, k in zip(variable, finite, strict=True)
    ]


def lasting_alike(variable: xr.DataArray, digits: int = 2) -> list[str]:
    """The times of a variable of one dim, all in the unit in which the longest reads well; words for none."""
    finite = variable.values[np.isfinite(variable.values)]
    size, unit = time_unit(float(finite.max(initial=0.0)), variable)
    return [
        f"{float(one) / size:.{digits}g}{unit}" if np.isfinite(one) else missing(float(one), variable)
        for one in variable
    ]


def _alone(variable: xr.DataArray, digits: int) -> str:
    """A single number with its unit, or the words for one that is not finite."""
    return sized(variable, digits) if math.isfinite(variable) else missing(float(variable), variable)


def _measure_of(variable: xr.DataArray) -> Measure | None:
    """The measure of a variable that is in the unit in which results are read; None for another."""
    measure = MEASURES.get(str(variable.attrs.get("quantity")))
    known = measure is not None and measure.unit in DIMENSIONS and unit_of(variable) == f" {measure.shown}"
    return measure if known else None


def _without_atoms(value: float, unit: str) -> float:
    """A value in SI, 0 for a length shorter than an atom."""
    return 0.0 if unit == "m" and abs(value) < ATOM else value
