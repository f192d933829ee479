"""The equation of motion of a device in SI units, as a function for other integrators."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from gelcone.devices.analysis import check_device
from gelcone.devices.device import Device
from gelcone.errors import InputError
from gelcone.motion.state_space import python_control, state_scales
from gelcone.physics.driven import INPUTS, driven
from gelcone.quantity import Array

Input = float | Callable[[float], float]
"""A constant, or a function of the time in seconds."""
SPACING = 1e-5
"""Dimensionless time on both sides over which the rate of a voltage is taken, where a circuit acts on the rate."""


class Rates:
    """The rates of change ``rates(t, y, voltage=..., force=...)`` of a device's states, in SI units.

    ``y`` has the ``states``: displacement, velocity and those of film, bias and circuit, (N,) or (N, points). The
    ``start`` is that of the device. The film is in tension, wrinkled or slack according to the states; where it has
    pulled in the rates are NaN.

    Parameters
    ----------
    device : a device of single numbers.

    Raises
    ------
    InputError : for an ensemble and anything but a device.
    """

    def __init__(self, device: Device) -> None:
        check_device(device, "rates")
        model, scales = device.to_model(), device.scales
        self._system, self._waveform = driven(model.system), model.system.waveform
        values = {name: np.asarray(value, dtype=float) for name, value in model.values.items()}
        self._n: dict[str, Any] = self._system.numbers_of(values)
        self._drive = model.system.waveform.numbers(values)
        self._scales = scales
        self._sizes, _ = state_scales(self._system.states, device)
        self.states: tuple[str, ...] = tuple(state.name for state in self._system.states)
        start = model.members().start_states(np.array([device.initial_state()]))[0]
        self.start: Array = np.asarray(start, dtype=float) * self._sizes
        still, moving = (self._system.rates(0.0, list(start), self._with(0.0, slope, 0.0)) for slope in (0.0, 1.0))
        self._takes_slope = still != moving

    def __call__(self, t: float, y: Any, *, voltage: Input | None = None, force: Input = 0.0) -> Array:
        """Rates of change, in the shape of ``y``.

        Parameters
        ----------
        t : time, s.
        y : states.
        voltage : commanded voltage, V. Default None: that of the device's drive. A circuit with a reduced resistance
            acts on its rate, which is taken by differences.
        force : force on the disc, N, positive away from the film's plane. Default 0.
        """
        z, n = self._at(t, y, voltage, force)
        with np.errstate(all="ignore"):
            changes = self._system.rates(0.0, list(z), n)
        return np.stack(np.broadcast_arrays(*changes)) * self._column(z) / self._scales.time

    def jacobian(self, t: float, y: Any, *, voltage: Input | None = None, force: Input = 0.0) -> Array:
        """Derivatives (N, N) of the rates by the states ``y`` (N,), for implicit integrators; see `__call__`."""
        z, n = self._at(t, y, voltage, force)
        _, rows = self._system.rates_and_slopes(0.0, [np.float64(value) for value in z], n)
        slopes = np.array([[float(value) for value in row[1:]] for row in rows])
        return slopes * self._sizes[:, None] / (self._sizes * self._scales.time)

    def to_control(self) -> Any:
        """The device as a ``control.NonlinearIOSystem``: inputs ``voltage`` and ``force``, and all states as outputs.

        Raises `MissingDependency` without python-control.
        """

        def update(t: float, y: Array, u: Array, _: Any) -> Array:
            return self(t, y, voltage=float(u[0]), force=float(u[1]))

        names = list(self.states)
        return python_control().nlsys(update, inputs=["voltage", "force"], outputs=names, states=names)

    def _column(self, z: Array) -> Array:
        return self._sizes.reshape((-1,) + (1,) * (z.ndim - 1))

    def _at(self, t: float, y: Any, voltage: Input | None, force: Input) -> tuple[Array, Mapping[str, Any]]:
        """Dimensionless states and all numbers."""
        states = np.asarray(y, dtype=float)
        if states.shape[:1] != (len(self.states),):
            raise InputError(f"y: must have {len(self.states)} states ({', '.join(self.states)}), not {states.shape}")
        z, s, tau = states / self._column(states), self._scales, t / self._scales.time
        if voltage is None:
            volts, slope = self._waveform.voltage(tau, self._drive), self._waveform.voltage_rate(tau, self._drive)
        else:
            volts = (voltage(t) if callable(voltage) else voltage) / s.voltage
            slope = self._slope(t, voltage) if callable(voltage) and self._takes_slope else 0.0
        newton = (force(t) if callable(force) else force) / s.force
        return z, self._with(volts, slope, newton)

    def _slope(self, t: float, voltage: Callable[[float], float]) -> float:
        """The dimensionless rate of a voltage by differences, without times before 0."""
        before, after = max(t - SPACING * self._scales.time, 0.0), t + SPACING * self._scales.time
        return (voltage(after) - voltage(before)) / (after - before) * self._scales.time / self._scales.voltage

    def _with(self, volts: Any, slope: Any, newton: Any) -> Mapping[str, Any]:
        """All numbers, under dimensionless inputs."""
        return self._n | dict(zip(INPUTS, (volts, slope, newton, 0.0), strict=True))


def rates(device: Device) -> Rates:
    """The equation of motion ``f(t, y, voltage=..., force=...)`` of a device in SI units, with its Jacobian.

    As SciPy takes it: ``solve_ivp(f, (0, 1), f.start, jac=f.jacobian, method="LSODA")``.

    Parameters
    ----------
    device : a device of single numbers.

    Returns
    -------
    A function of the time in s and the states, SI, in the order of its ``states``; voltage (V) and force (N) are
    numbers or functions of the time, by default the device's drive and none. ``jacobian`` takes the same, ``start``
    is where the device rests or is released.

    Raises
    ------
    InputError : for an ensemble and anything but a device.

    Examples
    --------
    >>> import gelcone
    >>> f = gelcone.rates(gelcone.find_device("biased-pump").replace(film="taut"))
    >>> f.states, round(float(f.start[0]), 5)
    (('displacement', 'velocity'), 0.01259)
    >>> acceleration = f(0.0, f.start, voltage=0.0, force=5e-3)[1]  # 5 mN on 5 g
    >>> f"{acceleration:.3f} m/s^2"
    '1.000 m/s^2'
    """
    return Rates(device)
