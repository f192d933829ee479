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
    from gelcone.atlas.bifurcation import bifurcation as bifurcation
    from gelcone.atlas.bifurcation import thresholds_of as thresholds_of
    from gelcone.atlas.cells import Plan as Plan
    from gelcone.atlas.envelope import envelope as envelope
    from gelcone.atlas.frequency import frequency_response as frequency_response
    from gelcone.atlas.grid import basin as basin
    from gelcone.atlas.grid import parameter_map as parameter_map
    from gelcone.atlas.record import look as look
    from gelcone.atlas.samples import Normal as Normal
    from gelcone.atlas.samples import Uniform as Uniform
    from gelcone.atlas.samples import draw as draw
    from gelcone.atlas.samples import probability as probability
    from gelcone.atlas.survey import survey as survey
    from gelcone.atlas.workers import cluster as cluster
    from gelcone.atlas.workers import threads as threads
    from gelcone.dataset import load as load
    from gelcone.dataset import model_of as model_of
    from gelcone.dataset import save as save
    from gelcone.device import Device as Device
    from gelcone.device import find_device as find_device
    from gelcone.errors import InputError as InputError
    from gelcone.errors import MissingDependency as MissingDependency
    from gelcone.film import ContinuumFilm as ContinuumFilm
    from gelcone.film import read_film as read_film
    from gelcone.laws import LAWS as LAWS
    from gelcone.laws import Gent as Gent
    from gelcone.laws import NeoHookean as NeoHookean
    from gelcone.laws import StrainEnergyLaw as StrainEnergyLaw
    from gelcone.laws import Yeoh as Yeoh
    from gelcone.materials import Material as Material
    from gelcone.materials import load_materials as load_materials
    from gelcone.model import ConeModel as ConeModel
    from gelcone.motion.balance import PullIn as PullIn
    from gelcone.motion.equilibrium import fold_voltages as fold_voltages
    from gelcone.motion.equilibrium import pitchfork_voltage as pitchfork_voltage
    from gelcone.motion.equilibrium import pull_in_voltage as pull_in_voltage
    from gelcone.motion.equilibrium import static as static
    from gelcone.motion.equilibrium import stroke_and_blocked_force as stroke_and_blocked_force
    from gelcone.motion.floquet import Onset as Onset
    from gelcone.motion.floquet import floquet_multipliers as floquet_multipliers
    from gelcone.motion.floquet import onset_voltage as onset_voltage
    from gelcone.motion.floquet import tongues as tongues
    from gelcone.motion.flow import Outcome as Outcome
    from gelcone.motion.flow import integrate as integrate
    from gelcone.motion.linear import small_signal_response as small_signal_response
    from gelcone.motion.linear import state_space as state_space
    from gelcone.motion.lyapunov import lyapunov as lyapunov
    from gelcone.motion.regime import Regime as Regime
    from gelcone.motion.regime import regime as regime
    from gelcone.motion.response import simulate as simulate
    from gelcone.motion.section import extrema as extrema
    from gelcone.motion.section import section as section
    from gelcone.motion.spectrum import spectrum as spectrum
    from gelcone.si import to_si as to_si
    from gelcone.validation.fit import fit_film as fit_film
    from gelcone.validation.fit import write_film as write_film

_HOME = {
    "basin": "atlas.grid",
    "bifurcation": "atlas.bifurcation",
    "cluster": "atlas.workers",
    "ConeModel": "model",
    "ContinuumFilm": "film",
    "Device": "device",
    "draw": "atlas.samples",
    "envelope": "atlas.envelope",
    "extrema": "motion.section",
    "find_device": "device",
    "fit_film": "validation.fit",
    "floquet_multipliers": "motion.floquet",
    "fold_voltages": "motion.equilibrium",
    "frequency_response": "atlas.frequency",
    "Gent": "laws",
    "InputError": "errors",
    "integrate": "motion.flow",
    "LAWS": "laws",
    "load": "dataset",
    "load_materials": "materials",
    "look": "atlas.record",
    "lyapunov": "motion.lyapunov",
    "Material": "materials",
    "MissingDependency": "errors",
    "model_of": "dataset",
    "NeoHookean": "laws",
    "Normal": "atlas.samples",
    "Onset": "motion.floquet",
    "onset_voltage": "motion.floquet",
    "Outcome": "motion.flow",
    "parameter_map": "atlas.grid",
    "pitchfork_voltage": "motion.equilibrium",
    "probability": "atlas.samples",
    "pull_in_voltage": "motion.equilibrium",
    "Plan": "atlas.cells",
    "PullIn": "motion.balance",
    "Regime": "motion.regime",
    "read_film": "film",
    "regime": "motion.regime",
    "save": "dataset",
    "section": "motion.section",
    "simulate": "motion.response",
    "small_signal_response": "motion.linear",
    "spectrum": "motion.spectrum",
    "state_space": "motion.linear",
    "static": "motion.equilibrium",
    "StrainEnergyLaw": "laws",
    "stroke_and_blocked_force": "motion.equilibrium",
    "survey": "atlas.survey",
    "threads": "atlas.workers",
    "thresholds_of": "atlas.bifurcation",
    "to_si": "si",
    "tongues": "motion.floquet",
    "Uniform": "atlas.samples",
    "write_film": "validation.fit",
    "Yeoh": "laws",
}

__all__ = ["__version__", *_HOME]


def __getattr__(name: str) -> Any:
    """Loads a public name when it is first used, so that ``import gelcone`` stays light."""
    if name not in _HOME:
        raise AttributeError(f"module 'gelcone' has no attribute {name!r}")
    return getattr(import_module(f"gelcone.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
