"""What an analysis is asked about, described in text: a device or preset, settings, an initial state, swept values."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.errors import InputError, unknown_name
from gelcone.physics.model import ConeModel, parameter_names, parameter_quantity
from gelcone.quantity import Array

if TYPE_CHECKING:
    from gelcone.atlas.uncertain import Distribution
    from gelcone.devices.device import Device
    from gelcone.physics.system import ConeSystem

MOST_POINTS = 10_000_000
RADIUS_RATIO = "radius_ratio"
DEFAULT_RADIUS_RATIO = 0.2
DEFAULT_INITIAL = (1.0, 0.0)
IN_SI: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "voltage": ("V", ("voltage",)),
    "voltage_bias": ("V", ("voltage",)),
    "drive_frequency": ("Hz", ("frequency",)),
    "rest_height": ("m", ("length",)),
    "spring_stiffness": ("N/m", ("force", "length")),
}
"""Parameters whose values may carry a unit when there is a device: the unit, and the parts of its scale."""


@dataclass(frozen=True)
class Subject:
    """What an analysis works on: the model, the device behind it if there is one, and the initial state.

    ``starts`` says whether the initial state was stated rather than taken by default.
    """

    model: ConeModel
    device: Device | None = None
    initial: tuple[float, ...] = DEFAULT_INITIAL
    starts: bool = False

    def over(self, texts: Iterable[str]) -> dict[str, Array]:
        """The parameters to sweep and their values, see `read_over`."""
        return read_over(texts, self.device, self.model.system)

    def alone(self, name: str) -> Subject:
        """This subject; `InputError` where it is an ensemble."""
        if self.model.shape:
            raise InputError(f"{name} starts from one actuator, not {self.model.size}; sweep a parameter with --over")
        return self

    def without_initial(self, remedy: str) -> None:
        """`InputError` with the remedy where an initial state was stated."""
        if self.starts:
            raise InputError(f"--initial: {remedy}")


def read_subject(
    device: str | None = None,
    *,
    preset: str | None = None,
    film: str | None = None,
    settings: Iterable[str] = (),
    initial: str | None = None,
    fitting: Callable[[], None] = lambda: None,
) -> Subject:
    """The subject that a device or preset, ``name=value`` settings and an initial state describe.

    With a device, a name of the device (``film_radius``, ``material.shear_modulus``) changes the device, and a name of
    the model (``voltage``) replaces what the device gives. With a preset, a name of the model replaces its value.
    ``fitting`` is called before a continuum film is fitted, which takes seconds.

    Raises
    ------
    InputError : for a device together with a preset, unknown names, and values that cannot be used.
    """
    given = read_settings(settings)
    if device is not None:
        if preset is not None:
            raise InputError(f"--preset {preset} and the device {device!r} are both given; give one or the other")
        return _of_device(device, given, film, initial, fitting)
    ratio = given.pop(RADIUS_RATIO, None) if film == "continuum" else None
    if preset is None:
        model, start = ConeModel.from_parameters(given), DEFAULT_INITIAL
    else:
        from gelcone.presets import find_preset

        chosen = find_preset(preset)
        model, start = chosen.model.replace(**given), chosen.initial
    if film is not None:
        from gelcone.continuum.fit import find_film

        ratio = DEFAULT_RADIUS_RATIO if ratio is None else ratio
        model = model.replace(film=find_film(film, model, ratio, starting=fitting))
    return Subject(model, None, read_initial(initial, None) or start, initial is not None)


def _of_device(
    name: str, given: dict[str, Any], film: str | None, initial: str | None, fitting: Callable[[], None]
) -> Subject:
    from gelcone.devices.device import Device, find_device

    fields, names = Device.field_names(), parameter_names()
    of_model = {k: v for k, v in given.items() if k in names and k not in fields}
    of_device = {k: v for k, v in given.items() if k not in of_model}
    for setting in of_device:
        if setting.split(".")[0] not in fields:
            raise unknown_name("parameter of a device or of the model", setting, [*fields, *names])
    found = find_device(name)
    if film is not None:
        of_device = {"film": film} | of_device
    if of_device:
        found = found.replace(**of_device)
    found.film_for(found.cone_model(), starting=fitting)
    model = found.to_model()
    model = model.replace(**of_model) if of_model else model
    return Subject(model, found, read_initial(initial, found) or found.initial_state(), initial is not None)


# --- single values ----------------------------------------------------------------------------------------------------


def read_settings(settings: Iterable[str]) -> dict[str, Any]:
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
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        return text
    return numbers[0] if len(numbers) == 1 else numbers


def read_range(text: str) -> Array:
    """``from:to:count`` as evenly spaced values."""
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


def read_initial(text: str | None, device: Device | None) -> tuple[float, float] | None:
    """A displacement and a velocity, dimensionless or - with a device - with units; None where none is given."""
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


# --- swept values -----------------------------------------------------------------------------------------------------


def read_over(over: Iterable[str], device: Device | None = None, system: ConeSystem | None = None) -> dict[str, Array]:
    """Parameters to sweep -> their values, in the order given.

    Values are a range ``from:to:count`` or a list ``v1,v2,...``, increasing and at least two; with a device they may
    carry units where the parameter has one (``voltage=0 V:500 V:51``). ``system`` brings the parameters of its own
    components.

    Raises
    ------
    InputError : for what is not ``name=values``, a name that is unknown (with the nearest one) or given twice, values
        that are empty, reversed, repeated or fewer than two, and values out of the parameter's bounds.
    """
    swept: dict[str, Array] = {}
    for name, values in _pairs(over, "name=from:to:count or name=v1,v2,..., for example --over voltage=0:2:401"):
        parameter_quantity(name, system)  # refuses an unknown name before its values are read
        if name in swept:
            raise InputError(f"--over {name}: is given twice; give it once")
        swept[name] = increasing(f"--over {name}", read_values(f"--over {name}", values, name, device, system))
    return swept


STATES = {"displacement": "length", "velocity": "velocity"}
"""Components of the initial state, and the quantity of each."""
DEFAULT_STATES = {"displacement": "-2:2:81", "velocity": "-2:2:81"}


def read_states(over: Iterable[str], device: Device | None) -> dict[str, Array]:
    """Initial displacements and velocities; one that is not given takes its default. `InputError` as `read_over`."""
    given: dict[str, str] = {}
    for name, values in _pairs(over, "name=from:to:count, for example --over displacement=-2:2:81"):
        if name not in STATES:
            raise unknown_name("component of the initial state", name, STATES)
        if name in given:
            raise InputError(f"--over {name}: is given twice; give it once")
        given[name] = values
    return {name: _read_states(name, given.get(name, DEFAULT_STATES[name]), device) for name in STATES}


def _read_states(name: str, text: str, device: Device | None) -> Array:
    option = f"--over {name}"
    if text.count(":") == 2:
        *ends, count = text.split(":")
        begin, end = (read_measure(option, part, STATES[name], device) for part in ends)
        return increasing(option, read_range(f"{begin!r}:{end!r}:{count.strip()}"))
    return increasing(option, np.array([read_measure(option, p, STATES[name], device) for p in text.split(",")]))


def _pairs(over: Iterable[str], form: str) -> Iterable[tuple[str, str]]:
    for text in over:
        name, equals, values = (part.strip() for part in text.partition("="))
        if not (equals and name and values):
            raise InputError(f"--over {text!r}: must be {form}")
        yield name, values


def read_values(
    option: str, text: str, name: str, device: Device | None = None, system: ConeSystem | None = None
) -> Array:
    """Values of the parameter ``name`` as a range ``from:to:count`` or a list ``v1,v2,...``, within its bounds.

    With a device they may carry units, then all of them.
    """
    if text.count(":") == 2:
        begin, end, count = text.split(":")
        first, last = _dimensionless(option, [begin, end], name, device)
        values: Any = read_range(f"{first}:{last}:{count.strip()}")
    else:
        values = [float(value) for value in _dimensionless(option, text.split(","), name, device)]
    return np.atleast_1d(np.asarray(parameter_quantity(name, system).check(name, values), dtype=float))


def increasing(option: str, values: Array) -> Array:
    """``values``, refused where they are fewer than two or do not increase."""
    if values.size < 2:
        raise InputError(f"{option}: has one point; a sweep takes at least two values")
    if not (values[1:] > values[:-1]).all():
        raise InputError(f"{option}: must increase; sort the values and remove duplicates")
    return values


def _dimensionless(option: str, texts: list[str], name: str, device: Device | None) -> list[str]:
    """Dimensionless numbers as they are; numbers with a unit scaled to the model."""
    texts = [text.strip() for text in texts]
    bare = [_is_number(text) for text in texts]
    if all(bare):
        return texts
    if device is None or name not in IN_SI:
        remedy = "give a range from:to:count or a list v1,v2,..."
        needs = " (units need a device)" if name in IN_SI else ""
        raise InputError(f"{option} {texts[bare.index(False)]!r}: must be a number; {remedy}{needs}")
    from gelcone.devices.units import parse

    unit, (scale, *over) = IN_SI[name]
    # A bare number among values with units would be dimensionless, which is hardly what was meant: `parse` refuses it.
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


def read_uncertain(texts: Iterable[str]) -> dict[str, Distribution]:
    """``name=low:high`` and ``name=mean~deviation`` as distributions; `InputError` for anything else."""
    from gelcone.atlas.uncertain import Normal, Uniform

    spread: dict[str, Distribution] = {}
    for text in texts:
        name, equals, form = (part.strip() for part in text.partition("="))
        sign = "~" if "~" in form else ":"
        try:
            one, other = (float(part) for part in form.split(sign))
        except ValueError:
            raise InputError(
                f"--uncertain {text!r}: must be name=low:high or name=mean~deviation, for example prestretch=1~0.02"
            ) from None
        if not (equals and name) or name in spread:
            raise InputError(f"--uncertain {text!r}: must be name=..., each name once")
        spread[name] = Normal(one, other) if sign == "~" else Uniform(one, other)
    return spread
