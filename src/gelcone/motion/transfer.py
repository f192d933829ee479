"""Transfer functions from voltage to displacement and current about a bias, by linear theory and as measured."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Outcome
from gelcone.devices.analysis import analysis, check_one
from gelcone.errors import InputError
from gelcone.motion.attractor.cycle import find_cycles, sampled
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.natural import natural_frequency
from gelcone.motion.state_space import StateSpace, check_frequencies, equilibrium_under_bias, state_space
from gelcone.motion.swing import SAMPLES, SMALLEST_HARMONIC, Swing, harmonics_of, settled_swing
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.progress import Progress
from gelcone.quantity import Array, Frequencies, Voltage, Voltages
from gelcone.register.analysis import Axis

if TYPE_CHECKING:
    import xarray as xr

LOWEST, HIGHEST, POINTS = 0.05, 10.0, 401
"""Default frequencies, over the natural one: lowest, highest, number."""
MEASURED = (0.2, 4.0)
"""Default range, over the natural frequency, in which signals are measured, at every `EVERY`-th frequency."""
EVERY = 10
AROUND, ANGLE = 32, np.radians(85.0)
"""Number of frequencies around each pole, and the largest phase of a resonance at which they lie."""
SMALL = 0.02
"""Amplitude of a small signal, as a share of the bias."""

Complex = npt.NDArray[np.complex128]


@analysis(
    axes={
        "frequencies": Axis("drive_frequency", "frequency", least=1),
        "amplitudes": Axis("amplitude", "amplitude", least=1),
    },
    answers="trajectories",
    single=True,
    file_only=("drive_frequency", "gain", "phase", "admittance", "admittance_phase"),
    examples=(
        "biased-pump --out results",
        'biased-pump --film taut --bias "1 kV" --over "amplitude=20 V,400 V" --over "frequency=5 Hz:20 Hz:16" --json',
    ),
)
def transfer(
    model: ConeModel,
    frequencies: Frequencies | None = None,
    *,
    bias: Voltage | None = None,
    amplitudes: Voltages | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Compute transfer functions from voltage to displacement and current about a bias, linear and of real signals.

    `gelcone.state_space` gives the linear model itself, with ``to_control()`` for python-control.

    Parameters
    ----------
    model : a single actuator with damping; its drive gives the defaults of ``bias`` and ``amplitudes`` alone.
    frequencies : drive frequencies. Default: 401 from 0.05 to 10 times the natural one, measured at some, and more
        around each resonance.
    bias : constant voltage about which the signals are, of films in opposite phase that of both. Default that of the
        drive.
    amplitudes : amplitudes of the sines whose answer is measured, 0 for none. Default 2 % of the bias, and that of the
        drive.
    tolerance : relative error of one integration step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over ``drive_frequency`` with the ``gain`` (displacement over voltage) and its ``phase`` ahead of the
    voltage in degrees, the ``admittance`` (current of the source over voltage) and its ``admittance_phase``, all by
    linear theory; over ``amplitude`` and ``measured_frequency`` ``measured_gain``, ``measured_phase``,
    ``measured_admittance`` and ``measured_admittance_phase``, with their ``outcome``: the fundamentals of the settled
    motion on which a run from the linear one ends, NaN where it does not repeat with the drive, has no settled motion,
    or is as small as rounding. Of a film whose charge is not known in a program the linear admittance is NaN.
    ``equilibrium_displacement`` is the displacement under the ``bias_voltage``, ``natural_frequency`` that of small
    motions about it as if undamped, in which the branches of a film that creeps have little time to relax,
    ``resonance`` where the gain of linear theory is largest, between the lowest and the highest frequency, and
    ``largest_gain`` the gain there.

    Raises
    ------
    InputError : for an ensemble, a model without damping, a bias of 0 or beyond pull-in, and frequencies or amplitudes
        out of bounds.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4, damping_ratio=0.1)
    >>> found = gelcone.transfer(model, [1.0, 1.5], amplitudes=0.1)
    >>> f"{found.gain[1].item():.4f}, measured {found.measured_gain[0, 1].item():.4f}"
    '2.5067, measured 2.4473'
    """
    check_one(model, "transfer")
    if not np.all(model.members().damped):
        raise InputError("damping_ratio = 0: without damping no signal settles; give it some")
    about = float(model.offset_voltage) if bias is None else float(bias)
    if about == 0.0:
        raise InputError(
            "bias = 0: give a bias (--bias), or voltage_bias, since about no voltage a small one does not move the disc"
        )
    given = model
    # in opposite phase both films have this bias
    model = model.replace(waveform="sine", voltage_bias=about)
    equilibrium_under_bias(model, about, "voltage_bias =" if bias is None else "bias =")
    electric = ("source_charge", "source_leak") if all(film.film.traced_charge for film in model.system.films) else ()
    space = state_space(model, outputs=("displacement", *electric))
    natural = float(natural_frequency(model, abs(about), space.place))
    omega = natural * np.geomspace(LOWEST, HIGHEST, POINTS) if frequencies is None else _frequencies(frequencies)
    within = (omega >= MEASURED[0] * natural) & (omega <= MEASURED[1] * natural)
    at = omega[within][::EVERY] if frequencies is None else omega
    fine = _with_resonances(space, omega)
    resonance, largest = _largest_gain(space, fine)
    if frequencies is None:
        omega = np.union1d(fine, resonance)
    signals = _amplitudes(model, about) if amplitudes is None else _signals(amplitudes)
    place, current, _ = _linear(space, omega)
    options: dict[str, Any] = {"tolerance": tolerance, "threads": threads}
    answers = _measured(model, space, signals, at, progress, options)
    linear, measured = ("drive_frequency",), ("amplitude", "measured_frequency")
    variables: dict[str, dataset.Variable] = {
        "equilibrium_displacement": ((), space.place, "displacement under the bias", "length"),
        "natural_frequency": ((), natural, "natural frequency of small undamped motions", "frequency"),
        "resonance": ((), resonance, "frequency of the largest gain", "frequency"),
        "largest_gain": ((), largest, "largest gain by linear theory", "gain"),
    }
    for dims, before, method, (x, i) in (
        (linear, "", "by linear theory", (place, current)),
        (measured, "measured_", "measured", answers[:2]),
    ):
        variables |= {
            f"{before}gain": (dims, np.abs(x), f"displacement over voltage, {method}", "gain"),
            f"{before}phase": (dims, _degrees(x), f"phase of the displacement, {method}", "angle"),
            f"{before}admittance": (dims, np.abs(i), f"current over voltage, {method}", "admittance"),
            f"{before}admittance_phase": (dims, _degrees(i), f"phase of the current, {method}", "angle"),
        }
    result = dataset.label(
        given,
        variables,
        coords={
            "drive_frequency": (linear, omega, "drive frequency", "frequency"),
            "measured_frequency": (("measured_frequency",), at, "drive frequency", "frequency"),
            "bias_voltage": ((), about, "constant voltage about which the signals are", "voltage"),
            "amplitude": (("amplitude",), signals, "amplitude of the voltage", "voltage"),
        },
        options={"bias": about, "tolerance": tolerance},
        title="transfer functions",
    )
    return result.assign(outcome=dataset.outcome_array(answers[2], measured))


def _frequencies(given: Any) -> Array:
    omega = np.atleast_1d(np.asarray(given, dtype=float))
    check_frequencies(omega)
    return np.unique(omega)


def _signals(given: Any) -> Array:
    amplitudes = np.unique(np.asarray(given, dtype=float))
    if not (np.isfinite(amplitudes).all() and (amplitudes >= 0.0).all()):
        raise InputError("amplitudes: must be finite and not negative; 0 measures none")
    return amplitudes[amplitudes > 0.0]


def _amplitudes(model: ConeModel, bias: float) -> Array:
    return np.unique([SMALL * abs(bias), *np.ravel(np.asarray(model.voltage, dtype=float))])


def _degrees(values: Complex) -> Array:
    return np.where(values == 0.0, np.nan, np.degrees(np.angle(values)))


def _with_resonances(space: StateSpace, omega: Array) -> Array:
    """Frequencies with additional ones around each oscillating pole, evenly spaced in the phase of its resonance."""
    poles = np.linalg.eigvals(space.A)
    poles = poles[poles.imag > 0.0]
    near = poles.imag - poles.real * np.tan(np.linspace(-ANGLE, ANGLE, AROUND))[:, None]
    return np.union1d(omega, near[(near > omega[0]) & (near < omega[-1])])


def _largest_gain(space: StateSpace, omega: Array) -> tuple[float, float]:
    """The frequency at which the gain is largest, between the first and the last of ``omega``, and the gain there."""
    from scipy.optimize import minimize_scalar

    def gain(at: Any) -> Array:
        return np.abs(_linear(space, np.atleast_1d(at))[0])

    gains = gain(omega)
    best = int(np.argmax(gains))
    ends = omega[max(best - 1, 0)], omega[min(best + 1, omega.size - 1)]
    peak = minimize_scalar(lambda at: -gain(at)[0], bounds=ends, method="bounded", options={"xatol": 1e-9 * ends[1]})
    return (float(peak.x), -float(peak.fun)) if -peak.fun > gains[best] else (float(omega[best]), float(gains[best]))


def _linear(space: StateSpace, omega: Array) -> tuple[Complex, Complex, Complex]:
    """Displacement and current over the voltage, and all states over it, (frequencies, N)."""
    states = space.moved(omega)[..., 0]
    place, *electric = (states @ space.C.T + space.D[:, 0]).T
    current = 1j * omega * electric[0] + electric[1] if electric else np.full(omega.shape, np.nan + 0j)
    return place, current, states


def _measured(
    model: ConeModel, space: StateSpace, signals: Array, omega: Array, progress: Progress, options: dict[str, Any]
) -> tuple[Complex, Complex, npt.NDArray[np.int8]]:
    """Displacement and current over the voltage, (signals, frequencies), of motions that start from the linear ones,
    and their outcomes."""
    shape = (signals.size, omega.size)
    if not np.prod(shape):
        return np.zeros(shape, complex), np.zeros(shape, complex), np.zeros(shape, np.int8)
    model = model.replace(voltage=signals[:, None], drive_frequency=omega)
    members = model.members()
    linear = np.tile(_linear(space, omega)[2], (signals.size, 1)).imag
    states = np.array(space.rest) + members.values["voltage"][:, None] * linear
    cycles = find_cycles(members, states, np.ones(members.size, dtype=np.int64), **options)
    near = cycles.found & (cycles.sign < 0)
    reached = Swing.blank(members.size, states=states.shape[1])
    reached.period[near], reached.final[near] = cycles.period[near], cycles.point[near]
    if not near.all():  # too far from the linear motion for Newton's method
        group, starts = members.take(~near), states[~near]
        reached.put(~near, settled_swing(group, starts, only_extent=True, progress=progress, **options))
    amplitudes = np.full((2, members.size), np.nan + 0j)
    for period in np.unique(reached.period[(reached.outcome == Outcome.OK) & (reached.period > 0)]):
        rows = np.flatnonzero((reached.outcome == Outcome.OK) & (reached.period == period))
        amplitudes[:, rows] = _fundamentals(members.take(rows), reached.final[rows], int(period), **options)
    x, i = amplitudes.reshape(2, *shape) / signals[:, None]
    return x, i, reached.outcome.reshape(shape)


def _fundamentals(members: Members, states: Array, period: int, **options: Any) -> Complex:
    """Complex amplitudes at the drive frequency of the displacement and the source's current, (2, members)."""
    run = sampled(members, states, period, SAMPLES, **options)
    spacing = (run.times.shape[1] - 1) // run.path.shape[1]
    currents = members.along(members.system.source_currents, run.times[:, spacing::spacing], run.path)
    signals = run.path[..., 0], currents[0]
    amplitudes = np.stack([harmonics_of(members, signal, SAMPLES)[:, 0] for signal in signals])
    largest = np.stack([np.abs(signal).max(axis=1) for signal in signals])
    return np.where(np.abs(amplitudes) > SMALLEST_HARMONIC * largest, amplitudes, np.nan)
