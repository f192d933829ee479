"""Conical PVC-gel actuators, from energy to motion.

A device in SI units, how it moves, and a picture of that:

>>> import gelcone
>>> device = gelcone.find_device("biased-pump").replace(frequency="9 Hz")
>>> response = gelcone.simulate(device, periods=10)
>>> response.displacement.units, int(response.outcome) == gelcone.Outcome.OK
('mm', True)
>>> figure = response.gelcone.plot()

Devices and gels
    Device, Device.from_toml, find_device, Material, load_materials, recorded
    read_tests, fit_material, fitted_material, fitted_text   a gel from tests on coupons
    read_device_tests, plan_device, fit_device, fitted_device, fitted_draws   a device from its measurements
    compare_measured                        a measured device against its predictions
    read_wish, design, designed_devices     devices that meet requirements in spite of tolerances
Analyses, of a device (SI in, SI out) or of a dimensionless ConeModel
    simulate, step, creep, transfer, section, extrema, spectrum   one run: how it moves
    regime, lyapunov, settled, triptych     the kind of motion, with the evidence
    static, limits, pull_in_voltage, fold_voltages, pitchfork_voltage, stroke_and_blocked_force
    film                                    the membrane from disc to rim at any height and voltage
    datasheet                               the numbers of an actuator on a page
    drive, frequency, envelope, operating_limits   stroke over frequency; where it is safe to drive
    tongues, onset_voltage, floquet_multipliers, small_signal_response
    state_space, rates, follow, sense       for control: linear, as a function, feed-forward, self-sensing
    environment                             for learned control: many devices at once in Gymnasium
    bifurcation, map, basin                 over one parameter, two, or initial states
    continue_branch, locus, thresholds_of   branches of periodic orbits, their bifurcations, ends of regimes
    validate                                forces of the cone against finite elements
    Plan, sweep, show, cluster              any analysis over any parameters, in stores, on clusters
    Uniform, Normal, draw, over_draws, probability, tolerances   uncertain parameters
Results, each an xarray.Dataset
    plot, in_words, table, save, load, export, to_si, model_of; also result.gelcone.plot() and so on; Outcome, Regime,
    PullIn, Onset
    integrate                               bare trajectories, without labels
    studio                                  the studio's page in a notebook
Models and their components
    ConeModel; Film, Bias, Waveform, Circuit, StrainEnergyLaw and those that ship

Fields of a device may be arrays, which make an ensemble, and any of them can be swept:

>>> thin = device.replace(film_thickness=[1.8e-4, 2.0e-4])
>>> gelcone.simulate(thin, periods=2).film_thickness.values.tolist()
[0.18, 0.2]

``help(gelcone.simulate)`` explains one of them, and ``gelcone help device`` on the command line lists the fields.
"""

from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

from gelcone._version import __version__ as __version__

# The only list of public names. Type checkers and editors follow these imports; at run time `__getattr__` makes them on
# first use, so that ``import gelcone`` stays light. A name with a line about it is an analysis, and the order here is
# that of the commands.
if TYPE_CHECKING:
    from gelcone.motion.response import simulate as simulate

    """How it moves: time response, stresses, energies, validity."""
    from gelcone.motion.step import step as step

    """A step of the voltage: rise, overshoot, settling time and drift."""
    from gelcone.motion.creep import creep as creep

    """Creep under held voltages, and the time to pull-in over voltage."""
    from gelcone.motion.transfer import transfer as transfer

    """Bode plot: voltage to displacement and current, linear and measured."""
    from gelcone.motion.section import section as section

    """Poincare section: the motion once every forcing period."""
    from gelcone.motion.extrema import extrema as extrema

    """The maxima and minima of the displacement."""
    from gelcone.motion.spectrum import spectrum as spectrum

    """Amplitude spectrum, its lines and its flatness."""
    from gelcone.motion.lyapunov import lyapunov as lyapunov

    """Lyapunov exponents, over a window and in the long run, with errors."""
    from gelcone.motion.regime import regime as regime

    """What kind of motion it is, with the evidence."""
    from gelcone.motion.triptych import triptych as triptych

    """Up to four motions side by side: over time, phase portrait, section."""
    from gelcone.motion.equilibrium import static as static

    """Equilibria under constant voltage, pitchfork, folds, pull-in, stroke."""
    from gelcone.motion.profile import film as film

    """The membrane from disc to rim: shape, stretches, field, wrinkles, capacitance."""
    from gelcone.continuum.compare import validate as validate

    """Forces of cone and membrane compared with finite elements."""
    from gelcone.motion.limits import limits as limits

    """How high a constant voltage may go: pull-in and pitchfork; and where the drive unsettles rest."""
    from gelcone.motion.settled import settled as settled

    """The settled motion: stroke, period, harmonics, and the linear stroke."""
    from gelcone.motion.operating_limits import operating_limits as operating_limits

    """How high the drive may go at its own frequency: pull-in, film slack, chaos and so on."""
    from gelcone.lab.datasheet import datasheet as datasheet

    """The data sheet on one page: force, stroke, work, coupling, bandwidth, power, limits."""
    from gelcone.motion.floquet import tongues as tongues

    """Where the drive makes rest unstable: onset voltage and tongues."""
    from gelcone.atlas.bifurcation import bifurcation as bifurcation

    """What the motion is along one parameter, and where it changes."""
    from gelcone.atlas.branches.continuation import continue_branch as continue_branch

    """Branches of periodic orbits, stable or not, and their bifurcations."""
    from gelcone.atlas.branches.locus import locus as locus

    """Folds, period doublings or symmetry breakings in two parameters."""
    from gelcone.atlas.maps import map as map

    """Exponent and regime over two parameters."""
    from gelcone.atlas.sweep import sweep as sweep

    """An analysis over any parameters, and the probability of chaos."""
    from gelcone.atlas.record import show as show

    """What a file or a store holds, also while its run continues."""
    from gelcone.atlas.maps import basin as basin

    """Which motions coexist: the attractor of each initial state."""
    from gelcone.atlas.frequency import frequency as frequency

    """Stroke over drive frequency, swept up and down: resonances and jumps."""
    from gelcone.motion.best_drive import drive as drive

    """Which voltage and frequency give the largest stroke, work or speed, and what limits them."""
    from gelcone.motion.envelope import envelope as envelope

    """How high the drive may go at every frequency, and which limit comes first."""

    from gelcone import plots as plots
    from gelcone.analyses.ask import in_words as in_words
    from gelcone.atlas.bifurcation import thresholds_of as thresholds_of
    from gelcone.atlas.cluster import cluster as cluster
    from gelcone.atlas.distribution import Normal as Normal
    from gelcone.atlas.distribution import Uniform as Uniform
    from gelcone.atlas.drawn import over_draws as over_draws
    from gelcone.atlas.plan import Plan as Plan
    from gelcone.atlas.probability import probability as probability
    from gelcone.atlas.tolerances import tolerances as tolerances
    from gelcone.atlas.uncertain import draw as draw
    from gelcone.codes import Outcome as Outcome
    from gelcone.codes import Regime as Regime
    from gelcone.dataset import load as load
    from gelcone.dataset import save as save
    from gelcone.devices.device import Device as Device
    from gelcone.devices.device import find_device as find_device
    from gelcone.devices.materials import Material as Material
    from gelcone.devices.materials import load_materials as load_materials
    from gelcone.devices.recorded import recorded as recorded
    from gelcone.devices.si import model_of as model_of
    from gelcone.devices.si import to_si as to_si
    from gelcone.errors import InputError as InputError
    from gelcone.errors import MissingDependency as MissingDependency
    from gelcone.export.public import export as export
    from gelcone.interchange import table as table
    from gelcone.lab.design import design as design
    from gelcone.lab.design import designed_devices as designed_devices
    from gelcone.lab.device import fit_device as fit_device
    from gelcone.lab.device import plan_device as plan_device
    from gelcone.lab.device_tests import read_device_tests as read_device_tests
    from gelcone.lab.fitted import fitted_device as fitted_device
    from gelcone.lab.fitted import fitted_draws as fitted_draws
    from gelcone.lab.material import fit_material as fit_material
    from gelcone.lab.material import fitted_material as fitted_material
    from gelcone.lab.material import fitted_text as fitted_text
    from gelcone.lab.measured import Measured as Measured
    from gelcone.lab.measured import read_tests as read_tests
    from gelcone.lab.page import compare_measured as compare_measured
    from gelcone.lab.wish import read_wish as read_wish
    from gelcone.learn.environment import environment as environment
    from gelcone.motion.feed_forward import follow as follow
    from gelcone.motion.floquet import Onset as Onset
    from gelcone.motion.floquet import floquet_multipliers as floquet_multipliers
    from gelcone.motion.floquet import onset_voltage as onset_voltage
    from gelcone.motion.flow import integrate as integrate
    from gelcone.motion.ramp import stroke_and_blocked_force as stroke_and_blocked_force
    from gelcone.motion.rates import rates as rates
    from gelcone.motion.self_sensing import sense as sense
    from gelcone.motion.state_space import small_signal_response as small_signal_response
    from gelcone.motion.state_space import state_space as state_space
    from gelcone.motion.static_bifurcations import fold_voltages as fold_voltages
    from gelcone.motion.static_bifurcations import pitchfork_voltage as pitchfork_voltage
    from gelcone.motion.static_bifurcations import pull_in_voltage as pull_in_voltage
    from gelcone.physics.balance import PullIn as PullIn
    from gelcone.physics.bias import Bias as Bias
    from gelcone.physics.bias import BuckledBeam as BuckledBeam
    from gelcone.physics.bias import ConstantForce as ConstantForce
    from gelcone.physics.bias import LinearSpring as LinearSpring
    from gelcone.physics.bias import Together as Together
    from gelcone.physics.bias import Weight as Weight
    from gelcone.physics.circuit import Circuit as Circuit
    from gelcone.physics.circuit import IdealSource as IdealSource
    from gelcone.physics.circuit import Port as Port
    from gelcone.physics.component import Component as Component
    from gelcone.physics.component import State as State
    from gelcone.physics.drive import Pieced as Pieced
    from gelcone.physics.drive import Pieces as Pieces
    from gelcone.physics.drive import Waveform as Waveform
    from gelcone.physics.film.film import Border as Border
    from gelcone.physics.film.film import Film as Film
    from gelcone.physics.film.taut import TautCone as TautCone
    from gelcone.physics.laws import LAWS as LAWS
    from gelcone.physics.laws import Gent as Gent
    from gelcone.physics.laws import NeoHookean as NeoHookean
    from gelcone.physics.laws import StrainEnergyLaw as StrainEnergyLaw
    from gelcone.physics.laws import Yeoh as Yeoh
    from gelcone.physics.model import ConeModel as ConeModel
    from gelcone.physics.placed import PlacedFilm as PlacedFilm
    from gelcone.physics.waveforms import Sine as Sine
    from gelcone.plots import plot as plot
    from gelcone.quantity import Quantity as Quantity
    from gelcone.studio.notebook import StudioFrame as StudioFrame
    from gelcone.studio.notebook import studio as studio


@cache
def _listing() -> dict[str, tuple[str, str]]:
    """Public name -> its module and the line about it, read from the imports above, also in a zip file."""
    import ast
    import pkgutil

    listing = ast.parse(pkgutil.get_data(__name__, "__init__.py") or b"")
    nodes = [node for block in listing.body if isinstance(block, ast.If) for node in block.body]
    public_names: dict[str, tuple[str, str]] = {}
    for node, behind in zip(nodes, [*nodes[1:], None], strict=True):
        if isinstance(node, ast.ImportFrom):
            about = (
                behind.value.value if isinstance(behind, ast.Expr) and isinstance(behind.value, ast.Constant) else ""
            )
            public_names |= {alias.name: (str(node.module), str(about)) for alias in node.names}
    return public_names


if not TYPE_CHECKING:  # else a type checker would take any name

    def __getattr__(name: str) -> Any:
        """Loads a public name when it is first used."""
        if name == "__all__":
            return sorted(_listing())
        if name.startswith("_") or name not in _listing():
            raise AttributeError(f"module 'gelcone' has no attribute {name!r}")
        module, _ = _listing()[name]
        if module == "gelcone":
            return import_module(f"gelcone.{name}")
        value = globals()[name] = getattr(import_module(module), name)
        return value


def __dir__() -> list[str]:
    return sorted(["__version__", *_listing()])
