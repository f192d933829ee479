"""Numbers, lists, ranges and tables from text, with the units of a device."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.errors import InputError

if TYPE_CHECKING:
    from gelcone.devices.device import Device
    from gelcone.devices.record import Field

MOST_POINTS = 100_000
Reader = Callable[[str, str], float]
"""Reads one number: (option, text) -> value."""


def read_pairs(settings: Iterable[str], device: bool = False) -> dict[str, str]:
    """``name=value`` pairs as texts; `InputError` for one that is not a pair, or a name given twice."""
    example = '--set "voltage_amplitude=500 V"' if device else "--set voltage=1.04"
    return pairs("--set", settings, f"name=value, for example {example}")


def pairs(option: str, texts: Iterable[str], form: str) -> dict[str, str]:
    """The values, as texts, by the names of an option that is given several times; `InputError`, which states ``form``,
    for another text, and for a name given twice."""
    values_by_name: dict[str, str] = {}
    for text in texts:
        name, equals, values = (part.strip() for part in text.partition("="))
        if not (equals and name and values):
            raise InputError(f"{option} {text!r}: must be {form}")
        if name in values_by_name:
            raise InputError(f"{option} {name}: is given twice; give it once")
        values_by_name[name] = values
    return values_by_name


def read_value(text: str) -> Any:
    """Read a number, a list ``0.5,1,2`` or ``[1, 2]``, a range ``0:2:5``, or else the text itself."""
    if text.count(":") == 2:
        return read_numbers("", text, lambda option, part: float(part))
    try:
        numbers = [float(part) for part in parts_of(text)]
    except ValueError:
        return text
    return numbers[0] if len(numbers) == 1 else numbers


def read_numbers(option: str, text: str, read: Reader) -> Any:
    """Read a number, a list ``v1,v2,...`` or ``[v1, v2, ...]`` or a range ``from:to:count``, each number by ``read``.

    Among values with units a bare number is refused, but 0.
    """
    shown = f"{option} {text!r}" if option else repr(text)
    if text.count(":") == 2:
        first, last, count = (part.strip() for part in text.split(":"))
        one_manner(shown, [first, last])
        try:
            begin, end, number = read(option, first), read(option, last), int(count)
        except ValueError as error:
            if isinstance(error, InputError):
                raise
            raise InputError(f"{shown}: must be a range from:to:count, for example 0:2:401") from None
        if not (math.isfinite(begin) and math.isfinite(end)):
            raise InputError(f"{shown}: the ends of a range must be finite")
        if not begin < end:
            raise InputError(f"{shown}: is empty or reversed; the first end must be below the second")
        if not 2 <= number <= MOST_POINTS:
            raise InputError(f"{shown}: has {number} points; a range takes 2 to {MOST_POINTS}")
        return np.linspace(begin, end, number)
    if ":" in text:
        raise InputError(f"{shown}: must be a range from:to:count, the last being the number of values: {text}:21")
    parts = parts_of(text)
    if not all(parts):
        raise InputError(f"{shown}: has an empty value; must be a number, a list v1,v2,... or a range from:to:count")
    if len(parts) > MOST_POINTS:
        raise InputError(f"{option}: has {len(parts)} values; a list takes at most {MOST_POINTS}")
    refuse_decimal_comma(shown, text)
    one_manner(shown, parts)
    numbers = [read(option, part) for part in parts]
    return numbers[0] if len(numbers) == 1 else np.array(numbers)


def parts_of(text: str) -> list[str]:
    """The values of a list, with or without brackets."""
    inner = text[1:-1] if text.startswith("[") and text.endswith("]") else text
    return [part.strip() for part in inner.split(",")]


def no_decimal_comma(option: str, text: str, parts: list[str]) -> None:
    """`InputError` for a setting that may be one number with a decimal comma, not a list."""
    if len(parts) == 2 and not text.startswith("[") and parts[0].lstrip("+-").isdecimal() and parts[1].isdecimal():
        one, two = ".".join(parts), ", ".join(parts)
        raise InputError(f"{option}={text}: may be one number or two; write {one} with a point, or the list [{two}]")


def refuse_decimal_comma(shown: str, text: str) -> None:
    """`InputError` for ``0,3 mm``, which reads as 0.3 mm with a decimal comma and as the list of 0 and 3 mm.

    A list of two values says what it is by a blank after its comma, by brackets, or by a unit on both. A longer one may
    begin with a bare 0.
    """
    for match in _DECIMAL_COMMA.finditer(text.strip()):
        if match.start() == 0 and match.end() < len(text.strip()):
            continue
        before, after, unit = match.groups()
        raise InputError(
            f"{shown}: looks like a decimal comma; write {before}.{after} {unit}, or of a list each unit: "
            f"{before} {unit},{after} {unit}"
        )


_DECIMAL_COMMA = re.compile(r"(?:^|(?<=,))([+-]?\d+),(\d+) ?((?![eE][+-]?\d)[^\W\d_][^,]*)")
"""A number with a comma between its digits, and a unit; one with an exponent has no such comma."""


def unit_or_brackets(option: str, text: str) -> None:
    """`InputError` for a setting of a device that lists bare numbers without brackets."""
    parts = parts_of(text)
    if len(parts) > 1 and not text.startswith("[") and all(map(is_number, parts)):
        no_decimal_comma(option, text, parts)
        raise InputError(f"{option}={text}: a list needs a unit on every value, or brackets: [{', '.join(parts)}]")


def one_manner(shown: str, parts: list[str]) -> None:
    """`InputError` where some numbers have a unit and others, not zero, have none."""
    bare = [part for part in parts if is_number(part)]
    if 0 < len(bare) < len(parts) and any(float(part) != 0.0 for part in bare):
        odd = next(part for part in bare if float(part) != 0.0)
        raise InputError(
            f"{shown}: {odd} has no unit, but the others do; give each its unit, and write decimals with a point"
        )


def is_number(text: str) -> bool:
    """Whether a text is a number without a unit."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def plain(option: str, text: str) -> float:
    """The number of a text without a unit; `InputError` for another text."""
    if not is_number(text):
        raise InputError(f"{option} {text!r}: must be a number; give a range from:to:count or a list v1,v2,...")
    return float(text)


def read_field(option: str, text: str, name: str, fields: Mapping[str, Field]) -> Any:
    """The value of a device's field: text, number, list or range; a bare number is in the field's SI unit."""
    from gelcone.devices.record import unknown_field

    if name not in fields:
        raise InputError(f"{option}: {unknown_field('device', name, fields)}")
    field = fields[name]
    if name == "material" and "," in text and not text.startswith("{"):
        return [part.strip() for part in text.split(",")]
    if not field.unit:
        return read_table(text)
    if "," not in text and ":" not in text and not is_number(text):
        return text  # read with its unit where the device is made
    return read_numbers(option, text, lambda option, part: of_field(option, part, field))


def read_table(text: str) -> Any:
    """A component's table, as in a device file: ``{component = "module:Class", ...}``; any other text as it is."""
    if not text.startswith("{"):
        return text
    try:
        return tomllib.loads(f"table = {text}")["table"]
    except ValueError as error:
        raise InputError(f"{text}: is not a table such as {{component = 'module:Class'}} ({error})") from None


def of_field(option: str, text: str, field: Field) -> float:
    """The number of a field in SI, from a text with or without a unit; `InputError` for another text."""
    from gelcone.devices.units import parse

    if is_number(text):
        number = float(text)
        if not math.isfinite(number) and not (field.infinite and number == math.inf):
            raise InputError(f"{option} {text}: must be finite; give a number, such as {field.example_text()}")
        return number
    return parse(option, text, field.unit, example=field.example_text())


def read_measure(option: str, text: str, quantity: str, device: Device | None, *, in_si: bool = False) -> float:
    """A number of a quantity: dimensionless or, with a device, with a unit, and then scaled to the model.

    With a device a bare number is refused, but 0. ``in_si`` leaves what is read in SI.
    """
    bare = is_number(text)
    if device is None:
        if not bare:
            raise InputError(f"{option} {text!r}: must be a number (units need a device)")
        number = float(text)
    else:
        from gelcone.devices.analysis import option_scale
        from gelcone.devices.scales import MEASURES
        from gelcone.devices.units import DIMENSIONS, parse

        unit = MEASURES[quantity].unit
        if bare and float(text) != 0.0:
            raise InputError(
                f"{option} {text}: has no unit; with a device give one, such as {DIMENSIONS[unit].example!r}"
            )
        number = 0.0 if bare else parse(option, text, unit)
        number = number if in_si else number / option_scale(option, quantity, device.scales)
    if not math.isfinite(number):
        raise InputError(f"{option} {text}: must be finite")
    return number


def read_measures(option: str, text: str, quantity: str, device: Device | None, *, in_si: bool = False) -> Any:
    """One or several numbers of a quantity, see `read_numbers` and `read_measure`."""
    return read_numbers(option, text, partial(read_measure, quantity=quantity, device=device, in_si=in_si))
