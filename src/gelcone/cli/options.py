"""Arguments that several commands share, and how their values are read."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from gelcone.errors import InputError, unknown_name
from gelcone.physics.model import ConeModel, parameter_names

if TYPE_CHECKING:
    from gelcone.devices.device import Device

F = TypeVar("F", bound=Callable[..., Any])
MOST_POINTS = 10_000_000
PRESET = "gelcone.preset"
FILM = "gelcone.film"
RADIUS_RATIO = "radius_ratio"
DEFAULT_RADIUS_RATIO = 0.2


@dataclass(frozen=True)
class Subject:
    """What a command works on: the model, the device behind it if there is one, and the initial state."""

    model: ConeModel
    device: Device | None
    initial: tuple[float, float]


def subject_options(function: F) -> F:
    """DEVICE, --preset, --film, --set and --initial; preset and film wait in the context for `read_subject`."""
    for decorate in (
        click.option(
            "--film",
            metavar="cone|continuum|FILE",
            expose_value=False,
            callback=_keep(FILM),
            help="The film as a homogeneous cone (default); as a continuum, fitted on first use and kept (for the "
            "device's a/b, or --set radius_ratio=..., default 0.2); or one that gelcone validate --fit wrote.",
        ),
        click.option(
            "--initial", metavar="X,U", help="Initial displacement and velocity (with a device also '5 mm,0 m/s')."
        ),
        click.option(
            "--set", "settings", multiple=True, metavar="NAME=VALUE", help="Set a parameter; may be repeated."
        ),
        click.option(
            "--preset",
            metavar="NAME",
            expose_value=False,
            callback=_keep(PRESET),
            help="Start from a parameter set of the source paper: table1, base, fast or spring.",
        ),
        click.argument("device", required=False, metavar="[DEVICE]"),
    ):
        function = decorate(function)
    return function


def _keep(key: str) -> Callable[[click.Context, click.Parameter, str | None], None]:
    def keep(context: click.Context, _: click.Parameter, name: str | None) -> None:
        if name is not None:
            context.meta[key] = name

    return keep


def film_choice() -> str | None:
    """What --film says, or None."""
    context = click.get_current_context(silent=True)
    return context.meta.get(FILM) if context else None


def output_options(function: F) -> F:
    """--out, --force and --json."""
    for decorate in (
        click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of text."),
        click.option("--force", is_flag=True, help="Overwrite results that exist."),
        click.option("--out", type=click.Path(path_type=Path), metavar="DIR", help="Write netCDF and a figure there."),
    ):
        function = decorate(function)
    return function


def read_subject(device: str | None, settings: tuple[str, ...], initial: str | None) -> Subject:
    """The model that DEVICE or --preset, --set and --initial describe.

    With a device, a name of the device (``film_radius``, ``material.shear_modulus``) changes the device, and a name of
    the model (``voltage``) replaces what the device gives. With a preset, a name of the model replaces its value.
    """
    given = read_settings(settings)
    context = click.get_current_context(silent=True)
    choice = film_choice()
    ratio = given.pop(RADIUS_RATIO, None) if choice == "continuum" and device is None else None
    preset = context.meta.get(PRESET) if context else None
    if preset is not None:
        if device is not None:
            raise InputError(f"--preset {preset} and the device {device!r} are both given; give one or the other")
        from gelcone.presets import find_preset

        start = find_preset(preset)
        model = _with_film(start.model.replace(**given), choice, ratio)
        return Subject(model, None, _initial(initial, None) or start.initial)
    if device is None:
        model = _with_film(ConeModel.from_parameters(given), choice, ratio)
        return Subject(model, None, _initial(initial, None) or (1.0, 0.0))
    from gelcone.devices.device import Device, find_device

    names = parameter_names()
    of_model = {k: v for k, v in given.items() if k in names and k not in Device.field_names()}
    of_device = {k: v for k, v in given.items() if k not in of_model}
    for name in of_device:
        if name.split(".")[0] not in Device.field_names():
            raise unknown_name("parameter of a device or of the model", name, [*Device.field_names(), *names])
    found = find_device(device)
    if choice is not None:
        of_device = {"film": choice} | of_device
    if of_device:
        found = found.replace(**of_device)
    found.film_for(found.cone_model(), starting=_fitting)
    model = found.to_model()
    model = model.replace(**of_model) if of_model else model
    return Subject(model, found, _initial(initial, found) or found.initial_state())


def _with_film(model: ConeModel, choice: str | None, ratio: Any) -> ConeModel:
    if choice is None:
        return model
    from gelcone.continuum.fit import find_film

    return model.replace(
        film=find_film(choice, model, DEFAULT_RADIUS_RATIO if ratio is None else ratio, starting=_fitting)
    )


def _fitting() -> None:
    click.echo("fitting the continuum film (seconds, once for each geometry, law and pre-stretch) ...", err=True)


def read_settings(settings: tuple[str, ...]) -> dict[str, Any]:
    """``name=value`` pairs as a mapping; `InputError` for one that is not a pair, or a name given twice."""
    values: dict[str, Any] = {}
    for setting in settings:
        name, equals, value = setting.partition("=")
        name = name.strip()
        if not equals or not name or not value.strip():
            raise InputError(f"--set {setting!r}: must be name=value, for example --set voltage=1.04")
        if name in values:
            raise InputError(f"--set {name}: is given twice; give it once")
        values[name] = read_value(value.strip())
    return values


def read_value(text: str) -> Any:
    """A number, a list ``1,2,3``, a range ``0:2:5``, or else the text itself."""
    if text.count(":") == 2:
        return read_range(text)
    parts = text.split(",")
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        return text
    return numbers[0] if len(numbers) == 1 else numbers


def read_range(text: str) -> Any:
    """``from:to:count`` as evenly spaced values."""
    import numpy as np

    try:
        first, last, count = (part.strip() for part in text.split(":"))
        begin, end, number = float(first), float(last), int(count)
    except ValueError:
        raise InputError(f"{text!r}: must be a range from:to:count, for example 0:2:401") from None
    if not (math.isfinite(begin) and math.isfinite(end)):
        raise InputError(f"{text!r}: the ends of a range must be finite")
    if not begin < end:
        raise InputError(f"{text!r}: is empty or reversed; the first end must be below the second")
    if not 2 <= number <= MOST_POINTS:
        raise InputError(f"{text!r}: has {number} points; a range takes 2 to {MOST_POINTS}")
    return np.linspace(begin, end, number)


def _initial(text: str | None, device: Device | None) -> tuple[float, float] | None:
    if text is None:
        return None
    parts = text.split(",")
    if len(parts) != 2:
        raise InputError(f"--initial {text!r}: must be a displacement and a velocity, for example --initial 1,0")
    x = read_measure("--initial", parts[0], "length", device)
    return x, read_measure("--initial", parts[1], "velocity", device)


def read_times(text: str, device: Device | None) -> list[float]:
    """Comma-separated times, dimensionless or - with a device - with a unit."""
    return [read_measure("--times", part, "time", device) for part in text.split(",")]


def read_measure(option: str, text: str, quantity: str, device: Device | None) -> float:
    """A dimensionless number, or with a device a number with a unit, scaled to the model."""
    try:
        number = float(text)
    except ValueError:
        if device is None:
            raise InputError(f"{option} {text.strip()!r}: must be a number (units need a device)") from None
        from gelcone.devices.units import parse

        si_unit = {"length": "m", "velocity": "m/s", "time": "s"}[quantity]
        return parse(option, text.strip(), si_unit) / float(getattr(device.scales, quantity))
    if not math.isfinite(number):
        raise InputError(f"{option} {text.strip()}: must be finite")
    return number
