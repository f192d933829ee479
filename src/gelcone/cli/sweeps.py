"""Sweeps over parameters on the command line: ``--over name=from:to:count`` or ``--over name=v1,v2,...``."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, TypeVar

import click

from gelcone.cli.options import read_range
from gelcone.errors import InputError
from gelcone.physics.model import parameter_quantity
from gelcone.quantity import Array

if TYPE_CHECKING:
    from gelcone.devices.device import Device

F = TypeVar("F", bound=Callable[..., Any])

# Parameters whose values may carry a unit when there is a device: the unit, and the parts of its scale.
_IN_SI = {
    "voltage": ("V", ("voltage",)),
    "voltage_bias": ("V", ("voltage",)),
    "drive_frequency": ("Hz", ("frequency",)),
    "rest_height": ("m", ("length",)),
    "spring_stiffness": ("N/m", ("force", "length")),
}


def over_option(text: str) -> Callable[[F], F]:
    """The option --over, which may be repeated, as the argument ``over``; ``text`` is its help."""
    return click.option("--over", multiple=True, metavar="NAME=VALUES", help=text)


def read_over(over: Iterable[str], device: Device | None = None) -> dict[str, Array]:
    """Parameters to sweep -> their values, in the order given.

    Values are a range ``from:to:count`` or a list ``v1,v2,...``, increasing and at least two; with a device they may
    carry units where the parameter has one (``voltage=0 V:500 V:51``).

    Raises
    ------
    InputError : for what is not ``name=values``, a name that is unknown (with the nearest one) or given twice, values
        that are empty, reversed, repeated or fewer than two, and values out of the parameter's bounds.
    """
    swept: dict[str, Array] = {}
    for text in over:
        name, equals, values = (part.strip() for part in text.partition("="))
        if not (equals and name and values):
            raise InputError(
                f"--over {text!r}: must be name=from:to:count or name=v1,v2,..., for example --over voltage=0:2:401"
            )
        parameter_quantity(name)  # refuses an unknown name before its values are read
        if name in swept:
            raise InputError(f"--over {name}: is given twice; give it once")
        swept[name] = increasing(f"--over {name}", read_values(f"--over {name}", values, name, device))
    return swept


def read_values(option: str, text: str, name: str, device: Device | None = None) -> Array:
    """Values of the parameter ``name`` as a range ``from:to:count`` or a list ``v1,v2,...``, within its bounds.

    With a device they may carry units, then all of them.
    """
    import numpy as np

    if text.count(":") == 2:
        begin, end, count = text.split(":")
        first, last = _plain(option, [begin, end], name, device)
        values = read_range(f"{first}:{last}:{count.strip()}")
    else:
        values = [float(value) for value in _plain(option, text.split(","), name, device)]
    return np.atleast_1d(np.asarray(parameter_quantity(name).check(name, values), dtype=float))


def increasing(option: str, values: Array) -> Array:
    """``values``, refused where they are fewer than two or do not increase."""
    if values.size < 2:
        raise InputError(f"{option}: has one point; a sweep takes at least two values")
    if not (values[1:] > values[:-1]).all():
        raise InputError(f"{option}: must increase; sort the values and leave out doubles")
    return values


def _plain(option: str, texts: list[str], name: str, device: Device | None) -> list[str]:
    """Dimensionless numbers as they are; numbers with a unit scaled to the model."""
    texts = [text.strip() for text in texts]
    bare = [_is_number(text) for text in texts]
    if all(bare):
        return texts
    if device is None or name not in _IN_SI:
        remedy = "give a range from:to:count or a list v1,v2,..."
        needs = " (units need a device)" if name in _IN_SI else ""
        raise InputError(f"{option} {texts[bare.index(False)]!r}: must be a number; {remedy}{needs}")
    from gelcone.devices.units import parse

    unit, (scale, *over) = _IN_SI[name]
    # a bare number among values with units would be dimensionless, which is hardly what was meant
    scaled = [parse(option, text, unit) / float(getattr(device.scales, scale)) for text in texts]
    for part in over:
        scaled = [number * float(getattr(device.scales, part)) for number in scaled]
    return [repr(number) for number in scaled]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
