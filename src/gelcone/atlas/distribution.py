"""Distributions of uncertain parameters, given in numbers or, for fields of a device, in texts with units."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from numbers import Real
from typing import Any

import numpy as np

from gelcone.devices.fields import SWEPT_FIELDS
from gelcone.devices.points import STATE_FIELDS
from gelcone.devices.units import parse, parse_deviation
from gelcone.errors import InputError
from gelcone.quantity import Array


@dataclass(frozen=True)
class Uniform:
    """The uniform distribution of an uncertain parameter between two bounds.

    Parameters
    ----------
    low : the lower bound; of a field of a device a text with a unit.
    high : the upper bound, likewise.

    Examples
    --------
    >>> import gelcone
    >>> drawn = gelcone.draw({"voltage": gelcone.Uniform(0.4, 0.8)}, 8)["voltage"]
    >>> bool((drawn > 0.4).all() and (drawn < 0.8).all()), (drawn < 0.6).sum().item()
    (True, 4)
    """

    low: Any
    high: Any

    def __post_init__(self) -> None:
        if _worded(self):
            return
        if not (np.isfinite(self.low) and np.isfinite(self.high) and self.low < self.high):
            raise InputError(f"{self.low:g}:{self.high:g}: a uniform distribution goes from a lower to a higher bound")

    def at(self, share: Array) -> Array:
        """Quantiles of the distribution at these shares."""
        return self.low + (self.high - self.low) * share


@dataclass(frozen=True)
class Normal:
    """The normal distribution of an uncertain parameter.

    Parameters
    ----------
    mean : its mean; of a field of a device a text with a unit.
    deviation : its standard deviation, likewise; or a share of the mean, as ``"3 %"``.

    Examples
    --------
    >>> import gelcone
    >>> drawn = gelcone.draw({"film_thickness": gelcone.Normal("0.2 mm", "0.01 mm")}, 64)["film_thickness"]
    >>> f"{1e3 * drawn.mean():.4f} mm, within 0.18 and 0.22 mm: {((drawn > 0.18e-3) & (drawn < 0.22e-3)).sum()} of 64"
    '0.1999 mm, within 0.18 and 0.22 mm: 61 of 64'
    """

    mean: Any
    deviation: Any

    def __post_init__(self) -> None:
        if _worded(self):
            return
        if not (np.isfinite(self.mean) and np.isfinite(self.deviation) and self.deviation > 0.0):
            bound = f"the standard deviation {self.deviation:g} must be positive and both numbers finite"
            raise InputError(f"{self.mean:g}~{self.deviation:g}: {bound}; give mean~deviation")

    def at(self, share: Array) -> Array:
        """Quantiles of the distribution at these shares."""
        from scipy.special import ndtri

        values: Array = self.mean + self.deviation * ndtri(share)
        return values


Distribution = Uniform | Normal


def _worded(given: Distribution) -> bool:
    """True if a distribution is given by texts; raises `InputError` for values that are neither texts nor numbers."""
    texts = [isinstance(value, str) for value in astuple(given)]
    for value in astuple(given):
        if isinstance(value, bool) or not isinstance(value, str | Real):
            raise InputError(f"{given}: {value!r} must be a number, or a text such as '0.25 mm' for a device's field")
    if any(texts) and not all(texts):
        raise InputError(f"{given}: mixes a number and a text; give both as numbers in SI, or both with a unit")
    return all(texts)


def in_numbers(name: str, given: Distribution) -> Distribution:
    """A distribution in SI numbers; texts are read as values of the device's field ``name``."""
    if not isinstance(given, Distribution):
        raise InputError(f"{name} = {given!r}: must be a distribution, such as gelcone.Uniform(low, high)")
    if not _worded(given):
        return given
    fields = {**SWEPT_FIELDS, **STATE_FIELDS}
    if name not in fields:
        raise InputError(f"{name}: {given} has units, and {name} is not a device's field with one; give numbers")
    field, (one, other) = fields[name], astuple(given)
    first = parse(name, one, field.unit, example=field.example_text())
    if isinstance(given, Normal):
        return Normal(first, parse_deviation(name, other, field.unit, first))
    return Uniform(first, parse(name, other, field.unit, example=field.example_text()))
