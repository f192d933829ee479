"""Small signals: the actuator linearised about an equilibrium under a constant voltage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.devices.analysis import check_model, for_devices
from gelcone.devices.device import Device
from gelcone.errors import InputError
from gelcone.motion.equilibrium import stroke_and_blocked_force
from gelcone.physics.balance import rest_of
from gelcone.physics.circuit import Circuit
from gelcone.physics.component import State
from gelcone.physics.differentiate import gradients
from gelcone.physics.drive import PHASES
from gelcone.physics.members import Ensemble, Members
from gelcone.physics.model import ConeModel
from gelcone.physics.statics import each, every_balance, rest_displacements
from gelcone.quantity import Array, Frequencies

if TYPE_CHECKING:
    import xarray as xr

HARMONICS = 8
"""Multiples of the drive frequency that are taken into account."""
ROUNDING = 1e-13
"""Harmonics below this share of the mean square are rounding."""
NEWTON_STEPS = 20
RAMP = 33
"""Steps in which the voltages on both films of a double cone rise together."""


class StateSpace(NamedTuple):
    """x' = A x + B u, y = C x + D u, as SciPy and python-control take it: ``scipy.signal.StateSpace(*it)``,
    ``control.ss(*it)``.

    States: displacement and velocity from the equilibrium; input: voltage from the bias; output: displacement. Units
    are dimensionless, or metres, seconds and volts for a device.
    """

    A: Array
    B: Array
    C: Array
    D: Array


def equilibrium_under_bias(model: ConeModel, bias: float) -> float:
    """The equilibrium that a slow ramp from 0 to the voltage ``bias`` ends at; `InputError` if there is none."""
    place = float(stroke_and_blocked_force(model, [abs(bias)])["displacement"][0])
    if not np.isfinite(place):
        raise InputError(f"voltage_bias = {bias:g}: beyond pull-in, there is no equilibrium; lower it")
    return place


def state_space(model: ConeModel | Device, device: Device | None = None) -> StateSpace:
    """The model linearised about its equilibrium under the constant voltage ``voltage_bias``.

    x'' = -2 zeta x' - K x + 2 v0 x0 v (of a taut film), with the stiffness K there; without a bias the
    voltage has no first-order effect and B is zero.

    Parameters
    ----------
    model : a single model, or a device, whose units are then metres, seconds and volts.
    device : scales the matrices to metres, seconds and volts. Default None: dimensionless.

    Raises
    ------
    InputError : for an ensemble, or a bias beyond pull-in.
    """
    if isinstance(model, Device):
        device, model = model, model.to_model()
    check_model(model, "state_space")
    if model.shape:
        raise InputError(f"a state-space model is that of a single actuator, not of an ensemble of shape {model.shape}")
    system, n = model.system, model.numbers()
    bias = float(model.voltage_bias)
    place = equilibrium_under_bias(model, float(np.abs(bias * system.circuit.gain(0.0, n))))
    at = [place, 0.0, *_settled_states(model, place, bias), bias]
    n = {**n, **system.switches_under(bias, [np.float64(value) for value in at[:-1]], n)}
    slopes = gradients(lambda z, xp: system.rates_under(z[-1], z[:-1], n, xp), at)
    jacobian, states = np.array(slopes, dtype=float), system.states
    scales, time, volt = _scales(states, device)
    A, B = jacobian[:, :-1] * scales[:, None] / (scales * time), jacobian[:, -1:] * scales[:, None] / (time * volt)
    return StateSpace(A=A, B=B, C=np.eye(1, len(states)), D=np.array([[0.0]]))


def _settled_states(model: ConeModel, place: float, voltage: float) -> list[float]:
    """The states besides the disc's at rest under a constant voltage, by Newton's method."""
    system, n = model.system, model.numbers()
    own = np.array([state.start for state in system.states[2:]])

    def rates(y: list[Any], xp: Any) -> list[Any]:
        return list(system.rates_under(voltage, [np.float64(place), np.float64(0.0), *y], n, xp)[2:])

    for _ in range(NEWTON_STEPS if own.size else 0):
        slopes = np.array(gradients(rates, list(own)), dtype=float)
        own = own - np.linalg.solve(slopes, np.array(rates(list(own), np), dtype=float))
    return [float(value) for value in own]


def _scales(states: tuple[State, ...], device: Device | None) -> tuple[Array, float, float]:
    """SI values of one unit of each state, of time and of voltage; 1 without a device."""
    if device is None:
        return np.ones(len(states)), 1.0, 1.0
    scales = device.scales
    own = [float(getattr(scales, state.quantity, 1.0)) for state in states]
    return np.array(own), scales.time, scales.voltage


@dataclass(frozen=True)
class LinearResponse:
    """``stroke`` (..., frequencies), and the complex amplitudes of the first two ``harmonics`` (..., 2, frequencies) of
    the drive, with the ensemble's axis before where there is one: the displacement is the imaginary part of harmonic
    times exp(i k omega t)."""

    stroke: Array
    harmonics: npt.NDArray[np.complex128]


def linear_response(model: Ensemble, frequencies: Array) -> LinearResponse:
    """The response to the members' own drives, linearised about the equilibria under their mean-square voltages.

    The force goes with the square of the film's voltage, whose harmonics drive the disc: for a sine with bias, that at
    the drive frequency with 2 v0 v, and at twice that with v^2/2. With a bias and a small amplitude this is
    `small_signal_response`. NaN where there is no equilibrium, or an unstable one. ``frequencies`` are angular,
    (frequencies,) or (members, frequencies).
    """
    members = model.members()
    omega = np.atleast_1d(np.asarray(frequencies, dtype=float))
    omega = np.broadcast_to(omega, (members.size, omega.shape[-1]))
    harmonics = _harmonics(members, omega)
    turn = np.exp(2j * np.pi * np.arange(PHASES) / PHASES)
    orders = np.arange(1, HARMONICS + 1)
    motion = np.einsum("mfk,kp->mfp", harmonics, turn ** orders[:, None]).imag
    found = LinearResponse(np.ptp(motion, axis=2), np.moveaxis(harmonics[..., :2], -1, 1))
    return found if model.shape else LinearResponse(found.stroke[0], found.harmonics[0])


def stiffness_under(model: ConeModel) -> float:
    """Slope of the static force at rest under the mean squares of a single model's drive, at its own frequency; NaN
    where there is no equilibrium."""
    members = model.members()
    voltages = _film_voltages(members, np.full((1, 1), float(model.drive_frequency)))
    return float(_equilibria(members, [np.mean(voltage**2, axis=-1) for voltage in voltages])[1][0, 0])


def _equilibria(members: Members, mean_squares: Sequence[Array]) -> tuple[Array, Array]:
    """Displacement and stiffness at rest under the mean squares of the films' voltages, (members, levels) each; NaN
    where there is none."""
    if len(members.system.films) > 1:
        return _under_both(members, mean_squares)
    (squared,) = mean_squares
    balances = every_balance(members)
    rests = each(rest_of, balances, [None] * len(balances))
    place = np.stack(
        [balance.along_ramp(rest, own)[0] for balance, rest, own in zip(balances, rests, squared, strict=True)]
    )
    return place, np.asarray(members.stiffness(place, np.sqrt(squared)))


def _harmonics(members: Members, omega: Array) -> npt.NDArray[np.complex128]:
    """Complex amplitudes (members, frequencies, HARMONICS) of the displacement at multiples of drive frequencies."""
    n = members.numbers(trailing=1)
    voltages = _film_voltages(members, omega)
    mean_squares = [np.mean(voltage**2, axis=-1) for voltage in voltages]
    place, stiffness = _equilibria(members, mean_squares)
    # amplitudes as multiples of sines: the displacement is the imaginary part of the sum
    drive = np.zeros((*place.shape, HARMONICS), dtype=complex)
    for film, voltage, mean_square in zip(members.system.films, voltages, mean_squares, strict=True):
        with np.errstate(all="ignore"):
            gain = np.broadcast_to(film.voltage_gain(place, mean_square, n), place.shape)
        harmonics = 2j * np.fft.fft(voltage**2)[..., 1 : HARMONICS + 1] / PHASES
        harmonics[np.abs(harmonics) < ROUNDING * mean_square[..., None]] = 0.0
        drive = drive + gain[..., None] * harmonics
    multiples = np.arange(1, HARMONICS + 1) * omega[..., None]
    damping = members.values["damping_ratio"][:, None, None]
    response = drive / (stiffness[..., None] - multiples**2 + 2j * damping * multiples)
    stable = np.broadcast_to((stiffness > 0.0)[..., None], response.shape)
    return np.where(stable, response, np.nan)


def _film_voltages(members: Members, omega: Array) -> list[Array]:
    """The films' voltages at `PHASES` phases of drives of frequencies (members, frequencies), through the circuit's
    gain, (members, frequencies, PHASES), or (members, 1, PHASES) where the circuit changes nothing."""
    system, n = members.system, members.numbers(trailing=2)
    samples = system.waveform.samples(members.numbers(trailing=1))

    def through(commanded: Array) -> Array:
        if type(system.circuit).gain is Circuit.gain:
            return commanded
        harmonics = np.fft.rfft(commanded)
        multiples = np.arange(harmonics.shape[-1]) * omega[..., None]
        return np.fft.irfft(system.circuit.gain(multiples, n) * harmonics, PHASES)

    lines = [system.line_of(film) for film in range(len(system.films))]
    commands = [np.asarray(system.command_of(line, samples, n)) for line in lines]
    commands = [np.broadcast_to(command, (members.size, 1, PHASES)) for command in commands]
    return [
        command if line.drive == "constant" else through(command) for line, command in zip(lines, commands, strict=True)
    ]


def _under_both(members: Members, mean_squares: Sequence[Array]) -> tuple[Array, Array]:
    """Where double cones rest under constant voltages that all rose from 0 together, and their stiffness there; NaN
    where one loses its stability on the way."""
    system, n = members.system, members.numbers(trailing=1)
    squares = np.broadcast_arrays(*mean_squares)
    x = np.broadcast_to(np.reshape(rest_displacements(members), (-1, 1)), squares[0].shape)
    stiffness = np.full(x.shape, np.nan)
    for share in np.linspace(0.0, 1.0, RAMP):
        with np.errstate(all="ignore"):
            for _ in range(NEWTON_STEPS):
                force, stiffness = system.force_under(x, [share * squared for squared in squares], n)
                x = x - force / stiffness
            x = np.where(np.isfinite(x) & (stiffness > 0.0), x, np.nan)
    return x, np.where(np.isnan(x), np.nan, stiffness)


@for_devices
def small_signal_response(model: ConeModel, frequencies: Frequencies) -> xr.Dataset:
    """Gain and phase from a small voltage about the bias to the displacement, over angular drive frequency.

    Parameters
    ----------
    model : a single model with a ``voltage_bias``.
    frequencies : positive, shape (frequencies,).

    Returns
    -------
    Dataset over ``drive_frequency``: ``gain`` (displacement per voltage, dimensionless) and ``phase`` in degrees, NaN
    where the gain is 0.
    """
    omega = np.atleast_1d(np.asarray(frequencies, dtype=float))
    if omega.ndim != 1 or not np.isfinite(omega).all() or (omega <= 0.0).any():
        raise InputError("frequencies: must be positive numbers")
    a, b, c, d = state_space(model)
    transfer = np.array([(c @ np.linalg.solve(1j * w * np.eye(len(a)) - a, b) + d)[0, 0] for w in omega])
    phase = np.where(transfer != 0.0, np.degrees(np.angle(transfer)), np.nan)
    dims = ("drive_frequency",)
    return dataset.label(
        model,
        {
            "gain": (dims, np.abs(transfer), "displacement per small voltage about the bias", "gain"),
            "phase": (dims, phase, "phase of the displacement", "angle"),
        },
        coords={"drive_frequency": (dims, omega, "drive frequency", "frequency")},
        options={},
        title="small-signal frequency response",
    )
