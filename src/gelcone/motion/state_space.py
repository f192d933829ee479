"""Small signals: the actuator linearised about an equilibrium under a constant voltage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.devices.analysis import check_model, check_one, device_words, dimensionless, for_devices
from gelcone.devices.device import Device
from gelcone.devices.scales import MEASURES
from gelcone.errors import InputError, MissingDependency, check_names
from gelcone.motion.constant_voltage import biased_like
from gelcone.motion.ramp import stroke_and_blocked_force
from gelcone.motion.rest import rest_under
from gelcone.physics.component import State
from gelcone.physics.differentiate import gradients
from gelcone.physics.model import ConeModel
from gelcone.physics.system import ConeSystem
from gelcone.quantity import Array, Frequencies

if TYPE_CHECKING:
    import xarray as xr

OUTPUTS: Mapping[str, str] = {
    "displacement": "length",
    "velocity": "velocity",
    "film_voltage": "voltage",
    "charge": "charge",
    "capacitance": "capacitance",
    "current": "current",
    "leak": "current",
    "source_charge": "charge",
    "source_leak": "current",
}
"""Outputs of a linear model -> quantity; the electric ones are those of the first film, or of the films of the first
source."""
INPUTS: Mapping[str, str] = {"voltage": "voltage", "force": "force", "voltage_rate": "slew rate"}
PASSED = 1e-12
"""Feed-through of the charge, as a share of its largest derivative, below which it is rounding."""


class _Matrices(NamedTuple):
    """The four matrices."""

    A: Array
    B: Array
    C: Array
    D: Array


class StateSpace(_Matrices):
    """x' = A x + B u, y = C x + D u, as SciPy and python-control take it: ``scipy.signal.StateSpace(*it)``,
    ``control.ss(*it)``.

    ``states``, ``inputs`` and ``outputs`` are the names of x, u and y, all counted from the equilibrium; ``place`` is
    its displacement and ``rest`` all states there. Units are dimensionless, or SI for a device.
    """

    states: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()
    place: float = np.nan
    rest: tuple[float, ...] = ()

    def moved(self, omega: Array) -> npt.NDArray[np.complex128]:
        """The states over the inputs at angular frequencies, (i omega - A)^-1 B, (frequencies, states, inputs)."""
        inner = 1j * np.asarray(omega)[:, None, None] * np.eye(len(self.A)) - self.A
        return np.asarray(np.linalg.solve(inner, np.broadcast_to(self.B, (len(inner), *self.B.shape))))

    def transfer(self, omega: Array) -> npt.NDArray[np.complex128]:
        """The outputs over the inputs, C (i omega - A)^-1 B + D, (frequencies, outputs, inputs)."""
        return np.asarray(self.C @ self.moved(omega) + self.D)

    def to_control(self) -> Any:
        """The model as a ``control.StateSpace`` with its names; raises `MissingDependency` without python-control."""
        names = {"states": list(self.states), "inputs": list(self.inputs), "outputs": list(self.outputs)}
        return python_control().ss(*self, **names)


def python_control() -> Any:
    """The module of python-control; raises `MissingDependency` without it."""
    try:
        import control
    except ImportError:
        raise MissingDependency("python-control is not installed: pip install control") from None
    return control


def equilibrium_under_bias(model: ConeModel, bias: float, given: str = "voltage_bias =") -> float:
    """The equilibrium at the end of a slow ramp from 0 to the voltage ``bias``. Raises `InputError` beyond pull-in; the
    message begins with the name ``given``."""
    drive = model.system.films[-1].drive
    parameter = {"opposite": "voltage_bias", "constant": "second_voltage"}.get(str(drive))
    start = abs(float(model.voltage_bias)) if drive == "opposite" else 0.0
    first, place = stroke_and_blocked_force(model, [start, abs(bias)])["displacement"].values
    if np.isfinite(place):
        return float(place)
    remedy = "lower it"
    if np.isfinite(first):
        remedy = "take one closer to voltage_bias" if start else remedy
    elif parameter is None:
        raise InputError("without voltage no equilibrium is stable; change the film or what holds it")
    elif drive == "constant" or abs(bias) != start:
        given, bias = f"{parameter} =", float(getattr(model, parameter))
    raise InputError(f"{given} {bias:g}: beyond pull-in, there is no equilibrium; {remedy}")


def state_space(
    model: ConeModel | Device,
    device: Device | None = None,
    *,
    voltage: float | str | None = None,
    inputs: Sequence[str] = ("voltage",),
    outputs: Sequence[str] = ("displacement",),
) -> StateSpace:
    """Linearise a model about its equilibrium under a constant voltage, with the states of films and circuits.

    x'' = -2 zeta x' - K x + 2 v0 x0 v (of a taut film), with the stiffness K there; without a bias the
    voltage has no first-order effect and B is zero.

    Parameters
    ----------
    model : a single model, or a device, whose units are then SI.
    device : scales the matrices to SI. Default None: dimensionless.
    voltage : the constant voltage, of films in opposite phase that on the first; in volts, or a text with a unit, with
        a device. Default: ``voltage_bias``, of a device ``voltage_offset``.
    inputs : of ``"voltage"``, commanded, ``"force"`` on the disc, away from the film's plane, and where the film has
        the commanded voltage ``"voltage_rate"``, the rate of the voltage, on which the current depends.
    outputs : of ``"displacement"``, ``"velocity"``, ``"film_voltage"``, ``"charge"``, ``"capacitance"``, ``"leak"``
        and, behind a circuit that keeps the charge from jumping or with the input ``"voltage_rate"``, ``"current"``,
        all of the first film; ``"source_charge"`` and ``"source_leak"``, of all films of its source.

    Returns
    -------
    The matrices ``A``, ``B``, ``C``, ``D`` as a tuple that SciPy takes, with the names of their ``states``, ``inputs``
    and ``outputs``, the displacement ``place`` of the equilibrium, and ``to_control()``.

    Raises
    ------
    InputError : for an ensemble, a voltage beyond pull-in, unknown names, a current that an ideal source makes
        jump, and the rate of a voltage that a circuit takes.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4)
    >>> linear = gelcone.state_space(model)
    >>> linear.A.shape, round(float(linear.A[1, 0]), 4)
    ((2, 2), -2.2028)
    """
    if isinstance(model, Device):
        device, model = model, model.to_model()
    check_model(model, "state_space")
    if voltage is not None and device is not None:
        voltage = dimensionless({"voltage": "voltage"}, {"voltage": voltage}, device.scales)["voltage"]
    with device_words(device):
        return _linearised(model, device, voltage, inputs, outputs)


def _linearised(
    model: ConeModel, device: Device | None, voltage: Any, inputs: Sequence[str], outputs: Sequence[str]
) -> StateSpace:
    """`state_space`, with the voltage in the model's units."""
    check_one(model, "state_space")
    for kind, given, known in (("input", inputs, INPUTS), ("output", outputs, OUTPUTS)):
        check_names(f"{kind} of a linear model", given, known)
    system = model.system
    bias = float(model.offset_voltage if voltage is None else voltage)
    model = biased_like(model, bias)
    given = "voltage_bias =" if voltage is None else "voltage:"
    n, place = model.numbers(), equilibrium_under_bias(model, bias, given)
    at = [*map(float, rest_under(model, place, bias)), bias]
    switches = system.under(bias, [np.float64(value) for value in at[:-1]], n).switches()
    n = {**n, **switches}
    slopes = gradients(lambda z, xp: system.under(z[-1], z[:-1], n, xp).rates(), at)
    jacobian, count = np.array(slopes, dtype=float), len(system.states)
    pushed = np.eye(count)[:, 1:2]
    passes = all(line.circuit.jumps and not getattr(line.circuit, "reduced", False) for line in system.lines)
    if "voltage_rate" in inputs and not passes:
        raise InputError("voltage_rate: is an input of an ideal source, and here is a circuit; leave it out")
    columns = {"voltage": jacobian[:, -1:], "force": pushed, "voltage_rate": 0.0 * pushed}
    B = np.hstack([columns[name] for name in inputs])
    C, D = _output_rows(system, at, n, switches, outputs, jacobian[:, :-1], B, inputs)
    x, time = state_scales(system.states, device)
    u, y = (
        np.array([1.0 if device is None else float(device.scales.size(known[name])) for name in given])
        for given, known in ((inputs, INPUTS), (outputs, OUTPUTS))
    )
    space = StateSpace(
        A=jacobian[:, :-1] * x[:, None] / (x * time),
        B=B * x[:, None] / (time * u),
        C=C * y[:, None] / x,
        D=D * y[:, None] / u,
    )
    space.states, space.inputs, space.outputs = tuple(s.name for s in system.states), tuple(inputs), tuple(outputs)
    space.place, space.rest = at[0] * float(x[0]), tuple((np.array(at[:-1]) * x).tolist())
    return space


def _output_rows(
    system: ConeSystem,
    at: list[float],
    n: Mapping[str, Any],
    switches: Mapping[str, Any],
    outputs: Sequence[str],
    A: Array,
    B: Array,
    inputs: Sequence[str],
) -> tuple[Array, Array]:
    """The rows of C and D of the outputs."""

    def values(z: list[Any], xp: Any) -> list[Any]:
        numbers = {**n, **{name: xp.constant(float(np.ravel(value)[0])) for name, value in switches.items()}}
        moment = system.under(z[-1], z[:-1], numbers, xp)
        v = moment.voltage(system.lines[0])
        quantities = {"displacement": z[0], "velocity": z[1], "film_voltage": v}
        if wanted & {"charge", "capacitance"}:
            quantities["capacitance"] = system.films[0].capacitance(
                z[0], v * v, system.states_of(z[:-1], "film", 0), numbers, xp
            )
            delays = system.circuit.delays
            quantities["charge"] = moment.stored(system.lines[0]) if delays else v * quantities["capacitance"]
        if "leak" in wanted:
            quantities["leak"] = moment.leaks()[0]
        if "source_charge" in wanted:
            quantities["source_charge"] = moment.stored(system.lines[0])
        if "source_leak" in wanted:
            quantities["source_leak"] = sum(moment.leaks()[k] for k in system.lines[0].films)
        return [xp.node(quantities[name]) for name in rows]

    rows = [*("charge" if name == "current" else name for name in outputs), "leak"]
    wanted = set(rows)
    slopes = np.array(gradients(values, at), dtype=float).reshape(len(rows), -1)
    C, passed = slopes[:, :-1].copy(), slopes[:, -1:]
    through = np.hstack([passed if name == "voltage" else 0.0 * passed for name in inputs])
    D = through.copy()
    for k, name in enumerate(outputs):
        if name == "current":  # what charges the film, and what leaks
            jumps = np.abs(passed[k]).max() > PASSED * np.abs(slopes[k]).max()
            if jumps and "voltage_rate" not in inputs:
                raise InputError(
                    "current: follows the rate of the voltage of an ideal source; give inputs=('voltage', "
                    "'voltage_rate'), take charge, whose rate it is, or a circuit with a series resistance"
                )
            C[k], D[k] = slopes[k, :-1] @ A + C[-1], slopes[k, :-1] @ B + through[-1]
            if jumps:
                D[k, list(inputs).index("voltage_rate")] = passed[k, 0]
    return C[:-1], D[:-1]


def state_scales(states: tuple[State, ...], device: Device | None) -> tuple[Array, float]:
    """SI values of one unit of each state and of time; 1 without a device."""
    if device is None:
        return np.ones(len(states)), 1.0
    sizes = [float(device.scales.size(state.quantity)) if state.quantity in MEASURES else 1.0 for state in states]
    return np.array(sizes), device.scales.time


def check_frequencies(omega: Array) -> None:
    """Raises `InputError` unless ``omega`` is a list of positive numbers."""
    if omega.size == 0:
        raise InputError("frequencies = []: is empty; give at least one value")
    if omega.ndim > 1:
        raise InputError(f"frequencies: must be a list, not of shape {omega.shape}")
    wrong = omega[~(np.isfinite(omega) & (omega > 0.0))]
    if wrong.size:
        raise InputError(f"frequencies: {wrong[0]:g} is among them; they must be positive and finite, leave it out")


@for_devices
def small_signal_response(model: ConeModel, frequencies: Frequencies) -> xr.Dataset:
    """Compute gain and phase from a small voltage about the bias to the displacement, over angular drive frequency.

    Parameters
    ----------
    model : a single model with a ``voltage_bias``.
    frequencies : positive, shape (frequencies,).

    Returns
    -------
    Dataset over ``drive_frequency``: ``gain`` (displacement per voltage, of a device in mm/kV) and ``phase`` in
    degrees, NaN where the gain is 0.

    Raises
    ------
    InputError : for an ensemble, a bias beyond pull-in, and frequencies that are missing or not positive.

    Examples
    --------
    >>> import gelcone
    >>> import numpy as np
    >>> model = gelcone.ConeModel(voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4)
    >>> found = gelcone.small_signal_response(model, np.array([0.1, 1.0]))
    >>> found.gain.values.round(4).tolist()
    [0.3472, 0.6308]
    """
    omega = np.atleast_1d(np.asarray(frequencies, dtype=float))
    check_frequencies(omega)
    transfer = state_space(model).transfer(omega)[:, 0, 0]
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
