"""Results of a device in the units that its users read: millimetres, volts, newtons, hertz, milliseconds."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.devices.device import Device

READ_AS = {
    "length": ("mm", 1e3),
    "time": ("ms", 1e3),
    "velocity": ("m/s", 1.0),
    "force": ("N", 1.0),
    "stiffness": ("N/m", 1.0),
    "energy": ("mJ", 1e3),
    "power": ("mW", 1e3),
    "apparent power": ("mVA", 1e3),
    "voltage": ("V", 1.0),
    "current": ("mA", 1e3),
    "field": ("V/um", 1e-6),
    "stress": ("kPa", 1e-3),
    "frequency": ("Hz", 1.0),
    "rate": ("1/s", 1.0),
}
"""Quantity of a dimensionless variable -> the unit it is read in, and how many of it make one SI unit."""


def factor(device: Device, quantity: str) -> float:
    """What one dimensionless unit of a quantity is in the unit of `READ_AS`."""
    scales = device.scales
    if quantity == "stiffness":
        scale = scales.force / scales.length
    elif quantity == "apparent power":
        scale = scales.power
    elif quantity == "rate":
        scale = 1.0 / scales.time
    else:
        scale = getattr(scales, quantity)
    return float(scale) * READ_AS[quantity][1]


def to_si(dataset: xr.Dataset, device: Device) -> xr.Dataset:
    """The same results with every variable that has an SI scale in the unit of `READ_AS`.

    The dimensionless parameters stay as they are, and so does what has a unit already; the attribute ``device`` names
    the device.
    """
    result = dataset.copy()
    for name, variable in dataset.variables.items():
        quantity = variable.attrs.get("quantity")
        if quantity in READ_AS and variable.attrs["units"] == "1":
            scaled = variable.astype(float) * factor(device, str(quantity))
            scaled.attrs = variable.attrs | {"units": READ_AS[str(quantity)][0]}
            if name in dataset.coords:
                result = result.assign_coords({name: scaled})
            else:
                result[name] = scaled
    result.attrs["device"] = device.name
    return result
