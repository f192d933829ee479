"""Small signals: the actuator linearised about an equilibrium under a constant voltage."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.errors import InputError
from gelcone.motion.equilibrium import stroke_and_blocked_force
from gelcone.physics.model import ConeModel, electric_pull
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.devices.device import Device


PHASES = 720
"""Places in a drive period at which the stroke of two harmonics is read."""


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


def state_space(model: ConeModel, device: Device | None = None) -> StateSpace:
    """The model linearised about its equilibrium under the constant voltage ``voltage_bias``.

    x'' = -2 zeta x' - K x + 2 v0 x0 v (less in a continuum film), with the stiffness K there; without a bias the
    voltage has no first-order effect and B is zero.

    Parameters
    ----------
    model : a single model.
    device : scales the matrices to metres, seconds and volts. Default None: dimensionless.

    Raises
    ------
    InputError : for an ensemble, or a bias beyond pull-in.
    """
    if model.shape:
        raise InputError(f"a state-space model is that of a single actuator, not of an ensemble of shape {model.shape}")
    bias = float(model.voltage_bias)
    place = equilibrium_under_bias(model, bias)
    stiffness, damping = float(model.stiffness(place, bias)), float(model.damping_ratio)
    gain = 2.0 * bias * float(electric_pull(place, bias, model.coefficients(), model.body))
    time, length, volt = (1.0, 1.0, 1.0) if device is None else _scales(device)
    return StateSpace(
        A=np.array([[0.0, 1.0], [-stiffness / time**2, -2.0 * damping / time]]),
        B=np.array([[0.0], [gain * length / (time**2 * volt)]]),
        C=np.array([[1.0, 0.0]]),
        D=np.array([[0.0]]),
    )


def _scales(device: Device) -> tuple[float, float, float]:
    scales = device.scales
    return scales.time, scales.length, scales.voltage


@dataclass(frozen=True)
class LinearResponse:
    """``stroke`` (frequencies,), and the complex amplitudes of the first two ``harmonics`` (2, frequencies) of the
    drive: the displacement is the imaginary part of harmonic times exp(i k omega t)."""

    stroke: Array
    harmonics: npt.NDArray[np.complex128]


def linear_response(model: ConeModel, frequencies: Array) -> LinearResponse:
    """The response to the model's own drive, linearised about the equilibrium under its mean-square voltage.

    The force goes with v^2 = (v0 + v sin)^2: its part at the drive frequency with 2 v0 v, at twice that with v^2/2.
    With a bias and a small amplitude this is `small_signal_response`. NaN where there is no equilibrium, or an unstable
    one. ``model`` is a single one, ``frequencies`` are angular.
    """
    bias, amplitude = float(model.voltage_bias), float(model.voltage)
    level = float(np.hypot(bias, amplitude / np.sqrt(2.0)))
    damping = float(model.damping_ratio)
    try:
        place = equilibrium_under_bias(model, level)
        stiffness = float(model.stiffness(place, level))
    except InputError:
        place, stiffness = np.nan, np.nan
    if not stiffness > 0.0:
        stiffness = np.nan
    omega = np.asarray(frequencies, dtype=float)
    # A cosine that is subtracted is a sine a quarter of a turn behind.
    forces = (2.0 * bias * amplitude * place, -0.5j * amplitude**2 * place)
    harmonics = np.stack(
        [force / (stiffness - (k * omega) ** 2 + 2j * damping * k * omega) for k, force in enumerate(forces, start=1)]
    )
    turn = np.exp(2j * np.pi * np.arange(PHASES) / PHASES)
    motion = (harmonics[0, :, None] * turn + harmonics[1, :, None] * turn**2).imag
    return LinearResponse(np.ptp(motion, axis=1), harmonics)


def small_signal_response(model: ConeModel, frequencies: npt.ArrayLike) -> xr.Dataset:
    """Gain and phase from a small voltage about the bias to the displacement, over angular drive frequency.

    Parameters
    ----------
    model : a single model with a ``voltage_bias``.
    frequencies : positive, shape (frequencies,).

    Returns
    -------
    Dataset over ``drive_frequency``: ``gain`` (displacement per voltage, dimensionless) and ``phase`` in degrees.
    """
    omega = np.atleast_1d(np.asarray(frequencies, dtype=float))
    if omega.ndim != 1 or not np.isfinite(omega).all() or (omega <= 0.0).any():
        raise InputError("frequencies: must be positive numbers")
    a, b, c, d = state_space(model)
    transfer = np.array([(c @ np.linalg.solve(1j * w * np.eye(2) - a, b) + d)[0, 0] for w in omega])
    dims = ("drive_frequency",)
    return dataset.label(
        model,
        {
            "gain": (dims, np.abs(transfer), "displacement per small voltage about the bias", "gain"),
            "phase": (dims, np.degrees(np.angle(transfer)), "phase of the displacement, degrees", "angle"),
        },
        coords={"drive_frequency": (dims, omega, "drive frequency", "frequency")},
        options={},
        title="small-signal frequency response",
    )
