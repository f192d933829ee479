"""Strict SI units: read numbers and strings such as "50 mm", write numbers with fitting units.

A string is one decimal number and one unit of the right dimension, adjacent or with one space between. Everything
else is refused, since lenient readers fail silently ("1,2 kV" read as 12 kV, "50 MM" as megamolar).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.errors import InputError
from gelcone.quantity import Array


class FieldError(InputError):
    """An `InputError` about one field; ``message`` starts with the field's name.

    ``meant`` holds the fields that were probably meant by an unknown name.
    """

    def __init__(self, field: str, message: str, meant: Sequence[str] = ()) -> None:
        super().__init__(field, message)
        self.field = field
        self.message = message
        self.meant: tuple[str, ...] = tuple(meant)

    def __str__(self) -> str:
        return self.message

    def within(self, parent: str) -> FieldError:
        """This error for the field inside ``parent``."""
        join = "." if self.message.startswith(self.field) else ": "
        return FieldError(f"{parent}.{self.field}", f"{parent}{join}{self.message}")


@dataclass(frozen=True)
class Dimension:
    """A dimension: its ``name``, its units as ``powers`` of ten of the SI unit, an ``example`` of a value, the units
    ``shown`` in output, and ``factors`` of units that are not powers of ten."""

    name: str
    powers: Mapping[str, int]
    example: str
    shown: tuple[str, ...]
    factors: Mapping[str, int] = field(default_factory=dict)

    def accepted(self, unit: str, example: str) -> str:
        """The forms that a value may take, for messages."""
        if unit == "1":
            return f"give a plain number such as {example}"
        units = ", ".join(u for u in (*self.powers, *self.factors) if u.isascii())
        return f"give a number in {unit} or a string such as '{example}' (units {units})"


def _dimension(name: str, example: str, powers: Mapping[str, int], shown: tuple[str, ...] = ()) -> Dimension:
    # "um" is also read with the micro sign (U+00B5) and with the Greek letter mu (U+03BC)
    spelt = {re.sub("u(?=[msJWACNVF])", mu, unit): power for unit, power in powers.items() for mu in "u\u00b5\u03bc"}
    return Dimension(name, spelt, example, shown or tuple(powers))


_PREFIXES = {"": 0, "k": 3, "M": 6, "G": 9}
_OHMS = {f"{prefix}{ohm}": power for prefix, power in _PREFIXES.items() for ohm in ("ohm", "Ohm")}

# SI unit -> dimension. ``shown`` lists the units that `format_si` chooses from, where that is not all of them.
DIMENSIONS: dict[str, Dimension] = {
    "1": _dimension("pure number", "1.2", {"": 0}),
    "m": _dimension("length", "50 mm", {"m": 0, "cm": -2, "mm": -3, "um": -6, "nm": -9}, ("m", "mm", "um", "nm")),
    "kg": _dimension("mass", "20 g", {"kg": 0, "g": -3, "mg": -6}),
    "s": replace(_dimension("time", "5 ms", {"s": 0, "ms": -3, "us": -6}), factors={"min": 60, "h": 3600}),
    "Hz": _dimension("frequency", "8 Hz", {"Hz": 0, "kHz": 3, "mHz": -3}),
    "V": _dimension("voltage", "1.2 kV", {"V": 0, "kV": 3, "mV": -3, "MV": 6}),
    "Pa": _dimension("pressure", "20 kPa", {"Pa": 0, "kPa": 3, "MPa": 6}),
    "N": _dimension("force", "0.5 N", {"N": 0, "mN": -3, "uN": -6, "nN": -9}),
    "m/s": _dimension("velocity", "10 mm/s", {"m/s": 0, "mm/s": -3}),
    "m/s^2": _dimension("acceleration", "9.81 m/s^2", {"m/s^2": 0, "m/s2": 0, "mm/s^2": -3}, ("m/s^2", "mm/s^2")),
    "N/m^3": _dimension(
        "cubic stiffness",
        "20 kN/m^3",
        {"N/m^3": 0, "kN/m^3": 3, "MN/m^3": 6, "N/mm^3": 9, "mN/mm^3": 6},
        ("N/m^3", "kN/m^3", "MN/m^3"),
    ),
    "N/m": _dimension(
        "stiffness",
        "60 N/m",
        {"N/m": 0, "kN/m": 3, "N/cm": 2, "N/mm": 3, "mN/mm": 0, "mN/m": -3},
        ("kN/m", "N/m", "mN/m"),
    ),
    "N s/m": _dimension(
        "damping", "0.04 N s/m", {"N s/m": 0, "N*s/m": 0, "kg/s": 0, "mN s/m": -3, "g/s": -3}, ("N s/m", "mN s/m")
    ),
    "V/m": _dimension(
        "electric field",
        "20 kV/mm",
        {"V/m": 0, "kV/m": 3, "V/mm": 3, "MV/m": 6, "kV/mm": 6, "V/um": 6},
        ("V/m", "kV/m", "MV/m"),
    ),
    "A": _dimension("current", "2 mA", {"A": 0, "mA": -3, "uA": -6, "nA": -9, "pA": -12}),
    "ohm": _dimension("resistance", "5 Mohm", _OHMS, ("ohm", "kohm", "Mohm", "Gohm")),
    "ohm m": _dimension(
        "resistivity",
        "1 Gohm m",
        {f"{ohm} m": power for ohm, power in _OHMS.items()} | {f"{ohm} cm": power - 2 for ohm, power in _OHMS.items()},
        ("ohm m", "kohm m", "Mohm m", "Gohm m"),
    ),
    "V/s": _dimension(
        "slew rate",
        "10 V/us",
        {"V/s": 0, "V/ms": 3, "V/us": 6, "kV/s": 3, "kV/ms": 6},
        ("V/s", "V/ms", "V/us"),
    ),
    "F": _dimension("capacitance", "1 nF", {"F": 0, "mF": -3, "uF": -6, "nF": -9, "pF": -12}),
    "C": _dimension("charge", "2 uC", {"C": 0, "mC": -3, "uC": -6, "nC": -9, "pC": -12}),
    "J": _dimension("energy", "2 mJ", {"J": 0, "mJ": -3, "uJ": -6, "nJ": -9, "pJ": -12}),
    "J/(m^3 K)": _dimension(
        "heat capacity over volume",
        "1.8 MJ/(m^3 K)",
        {"J/(m^3 K)": 0, "kJ/(m^3 K)": 3, "MJ/(m^3 K)": 6},
        ("J/(m^3 K)", "kJ/(m^3 K)", "MJ/(m^3 K)"),
    ),
    "W": _dimension("power", "3 mW", {"W": 0, "mW": -3, "uW": -6, "nW": -9, "pW": -12}),
    "VA": _dimension("apparent power", "10 mVA", {"VA": 0, "mVA": -3, "uVA": -6, "nVA": -9, "pVA": -12}),
}

# Three digits of exponent are enough for a double and keep int() cheap.
_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[eE]([+-]?\d{1,3}))?(?: ?([^\s\d].*))?", re.ASCII)


def _shown(value: Any) -> str:
    text = repr(value) if isinstance(value, str) else " ".join(repr(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."


def _parse_text(text: str, unit: str, dimension: Dimension) -> float | str:
    """Parse a text: the number in SI, or the reason why it is refused."""
    match = _NUMBER.fullmatch(text)
    if re.search(r"\d,\d", text):
        return "holds a comma; write decimals with a point"
    if match is None:
        return "is not one decimal number" + ("" if unit == "1" else " and one unit")
    digits, exponent, given = match.group(1), int(match.group(2) or 0), match.group(3) or ""
    if given in dimension.powers:
        # moving the decimal exponent rounds once: "0.3 mm" is exactly the double nearest to 0.0003
        return float(f"{digits}e{exponent + dimension.powers[given]}")
    if given in dimension.factors:
        return float(f"{digits}e{exponent}") * dimension.factors[given]
    if not given:
        return "has no unit"
    for other in DIMENSIONS.values():
        if given in other.powers or given in other.factors:
            return f"{given} is a unit of {other.name}, not of {dimension.name}"
    return f"{given!r} is not a unit of {dimension.name}"


def parse(
    name: str,
    value: Any,
    unit: str,
    *,
    above: float | None = None,
    least: float | None = None,
    infinite: bool = False,
    example: str = "",
) -> float:
    """Read ``value`` as a float in the SI unit ``unit``.

    Parameters
    ----------
    name : the field's name, for messages.
    value : a number, which is in SI; or a string of one number and one unit, such as ``"50 mm"`` or ``"1.2kV"``.
    unit : a key of `DIMENSIONS`; ``"1"`` for a pure number.
    above, least : bounds in SI, exclusive and inclusive. Default none.
    infinite : whether plus infinity, as a number, is allowed. Default no.
    example : a usual value, for messages. Default that of the dimension.

    Raises
    ------
    FieldError : an `InputError`, for values that are not exact, of another dimension, not finite or out of bounds.

    >>> parse("film_radius", "50 mm", "m")
    0.05
    """
    dimension = DIMENSIONS[unit]
    example = example or dimension.example
    number = _read(value.item() if isinstance(value, np.ndarray) and value.ndim == 0 else value, unit, dimension)
    if not isinstance(number, str) and not (math.isfinite(number) or (infinite and number == math.inf)):
        number = "must be finite"
    if isinstance(number, str):
        raise FieldError(name, f"{name} = {_shown(value)}: {number}; {dimension.accepted(unit, example)}")
    in_unit, bound = "" if unit == "1" else f" {unit}", ""
    if above is not None and not number > above:
        bound = f"must be greater than {above:g}{in_unit}"
    if least is not None and not number >= least:
        bound = f"must be at least {least:g}{in_unit}"
    if bound:
        raise FieldError(name, f"{name} = {_shown(value)}: {bound}; give a larger one, such as {example}")
    return number


def _read(value: Any, unit: str, dimension: Dimension) -> float | str:
    """Read a value: the number in SI, or the reason why it is refused."""
    if isinstance(value, str):
        return _parse_text(value, unit, dimension)
    if isinstance(value, Real) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            return math.inf
    if isinstance(value, list | tuple | np.ndarray):
        return "must be one value, not several"
    return f"must be a number or a string, not {type(value).__name__}"


def share_of(value: Any) -> float:
    """The number of a share, ``"2 %"`` or 0.02; NaN for other texts."""
    text = str(value).strip()
    try:
        return float(text.removesuffix("%")) * (0.01 if text.endswith("%") else 1.0)
    except ValueError:
        return math.nan


def parse_share(name: str, value: Any) -> float:
    """Read a share as `share_of`; `FieldError` unless it is positive and below 10."""
    number = share_of(value)
    if not 0.0 < number < 10.0:
        raise FieldError(
            name, f"{name} = {str(value).strip()[:60]!r}: must be greater than 0 and below 10, a share such as '2 %'"
        )
    return number


def parse_deviation(name: str, text: str, unit: str, value: float) -> float:
    """Read the standard deviation of a ``value``, both in SI: a share of it, ``"3 %"``, or a number with a unit.

    Raises `FieldError` as `parse` and `parse_share`, for a deviation that is not positive, and for a share of 0.
    """
    if not text.strip().endswith("%"):
        return parse(f"deviation of {name}", text, unit, above=0.0)
    if value == 0.0:
        raise FieldError(name, f"{name} = {text!r}: is a share of 0; give the deviation with a unit")
    return parse_share(name, text) * abs(value)


def parse_many(name: str, value: Any, unit: str, **bounds: Any) -> float | Array:
    """Read one value as `parse` does, or a list or one-dimensional array as a read-only float array (n,)."""
    if hasattr(value, "__array__"):
        value = np.asarray(value)
        if value.ndim > 1:
            raise FieldError(name, f"{name} has the shape {value.shape}: must be a number or one-dimensional; ravel it")
        if value.ndim and value.size and value.dtype.kind in "iuf":
            return _checked_array(name, value, unit, bounds)
        value = value.tolist()
    if not isinstance(value, list | tuple):
        if isinstance(value, str) and (remedy := _as_list(value, unit)):
            raise FieldError(name, f"{name} = {_shown(value)}: {remedy}")
        return parse(name, value, unit, **bounds)
    if not value:
        raise FieldError(name, f"{name} = []: is empty; give at least one value")
    return _read_only(np.array([parse(f"{name}[{i}]", v, unit, **bounds) for i, v in enumerate(value)]))


def _as_list(text: str, unit: str) -> str:
    """The remedy for a text with several values, which only the command line reads; empty for other texts."""
    if text.count(":") == 2:
        first, last, count = (part.strip() for part in text.split(":"))
        ends = [_parse_text(end, unit, DIMENSIONS[unit]) for end in (first, last)]
        numbers = ", ".join(f"{end:g}" for end in ends if not isinstance(end, str))
        grid = f" or numpy.linspace({numbers}, {count})" + ("" if unit == "1" else f", in {unit}")
        remedy = f"give a list such as ['{first}', '{last}']{grid * all(isinstance(end, float) for end in ends)}"
        return f"is a range, which only the command line reads; {remedy}"
    parts = [part.strip() for part in text.split(",")]
    if len(parts) > 1 and all(parts) and not re.search(r"\d,\d", text):
        return f"lists several values, which only the command line reads; give a list: {parts}"
    return ""


def _checked_array(name: str, values: npt.NDArray[Any], unit: str, bounds: Any) -> Array:
    """Check an array of numbers as `parse_many` does: bounds need only its extremes, and NaN counts as one."""
    array = np.array(values, dtype=float)
    for at in {int(array.argmin()), int(array.argmax())}:
        parse(f"{name}[{at}]", float(array[at]), unit, **bounds)
    return _read_only(array)


TYPED_DIGITS, MOST_TYPED, ROUNDINGS = 12, 1000, 4
"""Most digits of a number as it was typed; most numbers that are typed at once; and roundings, in units in the last
place, that scaling to a device and back makes."""


def without_rounding(values: Any) -> Array:
    """The values, those that differ by rounding alone from a number of `TYPED_DIGITS` replaced by it: a voltage of
    700.0000000000001, scaled to a device and back, by 700."""
    numbers = np.asarray(values, dtype=float)
    if numbers.size > MOST_TYPED:
        return numbers
    short = np.reshape([float(f"{value:.{TYPED_DIGITS}g}") for value in numbers.ravel()], numbers.shape)
    with np.errstate(invalid="ignore"):
        return np.where(np.abs(short - numbers) <= ROUNDINGS * np.spacing(np.abs(numbers)), short, numbers)


def _read_only(array: Array) -> Array:
    array.flags.writeable = False
    return array


def format_si(value: float, unit: str, digits: int = 4) -> str:
    """Write ``value`` (SI), rounded to ``digits`` significant digits, with a unit in which it lies from 1 to 1000.

    `parse` reads the text back. Raises KeyError for a unit that is not in `DIMENSIONS`.

    >>> format_si(0.0005, "m"), format_si(8.4e3, "V"), format_si(1.25, "1")
    ('500 um', '8.4 kV', '1.25')
    """
    numbers, symbol = in_one_unit([value], unit, digits)
    return f"{numbers[0]} {symbol}".rstrip()


def format_range(low: float, high: float, unit: str, digits: int = 4) -> str:
    """Write the ends of a range (SI) with one unit, that in which `format_si` writes the larger; equal ends once.

    >>> format_range(10e3, 700e6, "V/s"), format_range(0.0005, 0.0005, "m"), format_range(0.0, 2.0, "1")
    ('0.01 to 700 V/us', '500 um', '0 to 2')
    """
    numbers, symbol = in_one_unit([low, high], unit, digits)
    return f"{' to '.join(dict.fromkeys(numbers))} {symbol}".rstrip()


WRITTEN_OUT = 1e5
"""Numbers below it are written without a power of ten."""


def in_one_unit(values: Sequence[float], unit: str, digits: int) -> tuple[list[str], str]:
    """Texts of the numbers in the unit that leaves 1 to 1000 before the point of the largest, and that unit."""
    dimension = DIMENSIONS[unit]
    rounded = [float(f"{value:.{digits}g}") for value in values]
    # choosing after rounding keeps 999.96 mm from being written as "1000 mm"
    largest = max((abs(value) for value in rounded if math.isfinite(value)), default=0.0)
    scales = sorted((float(f"1e{dimension.powers[symbol]}"), symbol) for symbol in dimension.shown)
    fitting = [s for s in scales if largest >= s[0]] or scales[:1]
    scale, symbol = fitting[-1]
    if largest == 0.0:
        scale, symbol = 1.0, "" if unit == "1" else unit
    # of fewer digits than stand before the point, 540 is not written as 5.4e+02
    texts = [f"{value / scale:.{digits}g}" for value in rounded]
    return [f"{float(text):g}" if "e+" in text and abs(float(text)) < WRITTEN_OUT else text for text in texts], symbol
