"""Sweeps over parameters on the command line: ``--over name=from:to:count`` or ``--over name=v1,v2,...``."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, TypeVar

import click

from gelcone.cli.options import read_range
from gelcone.errors import InputError
from gelcone.model import parameter_quantity
from gelcone.quantity import Array

if TYPE_CHECKING:
    from gelcone.device import Device

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
    """Values of the parameter ``name`` as a range ``from:to:count`` or a list ``v1,v2,...``, within its bounds."""
    import numpy as np

    if text.count(":") == 2:
        begin, end, count = text.split(":")
        ends = f"{_plain(option, begin, name, device)}:{_plain(option, end, name, device)}"
        values = read_range(f"{ends}:{count.strip()}")
    else:
        values = [float(_plain(option, part, name, device)) for part in text.split(",")]
    return np.atleast_1d(np.asarray(parameter_quantity(name).check(name, values), dtype=float))


def increasing(option: str, values: Array) -> Array:
    """``values``, refused where they are fewer than two or do not increase."""
    if values.size < 2:
        raise InputError(f"{option}: has one point; a sweep takes at least two values")
    if not (values[1:] > values[:-1]).all():
        raise InputError(f"{option}: must increase; sort the values and leave out doubles")
    return values


def _plain(option: str, text: str, name: str, device: Device | None) -> str:
    """A dimensionless number as it is, or one with a unit scaled to the model."""
    text = text.strip()
    try:
        float(text)
    except ValueError:
        if device is None or name not in _IN_SI:
            raise InputError(
                f"{option} {text!r}: must be a number; give a range from:to:count or a list v1,v2,..."
                + (" (units need a device)" if name in _IN_SI else "")
            ) from None
        from gelcone.units import parse

        unit, (scale, *over) = _IN_SI[name]
        number = parse(option, text, unit) / float(getattr(device.scales, scale))
        for part in over:
            number *= float(getattr(device.scales, part))
        return repr(number)
    return text
