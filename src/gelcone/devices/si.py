"""Results of a device in practical units: millimetres, volts, newtons, hertz, milliseconds."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone import dataset
from gelcone.devices.device import Device
from gelcone.devices.fields import DAMPINGS
from gelcone.devices.materials import SEPARATOR, find_material, side_by_side
from gelcone.devices.numbers import numbers_of
from gelcone.devices.points import GELS, STATE_FIELDS, STATES, at, field_attributes
from gelcone.devices.scales import MEASURES, Scales
from gelcone.devices.units import DIMENSIONS, format_si, without_rounding
from gelcone.errors import InputError, check_result
from gelcone.physics.model import ConeModel

if TYPE_CHECKING:
    import xarray as xr

FIELDS_READ_AS = {"m": "mm", "kg": "g", "Pa": "kPa", "V/m": "MV/m"}
"""SI unit of a device's field -> the unit of an axis over it, where it differs."""
DEVICE = "device_fields"
"""Attribute of a result that holds the fields of its device, as JSON."""
DRAWN = "drawn_"
_SYMBOLS = re.compile(r" x = h/\(b-a\)| v\(tau\)| [sl][123]\b| per unit time|\bangular ")
"""Dimensionless symbols in long names, left out of variables with a unit."""


def device_attributes(device: Device) -> dict[str, str]:
    """The attributes of a result that name and describe its device."""
    return {"device": device.name, DEVICE: json.dumps(device.parameters())}


def device_of(result: xr.Dataset) -> Device | None:
    """Make the device that a result describes; None if it describes none."""
    text = result.attrs.get(DEVICE)
    return None if text is None else Device(**json.loads(text))


def model_of(result: xr.Dataset) -> ConeModel:
    """Make the model that a result was computed from.

    Parameters
    ----------
    result : a Dataset that an analysis returned or `gelcone.load` read.

    Returns
    -------
    The `ConeModel`, an ensemble over what was swept.

    Raises
    ------
    InputError : for anything but a result, and for a result that does not describe its model.

    Examples
    --------
    >>> import gelcone
    >>> response = gelcone.simulate(gelcone.ConeModel(voltage=0.4), periods=1)
    >>> gelcone.model_of(response).voltage
    0.4
    """
    check_result("model_of", result)
    device = device_of(result)
    fields = _points(result)
    if device is None or not fields:
        return dataset.model_of(_without_units(result, device))
    import xarray as xr

    names, coordinates = list(fields), [in_field_units(coordinate) for coordinate in fields.values()]
    spread = xr.broadcast(*coordinates)
    values = {name: one.values.ravel() for name, one in zip(names, spread, strict=True)}
    model = at(device, values).to_model()
    shape = spread[0].shape
    return model.replace(**{name: np.reshape(v, shape) for name, v in model.values.items() if np.ndim(v)})


def _without_units(result: xr.Dataset, device: Device | None) -> xr.Dataset:
    """The result with dimensionless swept parameters."""
    for name, coordinate in result.coords.items():
        if coordinate.attrs.get("quantity") == "parameter" and coordinate.attrs["units"] != "1" and device is not None:
            unscaled = coordinate / device.scales.shown(numbers_of(device)[str(name)].quantity)
            result = result.assign_coords({name: unscaled.assign_attrs(coordinate.attrs)})
    return result


def _points(result: xr.Dataset) -> dict[str, xr.DataArray]:
    """Field of the device -> coordinate over it, also of drawn fields; without components of the initial state."""
    coordinates = {
        str(n).removeprefix(DRAWN): c for n, c in result.coords.items() if c.attrs.get("quantity") == "device field"
    }
    points: dict[str, xr.DataArray] = {}
    for name, coordinate in coordinates.items():
        if name not in STATE_FIELDS:
            points |= _of_gels(coordinate) if name == GELS else {name: coordinate}
    return points


def _of_gels(gels: xr.DataArray) -> dict[str, xr.DataArray]:
    """The numbers in which gels differ, over the coordinate of their names."""
    gel = side_by_side([find_material(str(name)) for name in gels.values])
    numbers = {name: getattr(gel, name) for name, field in gel.fields.items() if field.unit}
    return {
        f"material.{name}": gels.copy(data=value).assign_attrs(units=gel.fields[name].unit)
        for name, value in numbers.items()
        if np.ndim(value)
    }


def in_field_units(coordinate: xr.DataArray) -> xr.DataArray:
    """The values of a coordinate over a field in the field's SI unit."""
    units = coordinate.attrs["units"]
    if coordinate.attrs.get("quantity") != "device field":
        return coordinate
    powers = next((d.powers for d in DIMENSIONS.values() if units in d.powers), {units: 0})
    return coordinate * float(f"1e{powers[units]}")


def to_si(result: xr.Dataset, device: Device | None = None) -> xr.Dataset:
    """Convert a result: every variable with an SI scale, also axes and states, gets a practical unit.

    Variables with a unit stay unchanged. The attributes name the device.

    Parameters
    ----------
    result : a Dataset that an analysis returned.
    device : the device of its model. Default: the device that the result describes.

    Returns
    -------
    A Dataset of the same variables in mm, V, ms and so on, named in their ``units``.

    Raises
    ------
    InputError : for anything but a result, and for a result that does not describe its device.

    Examples
    --------
    >>> import gelcone
    >>> device = gelcone.find_device("biased-pump").replace(film="taut")
    >>> plain = gelcone.simulate(device.to_model(), device.initial_state(), periods=1)
    >>> gelcone.to_si(plain, device).displacement.units, round(float(gelcone.to_si(plain, device).displacement[0]), 2)
    ('mm', 12.59)
    """
    check_result("to_si", result)
    device = device_of(result) if device is None else device
    if not isinstance(device, Device):
        raise InputError("to_si: the result does not say of which device it is; give the device too")
    result = _with_member_fields(result, device)
    with np.errstate(invalid="ignore", divide="ignore"):  # cells that make no actuator have no scales
        everywhere, arrays = Scales.of(_getter(result, device)), {}
    for name, variable in result.variables.items():
        own_fields = variable.attrs.get("along")
        scales = Scales.of(_getter(result, device, str(own_fields))) if own_fields else everywhere
        quantity, units = str(variable.attrs.get("quantity")), str(variable.attrs.get("units"))
        array = _converted(result, str(name), quantity, units, scales, device)
        if array is not None:
            arrays[str(name)] = array
    data = {name: (array.dims, array.values, array.attrs) for name, array in arrays.items() if name in result.data_vars}
    converted = result.assign(data)
    # axes last: one whose values then differ between members gets another name in all variables along it
    for name in [name for name in result.coords if name in arrays]:
        converted = _put(converted, str(name), arrays[str(name)])
    return converted.assign_attrs(device_attributes(device))


def shown_values(values: Any, attrs: Mapping[str, Any], scales: Scales) -> tuple[Any, dict[str, Any]]:
    """Convert values (cells, ...) of a variable to its practical unit, and its attributes; they stay unchanged if they
    have a unit, or no scale. ``scales`` are those of each cell, or of all."""
    quantity, taken = str(attrs.get("quantity")), dict(attrs)
    if attrs.get("units") != "1" or quantity not in (*MEASURES, "state"):
        return values, taken
    taken["long_name"] = in_words(taken["long_name"])
    if quantity == "state":
        factors, taken["units"] = state_factors(taken, values.shape[-1], scales)
        each = np.stack([np.broadcast_to(one, len(values)) for one in factors], axis=-1)
        return values * each.reshape(len(values), *[1] * (values.ndim - 2), -1), taken
    taken["units"] = MEASURES[quantity].shown
    factor = np.broadcast_to(scales.shown(quantity), len(values))
    return values * factor.reshape(-1, *[1] * (values.ndim - 1)), taken


def state_factors(attrs: Mapping[str, Any], count: int, scales: Scales) -> tuple[list[Any], str]:
    """The factor of each state of a variable over states, and their units. Files of 0.2 do not describe further states,
    which stay unchanged."""
    said = attrs[dataset.STATES].split(", ") if dataset.STATES in attrs else STATES.values()
    quantities = [*said, *["1"] * (count - len(said))]
    measured = [one in MEASURES for one in quantities]
    factors = [scales.shown(one) if known else 1.0 for one, known in zip(quantities, measured, strict=True)]
    units = [MEASURES[one].shown if known else "1" for one, known in zip(quantities, measured, strict=True)]
    return factors, ", ".join(units)


def _converted(
    result: xr.Dataset, name: str, quantity: str, units: str, scales: Scales, device: Device
) -> xr.DataArray | None:
    """A variable in its practical unit; None for one that stays unchanged."""
    variable = result[name]
    if quantity == "device field" and units in FIELDS_READ_AS:
        unit = FIELDS_READ_AS[units]
        powers = DIMENSIONS[units].powers
        # fifteen digits: 0.0002 m is 0.2 mm, and not the next double
        rounded = [float(f"{value * 10.0 ** -powers[unit]:.15g}") for value in variable.values.ravel()]
        values = np.reshape(rounded, variable.shape)
        return variable.copy(data=values).assign_attrs(variable.attrs | {"units": unit})
    if units != "1":
        return None
    attrs = dict(variable.attrs)
    if "long_name" in attrs:
        attrs["long_name"] = in_words(attrs["long_name"])
    if quantity == "state":
        import xarray as xr

        along = variable.dims[-1]
        factors, unit = state_factors(attrs, variable.shape[-1], scales)
        each = xr.concat(xr.broadcast(*map(xr.DataArray, factors)), dim=along)
        scaled = (variable * each).transpose(..., along)
    else:
        number = numbers_of(device).get(name) if quantity == "parameter" else None
        if number is not None and number.quantity in MEASURES:
            quantity = number.quantity
            attrs["long_name"] = device.all_fields()[number.field].meaning
        if quantity not in MEASURES:
            return None
        scaled, unit = variable.astype(float) * scales.shown(quantity), MEASURES[quantity].shown
        scaled = scaled.transpose(*variable.dims, ...)
        if name in result.coords:
            scaled = scaled.copy(data=without_rounding(scaled.values))
    return scaled.assign_attrs(attrs | {"units": unit})


def in_device_words(message: str, device: Device) -> str:
    """Translate a message about the model's parameters into the names and units of the device's fields."""
    scales, numbers, fields = device.scales, numbers_of(device), device.all_fields()

    def said(found: re.Match[str]) -> str:
        name, number = found["name"], found["number"]
        if name == "damping_ratio":
            field = next(one for one in DAMPINGS if getattr(device, one) is not None)
            return field if number is None or float(number) else f"{field} = 0"
        field, quantity = numbers[name]
        if number is None:
            return field
        if quantity == "1":
            return f"{field} = {number}"
        return f"{field} = {_size(scales, quantity, number, fields[field].unit)}"

    # a name that may be a word of a sentence is translated only with its value
    names = "|".join(name if "_" in name else f"{re.escape(name)}(?= = )" for name in (*numbers, "damping_ratio"))
    message = re.sub(rf"(?<![\w.'-])(?P<name>{names})(?![\w'])(?: = (?P<number>{_NUMBER}))?", said, message)
    for pattern, quantity, unit in _SIZES:

        def sized(found: re.Match[str], quantity: str = quantity, unit: str = unit) -> str:
            return re.sub(_NUMBER, lambda number: _size(scales, quantity, number[0], unit), found[0])

        message = re.sub(pattern, sized, message)
    message = re.sub(_RING, lambda times: f"{_size(scales, 'length', times[1], 'm')} ({times[0]})", message)
    return _DEFAULT.sub("", message)


def _size(scales: Scales, quantity: str, number: str, unit: str) -> str:
    """The text in SI of a dimensionless number of a quantity in a message."""
    return format_si(float(number) * float(np.ravel(scales.size(quantity))[0]), unit)


_NUMBER = r"[-+]?\d[\d.]*(?:e[-+]?\d+)?"
_SIZES = (
    (rf"displacements from {_NUMBER} to {_NUMBER}: none is reached; stay within {_NUMBER}", "length", "m"),
    (
        rf"displacements from {_NUMBER} on: no film spans them within its stretch limit; give \|x\| below {_NUMBER}",
        "length",
        "m",
    ),
    (rf"initial displacement {_NUMBER}", "length", "m"),
    (r"(?<!\w)displacements = \[[^]]*\]", "length", "m"),
    (rf"((transient|patience|budget|window|duration) = |times: |comes after |time of at most ){_NUMBER}", "time", "s"),
    (rf"(decay times last|slowest state last|longer than) {_NUMBER}", "time", "s"),
    (rf"(?<!\w)frequencies: {_NUMBER}", "frequency", "Hz"),
    (rf"(?<!\w)((voltages|before|bias) = |voltage: )(\[[^]]*\]|{_NUMBER})", "voltage", "V"),
)
"""Numbers in messages that do not belong to a parameter, with their quantity and unit."""
_RING = rf"({_NUMBER}) times film_radius - disc_radius"
"""A length in units of the width of the ring, to which the length in metres is added."""
_DEFAULT = re.compile(r"; its default is \S+$")
"""The default of a parameter, which is dimensionless and does not apply to the device."""


def in_words(long_name: str) -> str:
    """A long name without its dimensionless symbol."""
    return _SYMBOLS.sub("", long_name)


def _put(result: xr.Dataset, name: str, values: xr.DataArray) -> xr.Dataset:
    """The Dataset with a coordinate replaced; an axis whose values then differ between members loses its dim."""
    if name in values.dims and values.ndim > 1:
        dim = "sample" if "sample" not in result.dims else f"{name}_sample"
        result = result.drop_vars(name).rename_dims({name: dim})
        values = values.drop_vars(name).rename({name: dim})
    return result.assign_coords({name: (values.dims, values.values, values.attrs)})


def _with_member_fields(result: xr.Dataset, device: Device) -> xr.Dataset:
    """The result of an ensemble of devices with coordinates over the fields that differ, in place of the model's
    parameters."""
    if not device.shape or "member" not in result.dims:
        return result
    result = result.drop_vars([str(n) for n, c in result.coords.items() if c.attrs.get("quantity") == "parameter"])
    fields = {name: device.get(name) for name in device.swept_fields()}
    coords: dict[str, Any] = {
        name: ("member", value, field_attributes(device, name)) for name, value in fields.items() if np.ndim(value)
    }
    gels = device.material.name.split(SEPARATOR)
    if len(gels) > 1 and len(gels) == result.sizes["member"] and not gels[-1].endswith(", changed"):
        coords["material"] = ("member", np.array(gels), {"long_name": "gel", "units": "1", "quantity": "code"})
    return result.assign_coords(coords)


def _getter(result: xr.Dataset, device: Device, along: str = "") -> Callable[[str], Any]:
    """A function that returns a field of the device for every value of a result: a number, or an array over the swept
    fields. ``along`` names variables that replace fields, as ``field=variable,...``."""
    replacements = {
        name: result[variable] for name, _, variable in (pair.partition("=") for pair in along.split(",") if pair)
    }
    points = {name: in_field_units(coordinate) for name, coordinate in (_points(result) | replacements).items()}
    points = {name: coordinate.reset_coords(drop=True) for name, coordinate in points.items()}
    if "material.young_modulus" in points:
        points["material.shear_modulus"] = points["material.young_modulus"] / 3.0
    return lambda name: points[name] if name in points else device.get(name)
