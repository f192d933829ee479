"""Analyses of devices: public functions that take a `Device` in place of a model, with options and results in SI."""

from __future__ import annotations

import functools
import inspect
import math
import re
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Concatenate, ParamSpec, TypeVar, cast

import numpy as np

from gelcone.devices.device import Device
from gelcone.devices.points import dimensionless_state, read_state
from gelcone.devices.scales import MEASURES, Scales
from gelcone.devices.si import in_device_words, to_si
from gelcone.devices.units import FieldError, parse_many
from gelcone.errors import DoubtfulInput, InputError, described, unknown_name
from gelcone.physics.members import Ensemble
from gelcone.progress import barred
from gelcone.register.analysis import Analysis, annotation_of, check_flag, check_number

P = ParamSpec("P")
R = TypeVar("R")


class Scaled(float):
    """A dimensionless number among options that are in SI units otherwise."""


def scaled(value: Any) -> Any:
    """Mark a value as dimensionless if it is a number."""
    return Scaled(value) if isinstance(value, float) else value


def analysis(**declared: Any) -> Callable[[Callable[Concatenate[Any, P], R]], Callable[Concatenate[Any, P], R]]:
    """Declare a public function as an analysis, with the fields of `gelcone.register.analysis.Analysis`.

    The function then takes devices, too.
    """
    wraps = {"model": for_devices, "device": for_swept_devices, "plan": for_plans}

    def declare(function: Callable[Concatenate[Any, P], R]) -> Callable[Concatenate[Any, P], R]:
        takes = declared.get("takes", "model")
        run: Any = barred(wraps[takes](function) if takes in wraps else function)
        run.analysis = Analysis(run, **declared)
        return cast(Any, run)

    return declare


def for_devices(function: Callable[Concatenate[Any, P], R]) -> Callable[Concatenate[Any, P], R]:
    """Wrap a public analysis so that it takes a `Device` too.

    With a device its options are SI numbers or texts with units, it starts from the device's rest or release unless
    ``initial`` is given, and it returns a Dataset in SI units (`gelcone.to_si`). `plain` returns the function itself.
    """

    @functools.wraps(function)
    def run(model: Any, *args: P.args, **options: P.kwargs) -> R:
        if not isinstance(model, Device):
            check_model(model, function.__name__)
            check_options(function, options)
            return function(model, *args, **options)
        check_options(function, options, units=True)
        given = inspect.signature(function).bind(model, *args, **options).arguments
        given.pop(next(iter(given)))
        call: Any = function
        arguments = arguments_for(function, model, given)
        with device_words(model):
            result = call(model.to_model(), **arguments)
        if hasattr(result, "data_vars"):
            return to_si(result, model)  # type: ignore[return-value]
        return result

    run.__doc__ = with_units(function)
    return cast(Any, run)


def for_swept_devices(function: Callable[Concatenate[Any, P], R]) -> Callable[Concatenate[Any, P], R]:
    """Wrap a public analysis that makes a plan, and therefore takes the device and SI values itself."""

    @functools.wraps(function)
    def run(model: Any, *args: P.args, **options: P.kwargs) -> R:
        check_options(function, options, units=isinstance(model, Device))
        if not isinstance(model, Device):
            check_model(model, function.__name__)
        check_one(model, function.__name__)
        if not isinstance(model, Device):
            return function(model, *args, **options)
        bound = inspect.signature(function).bind(model, *args, **options)
        given = set(bound.arguments)
        bound.apply_defaults()
        for name in set(bound.arguments) - given:
            bound.arguments[name] = None if name == "initial" else scaled(bound.arguments[name])
        with device_words(model):
            return to_si(function(*bound.args, **bound.kwargs))  # type: ignore[arg-type, return-value]

    run.__doc__ = with_units(function)
    return cast(Any, run)


OF_DEVICES = {
    "model": "A `Device` in its place takes SI numbers, or texts with units, and the answer has units.",
    "initial": "With a device in m and m/s; default its own rest or release.",
}
"""Parameters of analyses -> the sentence about devices in their docstrings."""


def with_units(function: Callable[..., Any]) -> str:
    """The docstring of an analysis, with the units that its parameters have for a device."""
    before, heading, rest = inspect.cleandoc(function.__doc__ or "").partition("Parameters\n----------\n")
    entries, gap, after = rest.partition("\n\n")
    documented = []
    for entry in re.split(r"\n(?=\S)", entries):
        names = entry.partition(" : ")[0].split(", ")
        units = {MEASURES[q].unit for name in names if (q := annotation_of(function, name)[1])}
        remarks = [OF_DEVICES[name] for name in names if name in OF_DEVICES and "device" not in entry]
        remarks += [f"With a device in {unit}, or texts with units." for unit in sorted(units)]
        documented.append("\n    ".join([entry, *remarks]))
    return before + heading + "\n".join(documented) + gap + after


@contextmanager
def device_words(device: Device | None) -> Iterator[None]:
    """Translate input errors about the model into the names and units of the device."""
    try:
        yield
    except FieldError:
        raise
    except InputError as error:
        raise InputError(str(error) if device is None else in_device_words(str(error), device)) from None


def for_plans(function: Callable[Concatenate[Any, P], R]) -> Callable[Concatenate[Any, P], R]:
    """Wrap a public analysis of a plan, so that its result is in SI units if the plan has a device."""

    @functools.wraps(function)
    def run(plan: Any, *args: P.args, **options: P.kwargs) -> R:
        result: Any = function(plan, *args, **options)
        return result if plan.device is None else to_si(result)  # type: ignore[return-value]

    return cast(Any, run)


def plain(function: Callable[..., R]) -> Callable[..., R]:
    """Return the function of a public analysis without its wrapper: dimensionless, or over the SI axes of a plan."""
    return inspect.unwrap(function)


def check_one(model: Ensemble | Device, name: str) -> None:
    """Raise `InputError` for an ensemble of actuators."""
    if model.shape:
        raise InputError(
            f"{name}: takes one actuator, not an ensemble of {math.prod(model.shape)}; give every field and parameter "
            "one value"
        )


def check_model(model: Any, name: str) -> None:
    """Raise `InputError` unless ``model`` is a model; a device is refused here, too."""
    if isinstance(model, Ensemble):
        return
    if hasattr(model, "over") and hasattr(model, "draws"):
        raise InputError(f"{name}: was given a plan, which gelcone.sweep takes; give a model or a device")
    if hasattr(model, "attrs") and hasattr(model, "data_vars"):
        raise InputError(
            f"{name}: was given a result; give a model or a device (gelcone.model_of(result) is its model)"
        )
    if isinstance(model, str):
        raise InputError(
            f"{name}: was given the text {model!r}; gelcone.find_device({model!r}) gives the device of that name"
        )
    if isinstance(model, Device):
        raise InputError(f"{name}: takes a model; give device.to_model()")
    raise InputError(f"{name}: was given {described(model)} in place of a ConeModel or a Device")


def check_device(device: Any, name: str) -> None:
    """Raise `InputError` unless ``device`` is a single device."""
    if not isinstance(device, Device):
        raise InputError(
            f"{name}: takes a device, and was given {described(device)}; gelcone.find_device gives one by its "
            "name or file"
        )
    check_one(device, name)


def check_options(function: Callable[..., Any], options: Mapping[str, Any], units: bool = False) -> None:
    """Raise `InputError` for unknown options, for ``workers``, and for options that must be numbers or flags and are
    not.

    ``units``: options with a quantity may be texts with units, and are checked where they are read.
    """
    if "workers" in options:
        raise InputError(
            f"{function.__name__}: takes no workers; threads=N sets the threads, and gelcone.sweep takes workers"
        )
    known = inspect.signature(function).parameters
    for name, value in options.items():
        if name not in known:
            raise unknown_name(f"option of {function.__name__}", name, [*known][1:])
        kind, quantity = annotation_of(function, name)
        if value is not None and kind is float and not (units and quantity):
            check_number(name, value)
        if kind is bool:
            check_flag(name, value)


def arguments_for(function: Callable[..., Any], device: Device, given: Mapping[str, Any]) -> dict[str, Any]:
    """Compute the dimensionless arguments of an analysis for a device from those in SI."""
    arguments = dimensionless({name: annotation_of(function, name)[1] for name in given}, given, device.scales)
    if "initial" in inspect.signature(function).parameters:
        arguments["initial"] = state_of(device, given.get("initial"))
    return arguments


def state_of(device: Device, initial: Any = None) -> Any:
    """Make an initial state in SI, by default the device's own, dimensionless; warn if nothing moves the disc from
    it."""
    if initial is None:
        state = device.initial_state()
        if reason := at_rest(device, state):
            warnings.warn(reason, DoubtfulInput, stacklevel=4)
        return state
    if isinstance(initial, np.ndarray) and initial.ndim > 1:
        return initial / np.stack(np.broadcast_arrays(device.scales.length, device.scales.velocity), axis=-1)
    return dimensionless_state(device, read_state(initial, device))


def at_rest(device: Device, state: Any) -> str:
    """The reason why the disc stays at rest in a state, with the remedy; empty if it moves."""
    if np.any(state):
        moves = np.any(np.asarray(device.voltage_amplitude) > 0.0) or np.any(device.voltage_offset)
        starts_at_rest = device.release_height is None and not np.any(device.release_velocity)
        if moves or not starts_at_rest:
            return ""
        return "without a voltage the disc stays at its rest; set voltage_amplitude, voltage_offset or release_height"
    if not np.all(device.to_model().members().symmetric):
        return ""
    return (
        "the disc starts at rest in the middle of the flat film, which no voltage moves; set release_height, "
        "release_velocity or initial_height"
    )


def dimensionless(quantities: Mapping[str, str], options: Mapping[str, Any], scales: Scales) -> dict[str, Any]:
    """Scale the options in SI to the model, by their ``quantities``.

    If the time scales of the devices of a sweep differ, a time is at least as long as given for each of them.
    """
    taken = dict(options)
    for name, value in options.items():
        quantity = quantities.get(name, "")
        if value is not None and quantity and not isinstance(value, Scaled):
            number = parse_many(name, value, MEASURES[quantity].unit)
            taken[name] = scaled(number / option_scale(name, quantity, scales))
    return taken


def option_scale(name: str, quantity: str, scales: Scales) -> float:
    """The SI value of one unit of an option's quantity; `InputError` if it differs between the devices."""
    sizes = np.unique(scales.size(quantity))
    if sizes.size == 1 or quantity == "time":
        return float(sizes[0])
    raise InputError(
        f"{name}: is one {quantity} for devices whose units of {quantity} differ; run them one by one, or use a sweep"
    )
