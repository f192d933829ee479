"""A named quantity with its bounds, and the check that every number passes at the edge."""

from __future__ import annotations

import math
import operator
import reprlib
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt

from gelcone.errors import InputError

Array = npt.NDArray[np.float64]
Time = Annotated[float, "time"]
Times = Annotated[npt.ArrayLike, "time"]
Voltage = Annotated[float, "voltage"]
Voltages = Annotated[npt.ArrayLike, "voltage"]
Frequency = Annotated[float, "frequency"]
Frequencies = Annotated[npt.ArrayLike, "frequency"]
Lengths = Annotated[npt.ArrayLike, "length"]
Capacitance = Annotated[float, "capacitance"]
Capacitances = Annotated[npt.ArrayLike, "capacitance"]
"""Numbers of public functions that have a unit with a device, each annotated with its quantity."""
LARGEST = 1e30
"""Largest size of a parameter: squares and products of some stay far from overflow."""


def spread(value: Any, shape: tuple[int, ...]) -> Array:
    """Broadcast a value unless it has the shape; `np.broadcast_to` is slow for the many numbers of one actuator."""
    array = np.asarray(value, dtype=float)
    return array if array.shape == shape else np.broadcast_to(array, shape)


def taken(value: Any, places: Array) -> Any:
    """An array, broadcast to a mask, at the places in it; a number unchanged."""
    return np.broadcast_to(value, places.shape)[places] if np.ndim(value) else value


@dataclass(frozen=True)
class Quantity:
    """The meaning of a parameter and the values it may take.

    Parameters
    ----------
    symbol : as in formulas.
    meaning : in words.
    default : its value where none is given.
    lower : the lowest value, which is allowed itself unless ``positive`` is set. Default none.
    positive : whether it must be larger than 0. Default no.
    infinite : whether it may be infinite. Default no.
    scale : the quantity, one of `gelcone.devices.scales.MEASURES`, in whose SI unit a device gives it. Default ``"1"``,
        a pure number.
    typical : its lowest and highest usual value in SI. Default unknown.
    near : other names that people use for it.

    Examples
    --------
    >>> import gelcone
    >>> rate = gelcone.Quantity("t", "time constant", 0.3, positive=True, scale="time")
    >>> rate.default, rate.scale
    (0.3, 'time')
    """

    symbol: str
    meaning: str
    default: float
    lower: float = -np.inf
    positive: bool = False
    infinite: bool = False
    scale: str = "1"
    typical: tuple[float, float] | None = None
    near: tuple[str, ...] = ()

    def check(self, name: str, value: Any) -> float | Array:
        """Return ``value`` as a float or float array; `InputError` when it is out of bounds."""
        if isinstance(value, float) and self._allows(value):  # most are; arrays of one number take ten times as long
            return float(value)
        try:
            if np.asarray(value).dtype.kind not in "iuf":
                raise TypeError
            array = np.array(value, dtype=float)
        except (TypeError, ValueError):
            shown = " ".join(reprlib.repr(value).split())
            raise InputError(
                f"{name} = {shown}: must be a number or an array of numbers; write it without units"
            ) from None
        bound = "greater than 0" if self.positive else f"at least {self.lower:g}"
        if array.size == 0:
            raise InputError(f"{name} = []: is empty; give at least one value")
        if np.isnan(array).any():
            raise InputError(f"{name} = nan: must be a number; leave it out to take its default {self.default:g}")
        if not self.infinite and np.isinf(array).any():
            raise InputError(
                f"{name} = {array[np.isinf(array)].flat[0]:g}: must be finite; its default is {self.default:g}"
            )
        smallest = float(array.min())
        if (self.positive and smallest <= 0.0) or smallest < self.lower:
            raise InputError(f"{name} = {smallest:g}: must be {bound}; its default is {self.default:g}")
        finite = array[np.isfinite(array)]
        if finite.size and np.abs(finite).max() > LARGEST:
            odd = float(finite[np.abs(finite).argmax()])
            raise InputError(f"{name} = {odd:g}: is beyond what the equations can be computed with; give a smaller one")
        array.setflags(write=False)
        return float(array) if array.ndim == 0 else array

    def _allows(self, value: float) -> bool:
        """Test whether a single number is within all bounds."""
        largest = math.inf if self.infinite else LARGEST
        within = value > 0.0 if self.positive else value >= self.lower
        return within and (abs(value) <= LARGEST or abs(value) == largest)


ALL_CORES = "leave it out to use all cores"
"""Remedy for an unusable number of threads or processes."""
MOST = 10**12
"""No run could end that counts further."""


def check_count(name: str, value: Any, least: int, remedy: str = "") -> None:
    """Raise `InputError`, which ends in ``remedy``, unless ``value`` is a whole number of at least ``least``."""
    more = f"; {remedy}" if remedy else ""
    try:
        number = operator.index(value)
    except TypeError:
        shown = reprlib.repr(value)
        raise InputError(f"{name} = {shown}: must be a whole number, at least {least}{more}") from None
    if isinstance(value, bool) or number < least:
        raise InputError(f"{name} = {value!r}: must be at least {least}{more}")
    if number > MOST:
        raise InputError(f"{name} = {value!r}: must be at most {MOST}")
