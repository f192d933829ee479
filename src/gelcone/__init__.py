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
    from gelcone.atlas.maps import basin as basin
    from gelcone.atlas.maps import parameter_map as parameter_map
    from gelcone.atlas.plan import Plan as Plan
    from gelcone.atlas.record import look as look
    from gelcone.atlas.survey import survey as survey
    from gelcone.atlas.uncertain import Normal as Normal
    from gelcone.atlas.uncertain import Uniform as Uniform
    from gelcone.atlas.uncertain import draw as draw
    from gelcone.atlas.uncertain import probability as probability
    from gelcone.atlas.workers import cluster as cluster
    from gelcone.atlas.workers import threads as threads
    from gelcone.codes import Outcome as Outcome
    from gelcone.codes import Regime as Regime
    from gelcone.continuum.fit import fit_film as fit_film
    from gelcone.continuum.fit import write_film as write_film
    from gelcone.dataset import load as load
    from gelcone.dataset import model_of as model_of
    from gelcone.dataset import save as save
    from gelcone.devices.device import Device as Device
    from gelcone.devices.device import find_device as find_device
    from gelcone.devices.materials import Material as Material
    from gelcone.devices.materials import load_materials as load_materials
    from gelcone.devices.si import to_si as to_si
    from gelcone.errors import InputError as InputError
    from gelcone.errors import MissingDependency as MissingDependency
    from gelcone.motion.envelope import envelope as envelope
    from gelcone.motion.equilibrium import fold_voltages as fold_voltages
    from gelcone.motion.equilibrium import pitchfork_voltage as pitchfork_voltage
    from gelcone.motion.equilibrium import pull_in_voltage as pull_in_voltage
    from gelcone.motion.equilibrium import static as static
    from gelcone.motion.equilibrium import stroke_and_blocked_force as stroke_and_blocked_force
    from gelcone.motion.floquet import Onset as Onset
    from gelcone.motion.floquet import floquet_multipliers as floquet_multipliers
    from gelcone.motion.floquet import onset_voltage as onset_voltage
    from gelcone.motion.floquet import tongues as tongues
    from gelcone.motion.flow import integrate as integrate
    from gelcone.motion.frequency import frequency_response as frequency_response
    from gelcone.motion.linear import small_signal_response as small_signal_response
    from gelcone.motion.linear import state_space as state_space
    from gelcone.motion.lyapunov import lyapunov as lyapunov
    from gelcone.motion.regime import regime as regime
    from gelcone.motion.response import simulate as simulate
    from gelcone.motion.section import extrema as extrema
    from gelcone.motion.section import section as section
    from gelcone.motion.spectrum import spectrum as spectrum
    from gelcone.physics.balance import PullIn as PullIn
    from gelcone.physics.bias import Bias as Bias
    from gelcone.physics.bias import LinearSpring as LinearSpring
    from gelcone.physics.circuit import Circuit as Circuit
    from gelcone.physics.circuit import IdealSource as IdealSource
    from gelcone.physics.component import Component as Component
    from gelcone.physics.component import State as State
    from gelcone.physics.drive import Sine as Sine
    from gelcone.physics.drive import Waveform as Waveform
    from gelcone.physics.film.continuum import ContinuumFilm as ContinuumFilm
    from gelcone.physics.film.continuum import read_film as read_film
    from gelcone.physics.film.film import Film as Film
    from gelcone.physics.film.taut import TautCone as TautCone
    from gelcone.physics.laws import LAWS as LAWS
    from gelcone.physics.laws import Gent as Gent
    from gelcone.physics.laws import NeoHookean as NeoHookean
    from gelcone.physics.laws import StrainEnergyLaw as StrainEnergyLaw
    from gelcone.physics.laws import Yeoh as Yeoh
    from gelcone.physics.model import ConeModel as ConeModel
    from gelcone.plots import plot as plot
    from gelcone.quantity import Quantity as Quantity

_HOME = {
    "Bias": "physics.bias",
    "Circuit": "physics.circuit",
    "Component": "physics.component",
    "Film": "physics.film.film",
    "IdealSource": "physics.circuit",
    "LinearSpring": "physics.bias",
    "Quantity": "quantity",
    "Sine": "physics.drive",
    "State": "physics.component",
    "TautCone": "physics.film.taut",
    "Waveform": "physics.drive",
    "basin": "atlas.maps",
    "bifurcation": "atlas.bifurcation",
    "cluster": "atlas.workers",
    "ConeModel": "physics.model",
    "ContinuumFilm": "physics.film.continuum",
    "Device": "devices.device",
    "draw": "atlas.uncertain",
    "envelope": "motion.envelope",
    "extrema": "motion.section",
    "find_device": "devices.device",
    "fit_film": "continuum.fit",
    "floquet_multipliers": "motion.floquet",
    "fold_voltages": "motion.equilibrium",
    "frequency_response": "motion.frequency",
    "Gent": "physics.laws",
    "InputError": "errors",
    "integrate": "motion.flow",
    "LAWS": "physics.laws",
    "load": "dataset",
    "load_materials": "devices.materials",
    "look": "atlas.record",
    "lyapunov": "motion.lyapunov",
    "Material": "devices.materials",
    "MissingDependency": "errors",
    "model_of": "dataset",
    "NeoHookean": "physics.laws",
    "Normal": "atlas.uncertain",
    "Onset": "motion.floquet",
    "onset_voltage": "motion.floquet",
    "Outcome": "codes",
    "parameter_map": "atlas.maps",
    "pitchfork_voltage": "motion.equilibrium",
    "probability": "atlas.uncertain",
    "plot": "plots",
    "pull_in_voltage": "motion.equilibrium",
    "Plan": "atlas.plan",
    "PullIn": "physics.balance",
    "Regime": "codes",
    "read_film": "physics.film.continuum",
    "regime": "motion.regime",
    "save": "dataset",
    "section": "motion.section",
    "simulate": "motion.response",
    "small_signal_response": "motion.linear",
    "spectrum": "motion.spectrum",
    "state_space": "motion.linear",
    "static": "motion.equilibrium",
    "StrainEnergyLaw": "physics.laws",
    "stroke_and_blocked_force": "motion.equilibrium",
    "survey": "atlas.survey",
    "threads": "atlas.workers",
    "thresholds_of": "atlas.bifurcation",
    "to_si": "devices.si",
    "tongues": "motion.floquet",
    "Uniform": "atlas.uncertain",
    "write_film": "continuum.fit",
    "Yeoh": "physics.laws",
}

__all__ = ["__version__", "plots", *_HOME]


def __getattr__(name: str) -> Any:
    """Loads a public name when it is first used, so that ``import gelcone`` stays light."""
    if name == "plots":
        return import_module("gelcone.plots")
    if name not in _HOME:
        raise AttributeError(f"module 'gelcone' has no attribute {name!r}")
    return getattr(import_module(f"gelcone.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
