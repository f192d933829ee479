"""Distributions and columns of draws, from text."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from gelcone.analyses.request import Subject
from gelcone.analyses.swept import sweepable
from gelcone.analyses.values import of_field, one_manner, plain
from gelcone.devices.points import STATES, point_fields, swept_field
from gelcone.errors import InputError
from gelcone.quantity import Array

if TYPE_CHECKING:
    from gelcone.atlas.distribution import Distribution
    from gelcone.devices.device import Device


def read_uncertain(texts: Iterable[str], subject: Subject) -> dict[str, Distribution]:
    """``name=low:high`` and ``name=mean~deviation`` as distributions, and names alone whose range the material states.

    A deviation may be a share of the mean, ``3%``. Raises `InputError` for anything else."""
    from gelcone.atlas.distribution import Normal, Uniform

    device = subject.device
    spread: dict[str, Distribution] = {}
    form = "prestretch=1~0.02" if device is None else '"film_thickness=0.2 mm~0.01 mm"'
    for text in texts:
        name, equals, values = (part.strip() for part in text.partition("="))
        if not equals and (span := _own_range(name, device)):
            equals, values = "=", span
        sign = "~" if "~" in values else ":"
        parts = [part.strip() for part in values.split(sign)]
        option = f"--uncertain {name}"
        if not (equals and name) or name in spread or len(parts) != 2 or not all(parts):
            raise InputError(
                f"--uncertain {text!r}: must be name=low:high or name=mean~deviation, each name once, such as {form}"
            )
        _check_name(option, name, subject, name)
        one, other = _two(option, values, parts, name, device)
        try:
            spread[name] = Normal(one, other) if sign == "~" else Uniform(one, other)
        except InputError as error:
            raise InputError(f"{option}={values}: {error}") from None
    return spread


def _own_range(name: str, device: Device | None) -> str:
    """The range that a material states for a number of its own, as ``low:high``; empty where it states none."""
    from gelcone.devices.materials import RANGED

    field = name.removeprefix("material.")
    if device is None or field == name or field not in RANGED:
        return ""
    span = getattr(device.material, f"{field}_range")
    if span is None:
        raise InputError(
            f"--uncertain {name}: the material {device.material.name!r} states no range of it; give {name}=low:high"
        )
    return ":".join(f"{end:.15g}" for end in span)


def _check_name(option: str, name: str, subject: Subject, by: str) -> None:
    """`InputError` for a name that cannot be drawn, or that is set as well as drawn ``by`` an option."""
    if name not in STATES:
        sweepable(option, name, subject.device, subject.model.system)
    if name in subject.given:
        raise InputError(f"--set {name}: is drawn by --uncertain {by}; leave one of them out")


def read_drawn(option: str, name: str, numbers: Array, unit: str, subject: Subject) -> Array:
    """A column of a table of draws; of a device in SI, from numbers in a unit that the table names."""
    device = subject.device
    _check_name(option, name, subject, option.partition(":")[0])
    if device is None:
        if unit not in ("", "1"):
            raise InputError(f"{option} [{unit}]: a model without a device is dimensionless; leave the unit out")
        return numbers
    from gelcone.devices.units import parse

    field = swept_field(device, name)
    if unit in ("", "1") and field.unit not in ("", "1"):
        example = field.example_text()
        raise InputError(f"{option}: has no unit; write it into the header, as in {name} [{example.split()[-1]}]")
    return numbers if unit in ("", "1") else numbers * parse(option, f"1 {unit}", field.unit)


def _two(option: str, text: str, parts: list[str], name: str, device: Device | None) -> list[float]:
    """The two numbers of a distribution."""
    from gelcone.devices.units import parse_deviation

    def read(part: str) -> float:
        return plain(option, part) if device is None else of_field(option, part, point_fields(device)[name])

    if "~" in text and parts[1].endswith("%"):
        mean = read(parts[0])
        return [mean, parse_deviation(option, parts[1], "1", mean)]
    one_manner(f"{option}={text}", parts)
    return [read(part) for part in parts]
