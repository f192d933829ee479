"""Feed-forward and self-sensing: the voltage that follows a wanted motion, and the height that a capacitance means."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline

from gelcone import dataset
from gelcone.devices.analysis import check_one, for_devices
from gelcone.errors import InputError
from gelcone.physics.bracket import halved
from gelcone.physics.driven import INPUTS, driven
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array, Capacitance, Capacitances, Lengths, Times, Voltage

if TYPE_CHECKING:
    import xarray as xr

DEGREE = 5
"""Of the spline through the wanted heights: its accelerations are smooth."""
TOP = 1.0 - 1e-9
"""Share of the squared voltage at which the film ends, up to which it is used."""
TOLERANCE = 1e-9
HALVINGS = 60
STEP = 1e-5
"""Relative difference of a height for the slope of the capacitance."""


@for_devices
def follow(model: ConeModel, times: Times, displacement: Lengths, *, most: Voltage | None = None) -> xr.Dataset:
    """Compute the voltage under which the disc follows a wanted motion, and check it by an integration.

    The equation of motion gives the force of the film that the motion takes, and the film the voltage of that force.
    Where no voltage gives it - the film cannot push, and it ends where it pulls in - the nearest one is taken. Between
    samples the voltage changes at a constant rate.

    Parameters
    ----------
    model : a single model or device with one film that has no states of its own, and an ideal source.
    times : increasing times, at least 6.
    displacement : wanted displacements at these, through which a smooth curve is laid.
    most : largest voltage. Default None: no limit but those of the film.

    Returns
    -------
    Dataset over ``time``: ``displacement`` as wanted, the ``voltage``, whether it is ``reachable``, the displacement
    that the voltage gives, ``followed``, from the wanted start on, and its ``error``; and the ``largest_error``.
    Displacements are NaN from where the film has pulled in.

    Raises
    ------
    InputError : for an ensemble, films, biases and circuits with states, two films, and times that do not increase.

    Examples
    --------
    >>> import gelcone
    >>> import numpy as np
    >>> model = gelcone.ConeModel(rest_height=0.8, hoop_prestretch=1.4)
    >>> rest = gelcone.static(model, [0.0]).equilibrium_displacement.values.item()
    >>> times = np.linspace(0.0, 10.0, 101)
    >>> found = gelcone.follow(model, times, rest + 0.02 * (1.0 - np.cos(times)))
    >>> bool(found.reachable.values.all()), f"{found.voltage.values.max():.3f}, error {found.largest_error.item():.0e}"
    (True, '0.371, error 2e-05')
    """
    system = _plain_system(model, "follow")
    tau, x = _samples(times, displacement)
    wanted = make_interp_spline(tau, x, k=DEGREE)
    n, film = model.numbers(), system.films[0]
    speed, acceleration = wanted.derivative(1)(tau), wanted.derivative(2)(tau)
    bias = np.broadcast_to(system.bias.force(x, [], n)[0], x.shape)
    pull = -acceleration - 2.0 * np.asarray(n["damping_ratio"]) * speed - bias
    with np.errstate(all="ignore"):
        nowhere = x == 0.0  # the flat film pulls with no voltage
        squared = np.asarray(film.film.balancing(x, np.where(nowhere, 0.0, pull / np.where(nowhere, 1.0, x)), n))
        end = TOP * np.broadcast_to(film.highest_squared(x, n), x.shape)
    end = np.minimum(end, np.inf if most is None else float(most) ** 2)
    taken = np.clip(np.nan_to_num(squared, nan=0.0, posinf=np.inf), 0.0, end)
    voltage = np.sqrt(np.where(nowhere, 0.0, taken))
    followed = _integrated(model, tau, voltage, (float(x[0]), float(speed[0])))
    error = followed - x
    dims = ("time",)
    return dataset.label(
        model,
        {
            "displacement": (dims, x, "wanted displacement x = h/(b-a)", "length"),
            "voltage": (dims, voltage, "voltage across the film", "voltage"),
            "reachable": (dims, (squared == taken) & ~nowhere, "is there a voltage that gives the motion", "flag"),
            "followed": (dims, followed, "displacement under the voltage", "length"),
            "error": (dims, error, "displacement under the voltage less the wanted one", "length"),
            "largest_error": ((), np.abs(error).max(), "largest error of the displacement", "length"),
        },
        coords={"time": (dims, tau, "time", "time")},
        options={"most": most},
        title="feed-forward",
    )


def _plain_system(model: ConeModel, name: str) -> Any:
    """The system, of one film without states and an ideal source."""
    system = model.system
    check_one(model, name)
    if len(system.films) > 1:
        raise InputError(f"{name}: takes one film, and here are two; leave second_film out")
    if not system.planar or system.circuit.borders or system.circuit.name != "ideal":
        own = ", ".join(state.name for state in system.states[2:]) or system.circuit.name
        raise InputError(
            f"{name}: film, bias and circuit must have no states of their own, and have {own}; leave them out"
        )
    return system


def _samples(times: Any, displacement: Any) -> tuple[Array, Array]:
    """Times and wanted displacements; `InputError` for what is not a motion."""
    tau, x = np.asarray(times, dtype=float), np.asarray(displacement, dtype=float)
    if tau.ndim != 1 or tau.size <= DEGREE or tau.shape != x.shape:
        raise InputError(f"times, displacement: must be two lists of one length of at least {DEGREE + 1}")
    if not (np.isfinite(tau).all() and np.isfinite(x).all() and (np.diff(tau) > 0.0).all()):
        raise InputError("times: must increase and, like displacement, be finite")
    return tau - tau[0], x


def _integrated(model: ConeModel, tau: Array, voltage: Array, start: tuple[float, float]) -> Array:
    """The displacement under a voltage that changes at a constant rate between its samples."""
    system = driven(model.system)
    n = {**system.numbers_of({name: np.asarray(value, dtype=float) for name, value in model.values.items()})}

    def rates(t: float, z: Array) -> list[float]:
        own = n | {INPUTS[0]: np.interp(t, tau, voltage)}
        own |= system.switches(0.0, list(z), own)
        with np.errstate(all="ignore"):
            return [float(rate) for rate in system.rates(0.0, list(z), own)]

    options = {"method": "DOP853", "rtol": TOLERANCE, "atol": TOLERANCE**1.5, "max_step": np.diff(tau).max()}
    found = np.full(tau.shape, np.nan)
    with np.errstate(all="ignore"):
        run = solve_ivp(rates, (0.0, tau[-1]), start, t_eval=tau, **options)
    found[: run.t.size] = run.y[0]
    return np.where(np.logical_or.accumulate(np.isnan(found)), np.nan, found)


@for_devices
def sense(
    model: ConeModel, capacitance: Capacitances, *, voltage: Voltage = 0.0, uncertainty: Capacitance = 0.0
) -> xr.Dataset:
    """Compute the displacement of the disc from a measured capacitance of its film, with its error.

    Parameters
    ----------
    model : a single model or device with one film.
    capacitance : measured, shape (samples,).
    voltage : constant voltage on the film, which widens a film that wrinkles. Default 0.
    uncertainty : of the measured capacitance. Default 0.

    Returns
    -------
    Dataset over ``sample``: ``capacitance``, and the ``displacement``, above the film's plane, with its
    ``displacement_error``: what the uncertainty leaves. NaN for a capacitance that the film does not reach.

    Raises
    ------
    InputError : for an ensemble, two films, a film that creeps, and a negative uncertainty.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(rest_height=0.8, hoop_prestretch=1.4)
    >>> found = gelcone.sense(model, [1.3], uncertainty=0.01)
    >>> f"{found.displacement.item():.4f} +- {found.displacement_error.item():.4f}"
    '0.5477 +- 0.0091'
    """
    system = _plain_system(model, "sense")
    measured = np.atleast_1d(np.asarray(capacitance, dtype=float))
    if measured.ndim != 1 or not float(uncertainty) >= 0.0:
        raise InputError(f"capacitance, uncertainty = {uncertainty:g}: must be a list and a number of at least 0")
    n, film, squared = model.numbers(), system.films[0], float(voltage) ** 2

    def known(x: Array) -> Array:
        with np.errstate(all="ignore"):
            return np.asarray(film.capacitance(x, squared + 0.0 * x, [], n), dtype=float)

    x = _inverted(known, measured, film.film.reach(n))
    step = STEP * np.maximum(np.abs(x), STEP)
    with np.errstate(all="ignore"):
        slope = (known(x + step) - known(x - step)) / (2.0 * step)
        error = np.where(uncertainty > 0.0, uncertainty / np.abs(slope), 0.0)
    dims = ("sample",)
    return dataset.label(
        model,
        {
            "capacitance": (dims, measured, "measured capacitance", "capacitance"),
            "displacement": (dims, x, "displacement x = h/(b-a)", "length"),
            "displacement_error": (dims, np.where(np.isnan(x), np.nan, error), "error of the displacement", "length"),
        },
        options={"voltage": voltage, "uncertainty": uncertainty},
        title="self-sensing",
    )


def _inverted(known: Any, wanted: Array, reach: tuple[float, float]) -> Array:
    """The x at which an increasing function of the places where it is finite has some values."""
    grid = np.linspace(reach[0], min(reach[1], 3.0), 601)
    values = known(grid)
    there = grid[np.isfinite(values)]
    if not there.size:
        return np.full(wanted.shape, np.nan)
    ends = known(there[[0, -1]])
    low, high = np.full(wanted.shape, there[0]), np.full(wanted.shape, there[-1])
    low, high = halved(lambda x: known(x) < wanted, low, high, HALVINGS)
    return np.where((wanted >= ends[0]) & (wanted <= ends[1]), 0.5 * (low + high), np.nan)
