"""Conical PVC-gel actuators, from energy to motion.

Describe an actuator, let it move, and look at the result:

>>> import gelcone
>>> model = gelcone.ConeModel(voltage=1.04, drive_frequency=0.3, damping_ratio=0.05)
>>> response = gelcone.simulate(model, initial=(1.0, 0.0), periods=10)
>>> response.displacement.dims, int(response.outcome) == gelcone.Outcome.OK
(('time',), True)
>>> gelcone.ConeModel(voltage=[0.5, 1.0, 1.5]).shape
(3,)

A real device is a `Device` in SI units (`Device.from_toml`); `Device.to_model` gives its model and `to_si` brings
results back into millimetres, volts and milliseconds. `save` and `load` keep results as netCDF.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from gelcone._version import __version__

if TYPE_CHECKING:
    from gelcone.dataset import load, model_of, save
    from gelcone.device import Device, find_device
    from gelcone.errors import InputError, MissingDependency
    from gelcone.laws import LAWS, Gent, NeoHookean, StrainEnergyLaw, Yeoh
    from gelcone.materials import Material, load_materials
    from gelcone.model import ConeModel
    from gelcone.motion.flow import Outcome, integrate
    from gelcone.motion.response import simulate
    from gelcone.si import to_si

_HOME = {
    "LAWS": "laws",
    "ConeModel": "model",
    "Device": "device",
    "Gent": "laws",
    "InputError": "errors",
    "Material": "materials",
    "MissingDependency": "errors",
    "NeoHookean": "laws",
    "Outcome": "motion.flow",
    "StrainEnergyLaw": "laws",
    "Yeoh": "laws",
    "find_device": "device",
    "integrate": "motion.flow",
    "load": "dataset",
    "load_materials": "materials",
    "model_of": "dataset",
    "save": "dataset",
    "simulate": "motion.response",
    "to_si": "si",
}

__all__ = [
    "LAWS",
    "ConeModel",
    "Device",
    "Gent",
    "InputError",
    "Material",
    "MissingDependency",
    "NeoHookean",
    "Outcome",
    "StrainEnergyLaw",
    "Yeoh",
    "__version__",
    "find_device",
    "integrate",
    "load",
    "load_materials",
    "model_of",
    "save",
    "simulate",
    "to_si",
]


def __getattr__(name: str) -> Any:
    """Loads a public name when it is first used, so that ``import gelcone`` stays light."""
    if name not in _HOME:
        raise AttributeError(f"module 'gelcone' has no attribute {name!r}")
    return getattr(import_module(f"gelcone.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
